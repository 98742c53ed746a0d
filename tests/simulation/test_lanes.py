"""Runs in vector lanes: each has the bits that it has alone, whatever shares its pack and whatever the processor."""

import numpy as np
import pytest

import cogging
from cogging import _core
from cogging.model.model import CONTROLLERS
from tests.fixtures.log_columns import columns_of
from tests.fixtures.plants_by_hand import EXAMPLES, example, varied
from tests.golden.logs import CONTROLLERS as FIELDS
from tests.simulation.test_simulation import assert_same_bits

SETS = ["none", *_core.instruction_sets()]
MASS = 0.12
MOVE = cogging.Sine(cogging.SineParameters(center=0.05, amplitude=0.03, frequency=6.0))
TUNED = FIELDS | {"pid": FIELDS["pid"] | {"command_limit": 0.0}}
PACKED_GAINS = {"pid": "kp", "cascade": "kv", "speed": "kp", "arc": "feedback_gain", "dcarc": "error_gain"}
HAS_STATE = {"presliding_friction", "backlash", "flexible_mode"}
KEPT = {"columns": ["time", "command", "true_velocity"], "every": 7}
KEPT["reductions"] = ["command_max", "true_error_rms", "error_quantile(0.9)", "error_tone(6.0)", "command_wave(0.02)"]


def drawn_effects(rng):
    """One to four kinds of effects, each once; of the two loads on a motor one."""
    names = set(rng.choice(sorted(EXAMPLES), size=int(rng.integers(1, 5)), replace=False))
    names -= HAS_STATE if rng.random() < 0.7 else {"backlash"}
    return sorted(names)


def drawn_family(kind, seed):
    """Plants and controllers of one motion: some share a course, others differ in what a pack says but once."""
    rng = np.random.default_rng(seed)
    names, differ, sticks = drawn_effects(rng), rng.random() < 0.5, rng.random() < 0.15
    struct, make = CONTROLLERS[kind]
    basis = cogging.SplineHarmonics(pitch=0.02, harmonics=[1, 3], order=int(rng.integers(1, 5)), control_points=9)
    noise = cogging.NoiseParameters(force=0.01 * (rng.random() < 0.5), bandwidth=100.0)
    count = int(rng.integers(5, 20))
    plants, controllers = [], []
    for i in range(count):
        width = 0.0 if sticks and i % 3 == 0 else 0.003 * rng.uniform(0.3, 3)
        drawn = zip(("mass", "viscous", "coulomb"), rng.uniform([0.11, 0.2, 0.05], [0.13, 0.6, 0.15]), strict=True)
        axis = cogging.AxisParameters(**dict(drawn), coulomb_width=width, travel=[-0.2, 0.6])
        model = cogging.CoggingModel(basis, *(0.05 * rng.normal(size=(2, 2, 9))))
        effects = [example(name) for name in names]
        if differ:
            effects = [varied(one, rng) for one in effects]
        encoder = cogging.EncoderParameters(resolution=1e-6 * rng.uniform(0.5, 2), noise=1e-7 * rng.integers(2))
        plants.append(cogging.Plant(axis, cogging=model, effects=effects, encoder=encoder, noise=noise))
        settings = struct(**TUNED[kind])
        if kind in PACKED_GAINS:
            gain = getattr(settings, PACKED_GAINS[kind]) * rng.uniform(0.7, 1.2)
            settings = settings.replace(**{PACKED_GAINS[kind]: gain})
        if rng.random() < 0.1:
            settings = settings.replace(command_limit=50.0)
        controllers.append(make(settings))
    return plants, controllers, [int(seed) for seed in rng.integers(1000, size=count)], names, sticks


@pytest.fixture(autouse=True)
def instructions(monkeypatch):
    monkeypatch.delenv("COGGING_INSTRUCTIONS", raising=False)


def run_alone(plant, controller, **options):
    """The log of a run, or the text of what ended it."""
    try:
        return cogging.closed_loop(plant, controller, MOVE, **options)
    except cogging.DivergedError as error:
        return str(error)


def assert_same(batch, alone):
    """Each run's log has the bits of its log alone, or its row the reason that ended it alone."""
    reasons = {failure.run: failure.reason for failure in batch.failures}
    assert reasons == {i: log for i, log in enumerate(alone) if isinstance(log, str)}
    for i, expected in enumerate(alone):
        if i in reasons:
            continue
        assert_same_bits(batch[i], expected)


