"""Rows that stand in several logs: a copy is no new evidence, whatever it is called and from when on it counts."""

from __future__ import annotations

import dataclasses
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from cogging.arrays import FloatArray, Mask
from cogging.logs.changed_copies import between_rows, in_order
from cogging.logs.log import Log

BLOCK_BITS = 5
BLOCK = 1 << BLOCK_BITS  # rows that are compared at once, to find where logs may be the same
DIFFERENT = 12  # different rows in a block, at least: two machines at rest, or flickering by a count, look alike
STRETCH = 200  # rows that must be the same one after the other: where noise is, no repeat of a motion does that
STRETCH_DIFFERENT = 30  # different rows among those
COARSE = 1e-5  # of the spread of a column, to which it is rounded to be looked up
SAME = 1e-6  # of it, by which the same reading may differ: written with other digits, scaled, in single precision
OFFSETS = 64  # that are looked at exactly, those that most blocks speak for
ALIKE = 16  # places at which a block is looked up: a motion without noise repeats itself
MUCH = 0.25  # of the shorter log, that is a copy with rows left out or read anew: less may be like by chance
MIXERS = np.array([0x9E3779B97F4A7C15, 0xC2B2AE3D27D4EB4F, 0xFF51AFD7ED558CCD], dtype=np.uint64)


@dataclass(frozen=True)
class Spread:
    """Largest spread and size of the columns of several logs."""

    position: tuple[float, float]
    command: tuple[float, float]

    @classmethod
    def of(cls, logs: Sequence[Log]) -> Spread:
        """Over these logs."""

        def both(columns: Sequence[FloatArray]) -> tuple[float, float]:
            return max(float(np.ptp(c)) for c in columns), max(float(np.abs(c).max()) for c in columns)

        return cls(both([log.position for log in logs]), both([log.command for log in logs]))


def repeated(log: Log, other: Log) -> Mask:
    """The rows of a log that stand in another too, (n,): the same position and command, STRETCH rows on end.

    Time and references do not count: they may have been shifted, or added later. Rows may have been left out (up to
    about half of them), or read anew at other times, on the line between two rows; or all be in another unit, with
    another zero of the position.
    """
    found = np.zeros(len(log), dtype=bool)
    if min(len(log), len(other)) < STRETCH:
        return found
    found = _as_it_stands(log, other)
    if found.any() or (scaled := _in_unit_of(log, other)) is None:
        return found
    return _as_it_stands(scaled, other)


def _in_unit_of(log: Log, other: Log) -> Log | None:
    """The log with the range of position and the largest command of another; None where it has them, or none."""
    ranges = [(float(np.ptp(one.position)), float(np.abs(one.command).max())) for one in (log, other)]
    if min(min(pair) for pair in ranges) <= 0.0:
        return None
    length, command = (its / mine for mine, its in zip(*ranges, strict=True))
    position = length * (log.position - log.position.min()) + other.position.min()
    moved = abs(float(position[0] - log.position[0])) > SAME * ranges[1][0]
    if not moved and max(abs(length - 1.0), abs(command - 1.0)) < SAME:
        return None
    return Log(log.time, position, command * log.command)


def _as_it_stands(log: Log, other: Log) -> Mask:
    """The same of two logs in one unit."""
    found = np.zeros(len(log), dtype=bool)
    spread = Spread.of([log, other])
    for offset in _offsets(log, other, spread):
        first, end = max(0, -offset), min(len(log), len(other) - offset)
        if end - first < STRETCH:
            continue
        mine, its = slice(first, end), slice(first + offset, end + offset)
        same = _close(log.position[mine], other.position[its], spread.position)
        same &= _close(log.command[mine], other.command[its], spread.command)
        edges = np.flatnonzero(np.diff(np.concatenate([[False], same, [False]]).astype(np.int8)))
        for start, stop in zip(edges[::2], edges[1::2], strict=True):
            rows = slice(first + int(start), first + int(stop))
            if stop - start >= STRETCH and _different(log, rows, spread) >= STRETCH_DIFFERENT:
                found[rows] = True
    return found if found.any() else _changed(log, other, spread)


