"""The force balance of a log along its measured motion, and the instrumental-variable fit on it.

IDIM-IV (Janot, Vandanjon, Gautier 2014): the force that the model needs along the measured motion is compared with the
applied command, both through one low-pass filter. The instruments are the same columns along a simulated, noise-free
run, so that noise in the measured motion and command does not bias the estimate.
"""

from __future__ import annotations

import contextlib
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np

from cogging._core import DivergedError, Predictor
from cogging.arrays import FloatArray, IntArray, Mask
from cogging.effects.effect import laws_of
from cogging.estimation.residuals import HALVES, START, quiet_plant, scales_of
from cogging.estimation.statistics import shares_of_blocks, spread_of
from cogging.logs.log import Log
from cogging.logs.pauses import running_time
from cogging.model.model import Model
from cogging.model.parameters import Parameter, Scales, central, parameters_of, with_values

Simulator = Callable[[Model], Log] | None  # the noise-free run of a model, at a log's times

JITTER = 0.01  # of the median step: rows that are more even than this are used as logged
REST = 0.02  # of the largest speed: slower rows do not count, since friction at rest can take any value
GAP = 2.5  # median steps: no interpolation across longer steps
TOLERANCE = 1e-6  # relative: the fit has converged when its last step is smaller
NARROW = 0.05  # of the slowest speed that counts: a narrower friction law gives the same force there, within 3 %


@dataclass(frozen=True)
class Motion:
    """A smooth motion through the readings; entries (n,), those of `middle_*` half-way to the next row."""

    position: FloatArray  # position, middle_position: m
    middle_position: FloatArray
    middle_velocity: FloatArray  # mean over the interval, m/s
    acceleration: FloatArray  # mean over the interval, m/s^2


