"""What to do next: a command that the program takes, whatever was found and whatever the files are called."""

import shlex
from dataclasses import replace

import numpy as np
import pytest

from cogging.cli.main import _parser
from cogging.diagnosis.next_step import GivenFiles, next_step
from tests.fixtures.drawn_results import VERDICTS, drawn_result

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
