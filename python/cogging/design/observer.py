"""Observer gains with a certificate: Theorem 3 of Malaize and Levine 2009 as a design problem.

As printed the theorem has no minimum: with a noise-free position gamma_o falls to zero while the gains grow without
bound. A bound r on the poles, the disk |s| <= r at both velocities, makes it one; it is solved in the time unit 1/r.
"""

from __future__ import annotations

import importlib
import warnings
from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from cogging._core import ObserverBasedParameters
from cogging.arrays import FloatArray
from cogging.calls import Kind, check_arguments, check_constructor
from cogging.resources import on_one_blas_thread
from cogging.values import ByValue, brief

# By how much the solver is asked to keep the inequalities, so that they hold in truth. Tried in turn: what stops it for
# one of them (it is near the end of double precision there) often does not for the next.
MARGINS = (1e-5, 1e-6, 1e-4)
POSITIVE = ("omega", "damping", "pole_radius")
POLE_GRID = 41  # velocities at which the frozen poles are looked at


@dataclass(frozen=True, eq=False, repr=False)
class ObserverDesign(ByValue):
    """Gains of an ObserverBased controller, and what is certain about them.

    Attributes:
        observer_gain: K of (6) at |nu*| = 0, (2 N + 3,), for ObserverBasedParameters.
        observer_gain_slope: by which K grows with |nu*|, (2 N + 3,), or empty.
        position_gain, velocity_gain: L of (8), 1/s^2 and 1/s.
        gamma_c: H_infinity norm of H(s - alpha) (section IV.C), s.
        gamma_o: of (15), certified, s.
        gamma_n: the bound (16) on sqrt(sum (lambda_n / P_n)^2), 1/s^2.
        lambda_equal: the largest lambda_n when all are equal, gamma_n / sqrt(sum P_n^-2), m/s^2.
        lambda_alone: the largest lambda of one period alone, gamma_n min P_n, m/s^2.
        condition: number of the Lyapunov matrix.
        inequality_margin: the largest eigenvalue of the inequalities at both velocities; below 0 certifies.
        slowest_pole: largest real part of the frozen poles over the velocities, 1/s.
        slowest_pole_at_rest: the same of position, velocity and lambda_0 alone, the harmonics frozen, 1/s.
    """

    observer_gain: FloatArray
    observer_gain_slope: FloatArray
    position_gain: float
    velocity_gain: float
    gamma_c: float
    gamma_o: float
    gamma_n: float
    lambda_equal: float
    lambda_alone: float
    condition: float
    inequality_margin: float
    slowest_pole: float
    slowest_pole_at_rest: float

    def _brief(self) -> str:
        harmonics = (len(self.observer_gain) - 3) // 2
        return f"{harmonics} periods, lambda* {self.lambda_equal:.4g} m/s^2, slowest pole {self.slowest_pole:.4g} 1/s"


