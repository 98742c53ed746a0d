"""What the estimators found in the logs, and the result made of it."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from cogging._core import DivergedError
from cogging.arrays import FloatArray
from cogging.effects.effect import VOCABULARY
from cogging.estimation.statistics import student
from cogging.identification.determinability import Determinability
from cogging.identification.force_balance import BalanceEstimate, ForceBalance
from cogging.identification.logged_run import LoggedRun
from cogging.identification.result import Identification, LogFit, ParameterEstimate
from cogging.model.model import Model
from cogging.model.parameters import Parameter, parameters_of, with_values


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
    """

    told: Determinability
    estimate: BalanceEstimate
    balance: Values
    output: Values | None
    spread: Mapping[str, tuple[float, float]]
    balances: tuple[ForceBalance, ...]
    floors: tuple[float, ...]


def report(prior: Model, runs: Sequence[LoggedRun], found: Findings) -> Identification:
    """The result: the output error's values where the force balance does not see all, else the balance's."""
    told = found.told
    reported = _reported(prior, found)
    known = parameters_of(prior)
    entries = [_entry(known[path], note, reported, found) for path, note in zip(told.paths, told.notes, strict=True)]
    fitted = {entry.path: entry.value for entry in entries if entry.determined}
    model = with_values(prior, fitted)
    models = (prior, model, with_values(found.estimate.model, fitted))
    intervals = {**model.intervals, **{entry.path: entry.ci95 for entry in entries}}
    covariance = _covariance(entries, reported)
    size = np.sqrt(np.diag(covariance))
    size[size == 0.0] = 1.0
    return Identification(
        model=model.replace(intervals=intervals),
        parameters=tuple(entries),
        correlation=covariance / np.outer(size, size),
        covariance=covariance,
        determinability=told.notes,
        logs=tuple(
            _log_fit(run, models, balance, floor, found.estimate.instruments)
            for run, balance, floor in zip(runs, found.balances, found.floors, strict=True)
        ),
        audits=tuple(run.audit for run in runs),
        cutoff=found.balances[0].dynamics.cutoff,
        estimator="inverse_dynamics" if reported is found.balance else "output_error",
        controller=tuple(run.line for run in runs if run.line),
    )


def _reported(prior: Model, found: Findings) -> Values:
    """Whose values count."""
    told, inside = found.told, found.balance.paths
    hidden = any(told.determined(path) and path not in inside for path in told.paths)
    return found.output if found.output is not None and (hidden or _has_states(prior)) else found.balance


def _covariance(entries: Sequence[ParameterEstimate], reported: Values) -> FloatArray:
    """Of what is determined, 0 elsewhere, (p, p)."""
    covariance = np.zeros((len(entries), len(entries)))
    known = [i for i, entry in enumerate(entries) if entry.determined]
    inner = [reported.paths.index(entries[i].path) for i in known]
    covariance[np.ix_(known, known)] = reported.covariance[np.ix_(inner, inner)]
    return covariance


def _entry(prior: Parameter, note: str, reported: Values, found: Findings) -> ParameterEstimate:
    path, balance, output = prior.path, found.balance, found.output
    spread, determined = found.spread.get(path), found.told.determined(path)
    value, interval = prior.value, (-np.inf, np.inf)
    inverse = balance.value(path) if determined and path in balance.paths else None
    by_output = output.value(path) if output is not None and path in output.paths else None
    determined = determined and path in reported.paths and bool(np.isfinite(reported.sigma(path)))
    if determined:
        value, half = reported.value(path), reported.half_width(path)
        interval = (max(value - half, 0.0) if prior.positive else value - half, value + half)
    return ParameterEstimate(
        path=path,
        unit=prior.unit,
        prior=prior.value,
        value=value,
        ci95=interval,
        determined=determined,
        inverse_dynamics=inverse,
        output_error=by_output,
        difference=_difference(path, balance, output),
        spread=None if spread is None else spread[0],
        single_sigma=None if spread is None else spread[1],
        note=note,
    )


def _difference(path: str, balance: Values, output: Values | None) -> float | None:
    """The output error's value less the balance's, in units of its standard deviation were they independent."""
    if output is None or path not in output.paths or path not in balance.paths:
        return None
    sigma = float(np.hypot(balance.sigma(path), output.sigma(path)))
    return (output.value(path) - balance.value(path)) / sigma if sigma > 0 else None


def _log_fit(
    run: LoggedRun, models: tuple[Model, Model, Model], balance: ForceBalance, floor: float, instruments: bool
) -> LogFit:
    """What one log says of the prior, of the model with what it determines, and of that with all moved."""
    prior, model, free = models
    try:
        errors = run.relative_errors(model)
    except DivergedError:
        errors = {}
    return LogFit(
        name=run.name,
        rows=int(balance.mask.sum()),
        residual_before=balance.residual_rms(prior),
        residual_after=balance.residual_rms(model),
        residual_free=balance.residual_rms(free),
        floor=floor,
        replay=errors,
        instruments=instruments,
    )


def _has_states(model: Model) -> bool:
    """Whether an effect with states of its own is at work, which the force balance does not see."""
    for effect in model.effects:
        if "state" in effect.HOOKS and effect.to_dict() != VOCABULARY[effect.NAME].to_dict():
            return True
    return False
