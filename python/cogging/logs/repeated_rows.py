"""Rows that several logs share: a copy is no new evidence, even with rows left out, resampled or in other units."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
import numpy.typing as npt

from cogging.arrays import FloatArray, Mask, cross_correlation
from cogging.logs.log import Log

BLOCK_BITS = 5
BLOCK = 1 << BLOCK_BITS  # rows that are hashed together, to find where logs may be equal
DIFFERENT = 12  # least number of different rows in a block: machines at rest look alike
STRETCH = 200  # consecutive equal rows; with noise, no repeated motion reaches that
STRETCH_DIFFERENT = 30  # different rows among those
COARSE = 1e-5  # of the range of a column, to which it is rounded for hashing
SAME = 1e-6  # of it, by which equal readings may differ: other digits, a scale, single precision
OFFSETS = 64  # offsets that are compared exactly, those with most equal blocks
ALIKE = 16  # matches of a block that are followed: a motion without noise repeats itself
MUCH = 0.25  # of the shorter log; a smaller changed copy may be chance
WINDOW = 500  # rows of a window in which copies with changes are looked for
COPIED = 0.9  # share of a window that must be in the log of which it is a copy
LEFT = 0.4  # share of that log's rows that must remain in the copy
UNIQUE = 150  # rows of a window that must occur once in each log
IN_ORDER = 0.9  # share of these that must follow the one before
BETWEEN = 3e-5  # of the range of a column: distance from the line between two rows
MOVING = 100.0  # times BETWEEN, least change of a column in a window
ON_LINE = 0.9  # share of a window that must be on the lines of the other log
NEWTON_STEPS = 8  # to the shift in time
MIXERS = np.array([0x9E3779B97F4A7C15, 0xC2B2AE3D27D4EB4F, 0xFF51AFD7ED558CCD], dtype=np.uint64)


def _spread(*columns: FloatArray) -> tuple[float, float]:
    """Return the largest range and magnitude of a column over several logs."""
    return max(float(np.ptp(one)) for one in columns), max(float(np.abs(one).max()) for one in columns)


def repeated(log: Log, other: Log) -> Mask:
    """Return which rows of a log, (n,), are in another one: equal position and command over STRETCH rows.

    Time and references are ignored. Up to about half of the rows may have been left out, the rows may have been
    interpolated at other times, and units and the zero of the position may differ.
    """
    if min(len(log), len(other)) < STRETCH:
        return np.zeros(len(log), dtype=bool)
    found = _shared_rows(log, other)
    if found.any() or (scaled := _in_units_of(log, other)) is None:
        return found
    return _shared_rows(scaled, other)


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


def _shared_rows(log: Log, other: Log) -> Mask:
    """Return the shared rows of two logs in the same units."""
    found = np.zeros(len(log), dtype=bool)
    length, force = _spread(log.position, other.position), _spread(log.command, other.command)
    hashes = [_rounded_rows(one, length, force) for one in (log, other)]
    for offset in _offsets(*hashes):
        first, end = max(0, -offset), min(len(log), len(other) - offset)
        if end - first < STRETCH:
            continue
        mine, its = slice(first, end), slice(first + offset, end + offset)
        same = _close(log.position[mine], other.position[its], length)
        same &= _close(log.command[mine], other.command[its], force)
        edges = np.flatnonzero(np.diff(np.concatenate([[False], same, [False]]).astype(np.int8)))
        for start, stop in zip(edges[::2] + first, edges[1::2] + first, strict=True):
            if stop - start >= STRETCH:
                found[start:stop] |= len(np.unique(hashes[0][start:stop])) >= STRETCH_DIFFERENT
    if found.any():
        return found
    for found in (_in_order(*hashes), _between_rows(log, other, (length[0], force[0]))):
        if found.sum() >= MUCH * min(len(log), len(other)):
            return found
    return np.zeros(len(log), dtype=bool)


def counted_once(
    logs: Sequence[Log], names: Sequence[str], fewest: int
) -> tuple[list[Log], list[Mask], tuple[str, ...]]:
    """Return logs without the rows that a longer or earlier log contains.

    Args:
        logs: to be used together.
        names: of the logs, for the messages.
        fewest: rows that must remain; a log with fewer is left out.

    Returns:
        The remaining logs, which rows (n,) of each given log count, and messages.
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


def _close(one: FloatArray, other: FloatArray, spread: tuple[float, float]) -> Mask:
    return np.asarray(np.abs(one - other) <= SAME * spread[0] + 4.0 * np.finfo(float).eps * spread[1])


def _rounded_rows(log: Log, length: tuple[float, float], force: tuple[float, float]) -> npt.NDArray[np.uint64]:
    """Return a hash of the rounded position and command of each row."""
    numbers = np.zeros(len(log), dtype=np.uint64)
    for column, (size, largest), mixer in ((log.position, length, MIXERS[0]), (log.command, force, MIXERS[1])):
        step = COARSE * max(size, 1e-9 * largest) or 1.0
        with np.errstate(over="ignore"):
            # Scale and offset keep quantised readings away from the rounding boundaries.
            numbers += np.floor(column / step * 0.9 + 0.377).astype(np.int64).view(np.uint64) * mixer
            numbers ^= numbers >> np.uint64(29)
            numbers *= MIXERS[2]
    return numbers


