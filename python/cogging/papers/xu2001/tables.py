"""Table 1 of Xu and Yao 2001 beside ours, and what would explain the difference."""

from __future__ import annotations

from collections.abc import Mapping

from cogging.logs.log import Log
from cogging.papers.result import Row, Table
from cogging.papers.xu2001.setup import (
    CONTROLLERS,
    INDEXES,
    SETS,
    TABLE_1,
    UNITS,
    indexes,
)


def table_1(logs: Mapping[str, Mapping[str, Log]]) -> Table:
    """Table 1: the PID columns are calibrated, the ARC columns predicted."""
    rows = []
    for controller in CONTROLLERS:
        for set_name in SETS:
            found = indexes(logs[controller][set_name])
            for index, unit, printed in zip(INDEXES, UNITS, TABLE_1[controller][set_name], strict=True):
                status = "calibrated" if controller == "PID" else "predicted"
                rows.append(Row(controller, index, unit, printed, found[index], status, {"set": set_name}))
    return Table("table1", "Table 1: sinusoidal motion, sets 1 to 3", rows)


def exploration_table(explored: Mapping[str, float]) -> Table:
    """The rms log-ratio of the ARC columns to the paper's, by change of the ARC's numbers."""
    rows = [Row("ARC", "gap", "1", None, size, "exploratory", {"change": name}) for name, size in explored.items()]
    return Table("exploration", "Rms log-ratio of the ARC columns to the paper's, by change of the ARC's numbers", rows)
