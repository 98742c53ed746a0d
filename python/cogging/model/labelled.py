"""A result in the units of a model: the labels of its numbers, and the units in its sentences."""

from __future__ import annotations

import dataclasses
from collections.abc import Iterable, Mapping
from typing import Any, TypeVar

from cogging.model.units import Units

Result = TypeVar("Result")
#: Fields that hold a unit alone.
UNIT_FIELDS = ("unit",)
#: Fields that hold a name that must be found again, and no words.
NAME_FIELDS = ("name", "names", "alternative", "alternatives", "candidates", "parameter", "path", "verdict", "type")


def labelled(result: Result, units: Units, keep: Iterable[str] = ()) -> Result:
    """A result, freshly made in V and m, with its units and sentences in the labels of a model.

    What it is made of is gone through: dataclasses, tuples, lists and mappings; a field `unit` is a unit, a field
    `units` is what the result writes its own numbers with, every other text is a sentence, and a name stays. Models,
    logs, arrays and numbers stay as they are. To be done once: a label may itself be made of m.

    Args:
        result: of dataclasses, as every result of this package.
        units: those of the model; V and m give the result back as it is.
        keep: names of a user's in its sentences, such as those of logs.
    """
    return result if units == Units() else _labelled(result, units, tuple(keep))


def _labelled(value: Any, units: Units, keep: tuple[str, ...]) -> Any:
    if isinstance(value, str):
        return units.in_words(value, keep)
    if isinstance(value, Mapping):
        return {key: _field(key, entry, units, keep) for key, entry in value.items()}
    if type(value) in (tuple, list):
        return type(value)(_labelled(entry, units, keep) for entry in value)
    # What holds a model, a log or a schema of fields of its own has no sentences of ours.
    if dataclasses.is_dataclass(value) and not isinstance(value, type) and not hasattr(value, "replace"):
        named = {field.name: getattr(value, field.name) for field in dataclasses.fields(value) if field.init}
        told = {name: _field(name, entry, units, keep) for name, entry in named.items()}
        changed = {name: entry for name, entry in told.items() if entry is not named[name]}
        return dataclasses.replace(value, **changed) if changed else value
    return value


def _field(name: Any, value: Any, units: Units, keep: tuple[str, ...]) -> Any:
    if isinstance(value, Units):
        return units
    if name in UNIT_FIELDS and isinstance(value, str):
        return units.of(value)
    return value if name in NAME_FIELDS else _labelled(value, units, keep)
