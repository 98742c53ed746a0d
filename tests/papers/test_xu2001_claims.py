"""What Xu and Yao 2001 claim beside Table 1: the robust terms, Theorem 1 and Remark 3, PID poles at -320, case 2."""

import numpy as np
import pytest

import cogging
from cogging.papers.xu2001 import backstepping, fast_motion, pid_poles, robust_terms, sinusoidal_motion
from cogging.papers.xu2001 import epoxy_motor as xu2001_setup
from studies.xu2001 import study as xu2001_study


def by_labels(table):
    """The numbers of a table by controller, index and labels."""
    return {(row.controller, row.index, *row.labels.values()): row.simulated for row in table.rows}


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
    assert robust_terms.settled_gains() == pytest.approx((gain_1, gain_2), rel=1e-12)
    settled = robust_terms.one_count(1e-6)
    print(
        f"\none count: {abs(robust_terms.one_count(1e-6, held=1)):.1f} V one sample after the start, {-settled:.6g} V"
    )
    assert robust_terms.one_count(1e-6, held=1) == pytest.approx(-226.86, rel=1e-4)
    assert settled == pytest.approx(-8.2503e5, rel=1e-4)
    assert robust_terms.one_count(1e-6, held=1000) == pytest.approx(settled, rel=1e-9), "it has settled"
    assert robust_terms.one_count(1e-6, held=100) == pytest.approx(0.9915 * settled, rel=1e-3), "and had not before"
    # The other terms of the command are linear in the count, and 4,000 times smaller.
    assert settled == pytest.approx(-gain_1 * gain_2 / 8.3 * 1e-6, rel=3e-4)


@pytest.fixture(scope="module")
def limits():
    return by_labels(robust_terms.one_count_table())


@pytest.mark.parametrize(("rate", "diverges"), [(1e5, 0.51), (1e6, 1.191), (1e7, 3.336), (1e8, 9.335)])
def test_the_printed_robust_terms_last_until_the_gain_reaches_the_sampling(rate, diverges, limits):
    found = robust_terms.lasts(rate, 0.02)
    assert 1e3 * found.time == pytest.approx(diverges, rel=0.02)
    assert "diverged at" in found.end
    assert "velocity" in found.end
    label = f"{rate:.0e} Hz"
    assert limits["ARC, all terms", "diverges_at", label] == found.time
    assert limits["ARC, all terms", "unstable_from", label] == pytest.approx(found.time, abs=0.35e-3)


def test_the_printed_robust_terms_need_327_mhz(limits):
    assert limits["ARC, all terms", "rate_needed"] == pytest.approx(3.271e8, rel=0.005)
    # The first 2 ms run at 10 MHz, and more does not.
    assert robust_terms.lasts(1e7, 0.002).end == "ran to its end"


@pytest.mark.study
def test_the_rate_that_is_needed_by_runs():
    below = robust_terms.lasts(3.2e8, 0.06)
    assert below.time == pytest.approx(0.0318, rel=0.02)
    above = robust_terms.lasts(3.35e8, 0.06)  # the largest gain stands at 0.055 s
    assert above.time == 0.06
    assert above.error == pytest.approx(1.187e-6, rel=0.01)


def test_six_of_128_choices_of_robust_terms_run():
    found = robust_terms.which_run(robust_terms.subsets(), robust_terms.rigid(1e-6))
    assert len(found) == 128
    increments = {terms: values["du_rms"] for terms, values in found.items() if "du_rms" in values}
    assert increments == pytest.approx(
        {
            (): 0.0504,
            ("use_c_phi_1",): 0.0511,
            ("use_c_theta_2",): 0.213,
            ("use_u_s3",): 0.257,
            ("use_c_phi_1", "use_c_theta_2"): 0.217,
            ("use_c_phi_1", "use_u_s3"): 0.267,
        },
        rel=0.02,
    )
    ends = {
        terms[0]: values["diverges_at"]
        for terms, values in found.items()
        if len(terms) == 1 and terms not in increments
    }
    assert ends == pytest.approx(
        {"use_alpha_1s2": 0.008, "use_alpha_1s3": 0.0032, "use_c_phi_2": 0.008, "use_u_s2": 0.0024}, rel=0.1
    )


