"""From measured logs to a fitted model: parameters with intervals, and what the logs cannot tell."""

from __future__ import annotations

import os
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np
import numpy.typing as npt

from cogging._core import AxisParameters, DivergedError
from cogging.arrays import FloatArray
from cogging.calls import takes
from cogging.estimation.gauss_newton import Estimate, fit
from cogging.estimation.innovations import Innovations
from cogging.estimation.residuals import Residuals
from cogging.identification.determinability import Determinability, determinability, size_of
from cogging.identification.force_balance import BalanceEstimate, ForceBalance, fit_force_balance
from cogging.identification.inverse_dynamics import InverseDynamics
from cogging.identification.logged_run import LoggedRun
from cogging.identification.result import Identification, LogFit, ParameterEstimate
from cogging.log_check.audit import encoder_quantum
from cogging.logs.log import Log, read_log
from cogging.logs.pauses import running_time
from cogging.logs.repeated_rows import counted_once
from cogging.model.intervals import student
from cogging.model.model import Model
from cogging.model.parameters import Parameter, Scales, parameters_of, role_of, with_values
from cogging.progress import Progress, steps
from cogging.simulation.arguments import LOGS, MODEL

FEWEST_ROWS = 200
CUTOFFS = (80.0, 40.0, 20.0, 10.0)  # Hz, of the inverse dynamics' filter: the first at which ...
READING_SHARE = 0.5  # ... quantiser and encoder noise alone make less than this share of the residual's rms
STARTS = 3  # further starts where the law is not linear in a parameter
SHAPELESS = 2.0  # 1-sigma of a shape, relative to its size, above which it is left alone altogether
SPREAD = 0.1  # of their sizes, by which they are apart
STAGES = ("inverse dynamics", "output error", "logs one by one")


@takes(logs=LOGS, model=MODEL)
def identify(
    logs: Log | str | os.PathLike[str] | Sequence[Log | str | os.PathLike[str]],
    model: Model | str | os.PathLike[str],
    *,
    free: Sequence[str] | None = None,
    cutoff: float | None = None,
    rest: float | None = None,
    added_commands: Sequence[npt.ArrayLike | None] | None = None,
    names: Sequence[str] | None = None,
    progress: Progress = False,
) -> Identification:
    """Fit the parameters of a model to one or several logs together. Rows that stand in several of them count once.

    Two estimators: inverse dynamics with instruments from a simulated run (reported, since it weighs all motion below
    the cut-off alike, and so bears a model that is not quite true), and the whitened output error of the closed-loop
    replay (where the controller is known and made the log, else the whitened one-step prediction), as a check. Where
    the model has a second mass or a state of friction, or a free parameter that the force balance does not show, the
    output error is reported.

    A parameter that the logs do not determine (1-sigma above a fifth of its size with all others free) stays at its
    prior with an infinite interval. The others are fitted with it moving within its own size: their intervals allow
    for it.

    Args:
        logs: one or several, or their files.
        model: the prior, or its file.
        free: paths of the parameters to fit (`parameters_of` lists them). None: all but settings, places of nodes,
            those that are not finite, those with an uncertainty of 0, and `axis.coulomb_width` where it is 0.
        cutoff: of the inverse dynamics' filter, Hz; None: the highest of 80, 40, 20 and 10 Hz at which encoder noise
            does not rule the residual.
        rest: rows slower than this do not count, m/s; None: 2 % of the largest speed.
        added_commands: for each log, what was added to its controller's command, V, (n,), or None.
        names: of the logs, for the text.
        progress: True shows a bar, a function is told each stage in words.

    Returns:
        The fitted model, its parameters with intervals and what the logs cannot tell; print it to read them.

    Raises:
        InputError: a file that cannot be used, a log whose units cannot be those of the model.
        ValueError: a free parameter that the model has not, no logs, a log that is too short or at rest, a cut-off or
            rest that breaks its rule.

    Example:
        >>> prior = model.replace(axis=model.axis.replace(mass=0.1))
        >>> found = cogging.identify(log, prior, free=["axis.mass", "axis.viscous"])
        >>> print(f"{found['axis.mass'].value:.3f} V/(m/s^2), determined: {found['axis.mass'].determined}")
        0.120 V/(m/s^2), determined: True
    """
    if not isinstance(model, Model):
        model = Model.read(model)
    if isinstance(logs, Log | str | os.PathLike):
        logs = [logs]
    if not logs:
        raise ValueError("logs: must be at least 1, got 0")
    called = list(names or [f"log {i + 1}" if isinstance(g, Log) else os.fspath(g) for i, g in enumerate(logs)])
    added = list(added_commands or [None] * len(logs))
    for field, entries in (("names", called), ("added_commands", added)):
        if len(entries) != len(logs):
            raise ValueError(f"{field}: must be one for each of {len(logs)} logs, got {len(entries)}")
    known = parameters_of(model)
    paths = _free_by_default(model, known) if free is None else list(dict.fromkeys(free))
    for path in paths:
        _require_free(path, model, known)
    if not paths:
        raise ValueError("free: must name at least one parameter, got none")
    read = [log if isinstance(log, Log) else read_log(log) for log in logs]
    for name, log in zip(called, read, strict=True):
        if len(log) < FEWEST_ROWS:
            raise ValueError(f"{name}: rows: must be at least {FEWEST_ROWS} to fit a model, got {len(log)}")
        if log.position.max() == log.position.min():
            raise ValueError(f"{name}: position: must move, got {log.position[0]:g} m in every row")
        try:
            running_time(log.time)
        except ValueError as error:
            raise ValueError(f"{name}: {error}") from None
    rate = 1.0 / max(float(np.median(np.diff(log.time))) for log in read)
    for name, log, entry in zip(called, read, added, strict=True):
        if entry is not None and np.shape(entry) != (len(log),):
            raise ValueError(f"added_commands: {name}: must have shape ({len(log)},), got {np.shape(entry)}")
    read, kept, notes = counted_once(read, called, FEWEST_ROWS)
    added = [e if e is None else np.asarray(e)[rows] for e, rows in zip(added, kept, strict=True) if rows.any()]
    called = [name for name, rows in zip(called, kept, strict=True) if rows.any()]
    if cutoff is not None and not 0.0 < cutoff <= 0.2 * rate:
        raise ValueError(f"cutoff: must be above 0 and at most a fifth of {rate:g} rows a second, got {cutoff:g}")
    if rest is not None and not 0.0 <= rest < np.inf:
        raise ValueError(f"rest: must be at least 0, got {rest:g}")
    runs = [LoggedRun.of(*entry) for entry in zip(read, [model] * len(read), called, added, strict=True)]
    cutoffs = [cutoff] if cutoff is not None else [c for c in CUTOFFS if c <= 0.1 * rate] or [0.1 * rate]
    notes = (*notes, *(run.repairs for run in runs if run.repairs))
    return replace(_Fit(model, runs, paths, cutoffs, rest).run(progress), notes=notes)


