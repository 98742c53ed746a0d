"""The next experiment, computed: rivals, detection limits and intervals, expected and then seen."""

import json

import numpy as np
import pytest
from cogging.diagnosis.candidates.findings import profiled
from cogging.diagnosis.candidates.scan import scan
from cogging.diagnosis.evidence.null import fit_null, nuisances, sources_of
from cogging.diagnosis.experiment.detection import Detection, needed
from cogging.diagnosis.experiment.motion import Element, planned
from cogging.diagnosis.experiment.narrowing import Narrowing
from cogging.diagnosis.experiment.rivals import Found, found_in
from cogging.diagnosis.experiment.separation import Separation, pooled, within

import cogging
from cogging.effects.effect import VOCABULARY
from cogging.estimation.gauss_newton import fit
from cogging.files import FieldError, InputError
from tests.fixtures.pid_axis import MODEL

SMALL = MODEL.replace(controller=MODEL.controller.replace(sample_rate=1000.0))
LIMITS = cogging.MotionLimits(0.5, 5.0, 5.0, jerk=500.0).of(SMALL)
REST = 1.5e-3
SURVEY = (
    Element("strokes", {"reach": 1.0, "speed": 1.0, "speeds": 3.0}),
    Element("multisine", {"low": 2.0, "high": 40.0, "speed": 0.2}),
)
MOTION = planned(SURVEY, LIMITS, rate=1000.0)
#: Of each effect, parameters with which this axis shows it.
PRESENT = {
    "constant_force": {"force": 0.01},
    "cable_spring": {"stiffness": 0.1, "center": 0.2},
    "end_effect": {"force": 0.02, "decay_length": 0.05, "travel": [0.0, 0.51]},
    "cogging_harmonic": {"period": 0.03, "sine": 0.01, "cosine": -0.005},
    "coulomb_asymmetry": {"difference": 0.02},
    "viscous_asymmetry": {"difference": 0.1},
    "stribeck_friction": {"static_excess": 0.1, "velocity": 0.08, "exponent": 1.0},
    "position_dependent_friction": {"nodes": [0.0, 0.2, 0.4, 0.51], "levels": [0.0, 0.02, -0.02, 0.0]},
    "quadratic_drag": {"coefficient": 0.4},
    "force_constant_ripple": {"period": 0.04, "sine": 0.05, "cosine": 0.02},
    "force_constant_drift": {"change": 0.1, "time_constant": 1.0},
    "command_delay": {"delay": 1e-3},
    "actuator_lag": {"time_constant": 1e-3},
    "command_saturation": {"limit": 0.7},
    "command_dead_zone": {"width": 0.01},
    "encoder_periodic_error": {"period": 0.01, "sine": 3e-6, "cosine": 1e-6},
    "flexible_mode": {"frequency": 60.0, "damping_ratio": 0.03, "mass_ratio": 0.1},
    "disturbance_step": {"force": 0.03, "start": 1.0, "stop": 2.5},
    "disturbance_tone": {"frequency": 7.0, "sine": 0.01, "cosine": 0.0},
}


def question(name, alternatives, model=SMALL, **parameters):
    """What a motion is to tell of an effect."""
    effect = VOCABULARY[name].replace(**{**PRESENT.get(name, {}), **parameters})
    one = Found(name, (effect,), 0.0, tuple(alternatives), {})
    return Separation.of([one], one, model, VOCABULARY, REST)


def logged(separation, motion=MOTION, seed=1):
    return cogging.simulate(separation.truth, motion, seed=seed)


def entry(name, *alternatives, **parameters):
    return {
        "name": name,
        "alternatives": list(alternatives),
        "parameters": {k: {"value": v} for k, v in parameters.items()},
    }


def result(*effects, floor=0.0):
    return {"verdict": "ambiguous", "effects": list(effects), "gap": {"floor": floor}}


# Rivals ---------------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("name", sorted(PRESENT))
def test_an_effect_does_not_stand_apart_from_itself(name):
    """Refitted, it is itself: by sums of information and by the scan; beside nothing it is seen."""
    same = question(name, [name])
    log = logged(same)
    ready = same.looking(log)
    gram = ready.gram(log)
    alone = np.sqrt(same.squares(same.gram(log))[name])
    assert alone > 3.0
    [told] = ready.expectations(log)
    assert told.expected < max(0.3 * alone, 1.5)
    assert ready.squares(gram)[name] < max(0.15 * alone**2, 4.0)


PAIRS = [
    ("cable_spring", "end_effect"),
    pytest.param("cogging_harmonic", "encoder_periodic_error", marks=pytest.mark.study),
    pytest.param("force_constant_ripple", "cogging_harmonic", marks=pytest.mark.study),
]


