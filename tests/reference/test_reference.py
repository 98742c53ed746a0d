"""References: limits, rest, continuity and the shortest time, over thousands of random moves."""

import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.interpolate import CubicHermiteSpline

import cogging


def point_to_point(**changes):
    return cogging.PointToPoint(cogging.PointToPointParameters(**changes))


def random_moves(count, seed):
    """Moves in which each of the three limits binds or does not, in every combination."""
    rng = np.random.default_rng(seed)
    for _ in range(count):
        yield {
            "start": float(rng.uniform(-1, 1)),
            "distance": float(rng.choice([-1, 1]) * 10 ** rng.uniform(-5, 0.5)),
            "velocity": float(10 ** rng.uniform(-2.5, 1)),
            "acceleration": float(10 ** rng.uniform(-1, 2)),
            "jerk": float(rng.choice([math.inf, 10 ** rng.uniform(0, 5)])),
            "dwell": float(rng.choice([0.0, 10 ** rng.uniform(-3, 0)])),
            "repeats": int(rng.integers(1, 4)),
        }


def shortest_time(length, velocity, acceleration, jerk):
    """The least time of a rest-to-rest move: bisection on the peak speed, its ramp in closed form.

    Speeding up from 0 to w and back takes the distance w T(w), T the shortest time of a ramp: the jerk limit
    alone gives T = 2 sqrt(w / j) as long as sqrt(j w) <= a, else T = w / a + a / j.
    """

    def ramp(w):
        if math.isinf(jerk):
            return w / acceleration
        if math.sqrt(jerk * w) <= acceleration:
            return 2 * math.sqrt(w / jerk)
        return w / acceleration + acceleration / jerk

    low, high = 0.0, velocity
    if velocity * ramp(velocity) <= length:
        low = velocity
    else:
        for _ in range(200):
            middle = 0.5 * (low + high)
            low, high = (middle, high) if middle * ramp(middle) <= length else (low, middle)
    return 2 * ramp(low) + (length - low * ramp(low)) / low


# Point to point --------------------------------------------------------------------------------------------


def test_random_moves_keep_every_limit_and_take_the_shortest_time():
    for move in random_moves(2000, seed=1):
        reference = point_to_point(**move)
        length, v, a, j = abs(move["distance"]), move["velocity"], move["acceleration"], move["jerk"]
        T = reference.move_time
        assert pytest.approx(shortest_time(length, v, a, j), rel=1e-9) == T, move
        assert reference.period == pytest.approx(2 * (T + move["dwell"]), rel=1e-14), move
        assert reference.end == pytest.approx(move["repeats"] * reference.period, rel=1e-14), move

        t = np.linspace(0, T, 400)
        x, velocity, acceleration = reference.sample(t)
        scale = abs(move["start"]) + length
        low, high = sorted((move["start"], move["start"] + move["distance"]))
        assert x.min() >= low - 4e-16 * scale, move
        assert x.max() <= high + 4e-16 * scale, move
        forward = velocity * np.sign(move["distance"])
        assert forward.min() >= -1e-12 * v, move  # never turns back
        assert forward.max() <= v * (1 + 1e-12), move
        assert np.abs(acceleration).max() <= a * (1 + 1e-12), move
        if math.isfinite(j):
            slope = np.abs(np.diff(acceleration)) / np.diff(t)
            assert slope.max() <= j * (1 + 1e-9) + 1e-13 * a / T, move

        # At rest at both ends, and at the goal.
        x, velocity, acceleration = reference.sample(np.array([0.0, T]))
        np.testing.assert_allclose(x, [move["start"], move["start"] + move["distance"]], rtol=0, atol=4e-16 * scale)
        assert (velocity == 0.0).all(), move
        if math.isfinite(j):
            np.testing.assert_allclose(acceleration, 0.0, atol=1e-12 * a, err_msg=str(move))


