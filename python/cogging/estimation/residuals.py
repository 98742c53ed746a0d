"""The residuals of a model along a log, which rows count, and how they are whitened by an autoregressive filter."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Protocol

import numpy as np

from cogging._core import EncoderParameters, NoiseParameters, Plant, autoregression, friction_slope_max, whiten
from cogging.arrays import FloatArray, IntArray, Mask
from cogging.logs.log import Log
from cogging.model.model import Model
from cogging.model.parameters import Scales


class Residuals(Protocol):
    """The residuals of models along one log, V, and which rows count."""

    log: Log

    @property
    def mask(self) -> FloatArray:
        """1 where a row counts, 0 where it does not, (n,)."""

    @property
    def scales(self) -> Scales:
        """Typical sizes of the log's quantities."""

    def of(self, models: Sequence[Model]) -> FloatArray:
        """Residuals (V) of each model, (models, n)."""


def quiet(model: Model) -> Model:
    """The model without quantiser and noise."""
    return model.replace(encoder=EncoderParameters(), noise=NoiseParameters())


def quiet_plant(model: Model) -> Plant:
    """The plant of a model without quantiser and noise."""
    return quiet(model).plant()


HALVES = (0.5 ** np.arange(10.0)).tolist()  # lengths of a step that are tried


def scales_of(log: Log, velocity: FloatArray, acceleration: FloatArray) -> Scales:
    """Typical sizes of the quantities of a log with these velocities (m/s) and accelerations (m/s^2)."""
    return Scales(
        force=float(np.sqrt(np.mean(log.command**2))) or 1.0,
        position=float(np.ptp(log.position)) or 1.0,
        velocity=float(np.abs(velocity).max()) or 1.0,
        acceleration=float(np.quantile(np.abs(acceleration), 0.99)) or 1.0,
        time=float(log.time[-1] - log.time[0]),
        sample_time=float(np.median(np.diff(log.time))),
    )


def steps_needed(model: Model, sample_time: float) -> int:
    """Runge-Kutta steps a sample so that the friction's slope at rest stays well inside the stable region."""
    width = model.axis.coulomb_width
    if width == 0.0:
        return 1
    rate = friction_slope_max(width) * model.axis.coulomb / model.axis.mass
    return int(np.clip(np.ceil(rate * sample_time), 1, 20))


START = 0.06  # s, omitted at the start and after a gap: earlier commands are unknown


def since(event: Mask, time: FloatArray) -> FloatArray:
    """Seconds since the last row with the event, 0 in such a row, infinite before the first, (n,)."""
    last = np.maximum.accumulate(np.where(event, np.arange(len(time)), -1))
    return np.where(last >= 0, time - time[np.maximum(last, 0)], np.inf)


BLOCK = 0.2  # s, length of the jackknife blocks: rows further apart are taken to be uncorrelated


@dataclass(frozen=True)
class Whitened:
    """Whitened residual and columns of one log, in units of the whitened residual's rms; rows that count only."""

    residual: FloatArray  # (n,)
    columns: FloatArray  # d residual / d parameter, (p, n)
    block: IntArray  # number of the block of each row, (n,)
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
