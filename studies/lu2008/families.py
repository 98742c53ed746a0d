"""Families of cogging maps for Lu et al. 2008, and how near each comes: `python -m studies.lu2008.families`.

A family is a choice of each entry of GRID; within it a few amplitudes are free. Every cell is fitted to the twelve
numbers of Tables 1 and 2 and printed; the one with the fewest free amplitudes that brings 90 % of them within 15 % is
shipped (calibration.py).

Over the last move the error is linear in the control points of the map but for the quantiser and the estimates' bounds.
So the answers to single control points, simulated once (Responses), stand for the simulation in a search;
steps on the simulation itself then end the search of the shipped family.
"""

from __future__ import annotations

import itertools
import sys
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from scipy.optimize import minimize

from cogging._core import CoggingModel, Dcarc, Plant
from cogging.arrays import FloatArray
from cogging.papers.lu2008 import gantry
from cogging.papers.lu2008.tracking import INDEXES
from cogging.simulation.batch import closed_loop_batch
from studies.command import run_study
from studies.fitting import round_to_digits

SHIFT = 1 / 8  # of a pitch: leaves the fundamental most room within the bound, by sqrt(2) more than 0
#: Amplitudes of X and Y, each (periodic, modulated, uncompensated), V, from those that are free, by name of the sharing.
SHARINGS: dict[str, tuple[tuple[str, ...], Callable[[FloatArray], Sequence[FloatArray]]]] = {
    "all six": (
        ("periodic X", "modulated X", "uncompensated X", "periodic Y", "modulated Y", "uncompensated Y"),
        lambda v: v,
    ),
    "Y has no mean": (
        ("periodic X", "modulated X", "uncompensated X", "modulated Y", "uncompensated Y"),
        lambda v: (v[0], v[1], v[2], 0 * v[0], v[3], v[4]),
    ),
    "one fundamental": (
        ("fundamental of both", "modulated X", "uncompensated X", "uncompensated Y"),
        lambda v: (v[0], v[1], v[2], 0 * v[0], v[0], v[3]),
    ),
    "one modulation": (
        ("periodic X", "modulated both", "uncompensated X", "uncompensated Y"),
        lambda v: (v[0], v[1], v[2], 0 * v[0], v[1], v[3]),
    ),
    "one peak": (
        ("periodic X", "modulated X", "uncompensated X", "uncompensated Y"),
        lambda v: (v[0], v[1], v[2], 0 * v[0], v[0] + v[1], v[3]),
    ),
    "one fundamental, X half modulated": (
        ("fundamental of both", "uncompensated X", "uncompensated Y"),
        lambda v: (v[0], 0.5 * v[0], v[1], 0 * v[0], v[0], v[2]),
    ),
}
#: The discrete choices, each with all others: 2 x 3 x 3 x 4 x 6 = 432 cells.
GRID = {
    "error_difference": (True, False),
    "decay": (1.0, 1.5, 2.0),
    "half_waves": (1.0, 2.0, 3.0),
    "begin": (0.0, np.pi / 2, np.pi, 3 * np.pi / 2),
    "sharing": tuple(SHARINGS),
}
#: V: where the search begins, by what is free, of X or both and of Y.
START = {
    "fundamental": (0.08, 0.08),
    "periodic": (0.08, 0.005),
    "modulated": (0.05, 0.07),
    "uncompensated": (0.4, 0.04),
}
START_FACTORS = (0.7, 1.0, 1.4)
ROOM = 0.95  # share of the printed bound that the control points may take
NEAR, ENOUGH = 0.15, 11  # of the printed number; how many of the twelve, 90 %
STEP, STEP_LEAST = 0.02, 0.0005  # of the last search, relative and V
ON_RAMP = 0.1  # added to the misfit for each maximum on a ramp: the printed ones are whole counts (tables.maxima_table)
LEVEL = 0.02  # V: of the single control points of Responses
AT_ONCE = 16  # runs whose rows are kept together
EVERY = {"X": 2, "Y": 8}  # sample of those that the linear answers hold
SETTINGS = {"maxfev": 150, "xatol": 1e-4, "fatol": 1e-3}