def test_robust_terms_alone_on_the_calibrated_plant(unknowns):
    found = by_labels(robust_terms.subsets_table(unknowns))
    for terms, largest, increment in (
        ("none", 18.0, 0.0732),
        ("c_phi_1", 17.9, 0.0744),
        ("c_theta_2", 15.8, 0.321),
        ("u_s3", 15.7, 0.350),
    ):
        assert 1e6 * found["ARC", "e_M", terms, "calibrated"] == pytest.approx(largest, abs=1.0), terms
        assert found["ARC", "du_rms", terms, "calibrated"] == pytest.approx(increment, rel=0.03), terms
    assert found["ARC", "choices_that_run", "128"] == 6


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


def test_the_executable_gains_do_not_meet_the_conditions(unknowns):
    for name, expected in (("1", (0.9934, 0.0368, 0.0095, 1.69, 0.383)), ("2", (0.9934, 0.0359, 0.313, 156, 79.2))):
        found = backstepping.conditions(unknowns, name)
        print(f"\nset {name}: {found}")
        assert list(found.values()) == pytest.approx(expected, rel=0.03)


def test_remark_3_gains_bring_the_bound_down():
    finals = []
    for factor, final in zip(backstepping.FACTORS, (2.9e-8, 9.0e-9, 2.62e-9), strict=True):
        p = backstepping.deterministic_law(factor)
        of = backstepping.bound(p, backstepping.estimation_bound(p, backstepping.TONE))
        assert of.rate == pytest.approx(120 * factor)
        assert of.final == pytest.approx(9.170e-5 / factor**2, rel=1e-3)
        finals.append(backstepping.kept(p, backstepping.THETA, backstepping.TONE, backstepping.OFF).final)
        assert finals[-1] == pytest.approx(final, rel=0.03)
        assert finals[-1] < of.final
    assert finals[0] > finals[1] > finals[2]


def test_v_2_stays_under_its_bound_without_adaptation_on_drawn_machines():
    random = np.random.default_rng(51)
    rises = []
    for _ in range(12):
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


def test_the_error_without_disturbance_with_and_without_adaptation():
    adapted, fixed = backstepping.vanishing_errors(), backstepping.vanishing_errors(adaptation=False)
    assert [1e6 * error for error in adapted.values()] == pytest.approx([0.606, 0.560, 0.753], rel=0.05)
    assert [1e6 * error for error in fixed.values()] == pytest.approx([58.9] * 3, rel=0.01)


@pytest.fixture(scope="module")
def poles(unknowns):
    return by_labels(pid_poles.pid_poles_table(unknowns))


def test_a_delay_that_parts_the_pid_poles(poles):
    for pole, set_name, friction, limit in (
        ("-300", "1", "in motion", 1.240),
        ("-320", "1", "in motion", 1.135),
        ("-300", "2", "at rest", 0.5557),
        ("-320", "2", "at rest", 0.5373),
    ):
        found = 1e3 * poles[f"PID at {pole}", "delay_limit", set_name, friction]
        assert found == pytest.approx(limit, rel=2e-3), (pole, set_name)


def test_a_mode_that_parts_the_pid_poles(poles):
    for mode, low, high in (("250 Hz", 0.1998, 0.2336), ("300 Hz", 0.0938, 0.1097), ("400 Hz", 0.0715, 0.0787)):
        assert poles["PID at -320", "load_limit", "1", mode] == pytest.approx(low, rel=2e-3)
        assert poles["PID at -300", "load_limit", "1", mode] == pytest.approx(high, rel=2e-3)
    mode = "300 Hz, load 10.9 %"
    assert 1e6 * poles["PID at -300", "e_M", "1", mode] == pytest.approx(59.6, abs=1.0)
    assert poles["PID at -320", "diverges_at", "1", mode] == pytest.approx(9.50, rel=0.03)
    assert 1e6 * poles["ARC", "e_M", "1", mode] == pytest.approx(18.1, abs=1.0)


