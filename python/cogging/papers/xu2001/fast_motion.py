"""Case 2 of Xu and Yao 2001: the fast point-to-point motion, the ARC within 1 um at rest (section 4.3), Figs. 5, 6."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from typing import NamedTuple

import numpy as np
from matplotlib.figure import Figure

from cogging.logs.log import Log
from cogging.papers.compared import PRINTED
from cogging.papers.result import Row, Table
from cogging.papers.xu2001 import epoxy_motor
from cogging.papers.xu2001.epoxy_motor import CONTROLLERS, SEED, Conditions, Unknowns, fast_reference
from cogging.plot.canvas import drawn, new_figure
from cogging.plot.scales import pretty, scale_of
from cogging.plot.series import look
from cogging.plot.traces import draw_trace
from cogging.simulation.batch import closed_loop_batch

BAND = 5e-6  # m: scale of the rests in Fig. 6
WITHIN = 1e-6  # m: the paper's claim on the ARC in the rests
SETTLING = 0.3  # s of each rest that `e_settled` leaves out; assumed, the paper's rests are a picture


class Errors(NamedTuple):
    """Largest |encoder reading - reference| of a run of case 2, m."""

    moving: float  # while the reference moves
    at_rest: float  # while it rests
    settled: float  # in each rest after SETTLING
    settling: float  # s, longest time from the end of a move until the error stays within WITHIN, at most the rest


def errors(log: Log) -> Errors:
    """Return the errors of a run of case 2."""
    motion = fast_reference()
    since = np.mod(log.time, motion.period / 2.0) - motion.move_time
    size, moving = np.abs(log.error), since < 0.0
    outside = ~moving & (size > WITHIN + 1e-3 * epoxy_motor.RESOLUTION)  # readings are whole counts
    settling = float(since[outside].max(initial=0.0))
    return Errors(float(size[moving].max()), float(size[~moving].max()), float(size[since > SETTLING].max()), settling)


def run_fast(conditions: Conditions) -> dict[str, Log]:
    """Return the logs of PID and ARC in case 2 without load."""
    laws = [conditions.controller(name) for name in CONTROLLERS]
    machines = [epoxy_motor.plant(conditions.unknowns, "1")] * len(laws)
    batch = closed_loop_batch(machines, laws, fast_reference(), seeds=[SEED] * len(laws), logs=True)
    return dict(zip(CONTROLLERS, batch, strict=True))


def fast_motion_table(unknowns: Unknowns, joint: Conditions) -> Table:
    """Tabulate errors of PID and ARC, moving and at rest, on the calibrated plants and variations of the first."""
    sticks = epoxy_motor.shipped_unknowns("exact_stribeck")
    plants = {
        "calibrated": unknowns,
        "no encoder noise": replace(unknowns, encoder_noise=0.0),
        "noise x 2": replace(unknowns, encoder_noise=2.0 * unknowns.encoder_noise),
        "no ripple": replace(unknowns, ripple=0.0),
        "friction that sticks": sticks,
        "sticks, no noise": replace(sticks, encoder_noise=0.0),
    }
    units = {"e_moving": "m", "e_at_rest": "m", "e_settled": "m", "settling": "s"}
    rows = []
    for place, conditions in {**{name: Conditions(each) for name, each in plants.items()}, "joint": joint}.items():
        for name, log in run_fast(conditions).items():
            for (index, unit), value in zip(units.items(), errors(log), strict=True):
                claimed = name == "ARC" and place in ("calibrated", "joint") and index == "e_settled"
                status, printed = ("predicted", WITHIN) if claimed else ("exploratory", None)
                rows.append(Row(name, index, unit, printed, value, status, {"plant": place}))
    return Table("fast_motion", "Case 2, fast point-to-point motion: largest errors moving and at rest", rows)


@drawn
def figure_reference() -> Figure:
    """Draw Fig. 5: the fast point-to-point motion; dashed: the printed largest velocity and acceleration."""
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
            axes.axhline(side * largest, **PRINTED)
    panels[-1].set(xlabel="time (s)")
    figure.align_ylabels(panels)
    return figure


@drawn
def figure_fast(logs: Mapping[str, Log]) -> Figure:
    """Draw Fig. 6: the errors of PID and ARC in the fast motion, and in one rest beside the paper's 1 um."""
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
        for side in (-1.0, 1.0):
            row[1].axhline(side * float(scale(WITHIN)), **PRINTED)
        row[1].set(ylim=(-float(scale(BAND)), float(scale(BAND))))
        row[1].set_title("dashed: the paper's ±1 µm of the ARC at rest", fontsize="small", loc="right", pad=3.0)
    for axes in panels[-1]:
        axes.set(xlabel="time (s)")
    return figure
