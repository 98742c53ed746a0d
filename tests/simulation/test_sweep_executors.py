"""Sweeps on the workers of executors: the same table, and one line where workers die or lack the package."""

import concurrent.futures
import multiprocessing
import os
import signal
import sys

import pytest

import cogging
from tests.fixtures.lacking_workers import has_another_version
from tests.fixtures.sweeps import FEW, MANY, MOVE, SMALL, same


@pytest.fixture(scope="module")
def alone():
    """The table of the sweep without an executor."""
    return cogging.sweep(SMALL, MOVE, MANY, **FEW)


def test_threads_and_processes_give_the_same_table(alone):
    for kind in (concurrent.futures.ThreadPoolExecutor, concurrent.futures.ProcessPoolExecutor):
        with kind(2) as executor:
            same(cogging.sweep(SMALL, MOVE, MANY, executor=executor, **FEW), alone)


class Dies(concurrent.futures.Executor):
    """After four pieces its workers are gone."""

    left = 4

    def submit(self, function, *given):
        future = concurrent.futures.Future()
        self.left -= 1
        if self.left < 0:
            future.set_exception(ModuleNotFoundError("No module named\n'cogging'"))
        else:
            future.set_result(function(*given))
        return future


def test_a_failed_executor_is_one_line_and_all_finished_runs_are_kept(tmp_path, alone):
    out = tmp_path / "runs.csv"
    message = r"^executor: Dies could not run a piece: ModuleNotFoundError: No module [^\n]*; finished work is kept in"
    with pytest.raises(cogging.InputError, match=message):
        cogging.sweep(SMALL, MOVE, MANY, out=out, executor=Dies(), **FEW)
    assert len((tmp_path / "runs.csv.kept").read_bytes().splitlines()) == 1 + 4
    same(cogging.sweep(SMALL, MOVE, MANY, out=out, **FEW), alone)


@pytest.mark.skipif(sys.platform == "win32", reason="signals of another system")
def test_after_a_killed_process_the_same_call_continues(tmp_path, alone):
    out, steps = tmp_path / "runs.csv", []
    with concurrent.futures.ProcessPoolExecutor(2) as pool:

        def kill_one(step):
            steps.append(step)
            if len(steps) == 4:
                os.kill(next(iter(pool._processes)), signal.SIGKILL)

        message = r"^executor: ProcessPoolExecutor could not run a piece: BrokenProcessPool: [^\n]*; finished work is "
        with pytest.raises(cogging.InputError, match=message):
            cogging.sweep(SMALL, MOVE, MANY, out=out, executor=pool, progress=kill_one, **FEW)
    steps.clear()
    same(cogging.sweep(SMALL, MOVE, MANY, out=out, progress=steps.append, **FEW), alone)
    assert 32 < int(steps[0].split()[0]) <= 320, "what was done is not made again"


def test_a_worker_with_another_version_is_one_line(tmp_path):
    new = multiprocessing.get_context("spawn")  # nothing is imported there but what the task imports
    message = r"^executor: ProcessPoolExecutor [^\n]*: RuntimeError: must have version \d[^\n]*, has 0\.0\.1$"
    with (
        concurrent.futures.ProcessPoolExecutor(1, mp_context=new, initializer=has_another_version) as pool,
        pytest.raises(cogging.InputError, match=message),
    ):
        cogging.sweep(SMALL, MOVE, MANY, out=tmp_path / "runs.csv", executor=pool, **FEW)
    assert list(tmp_path.iterdir()) == []


@pytest.mark.study
@pytest.mark.filterwarnings("ignore")  # warnings of Dask
def test_killed_workers_of_dask_change_nothing(tmp_path):
    """Both, one after the other: Dask restarts the workers and their pieces."""
    distributed = pytest.importorskip("distributed")
    place = {"local_directory": str(tmp_path), "dashboard_address": None, "silence_logs": 50}
    move, steps = {**MOVE, "duration": 2.0}, []
    with distributed.LocalCluster(2, threads_per_worker=1, **place) as cluster, distributed.Client(cluster) as client:
        workers = list(client.run(os.getpid).values())

        def kill_one(step):
            steps.append(step)
            if len(steps) in (5, 20):
                os.kill(workers.pop(), signal.SIGKILL)

        found = cogging.sweep(SMALL, move, MANY, executor=client.get_executor(), progress=kill_one, **FEW)
    assert workers == []
    assert steps == [f"{8 * done} of 320 runs" for done in range(1, 41)]
    same(found, cogging.sweep(SMALL, move, MANY, **FEW))
