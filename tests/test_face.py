"""Every public object: one line that says what it is, equality by content, copies, pickle; mistakes in one line."""

import copy
import inspect
import pickle
from collections import ChainMap

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import cogging
from cogging.model.model import CONTROLLERS
from cogging.values import same
from tests.fixtures.examples import ABSTRACT, EXAMPLES, LOG, MODEL
from tests.fixtures.plants_by_hand import example

CLASSES = sorted(name for name in cogging.__all__ if inspect.isclass(getattr(cogging, name)))
OBJECTS = ChainMap(EXAMPLES, {f"effects.{name}": example(name) for name in cogging.EFFECTS})
ERRORS = ("ControllerError", "DivergedError", "InputError")


def test_every_public_class_has_an_example_of_its_own():
    assert set(CLASSES) == set(EXAMPLES) | ABSTRACT
    for name, value in EXAMPLES.items():
        assert type(value) is getattr(cogging, name)


def test_one_line_says_what_an_object_is():
    for name, value in OBJECTS.items():
        line = repr(value)
        assert line.startswith(type(value).__name__), name
        assert "\n" not in line, name
        assert "object at 0x" not in line, name
        assert len(line) < 400 or hasattr(value, "FIELDS") or hasattr(value, "parameters"), name
        assert all(f"{field}=" in line for field in getattr(value, "FIELDS", ())), name
        assert str(value) == (value.text() if hasattr(value, "text") else str(value)), name


def test_copies_are_equal_and_others_are_not():
    for name, value in OBJECTS.items():
        again = [copy.copy(value), copy.deepcopy(value)]
        if name == "CompiledController":  # its functions lie in the memory of this process
            with pytest.raises(TypeError, match=r"cannot pickle 'cogging\._core\.CompiledController' object"):
                pickle.dumps(value)
        else:
            again.append(pickle.loads(pickle.dumps(value)))
        if name in ERRORS:
            assert [(type(one), one.args) for one in again] == [(type(value), value.args)] * 3
            continue
        for one in again:
            assert type(one) is type(value)
            assert one == value, name
            assert repr(one) == repr(value)
        others = [other for other in OBJECTS.values() if type(other) is not type(value)]
        assert not any(value == other for other in (*others, None, 1.0, "text")), name
        if not isinstance(value, tuple):
            assert type(value).__eq__(value, object()) is NotImplemented
            with pytest.raises(TypeError, match="unhashable"):
                hash(value)


def test_one_field_makes_the_difference():
    for value, field, was in ((one, *entry) for one in structs() for entry in one.to_dict().items()):
        if not isinstance(was, float) or not np.isfinite(was):
            continue
        try:
            other = value.replace(**{field: 1.0625 * was + 0.03125})
        except ValueError:
            continue  # a rule that binds it to another field
        assert other != value, field
        assert repr(other) != repr(value), field


@pytest.mark.parametrize("name", sorted(kind.__name__ for _, kind in CONTROLLERS.values()))
def test_a_copied_controller_goes_on_as_the_one_it_was_copied_from(name):
    warm = OBJECTS[name]
    fresh = type(warm)(warm.parameters)
    assert warm != fresh
    ahead = hasattr(warm, "preview")
    runs = []
    for one in (warm.copy(), copy.deepcopy(warm), pickle.loads(pickle.dumps(warm)), fresh):
        commands = []
        for k in range(40):
            point = (0.1 + 1e-4 * k, 0.1, 1.0)
            reading = 0.1 + 1e-4 * k + 1e-5 * np.sin(k)
            if ahead:
                command = one.command(reference=point, ahead=point, reading=reading)
            else:
                command = one.command(
                    reference=point[0], reference_velocity=point[1], reference_acceleration=point[2], reading=reading
                )
            one.update(command)
            commands.append(command)
        runs.append((commands, one.estimates.tolist(), one.samples_refused))
    assert runs[0] == runs[1] == runs[2]
    assert runs[3] != runs[0]
    assert warm.samples_refused == 1


def test_compiled_controllers_are_equal_in_the_same_state():
    one = OBJECTS["CompiledController"].copy()
    other = one.copy()
    one.command((0.2, 0.0, 0.0), 0.1)
    assert one != other
    one.reset()
    other.reset()
    assert one == other


def test_a_copied_log_stays_read_only_and_its_line_short():
    time = 1e-3 * np.arange(1_000_000)
    log = cogging.Log(time, np.zeros_like(time), np.zeros_like(time))
    assert repr(log) == "Log(1000000 rows, 999.999 s at 1000 Hz, 0 to 0 m)"
    for one in (copy.deepcopy(LOG), pickle.loads(pickle.dumps(LOG))):
        with pytest.raises(ValueError, match="read-only"):
            one.position[0] = 1.0


