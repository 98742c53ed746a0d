"""Accuracies of Malaize and Levine 2009: Table I, Figs. 2 to 4, and what the controllers may not have known.

Also accuracies where something is not as the controllers believe, which are not in the paper.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace

import numpy as np
from matplotlib.figure import Figure

from cogging import effects
from cogging._core import Plant
from cogging.arrays import FloatArray
from cogging.logs.log import Log
from cogging.mapping.error_spectrum import TrackingSpectrum
from cogging.model.controller import ListedController
from cogging.papers.compared import Trace, compared, set_ticks
from cogging.papers.malaize2009 import causes, linear_motors
from cogging.papers.malaize2009.causes import LINES, Cause, Conditions, Explanation, other
from cogging.papers.malaize2009.linear_motors import CONTROLLERS, MOTORS, Motor, controllers, observer, plant, shipped
from cogging.papers.result import Row, Table, explored, known
from cogging.plot.canvas import drawn, legend, titled_panels
from cogging.plot.series import GREY, LIMIT, look, marker

AMPLITUDES_AND_RADII = tuple(f"{what} of {motor}" for motor in MOTORS for what in ("amplitude", "pole radius"))

#: Accuracies (m) by motor and controller, (draws,) each.
Accuracies = Mapping[str, Mapping[str, FloatArray]]
CRUISE = 0.99  # of the top speed: constant speed from there on
THINNED = 20  # lines are fitted to one sample of so many
RATIOS = (0.1, 0.2, 0.5, 1, 2, 5, 10)


def logs_under(
    motor: Motor, gains: linear_motors.Calibrated, conditions: Conditions, *, strokes: int = 0
) -> dict[str, Log]:
    """Run PID and observer with a cogging of gains.amplitude for the first strokes; 0: all."""
    machine = causes.machine(motor, gains.amplitude, conditions)
    laws = controllers(motor, gains, 1.0 + conditions.thrust)
    return {name: linear_motors.run(machine, law, motor, strokes=strokes) for name, law in laws.items()}


def logs_of_table_1() -> dict[str, dict[str, Log]]:
    """Run Table I with the first draw of the lines and phases; logs by motor and controller."""
    return {name: logs_under(motor, *causes.shipped_table_1(motor)) for name, motor in MOTORS.items()}


def accuracies_of_table_1(cause: Cause = LINES) -> dict[str, dict[str, FloatArray]]:
    """Return the accuracies of Table I under a cause in each draw."""
    return {
        name: causes.pair(motor, *causes.shipped_table_1(motor, cause), cause.draws) for name, motor in MOTORS.items()
    }


def accuracies_as_believed() -> dict[str, dict[str, FloatArray]]:
    """Return the same where the controllers know all of their machine, with the assumed phases."""
    return {name: causes.pair(motor, shipped(motor), Conditions(), 1) for name, motor in MOTORS.items()}


def table_1(cause: Cause, found: Accuracies, believed: Accuracies) -> Table:
    """Return Table I under a cause of one size: accuracy after the first stroke, mean over the draws, and lambda*.

    found: accuracies_of_table_1, fitted; believed: accuracies_as_believed, where the observer row was predicted.
    """

    def rows_of(accuracies: Accuracies, observer: str) -> list[Row]:
        rows = []
        for motor in MOTORS.values():
            label, star = {"motor": motor.name}, shipped(motor).lambda_star
            for name, printed, status in zip(CONTROLLERS, motor.accuracy, ("calibrated", observer), strict=True):
                accuracy, each, more = float(accuracies[motor.name][name].mean()), found[motor.name][name], {}
                if cause.draws > 1:
                    more = {f"of {cause.draws} draws": f"{1e6 * each.min():.3g} to {1e6 * each.max():.3g} um"}
                rows.append(Row(name, "accuracy", "m", printed, accuracy, status, label | more))
            rows.append(Row("observer", "lambda_star", "m/s^2", motor.lambda_star, star, "calibrated", label))
        return rows

    size = f"with {cause.name} of one size" + f" (mean of {cause.draws} draws)" * (cause.draws > 1)
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
        error, speed = np.abs(linear_motors.true_error(log)), np.abs(known(log.reference_velocity))
        later, fast = log.time >= 0.5 * linear_motors.reference(motor).period, speed >= CRUISE * motor.velocity
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


def lines_at_speed(log: Log, motor: Motor, periods: Sequence[float]) -> tuple[FloatArray, float]:
    """Return the rms amplitude of lines of some periods (m) in the error at constant speed, and its other share."""
    half = 0.5 * linear_motors.reference(motor).period
    powers, left, all_ = [], 0.0, 0.0
    fast = np.abs(known(log.reference_velocity)) >= CRUISE * motor.velocity
    for stroke in range(1, round(log.time[-1] / half)):
        rows = np.flatnonzero((np.floor(log.time / half) == stroke) & fast)[::THINNED]
        angle = 2.0 * np.pi * np.outer(log.position[rows], 1.0 / np.array(periods))
        basis = np.column_stack([np.ones(rows.size), np.sin(angle), np.cos(angle)])
        error = linear_motors.true_error(log)[rows]
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


@drawn
def figure_velocity() -> Figure:
    """Draw Fig. 2: the reference velocities."""
    figure, panels = titled_panels("Fig. 2: reference velocity (top speeds, strokes and rests assumed)", (8.0, 5.5), 2)
    for axes, motor in zip(panels, MOTORS.values(), strict=True):
        motion = linear_motors.reference(motor)
        time = np.linspace(0.0, motion.period, 2001)
        axes.plot(time, 1e3 * motion.sample(time)[1], **look(0))
        axes.set(ylabel=f"{motor.name} (mm/s)", xlabel="time (s)", ylim=(-450, 450))
        axes.margins(x=0.01)
    return figure


@drawn
def figure_spectrum(spectra: Mapping[str, Mapping[str, TrackingSpectrum]]) -> Figure:
    """Draw Fig. 3: the tracking errors against spatial period; triangles: the periods that the observer cancels."""
    title = "Fig. 3: spectrum of the tracking error, with unmodelled lines"
    figure, panels = titled_panels(title, (8.0, 6.0), len(MOTORS), sharex=True, sharey=True)
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


def figure_errors(logs: Mapping[str, Mapping[str, Log]], motor: Motor) -> Figure:
    """Draw Fig. 4: the tracking errors of a motor over the whole run, and the third stroke with its rest."""
    pairs = zip(logs[motor.name].items(), motor.accuracy, strict=True)
    traces = [Trace(name, log.time, linear_motors.true_error(log), printed) for (name, log), printed in pairs]
    period = linear_motors.reference(motor).period
    return compared(f"Fig. 4, {motor.name}: tracking error", traces, zoom=(period, 1.5 * period))


@drawn
def figure_held_out(found: Sequence[Explanation]) -> Figure:
    """Draw the observer's accuracy over the printed one on the motor that took no part, by cause."""
    title = "One value for both motors? Each cause fitted on one motor, given to the other"
    figure, axes = titled_panels(title, (8.0, 4.5))
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


