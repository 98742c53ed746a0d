"""Figs. 2 to 4, and what an unmodelled ripple does (Malaize and Levine 2009)."""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING, Any

import numpy as np

from cogging.logs.log import Log
from cogging.mapping.error_spectrum import tracking_spectrum
from cogging.papers.malaize2009.setup import (
    CONTROLLERS,
    MOTORS,
    SAMPLE_RATE,
    Motor,
    controllers,
    plant,
    reference,
    run,
    shipped,
    true_error,
)
from cogging.plot.canvas import drawn, new_figure

if TYPE_CHECKING:
    from matplotlib.figure import Figure


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
