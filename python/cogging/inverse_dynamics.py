"""Inverse dynamics with instruments: filtered forces against filtered motion, bias removed by a simulated run.

The idea of IDIM-IV (Janot, Vandanjon, Gautier 2014): the force that the model needs along the measured motion is
compared with the force that was applied, both through one low-pass filter; the instruments are the same columns along
a simulated, noise-free run, so that noise in the measured motion does not bias the fit. The forces are the core's.
"""

from __future__ import annotations

import itertools
from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from cogging._core import Predictor
from cogging.logs import Log
from cogging.model import Model
from cogging.parameters import Parameter, Scales, parameters_of, with_values
from cogging.residuals import START, quiet

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
        smooth, velocity = self._derivatives(position)
        self.middle_position = _middle(smooth)
        # Over an interval the force is held: what it does is told by the means of velocity and acceleration.
        self.middle_velocity = _slope(smooth, self.sample_time)
        self.acceleration = _slope(velocity, self.sample_time)
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
        padded = np.pad(rows, ((0, 0), (0, fast_length(n) - n)), mode="edge")
        mirrored = np.concatenate([padded, padded[:, ::-1]], axis=1)
        length = mirrored.shape[1]
        spectrum = np.fft.rfft(mirrored) * self._gain(length)
        return np.asarray(np.fft.irfft(spectrum, length)[:, :n])

    def _gain(self, length: int) -> FloatArray:
        frequency = np.fft.rfftfreq(length, self.sample_time)
        return np.asarray(1.0 / (1.0 + (frequency / self.cutoff) ** 8))

    def _derivatives(self, position: FloatArray) -> tuple[FloatArray, FloatArray]:
        # Position is filtered at five times the cut-off, so that what the common filter keeps is untouched.
        rows = len(position)
        position = np.pad(position, (0, fast_length(rows) + 1 - rows), mode="edge")
        n = len(position)
        line = np.linspace(position[0], position[-1], n)
        rest = position - line
        odd = np.concatenate([rest[:-1], -rest[:0:-1]])  # odd about the ends: no jump there, nor in the slope
        frequency = np.fft.rfftfreq(len(odd), self.sample_time)
        spectrum = np.fft.rfft(odd) / (1.0 + (frequency / min(5.0 * self.cutoff, 0.4 / self.sample_time)) ** 8)
        turn = 2j * np.pi * frequency
        smooth = np.fft.irfft(spectrum, len(odd))[:n] + line
        velocity = np.fft.irfft(spectrum * turn, len(odd))[:n] + (position[-1] - position[0]) / (
            (n - 1) * self.sample_time
        )
        return smooth[:rows], velocity[:rows]


