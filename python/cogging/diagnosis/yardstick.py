"""Size of the gap of any model: by replaying the loop if the controller is known, else by the force balance."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from typing import Any

import numpy as np

from cogging._core import DivergedError
from cogging.arrays import FloatArray, Mask
from cogging.diagnosis.balance.decision import Outcome
from cogging.diagnosis.balance.evidence import Evidence, TooLittleMotion
from cogging.diagnosis.balance.nuisances import instruments_of
from cogging.diagnosis.running_controller import obeys
from cogging.estimation.replay import Replay
from cogging.logs.log import Log
from cogging.model.model import Model

REPLAYED, BALANCED = "command of the replayed loop", "force balance"
JITTER = 0.01  # of the sample time: largest jitter of a replay, whose derivatives it distorts
ACCELERATION_TIME = 0.02  # s: averaging time of the acceleration in the figures
GROWTH = 0.02  # of the gap's power: smaller growth is chance
POSITION_GROWTH = 1.1  # largest growth of the error of the replayed position
ROUNDS = 2  # of re-tuning on confirm logs: the second uses the friction width of the first


@dataclass(frozen=True)
class Discrepancy:
    """Unexplained force of logs under one model."""

    signal: str  # REPLAYED or BALANCED
    series: tuple[FloatArray, ...]  # unexplained force of each log, V
    #: Time, position, velocity, acceleration and command of the same rows; drive: the command without noise.
    rows: tuple[Mapping[str, FloatArray], ...]
    masks: tuple[Mask, ...]  # rows in motion of each log
    position: float | None = None  # rms of measured less replayed position, m; None without replay

    def in_motion(self, name: str = "") -> FloatArray:
        """Return a column of `rows`, by default the unexplained force, over the rows in motion of all logs, (n,)."""
        columns = [rows[name] for rows in self.rows] if name else self.series
        return np.concatenate([row[mask] for row, mask in zip(columns, self.masks, strict=True)])

    @property
    def columns(self) -> dict[str, Any]:
        """Columns of `rows` by name, one array per log."""
        return {name: [rows[name] for rows in self.rows] for name in self.rows[0]}

    @property
    def rms(self) -> float:
        """Rms over rows in motion, V."""
        return self.rms_of()

    def rms_of(self, name: str = "") -> float:
        """Return the rms of a column of `rows`, by default of the unexplained force, over rows in motion."""
        moving = self.in_motion(name)
        return float(np.sqrt(np.mean(moving**2))) if len(moving) else 0.0

    @property
    def push(self) -> float:
        """Sign of the missing force where the series is positive: an excess of command opposes the force."""
        return -1.0 if self.signal == REPLAYED else 1.0


@dataclass(frozen=True)
class Yardstick:
    """Measure of the gap of any model: nuisance parameters re-fitted under their priors, effects fixed."""

    found: Outcome  # of the search, which holds the force balances
    given: Sequence[Log]
    confirm: Sequence[Log]
    stated: Model  # model as read, with the running controller
    replay: bool  # whether to replay the loop
    #: Cache of models and their versions re-tuned to the confirm logs, by id.
    tuned: dict[int, tuple[Model, Model]] = field(default_factory=dict)

    def on_given(self, model: Model) -> Discrepancy:
        """Return the unexplained force of the given logs under a model.

        Raises:
            DivergedError: the replay diverged.
        """
        return self._of(self.given, self.found.evidence.balances, model, 0.0)

    def on_confirm(self, model: Model) -> Discrepancy | None:
        """Return the unexplained force of the confirm logs under a model re-tuned to them; None if none moves."""
        if not self.confirm:
            return None
        balances = self.found.both.balances[len(self.given) :]
        if id(model) not in self.tuned:
            try:
                self.tuned[id(model)] = model, self.there(model)
            except TooLittleMotion:
                return None
        return self._of(self.confirm, balances, self.tuned[id(model)][1], self.found.shift)

    def there(self, model: Model) -> Model:
        """Return the model re-tuned to the confirm logs within its stated uncertainty; changes of the axis stay."""
        held = {path.removeprefix("axis."): 0.0 for path in self.found.evidence.free}
        known = self.stated.replace(
            axis=self.stated.axis.replace(**{name: getattr(model.axis, name) for name in held}),
            uncertainty={**self.stated.uncertainty, **held},
            effects=model.effects,
        )
        balances = self.found.both.balances[len(self.given) :]
        evidence = Evidence(balances, known, model).prepare(ROUNDS)
        return evidence.settled(evidence.model)

    def by_balance(self) -> Yardstick:
        """Return the yardstick without replay."""
        return replace(self, replay=False)

    def _of(self, logs: Sequence[Log], balances: Sequence[Any], model: Model, shift: float) -> Discrepancy:
        if not self.replay:
            left, along = [], []
            for b in balances:
                one = instruments_of(b, model)  # the measured command and acceleration have the noise of the residual
                time, slow = b.time[:: b.every], b.low_passed(one.acceleration, 0.5 / ACCELERATION_TIME)
                left.append(b.low_passed(one.residual(b, model) * b.keep, b.corner)[:: b.every])
                along.append(_motion(b, time, slow if b.reference is None else b.reference[2]))
                for name, row in (("command", b.command), ("drive", one.drive)):
                    along[-1][name] = np.interp(time, b.time, b.low_passed(row, b.corner))
            return Discrepancy(BALANCED, tuple(left), tuple(along), tuple(b.mask for b in balances))
        series, rows, masks, errors = [], [], [], []
        for log, b in zip(logs, balances, strict=True):
            run = Replay(_moved(log, shift), model).run(model)
            if not np.isfinite(run["command"]).all():
                raise DivergedError("the replay diverged")
            time = log.time - log.time[0]
            masks.append(np.interp(time, b.time, b.keep) > 0.5)
            series.append(log.command - run["command"])
            errors.append(np.mean((log.position + shift - run["position"])[masks[-1]] ** 2))
            rows.append(_motion(b, time, b.reference[2]) | dict.fromkeys(("command", "drive"), run["command"]))
        error = float(np.sqrt(np.mean(errors)))
        return Discrepancy(REPLAYED, tuple(series), tuple(rows), tuple(masks), error)


def replayable(logs: Sequence[Log], confirm: Sequence[Log], model: Model) -> bool:
    """Return whether all loops can be replayed: uniform sampling and the stated controller."""
    if model.controller is None:
        return False
    for log in (*logs, *confirm):
        steps = np.diff(log.time)
        uneven = float(np.quantile(np.abs(steps / np.median(steps) - 1.0), 0.9)) > JITTER
        if log.reference is None or uneven:
            return False
    return all(obeys(log, model) for log in confirm)


def _moved(log: Log, distance: float) -> Log:
    if not distance:
        return log
    reference = None if log.reference is None else log.reference + distance
    return replace(log, position=log.position + distance, reference=reference)


def _motion(b: Any, time: FloatArray, acceleration: FloatArray) -> dict[str, FloatArray]:
    """Return time, position, velocity and acceleration of a balance at times (s), interpolated."""
    motion = {"position": b.position, "velocity": b.velocity, "acceleration": acceleration}
    return {"time": time, **{name: np.interp(time, b.time, row) for name, row in motion.items()}}


def growth(before: Discrepancy, after: Discrepancy) -> bool:
    """Return whether a gap or the error of the replayed position grows beyond chance."""
    return after.rms**2 > (1.0 + GROWTH) * before.rms**2 or bool(
        before.position and (after.position or 0.0) > POSITION_GROWTH * before.position
    )
