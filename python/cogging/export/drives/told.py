"""What `cogging export` says of a table: what the drive will take of the map, and what it cannot."""

from __future__ import annotations

from cogging.export.drives.frame import Frame
from cogging.export.drives.sheet import Sheet
from cogging.export.drives.table import ALONE, Rest, Table, misfits
from cogging.model.units import Units

SHOWN = 5  # periods that are listed


def told(sheet: Sheet, table: Table, units: Units, unit: str, assumed: tuple[str, ...]) -> str:
    """Entries, quantum, the share that is removed and what is left, in lines for the screen.

    Args:
        sheet: of the drive.
        table: as it keeps it.
        units: of the model.
        unit: of an entry.
        assumed: what no source tells.
    """
    law, frame = table.law, table.frame
    bits = f"{53 if table.quantum is None else 24}-bit numbers in {unit}"
    entry = f"steps of {table.quantum:.6g} {unit}" if table.quantum else bits
    size = max(abs(float(table.values.max())), abs(float(table.values.min())))
    lines = [
        f"{sheet.drive}: {law.entries} entries, {entry}, largest {size:.6g} {unit}",
        f"over {law.span:.6g} {units.position} of the drive's own position, from {law.start:.6g}, "
        f"{'repeated' if law.wraps else 'nothing outside'}; {frame_line(frame, units, unit)}",
        *rest_lines(table.rest, units.command),
        *cannot(frame, law.span, table.rest, units, wraps=law.wraps),
        *left_out_lines(frame),
        *assumed_lines(frame, units, unit, assumed),
    ]
    return "\n".join(lines)


def left_out_lines(frame: Frame) -> list[str]:
    """Effects of the model that are in no table of cogging."""
    return [f"not in it, as no cogging: {', '.join(frame.left_out)}"] if frame.left_out else []


def assumed_lines(frame: Frame, units: Units, unit: str, assumed: tuple[str, ...]) -> list[str]:
    """What nobody has told: of the drive, and of the model's unit."""
    own = [] if frame.scale_said else [f"1 {units.command} of the model is 1 {unit} (--scale, or [units] of the model)"]
    return [f"assumed: {one}" for one in (*own, *assumed)]


def rest_lines(rest: Rest, unit: str) -> list[str]:
    """How much of the cogging is removed."""
    share = f"{100.0 * rest.removed:.5g} % of the cogging's rms"
    return [f"removes {share}, {rest.cogging:.4g} {unit} to {rest.left:.3g} {unit}, if the drive reads it so"]


def cannot(frame: Frame, span: float, rest: Rest, units: Units, *, wraps: bool) -> list[str]:
    """What the form cannot hold, and why."""
    lines = []
    if rest.span > ALONE * rest.cogging and wraps:
        why = []
        found = misfits(frame, span)
        if found:
            listed = ", ".join(f"{period:.5g}" for period in found[:SHOWN]) + ", ..." * (len(found) > SHOWN)
            why.append(f"periods that do not go into {span:.5g} {units.position}: {listed}")
        if frame.modulated:
            why.append("amplitudes that change along the travel")
        lines.append(f"cannot hold {rest.span:.3g} {units.command} rms: {'; '.join(why) or 'other spans differ'}")
    if rest.entries > ALONE * rest.cogging:
        lines.append(f"leaves {rest.entries:.3g} {units.command} rms between its entries and in their last digit")
    return lines


def frame_line(frame: Frame, units: Units, unit: str) -> str:
    """Zero, direction, sign and scale."""
    way = "counts as the model does" if frame.direction > 0 else "counts and pushes the other way"
    sign = "adds the entry to its command" if frame.sign > 0 else "takes the entry off its command"
    scale = f", {frame.scale:.6g} {unit} per {units.command}" if frame.scale != 1.0 or unit != units.command else ""
    return f"its zero at {frame.zero:.6g} {units.position}, it {way} and {sign}{scale}"
