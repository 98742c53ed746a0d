"""What Xu and Yao 2001 claim beside Table 1: robust terms, Theorem 1, PID poles, case 2. Numbers: test_numbers.py."""

import numpy as np
import pytest

import cogging
from cogging.papers.xu2001 import backstepping, epoxy_motor, pid_poles
from studies.xu2001 import study
from tests.fixtures.reproduced import numbers_of, table_of


@pytest.mark.parametrize("switches", [{}, dict(backstepping.ALL_TERMS, robust_factor=1e-6)], ids=["none", "all"])
def test_the_steps_along_a_log_are_those_of_the_controller(switches):
    p = epoxy_motor.arc_parameters(**switches)
    log, found = backstepping.run(p, epoxy_motor.plant(epoxy_motor.shipped_unknowns(), "1"), 0.2, seed=1)
    controller = cogging.OutputFeedbackArc(p)
    motion = zip(log.reference, log.reference_velocity, log.reference_acceleration, strict=True)
    for k, point in enumerate(motion):
        controller.command(point, log.position[k])
        assert controller.z_1 == pytest.approx(found.z_1[k], abs=1e-15)
        assert controller.z_2 == pytest.approx(found.z_2[k], abs=1e-12)
        controller.update(log.command[k])
    tau = p.weight_1 * found.phi_1 * found.z_1[:, None] + p.weight_2 * found.phi_2 * found.z_2[:, None]  # (50)
    change = (np.array(p.adaptation) * tau)[:-1] / p.sample_rate
    np.testing.assert_allclose(np.diff(log.estimates, axis=0), change, atol=1e-9)


def test_what_one_count_moves_the_command():
    # K_1 and K_2 at rest with the numbers of section 4.3: phi_1 = [0, 0, psi_2], psi_2 = k_1 / k_2 = 0.01.
    psi, theta_range = 0.01, 41.7**2 + 15.1**2 + 100.0**2
    gain_1 = 600 + 1 / (4 * 5e-5) + (1e-4 * 2e6 * psi) ** 2 + theta_range * psi**2 / (4 * 5e-5)
    by_position = 10 / 30 - gain_1 / 8.3
    phi_2 = by_position * psi
    gain_2 = 850 + (1e5 * psi / 30) ** 2 + (1e-4 * 2e6 * phi_2) ** 2
    gain_2 += theta_range * phi_2**2 / (4 * 1e-3) + by_position**2 / 4
    by_hand = -gain_1 * gain_2 / 8.3 * 1e-6
    assert backstepping.by_hand(1e-6) == pytest.approx(by_hand, rel=1e-12)
    settled = backstepping.one_count(1e-6)
    assert backstepping.one_count(1e-6, held=1000) == pytest.approx(settled, rel=1e-9), "it has settled"
    assert backstepping.one_count(1e-6, held=100) == pytest.approx(0.9915 * settled, rel=1e-3), "and had not before"
    # The other terms of the command are linear in the count, and 4,000 times smaller.
    assert settled == pytest.approx(by_hand, rel=3e-4)


def test_the_printed_robust_terms_last_until_the_gain_reaches_the_sampling():
    limits = numbers_of("xu2001", "robust_terms")
    ends = [limits["ARC, all terms", "diverges_at", f"{rate:.0e} Hz"] for rate in backstepping.RATES]
    for rate, end in zip(backstepping.RATES, ends, strict=True):
        assert limits["ARC, all terms", "unstable_from", f"{rate:.0e} Hz"] == pytest.approx(end, abs=0.35e-3)
    assert ends == sorted(ends)
    assert "diverged at" in backstepping.time_to_divergence(1e5, 0.02).end
    assert backstepping.time_to_divergence(1e7, 0.002).end == "ran to its end"
    assert np.isinf(backstepping.increment(1e-2, 2500.0, 1e-6))
    assert backstepping.increment(0.0, 2500.0, 1e-6) == pytest.approx(0.050, abs=0.002), "the quantiser alone"


@pytest.mark.study
def test_the_rate_that_is_needed_by_runs():
    assert backstepping.time_to_divergence(3.2e8, 0.06).time == pytest.approx(0.0318, rel=0.02)
    above = backstepping.time_to_divergence(3.35e8, 0.06)  # the largest gain is at 0.055 s
    assert above.time == 0.06
    assert above.error == pytest.approx(1.187e-6, rel=0.01)


def test_the_printed_gains_meet_the_condition_of_theorem_1():
    """Which (A.4) needs: the margins by hand from section 4.3."""
    assert backstepping.condition_margin(epoxy_motor.arc_parameters()) == pytest.approx((5.0, 50.0))


