"""Calibrates what Xu and Yao 2001 do not report: `python -m studies.xu2001.calibration [FILE]`.

Everything is fitted to e_M, e_F, e_rms, u_rms, c_u of Table 1, in some 15 minutes of one core, and comes with the
package as plant.toml, each fit with the error that it left:

- by friction law: the plant, on the 15 numbers of the PID at one seed of the encoder noise;
- `joint`: plant and a common factor on the adaptation rates, by model of the plant, on the means of all 30 numbers
  over eight seeds;
- `earlier_runs`, `readings`: the same with other numbers of earlier runs, and with what the printed rates may mean;
- `held_out`: the same on a part of the numbers, the others being left to predict.
"""

from __future__ import annotations

import sys
from collections.abc import Mapping, Sequence
from dataclasses import asdict, dataclass, field, replace
from typing import Any

import numpy as np

from cogging._core import DivergedError
from cogging.arrays import FloatArray
from cogging.outputs import to_toml
from cogging.papers.xu2001.epoxy_motor import (
    ALL,
    CONTROLLERS,
    FITTED,
    HELD_OUT,
    INDEXES,
    JOINT_LAW,
    PID,
    SEED,
    SEEDS,
    TABLE_1,
    Conditions,
    Unknowns,
)
from studies.command import run_calibration
from studies.fitting import fit_logarithms, round_to_digits

_FITTED = [INDEXES.index(index) for index in FITTED]
#: Where the search begins: what an earlier one had found for smooth_stribeck on the PID columns, rounded.
START = {
    "coulomb": 0.154,
    "coulomb_width": 1.7e-3,
    "static_excess": 0.0194,
    "stribeck_velocity": 0.011,
    "offset": 0.0106,
    "delay": 3.73e-4,
    "encoder_noise": 0.368e-6,
    "ripple": 0.0783,
    "ripple_period": 0.0419,
}
PID_STARTS = 8
EARLIER_RUNS = 2  # of 0 to 3 the number that comes nearest: `earlier_runs` of plant.toml
#: Where the joint search begins: what an earlier one had found at one seed, rounded. Held-out fits, which may not know
#: that, begin where the plant's does, with the adaptation as printed.
JOINT_START = {
    "coulomb": 0.135,
    "coulomb_width": 1e-3,
    "static_excess": 0.02,
    "stribeck_velocity": 0.0077,
    "offset": 0.005,
    "delay": 3.6e-4,
    "encoder_noise": 0.39e-6,
    "ripple": 0.112,
    "ripple_period": 0.0525,
    "adaptation_factor": 2.9,
}
HELD_OUT_START = START | {"adaptation_factor": 1.0}
#: Readings of the printed numbers that would make the adaptation as fast as the joint fit has it: the factor on Gamma
#: and what else is changed. All else is fitted to the 30 numbers.
READINGS: dict[str, tuple[float, Mapping[str, Any]]] = {
    "Gamma as printed": (1.0, {}),
    "Gamma x 2.5: steps of 1 ms in a loop of 0.4 ms": (2.5, {}),
    "Gamma x 3.7: 1/M of set 1 over that of set 2": (3.7, {}),
    "w_2 = 0.3 for 0.1": (1.0, {"weight_2": 0.3}),
}
MOST_EARLIER_RUNS = 3
BRIEFLY = (1, 0)  # iterations of the fits that begin where another ended
#: Models of the plant and their fixed values; 0 removes an effect. A model is nested in those that fix less.
LAWS: dict[str, dict[str, float]] = {
    "smooth_stribeck": {},
    "smooth_coulomb": {"static_excess": 0.0, "stribeck_velocity": 0.01},
    "smooth_coulomb_without_offset": {"static_excess": 0.0, "stribeck_velocity": 0.01, "offset": 0.0},
    "exact_stribeck": {"coulomb_width": 0.0},
    "exact_coulomb": {"coulomb_width": 0.0, "static_excess": 0.0, "stribeck_velocity": 0.01},
}


