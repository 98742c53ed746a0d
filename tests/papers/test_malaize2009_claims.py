"""What Malaize and Levine 2009 claim beyond Table I, and what the table hides: Theorem 3, friction, robustness."""

import sys

import numpy as np
import pytest

from cogging.papers.malaize2009 import theorem_3
from cogging.papers.malaize2009.linear_motors import (
    DAMPING,
    MOTORS,
    OMEGA,
    VISCOUS,
    problem,
    reference,
    shipped,
)
from tests.fixtures.reproduced import table_of


def of_theorem_3(name, index):
    return [
        row.simulated
        for row in table_of("malaize2009", "theorem_3").rows
        if (row.controller, row.index) == (name, index)
    ]


def test_theorem_3_has_no_minimum_as_printed_and_one_with_bounded_poles():
    # The same problem in three units of time: a minimum would be the same in all.
    stars = of_theorem_3("as printed", "lambda_star")
    assert stars[2] > 5 * stars[1] > 25 * stars[0]
    assert min(of_theorem_3("as printed", "largest_gain")) > 1e13
    assert min(of_theorem_3("as printed", "fastest_pole")) > 1e6 * 2 * np.pi
    poles, radii = np.array(of_theorem_3("poles bounded", "fastest_pole")), np.array(theorem_3.RADII)
    assert ((0.95 * radii < poles) & (poles < radii)).all()
    np.testing.assert_allclose(of_theorem_3("poles bounded", "lambda_star"), [2.175, 6.013, 26.0], rtol=0.01)


def test_what_the_printed_theorem_gives_keeps_its_promise():
    # gamma_o of the printed solution bounds the gain from B_o u (lambda_0 driven too) to z_o at frozen velocities.
    motor = MOTORS["ironless"]
    task = problem(motor, 1.0)
    found = theorem_3.as_printed(task, 10.0)
    inverse = np.sqrt(np.sum(1.0 / np.array(motor.periods) ** 2))
    gamma_o = 1.0 / (2 * np.pi * task.closed_loop_norm() * found.lambda_equal * inverse)
    assert found.slowest_pole < -task.decay_rate
    worst = 0.0
    for velocity in (task.velocity_min, task.velocity_max):
        a, c, c_o, _ = task.matrices(velocity)
        closed = a - np.outer(found.gain, c[0]) + task.decay_rate * np.eye(c.size)
        for w in np.concatenate([[0.0], np.geomspace(0.1, 1e5, 400)]):
            response = c_o @ np.linalg.solve(1j * w * np.eye(c.size) - closed, np.eye(c.size)[:, 2:])
            worst = max(worst, float(np.linalg.norm(response)))
    print(f"\ngamma_o {gamma_o:.3g} s, largest gain {worst:.3g} s")
    assert 0.1 * gamma_o < worst < gamma_o


@pytest.mark.parametrize("motor", MOTORS.values(), ids=MOTORS)
def test_from_rest_on_theorem_3_is_not_feasible(motor):
    # Drawn P > 0, Q and gamma_o: with nu* = 0 the block has an eigenvalue above 0, at least that of the cosine's minor.
    harmonics, random = len(motor.periods), np.random.default_rng(2009)
    task = problem(motor, 300.0)
    assert theorem_3.unobserved(task, 0.0) == 2 * harmonics
    assert theorem_3.unobserved(task, task.velocity_min) == 0
    assert of_theorem_3("as printed", "unobserved") == [6.0, 6.0]
    a, c, c_o, b_o = task.matrices(0.0)
    for alpha in (0.0, 0.01):
        for _ in range(20):
            root = random.normal(size=a.shape)
            p, q = root @ root.T, random.normal(size=(c.size, 1))
            square = 10.0 ** random.uniform(-4, 4)
            closed = p @ a - q @ c
            corner = closed + closed.T + c_o.T @ c_o + 2 * alpha * p
            block = np.block([[corner, p @ b_o], [b_o.T @ p, -square * np.eye(b_o.shape[1])]])
            cosine = p[4, 4]
            minor = np.linalg.eigvalsh([[2 * alpha * cosine, cosine], [cosine, -square]]).max()
            assert 0.0 < minor <= np.linalg.eigvalsh(block).max() * (1 + 1e-9)


def test_without_a_solver_the_table_is_left_out_and_a_note_names_the_extra(monkeypatch):
    monkeypatch.setitem(sys.modules, "cvxpy", None)
    tables, notes = theorem_3.further_tables()
    assert tables == []
    assert notes == ["The table of Theorem 3 is left out: it needs cvxpy, pip install 'cogging[design]'."]


