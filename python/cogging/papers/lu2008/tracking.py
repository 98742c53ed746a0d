"""Tracking errors of Lu, Chen, Yao, Wang 2008: Tables 1 and 2, held-out fits, maxima, constant speed, Figs. 7 to 10.

The claim, C3 before C2 before C1, also on random cogging maps, which are not calibrated.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping

import numpy as np
from matplotlib.figure import Figure
from scipy.stats import binomtest

from cogging._core import Arc, CoggingModel, Dcarc, Plant
from cogging.arrays import FloatArray
from cogging.effects import CoggingHarmonic
from cogging.logs.log import Log
from cogging.papers.compared import Trace, compared
from cogging.papers.lu2008 import gantry
from cogging.papers.lu2008.gantry import AXES, CONTROL_POINTS, CONTROLLERS, HARMONICS, GantryAxis
from cogging.papers.result import Row, Table, explored, known
from cogging.plot.canvas import drawn, legend, titled_panels
from cogging.plot.series import look, marker

#: Indexes, and their names as a field of GantryAxis (printed, of C1, C2 and C3) and in a Batch.
INDEXES = {"e_inf": "error_max", "e_2": "error_rms"}

#: The fitted amplitudes: see Family in studies.lu2008.families, which chose them.
FREE = ("fundamental of both", "modulated X", "uncompensated X", "uncompensated Y")

#: Title of each held-out fit, and whether a number of an axis, controller and index took part; the rest is predicted.
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


def table(axis: GantryAxis, logs: Mapping[str, Log]) -> Table:
    """Return Table 1 (X) or 2 (Y), all numbers fitted, beside the same family with the other reading of e'."""
    errors = np.array([gantry.indexes(logs[name], gantry.reference(axis)) for name in CONTROLLERS])
    title = f"Table {axis.table.removeprefix('table')}: performance indexes, {axis.name} axis"
    free = [name for name in FREE if name.endswith((axis.name, "both"))]
    late = Table(axis.table, title, _rows(axis, _errors(axis, gantry.LATE, error_difference=False)), free)
    return Table(axis.table, title, _rows(axis, errors), free, before=late, beside="e' late")


def held_out_table(split: str) -> Table:
    """Return the predictions of a fit to a part of the numbers, beside a guess without a model.

    The guess takes maxima as rms times the other table's ratio of the two, and C3 as C2.
    """
    said, seen = SPLITS[split]
    rows, guesses = [], []
    for axis in AXES.values():
        other = AXES["Y" if axis.name == "X" else "X"]
        for row in _rows(axis, _errors(axis, split), seen, {"axis": axis.name}):
            rows.append(row)
            if row.status == "predicted":
                number = CONTROLLERS.index(row.controller)
                guess = axis.error_rms[number] * other.error_max[number] / other.error_rms[number]
                if split == "without_c3":
                    guess = getattr(axis, INDEXES[row.index])[CONTROLLERS.index("C2")]
                guesses.append(Row(row.controller, row.index, "m", row.paper, guess, "predicted", row.labels))
    before = Table(f"held_out_{split}_guess", "", guesses)
    return Table(f"held_out_{split}", f"Held out: {said}; beside a guess without a model", rows, FREE, before, "guess")


def maxima_table(logs: Mapping[str, Mapping[str, Log]]) -> Table:
    """Tabulate the maxima by part of the motion in counts; at constant speed and at rest they are whole, as printed."""
    rows = []
    for axis in AXES.values():
        for printed, (name, log) in zip(axis.error_max, logs[axis.name].items(), strict=True):
            for part, largest in largest_by_part(axis, log).items():
                counts, label = largest / gantry.RESOLUTION, {"axis": axis.name, "at": part}
                rows.append(Row(name, "counts", "1", printed / gantry.RESOLUTION, counts, "derived", label))
    return Table("maxima", "The largest error by part of the motion, in counts of 0.5 um", rows)


def largest_by_part(axis: GantryAxis, log: Log) -> dict[str, float]:
    """Return the largest error (m) of the last move there and back at constant speed, at rest and on ramps."""
    motion = gantry.reference(axis)
    late, steady = log.time >= motion.end - motion.period, known(log.reference_acceleration) == 0.0
    speed = np.abs(known(log.reference_velocity)) > 0.5 * axis.velocity
    parts = {"constant speed": steady & speed, "rest": steady & ~speed, "ramp": ~steady}
    return {name: float(np.abs(log.error[late & rows]).max()) for name, rows in parts.items()}


