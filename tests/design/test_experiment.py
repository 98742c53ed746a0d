"""The next experiment: limits files, a motion within them on drawn machines, and what it is expected to show."""

import json

import numpy as np
import pytest

import cogging
from cogging.design.experiment_motion import motion_within
from cogging.diagnosis.balance.decision import THRESHOLD, score_of
from cogging.diagnosis.balance.differenced_balance import DifferencedBalance
from cogging.diagnosis.balance.evidence import Evidence
from cogging.effects.effect import VOCABULARY
from cogging.files import FieldError, InputError
from cogging.model.parameters import parameters_of
from tests.fixtures.pid_axis import MODEL

SMALL = MODEL.replace(uncertainty={"coulomb_width": 0.0})
LIMITS = cogging.MotionLimits(0.5, 5.0, 5.0, jerk=500.0)
GOOD = {"travel": [0.0, 0.4], "velocity": 0.5, "acceleration": 5.0, "jerk": 400.0, "duration": 5.0, "command": 3.0}
COLUMNS = ("time", "reference", "reference_velocity", "reference_acceleration")
RIVALS = {"name": "cogging_harmonic", "alternatives": ["encoder_periodic_error"]}
RESULT = {"effects": [RIVALS], "limits": {"constant_force": {"parameter": "force", "value": 0.5}}}


def drawn_limits(random):
    """Limits of machines from a stage of some millimetres to a gantry, slow and quick."""
    length, acceleration, sharp = np.exp(random.uniform(np.log([5e-3, 0.5, 5.0]), np.log([3.0, 40.0, 1000.0])))
    low, velocity = random.uniform(-1.0, 1.0), random.uniform(0.1, 1.0) * np.sqrt(acceleration * length)
    options = {"travel": (low, low + length), "jerk": sharp * acceleration}
    return cogging.MotionLimits(velocity, acceleration, random.uniform(2.0, 6.0), **options)


@pytest.mark.parametrize(
    ("change", "said"),
    [
        ({"velocity": 0.0}, "velocity: must be a number above 0"),
        ({"acceleration": "5"}, "acceleration: must be a number above 0"),
        ({"command": float("nan")}, "command: must be a number above 0"),
        ({"jerk": True}, "jerk: must be a number above 0"),
        ({"duration": 1.0}, "duration: must be from 2 to 600 s, got 1.0"),
        ({"travel": [0.4, 0.0]}, "travel: must be its lower and its upper end"),
        ({"travel": [0.4]}, "travel: must be its lower and its upper end"),
        ({"speed": 0.5}, "speed: is unknown"),
    ],
)
def test_an_invalid_limit_is_refused(change, said):
    with pytest.raises(FieldError, match=said):
        cogging.MotionLimits.from_dict(GOOD | change)


@pytest.mark.parametrize("name", GOOD)
def test_which_limits_must_be_given(name, tmp_path):
    rest = {key: value for key, value in GOOD.items() if key != name}
    file = tmp_path / "limits.toml"
    file.write_text("\n".join(f"{key} = {value}" for key, value in rest.items()))
    if name in ("velocity", "acceleration", "duration"):
        with pytest.raises(InputError, match=rf"limits\.toml: {name}: must be given, got nothing"):
            cogging.MotionLimits.read(file)
    else:
        assert cogging.MotionLimits.read(file).to_dict() == rest


def test_the_model_completes_the_limits():
    stated, few = cogging.MotionLimits.from_dict(GOOD), cogging.MotionLimits(0.5, 5.0, 3.0)
    assert stated.of(SMALL) == stated
    completed = few.of(SMALL)
    assert (completed.travel, completed.jerk, completed.command) == (tuple(SMALL.axis.travel), 500.0, None)
    limited = SMALL.replace(controller=SMALL.controller.replace(command_limit=2.5))
    assert few.of(limited).command == stated.of(limited).command == 2.5
    free = SMALL.replace(axis=SMALL.axis.replace(travel=[-np.inf, np.inf]))
    with pytest.raises(FieldError, match="travel: must be given where the model states none"):
        few.of(free)
    with pytest.raises(FieldError, match="travel: must be inside the model's"):
        cogging.MotionLimits(0.5, 5.0, 3.0, travel=(-0.1, 0.4)).of(SMALL)