def fast_length(length: int) -> int:
    """The next length whose only factors are 2, 3 and 5: quick to transform."""
    best = 1 << length.bit_length()
    for five in (1, 5, 25, 125):
        for three in (1, 3, 9, 27):
            factor = five * three
            two = 1 << max(0, (-(-length // factor) - 1).bit_length())
            if factor * two >= length:
                best = min(best, factor * two)
    return best


def _middle(values: FloatArray) -> FloatArray:
    return np.asarray(np.append(0.5 * (values[:-1] + values[1:]), values[-1]))


def _slope(values: FloatArray, step: float) -> FloatArray:
    slope = np.diff(values) / step
    return np.asarray(np.append(slope, slope[-1]))


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


@dataclass(frozen=True)
class ForceBalance:
    """One log's force balance: what the fit looks at.

    Attributes:
        log: measured.
        motion: the filtered motion.
        counts: rows in motion, away from the ends, (n,).
        block: number of the block of each row, (n,).
        scales: sizes of the log.
    """

    log: Log
    motion: InverseDynamics
    counts: npt.NDArray[np.bool_]
    block: npt.NDArray[np.int64]
    scales: Scales

    @classmethod
    def of(cls, log: Log, *, cutoff: float, rest: float | None = None) -> ForceBalance:
        """Filter a log's motion; rows slower than `rest` (m/s; None: 2 % of the largest speed) do not count."""
        motion = InverseDynamics(log, cutoff=cutoff)
        scales = scales_of(log, motion)
        speed = np.abs(motion.middle_velocity)
        edge = max(START, 0.5 / cutoff)
        counts = speed > (0.02 * scales.velocity if rest is None else rest)
        counts &= (motion.even >= motion.even[0] + edge) & (motion.even <= motion.even[-1] - edge)
        block = np.floor((motion.even - motion.even[0]) / max(0.2, 4.0 / cutoff)).astype(np.int64)
        return cls(log, motion, counts, block, scales)

    def columns(
        self, model: Model, parameters: Sequence[Parameter], scales: Scales, motion: InverseDynamics | None = None
    ) -> tuple[FloatArray, FloatArray]:
        """Residual (n,) and derivatives (p, n), V, of the rows of this motion or another."""
        models, widths = [model], []
        for parameter in parameters:
            step = scales.step(parameter)
            for value in (parameter.value + step, parameter.value - step):
                try:
                    models.append(with_values(model, {parameter.path: value}))
                except ValueError:  # beyond the parameter's range
                    models.append(model)
                    step *= 0.5
            widths.append(2.0 * step)
        table = (self.motion if motion is None else motion).of(models)
        return table[0], (table[1::2] - table[2::2]) / np.array(widths)[:, None]


@dataclass(frozen=True)
class BalanceEstimate:
    """What the fit of the force balance found.

    Attributes:
        values: (p,).
        covariance: jackknife over blocks, (p, p).
        model: with the values.
        residual_rms: V, one a log, rows in motion, below the cut-off.
        blocks: that the covariance rests on.
        instruments: whether simulated instruments were used in all logs.
    """

    values: FloatArray
    covariance: FloatArray
    model: Model
    residual_rms: tuple[float, ...]
    blocks: int
    instruments: bool


def fit_force_balance(
    model: Model,
    paths: Sequence[str],
    balances: Sequence[ForceBalance],
    scales: Scales,
    simulate: Sequence[Callable[[Model], FloatArray] | None],
    *,
    iterations: int = 10,
) -> BalanceEstimate:
    """Instrumental variables, Z^T r = 0, by Newton steps; least squares where no run can be simulated.

    Args:
        model: where to start.
        paths: of the free parameters.
        balances: the logs.
        scales: for the difference steps.
        simulate: for each log, the noise-free position (m) of a model at the log's times, or None.
        iterations: at most.
    """
    for _ in range(iterations):
        parameters = [parameters_of(model)[path] for path in paths]
        values = np.array([p.value for p in parameters])
        bread, right, parts, instruments = _equations(model, parameters, balances, scales, simulate)
        size = np.sqrt(np.abs(np.diag(bread)))
        size[size == 0.0] = 1.0
        step = -np.linalg.lstsq(bread / np.outer(size, size), right / size, rcond=1e-12)[0] / size
        length = 1.0
        while length > 1e-4:
            try:
                moved = with_values(
                    model, {p.path: _valid(p, p.value + length * s) for p, s in zip(parameters, step, strict=True)}
                )
                break
            except ValueError:
                length *= 0.5
        else:
            break
        model = moved
        if np.all(np.abs(step) <= 1e-6 * np.abs(values) + 1e-9 * np.array([scales.of(p.unit) for p in parameters])):
            break
    parameters = [parameters_of(model)[path] for path in paths]
    bread, _, parts, instruments = _equations(model, parameters, balances, scales, simulate)
    covariance, blocks = jackknife(bread, balances, parts)
    rms = [float(np.sqrt(np.mean(r**2))) for _, _, r, _ in parts]
    values = np.array([p.value for p in parameters])
    return BalanceEstimate(values, covariance, model, tuple(rms), blocks, instruments)


_Part = tuple[
    FloatArray, FloatArray, FloatArray, float
]  # instruments, columns, residual, weight of the rows that count


def jackknife(bread: FloatArray, balances: Sequence[ForceBalance], parts: Sequence[_Part]) -> tuple[FloatArray, int]:
    """Covariance (p, p) from leaving out one block after the other, and the number of blocks.

    A sandwich alone is too sure of a parameter that a few blocks show (mass, in a log with few hard accelerations):
    there the fit follows what it is judged by.
    """
    size = np.sqrt(np.maximum(np.abs(np.diag(bread)), 1e-300))
    shifts = []
    for balance, (z, columns, residual, weight) in zip(balances, parts, strict=True):
        edges = np.flatnonzero(np.diff(balance.block[balance.counts], prepend=-1, append=-2))
        for first, last in itertools.pairwise(edges):
            part = z[:, first:last]
            without = (bread - weight * part @ columns[:, first:last].T) / np.outer(size, size)
            score = weight * part @ residual[first:last] / size
            shifts.append(np.linalg.lstsq(without, score, rcond=1e-12)[0] / size)
    table = np.array(shifts)
    table -= table.mean(axis=0)
    return np.asarray(table.T @ table * (len(table) - 1) / len(table)), len(table)


def _equations(
    model: Model,
    parameters: Sequence[Parameter],
    balances: Sequence[ForceBalance],
    scales: Scales,
    simulate: Sequence[Callable[[Model], FloatArray] | None],
) -> tuple[FloatArray, FloatArray, list[_Part], bool]:
    p = len(parameters)
    bread, right = np.zeros((p, p)), np.zeros(p)
    parts, instruments = [], True
    for balance, run in zip(balances, simulate, strict=True):
        rows = balance.counts
        residual, columns = balance.columns(model, parameters, scales)
        z = columns
        if run is None:
            instruments = False
        else:
            motion = InverseDynamics(balance.log, cutoff=balance.motion.cutoff, along=run(model))
            z = balance.columns(model, parameters, scales, motion)[1]
        weight = 1.0 / float(np.mean(residual[rows] ** 2))
        bread += weight * z[:, rows] @ columns[:, rows].T
        right += weight * z[:, rows] @ residual[rows]
        parts.append((z[:, rows], columns[:, rows], residual[rows], weight))
    return bread, right, parts, instruments


def _valid(parameter: Parameter, value: float) -> float:
    if not parameter.positive:
        return float(value)
    return float(max(value, 0.1 * parameter.value if parameter.path in ("axis.mass", "axis.coulomb_width") else 0.0))
