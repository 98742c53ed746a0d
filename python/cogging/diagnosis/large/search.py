"""Large effects first: seeds of the force balance, each refitted before the next is looked for."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from cogging.diagnosis.candidates.signatures import Candidate
from cogging.diagnosis.evidence.allowance import LEVELS, Allowance
from cogging.diagnosis.large.balance import Balances
from cogging.diagnosis.large.levels import Levels, levels_of
from cogging.diagnosis.large.refit import refitted
from cogging.diagnosis.large.seeds import Seed, seeds
from cogging.diagnosis.thresholds import LARGE
from cogging.effects.effect import Effect
from cogging.model.model import Model
from cogging.model.parameters import parameters_of, with_values


@dataclass(frozen=True)
class LargeTerm:
    """A term that was added.

    Attributes:
        name: name of the effect, or of the change of a level.
        candidate: effect and shape as they were tried; None for a change of a level.
        path: path of the level that is no more held; None for an effect.
        parameters: how many numbers it has.
        left: ln of the power that it left, here and on other motion, less that before (see total_worth).
        alternatives: names that left about as little.
        before, confirm_before: rms of the balance without it, V.
        balances: logs under the model with it.
        confirm: confirm logs under it, levels re-tuned; None without.
    """

    name: str
    candidate: Candidate | None
    path: str | None
    parameters: int
    left: float
    alternatives: tuple[str, ...]
    before: float
    confirm_before: float | None
    balances: Balances
    confirm: Balances | None

    @property
    def statistic(self) -> float:
        """T: the power that it takes over the power that is left, times the rows that know nothing of each other."""
        return self.balances.independent_rows * ((self.before / self.balances.rms) ** 2 - 1.0)


@dataclass(frozen=True)
class Large:
    """Where the search for large effects stands, and what it found.

    Attributes:
        given: effects that the model had from the start.
        start: logs under the model as it was given, levels re-tuned as far as they are allowed to.
        confirm_start: confirm logs under it, levels re-tuned likewise; None without.
        balances, confirm: the same under the last model.
        allowed: how far levels may go that nothing was found about.
        terms: what was added, in its order.
        refused: what was not, each name with the reason.
    """

    given: int
    start: Balances
    confirm_start: Balances | None
    balances: Balances
    confirm: Balances | None
    allowed: Allowance
    terms: tuple[LargeTerm, ...] = ()
    refused: tuple[tuple[str, str], ...] = ()

    @property
    def model(self) -> Model:
        """With all that was added."""
        return self.balances.model


@dataclass(frozen=True)
class Trial:
    """A term that is tried: an effect, or the change of a level."""

    name: str
    effect: Effect | None
    candidate: Candidate | None
    path: str | None
    parameters: int
    left: float

    def worth(self, before: float) -> float:
        """ln of the power that it leaves of that before, less what its parameters must be worth."""
        return float(np.log(self.left / before)) + LARGE.parameter * self.parameters


def search_large(
    balances: Balances,
    confirm: Balances | None,
    allowed: Allowance,
    vocabulary: Mapping[str, Effect],
    progress: Callable[[str], None],
    *,
    any_size: bool = False,
) -> Large | None:
    """Add the largest missing effect, refit, and look again, until what is left is no more large.

    None where it is not large to begin with; or, of `any_size`, where nothing is found.

    Args:
        balances: logs under the given model.
        confirm: logs of other motion under it; None without.
        allowed: how far its levels may go.
        vocabulary: effects that are tried, by name.
        progress: function that is called with what is being done.
    """
    given = len(balances.model.effects)
    start = refitted(balances, allowed, given)
    confirm_start = None if confirm is None else with_levels_of_its_own(confirm.under(start.model), allowed)
    state = Large(given, start, confirm_start, start, confirm_start, allowed)
    if not (any_size or is_large(state)):
        return None
    while len(state.terms) < LARGE.terms and (is_large(state) or (any_size and not state.terms)):
        progress(f"large effects, {len(state.terms) + 1}")
        following = add_one(state, vocabulary)
        if following is None:
            break
        state = following
    return None if any_size and not state.terms else without_what_is_not_needed(state)


def is_large(state: Large) -> bool:
    """Whether what is left is large, or was and is not yet noise."""
    share = LARGE.large if not state.terms else LARGE.rest
    return state.balances.rms > max(share * state.balances.command, LARGE.above_noise * state.balances.noise)


def add_one(state: Large, vocabulary: Mapping[str, Effect]) -> Large | None:
    """The state with the term that leaves least, of those that are refitted; None where none is worth it."""
    levels = levels_of(state.balances, state.allowed)
    before = levels.alone()[1]
    found = [*effects_to_try(state, levels, vocabulary), *changes_to_try(state)]
    trials = sorted(found, key=lambda one: one.worth(before))
    worthwhile = [one for one in trials if one.worth(before) < float(np.log(1.0 - LARGE.worth))]
    if not worthwhile:
        return None
    best = worthwhile[0].worth(before)
    close = [one for one in worthwhile if one.worth(before) < LARGE.near * best][: LARGE.rivals]
    tried = [(one, *with_trial(state, one)) for one in close]
    ranked = sorted(tried, key=lambda one: total_worth(state, *one))
    refused = list(state.refused)
    for trial, after, confirm, allowed in ranked:
        reason = objection(state, after, confirm)
        if reason is not None:
            refused.append((trial.name, reason))
            continue
        term = term_of(state, trial, after, confirm, [one for one in ranked if one[0].name != trial.name])
        return replace(
            state,
            balances=after,
            confirm=confirm,
            allowed=allowed,
            terms=(*state.terms, term),
            refused=tuple(refused),
        )
    return None


def term_of(
    state: Large, trial: Trial, after: Balances, confirm: Balances | None, others: Sequence[tuple[Trial, Any, Any, Any]]
) -> LargeTerm:
    """The term that a trial becomes, with what else leaves about as little."""
    left = total_worth(state, trial, after, confirm, state.allowed)
    alike = tuple(other[0].name for other in others if total_worth(state, *other) < left + LARGE.alternative)
    return LargeTerm(
        trial.name,
        trial.candidate,
        trial.path,
        trial.parameters,
        left,
        alike,
        state.balances.rms,
        None if state.confirm is None else state.confirm.rms,
        after,
        confirm,
    )


def effects_to_try(state: Large, levels: Levels, vocabulary: Mapping[str, Effect]) -> list[Trial]:
    """The best term of each effect."""
    return [_trial(seed) for seed in seeds(state.balances, levels, vocabulary)]


def _trial(seed: Seed) -> Trial:
    roles = seed.candidate.law.ROLES
    shapes = [
        field
        for field, value in seed.candidate.shape.items()
        if roles[field]["role"] == "shape" and isinstance(value, float)
    ]
    return Trial(seed.name, seed.effect(), seed.candidate, None, len(shapes) + len(seed.amplitudes), seed.left)


def changes_to_try(state: Large) -> list[Trial]:
    """Mass and friction that are held by what the model states, each let go."""
    found = []
    for name in LEVELS:
        path = f"axis.{name}"
        value = float(getattr(state.balances.model.axis, name))
        if path in state.allowed.exact or state.allowed.at_end(path, value):
            left = levels_of(state.balances, state.allowed.without((path,))).alone()[1]
            found.append(Trial(f"{name}_change", None, None, path, 1, left))
    return found


def with_trial(state: Large, trial: Trial) -> tuple[Balances, Balances | None, Allowance]:
    """Logs, confirm logs and allowance under the model refitted with a term."""
    allowed = state.allowed if trial.path is None else state.allowed.without((trial.path,))
    model = state.model
    if trial.effect is not None:
        model = model.replace(effects=(*model.effects, trial.effect))
    after = refitted(state.balances.under(model), allowed, state.given)
    confirm = None if state.confirm is None else with_levels_of_its_own(state.confirm.under(after.model), allowed)
    return after, confirm, allowed


def total_worth(state: Large, trial: Trial, after: Balances, confirm: Balances | None, allowed: Allowance) -> float:
    """ln of the power left here and on other motion, less that before; plus what its parameters must be worth."""
    worth = 2.0 * float(np.log(after.rms / state.balances.rms)) + LARGE.parameter * trial.parameters
    if confirm is not None and state.confirm is not None:
        worth += 2.0 * float(np.log(confirm.rms / state.confirm.rms))
    return worth


def objection(state: Large, after: Balances, confirm: Balances | None) -> str | None:
    """Why a term is refused; None where nothing speaks against it."""
    if 2.0 * float(np.log(after.rms / state.balances.rms)) > float(np.log(1.0 - LARGE.worth)):
        return f"refitted, it leaves {after.rms:.3g} of {state.balances.rms:.3g} V"
    if confirm is not None and state.confirm is not None and confirm.rms > LARGE.growth * state.confirm.rms:
        return f"the gap on the other motion grows from {state.confirm.rms:.4g} to {confirm.rms:.4g} V with it"
    return None


def with_levels_of_its_own(balances: Balances, allowed: Allowance) -> Balances:
    """The balances with levels re-tuned on these logs, effects as they are."""
    levels = levels_of(balances, allowed, effects=False)
    steps, _ = levels.alone()
    known = parameters_of(balances.model, together=True)
    values = {
        path: float(
            np.clip(known[path].value + step, allowed.floors.get(path, -np.inf), allowed.ceilings.get(path, np.inf))
        )
        for path, step in zip(levels.paths, steps, strict=True)
    }
    return balances.under(with_values(balances.model, values))


def without_what_is_not_needed(state: Large) -> Large:
    """The state without terms that a later one made superfluous."""
    for place in reversed(range(len(state.terms) - 1)):
        term = state.terms[place]
        if term.candidate is None:
            continue
        effects = list(state.model.effects)
        del effects[state.given + sum(one.candidate is not None for one in state.terms[:place])]
        less = refitted(state.balances.under(state.model.replace(effects=tuple(effects))), state.allowed, state.given)
        if 2.0 * float(np.log(less.rms / state.balances.rms)) < LARGE.parameter * term.parameters:
            confirm = (
                None
                if state.confirm is None
                else with_levels_of_its_own(state.confirm.under(less.model), state.allowed)
            )
            terms = (*state.terms[:place], *state.terms[place + 1 :])
            told = (*state.refused, (term.name, "what was added after it explains it"))
            state = replace(state, balances=less, confirm=confirm, terms=terms, refused=told)
    return state
