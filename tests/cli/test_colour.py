"""Colour: on a terminal alone, as its user wishes, and of words that say the same without it."""

import io
import json
import os
import re
import sys

import pytest

from cogging.cli.main import main
from cogging.cli.terminal import PLAIN, VERDICTS, coloured, wants_colour
from tests.fixtures import command_files
from tests.fixtures.commands import Terminal

CODES = re.compile(r"\x1b\[[0-9;]*m")


@pytest.fixture
def settings(monkeypatch, tmp_path):
    """A folder with files, and no wishes for colour, of which the tests may be started with some."""
    for name in ("NO_COLOR", "FORCE_COLOR", "CLICOLOR", "CLICOLOR_FORCE"):
        monkeypatch.delenv(name, raising=False)
    monkeypatch.setenv("TERM", "xterm-256color")
    monkeypatch.chdir(tmp_path)
    command_files.write(tmp_path)
    return monkeypatch


def printed(settings, words, stream=Terminal, name="stdout"):
    """Run a call; its status, and what it wrote on one of its streams, which is of the given kind."""
    there = stream()
    settings.setattr(sys, name, there)
    try:
        return main(words), there.getvalue()
    except SystemExit as end:
        return end.code, there.getvalue()


#: Wishes, and whether there is colour on a terminal, and elsewhere.
WISHES = [
    ({}, True, False),
    ({"NO_COLOR": "1"}, False, False),
    ({"NO_COLOR": ""}, True, False),
    ({"NO_COLOR": "1", "FORCE_COLOR": "1"}, False, False),
    ({"FORCE_COLOR": "3", "TERM": "dumb"}, True, True),
    ({"FORCE_COLOR": "0"}, True, False),
    ({"CLICOLOR_FORCE": "1"}, True, True),
    ({"CLICOLOR_FORCE": "0"}, True, False),
    ({"CLICOLOR": "0"}, False, False),
    ({"TERM": "dumb"}, False, False),
]


@pytest.mark.skipif(os.name == "nt", reason="consoles of another kind")
@pytest.mark.parametrize(("wishes", "there", "elsewhere"), WISHES)
def test_wishes_are_kept(wishes, there, elsewhere, settings):
    for name, value in wishes.items():
        settings.setenv(name, value)
    assert wants_colour(Terminal()) is there
    assert wants_colour(io.StringIO()) is elsewhere


@pytest.mark.parametrize("verdict", [*VERDICTS, "data_mismatch"])
def test_words_say_the_same_without_it(verdict):
    text = f"""verdict: {verdict}
  cable_spring or end_effect: confidence 0.45
    stiffness = 1.0 V/m, 95 % 0.9 to 1.1
  warning: the log is short
next: cogging audit log.csv"""
    painted = coloured(text)
    assert CODES.sub("", painted) == text
    assert len(CODES.findall(painted)) == 2 * 4 + 1, "verdict (bold too), name, warning, next"
    for line in painted.splitlines():
        assert line.count(PLAIN) == (1 if CODES.search(line) else 0), "no colour runs into the next line"


def test_the_command_on_a_terminal_and_elsewhere(settings):
    words = ["diagnose", "log.csv", "--model", "model.toml", "--rows", "0:500"]
    shown, plain = (printed(settings, words, kind)[1] for kind in (Terminal, io.StringIO))
    assert "\x1b" not in plain
    assert CODES.sub("", shown) == plain
    assert "verdict: \x1b[1m\x1b[31minsufficient_excitation\x1b[0m\n" in shown
    assert shown.splitlines()[-1].startswith("\x1b[36mnext:\x1b[0m cogging ")


@pytest.mark.parametrize("words", ["audit log.csv --json -", "schema", "completion bash", "--help"])
def test_what_a_program_reads_and_help_have_none_even_where_it_is_forced(words, settings):
    settings.setenv("FORCE_COLOR", "1")
    status, out = printed(settings, words.split())
    assert status == 0
    assert "\x1b" not in out
    assert "\\x1b" not in out
    if words.startswith(("audit", "schema")):
        json.loads(out)


def test_files_have_none_even_where_it_is_forced(settings, tmp_path):
    settings.setenv("FORCE_COLOR", "1")
    call = ["identify", "log.csv", "--model", "model.toml", "--out", "new.toml", "--json", "new.json"]
    assert printed(settings, call)[0] == 0
    for path in tmp_path.glob("new.*"):
        assert b"\x1b" not in path.read_bytes()


def test_an_error_is_coloured_on_a_terminal_alone(settings):
    for kind, begun in ((Terminal, "\x1b[31mcogging:\x1b[0m missing.csv"), (io.StringIO, "cogging: missing.csv")):
        status, err = printed(settings, ["audit", "missing.csv"], kind, "stderr")
        assert (status, err.count("\n")) == (2, 1)
        assert err.startswith(begun)


@pytest.mark.skipif(os.name == "nt", reason="no file has such a name there")
def test_a_name_cannot_paint(settings, tmp_path):
    """What looks like colour in a name is shown as what it is."""
    name = "\x1b[32mverdict: named.csv"
    (tmp_path / name).write_bytes((tmp_path / "log.csv").read_bytes())
    status, out = printed(settings, ["audit", name])
    assert status == 0
    assert out.startswith("\\x1b[32mverdict: named.csv\n")
    assert set(CODES.findall(out)) <= {"\x1b[36m", PLAIN}