# Where something is not as believed -----------------------------------------------------------------------------------

RIPPLE_PERIOD = 0.0073  # m, no fraction of a motor's periods: of the ripple that no controller knows
#: What the figures of imperfections are drawn of: periods of a ripple (m), and sizes in the units of the panels.
DRAWN_PERIODS = np.geomspace(3e-3, 0.06, 60)
DRAWN_SIZES: dict[str, list[float]] = {"ripple": [0.5, 1, 2, 5, 10, 20, 50], "encoder": [1, 3, 10, 30, 100, 300, 1000]}
DRAWN_SIZES |= {"friction": [0.002, 0.01, 0.05, 0.2, 1, 5, 20], "thrust": [0.1, 0.2, 0.5, 1.0, 2.0, 5.0]}
FRICTION_WIDTHS = (1e-5, 5e-5, 2e-4, 1e-3, 5e-3)  # m/s, assumed
STRIBECK_EXCESS, STRIBECK_VELOCITY = 0.5, 0.01  # of the dry friction, and m/s; assumed


def rippled(motor: Motor, share: float) -> Plant:
    """Return the machine with a ripple that no controller knows; share: its rms over the cogging's."""
    amplitude = shipped(motor).amplitude
    size = share * linear_motors.cogging_rms(motor, amplitude) * np.sqrt(2.0)
    return plant(motor, amplitude, [effects.CoggingHarmonic(period=RIPPLE_PERIOD, sine=size)])


