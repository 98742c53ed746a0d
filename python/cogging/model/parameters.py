"""Parameters of a model as numbers by path, for fits and difference quotients."""

from __future__ import annotations

import re
from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field
from functools import partial
from typing import Any, NamedTuple

import numpy as np

from cogging._core import AxisParameters, CoggingModel
from cogging.calls import Kind, check_arguments
from cogging.effects.effect import Effect, Wave, kind_of
from cogging.model.model import AXIS_FIELDS, Model
from cogging.model.units import Units

SECTIONS = ("encoder", "noise", "controller")  # of the model, whose numbers have paths but are not fitted


@dataclass(frozen=True)
class Parameter:
    """One number of a model."""

    #: `axis.mass`, `cogging.sine[0][2]`, `effects.cable_spring.stiffness`; of repeated effects
    #: `effects.cogging_harmonic[1].sine`, of lists `effects.end.levels[3]`.
    path: str
    value: float  # in the model
    dimension: str  # unit in V and m
    uncertainty: float | None = None  # stated relative 1-sigma
    period: bool = False  # whether it is the period of a wave along the travel
    units: Units = field(default_factory=Units)  # labels of the model's units

    @property
    def unit(self) -> str:
        """Unit in the labels of the model."""
        return self.units.of(self.dimension)

    @property
    def positive(self) -> bool:
        """Whether it cannot be negative: mass and friction of the axis."""
        return self.path.startswith("axis.")

    def clipped(self, value: float) -> float:
        """Return the nearest value that one step of a fit may reach: mass and the width of friction fall to a tenth."""
        if not self.positive:
            return float(value)
        return float(max(value, 0.1 * self.value if self.path in ("axis.mass", "axis.coulomb_width") else 0.0))


@dataclass(frozen=True)
class Scales:
    """Magnitudes in a log, to which a parameter's step or error is compared."""

    force: float  # rms command, V
    position: float  # travel, m
    velocity: float  # largest speed, m/s
    acceleration: float  # m/s^2, largest that lasts
    time: float  # duration, s
    sample_time: float  # s

    @classmethod
    def largest(cls, several: Iterable[Scales]) -> Scales:
        """Return the largest of each magnitude over several logs, and the shortest sample time."""
        sizes = list(several)
        names = ("force", "position", "velocity", "acceleration", "time")
        most = {name: max(getattr(one, name) for one in sizes) for name in names}
        return cls(**most, sample_time=min(one.sample_time for one in sizes))

    def of(self, unit: str) -> float:
        """Return the value of a parameter of this unit whose effect would be as large as the command."""
        sizes = {
            "V": self.force,
            "V/m": self.force / self.position,
            "V/(m/s)": self.force / self.velocity,
            "V/(m/s)^2": self.force / self.velocity**2,
            "V/(m/s^2)": self.force / self.acceleration,
            "m": self.position,
            "m/s": self.velocity,
            "s": self.time,
            "Hz": 1.0 / self.time,
        }
        return sizes.get(unit, 1.0)

    def step(self, parameter: Parameter) -> float:
        """Return a small change of the parameter for a difference quotient."""
        size = abs(parameter.value)
        if parameter.dimension == "s" and size < 0.2 * self.time:
            return max(0.02 * self.sample_time, 1e-3 * size)
        if parameter.period and 0.0 < size < self.position:
            return 1e-3 * size * size / self.position  # the phase at the far end moves by 1e-3 turns
        if parameter.dimension == "m":
            return 1e-3 * max(size, 1e-6 * self.position)
        if parameter.dimension == "Hz":
            return 1e-3 / self.time
        if parameter.dimension == "m/s":
            return 1e-3 * size if size > 0.0 else 1e-5 * self.velocity
        return 1e-3 * max(size, 0.1 * self.of(parameter.dimension))


