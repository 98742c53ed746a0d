"""Malaize and Levine 2009: observer-based cancellation of cogging beside a PID on two motors (Table I).

Calibrated: the amplitudes on the PID row, the pole radius on lambda*. Predicted: the observer row. A second table says
what the first hides: what happens with ripple, thrust constant, encoder and periods that are not as believed.
"""

from __future__ import annotations

from collections.abc import Callable

from cogging.mapping.error_spectrum import tracking_spectrum
from cogging.papers.malaize2009.figures import (
    figure_errors,
    figure_ripple,
    figure_spectrum,
    figure_velocity,
)
from cogging.papers.malaize2009.imperfections import table_2
from cogging.papers.malaize2009.setup import (
    MOTORS,
    accuracy,
    controllers,
    plant,
    run,
    shipped,
)
from cogging.papers.malaize2009.tables import table_1
from cogging.papers.result import Reproduction


def reproduce(progress: Callable[[str], None] = lambda step: None) -> Reproduction:
    """Table I, Figs. 2, 3, 4, the table of imperfections and its figure. `progress` is told each of STEPS."""
    logs = {
        motor.name: {
            name: run(plant(motor, shipped(motor).amplitude), controller, motor)
            for name, controller in controllers(motor, shipped(motor)).items()
        }
        for motor in MOTORS.values()
    }
    table = table_1(logs)
    progress("table 1")
    figures = {"malaize2009_fig2": figure_velocity(), "malaize2009_fig3": figure_spectrum(logs)}
    figures["malaize2009_fig4"] = figure_errors(logs)
    progress("figures 2 to 4")
    hidden = table_2()
    progress("imperfections")
    figures["malaize2009_ripple"] = figure_ripple()
    progress("ripple")
    cold = ", ".join(
        f"{motor.name} {1e6 * accuracy(logs[motor.name]['observer'], motor, cold=True):.2f} um"
        for motor in MOTORS.values()
    )
    found = {motor.name: tracking_spectrum(logs[motor.name]["PID"]).periods for motor in MOTORS.values()}
    proposed = "; ".join(
        f"{name} {', '.join(f'{1e3 * period:.1f}' for period in periods)} mm" for name, periods in found.items()
    )
    notes = [
        f"First, cold stroke of the observer: {cold}.",
        f"Periods proposed by the spectrum of the PID's error: {proposed}.",
        "lambda* reports the bound on the poles, which the paper does not state: it was fitted to lambda*.",
    ]
    return Reproduction("malaize2009", [table, hidden], figures, notes)


#: What reproduce() tells its progress.
STEPS = ("table 1", "figures 2 to 4", "imperfections", "ripple")
