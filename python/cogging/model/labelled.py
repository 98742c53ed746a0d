"""A result in the units of a model: the labels of its numbers, and the units in its sentences."""

from __future__ import annotations

import dataclasses
from collections.abc import Iterable, Mapping
from typing import Any, TypeVar, cast

from cogging.model.units import Units

Result = TypeVar("Result")
#: Fields that hold a unit alone.
UNIT_FIELDS = ("unit",)
#: Fields that hold a name that must be found again, and no words.
NAME_FIELDS = ("name", "names", "alternative", "alternatives", "candidates", "parameter", "path", "verdict", "type")


def labelled(result: Result, units: Units, keep: Iterable[str] = (), *, apart: Iterable[str] = ()) -> Result:
    """A result, freshly made in V and m, with its units and sentences in the labels of a model.

    What it is made of is gone through: dataclasses, tuples, lists and mappings; a field `unit` is a unit, a field
    `units` is what the result writes its own numbers with, every other text is a sentence, and a name stays. Models,
    arrays and numbers stay as they are. To be done once: a label may itself be made of m.

    Args:
        result: of dataclasses, as every result of this package.
        units: those of the model; V and m give the result back as it is.
        keep: names of a user's in its sentences, such as those of logs.
        apart: fields of the result that stay as they are.
    """
    if units == Units():
        return result
    held, names, told = set(apart), tuple(keep), _of(result)
    now = {key: _field(key, told[key], units, names) for key in told if key not in held}
    return cast(Result, _with(result, told, now))


def _labelled(value: Any, units: Units, keep: tuple[str, ...]) -> Any:
    if isinstance(value, str):
        return units.in_words(value, keep)
    if isinstance(value, Mapping):
        return {key: _field(key, entry, units, keep) for key, entry in value.items()}
    if type(value) in (tuple, list):
        return type(value)(_labelled(entry, units, keep) for entry in value)
    # What can replace its own fields, as a model can, holds what a user said.
    if dataclasses.is_dataclass(value) and not isinstance(value, type) and not hasattr(value, "replace"):
        told = _of(value)
        return _with(value, told, {key: _field(key, entry, units, keep) for key, entry in told.items()})
    return value


def _of(value: Any) -> dict[str, Any]:
    return {field.name: getattr(value, field.name) for field in dataclasses.fields(value) if field.init}


def _with(value: Any, was: Mapping[str, Any], now: Mapping[str, Any]) -> Any:
    changed = {key: entry for key, entry in now.items() if entry is not was[key]}
    return dataclasses.replace(value, **changed) if changed else value


def _field(name: Any, value: Any, units: Units, keep: tuple[str, ...]) -> Any:
    if isinstance(value, Units):
        return units
    if name in UNIT_FIELDS and isinstance(value, str):
        return units.of(value)
    return value if name in NAME_FIELDS else _labelled(value, units, keep)
