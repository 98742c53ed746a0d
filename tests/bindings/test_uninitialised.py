"""An object whose __init__ has not run is refused with a TypeError wherever it is used, in every class of the core."""

import copy
import inspect
import itertools
import pickle
import re

import numpy as np
import pytest

import cogging
from cogging import _core

MODULES = (_core, _core.effects)
CLASSES = sorted(
    {
        kind
        for module in MODULES
        for kind in vars(module).values()
        if inspect.isclass(kind) and not issubclass(kind, Exception)
    },
    key=lambda kind: kind.__name__,
)
FUNCTIONS = [
    (f"{module.__name__}.{name}", function)
    for module in MODULES
    for name, function in vars(module).items()
    if callable(function) and not inspect.isclass(function) and not name.startswith("_")
]
OWN = re.compile(r"cogging\._core\.(?:effects\.)?(\w+)")


def raw(kind):
    return kind.__new__(kind)


def members(kind):
    """Names of what pybind11 has bound: properties and methods, __eq__, __repr__ and __getstate__ among them."""
    inherited = set(dir(object)) - {"__eq__", "__repr__"}
    names = [name for name in dir(kind) if name not in inherited and not name.startswith("_pybind11")]
    return [
        name
        for name in names
        if name not in ("__init__", "__setstate__", "__hash__", "__module__", "__doc__", "__signature__")
    ]


def signatures(function):
    """Each overload's parameters as (name, annotation)."""
    for line in (function.__doc__ or "").splitlines():
        found = re.match(r"^(?:\d+\. )?\w+\((.*)\) -> ", line)
        if found:
            parts = re.split(r", (?=\*|\w+: )", found.group(1))
            yield [tuple(part.split(": ", 1)) for part in parts if ": " in part]


def sample(annotation, without):
    """Some value that fits; `without` is the class whose place stays for an uninitialised object."""
    if "Mapping[str, " in annotation or "dict[str, " in annotation:
        return {"force": sample(annotation.split(", ", 1)[1], without)}
    for name in OWN.findall(annotation):
        kind = getattr(_core, name, None) or getattr(_core.effects, name)
        value = raw(kind) if kind is without else VALUES.get(name)
        if value is None:
            value = kind() if hasattr(kind, "FIELDS") else raw(kind)
        return [value] if "Sequence[" in annotation else value
    if "Sequence[" in annotation or "ndarray" in annotation or "numpy" in annotation:
        return np.linspace(0.0, 1.0, 4)
    if "bytes" in annotation:
        return b"1\n"
    if annotation == "str":
        return "own"
    return 1 if "Int" in annotation or "int" in annotation else 0.5


def plain_values():
    basis = cogging.SplineHarmonics(pitch=0.05, harmonics=[1])
    plant = _core.Plant(_core.AxisParameters())
    time = np.linspace(0.0, 0.1, 50)
    predictor = _core.Predictor(time, time, time)
    values = [
        basis,
        basis.spline,
        plant,
        predictor,
        predictor.predict(plant),
        cogging.CoggingModel(basis, [[0.1]], [[0.1]]),
        cogging.Sine(cogging.SineParameters()),
        cogging.Pid(cogging.PidParameters()),
    ]
    named = {type(value).__name__: value for value in values}
    return named | {"Reference": named["Sine"]}


VALUES = plain_values()
#: What only a plant asks, through its effects.
MEMBERLESS = {"OwnLaw", "PythonLaw", "CompiledLaw"}


def test_the_walk_sees_the_whole_core():
    names = {kind.__name__ for kind in CLASSES}
    assert {"Pid", "Plant", "NumberReader", "Predictor", "Prediction", "Reference", "Backlash"} <= names
    assert len(CLASSES) > 50
    assert {"closed_loop", "closed_loop_records", "replay_controller"} <= {name.split(".")[-1] for name, _ in FUNCTIONS}


def no_member_of_an_uninitialised_object_answers(kind):
    asked = 0
    for name in members(kind):
        bound = inspect.getattr_static(kind, name)
        if isinstance(bound, property):
            with pytest.raises(TypeError, match="must be initialised"):
                getattr(raw(kind), name)
            asked += 1
        elif isinstance(bound, staticmethod) or not callable(getattr(kind, name)):
            continue  # a class' own constant, or what no object takes part in
        else:
            method = getattr(raw(kind), name)
            for parameters in signatures(getattr(kind, name)):
                arguments = {
                    name: sample(annotation.split(" = ")[0], None) for name, annotation in parameters if name != "self"
                }
                positional = name.startswith("__") or any(word.startswith("arg") for word in arguments)
                with pytest.raises(TypeError, match="must be initialised"):
                    method(*arguments.values()) if positional else method(**arguments)
                asked += 1
    assert (asked == 0) == (kind.__name__ in MEMBERLESS)


