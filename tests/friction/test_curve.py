"""Friction laws against known truth, against scipy, and on a lead-screw drive."""

import numpy as np
import pytest
from scipy.optimize import least_squares

import cogging
from cogging import fit_friction_curve
from cogging.datasets import tro2021
from cogging.friction.friction_curve import Law
from tests.fixtures.measured import FOLDER

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


def law(v, **changes):
    p = TRUTH | {path.replace("__", "."): value for path, value in changes.items()}
    s = np.sign(v)
    fall = p["stribeck_friction.static_excess"] * np.exp(
        -(np.abs(v / p["stribeck_friction.velocity"]) ** p["stribeck_friction.exponent"])
    )
    level = p["coulomb"] + p["coulomb_asymmetry.difference"] / 2 * s + fall
    return level * s + (p["viscous"] + p["viscous_asymmetry.difference"] / 2 * s) * v


NEUTRAL = {
    "coulomb_viscous": {
        "coulomb_asymmetry__difference": 0.0,
        "viscous_asymmetry__difference": 0.0,
        "stribeck_friction__static_excess": 0.0,
    },
    "direction": {"stribeck_friction__static_excess": 0.0},
    "stribeck": {"coulomb_asymmetry__difference": 0.0, "viscous_asymmetry__difference": 0.0},
    "direction_stribeck": {},
}


@pytest.mark.parametrize("name", NEUTRAL)
def test_without_noise_the_truth_is_found_and_named(name):
    curve = fit_friction_curve(BOTH, law(BOTH, **NEUTRAL[name]) + 1e-7 * np.cos(np.arange(32.0) ** 2))
    assert curve.best.name == name
    for path, parameter in curve.best.parameters.items():
        assert parameter.value == pytest.approx(TRUTH[path], rel=1e-3)
        assert parameter.low <= parameter.value <= parameter.high
    assert curve.best.force(BOTH) == pytest.approx(law(BOTH, **NEUTRAL[name]), abs=1e-6)
    assert curve[name].held_out_rms < 1e-5
    if name != "coulomb_viscous":
        assert curve.best.gain > 0.99


@pytest.mark.parametrize("name", NEUTRAL)
def test_the_law_is_the_simulators(name):
    """Parameters bear the names of the effects: a plant with them, held at a steady speed, needs this force."""
    model = fit_friction_curve(BOTH, law(BOTH, **NEUTRAL[name])).models[list(NEUTRAL).index(name)]
    assert model.name == name
    speed, gain = 0.013, 1e4
    for direction in (-1.0, 1.0):
        axis = cogging.AxisParameters(
            mass=0.1, viscous=model.parameters["viscous"].value, coulomb=model.parameters["coulomb"].value
        )
        motion = cogging.Sampled(
            time=[0.0, 1.0, 2.0], position=direction * speed * np.arange(3.0), velocity=np.full(3, direction * speed)
        )
        controller = cogging.Pid(cogging.PidParameters(kp=gain, kd=50.0))
        plant = cogging.Plant(axis, effects=list(model.effects))
        log = cogging.closed_loop(plant, controller, motion, duration=1.0, initial_velocity=direction * speed)
        assert log.command[-1] == pytest.approx(float(model.force(direction * speed)), rel=1e-6)


def test_the_fit_is_the_least_squares_of_scipy():
    rng = np.random.default_rng(3)
    force = law(BOTH) + 0.01 * rng.normal(size=32)
    found = fit_friction_curve(BOTH, force)["direction_stribeck"]
    paths = list(TRUTH)

    def residual(p):
        changes = {path.replace(".", "__"): value for path, value in zip(paths, p, strict=True)}
        return law(BOTH, **changes) - force

    scipys = least_squares(residual, list(TRUTH.values()), x_scale=np.abs(list(TRUTH.values())), xtol=1e-14, ftol=1e-14)
    ours = np.sum((found.force(BOTH) - force) ** 2)
    assert ours <= 2 * scipys.cost * (1 + 1e-6)
    if ours > 2 * scipys.cost * (1 - 1e-6):
        assert [found.parameters[p].value for p in paths] == pytest.approx(scipys.x, rel=1e-3)


def test_intervals_cover_where_noise_grows_with_speed():
    rng = np.random.default_rng(4)
    paths = list(TRUTH)[:4]
    covered = np.zeros(4)
    runs, direction = 400, Law(direction=True, bow=False, exponent=None)
    for _ in range(runs):
        force = law(BOTH, **NEUTRAL["direction"]) + rng.normal(size=32) * 0.2 * np.abs(BOTH)
        found, _ = direction.intervals(direction.fit(BOTH, force), BOTH, force, 0.95, cogging.Units())
        covered += [found[p].low <= TRUTH[p] <= found[p].high for p in paths]
    assert (covered / runs > 0.90).all()
    assert (covered / runs < 0.995).all()