@check_arguments(model=Kind((Model,), "a Model"))
def parameters_of(model: Model, *, together: bool = False) -> dict[str, Parameter]:
    """Return every number of the model that can be fitted, by path: axis, cogging amplitudes, fields of the effects.

    With `together`, also parameters that change a harmonic along the whole travel: `cogging.sine[0][*]` adds to each
    control point (its value is their mean), `cogging.gain[0]` multiplies them, `cogging.phase[0]` (rad) rotates them,
    `cogging.stretch[0]` increases the sines and decreases the cosines (relative), and `cogging.shear[0]` adds a share
    of each to the other.

    Example:
        >>> known = cogging.parameters_of(model)
        >>> print(known["axis.mass"].value, known["axis.mass"].unit, len(known))
        0.12 V/(m/s^2) 10
    """
    found: list[Parameter] = []
    new = partial(Parameter, units=model.units)
    for name in AXIS_FIELDS:
        unit = AxisParameters.FIELDS[name][0]
        found.append(new(f"axis.{name}", getattr(model.axis, name), unit, model.uncertainty.get(name)))
    if model.cogging is not None:
        for part in ("sine", "cosine"):
            for (row, column), value in np.ndenumerate(getattr(model.cogging, part)):
                found.append(new(f"cogging.{part}[{row}][{column}]", float(value), "V"))
    if together and model.cogging is not None:
        for row in range(len(model.cogging.sine)):
            for part in ("sine", "cosine"):
                mean = float(np.mean(getattr(model.cogging, part)[row]))
                found.append(new(f"cogging.{part}[{row}][*]", mean, "V"))
            found.append(new(f"cogging.gain[{row}]", 1.0, "1"))
            found += [new(f"cogging.{name}[{row}]", 0.0, "1") for name in ("phase", "stretch", "shear")]
    for prefix, effect in effect_paths(model.effects):
        wave = kind_of(effect, Wave)
        period = wave.shape if wave is not None and effect.ROLES[wave.shape]["quantity"] == "distance" else None
        for name, (unit, _) in effect.FIELDS.items():
            value = getattr(effect, name)
            if isinstance(value, list):
                found.extend(new(f"{prefix}.{name}[{i}]", float(v), unit) for i, v in enumerate(value))
            elif isinstance(value, float):
                found.append(new(f"{prefix}.{name}", value, unit, period=name == period))
    return {parameter.path: parameter for parameter in found}


def effect_paths(effects: Iterable[Effect]) -> list[tuple[str, Effect]]:
    """Return the effects with their paths: the name, and a number if there are several of that name."""
    effects = list(effects)
    names = [effect.NAME for effect in effects]
    places = [f"[{names[:i].count(name)}]" if names.count(name) > 1 else "" for i, name in enumerate(names)]
    return [(f"effects.{effect.NAME}{place}", effect) for effect, place in zip(effects, places, strict=True)]


def renamed_path(path: str, names: Mapping[str, str]) -> str:
    """Return the path of a parameter whose effect has another path, by `names`; "" if its effect is not among them."""
    if not path.startswith("effects."):
        return path
    owner = next((one for one in names if path == one or path.startswith(one + ".")), None)
    return "" if owner is None else names[owner] + path[len(owner) :]


def effect_at(model: Model, path: str) -> Effect:
    """Return the effect of a path `effects.name.field`, `effects.name[i].field` or `effects.name.field[j]`."""
    prefix, _, leaf = path.rpartition(".")
    effect = dict(effect_paths(model.effects)).get(prefix)
    if effect is None or leaf.partition("[")[0] not in effect.FIELDS:
        raise ValueError(f"{path}: must be a parameter of an effect of the model")
    return effect


def role_at(model: Model, path: str) -> Mapping[str, Any]:
    """Return the entry of ROLES of a field of an effect (see cogging.effects)."""
    return effect_at(model, path).ROLES[path.rpartition(".")[2].partition("[")[0]]


def role_of(model: Model, path: str) -> str:
    """Return the role of a parameter in a search (see cogging.effects): "amplitude", "shape" or "setting"."""
    section, _, rest = path.partition(".")
    if section != "effects":
        return "shape" if rest == "coulomb_width" else "amplitude"
    return str(role_at(model, path)["role"])


