"""Pauses in a log: time without rows, which a grid at the sample rate must not fill."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from cogging.arrays import FloatArray
from cogging.logs.log import Log

SPARSE = 4.0  # rows of an even grid for each row, above which pauses are cut
CUT = 0.5  # s, length of a cut pause, or ...
CUT_STEPS = 10.0  # ... this many median steps if that is longer
SPARSEST = 20.0  # rows of an even grid for each row, with pauses cut, above which a log is refused


def running_time(time: FloatArray) -> FloatArray:
    """Return the time of rows with pauses cut to CUT, s, (n,); `time` itself if pauses do not matter.

    They matter if rows at the median step would be more than SPARSE times as many: a pause of a day.
    """
    steps = np.diff(time)
    step = float(np.median(steps))
    if float(time[-1] - time[0]) <= SPARSE * time.size * step:
        return time
    cut = np.minimum(steps, max(CUT, CUT_STEPS * step))
    share = time.size * step / float(cut.sum())
    if share < 1.0 / SPARSEST:
        rule = f"must have rows in at least {100.0 / SPARSEST:g} % of the time, pauses cut to {CUT:g} s"
        raise ValueError(f"time: {rule}, got {100.0 * share:.2g} % (median step {step:g} s)")
    return np.asarray(time[0] + np.concatenate([[0.0], np.cumsum(cut)]))


def without_pauses(log: Log) -> tuple[Log, str]:
    """Return the log with pauses cut (see running_time) and a message; the log itself and "" if there are none."""
    running = running_time(log.time)
    if running is log.time:
        return log, ""
    steps = np.diff(log.time)
    pauses, longest = int(np.sum(steps > max(CUT, CUT_STEPS * float(np.median(steps))))), int(np.argmax(steps))
    found = f"{pauses} pause{'s' * (pauses > 1)} in the rows, the longest of {steps[longest]:.4g} s after row {longest}"
    cut = f"cut to {np.diff(running)[longest]:.3g} s, and all times here exclude what was cut"
    return replace(log, time=running), f"{found}: {cut}"
