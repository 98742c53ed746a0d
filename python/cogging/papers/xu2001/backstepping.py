"""What the theory of Xu and Yao 2001 speaks of, along a run: z_1, z_2, phi_1, phi_2 and the gains, eq. 12 to 48.

Written a second time, in numpy over all rows of a log: the core's controller does not show its gains as it runs.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from cogging._core import OutputFeedbackArcParameters, smooth_sign
from cogging.arrays import FloatArray
from cogging.logs.log import Log


@dataclass(frozen=True)
class Backstepping:
    """The two steps of the design along a run; arrays of one entry, or of three, a row.

    Attributes:
        time: s.
        z_1, z_2: of the steps, m and V s (after 22, 25).
        phi_1, phi_2: of the adaptation law (26), (45); (n, 3).
        omega: of (39); (n, 3).
        by_theta: d alpha_1 / d theta_hat; (n, 3).
        by_position: d alpha_1 / d y.
        gain_1: of -z_1 in theta_1min alpha_1s: k_1s with (37), (38).
        gain_2: of -z_2 in u*_s: k_2s with (47).
    """

    time: FloatArray
    z_1: FloatArray
    z_2: FloatArray
    phi_1: FloatArray
    phi_2: FloatArray
    omega: FloatArray
    by_theta: FloatArray
    by_position: FloatArray
    gain_1: FloatArray
    gain_2: FloatArray

    def lyapunov(self, p: OutputFeedbackArcParameters) -> FloatArray:
        """V_2 of (30), (41)."""
        return 0.5 * (p.weight_1 * self.z_1**2 + p.weight_2 * self.z_2**2)


def backstepping(log: Log, p: OutputFeedbackArcParameters) -> Backstepping:
    """The steps of an ARC along a log of it, with the terms that its switches say.

    Args:
        log: with its reference and its estimates.
        p: of the controller.
    """
    assert log.reference is not None
    assert log.reference_velocity is not None
    assert log.estimates is not None
    origin = log.position[0]
    y, z_1 = log.position - origin, log.position - log.reference
    compensation = p.coulomb * np.asarray(smooth_sign(log.reference_velocity, p.coulomb_width))
    eta, lam, psi = (filtered(p, driven) for driven in (y, log.command - compensation, np.ones_like(y)))
    return steps(p, log.time, z_1, y, eta, lam, psi, log.estimates, log.reference_velocity)


def filtered(p: OutputFeedbackArcParameters, driven: FloatArray) -> FloatArray:
    """x' = A_0 x + e_2 input from rest (12), (18), the input held from row to row, exactly; (n, 2)."""
    from scipy.linalg import expm

    block = np.zeros((3, 3))
    block[:2] = [[-p.observer_gain_1, 1.0, 0.0], [-p.observer_gain_2, 0.0, 1.0]]
    step = expm(block / p.sample_rate)
    (a, b), (c, d) = step[:2, :2].tolist()
    into_1, into_2 = step[:2, 2].tolist()
    found, x_1, x_2 = [], 0.0, 0.0
    for value in driven.tolist():
        found.append((x_1, x_2))
        x_1, x_2 = a * x_1 + b * x_2 + into_1 * value, c * x_1 + d * x_2 + into_2 * value
    return np.array(found)


def steps(
    p: OutputFeedbackArcParameters,
    time: FloatArray,
    z_1: FloatArray,
    y: FloatArray,
    eta: FloatArray,
    lam: FloatArray,
    psi: FloatArray,
    theta: FloatArray,
    velocity: FloatArray,
) -> Backstepping:
    """The steps from the states of the filters, (n, 2) each, and the estimates, (n, 3)."""
    k_1, k_2 = p.observer_gain_1, p.observer_gain_2
    xi_12, xi_22 = -k_2 * eta[:, 0], k_2 * (eta[:, 1] - k_1 * eta[:, 0])  # (17)
    model = -(xi_22 - theta[:, 1] * (xi_12 + y) + theta[:, 2] * psi[:, 1] - velocity) / theta[:, 0]  # (25)
    phi_1 = np.stack([model, -(xi_12 + y), psi[:, 1]], axis=1)  # (26)
    omega = np.stack([lam[:, 1], -(xi_12 + y), psi[:, 1]], axis=1)  # (39)
    weights = weights_1(p)
    gain_1 = p.gain_1 + (phi_1**2) @ weights
    if p.use_alpha_1s3:
        gain_1 = gain_1 + p.robust_factor / (4.0 * p.epsilon_12)  # (38)
    z_2 = lam[:, 1] - (model - gain_1 * z_1 / p.theta_min[0])

    # d alpha_1: that of alpha_1a, and of the gain where it depends on phi_1.
    slope = theta[:, 1] / theta[:, 0]
    of_gain = 2.0 * z_1 * weights[:, None] * phi_1.T / p.theta_min[0]  # (3, n)
    by_position = slope * (1.0 - of_gain[0]) + of_gain[1] - gain_1 / p.theta_min[0]
    by_theta = -phi_1 / theta[:, :1] * (1.0 - of_gain[0])[:, None]
    phi_2 = -by_position[:, None] * omega  # (45)
    phi_2[:, 0] += p.weight_1 / p.weight_2 * z_1
    gain_2 = p.gain_2 + robust_2(p, by_theta, by_position, phi_2)
    return Backstepping(time, z_1, z_2, phi_1, phi_2, omega, by_theta, by_position, gain_1, gain_2)


def theta_range_square(p: OutputFeedbackArcParameters) -> float:
    """||theta_M||^2 of (32)."""
    return float(np.sum((np.array(p.theta_max) - np.array(p.theta_min)) ** 2))


def weights_1(p: OutputFeedbackArcParameters) -> FloatArray:
    """What phi_1^2 weighs in the gain of step 1, (3,): (28) and (37) with h_1 = ||theta_M||^2 ||phi_1||^2."""
    found = np.zeros(3)
    if p.use_c_phi_1:
        found += (np.array(p.c_phi_1) * np.array(p.adaptation)) ** 2
    if p.use_alpha_1s2:
        found += theta_range_square(p) / (4.0 * p.epsilon_11)
    return p.robust_factor * found


def robust_2(
    p: OutputFeedbackArcParameters, by_theta: FloatArray, by_position: FloatArray, phi_2: FloatArray
) -> FloatArray:
    """What stands beside g_2 in the gain of step 2: (43), (47) with h_2 = ||theta_M||^2 ||phi_2||^2."""
    found = np.zeros_like(by_position)
    if p.use_c_theta_2:
        found += np.sum((by_theta * np.array(p.c_theta_2)) ** 2, axis=1)
    if p.use_c_phi_2:
        found += np.sum((phi_2 * np.array(p.c_phi_2) * np.array(p.adaptation)) ** 2, axis=1)
    if p.use_u_s2:
        found += theta_range_square(p) * np.sum(phi_2**2, axis=1) / (4.0 * p.epsilon_21)
    if p.use_u_s3:
        found += by_position**2 / (4.0 * p.epsilon_22)
    return p.robust_factor * found
