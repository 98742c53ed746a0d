"""What Malaize and Levine 2009 claim beyond Table I: Theorem 3 and the error equations. Numbers: test_numbers.py."""

import sys

import numpy as np
import pytest

from cogging.papers.malaize2009 import theorem_3
from cogging.papers.malaize2009.linear_motors import DAMPING, MOTORS, OMEGA, VISCOUS, problem, shipped
from tests.fixtures.reproduced import table_of

EACH_MOTOR = pytest.mark.parametrize("motor", MOTORS.values(), ids=MOTORS)


def of_theorem_3(name, index):
    rows = table_of("malaize2009", "theorem_3").rows
    return np.array([row.simulated for row in rows if (row.controller, row.index) == (name, index)])


def test_theorem_3_has_no_minimum_as_printed_and_one_with_bounded_poles():
    # The same problem in three units of time: a minimum would be the same in all.
    stars = of_theorem_3("as printed", "lambda_star")
    assert stars[2] > 5 * stars[1] > 25 * stars[0]
    assert min(of_theorem_3("as printed", "largest_gain")) > 1e13
    poles, radii = of_theorem_3("poles bounded", "fastest_pole"), np.array(theorem_3.RADII)
    assert ((0.95 * radii < poles) & (poles < radii)).all()


@EACH_MOTOR
def test_from_rest_on_theorem_3_is_not_feasible(motor):
    # Drawn P > 0, Q and gamma_o: with nu* = 0 the block has an eigenvalue above 0, at least that of the cosine's minor.
    harmonics, random = len(motor.periods), np.random.default_rng(2009)
    task = problem(motor, 300.0)
    assert theorem_3.unobserved(task, 0.0) == 2 * harmonics
    assert theorem_3.unobserved(task, task.velocity_min) == 0
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
    note = "The table of Theorem 3 is left out: it needs cvxpy, pip install 'cogging[design]'."
    assert theorem_3.further_tables() == ([], [note])


@EACH_MOTOR
def test_the_errors_follow_equations_7_and_9_with_a_minus(motor):
    random = np.random.default_rng([2009, 7])
    task = problem(motor, 1.0)
    amplitudes, phases = random.uniform(0.1, 1.0, len(motor.periods)), random.uniform(0, 2 * np.pi, len(motor.periods))
    x, nu = 0.123, 0.3
    angles = 2 * np.pi * x / np.array(motor.periods) + phases
    zeta = np.concatenate([[0.2], np.column_stack([amplitudes * np.sin(angles), amplitudes * np.cos(angles)]).ravel()])
    truth = np.concatenate([[x, nu], zeta])
    estimate = truth + 0.1 * random.normal(size=truth.size)
    rotation = (task.matrices(1.0)[0] - task.matrices(0.0)[0])[2:, 2:]  # M_N
    a, c, c_o, _ = task.matrices(nu)
    a_star, c, c_o = task.matrices(nu - 0.1)[0], c[0], c_o[0]
    gain, b = np.array(shipped(motor).observer_gain), np.eye(truth.size)[1]
    x_star, nu_star, nu_rate, loop = 0.12, nu - 0.1, 2.0, np.array([OMEGA**2, 2 * DAMPING * OMEGA - VISCOUS])
    errors = np.array([x - x_star, nu - nu_star])
    # (8) with nu_hat and zeta_hat.
    u = -loop @ [errors[0], estimate[1] - nu_star] - estimate[2] - estimate[3::2].sum() + nu_rate + VISCOUS * nu_star
    true_rate = a @ truth + b * u  # (5)
    estimate_rate = a_star @ estimate + b * u + gain * (c @ (truth - estimate))  # (6)
    observed, coupling = estimate - truth, errors[1] * np.eye(truth.size)[:, 2:] @ rotation @ truth[2:]
    closed = (a_star - np.outer(gain, c)) @ observed
    np.testing.assert_allclose(estimate_rate - true_rate, closed - coupling, rtol=1e-9, atol=1e-6)
    assert np.abs(estimate_rate - true_rate - closed - coupling).max() > 1.0  # as printed, with a plus
    a_c, b_c = np.array([[0.0, 1.0], [0.0, -VISCOUS]]), np.array([0.0, 1.0])
    expected = (a_c - np.outer(b_c, loop)) @ errors - b_c * (c_o @ observed)
    np.testing.assert_allclose(true_rate[:2] - [nu_star, nu_rate], expected, rtol=1e-9)
    # The step from the interconnection (10), (11) to (12), (13).
    gamma = np.sqrt(np.sum((amplitudes / np.array(motor.periods)) ** 2))
    assert np.linalg.norm(rotation @ truth[2:]) == pytest.approx(2 * np.pi * gamma, rel=1e-12)


@EACH_MOTOR
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
