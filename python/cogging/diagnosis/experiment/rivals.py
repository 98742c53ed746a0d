"""Rivals: each effect of a result against each other name that its logs could not tell from it."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from cogging.diagnosis.result import Diagnosis
from cogging.diagnosis.thresholds import EXPERIMENT
from cogging.effects.effect import Effect, SplineKnots, Travel, kind_of
from cogging.files import FieldError
from cogging.model.model import Model, is_number
from cogging.shown import nearest, quoted

#: Changes of the axis that are named like effects, with the field of the axis.
CHANGES = {"mass_change": "mass", "viscous_change": "viscous", "coulomb_change": "coulomb"}


@dataclass(frozen=True)
class Found:
    """An effect of a result, with its parameters.

    Attributes:
        name: name of the effect, or of the change of the axis.
        terms: the effects that it consists of, the strongest first; none of a change.
        change: new / old - 1 of a change; else 0.
        alternatives: names that the logs could not tell from it.
        apart: standard deviations by which the logs of the result tell it from an alternative, where it says so.
    """

    name: str
    terms: tuple[Effect, ...]
    change: float
    alternatives: tuple[str, ...]
    apart: Mapping[str, float]

    def added_to(self, model: Model) -> Model:
        """The model with it."""
        if self.name not in CHANGES:
            return model.replace(effects=(*model.effects, *self.terms))
        field = CHANGES[self.name]
        return model.replace(axis=model.axis.replace(**{field: getattr(model.axis, field) * (1.0 + self.change)}))


def found_in(
    result: Diagnosis | Mapping[str, Any] | None, model: Model, vocabulary: Mapping[str, Effect]
) -> list[Found]:
    """The effects of a result.

    Args:
        result: a Diagnosis, or what its JSON holds; None: none.
        model: the given model of the result.
        vocabulary: effects by name, as they are when they do nothing.

    Raises:
        FieldError: a ValueError that names field, rule and value.
    """
    if result is None:
        return []
    document = result.to_dict() if isinstance(result, Diagnosis) else result
    entries = document.get("effects")
    if not isinstance(entries, list) or not all(isinstance(entry, Mapping) for entry in entries):
        raise FieldError("", "effects", f"must be the list of effects of a result of diagnose, got {quoted(entries)}")
    known = {*vocabulary, *CHANGES}
    return [_found(entry, number, model, vocabulary, known) for number, entry in enumerate(entries)]


def _found(
    entry: Mapping[str, Any], number: int, model: Model, vocabulary: Mapping[str, Effect], known: set[str]
) -> Found:
    place = f"effects[{number}]"
    name, others = entry.get("name"), entry.get("alternatives", [])
    if name not in known:
        raise FieldError(
            place, "name", f"must be an effect of the vocabulary, got {quoted(name)}{nearest(str(name), known)}"
        )
    if not isinstance(others, list) or not all(other in known for other in others):
        raise FieldError(place, "alternatives", f"must be names of the vocabulary, got {quoted(others)}")
    tables = [entry.get("parameters", {}), *entry.get("further", [])]
    apart = {k: float(v) for k, v in dict(entry.get("apart") or {}).items() if is_number(v)}
    alternatives = tuple(other for other in others if other != name)
    if name in CHANGES:
        return Found(name, (), _change(tables[0], place), alternatives, apart)
    terms = tuple(_effect(vocabulary[name], table, model, place) for table in tables)
    return Found(name, terms, 0.0, alternatives, apart)


def _change(table: Any, place: str) -> float:
    """The relative change of a parameter.

    Raises:
        FieldError: there is none, or one below -1.
    """
    change = _values(table, place).get("change")
    if not isinstance(change, float) or change <= -1.0:
        raise FieldError(f"{place}.parameters", "change", f"must be a number above -1, got {quoted(change)}")
    return change


def _effect(law: Effect, table: Any, model: Model, place: str) -> Effect:
    """The effect with the parameters of a result, settings that it leaves out as diagnose has them.

    Raises:
        FieldError: a field that it has not, or a value that breaks its rule.
    """
    fields: dict[str, Any] = dict(_values(table, place))
    for name in fields:
        if name not in law.FIELDS:
            raise FieldError(f"{place}.parameters", name, f"is no field of {law.NAME}{nearest(name, law.FIELDS)}")
    low, high = (float(end) for end in model.axis.travel)
    knots, ends = kind_of(law, SplineKnots), kind_of(law, Travel)
    if knots is not None and np.isfinite([low, high]).all() and knots.pitch not in fields:
        lists = [len(value) for value in fields.values() if isinstance(value, list)]
        count = max(lists, default=EXPERIMENT.spline_order + 1)
        fields |= {
            knots.pitch: (high - low) / max(count - EXPERIMENT.spline_order + 1, 1),
            knots.order: EXPERIMENT.spline_order,
            knots.origin: low,
        }
    if ends is not None and np.isfinite([low, high]).all():
        fields[ends.ends] = [low, high]
    try:
        return law.replace(**fields)
    except (TypeError, ValueError) as error:
        raise FieldError(place, "parameters", str(error)) from None


def _values(table: Any, place: str) -> dict[str, float | list[float]]:
    """Values of parameters by field; those that are not known are left out.

    Raises:
        FieldError: a parameter without a number.
    """
    if not isinstance(table, Mapping):
        raise FieldError(place, "parameters", f"must be a table, got {quoted(table)}")
    values: dict[str, float | list[float]] = {}
    for name, told in table.items():
        value = told.get("value") if isinstance(told, Mapping) else told
        if value is None:
            continue
        if isinstance(value, list) and value and all(map(is_number, value)):
            values[name] = [float(one) for one in value]
        elif is_number(value):
            values[name] = float(value)
        else:
            raise FieldError(f"{place}.parameters", name, f"must have a number as its value, got {quoted(value)}")
    return values


def with_others(model: Model, found: Sequence[Found], one: Found) -> Model:
    """The model with all that was found but one."""
    for other in found:
        if other is not one:
            model = other.added_to(model)
    return model
