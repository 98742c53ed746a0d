"""A step of every controller: no allocation, no lock, no denormal number, a stack with a bound."""

import os
import sys

import numpy as np
import pytest

import cogging
from cogging import _core
from cogging.model.model import CONTROLLERS
from tests.benchmarks import real_time
from tests.benchmarks.real_time import compile_unit, reports_stack, stack_of_each, undefined_symbols

CALLS = 20_000
STACK = 1024  # bytes, of every controller: what docs/real_time.md states
#: Functions of other units that a step may call: they neither lock nor allocate, and end in bounded time.
ALLOWED = {"sin", "cos", "sincos", "round", "memcpy", "memmove", "memset"}


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    if os.name == "nt":
        pytest.skip("no C++ compiler with the options of gcc here")
    return tmp_path_factory.mktemp("real_time")


@pytest.fixture(scope="module")
def rows(folder):
    return real_time.measure(real_time.build(folder, "-O1", *(["-Werror"] if reports_stack() else [])), CALLS)


@pytest.mark.study  # the states at rest: tests/control/test_faulty_readings.py
@pytest.mark.parametrize("kind", CONTROLLERS)
def test_a_step_in_closed_loop_neither_allocates_nor_meets_denormal_numbers(rows, kind):
    """Under way, in long rests, behind lost readings, with drawn gains; and its errors are those of the simulation."""
    assert list(rows) == ["none", *CONTROLLERS]
    row, parameters = rows[kind], real_time.settings()[kind]
    assert 0.0 < row["median"] <= row["own worst"] <= row["worst"]
    assert row["calls"] == CALLS
    assert row["differs"] == 0  # both runs of the loop do the same
    assert (row["allocations"], row["drawn_allocations"]) == (0, 0)
    assert (row["denormal"], row["drawn_denormal"], row["drawn_refused"]) == (0, 0, 0)
    assert row["denormal_tiny"] > 10_000  # of 20000 with denormal readings and references: they are counted

    controller = CONTROLLERS[kind][1](parameters)
    motion = cogging.PointToPoint(real_time.motion())
    duration = (CALLS - 1) / parameters.sample_rate
    log = _core.closed_loop(real_time.plant(), controller, motion, duration=duration)
    error = log["position"] - log["reference"]
    assert row["error_rms"] == pytest.approx(np.sqrt(np.mean(error**2)), rel=1e-9)
    assert row["error_max"] == pytest.approx(np.abs(error).max(), rel=1e-9)
    assert row["command_max"] == pytest.approx(np.abs(log["command"]).max(), rel=1e-9)
    assert np.ptp(log["position"]) > 0.39  # m
    _, numbers = controller.__getstate__()
    assert 8 * len(numbers) <= row["bytes"] + row["heap"] < 8 * len(numbers) + 4096
    assert (row["heap"] > 0) == (kind not in {"pid", "cascade", "output_feedback_arc"})


@pytest.mark.skipif(sys.platform != "linux", reason="names of symbols as ELF has them")
@pytest.mark.parametrize("flag", ["-O3", pytest.param("-Os", marks=pytest.mark.study)])
def test_a_step_calls_nothing_that_locks_allocates_or_throws_and_its_stack_is_bounded(folder, flag, tmp_path):
    """Of a unit that holds the steps and nothing else: function-local statics, memory, exceptions would be seen."""
    made = compile_unit(tmp_path, flag)
    assert undefined_symbols(made) <= ALLOWED
    if not reports_stack():
        pytest.skip("the compiler writes no call graph")
    found = [stack() for stack in stack_of_each(made).values()]
    assert len(found) == len(CONTROLLERS)
    assert set().union(*(outside for _, outside in found)) == undefined_symbols(made)
    assert all(0 < size <= (STACK if flag == "-O3" else 2 * STACK) for size, _ in found)
