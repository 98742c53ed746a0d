"""ODrive, firmware 0.5: the anticogging map, as the array that the firmware keeps."""

from __future__ import annotations

from cogging.export.drives.form import exported, require_turn, single
from cogging.export.drives.frame import frame_of
from cogging.export.drives.sheet import Sheet
from cogging.export.drives.table import Law, table_of
from cogging.export.forms import Exported
from cogging.model.model import Model
from cogging.shown import quoted

ENTRIES = 3600
UNITS = {"torque": "Nm", "current": "A"}
SHEET = Sheet(
    drive="ODrive, firmware 0.5, anticogging map",
    quantity="torque, Nm, from 0.5.1 on; current, A, before (`--quantity current`)",
    entries="3600 over one turn",
    quantum="24 bits of a number",
    between="held: index = (int)(turns * 3600), no line between",
    sign="added to the torque (current) command",
    zero="index 0 where the encoder's position in turns is 0, which an index pulse or an absolute encoder must fix; "
    "below 0 the index is one too high, as (int) rounds towards 0",
    loading="over USB single values are read (controller.get_anticogging_value, from 0.5.6 on) and none is set: the "
    "file is the initialiser of config.anticogging.cogging_map for a build of one's own, with pre_calibrated and "
    "anticogging_enabled set",
    source="github.com/odriverobotics/ODrive, Firmware/MotorControl/controller.cpp (anticogging_calibration, update), "
    "encoder.hpp (getCoggingRatio), CHANGELOG.md (0.5.1: units of torque; 0.5.6)",
    assumed=("firmware of its own line; forks keep other numbers of entries",),
)


def make(
    model: Model,
    *,
    scale: float | None = None,
    sign: int = 1,
    zero: float = 0.0,
    reverse: bool = False,
    turn: float | None = None,
    quantity: str = "torque",
) -> Exported:
    """Make the array of the map.

    Args:
        model: with `[cogging]`, rotary.
        scale, sign, zero, reverse, turn: see frame_of.
        quantity: "torque" or "current".

    Raises:
        ValueError: what cannot be used.
    """
    if quantity not in UNITS:
        raise ValueError(f"quantity: must be one of {', '.join(UNITS)}, got {quoted(quantity)}")
    unit = UNITS[quantity]
    frame = frame_of(model, unit, scale=scale, sign=sign, zero=zero, reverse=reverse, turn=turn)
    table = table_of(frame, Law(ENTRIES, 0.0, require_turn(frame, "the map of an ODrive"), True, "hold"))
    lines = [f"// ODrive 0.5 anticogging map, {unit}, entry i from i/{ENTRIES} of a turn on", "{"]
    lines += [f"    {_literal(value)}," for value in table.values.tolist()]
    return exported(model, SHEET, table, unit, [*lines, "}"], [])


def _literal(value: float) -> str:
    """A float of C."""
    text = single(value)
    return f"{text}f"
