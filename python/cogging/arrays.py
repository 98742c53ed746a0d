"""Types of arrays, for annotations, and arrays of what a user gives."""

from __future__ import annotations

from typing import Any

import numpy as np
import numpy.typing as npt

FloatArray = npt.NDArray[np.float64]
IntArray = npt.NDArray[np.intp]
Mask = npt.NDArray[np.bool_]  # which rows, or entries, count
DEEPEST = 4  # lists in one another


def no_number_in(values: Any, depth: int = DEEPEST) -> list[Any]:
    """The first truth value or text in a number's place, alone in a list; an empty list where there is none.

    numpy makes 1 of True and 3.2 of "3.2": neither was meant as a number.
    """
    if isinstance(values, bool | np.bool_ | str | bytes):
        return [values]
    if isinstance(values, list | tuple):
        inner = (no_number_in(entry, depth - 1) for entry in values if type(entry) not in (float, int))
        return next(filter(None, inner), []) if depth else []
    if not hasattr(values, "__array__"):
        return []
    try:
        array = np.asarray(values)
    except Exception:  # whatever an object answers: it is told where it is made an array
        return []
    if array.dtype.kind in "bSU":
        return list(array.ravel()[:1].tolist())
    return no_number_in(array.ravel().tolist(), depth) if array.dtype.kind == "O" else []


def real_array(name: str, values: npt.ArrayLike) -> FloatArray:
    """An argument as an array of real numbers.

    Raises:
        ValueError: it is none, or holds a truth value, a text or a complex number.
    """
    try:
        found = no_number_in(values)
        if not found and not np.iscomplexobj(values):
            return np.asarray(values, dtype=np.float64)
    except (TypeError, ValueError):
        found = []
    got = f"{found[0]!r} among them" if found else type(values).__name__
    raise ValueError(f"{name}: must be real numbers, got {got}")