@check_constructor
@dataclass(frozen=True, eq=False, repr=False)
class ObserverProblem(ByValue):
    """What the observer is designed for.

    Attributes:
        periods: P_n, m.
        velocity_min, velocity_max: range of |nu*| in which the harmonics are corrected, m/s; the first above 0.
        viscous: mu of (1), 1/s.
        omega, damping: of the position loop s^2 + 2 damping omega s + omega^2 (section IV.C), 1/s and 1.
        decay_rate: alpha, 1/s.
        pole_radius: r, 1/s.
        affine: let K grow with |nu*|.

    Raises:
        ValueError: a period <= 0 or none, velocity_min <= 0 or >= velocity_max, decay_rate < 0 or not below omega's
            slowest pole, another number that is not above 0.

    Example:
        >>> cogging.ObserverProblem(periods=[0.05, 0.025], velocity_min=0.05, velocity_max=0.4)
        ObserverProblem(periods [0.05, 0.025] m, 0.05 to 0.4 m/s, omega 120 1/s, decay_rate 3 1/s)
    """

    periods: Sequence[float]
    velocity_min: float
    velocity_max: float
    viscous: float = 0.0
    omega: float = 120.0
    damping: float = 1.0
    decay_rate: float = 3.0
    pole_radius: float = 500.0
    affine: bool = False

    def __post_init__(self) -> None:
        rest = "must be above 0: at rest zeta is not observable, and no gain is feasible"
        above = f"must be above velocity_min = {self.velocity_min:g}"
        rules: list[tuple[str, float, bool, str]] = [
            *(("periods", period, period > 0, "each must be above 0") for period in self.periods),
            ("velocity_min", self.velocity_min, self.velocity_min > 0, rest),
            ("velocity_max", self.velocity_max, self.velocity_max > self.velocity_min, above),
            ("viscous", self.viscous, self.viscous >= 0, "must be at least 0"),
            *((name, getattr(self, name), getattr(self, name) > 0, "must be above 0") for name in POSITIVE),
        ]
        if not len(self.periods):
            raise ValueError("periods: must list at least one, got none")
        for name, value, holds, rule in rules:
            if not (holds and np.isfinite(value)):
                raise ValueError(f"{name}: {rule}, got {value}")
        if not 0 <= self.decay_rate < self.slowest:
            below = f"must be below {self.slowest:g} 1/s, the position loop's slowest pole"
            rule = below if self.decay_rate >= 0 else "must be at least 0"
            raise ValueError(f"decay_rate: {rule}, got {self.decay_rate}")

    @property
    def slowest(self) -> float:
        """Decay rate of the position loop's slowest pole, 1/s."""
        return -float(np.roots([1.0, 2 * self.damping * self.omega, self.omega**2]).real.max())

    @property
    def velocity_gain(self) -> float:
        """Gain of the position loop on the velocity, 1/s."""
        return 2 * self.damping * self.omega - self.viscous

    def _brief(self) -> str:
        return (
            f"periods {brief(list(self.periods), 'm')}, {self.velocity_min:g} to {self.velocity_max:g} m/s, "
            f"omega {self.omega:g} 1/s, decay_rate {self.decay_rate:g} 1/s"
        )

    def controller_parameters(self, observer_gain: Sequence[float], **fields: Any) -> ObserverBasedParameters:
        """Return the parameters of ObserverBased with this K; the harmonics freeze below velocity_max / 100.

        fields: further ones, as `sample_rate` (Hz) and `mass` (V/(m/s^2)), or others in place of these.
        """
        lists: dict[str, Any] = {"periods": list(self.periods), "observer_gain": list(observer_gain)}
        gains = {"position_gain": self.omega**2, "velocity_gain": self.velocity_gain, "viscous": self.viscous}
        return ObserverBasedParameters(**{**lists, **gains, "velocity_min": 0.01 * self.velocity_max, **fields})

    def closed_loop_norm(self) -> float:
        """gamma_c = ||H(s - alpha)||_infinity, H(s) = s / (s^2 + 2 damping omega s + omega^2) (section IV.C), s."""
        scale = self.omega * np.concatenate([[0.0], np.logspace(-4, 3, 20_001)])
        s = 1j * scale - self.decay_rate
        return float(np.abs(s / (s**2 + 2 * self.damping * self.omega * s + self.omega**2)).max())

    def matrices(self, velocity: float) -> tuple[FloatArray, FloatArray, FloatArray, FloatArray]:
        """A(nu*), C, C_o, B_o of (5), (9), (11) in the time unit 1/r, where z_o is r^2 and u_o r^3 times smaller."""
        size, r = 3 + 2 * len(self.periods), self.pole_radius
        a = np.zeros((size, size))
        a[0, 1], a[1, 1], a[1, 2] = 1.0, -self.viscous / r, 1.0
        for n, period in enumerate(self.periods):
            i, w = 3 + 2 * n, 2 * np.pi * velocity / (period * r)
            a[1, i], a[i, i + 1], a[i + 1, i] = 1.0, w, -w
        c, c_o, b_o = np.zeros((1, size)), np.zeros((1, size)), np.zeros((size, size - 3))
        c[0, 0] = 1.0
        c_o[0, 1], c_o[0, 2], c_o[0, 3::2] = self.velocity_gain / r, 1.0, 1.0
        b_o[3:] = np.eye(size - 3)  # the first row of M_N is zero: lambda_0 is not driven
        return a, c, c_o, b_o


@check_arguments(problem=Kind((ObserverProblem,), "an ObserverProblem"))
@on_one_blas_thread(scipy=True)
def design_observer(problem: ObserverProblem) -> ObserverDesign:
    """Find the gain K with the smallest gamma_o (Theorem 3 with the pole disk), and certify it by eigenvalues.

    Args:
        problem: periods, velocities, position loop, decay rate and pole radius.

    Returns:
        The gains and what is certain about them.

    Raises:
        ValueError: no gain is feasible; offers the largest feasible decay rate.
        ImportError: cvxpy is not installed; names the extra.

    Example:
        >>> problem = cogging.ObserverProblem(periods=[0.05], velocity_min=0.05, velocity_max=0.2)
        >>> design = cogging.design_observer(problem)
        >>> bool(design.inequality_margin < 0.0 and design.slowest_pole < -problem.decay_rate)
        True
    """
    design = _solve(problem)
    if design is not None:
        return design
    largest = largest_decay_rate(problem)
    if largest >= problem.decay_rate:
        rule = "must be smaller for the solver to certify a gain in double precision"
        raise ValueError(f"pole_radius: {rule}, got {problem.pole_radius:g}")
    rule = f"must be at most {largest:.3g} 1/s for these velocities and this pole_radius"
    raise ValueError(f"decay_rate: {rule}, got {problem.decay_rate:g}")


