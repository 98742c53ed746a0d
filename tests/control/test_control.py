"""Controllers against literal transcriptions of their equations.

Theorem 1 and matrix (29) on drawn machines: tests/papers/test_lu2008_claims.py.
"""

import itertools
import math

import numpy as np
import pytest
from scipy.interpolate import BSpline as ScipySpline

import cogging
from cogging.model.model import CONTROLLERS


def friction_sign(v, width):
    return 2 / np.pi * math.atan(v / width) if width > 0 else float(np.sign(v))


def random_motion(seed, samples, sample_rate, wobble=1e-4):
    """A reference with its derivatives and a reading near it: whatever a controller may be fed."""
    rng = np.random.default_rng(seed)
    t = np.arange(samples) / sample_rate
    f, phase = rng.uniform(1, 20, 3), rng.uniform(0, 2 * np.pi, 3)
    amplitude = rng.uniform(0.01, 0.05, 3)
    w = 2 * np.pi * f[:, None]
    x = 0.2 + amplitude @ np.sin(w * t + phase[:, None])
    v = amplitude @ (w * np.cos(w * t + phase[:, None]))
    a = amplitude @ (-(w**2) * np.sin(w * t + phase[:, None]))
    reading = x + wobble * np.cumsum(rng.normal(size=samples)) / np.sqrt(samples)
    reading[rng.integers(0, samples, samples // 10)] += 3 * wobble  # and jumps
    return x, v, a, reading


def drive(controller, motion, limit=0.0):
    """Commands as computed and as applied."""
    computed, applied = [], []
    for x, v, a, reading in zip(*motion, strict=True):
        u = controller.command(reference=x, reference_velocity=v, reference_acceleration=a, reading=reading)
        computed.append(u)
        applied.append(min(max(u, -limit), limit) if limit > 0 else u)
        controller.update(applied[-1])
    return np.array(computed), np.array(applied)


# PID, cascade and speed ---------------------------------------------------------------------------------------------


def literal(kind, q, motion, limit=0.0):
    """The formulas of the contract. The sum of `pid` is held where the command is cut and the error pushes further;
    the command of `speed` is moved in time: means over fine pieces of a sample."""
    Ts, total, e_prev, y_prev, commands = 1 / q["sample_rate"], 0.0, None, None, []
    for x, v, a, y in zip(*motion, strict=True):
        e = y - x
        measured = 0.0 if y_prev is None else (y - y_prev) / Ts
        rate = 0.0 if e_prev is None else (e - e_prev) / Ts
        forward = measured if q["feedforward_velocity"] == "measured" else v
        u = q["mass"] * a + q["viscous"] * forward + q["coulomb"] * friction_sign(forward, q["coulomb_width"])
        if kind == "pid":
            u -= q["kp"] * e + q["ki"] * (total + e * Ts) + q["kd"] * rate
            upwards, is_cut = -q["ki"] * e > 0, abs(u) > limit > 0
            total += 0.0 if is_cut and (u > 0) == upwards else e * Ts
        elif kind == "cascade":
            u += q["kv"] * (-q["kp"] * e - measured)
        else:
            u += q["kp"] * (v - measured)
        e_prev, y_prev = e, y
        commands.append(u)
    if kind != "speed":
        return np.array(commands)
    pieces = 1000
    moved = np.concatenate([np.zeros(round(q["delay"] / Ts * pieces)), np.repeat(commands, pieces)])
    return moved[: pieces * len(commands)].reshape(-1, pieces).mean(axis=1)


FEEDFORWARD = {"mass": 0.12, "viscous": 0.166, "coulomb": 0.15}
LAWS = [
    ("pid", {"sample_rate": 5000.0, "kp": 9600.0, "ki": 1e5, "kd": 48.0}),
    ("pid", {"sample_rate": 5000.0, "kp": 9600.0, "ki": 1e5, "kd": 48.0, "command_limit": 30.0}),
    ("cascade", {"sample_rate": 2000.0, "kp": 80.0, "kv": 12.0}),
    *(("speed", {"sample_rate": 1000.0, "kp": 0.09, "delay": d}) for d in (0.0, 0.7e-3, 3.25e-3)),
]


@pytest.mark.parametrize(("kind", "gains"), LAWS)
@pytest.mark.parametrize(("velocity", "width"), [("reference", 1.11e-3), ("measured", 0.0)])
def test_the_command_is_the_formula_of_the_contract(kind, gains, velocity, width):
    struct, make = CONTROLLERS[kind]
    q = FEEDFORWARD | gains | {"coulomb_width": width, "feedforward_velocity": velocity}
    limit = q.get("command_limit", 0.0)
    motion = random_motion(5, 500, q["sample_rate"])
    computed, applied = drive(make(struct(**q)), motion, limit)
    expected = literal(kind, q, motion, limit)
    assert np.abs(expected).max() > 0.1
    assert limit == 0.0 or 0.05 < (computed != applied).mean() < 0.95
    tolerance = 1e-9 if limit else 1e-10 if kind == "pid" else 1e-11
    np.testing.assert_allclose(computed, expected, rtol=0, atol=tolerance * np.abs(expected).max())


# The adaptive robust laws ----------------------------------------------------------------------------------

NAMES = ("mass", "viscous", "coulomb", "disturbance")


def random_parameters(rng, **changes):
    """Any bounds, gains, harmonics and splines."""
    q = {
        "sample_rate": float(rng.choice([1000.0, 5000.0, 20000.0])),
        "error_gain": float(rng.uniform(20, 300)),
        "feedback_gain": float(rng.uniform(5, 100)),
        "coulomb_width": float(rng.choice([0.0, 10 ** rng.uniform(-4, -1)])),
        "error_difference": bool(rng.integers(2)),
    }
    for name in NAMES:
        low = float(rng.uniform(0.05, 0.3)) - (name == "disturbance") * 0.5
        high = low + float(rng.uniform(0.0, 0.5))
        q[name + "_bounds"] = [low, high]
        q[name] = float(np.clip(rng.uniform(low, high), low, high))
        q[name + "_adaptation"] = float(rng.choice([0.0, 10 ** rng.uniform(-1, 2)]))
    if rng.uniform() < 0.8:
        order = int(rng.integers(1, 5))
        points = int(rng.choice([1, order + 1, 11]))
        harmonics = [int(h) for h in rng.choice(np.arange(1, 13), size=rng.integers(1, 5), replace=False)]
        q |= {
            "cogging_pitch": 0.05,
            "cogging_harmonics": harmonics,
            "cogging_order": order,
            "cogging_origin": float(rng.uniform(-0.05, 0.05)),
            "cogging_control_points": max(points, order) if points > 1 else 1,
            "cogging_bounds": [-0.1, float(rng.uniform(0.05, 0.2))],
            "cogging_adaptation": float(rng.choice([0.0, 10 ** rng.uniform(0, 3)])),
        }
        if rng.uniform() < 0.5:
            count = 2 * len(harmonics) * q["cogging_control_points"]
            q["cogging_estimates"] = [float(c) for c in rng.uniform(-0.1, 0.05, count)]
    return q | changes


class LiteralAdaptiveRobust:
    """Eq. 13 to 19, 21 and 26 to 28, dense: theta = [M, B, A_f, A_r, -d_n], phi of the same length, u_s2 = 0."""

    def __init__(self, q, desired):
        self.q, self.desired = q, desired
        self.points = q.get("cogging_control_points", 1)
        self.order = q.get("cogging_order", 3) if self.points > 1 else 1
        self.harmonics = q.get("cogging_harmonics", [])
        count = 2 * len(self.harmonics) * self.points
        initial = q.get("cogging_estimates") or [0.0] * count
        bounds = [q["mass_bounds"], q["viscous_bounds"], q["coulomb_bounds"]]
        bounds += [q.get("cogging_bounds", [-0.1, 0.1])] * count
        bounds += [[-q["disturbance_bounds"][1], -q["disturbance_bounds"][0]]]
        self.low, self.high = np.array(bounds, dtype=float).T
        gains = [q[n + "_adaptation"] for n in NAMES[:3]] + [q.get("cogging_adaptation", 0.0)] * count
        self.gamma = np.array([*gains, q["disturbance_adaptation"]])
        self.theta = np.array([q["mass"], q["viscous"], q["coulomb"], *initial, -q["disturbance"]])
        self.Ts, self.y_prev, self.e_prev = 1 / q["sample_rate"], None, None

    def S_r(self, x):
        P = self.q.get("cogging_pitch", 0.05)
        if self.points == 1:
            N = np.ones(1)
        else:
            knots = self.q["cogging_origin"] + P * np.arange(1 - self.order, self.points + 1)
            inside = np.clip(x, knots[self.order - 1], knots[self.points])
            N = ScipySpline.design_matrix([inside], knots, self.order - 1).toarray()[0]
        angle = 2 * np.pi * np.array(self.harmonics) * x / P
        return np.outer(N, np.stack([np.sin(angle), np.cos(angle)], axis=1).ravel()).ravel()

    def regress(self, x_d, v_d, a_d, y):
        """Sets p (eq. 15) and phi (after eq. 16, or after eq. 28 at the desired trajectory)."""
        x_2 = 0.0 if self.y_prev is None else (y - self.y_prev) / self.Ts  # backward difference
        self.y_prev = y
        k_1 = self.q["error_gain"]
        e, e_dot = y - x_d, x_2 - v_d
        if self.q["error_difference"]:
            e_dot = 0.0 if self.e_prev is None else (e - self.e_prev) / self.Ts
        self.e_prev = e
        self.p = e_dot + k_1 * e
        x_2eq_dot = a_d - k_1 * e_dot
        a, v, x = (a_d, v_d, x_d) if self.desired else (x_2eq_dot, x_2, y)
        S_f = friction_sign(v, self.q["coulomb_width"])
        self.phi = np.concatenate([[-a, -v, -S_f], -self.S_r(x), [-1.0]])

    def command(self):
        return -self.phi @ self.theta - self.q["feedback_gain"] * self.p  # u_a + u_s1

    def update(self):
        rate = self.gamma * self.phi * self.p  # Gamma tau, tau = phi p
        rate = np.where((self.theta >= self.high) & (rate > 0), 0.0, rate)
        rate = np.where((self.theta <= self.low) & (rate < 0), 0.0, rate)
        self.theta = np.clip(self.theta + self.Ts * rate, self.low, self.high)

    def estimates(self, theta=None):
        """In the order of the package: mass, viscous, coulomb, d_n, then A_r."""
        theta = self.theta if theta is None else theta
        return np.concatenate([theta[:3], [-theta[-1]], theta[3:-1]])


ADAPTIVE = [pytest.param(cogging.Arc, False, id="arc"), pytest.param(cogging.Dcarc, True, id="dcarc")]


@pytest.mark.parametrize(("law", "desired"), ADAPTIVE)
def test_the_law_is_the_paper_step_by_step(law, desired):
    """And estimates stay within their bounds with gains by which one Euler step overshoots them by far."""
    rng = np.random.default_rng(20)
    moved, touched = np.zeros(5), 0
    for machine in range(24):
        q, overshoots = random_parameters(rng), machine % 4 == 0
        if overshoots:
            q |= {name: float(10 ** rng.uniform(1, 6)) for name in q if name.endswith("_adaptation")}
        controller = law(cogging.AdaptiveRobustParameters(**q))
        literal = LiteralAdaptiveRobust(q, desired)
        np.testing.assert_array_equal(controller.estimates, literal.estimates())
        first, commands, estimates = literal.estimates(), [], []
        for x, v, a, y in zip(*random_motion(100 + machine, 150, q["sample_rate"]), strict=True):
            u = controller.command(reference=x, reference_velocity=v, reference_acceleration=a, reading=y)
            literal.regress(x, v, a, y)
            size = np.abs(literal.phi * literal.theta).sum() + abs(q["feedback_gain"] * literal.p)
            commands.append((u, literal.command(), size))
            controller.update(u)
            literal.update()
            estimates.append((controller.estimates, literal.estimates()))
        found, expected = np.swapaxes(estimates, 0, 1)
        if overshoots:
            ends = np.sort([literal.estimates(literal.low), literal.estimates(literal.high)], axis=0)
            assert ((found >= ends[0]) & (found <= ends[1])).all(), q
            touched += np.count_nonzero((found == ends[0]) | (found == ends[1]))
            continue
        np.testing.assert_allclose(found, expected, rtol=0, atol=1e-10, err_msg=str(q))
        found, expected, size = np.transpose(commands)
        assert (np.abs(found - expected) <= 1e-10 * size).all(), q
        change = np.abs(literal.estimates() - first)
        moved[:4] += change[:4] > 1e-3
        moved[4] += (change[4:] > 1e-3).any()
    assert (moved >= 2).all()  # every kind of parameter was adapted
    assert touched > 500


def test_projection_is_eq_14():
    rng = np.random.default_rng(14)
    bounds = [
        (low, low + width) for low, width in zip(rng.uniform(-10, 10, 20), [0.0, *rng.uniform(0, 10, 19)], strict=True)
    ]
    for (low, high), rate in itertools.product(bounds, [0.0, *rng.uniform(-1e3, 1e3, 9)]):
        for estimate in (low, low + 0.3 * (high - low), high):
            leaves = (estimate == high and rate > 0) or (estimate == low and rate < 0)
            assert cogging.project(rate, estimate, low, high) == (0.0 if leaves else rate)


@pytest.mark.parametrize(("law", "desired"), ADAPTIVE)
def test_the_robust_term_satisfies_20_and_30(law, desired):
    """p (u_s2 - phi^T theta_tilde + d) <= epsilon for every theta and d in the bounds, and p u_s2 <= 0."""
    rng = np.random.default_rng(22)
    closest = -math.inf
    for machine in range(12):
        off = {name + "_adaptation": 0.0 for name in (*NAMES, "cogging")}
        q = random_parameters(rng, **off)
        epsilon, delta = float(10 ** rng.uniform(-4, 1)), float(rng.choice([0.0, rng.uniform(0, 2)]))
        on = q | {"epsilon": epsilon, "disturbance_bound": delta}
        bounded = q | {"disturbance_bound": delta}  # without epsilon there is no robust term
        plain, robust = (law(cogging.AdaptiveRobustParameters(**parameters)) for parameters in (bounded, on))
        literal = LiteralAdaptiveRobust(q, desired)
        motion = random_motion(300 + machine, 60, q["sample_rate"], wobble=10 ** rng.uniform(-7, -3))
        for x, v, a, y in zip(*motion, strict=True):
            sample = {"reference": x, "reference_velocity": v, "reference_acceleration": a, "reading": y}
            u = plain.command(**sample)
            u_s2 = robust.command(**sample) - u
            literal.regress(x, v, a, y)
            p, phi = literal.p, literal.phi
            rounding = 1e-15 * (abs(u) + abs(u_s2)) * 8
            assert p * u_s2 <= abs(p) * rounding, on
            # The worst theta of the box stands at the end that -p phi (theta_hat - theta) prefers.
            worst = np.maximum(p * phi * (literal.low - literal.theta), p * phi * (literal.high - literal.theta))
            worst_case = p * u_s2 + worst.sum() + abs(p) * delta
            assert worst_case <= epsilon * (1 + 1e-12) + abs(p) * rounding, on
            closest = max(closest, worst_case / epsilon)
            theta, d = rng.uniform(literal.low, literal.high), rng.uniform(-delta, delta)
            any_case = p * (u_s2 - phi @ (literal.theta - theta) + d)
            assert any_case <= epsilon * (1 + 1e-12) + abs(p) * rounding, on
    assert closest > 0.3  # it comes near the bound: a term of half the size would fail


def test_friction_slope_max_is_the_slope_at_rest():
    for width in (1e-4, 1 / 900, 0.05):
        step = 1e-6 * width
        assert cogging.friction_slope_max(width) == pytest.approx(friction_sign(step, width) / step, rel=1e-9)


@pytest.mark.parametrize("harmonics", [[1], [1, 6, 12]])
@pytest.mark.parametrize(("order", "points"), [(1, 11), (3, 13), (3, 1)])
def test_cogging_slope_max_bounds_the_slope(harmonics, order, points):
    basis = cogging.SplineHarmonics(pitch=0.05, harmonics=harmonics, order=order, control_points=points)
    bound = cogging.cogging_slope_max(basis, 0.1)
    rng = np.random.default_rng(43)
    x = rng.uniform(0, 0.5, 4000)
    worst = 0.0
    for _ in range(20):
        model = cogging.CoggingModel(basis, *rng.choice([-0.1, 0.1], size=(2, len(harmonics), points)))
        worst = max(worst, np.abs(model.slope(x)).max())
    assert worst <= bound
    assert worst > 0.3 * bound  # and is no empty one