@pytest.mark.parametrize(
    ("one", "other", "equal"),
    [
        (np.array([1.0, np.nan]), np.array([1.0, np.nan]), True),
        (np.array([1.0]), np.array([2.0]), False),
        (np.array([1.0, 1.0]), np.array([1.0]), False),
        (np.array(["a"]), np.array(["a"]), True),
        (np.array([1.0]), [1.0], False),
        (float("nan"), float("nan"), True),
        (float("nan"), 1.0, False),
        ({"a": np.arange(3)}, {"a": np.arange(3)}, True),
        ({"a": 1}, {"b": 1}, False),
        ([1, (2.0, "x")], [1, (2.0, "x")], True),
        ([1, 2], (1, 2), False),
        (1, 1.0, True),
    ],
)
def test_same(one, other, equal):
    assert same(one, other) is equal


@settings(derandomize=True, deadline=None, max_examples=40)
@given(
    random=st.integers(0, 2**32 - 1),
    effects=st.lists(
        st.sampled_from(sorted(set(cogging.EFFECTS) - {"backlash", "flexible_mode"})), max_size=4, unique=True
    ),
    controller=st.sampled_from([None, *sorted(CONTROLLERS)]),
    periods=st.booleans(),
    points=st.integers(0, 5),
)
def test_a_model_comes_back_from_its_document(random, effects, controller, periods, points):
    rng = np.random.default_rng(random)
    cog = None
    if points:
        which = {"periods": [0.021, 0.05]} if periods else {"harmonics": [1, 4]}
        order = int(rng.integers(1, points + 1))
        basis = cogging.SplineHarmonics(pitch=0.05, order=order, origin=rng.normal(), control_points=points, **which)
        cog = cogging.CoggingModel(basis, *rng.normal(size=(2, 2, points)))
    model = cogging.Model(
        axis=cogging.AxisParameters(mass=rng.lognormal(), viscous=rng.lognormal(), travel=[-rng.lognormal(), 1.0]),
        cogging=cog,
        effects=[example(name) for name in effects],
        encoder=cogging.EncoderParameters(resolution=rng.lognormal()),
        noise=cogging.NoiseParameters(force=rng.lognormal()),
        controller=None if controller is None else CONTROLLERS[controller][0](sample_rate=rng.uniform(100, 9000)),
        controller_type=controller,
        uncertainty={"mass": rng.random()} if rng.random() < 0.5 else {},
        intervals={"axis.mass": [0.0, np.inf]} if rng.random() < 0.5 else {},
        steps_per_sample=int(rng.integers(1, 9)),
    )
    again = cogging.Model.from_dict(model.to_dict())
    assert again == model
    assert again.replace(steps_per_sample=model.steps_per_sample + 1) != model
    assert pickle.loads(pickle.dumps(model)) == model


def test_progress_is_told_each_step():
    told = []
    cogging.identify(LOG, MODEL, free=["axis.mass"], progress=told.append)
    assert told == ["inverse dynamics", "output error", "logs one by one", "other answers"]


def structs():
    """An example of each class of parameters."""
    found = [value for value in OBJECTS.values() if hasattr(value, "FIELDS")]
    assert len(found) > 30
    return found


def test_parameter_structs_are_read_only_say_what_their_fields_are_and_refuse_a_nan():
    for value in structs():
        kind = type(value)
        assert kind(**value.to_dict()) == value
        for name, (_unit, meaning) in value.FIELDS.items():
            assert meaning, f"{kind.__name__}.{name} has no meaning"
            with pytest.raises(AttributeError):
                setattr(value, name, 1.0)
            default = getattr(kind(), name)
            if not isinstance(default, str):
                nan, end = ([0.0, np.nan], "") if isinstance(kind().to_dict()[name], list) else (np.nan, ".*nan")
                with pytest.raises((TypeError, ValueError), match=rf"\b{name}: {end}"):
                    kind(**{name: nan})


def test_signatures_are_in_plain_types():
    """What an editor offers behind a bracket: the fields, and types that a reader knows."""
    kinds = [getattr(cogging, name) for name in CLASSES if hasattr(getattr(cogging, name), "__signature__")]
    assert {cogging.PidParameters, cogging.Pid, cogging.Plant, cogging.SplineHarmonics} <= set(kinds)
    for kind in [*kinds, *cogging.EFFECTS.values()]:
        signature = inspect.signature(kind)
        assert "Supports" not in str(signature)
        for name in getattr(kind, "FIELDS", ()):
            assert same(signature.parameters[name].default, getattr(kind(), name))
    assert inspect.signature(cogging.PidParameters).parameters["kp"].annotation is float
    assert cogging.project.__doc__.startswith("project(rate: float, estimate: float, ")
    assert set(dir(cogging.plot)) == set(cogging.plot.__all__)