@pytest.mark.parametrize(("name", "other"), PAIRS)
def test_what_is_expected_is_what_is_seen(name, other):
    """The mean over logs of other noise, as `diagnose` tells it."""
    asked = question(name, [other])
    log = logged(asked)
    [told] = asked.looking(log).expectations(log)
    seen = []
    for seed in range(2, 5):
        result = cogging.diagnose(logged(asked, seed=seed), SMALL, planned={"expected": [vars(told)]})
        seen.append(result.planned[0].measured)
    assert told.expected > 2.0
    assert 0.6 * told.expected - 1.0 < np.mean(seen) < 1.4 * told.expected + 1.0, (told.expected, seen)


def test_information_of_parts_adds_up():
    asked = question("cable_spring", ["end_effect"])
    log = logged(asked)
    ready = asked.looking(log)
    gram = ready.gram(log)
    one, two = ready.squares(gram)["end_effect"], ready.squares(2.0 * gram)["end_effect"]
    assert two == pytest.approx(2.0 * one, rel=1e-6)
    assert ready.utility(2.0 * gram) > ready.utility(gram)


def test_a_stated_level_explains_some_of_its_change():
    one = Found("mass_change", (), 0.1, ("force_constant_ripple",), {})
    exact = SMALL.replace(uncertainty={"mass": 0.0})
    vague = SMALL.replace(uncertainty={"mass": 0.05})
    expected = []
    for model in (exact, vague):
        asked = Separation.of([one], one, model, VOCABULARY, REST)
        log = logged(asked)
        expected.append(asked.looking(log).expectations(log)[0].expected)
    assert expected[0] > 5.0
    assert 1.5 < expected[1] <= 2.0  # 10 % of what is stated to 5 %


def test_a_disturbance_that_would_come_too_late_comes():
    late = SMALL.replace(effects=[VOCABULARY["disturbance_step"].replace(force=0.1, start=9.0, stop=11.0)])
    [step] = within(late, 5.0).effects
    assert 0.0 < step.start < step.stop < 5.0
    assert within(SMALL.replace(effects=[step]), 5.0).effects == (step,)


def test_the_weakest_pair_counts_most_and_a_hopeless_one_not_alone():
    assert pooled([9.0, 9.0]) > pooled([4.0, 100.0])
    assert pooled([0.0, 30.0]) > pooled([0.0, 3.0])
    assert pooled([1e6], 100.0) - pooled([1e5], 100.0) < 1e-2 < pooled([1e6]) - pooled([1e5])


@pytest.mark.parametrize(
    ("wrong", "said"),
    [
        ({"effects": {}}, "effects: must be the list of effects"),
        ({"effects": [3]}, "effects: must be the list of effects"),
        (result(entry("spring")), r"effects\[0\]\.name: must be an effect of the vocabulary, got 'spring'"),
        (result(entry("cable_spring", "magic")), r"effects\[0\]\.alternatives: must be names of the vocabulary"),
        (result(entry("cable_spring", stiff=1.0)), r"effects\[0\]\.parameters\.stiff: is no field of cable_spring"),
        (result(entry("cable_spring", stiffness="1")), r"stiffness: must have a number as its value, got '1'"),
        (result(entry("command_delay", delay=-1.0)), r"effects\[0\]\.parameters: "),
        (result(entry("mass_change", change=-1.5)), r"parameters\.change: must be a number above -1, got -1\.5"),
        (result(entry("mass_change")), r"parameters\.change: must be a number above -1, got None"),
    ],
)
def test_a_result_that_cannot_be_used_is_refused(wrong, said):
    with pytest.raises(FieldError, match=said):
        found_in(wrong, SMALL, VOCABULARY)


@pytest.mark.parametrize("name", sorted(cogging.EFFECTS))
def test_every_effect_of_the_vocabulary_is_read(name):
    parameters = {key: value for key, value in PRESENT.get(name, {}).items() if key != "travel"}
    if name == "cogging_modulation":
        parameters = {"period": 0.05, "sine": [0.0, 0.1, 0.2, 0.1, 0.0], "cosine": [0.0] * 5}
    [found] = found_in(result(entry(name, "constant_force", **parameters)), SMALL, VOCABULARY)
    [effect] = found.terms
    assert name == effect.NAME
    for key, value in parameters.items():
        assert getattr(effect, key) == value
    assert found.added_to(SMALL).effects == (effect,)