#: Which of the twelve numbers take part in a fit: by axis, controller and index.
Seen = Callable[[str, str, str], bool]


def all_numbers(axis: str, controller: str, index: str) -> bool:
    """That of the tables."""
    return True


class Responses:
    """Errors (m) of C1, C2, C3 over the last move, per volt of each control point, and without cogging."""

    def __init__(self, axis: gantry.GantryAxis, error_difference: bool, every: int) -> None:
        motion = gantry.reference(axis)
        flat = np.zeros((2, len(gantry.HARMONICS), gantry.CONTROL_POINTS))
        points = np.concatenate([flat.reshape(1, -1), LEVEL * np.eye(flat.size)])
        machines = [_machine(axis, point.reshape(flat.shape), exact=True) for point in points]
        machines.append(_machine(axis, flat, exact=False))
        self.answers, self.alone = [], []
        for name in gantry.CONTROLLERS:
            controller = Dcarc(gantry.controller_parameters(axis, name, error_difference=error_difference))
            errors: list[FloatArray] = []
            for first in range(0, len(machines), AT_ONCE):
                part = machines[first : first + AT_ONCE]
                columns = ("time", "position", "reference")
                found = closed_loop_batch(part, [controller] * len(part), motion, columns=columns, every=every).columns
                rows = zip(found["time"], found["position"], found["reference"], strict=True)
                errors += [(x - wanted)[time >= motion.end - motion.period] for time, x, wanted in rows]
            self.answers.append((np.array(errors[1:-1]) - errors[0]).T / LEVEL)
            self.alone.append(errors[-1])

    def errors(self, columns: Sequence[FloatArray]) -> FloatArray:
        """e_inf and e_2 (m) of C1, C2, C3, (maps, 3, 2), from what maps add to the error of each, (rows, maps)."""
        found = [column + alone[:, None] for column, alone in zip(columns, self.alone, strict=True)]
        indexes = [[np.abs(error).max(axis=0), np.sqrt((error**2).mean(axis=0))] for error in found]
        return np.array(indexes).transpose(2, 0, 1)


def _machine(axis: gantry.GantryAxis, points: FloatArray, exact: bool) -> Plant:
    cogging = CoggingModel(gantry.cogging_basis(), points[0], points[1])
    quantised = gantry.plant(axis, cogging)
    return Plant(quantised.axis, cogging=cogging) if exact else quantised


def log_ratios(errors: dict[str, FloatArray]) -> FloatArray:
    """Of simulated to printed numbers, (maps, 12): by axis, controller and index."""
    gaps = []
    for name, found in errors.items():
        axis = gantry.AXES[name]
        gaps.append(np.log(found / np.array([axis.error_max, axis.error_rms]).T))
    return np.stack(gaps, axis=1).reshape(len(gaps[0]), -1)


def misfit(gaps: FloatArray, shares: FloatArray, seen: Seen = all_numbers) -> FloatArray:
    """What is made small, (maps,): the squared log-ratios that take part, their sum and four times the largest.

    A hundred squares of what the control points take beyond ROOM of the bound are added.

    Args:
        gaps: of log_ratios.
        shares: of the printed bound that the control points take at most, (axes, maps).
        seen: which numbers take part.
    """
    took = list(itertools.starmap(seen, itertools.product(gantry.AXES, gantry.CONTROLLERS, INDEXES)))
    squares = gaps[:, took] ** 2
    beyond = np.maximum(shares - ROOM, 0.0)
    return np.asarray(squares.sum(axis=1) + 4 * squares.max(axis=1) + 100 * (beyond**2).sum(axis=0))


