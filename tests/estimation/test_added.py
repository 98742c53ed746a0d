"""What one more effect adds to the innovations: along the prediction, against predicting the whole plant anew."""

import numpy as np
import pytest

import cogging
from cogging import EFFECTS, AxisParameters, Model
from cogging._core import Predictor
from cogging.estimation.innovations import LINEAR_HOOKS, Innovations
from cogging.estimation.residuals import quiet_plant
from tests.fixtures.covering import covering

RATE = 2000.0  # Hz
LINEAR = [name for name, effect in EFFECTS.items() if set(effect.HOOKS) <= LINEAR_HOOKS]


def machine(viscous=3.0, coulomb=1.0, width=0.002, effects=()):
    return Model(
        axis=AxisParameters(mass=0.8, viscous=viscous, coulomb=coulomb, coulomb_width=width, travel=[-0.2, 0.2]),
        cogging=cogging.CoggingModel(cogging.SplineHarmonics(pitch=0.03, harmonics=[1]), [[0.4]], [[0.2]]),
        effects=effects,
        controller=cogging.PidParameters(sample_rate=RATE, kp=4000.0, kd=60.0),
        controller_type="pid",
    )


@pytest.fixture(scope="module")
def log():
    """Two seconds to and fro, with a command that shakes it."""
    time = np.arange(4001) / RATE
    reference = 0.1 * np.sin(6.0 * time)
    shake = 0.3 * np.random.default_rng(1).normal(size=len(time))
    return cogging.simulate(machine(), cogging.Sampled(time, reference, None, None), duration=2.0, added_command=shake)


SIZES = {"distance": 0.03, "position": 0.1, "time": 1.0, "velocity": 0.2, "frequency": 30.0, "relative": 0.1}


def sample(name, random):
    """An effect with random amplitudes, and shapes somewhere in this log."""
    effect = EFFECTS[name]
    neutral, fields = effect(), {}
    for field, role in effect.ROLES.items():
        value = getattr(neutral, field)
        if role["role"] == "amplitude":
            size = 0.1 if role["quantity"] == "relative" else 1.0
            low = 0.0 if role["low"] == 0.0 else -size
            fields[field] = list(random.uniform(low, size, 4)) if isinstance(value, list) else random.uniform(low, size)
        elif value == []:
            fields[field] = list(np.linspace(-0.1, 0.1, 4))
        elif role["role"] == "shape":
            fields[field] = SIZES.get(role["quantity"], 1.0) * random.uniform(0.5, 1.0)
    if {"start", "stop"} <= set(fields):
        fields |= {"start": 0.4, "stop": 1.3}
    if {"pitch", "order", "origin"} <= set(effect.ROLES):
        fields |= {"pitch": 0.1, "order": 3, "origin": -0.1}
    return effect(**fields)


def joined(model, *effects):
    return model.replace(effects=(*model.effects, *effects))


@pytest.mark.parametrize(("name", "seed"), covering(LINEAR, range(2)))
def test_forces_are_those_of_the_whole_plant_to_rounding(log, name, seed):
    random = np.random.default_rng([seed, len(name)])
    others = [sample(other, random) for other in random.choice(LINEAR, 3, replace=False)]
    others.append(EFFECTS["coulomb_asymmetry"](difference=random.uniform(-3.0, 3.0)))  # a level that the clip may cut
    others.append(EFFECTS["actuator_lag"](time_constant=1e-3))
    model = machine(coulomb=random.uniform(0.0, 1.0), width=random.choice([0.0, 0.01]), effects=tuple(others))
    source, effect, plant = Innovations(log, model), sample(name, random), quiet_plant(model)
    along = source.predictor.predict(plant)
    quick = source.scale * source.predictor.added(along, plant, [effect], [0.3])
    general = source.rows_of_plants(along, plant, [quiet_plant(joined(model, effect))], [0.3])
    assert np.abs(general).max() > 1e-3
    assert quick == pytest.approx(general, abs=1e-9 * np.abs(general).max(), rel=1e-9)


