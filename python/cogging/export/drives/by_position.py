"""Plain CSV: position and force, for a drive or program that has no form here."""

from __future__ import annotations

from cogging.export.drives.form import exported, require_entries, require_turn, travel_of
from cogging.export.drives.frame import Frame, frame_of
from cogging.export.drives.sheet import Sheet
from cogging.export.drives.table import Law, table_of
from cogging.export.forms import Exported
from cogging.model.model import Model
from cogging.shown import quoted

RANGES = ("travel", "turn", "period")
SHEET = Sheet(
    drive="Plain CSV by position",
    quantity="the command that holds the axis against the cogging, in the model's command unit, or another by "
    "`--scale`",
    entries="any number (`--entries`, 1000), over the travel, a turn, or one period (`--over`)",
    quantum="17 digits, nothing lost",
    between="linear, or held to the next row (`--between hold`: the rows are then the middles of what they hold for)",
    sign="to be added to the command; `--sign -1` gives the force of the motor instead",
    zero="first row at the start of the range; position as the model counts, or from `--zero`, or the other way by "
    "`--reverse`",
    loading="the user's own means",
    source="this project: columns `position`, `force`, one row an entry",
    assumed=(),
)


def make(
    model: Model,
    *,
    entries: int = 1000,
    over: str | None = None,
    scale: float | None = None,
    sign: int = 1,
    zero: float = 0.0,
    reverse: bool = False,
    turn: float | None = None,
    between: str = "linear",
) -> Exported:
    """Make a table of position and force.

    Args:
        model: with `[cogging]`.
        entries: rows.
        over: "travel", "turn" or "period"; None: the turn of a rotary axis, else the travel, else the period.
        scale, sign, zero, reverse, turn: see frame_of.
        between: "linear" or "hold".

    Raises:
        ValueError: what cannot be used.
    """
    unit = model.units.command
    frame = frame_of(model, unit, scale=scale, sign=sign, zero=zero, reverse=reverse, turn=turn)
    start, span, wraps = _range(frame, over)
    law = Law(require_entries(entries), start, span, wraps, between)
    table = table_of(frame, law, quantum=None)
    rows = [f"{place!r},{value!r}" for place, value in zip(law.places.tolist(), table.values.tolist(), strict=True)]
    return exported(model, SHEET, table, unit, ["position,force", *rows], [])


def _range(frame: Frame, over: str | None) -> tuple[float, float, bool]:
    """Start and span of the table, and whether it repeats.

    Raises:
        ValueError: the range cannot be had from the model.
    """
    if over is None:
        over = "turn" if frame.turn > 0.0 else "travel" if frame.bounded else "period"
    if over not in RANGES:
        raise ValueError(f"over: must be one of {', '.join(RANGES)}, got {quoted(over)}")
    if over == "turn":
        return 0.0, require_turn(frame, "this range"), True
    if over == "travel":
        low, high = travel_of(frame)
        return low, high - low, False
    longest = frame.pitch or float(frame.periods.max())
    return 0.0, longest, True
