"""How the accuracies of Malaize and Levine 2009 change with what the controllers do not know; not in the paper."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from cogging._core import Plant
from cogging.arrays import FloatArray
from cogging.papers.malaize2009.imperfections import RIPPLE_PERIOD, cogging_rms, largest_errors, with_friction
from cogging.papers.malaize2009.setup import Calibrated, Motor, controllers, observer, pid, plant


@dataclass(frozen=True)
class Sweep:
    """One thing that is not as believed, in growing sizes.

    Attributes:
        name: with its unit, for an axis.
        sizes: in that unit, (n,).
        error: accuracy (m) by controller, (n,) each; infinite where a run diverged.
    """

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
    pairs = [{"PID": pid(factor), "observer": observer(motor, gains, thrust=factor)} for factor in 1.0 + 0.01 * thrusts]
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
