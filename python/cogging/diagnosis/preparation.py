"""Preparation of the logs: read, check, drop repeated rows and pauses, and repair single bad values."""

from __future__ import annotations

import os
from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass, replace

import numpy as np

from cogging.log_check.controller_check import check_controller, with_missing_rows
from cogging.log_check.log_audit import audit, check_against_model, hints
from cogging.logs.log import Log, read_log
from cogging.logs.pauses import without_pauses
from cogging.logs.repeated_rows import counted_once, repeated, repeated_text
from cogging.logs.spikes import repaired, spikes
from cogging.model.model import Model

ROWS_MIN = 500  # minimum number of rows of a log
Logs = Log | str | os.PathLike[str] | Sequence[Log | str | os.PathLike[str]]


@dataclass(frozen=True)
class Prepared:
    """Logs of one diagnosis."""

    given: list[Log]  # logs to diagnose
    names: list[str]  # their names in messages
    confirm: list[Log]  # logs of other motion
    confirm_names: list[str]
    notes: tuple[str, ...]  # on the preparation

    def changed(self, change: Callable[[Log, str], tuple[Log, Iterable[str]]]) -> Prepared:
        """Return the logs after a change, a function of each log and its name, with the notes that it returns."""
        logs, notes = [], list(self.notes)
        for log, name in zip((*self.given, *self.confirm), (*self.names, *self.confirm_names), strict=True):
            after, said = change(log, name)
            logs.append(after)
            notes += [f"{name}: {text}" for text in said if text]
        count = len(self.given)
        return replace(self, given=logs[:count], confirm=logs[count:], notes=tuple(notes))


def prepared(
    logs: Logs, model: Model, confirm: Logs, names: Sequence[str] | None, confirm_names: Sequence[str] | None
) -> Prepared:
    """Return the logs, read and checked, without repeated rows and pauses.

    Raises:
        ValueError: a log does not fit the model, or a confirm log shares rows with a given log.
        InputError: a file cannot be read.
    """
    given, called = read_logs(logs, names)
    others, others_called = read_logs(confirm, confirm_names, "confirm log")
    if not given:
        raise ValueError("logs: must be at least 1, got 0")
    for name, log in zip((*called, *others_called), (*given, *others), strict=True):
        if len(log) < ROWS_MIN:
            raise ValueError(f"{name}: rows: must be at least {ROWS_MIN} to be diagnosed, got {len(log)}")
        check_against_model(log, model, name)
    whole = _counted_once(given, called, others, others_called).changed(_without_pauses)
    return whole.changed(lambda log, name: (log, hints(audit(log), model)))


def _counted_once(given: list[Log], called: list[str], others: list[Log], others_called: list[str]) -> Prepared:
    """Return given and confirm logs without rows that another log of the same kind has.

    Raises:
        ValueError: a confirm log shares rows with a given log.
    """
    for name, log in zip(others_called, others, strict=True):
        for first, one in zip(called, given, strict=True):
            rows = repeated(log, one)
            if rows.any():
                raise ValueError(
                    f"{name}: must be other motion than {first} to confirm anything, but {repeated_text(rows)} in it"
                )
    left, kept, said = counted_once(given, called, ROWS_MIN)
    others_left, others_kept, others_said = counted_once(others, others_called, ROWS_MIN)
    names = [name for name, rows in zip(called, kept, strict=True) if rows.any()]
    others_names = [name for name, rows in zip(others_called, others_kept, strict=True) if rows.any()]
    return Prepared(left, names, others_left, others_names, (*said, *others_said))


def _without_pauses(log: Log, name: str) -> tuple[Log, list[str]]:
    """Return a log without its pauses, and a note on these."""
    try:
        running, said = without_pauses(log)
    except ValueError as error:
        raise ValueError(f"{name}: {error}") from None
    return running, [said]


def whole_logs(logs: Prepared, model: Model) -> Prepared:
    """Return the logs with outliers repaired and missing rows interpolated."""

    def repair(log: Log, name: str) -> tuple[Log, list[str]]:
        check = check_controller(log, model)
        commands = np.zeros(len(log), dtype=bool)
        if check is not None and check.reproduces:
            commands[list(check.doubted_commands)] = True
        whole, said = repaired(log, spikes(log.position), commands)
        whole, also = with_missing_rows(whole, model)
        return whole, [said, also]

    return logs.changed(repair)


def read_logs(logs: Logs, names: Sequence[str] | None = None, kind: str = "log") -> tuple[list[Log], list[str]]:
    """Read logs that are files, and return all logs with their names: as given, else the file, else a number.

    Raises:
        InputError: a file cannot be read.
        ValueError: the numbers of names and logs differ.
    """
    if isinstance(logs, Log | str | os.PathLike):
        logs = [logs]
    if names is not None and len(names) != len(logs):
        raise ValueError(f"names: must be one for each {kind}, got {len(names)} for {len(logs)}")
    called = [f"{kind} {i + 1}" if isinstance(log, Log) else os.fspath(log) for i, log in enumerate(logs)]
    return [log if isinstance(log, Log) else read_log(log) for log in logs], list(names or called)
