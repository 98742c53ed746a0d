"""Table I of Malaize and Levine 2009 beside ours."""

from __future__ import annotations

from collections.abc import Mapping

from cogging._core import closed_loop
from cogging.arrays import FloatArray
from cogging.logs.log import Log
from cogging.papers.malaize2009.causes import LINES, Cause, shipped_table_1
from cogging.papers.malaize2009.conditions import Conditions, controllers_under, drawn_accuracies, machine
from cogging.papers.malaize2009.setup import CONTROLLERS, MOTORS, Calibrated, Motor, reference, shipped
from cogging.papers.result import Row, Table

TITLE = "Table I: accuracy after the first stroke{}, and the certified lambda*"
AMPLITUDES_AND_RADII = tuple(f"{what} of {motor}" for motor in MOTORS for what in ("amplitude", "pole radius"))

#: Accuracies (m) by motor and controller, (draws,) each.
Accuracies = Mapping[str, Mapping[str, FloatArray]]


def logs_under(
    motor: Motor, gains: Calibrated, conditions: Conditions, draw: int = 0, *, strokes: int = 0
) -> dict[str, Log]:
    """The runs of PID and observer; gains.amplitude is that of the cogging; strokes: from the start, 0: all."""
    plant, motion = machine(motor, gains.amplitude, conditions, draw), reference(motor)
    return {
        name: Log.of(closed_loop(plant, each, motion, duration=0.5 * strokes * motion.period))
        for name, each in controllers_under(motor, gains, conditions).items()
    }


def logs_of_table_1(draw: int = 0) -> dict[str, dict[str, Log]]:
    """The runs of Table I of one draw of the lines and phases, by motor and controller."""
    found = {}
    for motor in MOTORS.values():
        conditions, gains = shipped_table_1(motor)
        found[motor.name] = logs_under(motor, gains, conditions, draw)
    return found


def accuracies_of_table_1(cause: Cause = LINES) -> dict[str, dict[str, FloatArray]]:
    """Those of Table I under a cause, in every draw."""
    found = {}
    for motor in MOTORS.values():
        conditions, gains = shipped_table_1(motor, cause)
        found[motor.name] = {
            name: drawn_accuracies(motor, gains, conditions, name, cause.draws) for name in CONTROLLERS
        }
    return found


def accuracies_as_believed() -> dict[str, dict[str, FloatArray]]:
    """The same where the controllers know all of their machine, with the assumed phases."""
    return {
        motor.name: {name: drawn_accuracies(motor, shipped(motor), Conditions(), name, 1) for name in CONTROLLERS}
        for motor in MOTORS.values()
    }


def table_1(cause: Cause, found: Accuracies, believed: Accuracies) -> Table:
    """Table I under a cause: accuracy after the first stroke, the mean over the draws, and lambda*.

    Args:
        cause: whose one size was fitted to the observer row.
        found: those of accuracies_of_table_1 under it.
        believed: those of accuracies_as_believed, shown before; there the observer row was predicted.
    """
    labels = {
        (motor, name): {f"of {cause.draws} draws": f"{1e6 * each.min():.3g} to {1e6 * each.max():.3g} um"}
        for motor, pair in found.items()
        for name, each in pair.items()
        if cause.draws > 1
    }
    words = f" (mean of {cause.draws} draws)" if labels else ""
    title = TITLE.format(f" with {cause.name} of one size{words}")
    before = Table("", "", _rows(believed, "predicted", labels), free=AMPLITUDES_AND_RADII)
    free = (*AMPLITUDES_AND_RADII, f"size of {cause.name}")
    id_ = "table1" if cause is LINES else f"table1_{cause.field}"
    return Table(id_, title, _rows(found, "calibrated", labels), free=free, before=before)


def _rows(found: Accuracies, observer: str, labels: Mapping[tuple[str, str], Mapping[str, str]]) -> list[Row]:
    """observer: status of its accuracies; labels: further ones, by motor and controller."""
    rows = []
    for motor in MOTORS.values():
        label = {"motor": motor.name}
        for name, printed, status in zip(CONTROLLERS, motor.accuracy, ("calibrated", observer), strict=True):
            accuracy = float(found[motor.name][name].mean())
            more = label | dict(labels.get((motor.name, name), {}))
            rows.append(Row(name, "accuracy", "m", printed, accuracy, status, more))
        star = shipped(motor).lambda_star
        rows.append(Row("observer", "lambda_star", "m/s^2", motor.lambda_star, star, "calibrated", label))
    return rows