def _changed(log: Log, other: Log, spread: Spread) -> Mask:
    """The rows of a log that stand in another with some left out, or at other times."""
    with np.errstate(over="ignore"):
        numbers = [_rounded(one.position, one.command, spread) for one in (log, other)]
    for found in (in_order(*numbers), between_rows(log, other, (spread.position[0], spread.command[0]))):
        if found.sum() >= MUCH * min(len(log), len(other)):
            return found
    return np.zeros(len(log), dtype=bool)


def counted_once(
    logs: Sequence[Log], names: Sequence[str], fewest: int
) -> tuple[list[Log], list[Mask], tuple[str, ...]]:
    """Logs without rows that a longer, or an earlier, log has too.

    Args:
        logs: that are to be evidence together.
        names: of them, for the sentences.
        fewest: rows that a log must have left to count at all.

    Returns:
        The logs that are left, which rows (n,) of each given log count (none of a log that is left out), and what is
        to be said.
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
    left_over = [log if rows.all() else rows_of(log, rows) for log, rows in zip(logs, kept, strict=True) if rows.any()]
    return left_over, kept, tuple(said[i] for i in sorted(said))


def repeated_text(rows: Mask) -> str:
    """How many rows are meant, and from where on: the subject of a sentence and its verb."""
    if rows.all():
        return f"all its {rows.size} rows are"
    return f"{int(rows.sum())} of its {rows.size} rows, from row {int(np.argmax(rows))} on, are"


def rows_of(log: Log, rows: Mask) -> Log:
    """Some rows of a log."""
    columns = {field.name: getattr(log, field.name) for field in dataclasses.fields(log) if field.name != "metadata"}
    taken = {name: column[rows] for name, column in columns.items() if column is not None}
    return dataclasses.replace(log, **taken)


def _close(one: FloatArray, other: FloatArray, spread: tuple[float, float]) -> Mask:
    return np.asarray(np.abs(one - other) <= SAME * spread[0] + 4.0 * np.finfo(float).eps * spread[1])


def _rounded(position: FloatArray, command: FloatArray, spread: Spread) -> npt.NDArray[np.uint64]:
    """One number a row for its rounded position and command."""
    numbers = np.zeros(len(position), dtype=np.uint64)
    columns = ((position, spread.position, MIXERS[0]), (command, spread.command, MIXERS[1]))
    for column, (size, largest), mixer in columns:
        step = COARSE * max(size, 1e-9 * largest) or 1.0
        # Not at places where readings with a quantum would lie half-way between two.
        numbers += np.floor(column / step * 0.9 + 0.377).astype(np.int64).view(np.uint64) * mixer
        numbers ^= numbers >> np.uint64(29)
        numbers *= MIXERS[2]
    return numbers


def _blocks(numbers: npt.NDArray[np.uint64]) -> tuple[npt.NDArray[np.uint64], Mask]:
    """A number for each BLOCK rows from each row on, and whether these differ enough to be known by it."""
    hashed = numbers.copy()
    power = MIXERS[0]
    for bit in range(BLOCK_BITS):
        step = 1 << bit
        hashed = hashed[:-step] + power * hashed[step:]
        power = power * power
    # Rows that are the first of their kind within BLOCK rows: as many as there are different ones, or fewer.
    order = np.argsort(numbers, kind="stable")
    again = np.zeros(len(numbers), dtype=bool)
    again[order[1:]] = (numbers[order[1:]] == numbers[order[:-1]]) & (np.diff(order) < BLOCK)
    total = np.concatenate([[0], np.cumsum(~again)])
    return hashed, (total[BLOCK:] - total[:-BLOCK]) >= DIFFERENT


def _offsets(log: Log, other: Log, spread: Spread) -> list[int]:
    """By how many rows the log may be moved to lie on the other, the likeliest first."""
    with np.errstate(over="ignore"):
        mine, known = _blocks(_rounded(log.position, log.command, spread))
        its, its_known = _blocks(_rounded(other.position, other.command, spread))
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


def _different(log: Log, rows: slice, spread: Spread) -> int:
    with np.errstate(over="ignore"):
        return len(np.unique(_rounded(log.position[rows], log.command[rows], spread)))
