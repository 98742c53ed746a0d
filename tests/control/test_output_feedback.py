"""Output-feedback adaptive robust control: Xu and Yao 2001, against formulas written down a second time.

Its Lyapunov functions along runs of drawn machines: tests/papers/test_xu2001_claims.py.
"""

import numpy as np
import pytest
from scipy.integrate import solve_ivp
from scipy.linalg import expm

import cogging
from cogging.papers.xu2001 import epoxy_motor as xu2001_setup
from cogging.papers.xu2001.backstepping import ROBUST_TERMS

SWITCHES = [{}, *({name: True} for name in ROBUST_TERMS), dict.fromkeys(ROBUST_TERMS, True)]


class Literal:
    """The law in numpy, term by term as printed (with the errata), the derivatives by complex steps."""

    def __init__(self, p):
        self.p = p
        self.k = np.array([p.observer_gain_1, p.observer_gain_2])
        self.a0 = np.array([[-self.k[0], 1.0], [-self.k[1], 0.0]])
        self.range2 = np.sum((np.array(p.theta_max) - np.array(p.theta_min)) ** 2)
        self.gamma = np.array(p.adaptation)

    def alpha(self, y, eta, psi_2, q_d, v_d, theta):
        p = self.p
        xi_1, xi_2 = self.a0 @ eta, -self.a0 @ self.a0 @ eta
        model = -(xi_2[1] - theta[1] * (xi_1[1] + y) + theta[2] * psi_2 - v_d) / theta[0]
        phi = np.array([model, -(xi_1[1] + y), psi_2])
        z = y - q_d
        k_1s = p.gain_1
        if p.use_c_phi_1:
            k_1s = k_1s + p.robust_factor * np.sum((np.array(p.c_phi_1) * self.gamma * phi) ** 2)
        value = model - k_1s * z / p.theta_min[0]
        if p.use_alpha_1s2:
            value = value - p.robust_factor * self.range2 * np.sum(phi**2) / (4 * p.theta_min[0] * p.epsilon_11) * z
        if p.use_alpha_1s3:
            value = value - p.robust_factor / (4 * p.theta_min[0] * p.epsilon_12) * z
        return value, phi

    def gradient(self, y, eta, psi_2, q_d, v_d, theta):
        point = np.array([y, *eta, psi_2, q_d, v_d, *theta], dtype=complex)
        out = []
        for i in range(point.size):
            moved = point.copy()
            moved[i] += 1e-30j
            out.append(self.alpha(moved[0], moved[1:3], moved[3], moved[4], moved[5], moved[6:])[0].imag / 1e-30)
        return np.array(out)

    def command(self, y, eta, lam, psi, reference, theta):
        p = self.p
        q_d, v_d, a_d = reference
        alpha, phi_1 = self.alpha(y, eta, psi[1], q_d, v_d, theta)
        d = self.gradient(y, eta, psi[1], q_d, v_d, theta)
        xi_1, xi_2 = self.a0 @ eta, -self.a0 @ self.a0 @ eta
        omega = np.array([lam[1], -(xi_1[1] + y), psi[1]])
        eta_rate = self.a0 @ eta + np.array([0, y])
        psi_rate = self.a0 @ psi + np.array([0, 1])
        alpha_rate = d[0] * (xi_2[1] + theta @ omega) + d[1:3] @ eta_rate + d[3] * psi_rate[1] + d[4] * v_d + d[5] * a_d
        z_1, z_2 = y - q_d, lam[1] - alpha
        phi_2 = -d[0] * omega
        phi_2[0] += p.weight_1 / p.weight_2 * z_1
        k_2s = p.gain_2
        if p.use_c_theta_2:
            k_2s += p.robust_factor * np.sum((d[6:] * np.array(p.c_theta_2)) ** 2)
        if p.use_c_phi_2:
            k_2s += p.robust_factor * np.sum((np.array(p.c_phi_2) * self.gamma * phi_2) ** 2)
        u = -p.weight_1 / p.weight_2 * theta[0] * z_1 + self.k[1] * lam[0] + alpha_rate - k_2s * z_2
        if p.use_u_s2:
            u -= p.robust_factor * self.range2 * np.sum(phi_2**2) / (4 * p.epsilon_21) * z_2
        if p.use_u_s3:
            u -= p.robust_factor * d[0] ** 2 / (4 * p.epsilon_22) * z_2
        return u, p.weight_1 * phi_1 * z_1 + p.weight_2 * phi_2 * z_2, z_1, z_2


