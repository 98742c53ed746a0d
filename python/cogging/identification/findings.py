"""What the estimators found in the logs, and the result made of it."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from cogging._core import DivergedError
from cogging.arrays import FloatArray
from cogging.effects.effect import VOCABULARY
from cogging.estimation.statistics import student
from cogging.identification.determinability import UNDETERMINED, Determinability, size_of
from cogging.identification.force_balance import BalanceEstimate, ForceBalance
from cogging.identification.logged_run import LoggedRun
from cogging.identification.other_answers import OtherAnswer
from cogging.identification.result import Identification, LogFit, ParameterEstimate
from cogging.identification.trust import (
    TrustLimits,
    is_missing,
    is_refuted,
    is_strong,
    moved_beyond,
    warnings_of,
    widened_interval,
)
from cogging.identification.unmodelled import AS_NOISE, WITH_FORCES, Unmodelled
from cogging.model.intervals import SIGMAS_95
from cogging.model.model import Model
from cogging.model.parameters import Parameter, Scales, parameters_of, with_values


@dataclass(frozen=True)
class Values:
    """Values of some parameters by one estimator: covariance (p, p) and degrees of freedom (p,)."""

    paths: tuple[str, ...]
    values: FloatArray
    covariance: FloatArray
    freedom: FloatArray

    def value(self, path: str) -> float:
        """What a parameter was found to be."""
        return float(self.values[self.paths.index(path)])

    def sigma(self, path: str) -> float:
        """Its standard deviation."""
        i = self.paths.index(path)
        return float(np.sqrt(self.covariance[i, i]))

    def half_width(self, path: str) -> float:
        """Half of its 95 % interval."""
        return student(float(self.freedom[self.paths.index(path)])) * self.sigma(path)


@dataclass(frozen=True)
class Findings:
    """What the estimators found.

    Attributes:
        told: what the logs determine.
        estimate: of the force balance.
        balance: its values; output: those of the output error, or None.
        spread: standard deviation of the values of logs fitted one by one, and the rms of their own, by path.
        balances: of the logs.
        floors: what quantiser and noise leave of each, V.
        left: what the fit of the force balance leaves of each.
        others: what it would have answered otherwise; first with further forces beside the model, then bent by them.
    """

    told: Determinability
    estimate: BalanceEstimate
    balance: Values
    output: Values | None
    spread: Mapping[str, tuple[float, float]]
    balances: tuple[ForceBalance, ...]
    floors: tuple[float, ...]
    left: tuple[Unmodelled, ...] = ()
    others: tuple[OtherAnswer, ...] = ()


def report(prior: Model, runs: Sequence[LoggedRun], found: Findings) -> Identification:
    """The result: the output error's values where the force balance does not see all, else the balance's."""
    told, limits = found.told, TrustLimits()
    reported, whole = _reported(prior, found), not has_states(prior)  # whether the balance holds all of the model
    strong = whole and any(is_strong(left, limits) for left in found.left)
    known = parameters_of(prior)
    missing = whole and any(is_missing(left, limits) for left in found.left)
    asked = _Asked(prior, reported, found, missing, strong, limits)
    entries = [asked.entry(known[path], note) for path, note in zip(told.paths, told.notes, strict=True)]
    fitted = {entry.path: entry.value for entry in entries if entry.determined and entry.value != entry.prior}
    model = with_values(prior, fitted)
    models = (prior, model, with_values(found.estimate.model, fitted))
    intervals = {**model.intervals, **{entry.path: entry.ci95 for entry in entries}}
    covariance = _covariance(entries, reported)
    size = np.sqrt(np.diag(covariance))
    size[size == 0.0] = 1.0
    of_logs = zip(runs, found.balances, found.floors, found.left, strict=True)
    logs = tuple(_log_fit(*of_log, models, found.estimate.instruments, whole) for of_log in of_logs)
    held = [e.path for e in entries if strong and told.determined(e.path) and e.value == e.prior]
    return Identification(
        model=model.replace(intervals=intervals),
        parameters=tuple(entries),
        correlation=covariance / np.outer(size, size),
        covariance=covariance,
        determinability=tuple(entry.note for entry in entries),
        logs=logs,
        audits=tuple(run.audit for run in runs),
        cutoff=found.balances[0].dynamics.cutoff,
        estimator="inverse_dynamics" if reported is found.balance else "output_error",
        controller=tuple(run.line for run in runs if run.line),
        explained=_of_all(logs),
        warnings=(
            *(run.sparse for run in runs if run.sparse),
            *warnings_of(logs, entries, held, limits, prior.units.command),
        ),
    )


def _reported(prior: Model, found: Findings) -> Values:
    """Whose values count."""
    told, inside = found.told, found.balance.paths
    hidden = any(told.determined(path) and path not in inside for path in told.paths)
    return found.output if found.output is not None and (hidden or has_states(prior)) else found.balance


def _covariance(entries: Sequence[ParameterEstimate], reported: Values) -> FloatArray:
    """Of what is determined, 0 elsewhere, (p, p), as much wider as the intervals are."""
    covariance = np.zeros((len(entries), len(entries)))
    known = [i for i, entry in enumerate(entries) if entry.determined]
    inner = [reported.paths.index(entries[i].path) for i in known]
    halves = np.array([0.5 * (entries[i].ci95[1] - entries[i].ci95[0]) for i in known])
    usual = np.array([max(reported.half_width(entries[i].path), 1e-300) for i in known])
    wider = np.maximum(halves / usual, 1.0)
    covariance[np.ix_(known, known)] = reported.covariance[np.ix_(inner, inner)] * np.outer(wider, wider)
    return covariance


@dataclass(frozen=True)
class _Asked:
    """What each parameter is asked of.

    Attributes:
        prior: the model as given.
        reported: the values that count.
        found: by all estimators.
        missing: whether something is.
        strong: whether it is so much that the intervals must allow for it.
        limits: from where something is said.
    """

    prior: Model
    reported: Values
    found: Findings
    missing: bool
    strong: bool
    limits: TrustLimits

    def entry(self, prior: Parameter, note: str) -> ParameterEstimate:
        """One parameter of the result."""
        path, balance, output = prior.path, self.found.balance, self.found.output
        spread, seen = self.found.spread.get(path), self.found.told.determined(path)
        inverse = balance.value(path) if seen and path in balance.paths else None
        by_output = output.value(path) if output is not None and path in output.paths else None
        difference = _difference(path, balance, output)
        doubted = self.strong or abs(difference or 0.0) > self.limits.check
        determined = seen and path in self.reported.paths and bool(np.isfinite(self.reported.sigma(path)))
        value, interval, elsewhere = prior.value, (-np.inf, np.inf), dict[str, float]()
        if determined:
            settled, wide = self._settled(prior) if doubted else self._as_reported(path)
            determined = not (doubted and self._is_lost(prior, wide))
            if determined:
                unasked = (AS_NOISE,) if self.missing else (AS_NOISE, WITH_FORCES)
                others = [other for other in self.found.others if other.way not in unasked]
                elsewhere = moved_beyond(path, settled, 0.5 * (wide[1] - wide[0]), others, self.limits.moved)
                value, interval = settled, (max(wide[0], 0.0) if prior.positive else wide[0], wide[1])
            if doubted:
                known = "not determined" if not determined else "as given" if value == prior.value else "moved"
                range_of_it = f"[{wide[0]:.4g}, {wide[1]:.4g}]"
                note = f"{note.split(':')[0]}: {known}, what the model lacks leaves it open over {range_of_it}"
        return ParameterEstimate(
            path=path,
            unit=prior.unit,
            prior=prior.value,
            value=value,
            ci95=interval,
            determined=determined,
            inverse_dynamics=inverse,
            output_error=by_output,
            difference=difference,
            spread=None if spread is None else spread[0],
            single_sigma=None if spread is None else spread[1],
            note=note,
            elsewhere=elsewhere,
        )

    def _as_reported(self, path: str) -> tuple[float, tuple[float, float]]:
        """Value and 95 % interval of the estimator that is reported."""
        value, half = self.reported.value(path), self.reported.half_width(path)
        return value, (value - half, value + half)

    def _settled(self, prior: Parameter) -> tuple[float, tuple[float, float]]:
        """Value and 95 % interval where the model lacks much, or the estimators contradict each other.

        The interval reaches to either side as far as to the intervals of both, and to what the balance says beside
        further forces and bent by them. The prior stands, unless these exclude it: then the balance beside forces does.
        """
        path, found = prior.path, self.found
        others = [other for other in found.others[:2] if path in other.values]
        if not others:
            return prior.value, (-np.inf, np.inf)
        both = [one for one in (found.balance, found.output) if one is not None and path in one.paths]
        answers = [(one.value(path), one.half_width(path)) for one in both]
        low, high = widened_interval(answers + [(other.values[path], other.half_widths[path]) for other in others])
        sigma = self.prior.uncertainty.get(path.removeprefix("axis."), 0.0)
        value = others[0].values[path] if is_refuted(prior, sigma, (low, high)) else prior.value
        reach = max(value - low, high - value)
        return value, (value - reach, value + reach)

    def _is_lost(self, prior: Parameter, interval: tuple[float, float]) -> bool:
        """Whether what is missing leaves an interval as wide as that of a parameter that no log determines."""
        scales = Scales.largest(balance.scales for balance in self.found.balances)
        sigma = 0.5 * (interval[1] - interval[0]) / SIGMAS_95
        return sigma > UNDETERMINED * size_of(self.found.estimate.model, prior, scales)


def _difference(path: str, balance: Values, output: Values | None) -> float | None:
    """The output error's value less the balance's, in units of its standard deviation were they independent."""
    if output is None or path not in output.paths or path not in balance.paths:
        return None
    sigma = float(np.hypot(balance.sigma(path), output.sigma(path)))
    return (output.value(path) - balance.value(path)) / sigma if sigma > 0 else None


def _log_fit(
    run: LoggedRun,
    balance: ForceBalance,
    floor: float,
    left: Unmodelled,
    models: tuple[Model, Model, Model],
    instruments: bool,
    whole: bool,
) -> LogFit:
    """What one log says of the prior, of the model with what it determines, and of that with all moved."""
    prior, model, free = models
    before, after = (_relative_errors(run, one) for one in (prior, model))
    rms = balance.residual_rms(model)
    by_replay = "command" in after and not whole
    return LogFit(
        name=run.name,
        rows=int(balance.mask.sum()),
        residual_before=balance.residual_rms(prior),
        residual_after=rms,
        residual_free=balance.residual_rms(free),
        floor=floor,
        noise=left.noise if whole else None,
        command=left.command,
        explained=1.0 - (after["command"] if by_replay else rms / max(left.command, 1e-300)) ** 2,
        replay_before=before,
        replay=after,
        instruments=instruments,
    )


def _relative_errors(run: LoggedRun, model: Model) -> dict[str, float]:
    """Those of the replay; none of a model that cannot be run."""
    try:
        return run.relative_errors(model)
    except (DivergedError, ValueError):
        return {}


def _of_all(logs: Sequence[LogFit]) -> float:
    """The share of the command's power that is explained, over the rows of all logs."""
    power = [log.rows * log.command**2 for log in logs]
    left = [(1.0 - log.explained) * one for log, one in zip(logs, power, strict=True)]
    return 1.0 - sum(left) / max(sum(power), 1e-300)


def has_states(model: Model) -> bool:
    """Whether an effect with states of its own is at work, which the force balance does not see."""
    for effect in model.effects:
        if "state" in effect.HOOKS and effect.to_dict() != VOCABULARY[effect.NAME].to_dict():
            return True
    return False
