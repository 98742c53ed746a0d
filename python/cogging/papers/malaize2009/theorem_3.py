"""Theorem 3 of Malaize and Levine 2009 as printed, beside the one with bounded poles (extra `design`).

As printed it has no minimum: gamma_o falls towards zero while the gains grow. Its solution is the same in every unit of
time, but what a solver gives is not: it stops where its tolerance ends, which moves with the unit. With nu* = 0 in the
range of velocities it is not feasible.
"""

from __future__ import annotations

import importlib.util
import warnings
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
    """What a solver gives for the printed problem.

    Attributes:
        status: as the solver calls it; "failed" where it gives up.
        gain: K, (2 N + 3,), in 1/s, 1/s^2 and 1/s^3; empty where there is no solution.
        lambda_equal: m/s^2, that (16) allows when all lambda_n are equal; likewise nan, as what follows.
        condition: number of P.
        fastest_pole: largest size of the frozen poles at both ends of the range, 1/s.
        slowest_pole: largest real part of these, 1/s; below -alpha for what is a solution.
    """

    status: str
    gain: FloatArray
    lambda_equal: float = np.nan
    condition: float = np.nan
    fastest_pole: float = np.nan
    slowest_pole: float = np.nan


def as_printed(task: ObserverProblem, rate: float, *, from_rest: bool = False) -> Solution:
    """Solve Theorem 3 as it is printed, B_o with its 2 N + 1 columns and no bound on the poles.

    Args:
        task: periods, velocities, position loop and decay rate; its pole radius counts for nothing.
        rate: 1/s, one over the unit of time in which the problem is given to the solver.
        from_rest: whether the range of velocities begins at 0.

    Raises:
        ImportError: cvxpy is not there.
    """
    cp: Any = importlib.import_module("cvxpy")
    task = replace(task, pole_radius=rate)
    ends = (0.0 if from_rest else task.velocity_min, task.velocity_max)
    vertices = [task.matrices(velocity)[0] for velocity in ends]
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
        warnings.simplefilter("ignore")  # that it is inaccurate is in the status
        try:
            given.solve(solver=cp.CLARABEL)
        except cp.error.SolverError:
            return Solution("failed", np.empty(0))
    if p.value is None or not square.value > 0.0:
        return Solution(given.status, np.empty(0))
    return _solution(task, given.status, vertices, p.value, q.value, float(square.value))


def _solution(
    task: ObserverProblem, status: str, vertices: list[FloatArray], p: FloatArray, q: FloatArray, square: float
) -> Solution:
    rate, inverse = task.pole_radius, 1.0 / np.asarray(task.periods)
    gain = np.linalg.solve(p, q)[:, 0]
    first = np.eye(gain.size)[0]
    poles = rate * np.concatenate([np.linalg.eigvals(a - np.outer(gain, first)) for a in vertices])
    bound = rate / (2.0 * np.pi * task.closed_loop_norm() * np.sqrt(square))
    return Solution(
        status,
        gain * np.array([rate, rate**2] + [rate**3] * (gain.size - 2)),
        float(bound / np.sqrt(np.sum(inverse**2))),
        float(np.linalg.cond(p)),
        float(np.abs(poles).max()),
        float(poles.real.max()),
    )


def unobserved(task: ObserverProblem, velocity: float) -> int:
    """How many of the 2 N + 3 states the position does not show at a constant velocity (m/s).

    At rest these are 2 N, and Theorem 3 is not feasible there, whatever alpha >= 0 is: for a cosine's state e,
    A(0) e = 0, C e = 0 and C_o e = 0, so that the block of (15) holds 2 alpha P_ee >= 0 on its diagonal where B_o gives
    it P_ee > 0 beside it, and is not negative semidefinite.
    """
    a, c, _, _ = task.matrices(velocity)
    rows = [c]
    for _ in range(c.size - 1):
        rows.append(rows[-1] @ a)
    return int(c.size - np.linalg.matrix_rank(np.vstack([row / np.linalg.norm(row) for row in rows]), tol=1e-9))


def theorem_3() -> Table:
    """What Theorem 3 gives for the ironcore motor: printed and with bounded poles; not in the paper.

    Raises:
        ImportError: cvxpy is not there.
    """
    motor = MOTORS["ironcore"]
    task = problem(motor, RADII[0])
    rows = []
    for rate in RATES:
        found = as_printed(task, rate)
        label = {"unit of time": f"{1.0 / rate:g} s", "solver": found.status}
        rows += _rows("as printed", label, found.lambda_equal, found.gain, found.condition, found.fastest_pole)
    for radius in RADII:
        design = design_observer(replace(task, pole_radius=radius))
        vertices = [replace(task, pole_radius=1.0).matrices(v)[0] for v in (task.velocity_min, task.velocity_max)]
        fastest = _fastest(vertices, design.observer_gain)
        label = {"radius": f"{radius:g} 1/s", "solver": "certified"}
        rows += _rows("poles bounded", label, design.lambda_equal, design.observer_gain, design.condition, fastest)
    for alpha in (task.decay_rate, 0.0):
        status = as_printed(replace(task, decay_rate=alpha), RATES[1], from_rest=True).status
        label = {"velocity_min": "0 m/s", "alpha": f"{alpha:g} 1/s", "solver": status}
        rows.append(explored("as printed", "unobserved", "1", unobserved(task, 0.0), label))
    return Table("theorem_3", "Theorem 3 (ironcore): no minimum as printed, none at all from rest on", rows)


def further_tables() -> tuple[list[Table], list[str]]:
    """The table of Theorem 3; without cvxpy none, and a note that names the extra."""
    if importlib.util.find_spec("cvxpy") is None:
        return [], ["The table of Theorem 3 is left out: it needs cvxpy, pip install 'cogging[design]'."]
    return [theorem_3()], []


def _fastest(vertices: list[FloatArray], gain: FloatArray) -> float:
    first = np.eye(gain.size)[0]
    return float(max(np.abs(np.linalg.eigvals(a - np.outer(gain, first))).max() for a in vertices))


def _rows(
    name: str, label: dict[str, str], bound: float, gain: FloatArray, condition: float, fastest: float
) -> list[Row]:
    if not gain.size:
        return []
    largest = float(np.abs(gain[2:]).max())
    numbers = [("lambda_star", "m/s^2", bound), ("largest_gain", "1/s^3", largest)]
    numbers += [("condition", "1", condition), ("fastest_pole", "1/s", fastest)]
    return [explored(name, index, unit, value, label) for index, unit, value in numbers]
