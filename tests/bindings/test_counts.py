"""Counts that come in from files and callers: each is bounded before it is multiplied, indexed or allocated by."""

import math
import re
import subprocess
import sys
import threading
from concurrent.futures import ThreadPoolExecutor

import numpy as np
import pytest

import cogging
from cogging import _core
from cogging._core import AdaptiveRobustParameters, BSpline, SplineHarmonics

INT_MAX = 2**31 - 1
STRUCTS = [kind for kind in vars(_core).values() if hasattr(kind, "FIELDS")] + list(cogging.EFFECTS.values())


def basis(terms, control_points, order=1):
    return SplineHarmonics(pitch=0.05, harmonics=list(range(1, terms + 1)), order=order, control_points=control_points)


@pytest.mark.parametrize("terms", [1, 32])
def test_too_many_coefficients_are_refused_and_the_largest_model_works(terms):
    """Also sizes whose product with the columns overflows 32 bits, some to something that looks small."""
    most = 10**7 // (2 * terms)
    shown = f"{most:g}" if float(f"{most:g}") == most else str(most)
    rule = rf"must be at most 1e\+07 / twice the terms = {re.escape(shown)}"
    harmonics = list(range(1, terms + 1))
    drawn = np.random.default_rng(terms).integers(most + 1, INT_MAX, 4).tolist()
    for points in (2**26 + 1, 2**27, 715827883, 2**30, 2**30 + 1, INT_MAX, *drawn):
        with pytest.raises(ValueError, match=rf"^control_points: {rule}"):
            basis(terms, points)
        with pytest.raises(ValueError, match=r"^control_points: must be at most 1e\+07"):
            SplineHarmonics(periods=[0.01 * i for i in harmonics], pitch=0.05, order=1, control_points=points)
        with pytest.raises(ValueError, match=rf"^cogging_control_points: {rule}"):
            AdaptiveRobustParameters(cogging_harmonics=harmonics, cogging_order=1, cogging_control_points=points)

    large = basis(terms, most, order=3)
    assert large.coefficients == 2 * terms * most
    first, values = large.active_regressor((most - 3) * 0.05 + 0.02)
    assert (first, first + len(values)) == (2 * terms * (most - 3), large.coefficients)
    learning = {"cogging_harmonics": harmonics, "cogging_control_points": most, "cogging_adaptation": 10.0}
    controller = cogging.Dcarc(AdaptiveRobustParameters(**learning))
    controller.command(reference=most * 0.05, reading=most * 0.05 + 1e-3)
    controller.update(0.0)
    assert np.flatnonzero(controller.estimates[4:]).min() >= first
    assert len(controller.estimates) == 4 + large.coefficients


def test_a_count_of_more_than_32_bits_is_refused_by_name():
    whole = [(struct, name) for struct in STRUCTS for name in struct.FIELDS if type(getattr(struct(), name)) is int]
    assert len(whole) > 3
    for struct, name in whole:
        with pytest.raises(ValueError, match=rf"^{name}: must be below 2\^31, got "):
            struct(**{name: 2**31})
    for name in ("order", "control_points"):
        with pytest.raises(ValueError, match=rf"^{name}: must be below"):
            BSpline(**{"order": 1, "origin": 0.0, "pitch": 1.0, "control_points": 5, name: -(2**63)})
    with pytest.raises(ValueError, match=r"^harmonics: must be below"):
        SplineHarmonics(harmonics=[2**31], pitch=0.1)


def test_a_matrix_that_cannot_be_allocated_is_one_error():
    spline = BSpline(order=1, origin=0.0, pitch=1.0, control_points=INT_MAX)
    for make in (spline.design_matrix, basis(5, 10**6).regressor):
        with pytest.raises(MemoryError, match="more memory was asked for than there is"):
            make(np.zeros(10**6))


