"""Lu, Chen, Yao, Wang 2008: DCARC with a B-spline cogging model on the two axes of a gantry (Tables 1 and 2).

The cogging maps are fitted to all twelve numbers within the printed bound; what a fit to fewer predicts of the others
stands in tables of its own. Further tables show what the paper says and does not tabulate: where the maxima stand,
DCARC beside ARC, the error at constant speed, the spectrum of the scans, matrix (29), the claim on other maps,
Theorem 1.
Sources are cited as in setup.py.
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
    from cogging.logs.log import Log
    from cogging.mapping.map_fit import MapFit

FIGURES = {"X": (5, 7), "Y": (6, 9)}  # of the scan, and of the errors over the whole run


def reproduce(progress: Callable[[str], None] = lambda step: None) -> Reproduction:
    """Tables 1 and 2, Figs. 2, 3, 5 to 10, and the claims. `progress` is called with each of STEPS as it is done."""
    tables: list[Table] = []
    further: list[Table] = []
    figures: dict[str, Figure] = {}
    fits: dict[str, MapFit] = {}
    machines: dict[str, Plant] = {}
    runs: dict[str, dict[str, Log]] = {}
    for order, number in ((1, 2), (3, 3)):
        figures[f"lu2008_fig{number}"] = figure_spline(order, number)
    progress("figures 2, 3")
    for axis in AXES.values():
        map_number, error_number = FIGURES[axis.name]
        cogging = cogging_map(axis, shipped_amplitudes(axis))
        scan = CoggingScan.of(cogging)
        machine = machines[axis.name] = plant(axis, cogging)
        fits[axis.name] = scan.fit()
        figures[f"lu2008_fig{map_number}"] = figure_map(axis, scan, scan.fit(list(HARMONICS)), map_number)
        progress(f"figure {map_number}")
        logs = runs[axis.name] = run(axis, machine)
        tables.append(table(axis, logs))
        progress(f"{tables[-1].id}")
        figures[f"lu2008_fig{error_number}"] = figure_errors(axis, logs, error_number)
        figures[f"lu2008_fig{error_number + 1}"] = figure_errors(axis, logs, error_number + 1, last_period=True)
        progress(f"figures {error_number}, {error_number + 1}")
        further += [
            smoothness_table(axis, logs),
            harmonics_table(axis.name, cogging, fits[axis.name]),
            condition_table(axis, machine, logs["C3"]),
        ]
    tables += [maxima_table(runs), *map(held_out_table, SPLITS)]
    further.insert(0, laws_table(machines))
    figures["lu2008_fft"] = figure_fft(fits)
    progress("spectrum, matrix (29)")
    further += _claims(machines, figures, progress)
    note = (
        "The cogging maps are not published: four amplitudes are fitted to all twelve numbers within the printed bound "
        "of A_r.\nThe shape is a choice among the 432 that studies.lu2008.families prints. e' late: e' of p as the "
        "reading's difference minus\nthe velocity of x_d. Assumed, not reported: e', dwell, jerk, smoothing of the "
        "friction, harmonics of C2."
    )
    return Reproduction("lu2008", [*tables, *further], figures, [note])


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
