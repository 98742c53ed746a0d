"""The TAB key: what `cogging completion` prints, tried in the shells themselves."""

import contextlib
import shlex
import shutil
import subprocess
import sys

import pytest

from cogging.cli.completion import SHELLS
from cogging.cli.main import COMMANDS, main
from tests.fixtures.commands import of


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    """A folder with files to complete, and the scripts."""
    folder = tmp_path_factory.mktemp("completion")
    (folder / "runs").mkdir()
    for name in ("first run.csv", "second.csv"):
        (folder / name).touch()
    for shell in SHELLS:
        with open(folder / f"script.{shell}", "w") as file, contextlib.redirect_stdout(file):
            assert main(["completion", shell]) == 0
    return folder


ASK = """
source script.bash
while IFS= read -r line; do
  eval "set -- $line"
  COMP_WORDS=("$@"); COMP_CWORD=$(($# - 1)); COMP_LINE="$*"; COMP_POINT=${#COMP_LINE}; COMPREPLY=()
  _shtab_cogging cogging "${COMP_WORDS[COMP_CWORD]}" "${COMP_WORDS[COMP_CWORD-1]}"
  printf '%s\\t' "${COMPREPLY[@]}"; echo
done
"""


@pytest.mark.skipif(sys.platform == "win32" or shutil.which("bash") is None, reason="needs bash")
def test_bash_offers_commands_options_values_and_files(folder):
    files = {"first run.csv", "second.csv", "runs"}
    options = {command: set(of(command)._option_string_actions) for command in COMMANDS}
    expected = {(command, "--"): {name for name in options[command] if name[1] == "-"} for command in COMMANDS}
    expected |= {
        ("dia",): {"diagnose"},
        ("experiment", "--goal", ""): {"separate", "detect", "fit"},
        ("reproduce", "--out", ""): {"runs"},
        ("diagnose", "second.csv", "--model", "fi"): {"first run.csv"},
    }
    beginnings = {("",): set(COMMANDS), ("audit", ""): files, ("completion", ""): set(SHELLS)}
    calls = "".join(shlex.join(["cogging", *words]) + "\n" for words in (*expected, *beginnings))
    done = subprocess.run(["bash", "--norc", "-c", ASK], input=calls, cwd=folder, capture_output=True, text=True)
    offered = [{word.strip() for word in line.split("\t") if word.strip()} for line in done.stdout.splitlines()]
    assert offered[: len(expected)] == list(expected.values())
    for words, found in zip(beginnings.values(), offered[len(expected) :], strict=True):
        assert words <= found


@pytest.mark.skipif(sys.platform == "win32", reason="shells of POSIX")
def test_every_shell_reads_its_script(folder):
    for shell in SHELLS:
        assert all(command in (folder / f"script.{shell}").read_text() for command in COMMANDS)
        if shutil.which(shell):
            done = subprocess.run([shell, "-n", f"script.{shell}"], cwd=folder, capture_output=True)
            assert (done.returncode, done.stdout, done.stderr) == (0, b"", b"")


def test_without_its_library_the_extra_is_named(monkeypatch, capsys):
    monkeypatch.setitem(sys.modules, "shtab", None)
    assert main(["completion", "bash"]) == 2
    assert capsys.readouterr().err == "cogging: shtab is needed but not installed: pip install 'cogging[completion]'\n"
