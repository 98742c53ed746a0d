"""On a terminal: colour as its user wishes and progress of long computations; neither in a pipe or a file."""

import io
import os
import re
import sys
import time

import pytest

from cogging import progress
from cogging.cli.main import main
from cogging.papers import malaize2009 as paper
from cogging.papers.result import Reproduction
from tests.fixtures import command_files
from tests.fixtures.command_files import examples_of

CODES = re.compile(r"\x1b\[[0-9;]*m")
#: Commands that show a running time, and commands that show how many steps are done.
TIMED, COUNTED = ("audit", "map", "predict", "simulate"), ("identify", "reproduce", "sweep", "tune")
CALLS = {command: examples_of(command)[0] for command in (*TIMED, *COUNTED)}
CALLS |= {"reproduce": ["reproduce", "malaize2009"], "map": examples_of("map")[1]}  # which draws no figure


class Terminal(io.StringIO):
    """A stream that says that it is a terminal."""

    def isatty(self):
        return True


@pytest.fixture
def settings(monkeypatch, tmp_path):
    """A folder with files for every command, and an environment without wishes for colour."""
    for name in ("NO_COLOR", "FORCE_COLOR", "CLICOLOR", "CLICOLOR_FORCE"):
        monkeypatch.delenv(name, raising=False)
    monkeypatch.setenv("TERM", "xterm-256color")
    monkeypatch.chdir(tmp_path)

    def reproduce(done):
        for _ in range(paper.STEPS):
            done("step")
            time.sleep(5e-3)
        return Reproduction("a", [], {})

    monkeypatch.setattr(paper, "reproduce", reproduce)
    command_files.write(tmp_path)
    return monkeypatch


@pytest.fixture
def call(settings):
    """Run a command; return its status, standard output and standard error, one of them a terminal."""

    def run(words, out=io.StringIO, err=io.StringIO):
        streams = out(), err()
        settings.setattr(sys, "stdout", streams[0])
        settings.setattr(sys, "stderr", streams[1])
        try:
            status = main(words)
        except SystemExit as end:
            status = end.code
        return status, *(stream.getvalue() for stream in streams)

    return run


@pytest.fixture
def impatient(settings):
    """Show progress at once."""
    settings.setattr(progress, "PATIENCE", 0.0)
    settings.setattr(progress, "BETWEEN", 0.01)


@pytest.mark.skipif(os.name == "nt", reason="consoles of another kind")
@pytest.mark.parametrize(
    ("wishes", "on_a_terminal", "elsewhere"),
    [
        ({"NO_COLOR": "", "FORCE_COLOR": "0", "CLICOLOR_FORCE": "0"}, True, False),
        ({"NO_COLOR": "1", "FORCE_COLOR": "1"}, False, False),
        ({"FORCE_COLOR": "3", "TERM": "dumb"}, True, True),
        ({"CLICOLOR_FORCE": "1"}, True, True),
        ({"CLICOLOR": "0"}, False, False),
        ({"TERM": "dumb"}, False, False),
    ],
)
def test_the_environment_decides_on_colour(wishes, on_a_terminal, elsewhere, settings, call):
    for name, value in wishes.items():
        settings.setenv(name, value)
    for stream, coloured in ((Terminal, on_a_terminal), (io.StringIO, elsewhere)):
        status, _, error = call(["audit", "missing.csv"], err=stream)
        assert (status, error.count("\n")) == (2, 1)
        assert error.startswith("\x1b[31mcogging:\x1b[0m missing.csv" if coloured else "cogging: missing.csv")


def test_colour_changes_no_word(call):
    words = ["diagnose", "log.csv", "--model", "model.toml", "--rows", "0:500"]
    shown, plain = (call(words, out=stream)[1] for stream in (Terminal, io.StringIO))
    assert "\x1b" not in plain
    assert CODES.sub("", shown) == plain
    assert "verdict: \x1b[1m\x1b[31minsufficient_excitation\x1b[0m\n" in shown
    assert shown.splitlines()[-1].startswith("\x1b[36mnext:\x1b[0m cogging ")


def test_forced_colour_stays_out_of_files_help_and_what_a_program_reads(settings, call, tmp_path):
    settings.setenv("FORCE_COLOR", "1")
    for words in ("audit log.csv --json -", "schema", "completion bash", "--help"):
        status, out, _ = call(words.split())
        assert (status, "x1b" in repr(out)) == (0, False), words
    assert call(["identify", "log.csv", "--model", "model.toml", "--out", "new.toml", "--json", "new.json"])[0] == 0
    assert not any(b"\x1b" in path.read_bytes() for path in tmp_path.glob("new.*"))


def left_on_the_screen(seen):
    """Return what a terminal shows in the end: each line as the last writing left it."""
    lines = []
    for line in seen.replace("\r\n", "\n").split("\n"):
        shown = ""
        for part in re.sub(r"\x1b\[[0-9;]*[A-Za-z]", "", line).split("\r"):
            shown = part + shown[len(part) :]
        lines.append(shown.rstrip())
    return "\n".join(lines).strip()


@pytest.mark.usefixtures("impatient")
@pytest.mark.parametrize("command", [*TIMED, *COUNTED])
def test_progress_is_shown_on_a_terminal_and_removed(command, call):
    status, out, seen = call(CALLS[command], err=Terminal)
    assert status == 0, seen
    assert re.search(r"\d+%.*\d+/\d+" if command in COUNTED else rf"{command}[^\r]*\[00:0\d\]", seen)
    assert left_on_the_screen(seen) == ""
    assert "next: cogging " in out
    assert "\r" not in out
    if command == "audit":
        status, out, seen = call([*CALLS["audit"], "--json", "-"], err=Terminal)
        assert (status, out[:2]) == (0, "[\n")
        assert "audit: log.csv [00:0" in seen


@pytest.mark.usefixtures("impatient")
def test_progress_moves_while_the_core_computes_and_makes_way_for_an_error(settings, call):
    def slow(*_, **__):
        time.sleep(0.15)
        raise ValueError("the end")

    settings.setattr("cogging.mapping.fit_map.fit_map", slow)
    settings.setenv("NO_COLOR", "1")
    status, _, seen = call(CALLS["map"], err=Terminal)
    assert status == 2
    assert len(re.findall(r"map[^\r]*\[00:0[01]\]", seen)) >= 3
    assert left_on_the_screen(seen) == "cogging: sensor.csv: the end"


@pytest.mark.usefixtures("impatient")
@pytest.mark.parametrize("command", ["map", "sweep"])
def test_there_is_no_progress_with_quiet_nor_in_a_pipe_nor_of_a_short_computation(command, settings, call):
    assert call([*CALLS[command], "--quiet"], err=Terminal) == (0, "", "")
    assert call(CALLS[command])[2] == ""
    settings.setattr(progress, "PATIENCE", 10.0)
    assert call(CALLS["simulate"], err=Terminal)[2] == ""
