"""A line on standard error that says what a command does and for how long, as long as it does it."""

from __future__ import annotations

import argparse
import sys
import threading
from collections.abc import Callable, Iterator
from contextlib import contextmanager

PATIENCE, BETWEEN = 1.0, 0.5  # s: until the line is shown, and until it is shown anew


@contextmanager
def working(arguments: argparse.Namespace, name: str) -> Iterator[Callable[[str], None]]:
    """Show on a terminal, from the first second on, what is being done; nothing elsewhere, and nothing when quiet.

    A thread keeps the time, so that the line moves while the core computes.

    Args:
        arguments: of the command, with `quiet`.
        name: what takes long.

    Yields:
        A function to be told each step in words (cogging.progress.Progress).
    """
    stream = sys.stderr
    if arguments.quiet or not stream.isatty():
        yield lambda step: None
        return
    step, done = [name], threading.Event()
    thread = threading.Thread(target=_show, args=(step, done), daemon=True)
    thread.start()
    try:
        yield lambda text: step.__setitem__(0, f"{name}: {text}")
    finally:
        done.set()
        thread.join()


def _show(step: list[str], done: threading.Event) -> None:
    """Show the line until all is done, and take it off again."""
    if done.wait(PATIENCE):
        return
    import time

    from tqdm import tqdm

    form = "{desc} [{elapsed}]"
    with tqdm(desc=step[0], bar_format=form, leave=False, file=sys.stderr, dynamic_ncols=True) as bar:
        bar.start_t = time.time() - PATIENCE
        while not done.wait(BETWEEN):
            bar.set_description_str(step[0])
