"""Theorem 1 A of Lu, Chen, Yao, Wang 2008 with u_s2 switched on: what it bounds, on machines drawn at random.

ARC: M p' = u_s - phi^T theta~ + d~ (18), so with (19) and (20) the function (22), V = M p^2 / 2, has
V' <= -k_s1 p^2 + epsilon <= -lambda V + epsilon with lambda = 2 k_s1 / theta_1max, and (23) follows.

DCARC: its regressor stands on the reference, so that by (24) and (25), with F = theta_2 + theta_3 g_f,
s = theta_4b^T g_r and e' = p - k_1 e,

    M p' = M k_1 e' - k_s1 p - F e' - s e + u_s2 - phi_d^T theta~ + d~.

V = M p^2 / 2 alone does not do, because of the terms in e. With M k_1^2 e^2 / 2 beside it, whose derivative is
M k_1^2 e p - M k_1^3 e^2, the mixed terms of M cancel:

    V' = -(k_s1 - M k_1 + F) p^2 + (k_1 F - s) p e - M k_1^3 e^2 + p (u_s2 - phi_d^T theta~ + d~) <= -z^T Q z + epsilon

with z = (p, e), where Q is (29) with M k_1^3 in the lower corner: (29) keeps half of it in hand. Where Q is positive,
z^T Q z >= lambda V, lambda being its smallest eigenvalue relative to diag(M, M k_1^2) / 2, and (23) holds for this V.
The estimates appear in neither bound: they only have to stay within theirs, which (14) sees to.

The paper proves this in continuous time. Here the controllers run at 20 kHz on an ideal encoder, with e' as the
reading's difference minus the velocity of x_d; epsilon and delta_d are not reported, ours are assumed.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from cogging._core import (
    AdaptiveRobustParameters,
    Arc,
    AxisParameters,
    CoggingModel,
    Dcarc,
    Plant,
    Reference,
    desired_compensation_condition,
    friction_slope_max,
    smooth_sign,
)
from cogging.arrays import FloatArray
from cogging.effects import ConstantForce, DisturbanceStep, DisturbanceTone
from cogging.logs.log import Log
from cogging.papers.lu2008.condition import controller_basis, steepest
from cogging.papers.lu2008.setup import (
    COULOMB_WIDTH,
    START,
    TRAVEL,
    GantryAxis,
    controller_parameters,
    reference,
)
from cogging.simulation.run import closed_loop

EPSILON = 0.002  # V m/s, of (20) and (30), not reported
DISTURBANCE = 0.3  # V, delta_d of (12), not reported
SAMPLE_RATE = 20000.0  # Hz, ours, in place of continuous time
DURATION = 0.5  # s, of a run
SETTLED = 10.0  # time constants 1 / lambda after which exp(-lambda t) counts for nothing
Law = type[Arc] | type[Dcarc]
ESTIMATED = ("mass", "viscous", "coulomb", "disturbance")


@dataclass(frozen=True)
class Trial:
    """A machine within the printed bounds, a controller, and how they start.

    Attributes:
        law: Arc or Dcarc.
        plant: of ideal encoder.
        parameters: of the controller, u_s2 on.
        theta: what the machine is, in the order of the controller's estimates, (4 + coefficients,).
        motion: the reference.
        start: m and m/s.
        rate: lambda, 1/s.
    """

    law: Law
    plant: Plant
    parameters: AdaptiveRobustParameters
    theta: FloatArray
    motion: Reference
    start: tuple[float, float]
    rate: float

    def run(self, **changes: Any) -> Log:
        """The run with its estimates; `changes` are of the controller, such as epsilon=0 to leave u_s2 out."""
        return closed_loop(
            self.plant,
            self.law(self.parameters.replace(**changes)),
            self.motion,
            duration=DURATION,
            initial_position=self.start[0],
            initial_velocity=self.start[1],
            record_estimates=True,
        )

    def lyapunov(self, log: Log) -> FloatArray:
        """V of the true state, W s: of (22), for Dcarc with the term in e^2."""
        assert log.true_position is not None
        assert log.true_velocity is not None
        e = log.true_position - _known(log.reference)
        k, mass = self.parameters.error_gain, self.plant.axis.mass
        p = log.true_velocity - _known(log.reference_velocity) + k * e
        return 0.5 * mass * (p**2 + ((k * e) ** 2 if self.law is Dcarc else 0.0))

    def bound(self, log: Log, first: float) -> FloatArray:
        """The right side of (23) from a first V on."""
        gone = np.exp(-self.rate * (log.time - log.time[0]))
        return np.asarray(gone * first + EPSILON / self.rate * (1.0 - gone))

    def holds(self, log: Log) -> bool:
        """Whether V stays below the bound at every sample."""
        found = self.lyapunov(log)
        return bool((found <= self.bound(log, float(found[0])) * (1.0 + 1e-12)).all())

    def settled(self, log: Log) -> float:
        """The largest V, over epsilon / lambda, once the start is forgotten."""
        late = log.time > SETTLED / self.rate
        return float(self.lyapunov(log)[late].max() * self.rate / EPSILON)

    def settled_error(self, log: Log) -> float:
        """The largest true |e| in the second half of the run, m."""
        assert log.true_position is not None
        late = log.time > 0.5 * DURATION
        return float(np.abs(log.true_position - _known(log.reference))[late].max())

    def error_bound(self) -> float:
        """What (23) leaves of |e| in the end, m.

        V <= epsilon / lambda bounds p, and e' = p - k_1 e has |e| <= max |p| / k_1; the term in e^2 of V says the same.
        """
        return float(np.sqrt(2.0 * EPSILON / (self.rate * self.plant.axis.mass)) / self.parameters.error_gain)

    def robust_term(self, log: Log) -> tuple[float, float]:
        """The largest p (u_s2 - phi^T theta~ + d~) / epsilon and p u_s2 / epsilon of any sample.

        Both as the controller has them, from its readings, and the former with the worst d~ of the sample.
        """
        q = self.parameters
        velocity = np.diff(log.position, prepend=log.position[0]) * q.sample_rate
        error = log.position - _known(log.reference)
        error_rate = velocity - _known(log.reference_velocity)
        p = error_rate + q.error_gain * error
        x, v, a = _known(log.reference), _known(log.reference_velocity), _known(log.reference_acceleration)
        if self.law is Arc:
            x, v, a = log.position, velocity, a - q.error_gain * error_rate
        friction = smooth_sign(v, q.coulomb_width)
        assert self.plant.cogging is not None
        phi = -np.column_stack([a, v, friction, -np.ones_like(a), self.plant.cogging.basis.regressor(x)])
        assert log.estimates is not None
        u_s2 = log.command + q.feedback_gain * p + np.sum(phi * log.estimates, axis=1)
        rest = np.abs(p) * q.disturbance_bound - p * np.sum(phi * (log.estimates - self.theta), axis=1)
        return float(np.max(p * u_s2 + rest)) / EPSILON, float(np.max(p * u_s2)) / EPSILON


def _known(column: FloatArray | None) -> FloatArray:
    assert column is not None
    return column


def draw(axis: GantryAxis, seed: int, law: Law, *, width: float = COULOMB_WIDTH, **gains: Any) -> Trial:
    """A machine inside the printed bounds or at their corners, estimates anywhere within, d~ within delta_d.

    Args:
        axis: gives bounds, motion and, where none are given, the printed gains.
        seed: of the machine.
        law: of the controller.
        width: of S_f, in machine and controller, m/s.
        gains: error_gain (1/s), feedback_gain (V/(m/s)).
    """
    rng = np.random.default_rng([2008, 1, seed])
    truth = [float(rng.choice([rng.uniform(*bound), *bound])) for bound in axis.bounds]
    estimates: dict[str, Any] = {
        name: float(rng.uniform(*bound)) for name, bound in zip(ESTIMATED, axis.bounds, strict=True)
    }
    basis, largest = controller_basis(axis), axis.cogging_bound
    sine, cosine = rng.uniform(-largest, largest, (2, len(axis.compensated), basis.spline.control_points))
    cogging = CoggingModel(basis, sine, cosine)
    share, phase, side = rng.uniform(), rng.uniform(0.0, 2.0 * np.pi), rng.choice([-1.0, 1.0])
    size = DISTURBANCE * share
    effects: list[Any] = [
        ConstantForce(force=truth[3]),
        DisturbanceTone(
            frequency=float(10 ** rng.uniform(0.0, 2.0)), sine=size * np.cos(phase), cosine=size * np.sin(phase)
        ),
        DisturbanceStep(force=side * (DISTURBANCE - size), start=rng.uniform(0.0, 0.2), stop=rng.uniform(0.3, 0.6)),
    ]
    mass, viscous, coulomb, _ = truth
    body = AxisParameters(mass=mass, viscous=viscous, coulomb=coulomb, coulomb_width=width, travel=list(TRAVEL))
    changes: dict[str, Any] = {
        "sample_rate": SAMPLE_RATE,
        "epsilon": EPSILON,
        "disturbance_bound": DISTURBANCE,
        "coulomb_width": width,
        "error_difference": False,
    }
    parameters = controller_parameters(axis, "C3", **changes, **estimates, **gains)
    start = START + float(rng.uniform(-1.0, 1.0) * rng.choice([0.0, 1e-4, 1e-3]))
    theta = np.array([*truth, *cogging.coefficients])
    plant = Plant(body, cogging=cogging, effects=effects)
    return Trial(
        law, plant, parameters, theta, reference(axis, repeats=1), (start, 0.0), rate_of(axis, law, parameters)
    )


def rate_of(axis: GantryAxis, law: Law, parameters: AdaptiveRobustParameters) -> float:
    """lambda of (23), 1/s, over the printed bounds; not above zero where Dcarc's gains do not satisfy (29)."""
    if law is Arc:
        return 2.0 * parameters.feedback_gain / axis.bounds[0][1]
    friction, cogging = friction_slope_max(parameters.coulomb_width), steepest(axis)[1]
    return desired_compensation_condition(parameters, friction_slope=friction, cogging_slope=cogging)[1]