@pytest.mark.parametrize("kind", [cogging.Arc, cogging.Dcarc])
def test_an_update_before_the_first_command_changes_no_estimate(kind):
    for _ in range(20):
        controller = kind(AdaptiveRobustParameters(cogging_harmonics=[1, 2], cogging_adaptation=1e3))
        before = controller.estimates
        controller.update(0.5)
        np.testing.assert_array_equal(controller.estimates, before)


@pytest.mark.parametrize("position", [math.nan, math.inf, -math.inf])
def test_a_position_that_is_no_number_is_no_index(position):
    large = basis(2, 50, order=3)
    first, values = large.active_regressor(position)
    assert 0 <= first <= large.coefficients - len(values)
    assert np.isnan(values).all()
    assert math.isnan(cogging.CoggingModel(large, np.ones((2, 50)), np.ones((2, 50))).force(position))


# Threads ---------------------------------------------------------------------------------------------------------


def test_threads_are_bounded():
    time, forces = np.linspace(0.0, 0.1, 20), np.zeros((3000, 20))
    predictor, plants = _core.Predictor(time, time, time), [_core.Plant(_core.AxisParameters())] * 1500
    pids = [cogging.Pid(cogging.PidParameters(sample_rate=100.0))] * 1500
    motion = cogging.PointToPoint(cogging.PointToPointParameters(distance=0.01, velocity=1.0, acceleration=100.0))
    for call in (
        lambda n: cogging.closed_loop_batch(plants, pids, motion, threads=n),
        lambda n: predictor.innovations(plants, threads=n),
        lambda n: predictor.net_force(plants, np.zeros(20), np.zeros(20), threads=n),
        lambda n: predictor.propagate(predictor.predict(plants[0]), 1.0, forces, threads=n),
        lambda n: _core.whiten(forces, [0.5], threads=n),
    ):
        for threads in (1025, 2**32 - 1):
            with pytest.raises(ValueError, match=rf"^threads: must be from 0 to 1024, got {threads}$"):
                call(threads)
        call(64)
        with pytest.raises(TypeError):
            call(-1)


NO_THREADS = """
import resource, sys
import numpy as np
from cogging import _core
used = int(open("/proc/self/statm").read().split()[0]) * resource.getpagesize()
resource.setrlimit(resource.RLIMIT_AS, (used + (150 << 20), used + (150 << 20)))  # stacks of 8 MB: a few threads
rows = np.arange(4000.0).reshape(1000, 4)
try:
    _core.whiten(rows, [0.5], threads=1000)
except ValueError as error:
    print(error)
print(_core.whiten(rows, [0.5], threads=2)[1, 1])
"""


@pytest.mark.skipif(sys.platform != "linux", reason="limits the address space by /proc")
def test_threads_that_cannot_start_are_one_error():
    done = subprocess.run([sys.executable, "-c", NO_THREADS], capture_output=True, text=True, timeout=60)
    assert done.returncode == 0, done.stderr
    refused, goes_on = done.stdout.splitlines()
    found = re.fullmatch(r"threads: must be no more than the system can start, which ended at (\d+), got 1000", refused)
    assert 1 <= int(found[1]) < 1000
    assert float(goes_on) == 5.0 - 0.5 * 4.0


# Tables ----------------------------------------------------------------------------------------------------------


def test_a_reader_reads_on_after_what_was_taken_and_refuses_threads_that_meet_in_it():
    """Whole rows come out, or a call is refused; nothing is read from memory that was given back."""
    block = b"".join(b"%d,%d\n" % (i, 2 * i) for i in range(20_000))
    one = _core.NumberReader(separator=",", fields=2, wanted=[0, 1], labels=["a", "b"])
    refused, taken, start = [], [], threading.Barrier(4)

    def work(call):
        start.wait()
        for _ in range(30):
            try:
                call()
            except ValueError as error:
                refused.append(str(error))

    jobs = [lambda: one.feed(block), lambda: one.feed(block), lambda: taken.append(one.take()), lambda: one.rows]
    with ThreadPoolExecutor(4) as pool:
        list(pool.map(work, jobs))
    taken.append(one.take())
    assert refused
    assert all("must be used by one thread at a time" in text for text in refused)
    assert all((b == 2.0 * a).all() for a, b in taken)
    assert sum(len(a) for a, _ in taken) % 20_000 == 0


