"""The fit behind `identify`: the force balance with instruments, and the whitened output error as its check."""

from __future__ import annotations

import contextlib
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import partial

import numpy as np

from cogging._core import AxisParameters, DivergedError
from cogging.arrays import FloatArray
from cogging.effects.effect import VOCABULARY
from cogging.estimation.force_balance import BalanceEstimate, ForceBalance, fit_force_balance
from cogging.estimation.gauss_newton import Estimate, fit
from cogging.estimation.innovations import Innovations
from cogging.estimation.residuals import Residuals
from cogging.estimation.statistics import student
from cogging.identification.determinability import UNDETERMINED, Determinability, determinability, size_of
from cogging.identification.identification_result import CHECK, Identification, LogFit, ParameterEstimate, warnings_of
from cogging.identification.logged_run import LoggedRun
from cogging.identification.unmodelled import AS_NOISE, WITH_FORCES, Unmodelled, other_answers
from cogging.log_check.encoder_readings import encoder_quantum
from cogging.logs.log import Log
from cogging.model.intervals import SIGMAS_95
from cogging.model.model import Model
from cogging.model.parameters import Parameter, Scales, parameters_of, role_of, with_values
from cogging.progress import Progress, steps

READING_SHARE = 0.5  # of the residual's rms: the largest share of quantiser and encoder noise at an accepted cut-off
STARTS, SPREAD = 3, 0.1  # further starts where the law is nonlinear in a parameter, and their spread in its size
SHAPELESS = 2.0  # relative 1-sigma above which a shape parameter is held
ITERATIONS, FEW_ITERATIONS = 15, 4  # of the output error; of a model that lacks much
LEAST_CUTOFF = 4.0  # Hz
FURTHER = 2.0  # factor on the cut-off, and thinning of the rows, for other answers
OTHER_ITERATIONS = 8
MOVED = 3.0  # an answer counts as other from this many times the larger half interval
STAGES = ("inverse dynamics", "output error", "logs one by one", "other answers")

Answer = dict[str, tuple[float, float, float]]  # by path: value, standard deviation, half of the 95 % interval


def answer_of(paths: Sequence[str], values: FloatArray, covariance: FloatArray, freedom: FloatArray) -> Answer:
    """Value, standard deviation and half of the 95 % interval by path."""
    rows = zip(paths, values, np.sqrt(np.maximum(np.diag(covariance), 0.0)), freedom, strict=True)
    return {path: (float(v), float(s), float(s * student(float(f)))) for path, v, s, f in rows}