class ForceBalance:
    """Command minus the force that a model needs along the measured motion, low-pass filtered, V.

    The rows form an even grid with the log's median step: readings are interpolated, commands averaged over each step;
    long pauses take few rows (`running_time`). A held command moves the axis along parabolas, which the rows show as a
    command that is smaller by (omega h)^2 / 12; the command enters as the rows show it. Motor and load of an effect
    with states (backlash, flexible_mode) are treated as one body, and presliding as sliding.

    Args:
        log: measured, or simulated in its place.
        cutoff: of the filter, Hz; magnitude of a fourth-order Butterworth filter, zero phase.
        hold: s, for which a command was held where the rows are further apart; None: from row to row.
        rest: m/s; slower rows do not count. None: 2 % of the largest speed.
        run: the noise-free run of a model, for instruments; None: there is none.

    Raises:
        ValueError: the rows of the log cover too little of its time.
    """

    even: FloatArray  # times of the rows, s, (n,)
    readings: FloatArray  # position in the rows, m, (n,)
    command: FloatArray  # in the rows, V, (n,)
    motion: Motion  # smoothed through the readings
    pauses: bool  # whether pauses were shortened

    def __init__(
        self, log: Log, *, cutoff: float, hold: float | None = None, rest: float | None = None, run: Simulator = None
    ) -> None:
        self.log, self.cutoff, self.hold, self._rest, self.run = log, cutoff, hold, rest, run
        steps, running = np.diff(log.time), running_time(log.time)
        self.sample_time = float(np.median(steps))
        rows = int(np.floor((running[-1] - running[0]) / self.sample_time + 1e-6)) + 1
        even = running[0] + self.sample_time * np.arange(rows)
        if np.abs(steps - self.sample_time).max() <= JITTER * self.sample_time and rows == len(log):
            self.readings, self.command = log.position, log.command
        else:
            self.readings = np.interp(even, running, log.position)
            self.command = mean_held(running, log.command, even, self.sample_time)
        self.pauses = running is not log.time
        self.even = np.interp(even, running, log.time) if self.pauses else even
        self.motion = self._smooth(self.readings)
        self._hidden = self._hidden_between_rows(self.command)
        self._predictor = Predictor(self.even - log.time[0], self.motion.position, self.command)

    # Which rows count -------------------------------------------------------------------------------------------------

    def away_from_gaps(self, edge: float, memory: float) -> Mask:
        """Rows at least `edge` (s) from both ends and `memory` (s) from gaps, across which the filter reaches, (n,)."""
        rows = (self.even >= self.even[0] + edge) & (self.even <= self.even[-1] - edge)
        for first, last in self._gaps(memory):
            rows[first:last] = False
        return np.asarray(rows)

    def _gaps(self, memory: float) -> list[IntArray]:
        time = self.log.time
        gaps = np.flatnonzero(np.diff(time) > GAP * self.sample_time)
        return [np.searchsorted(self.even, [time[k] - memory, time[k + 1] + memory]) for k in gaps]

    @cached_property
    def scales(self) -> Scales:
        """Typical sizes of the log's quantities; the straight line across a shortened pause does not count."""
        moved = np.ones(len(self.even), dtype=bool)
        if self.pauses:
            for first, last in self._gaps(2.0 / self.cutoff):
                moved[first:last] = False
        moved |= not moved.any()
        return scales_of(self.log, self.motion.middle_velocity[moved], self.motion.acceleration[moved])

    @property
    def rest(self) -> float:
        """Speed below which rows do not count, m/s."""
        return REST * self.scales.velocity if self._rest is None else self._rest

    @cached_property
    def mask(self) -> Mask:
        """Rows in motion, away from the ends and from gaps, (n,)."""
        rows = self.away_from_gaps(max(START, 0.5 / self.cutoff), 2.0 / self.cutoff)
        return np.asarray(rows & (np.abs(self.motion.middle_velocity) > self.rest))

    @cached_property
    def block(self) -> IntArray:
        """Number of the block of each row, (n,)."""
        return np.asarray(np.floor((self.even - self.even[0]) / max(0.2, 4.0 / self.cutoff)).astype(np.int64))

    # Residuals and columns --------------------------------------------------------------------------------------------

    def of(self, models: Sequence[Model]) -> FloatArray:
        """Residuals of models, V, (models, n)."""
        return self.filtered(self._unfiltered(models))

    def residual_rms(self, model: Model) -> float:
        """Rms of the residual over the rows that count, V."""
        return float(np.sqrt(np.mean(self.of([model])[0, self.mask] ** 2)))

    def columns(self, model: Model, parameters: Sequence[Parameter], scales: Scales) -> tuple[FloatArray, FloatArray]:
        """Residual (n,) and its derivatives (p, n) with respect to parameters, V, by central differences."""
        steps = [central(model, parameter, scales.step(parameter)) for parameter in parameters]
        table = self._unfiltered([model, *(side for step in steps for side in (step.above, step.below))])
        # The filter is linear: filtering the differences halves the work.
        table[1 : len(steps) + 1] = (table[1::2] - table[2::2]) / np.array([step.span for step in steps])[:, None]
        filtered = self.filtered(table[: len(steps) + 1])
        return filtered[0], filtered[1:]

    def along(self, model: Model) -> ForceBalance | None:
        """The force balance along a simulated run; None without a simulator, or if the model cannot be simulated."""
        if self.run is None:
            return None
        try:
            simulated = self.run(model)
        except (DivergedError, ValueError):  # for example a friction slope too steep for a nearly vanishing mass
            return None
        return ForceBalance(simulated, cutoff=self.cutoff, hold=self.hold)

    def instruments(self, model: Model, parameters: Sequence[Parameter], scales: Scales) -> FloatArray | None:
        """Derivatives (p, n) along a simulated run, V; None as for `along`."""
        simulated = self.along(model)
        return None if simulated is None else simulated.columns(model, parameters, scales)[1]

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
            force = self._predictor.net_force(plants, motion.middle_position, motion.middle_velocity)
            for row, i in zip(force, members, strict=True):
                row -= models[i].axis.mass * motion.acceleration
                row -= self._hidden
            tables.append(force)
        order = np.argsort([i for _, members in groups.values() for i in members])
        return tables[0] if len(tables) == 1 else np.concatenate(tables)[order]

    # Filters ----------------------------------------------------------------------------------------------------------

    def filtered(self, rows: FloatArray, every: int = 1) -> FloatArray:
        """Low-pass filter rows (p, n), or rows at every second (third, ...) time; mirrored at both ends."""
        from scipy.fft import dct, idct, next_fast_len

        n = rows.shape[1]
        padded = np.pad(rows, ((0, 0), (0, next_fast_len(n, real=True) - n)), mode="edge")
        length = padded.shape[1]
        frequency = np.arange(length) / (2.0 * length * every * self.sample_time)
        spectrum = dct(padded, axis=1, overwrite_x=True)
        spectrum /= 1.0 + (frequency / self.cutoff) ** 8
        return np.asarray(idct(spectrum, axis=1, overwrite_x=True)[:, :n])

    def _hidden_between_rows(self, command: FloatArray) -> FloatArray:
        """The part of a held command that the acceleration of a band-limited motion does not show, V, (n,).

        Held over steps h, u / M gives x = u / M (h^2 / 2) (z + 1) / (z - 1)^2 in the rows. The mean acceleration of the
        band-limited motion through these is (omega h / 2) cot(omega h / 2) u / M, z = exp(i omega h).
        """
        from scipy.fft import dct, idct

        steps = 1.0 if self.hold is None else min(self.hold / self.sample_time, 1.0)
        half = 0.5 * np.pi * steps * np.arange(len(command)) / len(command)  # omega h / 2, of the mirrored command
        shown = np.ones(len(half))
        shown[1:] = half[1:] / np.tan(half[1:])
        return np.asarray(idct((1.0 - shown) * dct(command)))

    def _behind(self, falsifying: Sequence[Any]) -> Motion:
        """The true motion behind readings that effects falsify."""
        if not falsifying:
            return self.motion
        position = self.readings
        for _ in range(3):  # fixed point of x = reading - error(x): the slope of the error is far below 1
            position = self.readings - sum(laws_of(effect).reading_at(position) - position for effect in falsifying)
        return self._smooth(position)

    def _smooth(self, position: FloatArray) -> Motion:
        """Filter at five times the cut-off, which leaves what the common filter passes."""
        from scipy.fft import next_fast_len

        rows = len(position)
        position = np.pad(position, (0, next_fast_len(rows, real=True) + 1 - rows), mode="edge")
        n = len(position)
        line = np.linspace(position[0], position[-1], n)
        rest = position - line
        odd = np.concatenate([rest[:-1], -rest[:0:-1]])  # odd about the ends: continuous in value and slope
        frequency = np.fft.rfftfreq(len(odd), self.sample_time)
        spectrum = np.fft.rfft(odd) / (1.0 + (frequency / min(5.0 * self.cutoff, 0.4 / self.sample_time)) ** 8)
        smooth = (np.fft.irfft(spectrum, len(odd))[:n] + line)[:rows]
        velocity = np.fft.irfft(spectrum * (2j * np.pi * frequency), len(odd))[:rows]
        # The force is held over an interval, so means over the interval show its effect.
        middle = np.append(0.5 * (smooth[:-1] + smooth[1:]), smooth[-1])
        slopes = [np.diff(values) / self.sample_time for values in (smooth, velocity)]
        return Motion(smooth, middle, *(np.append(slope, slope[-1]) for slope in slopes))


