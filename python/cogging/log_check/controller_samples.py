"""A log as the evenly timed samples of the controller that made it."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
import numpy.typing as npt

from cogging._core import Sampled
from cogging.arrays import FloatArray, IntArray, Mask
from cogging.logs.log import Log

LONG = 1.5  # samples between two rows, beyond which some may be missing
FILLED = 8  # consecutive missing samples that are interpolated; after more a new segment starts
FOLLOW = 0.05  # gain with which the clock follows the rows, so that jitter does not accumulate
SEGMENT = 20  # smallest number of usable rows of a segment


@dataclass(frozen=True)
class Samples:
    """The inputs of a controller, one entry a sample, (m,); without gaps these are the log's rows."""

    time: FloatArray  # s
    motion: dict[str, FloatArray]  # reference and derivatives by name, as a replay takes them
    position: FloatArray  # m; interpolated where the log has no row
    command: FloatArray  # V, likewise
    known: Mask  # whether the log has a row there
    row: npt.NDArray[np.int64]  # the row of the log, the one before where it has none
    segment: npt.NDArray[np.int64]  # number of the stretch between gaps too long to be filled

    @classmethod
    def of(cls, log: Log, reference: FloatArray, rate: float, left_out: Mask | None = None) -> Samples:
        """The samples of a log at `rate` (Hz) with a reference (m, (n,)); rows `left_out` are treated as missing."""
        motion = Sampled(log.time, reference, log.reference_velocity, log.reference_acceleration).samples
        n = len(log)
        missing = missing_samples(log.time, rate)
        parts = np.append(np.where(missing > FILLED, 0, missing), 0) + 1  # samples from each row to the next
        row = np.repeat(np.arange(n), parts)
        step = np.arange(len(row)) - (np.cumsum(parts) - parts)[row]
        at, known = row + step / parts[row], step == 0
        motion = {name: np.interp(at, np.arange(n), column) for name, column in motion.items()}
        time, position, command = (np.interp(at, np.arange(n), c) for c in (log.time, log.position, log.command))
        if left_out is not None and left_out.any():
            known = known & ~left_out[row]
            position = np.interp(at, np.flatnonzero(~left_out), log.position[~left_out])
        segment = np.concatenate([[0], np.cumsum(missing > FILLED)])[row]
        return cls(time, motion, position, command, known, row, segment)

    def judged(self, lags: Sequence[int]) -> Mask:
        """Samples with a row for the command and for the readings `lags` samples ago; not the first."""
        good = self.known.copy()
        good[0] = False
        for lag in lags:
            if lag:
                good[lag:] &= self.known[:-lag] & (self.segment[lag:] == self.segment[:-lag])
                good[:lag] &= self.segment[:lag] == 0  # the log starts without a gap
        if self.segment[-1]:
            good &= np.bincount(self.segment, good)[self.segment] >= SEGMENT
        return good

    def without_means(self, values: FloatArray, rows: Mask) -> FloatArray:
        """Values less their mean over the rows of each segment."""
        counts = np.maximum(np.bincount(self.segment, rows), 1.0)
        return np.asarray(values - (np.bincount(self.segment, values * rows) / counts)[self.segment])

    def medians(self, values: FloatArray, rows: Mask) -> FloatArray:
        """The median over the rows of each segment, one entry a sample."""
        result = np.zeros(int(self.segment[-1]) + 1)
        for number in np.unique(self.segment[rows]):
            result[number] = np.median(values[rows & (self.segment == number)])
        return result[self.segment]


def missing_samples(time: FloatArray, rate: float) -> npt.NDArray[np.int64]:
    """Number of missing controller samples between each two rows, (n - 1,); the clock may drift and jitter."""
    steps = np.diff(time)
    missing = np.zeros(len(steps), dtype=np.int64)
    own = steps[(steps > 0.5 / rate) & (steps * rate < LONG)]
    if len(own) == len(steps) or not (steps * rate > LONG).any():
        return missing
    step = float(own.mean()) if len(own) else 1.0 / rate
    late = 0.0  # of the last row against the clock, samples
    for k, passed in enumerate((steps / step).tolist()):
        samples = max(1, round(late + passed))
        missing[k] = samples - 1
        late = (late + passed - samples) * (1.0 - FOLLOW) if samples <= FILLED else 0.0
    return missing


EVEN = 0.01  # of the step: more even time stamps are kept


def on_its_clock(log: Log) -> tuple[Log, str]:
    """The log on an even clock if its readings are smoother there, with a remark; else the log as it is and "".

    Along the true times each reading is close to the cubic through its two neighbours on either side.
    """
    if len(log) < 5:
        return log, ""
    step = float(np.median(np.diff(log.time)))
    missing = missing_samples(log.time, 1.0 / step)
    segment = np.concatenate([[0], np.cumsum(missing > FILLED)])
    clock = _even(log.time, np.concatenate([[0], np.cumsum(missing + 1)]), segment)
    off = log.time - clock
    if np.abs(off).max() <= EVEN * step or not (np.diff(clock) > 0.0).all():
        return log, ""
    whole = segment[4:] == segment[:-4]
    if _roughness(clock, log.position, whole) >= _roughness(log.time, log.position, whole):
        return log, ""
    even = f"the readings are smoother on an even clock of {np.min(np.diff(clock)):.4g} s, which is used"
    return replace(log, time=clock), f"time stamps are off by {np.sqrt(np.mean(off**2)):.2g} s rms, and {even}"


def _even(time: FloatArray, row: IntArray, segment: IntArray) -> FloatArray:
    """Even times by a line through the stamps, with one slope for all segments, s, (n,)."""
    counts = np.bincount(segment)

    def means(values: FloatArray | IntArray) -> FloatArray:
        return np.asarray((np.bincount(segment, values) / counts)[segment])

    number = row - means(row)
    step = float(number @ (time - means(time))) / max(float(number @ number), 1e-300)
    return np.asarray(means(time) + step * number)


def cubic_weights(x: FloatArray) -> FloatArray:
    """Weights (4, n) with which the cubic through values at four offsets x (4, n) gives the value at 0."""
    return np.array([np.prod([x[j] / (x[j] - x[i]) for j in range(4) if j != i], axis=0) for i in range(4)])


def _roughness(time: FloatArray, position: FloatArray, whole: FloatArray) -> float:
    """Mean square of readings minus the cubic through their neighbours, normalised for white noise, m^2."""
    n = len(time) - 4
    rows = np.array([[0], [1], [3], [4]]) + np.arange(n)
    weights = cubic_weights(time[rows] - time[2 : n + 2])
    left = position[2 : n + 2] - np.sum(weights * position[rows], axis=0)
    return float(np.mean((left**2 / (1.0 + np.sum(weights**2, axis=0)))[whole])) if whole.any() else 0.0
