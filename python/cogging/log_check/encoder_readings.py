"""The step of an encoder and single outliers, from its readings."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from cogging.arrays import FloatArray

READINGS = 200_000  # used at most
OFF_GRID = 0.1  # of the quantum: tolerance of a multiple
PRIMES = (2, 3, 5, 7, 11, 13, 17, 19, 23, 29, 31, 37, 41, 43, 47)


def encoder_quantum(position: npt.ArrayLike) -> float:
    """The step (m) of which readings (n,) are multiples, within a tenth for 99 % of neighbouring levels; 0 if none is.

    It is the resolution of the file if that is coarser than the encoder.
    """
    levels = np.unique(np.asarray(position, dtype=np.float64)[:READINGS])
    differences = np.diff(levels)
    smallest = 64.0 * np.finfo(float).eps * float(np.abs(levels).max(initial=0.0))
    differences = differences[differences > smallest]
    if differences.size < 10:
        return 0.0
    quantum = float(np.quantile(differences, 0.01, method="lower"))
    for _ in range(60):
        near = differences[np.abs(differences - quantum) < 0.5 * quantum]
        quantum = _refined(differences, float(np.quantile(near, 0.5, method="lower")) if near.size > 10 else quantum)
        multiples = np.maximum(np.round(differences / quantum), 1.0)
        if np.mean(np.abs(differences - multiples * quantum) > OFF_GRID * quantum) <= 0.01:
            quantum = _refined(levels - levels[0], quantum * _common_factor(multiples))
            counts = (levels - levels[0]) / quantum
            return quantum if np.mean(np.abs(counts - np.round(counts)) < 2.5 * OFF_GRID) > 0.95 else 0.0
        left = np.abs(differences - np.round(differences / quantum) * quantum)
        left = left[left > OFF_GRID * quantum]
        quantum = float(np.quantile(left, 0.01, method="lower")) if left.size else 0.0
        if quantum <= smallest:
            return 0.0
    return 0.0


def _common_factor(multiples: FloatArray) -> int:
    """The largest number that divides nearly all multiples."""
    factor = 1
    for prime in PRIMES:
        while np.mean(np.mod(multiples, prime) == 0.0) > 0.99:
            multiples = multiples / prime
            factor *= prime
    return factor


def _refined(distance: FloatArray, quantum: float) -> float:
    """The quantum by least squares over increasing distances, so that the count of multiples stays certain."""
    reach = 10.0 * quantum
    while True:
        near = distance[distance <= reach]
        multiples = np.round(near / quantum)
        sure = (np.abs(near / quantum - multiples) < 2.5 * OFF_GRID) & (multiples > 0.0)
        if sure.any():
            quantum = float(np.sum(near[sure] * multiples[sure]) / np.sum(multiples[sure] ** 2))
        if reach >= float(distance.max()):
            return quantum
        reach *= 3.0


SPIKE = 5.0  # times the changes around it: an outlier


def find_outliers(position: FloatArray) -> npt.NDArray[np.int64]:
    """Rows of single readings that deviate far more than the changes around them."""
    steps = np.diff(position)
    there, back = steps[1:-2], steps[2:-1]
    around = np.max(np.abs([steps[:-3], steps[3:], there + back]), axis=0)
    moved = np.abs(steps[steps != 0.0])
    floor = float(np.median(moved)) if moved.size else 0.0  # toggling of the last digit at rest is no outlier
    height = np.minimum(np.abs(there), np.abs(back))
    found = (np.sign(there) * np.sign(back) < 0.0) & (height > SPIKE * np.maximum(around, floor))
    return np.flatnonzero(found).astype(np.int64) + 2