@pytest.mark.parametrize("switches", SWITCHES, ids=lambda s: "+".join(s) or "none")
def test_command_and_adaptation_against_the_printed_law(switches):
    p = xu2001_setup.arc_parameters(**switches, robust_factor=1e-4)
    controller, literal, random = cogging.OutputFeedbackArc(p), Literal(p), np.random.default_rng(2)
    block = np.zeros((3, 3))
    block[:2, :2], block[1, 2] = literal.a0, 1.0
    step = expm(block / p.sample_rate)
    eta = lam = psi = np.zeros(2)
    theta, first = np.array(p.theta), None
    for k in range(25):
        t = k / p.sample_rate
        reference = tuple(float(column[0]) for column in xu2001_setup.reference().sample(np.array([t])))
        reading = 0.2 + reference[0] + 1e-5 * random.normal()
        first = reading if first is None else first
        y, moved = reading - first, (reference[0] + 0.2 - first, *reference[1:])
        u_star, tau, z_1, z_2 = literal.command(y, eta, lam, psi, moved, theta)
        friction = p.coulomb * 2 / np.pi * np.arctan(reference[1] / p.coulomb_width)
        found = controller.command((0.2 + reference[0], *reference[1:]), reading)
        at = {"position": y, "eta_1": eta[0], "eta_2": eta[1], "psi_2": psi[1]}
        at |= {"reference": moved[0], "reference_velocity": moved[1]}
        virtual = controller.virtual_control(**at, theta=list(theta))
        value = literal.alpha(y, eta, psi[1], *moved[:2], theta)[0]
        assert virtual["value"] == pytest.approx(value, rel=1e-10, abs=1e-12)
        gradient = literal.gradient(y, eta, psi[1], *moved[:2], theta)
        partial = [virtual[name] for name in (*at, "theta_1", "theta_2", "theta_3")]
        np.testing.assert_allclose(partial, gradient, rtol=1e-9, atol=1e-9 * np.abs(gradient).max())
        assert found == pytest.approx(u_star + friction, abs=1e-8 * max(1.0, abs(found)))
        assert controller.z_1 == pytest.approx(z_1, abs=1e-12)
        assert controller.z_2 == pytest.approx(z_2, rel=1e-8, abs=1e-12)
        applied = np.clip(found, -1.0, 1.0)
        controller.update(applied)
        theta = np.clip(theta + np.array(p.adaptation) * tau / p.sample_rate, p.theta_min, p.theta_max)
        eta = step[:2, :2] @ eta + step[:2, 2] * y
        lam = step[:2, :2] @ lam + step[:2, 2] * (applied - friction)
        psi = step[:2, :2] @ psi + step[:2, 2]
        np.testing.assert_allclose(controller.estimates, theta, rtol=1e-8, atol=1e-7)
        np.testing.assert_allclose(controller.filters, [*eta, *lam, *psi], rtol=1e-9, atol=1e-12)


def estimation_error(theta, sample_rate, duration, disturbance=lambda time: 0.0):
    """The largest |x_2 - x_2 hat| of a run with the true theta, x_2 = q' + theta_2 q; the model is solved exactly."""
    fixed = {"coulomb": 0.0, "theta": theta, "adaptation": [0.0] * 3}
    controller = cogging.OutputFeedbackArc(xu2001_setup.arc_parameters(sample_rate=sample_rate, **fixed))
    step = expm(np.array([[0.0, 1.0, 0.0], [0.0, -theta[1], 1.0], [0.0, 0.0, 0.0]]) / sample_rate)
    x, errors = np.zeros(2), []  # position and velocity
    times = np.arange(int(duration * sample_rate)) / sample_rate
    for time, *point in zip(times, *xu2001_setup.reference().sample(times), strict=True):
        u = controller.command(point, x[0])
        errors.append(abs(controller.velocity_state(theta) - x[1] - theta[1] * x[0]))
        controller.update(u)
        x = step[:2, :2] @ x + step[:2, 2] * (theta[0] * u + theta[2] + disturbance(time))
    return max(errors[1:])


def test_the_state_estimate_is_exact_with_the_true_theta():
    """But for the sampling: psi and eta see the held position, hence the allowance of half a sample's motion."""
    fine, coarse = (estimation_error([20.0, 5.0, 3.0], rate, 0.5) for rate in (20_000.0, 2500.0))
    assert fine < 3e-3
    assert coarse / fine == pytest.approx(8.0, rel=0.2), "the error is of the sampling, and vanishes with it"


def test_the_estimation_bound():
    """(15): the largest that a disturbance |d~| <= size can make, the integral of |exp(A_0 t) e_2|."""
    p, size, times = xu2001_setup.arc_parameters(), 5.0, np.linspace(0.0, 0.2, 1001)
    a0 = np.array([[-p.observer_gain_1, 1.0], [-p.observer_gain_2, 0.0]])
    bound = size * np.trapezoid([abs(expm(a0 * t)[1, 1]) for t in times], times)
    error = estimation_error([20.0, 5.0, 0.0], 20_000.0, 0.4, lambda t: size * np.sign(np.sin(2 * np.pi * 30 * t)))
    assert error < bound + 3e-3
    assert error > 0.3 * bound, "the bound is of the right size"


@pytest.mark.parametrize(("beta_1", "beta_2"), [(100.0, 2500.0), (30.0, 2500.0)])  # both poles at -50, and a pair
def test_the_filtered_sine_solves_its_equation(beta_1, beta_2):
    fields = {"center": 0.1, "amplitude": 0.03, "frequency": 1.3, "beta_1": beta_1, "beta_2": beta_2}
    motion = cogging.FilteredSine(cogging.FilteredSineParameters(**fields))
    omega = 2 * np.pi * 1.3

    def rate(t, x):
        r, v, a = 0.1 + 0.03 * np.sin(omega * t), 0.03 * omega * np.cos(omega * t), -0.03 * omega**2 * np.sin(omega * t)
        return [x[1], a + beta_1 * (v - x[1]) + beta_2 * (r - x[0])]

    t = np.linspace(0, 1, 41)
    exact = solve_ivp(rate, (0, 1), [0.1, 0.0], t_eval=t, rtol=1e-11, atol=1e-13)
    position, velocity, acceleration = motion.sample(t)
    np.testing.assert_allclose(position, exact.y[0], atol=1e-9)
    np.testing.assert_allclose(velocity, exact.y[1], atol=1e-7)
    np.testing.assert_allclose(acceleration, [rate(a, x)[1] for a, x in zip(t, exact.y.T, strict=True)], atol=1e-5)