def laws_table(machines: Mapping[str, Plant]) -> Table:
    """Tabulate DCARC over ARC on the same machines; the paper says that it is better in all indexes."""
    rows = []
    for axis in AXES.values():
        on, motion = [machines[axis.name]] * len(CONTROLLERS), gantry.reference(axis)
        parameters = [gantry.controller_parameters(axis, name) for name in CONTROLLERS]
        dcarc, arc = (gantry.last_move([law(each) for each in parameters], on, motion).indexes for law in (Dcarc, Arc))
        for index, key in {**INDEXES, "du_rms": "command_change_rms"}.items():
            for name, ratio in zip(CONTROLLERS, dcarc[key] / arc[key], strict=True):
                rows.append(explored(name, index, "1", ratio, axis=axis.name))
    return Table("laws", "DCARC over ARC: errors, and the rms change of the command from sample to sample", rows)


def _errors(axis: GantryAxis, fit: str, **changes: bool) -> FloatArray:
    """Return e_inf and e_2 (m) of the controllers on the map of a shipped fit, (3, 2)."""
    machine = gantry.plant(axis, gantry.cogging_map(axis, gantry.shipped_amplitudes(axis, fit)))
    return np.asarray(gantry.last_errors(axis, [machine], None, **changes)[0])


def _rows(
    axis: GantryAxis,
    errors: FloatArray,
    seen: Callable[[str, str, str], bool] = lambda axis, name, index: True,
    labels: Mapping[str, str] | None = None,
) -> list[Row]:
    rows = []
    for name, found, *printed in zip(CONTROLLERS, errors.tolist(), axis.error_max, axis.error_rms, strict=True):
        for index, paper, value in zip(INDEXES, printed, found, strict=True):
            status = "calibrated" if seen(axis.name, name, index) else "predicted"
            rows.append(Row(name, index, "m", paper, value, status, labels or {}))
    return rows


def at_constant_speed(axis: GantryAxis, log: Log) -> FloatArray:
    """Return the error (m) at constant speed in the last move forth, by whole pitches: (pitches, rows of one)."""
    motion = gantry.reference(axis)
    fast = known(log.reference_velocity) > (1.0 - 1e-9) * axis.velocity
    rows = np.flatnonzero((log.time >= motion.end - motion.period) & fast)
    of_pitch = round(gantry.PITCH / axis.velocity * gantry.SAMPLE_RATE)
    pitches = len(rows) // of_pitch
    return log.error[rows[: pitches * of_pitch]].reshape(pitches, of_pitch)


def smoothness_table(axis: GantryAxis, logs: Mapping[str, Log]) -> Table:
    """Tabulate the rms error at constant speed: all of it, at the harmonics that C3 compensates, at the others."""
    others = [harmonic for harmonic in HARMONICS if harmonic not in axis.compensated]
    rows = []
    for name, log in logs.items():
        error = at_constant_speed(axis, log)
        rows.append(explored(name, "e_2", "m", np.sqrt(np.mean(error**2)), harmonics="all"))
        lines = np.abs(np.fft.rfft(error, axis=1)) / error.shape[1]
        for listed in (list(axis.compensated), others):
            rms = np.sqrt(2.0 * np.sum(lines[:, listed] ** 2) / len(error))
            rows.append(explored(name, "e_2", "m", rms, harmonics=" ".join(map(str, listed))))
    return Table(f"constant_speed_{axis.name}", f"The error at constant speed, {axis.name} axis", rows)


def figure_errors(axis: GantryAxis, logs: Mapping[str, Log], number: int, last_period: bool = False) -> Figure:
    """Draw Fig. 7 or 9, the errors of the whole run and the last move forth, or 8 or 10, those of the last period."""
    motion = gantry.reference(axis)
    begin = motion.end - motion.period
    traces = []
    for (name, log), printed in zip(logs.items(), axis.error_max, strict=True):
        shown = log.time >= (begin if last_period else 0.0)
        traces.append(Trace(name, log.time[shown], log.error[shown], printed))
    said = "one period" if last_period else "whole run and the last move forth"
    zoom = None if last_period else (begin, begin + 0.5 * motion.period)
    return compared(f"Fig. {number}: tracking errors, {axis.name} axis, {said}", traces, zoom=zoom)


# Random maps ----------------------------------------------------------------------------------------------------------

MAPS = 8  # of each axis and kind in `reproduce`; the study draws more
#: Kinds of maps: in the spline space of C3, which can then be exact, and with a line beside each harmonic.
KINDS = ("splines", "lines beside")
BESIDE = 0.2  # largest distance of a line from its harmonic's number; C3's splines can follow it
BESIDE_SIZES = (0.2, 1.5)  # of a line over the scale of its harmonic
LEVEL = 0.06  # V, of the fundamental: about two thirds of the largest coefficient within the bounds of the X axis


