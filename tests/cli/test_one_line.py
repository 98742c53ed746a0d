"""Input that cannot be used ends in one line, whatever the names, the terminal, the reader and the file are like."""

import os
import re
import subprocess
import sys

import pytest

import cogging
from cogging.cli.main import main
from tests.attack.commands import run_case
from tests.fixtures import hostile_calls

SIMULATE = ["simulate", "model.toml", "--reference", "ref.toml", "--out", "out.csv"]
COMMAND = [sys.executable, "-m", "cogging.cli.main"]


@pytest.fixture
def folder(tmp_path, monkeypatch):
    for name, content in hostile_calls.files().items():
        (tmp_path / name).write_bytes(content)
    monkeypatch.chdir(tmp_path)
    return tmp_path


#: How many calls of each kind the default run makes; `python -m tests.attack` makes thousands.
CALLS = {"model": 6, "option": 8, "signal": 3, "name": 6, "reference": 4, "document": 5, "sidecar": 3}


@pytest.mark.parametrize("kind", hostile_calls.KINDS)
def test_a_hostile_call_is_answered(kind):
    assert [found for seed in range(CALLS[kind]) if (found := run_case(seed, (kind,)))] == []


def process(arguments, folder, **options):
    """Run the command in a new process without this one's settings."""
    left_out = [name for name in os.environ if name.startswith(("PYTHON", "LC_", "LANG")) and name != "PYTHONPATH"]
    environment = {name: value for name, value in os.environ.items() if name not in left_out}
    streams = {"stdout": subprocess.PIPE, "stderr": subprocess.PIPE} | options
    return subprocess.run([*COMMAND, *arguments], cwd=folder, env=environment, check=False, timeout=120, **streams)


def test_a_name_in_letters_that_the_terminal_lacks(folder, monkeypatch):
    named = "caf\u00e9 \u4e2d \u00b5.csv"
    (folder / named).write_bytes(hostile_calls.LOG)
    with open(folder / "printed", "w", encoding="latin-1") as out:
        monkeypatch.setattr(sys, "stdout", out)
        assert main(["audit", named]) == 0
    assert (folder / "printed").read_text(encoding="latin-1").splitlines()[0] == "caf\u00e9 \\u4e2d \u00b5.csv"


@pytest.mark.skipif(os.name == "nt", reason="names are texts there")
def test_a_name_that_is_no_utf_8(folder):
    """It is read, written and named by its bytes."""
    name = os.fsdecode(b"caf\xe9.csv")
    (folder / name).write_bytes(hostile_calls.LOG)
    call = ["identify", name, "--model", "model.toml", "--free", "axis.mass", "--json", os.fsdecode(b"\xff.json")]
    done = process(call, folder)
    assert (done.returncode, done.stderr) == (0, b"")
    assert rb"caf\xe9.csv" in done.stdout
    assert r"caf\\xe9.csv" in (folder / os.fsdecode(b"\xff.json")).read_text()


@pytest.mark.skipif(os.name == "nt", reason="pipes of another kind")
def test_a_reader_that_has_gone(folder):
    """As `head -1` goes: nothing on standard error, and all that was asked for is written."""
    reading, writing = os.pipe()
    os.close(reading)
    done = process(["audit", "log.csv", "--json", "out.json"], folder, stdout=writing)
    os.close(writing)
    assert (done.returncode, done.stderr) == (0, b"")
    assert (folder / "out.json").exists()


@pytest.mark.skipif(os.name == "nt", reason="a shell of another kind")
def test_streams_that_are_closed(folder):
    """As a service may start it: a text has nowhere to go, and the files are written."""
    call = " ".join([*COMMAND, *SIMULATE])
    assert subprocess.run(f"{call} >&- 2>&-", shell=True, cwd=folder, check=False).returncode == 0
    assert len(cogging.read_log(folder / "out.csv")) > 100


@pytest.mark.skipif(not os.path.exists("/dev/full"), reason="no such device")
def test_an_output_that_is_full(folder):
    with open("/dev/full", "wb") as full:
        done = process(["schema"], folder, stdout=full)
    line = b"cogging: standard output: cannot be written: No space left on device\n"
    assert (done.returncode, done.stderr) == (2, line)


@pytest.mark.skipif(os.name == "nt", reason="a current folder cannot be deleted there")
def test_a_current_folder_that_was_deleted_is_named(tmp_path, monkeypatch, capsys):
    (tmp_path / "gone").mkdir()
    monkeypatch.chdir(tmp_path / "gone")
    (tmp_path / "gone").rmdir()
    assert main(["init", "run.csv"]) == 2
    assert re.fullmatch(
        "cogging: the current folder: must be there, got one that was deleted.*\n", capsys.readouterr().err
    )
