"""Custom effects in a plant: their motion, their description, and refused definitions."""

import copy
import ctypes
import math
import pickle
import re

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.integrate import solve_ivp

import cogging
from cogging.effects import Custom, Parameter, Wave
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


# Motion ---------------------------------------------------------------------------------------------------------------


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


def test_a_c_library_is_a_law():
    try:
        tanh = ctypes.CDLL("libm.so.6").tanh
    except OSError:
        pytest.skip("no C library of that name")
    tanh.argtypes, tanh.restype = [ctypes.c_double], ctypes.c_double
    own = Custom("shift", reading_error=tanh)
    np.testing.assert_allclose(own.reading_at([0.1, -0.2]), [0.1 + math.tanh(0.1), -0.2 - math.tanh(0.2)], rtol=1e-15)


def test_many_runs_at_once_are_those_one_by_one():
    effects = [own_eddy().replace(slope=slope) for slope in (0.5, 1.0, 2.0)]
    plants = [cogging.Plant(AXIS, effects=[one]) for one in effects]
    logs = cogging.closed_loop_batch(plants, [cogging.Pid(PID)] * 3, MOVES, threads=3, logs=True)
    for one, log in zip(effects, logs, strict=True):
        np.testing.assert_array_equal(run(one).true_position, log.true_position)


def test_a_law_of_two_hooks_acts_by_both():
    def pushes(position, size):
        return -size * position

    def rubs(position, size):
        return size * position

    parameters = {"size": Parameter(0.4, "V/m")}
    both = Custom("both", force=pushes, friction_level=rubs, parameters=parameters)
    assert both.HOOKS == ("force", "friction_level")
    one = Custom("one", force=pushes, parameters=parameters)
    other = Custom("other", friction_level=rubs, parameters=parameters)
    np.testing.assert_allclose(run(both).true_position, run(one, other).true_position, rtol=0, atol=1e-12)


# The integrator -------------------------------------------------------------------------------------------------------


def against_scipy(law, breaks, axis, own, velocity=0.35):
    """True motion of a free axis under 1 V from 0.1 m, against pieces between the places where the law jumps."""
    plant = cogging.Plant(axis, effects=[own])
    t = np.arange(400) / 1000.0
    still = np.zeros_like(t)
    push = cogging.Sampled(t, still, still, np.full_like(t, 0.3))
    pid = cogging.Pid(cogging.PidParameters(sample_rate=1000.0, mass=1.0))
    log = cogging.closed_loop(plant, pid, push, initial_position=0.1, initial_velocity=velocity)

    def rates(_, state):
        return [state[1], (0.3 - axis.viscous * state[1] + law(state[0], state[1])) / axis.mass]

    events = [lambda _, state, at=at: state[0] - at for at in breaks]
    for event in events:
        event.terminal = True
    state, start, states = np.array([0.1, velocity]), 0.0, [np.array([[0.1, velocity]])]
    while sum(map(len, states)) < len(t):
        left = t[t > start]
        solved = solve_ivp(rates, (start, t[-1]), state, "DOP853", left, rtol=1e-12, atol=1e-14, events=events)
        states.append(np.asarray(solved.y).reshape(2, -1).T)
        if solved.status == 1:  # on from a picometre behind the place
            hit = next(i for i, found in enumerate(solved.t_events) if len(found))
            start, state = float(solved.t_events[hit][0]), solved.y_events[hit][0]
            state = np.array([state[0] + 1e-12 * np.sign(state[1]), state[1]])
    truth = np.concatenate(states)
    return np.abs(log.true_position - truth[:, 0]).max() / np.ptp(truth[:, 0])


@settings(max_examples=6, deadline=None)
@given(place=st.floats(0.11, 0.2), jump=st.floats(-0.25, 0.25), kink=st.floats(-20.0, 20.0), mass=st.floats(0.05, 0.5))
def test_a_law_with_a_jump_and_a_kink_is_integrated_as_exactly_as_any(place, jump, kink, mass):
    def law(position, velocity=0.0):
        return np.where(position < place, 0.0, jump + kink * (position - place))

    own = Custom("wall", force=lambda position: law(position))
    axis = cogging.AxisParameters(mass=mass, viscous=0.3)
    assert against_scipy(law, [place], axis, own) < 1e-6