def mean_held(time: FloatArray, command: FloatArray, even: FloatArray, step: float) -> FloatArray:
    """Mean over each even step of a command that is held from its own time to the next."""
    total = np.concatenate([[0.0], np.cumsum(command[:-1] * np.diff(time))])
    edges = np.append(even, even[-1] + step)
    at_edges = np.interp(edges, time, total) + command[-1] * np.maximum(edges - time[-1], 0.0)
    return np.asarray(np.diff(at_edges) / step)


@dataclass(frozen=True)
class BalanceEstimate:
    """Parameters fitted on the force balance."""

    values: FloatArray  # (p,)
    covariance: FloatArray  # block jackknife plus the contribution of the prior, (p, p)
    freedom: FloatArray  # degrees of freedom of each variance, (p,)
    model: Model  # with the values
    residual_rms: tuple[float, ...]  # V, one for each log, over the rows in motion, below the cut-off
    instruments: bool  # whether simulated instruments were used for all logs


def fit_force_balance(
    model: Model, paths: list[str], balances: Sequence[ForceBalance], scales: Scales, loose: FloatArray, steps: int = 12
) -> BalanceEstimate:
    """Solve Z^T r = 0 by Newton steps, Z the instruments; least squares where no run can be simulated.

    `loose`: 1-sigma of a prior about the start, (p,); infinite: none. It keeps poorly determined parameters near their
    start and lets the covariance of the others allow for them.
    """
    if not paths:
        rms = tuple(balance.residual_rms(model) for balance in balances)
        return BalanceEstimate(np.empty(0), np.empty((0, 0)), np.empty(0), model, rms, False)
    prior, weight = np.array([parameters_of(model)[path].value for path in paths]), 1.0 / loose**2
    rows = [int(balance.mask.sum()) for balance in balances]

    def cost(model: Model) -> float:
        """Geometric mean over the rows of all logs of the residual's rms, V."""
        logs = [np.log(max(balance.residual_rms(model), 1e-300)) for balance in balances]
        return float(np.exp(np.dot(rows, logs) / sum(rows)))

    def equations(model: Model, instrumental: bool) -> tuple[FloatArray, FloatArray, list[Any], bool]:
        """Z^T d r / d parameter (p, p) and Z^T r (p,) with the prior; Z, columns, residual and weight of each log."""
        known = parameters_of(model)
        parameters = [known[path] for path in paths]
        bread, right = np.diag(weight), weight * (np.array([one.value for one in parameters]) - prior)
        parts, has_instruments = [], True
        for balance in balances:
            residual, columns = balance.columns(model, parameters, scales)
            simulated = balance.instruments(model, parameters, scales) if instrumental else None
            has_instruments &= simulated is not None
            z = (columns if simulated is None else simulated)[:, balance.mask]
            columns, residual = columns[:, balance.mask], residual[balance.mask]
            w = 1.0 / max(float(np.mean(residual**2)), 1e-300)
            bread = bread + w * z @ columns.T
            right += w * z @ residual
            parts.append((z, columns, residual, w))
        return bread, right, parts, has_instruments

    # Without instruments first: a simulated run far from the log could lead the steps astray.
    for instrumental in (False, True) if any(balance.run for balance in balances) else (False,):
        now = cost(model)
        narrow = min(model.axis.coulomb_width, NARROW * min(balance.rest for balance in balances))
        for _ in range(steps):
            known = parameters_of(model)
            values = np.array([known[path].value for path in paths])
            bread, right, _, _ = equations(model, instrumental)
            lowest = {path: known[path].clipped(-np.inf) for path in paths}
            if "axis.coulomb_width" in lowest:
                lowest["axis.coulomb_width"] = max(lowest["axis.coulomb_width"], narrow)
            step = bounded_step(bread, right, np.array(list(lowest.values())) - values)
            for length in HALVES:
                with contextlib.suppress(ValueError):
                    trial = with_values(model, dict(zip(paths, values + length * step, strict=True)))
                    trial_cost = cost(trial)
                    if trial_cost <= 1.02 * now:  # instruments may leave a little more than least squares
                        break
            else:
                break
            model, now = trial, trial_cost
            small = np.array([scales.of(known[path].dimension) for path in paths])
            if np.all(np.abs(step) <= TOLERANCE * (np.abs(values) + 1e-3 * small)):
                break
    bread, _, parts, has_instruments = equations(model, instrumental=True)
    # Leave out one block after the other: a sandwich estimate is too optimistic for a parameter that few blocks show.
    shifts = [
        solve_scaled(bread - own, right, bread)
        for balance, (z, columns, residual, w) in zip(balances, parts, strict=True)
        for own, right in shares_of_blocks(w * z, columns, residual, balance.block[balance.mask])
    ]
    covariance, freedom = spread_of(np.array(shifts))
    covariance = covariance + solve_scaled(bread, solve_scaled(bread, np.diag(weight), bread).T, bread)
    values = np.array([parameters_of(model)[path].value for path in paths])
    rms = tuple(float(np.sqrt(np.mean(residual**2))) for _, _, residual, _ in parts)
    return BalanceEstimate(values, covariance, freedom, model, rms, has_instruments)


def solve_scaled(matrix: FloatArray, right: FloatArray, whole: FloatArray) -> FloatArray:
    """matrix^-1 right, scaled by the diagonal of `whole` so that the units of the parameters do not matter."""
    size = np.sqrt(np.maximum(np.abs(np.diag(whole)), 1e-300))
    solution: FloatArray = np.linalg.lstsq(matrix / np.outer(size, size), (right.T / size).T, rcond=1e-12)[0]
    return np.asarray((solution.T / size).T)


def bounded_step(bread: FloatArray, right: FloatArray, lowest: FloatArray) -> FloatArray:
    """The step (p,) with bread step = -right, no entry below `lowest` (p,); the others allow for those held there."""
    held = np.zeros(len(right), dtype=bool)
    while True:
        reduced = np.where(held | held[:, None], np.diag(np.diag(bread)), bread)
        target = right + np.where(held, 0.0, bread[:, held] @ lowest[held])
        step = np.where(held, lowest, -solve_scaled(reduced, target, bread))
        beyond = ~held & (step < lowest)
        if not beyond.any():
            return step
        held |= beyond
