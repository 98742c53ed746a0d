"""Single readings that no axis can have made."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from cogging.arrays import FloatArray

SPIKE = 5.0  # times what happens around it: an implausible reading


def find_outliers(position: FloatArray) -> npt.NDArray[np.int64]:
    """Rows of single readings that leave and return by far more than anything around them."""
    if position.size < 5:
        return np.empty(0, dtype=np.int64)
    steps = np.diff(position)
    there, back = steps[1:-2], steps[2:-1]
    around = np.maximum(np.abs(steps[:-3]), np.abs(steps[3:]))
    around = np.maximum(around, np.abs(there + back))
    moved = np.abs(steps[steps != 0.0])
    floor = float(np.median(moved)) if moved.size else 0.0  # a flicker of the last digit at rest is no outlier
    height = np.minimum(np.abs(there), np.abs(back))
    found = (np.sign(there) * np.sign(back) < 0.0) & (height > SPIKE * np.maximum(around, floor))
    return np.flatnonzero(found).astype(np.int64) + 2
