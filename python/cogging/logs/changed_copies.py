"""Rows of a log that another has too where they no longer stand side by side: some left out, or read between others."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from cogging.arrays import FloatArray, IntArray, Mask, cross_correlation
from cogging.logs.log import Log

WINDOW = 500  # rows that are looked at together
COPIED = 0.9  # of them, that must stand in the log of which they are a copy
LEFT = 0.4  # of the rows of that log, that must be left in the copy
DIFFERENT = 150  # of them, that must be the only ones of their kind
IN_ORDER = 0.9  # of these, that must come after the one before
BETWEEN = 3e-5  # of the spread of a column, by which a value may be off the line between two rows
MOVING = 100.0  # times as much, at least, a column must change in a window
ON_LINE = 0.9  # of the rows of a window, that must lie on the line of the other log
STEPS = 8  # of Newton's method to the shift in time


def in_order(mine: npt.NDArray[np.uint64], its: npt.NDArray[np.uint64]) -> Mask:
    """Rows of a log, (n,), that another has too in the same order, some left out; both as one number a row."""
    there, here = _among(mine, its), _among(its, mine)
    values, first, counts = np.unique(its, return_index=True, return_counts=True)
    own, own_counts = np.unique(mine, return_counts=True)
    lonely = np.intersect1d(values[counts == 1], own[own_counts == 1], assume_unique=True)
    rows = np.flatnonzero(_among(mine, lonely))
    if rows.size < DIFFERENT:
        return np.zeros(len(mine), dtype=bool)
    place = first[np.searchsorted(values, mine[rows])]
    ordered, known = np.zeros(len(mine)), np.zeros(len(mine))
    known[rows], ordered[rows] = 1.0, np.concatenate([[True], np.diff(place) > 0])
    # Of one of the two logs nearly all rows are there: those of the copy.
    whole = _share(there) >= COPIED
    whole |= (_share(there) >= LEFT) & _among(mine, its[here & (_share(here) >= COPIED)])
    whole &= (_windowed(known) >= DIFFERENT) & (_windowed(ordered) >= IN_ORDER * _windowed(known))
    return np.asarray(whole & there)


def _among(rows: npt.NDArray[np.uint64], others: npt.NDArray[np.uint64]) -> Mask:
    """Which rows are among others, (n,). By sorting: numpy 2.0 takes numbers that fill 64 bits for signed ones else."""
    return np.isin(rows, others, kind="sort")


def between_rows(log: Log, other: Log, spread: tuple[float, float]) -> Mask:
    """Rows of a log, (n,), that lie between rows of another, at other times: a copy read anew on another grid.

    The position lies on the line between two rows, the command on it too or is that of the row before, at one shift in
    time for all; spread: of position and command, (m, V).
    """
    found = np.zeros(len(log), dtype=bool)
    shift = _shift(log, other)
    if shift is None:
        return found
    at = log.time + shift
    inside = (at >= other.time[0]) & (at <= other.time[-1])
    if inside.sum() < WINDOW:
        return found
    off = np.abs(log.position - np.interp(at, other.time, other.position)) <= BETWEEN * spread[0]
    before = np.clip(np.searchsorted(other.time, at, side="right") - 1, 0, len(other) - 1)
    held = np.abs(log.command - other.command[before]) <= BETWEEN * spread[1]
    line = np.abs(log.command - np.interp(at, other.time, other.command)) <= BETWEEN * spread[1]
    moving = _range(log.position) >= MOVING * BETWEEN * spread[0]
    moving &= _range(log.command) >= MOVING * BETWEEN * spread[1]
    for same in (inside & off & line, inside & off & held):
        found |= same & (_windowed(same.astype(float)) >= ON_LINE * WINDOW) & moving
    return found


def _range(values: FloatArray) -> FloatArray:
    """Highest less lowest value of the window about each row, (n,)."""
    from scipy.ndimage import maximum_filter1d, minimum_filter1d

    return np.asarray(maximum_filter1d(values, WINDOW) - minimum_filter1d(values, WINDOW))


def _windowed(values: FloatArray) -> FloatArray:
    """Sum over the window about each row, (n,)."""
    total = np.concatenate([[0.0], np.cumsum(values)])
    rows = np.arange(len(values))
    low, high = np.maximum(rows - WINDOW // 2, 0), np.minimum(rows + WINDOW // 2, len(values))
    return np.asarray(total[high] - total[low])


def _share(rows: Mask) -> FloatArray:
    """Share of the window about each row, (n,)."""
    return _windowed(rows.astype(float)) / _windowed(np.ones(len(rows)))


def _shift(log: Log, other: Log) -> float | None:
    """By how much the time of a log is to be moved to lie on another's; None where nothing is alike."""
    step = max(float(np.median(np.diff(log.time))), float(np.median(np.diff(other.time))))
    rows = [int((one.time[-1] - one.time[0]) / step) for one in (log, other)]
    if min(rows) < WINDOW or max(rows) > 20 * (len(log) + len(other)):
        return None
    speeds = [
        np.diff(np.interp(one.time[0] + step * np.arange(n), one.time, one.position))
        for one, n in zip((log, other), rows, strict=True)
    ]
    likeness = cross_correlation(speeds[1], speeds[0])
    size = cross_correlation(speeds[1] ** 2, np.ones(len(speeds[0])))
    size = np.maximum(size, 0.1 * float(size.max()))
    likeness = likeness / np.sqrt(size) if float(size.max()) > 0.0 else likeness
    lag = int(np.argmax(likeness)) - (len(speeds[0]) - 1)
    shift = float(other.time[0] - log.time[0]) + lag * step
    return _refined(log, other, shift, step)


def _refined(log: Log, other: Log, shift: float, step: float) -> float:
    """The shift at which the positions differ least, within two rows of a first one."""
    rows: IntArray = np.flatnonzero((log.time + shift > other.time[0]) & (log.time + shift < other.time[-1]))
    start = shift
    for _ in range(STEPS):
        at = log.time[rows] + shift
        miss = log.position[rows] - np.interp(at, other.time, other.position)
        slope = (
            np.interp(at + 0.5 * step, other.time, other.position)
            - np.interp(at - 0.5 * step, other.time, other.position)
        ) / step
        power = float(slope @ slope)
        if power == 0.0:
            break
        shift = float(np.clip(shift + float(slope @ miss) / power, start - 2.0 * step, start + 2.0 * step))
    return shift
