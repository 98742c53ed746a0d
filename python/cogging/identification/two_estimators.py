"""The two estimators of `identify`: the force balance with instruments, and the whitened output error as its check."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from cogging._core import AxisParameters, DivergedError
from cogging.arrays import FloatArray
from cogging.estimation.gauss_newton import Estimate, fit
from cogging.estimation.innovations import Innovations
from cogging.estimation.residuals import Residuals
from cogging.identification.determinability import Determinability, determinability, size_of
from cogging.identification.findings import Findings, Values, has_states, report
from cogging.identification.force_balance import BalanceEstimate, ForceBalance, fit_force_balance
from cogging.identification.inverse_dynamics import InverseDynamics
from cogging.identification.logged_run import LoggedRun
from cogging.identification.other_answers import OtherAnswer, other_answers
from cogging.identification.result import Identification
from cogging.identification.trust import TrustLimits, is_strong
from cogging.identification.unmodelled import AS_NOISE, WITH_FORCES, Unmodelled, freed, misfit
from cogging.log_check.encoder_quantum import encoder_quantum
from cogging.logs.log import Log
from cogging.model.model import Model
from cogging.model.parameters import Scales, parameters_of, role_of, with_values
from cogging.progress import Progress, steps

READING_SHARE = 0.5  # of the residual's rms, below which what quantiser and encoder noise alone make is borne
STARTS = 3  # further starts where the law is not linear in a parameter
SHAPELESS = 2.0  # 1-sigma of a shape, relative to its size, above which it is left alone altogether
SPREAD = 0.1  # of their sizes, by which they are apart
ITERATIONS, FEW_ITERATIONS = 15, 4  # of the output error; of a model that lacks much
STAGES = ("inverse dynamics", "output error", "logs one by one", "other answers")


class TwoEstimators:
    """The fit of a model's `paths` to logs: force balance, output error, and the logs one by one."""

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
        """Fit, stage by stage, and say which is begun."""
        with steps(progress, "identify", len(STAGES)) as begin:
            begin(STAGES[0])
            for cutoff in self.cutoffs:
                balances = [ForceBalance.of(run.log, cutoff=cutoff, rest=self.rest, hold=run.hold) for run in self.runs]
                self._require_rows(balances)
                scales = Scales.largest(balance.scales for balance in balances)
                told = self._determine(self.model, balances, scales)
                told, estimate = self._by_balance(told, balances, scales)
                floors = [noise_floor(balance, estimate.model) for balance in balances]
                shares = [f / max(rms, 1e-300) for f, rms in zip(floors, estimate.residual_rms, strict=True)]
                if max(shares) < READING_SHARE:
                    break
            pairs = zip(balances, self.simulate, strict=True)
            left = [Unmodelled.of(balance, estimate.model, run) for balance, run in pairs]
            begin(STAGES[1])
            output = self._output_error(estimate.model, told, left)
            begin(STAGES[2])
            spread = self._one_by_one(estimate.model, told, balances, scales)
            inside = tuple(self._moving(told))
            balance = Values(inside, estimate.values, estimate.covariance, estimate.freedom)
            begin(STAGES[3])
            others = self._other_answers(estimate, told, balances, scales, left)
            found = Findings(
                told, estimate, balance, output, spread, tuple(balances), tuple(floors), tuple(left), tuple(others)
            )
            return report(self.model, self.runs, found)

    def _other_answers(
        self,
        estimate: BalanceEstimate,
        told: Determinability,
        balances: Sequence[ForceBalance],
        scales: Scales,
        left: Sequence[Unmodelled],
    ) -> list[OtherAnswer]:
        """What the force balance would have answered otherwise, first beside further forces, then as bent by them."""
        paths = self._moving(told)
        if not paths:
            return []
        known, loose = parameters_of(estimate.model), self._loose(told, paths, scales)
        parameters = [known[path] for path in paths]
        moved, half_widths = freed(estimate.model, parameters, balances, left, scales, loose)
        beside = OtherAnswer.of(WITH_FORCES, paths, estimate.values + moved, half_widths)
        bent = misfit(estimate.model, parameters, balances, left, scales, loose)
        slow = OtherAnswer.of(AS_NOISE, paths, estimate.values, bent)
        return [beside, slow, *other_answers(estimate, paths, self.runs, balances, scales, loose, self.rest)]

    def _require_rows(self, balances: Sequence[ForceBalance]) -> None:
        needed = 4 * len(self.paths) + 50
        for run, balance in zip(self.runs, balances, strict=True):
            if int(balance.mask.sum()) < needed:
                raise ValueError(
                    f"{run.name}: rows: must be at least {needed} in motion, away from the ends and from gaps, to fit "
                    f"{len(self.paths)} parameters, got {int(balance.mask.sum())}"
                )

    def _by_balance(
        self, told: Determinability, balances: Sequence[ForceBalance], scales: Scales
    ) -> tuple[Determinability, BalanceEstimate]:
        """The fit of the force balance, once more where a prior far off hid what a law is sensitive to."""
        estimate = self._balance(self.model, told, balances, scales)
        again = self._determine(estimate.model, balances, scales)
        if _classes(again) == _classes(told):
            return told, estimate
        return again, self._balance(estimate.model, again, balances, scales)

    def _determine(self, model: Model, balances: Sequence[ForceBalance], scales: Scales) -> Determinability:
        return determinability(model, self.paths, balances, scales, self.simulate, lambda: self._sources(model))

    def _sources(self, model: Model) -> list[Residuals]:
        return [run.replay or Innovations(run.log, model, rest=self.rest) for run in self.runs]

    def _balance(
        self, start: Model, told: Determinability, balances: Sequence[ForceBalance], scales: Scales
    ) -> BalanceEstimate:
        """The fit of the force balance, from the best of a few starts where the law is not linear."""
        paths = self._moving(told)
        loose = self._loose(told, paths, scales)
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

    def _loose(self, told: Determinability, paths: Sequence[str], scales: Scales) -> FloatArray:
        """1-sigma about the start that is assumed of each parameter, (p,): its size where it is not determined."""
        return np.array([np.inf if told.determined(p) else size_of(self.model, self.prior[p], scales) for p in paths])

    def _moving(self, told: Determinability) -> list[str]:
        """What the fit of the force balance moves: more than it determines, so that the rest is not bent by a prior."""
        return [
            path
            for path, sigma in zip(told.paths, told.sigma, strict=True)
            if told.seen_by_balance(path) and (self._linear(path) or sigma < SHAPELESS)
        ]

    def _linear(self, path: str) -> bool:
        return role_of(self.model, path) == "amplitude"

    def _output_error(self, start: Model, told: Determinability, left: Sequence[Unmodelled]) -> Values | None:
        """The whitened output error of what the logs determine, from the better of two starts.

        A few iterations from the first where it is but a check, of a model that lacks much: no start would end sooner.
        """
        paths = [path for path in self.paths if told.determined(path)]
        if not paths:
            return None
        fits: list[Estimate] = []
        starts = [start, with_values(start, {path: self.prior[path].value for path in paths})]
        check = not has_states(self.model) and all(told.seen_by_balance(path) for path in paths)
        if check and any(is_strong(one, TrustLimits()) for one in left):
            starts, iterations = starts[:1], FEW_ITERATIONS
        else:
            iterations = ITERATIONS
        for model in starts:
            try:
                fits.append(fit(model, paths, self._sources(start), iterations=iterations))
            except (DivergedError, ValueError):
                continue
        if not fits:
            return None
        best = min(fits, key=lambda found: found.cost)
        return Values(best.paths, best.values, best.covariance, best.freedom)

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


def noise_floor(balance: ForceBalance, model: Model) -> float:
    """What the quantiser, as the readings show it, and the stated encoder noise leave in the force balance, V."""
    quantum = max(model.encoder.resolution, encoder_quantum(balance.log.position))
    random = np.random.default_rng(0)
    n = len(balance.log)
    noise = quantum * (random.random(n) - 0.5) + model.encoder.noise * random.standard_normal(n)
    log = Log(time=balance.log.time, position=noise, command=np.zeros(n))
    bare = Model(axis=AxisParameters(mass=model.axis.mass, viscous=model.axis.viscous))
    shaken = InverseDynamics(log, cutoff=balance.dynamics.cutoff).of([bare])
    return float(np.sqrt(np.mean(shaken[0, balance.mask] ** 2)))


def _classes(told: Determinability) -> tuple[tuple[bool, bool], ...]:
    return tuple((told.determined(path), told.seen_by_balance(path)) for path in told.paths)
