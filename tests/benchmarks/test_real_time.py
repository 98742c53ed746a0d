"""A step of every controller: no allocation, no lock, no denormal number, a stack with a bound; never a time.

Each instrument is shown what it must see beside what it must not.
"""

import os
import platform
import sys

import numpy as np
import pytest

import cogging
from cogging import _core
from cogging.model.model import CONTROLLERS
from tests.benchmarks import real_time
from tests.benchmarks.real_time_report import UnboundedStack, compile_unit, report, reports_stack, undefined_symbols

CALLS = 20_000
STACK = 1024  # bytes, of every controller: what docs/real_time.md states
LIBRARY = 512  # bytes that a function of the mathematics library may take below them
#: Functions of other units that a step may call: they neither lock nor allocate, and end in bounded time.
ALLOWED = {"sin", "cos", "sincos", "round", "memcpy", "memmove", "memset"}
EVERY = pytest.mark.parametrize("kind", CONTROLLERS)


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    if os.name == "nt":
        pytest.skip("no C++ compiler with the options of gcc here")
    return tmp_path_factory.mktemp("real_time")


@pytest.fixture(scope="module")
def program(folder):
    return real_time.build(folder, *(["-Werror"] if reports_stack() else []))


@pytest.fixture(scope="module")
def rows(program):
    return real_time.measure(program, CALLS)


@pytest.fixture(scope="module")
def unit(folder):
    return compile_unit(folder)


@pytest.fixture
def reaches(unit):
    if not reports_stack():
        pytest.skip("the compiler writes no call graph")
    return report(unit, list(CONTROLLERS))


def test_every_controller_of_the_list_is_measured(rows):
    assert list(rows) == ["none", *CONTROLLERS]
    for row in rows.values():
        assert row["calls"] == CALLS
        assert 0.0 <= row["median"] <= row["most"] <= row["worst"]
        assert 0.0 < row["mean"] <= row["most"]
        assert row["median"] <= row["own_worst"] <= row["worst"]
        assert row["differs"] == 0  # both runs of the loop do the same


@EVERY
def test_the_steps_close_the_loop_that_python_closes(rows, kind):
    """Adaptation, splines and observers are at work while they are timed: the errors are those of the simulation."""
    parameters = real_time.settings()[kind]
    motion = cogging.PointToPoint(real_time.motion())
    duration = (CALLS - 1) / parameters.sample_rate
    log = _core.closed_loop(real_time.plant(), CONTROLLERS[kind][1](parameters), motion, duration=duration)
    error = log["position"] - log["reference"]
    assert len(error) == CALLS
    assert rows[kind]["error_rms"] == pytest.approx(np.sqrt(np.mean(error**2)), rel=1e-9)
    assert rows[kind]["error_max"] == pytest.approx(np.abs(error).max(), rel=1e-9)
    assert rows[kind]["command_max"] == pytest.approx(np.abs(log["command"]).max(), rel=1e-9)
    assert np.ptp(log["position"]) > 0.39  # m


@EVERY
def test_no_allocation(rows, kind):
    assert rows[kind]["allocations"] == 0
    assert rows[kind]["drawn_allocations"] == 0


@EVERY
def test_no_denormal_number(rows, kind):
    """Neither under way nor in long rests, also with drawn gains, in drawn places and with readings lost."""
    row = rows[kind]
    assert row["drawn_calls"] == 400_000
    assert row["drawn_refused"] == 0
    assert (row["denormal_moving"], row["denormal_resting"], row["drawn_denormal"]) == (0, 0, 0)
    assert row["denormal_tiny"] > 10_000  # of 20000 with denormal readings and references: it would be seen


@EVERY
def test_bytes_hold_the_state(rows, kind):
    controller = CONTROLLERS[kind][1](real_time.settings()[kind])
    _, numbers = controller.__getstate__()
    assert 8 * len(numbers) <= rows[kind]["bytes"] + rows[kind]["heap"] < 8 * len(numbers) + 4096
    assert (rows[kind]["heap"] > 0) == (kind not in {"pid", "cascade", "output_feedback_arc"})


def test_what_the_instruments_must_see(program):
    said = real_time.measure(program, "check")
    assert said["seen"].pop("nothing") == 0
    assert len(said["seen"]) >= 4
    assert all(count >= 1 for count in said["seen"].values())
    assert said["denormal"] == {"500": 0, "1000": 1}
    # Of 1, 2, ... 20000 ticks, and one of a million.
    assert said["quantile"] == {"0.500000": 10001, "0.999900": 19999, "largest": 1e6, "longer_than_15000.5": 5001}
    if platform.libc_ver()[0] == "glibc":
        assert 9000 <= said["stack"]["10000"] - said["stack"]["1000"] < 9100