def drawn_states(motor, seed):
    """A(nu), A(nu*), C, C_o, M_N, and drawn truth, estimate and their cogging's amplitudes; nu* 0.1 m/s below nu."""
    random = np.random.default_rng([2009, seed])
    task = problem(motor, 1.0)
    amplitudes, phases = random.uniform(0.1, 1.0, len(motor.periods)), random.uniform(0, 2 * np.pi, len(motor.periods))
    x, nu = 0.123, 0.3
    angles = 2 * np.pi * x / np.array(motor.periods) + phases
    zeta = np.concatenate([[0.2], np.column_stack([amplitudes * np.sin(angles), amplitudes * np.cos(angles)]).ravel()])
    truth = np.concatenate([[x, nu], zeta])
    estimate = truth + 0.1 * random.normal(size=truth.size)
    rotation = (task.matrices(1.0)[0] - task.matrices(0.0)[0])[2:, 2:]
    a, c, c_o, _ = task.matrices(nu)
    return a, task.matrices(nu - 0.1)[0], c[0], c_o[0], rotation, truth, estimate, amplitudes


@pytest.mark.parametrize("motor", MOTORS.values(), ids=MOTORS)
def test_the_errors_follow_equations_7_and_9_with_a_minus(motor):
    a, a_star, c, c_o, rotation, truth, estimate, amplitudes = drawn_states(motor, 7)
    gain, harmonics = np.array(shipped(motor).observer_gain), len(motor.periods)
    b, b_o = np.eye(truth.size)[1], np.eye(truth.size)[:, 2:]
    x_star, nu_star, nu_rate, loop = 0.12, truth[1] - 0.1, 2.0, np.array([OMEGA**2, 2 * DAMPING * OMEGA - VISCOUS])
    errors = np.array([truth[0] - x_star, truth[1] - nu_star])
    # (8) with nu_hat and zeta_hat.
    u = -loop @ [errors[0], estimate[1] - nu_star] - estimate[2] - estimate[3::2].sum() + nu_rate + VISCOUS * nu_star
    true_rate = a @ truth + b * u  # (5)
    estimate_rate = a_star @ estimate + b * u + gain * (c @ (truth - estimate))  # (6)
    observed, coupling = estimate - truth, errors[1] * b_o @ rotation @ truth[2:]
    closed = (a_star - np.outer(gain, c)) @ observed
    np.testing.assert_allclose(estimate_rate - true_rate, closed - coupling, rtol=1e-9, atol=1e-6)
    assert np.abs(estimate_rate - true_rate - closed - coupling).max() > 1.0  # as printed, with a plus
    a_c, b_c = np.array([[0.0, 1.0], [0.0, -VISCOUS]]), np.array([0.0, 1.0])
    expected = (a_c - np.outer(b_c, loop)) @ errors - b_c * (c_o @ observed)
    np.testing.assert_allclose(true_rate[:2] - [nu_star, nu_rate], expected, rtol=1e-9)
    # The step from the interconnection (10), (11) to (12), (13).
    gamma = np.sqrt(np.sum((amplitudes / np.array(motor.periods)) ** 2))
    assert np.linalg.norm(rotation @ truth[2:]) == pytest.approx(2 * np.pi * gamma, rel=1e-12)
    assert b_o.shape[1] == 2 * harmonics + 1


@pytest.mark.parametrize("motor", MOTORS.values(), ids=MOTORS)
def test_gamma_c_is_the_least_for_which_14_has_a_solution(motor):
    # (14) has a solution where the Hamiltonian of (A - B L + alpha, B, C_c) has no eigenvalue on the imaginary axis.
    task = problem(motor, 300.0)
    a = np.array([[0.0, 1.0], [-(OMEGA**2), -2 * DAMPING * OMEGA]]) + task.decay_rate * np.eye(2)
    b, c = np.array([[0.0], [1.0]]), np.array([[0.0, 1.0]])
    found = {}
    for share in (0.99, 1.01):
        gamma = share * task.closed_loop_norm()
        poles = np.linalg.eigvals(np.block([[a, b @ b.T / gamma**2], [-c.T @ c, -a.T]]))
        found[share] = np.abs(poles.real).min() / np.abs(poles).max()
    assert found[0.99] < 1e-6
    assert found[1.01] > 1e-2


@pytest.mark.parametrize(("motor", "acceleration"), [("ironcore", 4.0), ("ironless", 2.5)])
def test_the_strokes_have_the_printed_acceleration(motor, acceleration):
    motion = reference(MOTORS[motor])
    _, velocity, found = motion.sample(np.linspace(0.0, motion.period, 20_001))
    assert np.abs(found).max() == pytest.approx(acceleration, rel=1e-9)
    assert velocity.max() == pytest.approx(-velocity.min(), rel=1e-9)
    assert velocity.max() == pytest.approx(MOTORS[motor].velocity, rel=1e-9)


def test_smooth_friction_costs_the_same_in_every_stroke_behind_the_first():
    found = {}
    for row in table_of("malaize2009", "smooth_friction").rows:
        found.setdefault((row.labels["motor"], row.labels["width"]), []).append(row.simulated)
    for strokes in found.values():
        assert strokes[0] > 2 * strokes[1]
        np.testing.assert_allclose(strokes[1:], strokes[-1], rtol=0.2)