@dataclass
class ParameterFit:
    """Fit the parameters `paths` of a model to logs; of the `cutoffs` (Hz) the first with small noise is used."""

    model: Model
    runs: Sequence[LoggedRun]
    paths: Sequence[str]
    cutoffs: Sequence[float]
    rest: float | None  # m/s, below which rows do not count

    def __post_init__(self) -> None:
        self.prior = parameters_of(self.model)

    def run(self, progress: Progress) -> Identification:
        """Fit stage by stage and report each stage."""
        with steps(progress, "identify", len(STAGES)) as begin:
            begin(STAGES[0])
            for cutoff in self.cutoffs:
                self.balances = [run.balance(cutoff, self.rest) for run in self.runs]
                needed = 4 * len(self.paths) + 50
                for r, balance in zip(self.runs, self.balances, strict=True):
                    if (count := int(balance.mask.sum())) < needed:
                        rule = f"must be at least {needed} in motion, away from the ends and from gaps"
                        raise ValueError(f"{r.name}: rows: {rule}, to fit {len(self.paths)} parameters, got {count}")
                self.scales = Scales.largest(balance.scales for balance in self.balances)
                self.seen = self._determine(self.model)
                self.estimate = self._fit_balance(self.model)
                again = self._determine(self.estimate.model)
                if again.classes != self.seen.classes:  # a prior far off hid a sensitivity
                    self.seen = again
                    self.estimate = self._fit_balance(self.estimate.model)
                self.floors = [noise_floor(balance, self.estimate.model) for balance in self.balances]
                left = zip(self.floors, self.estimate.residual_rms, strict=True)
                if max(floor / max(rms, 1e-300) for floor, rms in left) < READING_SHARE:
                    break
            model = self.estimate.model
            self.left = [Unmodelled.of(balance, model) for balance in self.balances]
            begin(STAGES[1])
            self.output = self._fit_output(model)
            begin(STAGES[2])
            self.spread = self._one_by_one(model)
            begin(STAGES[3])
            self.others = self._other_answers()
            return self._result()

    # The estimators ---------------------------------------------------------------------------------------------------

    def _determine(self, model: Model) -> Determinability:
        return determinability(model, self.paths, self.balances, self.scales, partial(self._sources, model))

    def _sources(self, model: Model) -> list[Residuals]:
        return [run.replay or Innovations(run.log, model, rest=self.rest) for run in self.runs]

    @property
    def moving(self) -> list[str]:
        """The parameters that the force balance moves: more than it determines, so that priors do not bias the rest."""
        sigmas = {path: sigma for path, sigma in self.seen.sigma.items() if self.seen.in_balance[path]}
        return [p for p, sigma in sigmas.items() if role_of(self.model, p) == "amplitude" or sigma < SHAPELESS]

    def _loose(self, paths: Sequence[str], seen: Determinability, model: Model) -> FloatArray:
        """1-sigma of the prior about the start, (p,): the size of a parameter that is not determined, else infinite."""
        sizes = {path: size_of(model, self.prior[path], self.scales) for path in paths}
        return np.array([np.inf if seen.determined(path) else size for path, size in sizes.items()])

    def _fit_balance(self, start: Model) -> BalanceEstimate:
        """Fit the force balance, from the best of several starts where the law is nonlinear."""
        paths, known = self.moving, parameters_of(start)
        loose = self._loose(paths, self.seen, self.model)
        nonlinear = [path for path in paths if self.seen.determined(path) and path != "axis.coulomb_width"]
        nonlinear = [path for path in nonlinear if role_of(self.model, path) != "amplitude"]
        starts, random = [start], np.random.default_rng(0)
        for _ in range(STARTS if nonlinear else 0):
            sizes = {path: size_of(start, known[path], self.scales) for path in nonlinear}
            moved = {path: known[path].value + SPREAD * random.normal() * sizes[path] for path in nonlinear}
            with contextlib.suppress(ValueError):
                starts.append(with_values(start, moved))
        fits = [fit_force_balance(start, paths, self.balances, self.scales, loose) for start in starts]
        return min(fits, key=lambda found: float(np.sum(np.log(np.maximum(found.residual_rms, 1e-300)))))

    def _fit_output(self, start: Model) -> Estimate | None:
        """Fit the whitened output error of the determined parameters from two starts; as a check, briefly from one."""
        paths = [path for path in self.paths if self.seen.determined(path)]
        if not paths:
            return None
        starts = [start, with_values(start, {path: self.prior[path].value for path in paths})]
        iterations = ITERATIONS
        is_check = not has_states(self.model) and all(self.seen.in_balance[path] for path in paths)
        if is_check and any(left.is_strong for left in self.left):
            starts, iterations = starts[:1], FEW_ITERATIONS
        fits: list[Estimate] = []
        for model in starts:
            with contextlib.suppress(DivergedError, ValueError):
                fits.append(fit(model, paths, self._sources(start), iterations=iterations))
        return min(fits, key=lambda found: found.cost, default=None)

    def _one_by_one(self, model: Model) -> dict[str, tuple[float, float]]:
        """Standard deviation of the values of logs fitted one by one, and the rms of their own, by path."""
        found: dict[str, list[tuple[float, float]]] = {}
        paths = [path for path in self.paths if self.seen.determined(path) and self.seen.in_balance[path]]
        for balance in self.balances if len(self.balances) > 1 else ():
            alone = determinability(model, self.paths, [balance], self.scales)
            loose = self._loose(paths, alone, model)
            single = fit_force_balance(model, paths, [balance], self.scales, loose, steps=4)
            for path, value, variance in zip(paths, single.values, np.diag(single.covariance), strict=True):
                if alone.determined(path):
                    found.setdefault(path, []).append((float(value), float(np.sqrt(variance))))
        spread = {}
        for path, entries in found.items():
            if len(entries) > 1:
                values, sigmas = np.array(entries).T
                spread[path] = (float(np.std(values, ddof=1)), float(np.sqrt(np.mean(sigmas**2))))
        return spread

    def _other_answers(self) -> dict[str, Answer]:
        """Answers by the way: beside unmodelled forces, biased by them, at other cut-offs, with half the rows."""
        paths = self.moving
        if not paths:
            return {}
        model, values, loose = self.estimate.model, self.estimate.values, self._loose(paths, self.seen, self.model)
        known, found = parameters_of(model), dict[str, Answer]()
        parameters = [known[path] for path in paths]
        moved, halves, bent = other_answers(model, parameters, self.left, self.scales, loose)

        def add(way: str, values: FloatArray, halves: Sequence[float] | FloatArray) -> None:
            rows = [(path, float(v), float(h)) for path, v, h in zip(paths, values, halves, strict=True)]
            found[way] = {path: (v, np.nan, h) for path, v, h in rows if np.isfinite([v, h]).all()}

        def refit(way: str, others: Sequence[ForceBalance]) -> None:
            if any(int(balance.mask.sum()) < 4 * len(paths) + 50 for balance in others):
                return
            again = fit_force_balance(model, paths, others, self.scales, loose, OTHER_ITERATIONS)
            answer = answer_of(paths, again.values, again.covariance, again.freedom)
            add(way, again.values, [half for _, _, half in answer.values()])

        add(WITH_FORCES, values + moved, halves)
        add(AS_NOISE, values, bent)
        cutoff = self.balances[0].cutoff
        step = max(balance.sample_time for balance in self.balances)
        pairs = list(zip(self.runs, self.balances, strict=True))
        for other in (FURTHER * cutoff, cutoff / FURTHER):
            if LEAST_CUTOFF <= other <= 0.2 / step:
                refit(f"below {other:g} Hz", [run.balance(other, own.rest) for run, own in pairs])
        if cutoff <= 0.2 / (FURTHER * step):
            refit("with every second row", [run.balance(cutoff, own.rest, every_second=True) for run, own in pairs])
        return found

    # The result -------------------------------------------------------------------------------------------------------

    def _result(self) -> Identification:
        """Report the output error's values where the force balance does not see all parameters, else the balance's."""
        seen, prior, estimate, output = self.seen, self.model, self.estimate, self.output
        inside = self.moving
        self.by_balance = answer_of(inside, estimate.values, estimate.covariance, estimate.freedom)
        self.by_output = answer_of(output.paths, output.values, output.covariance, output.freedom) if output else {}
        is_whole = not has_states(prior)  # whether the balance contains the whole model
        hidden = any(seen.determined(path) and path not in inside for path in seen.sigma)
        if output is not None and (hidden or not is_whole):
            name, reported, full, order = "output_error", self.by_output, output.covariance, list(output.paths)
        else:
            name, reported, full, order = "inverse_dynamics", self.by_balance, estimate.covariance, inside
        strong = is_whole and any(left.is_strong for left in self.left)
        missing = is_whole and any(left.is_missing for left in self.left)
        entries = [self._entry(self.prior[p], note, reported, strong, missing) for p, note in seen.notes.items()]
        fitted = {entry.path: entry.value for entry in entries if entry.determined and entry.value != entry.prior}
        model = with_values(prior, fitted)
        models = {"prior": prior, "model": model, "free": with_values(estimate.model, fitted)}
        logs = [self._log_fit(k, models, is_whole) for k in range(len(self.runs))]
        # Covariance of the determined parameters, as much wider as their intervals are.
        known = [i for i, entry in enumerate(entries) if entry.determined]
        covariance, rows = np.zeros((len(entries), len(entries))), [order.index(entries[i].path) for i in known]
        halves = np.array([0.5 * (entries[i].ci95[1] - entries[i].ci95[0]) for i in known])
        usual = np.array([max(reported[entries[i].path][2], 1e-300) for i in known])
        wider = np.maximum(halves / usual, 1.0)
        covariance[np.ix_(known, known)] = full[np.ix_(rows, rows)] * np.outer(wider, wider)
        size = np.sqrt(np.diag(covariance))
        size[size == 0.0] = 1.0
        power = [log.rows * log.command**2 for log in logs]
        unexplained = sum((1.0 - log.explained) * one for log, one in zip(logs, power, strict=True))
        held = [e.path for e in entries if strong and seen.determined(e.path) and e.value == e.prior]
        sparse = [run.sparse for run in self.runs if run.sparse]
        return Identification(
            model=model.replace(intervals={**model.intervals, **{entry.path: entry.ci95 for entry in entries}}),
            parameters=tuple(entries),
            correlation=covariance / np.outer(size, size),
            covariance=covariance,
            determinability=tuple(entry.note for entry in entries),
            logs=tuple(logs),
            audits=tuple(run.audit for run in self.runs),
            cutoff=self.balances[0].cutoff,
            estimator=name,
            controller=tuple(run.line for run in self.runs if run.line),
            explained=1.0 - unexplained / max(sum(power), 1e-300),
            warnings=(*sparse, *warnings_of(logs, entries, held, prior.units.command)),
        )

    def _entry(self, prior: Parameter, note: str, reported: Answer, strong: bool, missing: bool) -> ParameterEstimate:
        """One parameter of the result; `strong`, `missing`: see Unmodelled."""
        path, balance, output = prior.path, self.by_balance, self.by_output
        spread, seen, difference = self.spread.get(path, (None, None)), self.seen.determined(path), None
        if path in balance and path in output:
            (one, one_sigma, _), (other, other_sigma, _) = balance[path], output[path]
            sigma = float(np.hypot(one_sigma, other_sigma))
            difference = (other - one) / sigma if sigma > 0 else None
        doubted = strong or abs(difference or 0.0) > CHECK
        determined = seen and path in reported and bool(np.isfinite(reported[path][1]))
        value, interval, elsewhere = prior.value, (-np.inf, np.inf), dict[str, float]()
        if determined:
            settled, _, half = reported[path]
            wide = (settled - half, settled + half)
            if doubted:
                settled, wide = self._doubted_interval(prior)
                sigma = 0.5 * (wide[1] - wide[0]) / SIGMAS_95
                determined = sigma <= UNDETERMINED * size_of(self.estimate.model, prior, self.scales)
            if determined:
                left_out = (AS_NOISE,) if missing else (AS_NOISE, WITH_FORCES)
                half = 0.5 * (wide[1] - wide[0])
                others = {way: a[path] for way, a in self.others.items() if way not in left_out and path in a}
                elsewhere = {way: a[0] for way, a in others.items() if abs(a[0] - settled) > MOVED * max(half, a[2])}
                value, interval = settled, (max(wide[0], 0.0) if prior.positive else wide[0], wide[1])
            if doubted:
                known = "not determined" if not determined else "as given" if value == prior.value else "moved"
                span = f"[{wide[0]:.4g}, {wide[1]:.4g}]"
                note = f"{note.split(':')[0]}: {known}, unmodelled forces leave it open over {span}"
        return ParameterEstimate(
            path=path,
            unit=prior.unit,
            prior=prior.value,
            value=value,
            ci95=interval,
            determined=determined,
            inverse_dynamics=balance[path][0] if seen and path in balance else None,
            output_error=output[path][0] if path in output else None,
            difference=difference,
            spread=spread[0],
            single_sigma=spread[1],
            note=note,
            elsewhere=elsewhere,
        )

    def _doubted_interval(self, prior: Parameter) -> tuple[float, tuple[float, float]]:
        """Value and 95 % interval that cover both estimators and the answers beside and with unmodelled forces."""
        path = prior.path
        others = [other[path] for other in list(self.others.values())[:2] if path in other]
        if not others:
            return prior.value, (-np.inf, np.inf)
        values, _, halves = np.array([one[path] for one in (self.by_balance, self.by_output) if path in one] + others).T
        low, high = float(np.min(values - halves)), float(np.max(values + halves))
        stated = SIGMAS_95 * self.model.uncertainty.get(path.removeprefix("axis."), 0.0) * abs(prior.value)
        value = prior.value if low - stated <= prior.value <= high + stated else others[0][0]
        reach = max(value - low, high - value)
        return value, (value - reach, value + reach)

    def _log_fit(self, k: int, models: Mapping[str, Model], is_whole: bool) -> LogFit:
        """How well the prior, the model with what is determined, and that with all moved fit log `k`."""
        run, balance, left = self.runs[k], self.balances[k], self.left[k]

        def replay_errors(model: Model) -> dict[str, float]:
            try:
                return run.relative_errors(model)
            except (DivergedError, ValueError):
                return {}

        before, after = replay_errors(models["prior"]), replay_errors(models["model"])
        rms = {name: balance.residual_rms(model) for name, model in models.items()}
        by_replay = "command" in after and not is_whole
        return LogFit(
            name=run.name,
            rows=int(balance.mask.sum()),
            residual_before=rms["prior"],
            residual_after=rms["model"],
            residual_free=rms["free"],
            floor=self.floors[k],
            noise=left.noise if is_whole else None,
            command=left.command,
            explained=1.0 - (after["command"] if by_replay else rms["model"] / max(left.command, 1e-300)) ** 2,
            replay_before=before,
            replay=after,
            instruments=self.estimate.instruments,
        )


def has_states(model: Model) -> bool:
    """Whether the model has an active effect with states of its own, which the force balance does not contain."""
    stateful = [effect for effect in model.effects if "state" in effect.HOOKS]
    return any(effect.to_dict() != VOCABULARY[effect.NAME].to_dict() for effect in stateful)


def noise_floor(balance: ForceBalance, model: Model) -> float:
    """Rms that quantiser and stated encoder noise alone leave in the force balance, V."""
    quantum = max(model.encoder.resolution, encoder_quantum(balance.log.position))
    random = np.random.default_rng(0)
    n = len(balance.log)
    noise = quantum * (random.random(n) - 0.5) + model.encoder.noise * random.standard_normal(n)
    log = Log(time=balance.log.time, position=noise, command=np.zeros(n))
    bare = Model(axis=AxisParameters(mass=model.axis.mass, viscous=model.axis.viscous))
    residual = ForceBalance(log, cutoff=balance.cutoff).of([bare])
    return float(np.sqrt(np.mean(residual[0, balance.mask] ** 2)))
