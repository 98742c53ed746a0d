"""mjbots moteus: motor.cogging_dq_scale and the 1024 entries of motor.cogging_dq_comp."""

from __future__ import annotations

import numpy as np

from cogging.export.drives.form import exported, require_turn, single
from cogging.export.drives.frame import frame_of
from cogging.export.drives.sheet import Sheet
from cogging.export.drives.table import Law, table_of
from cogging.export.forms import Exported
from cogging.model.model import Model

ENTRIES = 1024
STEPS = 127  # of an int8, either way
SHEET = Sheet(
    drive="mjbots moteus, motor.cogging_dq_comp",
    quantity="q current, A",
    entries="1024 over one revolution of the commutation encoder",
    quantum="int8 times motor.cogging_dq_scale: 1/127 of the largest",
    between="linear",
    sign="added to the q current in position mode, behind the torque limit",
    zero="entry 0 at 0 of the commutation encoder's filtered value, with its offset and sign; entries go with it",
    loading="`moteus_tool --write-config FILE`: `conf set` lines and `conf write`",
    source="github.com/mjbots/moteus, fw/bldc_servo_control.h (ISR_DoPositionCommon), fw/bldc_servo_structs.h "
    "(cogging_dq_scale), utils/compensate_cogging.py",
    assumed=("a positive q current pushes the way the commutation encoder counts up (--sign)",),
)


def make(
    model: Model,
    *,
    scale: float | None = None,
    sign: int = 1,
    zero: float = 0.0,
    reverse: bool = False,
    turn: float | None = None,
) -> Exported:
    """Make the lines that set the table.

    Args:
        model: with `[cogging]`, rotary.
        scale, sign, zero, reverse, turn: see frame_of.

    Raises:
        ValueError: what cannot be used.
    """
    frame = frame_of(model, "A", scale=scale, sign=sign, zero=zero, reverse=reverse, turn=turn)
    law = Law(ENTRIES, 0.0, require_turn(frame, "the table of a moteus"), True, "linear")
    table = table_of(frame, law, steps=STEPS)
    quantum = table.quantum or 1.0
    whole = np.round(table.values / quantum).astype(int).tolist()
    lines = [f"conf set motor.cogging_dq_scale {single(quantum)}"]
    lines += [f"conf set motor.cogging_dq_comp.{index} {value}" for index, value in enumerate(whole)]
    return exported(model, SHEET, table, "A", [*lines, "conf write"], [])
