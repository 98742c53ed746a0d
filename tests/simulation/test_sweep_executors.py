"""Sweeps on threads and processes of executors: what dies, and what lacks the package. Dask: test_sweep_dask."""

import concurrent.futures
import multiprocessing
import os
import signal
import sys
from concurrent.futures.process import BrokenProcessPool

import pytest

import cogging
from tests.fixtures.lacking_workers import breaks_in_the_package, ends, has_another_version, lacks_the_package
from tests.fixtures.sweeps import DRAWN, FEW, MANY, MOVE, SMALL, same


def test_threads_and_processes_give_the_same_table():
    alone = cogging.sweep(SMALL, MOVE, MANY, **DRAWN)
    with concurrent.futures.ThreadPoolExecutor(3) as threads:
        same(cogging.sweep(SMALL, MOVE, MANY, executor=threads, **DRAWN), alone)
    with concurrent.futures.ProcessPoolExecutor(1) as processes:
        same(cogging.sweep(SMALL, MOVE, MANY, executor=processes, **DRAWN), alone)


class Dies(concurrent.futures.Executor):
    """After a few pieces its workers are gone."""

    def __init__(self, error):
        self.left, self.error = 4, error

    def submit(self, function, *given):
        future = concurrent.futures.Future()
        self.left -= 1
        if self.left < 0:
            future.set_exception(self.error)
        else:
            future.set_result(function(*given))
        return future


@pytest.mark.parametrize(
    ("error", "text"),
    [
        (BrokenProcessPool("a child process\nended"), "Dies has died: BrokenProcessPool: a child process ended"),
        (
            ModuleNotFoundError("No module named 'cogging'"),
            "Dies has a worker that cannot import the package: ModuleNotFound",
        ),
        (RuntimeError("gone"), "Dies could not run a piece: RuntimeError: gone"),
    ],
)
def test_an_executor_that_dies_is_one_line_and_finished_runs_stand(tmp_path, error, text):
    out = tmp_path / "runs.csv"
    with pytest.raises(
        cogging.InputError, match=f"^executor: {text}.*finished runs are kept in .*pieces, the same"
    ) as found:
        cogging.sweep(SMALL, MOVE, MANY, out=out, executor=Dies(error), **DRAWN)
    assert "\n" not in str(found.value)
    assert 1 <= len(list((tmp_path / "runs.csv.pieces").glob("[0-9]*.npz"))) <= 4
    same(cogging.sweep(SMALL, MOVE, MANY, out=out, **DRAWN), cogging.sweep(SMALL, MOVE, MANY, **DRAWN))


def kept(folder):
    """The pieces of runs.csv that stand."""
    return len(list((folder / "runs.csv.pieces").glob("[0-9]*.npz")))


@pytest.mark.skipif(sys.platform == "win32", reason="signals of another system")
def test_a_process_that_is_killed_is_one_line_and_the_same_call_goes_on(tmp_path):
    out, told = tmp_path / "runs.csv", []
    with concurrent.futures.ProcessPoolExecutor(2) as pool:

        def kill_one(step):
            told.append(step)
            if len(told) == 7:
                os.kill(next(iter(pool._processes)), signal.SIGKILL)

        text = (
            r"^executor: ProcessPoolExecutor has died: BrokenProcessPool: .*; finished runs are kept in .*\.pieces, the"
        )
        with pytest.raises(cogging.InputError, match=text) as found:
            cogging.sweep(SMALL, {**MOVE, "duration": 2.0}, MANY, out=out, executor=pool, progress=kill_one, **DRAWN)
    assert "\n" not in str(found.value)
    assert 7 <= kept(tmp_path) < 100
    told.clear()
    stood = kept(tmp_path)
    again = cogging.sweep(SMALL, {**MOVE, "duration": 2.0}, MANY, out=out, progress=told.append, **DRAWN)
    assert told[0] == f"{8 * stood + 8} of 800 runs"
    same(again, cogging.sweep(SMALL, {**MOVE, "duration": 2.0}, MANY, **DRAWN))


LACKING = [
    (lacks_the_package, r"cannot import the package: .*, process \d+: ModuleNotFoundError: No module named 'cogging'"),
    (breaks_in_the_package, r"cannot import the package: .*, process \d+: OSError: libstdc.* not found in two lines"),
    (has_another_version, r"has another version of the package: .*, process \d+: 0\.0\.1, where this is \d"),
]


@pytest.mark.parametrize(("made_so", "text"), LACKING, ids=[made_so.__name__ for made_so, _ in LACKING])
def test_a_worker_that_lacks_the_package_is_one_line(tmp_path, made_so, text):
    new = multiprocessing.get_context("spawn")  # nothing is imported there but what the task imports
    with (
        concurrent.futures.ProcessPoolExecutor(1, mp_context=new, initializer=made_so) as pool,
        pytest.raises(cogging.InputError, match=f"^executor: ProcessPoolExecutor has a worker that {text}") as found,
    ):
        cogging.sweep(SMALL, MOVE, MANY, out=tmp_path / "runs.csv", executor=pool, **FEW)
    assert "\n" not in str(found.value)
    assert "finished runs" not in str(found.value)
    assert list(tmp_path.iterdir()) == []
    same(cogging.sweep(SMALL, MOVE, MANY, out=tmp_path / "runs.csv", **FEW), cogging.sweep(SMALL, MOVE, MANY, **FEW))


@pytest.mark.skipif(sys.platform == "win32", reason="signals of another system")
def test_a_worker_that_ends_at_once_is_one_line():
    with (
        concurrent.futures.ProcessPoolExecutor(1, initializer=ends) as pool,
        pytest.raises(cogging.InputError, match=r"^executor: ProcessPoolExecutor has died: BrokenProcessPool: [^\n]*$"),
    ):
        cogging.sweep(SMALL, MOVE, MANY, executor=pool, **FEW)
