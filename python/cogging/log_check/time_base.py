"""The times at which the readings of a log were taken: its stamps, or the even clock that the stamps are noisy of."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from cogging.arrays import FloatArray, IntArray
from cogging.log_check.controller_samples import FILLED, missing_samples
from cogging.logs.log import Log

EVEN = 0.01  # of the step: stamps that are evener than this stand


def on_its_clock(log: Log) -> tuple[Log, str]:
    """The log at the times at which its readings were taken, and what is to be said of that; "" where stamps stand.

    A controller samples evenly, and a logger may stamp its rows late or early: of an axis at 0.4 m/s, 0.3 ms are
    0.1 mm, and pass for acceleration. Or the rows were taken as unevenly as they are stamped. The readings tell: along
    the true times they are smooth, so that each lies near the cubic through the two on either side.
    """
    if len(log) < 5:
        return log, ""
    step = float(np.median(np.diff(log.time)))
    missing = missing_samples(log.time, 1.0 / step)
    row = np.concatenate([[0], np.cumsum(missing + 1)])
    segment = np.concatenate([[0], np.cumsum(missing > FILLED)])
    clock = _even(log.time, row, segment)
    off = log.time - clock
    if np.abs(off).max() <= EVEN * step or not (np.diff(clock) > 0.0).all():
        return log, ""
    whole = segment[4:] == segment[:-4]
    if _roughness(clock, log.position, whole) >= _roughness(log.time, log.position, whole):
        return log, ""
    return replace(log, time=clock), (
        f"time stamps are off by {np.sqrt(np.mean(off**2)):.2g} s rms, and the readings smoother on an even clock of "
        f"{np.min(np.diff(clock)):.4g} s, which is taken"
    )


def _even(time: FloatArray, row: IntArray, segment: IntArray) -> FloatArray:
    """The line through the stamps over their numbers, of one slope in all segments, s, (n,)."""
    counts = np.bincount(segment)

    def means(values: FloatArray | IntArray) -> FloatArray:
        return np.asarray((np.bincount(segment, values) / counts)[segment])

    number = row - means(row)
    step = float(number @ (time - means(time))) / max(float(number @ number), 1e-300)
    return np.asarray(means(time) + step * number)


def _roughness(time: FloatArray, position: FloatArray, whole: FloatArray) -> float:
    """Mean square of readings less the cubic through their two neighbours on either side, over noise's, m^2."""
    n = len(time) - 4
    others = [0, 1, 3, 4]
    middle = time[2 : n + 2]
    near = {i: time[i : n + i] - middle for i in others}
    left, gain = position[2 : n + 2].copy(), np.ones(n)
    for i in others:
        weight = np.prod([near[j] / (near[j] - near[i]) for j in others if j != i], axis=0)
        left -= weight * position[i : n + i]
        gain += weight**2
    return float(np.mean((left**2 / gain)[whole])) if whole.any() else 0.0
