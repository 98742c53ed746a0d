"""`cogging experiment` as a user calls it: a result and limits in, a reference that the machine can run out."""

import json
import re

import numpy as np
import pytest

import cogging
from cogging.cli.main import main
from tests.fixtures.command_files import LIMITS

CALL = ["experiment", "--model", "model.toml", "--limits", "limits.toml", "--out", "next.toml"]


def test_from_a_result_to_a_motion_and_to_another(folder, capsys):
    assert main([*CALL, "--result", "result.json"]) == 0
    out = capsys.readouterr().out
    assert "the alternatives differ most in: the full travel" in out
    assert re.search(r"constant_force: force of \S+ V would be detected", out)
    assert "\nnext.toml, next.csv, next.plan.json written\n" in out
    assert out.endswith("next: cogging diagnose NEW_LOG.csv --model model.toml\n")
    first = (folder / "next.csv").read_text()
    assert main(["simulate", "model.toml", "--reference", "next.toml", "--out", "new.csv"]) == 0
    log = cogging.read_log(folder / "new.csv")
    assert log.time[-1] <= LIMITS["duration"]
    assert np.abs(np.diff(log.reference)).max() <= 0.3 * np.diff(log.time).max()
    capsys.readouterr()
    assert main([*CALL, "--result", "result.json", "--logs", "new.csv", "--json", "-"]) == 0
    assert json.loads(capsys.readouterr().out)["goal"] == "separate"
    assert (folder / "next.csv").read_text() != first


def test_missing_limits_are_drafted(folder, capsys):
    (folder / "limits.toml").unlink()
    call = [*CALL[:5], "--seed", "3", *CALL[5:], "--json", "plan.json"]
    assert main(call) == 0
    assert capsys.readouterr().out.endswith(f"limits.toml written\nnext: cogging {' '.join(call)}\n")
    assert cogging.MotionLimits.read("limits.toml") == cogging.MotionLimits(0.255, 1.27, 20.0, travel=(0.0, 0.51))
    log = cogging.read_log("log.csv")
    assert main([*CALL[:4], "seen.toml", *CALL[5:], "--logs", "log.csv"]) == 0
    seen = cogging.MotionLimits.read("seen.toml")
    assert seen.velocity == pytest.approx(0.5, rel=0.03)
    assert seen.command == pytest.approx(np.abs(log.command).max(), rel=0.01)
