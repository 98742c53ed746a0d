"""Logs made ready to be searched: read, checked, each row counted once, without pauses and single bad values."""

from __future__ import annotations

import os
from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from cogging.log_check.controller_check import check_controller, with_missing_rows
from cogging.log_check.log_audit import audit, check_against_model, hints
from cogging.logs.log import Log, read_log
from cogging.logs.pauses import without_pauses
from cogging.logs.repeated_rows import counted_once, repeated, repeated_text
from cogging.logs.spikes import repaired, spikes
from cogging.model.model import Model

ROWS_MIN = 500  # rows of a log: noise and friction are not told apart in fewer
Logs = Log | str | os.PathLike[str] | Sequence[Log | str | os.PathLike[str]]


@dataclass(frozen=True)
class Prepared:
    """The logs of one diagnosis.

    Attributes:
        given, names: logs that are searched, and what each is called in messages.
        confirm, confirm_names: logs of other motion, and what each is called.
        notes: sentences on what was done to them.
    """

    given: list[Log]
    names: list[str]
    confirm: list[Log]
    confirm_names: list[str]
    notes: tuple[str, ...]


def prepared(
    logs: Logs, model: Model, confirm: Logs, names: Sequence[str] | None, confirm_names: Sequence[str] | None
) -> Prepared:
    """The logs as they are searched: read and checked, rows that stand in several once, pauses cut out.

    Raises:
        ValueError: a log that cannot be used with the model, or a confirm log with rows of a given one.
        InputError: a file that cannot be read.
    """
    given, called = read_logs(logs, names)
    others, others_called = read_logs(confirm, confirm_names, "confirm log")
    if not given:
        raise ValueError("logs: must be at least 1, got 0")
    for name, log in zip((*called, *others_called), (*given, *others), strict=True):
        if len(log) < ROWS_MIN:
            raise ValueError(f"{name}: rows: must be at least {ROWS_MIN} to be diagnosed, got {len(log)}")
        check_against_model(log, model, name)
    whole = _counted_once(given, called, others, others_called)
    notes = list(whole.notes)
    given = [_without_pauses(log, name, notes) for log, name in zip(whole.given, whole.names, strict=True)]
    others = [_without_pauses(log, name, notes) for log, name in zip(whole.confirm, whole.confirm_names, strict=True)]
    for log, name in zip((*given, *others), (*whole.names, *whole.confirm_names), strict=True):
        notes += [f"{name}: {hint}" for hint in hints(audit(log), model)]
    return replace(whole, given=given, confirm=others, notes=tuple(notes))


def _counted_once(given: list[Log], called: list[str], others: list[Log], others_called: list[str]) -> Prepared:
    """Given and confirm logs, with rows that stand in several logs of a kind only once.

    Raises:
        ValueError: a confirm log has rows of a given one: it would confirm what was found in it.
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


def _without_pauses(log: Log, name: str, notes: list[str]) -> Log:
    """The log as it is searched: what a pause of a day would need is not laid out row by row."""
    try:
        running, said = without_pauses(log)
    except ValueError as error:
        raise ValueError(f"{name}: {error}") from None
    if said:
        notes.append(f"{name}: {said}")
    return running


def whole_logs(logs: Prepared, model: Model) -> Prepared:
    """The logs without single values that nobody saw, and with the rows that they lack."""
    notes = list(logs.notes)
    given = [_whole(log, model, name, notes) for log, name in zip(logs.given, logs.names, strict=True)]
    others = [_whole(log, model, name, notes) for log, name in zip(logs.confirm, logs.confirm_names, strict=True)]
    return replace(logs, given=given, confirm=others, notes=tuple(notes))


def _whole(log: Log, model: Model, name: str, notes: list[str]) -> Log:
    """One log repaired: after a bad value or a missing row, an observer rings."""
    check = check_controller(log, model)
    commands = np.zeros(len(log), dtype=bool)
    if check is not None and check.reproduces:
        commands[list(check.doubted_commands)] = True
    whole, said = repaired(log, spikes(log.position), commands)
    whole, also = with_missing_rows(whole, model)
    notes += [f"{name}: {text}" for text in (said, also) if text]
    return whole


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
