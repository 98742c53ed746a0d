"""Every public object: a one-line repr, equality by content, copies, pickle; parameters are read-only."""

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
from tests.fixtures.examples import ABSTRACT, EXAMPLES
from tests.fixtures.plants_by_hand import example

OBJECTS = ChainMap(EXAMPLES, {f"effects.{name}": example(name) for name in cogging.EFFECTS})
STRUCTS = [value for value in OBJECTS.values() if hasattr(value, "FIELDS")]


def test_every_public_class_has_an_example():
    classes = {name for name in cogging.__all__ if inspect.isclass(getattr(cogging, name))}
    assert classes == set(EXAMPLES) | ABSTRACT
    assert all(type(value) is getattr(cogging, name) for name, value in EXAMPLES.items())


def test_an_object_is_shown_in_one_line():
    for name, value in OBJECTS.items():
        line = repr(value)
        assert line.startswith(type(value).__name__), name
        assert "\n" not in line, name
        assert "object at 0x" not in line, name
        assert all(f"{field}=" in line for field in getattr(value, "FIELDS", ())), name
        assert not hasattr(value, "text") or str(value) == value.text(), name


def test_copies_are_equal_and_others_are_not():
    for name, value in OBJECTS.items():
        again = [copy.copy(value), copy.deepcopy(value)]
        if name == "CompiledController":  # its functions lie in the memory of this process
            with pytest.raises(TypeError, match=r"cannot pickle 'cogging\._core\.CompiledController' object"):
                pickle.dumps(value)
        else:
            again.append(pickle.loads(pickle.dumps(value)))
        if isinstance(value, Exception):
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


def test_parameters_are_read_only_and_each_field_counts():
    assert len(STRUCTS) > 30
    for value in STRUCTS:
        assert type(value)(**value.to_dict()) == value
        for name, was in value.to_dict().items():
            assert value.FIELDS[name][1], name  # its meaning
            with pytest.raises(AttributeError):
                setattr(value, name, 1.0)
            if isinstance(was, float) and np.isfinite(was):
                try:
                    other = value.replace(**{name: 1.0625 * was + 0.03125})
                except ValueError:
                    continue  # a rule that binds it to another field
                assert other != value, name
                assert repr(other) != repr(value), name


@pytest.mark.parametrize("name", sorted(kind.__name__ for _, kind in CONTROLLERS.values()))
def test_a_copied_controller_continues_as_the_original(name):
    warm = OBJECTS[name]
    fresh, runs = type(warm)(warm.parameters), []
    assert warm != fresh
    for one in (warm.copy(), copy.deepcopy(warm), pickle.loads(pickle.dumps(warm)), fresh):
        commands = []
        for k in range(40):
            x, reading = 0.1 + 1e-4 * k, 0.1 + 1e-4 * k + 1e-5 * np.sin(k)
            given = {"reference": x, "reference_velocity": 0.1, "reference_acceleration": 1.0}
            if hasattr(one, "preview"):
                given = {"reference": (x, 0.1, 1.0), "ahead": (x, 0.1, 1.0)}
            commands.append(one.command(**given, reading=reading))
            one.update(commands[-1])
        runs.append((commands, one.estimates.tolist(), one.samples_refused))
    assert runs[0] == runs[1] == runs[2]
    assert runs[3] != runs[0]
    assert warm.samples_refused == 1


@settings(derandomize=True, deadline=None, max_examples=12)
@given(
    seed=st.integers(0, 2**32 - 1),
    effects=st.sets(st.sampled_from(sorted(set(cogging.EFFECTS) - {"backlash", "flexible_mode"})), max_size=4),
    controller=st.sampled_from([None, *sorted(CONTROLLERS)]),
    waves=st.sampled_from([{"periods": [0.021, 0.05]}, {"harmonics": [1, 4]}]),
    points=st.integers(0, 5),
)
def test_a_model_comes_back_from_its_document(seed, effects, controller, waves, points):
    rng = np.random.default_rng(seed)
    cog = None
    if points:
        order = int(rng.integers(1, points + 1))
        basis = cogging.SplineHarmonics(pitch=0.05, order=order, origin=rng.normal(), control_points=points, **waves)
        cog = cogging.CoggingModel(basis, *rng.normal(size=(2, 2, points)))
    model = cogging.Model(
        axis=cogging.AxisParameters(mass=rng.lognormal(), viscous=rng.lognormal(), travel=[-rng.lognormal(), 1.0]),
        cogging=cog,
        effects=[example(name) for name in sorted(effects)],
        encoder=cogging.EncoderParameters(resolution=rng.lognormal()),
        noise=cogging.NoiseParameters(force=rng.lognormal()),
        controller=None if controller is None else CONTROLLERS[controller][0](sample_rate=rng.uniform(100, 9000)),
        controller_type=controller,
        uncertainty={"mass": rng.random()} if rng.random() < 0.5 else {},
        intervals={"axis.mass": [0.0, np.inf]} if rng.random() < 0.5 else {},
        steps_per_sample=int(rng.integers(1, 9)),
    )
    assert cogging.Model.from_dict(model.to_dict()) == model == pickle.loads(pickle.dumps(model))
    assert model.replace(steps_per_sample=model.steps_per_sample + 1) != model
