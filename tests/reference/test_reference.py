"""References: the shortest time within limits over random moves, and what holds for every motion of the list."""

import math

import numpy as np
import pytest
from scipy.interpolate import CubicHermiteSpline

import cogging
from cogging.files import FieldError
from cogging.simulation.reference import REFERENCES, reference_from, reference_to_dict


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


def test_random_moves_keep_every_limit_and_take_the_shortest_time():
    for move in random_moves(200, seed=1):
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


def test_the_way_back_mirrors_the_way_there_and_rests_are_rests_to_the_bit():
    for move in random_moves(40, seed=4):
        reference = point_to_point(**move)
        goal, T, half = move["start"] + move["distance"], reference.move_time, reference.period / 2
        t = T * np.random.default_rng(5).uniform(size=20)
        there, back = (np.array(reference.sample(at))[:2] for at in (t, half + t))
        slack = 1e-11 * np.array([[abs(move["start"]) + abs(move["distance"])], [move["velocity"]]])
        assert (np.abs(there + back - [[move["start"] + goal], [0.0]]) <= slack).all(), move
        if move["dwell"] > 1e-6:
            rest = np.linspace(T * (1 + 1e-12), half * (1 - 1e-12), 7)[1:-1]
            for times, place in ((rest, goal), (rest + half, move["start"]), (reference.end + rest, move["start"])):
                x, v, a = reference.sample(times)
                assert (x == x[0]).all(), move
                assert x[0] == pytest.approx(place, rel=0, abs=2 * np.spacing(abs(move["start"]) + 2 * abs(goal))), move
                assert not v.any(), move
                assert not a.any(), move


def uneven_times(seed, count=40):
    return np.cumsum(np.random.default_rng(seed).uniform(0.01, 0.1, count))


def test_sine_is_the_formula():
    reference = cogging.Sine(cogging.SineParameters(center=0.2, amplitude=0.07, frequency=3.5))
    t = np.random.default_rng(5).uniform(0, 5, 200)
    np.testing.assert_allclose(reference.sample(t)[0], 0.2 + 0.07 * np.sin(7 * np.pi * t), rtol=0, atol=1e-14)


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
    outside = cogging.Sampled(t, x, v, a).sample(np.array([t[0] - 1.0, t[-1] + 1.0]))
    np.testing.assert_array_equal(outside, [[x[0], x[-1]], [0.0, 0.0], [0.0, 0.0]])


def test_missing_derivatives_are_of_second_order():
    def worst(count):
        t = np.linspace(0, 1, count)
        _, v, a = cogging.Sampled(t, np.sin(5 * t)).sample(t)
        return (np.abs(v - 5 * np.cos(5 * t)).max(), np.abs(a + 25 * np.sin(5 * t))[2:-2].max())

    coarse, fine = np.array(worst(101)), np.array(worst(201))
    assert (np.log2(coarse / fine) > 1.8).all()
    # Given velocities are used for the acceleration, not differentiated again from positions.
    t = uneven_times(11)
    _, _, a = cogging.Sampled(t, np.zeros_like(t), 4 * t).sample(t)
    np.testing.assert_allclose(a, 4.0, rtol=0, atol=1e-10)


EVERY = pytest.mark.parametrize("kind", REFERENCES)


def made(kind, seed):
    """A motion with fields drawn about their defaults: numbers by up to a factor of 2, counts as they are."""
    struct, motion = REFERENCES[kind]
    rng = np.random.default_rng([seed, *kind.encode()])
    drawn = {
        name: value * float(rng.uniform(0.5, 2.0))
        for name, value in struct().to_dict().items()
        if isinstance(value, float) and math.isfinite(value)
    }
    return motion(struct(**drawn))


@EVERY
@pytest.mark.parametrize("seed", range(3))
def test_velocity_and_acceleration_are_derivatives(kind, seed):
    """By central differences, but for the few places at which a piece of the motion ends."""
    motion, step = made(kind, seed), 1e-5
    end = min(motion.end, 3.0 * min(motion.period, 1.0))
    times = np.random.default_rng(seed).uniform(step, end - step, 500)
    before, at, after = (motion.sample(times + shift) for shift in (-step, 0.0, step))
    for i in range(2):
        slope = (after[i] - before[i]) / (2.0 * step)
        assert np.quantile(np.abs(slope - at[i + 1]), 0.97) < 1e-4 * np.abs(at[i + 1]).max() + 1e-8
    assert np.abs(at[1]).max() > 0.0


@EVERY
def test_end_and_period(kind):
    motion = made(kind, 7)
    if math.isfinite(motion.end):
        position, velocity, acceleration = motion.sample(motion.end + np.array([0.0, 0.1, 10.0]))
        assert not np.ptp(position)
        assert not velocity.any()
        assert not acceleration.any()
    if math.isfinite(motion.period):
        last = motion.end if math.isfinite(motion.end) else 50.0 * motion.period  # any start-up has died away
        times = last - motion.period * np.linspace(0.01, 0.99, 37)
        struct, again = REFERENCES[kind]
        repeats = {"repeats": 2} if "repeats" in struct.FIELDS else {}
        longer = again(motion.parameters.replace(**repeats))
        for first, second in zip(longer.sample(times), longer.sample(times + motion.period), strict=True):
            np.testing.assert_allclose(first, second, atol=1e-7 * (1e-3 + np.abs(first).max()))


@EVERY
def test_a_file_and_back(kind):
    motion = made(kind, 3)
    fields = reference_to_dict(motion)
    assert fields["type"] == kind == motion.NAME
    again, duration = reference_from({**fields, "duration": 0.5})
    assert (again.parameters, duration) == (motion.parameters, 0.5)
    if math.isfinite(motion.end):
        assert reference_from(fields)[1] == 0.0
    else:
        with pytest.raises(FieldError, match="duration: must be given for a motion without an end, got none"):
            reference_from(fields)
    (entry,) = [
        one for one in cogging.schema()["$defs"]["reference"]["oneOf"] if one["properties"]["type"]["const"] == kind
    ]
    assert set(entry["properties"]) == {"type", "duration", *REFERENCES[kind][0].FIELDS}
    assert ("duration" in entry["required"]) is math.isinf(motion.end)
