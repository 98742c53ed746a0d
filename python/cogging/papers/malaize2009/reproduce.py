"""Malaize and Levine 2009: observer-based cancellation of cogging beside a PID on two motors (Table I).

Calibrated: the amplitudes on the PID row, the pole radius on lambda*. Predicted: the observer row. A second table says
what the first hides: what happens with ripple, thrust constant, encoder and periods that are not as believed.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import TYPE_CHECKING, Any

import numpy as np

from cogging.logs.log import Log
from cogging.mapping.error_spectrum import tracking_spectrum
from cogging.model.controller import ListedController
from cogging.papers.malaize2009.setup import (
    CONTROLLERS,
    MOTORS,
    SAMPLE_RATE,
    Calibrated,
    Motor,
    accuracies,
    accuracy,
    observer,
    pid,
    plant,
    reference,
    run,
    shipped,
    true_error,
)
from cogging.papers.result import Reproduction, Row, Table
from cogging.plot.canvas import drawn, new_figure

if TYPE_CHECKING:
    from matplotlib.figure import Figure

RIPPLE_PERIOD = 0.0073  # m, no fraction of a motor's periods: of the ripple that no controller knows


def controllers(motor: Motor, gains: Calibrated) -> dict[str, ListedController]:
    """PID and observer of Table I."""
    return {"PID": pid(), "observer": observer(motor, gains)}


def table_1(logs: Mapping[str, Mapping[str, Log]]) -> Table:
    """Table I: accuracy after the first stroke, and lambda*."""
    rows = []
    for motor in MOTORS.values():
        label = {"motor": motor.name}
        for name, printed in zip(CONTROLLERS, motor.accuracy, strict=True):
            status = "calibrated" if name == "PID" else "predicted"
            rows.append(Row(name, "accuracy", "m", printed, accuracy(logs[motor.name][name], motor), status, label))
        star = shipped(motor).lambda_star
        rows.append(Row("observer", "lambda_star", "m/s^2", motor.lambda_star, star, "calibrated", label))
    return Table("table1", "Table I: accuracy after the first stroke, and the certified lambda*", rows)


def imperfections(motor: Motor, gains: Calibrated) -> dict[str, dict[str, float]]:
    """Accuracies (m) of PID and observer where something is not as believed, by what it is."""
    amplitude = gains.amplitude
    rms = amplitude * float(np.sqrt(0.5 * np.sum(np.square(motor.shape))))
    both = controllers(motor, gains)

    def ripple(share: float) -> Any:
        return plant(motor, amplitude, ripples=[(RIPPLE_PERIOD, share * rms * np.sqrt(2.0))])

    def thrust(factor: float) -> dict[str, ListedController]:
        return {"PID": pid(factor), "observer": observer(motor, gains, thrust=factor)}

    exact = plant(motor, amplitude)
    cases: dict[str, tuple[Any, dict[str, ListedController]]] = {
        "as believed": (exact, both),
        "ripple of 4 % rms": (ripple(0.04), both),
        "ripple of 20 % rms": (ripple(0.20), both),
        "thrust + 0.5 %": (exact, thrust(1.005)),
        "thrust + 2 %": (exact, thrust(1.02)),
        "encoder 10 times coarser": (plant(motor, amplitude, resolution=10 * motor.resolution), both),
        "periods 2 % too long": (exact, {"PID": pid(), "observer": observer(motor, gains, stretch=1.02)}),
    }
    return {name: accuracies(machine, pair, motor) for name, (machine, pair) in cases.items()}


def table_2() -> Table:
    """What the first table hides; not in the paper. Where the observer is worse than the PID the label says so."""
    rows = []
    for motor in MOTORS.values():
        for case, found in imperfections(motor, shipped(motor)).items():
            worse = found["observer"] > found["PID"]
            for name in CONTROLLERS:
                label = {"motor": motor.name, "case": case}
                if name == "observer" and worse:
                    label["note"] = "worse than the PID"
                rows.append(Row(name, "accuracy", "m", None, found[name], "exploratory", label))
    return Table("imperfections", "What Table I hides: accuracy where something is not as believed", rows)


def ripple_ratio(motor: Motor, periods: Any, share: float = 0.04) -> Any:
    """Observer's over PID's rms error of one unmodelled ripple by its period (m), without cogging or friction."""
    gains = shipped(motor)
    size = share * gains.amplitude
    ratios = []
    for period in periods:
        machine = plant(motor, 0.0, ripples=[(float(period), size)], resolution=0.0, friction=0.0)
        rms = [
            float(np.sqrt(np.mean(true_error(run(machine, controller, motor))[_first_stroke(motor) :] ** 2)))
            for controller in controllers(motor, gains).values()
        ]
        ratios.append(rms[1] / rms[0])
    return np.array(ratios)


def _first_stroke(motor: Motor) -> int:
    return int(0.5 * reference(motor).period * SAMPLE_RATE)


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


def _pair(title: str) -> tuple[Figure, Any]:
    figure = new_figure((8.0, 5.5))
    figure.suptitle(title)
    return figure, zip(figure.subplots(2, 1), MOTORS.values(), strict=True)


@drawn
def figure_velocity() -> Figure:
    """Fig. 2: the reference velocities."""
    figure, panels = _pair("Fig. 2: reference velocity (top speeds, strokes and rests assumed)")
    for axes, motor in panels:
        motion = reference(motor)
        time = np.linspace(0.0, motion.period, 2001)
        axes.plot(time, 1e3 * motion.sample(time)[1])
        axes.set(ylabel=f"{motor.name} (mm/s)", xlabel="time (s)")
    return figure


@drawn
def figure_spectrum(logs: Mapping[str, Mapping[str, Log]]) -> Figure:
    """Fig. 3: the tracking errors against spatial period."""
    figure, panels = _pair("Fig. 3: spectrum of the tracking error")
    for axes, motor in panels:
        for name in CONTROLLERS:
            found = tracking_spectrum(logs[motor.name][name])
            axes.semilogy(1e3 / found.frequency, 1e6 * found.amplitude, label=name, linewidth=0.8)
        axes.set(ylabel=f"{motor.name} (µm)", xlabel="spatial period (mm)", xlim=(4, 60))
        axes.legend()
    return figure


@drawn
def figure_errors(logs: Mapping[str, Mapping[str, Log]]) -> Figure:
    """Fig. 4: the tracking errors."""
    figure, panels = _pair("Fig. 4: tracking error")
    for axes, motor in panels:
        for name in CONTROLLERS:
            log = logs[motor.name][name]
            axes.plot(log.time, 1e6 * true_error(log), label=name, linewidth=0.6)
        axes.set(ylabel=f"{motor.name} (µm)", xlabel="time (s)")
        axes.legend()
    return figure


@drawn
def figure_ripple() -> Figure:
    """The ratio observer / PID of the error that one unmodelled ripple makes, against its period."""
    figure, panels = _pair("Unmodelled ripple: observer's error over the PID's")
    for axes, motor in panels:
        periods = np.geomspace(3e-3, 0.06, 40)
        axes.semilogx(1e3 * periods, ripple_ratio(motor, periods))
        axes.axhline(1.0, color="black", linestyle=":")
        axes.set(ylabel=motor.name, xlabel="period of the ripple (mm)")
    return figure
