"""Kollmorgen AKD: the cogging compensation table, as CSV."""

from __future__ import annotations

from cogging.export.drives.form import exported, require_entries, require_positive, travel_of
from cogging.export.drives.frame import frame_of
from cogging.export.drives.sheet import Sheet
from cogging.export.drives.table import Law, table_of
from cogging.export.forms import Exported
from cogging.model.model import Model

ENTRIES = 8192
DIGITS = 9
SHEET = Sheet(
    drive="Kollmorgen AKD, cogging compensation table",
    quantity="current, A: the values become current of the drive directly",
    entries="8192, evenly over one revolution (rotary) or over a range that the user gives (linear: "
    "COGCOMP.RANGELOW to "
    "COGCOMP.RANGEHIGH); fewer by `--entries`",
    quantum="0.001 A, assumed (`--quantum`)",
    between="linear, assumed (`--between hold`)",
    sign="added to the current command as a feedforward",
    zero="assumed: entry 0 at position 0 of the homed or absolute feedback, or at the low end of the range; "
    "entries go with the "
    "drive's own count",
    loading="WorkBench, Current Loop, Cogging Compensation: import from csv while the drive is disabled; then "
    "COGCOMP.EN. "
    "Without absolute feedback the drive must be homed first, else it warns and adds nothing",
    source='Kollmorgen, AKD User Manual and WorkBench online help, topic "Cogging Compensation"; the range\'s '
    "keywords: KAS "
    'help, topic "Cogging Compensation" of the AKD2G, table of AKD keywords '
    "(webhelp.kollmorgen.com/kas3.07/Content/AKD2G_User_Manual/Cogging_Compensation.htm)",
    assumed=(
        "layout of the csv: one value a line, in the order of the entries, no header",
        "unit A, as the drive's other currents (peak or rms is not told: --scale), in steps of 0.001 A (--quantum)",
        "a positive value pushes the way the drive counts up (--sign)",
        "entry 0 at the drive's position 0 or the low end of the range, the last at its high end (--zero, --reverse)",
        "straight lines between entries (--between)",
    ),
)


def make(
    model: Model,
    *,
    entries: int = ENTRIES,
    scale: float | None = None,
    sign: int = 1,
    zero: float = 0.0,
    reverse: bool = False,
    turn: float | None = None,
    between: str = "linear",
    quantum: float = 0.001,
) -> Exported:
    """Make the csv of the table.

    Args:
        model: with `[cogging]`; on a linear axis the table covers the travel.
        entries: at most 8192.
        scale, sign, zero, reverse, turn: see frame_of.
        between: "linear" or "hold".
        quantum: of an entry, A.

    Raises:
        ValueError: what cannot be used.
    """
    frame = frame_of(model, "A", scale=scale, sign=sign, zero=zero, reverse=reverse, turn=turn)
    require_entries(entries, ENTRIES)
    notes = []
    if frame.turn > 0.0:
        law = Law(entries, 0.0, frame.turn, True, between)
    else:
        low, high = travel_of(frame)
        law = Law(entries, low, high - low, False, between)
        ends = " and ".join(
            f"COGCOMP.RANGE{name} to {end:.9g} {model.units.position}" for name, end in (("LOW", low), ("HIGH", high))
        )
        notes.append(f"set {ends}, in the drive's own unit")
    table = table_of(frame, law, quantum=require_positive("quantum", quantum))
    return exported(model, SHEET, table, "A", [f"{value:.{DIGITS}g}" for value in table.values.tolist()], notes)
