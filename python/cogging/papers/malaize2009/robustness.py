"""Accuracies of Malaize and Levine 2009 where something is not as the controllers believe; not in the paper."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence

import numpy as np
from matplotlib.figure import Figure

from cogging import effects
from cogging._core import Plant
from cogging.arrays import FloatArray
from cogging.model.controller import ListedController
from cogging.papers.compared import set_ticks
from cogging.papers.malaize2009 import linear_motors
from cogging.papers.malaize2009.linear_motors import CONTROLLERS, MOTORS, Motor, controllers, observer, plant, shipped
from cogging.papers.result import Table, explored
from cogging.plot.canvas import drawn, legend, new_figure
from cogging.plot.series import GREY, look, marker

RIPPLE_PERIOD = 0.0073  # m, no fraction of a motor's periods: of the ripple that no controller knows
FRICTION_WIDTHS = (1e-5, 5e-5, 2e-4, 1e-3, 5e-3)  # m/s, assumed
STRIBECK_EXCESS, STRIBECK_VELOCITY = 0.5, 0.01  # of the dry friction, and m/s; assumed


def rippled(motor: Motor, share: float) -> Plant:
    """Return the machine with a ripple that no controller knows; share: its rms over the cogging's."""
    amplitude = shipped(motor).amplitude
    size = share * linear_motors.cogging_rms(motor, amplitude) * np.sqrt(2.0)
    return plant(motor, amplitude, ripples=[(RIPPLE_PERIOD, size)])


def with_friction(motor: Motor, width: float, excess: float = 0.0) -> Plant:
    """Return the machine with friction smooth over a width (m/s; 0: it sticks), and relative Stribeck friction."""
    machine = plant(motor, shipped(motor).amplitude)
    listed = list(machine.effects)
    if excess:
        listed.append(effects.StribeckFriction(static_excess=excess * motor.friction, velocity=STRIBECK_VELOCITY))
    axis = machine.axis.replace(coulomb_width=width)
    return Plant(axis, cogging=machine.cogging, effects=listed, encoder=machine.encoder)


def largest_errors(
    motor: Motor, cases: Sequence[tuple[Plant, Mapping[str, ListedController]]]
) -> dict[str, FloatArray]:
    """Return the accuracy (m) of each machine under its own PID and observer, (n,) each."""
    machines = [machine for machine, _ in cases]
    return {
        name: linear_motors.batch_errors(machines, [laws[name] for _, laws in cases], motor) for name in CONTROLLERS
    }


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
            alone = plant(motor, amplitude, friction=0.0, resolution=step)
            machines[f"quantiser of {1e9 * step:g} nm alone"] = alone
        machines["encoder 10 times coarser"] = plant(motor, amplitude, resolution=10 * motor.resolution)
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
                worse = name == "observer" and pair[1] > pair[0]
                note = {"note": "worse than the PID"} if worse else {}
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


def ripple_ratio(motor: Motor, periods: FloatArray) -> FloatArray:
    """Return the observer's over the PID's rms error of one unknown ripple by its period (m), without any friction."""
    gains = shipped(motor)
    machines = [
        plant(motor, 0.0, ripples=[(period, 0.04 * gains.amplitude)], resolution=0.0, friction=0.0)
        for period in periods.tolist()
    ]
    pid, own = (
        linear_motors.batch_errors(machines, [law] * len(machines), motor, reduction="true_error_rms")
        for law in controllers(motor, gains).values()
    )
    return own / pid


@drawn
def figure_ripple() -> Figure:
    """Draw the ratio observer / PID of the error due to one unmodelled ripple, against its period."""
    figure = new_figure((8.0, 5.5))
    figure.suptitle("Unmodelled ripple: the observer's rms error over the PID's")
    for axes, motor in zip(figure.subplots(2, 1), MOTORS.values(), strict=True):
        periods = np.geomspace(3e-3, 0.06, 60)
        axes.semilogx(1e3 * periods, ripple_ratio(motor, periods), **look(0))
        axes.axhline(1.0, **look(2) | {"linestyle": ":"})
        for period in motor.periods:
            axes.axvline(1e3 * period, color=GREY, linewidth=0.8)
        axes.set(ylabel=f"{motor.name}: ratio", xlabel="period of the ripple (mm); upright: the observer's own", ylim=0)
        set_ticks(axes.xaxis, [3, 4, 5, 7, 10, 15, 20, 30, 40, 60])
    return figure


@drawn
def figure_robustness() -> Figure:
    """Draw the accuracies of PID and observer against each unknown quantity alone, over assumed ranges."""
    sweeps: dict[str, tuple[list[float], Callable[[Motor, float], Plant]]] = {
        f"rms of a ripple of {1e3 * RIPPLE_PERIOD:g} mm (% of the cogging)": (
            [0.5, 1, 2, 5, 10, 20, 50],
            lambda motor, percent: rippled(motor, 0.01 * percent),
        ),
        "step of the encoder (nm)": (
            [1, 3, 10, 30, 100, 300, 1000],
            lambda motor, step: plant(motor, shipped(motor).amplitude, resolution=1e-9 * step),
        ),
        "width of the dry friction (mm/s)": (
            [0.002, 0.01, 0.05, 0.2, 1, 5, 20],
            lambda motor, width: with_friction(motor, 1e-3 * width),
        ),
    }
    thrusts = [0.1, 0.2, 0.5, 1.0, 2.0, 5.0]
    figure = new_figure((8.0, 10.0))
    figure.suptitle("Accuracy where something is not as believed; dotted: printed in Table I")
    panels = figure.subplots(1 + len(sweeps), len(MOTORS), sharey="col")
    for motor, column in zip(MOTORS.values(), panels.T, strict=True):
        gains = shipped(motor)
        exact, laws = plant(motor, gains.amplitude), controllers(motor, gains)
        wrong = [(exact, controllers(motor, gains, 1.0 + 0.01 * thrust)) for thrust in thrusts]
        found = {"thrust above what is believed (%)": (thrusts, largest_errors(motor, wrong))}
        for name, (sizes, machine) in sweeps.items():
            found[name] = (sizes, largest_errors(motor, [(machine(motor, size), laws) for size in sizes]))
        for axes, (name, (sizes, errors)) in zip(column, found.items(), strict=True):
            for place, (law, printed) in enumerate(zip(CONTROLLERS, motor.accuracy, strict=True)):
                axes.loglog(sizes, 1e6 * errors[law], label=law, marker=marker(place), **look(place))
                axes.axhline(1e6 * printed, **look(place) | {"linestyle": ":"}, linewidth=0.9)
            axes.set(xlabel=name, ylabel="accuracy (µm)")
            set_ticks(axes.xaxis, sizes)
            axes.yaxis.set_major_formatter("{x:g}")
        column[0].set_title(motor.name)
        legend(column[0])
    return figure
