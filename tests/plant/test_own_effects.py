"""Custom effects in a plant: their motion, their description, and refused definitions."""

import copy
import ctypes
import math
import pickle
import re

import numpy as np
import pytest

import cogging
from cogging.effects import Custom, Parameter
from tests.fixtures.own_laws import COPIES, own_eddy, own_friction, own_spring

AXIS = cogging.AxisParameters(mass=0.12, viscous=0.166, coulomb=0.15, coulomb_width=1e-3, travel=[0.0, 0.51])
PID = cogging.PidParameters(sample_rate=2000.0, kp=9600.0, ki=1e5, kd=48.0)
MOVES = cogging.PointToPoint(
    cogging.PointToPointParameters(
        start=0.1, distance=0.2, velocity=0.4, acceleration=5.0, jerk=500.0, dwell=0.05, repeats=1
    )
)


def run(*effects, axis=AXIS, **options):
    return cogging.closed_loop(cogging.Plant(axis, effects=list(effects)), cogging.Pid(PID), MOVES, **options)


def compiled():
    import numba

    return numba.cfunc("float64(float64, float64, float64, float64, float64)")(
        lambda position, velocity, time, slope, corner: -slope * velocity / (1.0 + (velocity / corner) ** 2)
    )


@pytest.mark.parametrize("width", [1e-3, 0.0])
@pytest.mark.parametrize("name", sorted(COPIES))
def test_a_copy_of_an_effect_moves_as_it(name, width):
    """To 1e-9 of the motion: the copy needs more steps, where those of the effect err by less than 1e-6."""
    make, fields = COPIES[name]
    axis = AXIS.replace(coulomb_width=width)
    own, built_in = run(make().replace(**fields), axis=axis), run(cogging.EFFECTS[name](**fields), axis=axis)
    bare = run(axis=axis)
    for column, same in (("true_position", 1e-9), ("position", 1e-9), ("true_velocity", 1e-6)):
        size = np.abs(getattr(built_in, column)).max()
        np.testing.assert_allclose(getattr(own, column), getattr(built_in, column), rtol=0, atol=same * size)
    assert np.abs(bare.true_position - built_in.true_position).max() > 1e-7


def test_compiled_and_python_laws_give_the_same_bits():
    mine = own_eddy()
    parameters = {"slope": Parameter(0.0, "V/(m/s)"), "corner": Parameter(0.2, "m/s", role="shape", low=0.02, high=2.0)}
    law = compiled()
    values = {"slope": 1.5, "corner": 0.17}
    logs = [run(mine.replace(**values))]
    logs += [run(Custom("eddy", force=one, parameters=parameters).replace(**values)) for one in (law, law.ctypes)]
    for column in ("true_position", "true_velocity", "command"):
        np.testing.assert_array_equal(getattr(logs[0], column), getattr(logs[1], column))
        np.testing.assert_array_equal(getattr(logs[0], column), getattr(logs[2], column))
    assert np.abs(logs[0].command - run().command).max() > 0.1


def energy_error(effect, work, mass):
    """Return the largest change of kinetic energy less work, as a share of it, without friction under 0.3 V."""
    t = np.arange(400) / 1000.0
    still = np.zeros_like(t)
    push, pid = cogging.Sampled(t, still, still, still + 0.3), cogging.PidParameters(sample_rate=1000.0, mass=1.0)
    start = {"initial_position": 0.1, "initial_velocity": 0.35}
    plant = cogging.Plant(cogging.AxisParameters(mass=mass), effects=[effect])
    log = cogging.closed_loop(plant, cogging.Pid(pid), push, **start)
    kinetic = 0.5 * mass * log.true_velocity**2
    assert log.true_position.max() > 0.2
    return (
        np.abs(kinetic - kinetic[0] - 0.3 * (log.true_position - 0.1) - work(log.true_position)).max() / kinetic.max()
    )


@pytest.mark.parametrize("seed", range(2))
def test_a_law_with_a_jump_and_a_kink_is_integrated_as_exactly_as_any(seed):
    place, jump, kink, mass = np.random.default_rng(seed).uniform([0.11, -0.25, -1.0, 0.05], [0.2, 0.25, 1.0, 0.5])

    def force(position):
        return np.where(position < place, 0.0, jump + kink * (position - place))

    def work(position):
        beyond = np.maximum(position - place, 0.0)
        return jump * beyond + 0.5 * kink * beyond**2

    assert energy_error(Custom("wall", force=force), work, mass) < 1e-6


def test_a_narrow_pulse_must_be_stated_and_is_then_felt():
    """Five micrometres wide where half a sample covers 175: found only with its length scale."""

    def force(position):
        return np.where(abs(position - 0.150003) < 2.5e-6, -150.0, 0.0)

    def work(position):
        return -150.0 * np.clip(position - 0.150003 + 2.5e-6, 0.0, 5e-6)

    assert energy_error(Custom("notch", force=force, length_scale=5e-6), work, 0.3) < 1e-6
    assert energy_error(Custom("notch", force=force), work, 0.3) > 1e-4


