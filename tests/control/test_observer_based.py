"""Observer-based cancellation: the controller against matrices, the design against its inequalities."""

from itertools import pairwise

import numpy as np
import pytest
from scipy.linalg import expm

import cogging
from cogging.papers.malaize2009 import linear_motors as malaize2009_setup
from cogging.papers.malaize2009.linear_motors import MOTORS
from studies.malaize2009 import study as malaize2009_study

PERIODS = [0.024, 0.016, 0.012]


def problem(**changes):
    fields = {"periods": PERIODS, "velocity_min": 0.1, "velocity_max": 0.4, "viscous": 1.0, "pole_radius": 465.0}
    return cogging.ObserverProblem(**{**fields, **changes})


class Reset:
    """The start of lambda_0 from the whole history: of each stroke its direction, and its samples in a list."""

    def __init__(self, velocity_min):
        self.velocity_min, self.strokes, self.way = velocity_min, [], 0.0

    def last(self, way):
        """The representative estimate of the latest stroke in a direction, or None.

        It is the last where |a*| was at most its least so far plus a hundredth of its largest so far, of the samples
        above velocity_min if there are any.
        """
        found = [samples for one, samples in self.strokes if one == way and samples]
        if not found:
            return None
        fast = [sample for sample in found[-1] if sample[0] >= self.velocity_min]
        _, acceleration, estimate = np.array(fast or found[-1]).T
        most = np.minimum.accumulate(acceleration) + 0.01 * np.maximum.accumulate(acceleration)
        return estimate[acceleration <= most][-1]

    def begin(self, velocity, estimate):
        way = 0.0 if abs(velocity) <= 1e-3 * self.velocity_min else np.sign(velocity)
        if way == self.way:
            return estimate
        up, down = self.last(1.0), self.last(-1.0)
        self.way = way
        if way:
            self.strokes.append((way, []))
        if up is None and down is None:
            return estimate
        up, down = (-down if up is None else up), (-up if down is None else down)
        return {1.0: up, -1.0: down, 0.0: 0.5 * (up + down)}[way]

    def learn(self, velocity, acceleration, estimate):
        if self.way:
            self.strokes[-1][1].append((abs(velocity), abs(acceleration), estimate))


def literal(p, now, ahead, readings, applied):
    """(6) and (8) with matrices, as the docstring of the controller says, without delay; rows of x*, nu*, a*."""
    n, t_s = len(p.periods), 1.0 / p.sample_rate
    w = 2 * np.pi / np.array(p.periods)
    rotation_generator = np.zeros((2 * n, 2 * n))
    for i in range(n):
        rotation_generator[2 * i, 2 * i + 1], rotation_generator[2 * i + 1, 2 * i] = w[i], -w[i]
    state, reset, mirror = np.zeros(3 + 2 * n), Reset(p.velocity_min), 1.0
    commands = []
    for k, reading in enumerate(readings):
        x, v, a = now[k]
        if k == 0:
            state[0], state[1] = reading, v
        else:
            moved = x - now[k - 1, 0]
            speed, zeta = moved / t_s, state[3:].copy()
            push = applied[k - 1] / p.mass + state[2] + zeta[::2].sum()
            rate = speed * (w @ zeta[1::2])
            curve = -(speed**2) * (w**2 @ zeta[::2])
            acc = push - p.viscous * state[1]
            jerk = rate - p.viscous * acc
            snap = curve - p.viscous * jerk
            state[0] += t_s * state[1] + t_s**2 / 2 * acc + t_s**3 / 6 * jerk
            state[1] += t_s * acc + t_s**2 / 2 * jerk + t_s**3 / 6 * snap
            state[3:] = expm(moved * rotation_generator) @ zeta
        state[2] = reset.begin(v, state[2])
        mirror = reset.way or mirror
        gain = np.array(p.observer_gain)
        gain[4::2] *= mirror
        correction = t_s * gain * (reading - state[0])
        if abs(v) < p.velocity_min:
            correction[3:] = 0.0
        state = state + correction
        reset.learn(v, a, state[2])
        x2, v2, a2 = ahead[k]
        turned = expm((x2 - x) * rotation_generator) @ state[3:]
        force = state[2] + turned[::2].sum()
        u = -p.position_gain * (reading - x) - p.velocity_gain * (state[1] - v) - force + a2 + p.viscous * v2
        commands.append(p.mass * u)
    return np.array(commands), state, reset


