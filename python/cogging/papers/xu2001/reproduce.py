"""Xu and Yao 2001: output-feedback adaptive robust control and a PID on an epoxy-core linear motor (Table 1).

Three blocks that are never mixed: the plant's unknowns are *calibrated* on the PID columns (calibration.py), the
ARC columns are *predicted* with the printed gains in the reading that can run, and what would explain the difference
is *exploratory* (study.py).
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import TYPE_CHECKING

import numpy as np

from cogging._core import OutputFeedbackArc, Pid, closed_loop
from cogging.logs.log import Log
from cogging.model.controller import ListedController
from cogging.papers.result import Reproduction, Row, Table
from cogging.papers.xu2001.exploration import explore
from cogging.papers.xu2001.robust_terms import figure_increment
from cogging.papers.xu2001.setup import (
    CONTROLLERS,
    INDEXES,
    SEED,
    SETS,
    TABLE_1,
    UNITS,
    arc_parameters,
    fast_reference,
    indexes,
    pid_parameters,
    plant,
    run,
    shipped_unknowns,
)
from cogging.plot.canvas import drawn, new_figure

if TYPE_CHECKING:
    from matplotlib.figure import Figure


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


def reproduce(progress: Callable[[str], None] = lambda step: None) -> Reproduction:
    """Table 1 and Figs. 2 to 6. `progress` is told each of STEPS as it is done."""
    unknowns = shipped_unknowns()
    controllers: dict[str, ListedController] = {
        "PID": Pid(pid_parameters()),
        "ARC": OutputFeedbackArc(arc_parameters()),
    }
    logs = {name: run(unknowns, controller) for name, controller in controllers.items()}
    table = table_1(logs)
    progress("table 1")
    titles = {"1": "without load", "2": "with load", "3": "with disturbance"}
    figures = {
        f"xu2001_fig{number}": figure_errors(logs, name, f"Fig. {number}: sinusoidal motion {titles[name]}")
        for number, name in ((2, "1"), (3, "2"), (4, "3"))
    }
    progress("figures 2 to 4")
    fast = {
        name: {"1": Log.of(closed_loop(plant(unknowns, "1"), controller, fast_reference(), seed=SEED))}
        for name, controller in controllers.items()
    }
    figures["xu2001_fig5"] = figure_reference()
    figures["xu2001_fig6"] = figure_errors(fast, "1", "Fig. 6: fast point-to-point motion")
    progress("figures 5, 6")
    explored = explore(unknowns)
    figures["xu2001_increment"] = figure_increment()
    progress("exploration")
    note = (
        "The published ARC columns were not reproduced from the printed numbers: on a plant calibrated on the PID\n"
        "columns alone, the printed gains give the errors above. The robust terms are off, because as printed they\n"
        "cannot run on a 1 um encoder."
    )
    return Reproduction("xu2001", [table, exploration_table(explored)], figures, [note])


#: What reproduce() tells its progress.
STEPS = ("table 1", "figures 2 to 4", "figures 5, 6", "exploration")


@drawn
def figure_errors(logs: Mapping[str, Mapping[str, Log]], set_name: str, title: str) -> Figure:
    """Figs. 2, 3, 4, 6: the tracking errors of PID and ARC."""
    figure = new_figure((8.0, 5.0))
    figure.suptitle(title)
    for axes, name in zip(figure.subplots(2, 1, sharex=True), CONTROLLERS, strict=True):
        log = logs[name][set_name]
        axes.plot(log.time, 1e6 * log.error, linewidth=0.6)
        axes.set(ylabel=f"{name} (µm)", xlabel="time (s)" if name == "ARC" else None)
        axes.grid(alpha=0.3)
    return figure


@drawn
def figure_reference() -> Figure:
    """Fig. 5: the fast point-to-point motion."""
    motion = fast_reference()
    time = np.linspace(0.0, motion.end, 2001)
    figure = new_figure((8.0, 5.0))
    figure.suptitle("Fig. 5: fast point-to-point motion (stroke and rests assumed)")
    names = ("position (m)", "velocity (m/s)", "acceleration (m/s^2)")
    for axes, values, name in zip(figure.subplots(3, 1, sharex=True), motion.sample(time), names, strict=True):
        axes.plot(time, values, linewidth=0.8)
        axes.set(ylabel=name)
    figure.axes[-1].set(xlabel="time (s)")
    return figure
