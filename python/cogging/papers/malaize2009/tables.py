"""Table I of Malaize and Levine 2009 beside ours."""

from __future__ import annotations

from collections.abc import Mapping

from cogging.logs.log import Log
from cogging.papers.malaize2009.causes import shipped_table_1
from cogging.papers.malaize2009.conditions import Conditions, controllers_under, machine
from cogging.papers.malaize2009.setup import CONTROLLERS, MOTORS, Calibrated, Motor, accuracy, run, shipped
from cogging.papers.result import Row, Table

TITLE = "Table I: accuracy after the first stroke, and the certified lambda*"
AMPLITUDES_AND_RADII = tuple(f"{what}, {motor}" for motor in MOTORS for what in ("amplitude", "pole radius"))

#: Logs by motor and controller.
Logs = Mapping[str, Mapping[str, Log]]


def logs_under(motor: Motor, gains: Calibrated, conditions: Conditions) -> dict[str, Log]:
    """The runs of PID and observer; gains.amplitude is that of the cogging."""
    plant = machine(motor, gains.amplitude, conditions)
    return {name: run(plant, each, motor) for name, each in controllers_under(motor, gains, conditions).items()}


def logs_of_table_1() -> dict[str, dict[str, Log]]:
    """The runs of Table I, with the error of the periods."""
    found = {}
    for motor in MOTORS.values():
        conditions, gains = shipped_table_1(motor)
        found[motor.name] = logs_under(motor, gains, conditions)
    return found


def logs_as_believed() -> dict[str, dict[str, Log]]:
    """The same runs where the controllers know all of their machine."""
    return {motor.name: logs_under(motor, shipped(motor), Conditions()) for motor in MOTORS.values()}


def table_1(logs: Logs, believed: Logs) -> Table:
    """Table I: accuracy after the first stroke, and lambda*.

    Args:
        logs: those of logs_of_table_1; the error of the periods was fitted to the observer row.
        believed: those of logs_as_believed, shown before; there the observer row was predicted.
    """
    before = Table("table1", TITLE, _rows(believed, "predicted"), free=AMPLITUDES_AND_RADII)
    return Table(
        "table1", TITLE, _rows(logs, "calibrated"), free=(*AMPLITUDES_AND_RADII, "period error"), before=before
    )


def _rows(logs: Logs, observer: str) -> list[Row]:
    """observer: status of its accuracies."""
    rows = []
    for motor in MOTORS.values():
        label = {"motor": motor.name}
        for name, printed, status in zip(CONTROLLERS, motor.accuracy, ("calibrated", observer), strict=True):
            rows.append(Row(name, "accuracy", "m", printed, accuracy(logs[motor.name][name], motor), status, label))
        star = shipped(motor).lambda_star
        rows.append(Row("observer", "lambda_star", "m/s^2", motor.lambda_star, star, "calibrated", label))
    return rows
