"""Novanta Summit drives: the cogging compensation table behind the registers 0x2306, 0x2307 and 0x2308."""

from __future__ import annotations

from cogging.export.drives.form import exported, numbered, require_entries, require_positive, single
from cogging.export.drives.frame import Frame, frame_of
from cogging.export.drives.sheet import Sheet
from cogging.export.drives.table import Law, table_of
from cogging.export.forms import Exported
from cogging.model.model import Model

SHEET = Sheet(
    drive="Novanta Summit, registers 0x2306 to 0x2308",
    quantity="current, A",
    entries="as many as the range of register 0x2307 has in the drive's dictionary (`--entries`, to be given), "
    "over one "
    "electrical period",
    quantum="24 bits of a number, assumed",
    between="linear, assumed (`--between hold`)",
    sign="an offset at the output of the torque loop",
    zero="the electrical angle chooses the index; assumed: index 0 at angle 0",
    loading="write each index to 0x2307 and its value to 0x2308 (the file: index, value), 0x2306 = 1, then store all",
    source='Novanta, Summit series documentation, "Cogging compensation" '
    "(drives.novantamotion.com/summit/cogging-compensation)",
    assumed=(
        "a positive value pushes the way the electrical angle grows (--sign)",
        "the model's position --zero is electrical angle 0, which then grows with the model's count (--reverse)",
        "straight lines between entries, as in these drives' table of the absolute feedback, but entry i at i/n of the "
        "period (--between; --zero)",
        "a 32-bit floating point number",
    ),
)


def make(
    model: Model,
    *,
    entries: int | None = None,
    scale: float | None = None,
    sign: int = 1,
    zero: float = 0.0,
    reverse: bool = False,
    turn: float | None = None,
    pole_pairs: int | None = None,
    pole_pair_width: float | None = None,
    between: str = "linear",
) -> Exported:
    """Make the list of index and value.

    Args:
        model: with `[cogging]`.
        entries: of the drive's table.
        scale, sign, zero, reverse, turn: see frame_of.
        pole_pairs: electrical periods a turn, of a rotary motor.
        pole_pair_width: the electrical period of a linear one; None: the pitch of the map.
        between: "linear" or "hold".

    Raises:
        ValueError: what cannot be used.
    """
    if entries is None:
        raise ValueError("entries: must be given: as many as register 0x2307 of the drive has, got nothing")
    frame = frame_of(model, "A", scale=scale, sign=sign, zero=zero, reverse=reverse, turn=turn)
    span = _electrical_period(frame, pole_pairs, pole_pair_width)
    table = table_of(frame, Law(require_entries(entries), 0.0, span, True, between))
    lines = ["index,value", *(f"{index},{single(value)}" for index, value in numbered(table.values))]
    return exported(model, SHEET, table, "A", lines, ["set 0x2306 to 1, then store all"])


def _electrical_period(frame: Frame, pole_pairs: int | None, width: float | None) -> float:
    """The span of the table, x.

    Raises:
        ValueError: it is not given, or is none.
    """
    if frame.turn > 0.0:
        if not isinstance(pole_pairs, int) or pole_pairs < 1:
            raise ValueError(
                f"pole_pairs: must be a whole number of at least 1 on a rotary axis, got {pole_pairs or 'nothing'}"
            )
        return frame.turn / pole_pairs
    if width is None:
        width = frame.pitch
        if width == 0.0:
            raise ValueError("pole_pair_width: must be given for a map of periods without a pitch, got nothing")
    return require_positive("pole_pair_width", width)
