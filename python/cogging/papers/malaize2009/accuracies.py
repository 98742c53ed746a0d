"""Accuracies of Malaize and Levine 2009: Table I, Figs. 2 to 4, and what the controllers may not have known."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace
from typing import TYPE_CHECKING

import numpy as np

from cogging.arrays import FloatArray
from cogging.logs.log import Log
from cogging.mapping.error_spectrum import TrackingSpectrum, tracking_spectrum
from cogging.papers.compared import Trace, compared, set_ticks
from cogging.papers.malaize2009 import causes
from cogging.papers.malaize2009.causes import LINES, Cause, Conditions, Explanation, drawn_accuracies, other
from cogging.papers.malaize2009.linear_motors import (
    CONTROLLERS,
    MOTORS,
    Calibrated,
    Motor,
    controllers,
    reference,
    run,
    shipped,
    true_error,
)
from cogging.papers.result import Row, Table, explored
from cogging.plot.canvas import drawn, legend, new_figure
from cogging.plot.series import GREY, LIMIT, look, marker

if TYPE_CHECKING:
    from matplotlib.figure import Figure

AMPLITUDES_AND_RADII = tuple(f"{what} of {motor}" for motor in MOTORS for what in ("amplitude", "pole radius"))

#: Accuracies (m) by motor and controller, (draws,) each.
Accuracies = Mapping[str, Mapping[str, FloatArray]]
#: Logs by motor and controller.
Logs = Mapping[str, Mapping[str, Log]]
CRUISE = 0.99  # of the top speed: constant speed from there on
THINNED = 20  # lines are fitted to one sample of so many
RATIOS = (0.1, 0.2, 0.5, 1, 2, 5, 10)


def logs_under(motor: Motor, gains: Calibrated, conditions: Conditions, *, strokes: int = 0) -> dict[str, Log]:
    """Run PID and observer with a cogging of gains.amplitude for the first strokes; 0: all."""
    plant = causes.machine(motor, gains.amplitude, conditions)
    laws = controllers(motor, gains, 1.0 + conditions.thrust)
    return {name: run(plant, law, motor, strokes=strokes) for name, law in laws.items()}


def logs_of_table_1() -> dict[str, dict[str, Log]]:
    """Run Table I with the first draw of the lines and phases; logs by motor and controller."""
    found = {}
    for motor in MOTORS.values():
        conditions, gains = causes.shipped_table_1(motor)
        found[motor.name] = logs_under(motor, gains, conditions)
    return found


def accuracies_of_table_1(cause: Cause = LINES) -> dict[str, dict[str, FloatArray]]:
    """Return the accuracies of Table I under a cause in each draw."""
    found = {}
    for motor in MOTORS.values():
        conditions, gains = causes.shipped_table_1(motor, cause)
        found[motor.name] = {
            name: drawn_accuracies(motor, gains, conditions, name, cause.draws) for name in CONTROLLERS
        }
    return found


def accuracies_as_believed() -> dict[str, dict[str, FloatArray]]:
    """Return the same where the controllers know all of their machine, with the assumed phases."""
    return {
        motor.name: {name: drawn_accuracies(motor, shipped(motor), Conditions(), name, 1) for name in CONTROLLERS}
        for motor in MOTORS.values()
    }


def table_1(cause: Cause, found: Accuracies, believed: Accuracies) -> Table:
    """Return Table I under a cause of one size: accuracy after the first stroke, mean over the draws, and lambda*.

    found: accuracies_of_table_1, fitted; believed: accuracies_as_believed, where the observer row was predicted.
    """
    labels = {
        (motor, name): {f"of {cause.draws} draws": f"{1e6 * each.min():.3g} to {1e6 * each.max():.3g} um"}
        for motor, pair in found.items()
        for name, each in pair.items()
        if cause.draws > 1
    }

    def rows_of(accuracies: Accuracies, observer: str) -> list[Row]:
        rows = []
        for motor in MOTORS.values():
            label, star = {"motor": motor.name}, shipped(motor).lambda_star
            for name, printed, status in zip(CONTROLLERS, motor.accuracy, ("calibrated", observer), strict=True):
                accuracy = float(accuracies[motor.name][name].mean())
                more = label | labels.get((motor.name, name), {})
                rows.append(Row(name, "accuracy", "m", printed, accuracy, status, more))
            rows.append(Row("observer", "lambda_star", "m/s^2", motor.lambda_star, star, "calibrated", label))
        return rows

    words = f" (mean of {cause.draws} draws)" if labels else ""
    size = f"with {cause.name} of one size{words}"
    title = f"Table I: accuracy after the first stroke {size}, and the certified lambda*"
    before = Table("", "", rows_of(believed, "predicted"), free=AMPLITUDES_AND_RADII)
    free = (*AMPLITUDES_AND_RADII, f"size of {cause.name}")
    id_ = "table1" if cause is LINES else f"table1_{cause.field}"
    return Table(id_, title, rows_of(found, "calibrated"), free=free, before=before)


def what_explains(found: Sequence[Explanation]) -> Table:
    """Tabulate the size of each cause that alone gives the observer the printed accuracy; not in the paper."""
    rows = [
        explored("observer", "size", each.cause.unit, each.size, **each.labels, verdict=each.cause.verdict)
        for each in found
    ]
    return Table("what_explains", "What alone would give the observer the accuracy of Table I, by its size", rows)


def held_out(found: Sequence[Explanation]) -> Table:
    """Tabulate the observer's accuracy where each cause is fitted on one motor and applied to the other."""
    rows = []
    for each in found:
        pairs = ((each.motor, each.accuracy, "calibrated"), (other(each.motor), each.elsewhere, "predicted"))
        for motor, accuracy, status in pairs:
            labels = {"motor": motor.name, "cause": each.cause.name, "fitted on": each.motor.name}
            rows.append(Row("observer", "accuracy", "m", motor.accuracy[1], float(accuracy.mean()), status, labels))
    free = [f"{each.cause.name} of {each.motor.name}" for each in found]
    return Table("held_out", "Fitted on one motor, given to the other: the observer's accuracy", rows, free=free)


