"""Progress of long computations."""

from __future__ import annotations

import sys
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from typing import Union

#: What users pass as `progress`: False shows nothing, True a bar on standard error if that is a terminal or a notebook,
#: and a function is called with each step in words.
Progress = Union[bool, Callable[[str], None]]  # noqa: UP007 - evaluated when it is imported, also by Python 3.10


@contextmanager
def steps(progress: Progress, name: str, total: int | None = None) -> Iterator[Callable[[str], None]]:
    """Yield a function to call with each step in words; progress: as the user gave it; total: of steps, if known."""
    if callable(progress):
        yield progress
        return
    if not isinstance(progress, bool):
        raise TypeError(f"progress: must be True, False or a function of a text, got {progress!r}")
    if not progress:
        yield lambda step: None
        return
    from tqdm import tqdm

    form = None if total else "{desc}: {postfix} [{elapsed}]"
    notebook = type(sys.stderr).__module__.startswith("ipykernel")
    hidden = False if notebook else None  # None: where standard error is no terminal
    with tqdm(total=total, desc=name, unit="step", bar_format=form, leave=False, disable=hidden) as bar:

        def step(text: str) -> None:
            bar.set_postfix_str(text)
            bar.update()

        yield step
