"""Answers of the command as a process: one line, whatever the names, the terminal, the reader and the file are like."""

import json
import math
import os
import re
import subprocess
import sys

import numpy as np
import pytest

import cogging
from cogging.cli.main import main
from cogging.outputs import to_json
from tests.fixtures import hostile_calls
from tests.fixtures.hostile_answers import Answer, everything, faults, place


def process(arguments, folder, **options):
    """The command in a process of its own, without help from this one's settings."""
    environment = {name: value for name, value in os.environ.items() if not name.startswith(("PYTHON", "LC_", "LANG"))}
    environment |= options.pop("environment", {})
    return subprocess.run(
        [sys.executable, "-m", "cogging.cli.main", *arguments],
        cwd=folder,
        env=environment,
        capture_output=not options.pop("open", False),
        check=False,
        timeout=120,
        **options,
    )


@pytest.fixture
def folder(tmp_path):
    place(hostile_calls.Call([], hostile_calls.files()), tmp_path)
    return tmp_path


SIMULATE = ["simulate", "model.toml", "--reference", "ref.toml", "--out", "out.csv"]
AUDIT = ["audit", "log.csv", "--model", "model.toml"]


@pytest.mark.parametrize("kind", hostile_calls.KINDS)
def test_a_process_answers_as_this_one_does(kind, tmp_path):
    call = hostile_calls.draw(kind, 5000)
    if call.arguments[0] == "reproduce" or any("\0" in a or "\ud800" <= a[:1] <= "\udbff" for a in call.arguments):
        call = hostile_calls.draw("document", 5000)  # what no shell can pass, or takes long
    before = place(call, tmp_path)
    done = process(call.arguments, tmp_path)
    left = sorted(name for name, content in everything(tmp_path).items() if content != before.get(name))
    answer = Answer(done.returncode, done.stdout.decode(), done.stderr.decode(), 0.0, left)
    assert not list(faults(answer, tmp_path)), str(call)


@pytest.mark.parametrize("arguments", [AUDIT, ["--help"]])
def test_a_terminal_of_few_letters(arguments, folder):
    done = process(arguments, folder, environment={"PYTHONIOENCODING": "ascii"})
    assert (done.returncode, done.stderr) == (0, b"")
    assert done.stdout.decode("ascii")


@pytest.mark.parametrize("encoding", ["ascii", "latin-1"])
def test_a_name_in_letters_that_the_terminal_has_not(encoding, folder):
    named = "caf\u00e9 \u4e2d \u00b5.csv"
    (folder / named).write_bytes(hostile_calls.LOG)
    done = process(["audit", named], folder, environment={"PYTHONIOENCODING": encoding})
    assert (done.returncode, done.stderr) == (0, b"")
    shown = "caf\\xe9 \\u4e2d \\xb5.csv" if encoding == "ascii" else "caf\u00e9 \\u4e2d \u00b5.csv"
    assert done.stdout.decode(encoding).splitlines()[0] == shown


@pytest.mark.skipif(os.name == "nt", reason="names are texts there")
def test_a_name_that_is_no_utf_8(folder):
    """It is read, written and told as its bytes, not found out when everything is done."""
    name = os.fsdecode(b"caf\xe9.csv")
    (folder / name).write_bytes(hostile_calls.LOG)
    call = ["identify", name, "--model", "model.toml", "--free", "axis.mass", "--json", os.fsdecode(b"\xff.json")]
    done = process(call, folder)
    assert (done.returncode, done.stderr) == (0, b"")
    assert rb"caf\xe9.csv" in done.stdout
    told = json.loads((folder / os.fsdecode(b"\xff.json")).read_text())
    assert r"caf\xe9.csv" in json.dumps(told, ensure_ascii=False).replace("\\\\", "\\")
    done = process(["audit", name, "--json", "a.json"], folder)
    assert done.returncode == 0
    assert json.loads((folder / "a.json").read_text())[0]["log"] == r"caf\xe9.csv"
    os.remove(folder / name)
    done = process(["audit", name], folder)
    assert (done.returncode, done.stderr) == (2, b"cogging: caf\\xe9.csv: cannot be read: No such file or directory\n")


@pytest.mark.skipif(os.name == "nt", reason="pipes of another kind")
@pytest.mark.parametrize("arguments", [["schema"], [*AUDIT, "--json", "out.json"]])
def test_a_reader_that_has_gone(arguments, folder):
    """As `head -1` goes: nothing on standard error, and all that was asked for is written."""
    reading, writing = os.pipe()
    os.close(reading)
    done = process(arguments, folder, open=True, stdout=writing, stderr=subprocess.PIPE)
    os.close(writing)
    assert (done.returncode, done.stderr) == (0, b"")
    if arguments[-1].startswith("out."):
        assert (folder / arguments[-1]).exists()


