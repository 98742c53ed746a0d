"""What the forms of drives share: numbers that are asked for, the file, and the text beside it."""

from __future__ import annotations

import math
from collections.abc import Iterable

import numpy as np

from cogging.arrays import FloatArray
from cogging.export.drives.frame import Frame
from cogging.export.drives.sheet import Sheet
from cogging.export.drives.table import Table
from cogging.export.drives.told import told
from cogging.export.forms import Exported
from cogging.model.model import Model
from cogging.shown import quoted

MOST_ENTRIES = 1 << 20


def exported(
    model: Model, sheet: Sheet, table: Table, unit: str, lines: Iterable[str], notes: Iterable[str]
) -> Exported:
    """The file, the text beside it and what is said.

    Args:
        model: that it was made of.
        sheet: of the drive.
        table: as it keeps it.
        unit: of an entry.
        lines: of the file.
        notes: what to set in the drive beside the table, a line each.
    """
    said = told(sheet, table, model.units, unit, sheet.assumed)
    beside = "\n".join([sheet.text(), "", "This file:", *notes, said, ""])
    shown = "\n".join([said, *notes])
    return Exported(("\n".join(lines) + "\n").encode(), shown, {".txt": beside.encode()})


def single(value: float) -> str:
    """A number of 24 bits, as few digits as bring it back."""
    return str(np.float32(value))


def require_entries(entries: int, most: int = MOST_ENTRIES) -> int:
    """Refuse a number of entries out of range.

    Raises:
        ValueError: names the rule and the value.
    """
    if not isinstance(entries, int) or not 2 <= entries <= most:
        raise ValueError(f"entries: must be a whole number from 2 to {most}, got {quoted(entries)}")
    return entries


def require_positive(name: str, value: float) -> float:
    """Refuse what is no positive finite number.

    Raises:
        ValueError: names the rule and the value.
    """
    if not (math.isfinite(value) and value > 0.0):
        raise ValueError(f"{name}: must be finite and above 0, got {quoted(value)}")
    return value


def require_turn(frame: Frame, drive: str) -> float:
    """The turn of a drive whose table covers a revolution.

    Raises:
        ValueError: the axis is linear.
    """
    if frame.turn == 0.0:
        raise ValueError(f"turn: must be given: {drive} covers one revolution, got a linear axis")
    return frame.turn


def travel_of(frame: Frame) -> tuple[float, float]:
    """The ends of the motion at the drive's own position.

    Raises:
        ValueError: the model does not say them.
    """
    if not frame.bounded:
        rule = "must have two finite ends where a table covers the travel of a linear axis (or give turn)"
        raise ValueError(f"axis.travel: {rule}, got [{frame.low:g}, {frame.high:g}]")
    low, high = np.sort(frame.place(np.array([frame.low, frame.high])))
    return float(low), float(high)


def numbered(values: FloatArray) -> Iterable[tuple[int, float]]:
    """Entries with their index, from 0."""
    return enumerate(values.tolist())