@dataclass(frozen=True)
class _Values:
    """Values of some parameters by one estimator: covariance (p, p) and degrees of freedom (p,)."""

    paths: tuple[str, ...]
    values: FloatArray
    covariance: FloatArray
    freedom: FloatArray

    def value(self, path: str) -> float:
        return float(self.values[self.paths.index(path)])

    def sigma(self, path: str) -> float:
        i = self.paths.index(path)
        return float(np.sqrt(self.covariance[i, i]))

    def half_width(self, path: str) -> float:
        return student(float(self.freedom[self.paths.index(path)])) * self.sigma(path)


class _Fit:
    def __init__(
        self,
        model: Model,
        runs: Sequence[LoggedRun],
        paths: Sequence[str],
        cutoffs: Sequence[float],
        rest: float | None,
    ) -> None:
        self.model, self.runs, self.paths, self.cutoffs, self.rest = model, runs, paths, cutoffs, rest
        self.prior = parameters_of(model)
        self.simulate = [run.simulator() for run in runs]

    def run(self, progress: Progress) -> Identification:
        with steps(progress, "identify", len(STAGES)) as begin:
            begin(STAGES[0])
            for cutoff in self.cutoffs:
                balances = [ForceBalance.of(run.log, cutoff=cutoff, rest=self.rest) for run in self.runs]
                for run, balance in zip(self.runs, balances, strict=True):
                    if int(balance.counts.sum()) < 4 * len(self.paths) + 50:
                        raise ValueError(
                            f"{run.name}: rows: must be at least {4 * len(self.paths) + 50} in motion, away from the "
                            f"ends and from gaps, to fit {len(self.paths)} parameters, got {int(balance.counts.sum())}"
                        )
                scales = Scales.largest(balance.scales for balance in balances)
                told = self._determine(self.model, balances, scales)
                estimate = self._balance(self.model, told, balances, scales)
                again = self._determine(estimate.model, balances, scales)
                if _classes(again) != _classes(told):  # a prior far off may hide what a law is sensitive to
                    told = again
                    estimate = self._balance(estimate.model, told, balances, scales)
                floors = [noise_floor(balance, estimate.model) for balance in balances]
                if (
                    max(f / max(rms, 1e-300) for f, rms in zip(floors, estimate.residual_rms, strict=True))
                    < READING_SHARE
                ):
                    break
            begin(STAGES[1])
            output = self._output_error(estimate.model, told)
            begin(STAGES[2])
            spread = self._one_by_one(estimate.model, told, balances, scales)
            return self._report(told, estimate, output, spread, balances, scales, floors)

    def _determine(self, model: Model, balances: Sequence[ForceBalance], scales: Scales) -> Determinability:
        return determinability(model, self.paths, balances, scales, self.simulate, lambda: self._sources(model))

    def _sources(self, model: Model) -> list[Residuals]:
        return [run.replay or Innovations(run.log, model, rest=self.rest) for run in self.runs]

    def _balance(
        self, start: Model, told: Determinability, balances: Sequence[ForceBalance], scales: Scales
    ) -> BalanceEstimate:
        """The fit of the force balance, from the best of a few starts where the law is not linear."""
        paths = self._moving(told)
        loose = np.array([np.inf if told.determined(p) else size_of(self.model, self.prior[p], scales) for p in paths])
        bent = [path for path in paths if told.determined(path) and not self._linear(path)]
        bent = [path for path in bent if path != "axis.coulomb_width"]
        starts, random = [start], np.random.default_rng(0)
        for _ in range(STARTS if bent else 0):
            moved = {
                path: parameters_of(start)[path].value
                + SPREAD * random.normal() * size_of(start, parameters_of(start)[path], scales)
                for path in bent
            }
            try:
                starts.append(with_values(start, moved))
            except ValueError:
                continue
        fits = [fit_force_balance(s, paths, balances, scales, self.simulate, loose=loose) for s in starts]
        return min(fits, key=lambda found: float(np.sum(np.log(np.maximum(found.residual_rms, 1e-300)))))

    def _moving(self, told: Determinability) -> list[str]:
        """What the fit of the force balance moves: more than it determines, so that the rest is not bent by a prior."""
        return [
            path
            for path, sigma in zip(told.paths, told.sigma, strict=True)
            if told.seen_by_balance(path) and (self._linear(path) or sigma < SHAPELESS)
        ]

    def _linear(self, path: str) -> bool:
        return role_of(self.model, path) == "amplitude"

    def _output_error(self, start: Model, told: Determinability) -> _Values | None:
        """The whitened output error of what the logs determine, from the better of two starts."""
        paths = [path for path in self.paths if told.determined(path)]
        if not paths:
            return None
        fits: list[Estimate] = []
        for model in (start, with_values(start, {path: self.prior[path].value for path in paths})):
            try:
                fits.append(fit(model, paths, self._sources(start)))
            except (DivergedError, ValueError):
                continue
        if not fits:
            return None
        best = min(fits, key=lambda found: found.cost)
        return _Values(best.paths, best.values, best.covariance, best.freedom)

    def _one_by_one(
        self, model: Model, told: Determinability, balances: Sequence[ForceBalance], scales: Scales
    ) -> dict[str, tuple[float, float]]:
        """Standard deviation of the values of logs fitted one by one, and the rms of their own, by path."""
        found: dict[str, list[tuple[float, float]]] = {}
        for balance, simulator in zip(balances, self.simulate, strict=True) if len(balances) > 1 else ():
            alone = determinability(model, self.paths, [balance], scales, [simulator])
            paths = [p for p in self.paths if told.determined(p) and told.seen_by_balance(p)]
            loose = np.array([np.inf if alone.determined(p) else size_of(model, self.prior[p], scales) for p in paths])
            single = fit_force_balance(model, paths, [balance], scales, [simulator], loose=loose, iterations=4)
            for i, path in enumerate(paths):
                if alone.determined(path):
                    sigma = float(np.sqrt(single.covariance[i, i]))
                    found.setdefault(path, []).append((float(single.values[i]), sigma))
        spread = {}
        for path, entries in found.items():
            if len(entries) > 1:
                values, sigmas = np.array(entries).T
                spread[path] = (float(np.std(values, ddof=1)), float(np.sqrt(np.mean(sigmas**2))))
        return spread

    def _report(
        self,
        told: Determinability,
        estimate: BalanceEstimate,
        output: _Values | None,
        spread: Mapping[str, tuple[float, float]],
        balances: Sequence[ForceBalance],
        scales: Scales,
        floors: Sequence[float],
    ) -> Identification:
        inside = tuple(self._moving(told))
        balance = _Values(inside, estimate.values, estimate.covariance, estimate.freedom)
        hidden = any(told.determined(path) and path not in inside for path in self.paths)
        reported = output if output is not None and (hidden or _has_states(self.model)) else balance
        entries, fitted = [], {}
        for path, note in zip(told.paths, told.notes, strict=True):
            entry = self._entry(path, note, told.determined(path), reported, balance, output, spread.get(path))
            entries.append(entry)
            if entry.determined:
                fitted[path] = entry.value
        model = with_values(self.model, fitted)
        intervals = {**self.model.intervals, **{entry.path: entry.ci95 for entry in entries}}
        covariance = np.zeros((len(entries), len(entries)))
        known = [i for i, entry in enumerate(entries) if entry.determined]
        inner = [reported.paths.index(entries[i].path) for i in known]
        covariance[np.ix_(known, known)] = reported.covariance[np.ix_(inner, inner)]
        size = np.sqrt(np.diag(covariance))
        size[size == 0.0] = 1.0
        return Identification(
            model=model.replace(intervals=intervals),
            parameters=tuple(entries),
            correlation=covariance / np.outer(size, size),
            covariance=covariance,
            determinability=told.notes,
            logs=tuple(
                self._log_fit(run, model, with_values(estimate.model, fitted), b, floor, estimate)
                for run, b, floor in zip(self.runs, balances, floors, strict=True)
            ),
            audits=tuple(run.audit for run in self.runs),
            cutoff=balances[0].dynamics.cutoff,
            estimator="inverse_dynamics" if reported is balance else "output_error",
            controller=tuple(run.line for run in self.runs if run.line),
        )

    def _entry(
        self,
        path: str,
        note: str,
        determined: bool,
        reported: _Values,
        balance: _Values,
        output: _Values | None,
        spread: tuple[float, float] | None,
    ) -> ParameterEstimate:
        prior = self.prior[path]
        value, interval = prior.value, (-np.inf, np.inf)
        inverse = balance.value(path) if determined and path in balance.paths else None
        by_output = output.value(path) if output is not None and path in output.paths else None
        difference = None
        if inverse is not None and by_output is not None and output is not None:
            sigma = float(np.hypot(balance.sigma(path), output.sigma(path)))
            difference = (by_output - inverse) / sigma if sigma > 0 else None
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
            difference=difference,
            spread=None if spread is None else spread[0],
            single_sigma=None if spread is None else spread[1],
            note=note,
        )

    def _log_fit(
        self, run: LoggedRun, model: Model, free: Model, balance: ForceBalance, floor: float, estimate: BalanceEstimate
    ) -> LogFit:
        try:
            errors = run.relative_errors(model)
        except DivergedError:
            errors = {}
        return LogFit(
            name=run.name,
            rows=int(balance.counts.sum()),
            residual_before=balance.residual_rms(self.model),
            residual_after=balance.residual_rms(model),
            residual_free=balance.residual_rms(free),
            floor=floor,
            replay=errors,
            instruments=estimate.instruments,
        )


