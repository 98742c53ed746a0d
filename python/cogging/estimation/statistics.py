"""What estimates are judged by: a quantile, weights of columns, a moving mean."""

from __future__ import annotations

import numpy as np

from cogging.arrays import FloatArray


def least_squares(columns: FloatArray, row: FloatArray, rcond: float = 1e-10) -> FloatArray:
    """Weights (p,) of columns (p, n) that make a row (n,), scaled so that units do not matter."""
    size = np.sqrt(np.einsum("ij,ij->i", columns, columns))
    size[size == 0.0] = 1.0
    scaled = columns / size[:, None]
    return np.asarray(np.linalg.pinv(scaled @ scaled.T, rcond=rcond, hermitian=True) @ (scaled @ row) / size)


def moving_average(values: FloatArray, length: int) -> FloatArray:
    """Centred mean over `length` rows (odd from here), shorter at the ends."""
    half = length // 2
    if half == 0:
        return values
    total = np.concatenate([[0.0], np.cumsum(values)])
    rows = np.arange(len(values))
    first, last = np.maximum(rows - half, 0), np.minimum(rows + half + 1, len(values))
    return np.asarray((total[last] - total[first]) / (last - first))