@pytest.fixture(scope="module")
def fast(unknowns):
    return by_labels(fast_motion.fast_motion_table(unknowns))


def test_case_2_at_rest(fast):
    for name, plant, moving, at_rest, settled in (
        ("PID", "calibrated", 63.7, 48, 1),
        ("ARC", "calibrated", 38.0, 16, 1),
        ("ARC", "no encoder noise", 37.5, 15, 1),
        ("ARC", "noise x 2", 39.0, 17, 3),
        ("ARC", "no ripple", 16.3, 16, 1),
        ("ARC", "friction that sticks", 38.7, 14, 4),
        ("ARC", "sticks, no noise", 43.3, 13, 2),
    ):
        found = [1e6 * fast[name, index, plant] for index in ("e_moving", "e_at_rest", "e_settled")]
        assert found[0] == pytest.approx(moving, abs=1.0), (name, plant)
        assert found[1:] == pytest.approx([at_rest, settled], abs=0.01), (name, plant)  # whole counts
    assert fast["ARC", "settling", "calibrated"] == pytest.approx(0.271, abs=0.01)


def test_case_2_at_rest_over_seeds(unknowns):
    arc = {"ARC": cogging.OutputFeedbackArc(xu2001_setup.arc_parameters())}
    logs = [fast_motion.run_fast(unknowns, arc, seed)["ARC"] for seed in range(8)]
    counts = [round(1e6 * fast_motion.errors(log).settled) for log in logs]
    assert counts.count(1) == 5
    assert counts.count(2) == 3


def test_case_2_runs_at_its_limits():
    motion = xu2001_setup.fast_reference()
    _, velocity, acceleration = motion.sample(np.linspace(0, motion.end, 100_001))
    assert np.abs(velocity).max() == pytest.approx(1.0)
    assert np.abs(acceleration).max() == pytest.approx(12.0)


def test_the_figures_show_pid_and_arc_on_one_scale(unknowns):
    controllers = {
        "PID": cogging.Pid(xu2001_setup.pid_parameters()),
        "ARC": cogging.OutputFeedbackArc(xu2001_setup.arc_parameters()),
    }
    logs = {name: xu2001_setup.run(unknowns, controller) for name, controller in controllers.items()}
    for name, largest in (("1", 57.1), ("2", 60.0), ("3", 100.8)):
        panels = sinusoidal_motion.figure_errors(logs, name).axes
        limits = {axes.get_ylim() for axes in panels}
        assert len(limits) == 1, "one scale"
        end = max(limits.pop())
        assert end == pytest.approx(60.0) if name == "2" else largest < end < 1.2 * largest
    pid, rest_of_pid, arc, rest_of_arc = fast_motion.figure_fast(fast_motion.run_fast(unknowns, controllers)).axes
    assert pid.get_ylim() == arc.get_ylim()
    for rest in (rest_of_pid, rest_of_arc):
        assert rest.get_ylim() == (-5.0, 5.0)
        assert sorted(line.get_ydata()[0] for line in rest.lines[1:]) == [-1.0, 1.0]
    assert [axes.get_ylabel().split("\n")[1] for axes in fast_motion.figure_reference().axes] == [
        "(m)",
        "(m/s)",
        "(m/s²)",
    ]


def test_the_printed_robust_terms_cannot_run():
    assert np.isinf(robust_terms.increment(1.0, 2500.0, 1e-6))
    assert np.isinf(robust_terms.increment(1e-2, 2500.0, 1e-6))
    alone = robust_terms.increment(0.0, 2500.0, 1e-6)
    assert alone == pytest.approx(0.050, abs=0.002), "the quantiser alone gives most of the paper's 0.06 V"


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
