"""Inverse dynamics with instruments: filtered forces against filtered motion, bias removed by a simulated run.

The idea of IDIM-IV (Janot, Vandanjon, Gautier 2014): the force that the model needs along the measured motion is
compared with the force that was applied, both through one low-pass filter; the instruments are the same columns along
a simulated, noise-free run, so that noise in the measured motion does not bias the fit. The forces are the core's.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
import numpy.typing as npt

from cogging._core import Predictor
from cogging.logs import Log
from cogging.model import Model
from cogging.parameters import Scales
from cogging.residuals import quiet

FloatArray = npt.NDArray[np.float64]


class InverseDynamics:
    """Residuals of the force balance along a motion, V: what acts less mass times acceleration, low-pass filtered.

    Args:
        log: measured; its steps may jitter by less than half a step.
        cutoff: of the filter, Hz; Butterworth's magnitude of fourth order, without phase.
        along: position (m), (n,), of another motion to take in place of the measured one: the instruments'.
    """

    def __init__(self, log: Log, *, cutoff: float, along: FloatArray | None = None) -> None:
        self.cutoff = cutoff
        self.sample_time = float(np.median(np.diff(log.time)))
        self.even = log.time[0] + self.sample_time * np.arange(
            int(np.floor((log.time[-1] - log.time[0]) / self.sample_time + 1e-6)) + 1
        )
        position = np.interp(self.even, log.time, log.position if along is None else along)
        # The command is held, not interpolated: the row before each even time.
        held = np.clip(np.searchsorted(log.time, self.even + 0.25 * self.sample_time, side="right") - 1, 0, None)
        self.command = log.command[held]
        smooth, velocity, acceleration = self._derivatives(position)
        self.middle_position = _middle(smooth)
        self.middle_velocity = _middle(velocity)
        self.acceleration = _middle(acceleration)
        self.predictor = Predictor(self.even, smooth, self.command)

    def of(self, models: Sequence[Model]) -> FloatArray:
        """Residuals (V) at the even times, (models, n)."""
        force = self.predictor.net_force(
            [quiet(model).plant() for model in models], self.middle_position, self.middle_velocity
        )
        mass = np.array([model.axis.mass for model in models])
        return self.filtered(force - mass[:, None] * self.acceleration)

    def filtered(self, rows: FloatArray) -> FloatArray:
        """The low-pass filter on rows (p, n)."""
        n = rows.shape[1]
        mirrored = np.concatenate([rows, rows[:, ::-1]], axis=1)
        spectrum = np.fft.rfft(mirrored) * self._gain(2 * n)
        return np.asarray(np.fft.irfft(spectrum, 2 * n)[:, :n])

    def _gain(self, length: int) -> FloatArray:
        frequency = np.fft.rfftfreq(length, self.sample_time)
        return np.asarray(1.0 / (1.0 + (frequency / self.cutoff) ** 8))

    def _derivatives(self, position: FloatArray) -> tuple[FloatArray, FloatArray, FloatArray]:
        # Position is filtered at five times the cut-off, so that what the common filter keeps is untouched.
        n = len(position)
        line = np.linspace(position[0], position[-1], n)
        rest = position - line
        odd = np.concatenate([rest, -rest[:0:-1]])  # odd about the ends: no jump there, nor in the slope
        frequency = np.fft.rfftfreq(len(odd), self.sample_time)
        spectrum = np.fft.rfft(odd) / (1.0 + (frequency / min(5.0 * self.cutoff, 0.4 / self.sample_time)) ** 8)
        turn = 2j * np.pi * frequency
        smooth = np.fft.irfft(spectrum, len(odd))[:n] + line
        velocity = np.fft.irfft(spectrum * turn, len(odd))[:n] + (position[-1] - position[0]) / (
            (n - 1) * self.sample_time
        )
        acceleration = np.fft.irfft(spectrum * turn**2, len(odd))[:n]
        return smooth, velocity, acceleration


def _middle(values: FloatArray) -> FloatArray:
    return np.asarray(np.append(0.5 * (values[:-1] + values[1:]), values[-1]))


def scales_of(log: Log, motion: InverseDynamics) -> Scales:
    """Sizes of a log from the filtered motion."""
    return Scales(
        force=float(np.sqrt(np.mean(log.command**2))) or 1.0,
        position=float(np.ptp(log.position)) or 1.0,
        velocity=float(np.abs(motion.middle_velocity).max()) or 1.0,
        acceleration=float(np.quantile(np.abs(motion.acceleration), 0.99)) or 1.0,
        time=float(log.time[-1] - log.time[0]),
        sample_time=motion.sample_time,
    )
