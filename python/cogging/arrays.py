"""Array types, checks of arrays that a user gives, least squares and correlation."""

from __future__ import annotations

from typing import Any

import numpy as np
import numpy.typing as npt

FloatArray = npt.NDArray[np.float64]
IntArray = npt.NDArray[np.intp]
Mask = npt.NDArray[np.bool_]  # which rows, or entries, count
DEEPEST = 4  # nested lists that are searched
SIGMAS_95 = 1.959963984540054  # half width of a 95 % interval of a normal variable, in standard deviations


def no_number_in(values: Any, depth: int = DEEPEST) -> list[Any]:
    """Return the first truth value or text where numbers belong (numpy would convert it); an empty list if none."""
    if isinstance(values, bool | np.bool_ | str | bytes):
        return [values]
    if isinstance(values, list | tuple):
        inner = (no_number_in(entry, depth - 1) for entry in values if type(entry) not in (float, int))
        return next(filter(None, inner), []) if depth else []
    if not hasattr(values, "__array__"):
        return []
    try:
        array = np.asarray(values)
    except Exception:  # any error of a foreign object: it is reported where the array is used
        return []
    if array.dtype.kind in "bSU":
        return list(array.ravel()[:1].tolist())
    return no_number_in(array.ravel().tolist(), depth) if array.dtype.kind == "O" else []


def real_array(name: str, values: npt.ArrayLike) -> FloatArray:
    """Return an argument as an array of floats; raise ValueError for truth values, texts and complex numbers."""
    try:
        found = no_number_in(values)
        if not found and not np.iscomplexobj(values):
            return np.asarray(values, dtype=np.float64)
    except (TypeError, ValueError):
        found = []
    got = f"{found[0]!r} among them" if found else type(values).__name__
    raise ValueError(f"{name}: must be real numbers, got {got}")


def least_squares(columns: FloatArray, row: FloatArray, rcond: float = 1e-12) -> FloatArray:
    """Return the weights (p,) of least norm with which columns (p, n), scaled to rms 1, best approximate a row (n,)."""
    matrix = np.ascontiguousarray(columns.T)
    size = np.sqrt(np.mean(matrix**2, axis=0))
    size[size == 0.0] = 1.0
    return np.asarray(np.linalg.lstsq(matrix / size, row, rcond=rcond)[0] / size)


def cross_correlation(row: FloatArray, other: FloatArray) -> FloatArray:
    """Return sum_k row_(k + lag) other_k for lags from 1 - m to n - 1, faster to import than scipy.signal.correlate."""
    from scipy.fft import irfft, next_fast_len, rfft

    length = len(row) + len(other) - 1
    padded = next_fast_len(length, real=True)
    return np.asarray(irfft(rfft(row, padded) * rfft(other[::-1], padded), padded)[:length])