# Limits and intervals -------------------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("name", "field"),
    [("cable_spring", "stiffness"), pytest.param("coulomb_asymmetry", "difference", marks=pytest.mark.study)],
)
def test_a_detection_limit_is_where_an_effect_begins_to_be_found(name, field):
    asked = Detection.of(SMALL, {name: VOCABULARY[name]}, REST, {})
    log = cogging.simulate(SMALL, MOTION, seed=1)
    [told] = asked.looking(log).expectations(log)
    assert told.parameter == field
    assert told.unit == VOCABULARY[name].FIELDS[field][0]
    statistics = []
    for share in (0.3, 1.0):
        here = []
        for seed in range(2, 5):
            hidden = VOCABULARY[name].replace(**{field: share * told.expected})
            run = cogging.simulate(SMALL.replace(effects=[hidden]), MOTION, seed=seed)
            evidence = fit_null([run], SMALL)[1]
            found = profiled(evidence, scan(evidence, [VOCABULARY[name]]))
            here.append(found[0].test.statistic if found else 0.0)
        statistics.append(float(np.mean(here)))
    least = needed(1)
    assert statistics[0] < 0.6 * least
    assert 0.4 * least < statistics[1] < 2.0 * least


def test_needed_grows_with_freedom():
    assert 20.0 < needed(1) < needed(2) < needed(6) < 100.0


def test_an_interval_is_as_narrow_as_a_fit_makes_it():
    asked = Narrowing.of(SMALL, REST)
    log = cogging.simulate(SMALL, MOTION, seed=1)
    told = {one.name: one for one in asked.looking(log).expectations(log)}
    fitted = fit(SMALL, nuisances(SMALL), sources_of([log], SMALL, rest=REST, quick=True))
    halves = dict(zip(fitted.paths, fitted.half_width, strict=True))
    for path in ("axis.mass", "axis.viscous", "axis.coulomb"):
        assert 0.5 < told[path].expected / halves[path] < 2.0, path
        assert told[path].today is None


def test_what_is_known_before_counts():
    narrow = SMALL.replace(intervals={"axis.mass": (0.1199, 0.1201), "axis.viscous": (0.1, 0.2)})
    log = cogging.simulate(SMALL, MOTION, seed=1)
    told = {one.name: one for one in Narrowing.of(narrow, REST).looking(log).expectations(log)}
    free = {one.name: one for one in Narrowing.of(SMALL, REST).looking(log).expectations(log)}
    assert told["axis.mass"].today == pytest.approx(1e-4, rel=1e-3)
    for path in ("axis.mass", "axis.viscous"):
        assert told[path].expected <= told[path].today
        assert told[path].expected <= 1.01 * free[path].expected


# Plans ----------------------------------------------------------------------------------------------------------------


@pytest.fixture(scope="module")
def found():
    """A harmonic of force that a slow log took for an error of the encoder, or the other way round."""
    return result(entry("cogging_harmonic", "encoder_periodic_error", period=0.03, sine=0.006, cosine=0.0))


@pytest.fixture(scope="module")
def plan(found):
    return cogging.plan_experiment(SMALL, cogging.MotionLimits(0.5, 5.0, 6.0, jerk=500.0), result=found)


def test_a_plan_separates_better_than_the_usual_motion(plan, found):
    [told] = plan.expected
    assert (told.name, told.alternative, told.unit) == ("cogging_harmonic", "encoder_periodic_error", "sigma")
    [one] = found_in(found, SMALL, VOCABULARY)
    asked = Separation.of([one], one, SMALL, VOCABULARY, REST)
    usual = planned((Element("strokes", {"speed": 0.4}),), plan.limits, rate=1000.0)
    log = logged(asked, usual)
    [before] = asked.looking(log).expectations(log)
    assert told.expected > before.expected + 1.0
    assert all(share <= 1.0 for share in plan.taken.values())


def test_the_same_call_gives_the_same_plan(found):
    limits = cogging.MotionLimits(0.3, 5.0, 2.0)
    runs = [cogging.plan_experiment(SMALL, limits, result=found, goal="fit", seed=3) for _ in range(2)]
    assert runs[0] == runs[1]


def test_what_is_written_is_the_plan(plan, tmp_path):
    file = tmp_path / "next.toml"
    plan.write(file)
    assert sorted(path.name for path in tmp_path.iterdir()) == ["next.csv", "next.plan.json", "next.toml"]
    motion, duration = cogging.read_reference(file)
    assert duration == pytest.approx(plan.motion.end)
    times = np.linspace(0.0, plan.motion.end, 997)
    for read, meant in zip(motion.sample(times), plan.motion.sample(times), strict=True):
        assert np.abs(read - meant).max() < 1e-8 * float(np.abs(meant).max())
    log = cogging.simulate(SMALL, file, seed=9)
    assert np.abs(log.true_velocity).max() <= plan.limits.velocity
    told = json.loads((tmp_path / "next.plan.json").read_text())
    assert told["expected"] == [vars(one) for one in plan.expected]
    assert told["goal"] == "separate"


