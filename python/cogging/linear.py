"""Linear least squares in which units do not matter."""

from __future__ import annotations

import numpy as np

from cogging.arrays import FloatArray


def least_squares(columns: FloatArray, row: FloatArray, rcond: float = 1e-12) -> FloatArray:
    """Weights (p,) of columns (p, n) that make a row (n,), of all such the smallest.

    Args:
        columns: are scaled to unit rms first.
        row: what they are to make.
        rcond: directions of the scaled columns with a singular value below this share of the largest weigh nothing.
    """
    matrix = np.ascontiguousarray(columns.T)
    size = np.sqrt(np.mean(matrix**2, axis=0))
    size[size == 0.0] = 1.0
    return np.asarray(np.linalg.lstsq(matrix / size, row, rcond=rcond)[0] / size)
