"""Fits the unreported conditions of Xu and Yao 2001 to chosen numbers of their Table 1."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from cogging._core import DivergedError
from cogging.arrays import FloatArray
from cogging.papers.fitting import fit_logarithms, round_to_digits
from cogging.papers.xu2001.conditions import JOINT_LAW, LAWS, Conditions
from cogging.papers.xu2001.setup import (
    CONTROLLERS,
    INDEXES,
    SEEDS,
    TABLE_1,
    Unknowns,
    to_dict,
)

#: du_rms = c_u u_rms is printed to one digit and takes no part.
FITTED = ("e_M", "e_F", "e_rms", "u_rms", "c_u")
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


@dataclass(frozen=True)
class Problem:
    """What is fitted to what.

    Attributes:
        fitted: the sets of each controller whose numbers take part.
        law: of friction, one of LAWS.
        start: where the search begins, by name; with `adaptation_factor` where that is free.
        adaptation_factor: where it is not free.
        earlier_runs: of the ARC.
        changes: of the ARC's printed numbers, by field.
        iterations: at most, with long and with short steps.
        seeds: of the encoder noise; what is fitted is the mean over them.
    """

    fitted: Mapping[str, Sequence[str]]
    law: str = JOINT_LAW
    start: Mapping[str, float] = field(default_factory=lambda: START)
    adaptation_factor: float = 1.0
    earlier_runs: int = 0
    changes: Mapping[str, Any] = field(default_factory=dict)
    iterations: tuple[int, int] = (12, 8)
    seeds: Sequence[int] = SEEDS

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
    """The conditions that a fit found.

    Attributes:
        conditions: the best.
        gap: their log-ratios simulated / printed, one for each number that took part.
        errors: the rms log-ratio of every start, best first.
    """

    conditions: Conditions
    gap: FloatArray
    errors: Sequence[float]

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
        return {**found, "unknowns": to_dict(self.conditions.unknowns)}


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
    return to_dict(conditions.unknowns) | {"adaptation_factor": conditions.adaptation_factor}
