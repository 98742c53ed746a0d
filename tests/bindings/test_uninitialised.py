"""An object whose __init__ has not run is refused with a TypeError wherever it is used, in every class of the core."""

import copy
import pickle

import numpy as np
import pytest

import cogging
from tests.attack.binding_values import CLASSES, KIND, Pool, raw, sound
from tests.attack.core_signatures import targets

POOL = Pool()
TARGETS = targets()


def arguments(target, place=None, kind=None):
    """Sound arguments of a call, by position and by name; in one place an uninitialised object of a class."""
    random, positional, named = np.random.default_rng(0), [], {}
    for parameter in target.parameters:
        if parameter is not place and parameter.default is not parameter.empty:
            continue
        value = sound(parameter.name, parameter.annotation, random, POOL)
        if parameter is place:
            value = [raw(kind)] if "Sequence[" in parameter.annotation else raw(kind)
            value = {"force": value} if "Mapping[str" in parameter.annotation else value
        if parameter.kind is parameter.KEYWORD_ONLY or parameter.default is not parameter.empty:
            named[parameter.name] = value
        else:
            positional.append(value)
    return positional, named


def test_no_member_of_an_uninitialised_object_answers():
    methods = [target for target in TARGETS if target.owner and not target.is_static]
    assert len({target.owner for target in methods}) > 50
    for target in methods:
        if target.name in ("__init__", "__setstate__"):
            continue
        subject, (positional, named) = raw(target.place), arguments(target)

        with pytest.raises(TypeError, match="must be initialised"):
            getattr(subject, target.name)(*positional, **named)


def test_no_function_takes_an_uninitialised_object():
    """Every function, method and constructor that has a place for one; the other places are filled with sound ones."""
    tried = set()
    for target in TARGETS:
        if target.is_property or target.name == "__setstate__":
            continue
        subject = target.place
        if target.owner and target.name != "__init__" and not target.is_static:
            if target.owner not in POOL:
                continue
            subject = POOL[target.owner]
        function = subject if target.name == "__init__" else getattr(subject, target.name)
        for place in target.parameters:
            owners = tuple(CLASSES[name] for name in KIND.findall(place.annotation) if name in CLASSES)
            for kind in (kind for kind in CLASSES.values() if issubclass(kind, owners)):
                positional, named = arguments(target, place, kind)
                with pytest.raises((TypeError, RuntimeError), match=r"must be initialised|cast from non-held"):
                    function(*positional, **named)
                tried.add(kind.__name__)
    assert tried >= {"Plant", "CoggingModel", "AxisParameters", "SplineHarmonics", "Prediction", "Sine"}


def test_no_run_takes_an_uninitialised_controller():
    """Runs take any object as a controller, which no signature shows."""
    plant, motion, time = POOL["Plant"], POOL["Sine"], np.linspace(0.0, 1.0, 4)
    for kind in (*cogging.CONTROLLERS.values(), cogging.CompiledController):
        for run in (
            lambda kind=kind: cogging.closed_loop(plant, raw(kind), motion),
            lambda kind=kind: cogging.closed_loop_batch([plant], [raw(kind)], motion),
            lambda kind=kind: cogging.replay_controller(raw(kind), time=time, reference=time, position=time),
        ):
            with pytest.raises(TypeError, match="must be initialised"):
                run()


def test_an_uninitialised_object_is_not_copied_shown_or_compared():
    for name, kind in CLASSES.items():
        for use in (pickle.dumps, copy.copy, copy.deepcopy):
            with pytest.raises(TypeError):
                use(raw(kind))
        if "__repr__" in vars(kind):
            with pytest.raises(TypeError, match="must be initialised"):
                repr(raw(kind))
        if name in POOL and kind.__eq__ is not object.__eq__:
            for one, other in ((raw(kind), POOL[name]), (POOL[name], raw(kind)), (raw(kind), raw(kind))):
                with pytest.raises(TypeError, match="must be initialised"):
                    _ = one == other


def test_a_subclass_must_run_init_which_may_come_late():
    for kind in CLASSES.values():
        skips = type("Skips", (kind,), {"__init__": lambda self: None})
        with pytest.raises(TypeError, match="__init__"):
            skips()
        if hasattr(kind, "FIELDS"):
            assert type("Sound", (kind,), {})() == kind()
            late = raw(kind)
            late.__init__()
            assert late == kind()
