"""Every public object: a one-line repr, equality by content, copies, pickle; parameters are read-only."""

import copy
import inspect
import pickle
from collections import ChainMap

import numpy as np
import pytest

import cogging
from tests.fixtures.examples import ABSTRACT, EXAMPLES
from tests.fixtures.plants_by_hand import example

OBJECTS = ChainMap(EXAMPLES, {f"effects.{name}": example(name) for name in cogging.EFFECTS})


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
    structs = [value for value in OBJECTS.values() if hasattr(value, "FIELDS")]
    assert len(structs) > 30
    for value in structs:
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
