"""Rows that a log lacks, with the commands that its controller gave in them."""

from __future__ import annotations

import numpy as np

from cogging.arrays import FloatArray
from cogging.log_check.command_comparison import compared
from cogging.log_check.controller import check_controller
from cogging.log_check.controller_samples import FILLED
from cogging.logs.log import Log
from cogging.model.model import Model


def with_missing_rows(log: Log, model: Model) -> tuple[Log, str]:
    """The log with a row for each sample that lacks one between two rows, and what is to be said of that.

    Where the model's controller made the log, and gaps are of a few samples: the readings lie on the cubic through
    their neighbours, and the commands are those that the controller gives for them. A command that is held over the gap
    instead would be a blow that nobody gave, and be taken for what an effect does.
    """
    check = check_controller(log, model)
    if check is None or not check.reproduces or model.controller is None:
        return log, ""
    found = compared(log, model, check.type)
    samples = found.samples
    added = np.concatenate([[False], np.diff(samples.row) == 0])
    if not added.any():
        return log, ""
    position = log.position[samples.row]
    position[added] = cubic_between(log.time, log.position, samples.time[added])
    command = np.where(added, found.computed, log.command[samples.row])
    motion = samples.motion
    whole = Log(
        samples.time,
        position,
        command,
        motion["reference"],
        motion["reference_velocity"],
        motion["reference_acceleration"],
        metadata=log.metadata,
    )
    return whole, (
        f"{int(added.sum())} samples lack a row: readings drawn through their neighbours, commands as the "
        f"{check.type} gives them"
    )


def cubic_between(time: FloatArray, values: FloatArray, at: FloatArray) -> FloatArray:
    """Values at times between rows, on the cubic through the two rows on either side; on a line beside a long gap."""
    line = np.interp(at, time, values)
    if len(time) < 4:
        return np.asarray(line)
    k = np.clip(np.searchsorted(time, at) - 1, 1, len(time) - 3)
    rows = k[:, None] + np.arange(-1, 3)
    t, x = time[rows] - at[:, None], values[rows]
    cubic = np.zeros(len(at))
    for i in range(4):
        others = [j for j in range(4) if j != i]
        cubic += x[:, i] * np.prod([-t[:, j] / (t[:, i] - t[:, j]) for j in others], axis=0)
    near = t[:, 3] - t[:, 0] < (2 * FILLED + 3) * float(np.median(np.diff(time)))
    return np.where(near, cubic, line)