@pytest.mark.skipif(os.name == "nt", reason="a shell of another kind")
@pytest.mark.parametrize("closed", ["2>&-", ">&-", ">&- 2>&-"])
def test_a_stream_that_is_closed(closed, folder):
    """As a service may start it; progress, answers and results have nowhere to go, and the files are written."""
    call = "identify log.csv --model model.toml --free axis.mass --out out.toml"
    done = subprocess.run(f"{sys.executable} -m cogging.cli.main {call} {closed}", shell=True, cwd=folder, check=False)
    assert done.returncode == 0
    assert cogging.Model.read(folder / "out.toml").intervals["axis.mass"][0] > 0.0


@pytest.mark.skipif(os.name == "nt", reason="a shell of another kind")
@pytest.mark.parametrize("call", ["audit log.csv --json -", " ".join([*SIMULATE, "--json", "-"]), "schema"])
def test_a_result_for_an_output_that_is_closed(call, folder):
    """It went nowhere, with status 0."""
    command = f"{sys.executable} -m cogging.cli.main {call} >&-"
    done = subprocess.run(command, shell=True, cwd=folder, stderr=subprocess.PIPE, check=False)
    line = b"cogging: standard output: must be open for what is asked, got a closed one\n"
    assert (done.returncode, done.stderr) == (2, line)
    assert not (folder / "out.csv").exists()


@pytest.mark.skipif(not os.path.exists("/dev/full"), reason="no such device")
def test_an_output_that_is_full(folder):
    with open("/dev/full", "wb") as full:
        done = process(["schema"], folder, open=True, stdout=full, stderr=subprocess.PIPE)
    assert (done.returncode, done.stderr) == (
        2,
        b"cogging: standard output: cannot be written: No space left on device\n",
    )


DOCUMENTS = {
    "beyond 64 bits": (
        "mass = 9223372036854775808",
        r"line 2: axis.mass: must be a number that 64 bits hold, got 9223",
    ),
    "beyond all bits": ("mass = 1" + "0" * 400, r"line 2: axis.mass: must be a number that 64 bits hold, got 1000"),
    "thousands of digits": ("mass = " + "9" * 5000, "must be TOML: a whole number must have 64 bits"),
    "beyond 1e308": ("mass = 1.0\ntravel = [0.0, 1e309]", r"line 3: axis.travel: must be .* 64 bits hold, got 1e309"),
    "huge": ("mass = 1e300", r"line 2: axis.mass: must be at most 1e\+30 in size, got 1e\+300"),
    "nested lists": ("mass = " + "[" * 5000 + "]" * 5000, "must be TOML: tables and lists must be nested at most 32"),
    "nested a little": ("mass = " + "[" * 40 + "]" * 40, "must be TOML: tables and lists must be nested at most 32"),
    "nested tables": ("mass = " + "{a=" * 5000 + "1" + "}" * 5000, "tables and lists must be nested at most 32 deep"),
    "dotted": ("a" + ".a" * 20000 + " = 1", "must be TOML: a key must have at most 32 dots"),
    "effect's name": ('mass = 1.0\n[[effects]]\nname = ["cable_spring"]', r"effects.name: must be one of .*, got \['"),
    "controller's type": ("mass = 1.0\n[controller]\ntype = { a = 1 }", r"controller.type: .*, got \{'a': 1\}"),
    "texts as numbers": (
        'mass = 1.0\n[cogging]\npitch = 0.1\nharmonics = [1]\nsine = [["1"]]\ncosine = [["1"]]',
        "line 6: cogging.sine: must be rows of numbers",
    ),
    "counts": (
        "mass = 1.0\n[cogging]\npitch = 0.1\nharmonics = [4294967296]",
        r"line 5: cogging.harmonics: must be at most 2147483647 in size, got 4294967296",
    ),
    "escape codes": ('mass = 1.0\n"\\u001b[2J" = 1', r"axis\.\\x1b\[2J: is unknown"),
    "endless": ('mass = "' + "x" * 100000 + '"', r"axis.mass: must be a number, got 'xxx.* \.\.\. xxx"),
}


@pytest.mark.parametrize("case", DOCUMENTS)
def test_a_hostile_document(case, folder, capsys, monkeypatch):
    text, message = DOCUMENTS[case]
    monkeypatch.chdir(folder)
    (folder / "model.toml").write_text(f"[axis]\n{text}\n")
    assert main(SIMULATE) == 2
    error = capsys.readouterr().err
    assert error.startswith("cogging: model.toml: ")
    assert re.search(message, error), error
    assert error.count("\n") == 1
    assert len(error) < 2000


def test_json_holds_no_infinity():
    document = {
        "a": [math.inf, -math.inf, math.nan, 1.5, 3],
        "b": np.array([math.nan, 1.0]),
        "c": (True, None, "é\udce9"),
    }
    text = to_json(document)
    told = json.loads(text, parse_constant=pytest.fail)
    assert told == {"a": [None, None, None, 1.5, 3], "b": [None, 1.0], "c": [True, None, "é\\xe9"]}