def test_a_narrow_pulse_must_be_stated_and_is_then_felt():
    """Five micrometres wide where half a sample covers 175: seen only by who knows of it."""

    def law(position, velocity=0.0):
        return np.where(abs(position - 0.150003) < 2.5e-6, -150.0, 0.0)

    axis = cogging.AxisParameters(mass=0.3, viscous=0.3)
    breaks = [0.150003 - 2.5e-6, 0.150003 + 2.5e-6]
    stated = Custom("notch", force=lambda position: law(position), length_scale=5e-6)
    unstated = Custom("notch", force=lambda position: law(position))
    assert against_scipy(law, breaks, axis, stated) < 1e-6
    assert against_scipy(law, breaks, axis, unstated) > 1e-4


def test_a_force_that_jumps_at_rest_is_not_silently_wrong():
    """Dry friction written as a force has no solution at rest: the steps become ever smaller, which is an error."""
    own = Custom("dry", force=lambda velocity: -2.0 * np.sign(velocity))
    plant = cogging.Plant(cogging.AxisParameters(mass=0.1), effects=[own])
    pid = cogging.Pid(cogging.PidParameters(sample_rate=1000.0))
    still = cogging.Sine(cogging.SineParameters(amplitude=0.0))
    with pytest.raises(cogging.DivergedError, match="must change slowly enough to be integrated in 1e5 steps a sample"):
        cogging.closed_loop(plant, pid, still, duration=0.2, initial_velocity=0.1)


# Description ----------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("name", sorted(COPIES))
def test_a_copy_has_the_description_of_the_effect(name):
    make, fields = COPIES[name]
    own, kind = make(), cogging.EFFECTS[name]
    assert own.HOOKS == kind.HOOKS
    assert set(own.FIELDS) == set(kind.FIELDS) == set(own.ROLES)
    assert {key: unit for key, (unit, _) in own.FIELDS.items()} == {key: unit for key, (unit, _) in kind.FIELDS.items()}
    assert own.KINDS == kind.KINDS
    for key, role in own.ROLES.items():
        its = kind.ROLES[key]
        assert {part: role[part] for part in ("role", "quantity")} == {part: its[part] for part in ("role", "quantity")}
        assert role["high"] == pytest.approx(its["high"])
    one, its = own.replace(**fields), kind(**fields)
    assert one.to_dict() == its.to_dict() == fields
    rng = np.random.default_rng(1)
    where = {"position": rng.uniform(0.0, 0.4, 30), "velocity": rng.normal(size=30), "time": rng.uniform(0.0, 9.0, 30)}
    for method, taken in (
        ("force_at", ("position", "velocity", "time")),
        ("friction_level_at", ("position", "velocity", "time")),
        ("gain_at", ("position", "time")),
        ("reading_at", ("position",)),
    ):
        assert hasattr(one, method) == hasattr(its, method)
        if hasattr(its, method):
            asked = {key: where[key] for key in taken}
            np.testing.assert_allclose(getattr(one, method)(**asked), getattr(its, method)(**asked), atol=1e-14)
            scalar = {key: float(value[3]) for key, value in asked.items()}
            assert getattr(one, method)(**scalar) == pytest.approx(getattr(its, method)(**asked)[3], abs=1e-14)


