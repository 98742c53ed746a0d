"""How large the gaps of the nominal model, of it with one effect, with two and so on are, and whether one grows."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from typing import Any

import numpy as np

from cogging._core import DivergedError
from cogging.diagnosis.discrepancy import Discrepancy, discrepancies, floor_of, follows, has_balance, source_of
from cogging.diagnosis.entries import Gap
from cogging.diagnosis.evidence.allowance import Allowance
from cogging.diagnosis.running_controller import obeys
from cogging.diagnosis.large.balance import balances_of
from cogging.diagnosis.large.search import with_own_nuisances
from cogging.diagnosis.location import Location
from cogging.diagnosis.predictable import Predicted
from cogging.diagnosis.search.confirmation import as_there
from cogging.diagnosis.search.tuning import with_nuisances_tuned
from cogging.diagnosis.thresholds import ACCEPTANCE, GAP, LARGE
from cogging.estimation.innovations import Innovations
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
    """

    given: list[Discrepancy]
    confirm: list[Discrepancy] | None
    notes: tuple[str, ...] = ()

    @property
    def mostly_explained(self) -> bool:
        """Whether most of the gap's power is gone with all that was found."""
        return self.given[-1].rms ** 2 < LARGE.unexplained * self.given[0].rms ** 2

    def objection(self, least: float = 0.0) -> str:
        """Why what the last model has beyond the first does not enter it; empty where nothing speaks against that.

        Whitened residuals show whether it stands out of the noise. The gap, in which all noise counts, may not grow by
        more than chance, on given and on confirm logs; nor may the error of the replayed position.

        Args:
            least: share of the gap's power that it must take, on both.
        """
        for logs, what in ((self.given, "gap"), (self.confirm, "gap on the other motion")):
            if not logs:
                continue
            before, after = logs[0], logs[-1]
            chance = 0.0 if least else min(chance_of(before, after), ACCEPTANCE.power_growth * before.rms**2)
            if after.rms**2 >= (1.0 - least) * before.rms**2 + chance:
                return f"the {what} goes from {before.rms:.4g} to {after.rms:.4g} V with it"
            if before.position and (after.position or 0.0) > ACCEPTANCE.position_growth * before.position:
                return f"the error of the replayed position grows from {before.position:.4g} to {after.position:.4g} m"
        return ""


@dataclass(frozen=True)
class Yardstick:
    """How gaps are measured: the same in the search, for what is accepted, in the report and in the JSON.

    By the replayed loop where it follows the logs, else by an observer's innovations or the force balance. On the
    confirm logs effects are as they were found, and nuisances are tuned again.

    Attributes:
        logs, confirm: given and confirm logs.
        stated: model as it was read.
        fitted: model whose controller the confirm logs must obey to be replayed.
        paths: nuisances.
        allowed: how far they may go; None: freely.
        replay: whether the loop can be replayed on the given logs.
        balance: whether the gap is that of the force balance where no loop is replayed.
    """

    logs: Sequence[Log]
    confirm: Sequence[Log]
    stated: Model
    fitted: Model
    paths: Sequence[str]
    allowed: Allowance | None = None
    replay: bool = False
    balance: bool = False

    def measure(self, models: Sequence[Model], turns: Sequence[float] = ()) -> Measured:
        """The gaps of models, the last of which decides how they are measured.

        Args:
            models: models whose gaps are measured.
            turns: angle (rad) of each effect that the last one has beyond the stated one (confirmation.as_there); of
                the models before it, each has one effect less.
        """
        notes = []
        replay = self.replay
        given = self._of(self.logs, models, replay)
        if replay and not follows(given[-1], self.logs, models[-1]):
            replay = False
            given = self._of(self.logs, models, replay)
            notes.append("the replayed loop does not follow the log closely enough to measure with")
        if not self.confirm:
            return Measured(given, None, tuple(notes))
        loops = replay and self._confirm_loops
        if loops is not replay:
            notes.append("a confirm log does not obey the controller: its gap is that of an observer's innovations")
        added = [turns[: max(0, len(turns) - len(models) + 1 + i)] for i in range(len(models))]
        there = [self.elsewhere(as_there(one, turn)) for one, turn in zip(models, added, strict=True)]
        return Measured(given, self._of(self.confirm, there, loops), tuple(notes))

    def as_read(self, first: Discrepancy) -> Discrepancy | None:
        """Discrepancy of the stated model on the given logs, measured as the first one was; None where it cannot be."""
        try:
            read = self._of(self.logs, [self.stated], first.position is not None)[0]
        except (DivergedError, ValueError):
            return None
        return read if read.signal == first.signal else None

    def elsewhere(self, model: Model) -> Model:
        """The model with its nuisances tuned to the confirm logs, as far as they are allowed to move."""
        if self.balance and self.allowed is not None and has_balance(model):
            return with_own_nuisances(balances_of(self.confirm, self.stated).under(model), self.allowed).model
        return with_nuisances_tuned(model, self.paths, self._sources, self.allowed)

    def holding(self, paths: Sequence[str]) -> Yardstick:
        """The same, with these parameters no nuisances: what was found of them is an effect."""
        allowed = self.allowed and replace(self.allowed, exact=(*self.allowed.exact, *paths))
        return replace(self, paths=[path for path in self.paths if path not in paths], allowed=allowed)

    def as_measured(self, gap: Gap) -> Yardstick:
        """The same, by the replayed loop only where a gap was measured by it."""
        return replace(self, replay=gap.position_before is not None)

    def _of(self, logs: Sequence[Log], models: Sequence[Model], replay: bool) -> list[Discrepancy]:
        return discrepancies(logs, models, replay=replay, balance=self.balance, stated=self.stated)

    @cached_property
    def _sources(self) -> list[Innovations]:
        return [source_of(log, self.fitted) for log in self.confirm]

    @cached_property
    def _confirm_loops(self) -> bool:
        return all(obeys(log, self.fitted) for log in self.confirm)


def chance_of(before: Discrepancy, after: Discrepancy) -> float:
    """By how much chance may make the mean square of a gap grow: two deviations of what blocks of the logs say, V^2."""
    gains = [
        float(np.sum(part))
        for old, new, mask in zip(before.series, after.series, before.masks, strict=True)
        for part in np.array_split((new[mask] ** 2 - old[mask] ** 2), ACCEPTANCE.blocks)
    ]
    rows = sum(int(mask.sum()) for mask in before.masks)
    return float(2.0 * np.std(gains) * len(gains) ** 0.5 / max(rows, 1))


def gap_of(measured: Measured, read: Discrepancy | None, rest: Predicted, logs: Sequence[Log], final: Model) -> Gap:
    """The gap as given, re-tuned and with all that was found, of the given and the confirm logs.

    Args:
        measured: gaps of the nominal model up to the final one.
        read: gap of the model as it was read.
        rest: what a generic force predicts of the rest.
        logs: given logs.
        final: model with all that was found.
    """
    before, after, confirm = measured.given[0], measured.given[-1], measured.confirm
    command = np.concatenate([log.command[mask] for log, mask in zip(logs, after.masks, strict=True)])
    rms = float(np.sqrt(np.mean(command**2))) if len(command) else 0.0
    return Gap(
        "V",
        min(floor_of(after, logs, final), after.rms),
        before.rms,
        after.rms,
        confirm[0].rms if confirm else None,
        confirm[-1].rms if confirm else None,
        before.signal,
        before.position,
        after.position,
        None if read is None else read.rms,
        after.rms / rms if rms > 0.0 else None,
        rest.elsewhere,
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
