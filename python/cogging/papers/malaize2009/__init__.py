"""Malaize and Levine 2009: observer-based cancellation of cogging beside a PID on two motors (Table I).

Calibrated: amplitudes on the PID row, pole radii on lambda*, and on the observer row one share of unmodelled lines or,
in a second table, one width of smooth friction. If all is as believed, shown before, the observer row is predicted.
Further tables: what else would explain the observer row, and what it predicts of the other motor; ripple, thrust
constant, encoder, friction and periods that are not as believed; errors with smooth friction from stroke to stroke; and
the solution of Theorem 3 as printed.
"""

from __future__ import annotations

from collections.abc import Callable
from functools import partial

from cogging.mapping.error_spectrum import tracking_spectrum
from cogging.papers.malaize2009 import accuracies
from cogging.papers.malaize2009.causes import FRICTION, LINE_PERIODS, LINES, explained
from cogging.papers.malaize2009.linear_motors import MOTORS, accuracy
from cogging.papers.malaize2009.theorem_3 import further_tables
from cogging.papers.result import Reproduction

STEPS = 7  # that reproduce() reports


def reproduce(progress: Callable[[str], None] = lambda step: None) -> Reproduction:
    """Return Table I, what it hides, figures, and Theorem 3 where cvxpy is; `progress` is called with each step."""
    logs = accuracies.logs_of_table_1()
    believed, found = accuracies.accuracies_as_believed(), accuracies.accuracies_of_table_1()
    with_friction = accuracies.accuracies_of_table_1(FRICTION)
    tables = [accuracies.table_1(LINES, found, believed), accuracies.table_1(FRICTION, with_friction, believed)]
    progress("table 1")
    of_log = partial(tracking_spectrum, shortest_period=LINE_PERIODS[0])
    spectra = {motor: {name: of_log(log) for name, log in pair.items()} for motor, pair in logs.items()}
    figures = {
        "malaize2009_fig2": accuracies.figure_velocity(),
        "malaize2009_fig3": accuracies.figure_spectrum(spectra),
        "malaize2009_fig4": accuracies.figure_errors(logs, MOTORS["ironcore"]),
        "malaize2009_fig4_ironless": accuracies.figure_errors(logs, MOTORS["ironless"]),
    }
    progress("figures 2 to 4")
    tables += [accuracies.table_2(), accuracies.smooth_friction()]
    progress("imperfections")
    causes = explained()
    tables += [accuracies.what_explains(causes), accuracies.held_out(causes)]
    tables += [accuracies.what_else(causes), accuracies.spread_over_draws(causes, found)]
    figures["malaize2009_held_out"] = accuracies.figure_held_out(causes)
    progress("causes")
    figures["malaize2009_ripple"] = accuracies.figure_ripple()
    progress("ripple")
    figures["malaize2009_robustness"] = accuracies.figure_robustness()
    progress("robustness")
    theorem, note = further_tables()
    progress("theorem 3")
    first = {name: accuracy(logs[name]["observer"], motor, cold=True) for name, motor in MOTORS.items()}
    cold = ", ".join(f"{name} {1e6 * error:.2f} um" for name, error in first.items())
    periods = {name: [f"{1e3 * period:.1f}" for period in pair["PID"].periods] for name, pair in spectra.items()}
    proposed = "; ".join(f"{name} {', '.join(each)} mm" for name, each in periods.items())
    notes = [
        f"First stroke of the observer, in which it knows nothing, with unmodelled lines (draw 0): {cold}.",
        f"Periods proposed by the spectrum of the PID's error, with unmodelled lines: {proposed}.",
        "lambda* reports the bound on the poles, which the paper does not state: it was fitted to lambda*.",
    ]
    return Reproduction("malaize2009", [*tables, *theorem], figures, [*notes, *note])