def test_v_2_stays_under_its_bound_without_adaptation_on_drawn_machines():
    """So the gains of (37), (38), (47) meet (33), (35), (46)."""
    random = np.random.default_rng(51)
    rises = []
    for _ in range(6):
        theta, first = random.uniform([15, 4, -3], [30, 8, 3]), random.uniform([15, 4, -3], [30, 8, 3])
        size, start = random.uniform(0.5, 4.0), random.uniform(2e-3, 8e-3) * random.choice([-1, 1])
        p = backstepping.deterministic_law(random.uniform(0.5, 2.0), theta=list(first))
        found = backstepping.kept(p, theta, size, start)
        assert found.share < 1.0, (theta, first, size, start)
        rises.append(found.rise)
    assert 1e-3 < max(rises) < 1.0, "V_2 rises faster than its decay somewhere, never by what (A.5) allows"


def test_the_derivatives_of_z_1_and_v_2_along_runs():
    """(26), (29) and (44), (49) with the executable gains: differences from row to row against the right sides."""
    random = np.random.default_rng(26)
    for _ in range(3):
        theta = random.uniform([10, 3, -10], [45, 15, 10])
        p = epoxy_motor.arc_parameters(sample_rate=400_000.0, coulomb=0.0)
        log, found = backstepping.run(p, backstepping.design_model(theta), 0.02, random.uniform(1e-4, 1e-3))
        off, w, z = log.estimates - theta, (p.weight_1, p.weight_2), (found.z_1, found.z_2)
        by_parameters = [np.sum(off * phi, axis=1) for phi in (found.phi_1, found.phi_2)]
        slope = theta[0] * (z[1] - p.gain_1 * z[0] / p.theta_min[0]) - by_parameters[0]
        tau = w[0] * found.phi_1 * z[0][:, None] + w[1] * found.phi_2 * z[1][:, None]  # (50)
        adapted = np.sum(found.by_theta * np.array(p.adaptation) * tau, axis=1)
        gains = (p.gain_1 * theta[0] / p.theta_min[0], p.gain_2)  # (49) has theta_1min in place of theta_1
        right = sum(-w[j] * (gains[j] * z[j] ** 2 + z[j] * by_parameters[j]) for j in (0, 1)) - w[1] * adapted * z[1]
        for values, rate in ((found.z_1, slope), (found.lyapunov(p), right)):
            measured, middle = np.diff(values) * p.sample_rate, 0.5 * (rate[1:] + rate[:-1])
            np.testing.assert_allclose(measured, middle, atol=0.006 * np.abs(rate).max())


def test_v_theta_falls_on_drawn_machines():
    """(A.8) with the executable gains: parametric uncertainty alone; what rises is the sampling's."""
    random = np.random.default_rng(8)
    falls = []
    for _ in range(5):
        theta = random.uniform([10, 3, -10], [45, 15, 10])
        p = epoxy_motor.arc_parameters(sample_rate=100_000.0, coulomb=0.0)
        values = backstepping.adaptive_lyapunov(p, theta, 0.15)[1:]
        fall, rise = values[0] - values[-1], np.maximum(np.diff(values), 0.0).sum()
        assert rise < 0.02 * fall, theta
        falls.append(fall / values[0])
    assert 1e-3 < min(falls) < max(falls) < 1.0


def test_case_2_runs_at_its_limits_and_ends_in_whole_counts():
    motion = epoxy_motor.fast_reference()
    _, velocity, acceleration = motion.sample(np.linspace(0, motion.end, 100_001))
    assert (np.abs(velocity).max(), np.abs(acceleration).max()) == pytest.approx((1.0, 12.0))
    settled = [1e6 * row.simulated for row in table_of("xu2001", "fast_motion").rows if row.index == "e_settled"]
    assert settled == pytest.approx(np.round(settled))


def test_a_delay_makes_the_pid_unstable_where_the_linear_loop_says():
    p, mass = epoxy_motor.pid_parameters(coulomb=0.0), epoxy_motor.MASSES["1"]
    delay, frequency = study.loses_stability(lambda: cogging.Pid(p), mass)
    # Continuous loop with the sampling's half-sample hold and the difference's half sample: phase margin at crossover.
    omega = 2 * np.pi * np.linspace(20, 400, 200_000)
    s, t_s = 1j * omega, 1.0 / epoxy_motor.SAMPLE_RATE
    z = np.exp(s * t_s)
    difference = (1 - 1 / z) / t_s
    feedback = p.kp + p.ki * t_s / (1 - 1 / z) + (p.kd - p.viscous) * difference
    hold = (1 - 1 / z) / (s * t_s)
    loop = feedback * hold / (mass * s**2 + epoxy_motor.VISCOUS * s)
    crossing = np.flatnonzero(np.abs(loop) > 1)[-1]
    margin = (np.angle(loop[crossing]) + np.pi) % (2 * np.pi) / omega[crossing]
    assert delay == pytest.approx(margin, rel=0.05)
    assert delay == pytest.approx(pid_poles.delay_limit(-300.0, mass), rel=0.01)
    assert frequency == pytest.approx(omega[crossing] / (2 * np.pi), rel=0.05)
