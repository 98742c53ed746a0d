"""Malaize and Levine 2009: observer-based cancellation of cogging beside a PID on two motors (Table I).

Calibrated: amplitudes on the PID row, pole radii on lambda*, and on the observer row one share of unmodelled lines or,
in a second table, one width of smooth friction. Where all is as believed, shown before, the observer row is predicted.
Further tables say what these hide: what else would explain the observer row, and what it gives to the other motor; what
happens with ripple, thrust constant, encoder, friction and periods that are not as believed; how the errors with smooth
friction go from stroke to stroke; and what Theorem 3 gives as printed.
"""

from __future__ import annotations

from collections.abc import Callable

from cogging.papers.malaize2009.accuracies import (
    accuracies_as_believed,
    accuracies_of_table_1,
    figure_errors,
    figure_held_out,
    figure_spectrum,
    figure_velocity,
    held_out,
    logs_of_table_1,
    spectra_of,
    spread_over_draws,
    table_1,
    what_else,
    what_explains,
)
from cogging.papers.malaize2009.causes import FRICTION, LINES, explained
from cogging.papers.malaize2009.linear_motors import MOTORS, accuracy
from cogging.papers.malaize2009.robustness import figure_ripple, figure_robustness, smooth_friction, table_2
from cogging.papers.malaize2009.theorem_3 import further_tables
from cogging.papers.result import Reproduction


def reproduce(progress: Callable[[str], None] = lambda step: None) -> Reproduction:
    """Table I, what it hides, Theorem 3, and the figures; `progress` is called with each of STEPS.

    Without cvxpy (extra `design`) the table of Theorem 3 is left out, and a note says so.
    """
    logs = logs_of_table_1()
    believed, found = accuracies_as_believed(), accuracies_of_table_1()
    shown = [
        table_1(LINES, found, believed),
        table_1(FRICTION, accuracies_of_table_1(FRICTION), believed),
    ]
    progress("table 1")
    spectra = spectra_of(logs)
    figures = {"malaize2009_fig2": figure_velocity(), "malaize2009_fig3": figure_spectrum(spectra)}
    figures["malaize2009_fig4"] = figure_errors(logs, MOTORS["ironcore"])
    figures["malaize2009_fig4_ironless"] = figure_errors(logs, MOTORS["ironless"])
    progress("figures 2 to 4")
    tables = [*shown, table_2(), smooth_friction()]
    progress("imperfections")
    causes = explained()
    tables += [what_explains(causes), held_out(causes), what_else(causes), spread_over_draws(causes, found)]
    figures["malaize2009_held_out"] = figure_held_out(causes)
    progress("causes")
    figures["malaize2009_ripple"] = figure_ripple()
    progress("ripple")
    figures["malaize2009_robustness"] = figure_robustness()
    progress("robustness")
    theorem, note = further_tables()
    progress("theorem 3")
    cold = ", ".join(
        f"{motor.name} {1e6 * accuracy(logs[motor.name]['observer'], motor, cold=True):.2f} um"
        for motor in MOTORS.values()
    )
    proposed = "; ".join(
        f"{name} {', '.join(f'{1e3 * period:.1f}' for period in pair['PID'].periods)} mm"
        for name, pair in spectra.items()
    )
    notes = [
        f"First stroke of the observer, in which it knows nothing, with unmodelled lines (draw 0): {cold}.",
        f"Periods proposed by the spectrum of the PID's error, with unmodelled lines: {proposed}.",
        "lambda* reports the bound on the poles, which the paper does not state: it was fitted to lambda*.",
    ]
    return Reproduction("malaize2009", [*tables, *theorem], figures, [*notes, *note])


#: The steps that reproduce() reports.
STEPS = ("table 1", "figures 2 to 4", "imperfections", "causes", "ripple", "robustness", "theorem 3")
