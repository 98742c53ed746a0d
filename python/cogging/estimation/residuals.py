"""The residuals of a model along a log, and which rows count."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Protocol

import numpy as np

from cogging._core import EncoderParameters, NoiseParameters, Plant, friction_slope_max
from cogging.arrays import FloatArray, Mask
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


def steps_needed(model: Model, sample_time: float) -> int:
    """Runge-Kutta steps a sample so that the friction's slope at rest stays well inside the stable region."""
    width = model.axis.coulomb_width
    if width == 0.0:
        return 1
    rate = friction_slope_max(width) * model.axis.coulomb / model.axis.mass
    return int(np.clip(np.ceil(rate * sample_time), 1, 20))


SETTLED = 6.0  # time constants after which the observer has forgotten its initial error (7 exp(-6) remains)
START = 0.06  # s, omitted at the start and after a gap: earlier commands are unknown


def settling(still: Mask, time: FloatArray, velocity: FloatArray, rest: float, bandwidth: float) -> FloatArray:
    """Time that must pass since the last row at rest before each row counts, s, (n,).

    Friction below `rest` is unknown. At an acceleration a it acts for 2 rest / a and leaves a speed error that the
    observer forgets as (1 + s) exp(-s) over s time constants. The wait leaves as much of it as SETTLED time constants
    leave of a force that acted for one time constant or longer; it is at least one time constant.
    """
    constant = 1.0 / (2.0 * np.pi * bandwidth)
    last = np.maximum(np.maximum.accumulate(np.where(still, np.arange(len(time)), -1)), 0)
    starts = np.unique(last)
    ahead = np.minimum(np.searchsorted(time, time[starts] + 0.5 * SETTLED * constant), len(time) - 1)
    acceleration = np.abs(velocity[ahead] - velocity[starts]) / np.maximum(time[ahead] - time[starts], 1e-300)
    acted = 2.0 * rest / np.maximum(np.maximum(acceleration * constant, 2.0 * rest), 1e-300)
    waits = np.linspace(1.0, SETTLED, 51)
    left = (1.0 + waits) * np.exp(-waits)
    needed = np.interp(-left[-1] / np.maximum(acted, 1e-12), -left, waits)  # np.interp needs increasing abscissae
    return np.asarray(constant * needed[np.searchsorted(starts, last)])


def since(event: Mask, time: FloatArray) -> FloatArray:
    """Seconds since the last row with the event, 0 in such a row, infinite before the first, (n,)."""
    last = np.maximum.accumulate(np.where(event, np.arange(len(time)), -1))
    return np.where(last >= 0, time - time[np.maximum(last, 0)], np.inf)
