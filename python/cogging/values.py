"""Public values: equality by content, a one-line repr with units, copies and pickles.

Results in Python inherit from `ByValue`; `as_values` gives the classes of the core the same behaviour. Both hold arrays
and mappings, so neither has a hash.
"""

from __future__ import annotations

import collections
import copyreg
import dataclasses
import importlib
import inspect
import math
import re
import typing
from collections.abc import Callable, Mapping
from typing import Any

import numpy as np

from cogging import _core

SHOWN = 6  # entries of a list in a repr
#: Maps a unit in V and m to the label that a model gives it (Units.of).
UnitLabel = Callable[[str], str]
#: Properties that define an object of the core without a parameter struct, with their units.
DEFINING = {
    "BSpline": {"order": "", "origin": "m", "pitch": "m", "control_points": ""},
    "SplineHarmonics": {"pitch": "m", "harmonics": "", "periods": "m", "spline": ""},
    "CoggingModel": {"basis": "", "sine": "V", "cosine": "V"},
    "Plant": {"axis": "", "cogging": "", "effects": "", "encoder": "", "noise": ""},
    "Performance": dict.fromkeys(("error_max", "error_rms", "error_final_max"), "m")
    | {"command_rms": "V", "command_change_rms": "V", "command_chatter": ""},
    "Sampled": {"samples": ""},
}
CONTROLS = "model, move, controller=parameters"
#: Example of each parameter struct: its arguments, and those of `simulate`; of an effect the arguments alone.
EXAMPLES = {
    "AxisParameters": ("mass=0.12, viscous=0.2, travel=[0.0, 0.5]", "model.replace(axis=parameters), move"),
    "EncoderParameters": ("resolution=1e-6", "model.replace(encoder=parameters), move"),
    "NoiseParameters": ("force=0.02", "model.replace(noise=parameters), move"),
    "PidParameters": ("kp=9600.0, ki=1e5, kd=48.0, mass=0.12", CONTROLS),
    "CascadeParameters": ("kp=150.0, kv=40.0", CONTROLS),
    "SpeedParameters": ("kp=40.0, mass=0.12", CONTROLS),
    "AdaptiveRobustParameters": (
        "cogging_harmonics=[1, 2], cogging_adaptation=10.0",
        "model, move, controller=cogging.Dcarc(parameters)",
    ),
    "OutputFeedbackArcParameters": ("robust_factor=0.5", CONTROLS),
    "ObserverBasedParameters": ("periods=[0.05], mass=0.12", CONTROLS),
    "PointToPointParameters": ("start=0.05, distance=0.4, velocity=0.4", "model, cogging.PointToPoint(parameters)"),
    "SineParameters": ("center=0.2, amplitude=0.1", "model, cogging.Sine(parameters), duration=2.0"),
    "FilteredSineParameters": ("center=0.2, amplitude=0.1", "model, cogging.FilteredSine(parameters), duration=2.0"),
    "CoggingModulation": "period=0.05, sine=[0.0, 0.01], cosine=[0.0, 0.02], pitch=0.5, order=2",
    "PreslidingFriction": "stiffness=3000.0",
    "PositionDependentFriction": "nodes=[0.0, 0.5], levels=[0.0, 0.05]",
    "EmpiricalForce": "position_nodes=[0.0, 0.5], position_forces=[0.0, 0.1]",
    "CommandDelay": "delay=1e-3",
    "ActuatorLag": "time_constant=1e-3",
    "CommandSaturation": "limit=5.0",
    "CommandDeadZone": "width=0.01",
    "EncoderPeriodicError": "period=1e-3, sine=1e-6",
    "EncoderScaleError": "scale=1e-4",
    "Backlash": "gap=1e-5, mass_ratio=0.3",
    "FlexibleMode": "frequency=200.0, mass_ratio=0.3",
}


class ByValue:
    """Base of results: equal if all fields are equal, shown in one line, printed as `text()` where that exists."""

    __hash__ = None  # type: ignore[assignment]

    def __eq__(self, other: object) -> bool:
        if type(other) is not type(self):
            return NotImplemented
        names = [field.name for field in dataclasses.fields(self)]  # type: ignore[arg-type]
        return all(same(getattr(self, name), getattr(other, name)) for name in names)

    def __repr__(self) -> str:
        return f"{type(self).__name__}({self._brief()})"

    def __str__(self) -> str:
        text = getattr(self, "text", None)
        return str(text()) if callable(text) else repr(self)

    def _brief(self) -> str:
        """Return what the repr shows in brackets: the few numbers that matter, with units."""
        fields = dataclasses.fields(self)  # type: ignore[arg-type]
        return ", ".join(f"{field.name}={brief(getattr(self, field.name))}" for field in fields if field.repr)