def an_uninitialised_object_is_no_copy(kind):
    for use in (pickle.dumps, copy.copy, copy.deepcopy):
        with pytest.raises(TypeError):
            use(raw(kind))
    if "__repr__" in vars(kind):
        with pytest.raises(TypeError, match="must be initialised"):
            repr(raw(kind))
    if hasattr(kind, "FIELDS"):
        for one, other in ((raw(kind), kind()), (kind(), raw(kind)), (raw(kind), raw(kind))):
            with pytest.raises(TypeError, match="must be initialised"):
                _ = one == other


def test_no_function_takes_an_uninitialised_object():
    """Every function, method and constructor that has a place for one; the other places are filled with sound ones."""
    callables, tried = list(FUNCTIONS), set()
    for owner in CLASSES:
        if owner.__name__ in VALUES or hasattr(owner, "FIELDS"):
            value = VALUES.get(owner.__name__) or owner()
            callables += [(f"{owner.__name__}.{name}", getattr(value, name)) for name in members(owner)]
        callables.append((owner.__name__, owner))
    for name, function in filter(lambda entry: callable(entry[1]), callables):
        for parameters in signatures(function.__init__ if inspect.isclass(function) else function):
            fits = {word: takes(annotation) for word, annotation in parameters if word not in ("self", "arg0")}
            for place, kind in ((word, kind) for word, kinds in fits.items() for kind in kinds):
                arguments = {
                    word: sample_at(annotation, kind if word == place else None)
                    for word, annotation in parameters
                    if (word != "self" and " = " not in annotation) or word == place
                }
                with pytest.raises((TypeError, RuntimeError)) as raised:
                    function(**arguments)
                shared = kind.__name__ in MEMBERLESS  # held together with the plants: pybind11 refuses it itself
                told = "cast from non-held" if shared else "must be initialised"
                assert told in str(raised.value), f"{name}({place})"
                tried.add(kind.__name__)
    assert tried >= {"Plant", "CoggingModel", "AxisParameters", "SplineHarmonics", "Prediction", "Sine"}


@pytest.mark.parametrize("kind", [*cogging.CONTROLLERS.values(), cogging.CompiledController])
def test_no_run_takes_an_uninitialised_controller(kind):
    """Runs take any object as a controller, which no signature tells."""
    plant, motion, time = VALUES["Plant"], VALUES["Sine"], np.linspace(0.0, 1.0, 4)
    for run in (
        lambda: cogging.closed_loop(plant, raw(kind), motion),
        lambda: cogging.closed_loop_batch([plant], [raw(kind)], motion),
        lambda: cogging.replay_controller(raw(kind), time=time, reference=time, position=time),
    ):
        with pytest.raises(TypeError, match="must be initialised"):
            run()


def takes(annotation):
    """The classes of which an object fits."""
    named = OWN.findall(annotation)
    owners = tuple(owner for owner in CLASSES if owner.__name__ in named)
    return [kind for kind in CLASSES if owners and issubclass(kind, owners)]


def sample_at(annotation, without):
    """As sample; of a union, the member that is to stay uninitialised."""
    annotation = annotation.split(" = ")[0]
    if without is not None:
        value = raw(without)
        if "Mapping[str, " in annotation or "dict[str, " in annotation:
            return {"force": value}
        return [value] if "Sequence[" in annotation else value
    return sample(annotation, None)


def a_subclass_that_skips_init_is_refused(kind):
    class Skips(kind):
        def __init__(self):
            pass

    class Early(kind):
        def __init__(self):
            for name in members(kind):
                getattr(self, name)

    with pytest.raises(TypeError, match="__init__"):
        Skips()
    if any(isinstance(inspect.getattr_static(kind, name), property) for name in members(kind)):
        with pytest.raises(TypeError, match="initialised"):
            Early()


def copies_and_subclasses_of_sound_objects_work(kind):
    if not hasattr(kind, "FIELDS"):
        return

    class Sound(kind):
        def __init__(self, **fields):
            super().__init__(**fields)

    for value in (kind(), Sound()):
        assert value == kind()
        assert repr(value).startswith(kind.__name__)
    for copied in (copy.copy(kind()), copy.deepcopy(kind()), pickle.loads(pickle.dumps(kind())), kind().replace()):
        assert copied == kind()


@pytest.mark.parametrize(
    "holds",
    [
        no_member_of_an_uninitialised_object_answers,
        an_uninitialised_object_is_no_copy,
        a_subclass_that_skips_init_is_refused,
        copies_and_subclasses_of_sound_objects_work,
    ],
)
def test_of_every_class(holds):
    for kind in CLASSES:
        holds(kind)


def test_a_model_survives_pickle_and_copies():
    model = VALUES["CoggingModel"]
    for copied in (copy.copy(model), copy.deepcopy(model), pickle.loads(pickle.dumps(model))):
        assert copied.force(0.013) == model.force(0.013)


def test_init_may_run_late_but_must_have_run():
    made = raw(cogging.Pid)
    for _ in range(2):
        with pytest.raises(TypeError, match="must be initialised"):
            _ = made.sample_rate
    made.__init__(cogging.PidParameters(sample_rate=123.0))
    assert made.sample_rate == 123.0
    assert all(one == 123.0 for one in itertools.repeat(made.sample_rate, 3))
