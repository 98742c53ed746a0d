"""The parameters of a model as numbers by path, so that a fit can move them."""

from __future__ import annotations

import re
from collections import Counter
from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field
from functools import partial
from typing import Any

import numpy as np

from cogging._core import AxisParameters, CoggingModel
from cogging.calls import Kind, check_arguments
from cogging.effects.effect import Effect, Wave, kind_of
from cogging.model.model import Model
from cogging.model.units import Units

AXIS_FIELDS = ("mass", "viscous", "coulomb", "coulomb_width")


@dataclass(frozen=True)
class Parameter:
    """One number of a model.

    Attributes:
        path: where it stands: `axis.mass`, `cogging.sine[0][2]`, `effects.cable_spring.stiffness`; of effects that
            stand more than once `effects.cogging_harmonic[1].sine`, of lists `effects.end.levels[3]`.
        value: as the model has it.
        dimension: its unit in the terms of this package, of V and m.
        uncertainty: stated relative 1-sigma, or None.
        period: whether it is the period of a wave along the travel.
        units: labels of the model's units.
    """

    path: str
    value: float
    dimension: str
    uncertainty: float | None = None
    period: bool = False
    units: Units = field(default_factory=Units)

    @property
    def unit(self) -> str:
        """In the labels of the model."""
        return self.units.of(self.dimension)

    @property
    def positive(self) -> bool:
        """Whether it may not be negative: mass and friction of the axis."""
        return self.path.startswith("axis.")

    def clipped(self, value: float) -> float:
        """The nearest value to which one step of a fit may take the parameter.

        Mass and the width of friction, whose zero is no small change, fall to a tenth at most; viscous and Coulomb
        friction stop at zero.
        """
        if not self.positive:
            return float(value)
        return float(max(value, 0.1 * self.value if self.path in ("axis.mass", "axis.coulomb_width") else 0.0))


