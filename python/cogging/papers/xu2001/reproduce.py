"""Xu and Yao 2001: output-feedback adaptive robust control and a PID on an epoxy-core linear motor (Table 1).

Blocks that are never mixed: Table 1 under the joint conditions, *calibrated* on all its numbers but du_rms, beside the
table before, whose plant is calibrated on the PID columns and whose ARC columns are *predicted* with everything as
printed; what fits to a part of the numbers *predict* of the others; and what else was assumed and tried, *exploratory*.
"""

from __future__ import annotations

from collections.abc import Callable

from cogging._core import OutputFeedbackArc, Pid, closed_loop
from cogging.logs.log import Log
from cogging.model.controller import ListedController
from cogging.papers.result import Reproduction
from cogging.papers.xu2001.calibration import ALL
from cogging.papers.xu2001.conditions import JOINT_FREE, PID_FREE, joint_conditions
from cogging.papers.xu2001.exploration import explore, explore_conditions
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
from cogging.papers.xu2001.tables import (
    DU_RMS,
    conditions_table,
    exploration_table,
    held_out_tables,
    joint_note,
    table_1,
)


def reproduce(progress: Callable[[str], None] = lambda step: None) -> Reproduction:
    """Table 1 and Figs. 2 to 6. `progress` is told each of STEPS as it is done."""
    unknowns = shipped_unknowns()
    joint = joint_conditions()
    controllers: dict[str, ListedController] = {
        "PID": Pid(pid_parameters()),
        "ARC": OutputFeedbackArc(arc_parameters()),
    }
    logs = joint.all_logs()
    as_printed = {name: run(unknowns, controller) for name, controller in controllers.items()}
    table = table_1(logs, fitted=ALL, free=JOINT_FREE, before=table_1(as_printed, free=PID_FREE))
    tables = [table, *held_out_tables(), conditions_table()]
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
    explored = {**explore(unknowns), **explore_conditions(unknowns, joint, logs["ARC"])}
    figures["xu2001_increment"] = figure_increment()
    progress("exploration")
    return Reproduction("xu2001", [*tables, exploration_table(explored)], figures, [joint_note(table), DU_RMS])


#: What reproduce() tells its progress.
STEPS = ("table 1", "figures 2 to 4", "figures 5, 6", "exploration")
