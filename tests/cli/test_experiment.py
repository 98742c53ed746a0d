"""`cogging experiment` as a user calls it: a result and limits in, a reference that the machine can run out."""

import json
import re

import numpy as np
import pytest

import cogging
from cogging.cli.main import main
from tests.fixtures.files import MODEL

LIMITS = "velocity = 0.3\nacceleration = 5.0\njerk = 500.0\nduration = 2.5\ncommand = 2.0\n"
RESULT = {"verdict": "ambiguous", "effects": [{"name": "cable_spring", "alternatives": ["end_effect"]}]}
CALL = ["experiment", "--model", "model.toml", "--limits", "limits.toml", "--out", "next.toml"]


@pytest.fixture
def folder(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "model.toml").write_text(MODEL)
    (tmp_path / "limits.toml").write_text(LIMITS)
    (tmp_path / "result.json").write_text(json.dumps(RESULT))
    return tmp_path


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
    assert log.time[-1] <= 2.5
    assert np.abs(log.command).max() <= 2.0
    assert np.abs(np.diff(log.reference)).max() <= 0.3 * np.diff(log.time).max()
    capsys.readouterr()
    assert main([*CALL, "--result", "result.json", "--logs", "new.csv", "--json", "-"]) == 0
    assert json.loads(capsys.readouterr().out)["goal"] == "separate"
    assert (folder / "next.csv").read_text() != first


@pytest.mark.parametrize(
    ("file", "text", "said"),
    [
        ("limits.toml", LIMITS.replace("0.3", "-1"), "limits.toml: line 1: velocity: must be a number above 0"),
        ("limits.toml", LIMITS + "travel = [0.0, 9.0]", "limits.toml: line 6: travel: must be inside the model's"),
        ("result.json", "{", "result.json: must be the result of diagnose --json (JSON): "),
        ("result.json", "{}", "result.json: must be the result of diagnose --json, got no verdict and effects"),
    ],
)
def test_invalid_input_is_one_line(file, text, said, folder, capsys):
    (folder / file).write_text(text)
    assert main([*CALL, "--result", "result.json"]) == 2
    answer = capsys.readouterr().err
    assert answer.startswith(f"cogging: {said}"), answer
    assert answer.count("\n") == 1
    assert not list(folder.glob("next*"))


def test_missing_limits_are_drafted(folder, capsys):
    (folder / "limits.toml").unlink()
    call = [*CALL[:5], "--seed", "3", *CALL[5:], "--json", "plan.json"]
    assert main(call) == 0
    assert capsys.readouterr().out.endswith(f"limits.toml written\nnext: cogging {' '.join(call)}\n")
    limits = cogging.MotionLimits.read("limits.toml")
    assert limits == cogging.MotionLimits(0.255, 1.27, 20.0, travel=(0.0, 0.51))
    motion = "start = 0.05\ndistance = 0.4\nvelocity = 0.3\nacceleration = 4.0\njerk = 400.0\n"
    (folder / "ref.toml").write_text(f'type = "point_to_point"\n{motion}')
    assert main(["simulate", "model.toml", "--reference", "ref.toml", "--out", "log.csv"]) == 0
    log = cogging.read_log("log.csv")
    assert main([*CALL[:4], "seen.toml", *CALL[5:], "--logs", "log.csv"]) == 0
    seen = cogging.MotionLimits.read("seen.toml")
    assert seen.velocity == pytest.approx(0.3, rel=0.03)
    assert seen.command == pytest.approx(np.abs(log.command).max(), rel=0.01)