@pytest.mark.parametrize("name", sorted(COPIES))
def test_a_copy_is_described_as_the_effect(name):
    own, kind = COPIES[name][0](), cogging.EFFECTS[name]
    assert (own.HOOKS, own.KINDS) == (kind.HOOKS, kind.KINDS)
    for key, role in own.ROLES.items():
        same = kind.ROLES[key]
        assert (role["role"], role["quantity"]) == (same["role"], same["quantity"])
        assert role["high"] == pytest.approx(same["high"])


def test_a_custom_effect_is_a_value():
    one = own_spring().replace(stiffness=3.0)
    assert copy.deepcopy(one) == one == pickle.loads(pickle.dumps(one)) == own_spring().replace(stiffness=3.0)
    assert one not in (own_spring(), cogging.effects.CableSpring(stiffness=3.0))
    assert repr(one) == "Custom('own_spring', stiffness=3.0, center=0.0)"
    assert one.neutral().to_dict() == {"stiffness": 0.0, "center": 0.0}
    with pytest.raises(AttributeError, match="replace"):
        one.stiffness = 4.0


def test_a_model_file_and_a_log_hold_values_without_laws(tmp_path):
    own = own_spring()
    model = cogging.Model(axis=AXIS, effects=(own.replace(stiffness=3.0), cogging.effects.ConstantForce(force=0.1)))
    model.write(tmp_path / "model.toml")
    assert cogging.Model.read(tmp_path / "model.toml", effects=[own]) == model
    with pytest.raises(cogging.InputError, match=r"effects\.name: must be one of .* got 'own_spring'") as refused:
        cogging.Model.read(tmp_path / "model.toml")
    assert "Model.read(path, effects=[it])" in str(refused.value)
    log = cogging.simulate(model.replace(controller=PID, controller_type="pid"), MOVES)
    np.testing.assert_array_equal(cogging.repeat(log, effects=[own]).position, log.position)
    with pytest.raises(ValueError, match="must be one of"):
        cogging.repeat(log)


def law(force, name="mine", **more):
    return lambda: Custom(name, force=force, **more)


def plain(velocity):
    return velocity


REFUSED = [
    (law(plain, "cable_spring"), "name: must not be one of the vocabulary"),
    (law(plain, "My law"), "name: must be lower-case letters"),
    (law(lambda speed: speed), "mine.force: must take its arguments by name, .* got 'speed'"),
    (law(lambda velocity: 1j * velocity), "mine.force: raised TypeError .*real numbers"),
    (law(lambda velocity: velocity * math.nan), "mine.force: must be a finite number, got nan at position 0.02,"),
    (law(lambda velocity: [][0]), r"mine.force: raised IndexError \(list index out of range\)"),
    (law(lambda velocity: velocity - np.mean(velocity)), "mine.force: must give the same for arrays as for numbers"),
    (lambda: Custom("mine", command_gain=plain), "must take its arguments by name, of position, time"),
    (law(plain, parameters={"size": 1.0}), "mine.size: must be an argument of a law"),
    (law(ctypes.CFUNCTYPE(*[ctypes.c_double] * 4)(lambda x, v, t: v)), "mine.force: must be compiled code"),
    (lambda: law(compiled())(), r"must take doubles \(position, velocity, time\) and return one, got"),
    (lambda: Parameter(1.0, unit="T"), "low, high: must be given for an amplitude in 'T'"),
    (lambda: own_eddy().replace(corner=0.0), "eddy_drag.corner: must be above 0"),
    (lambda: own_friction().replace(levels=1.0), "own_friction.levels: must be a list of numbers"),
    (
        lambda: cogging.Model(axis=AXIS, effects=(law(plain)(), law(lambda velocity: -velocity)())),
        "effects: must be one law a name, got two different ones called 'mine'",
    ),
]


@pytest.mark.parametrize(("call", "message"), REFUSED, ids=[message[:40] for _, message in REFUSED])
def test_a_wrong_definition_or_value_is_one_line(call, message):
    with pytest.raises(ValueError, match=message) as refused:
        call()
    assert "\n" not in str(refused.value)


def test_a_law_that_fails_in_a_run_says_when_and_where():
    def late(time):
        return 0.0 * time if np.ndim(time) or time < 0.3 or time > 0.39 else [][0]  # where no trial comes by

    with pytest.raises(RuntimeError, match=r"mine\.force: raised IndexError .* at position .*time 0\.3 s") as raised:
        run(Custom("mine", force=late))
    assert isinstance(raised.value.__cause__, IndexError)
    endless = Custom("mine", friction_level=lambda position: np.where(abs(position - 0.2) > 1e-3, 0.0, np.nan))
    nowhere = r"mine\.friction_level: must be a finite number, got nan at"
    with pytest.raises(cogging.DivergedError, match=nowhere) as raised:
        run(endless)
    assert abs(float(re.search(r"position ([0-9.e-]+)", str(raised.value))[1]) - 0.2) <= 1e-3
