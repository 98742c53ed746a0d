"""Runs as pure functions, on one thread or many; their logs, their errors, their indexes."""

import copy
import itertools
import math
import pickle
import re
import sys
import threading
from concurrent.futures import ThreadPoolExecutor

import numpy as np
import pytest

import cogging
from cogging.model.model import CONTROLLERS
from tests.fixtures.log_columns import columns_of
from tests.golden.logs import CONTROLLERS as FIELDS

RUN_COLUMNS = ["time", "position", "command", "reference", "reference_velocity", "reference_acceleration"]
RUN_COLUMNS += ["true_position", "true_velocity"]
BASIS = cogging.SplineHarmonics(pitch=0.05, harmonics=[1, 2, 3], order=3, control_points=13)
MODEL = cogging.Model(
    axis=cogging.AxisParameters(mass=0.12, viscous=0.166, coulomb=0.15, coulomb_width=1 / 900, travel=[0.0, 0.51]),
    cogging=cogging.CoggingModel(BASIS, *(0.05 * np.random.default_rng(0).normal(size=(2, 3, 13)))),
    effects=[cogging.effects.CommandDelay(delay=0.00013), cogging.effects.ConstantForce(force=0.05)],
    encoder=cogging.EncoderParameters(resolution=0.5e-6, noise=1e-7),
    noise=cogging.NoiseParameters(force=0.01, bandwidth=100.0),
)
PLANT = MODEL.plant()
MOVE = {"start": 0.05, "distance": 0.4, "velocity": 0.5, "acceleration": 10.0, "jerk": 1000.0, "dwell": 0.1}
SAMPLE = {"reference": 0.1, "reference_velocity": 0.2, "reference_acceleration": 1.0}


def pid(**gains):
    return cogging.Pid(cogging.PidParameters(**{"kp": 9600.0, "ki": 1e5, "kd": 48.0, "mass": 0.12} | gains))


def stroke(**changes):
    return cogging.PointToPoint(cogging.PointToPointParameters(**MOVE | changes))


def run(controller, **options):
    return cogging.closed_loop(PLANT, controller, stroke(), **options)


def assert_same_bits(one, other):
    one, other = columns_of(one), columns_of(other)
    assert one.keys() == other.keys()
    for name in one:
        assert one[name].tobytes() == other[name].tobytes(), name


@pytest.mark.parametrize("kind", CONTROLLERS)
def test_runs_do_not_change_a_controller_and_its_copies_continue_as_it(kind):
    struct, make = CONTROLLERS[kind]
    controller = make(struct(**FIELDS[kind]))
    point = tuple(SAMPLE.values())
    sample = {"reference": point, "ahead": point} if hasattr(controller, "preview") else SAMPLE
    for reading in (0.1001, math.nan, 0.1002, 0.0999):
        controller.update(controller.command(reading=reading, **sample))
    before = controller.estimates
    controller.estimates[:] = 1e9  # a copy
    copies = [controller.copy(), copy.deepcopy(controller), pickle.loads(pickle.dumps(controller))]
    assert controller != make(struct(**FIELDS[kind]))
    run(controller, duration=0.05)
    cogging.closed_loop_batch([PLANT] * 2, [controller] * 2, stroke(), duration=0.05)
    np.testing.assert_array_equal(controller.estimates, before)
    for reading in (0.1003, 0.0998, 0.1):
        expected = controller.command(reading=reading, **sample)
        controller.update(expected)
        for one in copies:
            assert one.command(reading=reading, **sample) == expected
            one.update(expected)
    assert [one.samples_refused for one in (controller, *copies)] == [1] * 4


def test_threads_of_python_give_the_bits_of_one():
    """Runs, batches with threads of their own, and copies of a model, of shared objects."""
    controller, motion = pid(), stroke()

    def work(i):
        batch = cogging.closed_loop_batch([PLANT] * 3, [controller] * 3, motion, duration=0.1, threads=2, logs=True)
        assert pickle.loads(pickle.dumps(MODEL)) == copy.deepcopy(MODEL) == MODEL
        return [*batch, cogging.closed_loop(PLANT, controller, motion, duration=0.1, seed=i)]

    alone = [work(i) for i in range(4)]
    assert not np.array_equal(alone[0][-1].position, alone[1][-1].position)
    ready = threading.Barrier(4)
    with ThreadPoolExecutor(4) as pool:
        found = list(pool.map(lambda i: ready.wait() >= 0 and work(i), range(4)))
    for one, other in zip(itertools.chain(*found), itertools.chain(*alone), strict=True):
        assert_same_bits(one, other)


def test_a_run_releases_the_interpreter_lock():
    """With a switch interval of 1000 s the main thread gets the lock only if the run releases it."""
    started, finished = threading.Event(), threading.Event()
    run(pid(), duration=0.01)  # numpy is loaded now, which releases it too

    def work():
        started.set()
        cogging.closed_loop_batch([PLANT], [pid()], stroke(repeats=1000), duration=20.0, threads=1)
        finished.set()

    interval, thread = sys.getswitchinterval(), threading.Thread(target=work)
    try:
        sys.setswitchinterval(1000.0)
        thread.start()
        started.wait()
        assert not finished.is_set()
    finally:
        sys.setswitchinterval(interval)
        thread.join()


@pytest.mark.parametrize(("rate", "duration", "rows"), [(1000.0, 0.0015, 2), (3000.0, 1.0, 3001), (7.0, 1.0, 8)])
def test_times_are_the_samples_of_the_controller(rate, duration, rows):
    controller = cogging.Pid(cogging.PidParameters(sample_rate=rate))
    log = cogging.closed_loop(cogging.Plant(cogging.AxisParameters()), controller, stroke(), duration=duration)
    np.testing.assert_array_equal(log.time, np.arange(rows) / rate)


