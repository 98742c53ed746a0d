"""What a fit would have answered otherwise: below other cut-offs, with fewer rows, with forces that no model has."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from cogging.arrays import FloatArray
from cogging.estimation.statistics import student
from cogging.identification.force_balance import BalanceEstimate, ForceBalance, Simulator, fit_force_balance
from cogging.identification.logged_run import LoggedRun
from cogging.logs.log import Log
from cogging.model.model import Model
from cogging.model.parameters import Scales

LEAST_CUTOFF = 4.0  # Hz
FURTHER = 2.0  # by which the cut-off is doubled and halved, and the rows are thinned
ITERATIONS = 8  # at most: one or two serve where the answer stays


@dataclass(frozen=True)
class OtherAnswer:
    """What some parameters are found to be in another way.

    Attributes:
        way: in words, as "below 40 Hz".
        values: by path; half_widths: of their 95 % intervals, likewise.
    """

    way: str
    values: dict[str, float]
    half_widths: dict[str, float]

    @classmethod
    def of(cls, way: str, paths: Sequence[str], values: FloatArray, half_widths: FloatArray) -> OtherAnswer:
        """The answer in one way, (p,) each."""
        known = zip(paths, values, half_widths, strict=True)
        table = {path: (float(value), float(half)) for path, value, half in known if np.isfinite([value, half]).all()}
        return cls(way, {p: v for p, (v, _) in table.items()}, {p: h for p, (_, h) in table.items()})


def other_answers(
    estimate: BalanceEstimate,
    paths: Sequence[str],
    runs: Sequence[LoggedRun],
    balances: Sequence[ForceBalance],
    scales: Scales,
    loose: FloatArray,
    rest: float | None,
) -> list[OtherAnswer]:
    """The force balance at twice and half the cut-off, and of every second row.

    Args:
        estimate: where to start.
        paths: what it moved.
        runs: the logs.
        balances: of the logs, as they were fitted.
        scales: of all of them.
        loose: 1-sigma about the start that is assumed of each parameter, (p,).
        rest: m/s, as in `ForceBalance.of`.
    """
    cutoff = balances[0].dynamics.cutoff
    step = max(balance.dynamics.sample_time for balance in balances)
    simulate = [run.simulator() for run in runs]
    rests = [rest if rest is not None else balance.rest for balance in balances]
    found = []
    for other in (FURTHER * cutoff, cutoff / FURTHER):
        if LEAST_CUTOFF <= other <= 0.2 / step:
            logs = [(run.log, run.hold, one) for run, one in zip(runs, rests, strict=True)]
            found.append(_answer(f"below {other:g} Hz", estimate.model, paths, logs, other, scales, simulate, loose))
    if cutoff <= 0.2 / (FURTHER * step):
        logs = [
            (thinned(run.log), run.hold or balance.dynamics.sample_time, one)
            for run, balance, one in zip(runs, balances, rests, strict=True)
        ]
        fewer = [_thinned_run(run) for run in simulate]
        found.append(_answer("with every second row", estimate.model, paths, logs, cutoff, scales, fewer, loose))
    return [answer for answer in found if answer is not None]


def thinned(log: Log) -> Log:
    """Every second row, with the mean of the two commands that acted in between."""
    columns = log.columns()
    first = columns["command"][::2]
    second = np.append(columns["command"][1::2], first[-1:])[: len(first)]
    return Log.of({**{name: column[::2] for name, column in columns.items()}, "command": 0.5 * (first + second)})


def _thinned_run(run: Simulator | None) -> Simulator | None:
    return None if run is None else lambda model: thinned(run(model))


def _answer(
    way: str,
    model: Model,
    paths: Sequence[str],
    logs: Sequence[tuple[Log, float | None, float]],
    cutoff: float,
    scales: Scales,
    simulate: Sequence[Simulator | None],
    loose: FloatArray,
) -> OtherAnswer | None:
    """The fit in one way; None where too few rows are left for it."""
    balances = [ForceBalance.of(log, cutoff=cutoff, rest=rest, hold=hold) for log, hold, rest in logs]
    if any(int(balance.mask.sum()) < 4 * len(paths) + 50 for balance in balances):
        return None
    estimate = fit_force_balance(model, paths, balances, scales, simulate, loose=loose, iterations=ITERATIONS)
    deviation = np.sqrt(np.maximum(np.diag(estimate.covariance), 0.0))
    half_widths = deviation * [student(float(freedom)) for freedom in estimate.freedom]
    return OtherAnswer.of(way, paths, estimate.values, half_widths)