@dataclass(frozen=True)
class Problem:
    """What is fitted to what."""

    fitted: Mapping[str, Sequence[str]]  # the sets of each controller whose numbers take part
    law: str = JOINT_LAW  # of friction, one of LAWS
    #: Initial values by name; includes `adaptation_factor` if it is fitted.
    start: Mapping[str, float] = field(default_factory=lambda: START)
    adaptation_factor: float = 1.0  # where it is not free
    earlier_runs: int = 0  # of the ARC
    changes: Mapping[str, Any] = field(default_factory=dict)  # of the ARC's printed numbers, by field
    iterations: tuple[int, int] = (12, 8)  # at most, with long and with short steps
    seeds: Sequence[int] = SEEDS  # of the encoder noise; what is fitted is the mean over them

    def names(self) -> list[str]:
        """The free quantities."""
        return [name for name in self.start if name not in LAWS[self.law]]

    def conditions(self, values: Sequence[float] | FloatArray) -> Conditions:
        """The conditions of values in the order of names(), to the digits that the file keeps."""
        free = {name: round_to_digits(float(value)) for name, value in zip(self.names(), values, strict=True)}
        factor = free.pop("adaptation_factor", self.adaptation_factor)
        return Conditions(Unknowns(**{**LAWS[self.law], **free}), factor, self.earlier_runs, self.changes)


@dataclass(frozen=True)
class Fit:
    """The conditions that a fit found."""

    conditions: Conditions  # the best
    gap: FloatArray  # their log-ratios simulated / printed, one for each number that took part
    errors: Sequence[float]  # the rms log-ratio of every start, best first

    def to_dict(self, *, arc: bool = True) -> dict[str, Any]:
        """As plant.toml has it; without the ARC's conditions where it took no part."""
        found: dict[str, Any] = {
            "rms_log_error": round_to_digits(self.errors[0], 3),
            "largest_relative_error": round_to_digits(float(np.abs(np.expm1(self.gap)).max()), 3),
            "rms_log_error_of_starts": [round_to_digits(error, 3) for error in self.errors],
        }
        if arc:
            found["adaptation_factor"] = self.conditions.adaptation_factor
            found["earlier_runs"] = self.conditions.earlier_runs
        if self.conditions.changes:
            found["changes"] = dict(self.conditions.changes)
        return {**found, "unknowns": asdict(self.conditions.unknowns)}


def log_ratios(conditions: Conditions, fitted: Mapping[str, Sequence[str]], seeds: Sequence[int] = SEEDS) -> FloatArray:
    """Logarithms of simulated / printed for the fitted indexes of the sets of each controller, (numbers,)."""
    found = [
        conditions.by_seed(name, fitted[name], seeds).mean(axis=1) / [TABLE_1[name][place] for place in fitted[name]]
        for name in CONTROLLERS
        if name in fitted
    ]
    return np.asarray(np.log(np.concatenate(found)[:, _FITTED]).ravel())


def calibrate(problem: Problem, starts: int = 1, nested: Sequence[Fit] = ()) -> Fit:
    """Fit from several starts: the first as stated, the others with each quantity off by a factor of about 1.5.

    The ends of the fits of nested models are further starts, and stand for what this model reaches where its own
    searches end higher, so that no nested model has a smaller error.
    """
    numbers = len(FITTED) * sum(len(sets) for sets in problem.fitted.values())
    first = np.array([problem.start[name] for name in problem.names()])

    def gap(values: FloatArray) -> FloatArray:
        try:
            return log_ratios(problem.conditions(values), problem.fitted, problem.seeds)
        except DivergedError:
            return np.full(numbers, 5.0)  # worse than any run that ends

    begins = [
        first * np.exp(0.4 * np.random.default_rng([2001, start]).normal(size=first.size) if start else 0.0)
        for start in range(starts)
    ]
    for fit in nested:
        known = start_of(fit.conditions)
        begins.append(np.array([known.get(name) or problem.start[name] for name in problem.names()]))
    results = [(rms(fit.gap), fit.conditions, fit.gap) for fit in nested]
    for begin in begins:
        values, _ = fit_logarithms(gap, begin, step=0.03, iterations=problem.iterations[0])
        values, y = fit_logarithms(gap, values, step=0.006, iterations=problem.iterations[1])
        results.append((rms(y), problem.conditions(values), y))
    results.sort(key=lambda result: result[0])
    return Fit(results[0][1], results[0][2], [result[0] for result in results])


