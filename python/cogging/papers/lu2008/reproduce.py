"""Lu, Chen, Yao, Wang 2008: DCARC with a B-spline cogging model on the two axes of a gantry (Tables 1 and 2).

Each cogging map is calibrated on the three rms values, the maxima then follow. Sources are cited as in setup.py.
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
from cogging.papers.lu2008.tables import table
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
    note = (
        "The cogging maps are not published: three amplitudes an axis are calibrated on the three rms values "
        "(e_2),\nthe maxima (e_inf) are predicted. Assumed, not reported: shape of the maps, dwell, jerk, "
        "smoothing of the friction."
    )
    return Reproduction("lu2008", tables, figures, [note])


#: What reproduce() tells its progress.
STEPS = ("figures 2, 3", "figure 5", "table1", "figures 7, 8", "figure 6", "table2", "figures 9, 10")
