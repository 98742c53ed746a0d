"""Something done at the n-th file operation of a process: a kill, a signal, an error, wherever it may come."""

from __future__ import annotations

import contextlib
import os
import sys
from collections.abc import Callable
from typing import Any

#: What changes a folder, as Python's audit hooks call it; `open` where it writes.
OPERATIONS = ("open", "os.rename", "os.remove", "os.mkdir", "os.rmdir", "os.link")


def operation_of(event: str, arguments: tuple[Any, ...]) -> tuple[str, str] | None:
    """What an audit event does to which path; None where it changes nothing.

    A name that is given beside the descriptor of its folder, as when a folder is removed with all that it holds, has
    no path: that of the folder stands for it where the system tells it.
    """
    if event not in OPERATIONS or not arguments or not isinstance(arguments[0], str | bytes | os.PathLike):
        return None
    if event == "open" and not (len(arguments) == 3 and (arguments[2] or 0) & (os.O_WRONLY | os.O_RDWR)):
        return None
    path = os.fsdecode(arguments[0])
    if event in ("os.remove", "os.rmdir") and arguments[1] not in (-1, None):
        with contextlib.suppress(OSError):
            path = os.path.join(os.readlink(f"/proc/self/fd/{arguments[1]}"), path)
    return event, path


def at_operation(number: int, concerns: Callable[[str, str], bool], act: Callable[[str, str], None]) -> None:
    """From here on, do something before the n-th operation (from 1) that concerns; of this process, not of a fork."""
    process, left = os.getpid(), [number]

    def heard(event: str, arguments: tuple[Any, ...]) -> None:
        found = operation_of(event, arguments) if os.getpid() == process else None
        if found is not None and concerns(*found):
            left[0] -= 1
            if left[0] == 0:
                act(*found)

    sys.addaudithook(heard)
