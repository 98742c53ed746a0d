"""How large the gap is, before and after: by replaying the loop where the controller is known, else by prediction."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from cogging._core import DivergedError
from cogging.arrays import FloatArray, Mask
from cogging.diagnosis.large.balance import balances_of, is_load
from cogging.diagnosis.residual.shapes import coordinates
from cogging.diagnosis.thresholds import GAP, OBSERVER
from cogging.estimation.innovations import Innovations
from cogging.estimation.replay import Replay
from cogging.logs.log import Log
from cogging.model.model import Model


@dataclass(frozen=True)
class Discrepancy:
    """The discrepancy between logs and one model: the `gap` of the result.

    Attributes:
        rms: root mean square over rows in motion of all logs, V.
        signal: name of what was compared.
        series: discrepancy of each log, V, one (n,) a log.
        masks: rows in motion of each log, one (n,) a log.
        position: rms of measured less replayed position, m, or None.
    """

    rms: float
    signal: str
    series: tuple[FloatArray, ...]
    masks: tuple[Mask, ...]
    position: float | None


def discrepancies(
    logs: Sequence[Log],
    models: Sequence[Model],
    *,
    replay: bool,
    balance: bool = False,
    stated: Model | None = None,
) -> list[Discrepancy]:
    """The discrepancy of each model, by the replay of the loop where it can be had for every model, else by prediction.

    A controller that is sampled with jitter is not replayed: what the jitter does to its derivative would be the gap.

    Args:
        logs: logs that are measured.
        models: models that are held against them.
        replay: whether the loop may be replayed.
        balance: whether, instead of a prediction, the force balance is taken where every model has one: a prediction
            errs by the less, the more its own friction damps it, and a fit of what is large would make use of that.
        stated: model whose mass turns innovations into forces, and that sets the band of the force balance: what a fit
            makes of the mass must not; None: the first.
    """
    if replay and not any(jitters(log) for log in logs):
        try:
            return _replayed(logs, models)
        except (DivergedError, ValueError):
            pass
    if balance and all(has_balance(model) for model in models):
        return _balanced(logs, models, models[0] if stated is None else stated)
    series: list[list[FloatArray]] = [[] for _ in models]
    masks = []
    for log in logs:
        source = source_of(log, models[0] if stated is None else stated)
        masks.append(source.mask > 0)
        for i, row in enumerate(source.of(models)):
            series[i].append(row)
    signal = "innovations of an observer"
    return [Discrepancy(_rms(rows, masks), signal, tuple(rows), tuple(masks), None) for rows in series]


def jitters(log: Log) -> bool:
    """Whether the steps of the log's time differ by more than GAP.jitter of their median."""
    steps = np.diff(log.time)
    return float(np.quantile(np.abs(steps / np.median(steps) - 1.0), GAP.jitter_quantile)) > GAP.jitter


def source_of(log: Log, model: Model) -> Innovations:
    """The log as the model predicts it.

    An axis that keeps turning back would leave a slow observer no rows: it then gets a faster one, and less of rest.
    """
    source = Innovations(log, model, bandwidth=OBSERVER.gap_bandwidth)
    if source.mask.mean() < OBSERVER.moving_rows:
        source = Innovations(
            log,
            model,
            bandwidth=min(OBSERVER.turning_bandwidth, OBSERVER.bandwidth_of_rate / source.scales.sample_time),
        )
    if source.mask.mean() < OBSERVER.moving_rows:
        source = Innovations(
            log, model, bandwidth=source.bandwidth, rest=OBSERVER.rest_of_speed * source.scales.velocity
        )
    return source


def has_balance(model: Model) -> bool:
    """Whether a model has a force balance: no state of its own but that of a load that hangs on the motor."""
    return all("state" not in effect.HOOKS or is_load(effect) for effect in model.effects)


def _balanced(logs: Sequence[Log], models: Sequence[Model], stated: Model) -> list[Discrepancy]:
    balances = balances_of(logs, stated)
    found = []
    for model in models:
        rows = [source.of([model])[0] for source in balances.sources]
        even = [source.balance.dynamics.even for source in balances.sources]
        series = tuple(np.interp(log.time, at, row) for log, at, row in zip(logs, even, rows, strict=True))
        masks = tuple(
            np.round(np.interp(log.time, at, source.mask.astype(float))) > 0
            for log, at, source in zip(logs, even, balances.sources, strict=True)
        )
        rms = float(np.sqrt(np.mean(balances.joined(rows) ** 2)))
        found.append(Discrepancy(rms, "force balance", series, masks, None))
    return found


def _replayed(logs: Sequence[Log], models: Sequence[Model]) -> list[Discrepancy]:
    series: list[list[FloatArray]] = [[] for _ in models]
    errors: list[list[float]] = [[] for _ in models]
    masks = []
    for log in logs:
        replays = [Replay(log, model) for model in models]
        masks.append(source_of(log, models[0]).mask > 0)
        for i, (one, model) in enumerate(zip(replays, models, strict=True)):
            run = one.run(model)
            series[i].append(log.command - run["command"])
            errors[i].append(_rms([log.position - run["position"]], masks[-1:]) ** 2)
    return [
        Discrepancy(
            _rms(rows, masks),
            "command of the replayed loop",
            tuple(rows),
            tuple(masks),
            float(np.mean(error)) ** 0.5,
        )
        for rows, error in zip(series, errors, strict=True)
    ]


def _rms(rows: Sequence[FloatArray], masks: Sequence[Mask]) -> float:
    moving = np.concatenate([row[mask] for row, mask in zip(rows, masks, strict=True)])
    return float(np.sqrt(np.mean(moving**2))) if len(moving) else 0.0


def follows(seen: Discrepancy, logs: Sequence[Log], model: Model) -> bool:
    """Whether a model's replayed loop follows the logs closely enough to measure with.

    What the loop makes of friction at each reversal would else be the discrepancy.
    """
    return seen.rms <= GAP.followed * floor_of(seen, logs, model)


def floor_of(seen: Discrepancy, logs: Sequence[Log], model: Model) -> float:
    """What noise and quantiser alone would leave, V.

    The rms of the discrepancy once any force of position (for each direction), speed, time and acceleration is taken
    from it, over the rows less the freedom that this takes.
    """
    total, rows = 0.0, 0
    for series, mask, log in zip(seen.series, seen.masks, logs, strict=True):
        source = source_of(log, model)
        if not (source.mask > 0).any():
            return seen.rms
        known = coordinates(source, model)
        forces = (known[name][2]()[:, mask] for name in ("position", "velocity", "time", "acceleration"))
        table = np.concatenate([np.ones((1, int(mask.sum()))), *forces])
        size = np.sqrt(np.einsum("ij,ij->i", table, table))
        if not size.all():
            table, size = table[size > 0], size[size > 0]
        table /= size[:, None]
        gram = table @ table.T
        weights = np.linalg.lstsq(gram + GAP.floor_rank * np.eye(len(gram)), table @ series[mask], rcond=None)[0]
        left = series[mask] - weights @ table
        total += float(left @ left)
        rows += len(left) - int(np.linalg.matrix_rank(gram, tol=GAP.floor_rank, hermitian=True))
    return float(np.sqrt(total / max(rows, 1)))
