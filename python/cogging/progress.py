"""Progress of long computations."""

from __future__ import annotations

import sys
import threading
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from typing import Union

#: What users pass as `progress`: False shows nothing, True a bar on standard error if that is a terminal or a notebook,
#: and a function is called with each step in words.
Progress = Union[bool, Callable[[str], None]]  # noqa: UP007 - evaluated when it is imported, also by Python 3.10
PATIENCE, BETWEEN = 1.0, 0.5  # s, until progress is shown, and between its updates


@contextmanager
def steps(progress: Progress, name: str, total: int | None = None) -> Iterator[Callable[[str], None]]:
    """Yield a function to call with each step in words; progress: as the user gave it; total: of steps, if known."""
    if callable(progress):
        yield progress
        return
    if not isinstance(progress, bool):
        raise TypeError(f"progress: must be True, False or a function of a text, got {progress!r}")
    shown = progress and (type(sys.stderr).__module__.startswith("ipykernel") or getattr(sys.stderr, "isatty", bool)())
    if not shown:
        yield lambda step: None
        return
    said, done, begun = list[str](), threading.Event(), time.time()

    def show() -> None:
        if done.wait(PATIENCE):
            return
        from tqdm import tqdm

        form = None if total else "{desc} [{elapsed}]"
        with tqdm(total=total, desc=name, unit="step", bar_format=form, leave=False, dynamic_ncols=True) as bar:
            bar.start_t, is_done = begun, False
            while True:
                bar.n = len(said)
                bar.set_description_str(": ".join([name, *said[-1:]]))
                if is_done:
                    return
                is_done = done.wait(BETWEEN)

    thread = threading.Thread(target=show, daemon=True)
    thread.start()
    try:
        yield said.append
    finally:
        done.set()
        thread.join()
