"""Every controller where a sample is not finite (it holds its command, learns nothing, counts, recovers), and at rest.

At rest exactly where a motion began decaying states end at 0, and no state is a denormal number.
"""

import math

import numpy as np
import pytest

from cogging.model.model import CONTROLLERS
from tests.fixtures.covering import covering
from tests.golden.logs import CONTROLLERS as FIELDS

RATE, LIMIT = 5000.0, 4.0
PARAMETERS = {kind: fields | {"command_limit": LIMIT} for kind, fields in FIELDS.items()}
PARAMETERS["speed"]["delay"] = 0.0  # else what is held goes through the delay
OBSERVER = {"periods": [0.05, 0.025], "observer_gain": [600.0, 1.2e5, 8e6, 0.0, 0.0, 0.0, 0.0], "delay": 0.0003}
PARAMETERS["observer_based"] = OBSERVER | {"sample_rate": RATE, "mass": 0.12, "command_limit": LIMIT}
ADAPTATIONS = ("mass", "viscous", "coulomb", "disturbance", "cogging")
#: What must be off for a controller to be a linear law that a gap cannot change.
STILL = {kind: {f"{name}_adaptation": 0.0 for name in ADAPTATIONS} for kind in ("arc", "dcarc")}
STILL["output_feedback_arc"] = {"adaptation": [0.0, 0.0, 0.0]}
FAULTS = [math.nan, math.inf, -math.inf, 1e308, -1e308, 1e12, -math.nan]


def make(kind, **changes):
    struct, controller = CONTROLLERS[kind]
    return controller(struct(**PARAMETERS[kind] | changes))


def ask(controller, point, reading):
    """The command for a reference (position, velocity, acceleration) that continues at the same acceleration."""
    if not hasattr(controller, "preview"):
        return controller.command(point, reading)
    h, (x, v, a) = controller.preview, point
    return controller.command(reference=point, ahead=(x + h * v + 0.5 * h * h * a, v + h * a, a), reading=reading)


def cut(command):
    return min(max(command, -LIMIT), LIMIT)


def motion(samples):
    """A sine from 0.2 m that starts at rest at its lower end: position, velocity, acceleration, (n, 3)."""
    w, t = 2 * np.pi * 2.0, np.arange(samples) / RATE
    sine, cosine = 0.03 * np.sin(w * t), 0.03 * np.cos(w * t)
    return np.stack([0.2 - cosine, w * sine, w * w * cosine], axis=1).tolist()


@pytest.mark.parametrize(("kind", "seed"), covering(CONTROLLERS, range(2)))
def test_a_refused_sample_is_counted_and_teaches_nothing(kind, seed):
    """Whichever of reading, position, velocity and acceleration is at fault; that all come back: tests/cpp/soak.cpp."""
    controller, rng, last, refused = make(kind), np.random.default_rng(seed), 0.0, 0
    for point in motion(1000):
        values, learned = [*point, point[0] + 1e-6 * rng.normal()], controller.estimates
        is_faulty = rng.random() < 0.3
        if is_faulty:
            values[rng.integers(4)] = FAULTS[rng.integers(len(FAULTS))]
        command = ask(controller, values[:3], values[3])
        controller.update(cut(command))
        refused += is_faulty
        assert controller.samples_refused == refused
        assert math.isfinite(command)
        if is_faulty:
            assert command == cut(last)
            np.testing.assert_array_equal(controller.estimates, learned)
        last = command


@pytest.mark.parametrize(("kind", "length"), covering(CONTROLLERS, [1, 2, 7, 16]))
def test_the_step_behind_a_gap_does_not_kick(kind, length):
    """Along a line a gap in reading or reference changes no later command: velocities are over all samples passed."""
    whole, gappy = (make(kind, **STILL.get(kind, {})) for _ in range(2))
    speed, start = 0.21, int(np.random.default_rng(length).integers(20, 60))
    expected, found = [], []
    for k in range(120):
        x = 0.1 + speed * k / RATE
        expected.append(ask(whole, (x, speed, 0.0), x))
        lost = ("reading", "reference")[k % 2] if start <= k < start + length else ""
        point, reading = (math.nan if lost == "reference" else x, speed, 0.0), math.nan if lost == "reading" else x
        found.append(ask(gappy, point, reading))
        whole.update(0.0)
        gappy.update(0.0)
    behind = slice(start + length, None)
    np.testing.assert_allclose(found[behind], expected[behind], rtol=1e-7, atol=1e-9)
    np.testing.assert_array_equal(found[start : start + length], np.full(length, cut(expected[start - 1])))


@pytest.mark.parametrize("kind", CONTROLLERS)
def test_a_gap_at_the_start_changes_nothing(kind):
    late, fresh = make(kind), make(kind)
    points = motion(300)
    for fault in FAULTS:
        assert ask(late, points[0], fault) == 0.0
        late.update(fault)
    rng = np.random.default_rng(3)
    for point in points:
        reading = point[0] + 1e-6 * rng.normal()
        command = ask(fresh, point, reading)
        assert ask(late, point, reading) == command
        for controller in (late, fresh):
            controller.update(cut(command))
    np.testing.assert_array_equal(late.estimates, fresh.estimates)
    assert (late.samples_refused, fresh.samples_refused) == (len(FAULTS), 0)


@pytest.mark.parametrize(("kind", "fault"), covering(CONTROLLERS, FAULTS))
def test_an_applied_command_that_is_not_finite_is_replaced_by_the_computed_one(kind, fault):
    one, other = make(kind, command_limit=0.05), make(kind, command_limit=0.05)
    rng = np.random.default_rng(1)
    for k, point in enumerate(motion(200)):
        reading = point[0] + 1e-5 * rng.normal()
        command = ask(one, point, reading)
        assert ask(other, point, reading) == command
        applied = min(max(command, -0.05), 0.05)
        one.update(applied)
        other.update(fault if k % 3 == 0 else applied)
    assert other.samples_refused == 0


def states_at_rest(kind, start):
    """The states of a controller, ten times a second over 5 s after a drawn motion from `start`."""
    rng = np.random.default_rng([*kind.encode()])
    struct, made = CONTROLLERS[kind]
    controller = made(struct(**FIELDS[kind]))
    count, (size, turns) = 2000, rng.uniform([1e-3, 1.0], [2e-2, 3.0])
    w, t = 2 * np.pi * round(turns) * RATE / count, np.arange(count) / RATE
    lags = 0.5e-6 * rng.integers(-4, 5, count)
    lags[0] = 0.0  # positions of the output feedback count from here
    for time, lag in zip(t, lags, strict=True):
        x = size * (1 - np.cos(w * time))
        point = (start + x, size * w * np.sin(w * time), size * w**2 * np.cos(w * time))
        controller.update(ask(controller, point, start + x + lag))
    states = []
    for k in range(int(5 * RATE)):
        controller.update(ask(controller, (start, 0.0, 0.0), start))
        if k % 500 == 0:
            states.append(controller.__getstate__()[1])
    return np.array(states)


@pytest.mark.parametrize(("kind", "start"), covering(FIELDS, [0.0, 0.2]))
def test_no_state_is_denormal(kind, start):
    states = states_at_rest(kind, start)
    size = np.abs(states)
    assert np.isfinite(size).all()
    assert not ((size > 0.0) & (size < np.finfo(float).tiny)).any()
    if kind == "output_feedback_arc":  # eta falls by 1/e in 5 ms: after 5 s it would be exp(-1000) of what it was
        assert np.count_nonzero((states[0] != 0.0) & (states[-1] == 0.0)) >= (2 if start else 0)
        assert size[-1].max() > 0.1