def test_held_out_is_leaving_each_speed_out():
    rng = np.random.default_rng(5)
    force = law(BOTH) + 0.02 * rng.normal(size=32)
    curve = fit_friction_curve(BOTH, force, exponent=2.0)
    errors = []
    for speed in SPEEDS:
        out = np.isclose(np.abs(BOTH), speed)
        design = np.stack([np.sign(BOTH), BOTH], axis=1)
        p = np.linalg.lstsq(design[~out], force[~out], rcond=None)[0]
        errors.append(force[out] - design[out] @ p)
    assert curve["coulomb_viscous"].held_out_rms == pytest.approx(np.sqrt(np.mean(np.square(errors))), rel=1e-9)
    assert curve["coulomb_viscous"].gain == 0.0


def test_noise_alone_buys_no_effect():
    named = []
    for seed in range(8):
        rng = np.random.default_rng(seed)
        force = law(BOTH, **NEUTRAL["coulomb_viscous"]) + 0.02 * rng.normal(size=32)
        named.append(fit_friction_curve(BOTH, force, exponent=2.0).best.name)
    assert named.count("coulomb_viscous") >= 7


def test_friction_that_rises_is_no_stribeck_effect():
    rising = law(BOTH, stribeck_friction__static_excess=-0.1, stribeck_friction__exponent=1.0)
    curve = fit_friction_curve(BOTH, rising, exponent=1.0)
    assert curve["stribeck"].parameters["stribeck_friction.static_excess"].value == 0.0
    assert any("does not fall" in note for note in curve.notes)


def test_one_direction_and_few_speeds():
    forward = fit_friction_curve(SPEEDS, law(SPEEDS))
    assert [model.name for model in forward.models] == ["coulomb_viscous", "stribeck"]
    assert any("one way only" in note for note in forward.notes)
    few = fit_friction_curve([-0.3, -0.2, -0.1, 0.1, 0.2, 0.3], [-0.6, -0.5, -0.4, 0.4, 0.5, 0.6])
    assert [model.name for model in few.models] == ["coulomb_viscous"]
    assert few.best.parameters["viscous"].value == pytest.approx(1.0)


def test_rows_of_one_speed_are_one_point():
    rng = np.random.default_rng(6)
    rows = np.repeat(BOTH, 50) * (1 + 0.004 * rng.normal(size=1600))
    curve = fit_friction_curve(rows, law(rows) + 0.02 * rng.normal(size=1600))
    assert len(curve.velocity) == 32
    assert curve.speed.max() == 15
    assert curve.best.name == "direction_stribeck"


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ({"velocity": [0.1, np.nan]}, "velocity: must be finite numbers, got nan in row 1"),
        ({"velocity": [[0.1]]}, r"velocity: must be one-dimensional and not empty, got shape \(1, 1\)"),
        ({"velocity": ["a"]}, "velocity: must be real numbers"),
        ({"force": [1.0]}, "force: must have one value for each of the 32 speeds, got 1"),
        ({"velocity": np.where(BOTH[3] == BOTH, 0.0, BOTH)}, r"velocity: must not be 0 .*got \[3\]"),
        ({"velocity": [0.1, 0.2], "force": [1.0, 2.0]}, "velocity: must hold at least 5 points"),
        ({"exponent": 0.0}, "exponent: must be finite and above 0, got 0.0"),
        ({"same_speed": 1.0}, "same_speed: must lie from 0 to below 1, got 1.0"),
        ({"confidence": 1.0}, "confidence: must lie between 0 and 1, got 1.0"),
    ],
)
def test_refused(change, message):
    with pytest.raises(ValueError, match=f"^{message}") as caught:
        fit_friction_curve(**({"velocity": BOTH, "force": law(BOTH)} | change))
    assert "\n" not in str(caught.value)


@pytest.mark.data
def test_a_lead_screw_drive():
    """Direction and Stribeck each gain on speeds that were not seen; only together do they explain the curve."""
    speed, torque = tro2021.steady_speeds(FOLDER)
    assert len(speed) == 32
    curve = fit_friction_curve(speed, torque)
    print("\n" + curve.text())
    held_out = {model.name: model.held_out_rms for model in curve.models}
    assert curve.best.name == "direction_stribeck"
    assert held_out["direction"] < 0.45 * held_out["coulomb_viscous"]
    assert held_out["direction_stribeck"] < 0.4 * held_out["direction"]
    assert 0.9 < held_out["stribeck"] / held_out["coulomb_viscous"] < 1.0  # hidden as long as the directions are one
    found = curve.best.parameters
    assert found["coulomb_asymmetry.difference"].low > 5.0  # %
    assert found["stribeck_friction.static_excess"].value > 5.0
    assert 20.0 < found["stribeck_friction.velocity"].value < 80.0  # rpm
    assert curve.best.held_out_rms < 0.6  # % of nominal torque
