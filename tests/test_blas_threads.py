"""Linear algebra runs on one thread while the package computes: answers do not depend on how many there are."""

import os
import subprocess
import sys

#: A function that loads SciPy only when it runs, one within another, an error, and threads that begin and end in turn.
PROGRAM = """
import sys
from concurrent.futures import ThreadPoolExecutor
from cogging.resources import ONE_THREAD, on_one_blas_thread
from threadpoolctl import threadpool_info

def number():
    return {one["num_threads"] for one in threadpool_info() if one["user_api"] == "blas"}

assert "scipy.linalg" not in sys.modules
outer = on_one_blas_thread(scipy=False)
inner = on_one_blas_thread(scipy=True)
print(outer(inner(number))(), inner(number)(), number())
try:
    inner(lambda: 1 / 0)()
except ZeroDivisionError:
    print(number())
with ThreadPoolExecutor(1) as pool:
    with ONE_THREAD:
        pool.submit(ONE_THREAD.__enter__).result()
    print(number())
    pool.submit(ONE_THREAD.__exit__, None, None, None).result()
print(number())
"""


def test_one_thread_within_and_what_was_there_afterwards():
    names = dict.fromkeys(("OPENBLAS_NUM_THREADS", "OMP_NUM_THREADS", "MKL_NUM_THREADS"), "2")
    done = subprocess.run([sys.executable, "-c", PROGRAM], capture_output=True, text=True, env={**os.environ, **names})
    assert (done.stdout, done.stderr) == ("{1} {1} {2}\n{2}\n{1}\n{2}\n", "")