def with_friction(motor: Motor, width: float, excess: float = 0.0) -> Plant:
    """Return the machine with friction smooth over a width (m/s; 0: it sticks), and relative Stribeck friction."""
    law = effects.StribeckFriction(static_excess=excess * motor.friction, velocity=STRIBECK_VELOCITY)
    return plant(motor, shipped(motor).amplitude, [law] * (excess > 0.0), width=width)


def largest_errors(
    motor: Motor, cases: Sequence[tuple[Plant, Mapping[str, ListedController]]]
) -> dict[str, FloatArray]:
    """Return the accuracy (m) of each machine under its own PID and observer, (n,) each."""
    plants = [machine for machine, _ in cases]
    return {name: linear_motors.batch_errors(plants, [laws[name] for _, laws in cases], motor) for name in CONTROLLERS}


def table_2() -> Table:
    """Tabulate accuracies where something is not as believed; a note marks where the observer is worse than the PID."""
    rows = []
    for motor in MOTORS.values():
        gains = shipped(motor)
        amplitude, laws = gains.amplitude, controllers(motor, gains)
        exact = plant(motor, amplitude)
        machines = {"as believed": exact}
        machines |= {f"ripple of {100 * share:.0f} % rms": rippled(motor, share) for share in (0.04, 0.20)}
        for step in (motor.resolution, 10 * motor.resolution):
            alone = replace(motor, friction=0.0, resolution=step)
            machines[f"quantiser of {1e9 * step:g} nm alone"] = plant(alone, amplitude)
        machines["encoder 10 times coarser"] = plant(replace(motor, resolution=10 * motor.resolution), amplitude)
        machines |= {f"friction {1e3 * width:g} mm/s wide": with_friction(motor, width) for width in FRICTION_WIDTHS}
        machines["Stribeck friction that sticks"] = with_friction(motor, 0.0, STRIBECK_EXCESS)
        machines["Stribeck friction 0.05 mm/s wide"] = with_friction(motor, 5e-5, STRIBECK_EXCESS)
        cases = {name: (machine, laws) for name, machine in machines.items()}
        for share in (0.005, 0.02):
            cases[f"thrust + {100 * share:g} %"] = (exact, controllers(motor, gains, 1.0 + share))
        stretched = observer(motor, gains, stretch=1.02)
        cases["periods 2 % too long"] = (exact, {**laws, "observer": stretched})
        errors = largest_errors(motor, list(cases.values()))
        for case, *pair in zip(cases, *errors.values(), strict=True):
            for name, error in zip(CONTROLLERS, pair, strict=True):
                note = {"note": "worse than the PID"} if error > pair[0] else {}
                rows.append(explored(name, "accuracy", "m", error, motor=motor.name, case=case, **note))
    return Table("imperfections", "What Table I hides: accuracy where something is not as believed", rows)


def smooth_friction() -> Table:
    """Tabulate the observer's largest error (m) in each stroke and the rest after it, by the width of the friction."""
    rows = []
    for motor in MOTORS.values():
        half = 0.5 * linear_motors.reference(motor).period
        for width in (0.0, 5e-5, 1e-3):
            log = linear_motors.run(with_friction(motor, width), observer(motor, shipped(motor)), motor)
            stroke, error = np.floor(log.time / half + 1e-9), np.abs(linear_motors.true_error(log))
            for name, number in (("1st", 0), ("2nd", 1), ("3rd", 2), ("last", 2 * linear_motors.REPEATS - 1)):
                largest, label = error[stroke == number].max(), f"{1e3 * width:g} mm/s"
                rows.append(explored("observer", f"{name} stroke", "m", largest, motor=motor.name, width=label))
    title = "Smooth dry friction, stroke by stroke: the largest |x - x*| of a stroke and the rest behind it"
    return Table("smooth_friction", title, rows)