# What the compiler reports --------------------------------------------------------------------------------------------


@pytest.mark.skipif(sys.platform != "linux", reason="names of symbols as ELF has them")
def test_a_step_calls_nothing_that_locks_allocates_or_throws(unit):
    """Of one unit that holds the steps and nothing else: function-local statics, memory, exceptions would be seen."""
    assert undefined_symbols(unit) <= ALLOWED


def test_the_call_graph_tells_the_same_functions(unit, reaches):
    assert set().union(*(reach.outside for reach in reaches.values())) == undefined_symbols(unit)


@EVERY
def test_the_stack_is_bounded(rows, reaches, kind):
    reach = reaches[kind]
    assert 0 < reach.bytes <= STACK
    if "touched" in rows[kind]:
        assert reach.bytes / 4 <= rows[kind]["touched"] <= reach.bytes + (LIBRARY if reach.outside else 0)


@pytest.mark.parametrize("flag", ["-O1", "-Os"])
def test_the_stack_is_bounded_however_it_is_optimised(folder, reaches, flag, tmp_path):
    found = report(compile_unit(tmp_path, flag), list(CONTROLLERS))
    assert set(found) == set(reaches)
    assert all(0 < reach.bytes <= 2 * STACK and reach.outside <= ALLOWED for reach in found.values())


def report_of(body, before, tmp_path):
    """The reach of one step of this body."""
    source = tmp_path / "own.cpp"
    source.write_text(
        "#include <alloca.h>\n#include <cstddef>\n#include <mutex>\n#include <stdexcept>\n#include <string>\n"
        f"{before}\n"
        "namespace real_time {\n"
        f"template <std::size_t number> double step(double x) {{ {body} }}\n"
        "template double step<0>(double);\n}\n"
    )
    return report(compile_unit(tmp_path, source=source), ["own"])["own"]


@pytest.mark.parametrize(
    ("body", "symbol"),
    [
        ("static const std::string name(50 + std::size_t(x), 'n'); return name.size() + x;", "__cxa_guard_acquire"),
        ("double* volatile kept = new double(x); return *kept;", "_Znwm"),
        ('if (x > 3.0) throw std::runtime_error("large"); return x;', "__cxa_throw"),
        ("lock.lock(); lock.unlock(); return x;", "pthread_mutex_lock"),
    ],
)
def test_a_step_that_locks_allocates_or_throws_is_seen(reaches, tmp_path, body, symbol):
    """Also where it does so in a function that it calls."""
    before = f"std::mutex lock;\n__attribute__((noinline)) double deep(double x) {{ {body} }}"
    reach = report_of("return 2.0 * deep(x);", before, tmp_path)
    assert symbol in reach.outside | {name.removeprefix("__") for name in reach.outside}
    assert not reach.outside <= ALLOWED


@pytest.mark.parametrize(
    ("body", "said"),
    [
        (
            "volatile char* all = static_cast<char*>(alloca(std::size_t(x))); all[0] = 1; return x + all[0];",
            "frame is dyn",
        ),
        ("return x > 0.0 ? x * step<number>(x - 1.0) + x : 0.0;", "calls itself"),
        ("return other(x) + 1.0;", "only the run knows"),
    ],
)
def test_a_stack_without_a_bound_is_refused(reaches, tmp_path, body, said):
    with pytest.raises(UnboundedStack, match=said):
        report_of(body, "double (*volatile other)(double);", tmp_path)


@pytest.mark.parametrize("sizes", [(100, 3000), (2000, 50)])
def test_the_deepest_path_counts(reaches, tmp_path, sizes):
    """Of two functions that are called in turn: the larger, and its caller's own frame."""
    before = "".join(
        f"__attribute__((noinline)) double call_{i}(double x) {{ volatile char large[{size}]; large[0] = 1; "
        f"large[{size - 1}] = 2; return x + large[0]; }}\n"
        for i, size in enumerate(sizes)
    )
    body = "volatile char own[500]; own[0] = 1; return call_0(x) + call_1(x) + own[0];"
    assert 500 + max(sizes) <= report_of(body, before, tmp_path).bytes < 700 + max(sizes)
