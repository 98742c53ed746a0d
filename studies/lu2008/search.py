"""Searches the shape and the amplitudes of the cogging maps of Lu et al. 2008 that bring their tables near.

Over the last move the error is linear in the control points of the map but for the quantiser and the estimates' bounds.
So the answers to single control points, simulated once (Responses), stand for the simulation in a differential
evolution; steps on the simulation itself then end the search.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from scipy.optimize import differential_evolution

from cogging._core import CoggingModel, Dcarc, Plant
from cogging.arrays import FloatArray
from cogging.papers.lu2008.setup import (
    CONTROL_POINTS,
    CONTROLLERS,
    HARMONICS,
    GantryAxis,
    cogging_basis,
    cogging_map,
    controller_parameters,
    last_errors,
    plant,
    reference,
    share_of_bound,
)
from cogging.papers.lu2008.shapes import MapShape
from cogging.simulation.batch import closed_loop_batch

SHIFT = 1 / 8  # of a pitch: leaves the fundamental most room within the bound, by sqrt(2) more than 0; not searched
SHAPE_RANGES = ((0.8, 2.2), (1.0, 3.0), (np.pi / 2, 3 * np.pi / 2))  # decay, half_waves, begin (rad)
AMPLITUDE_RANGES = ((0.0, 0.15), (0.0, 0.2), (0.0, 0.8))  # V: periodic, modulated, uncompensated
ROOM = 0.95  # share of the printed bound that the control points may take
SHAPE_STEP = 0.02  # of the last search
AMPLITUDE_STEP, AMPLITUDE_STEP_LEAST = 0.02, 0.001  # of the same, relative and V
LEVEL = 0.02  # V: of the single control points of Responses
AT_ONCE = 16  # runs whose rows are kept together
SETTINGS = {"popsize": 5, "maxiter": 150, "tol": 0.0, "polish": False, "seed": 2008}


@dataclass(frozen=True)
class Fit:
    """A shape for both axes and three amplitudes for each axis that took part.

    Attributes:
        values: decay, half_waves, begin, then periodic, modulated, uncompensated of each axis.
    """

    values: tuple[float, ...]

    @property
    def shape(self) -> MapShape:
        """The shape."""
        decay, half_waves, begin = self.values[:3]
        return MapShape(decay, half_waves, begin, SHIFT)

    def amplitudes(self, number: int) -> tuple[float, float, float]:
        """Those of an axis by its place, V."""
        periodic, modulated, uncompensated = self.values[3 + 3 * number : 6 + 3 * number]
        return periodic, modulated, uncompensated

    def map(self, number: int, axis: GantryAxis) -> CoggingModel:
        """The map of an axis by its place."""
        return cogging_map(axis, self.amplitudes(number), self.shape)

    def rounded(self) -> Fit:
        """As the file keeps it: shape to 0.01, amplitudes to three digits."""
        shape = (round(float(value), 2) for value in self.values[:3])
        return Fit((*shape, *(float(f"{value:.3g}") for value in self.values[3:])))


class Responses:
    """Errors (m) of C1, C2, C3 over the last move, per volt of each control point, and without cogging."""

    def __init__(self, axis: GantryAxis, every: int) -> None:
        self.axis = axis
        motion = reference(axis)
        flat = np.zeros((2, len(HARMONICS), CONTROL_POINTS))
        points = np.concatenate([flat.reshape(1, -1), LEVEL * np.eye(flat.size)])
        machines = [self._machine(point.reshape(flat.shape), exact=True) for point in points]
        machines.append(self._machine(flat, exact=False))
        self.answers, self.alone = [], []
        for name in CONTROLLERS:
            controller = Dcarc(controller_parameters(axis, name))
            errors: list[FloatArray] = []
            for first in range(0, len(machines), AT_ONCE):
                part = machines[first : first + AT_ONCE]
                columns = ("time", "position", "reference")
                found = closed_loop_batch(part, [controller] * len(part), motion, columns=columns, every=every).columns
                rows = zip(found["time"], found["position"], found["reference"], strict=True)
                errors += [(x - wanted)[time >= motion.end - motion.period] for time, x, wanted in rows]
            self.answers.append((np.array(errors[1:-1]) - errors[0]).T / LEVEL)
            self.alone.append(errors[-1])

    def _machine(self, points: FloatArray, exact: bool) -> Plant:
        cogging = CoggingModel(cogging_basis(), points[0], points[1])
        quantised = plant(self.axis, cogging)
        return Plant(quantised.axis, cogging=cogging) if exact else quantised

    def errors(self, maps: Sequence[CoggingModel]) -> FloatArray:
        """e_inf and e_2 (m) of C1, C2, C3, (maps, 3, 2)."""
        points = np.array([np.concatenate([one.sine.ravel(), one.cosine.ravel()]) for one in maps]).T
        found = [answer @ points + alone[:, None] for answer, alone in zip(self.answers, self.alone, strict=True)]
        indexes = [[np.abs(error).max(axis=0), np.sqrt((error**2).mean(axis=0))] for error in found]
        return np.array(indexes).transpose(2, 0, 1)


def misfit(
    axes: Sequence[GantryAxis], fits: Sequence[Fit], errors: Sequence[FloatArray], controllers: int = 3
) -> FloatArray:
    """What is made small, (fits,): squared log-ratios to the printed numbers, their sum and four times the largest.

    A hundred squares of what the control points take beyond ROOM of the bound are added.

    Args:
        axes: whose tables are looked at.
        fits: a shape and the amplitudes of these axes, each.
        errors: of each axis, (fits, 3, 2).
        controllers: how many take part, from C1 on.
    """
    gaps = [
        np.log(found / np.array([axis.error_max, axis.error_rms]).T) for axis, found in zip(axes, errors, strict=True)
    ]
    squares = np.concatenate([gap[:, :controllers] for gap in gaps], axis=1).reshape(len(fits), -1) ** 2
    shares = [[share_of_bound(axis, fit.map(i, axis)) for i, axis in enumerate(axes)] for fit in fits]
    beyond = np.maximum(np.array(shares) - ROOM, 0.0)
    return np.asarray(squares.sum(axis=1) + 4 * squares.max(axis=1) + 100 * (beyond**2).sum(axis=1))


def simulated_misfit(axes: Sequence[GantryAxis], fits: Sequence[Fit], controllers: int = 3) -> FloatArray:
    """The misfit of the simulation, (fits,)."""
    errors = [last_errors(axis, [plant(axis, fit.map(i, axis)) for fit in fits]) for i, axis in enumerate(axes)]
    return misfit(axes, fits, errors, controllers)


def neighbours(fit: Fit) -> list[Fit]:
    """A step up and down in each value."""
    found = []
    for place, value in enumerate(fit.values):
        step = SHAPE_STEP if place < 3 else max(AMPLITUDE_STEP * value, AMPLITUDE_STEP_LEAST)
        for sign in (-1, 1):
            changed = (*fit.values[:place], max(0.0, value + sign * step), *fit.values[place + 1 :])
            found.append(Fit(changed).rounded())
    return found


def search(axes: Sequence[GantryAxis], responses: Sequence[Responses], controllers: int = 3) -> Fit:
    """The shape and the amplitudes of least misfit to the numbers of the axes (of so many controllers, from C1 on)."""

    def surrogate(values: FloatArray) -> FloatArray:
        fits = [Fit(tuple(column)) for column in values.T]
        errors = [one.errors([fit.map(i, one.axis) for fit in fits]) for i, one in enumerate(responses)]
        return misfit(axes, fits, errors, controllers)

    ranges = [*SHAPE_RANGES, *(AMPLITUDE_RANGES * len(axes))]
    found = differential_evolution(surrogate, ranges, vectorized=True, updating="deferred", **SETTINGS)
    fit = Fit(tuple(found.x)).rounded()
    least = float(simulated_misfit(axes, [fit], controllers)[0])
    while True:
        tried = neighbours(fit)
        misfits = simulated_misfit(axes, tried, controllers)
        if misfits.min() >= least:
            return fit
        fit, least = tried[int(misfits.argmin())], float(misfits.min())
