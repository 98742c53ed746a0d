"""Large effects first: seeds of the force balance, each refitted before the next is looked for."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np

from cogging._core import DivergedError
from cogging.diagnosis.candidates.signatures import Candidate
from cogging.diagnosis.evidence.allowance import AXIS_PARAMETERS, Allowance
from cogging.diagnosis.large.balance import Balances
from cogging.diagnosis.large.nuisances import Nuisances, nuisances_of
from cogging.diagnosis.large.refit import refitted
from cogging.diagnosis.large.seeds import Seed, seeds
from cogging.diagnosis.physical import unphysical
from cogging.diagnosis.thresholds import LARGE
from cogging.effects.effect import Effect
from cogging.model.model import Model
from cogging.model.parameters import parameters_of, with_values

MASS = "axis.mass"
Told = Callable[[str], None]


@dataclass(frozen=True)
class Trial:
    """A term that is tried.

    Attributes:
        name: name of the effect, or of the change of a parameter.
        effect: effect with its amplitudes; None for a change of a parameter.
        candidate: effect and shape; None likewise.
        path: path of a parameter that is no more held, alone or beside the effect; None where none is let go.
        parameters: how many numbers it has.
        left: power that it leaves before it is refitted, V^2 times rows.
    """

    name: str
    effect: Effect | None
    candidate: Candidate | None
    path: str | None
    parameters: int
    left: float

    def worth(self, before: float) -> float:
        """ln of the power that it leaves of that before, less what its parameters must be worth.

        To a millionth: of two that leave the same, the first in the list comes first on every processor.
        """
        return round(float(np.log(self.left / before)) + LARGE.parameter * self.parameters, 6)


@dataclass(frozen=True)
class LargeTerm:
    """A term that was added.

    Attributes:
        trial: the term as it was tried.
        alternatives: names that left about as little.
        before, confirm_before: rms of the balance without it, V.
        balances: logs under the model with it.
        confirm: confirm logs under it, nuisances re-tuned; None without.
    """

    trial: Trial
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
        stated: how far nuisances may go before anything was found about them.
        start: logs under the model as it was given, nuisances re-tuned as far as they are allowed to.
        confirm_start: confirm logs under it, nuisances re-tuned likewise; None without.
        balances, confirm: the same under the last model.
        allowed: how far nuisances may go that nothing was found about.
        terms: what was added, in its order.
        refused: what was not, each name with the reason.
    """

    given: int
    stated: Allowance
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

    @property
    def effects(self) -> tuple[LargeTerm, ...]:
        """Terms that are effects."""
        return tuple(term for term in self.terms if term.trial.effect is not None)

    @property
    def let_go(self) -> frozenset[str]:
        """Paths of nuisances that are no more held to what is stated of them."""
        return frozenset(term.trial.path for term in self.terms if term.trial.path is not None)

    @property
    def left(self) -> float:
        """ln of the power left here and on other motion, plus what the parameters must be worth."""
        left = 2.0 * float(np.log(self.balances.rms)) + LARGE.parameter * sum(t.trial.parameters for t in self.terms)
        return left if self.confirm is None else left + 2.0 * float(np.log(self.confirm.rms))


def search_large(
    balances: Balances,
    confirm: Balances | None,
    allowed: Allowance,
    vocabulary: Mapping[str, Effect],
    progress: Told,
    *,
    any_size: bool = False,
) -> Large | None:
    """Add the largest missing effect, refit, and look again, until what is left is no more large.

    Where what is left stays large, the search starts once more from what came second: of two effects of one size, the
    one that looks best alone may be neither. None where what the model leaves unexplained is not large to begin with;
    or, of `any_size`, where nothing is found.

    Args:
        balances: logs under the given model.
        confirm: logs of other motion under it; None without.
        allowed: how far its nuisances may go.
        vocabulary: effects that are tried, by name.
        progress: function that is called with what is being done.
        any_size: whether to look although little is unexplained.
    """
    given = len(balances.model.effects)
    start = refitted(balances, allowed, given)
    elsewhere = None if confirm is None else with_own_nuisances(confirm.under(start.model), allowed)
    empty = Large(given, allowed, start, elsewhere, start, elsewhere, allowed)
    if not (is_large(empty) or (any_size and start.rms > max(LARGE.least * start.command, start.noise))):
        return None
    progress("large effects, 1")
    best, rivals = best_start(empty, vocabulary, progress)
    best = with_alternatives(with_swaps(best, vocabulary, progress), vocabulary)
    if best.terms:
        known = {*best.terms[0].alternatives, *rivals} - {best.terms[0].trial.name}
        best = replace(best, terms=(replace(best.terms[0], alternatives=tuple(sorted(known))), *best.terms[1:]))
    return None if any_size and not best.terms else best


