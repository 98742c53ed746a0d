"""Lu, Chen, Yao, Wang 2008: DCARC with a B-spline cogging model on the two axes of a gantry (Tables 1 and 2).

The cogging maps are fitted to all twelve numbers within the printed bound; further tables show what fits to fewer
numbers predict of the others, and what the paper says without numbers: where the maxima occur, DCARC beside ARC, the
error at constant speed, the spectrum of the scans, matrix (29), the claim on other maps, Theorem 1.
"""

from __future__ import annotations

from collections.abc import Callable

from matplotlib.figure import Figure

from cogging.papers.lu2008 import cogging_scan, gantry, theorem_1, tracking
from cogging.papers.lu2008.gantry import AXES
from cogging.papers.lu2008.theorem_1 import condition_table
from cogging.papers.result import Reproduction, Table

NOTE = (
    "The cogging maps are not published: four amplitudes are fitted to all twelve numbers within the printed bound "
    "of A_r.\nThe shape is a choice among the 432 that studies.lu2008.families prints. e' late: e' of p as the "
    "reading's difference minus\nthe velocity of x_d. Assumed, not reported: e', dwell, jerk, smoothing of the "
    "friction, harmonics of C2."
)
STEPS = 10  # that reproduce() reports


def reproduce(progress: Callable[[str], None] = lambda step: None) -> Reproduction:
    """Return Tables 1 and 2, Figs. 2, 3, 5 to 10, and the claims; `progress` is called with each step."""
    tables: list[Table] = []
    further: list[Table] = []
    figures: dict[str, Figure] = {
        f"lu2008_fig{number}": cogging_scan.figure_spline(order, number) for order, number in ((1, 2), (3, 3))
    }
    progress("figures 2, 3")
    machines, fits, runs = {}, {}, {}
    for (name, axis), of_scan, of_errors in zip(AXES.items(), (5, 6), (7, 9), strict=True):
        cogging = gantry.cogging_map(axis, gantry.shipped_amplitudes(axis))
        scan, machines[name] = cogging_scan.scan_force(cogging), gantry.plant(axis, cogging)
        fits[name] = cogging_scan.fit_scan(scan)
        figures[f"lu2008_fig{of_scan}"] = cogging_scan.figure_map(axis, scan, of_scan)
        progress(f"figure {of_scan}")
        logs = runs[name] = gantry.run(axis, machines[name])
        tables.append(tracking.table(axis, logs))
        progress(axis.table)
        for number, last_period in ((of_errors, False), (of_errors + 1, True)):
            figures[f"lu2008_fig{number}"] = tracking.figure_errors(axis, logs, number, last_period)
        progress(f"figures {of_errors}, {of_errors + 1}")
        further += [
            tracking.smoothness_table(axis, logs),
            cogging_scan.harmonics_table(name, cogging, fits[name]),
            condition_table(axis, machines[name], logs["C3"]),
        ]
    tables += [tracking.maxima_table(runs), *map(tracking.held_out_table, tracking.SPLITS)]
    tables += [tracking.laws_table(machines), *further]
    figures["lu2008_fft"] = cogging_scan.figure_fft(fits)
    progress("spectrum, matrix (29)")
    errors = {
        kind: {name: tracking.errors_on_maps(axis, kind=kind) for name, axis in AXES.items()} for kind in tracking.KINDS
    }
    figures["lu2008_claim"] = tracking.figure_claim(errors[tracking.KINDS[1]])
    tables.append(tracking.claim_table(errors))
    progress("claim on random maps")
    decays = {name: theorem_1.decays(axis) for name, axis in AXES.items()}
    tables += [theorem_1.theorem_table(axis, machines[name]) for name, axis in AXES.items()]
    tables.append(theorem_1.convergence_table(decays))
    figures["lu2008_theorem1"] = theorem_1.figure_theorem(decays)
    progress("theorem 1")
    return Reproduction("lu2008", tables, figures, [NOTE])