def what_else(found: Sequence[Explanation]) -> Table:
    """Tabulate further consequences of each cause, by which the paper's words and Fig. 3 distinguish them.

    at_rest: largest error while the reference rests; ramps: on ramps over at constant speed; lines_left: largest
    amplitude of its own periods over the PID's; beside_lines, of the PID: rms of the error without them over all.
    """
    rows = []
    for each in found:
        motor, conditions = each.motor, each.cause.of(each.size)
        gains = replace(shipped(motor), amplitude=each.amplitude)
        logs = logs_under(motor, gains, conditions, strokes=causes.DRAWN_STROKES)
        log = logs["observer"]
        error, speed = np.abs(true_error(log)), _speed(log)
        later, fast = log.time >= 0.5 * reference(motor).period, speed >= CRUISE * motor.velocity
        periods = [period / (1.0 + conditions.period_error) for period in motor.periods]
        (pid_lines, beside), (own_lines, _) = (lines_at_speed(logs[name], motor, periods) for name in CONTROLLERS)
        ramps = error[later & ~fast & (speed > 0.0)].max()
        rows += [
            explored("observer", "at_rest", "m", error[later & (speed == 0.0)].max(), **each.labels),
            explored("observer", "ramps", "1", ramps / error[later & fast].max(), **each.labels),
            explored("observer", "lines_left", "1", (own_lines / pid_lines).max(), **each.labels),
            explored("PID", "beside_lines", "1", beside, **each.labels),
        ]
    return Table("what_else", "What each cause does beside, at that size", rows)


def _speed(log: Log) -> FloatArray:
    assert log.reference_velocity is not None
    return np.abs(log.reference_velocity)


def lines_at_speed(log: Log, motor: Motor, periods: Sequence[float]) -> tuple[FloatArray, float]:
    """Return the rms amplitude of lines of some periods (m) in the error at constant speed, and its other share."""
    half = 0.5 * reference(motor).period
    powers, left, all_ = [], 0.0, 0.0
    for stroke in range(1, round(log.time[-1] / half)):
        at_speed = (np.floor(log.time / half) == stroke) & (_speed(log) >= CRUISE * motor.velocity)
        rows = np.flatnonzero(at_speed)[::THINNED]
        angle = 2.0 * np.pi * np.outer(log.position[rows], 1.0 / np.array(periods))
        basis = np.column_stack([np.ones(rows.size), np.sin(angle), np.cos(angle)])
        error = true_error(log)[rows]
        parts = np.linalg.lstsq(basis, error, rcond=None)[0]
        powers.append(parts[1 : 1 + len(periods)] ** 2 + parts[1 + len(periods) :] ** 2)
        left += float(np.sum((error - basis @ parts) ** 2))
        all_ += float(np.sum((error - error.mean()) ** 2))
    return np.sqrt(np.mean(powers, axis=0)), float(np.sqrt(left / all_))


