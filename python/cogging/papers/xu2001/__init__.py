"""Xu and Yao 2001: output-feedback adaptive robust control and a PID on an epoxy-core linear motor (Table 1).

Parts that are never mixed: Table 1 under the joint conditions, *calibrated* on all its numbers but du_rms, beside the
table before, whose plant is calibrated on the PID columns and whose ARC columns are *predicted* with all numbers as
printed; what fits to a part of the numbers *predict* of the others; and other assumptions, *exploratory*.
"""

from __future__ import annotations

from collections.abc import Callable

from cogging.papers.result import Reproduction
from cogging.papers.xu2001 import backstepping, epoxy_motor, motion_cases
from cogging.papers.xu2001.epoxy_motor import ALL, CONTROLLERS, HELD_OUT, JOINT_FREE, PID_FREE, Conditions
from cogging.papers.xu2001.pid_poles import pid_poles_table

DU_RMS = "du_rms = c_u u_rms by (54): derived and not counted. The paper prints it with one digit."
STEPS = 6  # that reproduce() reports


def reproduce(progress: Callable[[str], None] = lambda step: None) -> Reproduction:
    """Return Table 1, Figs. 2 to 6, and the claims; `progress` is called with each step."""
    unknowns, joint = epoxy_motor.shipped_unknowns(), epoxy_motor.joint_conditions()
    before = motion_cases.table_1(Conditions(unknowns).table(), free=PID_FREE)
    table = motion_cases.table_1(joint.table(), fitted=ALL, free=JOINT_FREE, before=before)
    tables = [table, *map(motion_cases.held_out_table, HELD_OUT)]
    tables += [motion_cases.seeds_table(joint), motion_cases.conditions_table()]
    progress("table 1")
    logs = {name: joint.logs(name) for name in CONTROLLERS}
    numbers = {name: number for name, (number, *_) in motion_cases.OF_SET.items()}
    figures = {f"xu2001_fig{number}": motion_cases.figure_errors(logs, name) for name, number in numbers.items()}
    progress("figures 2 to 4")
    figures["xu2001_fig5"] = motion_cases.figure_reference()
    figures["xu2001_fig6"] = motion_cases.figure_fast(motion_cases.run_fast(joint))
    claims = [motion_cases.fast_motion_table(unknowns, joint)]
    progress("figures 5, 6")
    claims += [backstepping.one_count_table(), backstepping.subsets_table(unknowns)]
    figures["xu2001_increment"] = backstepping.figure_increment()
    progress("robust terms")
    claims += [backstepping.theorem_1_table(unknowns), pid_poles_table(unknowns)]
    progress("theorem 1, PID poles")
    tables.append(motion_cases.exploration_table(unknowns, joint, logs["ARC"]))
    progress("exploration")
    return Reproduction("xu2001", [*tables, *claims], figures, [motion_cases.joint_note(table), DU_RMS])
