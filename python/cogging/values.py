"""What public values share: equality by content, a line that tells them apart, and their text where they have one."""

from __future__ import annotations

import dataclasses
from collections.abc import Mapping
from typing import Any

import numpy as np

SHOWN = 4  # entries of a list that are shown


class ByValue:
    """A result or a description: equal where all it holds is equal, shown in one line, printed as its text.

    It holds arrays and mappings, so that it has no hash.
    """

    __hash__ = None  # type: ignore[assignment]

    def __eq__(self, other: object) -> bool:
        if type(other) is not type(self):
            return NotImplemented
        return all(
            same(getattr(self, field.name), getattr(other, field.name))
            for field in dataclasses.fields(self)  # type: ignore[arg-type]
        )

    def __repr__(self) -> str:
        return f"{type(self).__name__}({self._brief()})"

    def __str__(self) -> str:
        text = getattr(self, "text", None)
        return str(text()) if callable(text) else repr(self)

    def _brief(self) -> str:
        """What stands between the brackets of the one line: the few numbers that matter, with their units."""
        fields = dataclasses.fields(self)  # type: ignore[arg-type]
        return ", ".join(f"{field.name}={brief(getattr(self, field.name))}" for field in fields if field.repr)


def same(one: Any, other: Any) -> bool:
    """Whether two values have the same type and content; numbers that are no number are equal to each other."""
    if isinstance(one, np.ndarray) or isinstance(other, np.ndarray):
        return type(one) is type(other) and _same_arrays(one, other)
    if isinstance(one, Mapping) and isinstance(other, Mapping):
        return one.keys() == other.keys() and all(same(value, other[key]) for key, value in one.items())
    if type(one) is type(other) and isinstance(one, list | tuple):
        return len(one) == len(other) and all(map(same, one, other))
    if dataclasses.is_dataclass(one) and type(one).__eq__ is not ByValue.__eq__:
        return type(one) is type(other) and same(vars(one), vars(other))
    return bool(one == other) or (one is not None and one != one and other != other)


def _same_arrays(one: np.ndarray[Any, Any], other: np.ndarray[Any, Any]) -> bool:
    numbers = one.dtype.kind == "f" and other.dtype.kind == "f"
    return one.shape == other.shape and bool(np.array_equal(one, other, equal_nan=numbers))


def brief(value: Any, unit: str = "") -> str:
    """A value in a few characters: six digits of a number, the shape of an array, the length of a long list."""
    unit = f" {unit}" if unit and unit != "1" else ""
    if isinstance(value, np.ndarray):
        return f"{' x '.join(map(str, value.shape))} array"
    if isinstance(value, bool) or value is None or isinstance(value, str):
        return repr(value)
    if isinstance(value, int | float | np.number):
        return f"{value:.6g}{unit}"
    return _brief_collection(value, unit)


def _brief_collection(value: Any, unit: str) -> str:
    if isinstance(value, Mapping):
        return f"{len(value)} of {{{', '.join(map(str, list(value)[:SHOWN]))}{', ...' * (len(value) > SHOWN)}}}"
    if not isinstance(value, list | tuple):
        return type(value).__name__
    if len(value) <= SHOWN and all(isinstance(entry, int | float | str | np.number) for entry in value):
        return f"[{', '.join(brief(entry) for entry in value)}]{unit}"
    return f"{len(value)} entries"
