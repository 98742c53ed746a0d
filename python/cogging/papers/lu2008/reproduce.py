"""Lu, Chen, Yao, Wang 2008: DCARC with a B-spline cogging model on the two axes of a gantry (Tables 1 and 2).

The cogging maps are fitted to all twelve numbers within the printed bound; what a fit to fewer predicts of the others
stands in tables of its own. Sources are cited as in setup.py.
"""

from __future__ import annotations

from collections.abc import Callable

from cogging.papers.lu2008.figures import figure_errors, figure_map, figure_spline
from cogging.papers.lu2008.setup import (
    AXES,
    cogging_map,
    plant,
    run,
    shipped_amplitudes,
)
from cogging.papers.lu2008.tables import held_out_table, table, trivial_table, without_c3_table
from cogging.papers.result import Reproduction


def reproduce(progress: Callable[[str], None] = lambda step: None) -> Reproduction:
    """Tables 1 and 2 and Figs. 2, 3, 5 to 10. `progress` is told each of STEPS as it is done."""
    tables, figures = [], {}
    for order, number in ((1, 2), (3, 3)):
        figures[f"lu2008_fig{number}"] = figure_spline(order, number)
    progress("figures 2, 3")
    for axis, map_number, error_number in ((AXES["X"], 5, 7), (AXES["Y"], 6, 9)):
        cogging = cogging_map(axis, shipped_amplitudes(axis))
        figures[f"lu2008_fig{map_number}"] = figure_map(axis, cogging, map_number)
        progress(f"figure {map_number}")
        logs = run(axis, plant(axis, cogging))
        tables.append(table(axis, logs))
        progress(f"{tables[-1].id}")
        figures[f"lu2008_fig{error_number}"] = figure_errors(axis, logs, error_number)
        figures[f"lu2008_fig{error_number + 1}"] = figure_errors(axis, logs, error_number + 1, last_period=True)
        progress(f"figures {error_number}, {error_number + 1}")
    tables += [held_out_table("X"), held_out_table("Y"), without_c3_table(), trivial_table()]
    note = (
        "The cogging maps are not published: one shape for both axes and three amplitudes for each are fitted to all "
        "twelve\nnumbers within the printed bound of A_r, by ten free parameters. Before: another shape, three "
        "amplitudes an axis\ncalibrated on e_2 alone. Assumed, not reported: dwell, jerk, smoothing of the friction, "
        "harmonics of C2."
    )
    return Reproduction("lu2008", tables, figures, [note])


#: What reproduce() tells its progress.
STEPS = ("figures 2, 3", "figure 5", "table1", "figures 7, 8", "figure 6", "table2", "figures 9, 10")
