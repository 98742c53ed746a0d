"""Linear algebra on one thread, so that a result does not depend on how many threads there are.

A BLAS splits the sums of a matrix product over its threads and rounds differently for each number of them. The matrices
here are long and narrow: more threads gain nothing.
"""

from __future__ import annotations

import functools
import importlib
import threading
from collections.abc import Callable
from typing import Any, TypeVar

import threadpoolctl

F = TypeVar("F", bound=Callable[..., Any])


class OneThread:
    """While one block of it runs, in whichever thread, every loaded BLAS computes on one thread.

    The number of threads is one for the whole process. The last block to end restores what the first one found.
    """

    def __init__(self) -> None:
        self._lock = threading.Lock()
        self._blocks = 0
        self._limits: list[Any] = []

    def __enter__(self) -> None:
        with self._lock:
            self._blocks += 1
            _release_control()
            # In each block: a BLAS may have been loaded since the last one.
            self._limits.append(threadpoolctl.threadpool_limits(1, user_api="blas"))

    def __exit__(self, *error: object) -> None:
        with self._lock:
            self._blocks -= 1
            _release_control()
            while self._limits and self._blocks == 0:
                self._limits.pop().restore_original_limits()
            _release_control()


def _release_control() -> None:
    """Let any thread set the number of threads of OpenBLAS: newer versions of threadpoolctl heed one at a time."""
    release = getattr(threadpoolctl.OpenBLASController, "clear_controlling_thread", None)
    if release is not None:
        release(force=True)


ONE_THREAD = OneThread()


def on_one_blas_thread(*, scipy: bool) -> Callable[[F], F]:
    """Compute the linear algebra of a function on one thread.

    Args:
        scipy: whether it uses the BLAS of SciPy, which is then loaded first: loaded within the function, it would have
            threads of its own.
    """

    def decorate(function: F) -> F:
        @functools.wraps(function)
        def on_one_thread(*args: Any, **kwargs: Any) -> Any:
            if scipy:
                importlib.import_module("scipy.linalg")
            with ONE_THREAD:
                return function(*args, **kwargs)

        return on_one_thread  # type: ignore[return-value]

    return decorate