@dataclass(frozen=True)
class Scales:
    """What is large in a log: sizes against which a parameter's step or its error is judged.

    Attributes:
        force: rms command, V.
        position: travel, m.
        velocity: largest speed, m/s.
        acceleration: m/s^2, largest that lasts.
        time: duration, s.
        sample_time: s.
    """

    force: float
    position: float
    velocity: float
    acceleration: float
    time: float
    sample_time: float

    @classmethod
    def largest(cls, several: Iterable[Scales]) -> Scales:
        """The largest of each size over several logs, and the shortest sample time."""
        sizes = list(several)
        names = ("force", "position", "velocity", "acceleration", "time")
        return cls(
            **{name: max(getattr(s, name) for s in sizes) for name in names},
            sample_time=min(s.sample_time for s in sizes),
        )

    def of(self, unit: str) -> float:
        """The size that a parameter of this unit would have if its effect were as large as the command."""
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
            "1": 1.0,
        }
        return sizes.get(unit, 1.0)

    def step(self, parameter: Parameter) -> float:
        """A change of the parameter that is small against what it does, for a difference quotient."""
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
    """Every number of the model that a fit may move, by path: axis, cogging amplitudes, fields of the effects.

    With `together`, also what moves a harmonic's amplitudes along the whole travel as one: `cogging.sine[0][*]` adds to
    each control point (its value is their mean), `cogging.gain[0]` multiplies them, `cogging.phase[0]` (rad) turns
    them, `cogging.stretch[0]` lengthens the sines by what it shortens the cosines (relative), and `cogging.shear[0]`
    adds of each to the other.

    Args:
        model: any.
        together: also what moves the cogging as a whole, such as the gain and phase of a harmonic.

    Returns:
        Every number of the model that can be fitted, by its path.

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
    """The effects with their paths: the name, and its place among effects of that name where there are several."""
    effects = list(effects)
    total = Counter(effect.NAME for effect in effects)
    seen: Counter[str] = Counter()
    paths = []
    for effect in effects:
        place = f"[{seen[effect.NAME]}]" if total[effect.NAME] > 1 else ""
        paths.append((f"effects.{effect.NAME}{place}", effect))
        seen[effect.NAME] += 1
    return paths


def effect_at(model: Model, path: str) -> Effect:
    """The effect to which a path `effects.name.field`, `effects.name[i].field` or `effects.name.field[j]` belongs."""
    prefix, field = _effect_and_field(path)
    effect = dict(effect_paths(model.effects)).get(prefix)
    if effect is None or field not in effect.FIELDS:
        raise ValueError(f"{path}: must be a parameter of an effect of the model")
    return effect


def role_at(model: Model, path: str) -> Mapping[str, Any]:
    """What the core says of a field of an effect: its entry of ROLES (see cogging.effects)."""
    return effect_at(model, path).ROLES[_effect_and_field(path)[1]]


def role_of(model: Model, path: str) -> str:
    """What a parameter is to a search (see cogging.effects): "amplitude", "shape" or "setting"."""
    section, _, rest = path.partition(".")
    if section != "effects":
        return "shape" if rest == "coulomb_width" else "amplitude"
    return str(role_at(model, path)["role"])


def with_values(model: Model, values: Mapping[str, float]) -> Model:
    """A copy of the model with the numbers at these paths changed."""
    axis: dict[str, float] = {}
    tables: dict[str, Any] = {}
    effects: dict[int, dict[str, Any]] = {}
    prefixes = {prefix: i for i, (prefix, _) in enumerate(effect_paths(model.effects))}
    for path, value in values.items():
        section, _, rest = path.partition(".")
        if section == "axis" and rest in AXIS_FIELDS:
            axis[rest] = float(value)
        elif section == "cogging" and model.cogging is not None and _together(rest):
            _move_together(path, rest, value, model.cogging, tables)
        elif section == "cogging" and model.cogging is not None:
            name, row, column = _indexed(path, rest, 2)
            if name not in tables:
                tables[name] = np.array(getattr(model.cogging, name))
            tables[name][row, column] = value
        else:
            prefix, _, leaf = path.rpartition(".")
            if prefix not in prefixes:
                raise ValueError(
                    f"{path}: must be a parameter of the model, which has {', '.join(parameters_of(model))}"
                )
            place = prefixes[prefix]
            _change_effect(path, leaf, float(value), model.effects[place], effects.setdefault(place, {}))
    changed: dict[str, Any] = {}
    if axis:
        changed["axis"] = model.axis.replace(**axis)
    if tables and model.cogging is not None:
        changed["cogging"] = CoggingModel(
            model.cogging.basis, tables.get("sine", model.cogging.sine), tables.get("cosine", model.cogging.cosine)
        )
    if effects:
        changed["effects"] = tuple(
            effect.replace(**effects[i]) if i in effects else effect for i, effect in enumerate(model.effects)
        )
    return model.replace(**changed) if changed else model


def _effect_and_field(path: str) -> tuple[str, str]:
    prefix, _, leaf = path.rpartition(".")
    return prefix, leaf.partition("[")[0]


def _together(rest: str) -> bool:
    return rest.endswith("[*]") or rest.startswith(("gain[", "phase[", "stretch[", "shear["))


def _move_together(path: str, rest: str, value: float, cogging: CoggingModel, tables: dict[str, Any]) -> None:
    for name in ("sine", "cosine"):
        tables.setdefault(name, np.array(getattr(cogging, name)))
    if rest.endswith("[*]"):
        name, row = _indexed(path, rest.removesuffix("[*]"), 1)
        tables[name][row] += value - float(np.mean(getattr(cogging, name)[row]))
        return
    name, row = _indexed(path, rest, 1)
    waves = tables["sine"][row] + 1j * tables["cosine"][row]
    moved = {
        "gain": waves * value,
        "phase": waves * np.exp(1j * value),
        "stretch": waves + value * waves.conj(),
        "shear": waves + 1j * value * waves.conj(),
    }[name]
    tables["sine"][row], tables["cosine"][row] = moved.real, moved.imag


def _change_effect(path: str, leaf: str, value: float, effect: Any, changes: dict[str, Any]) -> None:
    """Put a number, or an entry of a list, among the changes of an effect."""
    if leaf.endswith("]"):
        name, index = _indexed(path, leaf, 1)
        changes.setdefault(name, list(getattr(effect, name)))[index] = value
    else:
        changes[leaf] = value


def _indexed(path: str, text: str, count: int) -> list[Any]:
    match = re.fullmatch(r"(\w+)" + r"\[(\d+)\]" * count, text)
    if match is None:
        raise ValueError(f"{path}: must be a parameter of the model")
    return [match.group(1), *(int(match.group(i + 2)) for i in range(count))]
