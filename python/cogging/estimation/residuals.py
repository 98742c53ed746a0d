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


START = 0.06  # s, omitted at the start and after a gap: earlier commands are unknown


def since(event: Mask, time: FloatArray) -> FloatArray:
    """Seconds since the last row with the event, 0 in such a row, infinite before the first, (n,)."""
    last = np.maximum.accumulate(np.where(event, np.arange(len(time)), -1))
    return np.where(last >= 0, time - time[np.maximum(last, 0)], np.inf)
