"""A small fixed part of the blind benchmark: `diagnose` on logs from a simulator that shares nothing with the core.

The seed is a tuning seed: what is asserted here is no rate to report (see `python -m tests.blind.benchmark --report`).
"""

import json

import pytest

from tests.blind.benchmark import run_case
from tests.blind.score import judge
from tests.blind.suite import draw_suite, plan_suite

SEED = 7
CALM = ["plain", "coloured_noise", "pink_noise", "wrong_nominals", "fine_steps", "poor_motion"]
EASY = ["cable_spring", "disturbance_tone", "viscous_asymmetry", "command_dead_zone", "cogging_harmonic"]
PLAN = plan_suite(SEED, 6, kinds=["null"], families=CALM)
PLAN += plan_suite(SEED, 5, kinds=["effect"], effects=EASY, ratios=[1000.0])
PLAN += plan_suite(SEED, 4, kinds=["effect"], effects=["local_force"], ratios=[1000.0])
#: Places in the plan: a null and a snag at 1 kHz; all are a longer study.
CASES = [pytest.param({3, 12}, id="some"), pytest.param(set(range(15)), id="all", marks=pytest.mark.study)]


@pytest.fixture(scope="module", params=CASES)
def outcomes(request, tmp_path_factory):
    folder = tmp_path_factory.mktemp("blind")
    plan = [one if place in request.param else None for place, one in enumerate(PLAN)]
    found = []
    for name, key in sorted(draw_suite(SEED, folder / "cases", folder / "key", plan)["cases"].items()):
        answer = folder / f"{name}.json"
        _, result, seconds = run_case((folder / "cases" / name, answer))
        assert json.loads(answer.read_text())["result"] == json.loads(json.dumps(result))
        print(name, key["kind"], [e["name"] for e in key["effects"]], "->", result.get("verdict", result))
        found.append(judge(key, result, seconds))
    assert len(found) == len(request.param)
    return found


def test_nothing_is_found_where_nothing_is_hidden(outcomes):
    nulls = [one.verdict for one in outcomes if one.kind == "null"]
    assert nulls
    assert set(nulls) <= {"no_gap", "insufficient_excitation"}


def test_strong_effects_are_named_and_none_wrongly(outcomes):
    """A snag is a force at one place and no modulation, whatever its shape."""
    strong = [one for one in outcomes if one.kind == "effect"]
    snags = [one for one in strong if one.truths == ("local_force",)]
    assert all(one.found for one in strong if one not in snags)
    assert sum(one.found for one in snags) >= 0.75 * len(snags) > 0
    assert not any(one.wrong for one in strong)
