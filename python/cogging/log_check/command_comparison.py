"""The command that a stated controller gives for the references and readings of a log, beside the logged one."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np

from cogging._core import replay_controller
from cogging.arrays import FloatArray, Mask
from cogging.files import LARGEST
from cogging.log_check.controller_samples import Samples
from cogging.logs.log import Log
from cogging.logs.spikes import FEW, HIGH, between, off_neighbours, spikes
from cogging.model.model import CONTROLLERS, Model

SHIFTS = (-2, -1, 0, 1, 2)  # rows by which the command is moved
ROUGH = 1e-3  # of the rms command: what differs less is not looked into
EXPLAINS = 0.7  # of the difference: values that leave and return must explain the rest of it to be left out


@dataclass(frozen=True)
class Compared:
    """A log beside what the stated controller gives for it, one entry a sample.

    Attributes:
        samples: of the log.
        computed: V, the start of the integral in it.
        start: V, that start, constant between gaps.
        judged: samples that are compared.
        doubted: rows whose command no controller gives: a single value that leaves and returns.
        unseen: rows of the log, (n,), whose reading the controller did not see: likewise.
        shifts: rms difference by the rows that the command is moved, V.
    """

    samples: Samples
    computed: FloatArray
    start: FloatArray
    judged: Mask
    doubted: Mask
    unseen: Mask
    shifts: Mapping[int, float]


def compared(log: Log, model: Model, kind: str) -> Compared:
    """A log beside its controller: as its rows say or, where that explains more, without what leaves and returns."""
    reference = _reference(log, kind)
    found = _compared_with(log, model, kind, reference, np.zeros(len(log), dtype=bool), cleaned=False)
    if not found.judged.any() or found.shifts[0] <= ROUGH * root_mean_square(log.command):
        return found
    readings, commands = spikes(log.position - reference), spikes(log.command)
    for unseen, cleaned in ((readings, False), (readings, True), (np.zeros(len(log), dtype=bool), True)):
        if (unseen.any() or cleaned) and (commands.any() or not cleaned):
            other = _compared_with(log, model, kind, reference, unseen, cleaned=cleaned)
            if other.judged.any() and other.shifts[0] < EXPLAINS * found.shifts[0]:
                found = other
    return found


def _compared_with(
    log: Log, model: Model, kind: str, reference: FloatArray, unseen: Mask, *, cleaned: bool
) -> Compared:
    controller: Any = model.controller
    samples = Samples.of(log, reference, controller.sample_rate, unseen)
    judged = samples.judged(_lags(kind, controller))
    applied = samples.command
    if cleaned:
        applied = between(applied, samples.time, spikes(applied))
    computed, integral, limited = _recompute(samples, applied, judged, model, kind)
    start = np.zeros(len(computed))
    if integral:
        free = judged & (np.abs(samples.command) < controller.command_limit * (1.0 - 1e-6)) if limited else judged
        start = samples.medians(samples.command - computed, free)
        if limited:
            start[samples.segment == 0] = 0.0
    limit = controller.command_limit
    computed = np.clip(computed + start, -limit, limit) if limit > 0.0 else computed + start
    doubted = doubted_commands(samples.command, computed, judged)
    shifts = _by_shift(samples, computed, judged, doubted)
    if doubted.any() and min(shifts.values()) < 0.5 * shifts[0]:  # it is the timing that is wrong
        doubted = np.zeros(len(computed), dtype=bool)
        shifts = _by_shift(samples, computed, judged, doubted)
    judged = judged & ~doubted
    return Compared(samples, computed, start, judged, doubted, unseen, shifts)


def _by_shift(samples: Samples, computed: FloatArray, judged: Mask, doubted: Mask) -> dict[int, float]:
    """Rms difference by the rows that the command is moved, V, without commands that are doubted."""
    return {shift: root_mean_square(_shifted(samples, computed, judged, doubted, shift)) for shift in SHIFTS}


def doubted_commands(command: FloatArray, computed: FloatArray, rows: Mask) -> Mask:
    """Commands that leave and return at once where those that are computed do not; none where they are many."""
    if not rows.any():
        return rows
    left = command - computed
    left = np.abs(left - np.median(left[rows]))
    usual = max(float(np.median(left[rows])) * 1.4826, 0.1 * ROUGH * root_mean_square(command[rows]))
    found = rows & (left > HIGH * usual)
    found &= (np.abs(off_neighbours(command)) > 0.3 * left) & (np.abs(off_neighbours(computed)) < 0.2 * left)
    return found if found.sum() <= FEW * rows.sum() else np.zeros(len(rows), dtype=bool)


def _lags(kind: str, controller: Any) -> tuple[int, ...]:
    """How many samples ago the readings were taken that make a command, as far as it forgets them."""
    if kind != "speed":
        return (0, 1)
    whole = int(controller.delay * controller.sample_rate + 1e-9)
    return (0, whole, whole + 1, whole + 2)


def _reference(log: Log, kind: str) -> FloatArray:
    if log.reference is not None:
        return log.reference
    assert log.reference_velocity is not None
    velocity = log.reference_velocity
    moved = 0.5 * (velocity[1:] + velocity[:-1]) * np.diff(log.time)
    reference: FloatArray = log.position[0] + np.concatenate([[0.0], np.cumsum(moved)])
    return reference


def _recompute(
    samples: Samples, applied: FloatArray, judged: Mask, model: Model, kind: str
) -> tuple[FloatArray, bool, bool]:
    """The command as stated, whether an unknown start of its integral may be added, and whether it meets its limit."""
    controller: Any = model.controller
    limit = controller.command_limit
    limited = limit > 0.0 and np.abs(samples.command).max() >= limit * (1 - 1e-6)
    arguments = {**samples.motion, "position": samples.position}
    integral = kind == "pid" and controller.ki > 0.0
    if kind in ("pid", "cascade") and not limited:
        unlimited = CONTROLLERS[kind][1](controller.replace(command_limit=0.0))
        return _bounded(replay_controller(unlimited, **arguments)), integral, False
    fresh = model.make_controller()
    own = _bounded(replay_controller(fresh, **arguments))
    if kind in ("pid", "cascade"):
        return own, integral and bool(samples.segment[-1]), True
    # What a controller with memory was told to have been applied is its own command or, after a disturbance of the
    # command or a start in mid-motion, what the log holds.
    told = _bounded(replay_controller(fresh, **arguments, applied=applied))
    return min(own, told, key=lambda command: root_mean_square((samples.command - command)[judged])), False, limited


def _bounded(command: FloatArray) -> FloatArray:
    """The command of a controller that may have run away: as far off as can be squared is far enough."""
    return np.clip(np.nan_to_num(command, nan=LARGEST), -LARGEST, LARGEST)


def _shifted(samples: Samples, computed: FloatArray, judged: Mask, doubted: Mask, shift: int) -> FloatArray:
    """Logged minus computed when the logged command is moved back by `shift` rows; rows 3 to n - 2 or, unmoved, all."""
    command = samples.command
    known = samples.known & ~doubted
    if shift == 0:
        rows = judged & ~doubted
        return command[rows] - computed[rows]
    edge = max(SHIFTS)
    at = np.arange(1 + edge, command.size - edge)
    at = at[judged[at] & known[at + shift] & (samples.segment[at] == samples.segment[at + shift])]
    return np.asarray(command[at + shift] - computed[at])


def root_mean_square(values: FloatArray) -> float:
    """The rms of values (n,); infinite where there are none."""
    return float(np.sqrt(np.mean(values**2))) if values.size else float("inf")