def test_velocity_and_acceleration_are_the_derivatives():
    for move in random_moves(200, seed=3):
        reference = point_to_point(**move)
        T = reference.move_time
        t = np.linspace(0, T, 4001)
        h = t[1]
        x, v, a = reference.sample(t)
        middle = 0.5 * (t[1:] + t[:-1])
        _, v_middle, a_middle = reference.sample(middle)
        limit = move["acceleration"]
        # Simpson is exact for the cubic pieces; an interval with a switch errs by the jump in the next
        # derivative: of the jerk, 2 j, or of the acceleration, 2 a, where the jerk is infinite.
        jump = min(move["jerk"] * h, 2 * limit)
        rounding = 4 * np.spacing(np.abs(x).max()) + 1e-12 * h * np.abs(v).max()
        moved = np.abs(np.diff(x) - h / 6 * (v[1:] + 4 * v_middle + v[:-1]))
        assert moved.max() <= jump * h**2 + rounding, move
        gained = np.abs(np.diff(v) - h / 6 * (a[1:] + 4 * a_middle + a[:-1]))
        assert gained.max() <= jump * h + 1e-15 * limit, move
        assert (moved > rounding).sum() <= 8, move  # eight switches of the jerk


@given(
    distance=st.floats(1e-4, 1.0),
    sign=st.sampled_from([-1, 1]),
    dwell=st.floats(0, 0.5),
    jerk=st.one_of(st.just(math.inf), st.floats(1.0, 1e5)),
    fraction=st.floats(0, 1),
)
@settings(deadline=None, derandomize=True, max_examples=300)
def test_there_and_back_mirror_each_other(distance, sign, dwell, jerk, fraction):
    start = 0.25
    reference = point_to_point(
        start=start, distance=sign * distance, velocity=0.3, acceleration=4.0, jerk=jerk, dwell=dwell, repeats=3
    )
    T, half = reference.move_time, reference.period / 2
    t = fraction * T
    x, v, a = reference.sample(np.array([t, T - t, half + t]))
    slack = 1e-12
    # The second half of a move is the first mirrored; the way back is the way there with the other sign.
    assert x[0] + x[1] == pytest.approx(2 * start + sign * distance, abs=slack)
    assert v[0] == pytest.approx(v[1], abs=slack * 10)
    assert x[0] - start == pytest.approx(start + sign * distance - x[2], abs=slack)
    assert v[0] == pytest.approx(-v[2], abs=slack * 10)
    if math.isfinite(jerk):
        assert a[0] == pytest.approx(-a[1], abs=1e-9 + jerk * slack)
        assert a[0] == pytest.approx(-a[2], abs=1e-9 + jerk * slack)
    # Both rests are rests, to the bit, and at their place up to one rounding.
    rest = np.linspace(T * (1 + 1e-12), half * (1 - 1e-12), 7)[1:-1] if dwell > 1e-6 else np.array([])
    for time, place in ((rest, start + sign * distance), (rest + half, start)):
        x, v, a = reference.sample(time)
        assert (x == x[:1]).all()
        np.testing.assert_allclose(x, place, rtol=0, atol=np.spacing(1.25))
        assert (v == 0.0).all()
        assert (a == 0.0).all()
    # Each repetition is the first.
    first = np.array(reference.sample(np.array([t, half + t])))
    for repeat in (1, 2):
        again = np.array(reference.sample(np.array([t, half + t]) + repeat * reference.period))
        np.testing.assert_allclose(again[:2], first[:2], rtol=0, atol=1e-12)


def test_before_and_after_the_motion_it_rests_at_the_start():
    reference = point_to_point(start=0.1, distance=-0.05, velocity=1.0, acceleration=3.0, repeats=2)
    x, v, a = reference.sample(np.array([-1.0, 0.0, reference.end, reference.end + 1e6]))
    assert (x == 0.1).all()
    assert (v == 0.0).all()
    assert (a == 0.0).all()


# Sine ------------------------------------------------------------------------------------------------------


