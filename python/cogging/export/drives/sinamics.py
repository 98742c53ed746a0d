"""Siemens SINAMICS: the compensation values p5260[0..4095] of the cogging torque compensation."""

from __future__ import annotations

from cogging.export.drives.form import exported, numbered, require_positive, single, travel_of
from cogging.export.drives.frame import frame_of
from cogging.export.drives.sheet import Sheet
from cogging.export.drives.table import Law, table_of
from cogging.export.forms import Exported
from cogging.model.model import Model

ENTRIES = 4096
SHEET = Sheet(
    drive="Siemens SINAMICS S120, p5260[0..4095]",
    quantity="torque, Nm, of rotary motors; force, N, of linear ones",
    entries="4096 over one period of the table: p5253 mechanical revolutions, or p5253 pole pair widths (p0315) "
    "of a linear "
    "motor, for which the whole travel is recommended",
    quantum="24 bits of a number, assumed",
    between="held, assumed (`--between linear`)",
    sign="added to the torque setpoint (r5255[1] shows the precontrolled torque)",
    zero="assumed: index 0 at position 0 of an encoder that knows its place within the period; indices go with the "
    "drive's count",
    loading="write the parameters p5260[i] (the file: parameter, index, value), p5253 as said beside it, then "
    "activate by "
    "p5250; p5250.1 = 0: one table for both directions",
    source="Siemens, SINAMICS S120 Drive Functions, Function Manual 11/2017, 6SL3097-4AB00-0BP5, section 8.15 "
    '"Cogging torque compensation", page 631',
    assumed=(
        "a positive value pushes the way the drive counts up (--sign)",
        "index 0 at the encoder's position 0 (--zero, --reverse); r5254[1] shows the index in use: compare it",
        "an entry holds until the next index (--between), a 32-bit floating point number",
    ),
)


def make(
    model: Model,
    *,
    scale: float | None = None,
    sign: int = 1,
    zero: float = 0.0,
    reverse: bool = False,
    turn: float | None = None,
    between: str = "hold",
    pole_pair_width: float | None = None,
) -> Exported:
    """Make the list of parameters.

    Args:
        model: with `[cogging]`; on a linear axis the table covers the travel.
        scale, sign, zero, reverse, turn: see frame_of.
        between: "linear" or "hold".
        pole_pair_width: p0315 of a linear motor; None: the pitch of the map.

    Raises:
        ValueError: what cannot be used.
    """
    rotary = turn > 0.0 if turn is not None else model.units.position == "rad"
    unit = "Nm" if rotary else "N"
    frame = frame_of(model, unit, scale=scale, sign=sign, zero=zero, reverse=reverse, turn=turn)
    if frame.turn > 0.0:
        law, factor = Law(ENTRIES, 0.0, frame.turn, True, between), 1.0
    else:
        low, high = travel_of(frame)
        width = pole_pair_width if pole_pair_width is not None else frame.pitch or high - low
        # The table repeats, and its index 0 need not be where the travel begins: two entries beside the travel keep its
        # ends apart.
        span = (high - low) * ENTRIES / (ENTRIES - 2)
        factor = span / require_positive("pole_pair_width", width)
        law = Law(ENTRIES, 0.0, span, True, between)
    table = table_of(frame, law)
    lines = ["parameter,index,value", *(f"p5260,{index},{single(value)}" for index, value in numbered(table.values))]
    return exported(model, SHEET, table, unit, lines, [f"set p5253 to {factor:.9g}"])
