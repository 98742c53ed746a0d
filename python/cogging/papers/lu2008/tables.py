"""Tables 1 and 2 of Lu, Chen, Yao, Wang 2008, ours beside the paper's, and what was held out of the fit."""

from __future__ import annotations

from collections.abc import Collection, Mapping
from dataclasses import replace

import numpy as np

from cogging.arrays import FloatArray
from cogging.logs.log import Log
from cogging.papers.lu2008.setup import (
    AXES,
    CONTROLLERS,
    FIRST,
    PRESENT,
    WITHOUT_C3,
    GantryAxis,
    cogging_map,
    indexes,
    last_errors,
    plant,
    reference,
    shipped_amplitudes,
    shipped_shape,
)
from cogging.papers.result import Row, Table

INDEXES = ("e_inf", "e_2")
AMPLITUDES = ("periodic", "modulated", "uncompensated")
#: Of the shape, for both axes; shift was chosen for the room that it leaves within the bound, and counts as well.
SHAPE = ("decay", "half_waves", "begin", "shift")
_FREE_OF_BOTH = [*(f"{name} {axis}" for name in AMPLITUDES for axis in AXES), *(f"{name} of both" for name in SHAPE)]


def table(axis: GantryAxis, logs: dict[str, Log]) -> Table:
    """Table 1 (X) or 2 (Y): every number took part in the fit; `before` is the row of the conditions assumed at first.

    The shape is shared by both tables: its four parameters are named in each.
    """
    errors = np.array([indexes(logs[name], reference(axis)) for name in CONTROLLERS])
    title = f"Table {_number(axis)}: performance indexes, {axis.name} axis"
    free = [*(f"{name} {axis.name}" for name in AMPLITUDES), *(f"{name} of both" for name in SHAPE)]
    return Table(axis.table, title, _rows(axis, errors, INDEXES, {}), free, before=first_table(axis))


def first_table(axis: GantryAxis) -> Table:
    """The same numbers with the map assumed at first: amplitudes calibrated on the rms values, the maxima predicted."""
    title = f"Table {_number(axis)}, the map assumed at first"
    free = [f"{name} {axis.name}" for name in AMPLITUDES]
    return Table(f"{axis.table}_first", title, _rows(axis, _errors(axis, FIRST), ("e_2",), {}), free)


def held_out_table(fitted: str) -> Table:
    """Shape fitted to the table of one axis alone; the maxima of the other axis are predicted with it.

    Args:
        fitted: "X" or "Y", the axis whose six numbers were fitted by its amplitudes and the shape. The amplitudes of
            the other are calibrated on its three rms values.
    """
    axis = AXES[fitted]
    rows = []
    for other in AXES.values():
        calibrated = INDEXES if other is axis else ("e_2",)
        rows += _rows(other, _errors(other, f"from_{axis.table}"), calibrated, {"axis": other.name})
    title = f"Held out: shape fitted to Table {_number(axis)} alone, maxima of the other axis predicted"
    return Table(f"held_out_from_{axis.table}", title, rows, _FREE_OF_BOTH)


def without_c3_table() -> Table:
    """Shape and amplitudes fitted to the eight numbers of C1 and C2 in both tables; those of C3 are predicted.

    Ten parameters for eight numbers: other fits are as near and predict other numbers, this is the one that search.py
    comes to.
    """
    rows = [
        replace(row, status="predicted" if row.controller == "C3" else "calibrated")
        for axis in AXES.values()
        for row in _rows(axis, _errors(axis, WITHOUT_C3), INDEXES, {"axis": axis.name})
    ]
    return Table("held_out_c3", "Held out: fitted to C1 and C2 of both tables, C3 predicted", rows, _FREE_OF_BOTH)


def trivial_table() -> Table:
    """What predicts the maxima of an axis without a model: its rms values times e_inf / e_2 of the other table."""
    rows = []
    for axis, other in ((AXES["X"], AXES["Y"]), (AXES["Y"], AXES["X"])):
        ratio = np.array(other.error_max) / np.array(other.error_rms)
        guessed = ratio * np.array(axis.error_rms)
        rows += [
            Row(name, "e_inf", "m", axis.error_max[i], float(guessed[i]), "predicted", {"axis": axis.name})
            for i, name in enumerate(CONTROLLERS)
        ]
    return Table("held_out_trivial", "Held out: maxima from the rms and the other table's e_inf / e_2, no model", rows)


def _number(axis: GantryAxis) -> str:
    return axis.table.removeprefix("table")


def _errors(axis: GantryAxis, conditions: str = PRESENT) -> FloatArray:
    """e_inf and e_2 (m) of the controllers under conditions that come with the package, (3, 2)."""
    cogging = cogging_map(axis, shipped_amplitudes(axis, conditions), shipped_shape(conditions))
    return np.asarray(last_errors(axis, [plant(axis, cogging)])[0])


def _rows(axis: GantryAxis, errors: FloatArray, calibrated: Collection[str], labels: Mapping[str, str]) -> list[Row]:
    printed = np.array([axis.error_max, axis.error_rms]).T
    return [
        Row(
            name,
            index,
            "m",
            float(printed[i, j]),
            float(errors[i, j]),
            "calibrated" if index in calibrated else "predicted",
            labels,
        )
        for i, name in enumerate(CONTROLLERS)
        for j, index in enumerate(INDEXES)
    ]