def test_the_new_log_says_what_became_of_it(plan, found, tmp_path):
    [one] = found_in(found, SMALL, VOCABULARY)
    log = cogging.simulate(one.added_to(SMALL), plan.motion, seed=11)
    plan.write(tmp_path / "next.toml")
    told = cogging.diagnose(log, SMALL, planned=tmp_path / "next.toml")
    assert told == cogging.diagnose(log, SMALL, planned=plan)
    [outcome] = told.planned
    assert outcome.expected == plan.expected[0].expected
    assert outcome.came_true is True
    assert outcome.measured > 2.0
    assert "for cogging_harmonic: it came true" in told.text()
    assert told.to_dict()["planned"] == [vars(outcome)]
    # The rival's own log speaks for the rival.
    other = VOCABULARY["encoder_periodic_error"].replace(period=0.03, sine=1e-5)
    [against] = cogging.diagnose(
        cogging.simulate(SMALL.replace(effects=[other]), plan.motion, seed=12), SMALL, planned=plan
    ).planned
    assert against.measured < outcome.measured - 2.0


@pytest.mark.parametrize("goal", [pytest.param("detect", marks=pytest.mark.study), "fit"])
def test_the_other_goals_come_true_too(goal):
    limits = cogging.MotionLimits(0.5, 5.0, 4.0, jerk=500.0)
    plan = cogging.plan_experiment(SMALL, limits, goal=goal)
    assert plan.goal == goal
    log = cogging.simulate(SMALL, plan.motion, seed=5)
    told = cogging.diagnose(log, SMALL, planned=plan).planned
    assert [one.name for one in told] == [one.name for one in plan.expected]
    shares = [one.measured / one.expected for one in told if one.measured is not None and one.expected is not None]
    assert len(shares) >= 3
    assert 0.4 < np.median(shares) < 2.0
    assert all(one.came_true == (one.measured <= 2.0 * one.expected) for one in told if one.came_true is not None)


def test_a_goal_is_chosen_from_the_result():
    limits = cogging.MotionLimits(0.5, 5.0, 2.0)
    with pytest.raises(ValueError, match="goal: separate needs a result with alternatives"):
        cogging.plan_experiment(SMALL, limits, goal="separate")
    with pytest.raises(ValueError, match="goal: must be one of separate, detect, fit, got 'all'"):
        cogging.plan_experiment(SMALL, limits, goal="all")


def test_limits_that_no_motion_keeps_to_are_refused():
    with pytest.raises(ValueError, match="limits: no motion of this machine keeps to them"):
        cogging.plan_experiment(SMALL, cogging.MotionLimits(0.5, 5.0, 2.0, command=0.1), goal="fit")


def test_what_is_not_stated_is_said():
    bare = SMALL.replace(
        controller=None,
        controller_type=None,
        noise=cogging.NoiseParameters(),
        encoder=cogging.EncoderParameters(),
    )
    plan = cogging.plan_experiment(bare, cogging.MotionLimits(0.3, 5.0, 2.0), goal="fit")
    assert any("states no controller" in note for note in plan.notes)
    assert any("neither noise nor the encoder's resolution" in note for note in plan.notes)
    assert "note: the model states no controller" in plan.text()


def test_noise_as_loud_as_the_result_measured_it(found):
    """A floor three times the model's noise makes the same motion tell a third as much."""
    [one] = found_in(found, SMALL, VOCABULARY)
    asked = Separation.of([one], one, SMALL, VOCABULARY, REST)
    log = logged(asked)
    ready = asked.looking(log)
    louder = Separation(**{**vars(ready), "loudness": 9.0})
    [quiet], [loud] = ready.expectations(log), louder.expectations(log)
    assert loud.expected == pytest.approx(quiet.expected / 3.0, rel=1e-2)


def test_a_plan_that_is_none_is_refused(tmp_path):
    log = cogging.simulate(SMALL, MOTION, seed=1)
    file = tmp_path / "next.toml"
    with pytest.raises(InputError, match=r"next\.plan\.json: cannot be read"):
        cogging.diagnose(log, SMALL, planned=file)
    (tmp_path / "next.plan.json").write_text("[1]")
    with pytest.raises(InputError, match="must be the plan of cogging experiment, got a list"):
        cogging.diagnose(log, SMALL, planned=file)
    (tmp_path / "next.plan.json").write_text('{"expected": [{"name": 3}]}')
    with pytest.raises(InputError, match=r"next\.plan\.json: expected\[0\]\.name: must be a text, got 3"):
        cogging.diagnose(log, SMALL, planned=file)