def _blocks(numbers: npt.NDArray[np.uint64]) -> tuple[npt.NDArray[np.uint64], Mask]:
    """Return a hash of BLOCK rows from each row on, and whether these rows differ enough to identify the block."""
    hashed = numbers.copy()
    power = MIXERS[0]
    for bit in range(BLOCK_BITS):
        step = 1 << bit
        hashed = hashed[:-step] + power * hashed[step:]
        power = power * power
    # Count rows that do not repeat one of the BLOCK rows before.
    order = np.argsort(numbers, kind="stable")
    again = np.zeros(len(numbers), dtype=bool)
    again[order[1:]] = (numbers[order[1:]] == numbers[order[:-1]]) & (np.diff(order) < BLOCK)
    total = np.concatenate([[0], np.cumsum(~again)])
    return hashed, (total[BLOCK:] - total[:-BLOCK]) >= DIFFERENT


def _offsets(log: npt.NDArray[np.uint64], other: npt.NDArray[np.uint64]) -> list[int]:
    """Return the offsets in rows at which blocks of two logs agree, the most frequent first; both given as hashes."""
    with np.errstate(over="ignore"):
        mine, known = _blocks(log)
        its, its_known = _blocks(other)
    places = np.flatnonzero(its_known)
    order = places[np.argsort(its[places], kind="stable")]
    ordered = its[order]
    blocks = np.arange(0, len(mine), BLOCK)
    blocks = blocks[known[blocks]]
    first = np.searchsorted(ordered, mine[blocks], side="left")
    last = np.minimum(np.searchsorted(ordered, mine[blocks], side="right"), first + ALIKE)
    offsets = [order[first[hit] + k] - blocks[hit] for k in range(ALIKE) if (hit := first + k < last).any()]
    if not offsets:
        return []
    values, votes = np.unique(np.concatenate(offsets), return_counts=True)
    return [int(value) for value in values[np.argsort(-votes, kind="stable")][:OFFSETS]]


def _in_order(mine: npt.NDArray[np.uint64], its: npt.NDArray[np.uint64]) -> Mask:
    """Return which rows of a log, (n,), are in another one in the same order, some left out; both given as hashes."""
    there, here = _among(mine, its), _among(its, mine)
    values, first, counts = np.unique(its, return_index=True, return_counts=True)
    own, own_counts = np.unique(mine, return_counts=True)
    unique = np.intersect1d(values[counts == 1], own[own_counts == 1], assume_unique=True)
    rows = np.flatnonzero(_among(mine, unique))
    if rows.size < UNIQUE:
        return np.zeros(len(mine), dtype=bool)
    place = first[np.searchsorted(values, mine[rows])]
    ordered, known = np.zeros(len(mine)), np.zeros(len(mine))
    known[rows], ordered[rows] = 1.0, np.concatenate([[True], np.diff(place) > 0])
    # Nearly all rows of the copy are in the other log.
    whole = _share(there) >= COPIED
    whole |= (_share(there) >= LEFT) & _among(mine, its[here & (_share(here) >= COPIED)])
    whole &= (_windowed(known) >= UNIQUE) & (_windowed(ordered) >= IN_ORDER * _windowed(known))
    return np.asarray(whole & there)


def _among(rows: npt.NDArray[np.uint64], others: npt.NDArray[np.uint64]) -> Mask:
    """Return which rows are among others, (n,); by sorting, as numpy 2.0 treats 64-bit hashes as signed otherwise."""
    return np.isin(rows, others, kind="sort")


def _between_rows(log: Log, other: Log, spread: tuple[float, float]) -> Mask:
    """Return which rows of a log, (n,), are interpolated between rows of another one, at one shift in time.

    The position is on the line between two rows; the command is too, or is held from the row before. `spread`: range of
    position and command, (m, V).
    """
    from scipy.ndimage import maximum_filter1d, minimum_filter1d

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
    moving = np.ones(len(log), dtype=bool)
    for column, size in ((log.position, spread[0]), (log.command, spread[1])):
        moving &= maximum_filter1d(column, WINDOW) - minimum_filter1d(column, WINDOW) >= MOVING * BETWEEN * size
    for same in (inside & off & line, inside & off & held):
        found |= same & (_windowed(same.astype(float)) >= ON_LINE * WINDOW) & moving
    return found


def _windowed(values: FloatArray) -> FloatArray:
    """Return the sum over the window around each row, (n,)."""
    total = np.concatenate([[0.0], np.cumsum(values)])
    rows = np.arange(len(values))
    low, high = np.maximum(rows - WINDOW // 2, 0), np.minimum(rows + WINDOW // 2, len(values))
    return np.asarray(total[high] - total[low])


def _share(rows: Mask) -> FloatArray:
    return _windowed(rows.astype(float)) / _windowed(np.ones(len(rows)))


def _shift(log: Log, other: Log) -> float | None:
    """Return the shift (s) of a log's time at which its position best fits another one; None if the lengths do not."""
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
