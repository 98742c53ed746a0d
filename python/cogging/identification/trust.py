"""What speaks against a fit: sentences for its reader, and intervals that strong unmodelled forces widen or refuse."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from cogging.identification.other_answers import OtherAnswer
from cogging.identification.result import LogFit, ParameterEstimate, percent
from cogging.identification.unmodelled import Unmodelled
from cogging.model.intervals import SIGMAS_95
from cogging.model.parameters import Parameter

SHOWN = 3  # parameters that one sentence names


@dataclass(frozen=True)
class TrustLimits:
    """From where something is said, set on drawn machines.

    Attributes:
        missing: residual over noise, from which something is missing; good logs leave 1.0 to 1.3 times the noise.
        strong: rms of what is missing over that of the command, from which parameters stay as given and intervals
            allow for it: of models that lack 10 to 90 % of the command they would hold the truth in 77 % of cases.
        buried: residual over noise, from which they do too: what is missing is then 15 of 16 parts of what is left.
        explained: share of the command's power, below which a model explains too little.
        check: difference of the two estimators in standard deviations, from which they do likewise.
        worse: residual or replay over that of the model as given.
        moved: move of a value in another way of fitting, over the larger of the halves of both intervals.
    """

    missing: float = 2.0
    strong: float = 0.05
    buried: float = 4.0
    explained: float = 0.5
    check: float = 5.0
    worse: float = 1.05
    moved: float = 3.0


def is_missing(left: Unmodelled, limits: TrustLimits) -> bool:
    """Whether a log's residual is many times its noise."""
    return left.residual > limits.missing * left.noise


def is_strong(left: Unmodelled, limits: TrustLimits) -> bool:
    """Whether what is missing is so much of the command that the scatter of blocks does not tell what it does."""
    much = left.structured > limits.strong * left.command or left.residual > limits.buried * left.noise
    return is_missing(left, limits) and much


def moved_beyond(
    path: str, value: float, half_width: float, others: Sequence[OtherAnswer], share: float
) -> dict[str, float]:
    """The other answers of a parameter that lie beyond `share` times the larger half interval, by their way."""
    beyond = {}
    for other in others:
        if path in other.values:
            reach = share * max(half_width, other.half_widths[path])
            if abs(other.values[path] - value) > reach:
                beyond[other.way] = other.values[path]
    return beyond


def warnings_of(
    logs: Sequence[LogFit],
    parameters: Sequence[ParameterEstimate],
    held: Sequence[str],
    limits: TrustLimits,
    unit: str,
) -> tuple[str, ...]:
    """What is to be said against a fit, most important first.

    Args:
        logs: what each says of it.
        parameters: as fitted.
        held: paths of those that stay as given for what is missing.
        limits: from where something is said.
        unit: of the command.
    """
    said = [sentence for log in logs for sentence in _of_log(log, limits, unit)]
    if held:
        said.append(f"what is missing is too much of the command to tell {_some(held)}: as given")
    said += _of_estimators([p for p in parameters if p.path not in held], limits)
    return (*said, *_of_other_answers(parameters))


def _of_log(log: LogFit, limits: TrustLimits, unit: str) -> list[str]:
    said = []
    missing = log.noise is not None and log.residual_free > limits.missing * log.noise
    if missing and log.noise is not None:
        times = log.residual_free / max(log.noise, 1e-300)
        share = 1.0 - (log.residual_free / max(log.command, 1e-300)) ** 2
        said.append(
            f"{log.name}: something is missing: the model leaves {log.residual_free:.3g} {unit}, {times:.3g} times the "
            f"noise ({log.noise:.2g} {unit}), and explains {percent(share)} of the command: run diagnose"
        )
    if log.explained < limits.explained and not missing:
        said.append(f"{log.name}: the model explains only {percent(log.explained)} of the command")
    if log.residual_after > limits.worse * log.residual_before:
        said.append(
            f"{log.name}: the fit is worse than the model as given: force balance {log.residual_before:.4g} {unit} "
            f"before, {log.residual_after:.4g} {unit} after"
        )
    for name in ("position", "command"):
        before, after = log.replay_before.get(name), log.replay.get(name)
        if before is not None and after is not None and after > limits.worse * before:
            said.append(
                f"{log.name}: the fit is worse than the model as given: replayed {name} off by {100 * before:.3g} % "
                f"before, by {100 * after:.3g} % after"
            )
    if log.replay_before and not log.replay:
        said.append(f"{log.name}: the fit is worse than the model as given: its replay diverges")
    return said


def _of_estimators(parameters: Sequence[ParameterEstimate], limits: TrustLimits) -> list[str]:
    apart = [p for p in parameters if p.difference is not None and abs(p.difference) > limits.check]
    if not apart:
        return []
    apart.sort(key=lambda p: -abs(p.difference or 0.0))
    told = [
        f"{p.path} ({p.inverse_dynamics:.4g} and {p.output_error:.4g} {p.unit}, {abs(p.difference or 0.0):.2g} sigma)"
        for p in apart[:SHOWN]
        if p.inverse_dynamics is not None and p.output_error is not None
    ]
    return [f"inverse dynamics and output error contradict each other: {_listed(told, len(apart))}"]


def _of_other_answers(parameters: Sequence[ParameterEstimate]) -> list[str]:
    ways: dict[str, list[str]] = {}
    for p in parameters:
        for way, value in p.elsewhere.items():
            ways.setdefault(way, []).append(f"{p.path} is {value:.4g} in place of {p.value:.4g} {p.unit}")
    return [f"{way}, {_listed(told[:SHOWN], len(told))}" for way, told in ways.items()]


def _some(paths: Sequence[str]) -> str:
    return _listed(list(paths[:SHOWN]), len(paths))


def _listed(told: Sequence[str], number: int) -> str:
    more = f" and {number - len(told)} more" if number > len(told) else ""
    return ", ".join(told) + more


def widened_interval(answers: Sequence[tuple[float, float]]) -> tuple[float, float]:
    """The interval that holds all answers, each a value and half of its 95 % interval."""
    values, halves = np.array(answers).T
    return float(np.min(values - halves)), float(np.max(values + halves))


def is_refuted(prior: Parameter, sigma: float, interval: tuple[float, float]) -> bool:
    """Whether a parameter as given, with its stated relative uncertainty, lies outside an interval altogether."""
    reach = SIGMAS_95 * sigma * abs(prior.value)
    return not interval[0] - reach <= prior.value <= interval[1] + reach
