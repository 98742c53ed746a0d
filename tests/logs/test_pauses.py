"""Pauses in a log: what they cost goes with the rows, and what is found is what the rows say."""

import dataclasses
import json
import subprocess
import sys

import numpy as np
import pytest

import cogging
from cogging import Log
from cogging.estimation.force_balance import ForceBalance
from cogging.estimation.innovations import Innovations
from cogging.identification.identification import identify
from cogging.logs.pauses import SPARSE, SPARSEST, running_time, without_pauses
from tests.fixtures.moving_axis import machine, paused, record

DAY, YEAR = 86400.0, 3.15e7


@pytest.fixture(scope="module")
def log():
    return record(machine(), 3)


def test_pauses_cost_no_memory_and_move_no_fit(log):
    """In a process of its own, whose memory is measured: a day took 12 GB and more."""
    script = """
import dataclasses, json, resource
resource.setrlimit(resource.RLIMIT_AS, (6 << 30, 6 << 30))
import cogging
from cogging.identification.identification import identify
from tests.fixtures.moving_axis import machine, paused, record
log, answer = record(machine(), 3), {}
idle = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss
for name, pauses in {"none": {}, "both": {2000: 1e5, 6000: 3.15e7}}.items():
    found = identify(paused(log, pauses), machine())
    answer[name] = {p.path: [p.value, *p.ci95] for p in found.parameters}
    assert cogging.audit(paused(log, pauses), machine()).gaps == len(pauses)
result = cogging.diagnose(paused(log, {4000: 3.15e7}), machine())
answer["verdict"], answer["notes"] = result.verdict, list(result.notes)
answer["megabytes"] = (resource.getrusage(resource.RUSAGE_SELF).ru_maxrss - idle) / 1024
print(json.dumps(answer))
"""
    done = subprocess.run([sys.executable, "-c", script], capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr
    answer = json.loads(done.stdout)
    assert answer["megabytes"] < 300.0
    for path, (value, low, high) in answer["none"].items():
        if low < high:
            assert abs(answer["both"][path][0] - value) < 0.25 * (high - low), path
            assert 0.6 < (answer["both"][path][2] - answer["both"][path][1]) / (high - low) < 1.7, path
    assert answer["verdict"] == "no_gap"
    pause, replay = answer["notes"]
    assert pause == (
        "log 1: 1 pause in the rows, the longest of 3.15e+07 s after row 3999: cut to 0.5 s, and all times here "
        "exclude what was cut"
    )
    assert replay.startswith("time: must be evenly spaced")
    assert replay.endswith("the gap is that of the force balance")


def test_what_is_hidden_is_found_beside_a_pause():
    hidden = cogging.effects.ViscousAsymmetry(difference=1.5)
    log, other = (record(machine([hidden]), seed) for seed in (3, 4))
    found = cogging.diagnose(paused(log, {4000: DAY}), machine(), confirm=paused(other, {3000: YEAR}))
    assert [effect.name for effect in found.effects] == ["viscous_asymmetry"]
    low, high = found.effects[0].parameters["difference"].ci95
    assert low < 1.5 < high
    assert [note.partition(":")[0] for note in found.notes if "pause" in note] == ["log 1", "confirm log 1"]


def test_even_rows_are_bounded_by_rows_whatever_the_time():
    """Random logs with any number of gaps and pauses of any length."""
    random = np.random.default_rng(1)
    cut = refused = plain = 0
    for _ in range(100):
        rows = int(random.integers(60, 2000))
        step = 10.0 ** random.uniform(-4.0, -1.0)
        steps = step * random.uniform(0.8, 1.2, rows)
        gaps = random.random(rows) < 10.0 ** random.uniform(-3.0, -0.5)
        steps[gaps] = step * 10.0 ** random.uniform(0.0, 10.0, gaps.sum())
        time = random.uniform(-1e3, 1e3) + np.cumsum(steps)
        log = Log(time, np.sin(np.arange(rows)), np.cos(np.arange(rows)))
        said = ""
        try:
            dynamics = ForceBalance(log, cutoff=0.1 / float(np.median(np.diff(time))))
        except ValueError as error:
            said = str(error)
        if said:
            assert said.startswith(f"time: must have rows in at least {100.0 / SPARSEST:g} %")
            refused += 1
            continue
        assert len(dynamics.even) <= SPARSEST * rows + 1
        assert (np.diff(dynamics.even) > 0.0).all()
        assert dynamics.even[0] == time[0]
        left = running_time(time)[-1] - np.interp(dynamics.even[-1], time, running_time(time))
        assert 0.0 <= left < 1.01 * float(np.median(np.diff(time)))
        running, said = without_pauses(log)
        if dynamics.pauses:
            cut += 1
            assert "all times here exclude what was cut" in said
            assert (np.diff(running.time) <= np.diff(time) * (1.0 + 1e-6) + 1e-9).all()
        else:
            plain += 1
            assert running is log
            assert time[-1] - time[0] <= SPARSE * rows * float(np.median(np.diff(time)))
    assert min(cut, refused, plain) > 5


def test_a_log_without_pauses_is_not_touched(log):
    assert running_time(log.time) is log.time
    short = paused(log, {4000: 5.0})
    assert running_time(short.time) is short.time, "a pause that is no longer than the rest costs little"
    assert not ForceBalance(short, cutoff=20.0).pauses


@pytest.mark.parametrize("judge", [identify, cogging.diagnose])
def test_rows_that_fill_hardly_any_of_the_time_are_refused(judge, log):
    rows = np.arange(len(log))
    time = rows // 3 * 100.0 + rows % 3 * 1e-3  # three rows, and a pause after each three
    with pytest.raises(ValueError, match=r"log 1: time: must have rows in at least 5 % of the time, .* got 0\.\d+ %"):
        judge(dataclasses.replace(log, time=time), machine())


@pytest.mark.parametrize("width", [2e-3, 1e-5])
def test_the_observer_starts_anew_after_a_pause_of_any_length(width, log):
    """Over an hour it used to be integrated in a few steps, and to diverge where friction is steep."""
    model = machine([cogging.effects.ActuatorLag(time_constant=1e-3)])
    model = model.replace(axis=model.axis.replace(coulomb_width=width))
    short = Innovations(paused(log, {4000: 10.0}), model)
    expected = short.of([model])[0]
    for pause in (DAY, YEAR):
        source = Innovations(paused(log, {4000: pause}), model)
        residual = source.of([model])[0]
        np.testing.assert_array_equal(source.mask, short.mask)
        np.testing.assert_allclose(residual[:4000], expected[:4000], rtol=0, atol=1e-10)
        # The times themselves are rounded to 4 ns beside a year.
        assert np.abs((residual - expected)[source.mask > 0]).max() < 1e-4 * np.sqrt(np.mean(log.command**2))
        assert np.abs(source.along.middle_position).max() < 1.0
