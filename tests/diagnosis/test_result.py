"""The result: what it holds, what JSON has of it, and that showing it computes nothing."""

import json
import math

import numpy as np
import pytest

import cogging
from cogging.diagnosis.balance.evidence import Evidence
from cogging.diagnosis.entries import Gap
from cogging.estimation import gauss_newton
from cogging.estimation.innovations import Innovations
from cogging.estimation.replay import Replay
from tests.fixtures.pid_axis import MODEL, run


def test_the_json_is_as_the_contract_says(found):
    told = json.loads(json.dumps(found.to_dict(), allow_nan=False))
    assert set(told) >= {"verdict", "effects", "unlisted", "gap", "separating_experiment"}
    assert told["verdict"] == "named"
    (effect,) = told["effects"]
    assert set(effect) >= {"name", "alternatives", "confidence", "parameters", "where"}
    assert effect["alternatives"] == []
    assert 0.0 <= effect["confidence"] <= 1.0
    assert set(effect["parameters"]["difference"]) == {"value", "unit", "ci95"}
    assert effect["parameters"]["difference"]["unit"] == "V/(m/s)"
    assert set(effect["where"]) == {"coordinate", "range"}
    assert len(effect["where"]["range"]) == 2
    gap = told["gap"]
    assert set(gap) >= {"unit", "floor", "before", "after", "confirm_before", "confirm_after"}
    assert all(isinstance(gap[key], float) for key in ("floor", "before", "after", "confirm_before", "confirm_after"))
    assert told["unlisted"] is None
    assert told["separating_experiment"] is None


def test_what_is_not_finite_is_null():
    gap = Gap("V", math.nan, math.inf, 0.0, None, None, "not measured")
    spoilt = cogging.Diagnosis(
        "no_gap", (), {"share": np.float64("nan"), "places": np.ones(2)}, gap, None, MODEL, MODEL
    )
    told = spoilt.to_dict()
    assert told["gap"]["floor"] is None
    assert told["gap"]["before"] is None
    assert told["unlisted"] == {"share": None, "places": [1.0, 1.0]}


def test_showing_a_result_computes_nothing(found, monkeypatch):
    """Neither a fit nor a prediction, a replay, a score test or least squares: all that is shown was held."""

    def computed(*arguments, **named):
        raise AssertionError("something was computed while a result was shown")

    for owner, names in (
        (Innovations, ["__init__", "of"]),
        (Replay, ["__init__", "of", "run"]),
        (Evidence, ["make", "fitted", "score"]),
        (np.linalg, ["lstsq", "solve", "eigh", "pinv"]),
        (gauss_newton, ["fit"]),
    ):
        for name in names:
            monkeypatch.setattr(owner, name, computed)
    assert found.text().startswith("verdict: named")
    assert found.to_dict()["verdict"] == "named"
    assert found.html().count("<svg") >= 2
    assert len(found.plot().axes) == 4
    assert len(found.location.plot().axes) == 4
    with pytest.raises(AssertionError, match="while a result was shown"):  # the watch does watch
        cogging.locate_gap(run(duration=1.0), MODEL)


def test_a_result_holds_where_its_gap_sits(found):
    shapes = found.location.shapes
    assert [shape.log_p_value for shape in shapes] == sorted(shape.log_p_value for shape in shapes)
    assert found.where_text == tuple(found.location.lines())
    assert {shape.coordinate for shape in found.location.significant} >= {"velocity"}


def test_a_result_holds_what_each_effect_takes_and_what_is_left(found):
    told = found.to_dict()
    (effect,), gap = told["effects"], told["gap"]
    assert effect["share"] == pytest.approx(1.0 - (gap["after"] / gap["before"]) ** 2, rel=0.05)
    command = found.series["command"][0][found.series["mask"][0]]
    assert gap["share"] == pytest.approx(gap["after"] / np.sqrt(np.mean(command**2)), rel=0.05)
    assert 0.0 <= gap["predictable"] < 0.2
    assert gap["signal"] == "command of the replayed loop"
    assert gap["given"] > 0.0