def compare(log, model, effect):
    """Correlation of the quick column with the difference of whole predictions, ratio of their sizes, relative rms."""
    source, plant = Innovations(log, model), quiet_plant(model)
    along = source.predictor.predict(plant)
    assert source.predictor.is_addable(plant, effect)
    quick = source.scale * source.predictor.added(along, plant, [effect], [1.0])[0]
    before, after = source.of([model, joined(model, effect)])
    mask = source.mask > 0.0
    quick, whole = quick[mask], (after - before)[mask]
    size, expected = np.linalg.norm(quick), np.linalg.norm(whole)
    return quick @ whole / (size * expected), size / expected, np.linalg.norm(quick - whole) / expected


BASES = [
    (),
    (EFFECTS["force_constant_ripple"](period=0.05, sine=0.3),),
    (EFFECTS["command_delay"](delay=0.7 / RATE), EFFECTS["actuator_lag"](time_constant=1.0 / RATE)),
]
CHANGES = [EFFECTS["command_delay"](delay=samples / RATE) for samples in (0.3, 4.6)]
CHANGES += [EFFECTS["actuator_lag"](time_constant=samples / RATE) for samples in (0.3, 5.0)]
CHANGES += [EFFECTS["command_saturation"](limit=limit) for limit in (1.0, 2.0)]
CHANGES += [EFFECTS["command_dead_zone"](width=width) for width in (0.2, 1.0)]


@pytest.mark.parametrize(("base", "change"), covering(range(len(BASES)), range(len(CHANGES))))
def test_a_changed_command_adds_what_whole_predictions_say(log, base, change):
    effect = CHANGES[change]  # there may be one current loop
    others = tuple(one for one in BASES[base] if effect.NAME != one.NAME or effect.NAME != "actuator_lag")
    correlation, ratio, error = compare(log, machine(effects=others), effect)
    assert correlation > 0.9999
    assert ratio == pytest.approx(1.0, abs=0.002)
    assert error < 0.008


@pytest.mark.parametrize(
    ("width", "frequency", "mass_ratio", "damping_ratio"),
    covering([0.002, 0.0], [20.0, 60.0, 150.0, 400.0, 800.0], [0.05, 0.2, 0.5], [0.01, 0.03, 0.1]),
)
def test_a_load_on_a_spring_adds_what_whole_predictions_say(log, width, frequency, mass_ratio, damping_ratio):
    model = machine(width=width)
    load = EFFECTS["flexible_mode"](frequency=frequency, mass_ratio=mass_ratio, damping_ratio=damping_ratio)
    # What rings through many reversals is decided by friction there, and must be predicted as a whole.
    decay = 2.0 * np.pi * frequency * damping_ratio + 0.5 * 3.0 / 0.8 * mass_ratio / (1.0 - mass_ratio)
    if decay < 6.0 and mass_ratio > 0.1:
        assert not Predictor.is_addable(model.plant(), load)
        return
    correlation, ratio, error = compare(log, model, load)
    assert correlation > (0.999 if width > 0.0 else 0.99)
    assert ratio == pytest.approx(1.0, abs=0.005 if width > 0.0 else 0.02)
    assert error < (0.03 if width > 0.0 else 0.08)


def strikes(log, model, loads):
    """Mean innovations of motor and load in a trajectory for each of the loads, which differ in their gaps.

    By hand: Runge-Kutta of both masses, and the observer.
    """
    axis, ratio, gap = model.axis, loads[0].mass_ratio, np.array([load.gap for load in loads])
    motor, mass = axis.mass * (1.0 - ratio), axis.mass * ratio
    reduced, w = motor * ratio, 2.0 * np.pi * loads[0].contact_frequency
    stiffness, damping = w**2 * reduced, 2.0 * loads[0].contact_damping_ratio * w * reduced

    def slope(state, command):
        _, v, q, r = state
        spring = stiffness * np.maximum(np.abs(q) - 0.5 * gap, 0.0) * np.sign(q)
        pull = spring + np.clip(damping * r, -np.abs(spring), np.abs(spring))
        friction = axis.viscous * v + axis.coulomb * 2.0 / np.pi * np.arctan(v / axis.coulomb_width)
        a = (command - friction + pull) / motor
        return np.array([v, a, r, -pull / mass - a])

    h, bandwidth, pieces = 1.0 / RATE, 20.0, 16
    pole = np.exp(-2.0 * np.pi * bandwidth * h)
    gains = np.array([[1.0 - pole**2], [(1.0 - pole) ** 2 / h]])
    state = np.zeros((4, len(loads)))
    state[0] = log.position[0]
    innovations, d = [np.zeros(len(loads))], h / pieces
    for u, reading in zip(log.command[:-1], log.position[1:], strict=True):
        for _ in range(pieces):
            one = slope(state, u)
            two = slope(state + 0.5 * d * one, u)
            three = slope(state + 0.5 * d * two, u)
            four = slope(state + d * three, u)
            state = state + d / 6.0 * (one + 2.0 * two + 2.0 * three + four)
        innovations.append(reading - state[0])
        state[:2] += gains * innovations[-1]
    return np.mean(innovations, axis=1)