def with_values(model: Model, values: Mapping[str, float]) -> Model:
    """Return a copy of the model with the numbers at these paths changed."""
    effects = dict(effect_paths(model.effects))
    owners = {name: getattr(model, name) for name in ("axis", *SECTIONS)} | effects
    given: dict[str, dict[str, float]] = {}  # by what the path before the field names
    for path, value in values.items():
        owner, _, leaf = path.rpartition(".")
        given.setdefault(owner, {})[leaf] = value
    new: dict[str, Any] = {}
    for owner, fields in given.items():
        if owner == "cogging" and model.cogging is not None:
            new[owner] = _with_amplitudes(model.cogging, fields)
        elif owners.get(owner) is None or (owner == "axis" and not set(fields) <= set(AXIS_FIELDS)):
            known = ", ".join(parameters_of(model))
            raise ValueError(f"{owner}.{next(iter(fields))}: must be a parameter of the model, which has {known}")
        else:
            new[owner] = with_fields(owner, owners[owner], fields)
    if effects.keys() & new.keys():
        new["effects"] = tuple(new.pop(owner, effect) for owner, effect in effects.items())
    return model.replace(**new) if new else model


def with_fields(owner: str, struct: Any, values: Mapping[str, float]) -> Any:
    """Return a struct of the core, or an effect, with numbers changed by field; `levels[3]` is an entry of a list."""
    old, changes = struct.to_dict(), dict[str, Any]()
    for leaf, value in values.items():
        match = re.fullmatch(r"(\w+)(?:\[(\d+)\])?", leaf)
        if match is None:
            raise ValueError(f"{owner}.{leaf}: must be a parameter of the model")
        name, place = match.groups()
        present = old[name][int(place)] if place else old.get(name, 0.0)  # the struct refuses an unknown field
        if isinstance(present, int) and value != int(value):
            raise ValueError(f"{owner}.{leaf}: must be a whole number, got {value:g}")
        if place:
            changes.setdefault(name, list(old[name]))[int(place)] = type(present)(value)
        else:
            changes[name] = type(present)(value)
    return struct.replace(**changes)


def _with_amplitudes(cogging: CoggingModel, values: Mapping[str, float]) -> CoggingModel:
    tables = {"sine": np.array(cogging.sine), "cosine": np.array(cogging.cosine)}
    for leaf, value in values.items():
        match = re.fullmatch(r"(\w+)\[(\d+)\](?:\[(\d+|\*)\])?", leaf)
        if match is None:
            raise ValueError(f"cogging.{leaf}: must be a parameter of the model")
        name, row, column = match[1], int(match[2]), match[3]
        if column == "*":
            tables[name][row] += value - float(np.mean(getattr(cogging, name)[row]))
        elif column is not None:
            tables[name][row, int(column)] = value
        else:  # of the whole harmonic
            waves = tables["sine"][row] + 1j * tables["cosine"][row]
            moved = {
                "gain": waves * value,
                "phase": waves * np.exp(1j * value),
                "stretch": waves + value * waves.conj(),
                "shear": waves + 1j * value * waves.conj(),
            }[name]
            tables["sine"][row], tables["cosine"][row] = moved.real, moved.imag
    return CoggingModel(cogging.basis, tables["sine"], tables["cosine"])


class DifferenceStep(NamedTuple):
    """Two models that differ in one parameter: df/dp is approximately (f(above) - f(below)) / span."""

    above: Model  # the model on one side
    below: Model  # the model on the other side, or the given one
    span: float  # difference of the parameter; negative if only a step down is allowed


def central(model: Model, parameter: Parameter, step: float) -> DifferenceStep:
    """Return a step to both sides, or to one side if the other breaks the rule of the field."""
    ends = []
    for value in (parameter.value + step, parameter.value - step):
        try:
            ends.append((with_values(model, {parameter.path: value}), value))
        except ValueError:
            ends.append((model, parameter.value))
    (above, high), (below, low) = ends
    if not high > low:
        raise _no_step(parameter, step)
    return DifferenceStep(above, below, high - low)


def one_sided(model: Model, parameter: Parameter, step: float) -> DifferenceStep:
    """Return a step up from the model, or down if up breaks the rule of the field: exact for a linear function."""
    for signed in (step, -step):
        try:
            return DifferenceStep(with_values(model, {parameter.path: parameter.value + signed}), model, signed)
        except ValueError:
            continue
    raise _no_step(parameter, step)


def _no_step(parameter: Parameter, step: float) -> ValueError:
    return ValueError(
        f"{parameter.path}: must be able to move by {step:g} up or down for a derivative, got {parameter.value:g}"
    )