@pytest.mark.parametrize("seed", range(8))
def test_a_motion_keeps_its_limits_and_is_consistent(seed):
    limits = drawn_limits(np.random.default_rng(seed))
    motion, parts = motion_within(limits, 2000.0, seed=seed)
    time, position, velocity, acceleration = (motion.samples[name] for name in COLUMNS)
    low, high = limits.travel
    assert limits.duration - 1e-3 < time[-1] <= limits.duration
    assert np.abs(velocity).max() <= limits.velocity
    assert np.abs(acceleration).max() <= limits.acceleration
    assert np.abs(np.diff(acceleration) / np.diff(time)).max() <= limits.jerk
    assert low < position.min()
    assert position.max() < high
    assert not np.any([velocity[[0, -1]], acceleration[[0, -1]]])
    covered = position[0] + np.concatenate([[0.0], np.cumsum(0.5 * (velocity[1:] + velocity[:-1]) * np.diff(time))])
    assert np.abs(covered - position).max() < 2e-4 * (high - low)
    assert parts[0].kind == "strokes"
    assert np.mean(np.abs(velocity) > 2e-4 * limits.velocity) > 0.5


def test_a_motion_shows_what_separates_effects():
    """Full travel, speeds over a factor of four, other commands at the same place, small reversals, fast content."""
    limits = cogging.MotionLimits(0.5, 5.0, 20.0, jerk=500.0, travel=(0.0, 0.5))
    motion, parts = motion_within(limits, 2000.0)
    position, velocity, acceleration = (motion.samples[name] for name in COLUMNS[1:])
    rows = {part.kind: slice(round(part.start * 2000), round(part.end * 2000)) for part in parts}
    assert list(rows) == ["strokes", "random_moves", "creep", "sweep"]
    assert np.ptp(position[rows["strokes"]]) > 0.95 * 0.5
    speed = np.abs(velocity[rows["strokes"]])
    assert all(np.mean(np.abs(speed / top - 1.0) < 0.02) > 0.05 for top in (0.45, 0.18))
    accelerated, _ = np.histogram(position[np.abs(acceleration) > 0.5], bins=10)
    assert np.sum(accelerated > 20) >= 5  # of ten places
    slow = velocity[rows["creep"]][2000:]
    assert 0.0 < np.abs(slow).max() < 0.02 * limits.velocity
    assert np.sum(np.diff(np.sign(slow[slow != 0.0])) != 0.0) > 4
    spectrum = np.abs(np.fft.rfft(acceleration[rows["sweep"]])) ** 2
    frequency = np.fft.rfftfreq(len(acceleration[rows["sweep"]]), 5e-4)
    assert spectrum[(frequency > 100.0) & (frequency < 140.0)].min() > 100.0 * spectrum[frequency > 400.0].max()


@pytest.mark.parametrize("seed", range(2))
def test_the_machine_keeps_to_the_limits(seed):
    random = np.random.default_rng(seed)
    velocity, acceleration, command = random.uniform((0.2, 2.0, 0.4), (0.8, 8.0, 1.0))
    limits = cogging.MotionLimits(velocity, acceleration, 3.0, travel=(0.05, 0.4), command=command)
    plan = cogging.plan_experiment(SMALL, limits, goal="fit", seed=seed)
    assert (plan.scale < 1.0) == (command < 0.9 * (0.12 * acceleration + 0.166 * velocity) + 0.15)
    log = cogging.simulate(SMALL, plan.motion, seed=seed)
    assert np.abs(log.command).max() <= command
    assert np.abs(log.true_velocity).max() <= velocity
    stop = log.true_velocity * np.abs(log.true_velocity) / (2.0 * acceleration)
    for place in (log.true_position, log.true_position + stop):
        assert 0.05 <= place.min() <= place.max() <= 0.4


@pytest.fixture(scope="module")
def plan():
    return cogging.plan_experiment(SMALL, LIMITS, result=RESULT)


def evidence_of(log):
    """The evidence that `diagnose` has of one log."""
    balance = DifferencedBalance(log, SMALL.axis.coulomb_width, SMALL.encoder.resolution)
    balance.listen(balance.residual(SMALL), SMALL.axis)
    return Evidence([balance], SMALL, SMALL).prepare(2)


@pytest.mark.parametrize(("name", "field"), [("constant_force", "force"), ("viscous_asymmetry", "difference")])
def test_a_detection_limit_is_where_an_effect_passes_the_threshold(plan, name, field):
    [entry] = [one for one in plan.expected if one.name == name]
    assert (entry.parameter, entry.unit) == (field, VOCABULARY[name].FIELDS[field][0])
    passed = []
    for share in (0.25, 1.5):
        hidden = VOCABULARY[name].replace(**{field: share * entry.expected})
        for seed in range(2, 5):
            seen = evidence_of(cogging.simulate(SMALL.replace(effects=(hidden,)), plan.motion, seed=seed))
            column = seen.balances[0].added(SMALL, [hidden], seen.drives[0])
            passed.append(score_of(seen.score([seen.balances[0].rows(column)])[0], 1, 1, 10) > THRESHOLD)
    assert sum(passed[:3]) == 0
    assert sum(passed[3:]) >= 2


