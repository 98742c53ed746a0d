"""Linear algebra on one thread: what a function answers does not depend on how many threads there are.

The sums of a matrix product are split over the threads of a BLAS, and rounded otherwise for each number of them. The
matrices here are long and narrow: more threads gain nothing, and wait for each other where the processors are busy.
"""

from __future__ import annotations

import ctypes
import functools
import importlib
import sys
import threading
from collections.abc import Callable
from pathlib import Path
from typing import Any, NamedTuple, TypeVar

F = TypeVar("F", bound=Callable[..., Any])
#: Modules that are linked to the BLAS of their package; in many builds NumPy and SciPy bring one each.
NUMPY, SCIPY = "numpy.linalg._umath_linalg", "scipy.linalg._fblas"
#: The functions that give and take the number of threads: OpenBLAS as the packages name it, MKL, BLIS, FlexiBLAS.
NAMES = [
    *((f"{name}get_num_threads{end}", f"{name}set_num_threads{end}")
      for name in ("scipy_openblas_", "openblas_") for end in ("", "64_", "_64")),
    ("MKL_Get_Max_Threads", "MKL_Set_Num_Threads"),
    ("bli_thread_get_num_threads", "bli_thread_set_num_threads"),
    ("flexiblas_get_num_threads", "flexiblas_set_num_threads"),
]  # fmt: skip


class Library(NamedTuple):
    """A BLAS that is loaded: what gives its number of threads, and what takes it."""

    number: Callable[[], int]
    set_number: Callable[[int], Any]


@functools.cache
def library_of(module: str) -> Library | None:
    """The BLAS that a module of NumPy or SciPy is linked to; none where it lets nobody set its threads (Accelerate)."""
    file = Path(str(importlib.import_module(module).__file__))
    paths = [file]  # what is looked for in it is found in what it is linked to, but on Windows
    if sys.platform == "win32":
        package = module.partition(".")[0]
        paths = sorted((file.parents[2] / f"{package}.libs").glob("*openblas*.dll"))
    for path in paths:
        loaded = ctypes.CDLL(str(path))
        for number, set_number in NAMES:
            if hasattr(loaded, number) and hasattr(loaded, set_number):
                return Library(getattr(loaded, number), getattr(loaded, set_number))
    return None


class OneThread:
    """While one block of it runs, in whichever thread, the BLAS of NumPy and SciPy compute on one thread.

    Their number of threads is one for the whole process: others who compute meanwhile have one as well. The last block
    to end puts back what the first one found.
    """

    def __init__(self) -> None:
        self._lock = threading.Lock()
        self._blocks = 0
        self._found: dict[str, tuple[Library, int]] = {}

    def __enter__(self) -> None:
        with self._lock:
            self._blocks += 1
            for module in (NUMPY, SCIPY):
                if module in sys.modules and module not in self._found and (library := library_of(module)):
                    self._found[module] = library, library.number()
                    library.set_number(1)

    def __exit__(self, *error: object) -> None:
        with self._lock:
            self._blocks -= 1
            while self._found and self._blocks == 0:
                _, (library, number) = self._found.popitem()  # the last first: both may be one library
                library.set_number(number)


ONE_THREAD = OneThread()


def on_one_blas_thread(*, scipy: bool) -> Callable[[F], F]:
    """Let a function do its linear algebra on one thread, so that its answer has the same bits whatever their number.

    Args:
        scipy: whether it uses that of SciPy, which is then imported first: loaded within the function, it would have
            threads of its own.
    """

    def of(function: F) -> F:
        @functools.wraps(function)
        def alone(*given: Any, **named: Any) -> Any:
            if scipy:
                importlib.import_module(SCIPY)
            with ONE_THREAD:
                return function(*given, **named)

        return alone  # type: ignore[return-value]

    return of
