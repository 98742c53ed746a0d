"""The force balance of a model along a motion, both sides through one low-pass filter; the forces are the core's."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from cogging._core import Predictor
from cogging.arrays import FloatArray
from cogging.effects.effect import laws_of
from cogging.estimation.residuals import quiet_plant
from cogging.logs.log import Log
from cogging.logs.pauses import running_time
from cogging.model.model import Model
from cogging.model.parameters import DifferenceStep

JITTER = 0.01  # of the median step: logs that are evener than this take the command as it stands in the rows


@dataclass(frozen=True)
class Motion:
    """A smooth motion behind readings; entries (n,), the middle ones half-way to the next row.

    Attributes:
        position: m.
        middle_position: m.
        middle_velocity: mean over the interval, m/s.
        acceleration: mean over the interval, m/s^2.
    """

    position: FloatArray
    middle_position: FloatArray
    middle_velocity: FloatArray
    acceleration: FloatArray


class InverseDynamics:
    """Residuals of the force balance along a motion, V: what acts less mass times acceleration, low-pass filtered.

    The rows are those of an even grid with the log's median step: readings are interpolated, of commands the mean that
    acts over each step is taken. Long pauses are passed over in few rows, whatever their length (see running_time).
    A held command moves the axis in parabolas, which rows tell as a command that is smaller by (omega h)^2 / 12: the
    command enters as the rows show it. Effects that falsify the reading are taken out of it. Motor and load of an
    effect with states (backlash, flexible_mode) are taken as one body, and presliding as sliding: right only in steady
    motion.

    Args:
        log: measured, or simulated in its place.
        cutoff: of the filter, Hz; Butterworth's magnitude of fourth order, without phase.
        hold: s, for which a command was held, where the rows are further apart; None: from row to row.

    Raises:
        ValueError: the log's rows fill hardly any of its time.
    """

    def __init__(self, log: Log, *, cutoff: float, hold: float | None = None) -> None:
        self.cutoff, self.hold = cutoff, hold
        steps, running = np.diff(log.time), running_time(log.time)
        self.sample_time = float(np.median(steps))
        rows = int(np.floor((running[-1] - running[0]) / self.sample_time + 1e-6)) + 1
        even = running[0] + self.sample_time * np.arange(rows)
        if np.abs(steps - self.sample_time).max() <= JITTER * self.sample_time and rows == len(log):
            self.readings, self.command = log.position, log.command
        else:
            self.readings = np.interp(even, running, log.position)
            self.command = mean_held(running, log.command, even, self.sample_time)
        self.pauses = running is not log.time  # whether some were cut
        self.even = np.interp(even, running, log.time) if self.pauses else even
        self.motion = self._smooth(self.readings)
        self.lost = self._lost_between_rows(self.command)
        self.predictor = Predictor(self.even - log.time[0], self.motion.position, self.command)

    def of(self, models: Sequence[Model]) -> FloatArray:
        """Residuals (V) at the even times, (models, n)."""
        return self.filtered(self._unfiltered(models))

    def columns(self, model: Model, steps: Sequence[DifferenceStep]) -> tuple[FloatArray, FloatArray]:
        """Residual (V, (n,)) of a model, and its derivatives (p, n) over steps of its parameters.

        The filter is linear: it is asked of the differences, half as many.
        """
        table = self._unfiltered([model, *(side for step in steps for side in (step.above, step.below))])
        table[1 : len(steps) + 1] = (table[1::2] - table[2::2]) / np.array([step.span for step in steps])[:, None]
        filtered = self.filtered(table[: len(steps) + 1])
        return filtered[0], filtered[1:]

    def _unfiltered(self, models: Sequence[Model]) -> FloatArray:
        groups: dict[str, tuple[Motion, list[int]]] = {}
        for i, model in enumerate(models):
            falsifying = [effect for effect in model.effects if "reading" in effect.HOOKS]
            key = repr([(effect.NAME, effect.to_dict()) for effect in falsifying])
            if key not in groups:
                groups[key] = (self._behind(falsifying), [])
            groups[key][1].append(i)
        tables = []
        for motion, members in groups.values():
            plants = [quiet_plant(models[i]) for i in members]
            force = self.predictor.net_force(plants, motion.middle_position, motion.middle_velocity)
            for row, i in zip(force, members, strict=True):
                row -= models[i].axis.mass * motion.acceleration
                row -= self.lost
            tables.append(force)
        if not tables:
            return np.empty((0, len(self.even)))
        order = np.argsort([i for _, members in groups.values() for i in members])
        return tables[0] if len(tables) == 1 else np.concatenate(tables)[order]

    def filtered(self, rows: FloatArray, every: int = 1) -> FloatArray:
        """The low-pass filter on rows (p, n), or on such of every second (third, ...) time.

        Mirrored at both ends: of such rows the transform is that of cosines.
        """
        from scipy.fft import dct, idct, next_fast_len

        n = rows.shape[1]
        padded = np.pad(rows, ((0, 0), (0, next_fast_len(n, real=True) - n)), mode="edge")
        length = padded.shape[1]
        frequency = np.arange(length) / (2.0 * length * every * self.sample_time)
        spectrum = dct(padded, axis=1, overwrite_x=True)
        spectrum /= 1.0 + (frequency / self.cutoff) ** 8
        return np.asarray(idct(spectrum, axis=1, overwrite_x=True)[:, :n])

    def _lost_between_rows(self, command: FloatArray) -> FloatArray:
        """What of a held command the acceleration does not show that is taken from a band-limited motion, V, (n,).

        Held over steps h, u / M gives x = u / M (h^2 / 2) (z + 1) / (z - 1)^2 in the rows. The mean acceleration of the
        band-limited motion through these is (omega h / 2) cot(omega h / 2) u / M, z = exp(i omega h). Of every second
        row (third, ...) with the means of the commands the same is seen, h that for which each was held.
        """
        from scipy.fft import dct, idct

        steps = 1.0 if self.hold is None else min(self.hold / self.sample_time, 1.0)
        half = 0.5 * np.pi * steps * np.arange(len(command)) / len(command)  # omega h / 2, of the mirrored command
        shown = np.ones(len(half))
        shown[1:] = half[1:] / np.tan(half[1:])
        return np.asarray(idct((1.0 - shown) * dct(command)))

    def _behind(self, falsifying: Sequence[Any]) -> Motion:
        """The motion behind the readings."""
        if not falsifying:
            return self.motion
        position = self.readings
        for _ in range(3):  # x = reading - error(x), whose slope is far below 1
            error = sum(laws_of(effect).reading_at(position) - position for effect in falsifying)
            position = self.readings - error
        return self._smooth(position)

    def _smooth(self, position: FloatArray) -> Motion:
        from scipy.fft import next_fast_len

        # Filtered at five times the cut-off, so that what the common filter keeps is untouched.
        rows = len(position)
        position = np.pad(position, (0, next_fast_len(rows, real=True) + 1 - rows), mode="edge")
        n = len(position)
        line = np.linspace(position[0], position[-1], n)
        rest = position - line
        odd = np.concatenate([rest[:-1], -rest[:0:-1]])  # odd about the ends: no jump there, nor in the slope
        frequency = np.fft.rfftfreq(len(odd), self.sample_time)
        spectrum = np.fft.rfft(odd) / (1.0 + (frequency / min(5.0 * self.cutoff, 0.4 / self.sample_time)) ** 8)
        smooth = np.fft.irfft(spectrum, len(odd))[:n] + line
        velocity = np.fft.irfft(spectrum * (2j * np.pi * frequency), len(odd))[:n]
        smooth, velocity = smooth[:rows], velocity[:rows]  # the line's slope is constant: no acceleration
        # Over an interval the force is held: what it does is told by the means of velocity and acceleration.
        middle = np.append(0.5 * (smooth[:-1] + smooth[1:]), smooth[-1])
        return Motion(smooth, middle, _slope(smooth, self.sample_time), _slope(velocity, self.sample_time))


def mean_held(time: FloatArray, command: FloatArray, even: FloatArray, step: float) -> FloatArray:
    """Mean over each even step of a command that is held from its own time to the next."""
    total = np.concatenate([[0.0], np.cumsum(command[:-1] * np.diff(time))])
    edges = np.append(even, even[-1] + step)
    at_edges = np.interp(edges, time, total) + command[-1] * np.maximum(edges - time[-1], 0.0)
    return np.asarray(np.diff(at_edges) / step)


def _slope(values: FloatArray, step: float) -> FloatArray:
    slope = np.diff(values) / step
    return np.asarray(np.append(slope, slope[-1]))
