"""Whether a column of a log was read as something it is not: said only where that is beyond doubt."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from cogging.identification.misreading.by_balance import misread_by_balance, the_likelier
from cogging.identification.misreading.by_columns import misread_columns
from cogging.identification.misreading.by_controller import misread_by_controller
from cogging.identification.misreading.explained import explained_share
from cogging.identification.misreading.readings import Reading
from cogging.log_check.controller import check_controller
from cogging.log_check.recovery import recover_controller
from cogging.logs.log import Log
from cogging.logs.spikes import repaired, spikes
from cogging.model.model import Model

OF_UNITS = ("scale",)  # kinds that a controller of unknown gains does not tell


@dataclass(frozen=True)
class Misreading:
    """A column of a log that was read as something it is not.

    Attributes:
        column: of the log.
        misreading: sign, scale, swap, derivative (of the position), shift, or reference (given as position).
        factor: by which the column is to be multiplied, or None.
        rows: by which the command stands too late, negative: too early; or None.
        option: what to give on the command line, or "" where no option does it.
        alternatives: options that these logs cannot tell from it.
        explained: share of the command's power in motion that the model explains as the log was read; None: not told.
        explained_otherwise: the same with the column read so.
        logs: names of the logs.
        advice: what to do, in words.
        text: all that in a sentence.
    """

    column: str
    misreading: str
    factor: float | None
    rows: int | None
    option: str
    alternatives: tuple[str, ...]
    explained: float | None
    explained_otherwise: float | None
    logs: tuple[str, ...]
    advice: str
    text: str

    def to_dict(self) -> dict[str, Any]:
        """All of it for JSON."""
        return {**vars(self), "alternatives": list(self.alternatives), "logs": list(self.logs)}


@np.errstate(all="ignore")  # wild numbers are refused by those who compute with them
def misreading(logs: Sequence[Log], model: Model, names: Sequence[str] | None = None) -> Misreading | None:
    """What simple misreadings would do to logs that a model does not explain; a clear winner only.

    Tried of each log are the sign of command, position or reference; units of command, position and time; columns in
    each other's place; a velocity, or the reference, in place of the position; a command that stands rows too late or
    far too early. Judges are the columns themselves, the stated controller, and the force balance: mass and friction,
    which cannot be negative, beside a force of any place and a slow one in time. The balance speaks only where the log
    as read is excluded with mass and friction far from the model's and the other reading fits. A command that acts up
    to 15 ms or 10 rows late is left to the effects that do that.

    Args:
        logs: each is judged by itself.
        model: what is believed of the machine.
        names: of the logs; None: by their number.

    Returns:
        The misreading of the first log that has one, and of all that share it; None where none is clear.

    Example:
        >>> pushed = cogging.Log(log.time, log.position, -log.command)
        >>> misreading([pushed], model).option
        '--scale command=-1'
    """
    called = list(names) if names is not None else [f"log {i + 1}" for i in range(len(logs))]
    whole = [_without_spikes(log) for log in logs]
    judged = [readings_of(log, model) for log in whole]
    first = next((i for i, readings in enumerate(judged) if readings), None)
    if first is None:
        return None
    same = [i for i, readings in enumerate(judged) if readings and _alike(readings[0], judged[first][0])]
    return _told(judged[first], whole[first], model, [called[i] for i in same], everywhere=len(same) == len(logs))


def readings_of(log: Log, model: Model) -> list[Reading]:
    """The misreading of one log, with those that it cannot be told from; none where no winner is clear."""
    check = check_controller(log, model) if log.reference is not None else None
    if check is not None and check.reproduces:
        return misread_by_controller(log, model)
    found = misread_columns(log, model)
    if not found:
        by_controller = misread_by_controller(log, model)
        if by_controller:
            return the_likelier(log, model, by_controller)
        found = misread_by_balance(log, model)
    made = found and found[0].kind not in OF_UNITS and log.reference is not None and recover_controller(log) is not None
    return [] if made else found


def _without_spikes(log: Log) -> Log:
    return repaired(log, spikes(log.position), spikes(log.command))[0]


def _alike(one: Reading, other: Reading) -> bool:
    return (one.column, one.kind, dict(one.factors), one.shift) == (
        other.column,
        other.kind,
        dict(other.factors),
        other.shift,
    )


def _told(readings: Sequence[Reading], log: Log, model: Model, names: Sequence[str], *, everywhere: bool) -> Misreading:
    best = readings[0]
    explained, otherwise = _share(log, model), None if best.kind == "reference" else _share(best.of(log), model)
    prefixes = [""] if everywhere else [f"{name}:" for name in names]
    options = [reading.option(log, prefixes) for reading in readings]
    text = f"{', '.join(names)}: {best.column} {best.said}"
    if explained is not None and otherwise is not None:
        text += f"; the model explains {_percent(explained)} of the command's power in motion as it was read, "
        text += f"{_percent(otherwise)} otherwise"
    others = [f"{r.column} {r.said} ({option})" for r, option in zip(readings, options, strict=True)][1:]
    if others:
        text += f"; these logs cannot tell it from: {'; '.join(others)}"
    advice = best.advice(options[0])
    return Misreading(
        column=best.column,
        misreading=best.kind,
        factor=best.factors.get(best.column),
        rows=best.shift or None,
        option=options[0],
        alternatives=tuple(options[1:]),
        explained=explained,
        explained_otherwise=otherwise,
        logs=tuple(names),
        advice=f"{advice[0].upper()}{advice[1:]}.",
        text=f"{text}: {advice}",
    )


def _percent(share: float) -> str:
    return f"{100.0 * max(share, 0.0):.0f} %" if share < 0.995 else f"{100.0 * share:.3g} %"


def _share(log: Log, model: Model) -> float | None:
    try:
        share = explained_share([log], model)
    except ValueError:
        return None
    return share if share is not None and math.isfinite(share) else None
