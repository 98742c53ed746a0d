"""Pauses in a log: times without rows, over which nothing may be laid out row by row."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from cogging.arrays import FloatArray
from cogging.logs.log import Log

SPARSE = 4.0  # times as many even rows as there are rows: from there on pauses are cut
CUT = 0.5  # s, to which they are cut, or ...
CUT_STEPS = 10.0  # ... this many median steps where that is longer
SPARSEST = 20.0  # times as many even rows as there are rows, even then: memory would go with time, not with rows


def running_time(time: FloatArray) -> FloatArray:
    """The time of rows without what their pauses have beyond CUT, s, (n,); `time` itself where pauses do not matter.

    They do where rows at the median step would be more than SPARSE times the rows there are: a pause of a day.
    """
    steps = np.diff(time)
    step = float(np.median(steps))
    if float(time[-1] - time[0]) <= SPARSE * time.size * step:
        return time
    cut = np.minimum(steps, max(CUT, CUT_STEPS * step))
    share = time.size * step / float(cut.sum())
    if share < 1.0 / SPARSEST:
        raise ValueError(
            f"time: must have rows in at least {100.0 / SPARSEST:g} % of the time, pauses cut to {CUT:g} s, got "
            f"{100.0 * share:.2g} % (median step {step:g} s)"
        )
    return np.asarray(time[0] + np.concatenate([[0.0], np.cumsum(cut)]))


def without_pauses(log: Log) -> tuple[Log, str]:
    """The log with its pauses cut (see running_time), and what is to be said of that; the log itself and "" if none is."""
    running = running_time(log.time)
    if running is log.time:
        return log, ""
    steps = np.diff(log.time)
    pauses, longest = int(np.sum(steps > max(CUT, CUT_STEPS * float(np.median(steps))))), int(np.argmax(steps))
    said = (
        f"{pauses} pause{'s' if pauses > 1 else ''} in the rows, the longest of {steps[longest]:.4g} s after row "
        f"{longest}: cut to {np.diff(running)[longest]:.3g} s, and all times here count without the rest"
    )
    return replace(log, time=running), said