def test_the_reference_is_logged_and_its_end_is_the_duration():
    reference = stroke()
    log = run(pid())
    assert log.time[-1] == pytest.approx(reference.end, abs=1 / 5000)
    for name, column in zip(RUN_COLUMNS[3:6], reference.sample(log.time), strict=True):
        np.testing.assert_array_equal(getattr(log, name), column)
    assert (log.true_position[0], log.true_velocity[0]) == (0.05, 0.0)
    log = run(pid(), duration=0.01, initial_position=0.0502, initial_velocity=-0.01)
    assert (log.true_position[0], log.true_velocity[0]) == (0.0502, -0.01)


def test_the_command_limit_cuts_the_applied_and_logged_command():
    for kind, (struct, make) in CONTROLLERS.items():
        log = run(make(struct(**FIELDS[kind] | {"command_limit": 0.2})), duration=0.1)
        assert np.abs(log.command).max() == 0.2, kind
        assert (np.abs(log.command) == 0.2).sum() > 20, kind


def test_the_steps_per_sample_of_a_model_are_used_unless_stated():
    model = MODEL.replace(controller=pid().parameters, steps_per_sample=4)
    assert cogging.Model.from_dict(model.to_dict()) == model
    for stated, used in ({}, 4), ({"steps_per_sample": 2}, 2):
        assert cogging.simulate(model, stroke(), duration=0.01, **stated).metadata["steps_per_sample"] == used


def test_a_diverging_run_says_when_and_where():
    line = r"^the run diverged at (\S+) s: position (\S+), velocity \S+; the travel is \[0, 0.51\]$"
    with pytest.raises(RuntimeError, match=line) as caught:
        run(pid(kp=1e9), duration=0.5)
    assert type(caught.value) is cogging.DivergedError
    when, where = map(float, re.match(line, str(caught.value)).groups())
    assert 0.0 < when < 0.5
    assert not -0.255 < where < 0.765  # half a travel beyond its ends
    # It is the first such sample: until the one before, the run is as any other.
    x = run(pid(kp=1e9), duration=(round(when * 5000) - 1) / 5000).true_position
    assert ((x > -0.255) & (x < 0.765)).all()
    push = cogging.Plant(cogging.AxisParameters(), effects=[cogging.effects.ConstantForce(force=1e300)])
    with pytest.raises(cogging.DivergedError, match=r"diverged at 0\.0002 s"):
        cogging.closed_loop(push, pid(), stroke(), duration=1.0)


SINE = cogging.Sine(cogging.SineParameters(center=0.2, amplitude=0.01))
FAR = stroke(distance=0.5)
LOOP = {"plant": PLANT, "controller": pid(), "reference": SINE, "duration": 0.5}
BATCH = {"plants": [PLANT], "controllers": [pid()], "reference": SINE, "duration": 0.5}
ROWS = {"time": [0, 1], "error": [0, 1], "command": [0, 1]}
#: A call, its usual arguments, others, and the error.
WRONG = [
    *(
        (cogging.closed_loop, LOOP, *case)
        for case in (
            ({"duration": -1.0}, "duration: must be finite and above 0 (or left out), got -1"),
            ({"duration": 1e-5}, "duration: must hold 1 to 1e9 samples, got 1e-05"),
            ({"duration": 0.0}, "duration: must be given for a reference without an end of its own, got inf"),
            ({"steps_per_sample": 10001}, "steps_per_sample: must be from 1 to 10000, got 10001"),
            ({"reference": FAR, "duration": 1.0}, "reference: must stay within travel [0, 0.51], got 0.51"),
            ({"reference": stroke(start=-0.1)}, "reference: must stay within travel [0, 0.51], got -0.1 at 0 s"),
        )
    ),
    (cogging.closed_loop_batch, BATCH, {"plants": [PLANT] * 2}, "controllers: must be one for each plant, got 1"),
    (cogging.closed_loop_batch, BATCH, {"seeds": [1, 2]}, "seeds: must be one for each plant, got 2"),
    (cogging.closed_loop_batch, BATCH, {"reductions": ["eror_max"]}, "reductions: 'eror_max' is unknown; did you mean"),
    (cogging.closed_loop_batch, BATCH, {"columns": ["speed"]}, "columns: must be columns of a log, got speed"),
    (cogging.closed_loop_batch, BATCH, {"start": 2.0}, "run 0: start, stop: must hold at least 2 rows, got 0"),
    (cogging.performance, ROWS, {"error": [0]}, "error: must be as long as time, got 1"),
    (cogging.performance, ROWS, {"start": 2.0, "stop": 1.0}, "start: must be below stop = 1, got 2"),
    (cogging.performance, ROWS, {"start": 0.5}, "start, stop: must hold at least 2 rows, got 1"),
]


@pytest.mark.parametrize(("call", "usual", "fields", "message"), WRONG)
def test_a_wrong_argument_is_one_line(call, usual, fields, message):
    with pytest.raises(ValueError) as caught:  # noqa: PT011 the message is compared from its beginning
        call(**usual | fields)
    assert str(caught.value).startswith(message)
    assert "\n" not in str(caught.value)


def test_indexes_are_numpys():
    rng = np.random.default_rng(0)
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
    assert whole.error_final_max == np.abs(e[t >= t[-1] - 2.0]).max()  # 2 s by default
    assert whole.error_rms == pytest.approx(np.sqrt(np.mean(e**2)), rel=1e-12)
    assert cogging.performance([0, 1], [0.0, 0.0], [0.0, 0.0]).command_chatter == 0.0
    with pytest.raises(ValueError, match=r"^error: must be a finite number, got nan$"):
        cogging.performance([0, 1, 2], [1.0, math.nan, 2.0], [1.0, 1.0, 1.0])