@pytest.mark.parametrize(("seed", "velocity_min"), [(1, 0.0), (2, 0.02)])
def test_commands_and_estimates_against_matrices(seed, velocity_min):
    # Strokes of drawn length, direction and speed (below velocity_min too), some without a rest between, some that
    # continue in the same direction; a velocity of rounding size at rest is rest. Readings and applied commands are
    # drawn too.
    random = np.random.default_rng([2009, seed])
    shipped = malaize2009_setup.observer(MOTORS["ironcore"], malaize2009_setup.shipped(MOTORS["ironcore"])).parameters
    p = shipped.replace(mass=0.7, delay=0.0, velocity_min=velocity_min)
    speeds = []
    for _ in range(20):
        top = random.choice([-1.0, 1.0]) * random.choice([0.012, 0.05, 0.2])
        speeds += [top * np.sin(np.linspace(0.0, np.pi, random.integers(20, 120))) ** 2]
        speeds += [1e-18 * random.normal(size=random.choice([0, 1, 40])) * (velocity_min > 0)]
    velocity = np.concatenate([np.zeros(10), *speeds])
    now = np.column_stack([np.cumsum(velocity) / p.sample_rate, velocity, np.gradient(velocity) * p.sample_rate])
    ahead = np.concatenate([now[3:], np.repeat(now[-1:], 3, axis=0)])
    controller = cogging.ObserverBased(p)
    readings = now[:, 0] + 1e-6 * random.normal(size=len(now))
    applied = np.cumsum(random.normal(size=len(now))) * 0.1
    found = []
    for k in range(len(now)):
        found.append(controller.command(reference=list(now[k]), ahead=list(ahead[k]), reading=readings[k]))
        controller.update(applied[k])
    expected, state, reset = literal(p, now, ahead, readings, applied)
    np.testing.assert_allclose(found, expected, rtol=1e-7, atol=1e-7 * np.abs(expected).max())
    np.testing.assert_allclose(controller.estimates, state, rtol=1e-6, atol=1e-7 * np.abs(state).max())
    ways = [way for way, _ in reset.strokes]
    assert min(ways.count(1.0), ways.count(-1.0)) >= 2
    assert any(one == other for one, other in pairwise(ways))
    assert {max(speed for speed, *_ in learnt) < 0.02 for _, learnt in reset.strokes} == {False, True}


@pytest.fixture(scope="module")
def design():
    return cogging.design_observer(problem())


def test_the_design_is_certified_by_its_inequalities(design):
    task = problem()
    assert design.inequality_margin < 0
    assert design.slowest_pole < -task.decay_rate
    assert design.slowest_pole_at_rest < 0
    assert design.condition < 1e4
    # gamma_c against the state space: the norm of C_c (s - alpha - A + B L)^-1 B.
    a = np.array([[0.0, 1.0], [-(task.omega**2), -2 * task.omega]]) + task.decay_rate * np.eye(2)
    omega = np.concatenate([[0.0], np.logspace(-2, 5, 2001)])
    gain = [abs(np.linalg.solve(1j * w * np.eye(2) - a, [0.0, 1.0])[1]) for w in omega]
    assert design.gamma_c == pytest.approx(max(gain), rel=1e-4)
    assert design.gamma_n == pytest.approx(1 / (2 * np.pi * design.gamma_c * design.gamma_o), rel=1e-12)
    inverse = 1 / np.array(PERIODS)
    assert design.lambda_equal * np.sqrt(np.sum(inverse**2)) == pytest.approx(design.gamma_n, rel=1e-12)
    assert design.lambda_alone * inverse.max() == pytest.approx(design.gamma_n, rel=1e-12)


def test_the_frozen_observer_has_the_certified_gain(design):
    # gamma_o bounds the gain from B_o u to z_o = (L_nu nu~ + C_N zeta~) at any frozen velocity, with the decay rate.
    task = problem()
    n = len(PERIODS)
    for velocity in (0.1, 0.23, 0.4):
        a = np.zeros((2 * n + 3, 2 * n + 3))
        a[0, 1], a[1, 1], a[1, 2] = 1.0, -1.0, 1.0
        for row, period in zip(range(3, 2 * n + 3, 2), PERIODS, strict=True):
            a[1, row] = 1.0
            a[row, row + 1], a[row + 1, row] = 2 * np.pi * velocity / period * np.array([1.0, -1.0])
        a[:, 0] -= design.observer_gain
        c_o = np.array([0.0, design.velocity_gain, 1.0] + [1.0, 0.0] * n)
        b_o = np.eye(2 * n + 3)[:, 3:]
        worst = 0.0
        for w in np.linspace(0.0, 1500.0, 301):
            response = c_o @ np.linalg.solve((1j * w - task.decay_rate) * np.eye(2 * n + 3) - a, b_o)
            worst = max(worst, np.linalg.norm(response))
        assert worst < design.gamma_o
        assert np.abs(np.linalg.eigvals(a)).max() < task.pole_radius * (1 + 1e-9)


def test_random_machines_decay_as_certified(design):
    assert min(malaize2009_study.decay(MOTORS["ironcore"], design, seed) for seed in range(2)) > 3.0


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ({"periods": [0.02, 0.0]}, "periods: each must be above 0, got 0.0"),
        ({"velocity_min": 0.0}, "velocity_min: must be above 0: at rest zeta is not observable"),
        ({"decay_rate": 130.0}, "decay_rate: must be below 120 1/s, the position loop's slowest pole, got 130.0"),
        ({"decay_rate": 60.0, "periods": [0.02]}, r"decay_rate: must be at most [0-9.]+ 1/s .* got 60"),
    ],
)
def test_design_rules(change, message):
    with pytest.raises(ValueError, match=message):
        cogging.design_observer(problem(**change))