def rms(gap: FloatArray) -> float:
    """The rms of log-ratios."""
    return float(np.sqrt(np.mean(gap**2)))


def start_of(conditions: Conditions) -> dict[str, float]:
    """Conditions as a start, with the adaptation's factor free."""
    return asdict(conditions.unknowns) | {"adaptation_factor": conditions.adaptation_factor}


def by_model(problem: Problem, done: Mapping[str, Fit], starts: int = 1) -> dict[str, Fit]:
    """The fits of the models of the plant but JOINT_LAW, each after those that are nested in it.

    Nested are models with more of the quantities held at zero: the best of them is a further start.
    """
    found = dict(done)
    for law in sorted((law for law in LAWS if law != JOINT_LAW), key=lambda law: -len(LAWS[law])):
        nested = [fit for other, fit in found.items() if LAWS[law].items() <= LAWS[other].items()]
        nested = sorted(nested, key=lambda fit: fit.errors[0])[:1]
        found[law] = calibrate(replace(problem, law=law), starts if starts > 1 or not nested else 0, nested)
    return found


def earlier_run_fits(joint: Fit) -> dict[str, Fit]:
    """The joint fit with other numbers of earlier runs, each from the end of the shipped one."""
    others = [number for number in range(MOST_EARLIER_RUNS + 1) if number != EARLIER_RUNS]
    problem = Problem(ALL, start=start_of(joint.conditions), iterations=BRIEFLY)
    return {str(number): calibrate(replace(problem, earlier_runs=number)) for number in others}


def reading_fits(joint: Fit) -> dict[str, Fit]:
    """The joint fit under each of READINGS, from the end of the shipped one."""
    plant = {name: value for name, value in start_of(joint.conditions).items() if name != "adaptation_factor"}
    fixed = Problem(ALL, start=plant, earlier_runs=EARLIER_RUNS, iterations=BRIEFLY)
    return {name: calibrate(replace(fixed, adaptation_factor=x, changes=y)) for name, (x, y) in READINGS.items()}


def held_out_fit(split: str) -> Fit:
    """Plant, factor and number of earlier runs (0 to 2) on the numbers of a split alone, from the printed start."""
    problem = Problem(HELD_OUT[split], start=HELD_OUT_START, iterations=BRIEFLY)
    fits = [calibrate(replace(problem, earlier_runs=number)) for number in range(EARLIER_RUNS + 1)]
    best = min(fits, key=lambda fit: fit.errors[0]).conditions
    return calibrate(replace(problem, start=start_of(best), earlier_runs=best.earlier_runs, iterations=(3, 0)))


def plant_toml() -> str:
    """The text of plant.toml."""
    joint_problem = Problem(ALL, start=JOINT_START, earlier_runs=EARLIER_RUNS, iterations=(8, 4))
    joint = calibrate(joint_problem)
    plants = by_model(Problem(PID, seeds=(SEED,)), {}, PID_STARTS)
    document: dict[str, Any] = {law: fit.to_dict(arc=False) for law, fit in plants.items()}
    parts = {
        "joint": by_model(replace(joint_problem, iterations=(2, 0)), {JOINT_LAW: joint}),
        "earlier_runs": earlier_run_fits(joint),
        "readings": reading_fits(joint),
        "held_out": {split: held_out_fit(split) for split in HELD_OUT},
    }
    document |= {part: {name: fit.to_dict() for name, fit in fits.items()} for part, fits in parts.items()}
    head = "# What the paper does not report, by what it was fitted to, written by studies.xu2001.calibration.\n"
    return head + to_toml(document)


if __name__ == "__main__":
    sys.exit(run_calibration(__doc__, plant_toml, "cogging.papers.xu2001", "plant.toml"))