@drawn
def figure_ripple() -> Figure:
    """Draw the observer's over the PID's rms error of one unknown ripple, by its period, without any friction."""
    figure, panels = titled_panels("Unmodelled ripple: the observer's rms error over the PID's", (8.0, 5.5), 2)
    for axes, motor in zip(panels, MOTORS.values(), strict=True):
        gains, size = shipped(motor), 0.04 * shipped(motor).amplitude
        ripples = [effects.CoggingHarmonic(period=period, sine=size) for period in DRAWN_PERIODS.tolist()]
        machines = [plant(replace(motor, resolution=0.0, friction=0.0), 0.0, [ripple]) for ripple in ripples]
        pid, own = (
            linear_motors.batch_errors(machines, [law] * len(machines), motor, reduction="true_error_rms")
            for law in controllers(motor, gains).values()
        )
        axes.semilogx(1e3 * DRAWN_PERIODS, own / pid, **look(0))
        axes.axhline(1.0, **look(2) | {"linestyle": ":"})
        for period in motor.periods:
            axes.axvline(1e3 * period, color=GREY, linewidth=0.8)
        axes.set(ylabel=f"{motor.name}: ratio", xlabel="period of the ripple (mm); upright: the observer's own", ylim=0)
        set_ticks(axes.xaxis, [3, 4, 5, 7, 10, 15, 20, 30, 40, 60])
    return figure


@drawn
def figure_robustness() -> Figure:
    """Draw the accuracies of PID and observer against each unknown quantity alone, over assumed ranges."""
    names = {
        "thrust": "thrust above what is believed (%)",
        "ripple": f"rms of a ripple of {1e3 * RIPPLE_PERIOD:g} mm (% of the cogging)",
        "encoder": "step of the encoder (nm)",
        "friction": "width of the dry friction (mm/s)",
    }
    title = "Accuracy where something is not as believed; dotted: printed in Table I"
    figure, panels = titled_panels(title, (8.0, 10.0), len(names), len(MOTORS), sharey="col")
    for motor, column in zip(MOTORS.values(), panels.T, strict=True):
        gains = shipped(motor)
        exact, laws = plant(motor, gains.amplitude), controllers(motor, gains)
        stepped = [replace(motor, resolution=1e-9 * step) for step in DRAWN_SIZES["encoder"]]
        cases = {
            "thrust": [(exact, controllers(motor, gains, 1.0 + 0.01 * part)) for part in DRAWN_SIZES["thrust"]],
            "ripple": [(rippled(motor, 0.01 * percent), laws) for percent in DRAWN_SIZES["ripple"]],
            "encoder": [(plant(each, gains.amplitude), laws) for each in stepped],
            "friction": [(with_friction(motor, 1e-3 * width), laws) for width in DRAWN_SIZES["friction"]],
        }
        for axes, (kind, name) in zip(column, names.items(), strict=True):
            sizes, errors = DRAWN_SIZES[kind], largest_errors(motor, cases[kind])
            for place, (law, printed) in enumerate(zip(CONTROLLERS, motor.accuracy, strict=True)):
                axes.loglog(sizes, 1e6 * errors[law], label=law, marker=marker(place), **look(place))
                axes.axhline(1e6 * printed, **look(place) | {"linestyle": ":"}, linewidth=0.9)
            axes.set(xlabel=name, ylabel="accuracy (µm)")
            set_ticks(axes.xaxis, sizes)
            axes.yaxis.set_major_formatter("{x:g}")
        column[0].set_title(motor.name)
        legend(column[0])
    return figure
