"""Runs as pure functions, on one thread or many; their logs, their errors, their indexes."""

import math
import sys
import threading

import numpy as np
import pytest

import cogging
from tests.fixtures.log_columns import columns_of

COLUMNS = (
    "time",
    "position",
    "command",
    "reference",
    "reference_velocity",
    "reference_acceleration",
    "true_position",
    "true_velocity",
)


def gantry(seed=0, **changes):
    """An axis like X of Lu et al. 2008: modulated cogging, half-micron encoder, force noise."""
    rng = np.random.default_rng(seed)
    basis = cogging.SplineHarmonics(pitch=0.05, harmonics=[1, 2, 3, 6, 12], order=3, control_points=13)
    parts = {
        "cogging": cogging.CoggingModel(basis, *(0.05 * rng.normal(size=(2, 5, 13)))),
        "effects": [cogging.EFFECTS["command_delay"](delay=0.00013), cogging.EFFECTS["constant_force"](force=0.05)],
        "encoder": cogging.EncoderParameters(resolution=0.5e-6, noise=1e-7),
        "noise": cogging.NoiseParameters(force=0.01, bandwidth=100.0),
    }
    axis = cogging.AxisParameters(mass=0.12, viscous=0.166, coulomb=0.15, coulomb_width=1 / 900, travel=[0.0, 0.51])
    return cogging.Plant(axis, **parts | changes)


def dcarc(**changes):
    parameters = cogging.AdaptiveRobustParameters(
        error_gain=200.0,
        feedback_gain=48.0,
        mass_bounds=[0.1, 0.2],
        viscous=0.166,
        coulomb=0.15,
        mass_adaptation=1.0,
        viscous_adaptation=10.0,
        coulomb_adaptation=10.0,
        disturbance_adaptation=1000.0,
        cogging_harmonics=[1, 2, 3],
        cogging_control_points=13,
        cogging_adaptation=100.0,
    )
    return cogging.Dcarc(parameters.replace(**changes))


def pid(**gains):
    return cogging.Pid(cogging.PidParameters(**{"kp": 9600.0, "ki": 1e5, "kd": 48.0, "mass": 0.12} | gains))


def stroke(**changes):
    parameters = {"start": 0.05, "distance": 0.4, "velocity": 0.5, "acceleration": 10.0, "jerk": 1000.0, "dwell": 0.1}
    return cogging.PointToPoint(cogging.PointToPointParameters(**parameters | changes))


CONTROLLERS = {
    "pid": pid(),
    "cascade": cogging.Cascade(cogging.CascadeParameters(sample_rate=5000.0, kp=150.0, kv=40.0)),
    "speed": cogging.Speed(cogging.SpeedParameters(sample_rate=5000.0, kp=4.0, delay=3.3e-4)),
    "arc": cogging.Arc(dcarc().parameters.replace(epsilon=0.1)),
    "dcarc": dcarc(),
}


def assert_same_bits(one, other):
    one, other = columns_of(one), columns_of(other)
    assert one.keys() == other.keys()
    for name in one:
        assert one[name].tobytes() == other[name].tobytes(), name


# Pure functions --------------------------------------------------------------------------------------------


@pytest.mark.parametrize("name", CONTROLLERS)
def test_the_controller_given_is_not_changed(name):
    controller = CONTROLLERS[name].copy()
    sample = {"reference": 0.1, "reference_velocity": 0.2, "reference_acceleration": 1.0}
    for reading in (0.1001, 0.1002, 0.0999):
        controller.update(controller.command(reading=reading, **sample))
    before = controller.estimates
    controller.estimates[:] = 1e9  # a copy: the controller does not see it
    twin = controller.copy()
    cogging.closed_loop(gantry(), controller, stroke(), duration=0.1)
    cogging.closed_loop_batch([gantry()] * 2, [controller] * 2, stroke(), duration=0.1)
    np.testing.assert_array_equal(controller.estimates, before)
    for reading in (0.1003, 0.0998, 0.1):  # its hidden state neither
        expected = twin.command(reading=reading, **sample)
        assert controller.command(reading=reading, **sample) == expected
        twin.update(expected)
        controller.update(expected)


