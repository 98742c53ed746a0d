"""Calls of the core on Python's threads, all of which end when the caller is interrupted."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from concurrent.futures import ThreadPoolExecutor
from typing import TypeVar

from cogging._core import StopFlag

Job = TypeVar("Job")
Result = TypeVar("Result")


def on_threads(run: Callable[[Job], Result], jobs: Iterable[Job], threads: int | None = None) -> list[Result]:
    """Run the jobs on threads (None: as many as Python chooses) and give their results in order.

    The loops run in the core, which lets other threads go on. An exception of a job, or a KeyboardInterrupt of the
    caller, ends what the other jobs do in the core before it is raised.
    """
    stop = StopFlag()
    with ThreadPoolExecutor(max_workers=threads, initializer=stop.heed) as pool:
        try:
            return list(pool.map(run, jobs))
        except BaseException:
            stop.set()
            raise
