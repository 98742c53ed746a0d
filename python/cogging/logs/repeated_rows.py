"""Rows that several logs share: a copy is no new evidence, even with rows left out, resampled or in other units."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from cogging.arrays import IntArray, Mask, cross_correlation
from cogging.logs.log import Log

STRETCH = 200  # consecutive equal rows; with noise, no repeated motion reaches that
STRETCH_DIFFERENT = 30  # different rows among those: machines at rest look alike
COARSE = 1e-5  # of the range of a column, to which it is rounded to find equal rows
SAME = 1e-6  # of it, by which equal readings may differ: other digits, a scale, single precision
OFFSETS = 64  # offsets that are compared exactly, those with most equal rows
MUCH = 0.25  # of the shorter log; a smaller changed copy may be chance
WINDOW = 500  # rows of a window in which copies with changes are looked for
BETWEEN = 3e-5  # of the range of a column: distance from the line between two rows
MOVING = 100.0  # times BETWEEN, least change of a column in a window
ON_LINE = 0.9  # share of a window that must be on the lines of the other log
NEWTON_STEPS = 8  # to the shift in time


def repeated(log: Log, other: Log) -> Mask:
    """Return which rows of a log, (n,), are in another one: equal position and command over STRETCH rows.

    Time and references are ignored for equal rows. Up to about half of the rows may have been left out, or the rows
    interpolated at other times; units and the zero of the position may differ.
    """
    none = np.zeros(len(log), dtype=bool)
    if min(len(log), len(other)) < STRETCH:
        return none
    for mine in filter(None, (log, _in_units_of(log, other))):
        pairs = ((mine.position, other.position), (mine.command, other.command))
        spread = [(max(map(np.ptp, both)), max(float(np.abs(one).max()) for one in both)) for both in pairs]
        keys = _rounded_rows(mine, other, spread)
        if (found := _equal_rows(mine, other, keys, spread)).any():
            return found
        copied = _rows_between(other, mine, spread)  # rows of the other log, where this log lacks some
        for found in (_rows_between(mine, other, spread), np.isin(keys[0], keys[1][copied])):
            if found.sum() >= MUCH * min(len(log), len(other)):
                return np.asarray(found)
    return none


def counted_once(
    logs: Sequence[Log], names: Sequence[str], fewest: int
) -> tuple[list[Log], list[Mask], tuple[str, ...]]:
    """Return logs without the rows that a longer or earlier log contains.

    `fewest`: rows that must remain; a log with fewer is left out. Also returned: which rows (n,) of each given log
    count, and messages that use the `names`.
    """
    order = sorted(range(len(logs)), key=lambda i: -len(logs[i]))
    kept = [np.ones(len(log), dtype=bool) for log in logs]
    said: dict[int, str] = {}
    for place, i in enumerate(order):
        for j in order[:place]:
            if not kept[j].any() or not (rows := repeated(logs[i], logs[j]) & kept[i]).any():
                continue
            kept[i] &= ~rows
            left = int(kept[i].sum())
            before = f"{said[i]}; " if i in said else f"{names[i]}: "
            said[i] = f"{before}{repeated_text(rows)} in {names[j]} too: counted once"
            if left < fewest:
                kept[i][:] = False
                said[i] += f", and the other {left} are too few to count" if left else ""
                break
    left_over = [log if rows.all() else log[rows] for log, rows in zip(logs, kept, strict=True) if rows.any()]
    return left_over, kept, tuple(said[i] for i in sorted(said))


def repeated_text(rows: Mask) -> str:
    """Return the number and the start of some rows, as subject and verb of a sentence."""
    if rows.all():
        return f"all its {rows.size} rows are"
    return f"{int(rows.sum())} of its {rows.size} rows, from row {int(np.argmax(rows))} on, are"


Spread = Sequence[tuple[float, float]]  # range and magnitude of position and command over two logs


def _in_units_of(log: Log, other: Log) -> Log | None:
    """Return the log scaled to the position range and largest command of another; None if it has them already."""
    ranges = [(float(np.ptp(one.position)), float(np.abs(one.command).max())) for one in (log, other)]
    if min(min(pair) for pair in ranges) <= 0.0:
        return None
    length, command = (its / mine for mine, its in zip(*ranges, strict=True))
    position = length * (log.position - log.position.min()) + other.position.min()
    moved = abs(float(position[0] - log.position[0])) > SAME * ranges[1][0]
    if not moved and max(abs(length - 1.0), abs(command - 1.0)) < SAME:
        return None
    return Log(log.time, position, command * log.command)


def _rounded_rows(log: Log, other: Log, spread: Spread) -> list[IntArray]:
    """Return a whole number for the rounded position and command of each row of both logs."""
    keys = [np.zeros(len(one), dtype=np.intp) for one in (log, other)]
    for name, (size, largest) in zip(("position", "command"), spread, strict=True):
        columns = [getattr(one, name) for one in (log, other)]
        least, step = min(map(np.min, columns)), COARSE * max(size, 1e-9 * largest) or 1.0
        for key, column in zip(keys, columns, strict=True):
            key *= 1 << 20
            # Scale and offset keep quantised readings away from the rounding boundaries.
            key += np.floor((column - least) / step * 0.9 + 0.377).astype(np.intp)
    return keys


def _equal_rows(log: Log, other: Log, keys: Sequence[IntArray], spread: Spread) -> Mask:
    """Return which rows, (n,), are equal to those of another log over STRETCH rows, at one of several offsets."""
    found = np.zeros(len(log), dtype=bool)
    known, first = np.unique(keys[1], return_index=True)
    at = np.minimum(np.searchsorted(known, keys[0]), len(known) - 1)
    rows = np.flatnonzero(known[at] == keys[0])
    offsets, votes = np.unique(first[at[rows]] - rows, return_counts=True)
    for offset in offsets[np.argsort(-votes, kind="stable")][:OFFSETS].tolist():
        start, end = max(0, -offset), min(len(log), len(other) - offset)
        if end - start < STRETCH:
            continue
        same = np.ones(end - start, dtype=bool)
        for name, (size, largest) in zip(("position", "command"), spread, strict=True):
            off = np.abs(getattr(log, name)[start:end] - getattr(other, name)[start + offset : end + offset])
            same &= off <= SAME * size + 4.0 * np.finfo(float).eps * largest
        edges = np.flatnonzero(np.diff(np.concatenate([[False], same, [False]]).astype(np.int8))) + start
        for one, stop in zip(edges[::2], edges[1::2], strict=True):
            if stop - one >= STRETCH:
                found[one:stop] |= len(np.unique(keys[0][one:stop])) >= STRETCH_DIFFERENT
    return found


def _rows_between(log: Log, other: Log, spread: Spread) -> Mask:
    """Return which rows, (n,), lie between rows of another log at one shift in time; the command may be held."""
    from scipy.ndimage import maximum_filter1d, minimum_filter1d

    found = np.zeros(len(log), dtype=bool)
    shift = _shift(log, other)
    if shift is None:
        return found
    at = log.time + shift
    inside = (at >= other.time[0]) & (at <= other.time[-1])
    if inside.sum() < WINDOW:
        return found
    close = [BETWEEN * size for size, _ in spread]
    near = inside & (np.abs(log.position - np.interp(at, other.time, other.position)) <= close[0])
    held = other.command[np.clip(np.searchsorted(other.time, at, side="right") - 1, 0, len(other) - 1)]
    moving = np.ones(len(log), dtype=bool)
    for column, least in zip((log.position, log.command), close, strict=True):
        moving &= maximum_filter1d(column, WINDOW) - minimum_filter1d(column, WINDOW) >= MOVING * least
    rows = np.arange(len(log))
    low, high = np.maximum(rows - WINDOW // 2, 0), np.minimum(rows + WINDOW // 2, len(log))
    for command in (np.interp(at, other.time, other.command), held):
        same = near & (np.abs(log.command - command) <= close[1])
        total = np.concatenate([[0], np.cumsum(same)])
        found |= same & (total[high] - total[low] >= ON_LINE * (high - low)) & moving
    return found


def _shift(log: Log, other: Log) -> float | None:
    """Return the shift (s) of a log's time at which its position best fits another one; None if the lengths do not."""
    step = max(float(np.median(np.diff(log.time))), float(np.median(np.diff(other.time))))
    rows = [int((one.time[-1] - one.time[0]) / step) for one in (log, other)]
    if min(rows) < WINDOW or max(rows) > 20 * (len(log) + len(other)):
        return None
    pairs = zip((log, other), rows, strict=True)
    speeds = [np.diff(np.interp(one.time[0] + step * np.arange(n), one.time, one.position)) for one, n in pairs]
    likeness = cross_correlation(speeds[1], speeds[0])
    size = cross_correlation(speeds[1] ** 2, np.ones(len(speeds[0])))
    size = np.maximum(size, 0.1 * float(size.max()))
    likeness = likeness / np.sqrt(size) if float(size.max()) > 0.0 else likeness
    lag = int(np.argmax(likeness)) - (len(speeds[0]) - 1)
    start = shift = float(other.time[0] - log.time[0]) + lag * step
    inside = np.flatnonzero((log.time + shift > other.time[0]) & (log.time + shift < other.time[-1]))
    for _ in range(NEWTON_STEPS):  # refine within two rows
        at = log.time[inside] + shift
        miss = log.position[inside] - np.interp(at, other.time, other.position)
        ends = [np.interp(at + way * step, other.time, other.position) for way in (0.5, -0.5)]
        slope = (ends[0] - ends[1]) / step
        power = float(slope @ slope)
        if power == 0.0:
            break
        shift = float(np.clip(shift + float(slope @ miss) / power, start - 2.0 * step, start + 2.0 * step))
    return shift
