"""What Table I of Malaize and Levine 2009 hides: accuracies where something is not as believed; not in the paper."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from cogging import effects
from cogging._core import Plant
from cogging.arrays import FloatArray
from cogging.logs.log import Log
from cogging.model.controller import ListedController
from cogging.papers.compared import set_ticks
from cogging.papers.malaize2009.linear_motors import (
    CONTROLLERS,
    MOTORS,
    REPEATS,
    Calibrated,
    Motor,
    batch_errors,
    cogging_rms,
    controllers,
    observer,
    pid,
    plant,
    reference,
    run,
    shipped,
    true_error,
)
from cogging.papers.result import Table, explored
from cogging.plot.canvas import drawn, legend, new_figure
from cogging.plot.series import GREY, look, marker

if TYPE_CHECKING:
    from matplotlib.figure import Figure

RIPPLE_PERIOD = 0.0073  # m, no fraction of a motor's periods: of the ripple that no controller knows
FRICTION_WIDTHS = (0.0, 1e-5, 5e-5, 2e-4, 1e-3, 5e-3)  # m/s, assumed
STRIBECK_EXCESS = 0.5  # of the dry friction, assumed


def ripple_ratio(motor: Motor, periods: Any, share: float = 0.04) -> Any:
    """Observer's over PID's rms error of one unmodelled ripple by its period (m), without cogging or friction."""
    gains = shipped(motor)
    size = share * gains.amplitude
    machines = [plant(motor, 0.0, ripples=[(float(period), size)], resolution=0.0, friction=0.0) for period in periods]
    rms = [
        batch_errors(machines, [controller] * len(machines), motor, reduction="true_error_rms")
        for controller in controllers(motor, gains).values()
    ]
    return rms[1] / rms[0]


@drawn
def figure_ripple() -> Figure:
    """The ratio observer / PID of the error that one unmodelled ripple makes, against its period."""
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
            set_ticks(axes.xaxis, sweep.sizes.tolist())
            axes.yaxis.set_major_formatter("{x:g}")
        column[0].set_title(motor.name)
        legend(column[0])
    return figure


def with_friction(machine: Plant, width: float, excess: float = 0.0, velocity: float = 0.01) -> Plant:
    """The machine with its dry friction smooth about rest.

    Args:
        machine: of plant().
        width: m/s; 0 is exact dry friction, which sticks.
        excess: m/s^2, of Stribeck friction at rest over the dry one.
        velocity: m/s, at which that excess has fallen to 1/e.
    """
    listed = list(machine.effects)
    if excess:
        listed.append(effects.StribeckFriction(static_excess=excess, velocity=velocity))
    axis = machine.axis.replace(coulomb_width=width)
    return Plant(axis, cogging=machine.cogging, effects=listed, encoder=machine.encoder, noise=machine.noise)


def by_stroke(log: Log, motor: Motor) -> FloatArray:
    """Max |x - x*| (m) of each stroke with the rest behind it, (strokes,)."""
    half = 0.5 * reference(motor).period
    stroke = np.floor(log.time / half + 1e-9).astype(int)
    error = np.abs(true_error(log))
    return np.array([error[stroke == each].max() for each in range(2 * REPEATS)])


def largest_errors(
    motor: Motor, machines: Sequence[Plant], controllers: Sequence[Mapping[str, ListedController]]
) -> dict[str, FloatArray]:
    """Return the accuracy (m) of each machine under its own PID and observer, (n,) each."""
    return {name: batch_errors(machines, [pair[name] for pair in controllers], motor) for name in CONTROLLERS}


def imperfections(motor: Motor, gains: Calibrated) -> dict[str, dict[str, float]]:
    """Accuracies (m) of PID and observer where something is not as believed, by what it is."""
    machines = machines_not_as_believed(motor, gains.amplitude)
    cases = {name: (machine, controllers(motor, gains)) for name, machine in machines.items()}
    exact = machines["as believed"]
    for share in (0.005, 0.02):
        cases[f"thrust + {100 * share:g} %"] = (exact, controllers(motor, gains, 1.0 + share))
    cases["periods 2 % too long"] = (exact, {"PID": pid(), "observer": observer(motor, gains, stretch=1.02)})
    errors = largest_errors(motor, *zip(*cases.values(), strict=True))
    return {name: {each: float(errors[each][i]) for each in CONTROLLERS} for i, name in enumerate(cases)}


def machines_not_as_believed(motor: Motor, amplitude: float) -> dict[str, Plant]:
    """Machines that their controllers know nothing of, by what they have; amplitude: of the first period, m/s^2."""
    rms = cogging_rms(motor, amplitude)
    exact, excess = plant(motor, amplitude), STRIBECK_EXCESS * motor.friction
    found = {"as believed": exact}
    for share in (0.04, 0.20):
        ripple = (RIPPLE_PERIOD, share * rms * np.sqrt(2.0))
        found[f"ripple of {100 * share:.0f} % rms"] = plant(motor, amplitude, ripples=[ripple])
    for times in (1, 10):
        machine = plant(motor, amplitude, friction=0.0, resolution=times * motor.resolution)
        found[f"quantiser of {1e9 * times * motor.resolution:g} nm alone"] = machine
    found["encoder 10 times coarser"] = plant(motor, amplitude, resolution=10 * motor.resolution)
    for width in FRICTION_WIDTHS[1:]:
        found[f"friction {1e3 * width:g} mm/s wide"] = with_friction(exact, width)
    found["Stribeck friction that sticks"] = with_friction(exact, 0.0, excess)
    found["Stribeck friction 0.05 mm/s wide"] = with_friction(exact, 5e-5, excess)
    return found


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
                rows.append(explored(name, "accuracy", "m", found[name], label))
    return Table("imperfections", "What Table I hides: accuracy where something is not as believed", rows)


def smooth_friction() -> Table:
    """The observer's error stroke by stroke (m), by the width of the friction; not in the paper."""
    rows = []
    for motor in MOTORS.values():
        gains = shipped(motor)
        for width in (0.0, 5e-5, 1e-3):
            machine = with_friction(plant(motor, gains.amplitude), width)
            strokes = by_stroke(run(machine, observer(motor, gains), motor), motor)
            label = {"motor": motor.name, "width": f"{1e3 * width:g} mm/s"}
            for index, error in zip(("1st", "2nd", "3rd", "last"), strokes[[0, 1, 2, -1]], strict=True):
                rows.append(explored("observer", f"{index} stroke", "m", error, label))
    title = "Smooth dry friction, stroke by stroke: the largest |x - x*| of a stroke and the rest behind it"
    return Table("smooth_friction", title, rows)