def test_rows_that_cannot_be_there_are_refused():
    columns = [np.arange(5.0), np.arange(5.0)]
    for first, end in ((3, 2), (0, 6), (2**62, 2**63 - 1), (0, -1), (-1, 2)):
        with pytest.raises(ValueError, match="first: must be at least 0" if first < 0 else "end: must be from first"):
            _core.format_rows(columns, first, end)
    with pytest.raises(ValueError, match="columns: must be at least one"):
        _core.format_rows([], 0, 1)
    with pytest.raises(ValueError, match="end: must be from first"):
        _core.format_rows([np.arange(5.0), np.arange(4.0)], 0, 5)
    table = {"separator": ",", "fields": 2, "wanted": [0], "labels": ["a"]}
    with pytest.raises(ValueError, match=r"expected_rows: must be at most 1e\+12"):
        _core.NumberReader(**table, expected_rows=2**64 - 1)
    with pytest.raises(MemoryError, match="more memory was asked for"):
        _core.NumberReader(**table, expected_rows=10**12)


# Other numbers ---------------------------------------------------------------------------------------------------


def machine(effects=(), width=0.0):
    axis = _core.AxisParameters(mass=0.1, coulomb=0.2, coulomb_width=width, travel=[-4.0, 4.0])
    return _core.Plant(axis, effects=list(effects))


MOTION = cogging.Sine(cogging.SineParameters(amplitude=0.01, frequency=2.0))


@pytest.mark.parametrize("width", [0.0, 1e-3])
@pytest.mark.parametrize("lag", [0.0, 1e-3])
def test_a_command_that_is_no_number_never_rests(width, lag):
    """A current loop makes inf - inf of an infinite one, which is no force that breaks an axis away."""
    lagging = [cogging.EFFECTS["actuator_lag"](time_constant=lag)]
    saturated = [cogging.EFFECTS["command_saturation"](limit=1.0), *lagging]
    motion = cogging.FilteredSine(cogging.FilteredSineParameters())  # starts with 20 m/s^2
    for mass, value in ((0.0, "-inf"), (1e308, "-?nan")):
        pid = cogging.Pid(cogging.PidParameters(kp=1e308, mass=mass, sample_rate=1000.0))
        run = {"initial_position": 2.5, "duration": 0.1}
        with pytest.raises(cogging.DivergedError, match=rf"at 0 s: the command must be a finite number, got {value}"):
            cogging.closed_loop(machine(lagging, width), pid, motion, **run)
        if mass == 0.0:  # an infinite command that is cut is a number again
            columns = _core.closed_loop(machine(saturated, width), pid, motion, **run)  # no Log holds that command
            assert columns["true_position"][-1] < 2.5 - 1e-3


@pytest.mark.parametrize("lag", [5e-324, 1e-12])
@pytest.mark.parametrize("width", [0.0, 1e-3])
def test_a_lag_shorter_than_time_resolves_is_none(lag, width):
    pid = cogging.Pid(cogging.PidParameters(kp=900.0, kd=10.0, sample_rate=1000.0))
    run = {"duration": 0.3, "steps_per_sample": 2}
    without = cogging.closed_loop(machine((), width), pid, MOTION, **run)
    log = cogging.closed_loop(machine([cogging.EFFECTS["actuator_lag"](time_constant=lag)], width), pid, MOTION, **run)
    np.testing.assert_allclose(log.true_position, without.true_position, rtol=0, atol=1e-9)
    late = 1.7e9  # s: seconds since 1970, which doubles resolve to 0.2 us
    columns = late + log.time, log.position, log.command
    plant = machine([cogging.EFFECTS["actuator_lag"](time_constant=max(lag, 1e-9))], width)
    assert np.isfinite(_core.Predictor(*columns).predict(plant).innovation).all()
