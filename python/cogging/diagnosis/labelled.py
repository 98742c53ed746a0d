"""A result of a diagnosis in the units of a model: its words are made in V and m, and put into its labels here.

Nothing else in the package does so: words are made once, with the units in hand (`Units.of`). What makes those of a
diagnosis anew is to do the same, and this file is to go with the last that uses it.
"""

from __future__ import annotations

import dataclasses
import re
from collections.abc import Iterable, Mapping
from typing import Any, TypeVar, cast

from cogging.model.units import Units

Result = TypeVar("Result")
#: V or m in a sentence, alone or with a prefix, with what it is divided by: no part of a file's name, a key, a formula.
IN_WORDS = re.compile(
    r"(?<![\w./\\=*·-])(?:1/)?\(?[kmunµ]?[Vm](?:\^?[23²³])?"
    r"(?:(?:/| per )(?:\([\w/ ^²]*\)(?:\^2|²)?|√?\w+(?:/s(?:\^2|²)?)?))?(?![\w\\=]|[./-]\w)"
)
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


def in_words(text: str, units: Units, keep: Iterable[str] = ()) -> str:
    """A sentence with each unit of V and m in it in these labels; names of a user's in it (`keep`) stay."""
    if units == Units():
        return text
    names = [re.escape(name) for name in sorted(keep, key=len, reverse=True) if name]
    parts = re.split(f"({'|'.join(names)})", text) if names else [text]
    return "".join(
        part if i % 2 else IN_WORDS.sub(lambda found: units.of(found[0]), part) for i, part in enumerate(parts)
    )


def _labelled(value: Any, units: Units, keep: tuple[str, ...]) -> Any:
    if isinstance(value, str):
        return in_words(value, units, keep)
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
