"""Linear algebra runs on one thread while the package computes: answers do not depend on how many there are."""

import importlib
import os
import subprocess
import sys
from concurrent.futures import ThreadPoolExecutor

import pytest
import threadpoolctl

from cogging.resources import ONE_THREAD, on_one_blas_thread


def threads():
    """Of each BLAS that is loaded."""
    return [info["num_threads"] for info in threadpoolctl.threadpool_info() if info["user_api"] == "blas"]


@pytest.fixture
def two_threads():
    importlib.import_module("scipy.linalg")
    with threadpoolctl.threadpool_limits(2, user_api="blas"):
        if set(threads()) != {2}:
            pytest.skip("a BLAS whose threads cannot be set")
        yield


def test_one_thread_within_and_what_was_there_behind(two_threads):
    @on_one_blas_thread(scipy=False)
    def seen(inner=None):
        return {*threads(), *(inner() if inner else ()), *threads()}

    assert seen(seen) == {1}
    assert set(threads()) == {2}
    with pytest.raises(ZeroDivisionError):
        on_one_blas_thread(scipy=True)(lambda: 1 / 0)()
    assert set(threads()) == {2}


def test_the_last_of_several_threads_puts_back_what_the_first_found(two_threads):
    with ThreadPoolExecutor(1) as pool:
        with ONE_THREAD:
            pool.submit(ONE_THREAD.__enter__).result()
        assert set(threads()) == {1}
        pool.submit(ONE_THREAD.__exit__, None, None, None).result()
    assert set(threads()) == {2}


def test_scipy_is_loaded_before_its_threads_are_set():
    """Loaded only within a function, its BLAS would have the threads that the environment asks for."""
    program = """
import sys
from cogging.resources import on_one_blas_thread
from threadpoolctl import threadpool_info
def number():
    return {one["num_threads"] for one in threadpool_info() if one["user_api"] == "blas"}
assert "scipy.linalg" not in sys.modules
outer = on_one_blas_thread(scipy=False)
inner = on_one_blas_thread(scipy=True)
print(outer(inner(number))(), inner(number)(), number())
"""
    names = dict.fromkeys(("OPENBLAS_NUM_THREADS", "OMP_NUM_THREADS", "MKL_NUM_THREADS"), "2")
    done = subprocess.run([sys.executable, "-c", program], capture_output=True, text=True, env={**os.environ, **names})
    assert (done.stdout, done.stderr) == ("{1} {1} {2}\n", "")
