"""Force balance of a log along its measured motion: M a less the forces of a model, row by row."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from copy import copy
from functools import cached_property, lru_cache
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray
from scipy.ndimage import maximum_filter1d, median_filter, minimum_filter1d
from scipy.signal import butter, csd, firwin, lfilter, sosfilt, sosfiltfilt, sosfreqz, upfirdn, welch

from cogging._core import AxisParameters, Plant, Predictor
from cogging.arrays import FloatArray, Mask
from cogging.diagnosis.balance.cells import dahl, load_response, lost_motion
from cogging.effects.effect import Effect, laws_of
from cogging.estimation.force_balance import mean_held
from cogging.estimation.residuals import quiet_plant
from cogging.log_check.encoder_readings import encoder_quantum
from cogging.logs.log import Log
from cogging.model.model import Model

# Grid of the motion
MIDDLE_RATE = 3000.0  # Hz: rate at which laws are evaluated, well above any corner
UNEVEN = 0.3  # of the median step: larger deviations require resampling to a uniform grid
GAP_STEPS = 5.0  # median steps: a longer step is a gap, whose rows are invalid
SKIP = 0.06  # s: invalid rows at both ends (filter transients, start of the loop)
MOST_SUB_STEPS = 6  # in a row about a reversal of friction; more do not change its mean
SLOPE_STEP = 5e-5  # of the range of the motion: step of the derivatives of a reading error, below its period
NEAR = 10.0  # speed changes per row: at higher speeds a row needs no sub-steps
# Speed and rest
SPEED_NOISE = 0.2  # of `coulomb_width`: target noise of the smoothed speed
WIDTH_SHARE = 0.05  # of the rms speed: friction width where the model has none
LOWEST_BAND = 30.0  # Hz: lowest corner of the speed filter, which keeps reversals
NYQUIST_SHARE = 0.4  # of the sample rate: highest corner of the speed filter
REST_TIME = 0.012  # s: an axis that moves less than the encoder resolution within it is at rest
STILL = 4.5  # standard deviations of a reading: range of the readings of an axis that stands still, two counts
# Decimated rows
ROWS_PER_CORNER = 4.0  # sample rate over the corner of the low-pass filter
FIRST_CORNER = 60.0  # Hz, until the noise is known
CORNERS = (5.0, 250.0)  # Hz: limits of the corner; resonances and delays lie below, a loop's bandwidth above
FORCE_NOISE = (2.0, 30.0)  # Hz: band in which the force noise is estimated
SLOW = 10.0  # Hz: below it the measured acceleration has little noise
FOLLOWED = 0.2  # of the crossover: below it the loop follows its reference, and noise hardly shifts its command in time
WINDOW = 0.25  # s: of the spectra of which the crossover of a loop is estimated
OCTAVES = (40.0, 80.0, 160.0)  # Hz: where these octaves begin; motion has the least power in one of them
GAP = 24  # invalid rows after a gap, over which the first taps of the whitening filter reach
ENCODER_SHARE = 0.3  # of the residual power: encoder noise at the corner where the residual is systematic
#: Hooks that change the command before it acts.
COMMAND_HOOKS = ("command_gain", "command_delay", "lag", "shape_command")


class FineMotion(NamedTuple):
    """Motion at every row, and at sub-steps of the rows close to a reversal."""

    instant: FloatArray  # s, (m,)
    start: FloatArray  # s, (m,): midpoint to the previous instant, from which the command of an instant acts
    position: FloatArray  # m, (m,)
    velocity: FloatArray  # m/s, (m,)
    rows: NDArray[np.intp]  # indexes of the rows of the motion, (n,)
    near: Mask  # rows close to a reversal, (n,)
    around: NDArray[np.intp]  # indexes about each of them, (count, 2 half - 1)
    weights: FloatArray  # of these in the mean of a row, (2 half - 1,)


def decimated(rows: FloatArray, every: int) -> FloatArray:
    """Return every n-th column of rows (p, n) after a zero-phase low-pass filter."""
    if every == 1:
        return rows
    half = 8 * every
    taps = firwin(2 * half + 1, 0.8 / every, window=("kaiser", 9.0))
    padded = np.pad(rows, ((0, 0), (half, half)), mode="edge")
    first = 2 * half // every
    return np.asarray(upfirdn(taps, padded, 1, every, axis=1)[:, first : first + -(-rows.shape[1] // every)])


@lru_cache(maxsize=64)
def row_filter(every: int, rate: float, corner: float) -> tuple[FloatArray, FloatArray]:
    """Return the taps of the anti-aliasing filter, and the second-order sections that act after decimation."""
    taps = firwin(16 * every + 1, 0.8 / every, window=("kaiser", 5.0)) if every > 1 else np.ones(1)
    return taps, butter(2, min(corner / (0.5 * rate), 0.8), output="sos")


class DifferencedBalance:
    """Force balance of one log, for any model.

    Row k is M a_k = mean force over the adjacent steps, weighted by their lengths, with
    a_k = 2 (s_k - s_(k-1)) / (h_k + h_(k-1)), where s are the slopes of the readings and h the time steps. It is exact
    for held commands at any time steps.

    Args:
        log: measured log.
        width: width of Coulomb friction, m/s; the speed is smoothed until its noise is small compared with it.
        quantum: encoder resolution, m; 0 estimates it from the log.

    Attributes:
        time: s, from the first row of the log, (n,), `step` (s) apart.
        position: m, (n,).
        velocity: m/s, (n,).
        acceleration: m/s^2, (n,).
        command: V, (n,).
        thinning: rows of the log in a row of the motion.
        reference: reference position, velocity and acceleration, (3, n), or None.
        encoder_noise: standard deviation of a reading, m.
        speed_noise: standard deviation of `velocity`, m/s.
        valid: rows away from gaps and from both ends, (n,).
        resting: rows at rest, in which the axis moves no more than `least` (m) within REST_TIME, (n,).
        keep: 1 for a valid row, else 0, (n,).
        keep_near_rest: the same with rows near rest in which the readings still move, (n,).
        corner: corner of the low-pass filter before decimation, Hz.
        crossover: frequency above which the loop does not answer its noise, Hz.
        largely: whether a model lacks so much that noise is negligible below the corner.
    """

    def __init__(self, log: Log, width: float = 1e-3, quantum: float = 0.0) -> None:
        quantum = quantum or encoder_quantum(log.position)
        self.log, self.width, self.corner, self.crossover, self.largely = log, width, FIRST_CORNER, SLOW, False
        self.cache: dict[Any, Any] = {}
        time, position, command, gap = _even(log)
        steps = np.diff(time)
        pair = steps[1:] + steps[:-1]
        acceleration = 2.0 * np.diff(np.diff(position) / steps) / pair
        velocity = (position[2:] - position[:-2]) / pair
        acting = (command[1:-1] * steps[1:] + command[:-2] * steps[:-1]) / pair
        h = float(np.median(np.diff(log.time - log.time[0])))
        rate = 1.0 / h
        self.thinning = max(1, round(rate / MIDDLE_RATE))
        self.step = h * self.thinning
        middle = decimated(np.vstack([position[1:-1], acceleration, velocity, acting]), self.thinning)
        self.time = time[1:-1][:: self.thinning]
        self.position, self.acceleration, self.raw_velocity, self.command = middle
        self.reference = self._reference(log)
        # third differences remove a parabola and multiply the variance of white noise by 20
        third = np.diff(position, 3)
        self.encoder_noise = max(
            1.4826 * float(np.median(np.abs(third))) / np.sqrt(20.0), quantum / np.sqrt(12.0), 1e-15
        )
        width = width or WIDTH_SHARE * float(np.sqrt(np.mean(self.raw_velocity**2)))
        # position noise of density d (m^2/Hz) causes a speed variance of 4 pi^2 d band^3 / 3 below `band`
        density = 2.0 * self.encoder_noise**2 / rate
        wanted = (3.0 * (SPEED_NOISE * max(width, 1e-9)) ** 2 / (4 * np.pi**2 * density)) ** (1 / 3)
        self.band = float(np.clip(wanted, LOWEST_BAND, NYQUIST_SHARE / self.step))
        # filter the difference from the reference, which has no noise and keeps fast starts and stops
        asked = 0.0 if self.reference is None else self.reference[1]
        self.velocity: FloatArray = asked + self.low_passed(self.raw_velocity - asked, self.band)
        self.speed_noise = float(np.sqrt(4 * np.pi**2 * density * self.band**3 / 3))
        self.valid = ~gap[1:-1][:: self.thinning] & (self.time > SKIP) & (self.time < self.time[-1] - SKIP)
        self.set_rest(max(2.0 * quantum, 3.0 * self.speed_noise * REST_TIME), STILL * self.encoder_noise)

    @property
    def every(self) -> int:
        """Rows of the motion in a decimated row."""
        return max(1, int(1.0 / (self.step * ROWS_PER_CORNER * self.corner) + 1e-3))  # beyond rounding

    @property
    def rate(self) -> float:
        """Sample rate of the decimated rows, Hz."""
        return 1.0 / (self.step * self.every)

    @property
    def mask(self) -> Mask:
        """Valid decimated rows."""
        return self.keep[:: self.every] > 0

    @property
    def counted(self) -> Mask:
        """Valid decimated rows behind a whitening filter."""
        return np.asarray(lfilter(np.ones(GAP), 1.0, (~self.mask).astype(float)) < 0.5)

    def remembered(self, name: str, model: Model, make: Callable[[DifferencedBalance, Model], Any]) -> Any:
        """Return what `make` computed for the last model of this name, if it was this one; else compute it."""
        known = self.cache.get(name)
        if known is None or known[0] is not model:
            self.cache[name] = known = model, make(self, model)
        return known[1]

    def moved(self, distance: float) -> DifferencedBalance:
        """Return a copy with positions shifted by a distance (m): another zero of the encoder."""
        other = copy(self)
        other.cache = {}
        other.__dict__.pop("fine", None)
        other.position = self.position + distance
        if self.reference is not None:
            other.reference = self.reference + np.array([[distance], [0.0], [0.0]])
        return other

    def with_creep(self) -> DifferencedBalance:
        """Return a copy in which rows near rest are valid as long as the readings move."""
        other = copy(self)
        other.keep = self.keep_near_rest
        return other

    def earlier(self, seconds: float) -> DifferencedBalance:
        """Return a copy whose command acts `seconds` before it was logged."""
        other = copy(self)
        other.cache = {}
        other.command = np.interp(self.time + seconds, self.time, self.command)
        return other

    def _reference(self, log: Log) -> FloatArray | None:
        """Return reference position, velocity and acceleration, (3, n), or None if the log has no reference."""
        if log.reference is None:
            return None
        x = log.reference
        v = np.gradient(x, log.time) if log.reference_velocity is None else log.reference_velocity
        a = np.gradient(v, log.time) if log.reference_acceleration is None else log.reference_acceleration
        return np.array([np.interp(self.time, log.time - log.time[0], row) for row in (x, v, a)])

    def timed(self, drive: FloatArray) -> FloatArray:
        """Return the command whose timing is known, V, (n,), from its part without noise, `drive`.

        Without a reference that is the slow part, and the whole command as logged where its noise is negligible.
        """
        if self.reference is not None:
            return drive
        return self.command if self.largely else self.low_passed(drive, FOLLOWED * self.crossover)

    def low_passed(self, x: FloatArray, cutoff: float) -> FloatArray:
        """Return rows (n,) behind a zero-phase low-pass filter with a corner (Hz)."""
        if cutoff >= 0.45 / self.step:
            return x
        return np.asarray(sosfiltfilt(butter(2, cutoff * 2 * self.step, output="sos"), x))

    def set_rest(self, least: float, still: float) -> None:
        """Set the rows at rest: those in which the axis moves less than a distance (m) within REST_TIME.

        Of them, rows near rest in which it moves more than the distance `still` remain valid for friction near rest.
        """
        self.least, size = least, 2 * max(1, round(0.5 * REST_TIME / self.step)) + 1
        moved = maximum_filter1d(self.position, size) - minimum_filter1d(self.position, size)
        self.resting: Mask = maximum_filter1d((moved <= least).astype(np.uint8), size) > 0
        held = maximum_filter1d((moved <= still).astype(np.uint8), size) > 0
        self.keep: FloatArray = (self.valid & ~self.resting).astype(float)
        self.keep_near_rest: FloatArray = (self.valid & ~(held & self.resting)).astype(float)

    def filters(self) -> tuple[FloatArray, FloatArray]:
        """Return the filters of `rows` (see `row_filter`)."""
        return row_filter(self.every, self.rate, self.corner)

    def rows(self, columns: FloatArray) -> FloatArray:
        """Return columns (p, n) with invalid rows set to zero, low-pass filtered and decimated, (p, m)."""
        taps, sections = self.filters()
        half, columns = len(taps) // 2, np.atleast_2d(columns) * self.keep
        if self.every > 1:
            columns = np.pad(columns, ((0, 0), (half, half)))
            count = -(-len(self.time) // self.every)
            columns = upfirdn(taps, columns, 1, self.every, axis=1)[:, 2 * half // self.every :][:, :count]
        return np.asarray(sosfilt(sections, columns, axis=1))

    def adjoint(self, rows: FloatArray) -> FloatArray:
        """Return the transpose of `rows`, (m,) to (n,): sum(rows(c) * r) = sum(c * adjoint(r)) for every column c."""
        taps, sections = self.filters()
        back = sosfilt(sections, rows[::-1])[::-1]
        if self.every > 1:
            half = len(taps) // 2
            back = upfirdn(taps, np.append(back, np.zeros(2)), self.every)[half : half + len(self.time)]
        return np.asarray(back * self.keep)

    def power(self, frequency: FloatArray) -> FloatArray:
        """Return the power gain of `rows` at frequencies (Hz), per row of the motion."""
        taps, sections = self.filters()
        f = np.clip(np.ravel(frequency), 0.0, 0.5 / self.step)
        folded = np.abs((f + 0.5 * self.rate) % self.rate - 0.5 * self.rate)
        gain = gain_of_taps(taps, f * self.step)
        gain *= np.abs(sosfreqz(sections, 2 * np.pi * folded / self.rate)[1])
        return np.asarray(gain**2 / self.every)

    def listen(self, residual: FloatArray, axis: AxisParameters, largely: bool = False) -> None:
        """Set what depends on the noise: the low-pass corner, the crossover of the loop and the rows at rest.

        The corner is where the encoder noise, M^2 w^4 times its density, exceeds the force noise. A loop responds to
        noise with -T times the residual, T = C / (M s^2 + C) of a controller C, of gain crossover / f at high
        frequencies f. Where the force noise moves an axis at rest, its speed is correlated with that noise.

        Args:
            residual: residual of the balance under a model, V, (n,).
            axis: parameters of that model.
            largely: whether the residual is systematic; the encoder noise is then compared with a share of its power.
        """
        f, p = welch(residual, 1.0 / self.step, nperseg=int(min(len(residual), 1.0 / self.step)))
        noise = 2.0 * self.encoder_noise**2 * self.step / self.thinning * (axis.mass * (2 * np.pi * f) ** 2) ** 2
        read = (f > FORCE_NOISE[0]) & (f < FORCE_NOISE[1])
        level = np.full(len(f), max(float(np.median(p[read] - noise[read])), 0.0))
        self.largely = largely
        if largely:
            level = ENCODER_SHARE * median_filter(p, 2 * int(CORNERS[0] / f[1]) + 1)
        loud = noise > level
        self.corner, self.cache = float(np.clip(f[np.argmax(loud)] if loud.any() else np.inf, *CORNERS)), {}
        if largely:
            return
        slope = 2.0 / np.pi * axis.coulomb / max(axis.coulomb_width, 1e-9) + axis.viscous + axis.mass / REST_TIME
        pushed = float(np.sqrt(0.5 * level[0] / REST_TIME)) / slope * REST_TIME
        self.set_rest(max(self.least, pushed), max(STILL * self.encoder_noise, pushed))
        n = min(len(residual), max(8, int(WINDOW / self.step)))
        f, cross = csd(self.command, residual, 1.0 / self.step, nperseg=n)
        gain = f * np.abs(cross) / np.maximum(welch(residual, 1.0 / self.step, nperseg=n)[1], 1e-300)
        octaves = [gain[(f >= low) & (f < min(2.0 * low, NYQUIST_SHARE / self.step))] for low in OCTAVES]
        response = min((float(np.median(part)) for part in octaves if len(part)), default=SLOW)
        self.crossover = float(np.clip(response, SLOW, self.corner))

    @cached_property
    def fine(self) -> FineMotion:
        """Motion with sub-steps about reversals, in each of which the speed changes by at most `width`."""
        change = np.abs(np.diff(self.velocity))
        change = np.maximum(np.append(change, 0.0), np.append(0.0, change))
        n = int(np.clip(np.ceil(change.max() / max(self.width, 1e-9)), 1, MOST_SUB_STEPS))
        half, rows = max(1, round(n / self.thinning)), np.arange(len(self.time))
        near: Mask = (np.abs(self.velocity) < NEAR * change) & (change > self.width) & (half > 1)
        last = n * (len(rows) - 1)
        wanted = np.clip(n * rows[near][:, None] + np.arange(1 - half, half), 0, last)
        at = np.union1d(n * rows, wanted)
        instant, position, velocity = (np.interp(at / n, rows, x) for x in (self.time, self.position, self.velocity))
        start = instant - 0.5 * np.diff(instant, prepend=instant[0] - self.step)
        weights = (half - np.abs(np.arange(1 - half, half))) / half**2
        places = np.searchsorted(at, n * rows), np.searchsorted(at, wanted)
        return FineMotion(instant, start, position, velocity, places[0], near, places[1], weights)

    def averaged(self, table: FloatArray) -> FloatArray:
        """Return laws along the fine motion (p, m) averaged over the steps adjacent to each row, (p, n).

        The weights fall linearly to 0 at the adjacent rows. Away from a reversal the mean is the value plus a twelfth
        of the second difference.
        """
        fine = self.fine
        out = table[:, fine.rows]
        out[:, 1:-1] += np.diff(out, 2, axis=1) / (12.0 * self.thinning**2)
        if len(fine.around):
            out[:, fine.near] = table[:, fine.around] @ fine.weights
        return np.asarray(out)

    def forces(
        self, plants: Sequence[Plant], command: FloatArray | None = None, error: FloatArray | None = None
    ) -> FloatArray:
        """Return the net force of plants along the motion, V, (plants, n), without a command at 0 V.

        The encoder error is that along the fine motion, m, (m,).
        """
        t, start, x, v = self.fine[:4]
        u = np.zeros(len(t)) if command is None else np.interp(t, self.time, command)
        if error is not None:
            x, v = x - error, v - np.gradient(error, t)
        return self.averaged(Predictor(start, x, u).net_force(plants, x, v))

    def residual(
        self, model: Model, command: FloatArray | None = None, acceleration: FloatArray | None = None
    ) -> FloatArray:
        """Return the unexplained force (V, (n,)): M a less the force of the model.

        Command (V) and acceleration (m/s^2, (n,)) are the logged ones by default. The measured acceleration has the
        noise of the residual, which the change of the residual with a parameter must not have.
        """
        command = self.command if command is None else command
        a, error = self.acceleration if acceleration is None else acceleration, None
        wrong = [laws_of(e) for e in model.effects if "reading" in e.HOOKS]
        if wrong:
            error, slope, bend = self.reading_error(wrong)
            a = (1.0 - slope) * a - bend * self.velocity**2
        shaped = any(hook in e.HOOKS for e in model.effects for hook in COMMAND_HOOKS)
        force = self.forces([quiet_plant(model)], command if shaped else None, error)[0]
        if shaped:  # only what the effects change: a mean over the rows would smooth the command, but not M a
            force = force - self.averaged(np.interp(self.fine.instant, self.time, command)[None])[0]
        # the plant's force is that of sliding friction: a bristle has a state
        for stiffness in (getattr(e, "stiffness", 0.0) for e in model.effects if e.NAME == "presliding_friction"):
            if 0.0 < stiffness < np.inf and model.axis.coulomb > 0.0:
                force = force + self.bristle(model.axis, model.axis.coulomb / stiffness)
        return np.asarray(model.axis.mass * a - force - command)

    def reading_error(self, effects: list[Any]) -> tuple[FloatArray, FloatArray, FloatArray]:
        """Return the error of the reading along the fine motion, m, (m,), and its slope and curvature at each row."""
        old = self.cache.get("reading", [])  # most models that are compared share their laws
        by = SLOPE_STEP * float(np.ptp(self.position))

        def made(law: Any) -> tuple[FloatArray, FloatArray, FloatArray]:
            before, at, after = (law.reading_at(x) - x for x in (self.position - by, self.position, self.position + by))
            fine = self.fine.position
            return law.reading_at(fine) - fine, (after - before) / (2.0 * by), (after - 2.0 * at + before) / by**2

        known = [(law, next((parts for one, parts in old if one == law), None) or made(law)) for law in effects]
        self.cache["reading"] = known
        error, slope, bend = (np.sum(rows, axis=0) for rows in zip(*(parts for _, parts in known), strict=True))
        return error, slope, bend

    def loads(self, model: Model, force: FloatArray, acceleration: FloatArray) -> FloatArray:
        """Return what loads of a model behind a spring or a gap add to the residual of a rigid axis, V, (n,).

        The net force (V, (n,)) drives r / (1 - r) of the response of a load of share r at the free-free frequency. With
        a gap, the motor has the given acceleration (m/s^2, (n,)), which must not drift.
        """
        out = np.zeros(len(self.time))
        for name, fields in ((e.NAME, e.to_dict()) for e in model.effects):
            share = fields.get("mass_ratio", 0.0)
            if name == "flexible_mode" and share > 0.0 and np.isfinite(fields["frequency"]):
                swing = force - load_response(force, self.step, fields["frequency"], fields["damping_ratio"])
                out += share / (1.0 - share) * swing
            elif name == "backlash" and share > 0.0 and fields["gap"] > 0.0:
                out += share * model.axis.mass * np.sum(self.play(acceleration, fields["gap"]), axis=0)
        return out

    def play(self, acceleration: FloatArray, gap: float) -> FloatArray:
        """Return the acceleration relative to a load with a gap (m), m/s^2, (2, n): while apart, and as they meet."""
        speed, alone = lost_motion(acceleration * ~self.resting, self.step, gap)
        return np.array([alone, np.gradient(speed, self.step) - alone])

    def bristle(self, axis: AxisParameters, length: float) -> FloatArray:
        """Return the force of a Dahl contact with a presliding length (m) less that of Coulomb friction, V, (n,).

        The noise of the readings is filtered first: at rest it would wear off the deflection of the contact.
        """
        asked = 0.0 if self.reference is None else self.reference[0]
        x = asked + self.low_passed(self.position - asked, self.corner)
        alone = AxisParameters(mass=1.0, viscous=0.0, coulomb=axis.coulomb, coulomb_width=axis.coulomb_width)
        sliding = self.forces([quiet_plant(Model(axis=alone))])[0]
        return np.asarray(-axis.coulomb * dahl(x, length) - sliding)

    def added(self, model: Model, effects: Sequence[Effect], command: FloatArray | None = None) -> FloatArray:
        """Return the force that each effect adds to a moving axis, V, (effects, n), under a command (V, (n,)).

        The Coulomb level is set so high that no effect can lower it to zero.
        """
        own, hooks = model.axis, {hook for e in effects for hook in e.HOOKS}
        level = 1e6 if "friction_level" in hooks else 0.0
        axis = AxisParameters(mass=1.0, viscous=0.0, coulomb=level, coulomb_width=own.coulomb_width, travel=own.travel)
        plants = [quiet_plant(Model(axis=axis, effects=(e,))) for e in effects]
        if hooks <= {"force"}:  # nothing else acts on this axis
            return self.forces(plants)
        known = self.cache.get(level)
        if known is None or known[0] is not model or known[1] is not command:
            base = self.forces([quiet_plant(Model(axis=axis))], command)
            self.cache[level] = known = model, command, base
        return self.forces(plants, command) - known[2]


def gain_of_taps(taps: FloatArray, frequency: FloatArray) -> FloatArray:
    """Return the gain of an impulse response at frequencies in cycles per row, between those of a fine transform."""
    size = 32 * len(taps)
    return np.interp(frequency, np.fft.rfftfreq(size), np.abs(np.fft.rfft(taps, size)))


def _even(log: Log) -> tuple[FloatArray, FloatArray, FloatArray, Mask]:
    """Return time (s, from 0), position, command and the rows in gaps, on a uniform grid if the time steps vary."""
    time = log.time - log.time[0]
    steps = np.diff(time)
    h = float(np.median(steps))
    if np.abs(steps - h).max() <= UNEVEN * h:
        return time, log.position, log.command, np.zeros(len(time), dtype=bool)
    even = np.arange(0.0, time[-1], h)
    gap = np.interp(even, time[1:], steps) > GAP_STEPS * h
    return even, np.interp(even, time, log.position), mean_held(time, log.command, even, h), gap