def best_start(empty: Large, vocabulary: Mapping[str, Effect], progress: Told) -> tuple[Large, set[str]]:
    """The state that leaves least of those that start from different terms; and first terms that lead as far.

    Further starts are followed while what is left stays large, and where two first terms leave about as little: what
    one of them lacks, others may make up for.
    """
    nuisances = nuisances_of(empty.balances, empty.allowed)
    before = nuisances.alone()[1]
    trials = worthwhile(empty, vocabulary)
    best = followed(with_best(empty, trials), vocabulary, progress)
    ends = {best.terms[0].trial.name: best.left} if best.terms else {}
    for trial in trials[: LARGE.starts]:
        near = trial.worth(before) < trials[0].worth(before) + LARGE.near_start
        if trial.name in ends or not best.terms or not (near or is_large(best)):
            continue
        other = followed(with_best(empty, [trial]), vocabulary, progress)
        if other.terms and other.terms[0].trial.name == trial.name:
            ends[trial.name] = other.left
        best = other if other.left < best.left else best
    return best, {name for name, left in ends.items() if left < best.left + LARGE.alternative}


def with_alternatives(state: Large, vocabulary: Mapping[str, Effect]) -> Large:
    """The state in which each effect knows the names that would leave about as little in its place."""
    terms = []
    for place, term in enumerate(state.terms):
        if term.trial.effect is None:
            terms.append(term)
            continue
        less = without_term(state, place)
        others = {name: law for name, law in vocabulary.items() if name != term.trial.name}
        found = tried_each(less, worthwhile(less, others)[: LARGE.rivals])[0]
        alike = {one.name for one, its in found if its.left < state.left + LARGE.alternative}
        terms.append(replace(term, alternatives=tuple(sorted(alike))))
    return replace(state, terms=tuple(terms))


def with_swaps(state: Large, vocabulary: Mapping[str, Effect], progress: Told) -> Large:
    """The state with terms exchanged for others, while what is left stays large and that leaves less of it.

    What stood for several effects together is not needed once they are there, but keeps them from being found.
    """
    for term in state.terms if is_large(state) else ():
        if term.trial.effect is None or term not in state.terms:
            continue
        others = {name: law for name, law in vocabulary.items() if name != term.trial.name}
        other = followed(without_term(state, state.terms.index(term)), others, progress)
        if other.left < state.left - LARGE.alternative:
            state = other
    return state


def followed(state: Large, vocabulary: Mapping[str, Effect], progress: Told) -> Large:
    """The state after further large effects were added one after the other, and what they made superfluous left out."""
    while len(state.terms) < LARGE.terms and is_large(state):
        progress(f"large effects, {len(state.terms) + 1}")
        following = with_best(state, worthwhile(state, vocabulary))
        if len(following.terms) == len(state.terms):
            state = following
            break
        state = following
    return without_what_is_not_needed(state)


def is_large(state: Large) -> bool:
    """Whether what is left is large, or was and is not yet noise."""
    share = LARGE.large_still if state.terms else LARGE.large
    balances = state.balances
    return min(balances.rms, balances.force) > max(share * balances.command, LARGE.above_noise * balances.noise)


# Choose ---------------------------------------------------------------------------------------------------------------


def worthwhile(state: Large, vocabulary: Mapping[str, Effect]) -> list[Trial]:
    """Terms that take a good part of what is left, the best first."""
    nuisances = nuisances_of(state.balances, state.allowed)
    before = nuisances.alone()[1]
    found = [*effects_to_try(state, nuisances, vocabulary), *changes_to_try(state)]
    found += with_mass_to_try(state, found, vocabulary)
    least = float(np.log(1.0 - LARGE.power_taken))
    ranked = sorted((one for one in found if one.worth(before) < least), key=lambda one: one.worth(before))
    first = {one.name: one for one in reversed(ranked)}  # of two of one name, the better
    return [one for one in ranked if first[one.name] is one]


def effects_to_try(state: Large, nuisances: Nuisances, vocabulary: Mapping[str, Effect]) -> list[Trial]:
    """The best term of each effect."""
    return [_trial(seed) for seed in seeds(state.balances, nuisances, vocabulary)]


def with_mass_to_try(state: Large, alone: Sequence[Trial], vocabulary: Mapping[str, Effect]) -> list[Trial]:
    """Effects that take far more together with a change of mass than either does alone.

    Where a loop is soft, a force moves the axis instead of being held: less of it shows, the farther off the mass is.
    """
    left = {one.name: one.left for one in alone}
    if "mass_change" not in left:
        return []
    free = nuisances_of(state.balances, state.allowed.without((MASS,)))
    found = [_trial(seed, MASS) for seed in seeds(state.balances, free, vocabulary)]
    limit = 1.0 - LARGE.power_taken
    return [one for one in found if one.left < limit * min(left["mass_change"], left.get(one.name, np.inf))]


def _trial(seed: Seed, path: str | None = None) -> Trial:
    roles = seed.candidate.law.ROLES
    shapes = [
        field
        for field, value in seed.candidate.shape.items()
        if roles[field]["role"] == "shape" and isinstance(value, float)
    ]
    parameters = len(shapes) + len(seed.amplitudes) + (path is not None)
    return Trial(seed.name, seed.effect(), seed.candidate, path, parameters, seed.left)


