"""The search for missing effects: scan, choose, refit, accept, and look again at what is left."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence

from cogging._core import DivergedError
from cogging.diagnosis.candidates.findings import Finding, cleaned, profiled
from cogging.diagnosis.candidates.map_errors import MapError, freed, map_error
from cogging.diagnosis.candidates.scan import scan
from cogging.diagnosis.candidates.signatures import vocabulary_of
from cogging.diagnosis.discrepancy import has_balance, source_of
from cogging.diagnosis.evidence.allowance import allowance
from cogging.diagnosis.evidence.evidence import Evidence
from cogging.diagnosis.evidence.gather import gather
from cogging.diagnosis.evidence.null import fit_null
from cogging.diagnosis.large.balance import balances_of
from cogging.diagnosis.large.search import Large, search_large
from cogging.diagnosis.physical import physical_ceilings
from cogging.diagnosis.residual.events import with_events
from cogging.diagnosis.residual.modulated_look_alikes import modulated_look_alikes
from cogging.diagnosis.residual.shapes import low_power, shapes
from cogging.diagnosis.search.acceptance import excludes_none
from cogging.diagnosis.search.choice import (
    choose,
    is_rounding,
    is_seen,
    refusal,
    told_apart,
    worths,
)
from cogging.diagnosis.search.confirmation import Confirmation, confirmation, retuned
from cogging.diagnosis.search.form_rivals import law_instead, with_forms
from cogging.diagnosis.search.gaps import Yardstick
from cogging.diagnosis.search.large_start import started, tuned_beside_large
from cogging.diagnosis.search.refit import refit
from cogging.diagnosis.search.state import Added, Choice, Scanned, Search, State, Task
from cogging.diagnosis.search.tuning import amplitude_paths, gap_size, tuned_together, with_nuisances_tuned
from cogging.diagnosis.thresholds import CHOICE, LARGE, SEARCH
from cogging.effects.effect import Effect
from cogging.estimation.gauss_newton import Estimate
from cogging.logs.log import Log
from cogging.model.intervals import SIGMAS_95
from cogging.model.model import Model


def search(
    logs: Sequence[Log],
    model: Model,
    confirm: Sequence[Log] = (),
    progress: Callable[[str], None] = lambda step: None,
    replay: bool = False,
    free_map: bool = False,
    vocabulary: Mapping[str, Effect] | None = None,
) -> Search:
    """Scan, add what stands, until nothing significant is left or as many as can be told were added.

    Args:
        logs: logs that are searched.
        model: model that is held against them.
        confirm: logs of other motion.
        progress: function that is called with what is being done.
        replay: whether an effect must pay by the gap of the replayed loop, where that follows the logs.
        free_map: whether errors of the cogging map are re-tuned; tried where they explain as much as the best effect.
        vocabulary: effects that are tried, as they are when they do nothing, by name; the list when None.
    """
    state = begin(Task(logs, model, confirm, progress, replay, free_map, vocabulary or vocabulary_of(model)))
    while True:
        progress(f"scanning, effect {len(state.added) + 1}")
        scanned = scan_twice(state)
        if len(state.added) == SEARCH.terms_max:
            return finish(state, scanned)
        wrong_map = None if free_map else map_error(state.estimate, state.evidence)
        if wrong_map is not None and wrong_map.rivals(
            max((f.score for f in scanned.findings), default=0.0), SEARCH.rival
        ):
            return search(logs, model, confirm, progress, replay, True, vocabulary)  # re-tuning comes first
        choice = choose_next(state, scanned)
        if choice is None:
            return finish(state, scanned)
        owner = law_instead(choice.finding, state.estimate.model.effects[len(model.effects) :], state.evidence)
        if owner is not None:
            state.refused.append((choice.finding, f"another law of {owner} explains as much"))
            continue
        fitted = refit_with(state, choice)
        paying = None if fitted is None else tuned_if_it_pays(state, choice, fitted)
        if paying is not None:
            accept(state, scanned, choice, *paying, wrong_map)


def begin(task: Task) -> State:
    """The model re-tuned, before anything is looked for; where it leaves much unexplained, with the large effects."""
    task.progress("re-tuning the model")
    large = large_effects(task)
    if large is not None:
        return started(task, large)
    nominal, evidence = fit_null(task.logs, task.model)
    if leaves_allowance(task.model, nominal):
        large = large_effects(task, any_size=True)
        if large is not None:
            return started(task, large)
    if task.free_map:
        nominal, evidence = freed(nominal, evidence)
    sources = [source_of(log, nominal.model) for log in task.logs]
    tuned = with_nuisances_tuned(nominal.model, nominal.paths, sources)
    quick = all(source.quick_starts for source in evidence.sources)
    yardstick = Yardstick(task.logs, task.confirm, task.model, nominal.model, nominal.paths, replay=task.replay)
    state = State(task, nominal, evidence, tuned, sources, quick, nominal, evidence, tuned, yardstick)
    state.confirm_evidence = evidence_elsewhere(state)
    return state


def leaves_allowance(model: Model, nominal: Estimate) -> bool:
    """Whether re-tuning takes mass or friction much farther than the model states that they may be off.

    Then something was taken for them, unless they have changed.
    """
    allowed = allowance(model)
    return any(allowed.far_outside(path, value) for path, value in zip(nominal.paths, nominal.values, strict=True))


def large_effects(task: Task, *, any_size: bool = False) -> Large | None:
    """The search for large effects; None where what the model leaves unexplained is small, or nothing can be said."""
    try:
        balances = balances_of(task.logs, task.model)
        confirm = balances_of(task.confirm, task.model) if task.confirm else None
    except ValueError:
        return None
    allowed = allowance(task.model, physical_ceilings(task.logs))
    return search_large(balances, confirm, allowed, task.vocabulary, task.progress, any_size=any_size)


def evidence_elsewhere(state: State) -> Evidence | None:
    """The confirm logs under the present model; None where they cannot be predicted."""
    task, estimate = state.task, state.estimate
    if not task.confirm:
        return None
    try:
        paths, allowed = estimate.paths, state.allowed
        return retuned(task.confirm, estimate.model, task.model, paths, quick=state.quick, allowed=allowed)
    except (DivergedError, ValueError):
        return None


# Scan -----------------------------------------------------------------------------------------------------------------


def scan_twice(state: State) -> Scanned:
    """What the evidence holds; where something stands out of it, with filters that are estimated without that.

    A strong effect in the residual is taken for noise by the filters: they are estimated again without the best
    explanation, and effects near the best are tried a second time. The state keeps the evidence with these filters.
    """
    evidence, vocabulary = state.evidence, state.task.vocabulary
    findings, faint = told_apart(profiled(evidence, scan(evidence, vocabulary.values())))
    found = shapes(evidence)
    state.nominal_shapes = state.nominal_shapes or with_events(evidence, found)
    best = max(findings, key=lambda f: f.score, default=None)
    if best is not None and best.log_p_value < SEARCH.rescan_from * CHOICE.detected:
        state.evidence = cleaned(evidence, best)
        near = {
            f.name for f in findings if f.score > best.score - SEARCH.rescan_within and f.log_p_value < CHOICE.possible
        }
        again = scan(state.evidence, [vocabulary[name] for name in sorted(near)])
        sharper, still_faint = told_apart(profiled(evidence, again))
        findings = [*sharper, *(f for f in findings if f.name not in near)]
        faint = [*still_faint, *(f for f in faint if f.name not in near)]
    return Scanned(findings, faint, found, evidence)


# Choose ---------------------------------------------------------------------------------------------------------------


def choose_next(state: State, scanned: Scanned) -> Choice | None:
    """The effect that is tried next, of those alike the one that both motions favour; None where nothing stands."""
    barred = barred_names(state)
    worth = worths(state.estimate, state.evidence, scanned.findings)
    step = first_that_stands(state, scanned, barred, worth)
    if step is None:
        return None
    rivals, chosen, check = choose(
        scanned.findings, *step, state.confirm_evidence, barred - state.unpaid, worth, state.unpaid
    )
    return Choice(chosen, check, rivals)


def barred_names(state: State) -> set[str]:
    """Effects that are not tried: refused before, or as many as can be told were added."""
    names = [one.finding.name for one in state.added]
    barred = {finding.name for finding, _ in state.refused}
    if len(set(names)) == SEARCH.effects_max:  # further harmonics of what was found may still come
        barred |= set(state.task.vocabulary) - set(names)
    return barred | {name for name in names if names.count(name) == SEARCH.harmonics_max}


def first_that_stands(
    state: State, scanned: Scanned, barred: set[str], worth: dict[str, float]
) -> tuple[Finding, Confirmation | None] | None:
    """The best finding that other motion confirms; else the best that it does not refute. The refuted are refused."""
    confirm = bool(state.task.confirm)
    power = low_power(state.evidence)
    other_power = low_power(state.confirm_evidence) if state.confirm_evidence is not None else 0.0
    waiting: tuple[Finding, Confirmation | None] | None = None
    for finding in sorted(scanned.findings, key=lambda f: -worth.get(f.name, f.score if not worth else 0.0)):
        if finding.log_p_value > (SEARCH.hinted if confirm else CHOICE.detected) or finding.name in barred:
            continue
        if is_rounding(finding, scanned.faint):
            continue
        check = confirmation(state.confirm_evidence, finding)
        if confirm and check is None:  # the other logs cannot be predicted: they show nothing
            check = Confirmation(0.0, 0.0, 0.0)
        if not is_seen(finding, check, power, other_power):
            continue
        reason = refusal(finding, check)
        if reason is not None:
            state.refused.append((finding, reason))
            continue
        if check is None or check.confirmed:
            return finding, check
        waiting = waiting or (finding, check)  # what other motion cannot show waits for what it does
    return waiting


# Refit ----------------------------------------------------------------------------------------------------------------


def refit_with(state: State, choice: Choice) -> Estimate | None:
    """The fit with the effect in the model; None, and the effect refused, where nothing tells it from none."""
    finding, check = choice.finding, choice.check
    try:
        state.task.progress(f"adding {finding.name}")
        given = len(state.task.model.effects)
        fitted = refit(state.estimate, finding, state.evidence, given, state.allowed)
    except (DivergedError, ValueError) as error:
        refuse(state, finding, f"the model with it cannot be fitted: {error}")
        return None
    elsewhere = check is not None and check.confirmed and check.ratio > SIGMAS_95 * check.deviation
    if elsewhere or excludes_none(fitted, finding.candidate.law):
        return fitted
    refuse(state, finding, "refitted, the interval of its size includes none")
    return None


def tuned_if_it_pays(state: State, choice: Choice, fitted: Estimate) -> tuple[Estimate, Model] | None:
    """The fit and its model tuned to the gap; None, and the effect refused, where a gap does not shrink with it.

    How far the shape of a large effect is from its law is large too, against noise alone: what is added beside one must
    take a good part of what is left, here and on other motion.
    """
    turns = [*state.turns, 0.0 if choice.check is None else choice.check.turn]
    try:
        fitted, tuned = tuned_with(state, choice.finding, fitted)
        measured = state.yardstick.measure([state.tuned, tuned], turns)
        why = measured.objection(0.0 if state.large is None else LARGE.power_taken)
    except (DivergedError, ValueError) as error:
        why = f"the model with it cannot be held against the logs: {error}"
    if why:
        refuse(state, choice.finding, why)
        return None
    return fitted, tuned


def tuned_with(state: State, finding: Finding, fitted: Estimate) -> tuple[Estimate, Model]:
    """The fit with an effect in it and its model tuned to the gap: by the balance where that measures the gap."""
    if state.large is not None and has_balance(fitted.model) and not state.task.replay:
        return tuned_beside_large(state, fitted, finding)
    paths, sources = state.nominal.paths, state.tuning_sources
    return tuned_together(
        state.tuned,
        fitted,
        finding,
        lambda model: gap_size(model, sources),
        lambda model: with_nuisances_tuned(model, paths, sources, state.allowed),
        lambda model: with_nuisances_tuned(model, [*paths, *amplitude_paths(model)], sources, state.allowed),
        state.evidence.sources,
    )


def refuse(state: State, finding: Finding, reason: str) -> None:
    """Nothing speaks against the effect but what became of the model: it may come again beside another."""
    state.refused.append((finding, reason))
    state.unpaid.add(finding.name)


# Accept ---------------------------------------------------------------------------------------------------------------


def accept(
    state: State, scanned: Scanned, choice: Choice, fitted: Estimate, tuned: Model, wrong_map: MapError | None
) -> None:
    """Take the effect into the model, and make the evidence of what is left."""
    or_map = wrong_map is not None and wrong_map.rivals(
        choice.rivals[0].score, max(SEARCH.map_rival * SEARCH.rival, CHOICE.form * wrong_map.statistic)
    )
    missing = [*scanned.shapes, *modulated_look_alikes(state.evidence, choice.finding)]
    rivals = with_forms(choice.rivals, scanned.findings, state.evidence, state.confirm_evidence)
    state.added.append(Added(choice.finding, rivals, missing, choice.check, tuned, or_map))
    state.estimate, state.tuned = fitted, tuned
    state.evidence = gather(fitted, state.evidence.sources, memory=state.evidence.memory)
    state.confirm_evidence = evidence_elsewhere(state)


def finish(state: State, scanned: Scanned) -> Search:
    """What was found, and the residual shapes of what is left."""
    evidence = state.evidence
    known = scanned.shapes if evidence is scanned.seen else ()
    return Search(
        state.nominal,
        state.nominal_evidence,
        state.tuned_nominal,
        state.estimate,
        evidence,
        state.added,
        state.refused,
        state.nominal_shapes,
        with_events(evidence, shapes(evidence, plain=True, known=known)),
        scanned.findings,
        state.confirm_evidence,
        state.task.vocabulary,
        state.yardstick,
        state.large,
    )
