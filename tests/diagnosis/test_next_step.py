"""What to do next: a command that the program takes, whatever was found and whatever the files are called."""

import html
import shlex
from dataclasses import replace

import numpy as np
import pytest

from cogging.cli.diagnose import _given
from cogging.cli.log_options import OPTIONS
from cogging.cli.main import _parser, main
from cogging.diagnosis.next_step import GivenFiles, next_step
from tests.fixtures.drawn_results import VERDICTS, drawn_result
from tests.fixtures.pid_axis import MODEL, run

HOSTILE = ("my log.csv", "a'b.csv", "$HOME.csv", "log;rm.csv", "ünïcode.csv", "x" * 200 + ".csv")
NAMED = GivenFiles(HOSTILE[:2], HOSTILE[2], HOSTILE[3:5], ("--columns", "position=q m"), "r e.json", HOSTILE[5])


@pytest.mark.parametrize("files", [None, NAMED, replace(NAMED, patched=""), replace(NAMED, result="")])
@pytest.mark.parametrize("verdict", VERDICTS)
def test_the_next_command_is_one_that_the_program_takes(verdict, files):
    """As a shell reads it back, and with the files of the call in it."""
    generator = np.random.default_rng(VERDICTS.index(verdict))
    commands = set()
    for _ in range(8):
        step = next_step(drawn_result(generator, verdict), files)
        assert step.words.endswith(".")
        assert step.words[0].isupper()
        if not step.command:
            assert verdict == "data_mismatch"
            continue
        words = shlex.split(step.line())
        assert tuple(words) == step.command
        assert words[0] == "cogging"
        parsed = _parser().parse_args(words[1:])
        given = files or GivenFiles()
        commands.add(words[1])
        if words[1] in ("diagnose", "audit"):
            assert parsed.logs == list(given.logs)
            assert parsed.model == given.model
            assert parsed.columns or not given.options
        if words[1] == "diagnose":
            assert parsed.confirm[: len(given.confirm)] == list(given.confirm)
    assert commands or verdict == "data_mismatch"


def test_a_name_that_is_sure_is_checked_then_used(found):
    """Without other motion: record it; with it: write the model; with that: use it."""
    alone = replace(found, gap=replace(found.gap, confirm_before=None, confirm_after=None))
    assert next_step(alone).command[-2:] == ("--confirm", "OTHER_LOG.csv")
    assert next_step(found).command[-2:] == ("--out", "PATCHED.toml")
    assert next_step(found, GivenFiles(patched="new.toml")).command[:3] == ("cogging", "predict", "new.toml")


def test_the_report_of_the_command_names_the_files_and_how_they_were_read(tmp_path, capsys):
    """What its next command says, the program reads as this call did."""
    log = run(duration=0.3)
    log.write(tmp_path / "a b.csv")
    MODEL.write(tmp_path / "m.toml")
    call = ["diagnose", str(tmp_path / "a b.csv"), "--model", str(tmp_path / "m.toml"), "--rows", "a b.csv:0:590"]
    call += ["--scale", "command=1,position=1.0", "--zero", "position=-0.001", "--report", str(tmp_path / "r.html")]
    assert main(call) == 0
    page = html.unescape((tmp_path / "r.html").read_text())
    told = shlex.split(page.partition("<pre>")[2].partition("</pre>")[0])
    assert told[:2] == ["cogging", "audit"]  # moved by its zero, the log is not what the controller made
    shown = _parser().parse_args(told[1:])
    once, again = _parser().parse_args(call), _parser().parse_args(_given_back(call))
    for option in OPTIONS:
        assert getattr(again, option) == getattr(shown, option) == getattr(once, option)
    assert shown.model == once.model
    assert (again.logs, again.confirm) == (once.logs, once.confirm)


def _given_back(call):
    """The call of a data mismatch, whose next step is the same call with one column read otherwise."""
    told = _given(_parser().parse_args(call))
    mismatch = drawn_result(np.random.default_rng(4), "data_mismatch")
    asked = replace(mismatch, mismatch={"advice": "Give it.", "option": "--scale reference=1"})
    words = list(next_step(asked, told).command)
    assert words[-2:] == ["--scale", "reference=1"]
    return words[1:-2]