def random_machine(axis: GantryAxis, seed: int, kind: str = KINDS[0]) -> Plant:
    """Return an axis with a random map of one of KINDS: harmonics of random strength and phase that change with x."""
    random = np.random.default_rng([2008, seed])
    strength = LEVEL * random.lognormal(0.0, 0.4, len(HARMONICS)) / np.array(HARMONICS)
    phase = random.uniform(0.0, 2.0 * np.pi, len(HARMONICS))
    depth = random.uniform(0.2, 0.8, len(HARMONICS))
    profile = 1.0 + depth[:, None] * random.uniform(-1.0, 1.0, (len(HARMONICS), CONTROL_POINTS))
    sine, cosine = ((strength * part(phase))[:, None] * profile for part in (np.cos, np.sin))
    lines, random = [], np.random.default_rng([2008, 1, seed])
    for harmonic in HARMONICS if kind == KINDS[1] else ():
        period = gantry.PITCH / (harmonic + random.uniform(-BESIDE, BESIDE))
        size, angle = LEVEL / harmonic * random.uniform(*BESIDE_SIZES), random.uniform(0.0, 2.0 * np.pi)
        lines.append(CoggingHarmonic(period=period, sine=size * np.sin(angle), cosine=size * np.cos(angle)))
    return gantry.plant(axis, CoggingModel(gantry.cogging_basis(), sine, cosine), lines)


def errors_on_maps(axis: GantryAxis, maps: int = MAPS, kind: str = KINDS[0]) -> dict[str, FloatArray]:
    """Return e_inf and e_2 (m) of C1, C2, C3 over the last move on random maps, (maps, 3) each."""
    found = gantry.last_errors(axis, [random_machine(axis, seed, kind) for seed in range(maps)])
    return {"e_inf": found[..., 0], "e_2": found[..., 1]}


def orders(errors: FloatArray) -> dict[str, int]:
    """Return on how many maps C3 beats C2, C2 beats C1, and both, of the errors of C1, C2, C3, (maps, 3)."""
    c1, c2, c3 = errors.T
    claims = {"C3 < C2": c3 < c2, "C2 < C1": c2 < c1, "C3 < C2 < C1": (c3 < c2) & (c2 < c1)}
    return {claim: int(np.count_nonzero(holds)) for claim, holds in claims.items()}


def claim_table(errors: Mapping[str, Mapping[str, Mapping[str, FloatArray]]]) -> Table:
    """Tabulate the share of maps on which each part of the claim holds, and on which C3 / C2 is below the paper's."""
    rows = []
    for kind, by_axis in errors.items():
        for axis, by_index in by_axis.items():
            for index, found in by_index.items():
                _, second, third = getattr(AXES[axis], INDEXES[index])
                below = int(np.count_nonzero(found[:, 2] / found[:, 1] < third / second))
                for claim, hits in {**orders(found), f"C3 / C2 < {third / second:.2f}": below}.items():
                    interval = binomtest(hits, len(found)).proportion_ci(0.95, method="wilson")
                    labels = {"map": kind, "axis": axis, "by": index, "ci95": "{:.2f} to {:.2f}".format(*interval)}
                    labels["maps"] = str(len(found))
                    rows.append(explored(claim, "share", "1", hits / len(found), **labels))
    return Table("claim", "Share of random cogging maps on which a controller is better", rows)


@drawn
def figure_claim(errors: Mapping[str, Mapping[str, FloatArray]]) -> Figure:
    """Draw C2 / C1 and C3 / C2 of errors_on_maps, by axis, beside the paper's own machine."""
    title = "C3 before C2 before C1 on random cogging maps with lines beside the harmonics"
    figure, panels = titled_panels(title, (8.0, 3.8), 1, 2, sharey=True)
    largest = 1.0
    for axes, index in zip(panels, INDEXES, strict=True):
        names: list[str] = []
        for name, by_index in errors.items():
            c1, c2, c3 = by_index[index].T
            p1, p2, p3 = getattr(AXES[name], INDEXES[index])
            for said, ratio, paper in ((f"{name}: C2 / C1", c2 / c1, p2 / p1), (f"{name}: C3 / C2", c3 / c2, p3 / p2)):
                place = len(names) + 0.25 * (np.linspace(-1.0, 1.0, len(ratio)) if len(ratio) > 1 else np.zeros(1))
                first = not names
                axes.plot(place, ratio, marker(0), **{**look(0), "linestyle": "none"}, label="map" if first else None)
                mark = {**look(4), "linestyle": "none", "markersize": 9}
                axes.plot(len(names), paper, marker(3), **mark, label="paper's tables" if first else None)
                names.append(said)
                largest = max(largest, float(ratio.max()), paper)
        axes.axhline(1.0, color="black", linewidth=1.0)
        axes.set_xticks(range(len(names)), names, rotation=20)
        axes.set_title("maximum" if index == "e_inf" else "rms", loc="left")
        axes.set_ylim(0.0, 1.08 * largest)
    panels[0].set_ylabel("ratio of errors, below 1: better")
    legend(panels[-1], 2)
    return figure