@pytest.mark.parametrize(("mass_ratio", "gap"), [(0.05, 2e-4), (0.4, 1e-4)])
def test_a_loose_load_does_on_average_what_single_trajectories_do(log, mass_ratio, gap):
    model = machine().replace(cogging=None)
    short = log[:600]
    predictor = Predictor(short.time, short.position, short.command, bandwidth=20.0)
    shares = (0.7, 0.85, 1.0, 1.15, 1.3)
    loads = [EFFECTS["backlash"](gap=share * gap, mass_ratio=mass_ratio) for share in shares]
    expected = strikes(short, model, loads)
    rigid, loose = predictor.innovations(
        [quiet_plant(model), quiet_plant(joined(model, EFFECTS["backlash"](gap=gap, mass_ratio=mass_ratio)))]
    )
    assert np.linalg.norm(expected - rigid) > 1e-6
    # A light load is added to first order.
    assert np.linalg.norm(loose - expected) < 0.04 * np.linalg.norm(expected - rigid)
    whole = predictor.predict(quiet_plant(joined(model, EFFECTS["backlash"](gap=gap, mass_ratio=mass_ratio))))
    np.testing.assert_array_equal(whole.innovation, loose)
    (none,) = predictor.innovations([quiet_plant(joined(model, EFFECTS["backlash"](gap=gap)))])
    np.testing.assert_array_equal(none, rigid)


def test_after_a_gap_and_at_uneven_steps_a_load_starts_anew(log):
    random = np.random.default_rng(5)
    kept = np.sort(random.choice(np.arange(len(log)), 3000, replace=False))
    kept = kept[(kept < 1500) | (kept > 2100)]
    model, plant = machine(coulomb=0.0), quiet_plant(machine(coulomb=0.0))
    predictor = Predictor(log.time[kept], log.position[kept], log.command[kept], gap=0.1)
    along = predictor.predict(plant)
    for effect in (EFFECTS["flexible_mode"](frequency=90.0, mass_ratio=0.3), EFFECTS["command_delay"](delay=0.9e-3)):
        quick = predictor.added(along, plant, [effect], [1.0])[0]
        before, after = predictor.innovations([plant, quiet_plant(joined(model, effect))])
        assert np.linalg.norm(quick - (after - before)) < 0.01 * np.linalg.norm(after - before)


def test_what_must_be_predicted_as_a_whole_is_refused(log):
    predictor = Predictor(log.time, log.position, log.command)
    plant = quiet_plant(machine())
    along = predictor.predict(plant)
    constant, lag = EFFECTS["constant_force"](force=1.0), EFFECTS["actuator_lag"](time_constant=1e-3)
    for name in ("presliding_friction", "encoder_scale_error", "encoder_periodic_error"):
        assert not predictor.is_addable(plant, EFFECTS[name]())
        with pytest.raises(ValueError, match=f"{name}: must be predicted as a whole"):
            predictor.added(along, plant, [EFFECTS[name]()], [1.0])
    loose = EFFECTS["backlash"](gap=1e-4, mass_ratio=0.3)
    assert not predictor.is_addable(plant, loose)
    assert predictor.is_addable(quiet_plant(machine(coulomb=0.0)), loose)
    loaded = quiet_plant(machine(effects=(EFFECTS["flexible_mode"](frequency=100.0, mass_ratio=0.1),)))
    assert not predictor.is_addable(loaded, EFFECTS["command_delay"](delay=1e-3))
    assert predictor.is_addable(loaded, constant)
    for other, effects, sizes, message in (
        (plant, [constant], [], "sizes: must be as many as effects"),
        (plant, [constant], [0.0], "sizes: must be"),
        (quiet_plant(machine(effects=(lag,))), [lag], [1.0], "actuator_lag: may stand once"),
    ):
        with pytest.raises(ValueError, match=message):
            predictor.added(along, other, effects, sizes)