def test_every_effect_has_a_limit_or_a_reason(plan):
    entries = {one.name: one for one in plan.expected}
    assert set(VOCABULARY) - {"gravity", "empirical_force", *entries} == set()
    assert all((one.expected is None) == bool(one.why) for one in plan.expected)
    assert entries["constant_force"].text().endswith("V would be detected; today 0.5 V")
    assert entries["backlash"].text().endswith("m would be detected")


def test_intervals_are_as_wide_as_estimates_scatter():
    plan = cogging.plan_experiment(SMALL, LIMITS, goal="fit")
    paths = ("axis.mass", "axis.viscous", "axis.coulomb")
    entries = {one.name: one for one in plan.expected}
    found = []
    for seed in range(2, 9):
        seen = evidence_of(cogging.simulate(SMALL, plan.motion, seed=seed))
        found.append([parameters_of(seen.model)[path].value for path in paths])
    for path, scatter in zip(paths, np.std(found, axis=0), strict=True):
        assert 0.5 < entries[path].expected / (1.96 * scatter) < 2.0, path
        assert entries[path].today is None
    narrow = SMALL.replace(intervals={"axis.mass": (0.11999, 0.12001), "axis.viscous": (0.1, 0.2)})
    known = {one.name: one for one in cogging.plan_experiment(narrow, LIMITS, goal="fit").expected}
    assert known["axis.mass"].today == pytest.approx(1e-5, rel=1e-3)
    for path in ("axis.mass", "axis.viscous"):
        assert known[path].expected <= min(known[path].today, 1.01 * entries[path].expected)


@pytest.mark.parametrize(
    ("wrong", "said"),
    [
        ({"effects": {}}, "effects: must be the list of effects"),
        ({"effects": [{**RIVALS, "alternatives": 3}]}, r"effects\[0\]\.alternatives: must be an effect of the voc"),
        ({"effects": [{**RIVALS, "name": "spring"}]}, r"effects\[0\]\.name: must be an effect .*, got 'spring'"),
    ],
)
def test_an_invalid_result_is_refused(wrong, said):
    with pytest.raises(FieldError, match=said):
        cogging.plan_experiment(SMALL, LIMITS, result=wrong)


def test_an_ambiguous_result_gets_advice_and_no_promise(plan):
    assert plan.goal == "separate"
    assert "a reading error grows with speed squared" in plan.advice
    assert "whether this motion separates them is not predicted" in plan.text()


def test_the_written_files_are_the_plan(plan, tmp_path):
    plan.write(tmp_path / "next.toml")
    assert sorted(path.name for path in tmp_path.iterdir()) == ["next.csv", "next.plan.json", "next.toml"]
    motion, duration = cogging.read_reference(tmp_path / "next.toml")
    assert duration == pytest.approx(plan.motion.end)
    times = np.linspace(0.0, plan.motion.end, 997)
    for read, meant in zip(motion.sample(times), plan.motion.sample(times), strict=True):
        assert np.abs(read - meant).max() < 1e-8 * float(np.abs(meant).max())
    document = json.loads((tmp_path / "next.plan.json").read_text())
    assert document["expected"] == [one._asdict() for one in plan.expected]
    assert document["separating_experiment"] == plan.advice


def test_a_goal_without_what_it_needs_and_limits_that_no_motion_keeps_are_refused():
    with pytest.raises(ValueError, match="goal: separate needs a result with alternatives"):
        cogging.plan_experiment(SMALL, LIMITS, goal="separate")
    with pytest.raises(ValueError, match="goal: must be one of separate, detect, fit, got 'all'"):
        cogging.plan_experiment(SMALL, LIMITS, goal="all")
    with pytest.raises(ValueError, match="keeps the limits, not even at a fifth of the speed: command at "):
        cogging.plan_experiment(SMALL, cogging.MotionLimits(0.5, 5.0, 2.0, command=0.1), goal="fit")


def test_assumptions_are_noted():
    bare = SMALL.replace(controller=None, controller_type=None, noise=cogging.NoiseParameters())
    bare = bare.replace(encoder=cogging.EncoderParameters())
    plan = cogging.plan_experiment(bare, cogging.MotionLimits(0.3, 5.0, 2.0), goal="fit")
    assert "note: the model states no controller" in plan.text()
    assert any("neither noise nor the encoder's resolution" in note for note in plan.notes)
