"""What Xu and Yao 2001 claim beside Table 1: the robust terms, Theorem 1 and Remark 3, PID poles at -320, case 2."""

import numpy as np
import pytest

import cogging
from cogging.papers.xu2001 import backstepping, pid_poles, robust_terms
from cogging.papers.xu2001 import epoxy_motor as xu2001_setup
from studies.xu2001 import study as xu2001_study
from tests.fixtures.reproduced import numbers_of, table_of


@pytest.fixture(scope="module")
def unknowns():
    return xu2001_setup.shipped_unknowns()


@pytest.mark.parametrize("switches", [{}, dict(robust_terms.ALL_TERMS, robust_factor=1e-6)], ids=["none", "all"])
def test_the_steps_along_a_log_are_those_of_the_controller(switches, unknowns):
    p = xu2001_setup.arc_parameters(**switches)
    log, found = backstepping.run(p, xu2001_setup.plant(unknowns, "1"), 0.2, seed=1)
    controller = cogging.OutputFeedbackArc(p)
    for k in range(log.time.size):
        controller.command(
            reference=log.reference[k],
            reference_velocity=log.reference_velocity[k],
            reference_acceleration=log.reference_acceleration[k],
            reading=log.position[k],
        )
        assert controller.z_1 == pytest.approx(found.z_1[k], abs=1e-15)
        assert controller.z_2 == pytest.approx(found.z_2[k], abs=1e-12)
        controller.update(log.command[k])
    tau = p.weight_1 * found.phi_1 * found.z_1[:, None] + p.weight_2 * found.phi_2 * found.z_2[:, None]  # (50)
    change = (np.array(p.adaptation) * tau)[:-1] / p.sample_rate
    np.testing.assert_allclose(np.diff(log.estimates, axis=0), change, atol=1e-9)


def gains_by_hand():
    """K_1 and K_2 at rest with the numbers of section 4.3: phi_1 = [0, 0, psi_2], psi_2 = k_1 / k_2 = 0.01."""
    psi, theta_range = 0.01, 41.7**2 + 15.1**2 + 100.0**2
    gain_1 = 600 + 1 / (4 * 5e-5) + (1e-4 * 2e6 * psi) ** 2 + theta_range * psi**2 / (4 * 5e-5)
    by_position = 10 / 30 - gain_1 / 8.3
    phi_2 = by_position * psi
    gain_2 = 850 + (1e5 * psi / 30) ** 2 + (1e-4 * 2e6 * phi_2) ** 2
    return gain_1, gain_2 + theta_range * phi_2**2 / (4 * 1e-3) + by_position**2 / 4


def test_what_one_count_moves_the_command():
    gain_1, gain_2 = gains_by_hand()
    assert robust_terms.by_hand(1e-6) == pytest.approx(-gain_1 * gain_2 / 8.3 * 1e-6, rel=1e-12)
    settled = robust_terms.one_count(1e-6)
    assert robust_terms.one_count(1e-6, held=1) == pytest.approx(-226.86, rel=1e-4)
    assert settled == pytest.approx(-8.2503e5, rel=1e-4)
    assert robust_terms.one_count(1e-6, held=1000) == pytest.approx(settled, rel=1e-9), "it has settled"
    assert robust_terms.one_count(1e-6, held=100) == pytest.approx(0.9915 * settled, rel=1e-3), "and had not before"
    # The other terms of the command are linear in the count, and 4,000 times smaller.
    assert settled == pytest.approx(-gain_1 * gain_2 / 8.3 * 1e-6, rel=3e-4)


def test_the_printed_robust_terms_last_until_the_gain_reaches_the_sampling():
    limits = numbers_of("xu2001", "robust_terms")
    ends = [limits["ARC, all terms", "diverges_at", f"{rate:.0e} Hz"] for rate in robust_terms.RATES]
    for rate, end in zip(robust_terms.RATES, ends, strict=True):
        assert limits["ARC, all terms", "unstable_from", f"{rate:.0e} Hz"] == pytest.approx(end, abs=0.35e-3)
    assert ends == sorted(ends)
    found = robust_terms.time_to_divergence(1e5, 0.02)
    assert found.time == ends[0]
    assert "diverged at" in found.end
    assert robust_terms.time_to_divergence(1e7, 0.002).end == "ran to its end", (
        "the first 2 ms run at 10 MHz, and more does not"
    )
    assert np.isinf(robust_terms.increment(1e-2, 2500.0, 1e-6))
    assert robust_terms.increment(0.0, 2500.0, 1e-6) == pytest.approx(0.050, abs=0.002), "the quantiser alone"


