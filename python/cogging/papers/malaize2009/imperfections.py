"""What Table I of Malaize and Levine 2009 hides: accuracies where something is not as believed."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np

from cogging import effects
from cogging._core import Plant
from cogging.arrays import FloatArray
from cogging.logs.log import Log
from cogging.model.controller import ListedController
from cogging.papers.malaize2009.setup import (
    CONTROLLERS,
    MOTORS,
    REPEATS,
    Calibrated,
    Motor,
    controllers,
    observer,
    pid,
    plant,
    reference,
    run,
    shipped,
    true_error,
)
from cogging.papers.result import Row, Table
from cogging.simulation.batch import closed_loop_batch

RIPPLE_PERIOD = 0.0073  # m, no fraction of a motor's periods: of the ripple that no controller knows
FRICTION_WIDTHS = (0.0, 1e-5, 5e-5, 2e-4, 1e-3, 5e-3)  # m/s, assumed
STRIBECK_EXCESS = 0.5  # of the dry friction, assumed


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


def cogging_rms(motor: Motor, amplitude: float) -> float:
    """rms (m/s^2) of the cogging that the observer knows; amplitude: of the first period, m/s^2."""
    return amplitude * float(np.sqrt(0.5 * np.sum(np.square(motor.shape))))


def by_stroke(log: Log, motor: Motor) -> FloatArray:
    """Max |x - x*| (m) of each stroke with the rest behind it, (strokes,)."""
    half = 0.5 * reference(motor).period
    stroke = np.floor(log.time / half + 1e-9).astype(int)
    error = np.abs(true_error(log))
    return np.array([error[stroke == each].max() for each in range(2 * REPEATS)])


def largest_errors(
    motor: Motor, machines: Sequence[Plant], controllers: Sequence[Mapping[str, ListedController]]
) -> dict[str, FloatArray]:
    """setup.accuracy (m) of each machine under its own PID and observer, (n,) each; infinite where a run diverged."""
    found = {}
    for name in CONTROLLERS:
        run = closed_loop_batch(
            machines,
            [pair[name] for pair in controllers],
            reference(motor),
            start=0.5 * reference(motor).period,
            reductions=["true_error_max"],
        )
        found[name] = np.nan_to_num(run.indexes["true_error_max"], nan=np.inf)
    return found


def imperfections(motor: Motor, gains: Calibrated) -> dict[str, dict[str, float]]:
    """Accuracies (m) of PID and observer where something is not as believed, by what it is."""
    machines = machines_not_as_believed(motor, gains.amplitude)
    cases = {name: (machine, controllers(motor, gains)) for name, machine in machines.items()}
    exact = machines["as believed"]
    for share in (0.005, 0.02):
        pair = {"PID": pid(1.0 + share), "observer": observer(motor, gains, thrust=1.0 + share)}
        cases[f"thrust + {100 * share:g} %"] = (exact, pair)
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
                rows.append(Row(name, "accuracy", "m", None, found[name], "exploratory", label))
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
                rows.append(Row("observer", f"{index} stroke", "m", None, float(error), "exploratory", label))
    title = "Smooth dry friction, stroke by stroke: the largest |x - x*| of a stroke and the rest behind it"
    return Table("smooth_friction", title, rows)