def test_a_controller_with_a_past_starts_from_it():
    """The run copies the state that is given: a warm controller is not reset."""
    warm = dcarc()
    sample = {"reference": 0.1, "reference_velocity": 0.5, "reference_acceleration": 5.0}
    for reading in (0.1001, 0.1003):
        warm.update(warm.command(reading=reading, **sample))
    log = cogging.closed_loop(gantry(), warm, stroke(), duration=0.01, record_estimates=True)
    np.testing.assert_array_equal(log.estimates[0], warm.estimates)
    assert (warm.estimates != dcarc().estimates).any()


def test_a_batch_without_seeds_uses_the_default_one():
    logs = cogging.closed_loop_batch([gantry(), gantry(1)], [dcarc(), pid()], stroke(), duration=0.1, logs=True)
    assert_same_bits(logs[0], cogging.closed_loop(gantry(), dcarc(), stroke(), duration=0.1))
    assert_same_bits(logs[1], cogging.closed_loop(gantry(1), pid(), stroke(), duration=0.1))
    assert cogging.closed_loop_batch([], [], stroke(), logs=True).logs == ()


def test_a_run_of_a_batch_that_diverges_leaves_the_others():
    wild = pid(kp=1e9)
    four = [gantry()] * 4, [pid(), pid(), wild, pid()], stroke()
    batch = cogging.closed_loop_batch(*four, duration=0.5, threads=2, logs=True)
    with pytest.raises(cogging.DivergedError, match=r"^run 2: the run diverged at") as alone:
        _ = batch.logs
    with pytest.raises(cogging.DivergedError, match=r"^the run diverged at") as same:
        cogging.closed_loop(gantry(), wild, stroke(), duration=0.5)
    assert str(alone.value) == f"run 2: {same.value}"
    assert_same_bits(batch[3], cogging.closed_loop(gantry(), pid(), stroke(), duration=0.5))
    assert [(failure.run, failure.reason) for failure in batch.failures] == [(2, str(same.value))]
    assert f"at {batch.failures[0].time:g} s" in str(same.value)
    assert [failure.run for failure in batch[1:][:2].failures] == [1]


# The interpreter's lock ------------------------------------------------------------------------------------


@pytest.mark.parametrize("batch", [False, True])
def test_another_thread_runs_meanwhile(batch):
    """With a switch interval of 1000 s the main thread gets the lock only if the run lets go of it."""
    started, finished = threading.Event(), threading.Event()
    plant, controller, reference = gantry(), dcarc(), stroke(repeats=1000)
    cogging.closed_loop(plant, controller, reference, duration=0.01)  # numpy is loaded now, which lets go of it too

    def work():
        started.set()
        if batch:
            cogging.closed_loop_batch([plant], [controller], reference, duration=60.0, threads=1)
        else:
            cogging.closed_loop(plant, controller, reference, duration=60.0)
        finished.set()

    interval = sys.getswitchinterval()
    thread = threading.Thread(target=work)
    try:
        sys.setswitchinterval(1000.0)
        thread.start()
        started.wait()
        meanwhile = not finished.is_set()
    finally:
        sys.setswitchinterval(interval)
        thread.join()
    assert meanwhile
    assert finished.is_set()


# Logs ------------------------------------------------------------------------------------------------------


def test_columns_are_the_runs_own_memory():
    log = cogging.closed_loop(gantry(), dcarc(), stroke(), duration=0.1, record_estimates=True)
    columns = columns_of(log)
    assert sorted(columns) == sorted([*COLUMNS, "estimates"])
    for name, column in columns.items():
        assert column.dtype == np.float64, name
        assert not column.flags.owndata, name
        assert type(column.base.base).__name__ == "PyCapsule", name
        assert column.flags.c_contiguous, name
        assert len(column) == 501, name
    kept = log.position
    before = kept.copy()
    del log, columns, column
    cogging.closed_loop(gantry(1), dcarc(), stroke(), duration=0.1)  # would reuse memory that was given back
    np.testing.assert_array_equal(kept, before)


@pytest.mark.parametrize(
    ("rate", "duration", "rows"), [(5000.0, 0.1, 501), (1000.0, 0.0015, 2), (3000.0, 1.0, 3001), (7.0, 1.0, 8)]
)
def test_times_are_the_samples_of_the_controller(rate, duration, rows):
    plant = cogging.Plant(cogging.AxisParameters())
    controller = cogging.Pid(cogging.PidParameters(sample_rate=rate))
    log = cogging.closed_loop(plant, controller, stroke(), duration=duration)
    np.testing.assert_array_equal(log.time, np.arange(rows) / rate)


