"""How large the gaps of the nominal model, of it with one effect, with two and so on are, and whether one grows."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from cogging._core import DivergedError
from cogging.diagnosis.discrepancy import Discrepancy, discrepancies, floor_of, follows
from cogging.diagnosis.entries import Gap
from cogging.diagnosis.evidence.preparation import Prepared
from cogging.diagnosis.evidence.running_controller import obeys
from cogging.diagnosis.location import Location
from cogging.diagnosis.thresholds import ACCEPTANCE, GAP, LARGE
from cogging.estimation.statistics import moving_average
from cogging.logs.log import Log
from cogging.model.model import Model


@dataclass(frozen=True)
class Measured:
    """The gaps of several models: nominal, with one effect, with two, and so on.

    Attributes:
        given: discrepancies on the given logs, one a model.
        confirm: the same on the confirm logs; None without.
        notes: sentences on how they could not be measured.
        stated: discrepancy of the model as it was read, on the given logs.
    """

    given: list[Discrepancy]
    confirm: list[Discrepancy] | None
    notes: tuple[str, ...]
    stated: Discrepancy

    @property
    def mostly_explained(self) -> bool:
        """Whether most of the gap's power is gone with all that was found."""
        return self.given[-1].rms ** 2 < LARGE.unexplained * self.given[0].rms ** 2


def measure(
    logs: Prepared,
    models: Sequence[Model],
    there: Sequence[Model],
    fitted: Model,
    stated: Model,
    *,
    replay: bool,
    balance: bool,
) -> Measured:
    """Measure the gaps of models, the last of which is the final one, by the replayed loop where it follows the logs.

    Args:
        logs: given and confirm logs.
        models: models whose gaps are measured.
        there: the same as they hold on the confirm logs.
        fitted: model whose controller the confirm logs must obey to be replayed.
        stated: model as it was read.
        replay: whether the loop can be replayed on the given logs.
        balance: whether the gap is that of the force balance where no loop is replayed.
    """
    notes = []
    given = discrepancies(logs.given, models, replay=replay, balance=balance, stated=stated)
    if replay and not follows(given[-1], logs.given, models[-1]):
        replay = False
        given = discrepancies(logs.given, models, replay=False, balance=balance, stated=stated)
        notes.append("the replayed loop does not follow the log closely enough to measure with: friction at reversals")
    loops = replay and all(obeys(log, fitted) for log in logs.confirm)
    confirm = None
    if logs.confirm:
        confirm = discrepancies(logs.confirm, there, replay=loops, balance=balance, stated=stated)
    if confirm and loops is not replay:
        notes.append("a confirm log does not obey the controller: its gap is that of an observer's innovations")
    as_read = _as_read(logs.given, [*models, stated], given[0], replay=replay, balance=balance)
    if as_read is not None and as_read.rms < given[0].rms:
        given = [as_read, *given[1:]]  # re-tuning that makes the gap larger is none
    return Measured(given, confirm, tuple(notes), given[0] if as_read is None else as_read)


def growth(measured: Measured) -> str:
    """By what a gap, or the replayed position, grew with what was added; empty where nothing did."""
    pairs = [
        ("gap", measured.given[0].rms, measured.given[-1].rms),
        ("gap as read", measured.stated.rms, measured.given[-1].rms),
    ]
    if measured.confirm:
        pairs.append(("gap on the other motion", measured.confirm[0].rms, measured.confirm[-1].rms))
    limit = ACCEPTANCE.position_growth / ACCEPTANCE.gap_growth
    for logs in (measured.given, measured.confirm or []):
        if logs and logs[0].position is not None and logs[-1].position is not None:
            pairs.append(("error of the replayed position", limit * logs[0].position, logs[-1].position))
    for what, before, after in pairs:
        if after > ACCEPTANCE.gap_growth * before:
            return f"with all that was found the {what} grows from {before:.4g} to {after:.4g}"
    return ""


def _as_read(
    logs: Sequence[Log], models: Sequence[Model], first: Discrepancy, *, replay: bool, balance: bool
) -> Discrepancy | None:
    """The discrepancy of the last of models, measured as that of the first was; None where it cannot be."""
    try:
        read = discrepancies(logs, models, replay=replay, balance=balance, stated=models[-1])[-1]
    except (DivergedError, ValueError):
        return None
    return read if read.signal == first.signal else None


def gap_of(measured: Measured, logs: Sequence[Log], final: Model) -> Gap:
    """The gap as given, re-tuned and with all that was found, of the given and the confirm logs."""
    before, after = measured.given[0], measured.given[-1]
    return Gap(
        "V",
        min(floor_of(after, logs, final), after.rms),
        before.rms,
        after.rms,
        measured.confirm[0].rms if measured.confirm else None,
        measured.confirm[-1].rms if measured.confirm else None,
        before.signal,
        before.position,
        after.position,
        measured.stated.rms,
    )


def series_of(logs: Sequence[Log], measured: Sequence[Discrepancy], location: Location) -> dict[str, Any]:
    """Rows of the logs by name, for the figures."""
    before, after = measured[0], measured[-1]
    # A replayed gap is part of the logged command: against that, noise alone would look like a gain.
    replayed = before.signal.startswith("command")
    velocities = location.series["velocity"]
    return {
        "logs": list(logs),
        "time": [log.time for log in logs],
        "gap_before": before.series,
        "gap_after": after.series,
        "mask": before.masks,
        "position": [log.position for log in logs],
        "velocity": velocities,
        "acceleration": [
            np.gradient(moving_average(velocity, round(GAP.smoothing / float(np.median(np.diff(log.time))))), log.time)
            for velocity, log in zip(velocities, logs, strict=True)
        ],
        "command": [log.command - (gap if replayed else 0.0) for log, gap in zip(logs, before.series, strict=True)],
    }