def largest_decay_rate(problem: ObserverProblem) -> float:
    """The largest alpha (1/s) for which a gain was found, to 2 %; 0 if there is none."""
    low, high = 0.0, 0.999 * problem.slowest
    while high - low > max(0.02 * high, 1e-3):
        middle = 0.5 * (low + high)
        is_found = _solve(replace(problem, decay_rate=middle)) is not None
        low, high = (middle, high) if is_found else (low, middle)
    return low


def _solve(problem: ObserverProblem) -> ObserverDesign | None:
    """Solve the inequalities, kept by a margin, for the smallest gamma_o; None if no solution is certified."""
    try:
        cp: Any = importlib.import_module("cvxpy")
    except ImportError:
        raise ImportError("cvxpy is not installed: pip install 'cogging[design]'") from None
    size = 3 + 2 * len(problem.periods)
    for margin in MARGINS:
        p, gamma_square = cp.Variable((size, size), symmetric=True), cp.Variable()
        q = [cp.Variable((size, 1)) for _ in range(2)] if problem.affine else [cp.Variable((size, 1))] * 2
        constraints = [p >> margin * np.eye(size)]
        for matrix in inequalities(problem, p, q, gamma_square, cp.bmat):
            constraints.append(-(matrix + matrix.T) / 2 >> margin * np.eye(matrix.shape[0]))
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")  # an inaccurate solution is judged below, by its eigenvalues
            try:
                cp.Problem(cp.Minimize(gamma_square), constraints).solve(solver=cp.CLARABEL)
            except cp.error.SolverError:
                continue
        values = [variable.value for variable in (p, *q)]
        if all(value is not None for value in values):
            design = _check(problem, values[0], values[1:], float(gamma_square.value))
            if design is not None:
                return design
    return None


def inequalities(problem: ObserverProblem, p: Any, gains: Sequence[Any], gamma_square: Any, block: Any) -> list[Any]:
    """The matrices of (15) and of the pole disk at both velocities, which must be negative.

    `p`, `gains` (P K at both velocities) and `gamma_square` (in the time unit 1/r) are variables of cvxpy or arrays;
    `block` makes a matrix of blocks of them (cvxpy.bmat or numpy.block).
    """
    alpha, found = problem.decay_rate / problem.pole_radius, []
    for velocity, gain in zip((problem.velocity_min, problem.velocity_max), gains, strict=True):
        a, c, c_o, b_o = problem.matrices(velocity)
        closed = p @ a - gain @ c
        corner = closed + closed.T + c_o.T @ c_o + 2 * alpha * p
        found.append(block([[corner, p @ b_o], [b_o.T @ p, -gamma_square * np.eye(b_o.shape[1])]]))
        found.append(block([[-p, closed], [closed.T, -p]]))
    return found


def _check(problem: ObserverProblem, p: FloatArray, q: list[FloatArray], gamma_square: float) -> ObserverDesign | None:
    """Check a solution by eigenvalues; None if one inequality or the frozen poles fail."""
    if np.linalg.eigvalsh(p).min() <= 0 or gamma_square <= 0:
        return None
    margin = max(np.linalg.eigvalsh(m).max() for m in inequalities(problem, p, q, gamma_square, np.block))
    r = problem.pole_radius
    units = np.array([r, r**2] + [r**3] * (p.shape[0] - 2))
    low, high = (np.linalg.solve(p, gain)[:, 0] * units for gain in q)
    slope = (high - low) / (problem.velocity_max - problem.velocity_min)
    at_rest = low - slope * problem.velocity_min

    def poles(velocity: float, states: int) -> float:
        a, c, _, _ = problem.matrices(velocity)
        gain = (at_rest + slope * velocity) / units
        return r * float(np.linalg.eigvals((a - np.outer(gain, c[0]))[:states, :states]).real.max())

    grid = np.linspace(problem.velocity_min, problem.velocity_max, POLE_GRID)
    slowest = max(poles(float(velocity), p.shape[0]) for velocity in grid)
    if margin >= 0 or slowest > -problem.decay_rate:
        return None
    gamma_c, gamma_o = problem.closed_loop_norm(), np.sqrt(gamma_square) / r
    gamma_n = 1.0 / (2 * np.pi * gamma_c * gamma_o)
    inverse = 1.0 / np.asarray(problem.periods)
    return ObserverDesign(
        observer_gain=at_rest,
        observer_gain_slope=slope if problem.affine else np.empty(0),
        position_gain=problem.omega**2,
        velocity_gain=problem.velocity_gain,
        gamma_c=gamma_c,
        gamma_o=float(gamma_o),
        gamma_n=float(gamma_n),
        lambda_equal=float(gamma_n / np.sqrt(np.sum(inverse**2))),
        lambda_alone=float(gamma_n / inverse.max()),
        condition=float(np.linalg.cond(p)),
        inequality_margin=float(margin),
        slowest_pole=slowest,
        slowest_pole_at_rest=poles(0.0, 3),
    )
