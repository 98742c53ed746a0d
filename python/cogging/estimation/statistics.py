"""What estimates are judged by: a quantile, a moving mean."""

from __future__ import annotations

import numpy as np

from cogging.arrays import FloatArray


def student(freedom: float, confidence: float = 0.95) -> float:
    """The two-sided quantile of Student's t; taken at 2 degrees of freedom where there are fewer."""
    from scipy.special import stdtrit

    return float(stdtrit(max(freedom, 2.0), 0.5 + 0.5 * confidence))


def moving_average(values: FloatArray, length: int) -> FloatArray:
    """Centred mean over `length` rows (odd from here), shorter at the ends."""
    half = length // 2
    if half == 0:
        return values
    total = np.concatenate([[0.0], np.cumsum(values)])
    rows = np.arange(len(values))
    first, last = np.maximum(rows - half, 0), np.minimum(rows + half + 1, len(values))
    return np.asarray((total[last] - total[first]) / (last - first))
