"""Calibrates the gains of `cogging reproduce --compare`: `python -m studies.comparison_gains [FILE]` (extra `design`).

Observer gains by the papers' rules, and for each axis the factors on the controllers' bandwidths that give all loops the
same delay margin. They come with the package as comparison_gains.toml.
"""

from __future__ import annotations

import sys
from collections.abc import Iterable

import numpy as np

from cogging._core import DivergedError
from cogging.design.loop_margins import Loops, Machine, push_of
from cogging.design.observer import design_observer
from cogging.model.controller import ListedController
from cogging.model.model import Model
from cogging.papers import comparison
from cogging.papers.lu2008 import gantry as lu2008
from cogging.simulation.varied import Setup
from studies.command import run_calibration
from studies.fitting import round_to_digits


def delay_margin(controller: ListedController, axis: lu2008.GantryAxis) -> float:
    """The delay (s) of the command that the loop on an axis tolerates, as `cogging tune` measures it."""
    plant, motion = comparison.machine(axis=axis), lu2008.reference(axis, repeats=1)
    model = Model(axis=plant.axis, cogging=plant.cogging, encoder=plant.encoder)
    largest = axis.mass * axis.acceleration + axis.coulomb
    push = push_of(motion, lu2008.SAMPLE_RATE, 0.0, largest)
    return Loops([Machine(Setup(model, motion), 0)], controller, push).delay_margin()


def factor_of(name: str, axis: lu2008.GantryAxis) -> float:
    """The factor (3 digits) on the bandwidth of a controller at which the loop tolerates DELAY_MARGIN, by bisection."""
    low, high = 0.3, 5.0
    while high / low > 1.03:
        middle = float(np.sqrt(low * high))
        try:
            holds = delay_margin(comparison.scaled(name, axis, middle), axis) >= comparison.DELAY_MARGIN
        except (ValueError, DivergedError):
            holds = middle < 1.0  # no such gain: too slow for the observer's decay rate, or too fast for the samples
        low, high = (middle, high) if holds else (low, middle)
    return round_to_digits(low, 3)


def gains_toml() -> str:
    """The text of comparison_gains.toml, which comes with the package (extra `design` to write it anew)."""
    lines = ["# Gains of the comparison, by studies.comparison_gains.", "[own]"]
    for name, radius in comparison.POLE_RADII.items():
        lines.append(f'"{name}" = {_digits(design_observer(comparison.observer_problem(radius)).observer_gain)}')
    for axis in lu2008.AXES.values():
        factors = {name: factor_of(name, axis) for name in comparison.SCALED}
        slow = (axis, factors["observer_based"], comparison.SLOW_DECAY_RATE)
        problem = comparison.observer_problem(comparison.POLE_RADII["observer_based"], *slow)
        lines += [f"[{axis.name}]", f"observer_gain = {_digits(design_observer(problem).observer_gain)}"]
        lines += [f"[{axis.name}.factors]", *(f'"{name}" = {factor}' for name, factor in factors.items())]
    return "\n".join(lines) + "\n"


def _digits(gain: Iterable[float]) -> list[float]:
    return [round_to_digits(float(value), 6) for value in gain]


if __name__ == "__main__":
    sys.exit(run_calibration(__doc__, gains_toml, "cogging.papers", "comparison_gains.toml"))
