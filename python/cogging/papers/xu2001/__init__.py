"""Xu and Yao 2001: output-feedback adaptive robust control and a PID on an epoxy-core linear motor (Table 1).

Blocks that are never mixed: Table 1 under the joint conditions, *calibrated* on all its numbers but du_rms, beside the
table before, whose plant is calibrated on the PID columns and whose ARC columns are *predicted* with everything as
printed; what fits to a part of the numbers *predict* of the others; and what else was assumed and tried, *exploratory*.
"""

from __future__ import annotations

from collections.abc import Callable

from cogging.papers.result import Reproduction
from cogging.papers.xu2001.backstepping import theorem_1_table
from cogging.papers.xu2001.epoxy_motor import (
    ALL,
    CONTROLLERS,
    HELD_OUT,
    JOINT_FREE,
    PID_FREE,
    Conditions,
    joint_conditions,
    shipped_unknowns,
)
from cogging.papers.xu2001.fast_motion import fast_motion_table, figure_fast, figure_reference, run_fast
from cogging.papers.xu2001.pid_poles import pid_poles_table
from cogging.papers.xu2001.robust_terms import figure_increment, one_count_table, subsets_table
from cogging.papers.xu2001.sinusoidal_motion import (
    DU_RMS,
    OF_SET,
    conditions_table,
    exploration_table,
    explore,
    explore_conditions,
    figure_errors,
    held_out_table,
    joint_note,
    seeds_table,
    table_1,
)


def reproduce(progress: Callable[[str], None] = lambda step: None) -> Reproduction:
    """Table 1 and Figs. 2 to 6. `progress` is called with each of STEPS as it is done."""
    unknowns = shipped_unknowns()
    joint = joint_conditions()
    before = table_1(Conditions(unknowns).table(), free=PID_FREE)
    table = table_1(joint.table(), fitted=ALL, free=JOINT_FREE, before=before)
    tables = [table, *map(held_out_table, HELD_OUT), seeds_table(joint), conditions_table()]
    progress("table 1")
    logs = {name: joint.logs(name) for name in CONTROLLERS}
    figures = {f"xu2001_fig{number}": figure_errors(logs, name) for name, (number, _, _) in OF_SET.items()}
    progress("figures 2 to 4")
    figures["xu2001_fig5"] = figure_reference()
    figures["xu2001_fig6"] = figure_fast(
        run_fast(joint.unknowns, {name: joint.controller(name) for name in CONTROLLERS})
    )
    claims = [fast_motion_table(unknowns, {"joint": (joint.unknowns, joint.arc_parameters())})]
    progress("figures 5, 6")
    claims += [one_count_table(), subsets_table(unknowns)]
    figures["xu2001_increment"] = figure_increment()
    progress("robust terms")
    claims += [theorem_1_table(unknowns), pid_poles_table(unknowns)]
    progress("theorem 1, PID poles")
    explored = {**explore(unknowns), **explore_conditions(unknowns, joint, logs["ARC"])}
    progress("exploration")
    tables.append(exploration_table(explored))
    return Reproduction("xu2001", [*tables, *claims], figures, [joint_note(table), DU_RMS])


#: The steps that reproduce() reports.
STEPS = ("table 1", "figures 2 to 4", "figures 5, 6", "robust terms", "theorem 1, PID poles", "exploration")
