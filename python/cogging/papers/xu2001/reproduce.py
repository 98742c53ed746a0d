"""Xu and Yao 2001: output-feedback adaptive robust control and a PID on an epoxy-core linear motor (Table 1).

Three blocks that are never mixed: the plant's unknowns are *calibrated* on the PID columns (calibration.py), the
ARC columns are *predicted* with the printed gains in the reading that can run, and what would explain the difference
is *exploratory* (study.py).
"""

from __future__ import annotations

from collections.abc import Callable

from cogging._core import OutputFeedbackArc, Pid, closed_loop
from cogging.logs.log import Log
from cogging.model.controller import ListedController
from cogging.papers.result import Reproduction
from cogging.papers.xu2001.exploration import explore
from cogging.papers.xu2001.figures import figure_errors, figure_reference
from cogging.papers.xu2001.robust_terms import figure_increment
from cogging.papers.xu2001.setup import (
    SEED,
    arc_parameters,
    fast_reference,
    pid_parameters,
    plant,
    run,
    shipped_unknowns,
)
from cogging.papers.xu2001.tables import exploration_table, table_1


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
