"""Case 2 of Xu and Yao 2001: the fast point-to-point motion, the ARC within 1 um at rest (section 4.3), Figs. 5, 6."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from cogging._core import OutputFeedbackArc, OutputFeedbackArcParameters, Pid
from cogging.logs.log import Log
from cogging.model.controller import ListedController
from cogging.papers.result import Row, Table
from cogging.papers.xu2001.epoxy_motor import (
    CONTROLLERS,
    RESOLUTION,
    SEED,
    Unknowns,
    arc_parameters,
    fast_reference,
    pid_parameters,
    plant,
    shipped_unknowns,
)
from cogging.plot.canvas import drawn, new_figure
from cogging.plot.scales import pretty, scale_of
from cogging.plot.series import LIMIT, look
from cogging.plot.traces import draw_trace
from cogging.simulation.batch import closed_loop_batch

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure
BAND = 5e-6  # m: scale of the rests in Fig. 6
WITHIN = 1e-6  # m: what the paper says of the ARC in the rests
SETTLING = 0.3  # s of each rest that are left out of `e_settled`; assumed, the paper's rests are a picture


@drawn
def figure_reference() -> Figure:
    """Fig. 5: the fast point-to-point motion; dashed: the printed largest velocity and acceleration."""
    motion = fast_reference()
    time = np.linspace(0.0, motion.end, 4001)
    figure = new_figure((8.0, 5.4))
    figure.suptitle("Fig. 5: fast point-to-point motion (stroke and rests assumed)")
    quantities = (("position", "m", 0.0), ("velocity", "m/s", 1.0), ("acceleration", "m/s^2", 12.0))
    panels = figure.subplots(3, 1, sharex=True)
    for axes, values, (name, unit, largest) in zip(panels, motion.sample(time), quantities, strict=True):
        axes.plot(time, values, **look(0))
        axes.set(ylabel=f"{name}\n({pretty(unit)})")
        for side in (-1.0, 1.0) if largest else ():
            axes.axhline(side * largest, color=LIMIT, linestyle=(0, (6, 3)), linewidth=1.0)
    panels[-1].set(xlabel="time (s)")
    figure.align_ylabels(panels)
    return figure


@drawn
def figure_fast(logs: Mapping[str, Log]) -> Figure:
    """Fig. 6: the errors of PID and ARC in the fast motion on one scale, and in one rest beside the paper's 1 um."""
    motion = fast_reference()
    rest = (motion.move_time, motion.period / 2.0)
    scale = scale_of("m", *(logs[name].error for name in CONTROLLERS))
    figure = new_figure((8.0, 4.7))
    figure.suptitle("Fig. 6: fast point-to-point motion, and its first rest")
    panels = figure.subplots(2, 2, sharex="col", sharey="col")
    for row, name in zip(panels, CONTROLLERS, strict=True):
        log = logs[name]
        for axes, (start, end) in zip(row, ((-np.inf, np.inf), rest), strict=True):
            shown = (log.time >= start) & (log.time < end)
            draw_trace(axes, log.time[shown], scale(log.error[shown]), linewidth=0.8, **look(0, dense=True))
            axes.margins(x=0.01)
        row[0].set(ylabel=scale.label("error"))
        row[0].set_title(name, fontsize="small", loc="left", pad=3.0)
        _mark_band(row[1], float(scale(WITHIN)), float(scale(BAND)))
    for axes in panels[-1]:
        axes.set(xlabel="time (s)")
    return figure


def _mark_band(axes: Axes, size: float, end: float) -> None:
    for side in (-size, size):
        axes.axhline(side, color=LIMIT, linestyle=(0, (6, 3)), linewidth=1.0)
    axes.set(ylim=(-end, end))
    axes.set_title("dashed: the paper's ±1 µm of the ARC at rest", fontsize="small", loc="right", pad=3.0)


class Errors(NamedTuple):
    """Largest |encoder reading - reference| of a run of case 2, m.

    Attributes:
        moving: while the reference moves.
        at_rest: while it rests.
        settled: in each rest after SETTLING.
        settling: s, the longest time from the end of a move until the error stays within WITHIN.
    """

    moving: float
    at_rest: float
    settled: float
    settling: float


def errors(log: Log) -> Errors:
    """The errors of a run of case 2; the settling is the whole rest where one does not come to stay within WITHIN."""
    motion = fast_reference()
    half = motion.period / 2.0
    since = np.mod(log.time, half) - motion.move_time
    size, moving = np.abs(log.error), since < 0.0
    outside = ~moving & (size > WITHIN + 1e-3 * RESOLUTION)  # readings are whole counts
    settling = float(since[outside].max(initial=0.0))
    return Errors(float(size[moving].max()), float(size[~moving].max()), float(size[since > SETTLING].max()), settling)


def run_fast(unknowns: Unknowns, controllers: Mapping[str, ListedController], seed: int = SEED) -> dict[str, Log]:
    """Case 2 without load."""
    made = list(controllers.values())
    machines = [plant(unknowns, "1")] * len(made)
    batch = closed_loop_batch(machines, made, fast_reference(), seeds=[seed] * len(made), logs=True)
    return dict(zip(controllers, batch, strict=True))


def machines(unknowns: Unknowns) -> dict[str, Unknowns]:
    """The plants on which case 2 is run: what decides the rest is the encoder's noise and whether friction sticks."""
    sticks = shipped_unknowns("exact_stribeck")
    return {
        "calibrated": unknowns,
        "no encoder noise": replace(unknowns, encoder_noise=0.0),
        "noise x 2": replace(unknowns, encoder_noise=2.0 * unknowns.encoder_noise),
        "no ripple": replace(unknowns, ripple=0.0),
        "friction that sticks": sticks,
        "sticks, no noise": replace(sticks, encoder_noise=0.0),
    }


def fast_motion_table(
    unknowns: Unknowns, others: Mapping[str, tuple[Unknowns, OutputFeedbackArcParameters]] | None = None
) -> Table:
    """Errors of PID and ARC moving and at rest; of the ARC's rest the paper prints 1 um.

    Args:
        unknowns: of the calibrated plant, under the ARC as printed.
        others: further plants by name, each with its ARC.
    """
    places = {name: (machine, arc_parameters()) for name, machine in machines(unknowns).items()} | dict(others or {})
    rows = []
    for place, (machine, parameters) in places.items():
        pair: dict[str, ListedController] = {"PID": Pid(pid_parameters()), "ARC": OutputFeedbackArc(parameters)}
        for name, log in run_fast(machine, pair).items():
            found = errors(log)
            claimed = name == "ARC" and (place == "calibrated" or place in (others or {}))
            units = {"e_moving": "m", "e_at_rest": "m", "e_settled": "m", "settling": "s"}
            for (index, unit), value in zip(units.items(), found, strict=True):
                is_claim = claimed and index == "e_settled"
                status, printed = ("predicted", WITHIN) if is_claim else ("exploratory", None)
                rows.append(Row(name, index, unit, printed, value, status, {"plant": place}))
    return Table("fast_motion", "Case 2, fast point-to-point motion: largest errors moving and at rest", rows)
