"""Figs. 2 to 4, and what is not as believed does to the errors (Malaize and Levine 2009)."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

from cogging.logs.log import Log
from cogging.mapping.error_spectrum import TrackingSpectrum
from cogging.papers.compared import Trace, compared
from cogging.papers.malaize2009.robustness import sweeps
from cogging.papers.malaize2009.setup import (
    CONTROLLERS,
    MOTORS,
    Motor,
    controllers,
    plant,
    reference,
    shipped,
    true_error,
)
from cogging.plot.canvas import drawn, legend, new_figure
from cogging.plot.series import GREY, LIMIT, look, marker
from cogging.simulation.batch import closed_loop_batch

if TYPE_CHECKING:
    from matplotlib.figure import Figure


def ripple_ratio(motor: Motor, periods: Any, share: float = 0.04) -> Any:
    """Observer's over PID's rms error of one unmodelled ripple by its period (m), without cogging or friction."""
    gains = shipped(motor)
    size = share * gains.amplitude
    machines = [plant(motor, 0.0, ripples=[(float(period), size)], resolution=0.0, friction=0.0) for period in periods]
    rms = [
        closed_loop_batch(
            machines,
            [controller] * len(machines),
            reference(motor),
            start=0.5 * reference(motor).period,
            reductions=["true_error_rms"],
        ).indexes["true_error_rms"]
        for controller in controllers(motor, gains).values()
    ]
    return rms[1] / rms[0]


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
        axes.plot(time, 1e3 * motion.sample(time)[1], **look(0))
        axes.set(ylabel=f"{motor.name} (mm/s)", xlabel="time (s)", ylim=(-450, 450))
        axes.margins(x=0.01)
    return figure


@drawn
def figure_spectrum(spectra: Mapping[str, Mapping[str, TrackingSpectrum]]) -> Figure:
    """Fig. 3: the tracking errors against spatial period, by motor and controller; triangles: the periods cancelled."""
    figure = new_figure((8.0, 6.0))
    figure.suptitle("Fig. 3: spectrum of the tracking error, with unmodelled lines")
    panels = figure.subplots(len(MOTORS), 1, sharex=True, sharey=True)
    for axes, motor in zip(panels, MOTORS.values(), strict=True):
        for place, name in enumerate(CONTROLLERS):
            found = spectra[motor.name][name]
            axes.loglog(1e3 / found.frequency, 1e6 * found.amplitude, label=name, linewidth=1.1, **look(place))
        marks = {"marker": "v", "linestyle": "", "color": LIMIT, "transform": axes.get_xaxis_transform()}
        axes.plot(1e3 * np.array(motor.periods), np.full(len(motor.periods), 0.97), **marks)
        axes.set(ylabel=f"{motor.name}: amplitude (µm)", xlim=(4, 60), ylim=(1e-4, 10))
        _ticks(axes.xaxis, [4, 5, 6, 8, 10, 12, 16, 21, 24, 30, 42, 60])
        _ticks(axes.yaxis, [1e-4, 1e-3, 1e-2, 0.1, 1, 10])
        legend(axes)
    panels[-1].set_xlabel("spatial period (mm); triangles: those that the observer cancels")
    return figure


def figure_errors(logs: Mapping[str, Mapping[str, Log]], motor: Motor) -> Figure:
    """Fig. 4: the tracking errors of a motor; beside the whole run, the third stroke and its rest."""
    traces = [
        Trace(name, logs[motor.name][name].time, true_error(logs[motor.name][name]), printed)
        for name, printed in zip(CONTROLLERS, motor.accuracy, strict=True)
    ]
    period = reference(motor).period
    return compared(f"Fig. 4, {motor.name}: tracking error", traces, zoom=(period, 1.5 * period))


@drawn
def figure_ripple() -> Figure:
    """The ratio observer / PID of the error that one unmodelled ripple makes, against its period."""
    figure, panels = _pair("Unmodelled ripple: the observer's rms error over the PID's")
    for axes, motor in panels:
        periods = np.geomspace(3e-3, 0.06, 60)
        axes.semilogx(1e3 * periods, ripple_ratio(motor, periods), **look(0))
        axes.axhline(1.0, **look(2) | {"linestyle": ":"})
        for period in motor.periods:
            axes.axvline(1e3 * period, color=GREY, linewidth=0.8)
        axes.set(ylabel=f"{motor.name}: ratio", xlabel="period of the ripple (mm); upright: the observer's own", ylim=0)
        _ticks(axes.xaxis, [3, 4, 5, 7, 10, 15, 20, 30, 40, 60])
    return figure


@drawn
def figure_robustness() -> Figure:
    """The accuracies of PID and observer against what they do not know, each size alone."""
    figure = new_figure((8.0, 10.0))
    figure.suptitle("Accuracy where something is not as believed; dotted: printed in Table I")
    columns = [sweeps(motor, shipped(motor)) for motor in MOTORS.values()]
    panels = figure.subplots(len(columns[0]), len(columns), sharey="col")
    for motor, found, column in zip(MOTORS.values(), columns, panels.T, strict=True):
        for axes, sweep in zip(column, found, strict=True):
            for place, (name, printed) in enumerate(zip(CONTROLLERS, motor.accuracy, strict=True)):
                axes.loglog(sweep.sizes, 1e6 * sweep.error[name], label=name, marker=marker(place), **look(place))
                axes.axhline(1e6 * printed, **look(place) | {"linestyle": ":"}, linewidth=0.9)
            axes.set(xlabel=sweep.name, ylabel="accuracy (µm)")
            _ticks(axes.xaxis, sweep.sizes.tolist())
            axes.yaxis.set_major_formatter(lambda value, _: f"{value:g}")
        column[0].set_title(motor.name)
        legend(column[0])
    return figure


def _ticks(axis: Any, places: Sequence[float]) -> None:
    axis.set_ticks(places, [f"{place:g}" for place in places])
    axis.set_ticks([], minor=True)