def noise_floor(balance: ForceBalance, model: Model) -> float:
    """What the quantiser, as the readings show it, and the stated encoder noise leave in the force balance, V."""
    quantum = max(model.encoder.resolution, encoder_quantum(balance.log.position))
    random = np.random.default_rng(0)
    n = len(balance.log)
    noise = quantum * (random.random(n) - 0.5) + model.encoder.noise * random.standard_normal(n)
    log = Log(time=balance.log.time, position=noise, command=np.zeros(n))
    bare = Model(axis=AxisParameters(mass=model.axis.mass, viscous=model.axis.viscous))
    shaken = InverseDynamics(log, cutoff=balance.dynamics.cutoff).of([bare])
    return float(np.sqrt(np.mean(shaken[0, balance.counts] ** 2)))


def _free_by_default(model: Model, known: Mapping[str, Parameter]) -> list[str]:
    exact = {f"axis.{name}" for name, sigma in model.uncertainty.items() if sigma == 0.0}
    if model.axis.coulomb_width == 0.0:
        exact.add("axis.coulomb_width")
    paths = []
    for path, parameter in known.items():
        role = role_of(model, path)
        place = role == "shape" and path.endswith("]")  # where nodes stand is a choice
        if path not in exact and role != "setting" and not place and np.isfinite(parameter.value):
            paths.append(path)
    return paths


def _require_free(path: str, model: Model, known: Mapping[str, Parameter]) -> None:
    if path not in known:
        raise ValueError(f"free: {path}: must be one of {', '.join(known)}")
    if role_of(model, path) == "setting":
        raise ValueError(f"free: {path}: must be a parameter that a fit may move, got a setting")
    if not np.isfinite(known[path].value):
        raise ValueError(f"free: {path}: must start from a finite value, got {known[path].value:g}")
    if path == "axis.coulomb_width" and known[path].value == 0.0:
        raise ValueError(f"free: {path}: must start above 0 to be fitted, got 0, which is a law of its own")


def _has_states(model: Model) -> bool:
    """Whether an effect with states of its own is at work, which the force balance does not see."""
    for effect in model.effects:
        neutral = type(effect)().to_dict()
        if "state" in effect.HOOKS and effect.to_dict() != neutral:
            return True
    return False


def _classes(told: Determinability) -> tuple[tuple[bool, bool], ...]:
    return tuple((told.determined(path), told.seen_by_balance(path)) for path in told.paths)