def same(one: Any, other: Any) -> bool:
    """Return whether two values have the same type and content; NaN equals NaN."""
    if isinstance(one, np.ndarray) or isinstance(other, np.ndarray):
        if type(one) is not type(other) or one.shape != other.shape:
            return False
        floats = one.dtype.kind == "f" and other.dtype.kind == "f"
        return bool(np.array_equal(one, other, equal_nan=floats))
    if isinstance(one, Mapping) and isinstance(other, Mapping):
        return one.keys() == other.keys() and all(same(value, other[key]) for key, value in one.items())
    if type(one) is type(other) and isinstance(one, list | tuple):
        return len(one) == len(other) and all(map(same, one, other))
    if dataclasses.is_dataclass(one) and type(one).__eq__ is not ByValue.__eq__:
        return type(one) is type(other) and same(vars(one), vars(other))
    return bool(one == other) or (one is not None and one != one and other != other)


def brief(value: Any, unit: str = "") -> str:
    """Return a value in a few characters: six digits, the shape of an array, the length of a long list."""
    unit = f" {unit}" if unit and unit != "1" else ""
    if isinstance(value, np.ndarray):
        return f"{' x '.join(map(str, value.shape))} array"
    if isinstance(value, bool) or value is None or isinstance(value, str):
        return repr(value)
    if isinstance(value, int | float | np.number):
        return f"{value:.6g}{unit}"
    if isinstance(value, Mapping):
        return f"{len(value)} of {{{', '.join(map(str, list(value)[:SHOWN]))}{', ...' * (len(value) > SHOWN)}}}"
    if not isinstance(value, list | tuple):
        return type(value).__name__
    if len(value) <= SHOWN and all(isinstance(entry, int | float | str | np.number) for entry in value):
        return f"[{', '.join(brief(entry) for entry in value)}]{unit}"
    return f"{len(value)} entries"


# Objects of the core ------------------------------------------------------------------------------------------------


def line_of(value: Any, label: UnitLabel) -> str:
    """Return an object of the core in one line, with the units of a model's labels."""
    kind = _core_class(value)
    name, struct = kind.__name__, value if hasattr(kind, "FIELDS") else getattr(value, "parameters", None)
    if struct is not None:
        units = struct.FIELDS
        contents = ", ".join(f"{key}={brief(one, label(units[key][0]))}" for key, one in struct.to_dict().items())
    elif name == "SplineHarmonics":
        contents = _basis_contents(value, label)
    elif name == "CoggingModel":
        largest = max(float(abs(value.sine).max()), float(abs(value.cosine).max()))
        contents = f"{_basis_contents(value.basis, label)}, amplitudes up to {largest:.4g} {label('V')}"
    elif name == "Plant":
        cogging = [] if value.cogging is None else [f"cogging of {value.cogging.basis.terms} terms"]
        mass = f"mass {value.axis.mass:.6g} {label('V/(m/s^2)')}"
        contents = ", ".join([mass, *cogging, *(effect.NAME for effect in value.effects)])
    elif name == "Sampled":
        times = value.samples["time"]
        contents = f"{len(times)} samples from {times[0]:.6g} to {times[-1]:.6g} s"
    else:
        contents = ", ".join(f"{key}={brief(getattr(value, key), label(unit))}" for key, unit in DEFINING[name].items())
    return f"{name}({contents})"


def _basis_contents(basis: Any, label: UnitLabel) -> str:
    if basis.harmonics:
        terms = f"harmonics {brief(list(basis.harmonics))} of {basis.pitch:g} {label('m')}"
    else:
        terms = f"periods {brief(list(basis.periods), label('m'))}"
    spline = basis.spline
    if spline.control_points == 1:
        return terms
    origin = f"{spline.origin:g} {label('m')}"
    return f"{terms}, {spline.control_points} control points of order {spline.order} from {origin}"


def _core_class(value: Any) -> Any:
    """Return the class of the core that an object has, also where a user's class derives from it."""
    return next((one for one in type(value).__mro__ if one.__module__.startswith("cogging._core")), None)


def fields_of_basis(basis: Any) -> dict[str, Any]:
    """Return what makes a SplineHarmonics but for its number of control points, as `[cogging]` of a model file."""
    spline = basis.spline
    terms = {"harmonics": list(basis.harmonics)} if basis.harmonics else {"periods": list(basis.periods)}
    return {"pitch": basis.pitch or spline.pitch, **terms, "order": spline.order, "origin": spline.origin}


