"""A small fixed part of the blind benchmark: `diagnose` on logs from a simulator that shares nothing with the core.

The seed is a tuning seed: what is asserted here is no rate to report (see `python -m tests.blind.benchmark --report`).
"""

import json

import pytest

from tests.blind.runners import run_case
from tests.blind.score import judge
from tests.blind.suite import draw_suite, plan_suite

SEED = 7
CALM = ["plain", "coloured_noise", "pink_noise", "wrong_nominals", "fine_steps", "poor_motion"]
EASY = ["cable_spring", "disturbance_tone", "viscous_asymmetry", "command_dead_zone", "cogging_harmonic"]


#: How many of the drawn cases are run: nulls, effects, snags. All of them are a longer study.
CASES = [pytest.param((1, 2, 1), id="some"), pytest.param((6, 5, 4), id="all", marks=pytest.mark.study)]


@pytest.fixture(scope="module", params=CASES)
def counts(request):
    return dict(zip(("null", "effect", "snag"), request.param, strict=True))


def first(plan, count):
    """The plan with its first cases alone."""
    return [one if index < count else None for index, one in enumerate(plan)]


@pytest.fixture(scope="module")
def snags(counts, tmp_path_factory):
    """Results on logs of axes that a force holds at one place, of any shape."""
    folder = tmp_path_factory.mktemp("snags")
    plan = plan_suite(SEED, 4, kinds=["effect"], effects=["local_force"], ratios=[1000.0])
    key = draw_suite(SEED, folder / "cases", folder / "key", first(plan, counts["snag"]))
    cases = [(str(folder / "cases" / name), str(folder / f"{name}.json")) for name in sorted(key["cases"])]
    return [run_case(case)[1] for case in cases]


def test_a_snag_is_a_force_at_one_place_and_no_modulation(snags):
    names = [[{effect["name"], *effect["alternatives"]} for effect in result["effects"]] for result in snags]
    print([(result["verdict"], told) for result, told in zip(snags, names, strict=True)])
    assert sum(any("local_force" in one for one in told) for told in names) >= 0.75 * len(names)
    assert not any("cogging_modulation" in one for told in names for one in told)


@pytest.fixture(scope="module")
def outcomes(counts, tmp_path_factory):
    folder = tmp_path_factory.mktemp("blind")
    nulls = first(plan_suite(SEED, 6, kinds=["null"], families=CALM), counts["null"])
    plan = nulls + first(plan_suite(SEED, 5, kinds=["effect"], effects=EASY, ratios=[1000.0]), counts["effect"])
    key = draw_suite(SEED, folder / "cases", folder / "key", plan)
    found = []
    for name, truth in sorted(key["cases"].items()):
        answer = folder / f"{name}.json"
        _, result, seconds = run_case((str(folder / "cases" / name), str(answer)))
        assert json.loads(answer.read_text())["result"] == json.loads(json.dumps(result))
        print(name, truth["kind"], [e["name"] for e in truth["effects"]], "->", result.get("verdict", result))
        found.append((truth, result, judge(name, truth, result, seconds)))
    return found


def test_every_case_is_answered(outcomes, counts):
    assert len(outcomes) == counts["null"] + counts["effect"]
    assert all("error" not in result for _, result, _ in outcomes)


def test_nothing_is_named_where_nothing_is_hidden(outcomes, counts):
    nulls = [result["verdict"] for truth, result, _ in outcomes if truth["kind"] == "null"]
    assert len(nulls) == counts["null"]
    assert set(nulls) <= {"no_gap", "insufficient_excitation"}


def test_strong_effects_are_named_and_none_wrongly(outcomes, counts):
    right = wrong = 0
    for truth, result, _ in outcomes:
        if truth["kind"] != "effect":
            continue
        hidden = {e["name"] for e in truth["effects"]}
        names = {n for e in result["effects"] for n in (e["name"], *e["alternatives"])}
        right += hidden <= names
        wrong += result["verdict"] == "named" and not hidden & names
    assert (right, wrong) == (counts["effect"], 0)
