"""Tables 1 and 2 of Lu, Chen, Yao, Wang 2008, what was held out of fits, the maxima, the error at constant speed."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import TYPE_CHECKING

import numpy as np

from cogging._core import Arc, Dcarc, Plant
from cogging.arrays import FloatArray
from cogging.logs.log import Log
from cogging.papers.compared import Trace, compared
from cogging.papers.lu2008.gantry import (
    AXES,
    CONTROLLERS,
    HARMONICS,
    LATE,
    PITCH,
    RESOLUTION,
    SAMPLE_RATE,
    GantryAxis,
    cogging_map,
    controller_parameters,
    indexes,
    known,
    last_errors,
    last_move,
    plant,
    reference,
    shipped_amplitudes,
)
from cogging.papers.result import Row, Table, explored

if TYPE_CHECKING:
    from matplotlib.figure import Figure

INDEXES = ("e_inf", "e_2")

#: What is fitted, in volts: see Family in studies.lu2008.families, which chose them.
FREE = ("fundamental of both", "modulated X", "uncompensated X", "uncompensated Y")

#: Which numbers a held-out fit saw, by axis, controller and index; the others are predicted.
SPLITS: dict[str, tuple[str, Callable[[str, str, str], bool]]] = {
    "from_rms": ("fitted to the six rms, the maxima predicted", lambda axis, name, index: index == "e_2"),
    "from_table1": (
        "fitted to Table 1 and Y's rms, Y's maxima predicted",
        lambda axis, name, index: axis == "X" or index == "e_2",
    ),
    "from_table2": (
        "fitted to Table 2 and X's rms, X's maxima predicted",
        lambda axis, name, index: axis == "Y" or index == "e_2",
    ),
    "without_c3": ("fitted to C1 and C2, C3 predicted", lambda axis, name, index: name != "C3"),
}

AT_SPEED = 1.0 - 1e-9  # of the largest velocity


def table(axis: GantryAxis, logs: Mapping[str, Log]) -> Table:
    """Table 1 (X) or 2 (Y): every number took part in the fit; beside it the same family with the other reading of e'.

    The fundamental is one number for both tables and is named in each.
    """
    errors = np.array([indexes(logs[name], reference(axis)) for name in CONTROLLERS])
    title = f"Table {axis.table.removeprefix('table')}: performance indexes, {axis.name} axis"
    free = [name for name in FREE if name.endswith((axis.name, "both"))]
    late = Table(axis.table, title, _rows(axis, _errors(axis, LATE, error_difference=False)), free)
    return Table(axis.table, title, _rows(axis, errors), free, before=late, beside="e' late")


def held_out_table(split: str) -> Table:
    """What a fit of the same family to a part of the numbers predicts of the rest, beside a rule without a model.

    The rule takes maxima as rms times the other table's ratio of the two, and C3 as C2. The discrete choices of the
    family were made with all twelve numbers in view.
    """
    said, seen = SPLITS[split]
    rows, guesses = [], []
    for axis in AXES.values():
        for row in _rows(axis, _errors(axis, split), seen, {"axis": axis.name}):
            rows.append(row)
            if row.status == "predicted":
                guess = _guess(axis, CONTROLLERS.index(row.controller), INDEXES.index(row.index), split)
                guesses.append(Row(row.controller, row.index, "m", row.paper, guess, "predicted", row.labels))
    before = Table(f"held_out_{split}_guess", "", guesses)
    return Table(f"held_out_{split}", f"Held out: {said}; beside a guess without a model", rows, FREE, before, "guess")


def _guess(axis: GantryAxis, number: int, index: int, split: str) -> float:
    if split == "without_c3":
        return (axis.error_max, axis.error_rms)[index][CONTROLLERS.index("C2")]
    other = AXES["Y" if axis.name == "X" else "X"]
    return axis.error_rms[number] * other.error_max[number] / other.error_rms[number]


def maxima_table(logs: Mapping[str, Mapping[str, Log]]) -> Table:
    """The maxima in counts of the encoder, and the largest on ramps beside: the printed ones are whole counts.

    A reading is on the grid of the encoder; minus x_d it is a whole number of counts only where x_d is on it too: at
    constant speed (200 or 40 counts a sample here) and at rest. So the printed maxima lie there.

    Args:
        logs: by axis and controller.
    """
    rows = []
    for axis in AXES.values():
        for i, (name, log) in enumerate(logs[axis.name].items()):
            counts = axis.error_max[i] / RESOLUTION
            for part, largest in largest_by_part(axis, log).items():
                label = {"axis": axis.name, "at": part}
                rows.append(Row(name, "counts", "1", counts, largest / RESOLUTION, "derived", label))
    return Table("maxima", "The largest error by part of the motion, in counts of 0.5 um", rows)


def largest_by_part(axis: GantryAxis, log: Log) -> dict[str, float]:
    """The largest error (m) of the last move there and back at constant speed, at rest and on ramps."""
    motion = reference(axis)
    late, steady = log.time >= motion.end - motion.period, known(log.reference_acceleration) == 0.0
    speed = np.abs(known(log.reference_velocity)) > 0.5 * axis.velocity
    parts = {"constant speed": steady & speed, "rest": steady & ~speed, "ramp": ~steady}
    return {name: float(np.abs(log.error[late & rows]).max()) for name, rows in parts.items()}


def laws_table(machines: Mapping[str, Plant]) -> Table:
    """DCARC over ARC on the same machine: the paper says that it is better in all indexes, of which it prints none."""
    rows = []
    for axis in AXES.values():
        on = [machines[axis.name]] * len(CONTROLLERS)
        found = [
            last_move([law(controller_parameters(axis, name)) for name in CONTROLLERS], on, reference(axis)).indexes
            for law in (Dcarc, Arc)
        ]
        for index, key in (("e_inf", "error_max"), ("e_2", "error_rms"), ("du_rms", "command_change_rms")):
            for i, name in enumerate(CONTROLLERS):
                ratio = float(found[0][key][i] / found[1][key][i])
                rows.append(explored(name, index, "1", ratio, {"axis": axis.name}))
    return Table("laws", "DCARC over ARC: errors, and the rms change of the command from sample to sample", rows)


def _errors(axis: GantryAxis, fit: str, **changes: bool) -> FloatArray:
    """e_inf and e_2 (m) of the controllers on the map of a fit that comes with the package, (3, 2)."""
    machine = plant(axis, cogging_map(axis, shipped_amplitudes(axis, fit)))
    return np.asarray(last_errors(axis, [machine], None, **changes)[0])


def _rows(
    axis: GantryAxis,
    errors: FloatArray,
    seen: Callable[[str, str, str], bool] = lambda axis, name, index: True,
    labels: Mapping[str, str] | None = None,
) -> list[Row]:
    printed = np.array([axis.error_max, axis.error_rms]).T
    rows = []
    for i, name in enumerate(CONTROLLERS):
        for j, index in enumerate(INDEXES):
            status = "calibrated" if seen(axis.name, name, index) else "predicted"
            rows.append(Row(name, index, "m", float(printed[i, j]), float(errors[i, j]), status, labels or {}))
    return rows


def at_constant_speed(axis: GantryAxis, log: Log) -> FloatArray:
    """The error (m) at constant speed in the last move forth, by whole pitches: (pitches, rows of one)."""
    motion = reference(axis)
    fast = known(log.reference_velocity) > AT_SPEED * axis.velocity
    rows = np.flatnonzero((log.time >= motion.end - motion.period) & fast)
    of_pitch = round(PITCH / axis.velocity * SAMPLE_RATE)
    pitches = len(rows) // of_pitch
    return log.error[rows[: pitches * of_pitch]].reshape(pitches, of_pitch)


def rms_at(error: FloatArray, harmonics: tuple[int, ...]) -> float:
    """The rms (m) of the parts of an error at harmonics of the pitch, pitch by pitch.

    Args:
        error: m, (pitches, rows of one).
        harmonics: of the pitch.
    """
    lines = np.abs(np.fft.rfft(error, axis=1)[:, list(harmonics)]) / error.shape[1]
    return float(np.sqrt(2.0 * np.sum(lines**2) / len(error)))


def smoothness_table(axis: GantryAxis, logs: Mapping[str, Log]) -> Table:
    """The rms error of C1, C2, C3 at constant speed: all of it, at the harmonics that C3 compensates, at the others."""
    others = tuple(harmonic for harmonic in HARMONICS if harmonic not in axis.compensated)
    rows = []
    for name, log in logs.items():
        error = at_constant_speed(axis, log)
        for part, found in (
            ("all", float(np.sqrt(np.mean(error**2)))),
            (" ".join(map(str, axis.compensated)), rms_at(error, axis.compensated)),
            (" ".join(map(str, others)), rms_at(error, others)),
        ):
            rows.append(explored(name, "e_2", "m", found, {"harmonics": part}))
    return Table(f"constant_speed_{axis.name}", f"The error at constant speed, {axis.name} axis", rows)


def figure_errors(axis: GantryAxis, logs: Mapping[str, Log], number: int, last_period: bool = False) -> Figure:
    """Figs. 7 and 9: the tracking errors of C1 to C3 over the whole run, and the last move forth; 8, 10: last period.

    The maxima of Tables 1 and 2 are marked.
    """
    motion = reference(axis)
    begin = motion.end - motion.period
    traces = []
    for (name, log), printed in zip(logs.items(), axis.error_max, strict=True):
        shown = log.time >= (begin if last_period else 0.0)
        traces.append(Trace(name, log.time[shown], log.error[shown], printed))
    said = "one period" if last_period else "whole run and the last move forth"
    zoom = None if last_period else (begin, begin + 0.5 * motion.period)
    title = f"Fig. {number}: tracking errors, {axis.name} axis, {said}"
    return compared(title, traces, quantity="error", zoom=zoom)
