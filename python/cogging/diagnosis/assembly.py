"""From a search to a result: the models with their gaps, the names, the verdict and what was tried."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace
from typing import Any

import numpy as np

from cogging.diagnosis.discrepancy import source_of
from cogging.diagnosis.entries import NamedEffect, ShapeTerm, Step
from cogging.diagnosis.evidence.allowance import Allowance
from cogging.diagnosis.evidence.preparation import Prepared
from cogging.diagnosis.separating import separating
from cogging.diagnosis.gaps import Measured, gap_of, series_of
from cogging.diagnosis.limits import limits
from cogging.diagnosis.locate import location_of
from cogging.diagnosis.naming.large_names import map_note, named_large, unsettled
from cogging.diagnosis.naming.masking import masking_notes
from cogging.diagnosis.naming.names import changed, merged, named, with_term_of
from cogging.diagnosis.naming.near_rest import near_rest
from cogging.diagnosis.naming.parameter_changes import changes, look_alikes
from cogging.diagnosis.naming.shape_terms import with_shape_terms
from cogging.diagnosis.naming.sizes import with_shares
from cogging.diagnosis.naming.verdict import not_noise, seen_and_refused, unlisted, verdict
from cogging.diagnosis.patched import with_intervals
from cogging.diagnosis.physical import physical_ceilings
from cogging.diagnosis.predictable import predicted
from cogging.diagnosis.residual.location_words import shape_text
from cogging.diagnosis.residual.shape import FRICTION_INTERVALS, Shape
from cogging.diagnosis.result import Diagnosis
from cogging.diagnosis.search.empirical import NoTerm, with_term
from cogging.diagnosis.search.placebo import placebos
from cogging.diagnosis.search.state import Added, Search, turns_of
from cogging.diagnosis.search.tuning import with_nuisances_tuned
from cogging.diagnosis.thresholds import LOCATION, PARAMETER_CHANGE, VERDICT
from cogging.effects.effect import Effect
from cogging.logs.log import Log
from cogging.model.model import Model
from cogging.model.parameters import parameters_of, with_values


def assemble(found: Search, logs: Prepared, model: Model) -> Diagnosis:
    """The result of a search.

    Args:
        found: the search.
        logs: logs that it saw.
        model: given model, with the controller that was running.
    """
    friction = near_rest(found)
    found, terms = with_shape_terms(found)
    beyond = [change for change in changes(found, model) if abs(change[3]) > PARAMETER_CHANGE.changed]
    retuned, final = file_form(found.tuned, model), with_intervals(file_form(last_model(found), model), found.estimate)
    held = [f"axis.{change[0]}" for change in beyond]
    models = [_as_stated(found, retuned, model, held[count:]) for count in range(len(held) + 1)]
    models += [file_form(added.model, model) for added in found.added]
    nominal, models[-1] = models[0], final
    yardstick = found.yardstick.holding(held)
    measured = yardstick.measure(models, turns_of(found.added))
    read = yardstick.as_read(measured.given[0])
    if read is not None and read.rms < measured.given[0].rms:  # re-tuning that makes the gap larger is none
        measured, nominal = replace(measured, given=[read, *measured.given[1:]]), model
        final = final if len(models) > 1 else model
    if found.added and (why := measured.objection()):
        result = assemble(without_what_was_added(found, why), logs, model)
        return replace(result, **told_all_the_same(result, found))
    rest = predicted(logs.given, measured.given[-1], logs.confirm, measured.confirm[-1] if measured.confirm else None)
    names = [f"{change[0]}_change" for change in beyond] + [added.finding.name for added in found.added]
    gap = gap_of(measured, read, rest, logs.given, final)
    effects = with_shares(_effects(found, model, beyond, terms), names, measured.given, final)
    effects = effects if found.large is None else unsettled(effects, gap)
    residual_shape = unlisted(found, effects, checked=bool(logs.confirm) and found.confirm_evidence is not None)
    systematic = not_noise(rest, gap)
    location = location_of(found.nominal_evidence, found.nominal.model, found.nominal_shapes)
    found = replace(found, yardstick=found.yardstick.as_measured(gap))
    final, effects = with_curves(final, effects, found, logs)
    explained = found.large is not None and measured.mostly_explained
    return Diagnosis(
        verdict="unlisted" if systematic else verdict(effects, residual_shape, explained=explained),
        effects=tuple(effects),
        unlisted=residual_shape or systematic,
        gap=gap,
        separating_experiment=_separating(effects, found.vocabulary, logs.given),
        model=final,
        nominal=nominal,
        location=location,
        where_text=tuple(
            shape_text(shape) for shape in location.shapes if shape.log_p_value < LOCATION.told_with_names
        ),
        ledger=tuple(_ledger(found, measured, len(held))),
        notes=(*logs.notes, *masking_notes(retuned, final), *measured.notes, *_notes(found, model)),
        placebo=placebos(found),
        series=series_of(logs.given, measured.given, location) | {"given": model},
        vocabulary=found.vocabulary,
        limits=limits(found, model, bool(logs.confirm)),
        near_rest=friction,
    )


def told_all_the_same(result: Diagnosis, found: Search) -> dict[str, Any]:
    """Verdict and entry where what was added made the model worse, all together: there is a gap all the same."""
    if result.verdict != "no_gap":
        return {}
    return {"verdict": "unlisted", "unlisted": seen_and_refused(found)}


# Models ---------------------------------------------------------------------------------------------------------------


def last_model(found: Search) -> Model:
    """The model with all that was added, and mass and friction as a search for large effects left them."""
    if found.added:
        return found.added[-1].model
    return found.tuned if found.large is None else found.large.model


def file_form(fitted: Model, model: Model) -> Model:
    """The fitted model with the sections of the given one."""
    return fitted.replace(uncertainty=dict(model.uncertainty), controller=model.controller)


def _as_stated(found: Search, nominal: Model, model: Model, held: Sequence[str]) -> Model:
    """The nominal model with what was found to have changed as the given model states it, and all else re-tuned."""
    if not held:
        return nominal
    values = {path: parameters_of(model)[path].value for path in held}
    paths = [path for path in found.nominal.paths if path not in held]
    sources = [source_of(source.log, nominal) for source in found.nominal_evidence.sources]
    return file_form(with_nuisances_tuned(with_values(nominal, values), paths, sources), model)


def with_empirical_term(result: Diagnosis, found: Search, model: Model, logs: Prepared) -> Diagnosis:
    """The result with an empirical term in its model, or with a note why there is none."""
    residual_shape = dict(result.unlisted or {})
    found = replace(found, yardstick=found.yardstick.as_measured(result.gap))
    try:
        larger, told = with_term(found, residual_shape, last_model(found), logs.given)
    except NoTerm as why:
        return replace(result, notes=(*result.notes, str(why)))
    larger = with_intervals(file_form(larger, model), found.estimate)
    return replace(result, model=larger, unlisted=residual_shape | {"added": told})


# Gaps -----------------------------------------------------------------------------------------------------------------


def without_what_was_added(found: Search, why: str) -> Search:
    """The search as if nothing had been added: together, what was found makes the model worse."""
    refused = [*((added.finding, why) for added in found.added), *found.refused]
    return replace(
        found,
        added=[],
        refused=refused,
        estimate=found.nominal,
        evidence=found.nominal_evidence,
        confirm_evidence=None,
        residual_shapes=found.nominal_shapes,  # all that was seen is left
    )


# Effects --------------------------------------------------------------------------------------------------------------


def _effects(
    found: Search,
    model: Model,
    beyond: Sequence[tuple[str, float, float, float]],
    terms: Mapping[int, ShapeTerm],
) -> list[NamedEffect]:
    """What was added, by name, and what of mass and friction has changed."""
    left = [
        shape
        for shape in found.residual_shapes
        if shape.log_p_value < VERDICT.left_over and shape.coordinate != FRICTION_INTERVALS
    ]
    effects = merged([with_term_of(_named(found, i, left), terms.get(i)) for i in range(len(found.added))])
    return effects + [changed(change, look_alikes(found, model, change[0]), left) for change in beyond]


def with_curves(
    final: Model, effects: Sequence[NamedEffect], found: Search, logs: Prepared
) -> tuple[Model, list[NamedEffect]]:
    """The final model with the curves of effects of another shape, and the effects; where one does not pay, without.

    A curve is held as an empirical force: its cause has a name, its law has none.
    """
    told = []
    for effect in effects:
        term = effect.shape_term
        if term is not None and term.curve is not None:
            try:
                larger = with_term(found, term.curve, final, logs.given)[0]
                final = with_intervals(larger, found.estimate)
            except NoTerm:
                effect = replace(effect, shape_term=replace(term, curve=None))
        told.append(effect)
    return final, told


def _named(found: Search, place: int, left: Sequence[Shape]) -> NamedEffect:
    term = found.added[place].large
    return named(found, place, left) if term is None else named_large(found, place, term)


def _notes(found: Search, model: Model) -> list[str]:
    """What is to be said of waves elsewhere, of those of one pitch, and of parameters that re-tuning ran up."""
    note = None if found.large is None else map_note(found.estimate.model.effects[len(model.effects) :], model)
    return [*_turned_note(found), *([] if note is None else [note]), *at_their_end(found)]


def at_their_end(found: Search) -> list[str]:
    """Which of mass and friction re-tuning took to the end of what is allowed: a symptom, not a value."""
    logs = [source.log for source in found.evidence.sources]
    most = physical_ceilings(logs)
    allowed = Allowance({}, most, (), most) if found.large is None else found.large.allowed
    return [
        f"{path}: re-tuning takes it to {value:.4g}, the end of what the model and these logs allow: something else is "
        "taken for it"
        for path, value in zip(found.estimate.paths, found.estimate.values, strict=True)
        if path in allowed.ceilings and path not in allowed.exact and allowed.at_end(path, value)
    ]


def _turned_note(found: Search) -> list[str]:
    """Which waves lie elsewhere on the other motion: the zeros of position or time of the logs differ."""
    told = []
    for added, turn in zip(found.added, turns_of(found.added), strict=True):
        if turn != 0.0:
            degrees = (np.degrees(turn) + 180.0) % 360.0 - 180.0
            value = next(iter(added.finding.candidate.shape.values()))
            told.append(f"{added.finding.name} at {value:.4g} by {degrees:.0f} degrees")
    if not told:
        return []
    return [
        f"the other motion shows waves turned, as where its zero of position or time is another: {', '.join(told)}; "
        "its gap is told with them so turned"
    ]


def _separating(effects: Sequence[NamedEffect], vocabulary: Mapping[str, Effect], logs: Sequence[Log]) -> str | None:
    """The motion that would tell effects from their alternatives; None where none has any."""
    if not any(effect.alternatives for effect in effects):
        return None
    names = sorted({name for effect in effects for name in (effect.name, *effect.alternatives)})
    return separating(names, vocabulary, logs)


def _ledger(found: Search, measured: Measured, start: int) -> list[Step]:
    """What was added, with the gaps without and with it, then what was refused; `start`: the model without any."""
    given, confirm = measured.given[start:], measured.confirm[start:] if measured.confirm else None
    added = [
        Step(
            one.finding.name,
            True,
            _reason(one),
            one.finding.test.statistic,
            given[i].rms,
            given[i + 1].rms,
            confirm[i].rms if confirm else None,
            confirm[i + 1].rms if confirm else None,
        )
        for i, one in enumerate(found.added)
    ]
    large = () if found.large is None else found.large.refused
    added += [Step(name, False, reason, 0.0, None, None, None, None) for name, reason in large]
    return added + [
        Step(finding.name, False, reason, finding.test.statistic, None, None, None, None)
        for finding, reason in found.refused
    ]


def _reason(added: Added) -> str:
    check = added.confirmation
    if check is None:
        return "no other motion to confirm it"
    if check.confirmed:
        return f"other motion shows {check.ratio:.2f} +- {check.deviation:.2f} of what was foreseen"
    return f"the other motion cannot show it (lambda {check.noncentrality:.1f})"