def test_the_reference_is_logged_as_it_is_and_its_own_end_is_the_duration():
    reference = stroke(repeats=2)
    log = cogging.closed_loop(gantry(), dcarc(), reference)
    assert log.time[-1] == pytest.approx(reference.end, abs=1 / 5000)
    for name, column in zip(
        ("reference", "reference_velocity", "reference_acceleration"), reference.sample(log.time), strict=True
    ):
        np.testing.assert_array_equal(getattr(log, name), column)


def test_the_axis_starts_at_rest_on_the_reference_unless_told_otherwise():
    log = cogging.closed_loop(gantry(), dcarc(), stroke(), duration=0.01)
    assert (log.true_position[0], log.true_velocity[0]) == (0.05, 0.0)
    log = cogging.closed_loop(
        gantry(), dcarc(), stroke(), duration=0.01, initial_position=0.0502, initial_velocity=-0.01
    )
    assert (log.true_position[0], log.true_velocity[0]) == (0.0502, -0.01)


def test_the_command_limit_of_a_controller_cuts_what_is_applied_and_logged():
    for controller in (pid(command_limit=0.7), dcarc(command_limit=0.7)):
        log = cogging.closed_loop(gantry(), controller, stroke(), duration=0.3)
        assert np.abs(log.command).max() == 0.7
        assert (np.abs(log.command) == 0.7).sum() > 20


# Errors ----------------------------------------------------------------------------------------------------


def test_a_diverging_run_says_when_and_where():
    with pytest.raises(cogging.DivergedError) as caught:
        cogging.closed_loop(gantry(), pid(kp=1e9), stroke(), duration=0.5)
    text = str(caught.value)
    words = text.replace(",", "").replace(";", "").split()
    when, where = float(words[words.index("at") + 1]), float(words[words.index("position") + 1])
    assert 0.0 < when < 0.5
    assert not -0.255 < where < 0.765  # half a travel beyond its ends
    assert "the travel is [0, 0.51]" in text
    assert "\n" not in text
    assert isinstance(caught.value, RuntimeError)
    # It is the first such sample: until the one before, the run is as any other.
    samples = round(when * 5000)
    log = cogging.closed_loop(gantry(), pid(kp=1e9), stroke(), duration=(samples - 1) / 5000)
    x = log.true_position
    assert ((x > -0.255) & (x < 0.765)).all()


def test_an_axis_without_travel_diverges_when_it_is_no_number_or_a_million_metres_away():
    plant = cogging.Plant(cogging.AxisParameters())
    with pytest.raises(cogging.DivergedError, match="diverged at"):
        cogging.closed_loop(plant, pid(kp=1e15), stroke(), duration=1.0)
    push = cogging.Plant(cogging.AxisParameters(), effects=[cogging.EFFECTS["constant_force"](force=1e300)])
    with pytest.raises(cogging.DivergedError, match=r"diverged at 0\.0002 s"):
        cogging.closed_loop(push, pid(), stroke(), duration=1.0)


def test_a_reference_outside_the_travel_is_refused_before_the_run():
    with pytest.raises(ValueError, match=r"^reference: must stay within travel \[0, 0.51\], got 0\.51\d* at 0\.\d+ s$"):
        cogging.closed_loop(gantry(), dcarc(), stroke(distance=0.5))
    with pytest.raises(ValueError, match=r"^reference: must stay within travel .* got -0\.1 at 0 s$"):
        cogging.closed_loop(gantry(), dcarc(), stroke(start=-0.1))


@pytest.mark.parametrize(
    ("options", "message"),
    [
        ({"duration": -1.0}, "duration: must be finite and above 0 (or left out), got -1"),
        ({"duration": math.nan}, "duration: must be finite and above 0 (or left out), got nan"),
        ({"duration": math.inf}, "duration: must be finite and above 0 (or left out), got inf"),
        ({"duration": 1e-5}, "duration: must hold 1 to 1e9 samples, got 1e-05"),
        ({"duration": 1e6}, "duration: must hold 1 to 1e9 samples, got 1e+06"),
        ({}, "duration: must be given for a reference without an end of its own, got inf"),
        ({"duration": 1.0, "steps_per_sample": 0}, "steps_per_sample: must be from 1 to 10000, got 0"),
        ({"duration": 1.0, "steps_per_sample": 10001}, "steps_per_sample: must be from 1 to 10000, got 10001"),
        ({"duration": 1.0, "initial_position": math.nan}, "initial_position: must be a finite number, got nan"),
        ({"duration": 1.0, "initial_velocity": math.inf}, "initial_velocity: must be a finite number, got inf"),
    ],
)
def test_run_rules(options, message):
    reference = cogging.Sine(cogging.SineParameters(center=0.2, amplitude=0.01))
    with pytest.raises(ValueError) as caught:  # noqa: PT011 the message is compared whole
        cogging.closed_loop(gantry(), pid(), reference, **options)
    assert str(caught.value) == message


