"""Where a search starts once large effects were found: they are added already, each as its refit made it."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from cogging._core import DivergedError
from cogging.diagnosis.candidates.findings import Finding
from cogging.diagnosis.candidates.movable import shape_limits
from cogging.diagnosis.discrepancy import source_of
from cogging.diagnosis.evidence.evidence import Evidence
from cogging.diagnosis.evidence.gather import gather
from cogging.diagnosis.evidence.log_p_value import log_survival
from cogging.diagnosis.evidence.null import limits_of, sources_of
from cogging.diagnosis.evidence.score_test import ScoreTest
from cogging.diagnosis.large.refit import movable, refitted
from cogging.diagnosis.large.search import Large, LargeTerm, with_own_nuisances, without_term
from cogging.diagnosis.search.confirmation import Confirmation, retuned
from cogging.diagnosis.search.gaps import Yardstick
from cogging.diagnosis.search.state import Added, State, Task
from cogging.diagnosis.search.tuning import tuned_together
from cogging.diagnosis.thresholds import LARGE
from cogging.estimation.gauss_newton import Estimate, fit
from cogging.estimation.innovations import Innovations
from cogging.model.model import Model

TIMING = {"command_delay", "lag", "state"}  # hooks of what acts by when, not where


def started(task: Task, large: Large) -> State:
    """The state of a search in which the large effects were added."""
    held = movable(large.start.model, large.allowed, large.given)
    sources = sources_of(task.logs, task.model)
    nominal = fit(large.start.model, held, sources, iterations=0)
    large = with_supported_timing(large, sources)
    estimate = fitted(large, sources)
    state = State(
        task,
        nominal,
        gather(nominal, sources),
        large.start.model,
        [source_of(log, task.model) for log in task.logs],
        False,
        estimate,
        gather(estimate, sources),
        large.model,
        Yardstick(
            task.logs, task.confirm, task.model, nominal.model, nominal.paths, large.allowed, task.replay, balance=True
        ),
        large=large,
    )
    state.added = [added(term, place, large) for place, term in enumerate(large.effects)]
    if task.confirm:
        state.confirm_evidence = elsewhere(state, large)
    return state


def with_supported_timing(large: Large, sources: Sequence[Innovations]) -> Large:
    """The large effects without those of timing that whitened residuals do not show.

    In a closed loop, noise of the reading comes back in the command: in the force balance, which knows nothing of what
    noise is, a command that acts a little later explains some of it.
    """
    for term in large.effects[1:]:
        if term.trial.candidate is None or not TIMING & set(term.trial.candidate.law.HOOKS):
            continue
        less = without_term(large, large.terms.index(term))
        try:
            gain = 2.0 * (whitened_fit(less, sources).cost - whitened_fit(large, sources).cost)
        except (DivergedError, ValueError):
            continue
        if gain < LARGE.timing_gain:
            told = (*less.refused, (term.trial.name, f"whitened residuals gain {gain:.0f} of 2 ln likelihood by it"))
            large = replace(less, refused=told)
    return large


def whitened_fit(large: Large, sources: Sequence[Innovations]) -> Estimate:
    """The fit of the whitened residuals from where that of the balance ended."""
    model = large.model
    limits = shape_limits(model, large.balances), limits_of(sources, large.allowed)
    floors, ceilings = (shape | nuisance for shape, nuisance in zip(*limits, strict=True))
    paths = movable(model, large.allowed, large.given)
    return fit(model, paths, sources, iterations=LARGE.whitened_iterations, floors=floors, ceilings=ceilings)


def fitted(large: Large, sources: Sequence[Innovations]) -> Estimate:
    """The fit of the whitened residuals from where the balance's ended; there itself, where it makes the gap larger."""
    model = large.model
    paths = movable(model, large.allowed, large.given)
    at_start = fit(model, paths, sources, iterations=0)
    try:
        found = whitened_fit(large, sources)
    except (DivergedError, ValueError):
        return at_start
    again = with_own_nuisances(large.balances.under(found.model), large.allowed)
    return found if again.rms <= LARGE.growth * large.balances.rms else at_start


def elsewhere(state: State, large: Large) -> Evidence | None:
    """The confirm logs under the present model; None where they cannot be predicted."""
    task, estimate = state.task, state.estimate
    try:
        return retuned(task.confirm, estimate.model, task.model, estimate.paths, allowed=large.allowed)
    except (DivergedError, ValueError):
        return None


def added(term: LargeTerm, place: int, large: Large) -> Added:
    """A term of the large effects as what a search adds."""
    candidate, effect = term.trial.candidate, term.trial.effect
    assert candidate is not None
    sizes = [getattr(effect, name) if at is None else getattr(effect, name)[at] for name, at in candidate.amplitudes]
    before = large.effects[place - 1].balances if place else large.start
    explained = before.residual - term.balances.residual
    freedom = max(term.trial.parameters, 1)
    trials = float(np.log(LARGE.trials))
    test = ScoreTest(term.statistic, freedom, -np.ones(1), explained, np.full(1, np.inf))
    chance = min(0.0, log_survival(term.statistic, freedom) + trials)
    score = term.statistic - 2.0 * freedom - 2.0 * trials
    finding = Finding(candidate, test, np.array(sizes or [1.0]), LARGE.trials, chance, score)
    return Added(finding, [finding], [], confirmation_of(term), term.balances.model, large=term)


def confirmation_of(term: LargeTerm) -> Confirmation | None:
    """What other motion says to a term with frozen amplitudes."""
    if term.confirm is None or term.confirm_before is None:
        return None
    gain = term.confirm.independent_rows * ((term.confirm_before / term.confirm.rms) ** 2 - 1.0)
    if term.confirm.rms > (1.0 - LARGE.shown) * term.confirm_before:
        return Confirmation(0.0, 0.0, gain)
    return Confirmation(gain, 1.0, gain)


def tuned_beside_large(state: State, fitted: Estimate, finding: Finding) -> tuple[Estimate, Model]:
    """A fit with an effect beside large ones, and its model tuned to the balance, which does not grow by it."""
    assert state.large is not None
    large, balances = state.large, state.large.balances

    def everything(model: Model) -> Model:
        return refitted(balances.under(model), large.allowed, large.given).model

    def nuisances(model: Model) -> Model:
        return with_own_nuisances(balances.under(model), large.allowed).model

    return tuned_together(
        state.tuned, fitted, finding, lambda m: balances.under(m).rms, nuisances, everything, state.evidence.sources
    )
