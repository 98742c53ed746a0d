"""What a model leaves unexplained of a log, row by row, in force units; and the plant that is expected of a model."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Protocol

import numpy as np

from cogging._core import EncoderParameters, NoiseParameters, Plant, friction_slope_max
from cogging.arrays import FloatArray
from cogging.logs.log import Log
from cogging.model.model import Model
from cogging.model.parameters import Scales


class Residuals(Protocol):
    """One log seen by models: rows that count, and what each model leaves unexplained of them, V."""

    log: Log

    @property
    def mask(self) -> FloatArray:
        """1 where a row counts, 0 where it does not, (n,)."""

    @property
    def scales(self) -> Scales:
        """Sizes of the log."""

    def of(self, models: Sequence[Model]) -> FloatArray:
        """Residuals (V) of each model, (models, n)."""


def quiet(model: Model) -> Model:
    """The model without quantiser and noise: what is expected of it."""
    return model.replace(encoder=EncoderParameters(), noise=NoiseParameters())


def quiet_plant(model: Model) -> Plant:
    """The plant of a model without quantiser and noise: what predicts."""
    return quiet(model).plant()


def steps_needed(model: Model, sample_time: float) -> int:
    """Runge-Kutta steps a sample so that the friction's slope at rest stays well inside the stable region."""
    width = model.axis.coulomb_width
    if width == 0.0:
        return 1
    rate = friction_slope_max(width) * model.axis.coulomb / model.axis.mass
    return int(np.clip(np.ceil(rate * sample_time), 1, 20))