def test_batch_rules():
    with pytest.raises(ValueError, match=r"^controllers: must be one for each plant, got 1$"):
        cogging.closed_loop_batch([gantry()] * 2, [pid()], stroke())
    with pytest.raises(ValueError, match=r"^seeds: must be one for each plant, got 3$"):
        cogging.closed_loop_batch([gantry()] * 2, [pid()] * 2, stroke(), seeds=[1, 2, 3])
    with pytest.raises(ValueError, match=r"^run \d: reference: must stay within travel"):
        cogging.closed_loop_batch([gantry()] * 2, [pid()] * 2, stroke(distance=0.5))


# Indexes ---------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("seed", range(5))
def test_indexes_are_numpys(seed):
    rng = np.random.default_rng(seed)
    t = np.cumsum(rng.uniform(0.5e-3, 1.5e-3, 4000))
    e, u = rng.normal(size=(2, 4000)) * [[1e-5], [2.0]]
    start, stop, window = 0.7, 3.1, 0.4
    got = cogging.performance(t, e, u, start=start, stop=stop, final_window=window)
    rows = (t >= start) & (t < stop)
    e_in, u_in, t_in = e[rows], u[rows], t[rows]
    assert got.error_max == np.abs(e_in).max()
    assert got.error_rms == pytest.approx(np.sqrt(np.mean(e_in**2)), rel=1e-12)
    assert got.error_final_max == np.abs(e_in[t_in >= t_in[-1] - window]).max()
    assert got.command_rms == pytest.approx(np.sqrt(np.mean(u_in**2)), rel=1e-12)
    assert got.command_change_rms == pytest.approx(np.sqrt(np.mean(np.diff(u_in) ** 2)), rel=1e-12)
    assert got.command_chatter == pytest.approx(got.command_change_rms / got.command_rms, rel=1e-14)
    whole = cogging.performance(t, e, u)
    assert whole.error_max == np.abs(e).max()
    assert whole.error_final_max == np.abs(e[t >= t[-1] - 2.0]).max()  # 2 s when nothing else is said
    assert whole.error_rms == pytest.approx(np.sqrt(np.mean(e**2)), rel=1e-12)
    assert cogging.performance([0, 1], [0.0, 0.0], [0.0, 0.0]).command_chatter == 0.0


def test_a_nan_in_the_error_is_not_lost():
    """An index of a column with a NaN is a NaN or an error, never a number."""
    try:
        got = cogging.performance([0, 1, 2], [1.0, math.nan, 2.0], [1.0, 1.0, 1.0])
    except ValueError:
        return
    assert math.isnan(got.error_rms)
    assert math.isnan(got.error_max)


@pytest.mark.parametrize(
    ("arguments", "options", "message"),
    [
        (([0, 1], [0], [0, 1]), {}, "error: must be as long as time, got 1"),
        (([0, 1], [0, 1], [0]), {}, "command: must be as long as time, got 1"),
        (([0, 1], [0, 1], [0, 1]), {"start": 2.0, "stop": 1.0}, "start: must be below stop = 1, got 2"),
        (([0, 1], [0, 1], [0, 1]), {"start": math.nan}, "start: must be below stop = inf, got nan"),
        (([0, 1], [0, 1], [0, 1]), {"final_window": 0.0}, "final_window: must be above 0, got 0"),
        (([0, 1], [0, 1], [0, 1]), {"start": 0.5}, "start, stop: must hold at least 2 rows, got 1"),
        (([], [], []), {}, "start, stop: must hold at least 2 rows, got 0"),
    ],
)
def test_performance_rules(arguments, options, message):
    with pytest.raises(ValueError) as caught:  # noqa: PT011 the message is compared whole
        cogging.performance(*arguments, **options)
    assert str(caught.value) == message
