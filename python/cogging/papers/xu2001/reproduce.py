"""Xu and Yao 2001: output-feedback adaptive robust control and a PID on an epoxy-core linear motor (Table 1).

Three blocks that are never mixed: the plant's unknowns are *calibrated* on the PID columns (calibration.py), the
ARC columns are *predicted* with the printed gains in the reading that can run, and what would explain the difference
is *exploratory* (study.py).
"""

from __future__ import annotations

from collections.abc import Callable

from cogging._core import OutputFeedbackArc, Pid
from cogging.model.controller import ListedController
from cogging.papers.result import Reproduction
from cogging.papers.xu2001.exploration import explore
from cogging.papers.xu2001.fast_motion import fast_motion_table, run_fast
from cogging.papers.xu2001.figures import OF_SET, figure_errors, figure_fast, figure_increment, figure_reference
from cogging.papers.xu2001.pid_poles import pid_poles_table
from cogging.papers.xu2001.robust_terms import one_count_table, subsets_table
from cogging.papers.xu2001.setup import arc_parameters, pid_parameters, run, shipped_unknowns
from cogging.papers.xu2001.tables import exploration_table, table_1
from cogging.papers.xu2001.theorem_1 import theorem_1_table


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
    figures = {f"xu2001_fig{number}": figure_errors(logs, name) for name, (number, _, _) in OF_SET.items()}
    progress("figures 2 to 4")
    figures["xu2001_fig5"] = figure_reference()
    figures["xu2001_fig6"] = figure_fast(run_fast(unknowns, controllers))
    claims = [fast_motion_table(unknowns)]
    progress("figures 5, 6")
    claims += [one_count_table(), subsets_table(unknowns)]
    figures["xu2001_increment"] = figure_increment()
    progress("robust terms")
    claims += [theorem_1_table(unknowns), pid_poles_table(unknowns)]
    progress("theorem 1, PID poles")
    explored = explore(unknowns)
    progress("exploration")
    note = (
        "The published ARC columns were not reproduced from the printed numbers: on a plant calibrated on the PID\n"
        "columns alone, the printed gains give the errors above. The robust terms are off, because as printed they\n"
        "cannot run on a 1 um encoder."
    )
    return Reproduction("xu2001", [table, *claims, exploration_table(explored)], figures, [note])


#: What reproduce() tells its progress.
STEPS = ("table 1", "figures 2 to 4", "figures 5, 6", "robust terms", "theorem 1, PID poles", "exploration")
