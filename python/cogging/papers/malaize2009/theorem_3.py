"""Theorem 3 of Malaize and Levine 2009 as printed, beside the one with bounded poles (extra `design`).

As printed it has no minimum: gamma_o falls towards zero while the gains grow. Its solution is the same in every unit of
time, but a solver's is not: it stops at its tolerance, which depends on the unit. With nu* = 0 in the range of
velocities the problem is not feasible.
"""

from __future__ import annotations

import importlib
import importlib.util
import warnings
from collections.abc import Iterable
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from cogging.arrays import FloatArray
from cogging.design.observer import ObserverProblem, design_observer
from cogging.papers.malaize2009.linear_motors import MOTORS, problem
from cogging.papers.result import Row, Table, explored

RATES = (1.0, 10.0, 100.0)  # 1/s: of the units of time in which the printed problem is given to the solver
RADII = (350.0, 500.0, 1000.0)  # 1/s: bounds on the poles


@dataclass(frozen=True)
class Solution:
    """A solver's answer to the printed problem; NaN and an empty gain if there is none."""

    status: str  # the solver's; "failed" if it gives up
    gain: FloatArray  # K, (2 N + 3,), in 1/s, 1/s^2 and 1/s^3
    lambda_equal: float = np.nan  # m/s^2, that (16) allows when all lambda_n are equal
    condition: float = np.nan  # number of P
    poles: FloatArray | float = np.nan  # 1/s, frozen at both ends of the range


def as_printed(task: ObserverProblem, rate: float, *, from_rest: bool = False) -> Solution:
    """Solve Theorem 3 as printed, without a bound on the poles, in a unit of time of 1 / rate (s) (needs cvxpy)."""
    cp: Any = importlib.import_module("cvxpy")
    task = replace(task, pole_radius=rate)
    vertices = [task.matrices(velocity)[0] for velocity in (0.0 if from_rest else task.velocity_min, task.velocity_max)]
    _, c, c_o, _ = task.matrices(task.velocity_max)
    size, alpha = c.size, task.decay_rate / rate
    b_o = np.eye(size)[:, 2:]
    p, q, square = cp.Variable((size, size), symmetric=True), cp.Variable((size, 1)), cp.Variable()
    constraints = [p >> 0]
    for a in vertices:
        corner = a.T @ p + p @ a - c.T @ q.T - q @ c + c_o.T @ c_o + 2.0 * alpha * p
        block = cp.bmat([[corner, p @ b_o], [b_o.T @ p, -square * np.eye(size - 2)]])
        constraints.append(-0.5 * (block + block.T) >> 0)
    given = cp.Problem(cp.Minimize(square), constraints)
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")  # the status reports an inaccurate solution
        try:
            given.solve(solver=cp.CLARABEL)
        except cp.error.SolverError:
            return Solution("failed", np.empty(0))
    if p.value is None or not square.value > 0.0:
        return Solution(given.status, np.empty(0))
    gain = np.linalg.solve(p.value, q.value)[:, 0]
    bound = rate / (2.0 * np.pi * task.closed_loop_norm() * np.sqrt(float(square.value)))
    equal = float(bound / np.sqrt(np.sum((1.0 / np.asarray(task.periods)) ** 2)))
    in_seconds = gain * np.array([rate, rate**2] + [rate**3] * (size - 2))
    return Solution(given.status, in_seconds, equal, float(np.linalg.cond(p.value)), rate * _poles(vertices, gain))


def _poles(vertices: Iterable[FloatArray], gain: FloatArray) -> FloatArray:
    """Return the poles of the observer at frozen velocities, those of a vertex after another."""
    first = np.eye(gain.size)[0]
    return np.concatenate([np.linalg.eigvals(a - np.outer(gain, first)) for a in vertices])


def unobserved(task: ObserverProblem, velocity: float) -> int:
    """Return how many of the 2 N + 3 states are unobservable from the position at a constant velocity (m/s).

    At rest 2 N, so that Theorem 3 is not feasible: for a cosine's state e, A(0) e = 0, C e = 0 and C_o e = 0, so that
    (15) has 2 alpha P_ee >= 0 on its diagonal and P_ee > 0 beside it by B_o, and is not negative semidefinite.
    """
    a, c, _, _ = task.matrices(velocity)
    rows = [c]
    for _ in range(c.size - 1):
        rows.append(rows[-1] @ a)
    return int(c.size - np.linalg.matrix_rank(np.vstack([row / np.linalg.norm(row) for row in rows]), tol=1e-9))


def theorem_3() -> Table:
    """Tabulate Theorem 3 for the ironcore motor, printed and with bounded poles; not in the paper (needs cvxpy)."""
    task = problem(MOTORS["ironcore"], RADII[0])
    rows: list[Row] = []
    for rate in RATES:
        found = as_printed(task, rate)
        label = {"unit of time": f"{1.0 / rate:g} s", "solver": found.status}
        rows += _rows("as printed", label, found)
    for radius in RADII:
        design = design_observer(replace(task, pole_radius=radius))
        vertices = [replace(task, pole_radius=1.0).matrices(v)[0] for v in (task.velocity_min, task.velocity_max)]
        gain = design.observer_gain
        found = Solution("certified", gain, design.lambda_equal, design.condition, _poles(vertices, gain))
        rows += _rows("poles bounded", {"radius": f"{radius:g} 1/s", "solver": found.status}, found)
    for alpha in (task.decay_rate, 0.0):
        status = as_printed(replace(task, decay_rate=alpha), RATES[1], from_rest=True).status
        label = {"velocity_min": "0 m/s", "alpha": f"{alpha:g} 1/s", "solver": status}
        rows.append(explored("as printed", "unobserved", "1", unobserved(task, 0.0), **label))
    return Table("theorem_3", "Theorem 3 (ironcore): no minimum as printed, none at all from rest on", rows)


def further_tables() -> tuple[list[Table], list[str]]:
    """Return the table of Theorem 3; without cvxpy none, and a note that names the extra."""
    if importlib.util.find_spec("cvxpy") is None:
        return [], ["The table of Theorem 3 is left out: it needs cvxpy, pip install 'cogging[design]'."]
    return [theorem_3()], []


def _rows(name: str, label: dict[str, str], found: Solution) -> list[Row]:
    if not found.gain.size:
        return []
    return [
        explored(name, "lambda_star", "m/s^2", found.lambda_equal, **label),
        explored(name, "largest_gain", "1/s^3", np.abs(found.gain[2:]).max(), **label),
        explored(name, "condition", "1", found.condition, **label),
        explored(name, "fastest_pole", "1/s", np.abs(found.poles).max(), **label),
    ]
