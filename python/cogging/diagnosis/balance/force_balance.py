"""The force balance of a log along its measured motion: what acts, less what the model accounts for, row by row."""

from __future__ import annotations

from copy import copy
from functools import cached_property

import numpy as np
from scipy.ndimage import maximum_filter1d, minimum_filter1d
from scipy.signal import butter, firwin, freqz, sosfilt, sosfiltfilt, sosfreqz, upfirdn, welch

from cogging._core import AxisParameters, Predictor
from cogging.effects.effect import laws_of
from cogging.estimation.residuals import quiet_plant
from cogging.identification.inverse_dynamics import _mean_held
from cogging.log_check.encoder_quantum import encoder_quantum
from cogging.model.model import Model

MIDDLE_RATE = 6000.0  # Hz, at which laws are evaluated
ROWS = 4.0  # at which rows are compared, in corners of the band
SKIP = 0.06  # s, at either end: the filters' edges and the start of the loop
REST_TIME = 0.012  # s, over which an axis that moves less than the encoder sees is at rest


def decimated(rows, every):
    """Low-pass filter and every n-th of rows (p, n)."""
    if every == 1:
        return rows
    half = 2 * every
    taps = firwin(2 * half + 1, 0.8 / every)
    padded = np.pad(rows, ((0, 0), (half, half)), mode="edge")
    out = upfirdn(taps, padded, 1, every, axis=1)
    first = 2 * half // every
    return out[:, first : first + -(-rows.shape[1] // every)]


class ForceBalance:
    """One log, ready to be held against any model.

    Row k: M a_k = mean force over the steps beside it, weighted with their lengths, where
    a_k = 2 (s_k - s_(k-1)) / (h_k + h_(k-1)), s the slopes of the readings: exact for held commands at any time steps.
    """

    def __init__(self, log, width=1e-3, quantum=0.0):
        quantum = quantum or encoder_quantum(log.position)
        time, position, command = log.time - log.time[0], log.position, log.command
        steps = np.diff(time)
        h = float(np.median(steps))
        if np.abs(steps - h).max() > 0.3 * h:  # uneven: on an even grid
            even = np.arange(0.0, time[-1], h)
            command = _mean_held(time, command, even, h)
            gap = np.interp(even, time[1:], steps) > 5 * h
            position = np.interp(even, time, position)
            self.uneven = True
            time = even
        else:
            self.uneven = False
            gap = np.zeros(len(time), bool)
        self.log, self.kept = log, {}
        self.width = width
        h_all = np.diff(time)
        slope = np.diff(position) / h_all
        pair = h_all[1:] + h_all[:-1]
        acceleration = 2.0 * np.diff(slope) / pair
        velocity = (position[2:] - position[:-2]) / pair
        acting = (command[1:-1] * h_all[1:] + command[:-2] * h_all[:-1]) / pair
        rate = 1.0 / h
        self.first = max(1, round(rate / MIDDLE_RATE))
        self.step = h * self.first  # s, of the middle rows
        mid = decimated(np.vstack([position[1:-1], acceleration, velocity, acting]), self.first)
        self.time = time[1:-1][:: self.first]
        self.position, self.acceleration, self.raw_velocity, self.command = mid
        self.reference = self._reference(log)
        # the encoder's noise: what a parabola through four rows leaves, quiet rows
        third = np.diff(position, 3)
        self.encoder_noise = max(
            1.4826 * float(np.median(np.abs(third))) / np.sqrt(20.0), quantum / np.sqrt(12.0), 1e-15
        )
        density = 2.0 * self.encoder_noise**2 / rate
        self.band = float(
            np.clip((3.0 * (0.2 * max(width, 1e-9)) ** 2 / (4 * np.pi**2 * density)) ** (1 / 3), 30.0, 0.4 / self.step)
        )
        self.band = min(self.band, 0.4 / self.step)
        # what the axis was asked for is known without noise; its starts and stops are faster than any low-pass filter
        asked = 0.0 if self.reference is None else self.reference[1]
        self.velocity = asked + self._low_pass(self.raw_velocity - asked, self.band)
        self.speed_noise = float(np.sqrt(4 * np.pi**2 * density * self.band**3 / 3))
        size = 2 * max(1, round(0.5 * REST_TIME / self.step)) + 1
        moved = maximum_filter1d(self.position, size) - minimum_filter1d(self.position, size)
        slowest = max(2.0 * quantum / REST_TIME, 3.0 * self.speed_noise)
        near = maximum_filter1d((moved <= slowest * REST_TIME).astype(np.uint8), size) > 0
        self.resting = near
        keep = ~self.resting & ~gap[1:-1][:: self.first]
        keep &= (self.time > SKIP) & (self.time < self.time[-1] - SKIP)
        self.keep = keep.astype(float)

    @property
    def every(self):
        """Rows of the motion in a row that is compared."""
        return max(1, int(1.0 / (self.step * ROWS * self.corner)))

    @property
    def rate(self):
        return 1.0 / (self.step * self.every)

    @property
    def mask(self):
        return self.keep[:: self.every] > 0

    def moved(self, distance):
        """The same log with its zero elsewhere, by a distance, m."""
        other = copy(self)
        other.kept = {}
        other.__dict__.pop("fine", None)
        other.position = self.position + distance
        if self.reference is not None:
            other.reference = self.reference + np.array([[distance], [0.0], [0.0]])
        return other

    def _reference(self, log):
        """Place, speed and acceleration that were asked for, (3, n); None where the log does not tell."""
        if log.reference is None:
            return None
        x = log.reference
        v = np.gradient(x, log.time) if log.reference_velocity is None else log.reference_velocity
        a = np.gradient(v, log.time) if log.reference_acceleration is None else log.reference_acceleration
        return np.array([np.interp(self.time, log.time - log.time[0], row) for row in (x, v, a)])

    def _low_pass(self, x, cutoff):
        if cutoff >= 0.45 / self.step:
            return x
        return sosfiltfilt(butter(2, cutoff * 2 * self.step, output="sos"), x)

    corner = 60.0  # Hz

    def filters(self):
        """Taps before the rows are thinned out, and second-order sections behind them."""
        half = 8 * self.every
        taps = firwin(2 * half + 1, 0.8 / self.every, window=("kaiser", 5.0)) if self.every > 1 else np.ones(1)
        return taps, butter(2, min(self.corner / (0.5 * self.rate), 0.8), output="sos")

    def rows(self, columns):
        """Columns at the middle rate as they are compared, filtered, (p, m)."""
        taps, sections = self.filters()
        half, columns = len(taps) // 2, np.atleast_2d(columns) * self.keep
        if self.every > 1:
            columns = np.pad(columns, ((0, 0), (half, half)))
            count = -(-len(self.time) // self.every)
            columns = upfirdn(taps, columns, 1, self.every, axis=1)[:, 2 * half // self.every :][:, :count]
        return sosfilt(sections, columns, axis=1)

    def adjoint(self, rows):
        """The transpose of `rows`, (n,)."""
        taps, sections = self.filters()
        back = sosfilt(sections, rows[::-1])[::-1]
        if self.every > 1:
            half = len(taps) // 2
            back = upfirdn(taps, np.append(back, np.zeros(2)), self.every)[half : half + len(self.time)]
        return back * self.keep

    def power(self, f):
        """Power gain of `rows` at f (Hz), a row of the middle rate."""
        taps, sections = self.filters()
        f = np.clip(np.ravel(f), 0.0, 0.5 / self.step)
        folded = np.abs((f + 0.5 * self.rate) % self.rate - 0.5 * self.rate)
        gain = np.abs(freqz(taps, 1.0, 2 * np.pi * f * self.step)[1])
        gain *= np.abs(sosfreqz(sections, 2 * np.pi * folded / self.rate)[1])
        return gain**2 / self.every

    def hear(self, residual, mass):
        """Filter from where the encoder's noise is above that of the force; residual at the middle rate, V (n,)."""
        f, p = welch(residual, 1.0 / self.step, nperseg=int(min(len(residual), 1.0 / self.step)))
        low = np.median(p[(f > 2) & (f < 30)])
        density = 2.0 * self.encoder_noise**2 * self.step / self.first
        self.corner = float(np.clip(np.sqrt(np.sqrt(low / density) / mass) / (2 * np.pi), 20.0, 250.0))

    @cached_property
    def fine(self):
        """Sub-steps of the motion: friction changes sign within a step."""
        most = float(np.max(np.abs(np.diff(self.velocity))))
        n = int(np.clip(np.ceil(most / max(self.width, 1e-9)), 1, 6))
        if n == 1:
            return 1, self.time - 0.5 * self.step, self.position, self.velocity
        at = np.arange(n * len(self.time) - n + 1) / n
        rows = np.arange(len(self.time))
        t = np.interp(at, rows, self.time) - 0.5 * self.step / n
        return n, t, np.interp(at, rows, self.position), np.interp(at, rows, self.velocity)

    def averaged(self, table):
        """Rows at the sub-steps, averaged over the steps beside each row of the motion, as the acceleration is."""
        n = self.fine[0]
        if n == 1:
            return table
        half = max(1, round(n / self.first))
        weights = np.concatenate([np.arange(1, half + 1), np.arange(half - 1, 0, -1)]) / half**2
        padded = np.pad(table, ((0, 0), (half - 1, half - 1)), mode="edge")
        rows = len(self.time)
        out = weights[0] * padded[:, ::n][:, :rows]
        for k, w in enumerate(weights[1:], 1):
            out = out + w * padded[:, k::n][:, :rows]
        return out

    def forces(self, plants, command=None, error=None):
        """What acts by plants along the motion, V, (plants, n); `error`: of the reading, at the sub-steps."""
        n, t, x, v = self.fine
        if command is None:
            u = np.zeros(len(t))
        else:
            u = command if n == 1 else np.interp(t + 0.5 * self.step / n, self.time, command)
        if error is not None:
            x, v = x - error, v - np.gradient(error, self.step / n)
        return self.averaged(Predictor(t, x, u).net_force(plants, x, v))

    def residual(self, model):
        """The missing force, V, (n,) at the middle rate: M a less what the model accounts for."""
        a = self.acceleration
        falsify = [e for e in model.effects if "reading" in e.HOOKS]
        error = None
        if falsify:
            n, _, x, _ = self.fine
            error = sum(laws_of(e).reading_at(x) - x for e in falsify)
            coarse = error[::n]
            a = a - np.gradient(np.gradient(coarse, self.step), self.step)
        shaped = any(
            h in e.HOOKS for e in model.effects for h in ("command_gain", "command_delay", "lag", "shape_command")
        )
        force = self.forces([quiet_plant(model)], self.command if shaped else None, error)[0]
        return model.axis.mass * a - force - (0.0 if shaped else self.command)

    def added(self, model, effects, command):
        """The force that each effect adds, V, (effects, n) at the middle rate; `command`: what drives the axis."""
        axis = AxisParameters(
            mass=1.0, viscous=0.0, coulomb=1e6, coulomb_width=model.axis.coulomb_width, travel=model.axis.travel
        )
        base = Model(axis=axis, cogging=model.cogging)
        table = self.forces([quiet_plant(base)] + [quiet_plant(base.replace(effects=(e,))) for e in effects], command)
        return table[1:] - table[0]
