"""The logs that a diagnosis was given, read and with a name each for messages."""

from __future__ import annotations

import os
from collections.abc import Sequence

from cogging.logs.log import Log, read_log

Logs = Log | str | os.PathLike[str] | Sequence[Log | str | os.PathLike[str]]


def read_logs(logs: Logs, names: Sequence[str] | None = None, kind: str = "log") -> tuple[list[Log], list[str]]:
    """Read what is a file, and name each: as given, else after its file, else by its number.

    Raises:
        InputError: a file that cannot be read.
        ValueError: another number of names than of logs.
    """
    if isinstance(logs, Log | str | os.PathLike):
        logs = [logs]
    if names is not None and len(names) != len(logs):
        raise ValueError(f"names: must be one for each {kind}, got {len(names)} for {len(logs)}")
    called = [f"{kind} {i + 1}" if isinstance(log, Log) else os.fspath(log) for i, log in enumerate(logs)]
    return [log if isinstance(log, Log) else read_log(log) for log in logs], list(names or called)
