"""Colour: on a terminal alone, as its user wishes, and of words that say the same without it."""

import io
import json
import os
import re
import subprocess
import sys

import pytest

from cogging.cli.main import main
from cogging.cli.terminal import PLAIN, VERDICTS, coloured, wants_colour
from tests.fixtures import command_files

CODES = re.compile(r"\x1b\[[0-9;]*m")


class Terminal(io.StringIO):
    def isatty(self):
        return True


@pytest.fixture
def settings(monkeypatch):
    """Wishes for colour, of which the tests may be started with some."""
    for name in ("NO_COLOR", "FORCE_COLOR", "CLICOLOR", "CLICOLOR_FORCE"):
        monkeypatch.delenv(name, raising=False)
    monkeypatch.setenv("TERM", "xterm-256color")
    return monkeypatch


#: Wishes, and whether there is colour on a terminal, and elsewhere.
WISHES = [
    ({}, True, False),
    ({"NO_COLOR": "1"}, False, False),
    ({"NO_COLOR": ""}, True, False),
    ({"NO_COLOR": "1", "FORCE_COLOR": "1"}, False, False),
    ({"FORCE_COLOR": "1"}, True, True),
    ({"FORCE_COLOR": "3", "TERM": "dumb"}, True, True),
    ({"FORCE_COLOR": "0"}, True, False),
    ({"CLICOLOR_FORCE": "1"}, True, True),
    ({"CLICOLOR_FORCE": "0"}, True, False),
    ({"CLICOLOR": "0"}, False, False),
    ({"CLICOLOR": "1"}, True, False),
    ({"TERM": "dumb"}, False, False),
]


@pytest.mark.skipif(os.name == "nt", reason="consoles of another kind")
@pytest.mark.parametrize(("wishes", "there", "elsewhere"), WISHES)
def test_wishes_are_kept(wishes, there, elsewhere, settings):
    for name, value in wishes.items():
        settings.setenv(name, value)
    assert wants_colour(Terminal()) is there
    assert wants_colour(io.StringIO()) is elsewhere


def test_a_closed_stream_has_none(settings):
    stream = Terminal()
    stream.close()
    stream.isatty = lambda: (_ for _ in ()).throw(ValueError("closed"))
    assert wants_colour(stream) is False


TEXT = """verdict: {}
  cable_spring or end_effect: confidence 0.45
    stiffness = 1.0 V/m, 95 % 0.9 to 1.1
  warning: the log is short
note: nothing
next: cogging audit log.csv"""


@pytest.mark.parametrize("verdict", [*VERDICTS, "data_mismatch", "controller_mismatch"])
def test_words_say_the_same_without_it(verdict):
    text = TEXT.format(verdict)
    painted = coloured(text)
    assert CODES.sub("", painted) == text
    assert len(CODES.findall(painted)) == 2 * 4 + 1, "verdict (bold too), name, warning, next"
    for line in painted.splitlines():
        assert line.count(PLAIN) == (1 if CODES.search(line) else 0), "no colour runs into the next line"
    assert CODES.sub("", painted.splitlines()[0]) != painted.splitlines()[0]


def on(stream_name, stream, settings):
    settings.setattr(sys, stream_name, stream)
    return stream


def test_the_command_on_a_terminal_and_elsewhere(settings, tmp_path):
    settings.chdir(tmp_path)
    command_files.write(tmp_path)
    words = ["diagnose", "log.csv", "--model", "model.toml", "--rows", "0:500"]
    told = {}
    for kind in (Terminal, io.StringIO):
        out, err = on("stdout", kind(), settings), on("stderr", io.StringIO(), settings)
        assert main(words) == 0
        told[kind] = out.getvalue()
        assert err.getvalue() == ""
    assert "\x1b" not in told[io.StringIO]
    assert CODES.sub("", told[Terminal]) == told[io.StringIO]
    assert "verdict: \x1b[1m\x1b[31minsufficient_excitation\x1b[0m\n" in told[Terminal]
    assert told[Terminal].splitlines()[-1].startswith("\x1b[36mnext:\x1b[0m cogging ")


@pytest.mark.parametrize("words", [["audit", "log.csv", "--json", "-"], ["schema"], ["completion", "bash"]])
def test_what_a_program_reads_has_none_even_on_a_terminal(words, settings, tmp_path):
    settings.chdir(tmp_path)
    settings.setenv("FORCE_COLOR", "1")
    command_files.write(tmp_path)
    out = on("stdout", Terminal(), settings)
    assert main(words) == 0
    assert "\x1b" not in out.getvalue()
    if words[0] != "completion":
        json.loads(out.getvalue())


def test_files_have_none_even_where_it_is_forced(settings, tmp_path):
    settings.chdir(tmp_path)
    settings.setenv("FORCE_COLOR", "1")
    command_files.write(tmp_path)
    on("stdout", Terminal(), settings)
    assert main(["identify", "log.csv", "--model", "model.toml", "--out", "new.toml", "--json", "new.json"]) == 0
    for path in tmp_path.glob("new.*"):
        assert b"\x1b" not in path.read_bytes()


def test_an_error_is_coloured_on_a_terminal_alone(settings):
    for kind, begun in ((Terminal, "\x1b[31mcogging:\x1b[0m missing.csv"), (io.StringIO, "cogging: missing.csv")):
        err = on("stderr", kind(), settings)
        assert main(["audit", "missing.csv"]) == 2
        assert err.getvalue().startswith(begun)
        assert err.getvalue().count("\n") == 1


def test_a_name_cannot_paint(settings, tmp_path):
    """What looks like colour in a name is shown as what it is."""
    settings.chdir(tmp_path)
    command_files.write(tmp_path)
    (tmp_path / "\x1b[32mverdict: named.csv").write_bytes((tmp_path / "log.csv").read_bytes())
    out = on("stdout", Terminal(), settings)
    assert main(["audit", "\x1b[32mverdict: named.csv"]) == 0
    assert out.getvalue().startswith("\\x1b[32mverdict: named.csv\n")
    assert set(CODES.findall(out.getvalue())) <= {"\x1b[36m", PLAIN}


def test_help_is_plain_on_every_python(settings):
    done = subprocess.run(
        [sys.executable, "-m", "cogging", "--help"],
        env={**os.environ, "FORCE_COLOR": "1"},
        capture_output=True,
        text=True,
        check=True,
    )
    assert "\x1b" not in done.stdout
    assert "\\x1b" not in done.stdout
