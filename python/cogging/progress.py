"""How a function that takes long says what it is doing."""

from __future__ import annotations

import sys
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from typing import Union

#: What a user gives as `progress`: False says nothing, True shows a bar on standard error where somebody looks at it (a
#: terminal or a notebook), and a function is told each step in words.
Progress = Union[bool, Callable[[str], None]]  # noqa: UP007 - evaluated when it is imported, also by Python 3.10


@contextmanager
def steps(progress: Progress, name: str, total: int | None = None) -> Iterator[Callable[[str], None]]:
    """A function to be told each step in words as it is begun or done, for as long as the block lasts.

    Args:
        progress: as the user gave it.
        name: what takes long.
        total: how many steps there are, where it is known.
    """
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
