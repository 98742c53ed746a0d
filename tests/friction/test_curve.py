"""Friction laws against known truth, against scipy, and on a lead-screw drive."""

import numpy as np
import pytest

import cogging
from cogging import fit_friction_curve
from cogging.friction.friction_curve import Law

SPEEDS = np.geomspace(0.002, 0.2, 16)
BOTH = np.concatenate([-SPEEDS[::-1], SPEEDS])
TRUTH = {
    "coulomb": 0.3,
    "viscous": 0.8,
    "coulomb_asymmetry.difference": 0.06,
    "viscous_asymmetry.difference": -0.2,
    "stribeck_friction.static_excess": 0.12,
    "stribeck_friction.velocity": 0.02,
    "stribeck_friction.exponent": 1.5,
}


def law(v, changes=()):
    """The force at speeds v, (n,), of TRUTH with some values changed."""
    coulomb, viscous, more, steeper, excess, velocity, exponent = (TRUTH | dict(changes)).values()
    s = np.sign(v)
    level = coulomb + more / 2 * s + excess * np.exp(-(np.abs(v / velocity) ** exponent))
    return level * s + (viscous + steeper / 2 * s) * v


ONE_WAY = {"coulomb_asymmetry.difference": 0.0, "viscous_asymmetry.difference": 0.0}
NO_EXCESS = {"stribeck_friction.static_excess": 0.0}
#: What each law lacks of TRUTH.
NEUTRAL = {
    "coulomb_viscous": ONE_WAY | NO_EXCESS,
    "direction": NO_EXCESS,
    "stribeck": ONE_WAY,
    "direction_stribeck": {},
}


@pytest.mark.parametrize("name", list(NEUTRAL)[1:])  # the plainest: test_noise_alone_names_no_effect
def test_without_noise_the_truth_is_found_and_is_the_simulators(name):
    """Parameters bear the names of the effects: a plant with them, held at a steady speed, needs this force."""
    speeds = BOTH[::2]
    force = law(speeds, NEUTRAL[name])
    exponent = None if name == "direction_stribeck" else TRUTH["stribeck_friction.exponent"]  # searched once
    curve = fit_friction_curve(speeds, force + 1e-7 * np.cos(np.arange(16.0) ** 2), exponent=exponent)
    best = curve.best
    assert best.name == name
    for path, parameter in best.parameters.items():
        assert parameter.value == pytest.approx(TRUTH[path], rel=1e-3)
        assert parameter.low <= parameter.value <= parameter.high
    assert best.force(speeds) == pytest.approx(force, abs=1e-6)
    assert curve[name].held_out_rms < 1e-5
    assert best.gain > 0.99
    axis = cogging.AxisParameters(
        mass=0.1, viscous=best.parameters["viscous"].value, coulomb=best.parameters["coulomb"].value
    )
    plant = cogging.Plant(axis, effects=list(best.effects))
    controller = cogging.Pid(cogging.PidParameters(kp=1e4, kd=50.0))
    for speed in (-0.013, 0.013):
        motion = cogging.Sampled(time=[0.0, 1.0, 2.0], position=speed * np.arange(3.0), velocity=np.full(3, speed))
        log = cogging.closed_loop(plant, controller, motion, duration=1.0, initial_velocity=speed)
        assert log.command[-1] == pytest.approx(float(best.force(speed)), rel=1e-6)


def test_intervals_hold_the_truth_where_noise_grows_with_speed():
    rng, paths, runs = np.random.default_rng(4), list(TRUTH)[:4], 250
    covered, direction = np.zeros(4), Law(direction=True, bow=False, exponent=None)
    for _ in range(runs):
        force = law(BOTH, NO_EXCESS) + rng.normal(size=32) * 0.2 * np.abs(BOTH)
        found, _ = direction.intervals(direction.fit(BOTH, force), BOTH, force, 0.95, cogging.Units())
        covered += [found[p].low <= TRUTH[p] <= found[p].high for p in paths]
    assert (covered / runs > 0.90).all()
    assert (covered / runs < 0.995).all()


def test_held_out_is_leaving_each_speed_out():
    speeds = np.concatenate([-SPEEDS[::-2], SPEEDS[1::2]])
    force = law(speeds) + 0.02 * np.random.default_rng(5).normal(size=16)
    curve = fit_friction_curve(speeds, force, exponent=2.0)
    design, errors = np.stack([np.sign(speeds), speeds], axis=1), []
    for speed in SPEEDS[1::2]:
        out = np.isclose(np.abs(speeds), speed)
        errors.append(force[out] - design[out] @ np.linalg.lstsq(design[~out], force[~out], rcond=None)[0])
    assert curve["coulomb_viscous"].held_out_rms == pytest.approx(np.sqrt(np.mean(np.square(errors))), rel=1e-9)
    assert curve["coulomb_viscous"].gain == 0.0


def test_noise_alone_names_no_effect():
    named, speeds = [], BOTH[::2]
    for seed in range(2):
        force = law(speeds, NEUTRAL["coulomb_viscous"]) + 0.02 * np.random.default_rng(seed).normal(size=16)
        named.append(fit_friction_curve(speeds, force, exponent=2.0).best.name)
    assert named == ["coulomb_viscous"] * 2


def test_friction_that_rises_is_no_stribeck_effect():
    rising = law(BOTH, {"stribeck_friction.static_excess": -0.1, "stribeck_friction.exponent": 1.0})
    curve = fit_friction_curve(BOTH, rising, exponent=1.0)
    assert curve["stribeck"].parameters["stribeck_friction.static_excess"].value == 0.0
    assert any("does not fall" in note for note in curve.notes)


def test_one_direction_few_speeds_and_many_rows_of_one_speed():
    forward = fit_friction_curve(SPEEDS, law(SPEEDS), exponent=1.5)
    assert [model.name for model in forward.models] == ["coulomb_viscous", "stribeck"]
    assert any("one way only" in note for note in forward.notes)
    few = fit_friction_curve([-0.3, -0.2, -0.1, 0.1, 0.2, 0.3], [-0.6, -0.5, -0.4, 0.4, 0.5, 0.6])
    assert [model.name for model in few.models] == ["coulomb_viscous"]
    assert few.best.parameters["viscous"].value == pytest.approx(1.0)
    rng = np.random.default_rng(6)
    rows = np.repeat(BOTH, 50) * (1 + 0.004 * rng.normal(size=1600))
    many = fit_friction_curve(rows, law(rows) + 0.02 * rng.normal(size=1600), exponent=1.5)
    assert (len(many.velocity), many.speed.max()) == (32, 15)
    assert many.best.name == "direction_stribeck"


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ({"velocity": [0.1, np.nan]}, "velocity: must be finite numbers, got nan in row 1"),
        ({"force": [1.0]}, "force: must have one value for each of the 32 speeds, got 1"),
        ({"velocity": np.where(BOTH[3] == BOTH, 0.0, BOTH)}, r"velocity: must not be 0 .*got \[3\]"),
        ({"velocity": [0.1, 0.2], "force": [1.0, 2.0]}, "velocity: must hold at least 5 points"),
        ({"exponent": 0.0}, "exponent: must be finite and above 0, got 0.0"),
        ({"confidence": 1.0}, "confidence: must lie between 0 and 1, got 1.0"),
    ],
)
def test_refused(change, message):
    with pytest.raises(ValueError, match=f"^{message}") as caught:
        fit_friction_curve(**({"velocity": BOTH, "force": law(BOTH)} | change))
    assert "\n" not in str(caught.value)