def _parts(value: Any) -> Any:
    """Return the arguments that make an object of the core, by name, or its parameter struct, which is the only one."""
    kind = _core_class(value)
    if kind is _core.SplineHarmonics:
        return {**fields_of_basis(value), "control_points": value.spline.control_points}
    if kind is _core.Sampled:
        names = {"time": "time", "position": "reference"}
        names |= {name: f"reference_{name}" for name in ("velocity", "acceleration")}
        return {name: value.samples[column] for name, column in names.items()}
    if kind.__name__ in DEFINING:
        return {name: getattr(value, name) for name in DEFINING[kind.__name__]}
    return value.to_dict() if hasattr(kind, "FIELDS") else value.parameters


def _equal(self: Any, other: object) -> bool:
    kind = _core_class(self)
    if _core_class(other) is not kind:
        return NotImplemented  # type: ignore[no-any-return]
    if hasattr(kind, "__setstate__"):  # a controller has learned
        return same(self.__getstate__(), other.__getstate__())
    return same(_parts(self), _parts(other))


def _reduce(self: Any) -> Any:
    return _rebuild, (type(self), _parts(self))


def _rebuild(kind: Any, parts: Any) -> Any:
    return kind(**parts) if isinstance(parts, dict) else kind(parts)


def _reduce_state(self: Any) -> Any:
    return copyreg.__newobj__, (type(self),), self.__getstate__()  # type: ignore[attr-defined]


def _refuse_pickle(self: Any) -> Any:
    kind = type(self)
    raise TypeError(f"cannot pickle '{kind.__module__}.{kind.__qualname__}' object")


class _Signature:
    """The signature of a class of the core, as the docstring of its constructor states it."""

    def __get__(self, _: object, kind: Any) -> inspect.Signature:
        line = (kind.__init__.__doc__ or "").partition("\n")[0]
        if not line.startswith("__init__(self"):  # that of a user's own subclass
            raise AttributeError("__signature__")
        line = re.sub(
            r'typing\.Annotated\[numpy\.typing\.ArrayLike[^"]*"[^"]*"\]|numpy\.typing\.ArrayLike', "numpy.ndarray", line
        )
        space: dict[str, Any] = {"typing": typing, "collections": collections, "numpy": np, "inf": math.inf}
        space["cogging"] = importlib.import_module("cogging")
        exec(compile(f"def {line}: ...", "signature", "exec", dont_inherit=True), space)
        found = inspect.signature(space["__init__"])
        return found.replace(parameters=list(found.parameters.values())[1:], return_annotation=inspect.Signature.empty)


def _example(kind: Any) -> str:
    name = kind.__name__
    arguments, use = EXAMPLES.get(name, ""), "model.replace(effects=[parameters]), move"
    if isinstance(arguments, tuple):
        arguments, use = arguments
    elif not arguments:
        arguments = next(f"{key}=0.01" for key, role in kind.ROLES.items() if role["role"] == "amplitude")
    part = "effects." if hasattr(kind, "ROLES") else ""
    return f">>> parameters = cogging.{part}{name}({arguments})\n    >>> log = cogging.simulate({use})"


def as_values() -> None:
    """Give the classes of the core equality, repr, copies, pickles, a signature and an example.

    Every class gets a `__reduce__`, if only one that refuses: Python's default for protocols 0 and 1 would create an
    uninitialised pybind11 object, which ends the process.
    """
    for kind in (*vars(_core).values(), *vars(_core.effects).values()):
        if not isinstance(kind, type) or issubclass(kind, Exception):
            continue
        methods: dict[str, Any] = {"__signature__": _Signature()}
        if hasattr(kind, "ROLES") or kind.__name__ in EXAMPLES:
            methods["__doc__"] = f"{kind.__doc__}\n\nExample:\n    {_example(kind)}"
        if kind.__reduce__ is object.__reduce__:
            methods["__reduce__"] = _reduce_state if hasattr(kind, "__setstate__") else _refuse_pickle
        is_value = hasattr(kind, "FIELDS") or hasattr(kind, "parameters") or kind.__name__ in DEFINING
        if is_value and kind is not _core.CompiledController:  # the core compares that one: it alone sees its functions
            methods |= {"__eq__": _equal, "__repr__": lambda self: line_of(self, str), "__hash__": None}
            if not hasattr(kind, "__setstate__"):
                methods["__reduce__"] = _reduce
        for name, method in methods.items():
            setattr(kind, name, method)