class Sweep(NamedTuple):
    """One thing that is not as believed: its name with a unit, sizes in that unit, and the accuracies by controller."""

    name: str
    sizes: FloatArray
    error: dict[str, FloatArray]


def sweeps(motor: Motor, gains: Calibrated) -> list[Sweep]:
    """Thrust, an unmodelled ripple, the encoder's step and the width of the friction, each alone (assumed ranges)."""
    exact = plant(motor, gains.amplitude)
    rms = cogging_rms(motor, gains.amplitude)

    def rippled(percent: float) -> Plant:
        return plant(motor, gains.amplitude, ripples=[(RIPPLE_PERIOD, 0.01 * percent * rms * np.sqrt(2.0))])

    def read_by(step: float) -> Plant:
        return plant(motor, gains.amplitude, resolution=1e-9 * step)

    def rubbed(width: float) -> Plant:
        return with_friction(exact, 1e-3 * width)

    thrusts = np.array([0.1, 0.2, 0.5, 1.0, 2.0, 5.0])
    pairs = [controllers(motor, gains, float(factor)) for factor in 1.0 + 0.01 * thrusts]
    found = [Sweep("thrust above what is believed (%)", thrusts, largest_errors(motor, [exact] * len(pairs), pairs))]
    for name, sizes, machine in (
        (f"rms of a ripple of {1e3 * RIPPLE_PERIOD:g} mm (% of the cogging)", [0.5, 1, 2, 5, 10, 20, 50], rippled),
        ("step of the encoder (nm)", [1, 3, 10, 30, 100, 300, 1000], read_by),
        ("width of the dry friction (mm/s)", [0.002, 0.01, 0.05, 0.2, 1, 5, 20], rubbed),
    ):
        machines = [machine(size) for size in sizes]
        errors = largest_errors(motor, machines, [controllers(motor, gains)] * len(sizes))
        found.append(Sweep(name, np.array(sizes, dtype=float), errors))
    return found