@dataclass(frozen=True)
class Family:
    """One cell of GRID."""

    error_difference: bool
    decay: float
    half_waves: float
    begin: float
    sharing: str

    @property
    def shape(self) -> gantry.MapShape:
        """The shape of both maps."""
        return gantry.MapShape(self.decay, self.half_waves, self.begin, SHIFT)

    @property
    def free(self) -> tuple[str, ...]:
        """The names of the amplitudes that are fitted."""
        return SHARINGS[self.sharing][0]

    def amplitudes(self, values: FloatArray) -> dict[str, FloatArray]:
        """Periodic, modulated and uncompensated part by axis, V, (3, ...), of the free values, (free, ...)."""
        six = np.array(SHARINGS[self.sharing][1](np.asarray(values)))
        return {"X": six[:3], "Y": six[3:]}

    def maps(self, values: FloatArray) -> dict[str, CoggingModel]:
        """The map of each axis."""
        parts = self.amplitudes(values)
        return {name: gantry.cogging_map(axis, tuple(parts[name]), self.shape) for name, axis in gantry.AXES.items()}


class Surrogate:
    """The linear answers of a family: the error of a map from those of its three amplitudes."""

    def __init__(self, family: Family, responses: dict[str, Responses]) -> None:
        self.family, self.responses = family, responses
        self.columns: dict[str, list[FloatArray]] = {}
        self.bound: dict[str, FloatArray] = {}
        for name, axis in gantry.AXES.items():
            known = (gantry.HARMONICS, axis.compensated, gantry.CONTROL_POINTS)
            parts = [gantry.control_points(family.shape, tuple(unit), *known) for unit in np.eye(3)]
            units = np.reshape(parts, (3, -1)).T
            self.columns[name] = [answer @ units for answer in responses[name].answers]
            learned = np.tile(np.repeat(np.isin(gantry.HARMONICS, axis.compensated), gantry.CONTROL_POINTS), 2)
            self.bound[name] = units[learned] / axis.cogging_bound

    def gaps(self, values: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Log-ratios (maps, 12) and shares of the bound (axes, maps) of free values, (free, maps)."""
        amplitudes = self.family.amplitudes(values)
        errors = {
            name: self.responses[name].errors([column @ each for column in self.columns[name]])
            for name, each in amplitudes.items()
        }
        shares = np.array([np.abs(self.bound[name] @ each).max(axis=0) for name, each in amplitudes.items()])
        return log_ratios(errors), shares

    def fit(self, seen: Seen = all_numbers) -> FloatArray:
        """The free values (V) of least misfit, by simplexes from several starts."""

        def of(values: FloatArray) -> float:
            return float(misfit(*self.gaps(np.abs(values)[:, None]), seen)[0])

        first = np.array([START[name.split()[0]][name.endswith("Y")] for name in self.family.free])
        found = [minimize(of, factor * first, method="Nelder-Mead", options=SETTINGS) for factor in START_FACTORS]
        return np.asarray(np.abs(min(found, key=lambda one: float(one.fun)).x))


def simulated(family: Family, values: Sequence[FloatArray]) -> FloatArray:
    """The misfit of the simulation at each of several free values, plus ON_RAMP for each maximum that is on a ramp."""
    maps = [family.maps(each) for each in values]
    errors, shares, on_ramps = {}, [], np.zeros(len(maps))
    for name, axis in gantry.AXES.items():
        steady, ramp, rms = by_part(axis, [each[name] for each in maps], family.error_difference)
        errors[name] = np.stack([np.maximum(steady, ramp), rms], axis=-1)
        on_ramps += np.count_nonzero(ramp > steady, axis=1)
        shares.append([gantry.share_of_bound(axis, each[name]) for each in maps])
    return misfit(log_ratios(errors), np.array(shares)) + ON_RAMP * on_ramps


def by_part(
    axis: gantry.GantryAxis, maps: Sequence[CoggingModel], error_difference: bool
) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Of C1, C2, C3 on each map the largest error where x_d does not accelerate, where it does, and the rms, m."""
    motion = gantry.reference(axis)
    time = np.arange(round(motion.end * gantry.SAMPLE_RATE) + 1) / gantry.SAMPLE_RATE
    wanted, _, acceleration = motion.sample(time)
    late = time >= motion.end - motion.period
    found = []
    for name in gantry.CONTROLLERS:
        controller = Dcarc(gantry.controller_parameters(axis, name, error_difference=error_difference))
        machines = [gantry.plant(axis, each) for each in maps]
        runs = closed_loop_batch(machines, [controller] * len(maps), motion, columns=("position",)).columns["position"]
        rows = late[: len(runs[0])]
        errors = np.abs(np.array([run[rows] for run in runs]) - wanted[: len(runs[0])][rows])
        ramp = acceleration[: len(runs[0])][rows] != 0.0
        found.append([errors[:, ~ramp].max(axis=1), errors[:, ramp].max(axis=1), np.sqrt((errors**2).mean(axis=1))])
    steady, ramps, rms = np.array(found).transpose(1, 2, 0)
    return steady, ramps, rms


def neighbours(values: FloatArray) -> list[FloatArray]:
    """A step up and down in each value, to three digits."""
    found = []
    for (place, value), sign in itertools.product(enumerate(values), (-1.0, 1.0)):
        found.append(np.array(values))
        found[-1][place] = round_to_digits(max(0.0, value + sign * max(STEP * value, STEP_LEAST)), 3)
    return found


def polished(family: Family, values: FloatArray) -> FloatArray:
    """The free values (V) from which no step lowers the misfit of the simulation, beginning at some."""
    values = np.array([round_to_digits(value, 3) for value in values])
    least = float(simulated(family, [values])[0])
    while True:
        tried = neighbours(values)
        misfits = simulated(family, tried)
        if misfits.min() >= least:
            return values
        values, least = tried[int(misfits.argmin())], float(misfits.min())


class Cell(NamedTuple):
    """A family fitted to all numbers, in the linear answers: how many come within 15 %, of them maxima, the worst."""

    family: Family
    near: int
    maxima: int
    worst: float


def grid(show: Callable[[str], None]) -> list[Cell]:
    """Fit every cell of GRID and print it."""
    answers = {
        reading: {name: Responses(axis, reading, EVERY[name]) for name, axis in gantry.AXES.items()}
        for reading in (True, False)
    }
    found = []
    show(
        f"{'e_diff':<8}{'decay':>6}{'waves':>6}{'begin':>7}  {'sharing':<36}{'free':>5}{'near':>5}{'maxima':>7}{'worst':>7}"
    )
    for choice in itertools.product(*GRID.values()):
        family = Family(*choice)
        surrogate = Surrogate(family, answers[family.error_difference])
        values = surrogate.fit()
        off = np.abs(np.expm1(surrogate.gaps(values[:, None])[0][0]))
        cell = Cell(family, int((off <= NEAR).sum()), int((off[::2] <= NEAR).sum()), float(off.max()))
        found.append(cell)
        show(
            f"{family.error_difference!s:<8}{family.decay:>6.1f}{family.half_waves:>6.0f}{family.begin:>7.2f}  "
            f"{family.sharing:<36}{len(family.free):>5}{cell.near:>5}{cell.maxima:>7}{cell.worst:>7.2f}   "
            + " ".join(f"{value:.3f}" for value in values)
        )
    return found


def main(_: str = "", show: Callable[[str], None] = print) -> None:
    """Print every cell, and of each reading of e' and sharing how many bring 11 of 12 within 15 %, and the best."""
    found = grid(show)
    for reading, sharing in itertools.product((True, False), SHARINGS):
        cells = [cell for cell in found if (cell.family.error_difference, cell.family.sharing) == (reading, sharing)]
        best = max(cells, key=lambda cell: (cell.near, -cell.worst))
        enough = sum(cell.near >= ENOUGH for cell in cells)
        show(
            f"e_diff {reading!s:<6}{sharing:<36}{len(best.family.free)} free, {enough:>2} of {len(cells)} cells bring "
            f"{ENOUGH}; best {best.near}, worst number off by {best.worst:.0%}: {best.family.shape}"
        )


if __name__ == "__main__":
    sys.exit(run_study(__doc__, main))