@pytest.mark.parametrize(("kind", "seed"), [(kind, seed) for seed in range(2) for kind in CONTROLLERS])
def test_a_run_in_a_pack_has_the_bits_of_the_run_alone(kind, seed, monkeypatch):
    plants, controllers, seeds, names, sticks = drawn_family(kind, [seed, *kind.encode()])
    options = {"duration": 0.06, "steps_per_sample": 1 + seed % 2}
    runs = list(zip(plants, controllers, seeds, strict=True))
    alone = [run_alone(plant, controller, seed=number, **options) for plant, controller, number in runs]
    kept = []
    for number, instructions in enumerate(SETS):
        monkeypatch.setenv("COGGING_INSTRUCTIONS", instructions)
        assert _core.instruction_set() == instructions
        chosen = options | {"seeds": seeds, "threads": 1 + (seed + number) % 3}
        batch = cogging.closed_loop_batch(plants, controllers, MOVE, logs=True, **chosen)
        assert_same(batch, alone)
        if instructions == "none" or HAS_STATE & set(names):
            assert not any(batch.in_lanes)
        elif sticks:
            assert not any(batch.in_lanes[::3])
        kept.append(cogging.closed_loop_batch(plants, controllers, MOVE, **KEPT, **chosen))
        assert all(kept[0].indexes[name].tobytes() == values.tobytes() for name, values in kept[-1].indexes.items())
        every_7th = [None if isinstance(log, str) else columns_of(log)["command"][::7].tobytes() for log in alone]
        found = zip(every_7th, kept[-1].columns["command"], strict=True)
        assert [None if log is None else run.tobytes() for log, run in found] == every_7th


def test_runs_of_one_course_share_packs_and_others_do_not(monkeypatch):
    """Nine of one course, one with a limit of its own, one with a past, one that sticks."""
    if SETS == ["none"]:
        pytest.skip("no instruction set was compiled for this machine")
    settings = cogging.PidParameters(**TUNED["pid"])
    axis = cogging.AxisParameters(mass=MASS, viscous=0.4, coulomb=0.1, coulomb_width=0.003, travel=[-0.2, 0.6])
    warm = cogging.Pid(settings)
    warm.command(reference=0.05, reference_velocity=0.0, reference_acceleration=0.0, reading=0.0501)
    axes = [axis.replace(mass=MASS * (1 + 0.02 * i)) for i in range(12)]
    axes[11] = axis.replace(coulomb_width=0.0)
    controllers = [cogging.Pid(settings) for _ in range(12)]
    controllers[9] = cogging.Pid(settings.replace(command_limit=9.0))
    controllers[10] = warm
    plants = [cogging.Plant(one) for one in axes]
    batch = cogging.closed_loop_batch(plants, controllers, MOVE, duration=0.02, threads=1, logs=True)
    assert 9 % _core.instruction_sets()[_core.instruction_set()] == 1  # the ninth is left over
    assert list(batch.in_lanes) == [i < 8 for i in range(12)]
    assert_same(
        batch, [cogging.closed_loop(p, c, MOVE, duration=0.02) for p, c in zip(plants, controllers, strict=True)]
    )
    monkeypatch.setenv("COGGING_INSTRUCTIONS", "none")
    assert not any(cogging.closed_loop_batch(plants, controllers, MOVE, duration=0.02).in_lanes)


@pytest.mark.parametrize("instructions", SETS)
@pytest.mark.parametrize(
    ("kp", "width", "where", "message"),
    [
        (1e7, 0.003, 8, "diverged at"),
        (1e12, 0.0, 3, "^axis: must change slowly enough"),  # more periods of a wave in a sample than steps are allowed
        (1e12, 0.003, 8, "^axis: must change slowly enough"),
    ],
)
def test_a_diverging_run_has_the_reason_that_it_has_alone(kp, width, where, message, instructions, monkeypatch):
    monkeypatch.setenv("COGGING_INSTRUCTIONS", instructions)
    effects = [cogging.effects.CoggingHarmonic(period=0.02, sine=0.3)] if kp > 1e9 else []
    travel = {} if effects else {"travel": [-0.2, 0.6]}
    axis = cogging.AxisParameters(mass=MASS, coulomb=0.1, coulomb_width=width, **travel)
    plant, gains = cogging.Plant(axis, effects=effects), [9600.0] * 9
    gains[where] = kp
    controllers = [cogging.Pid(cogging.PidParameters(**TUNED["pid"]).replace(kp=gain)) for gain in gains]
    with pytest.raises(cogging.DivergedError, match=message) as error:
        cogging.closed_loop(plant, controllers[where], MOVE, duration=0.3)
    batch = cogging.closed_loop_batch([plant] * 9, controllers, MOVE, duration=0.3)
    assert [(failure.run, failure.reason) for failure in batch.failures] == [(where, str(error.value))]
    assert f" at {batch.failures[0].time:g} s" in str(error.value)
    assert np.isnan(batch.indexes["error_max"]).tolist() == [run == where for run in range(9)]


def test_an_unknown_instruction_set_is_one_line(monkeypatch):
    monkeypatch.setenv("COGGING_INSTRUCTIONS", "v9")
    with pytest.raises(ValueError, match=r'^COGGING_INSTRUCTIONS: must be one that this [^\n]*none, got "v9"$'):
        cogging.closed_loop_batch([], [], MOVE, duration=0.1)
