"""Whiten residuals and the columns of a fit by an autoregressive filter."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from cogging._core import autoregression, whiten
from cogging.arrays import FloatArray
from cogging.estimation.residuals import Residuals

BLOCK = 0.2  # s, length of the jackknife blocks: rows further apart are taken to be uncorrelated


@dataclass(frozen=True)
class Whitened:
    """Whitened residual and columns of one log, in units of the whitened residual's rms; rows that count only."""

    residual: FloatArray  # (n,)
    columns: FloatArray  # d residual / d parameter, (p, n)
    block: npt.NDArray[np.int64]  # number of the block of each row, (n,)
    coefficients: FloatArray  # of the autoregressive filter
    rms: float  # of the whitened residual before division, V


def whitening_filter(log: Residuals, residual: FloatArray) -> FloatArray:
    """Autoregressive coefficients from the rows that count, with outliers clipped at 6 times the median size."""
    counted = np.abs(residual[log.mask > 0])
    if not len(counted):
        raise ValueError("log: must have rows in motion, got an axis that rests or keeps turning back")
    order = int(np.clip(round(0.02 / log.scales.sample_time), 12, 48))  # 20 ms of memory
    limit = 6.0 * 1.4826 * float(np.median(counted))
    clipped = np.clip(residual, -limit, limit) if limit > 0 else residual
    return np.asarray(autoregression(clipped, log.mask, order=order))


def whitened(log: Residuals, residual: FloatArray, columns: FloatArray) -> Whitened:
    """Whiten a residual and its columns, and keep the rows that count."""
    coefficients = whitening_filter(log, residual)
    table = np.asarray(whiten(np.vstack([residual[None, :], columns]), list(coefficients)))
    rows = log.mask > 0
    rms = float(np.sqrt(np.mean(table[0, rows] ** 2)))
    rms = rms if rms > 0 else 1.0
    block = np.floor(log.log.time[rows] / BLOCK).astype(np.int64)
    return Whitened(table[0, rows] / rms, table[1:, rows] / rms, block, coefficients, rms)
