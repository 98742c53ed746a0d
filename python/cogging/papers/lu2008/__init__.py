"""Lu, Chen, Yao, Wang 2008: DCARC with a B-spline cogging model on the two axes of a gantry (Tables 1 and 2).

The cogging maps are fitted to all twelve numbers within the printed bound; what a fit to fewer predicts of the others
stands in tables of its own. Further tables show what the paper says and does not tabulate: where the maxima stand,
DCARC beside ARC, the error at constant speed, the spectrum of the scans, matrix (29), the claim on other maps,
Theorem 1.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import TYPE_CHECKING

from cogging.papers.lu2008.cogging_scan import CoggingScan, figure_fft, figure_map, figure_spline, harmonics_table
from cogging.papers.lu2008.gantry import AXES, HARMONICS, cogging_map, plant, run, shipped_amplitudes
from cogging.papers.lu2008.random_maps import KINDS, claim_table, errors_on_maps, figure_claim
from cogging.papers.lu2008.robust_bound import convergence_table, decays, figure_theorem, theorem_table
from cogging.papers.lu2008.stability_matrix import condition_table
from cogging.papers.lu2008.tracking import (
    SPLITS,
    figure_errors,
    held_out_table,
    laws_table,
    maxima_table,
    smoothness_table,
    table,
)
from cogging.papers.result import Reproduction, Table

if TYPE_CHECKING:
    from matplotlib.figure import Figure

    from cogging._core import Plant

NOTE = (
    "The cogging maps are not published: four amplitudes are fitted to all twelve numbers within the printed bound "
    "of A_r.\nThe shape is a choice among the 432 that studies.lu2008.families prints. e' late: e' of p as the "
    "reading's difference minus\nthe velocity of x_d. Assumed, not reported: e', dwell, jerk, smoothing of the "
    "friction, harmonics of C2."
)


def reproduce(progress: Callable[[str], None] = lambda step: None) -> Reproduction:
    """Return Tables 1 and 2, Figs. 2, 3, 5 to 10, and the claims; `progress` is called with each of STEPS."""
    tables: list[Table] = []
    further: list[Table] = []
    figures: dict[str, Figure] = {
        f"lu2008_fig{number}": figure_spline(order, number) for order, number in ((1, 2), (3, 3))
    }
    progress("figures 2, 3")
    machines, fits, runs = {}, {}, {}
    for (name, axis), of_scan, of_errors in zip(AXES.items(), (5, 6), (7, 9), strict=True):
        cogging = cogging_map(axis, shipped_amplitudes(axis))
        scan, machines[name] = CoggingScan.of(cogging), plant(axis, cogging)
        fits[name] = scan.fit()
        figures[f"lu2008_fig{of_scan}"] = figure_map(axis, scan, scan.fit(list(HARMONICS)), of_scan)
        progress(f"figure {of_scan}")
        logs = runs[name] = run(axis, machines[name])
        tables.append(table(axis, logs))
        progress(axis.table)
        for number, last_period in ((of_errors, False), (of_errors + 1, True)):
            figures[f"lu2008_fig{number}"] = figure_errors(axis, logs, number, last_period)
        progress(f"figures {of_errors}, {of_errors + 1}")
        further += [
            smoothness_table(axis, logs),
            harmonics_table(name, cogging, fits[name]),
            condition_table(axis, machines[name], logs["C3"]),
        ]
    tables += [maxima_table(runs), *map(held_out_table, SPLITS), laws_table(machines), *further]
    figures["lu2008_fft"] = figure_fft(fits)
    progress("spectrum, matrix (29)")
    tables += _claims(machines, figures, progress)
    return Reproduction("lu2008", tables, figures, [NOTE])


def _claims(machines: dict[str, Plant], figures: dict[str, Figure], progress: Callable[[str], None]) -> list[Table]:
    """What is claimed of any machine: on random maps, and Theorem 1 on drawn ones."""
    errors = {kind: {name: errors_on_maps(axis, kind=kind) for name, axis in AXES.items()} for kind in KINDS}
    figures["lu2008_claim"] = figure_claim(errors[KINDS[1]])
    progress("claim on random maps")
    found = {name: decays(axis) for name, axis in AXES.items()}
    bounds = [theorem_table(axis, machines[name]) for name, axis in AXES.items()]
    figures["lu2008_theorem1"] = figure_theorem(found)
    progress("theorem 1")
    return [claim_table(errors), *bounds, convergence_table(found)]


#: The steps that reproduce() reports.
STEPS = (
    "figures 2, 3",
    "figure 5",
    "table1",
    "figures 7, 8",
    "figure 6",
    "table2",
    "figures 9, 10",
    "spectrum, matrix (29)",
    "claim on random maps",
    "theorem 1",
)
