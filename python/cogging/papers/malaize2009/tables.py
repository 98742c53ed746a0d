"""Table I of Malaize and Levine 2009 beside ours."""

from __future__ import annotations

from collections.abc import Mapping

from cogging.logs.log import Log
from cogging.papers.malaize2009.setup import CONTROLLERS, MOTORS, accuracy, shipped
from cogging.papers.result import Row, Table


def table_1(logs: Mapping[str, Mapping[str, Log]]) -> Table:
    """Table I: accuracy after the first stroke, and lambda*."""
    rows = []
    for motor in MOTORS.values():
        label = {"motor": motor.name}
        for name, printed in zip(CONTROLLERS, motor.accuracy, strict=True):
            status = "calibrated" if name == "PID" else "predicted"
            rows.append(Row(name, "accuracy", "m", printed, accuracy(logs[motor.name][name], motor), status, label))
        star = shipped(motor).lambda_star
        rows.append(Row("observer", "lambda_star", "m/s^2", motor.lambda_star, star, "calibrated", label))
    return Table("table1", "Table I: accuracy after the first stroke, and the certified lambda*", rows)
