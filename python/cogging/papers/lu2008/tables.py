"""Tables 1 and 2 of Lu, Chen, Yao, Wang 2008, ours beside the paper's."""

from __future__ import annotations

from cogging.logs.log import Log
from cogging.papers.lu2008.setup import (
    CONTROLLERS,
    GantryAxis,
    indexes,
    reference,
)
from cogging.papers.result import Row, Table


def table(axis: GantryAxis, logs: dict[str, Log]) -> Table:
    """Table 1 (X) or 2 (Y): the rms values are calibrated, the maxima predicted."""
    rows = []
    for i, name in enumerate(CONTROLLERS):
        error_max, error_rms = indexes(logs[name], reference(axis))
        rows.append(Row(name, "e_inf", "m", axis.error_max[i], error_max, "predicted"))
        rows.append(Row(name, "e_2", "m", axis.error_rms[i], error_rms, "calibrated"))
    number = axis.table.removeprefix("table")
    return Table(axis.table, f"Table {number}: performance indexes, {axis.name} axis", rows)