def test_few_of_128_choices_of_robust_terms_run():
    assert len(set(robust_terms.subsets())) == 128
    rows = [row for row in table_of("xu2001", "robust_subsets").rows if "terms" in row.labels]
    running = {row.labels["terms"] for row in rows if row.labels["plant"] == "calibrated"}
    assert running == {"none", "c_phi_1", "c_theta_2", "u_s3", "c_phi_1 + c_theta_2", "c_phi_1 + u_s3"}
    assert len({row.labels["terms"] for row in rows if row.index == "diverges_at"} | running) == 10, "all singles"


@pytest.mark.study
def test_the_rate_that_is_needed_by_runs():
    below = robust_terms.time_to_divergence(3.2e8, 0.06)
    assert below.time == pytest.approx(0.0318, rel=0.02)
    above = robust_terms.time_to_divergence(3.35e8, 0.06)  # the largest gain stands at 0.055 s
    assert above.time == 0.06
    assert above.error == pytest.approx(1.187e-6, rel=0.01)


def test_the_examples_of_the_robust_functions_meet_their_conditions():
    """(33), (35), (46) i and ii by (37), (38), (47), and each with its whole epsilon used up somewhere."""
    random, rows = np.random.default_rng(2001), 20_000
    low, high = np.array([8.3, 2.4, -50.0]), np.array([50.0, 17.5, 50.0])
    theta_1, range_square = random.uniform(low[0], high[0], rows), np.sum((high - low) ** 2)
    phi = random.normal(size=(rows, 3)) * 10.0 ** random.uniform(-3, 1, (rows, 1))
    off = random.uniform(-1, 1, (rows, 3)) * (high - low)
    epsilon, z = 10.0 ** random.uniform(-5, 0, rows), random.normal(size=rows)
    z *= 4 * epsilon / np.linalg.norm(high - low) / np.linalg.norm(phi, axis=1)
    bounding = range_square * np.sum(phi**2, axis=1)
    first = -bounding / (4 * low[0] * epsilon) * z  # (37)
    second = -bounding / (4 * epsilon) * z  # (47)
    for left in (z * (theta_1 * first - np.sum(off * phi, axis=1)), z * (second - np.sum(off * phi, axis=1))):
        assert 0.5 < np.max(left / epsilon) <= 1.0
    assert np.all(z * first <= 0)
    assert np.all(z * second <= 0)
    delta, slope = random.normal(size=rows), 10.0 ** random.uniform(0, 3, rows)
    z = random.normal(size=rows) * 2 * epsilon * np.abs(delta)
    third = z * (-theta_1 / (4 * low[0] * epsilon) * z + delta)  # (38)
    assert 0.9 < np.max(third / (epsilon * delta**2)) <= 1.0
    fourth = z / slope * (-(slope**2) / (4 * epsilon) * z / slope - slope * delta)  # (47), Delta_2 of (45)
    assert 0.9 < np.max(fourth / (epsilon * delta**2)) <= 1.0


def test_the_condition_of_theorem_1_is_what_a_4_needs():
    assert backstepping.condition_margin(xu2001_setup.arc_parameters()) == pytest.approx((5.0, 50.0))
    random, rows = np.random.default_rng(4), 20_000
    slope, phi = random.normal(size=(rows, 3)), random.normal(size=(2, rows, 3))
    z, gamma, w = random.normal(size=(2, rows)), 10.0 ** random.uniform(-1, 1, (rows, 3)), np.array([1.0, 0.1])
    c_theta = 10.0 ** random.uniform(-1, 1, (rows, 3))
    tau = sum(w[k] * phi[k] * z[k][:, None] for k in (0, 1))
    left = w[1] * np.abs(np.sum(slope * gamma * tau, axis=1) * z[1])

    def share(margin):
        right = w[1] * np.sum((slope * c_theta) ** 2, axis=1) * z[1] ** 2
        for k in (0, 1):
            c_phi_square = margin * w[k] * w[1] / (2 * c_theta**2)
            right = right + w[k] * np.sum(c_phi_square * (gamma * phi[k]) ** 2, axis=1) * z[k] ** 2
        return np.max(left / right)

    assert 0.8 < share(1.0) <= 1.0
    assert share(0.25) > 1.0, "with a smaller C_phi it does not hold"


