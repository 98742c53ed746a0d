"""Outliers: single readings or commands that jump away and return."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from cogging.arrays import FloatArray, Mask
from cogging.logs.log import Log

HIGH = 8.0  # times the quantile NEARLY_ALL of the distances from the median of five
NEARLY_ALL = 0.97
SMOOTH = 1e-4  # of the range of the values: least such quantile
FEW = 0.02  # of the rows: more are no outliers


def off_neighbours(values: FloatArray) -> FloatArray:
    """Return the distance of each value from the median of the five around it, (n,); 0 for two at each end."""
    off = np.zeros(len(values))
    if len(values) >= 5:
        five = np.lib.stride_tricks.sliding_window_view(values, 5)
        off[2:-2] = values[2:-2] - np.median(five, axis=1)
    return off


def spikes(values: FloatArray) -> Mask:
    """Return which values, (n,), jump away and return within two rows; none if there are many."""
    off = np.abs(off_neighbours(values))
    low, high = np.quantile(values, [0.01, 0.99]) if values.size else (0.0, 0.0)
    usual = max(float(np.quantile(off, NEARLY_ALL)) if values.size else 0.0, SMOOTH * float(high - low))
    found = off > HIGH * usual if usual > 0.0 else np.zeros(len(values), dtype=bool)
    return found if found.mean() <= FEW else np.zeros(len(values), dtype=bool)


def between(values: FloatArray, time: FloatArray, rows: Mask) -> FloatArray:
    """Return the values with those of some rows interpolated between their neighbours."""
    result = values.copy()
    result[rows] = np.interp(time[rows], time[~rows], values[~rows])
    return result


def repaired(log: Log, readings: Mask, commands: Mask) -> tuple[Log, str]:
    """Return the log with these readings and commands interpolated, and a message."""
    said = []
    for rows, what in ((readings, "reading"), (commands, "command")):
        if rows.any():
            many = int(rows.sum())
            said.append(f"{many} single {what}{'s' if many > 1 else ''}, first in row {int(np.argmax(rows))}")
    if not said:
        return log, ""
    position, command = between(log.position, log.time, readings), between(log.command, log.time, commands)
    whole = replace(log, position=position, command=command)
    return whole, f"{' and '.join(said)}, that jump away and return at once: replaced by interpolation"