def test_a_custom_effect_is_a_value():
    one = own_spring().replace(stiffness=3.0)
    assert one == own_spring().replace(stiffness=3.0)
    assert one != own_spring()
    assert one != cogging.effects.CableSpring(stiffness=3.0)
    assert repr(one) == "Custom('own_spring', stiffness=3.0, center=0.0)"
    assert copy.deepcopy(one) == one == pickle.loads(pickle.dumps(one))
    assert one.resolved(AXIS) is one
    assert cogging.Plant(AXIS, effects=[one]).effects == [one]
    assert one.neutral().to_dict() == {"stiffness": 0.0, "center": 0.0}
    nodes = own_friction().replace(nodes=[0.0, 0.2], levels=[0.1, 0.3])
    nodes.levels.append(7.0)
    assert nodes.levels == [0.1, 0.3]
    with pytest.raises(AttributeError, match="replace"):
        one.stiffness = 4.0
    with pytest.raises(AttributeError, match="no attribute 'mass'"):
        _ = one.mass
    with pytest.raises((pickle.PicklingError, AttributeError)):  # as any function that has no name of its own
        pickle.dumps(Custom("other", force=lambda velocity: -velocity))


def test_a_model_file_holds_values_without_laws(tmp_path):
    own = own_spring()
    model = cogging.Model(axis=AXIS, effects=(own.replace(stiffness=3.0), cogging.effects.ConstantForce(force=0.1)))
    model.write(tmp_path / "model.toml")
    read = cogging.Model.read(tmp_path / "model.toml", effects=[own])
    assert read == model
    assert cogging.Model.from_dict(model.to_dict(), effects=[own]) == model
    with pytest.raises(cogging.InputError, match=r"effects\.name: must be one of .* got 'own_spring'") as refused:
        cogging.Model.read(tmp_path / "model.toml")
    assert "Model.read(path, effects=[it])" in str(refused.value)
    text = (tmp_path / "model.toml").read_text()
    for old, new, message in (
        ("stiffness = 3.0", 'stiffness = "3"', "stiffness: must be a number"),
        ("stiffness = 3.0", "stifness = 3.0", "stifness"),
        ("stiffness = 3.0", "stiffness = nan", "stiffness: must be a finite number"),
    ):
        (tmp_path / "wrong.toml").write_text(text.replace(old, new))
        with pytest.raises(cogging.InputError, match=message):
            cogging.Model.read(tmp_path / "wrong.toml", effects=[own])


def test_a_log_is_repeated_with_the_law_that_it_does_not_hold():
    model = cogging.Model(axis=AXIS, effects=(own_eddy().replace(slope=1.0),), controller=PID, controller_type="pid")
    log = cogging.simulate(model, MOVES)
    np.testing.assert_array_equal(cogging.repeat(log, effects=[own_eddy()]).position, log.position)
    with pytest.raises(ValueError, match="must be one of"):
        cogging.repeat(log)


# Refused --------------------------------------------------------------------------------------------------------------


def law(force, name="mine", **more):
    return lambda: Custom(name, force=force, **more)


def with_fields(**fields):
    return lambda: Parameter(1.0, **fields)


def remembering(velocity, calls=[0]):  # noqa: B006 (that is what is wrong with it)
    calls[0] += 1
    return velocity * calls[0]


def plain(velocity):
    return velocity


