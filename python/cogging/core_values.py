"""Objects of the core as values: equal by content, shown in one line with units, copied and pickled whole.

Each class says what it is made of: its parameters, or the properties below. A controller is also what it has learned,
which the core keeps and gives back. None of them has a hash.
"""

from __future__ import annotations

import copyreg
from collections.abc import Callable
from typing import Any

from cogging import _core
from cogging.values import brief, same

#: Gives the label of a unit of this package, of V and m.
UnitOf = Callable[[str], str]
#: Properties that make an object, by class, with the unit of those that are shown.
MADE_OF = {
    "BSpline": {"order": "", "origin": "m", "pitch": "m", "control_points": ""},
    "SplineHarmonics": {"pitch": "m", "harmonics": "", "periods": "m", "spline": ""},
    "CoggingModel": {"basis": "", "sine": "V", "cosine": "V"},
    "Plant": {"axis": "", "cogging": "", "effects": "", "encoder": "", "noise": ""},
    "Performance": {
        "error_max": "m",
        "error_rms": "m",
        "error_final_max": "m",
        "command_rms": "V",
        "command_change_rms": "V",
        "command_chatter": "",
    },
    "Sampled": {"samples": ""},
}


def _parts(value: Any) -> Any:
    """What an object is made of, for comparison."""
    kind = _kind(value)
    if kind.__name__ in MADE_OF:
        return [getattr(value, name) for name in MADE_OF[kind.__name__]]
    if hasattr(kind, "FIELDS"):
        return value.to_dict()
    return value.__getstate__() if hasattr(kind, "sample_rate") else value.parameters


def _kind(value: Any) -> Any:
    """The class of the core that an object is of, also where a user's class stands before it."""
    return next((one for one in type(value).__mro__ if one.__module__.startswith("cogging._core")), None)


def _equal(self: Any, other: object) -> bool:
    if _kind(other) is not _kind(self):
        return NotImplemented  # type: ignore[no-any-return]
    return same(_parts(self), _parts(other))


def _fields(struct: Any, of: UnitOf) -> str:
    """The fields of a parameter struct that are not its defaults, with their units."""
    kind = _kind(struct)
    values, usual = struct.to_dict(), kind().to_dict()
    shown = [
        f"{name}={brief(value, of(kind.FIELDS[name][0]))}"
        for name, value in values.items()
        if not same(value, usual[name]) or len(values) == 1
    ]
    return ", ".join(shown)


def line_of(value: Any, of: UnitOf) -> str:
    """An object of the core in one line; `of` gives the label of a unit (Units.of of a model)."""
    kind = _kind(value)
    name = kind.__name__
    if hasattr(kind, "FIELDS"):
        return f"{name}({_fields(value, of)})"
    if hasattr(kind, "parameters"):
        return f"{name}({_fields(value.parameters, of)})"
    return f"{name}({_LINES.get(name, _of_properties)(value, of)})"


def _shown(self: Any) -> str:
    return line_of(self, str)


def _of_properties(value: Any, of: UnitOf) -> str:
    named = MADE_OF[_kind(value).__name__]
    return ", ".join(f"{name}={brief(getattr(value, name), of(unit))}" for name, unit in named.items())


def _basis_line(basis: Any, of: UnitOf) -> str:
    if basis.harmonics:
        which = f"harmonics {brief(list(basis.harmonics))} of {basis.pitch:g} {of('m')}"
    else:
        which = f"periods {brief(list(basis.periods), of('m'))}"
    spline = basis.spline
    if spline.control_points == 1:
        return which
    return f"{which}, {spline.control_points} control points of order {spline.order} from {spline.origin:g} {of('m')}"


def _cogging_line(model: Any, of: UnitOf) -> str:
    largest = max(float(abs(model.sine).max()), float(abs(model.cosine).max()))
    return f"{_basis_line(model.basis, of)}, amplitudes up to {largest:.4g} {of('V')}"


def _plant_line(plant: Any, of: UnitOf) -> str:
    told = [f"mass {plant.axis.mass:.6g} {of('V/(m/s^2)')}"]
    if plant.cogging is not None:
        told.append(f"cogging of {plant.cogging.basis.terms} terms")
    return ", ".join([*told, *(effect.NAME for effect in plant.effects)])


def _sampled_line(motion: Any, of: UnitOf) -> str:
    times = motion.samples["time"]
    return f"{len(times)} samples from {times[0]:.6g} to {times[-1]:.6g} s"


_LINES = {
    "SplineHarmonics": _basis_line,
    "CoggingModel": _cogging_line,
    "Plant": _plant_line,
    "Sampled": _sampled_line,
}


def _remade(kind: Any, parts: Any) -> Any:
    """An object of the core from what _reduced kept of it."""
    if kind is _core.SplineHarmonics:
        spline = parts["spline"]
        wanted = {name: parts[name] for name in ("harmonics", "periods") if parts[name]}
        pitch = parts["pitch"] if parts["pitch"] > 0.0 else spline.pitch
        return kind(
            pitch=pitch, order=spline.order, origin=spline.origin, control_points=spline.control_points, **wanted
        )
    if kind is _core.Sampled:
        columns = parts["samples"]
        return kind(*(columns[name] for name in ("time", "reference", "reference_velocity", "reference_acceleration")))
    if kind is _core.Plant:
        return kind(parts.pop("axis"), **parts)
    return kind(parts) if hasattr(kind, "parameters") else kind(**parts)


def _reduced(self: Any) -> Any:
    kind = type(self)
    if hasattr(kind, "parameters"):
        return _remade, (kind, self.parameters)
    if hasattr(kind, "FIELDS"):
        return _remade, (kind, self.to_dict())
    return _remade, (kind, {name: getattr(self, name) for name in MADE_OF[kind.__name__]})


def _restated(self: Any) -> Any:
    return copyreg.__newobj__, (type(self),), self.__getstate__()  # type: ignore[attr-defined]


def _refused(self: Any) -> Any:
    kind = type(self)
    raise TypeError(f"cannot pickle '{kind.__module__}.{kind.__qualname__}' object")


def as_values() -> None:
    """Let the classes of the core be compared, shown, copied and pickled.

    Each is told how it is pickled, or that it is not: Python's own way for protocols 0 and 1 would make a bare object
    of pybind11, which ends the process.
    """
    for kind in (*vars(_core).values(), *vars(_core.effects).values()):
        if not isinstance(kind, type) or issubclass(kind, Exception):
            continue
        if kind.__reduce__ is object.__reduce__:
            setattr(kind, "__reduce__", _restated if hasattr(kind, "__setstate__") else _refused)  # noqa: B010
        if kind is _core.CompiledController:
            continue  # this one is compared by the core, which alone sees its functions
        struct, parameters = hasattr(kind, "FIELDS"), hasattr(kind, "parameters")
        if not (struct or parameters or kind.__name__ in MADE_OF):
            continue
        setattr(kind, "__eq__", _equal)  # noqa: B010 - mypy knows these classes as they are bound
        setattr(kind, "__repr__", _shown)  # noqa: B010
        setattr(kind, "__hash__", None)  # noqa: B010
        if not hasattr(kind, "__setstate__"):
            setattr(kind, "__reduce__", _reduced)  # noqa: B010