def test_sine_is_the_formula():
    reference = cogging.Sine(cogging.SineParameters(center=0.2, amplitude=0.07, frequency=3.5))
    t = np.random.default_rng(5).uniform(0, 5, 200)
    x, v, a = reference.sample(t)
    w = 2 * np.pi * 3.5
    np.testing.assert_allclose(x, 0.2 + 0.07 * np.sin(w * t), rtol=0, atol=1e-14)
    np.testing.assert_allclose(v, 0.07 * w * np.cos(w * t), rtol=0, atol=1e-13)
    np.testing.assert_allclose(a, -0.07 * w**2 * np.sin(w * t), rtol=0, atol=1e-11)
    assert reference.end == math.inf


# Sampled ---------------------------------------------------------------------------------------------------


def uneven_times(seed, count=40):
    return np.cumsum(np.random.default_rng(seed).uniform(0.01, 0.1, count))


def test_a_sampled_parabola_is_exact():
    t = uneven_times(6)
    reference = cogging.Sampled(t, 0.1 - 0.3 * t + 0.7 * t**2)
    inside = np.random.default_rng(7).uniform(t[0], t[-1], 300)
    x, v, a = reference.sample(inside)
    np.testing.assert_allclose(x, 0.1 - 0.3 * inside + 0.7 * inside**2, rtol=0, atol=1e-12)
    np.testing.assert_allclose(v, -0.3 + 1.4 * inside, rtol=0, atol=1e-11)
    np.testing.assert_allclose(a, 1.4, rtol=0, atol=1e-9)
    assert reference.end == t[-1]


def test_sampled_agrees_at_the_samples():
    t = uneven_times(8)
    x, v, a = np.sin(3 * t), 3 * np.cos(3 * t), -9 * np.sin(3 * t)
    got = cogging.Sampled(t, x, v, a).sample(t)
    for column, given_column in zip(got, (x, v, a), strict=True):
        np.testing.assert_allclose(column, given_column, rtol=0, atol=1e-13)


def test_between_samples_the_position_is_cubic_hermite_and_the_acceleration_linear():
    t = uneven_times(9)
    rng = np.random.default_rng(10)
    x, v, a = rng.normal(size=(3, len(t)))
    inside = rng.uniform(t[0], t[-1], 500)
    got = cogging.Sampled(t, x, v, a).sample(inside)
    hermite = CubicHermiteSpline(t, x, v)
    np.testing.assert_allclose(got[0], hermite(inside), rtol=0, atol=1e-12)
    np.testing.assert_allclose(got[1], hermite(inside, 1), rtol=0, atol=1e-9)
    np.testing.assert_allclose(got[2], np.interp(inside, t, a), rtol=0, atol=1e-12)


def test_missing_derivatives_are_of_second_order():
    def worst(count):
        t = np.linspace(0, 1, count)
        _, v, a = cogging.Sampled(t, np.sin(5 * t)).sample(t)
        inner = slice(2, -2)
        return (np.abs(v - 5 * np.cos(5 * t)).max(), np.abs(a + 25 * np.sin(5 * t))[inner].max())

    coarse, fine = np.array(worst(101)), np.array(worst(201))
    assert (np.log2(coarse / fine) > 1.8).all()
    # Given velocities are used for the acceleration, not differentiated again from positions.
    t = uneven_times(11)
    _, _, a = cogging.Sampled(t, np.zeros_like(t), 4 * t).sample(t)
    np.testing.assert_allclose(a, 4.0, rtol=0, atol=1e-10)


def test_outside_its_samples_it_rests():
    reference = cogging.Sampled([1.0, 2.0, 4.0], [0.1, 0.2, 0.7])
    x, v, a = reference.sample(np.array([0.0, 0.999, 4.001, 9.0]))
    np.testing.assert_array_equal(x, [0.1, 0.1, 0.7, 0.7])
    assert (v == 0.0).all()
    assert (a == 0.0).all()
