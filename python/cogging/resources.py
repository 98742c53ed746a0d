"""Memory and threads: what a call needs is checked before it is allocated, BLAS runs on one thread, jobs on many.

The bytes for each task were measured as the growth of a process over the call (`python -m studies.memory_peaks`).
"""

from __future__ import annotations

import contextlib
import importlib
import os
import threading
from collections.abc import Callable, Iterable, Iterator, Sized
from concurrent.futures import ThreadPoolExecutor
from typing import TypeVar

import threadpoolctl

from cogging import _core

Job = TypeVar("Job")
Result = TypeVar("Result")

NUMBER = 8  # bytes
LOG_COLUMNS = 8  # of a simulated log
MACHINE = 2500.0  # bytes of a drawn machine and its plant; 1350 to 1950 measured
POINT = 36.0  # bytes for each point of a scan and line of its spectrum, two complex tables; 26 to 33 measured
#: Bytes for each row of a log, and for each row and fitted parameter, beside the log itself.
ROW = {
    "audit": (500.0, 0.0),  # 441 measured
    "identify": (1300.0, 70.0),  # 1840 with 10 parameters, 6500 with 82
    "diagnose": (9000.0, 0.0),  # 8960 and fewer, of a model that lacks most of the command
}


def require_rows(task: str, logs: Iterable[Sized], parameters: int = 0) -> None:
    """Raise ValueError if a task (a key of ROW) on these logs and fitted parameters exceeds the free memory."""
    rows = sum(len(log) for log in logs)
    row, parameter = ROW[task]
    size = row + parameter * parameters
    _core.require_memory("rows", rows * size, f"the tables of {task}, {size:.3g} bytes a row,", str(rows))


def require_machines(name: str, count: int, numbers: int) -> None:
    """Raise ValueError if `count` machines with so many drawn numbers each exceed the free memory."""
    _core.require_memory(name, count * (MACHINE + 4 * NUMBER * numbers), f"{count} machines", str(count))


def require_table(name: str, rows: float, columns: float, copies: float = 1.0) -> None:
    """Raise ValueError if `copies` of a table of numbers exceed the free memory; `name`: field that sets the rows."""
    size = f"{rows:.6g} rows of {columns:g} columns" + (f", {copies:g} times," if copies > 1.0 else "")
    _core.require_memory(name, NUMBER * rows * columns * copies, size, f"{rows:.6g}")


def on_threads(run: Callable[[Job], Result], jobs: Iterable[Job]) -> list[Result]:
    """Return the results of jobs in order, a thread for each processor; an exception stops the others in the core."""
    stop = _core.StopFlag()
    with ThreadPoolExecutor(max_workers=os.cpu_count(), initializer=stop.heed) as pool:
        try:
            return list(pool.map(run, jobs))
        except BaseException:
            stop.set()
            raise


_lock = threading.Lock()
_limits = contextlib.ExitStack()  # of the contexts below, lifted when the last of them ends
_entered = 0


@contextlib.contextmanager
def on_one_blas_thread(*, scipy: bool) -> Iterator[None]:
    """Let every loaded BLAS compute on one thread in a block, or in a decorated function; scipy: load SciPy's before.

    A BLAS rounds sums differently for each number of threads. The last of several concurrent contexts restores it.
    """
    global _entered
    if scipy:
        importlib.import_module("scipy.linalg")
    with _lock:
        _entered += 1
        _release_control()
        # In each context: a BLAS may have been loaded since the last one.
        _limits.enter_context(threadpoolctl.threadpool_limits(1, user_api="blas"))
    try:
        yield
    finally:
        with _lock:
            _entered -= 1
            _release_control()
            if _entered == 0:
                _limits.close()
            _release_control()


def _release_control() -> None:
    """Let any thread set the number of threads of OpenBLAS; newer versions of threadpoolctl allow one at a time."""
    release = getattr(threadpoolctl.OpenBLASController, "clear_controlling_thread", None)
    if release is not None:
        release(force=True)