def changes_to_try(state: Large) -> list[Trial]:
    """Mass and friction that are held by what the model states, each let go."""
    found = []
    for name in AXIS_PARAMETERS:
        path = f"axis.{name}"
        value = float(getattr(state.model.axis, name))
        if path in state.allowed.exact or state.allowed.at_end(path, value):
            left = nuisances_of(state.balances, state.allowed.without((path,))).alone()[1]
            found.append(Trial(f"{name}_change", None, None, path, 1, left))
    return found


# Refit and accept -----------------------------------------------------------------------------------------------------


def with_best(state: Large, trials: Sequence[Trial]) -> Large:
    """The state with the term that leaves least once it is refitted; with reasons where none is accepted.

    The balance of a wrong model may mislead: terms near the best are refitted too.
    """
    if not trials:
        return state
    before = state.balances.rms**2 * len(state.balances.residual)
    close = [one for one in trials if one.worth(before) <= LARGE.near * trials[0].worth(before)][: LARGE.rivals]
    tried, refused = tried_each(state, close)
    for trial, after in tried:
        reason = objection(state, after)
        if reason is not None:
            refused.append((trial.name, reason))
            continue
        return replace(after, refused=tuple(refused))
    return replace(state, refused=tuple(refused))


def tried_each(state: Large, trials: Sequence[Trial]) -> tuple[list[tuple[Trial, Large]], list[tuple[str, str]]]:
    """Each term with the state that it leads to, what leaves least first; and all that were refused, with reasons."""
    refused, tried = list(state.refused), []
    for one in trials:
        try:
            tried.append((one, with_trial(state, one)))
        except (DivergedError, ValueError) as error:
            refused.append((one.name, f"the model with it cannot be fitted: {error}"))
    return sorted(tried, key=lambda pair: pair[1].left), refused


def with_trial(state: Large, trial: Trial) -> Large:
    """The state with a term, refitted."""
    allowed = state.allowed if trial.path is None else state.allowed.without((trial.path,))
    model = state.model
    if trial.effect is not None:
        model = model.replace(effects=(*model.effects, trial.effect))
    after = refitted(state.balances.under(model), allowed, state.given)
    confirm = None if state.confirm is None else with_own_nuisances(state.confirm.under(after.model), allowed)
    before = None if state.confirm is None else state.confirm.rms
    term = LargeTerm(trial, (), state.balances.rms, before, after, confirm)
    return replace(state, balances=after, confirm=confirm, allowed=allowed, terms=(*state.terms, term))


def objection(state: Large, after: Large) -> str | None:
    """Why a term is refused; None where nothing speaks against it."""
    mine, its = after.balances.rms, state.balances.rms
    if mine**2 > (1.0 - LARGE.power_taken) * its**2:
        return f"refitted, it leaves {mine:.3g} of {its:.3g} V"
    if after.confirm is not None and state.confirm is not None and after.confirm.rms > LARGE.growth * state.confirm.rms:
        return f"the gap on the other motion grows from {state.confirm.rms:.4g} to {after.confirm.rms:.4g} V with it"
    return unphysical(after.model, after.given, [source.log for source in after.balances.sources]) or None


def with_own_nuisances(balances: Balances, allowed: Allowance) -> Balances:
    """The balances with nuisances re-tuned on these logs, effects as they are."""
    nuisances = nuisances_of(balances, allowed, effects=False)
    steps, _ = nuisances.alone()
    known = parameters_of(balances.model, together=True)
    values = {
        path: allowed.nearest(path, known[path].value + float(step))
        for path, step in zip(nuisances.paths, steps, strict=True)
    }
    return balances.under(with_values(balances.model, values))


def without_what_is_not_needed(state: Large) -> Large:
    """The state without terms that a later one made superfluous."""
    for place in reversed(range(len(state.terms) - 1)):
        term = state.terms[place]
        if term.trial.effect is None:
            continue
        less = without_term(state, place)
        if 2.0 * float(np.log(less.balances.rms / state.balances.rms)) < LARGE.parameter * term.trial.parameters:
            told = (*state.refused, (term.trial.name, "what was added after it explains it"))
            state = replace(less, refused=told)
    return state


def without_term(state: Large, place: int) -> Large:
    """The state without the effect that was added at a place, all else refitted."""
    effects = list(state.model.effects)
    del effects[state.given + sum(one.trial.effect is not None for one in state.terms[:place])]
    less = refitted(state.balances.under(state.model.replace(effects=tuple(effects))), state.allowed, state.given)
    other = None if state.confirm is None else state.confirm.under(less.model)
    confirm = None if other is None else with_own_nuisances(other, state.allowed)
    terms = (*state.terms[:place], *state.terms[place + 1 :])
    return replace(state, balances=less, confirm=confirm, terms=terms)
