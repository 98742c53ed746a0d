"""What to do next: a command that the program takes, whatever was found and whatever the files are called."""

import html
import shlex
from dataclasses import replace

import numpy as np
import pytest

from cogging.cli.log_options import OPTIONS
from cogging.cli.main import _parser, main
from cogging.diagnosis.next_step import GivenFiles, next_step
from tests.fixtures.drawn_results import VERDICTS, drawn_result
from tests.fixtures.pid_axis import MODEL, run

HOSTILE = ("my log.csv", "a'b.csv", "$HOME.csv", "log;rm.csv", "ünïcode.csv", "x" * 200 + ".csv")
NAMED = GivenFiles(HOSTILE[:2], HOSTILE[2], HOSTILE[3:5], "r e.json", HOSTILE[5])


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
        if not step.line:
            assert verdict == "data_mismatch"
            continue
        words = shlex.split(step.line)
        assert words[0] == "cogging"
        parsed = _parser().parse_args(words[1:])
        given = files or GivenFiles()
        commands.add(words[1])
        if words[1] in ("diagnose", "audit"):
            assert parsed.model == given.model
        if words[1] == "diagnose":
            assert set(given.logs) <= {*parsed.logs, *parsed.confirm}
            assert parsed.confirm[: len(given.confirm)] == list(given.confirm)
    assert commands or verdict == "data_mismatch"


def test_a_name_that_is_sure_is_written_checked_then_used(found):
    """The model is written, confirmed by other motion, then used; one of several logs can confirm."""
    alone = replace(found, gap=replace(found.gap, confirm_before=None, confirm_after=None))
    patched = GivenFiles(patched="new.toml")
    assert next_step(alone).kind == "write_model"
    assert next_step(alone).line.endswith("--out PATCHED.toml")
    assert next_step(alone, patched).kind == "confirm"
    assert "--confirm OTHER_LOG.csv" in next_step(alone, patched).line
    assert next_step(alone, GivenFiles(("a.csv", "b.csv"))).kind == "confirm_by_last"
    assert next_step(found).line.endswith("--out PATCHED.toml")
    assert next_step(found, patched).kind == "use"
    assert next_step(found, patched).line.startswith("cogging predict new.toml")


@pytest.mark.parametrize("verdict", VERDICTS)
def test_what_was_just_followed_is_not_next(verdict):
    """A call is not proposed again as it was given."""
    generator = np.random.default_rng(5 + VERDICTS.index(verdict))
    followed = replace(NAMED, empirical=True)
    call = ["diagnose", *NAMED.logs, "--model", NAMED.model, "--confirm", *NAMED.confirm, "--out", NAMED.patched]
    for _ in range(8):
        words = shlex.split(next_step(drawn_result(generator, verdict), followed).line)
        assert words[1:] not in (call, [*call, "--empirical"])


def test_the_report_of_the_command_says_what_the_screen_says(tmp_path, capsys):
    """The command in it names the files and how they were read."""
    run(duration=0.6).write(tmp_path / "a b.csv")
    MODEL.write(tmp_path / "m.toml")
    call = ["diagnose", str(tmp_path / "a b.csv"), "--model", str(tmp_path / "m.toml"), "--rows", "a b.csv:0:590"]
    call += ["--scale", "command=1,position=1.0", "--zero", "position=-0.001", "--report", str(tmp_path / "r.html")]
    assert main(call) == 0
    told = html.unescape((tmp_path / "r.html").read_text()).partition("<pre>")[2].partition("</pre>")[0]
    assert capsys.readouterr().out.rstrip().endswith(f"next: {told}")
    words = shlex.split(told)
    assert words[:2] == ["cogging", "audit"]  # moved by its zero, the log is not what the controller made
    shown, once = _parser().parse_args(words[1:]), _parser().parse_args(call)
    for option in OPTIONS:
        assert getattr(shown, option) == getattr(once, option)
    assert (shown.model, shown.logs) == (once.model, once.logs)