def spread_over_draws(found: Sequence[Explanation], table_1: Accuracies) -> Table:
    """Tabulate how much a draw matters: of lines and phases in Table I, and of each cause at its size."""
    cases = [(name, motor, "Table I", table_1[motor.name][name]) for motor in MOTORS.values() for name in CONTROLLERS]
    cases += [("observer", each.motor, each.cause.name, each.accuracy) for each in found if each.cause.draws > 1]
    rows = []
    for name, motor, under, accuracies in cases:
        values = (accuracies.mean(), accuracies.std(ddof=1), accuracies.min(), accuracies.max())
        for index, value in zip(("mean", "sd", "least", "largest"), values, strict=True):
            rows.append(explored(name, index, "m", value, motor=motor.name, under=under))
    return Table("draws", "How much a draw counts: accuracy over the draws", rows)


def spectra_of(logs: Logs) -> dict[str, dict[str, TrackingSpectrum]]:
    """Return spectra of the tracking errors from 4 mm on, by motor and controller."""
    return {
        motor: {name: tracking_spectrum(log, shortest_period=causes.LINE_PERIODS[0]) for name, log in pair.items()}
        for motor, pair in logs.items()
    }


@drawn
def figure_velocity() -> Figure:
    """Draw Fig. 2: the reference velocities."""
    figure = new_figure((8.0, 5.5))
    figure.suptitle("Fig. 2: reference velocity (top speeds, strokes and rests assumed)")
    for axes, motor in zip(figure.subplots(2, 1), MOTORS.values(), strict=True):
        motion = reference(motor)
        time = np.linspace(0.0, motion.period, 2001)
        axes.plot(time, 1e3 * motion.sample(time)[1], **look(0))
        axes.set(ylabel=f"{motor.name} (mm/s)", xlabel="time (s)", ylim=(-450, 450))
        axes.margins(x=0.01)
    return figure


@drawn
def figure_spectrum(spectra: Mapping[str, Mapping[str, TrackingSpectrum]]) -> Figure:
    """Draw Fig. 3: the tracking errors against spatial period; triangles: the periods that the observer cancels."""
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
        set_ticks(axes.xaxis, [4, 5, 6, 8, 10, 12, 16, 21, 24, 30, 42, 60])
        set_ticks(axes.yaxis, [1e-4, 1e-3, 1e-2, 0.1, 1, 10])
        legend(axes)
    panels[-1].set_xlabel("spatial period (mm); triangles: those that the observer cancels")
    return figure


def figure_errors(logs: Logs, motor: Motor) -> Figure:
    """Draw Fig. 4: the tracking errors of a motor over the whole run, and the third stroke with its rest."""
    traces = [
        Trace(name, log.time, true_error(log), printed)
        for (name, log), printed in zip(logs[motor.name].items(), motor.accuracy, strict=True)
    ]
    period = reference(motor).period
    return compared(f"Fig. 4, {motor.name}: tracking error", traces, zoom=(period, 1.5 * period))


@drawn
def figure_held_out(found: Sequence[Explanation]) -> Figure:
    """Draw the observer's accuracy over the printed one on the motor that took no part, by cause."""
    figure = new_figure((8.0, 4.5))
    figure.suptitle("One value for both motors? Each cause fitted on one motor, given to the other")
    axes = figure.subplots()
    names = [cause.name for cause in causes.CAUSES]
    for place, motor in enumerate(MOTORS.values()):
        chosen = [each for each in found if each.motor is motor]
        ratios = [each.elsewhere.mean() / other(motor).accuracy[1] for each in chosen]
        rows = [names.index(each.cause.name) for each in chosen]
        label = f"fitted on {motor.name}, {other(motor).name} predicted"
        axes.semilogx(ratios, rows, marker(place), color=look(place)["color"], markersize=8, label=label)
    axes.axvspan(1 / 1.15, 1.15, color=GREY, alpha=0.35, linewidth=0.0)
    axes.axvline(1.0, color=GREY, linewidth=0.8)
    axes.set_yticks(range(len(names)), names)
    axes.invert_yaxis()
    set_ticks(axes.xaxis, RATIOS)
    axes.set(xlim=(RATIOS[0], RATIOS[-1]), xlabel="observer's accuracy over the printed one (grey: within 15 %)")
    legend(axes)
    return figure
