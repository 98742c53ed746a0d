"""An action before the n-th file operation of a process: a kill, a signal, an error, wherever it may come."""

from __future__ import annotations

import contextlib
import os
import sys
from collections.abc import Callable
from typing import Any

#: Audit events that change a folder; `open` where it writes.
OPERATIONS = ("open", "os.rename", "os.remove", "os.mkdir", "os.rmdir", "os.link")


def path_of(event: str, arguments: tuple[Any, ...]) -> str | None:
    """Path that an audit event changes, or None."""
    if event not in OPERATIONS or not arguments or not isinstance(arguments[0], str | bytes | os.PathLike):
        return None
    if event == "open" and not (len(arguments) == 3 and (arguments[2] or 0) & (os.O_WRONLY | os.O_RDWR)):
        return None
    path = os.fsdecode(arguments[0])
    if event in ("os.remove", "os.rmdir") and arguments[1] not in (-1, None):  # relative to a folder's descriptor
        with contextlib.suppress(OSError):
            path = os.path.join(os.readlink(f"/proc/self/fd/{arguments[1]}"), path)
    return path


def at_operation(number: int, concerns: Callable[[str, str], bool], act: Callable[[str, str], None]) -> None:
    """Call `act` before the n-th operation (from 1) for which `concerns` is true; in this process, not in forks."""
    process, left = os.getpid(), number

    def hook(event: str, arguments: tuple[Any, ...]) -> None:
        nonlocal left
        path = path_of(event, arguments) if os.getpid() == process else None
        if path is not None and concerns(event, path):
            left -= 1
            if left == 0:
                act(event, path)

    sys.addaudithook(hook)
