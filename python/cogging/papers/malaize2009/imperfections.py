"""What Table I of Malaize and Levine 2009 hides: accuracies where something is not as believed."""

from __future__ import annotations

from typing import Any

import numpy as np

from cogging.model.controller import ListedController
from cogging.papers.malaize2009.setup import (
    CONTROLLERS,
    MOTORS,
    Calibrated,
    Motor,
    accuracies,
    controllers,
    observer,
    pid,
    plant,
    shipped,
)
from cogging.papers.result import Row, Table

RIPPLE_PERIOD = 0.0073  # m, no fraction of a motor's periods: of the ripple that no controller knows


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