def test_remark_3_gains_bring_the_bound_down_and_v_2_with_it():
    found = numbers_of("xu2001", "theorem_1")
    finals = [found["deterministic", "v_2_final", f"{factor:g}"] for factor in backstepping.FACTORS]
    for factor, final in zip(backstepping.FACTORS, finals, strict=True):
        assert (
            final < found["deterministic", "v_2_bound", f"{factor:g}"] == pytest.approx(9.170e-5 / factor**2, rel=1e-3)
        )
    assert finals == sorted(finals, reverse=True)
    for set_name in ("1", "2"):  # the executable gains do not meet the conditions
        assert max(found["ARC", f"k_{k}s_over_needed", set_name] for k in (1, 2)) < 1.0
    assert found["ARC, no adaptation", "e_F", "500 s"] > 50 * found["ARC", "e_F", "500 s"]


def test_v_2_stays_under_its_bound_without_adaptation_on_drawn_machines():
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
    for _ in range(5):
        theta = random.uniform([10, 3, -10], [45, 15, 10])
        p = xu2001_setup.arc_parameters(sample_rate=400_000.0, coulomb=0.0)
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
    for _ in range(8):
        theta = random.uniform([10, 3, -10], [45, 15, 10])
        p = xu2001_setup.arc_parameters(sample_rate=100_000.0, coulomb=0.0)
        values = backstepping.adaptive_lyapunov(p, theta, 0.15)[1:]
        fall, rise = values[0] - values[-1], np.maximum(np.diff(values), 0.0).sum()
        assert rise < 0.02 * fall, theta
        falls.append(fall / values[0])
    assert 1e-3 < min(falls) < max(falls) < 1.0


def test_a_delay_and_a_mode_part_the_pid_poles():
    found = numbers_of("xu2001", "pid_poles")
    for where in (("1", "in motion"), ("2", "at rest")):
        early, late = (found[(f"PID at {pole}", "delay_limit", *where)] for pole in ("-320", "-300"))
        assert early < late
    for mode in ("250 Hz", "300 Hz", "400 Hz"):
        assert found["PID at -320", "load_limit", "1", mode] < found["PID at -300", "load_limit", "1", mode]
    ((index, _),) = [(index, mode) for name, index, _, mode in found if name == "PID at -320" and "load 1" in mode]
    assert index == "diverges_at"


def test_case_2_comes_to_rest_within_a_count_or_two():
    found = numbers_of("xu2001", "fast_motion")
    assert 1e6 * found["ARC", "e_settled", "calibrated"] == pytest.approx(1.0)
    assert found["ARC", "e_moving", "calibrated"] < found["PID", "e_moving", "calibrated"]
    assert all(
        1e6 * value == pytest.approx(round(1e6 * value)) for place, value in found.items() if place[1] == "e_settled"
    )


def test_case_2_runs_at_its_limits():
    motion = xu2001_setup.fast_reference()
    _, velocity, acceleration = motion.sample(np.linspace(0, motion.end, 100_001))
    assert np.abs(velocity).max() == pytest.approx(1.0)
    assert np.abs(acceleration).max() == pytest.approx(12.0)


def test_integral_stiffness_of_the_pid_is_its_integral_gain():
    controller = cogging.Pid(xu2001_setup.pid_parameters(coulomb=0.0))
    assert xu2001_study.integral_stiffness(controller, xu2001_setup.MASSES["1"]) == pytest.approx(5.4e5, rel=0.01)


def test_a_delay_makes_the_pid_unstable_where_the_linear_loop_says():
    delay, frequency = xu2001_study.loses_stability(
        lambda: cogging.Pid(xu2001_setup.pid_parameters(coulomb=0.0)), xu2001_setup.MASSES["1"]
    )
    # Continuous loop with the sampling's half-sample hold and the difference's half sample: phase margin at crossover.
    p, mass = xu2001_setup.pid_parameters(), xu2001_setup.MASSES["1"]
    omega = 2 * np.pi * np.linspace(20, 400, 200_000)
    s, t_s = 1j * omega, 1.0 / xu2001_setup.SAMPLE_RATE
    z = np.exp(s * t_s)
    difference = (1 - 1 / z) / t_s
    feedback = p.kp + p.ki * t_s / (1 - 1 / z) + (p.kd - p.viscous) * difference
    hold = (1 - 1 / z) / (s * t_s)
    loop = feedback * hold / (mass * s**2 + xu2001_setup.VISCOUS * s)
    crossing = np.flatnonzero(np.abs(loop) > 1)[-1]
    margin = (np.angle(loop[crossing]) + np.pi) % (2 * np.pi) / omega[crossing]
    assert delay == pytest.approx(margin, rel=0.05)
    assert delay == pytest.approx(pid_poles.delay_limit(-300.0, mass), rel=0.01)
    assert frequency == pytest.approx(omega[crossing] / (2 * np.pi), rel=0.05)