REFUSED = [
    (law(plain, "cable_spring"), "name: must not be one of the vocabulary"),
    (law(plain, "mass_change"), "name: must not be one of the vocabulary"),
    (law(plain, "My law"), "name: must be lower-case letters"),
    (law(plain, 3), "name: must be lower-case letters"),
    (lambda: Custom("mine"), "mine: must have a law"),
    (law(3.0), "mine.force: must be a function, got 3.0"),
    (law(max), "mine.force: must be a function whose arguments have names"),
    (law(lambda speed: speed), "mine.force: must take its arguments by name, .* got 'speed'"),
    (law(lambda velocity, /: velocity), "mine.force: must take its arguments by name"),
    (law(lambda velocity: 1j * velocity), "mine.force: raised TypeError .*real numbers"),
    (law(lambda velocity: "a"), "mine.force: raised TypeError .*real numbers"),
    (law(lambda velocity: None), "mine.force: raised TypeError"),
    (law(lambda velocity: np.zeros(2)), r"mine.force: raised ValueError .*shape \(2,\)"),
    (law(lambda velocity: velocity * math.nan), "mine.force: must be a finite number, got nan at position 0.02,"),
    (law(lambda velocity: [][0]), r"mine.force: raised IndexError \(list index out of range\)"),
    (law(lambda velocity: 1.0 if velocity > 0 else 0.0), "mine.force: raised ValueError .*along arrays of 3"),
    (law(lambda velocity: velocity.clip(0)), "mine.force: raised AttributeError .* at position 0.02,"),
    (law(lambda velocity: velocity - np.mean(velocity)), "mine.force: must give the same for arrays as for numbers"),
    (law(remembering), "mine.force: must give the same for arrays as for numbers"),
    (lambda: Custom("mine", command_gain=plain), "must take its arguments by name, of position, time"),
    (lambda: Custom("mine", reading_error=lambda time: time), "arguments by name, of position, got 'time'"),
    (law(plain, parameters={"size": 1.0}), "mine.size: must be an argument of a law"),
    (law(lambda velocity, replace: 0.0, parameters={"replace": 1.0}), "mine.parameters: .* no place or method"),
    (law(lambda velocity, a: velocity, parameters={"a": math.inf}), "mine.a: must be a finite number"),
    (law(lambda velocity, a: velocity, parameters={"a": "b"}), "mine.a: must be"),
    (law(plain, length_scale=0.0), "length_scale: must be above 0"),
    (law(plain, kinds=[Wave(shape="p", sine="s", cosine="c")]), "mine.kinds: must name parameters"),
    (law(ctypes.CFUNCTYPE(*[ctypes.c_double] * 4)(lambda x, v, t: v)), "mine.force: must be compiled code"),
    (lambda: law(compiled())(), r"must take doubles \(position, velocity, time\) and return one, got"),
    (
        lambda: law(compiled(), parameters={"slope": [0.0, 1.0], "corner": 1.0})(),
        "a compiled law accepts numbers only, got the list 'slope'",
    ),
    (with_fields(role="wish"), "role: must be"),
    (with_fields(quantity="charm"), "quantity: must be"),
    (with_fields(low=1.0), "low, high: both or neither"),
    (with_fields(low=1.0, high=0.0), "low, high: must be finite, low below high"),
    (with_fields(role="shape"), "low, high: must be given for a shape"),
    (with_fields(role="shape", low=0.0, high=1.0, logarithmic=True), "low: must be above 0"),
    (with_fields(unit="T"), "low, high: must be given for an amplitude in 'T'"),
    (with_fields(low=0.5, high=1.0), "must hold 0 for an amplitude"),
    (with_fields(neutral=1.0), "neutral: must be 0 for an amplitude"),
    (lambda: own_eddy().replace(slope=math.nan), "eddy_drag.slope: must be a finite number"),
    (lambda: own_eddy().replace(slope=[1.0]), "eddy_drag.slope: must be a number"),
    (lambda: own_eddy().replace(corner=0.0), "eddy_drag.corner: must be above 0"),
    (lambda: own_eddy().replace(speed=1.0), "eddy_drag.speed: must be one of slope, corner"),
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

    with pytest.raises(
        RuntimeError, match=r"mine\.force: raised IndexError .* at position .*, .*time 0\.3 s"
    ) as raised:
        run(Custom("mine", force=late))
    assert isinstance(raised.value.__cause__, IndexError)
    endless = Custom("mine", friction_level=lambda position: np.where(abs(position - 0.2) > 1e-3, 0.0, np.nan))
    with pytest.raises(
        cogging.DivergedError, match=r"mine\.friction_level: must be a finite number, got nan at"
    ) as raised:
        run(endless)
    place = float(re.search(r"position ([0-9.e-]+)", str(raised.value))[1])
    assert abs(place - 0.2) <= 1e-3


def test_ctrl_c_passes_through_a_law():
    def stop(time):
        if np.ndim(time) == 0 and 0.2 < time < 0.25:
            raise KeyboardInterrupt
        return 0.0 * time

    with pytest.raises(KeyboardInterrupt):
        run(Custom("mine", force=stop))
