"""`cogging experiment`: a result and limits in, a reference within the limits out."""

import json
import re

import numpy as np
import pytest

import cogging
from cogging.cli.main import main
from tests.fixtures import command_files
from tests.fixtures.command_files import RESULT

LIMITS = "velocity = 0.3\nacceleration = 5.0\njerk = 500.0\nduration = 2.0\ncommand = 2.0\n"
CALL = ["experiment", "--model", "model.toml", "--limits", "limits.toml", "--out", "next.toml"]


@pytest.fixture
def folder(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    command_files.write(tmp_path)
    (tmp_path / "limits.toml").write_text(LIMITS)
    return tmp_path


def test_from_a_result_to_a_motion_within_the_limits(folder, capsys):
    assert main([*CALL, "--result", "result.json"]) == 0
    printed = capsys.readouterr().out
    assert re.search(r"cable_spring or end_effect: the right one is the likelier in \d+ % of simulated runs", printed)
    assert "\nnext.toml, next.csv, next.plan.json written\n" in printed
    assert printed.endswith("next: cogging diagnose NEW_LOG.csv --model model.toml\n")
    assert main(["simulate", "model.toml", "--reference", "next.toml", "--out", "new.csv"]) == 0
    log = cogging.read_log(folder / "new.csv")
    assert log.time[-1] <= 2.0
    assert np.abs(log.command).max() <= 2.0
    assert np.abs(np.diff(log.reference)).max() <= 0.3 * np.diff(log.time).max()
    assert json.loads((folder / "next.plan.json").read_text())["goal"] == "separate"


NO_RESULT = "result.json: must be the result of diagnose --json"


@pytest.mark.parametrize(
    ("file", "text", "message"),
    [
        ("limits.toml", "velocity = 0.3\nduration = 3.0", "limits.toml: acceleration: must be given, got nothing"),
        ("limits.toml", LIMITS.replace("0.3", "-1"), "limits.toml: line 1: velocity: must be a number above 0"),
        ("limits.toml", LIMITS + "travel = [0.0, 9.0]", "limits.toml: line 6: travel: must be inside the model's"),
        ("limits.toml", LIMITS.replace("command = 2.0", "command = 0.01"), "limits.toml with model.toml: no motion of"),
        ("result.json", "{", f"{NO_RESULT} (JSON): "),
        ("result.json", "{}", f"{NO_RESULT}, got no verdict and effects"),
        ("result.json", "[" * 100_000, f"{NO_RESULT}, got lists or"),
        ("result.json", json.dumps(RESULT).replace("cable_spring", "spring"), "result.json: effects[0].name: must be"),
    ],
)
def test_invalid_input_is_one_line(file, text, message, folder, capsys):
    (folder / file).write_text(text)
    assert main([*CALL, "--result", "result.json"]) == 2
    error = capsys.readouterr().err
    assert error.startswith(f"cogging: {message}"), error
    assert error.count("\n") == 1
    assert not list(folder.glob("next*"))


def test_limits_that_are_not_there_are_drafted(folder, capsys):
    (folder / "limits.toml").unlink()
    assert main(CALL) == 0
    assert capsys.readouterr().out.endswith(f"limits.toml written\nnext: cogging {' '.join(CALL)}\n")
    assert cogging.MotionLimits.read("limits.toml") == cogging.MotionLimits(0.255, 1.27, 20.0, travel=(0.0, 0.51))
    motion = {"type": "point_to_point", "start": 0.05, "distance": 0.4, "velocity": 0.3, "acceleration": 4.0}
    log = cogging.simulate("model.toml", {**motion, "jerk": 400.0})
    log.write("log.csv")
    assert main([*CALL[:4], "seen.toml", *CALL[5:], "--logs", "log.csv"]) == 0
    seen = cogging.MotionLimits.read("seen.toml")
    assert seen.velocity == pytest.approx(0.3, rel=0.03)
    assert seen.command == pytest.approx(np.abs(log.command).max(), rel=0.01)


def test_a_goal_that_the_result_does_not_allow(folder, capsys):
    assert main([*CALL, "--goal", "separate"]) == 2
    expected = "cogging: goal: separate needs a result with alternatives, got none; detect and fit need none\n"
    assert capsys.readouterr().err == expected
