"""The map of causes of Malaize and Levine 2009 as tables: sizes, what more they do, and held-out motors."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from cogging.arrays import FloatArray
from cogging.logs.log import Log
from cogging.papers.malaize2009.causes import Explanation, other
from cogging.papers.malaize2009.conditions import DRAWN_STROKES
from cogging.papers.malaize2009.setup import CONTROLLERS, MOTORS, Motor, reference, shipped, true_error
from cogging.papers.malaize2009.tables import Accuracies, logs_under
from cogging.papers.result import Row, Table

CRUISE = 0.99  # of the top speed and above: constant speed
THINNED = 20  # samples of which one is used where lines are fitted


def what_explains(found: Sequence[Explanation]) -> Table:
    """The size of each cause that alone gives the observer the printed accuracy; not in the paper."""
    rows = [
        Row("observer", "size", each.cause.unit, None, each.size, "exploratory", _labels(each, each.cause.verdict))
        for each in found
    ]
    return Table("what_explains", "What alone would give the observer the accuracy of Table I, by its size", rows)


def held_out(found: Sequence[Explanation]) -> Table:
    """The observer's accuracy where each cause is fitted on one motor and given to the other."""
    rows = []
    for each in found:
        labels = {"cause": each.cause.name, "fitted on": each.motor.name}
        pairs = ((each.motor, each.accuracy, "calibrated"), (other(each.motor), each.elsewhere, "predicted"))
        for motor, accuracy, status in pairs:
            label = {"motor": motor.name, **labels}
            rows.append(Row("observer", "accuracy", "m", motor.accuracy[1], float(accuracy.mean()), status, label))
    free = [f"{each.cause.name} of {each.motor.name}" for each in found]
    return Table("held_out", "Fitted on one motor, given to the other: the observer's accuracy", rows, free=free)


def what_else(found: Sequence[Explanation]) -> Table:
    """What each cause does beside, at its size: the marks by which the paper's words and Fig. 3 tell them apart.

    Of the observer `at_rest`, the largest error while the reference rests; `ramps`, its largest error in ramps over
    that at constant speed; `lines_left`, at constant speed and of the observer's own periods the largest amplitude over
    the PID's; of the PID `beside_lines`, the rms at constant speed of what is no such line over all.
    """
    rows = []
    for each in found:
        labels = {"motor": each.motor.name, "cause": each.cause.name}
        for (name, index), value in consequences(each).items():
            rows.append(Row(name, index, "m" if index == "at_rest" else "1", None, value, "exploratory", labels))
    return Table("what_else", "What each cause does beside, at that size", rows)


def consequences(each: Explanation) -> dict[tuple[str, str], float]:
    """The numbers of `what_else` by controller and index."""
    motor, conditions = each.motor, each.cause.of(each.size)
    gains = replace(shipped(motor), amplitude=each.amplitude)
    logs = logs_under(motor, gains, conditions, strokes=DRAWN_STROKES)
    log = logs["observer"]
    later, speed = log.time >= 0.5 * reference(motor).period, _speed(log)
    error, fast = np.abs(true_error(log)), speed >= CRUISE * motor.velocity
    periods = [period / (1.0 + conditions.period_error) for period in motor.periods]
    lines = {name: lines_at_speed(log, motor, periods) for name, log in logs.items()}
    ramps = error[later & ~fast & (speed > 0.0)].max()
    return {
        ("observer", "at_rest"): float(error[later & (speed == 0.0)].max()),
        ("observer", "ramps"): float(ramps / error[later & fast].max()),
        ("observer", "lines_left"): float((lines["observer"][0] / lines["PID"][0]).max()),
        ("PID", "beside_lines"): lines["PID"][1],
    }


def _speed(log: Log) -> FloatArray:
    if log.reference_velocity is None:
        raise ValueError("reference_velocity: must be in the log, which has to be a simulated one")
    return np.abs(log.reference_velocity)


def lines_at_speed(log: Log, motor: Motor, periods: Sequence[float]) -> tuple[FloatArray, float]:
    """Lines in the true error at constant speed, least squares in every stroke but the first.

    Args:
        log: a simulated one.
        motor: whose strokes these are.
        periods: m, of the lines.

    Returns:
        Amplitude (m) of each, rms over the strokes, (periods,); rms of what is left, over that of all.
    """
    half = 0.5 * reference(motor).period
    powers, left, all_ = [], 0.0, 0.0
    for stroke in range(1, round(log.time[-1] / half)):
        rows = np.flatnonzero((np.floor(log.time / half) == stroke) & (_speed(log) >= CRUISE * motor.velocity))[
            ::THINNED
        ]
        angle = 2.0 * np.pi * np.outer(log.position[rows], 1.0 / np.array(periods))
        basis = np.column_stack([np.ones(rows.size), np.sin(angle), np.cos(angle)])
        error = true_error(log)[rows]
        parts = np.linalg.lstsq(basis, error, rcond=None)[0]
        powers.append(parts[1 : 1 + len(periods)] ** 2 + parts[1 + len(periods) :] ** 2)
        left += float(np.sum((error - basis @ parts) ** 2))
        all_ += float(np.sum((error - error.mean()) ** 2))
    return np.sqrt(np.mean(powers, axis=0)), float(np.sqrt(left / all_))


def spread_over_draws(found: Sequence[Explanation], table_1: Accuracies) -> Table:
    """How much the draw counts: of lines and phases in Table I, and of what each cause draws at its size."""
    rows = []
    for motor in MOTORS.values():
        for name in CONTROLLERS:
            rows += _spread(name, motor, "Table I", table_1[motor.name][name])
    for each in found:
        if each.cause.draws > 1:
            rows += _spread("observer", each.motor, each.cause.name, each.accuracy)
    return Table("draws", "How much a draw counts: accuracy over the draws", rows)


def _spread(controller: str, motor: Motor, what: str, accuracies: FloatArray) -> list[Row]:
    labels = {"motor": motor.name, "under": what}
    statistics = {
        "mean": accuracies.mean(),
        "sd": accuracies.std(ddof=1),
        "least": accuracies.min(),
        "largest": accuracies.max(),
    }
    return [Row(controller, name, "m", None, float(value), "exploratory", labels) for name, value in statistics.items()]


def _labels(each: Explanation, verdict: str) -> dict[str, str]:
    return {"motor": each.motor.name, "cause": each.cause.name, "verdict": verdict}
