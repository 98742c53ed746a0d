"""Pieces of a sweep on the workers of an executor, which may be other machines."""

from __future__ import annotations

import importlib.metadata
import pickle
import time
import uuid
from collections.abc import Callable, Iterator, Sequence
from concurrent.futures import (
    FIRST_COMPLETED,
    BrokenExecutor,
    CancelledError,
    Executor,
    Future,
    ThreadPoolExecutor,
    wait,
)
from typing import Any, TypeVar

from cogging._core import StopFlag
from cogging.files import InputError

PieceOf = TypeVar("PieceOf")
Found = TypeVar("Found")
WAITING_MOST = 1024  # pieces that an executor is given ahead: as many workers are kept busy
LOOK_EVERY = 2.0  # s, between two looks at whether workers are left
GONE_MOST = 60.0  # s, that all workers may be gone, as those are that are started anew

#: What a worker runs, as text: one that lacks the package, or has another, cannot be sent a function of it, and must
#: answer with what it lacks. The task is unpickled by the package, and not before it is known to be the same.
WORKER = """
def run(version, task):
    import importlib, importlib.metadata, os, pickle, platform
    worker = f"{platform.node()}, process {os.getpid()}"
    try:
        importlib.import_module("cogging")
        own = importlib.metadata.version("cogging")
    except Exception as error:
        return "cannot import the package", f"{worker}: {type(error).__name__}: {error}"
    if own != version:
        return "has another version of the package", f"{worker}: {own}, where this is {version}"
    function, piece = pickle.loads(task)
    return "", function(piece)
"""
#: Runs it: of all that every worker has, `eval` alone takes a program and gives its value.
CALL = "(exec(program, space), space['run'](version, task))[1]"


def run_elsewhere(
    function: Callable[[PieceOf], Found], pieces: Sequence[PieceOf], executor: Executor, stands: Callable[[], str]
) -> Iterator[Found]:
    """What a function of the package gives for each piece, as an executor's workers finish them.

    Never more than a few pieces ahead are waiting there.

    Args:
        function: that can be pickled.
        pieces: its arguments.
        executor: whose workers run it.
        stands: gives what to tell of finished work where the executor does not do its own, or nothing.

    Raises:
        InputError: the executor has died, no worker is left, or one lacks the package or has another version of it.
    """
    stop = StopFlag()
    waiting: set[Future[Any]] = set()
    left = iter(pieces)
    seen = _Workers(executor)
    try:
        while True:
            for piece in left:
                waiting.add(_submitted(function, piece, executor, stop))
                if len(waiting) >= WAITING_MOST:
                    break
            if not waiting:
                return
            done = wait(waiting, LOOK_EVERY, return_when=FIRST_COMPLETED).done
            for future in sorted(done, key=_failed):  # those last
                waiting.remove(future)
                refused, found = future.result()
                if refused:
                    raise InputError(_told(executor, f"has a worker that {refused}: {found}", stands()))
                yield found
            if seen.gone(bool(done)):
                raise InputError(_told(executor, f"has had no worker left for {GONE_MOST:g} s", stands()))
    except (InputError, MemoryError):
        raise
    except Exception as error:
        raise InputError(_told(executor, _died(error), stands())) from error
    finally:
        stop.set()
        for future in waiting:
            future.cancel()


def _submitted(function: Callable[[Any], Any], piece: Any, executor: Executor, stop: StopFlag) -> Future[Any]:
    if isinstance(executor, ThreadPoolExecutor):  # only threads of this process can heed a flag
        return executor.submit(_run_and_heed, function, piece, stop)
    given = {
        "program": WORKER,
        "space": {},
        "version": importlib.metadata.version("cogging"),
        "task": pickle.dumps((function, piece)),
        "call": uuid.uuid4().hex,  # Dask answers a call that equals an earlier one with what that gave, errors too
    }
    return executor.submit(eval, CALL, given)


def _run_and_heed(function: Callable[[Any], Any], piece: Any, stop: StopFlag) -> tuple[str, Any]:
    stop.heed()
    return "", function(piece)


def _failed(future: Future[Any]) -> bool:
    return future.cancelled() or future.exception() is not None or bool(future.result()[0])


class _Workers:
    """Whether workers that were there are all gone: a task of Dask waits for a new one without an end."""

    def __init__(self, executor: Executor) -> None:
        self._client = getattr(executor, "_client", None)  # of Dask's; it has no public name there
        self._last = float("inf")  # when there was one; before the first, as in a queue, there is no end

    def gone(self, worked: bool) -> bool:
        """Whether there has been none for so long that there will be none; one that has just worked is there."""
        if self._client is None or not hasattr(self._client, "nthreads"):
            return False
        try:
            if worked or self._client.nthreads():
                self._last = time.monotonic()
        except Exception:  # what has happened to it, its futures tell
            return False
        return time.monotonic() - self._last > GONE_MOST


def _died(error: Exception) -> str:
    what = ": ".join(filter(None, (type(error).__name__, str(error))))
    if isinstance(error, CancelledError):
        return "has cancelled a piece, as one does that was closed or has lost its scheduler"
    if isinstance(error, ImportError):
        return f"has a worker that cannot import the package: {what}"
    return f"{'has died' if isinstance(error, BrokenExecutor) else 'could not run a piece'}: {what}"


def _told(executor: Executor, what: str, stands: str) -> str:
    """One line about an executor that did not do its work."""
    return f"executor: {type(executor).__name__} {' '.join(what.split())}" + (f"; {stands}" if stands else "")
