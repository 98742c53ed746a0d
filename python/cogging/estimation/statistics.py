"""Quantiles, moving means and the block jackknife."""

from __future__ import annotations

import itertools
from collections.abc import Iterator, Sequence

import numpy as np

from cogging.arrays import FloatArray, IntArray
from cogging.estimation.residuals import Whitened


def student(freedom: float, confidence: float = 0.95) -> float:
    """Two-sided quantile of Student's t, with at least 2 degrees of freedom."""
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


LOOSE = 1e-3  # component in an undetermined direction, above which a parameter is not determined
ALONE = 2.0  # variance ratio without a block, above which that block alone determines a parameter
SINGULAR = 1e-9  # of the largest eigenvalue of the scaled curvature: smaller ones are zero


def jackknife(logs: Sequence[Whitened]) -> tuple[FloatArray, FloatArray]:
    """Covariance (p, p) from leaving out one block of rows after the other, and its degrees of freedom (p,).

    A parameter that one block alone determines does not move when another is left out: it gets the covariance of white
    residuals, inflated as those of the other parameters are. What no row determines has an infinite variance.
    """
    whole = np.asarray(sum(log.columns @ log.columns.T for log in logs))
    if not len(whole):
        return whole, np.empty(0)
    size = np.sqrt(np.diag(whole))
    size[size == 0.0] = 1.0
    scaled = whole / np.outer(size, size)
    white = np.diag(np.linalg.pinv(scaled, rcond=SINGULAR, hermitian=True)).copy()
    hangs = np.zeros(len(size), dtype=bool)  # on one block alone
    shifts = []
    for log in logs:
        columns = log.columns / size[:, None]
        for curvature, right in shares_of_blocks(columns, columns, log.residual, log.block):
            without = np.linalg.pinv(scaled - curvature, rcond=SINGULAR, hermitian=True)
            shifts.append(without @ right)
            left = np.diag(without)  # smaller than with the block: no remaining row depends on it
            hangs |= (left > ALONE * white) | (left < 0.99 * white)
    covariance, freedom = spread_of(np.array(shifts) / size)
    white /= size**2
    usual = np.diag(covariance)[~hangs & (white > 0.0)] / white[~hangs & (white > 0.0)]
    floor = white * max(1.0, float(np.median(usual)) if len(usual) else 1.0)
    alone = np.flatnonzero(hangs)
    covariance[alone, :] = covariance[:, alone] = 0.0
    covariance[alone, alone] = floor[alone]
    freedom[alone] = max(len(shifts) - len(size), 1)
    values, vectors = np.linalg.eigh(scaled)
    open_to = np.abs(vectors[:, values < SINGULAR * max(values[-1], 1e-300)]).max(axis=1, initial=0.0)
    loose = np.flatnonzero(open_to > LOOSE)
    covariance[loose, loose] = np.inf
    return covariance, freedom


def shares_of_blocks(
    instruments: FloatArray, columns: FloatArray, residual: FloatArray, block: IntArray
) -> Iterator[tuple[FloatArray, FloatArray]]:
    """Contribution of each block of rows (n,) to Z^T columns, (p, p), and to Z^T residual, (p,).

    `instruments` are Z^T, (p, n), the columns themselves in least squares; the rows of a block follow each other.
    """
    edges = [*np.flatnonzero(np.diff(block, prepend=block[0] - 1)), len(block)]
    for first, last in itertools.pairwise(edges):
        part = instruments[:, first:last]
        yield part @ columns[:, first:last].T, part @ residual[first:last]


def spread_of(shifts: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Covariance (p, p) of values that shift by `shifts` (blocks, p) without each block, and its freedom (p,).

    The degrees of freedom are Satterthwaite's, of a sum of squares of unequal size.
    """
    table = shifts - shifts.mean(axis=0)
    blocks, p = table.shape
    sizes = np.abs(table).max(axis=0)
    parts = (table / np.where(sizes > 0.0, sizes, 1.0)) ** 2
    freedom = 3.0 * parts.sum(axis=0) ** 2 / np.maximum((parts**2).sum(axis=0), 1e-300)
    return np.asarray(table.T @ table * (blocks - 1) / blocks), np.clip(freedom, 1.0, max(blocks - p, 1))
