"""Which misreading would let the stated controller have made a log."""

from __future__ import annotations

import math
from collections.abc import Iterator

import numpy as np

from cogging.arrays import cross_correlation
from cogging.identification.misreading.by_columns import exchanged
from cogging.identification.misreading.readings import REFERENCES, Reading, in_unit_of_command, in_unit_of_length, moved
from cogging.log_check.command_comparison import compared
from cogging.log_check.controller import check_controller
from cogging.logs.log import Log
from cogging.model.model import Model

CLOSE = 5e-3  # of the rms command: what the stated controller misses by less was read right
MARGIN = 0.2  # of what the controller misses of the log as read, that it may miss of the other reading
UNIT = 9.0  # by which a command differs from its controller's before its unit is doubted, not a gain
FURTHEST = 0.1  # of the rows by which a command is moved


def misread_by_controller(log: Log, model: Model) -> list[Reading]:
    """The reading of which the stated controller gives the command, where it does not as the log was read.

    Of a unit there are two where the controller cannot tell whether the command is in another, or all positions are.
    """
    if log.reference is None or model.controller is None:
        return []
    check = check_controller(log, model)
    if check is None or check.reproduces is None or check.relative is None or check.relative < CLOSE:
        return []
    found: list[Reading] = []
    shifts = (moved(rows, log) for rows in _shifts(log, model))
    for reading in shifts if check.reproduces else (*_readings(check.ratio, model), *shifts):
        if found and reading.kind != "scale":
            break
        try:
            other = check_controller(reading.of(log), model)
        except ValueError:
            continue
        if other is not None and other.reproduces and (other.relative or 0.0) < MARGIN * min(check.relative, 1.0):
            found.append(reading)
            if reading.kind != "scale":
                break
    return found


def _readings(ratio: float | None, model: Model) -> Iterator[Reading]:
    yield Reading("command", "sign", "has the other sign than the stated controller gives it", {"command": -1.0})
    yield Reading("position", "sign", "has the other sign than the stated controller sees", {"position": -1.0})
    others = dict.fromkeys(REFERENCES, -1.0)
    yield Reading("reference", "sign", "has the other sign than the stated controller sees", others)
    yield exchanged("position", "reference")
    yield exchanged("position", "command")
    if ratio and abs(math.log(abs(ratio))) > math.log(UNIT):
        yield in_unit_of_command(1.0 / ratio)
        yield in_unit_of_length(abs(ratio), REFERENCES, model.units)


def _shifts(log: Log, model: Model) -> list[int]:
    """Rows by which the logged command may stand later than that of the controller, the likeliest first."""
    kind = model.controller_type or ""
    found = compared(log, model, kind)
    if len(found.computed) != len(found.samples.command):
        return []
    logged = np.where(found.judged, found.samples.command - np.mean(found.samples.command[found.judged]), 0.0)
    given = np.where(found.judged, found.computed - np.mean(found.computed[found.judged]), 0.0)
    most = max(3, int(FURTHEST * len(logged)))
    likeness = cross_correlation(logged, given)
    zero = len(given) - 1
    lags = np.arange(-most, most + 1)
    lags = lags[lags != 0]
    order = np.argsort(-likeness[zero + lags])[:3]
    return [int(lag) for lag in lags[order]]
