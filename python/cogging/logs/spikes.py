"""Single values that leave and return: readings, or commands, that nobody ever saw."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from cogging.arrays import FloatArray, Mask
from cogging.logs.log import Log

HIGH = 8.0  # times what nearly all values are off the median of five by
NEARLY_ALL = 0.97
SMOOTH = 1e-4  # of the range of the values, at least, where they are smooth
FEW = 0.02  # of the rows: more are no outliers


def off_neighbours(values: FloatArray) -> FloatArray:
    """By how much each value is off the median of the five about it, (n,); 0 for the two at each end."""
    off = np.zeros(len(values))
    if len(values) >= 5:
        five = np.lib.stride_tricks.sliding_window_view(values, 5)
        off[2:-2] = values[2:-2] - np.median(five, axis=1)
    return off


def spikes(values: FloatArray) -> Mask:
    """Values that leave and return within two rows by far more than any others do; none where they are many."""
    off = np.abs(off_neighbours(values))
    low, high = np.quantile(values, [0.01, 0.99]) if values.size else (0.0, 0.0)
    usual = max(float(np.quantile(off, NEARLY_ALL)) if values.size else 0.0, SMOOTH * float(high - low))
    found = off > HIGH * usual if usual > 0.0 else np.zeros(len(values), dtype=bool)
    return found if found.mean() <= FEW else np.zeros(len(values), dtype=bool)


def between(values: FloatArray, time: FloatArray, rows: Mask) -> FloatArray:
    """The values with those of some rows put on the line between their neighbours."""
    result = values.copy()
    result[rows] = np.interp(time[rows], time[~rows], values[~rows])
    return result


def repaired(log: Log, readings: Mask, commands: Mask) -> tuple[Log, str]:
    """The log with these readings and commands put between their neighbours, and what is to be said of that."""
    said = []
    for rows, what in ((readings, "reading"), (commands, "command")):
        if rows.any():
            many = int(rows.sum())
            said.append(f"{many} single {what}{'s' if many > 1 else ''}, first in row {int(np.argmax(rows))}")
    if not said:
        return log, ""
    whole = replace(
        log,
        position=between(log.position, log.time, readings),
        command=between(log.command, log.time, commands),
    )
    return whole, f"{' and '.join(said)}, that leave and return at once: put between their neighbours"
