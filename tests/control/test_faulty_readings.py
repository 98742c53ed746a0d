"""A sample that is not finite: every controller holds its last command, learns nothing, counts it and recovers."""

import math

import numpy as np
import pytest

from cogging.model.model import CONTROLLERS
from tests.fixtures.covering import covering

RATE, LIMIT, MASS, VISCOUS = 5000.0, 4.0, 0.12, 0.3
FEEDFORWARD = {"mass": MASS, "viscous": VISCOUS, "command_limit": LIMIT, "sample_rate": RATE}
ADAPTATIONS = {"mass_adaptation": 1.0, "viscous_adaptation": 10.0, "coulomb_adaptation": 10.0}
ADAPTATIONS |= {"disturbance_adaptation": 1000.0, "cogging_adaptation": 100.0}
ADAPTIVE = {"cogging_harmonics": [1, 2], "cogging_control_points": 9, "epsilon": 0.1} | ADAPTATIONS | FEEDFORWARD
OBSERVER = {"periods": [0.05, 0.025], "observer_gain": [600.0, 1.2e5, 8e6, 0.0, 0.0, 0.0, 0.0], "delay": 0.0003}
PARAMETERS = {
    "pid": {"kp": 4800.0, "ki": 1e5, "kd": 48.0, "feedforward_velocity": "measured"} | FEEDFORWARD,
    "cascade": {"kp": 100.0, "kv": 40.0, "feedforward_velocity": "measured"} | FEEDFORWARD,
    "speed": {"kp": 20.0} | FEEDFORWARD,
    "arc": ADAPTIVE,
    "dcarc": ADAPTIVE,
    "output_feedback_arc": {"theta": [8.4, 2.5, 0.0], "sample_rate": RATE, "command_limit": LIMIT, "coulomb": 0.01},
    "observer_based": OBSERVER | {"sample_rate": RATE, "mass": MASS, "command_limit": LIMIT},
}
#: What must be off for a controller to be a linear law that a gap cannot change.
STILL = {kind: dict.fromkeys(ADAPTATIONS, 0.0) for kind in ("arc", "dcarc")}
STILL["output_feedback_arc"] = {"adaptation": [0.0, 0.0, 0.0]}
FAULTS = [math.nan, math.inf, -math.inf, 1e308, -1e308, 1e12, -math.nan]


def make(kind, **changes):
    struct, controller = CONTROLLERS[kind]
    return controller(struct(**PARAMETERS[kind] | changes))


def ask(controller, point, reading):
    """The command for a reference (position, velocity, acceleration) that continues at the same acceleration."""
    x, v, a = point
    if not hasattr(controller, "preview"):
        return controller.command(reference=x, reference_velocity=v, reference_acceleration=a, reading=reading)
    h = controller.preview
    return controller.command(reference=point, ahead=(x + h * v + 0.5 * h * h * a, v + h * a, a), reading=reading)


def cut(command):
    return min(max(command, -LIMIT), LIMIT)


def motion(samples):
    """A sine from 0.2 m that starts at rest at its lower end: position, velocity, acceleration, (n, 3)."""
    w, t = 2 * np.pi * 2.0, np.arange(samples) / RATE
    sine, cosine = 0.03 * np.sin(w * t), 0.03 * np.cos(w * t)
    return np.stack([0.2 - cosine, w * sine, w * w * cosine], axis=1).tolist()


def run(controller, faults, samples=4000):
    """A loop around a mass with viscous friction; `faults` maps samples to what is read, or referred to, there.

    Returns commands as computed, and the true states (n, 2).
    """
    points = motion(samples)
    x, v, decay = points[0][0], 0.0, math.exp(-VISCOUS / MASS / RATE)
    commands, states = [], []
    for k, point in enumerate(points):
        states.append((x, v))
        learned = controller.estimates
        refused = controller.samples_refused
        reading, place = x, k % 4  # position, velocity or acceleration of the reference, or the reading
        if k in faults:
            point, reading = ([*point[:place], faults[k], *point[place + 1 :]], x) if place < 3 else (point, faults[k])
        command = ask(controller, point, reading)
        controller.update(cut(command))
        if k in faults:
            np.testing.assert_array_equal(controller.estimates, learned)
            assert command == (cut(commands[-1]) if commands else 0.0)
        assert controller.samples_refused == refused + (k in faults)
        commands.append(command)
        steady = cut(command) / VISCOUS
        x, v = x + steady / RATE + (v - steady) * (1 - decay) * MASS / VISCOUS, steady + (v - steady) * decay
    return np.array(commands), np.array(states)


def draw_faults(seed, samples=4000, first=False):
    """Single samples, bursts that are bridged and ones that are not, of every fault; the last 1200 are sound."""
    rng = np.random.default_rng(seed)
    faults = {}
    for length in (1, 1, 1, 2, 3, int(rng.integers(4, 17)), int(rng.integers(17, 40))):
        start = int(rng.integers(200, samples - 1300))
        faults |= {start + i: FAULTS[rng.integers(len(FAULTS))] for i in range(length)}
    if first:
        faults |= {i: FAULTS[rng.integers(len(FAULTS))] for i in range(rng.integers(1, 30))}
    return faults


@pytest.mark.parametrize(("kind", "seed"), covering(CONTROLLERS, range(2)))
def test_a_controller_recovers_from_gaps(kind, seed):
    faults = draw_faults(seed, first=seed % 2 == 1)
    sound, undisturbed = run(make(kind), {})
    controller = make(kind)
    commands, states = run(controller, faults)
    assert np.isfinite([*commands, *states.ravel()]).all()
    assert controller.samples_refused == len(faults)
    assert np.abs(commands - sound).max() > 1e-3, "the gaps were felt at all"
    wanted = np.array(motion(len(states)))[:, :2]
    place = 1 if kind == "speed" else 0  # a velocity loop knows no position to come back to
    off, off_undisturbed = (np.abs(run - wanted)[-500:, place].max() for run in (states, undisturbed))
    assert off < 1.1 * off_undisturbed + (1e-4 if kind == "speed" else 2e-6)


@pytest.mark.parametrize(("kind", "length"), covering(CONTROLLERS, [1, 2, 7, 16]))
def test_the_step_behind_a_gap_does_not_kick(kind, length):
    """Along a straight line a gap changes no later command: velocities are taken over the samples that passed."""
    changes = STILL.get(kind, {})
    whole, gappy = make(kind, **changes), make(kind, **changes)
    speed, rng = 0.21, np.random.default_rng(length)
    start = int(rng.integers(20, 60))
    expected, found = [], []
    for k in range(120):
        x = 0.1 + speed * k / RATE
        expected.append(ask(whole, (x, speed, 0.0), x))
        found.append(ask(gappy, (x, speed, 0.0), math.nan if start <= k < start + length else x))
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
