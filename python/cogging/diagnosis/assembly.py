"""From a search to a result: the models with their gaps, the names, the verdict and what was tried."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from cogging._core import DivergedError
from cogging.diagnosis.discrepancy import Discrepancy, discrepancies, floor_of, follows, source_of
from cogging.diagnosis.entries import Gap, NamedEffect, ShapeTerm, Step
from cogging.diagnosis.evidence.preparation import Prepared
from cogging.diagnosis.evidence.running_controller import obeys
from cogging.diagnosis.experiment.separating import separating
from cogging.diagnosis.limits import limits
from cogging.diagnosis.locate import location_of
from cogging.diagnosis.location import Location
from cogging.diagnosis.naming.large_names import map_note, named_large
from cogging.diagnosis.naming.level_changes import changes, look_alikes
from cogging.diagnosis.naming.masking import masking_notes
from cogging.diagnosis.naming.names import changed, merged, named, with_term_of
from cogging.diagnosis.naming.near_rest import near_rest
from cogging.diagnosis.naming.shape_terms import with_shape_terms
from cogging.diagnosis.naming.sizes import largest_first
from cogging.diagnosis.naming.verdict import unlisted, verdict
from cogging.diagnosis.patched import with_intervals
from cogging.diagnosis.residual.location_words import shape_text
from cogging.diagnosis.residual.shape import FRICTION_INTERVALS, Shape
from cogging.diagnosis.result import Diagnosis
from cogging.diagnosis.search.empirical import NoTerm, with_term
from cogging.diagnosis.search.levels import with_levels
from cogging.diagnosis.search.placebo import placebos
from cogging.diagnosis.search.state import Added, Search
from cogging.diagnosis.thresholds import ACCEPTANCE, GAP, LARGE, LEVEL_CHANGE, LOCATION, VERDICT
from cogging.effects.effect import Effect
from cogging.estimation.statistics import moving_average
from cogging.logs.log import Log
from cogging.model.model import Model
from cogging.model.parameters import parameters_of, with_values


def assemble(found: Search, logs: Prepared, model: Model, replay: bool) -> Diagnosis:
    """The result of a search.

    Args:
        found: the search.
        logs: logs that it saw.
        model: given model, with the controller that was running.
        replay: whether the loop can be replayed.
    """
    friction = near_rest(found)
    found, terms = with_shape_terms(found)
    beyond = [change for change in changes(found, model) if abs(change[3]) > LEVEL_CHANGE.changed]
    retuned, final = file_form(found.tuned, model), with_intervals(file_form(last_model(found), model), found.estimate)
    nominal = _as_stated(found, retuned, model, [f"axis.{change[0]}" for change in beyond])
    models = [nominal, *(file_form(added.model, model) for added in found.added[:-1]), final]
    measured = measure(logs, models, found.nominal.model, model, replay=replay, balance=found.large is not None)
    if found.added and (why := growth(measured)):
        return assemble(without_what_was_added(found, why), logs, model, replay)
    if measured.given[0] is measured.stated:
        nominal = model  # re-tuning does not pay
    effects = _effects(found, model, beyond, terms)
    if found.large is not None:
        effects = largest_first(effects, found.large.balances, final, model)
    residual_shape = unlisted(found, effects, checked=bool(logs.confirm))
    location = location_of(found.nominal_evidence, found.nominal.model, found.nominal_shapes)
    final, effects = with_curves(final, effects, found, logs)
    return Diagnosis(
        verdict=verdict(effects, residual_shape, explained=found.large is not None and measured.mostly_explained),
        effects=tuple(effects),
        unlisted=residual_shape,
        gap=_gap(measured, logs.given, final),
        separating_experiment=_separating(effects, found.vocabulary, logs.given),
        model=final,
        nominal=nominal,
        location=location,
        where_text=tuple(
            shape_text(shape) for shape in location.shapes if shape.log_p_value < LOCATION.told_with_names
        ),
        ledger=tuple(_ledger(found, measured)),
        notes=(*logs.notes, *masking_notes(retuned, final), *measured.notes, *_large_notes(found, model)),
        placebo=placebos(found),
        series=_series(logs.given, measured.given, location) | {"given": model},
        vocabulary=found.vocabulary,
        limits=limits(found, model, bool(logs.confirm)),
        near_rest=friction,
    )


# Models ---------------------------------------------------------------------------------------------------------------


def last_model(found: Search) -> Model:
    """The model with all that was added."""
    return found.added[-1].model if found.added else found.tuned


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
    return file_form(with_levels(with_values(nominal, values), paths, sources), model)


def with_empirical_term(result: Diagnosis, found: Search, model: Model, logs: Prepared) -> Diagnosis:
    """The result with an empirical term in its model, or with a note why there is none."""
    residual_shape = dict(result.unlisted or {})
    try:
        larger, told = with_term(found, residual_shape, last_model(found), logs.given, logs.confirm)
    except NoTerm as why:
        return replace(result, notes=(*result.notes, str(why)))
    larger = with_intervals(file_form(larger, model), found.estimate)
    return replace(result, model=larger, unlisted=residual_shape | {"added": told})


# Gaps -----------------------------------------------------------------------------------------------------------------


@dataclass(frozen=True)
class Measured:
    """The gaps of several models: nominal, with one effect, with two, and so on.

    Attributes:
        given: discrepancies on the given logs, one a model.
        confirm: the same on the confirm logs; None without.
        notes: sentences on how they could not be measured.
        stated: discrepancy of the model as it was read, on the given logs.
    """

    given: list[Discrepancy]
    confirm: list[Discrepancy] | None
    notes: tuple[str, ...]
    stated: Discrepancy

    @property
    def mostly_explained(self) -> bool:
        """Whether most of the gap's power is gone with all that was found."""
        return self.given[-1].rms ** 2 < LARGE.unexplained * self.given[0].rms ** 2


def measure(
    logs: Prepared, models: Sequence[Model], fitted: Model, stated: Model, *, replay: bool, balance: bool
) -> Measured:
    """Measure the gaps of models, the last of which is the final one, by the replayed loop where it follows the logs.

    Args:
        logs: given and confirm logs.
        models: models whose gaps are measured.
        fitted: model whose controller the confirm logs must obey to be replayed.
        stated: model as it was read.
        replay: whether the loop can be replayed on the given logs.
        balance: whether the gap is that of the force balance where no loop is replayed.
    """
    notes = []
    given = discrepancies(logs.given, models, replay=replay, balance=balance, stated=stated)
    if replay and not follows(given[-1], logs.given, models[-1]):
        replay = False
        given = discrepancies(logs.given, models, replay=False, balance=balance, stated=stated)
        notes.append("the replayed loop does not follow the log closely enough to measure with: friction at reversals")
    loops = replay and all(obeys(log, fitted) for log in logs.confirm)
    confirm = None
    if logs.confirm:
        confirm = discrepancies(logs.confirm, models, replay=loops, balance=balance, stated=stated)
    if confirm and loops is not replay:
        notes.append("a confirm log does not obey the controller: its gap is that of an observer's innovations")
    as_read = _as_read(logs.given, [*models, stated], given[0], replay=replay, balance=balance)
    if as_read is not None and as_read.rms < given[0].rms:
        given = [as_read, *given[1:]]  # re-tuning that makes the gap larger is none
    return Measured(given, confirm, tuple(notes), given[0] if as_read is None else as_read)


def growth(measured: Measured) -> str:
    """By what a gap, or the replayed position, grew with what was added; empty where nothing did."""
    pairs = [
        ("gap", measured.given[0].rms, measured.given[-1].rms),
        ("gap as read", measured.stated.rms, measured.given[-1].rms),
    ]
    if measured.confirm:
        pairs.append(("gap on the other motion", measured.confirm[0].rms, measured.confirm[-1].rms))
    limit = ACCEPTANCE.position_growth / ACCEPTANCE.gap_growth
    for logs in (measured.given, measured.confirm or []):
        if logs and logs[0].position is not None and logs[-1].position is not None:
            pairs.append(("error of the replayed position", limit * logs[0].position, logs[-1].position))
    for what, before, after in pairs:
        if after > ACCEPTANCE.gap_growth * before:
            return f"with all that was found the {what} grows from {before:.4g} to {after:.4g}"
    return ""


def without_what_was_added(found: Search, why: str) -> Search:
    """The search as if nothing had been added: together, what was found makes the model worse."""
    refused = [*((added.finding, why) for added in found.added), *found.refused]
    return replace(
        found, added=[], refused=refused, estimate=found.nominal, evidence=found.nominal_evidence, confirm_evidence=None
    )


def _as_read(
    logs: Sequence[Log], models: Sequence[Model], first: Discrepancy, *, replay: bool, balance: bool
) -> Discrepancy | None:
    """The discrepancy of the last of models, measured as that of the first was; None where it cannot be."""
    try:
        read = discrepancies(logs, models, replay=replay, balance=balance, stated=models[-1])[-1]
    except (DivergedError, ValueError):
        return None
    return read if read.signal == first.signal else None


def _gap(measured: Measured, logs: Sequence[Log], final: Model) -> Gap:
    before, after = measured.given[0], measured.given[-1]
    return Gap(
        "V",
        min(floor_of(after, logs, final), after.rms),
        before.rms,
        after.rms,
        measured.confirm[0].rms if measured.confirm else None,
        measured.confirm[-1].rms if measured.confirm else None,
        before.signal,
        before.position,
        after.position,
        measured.stated.rms,
    )


def _series(logs: Sequence[Log], measured: Sequence[Discrepancy], location: Location) -> dict[str, Any]:
    """Rows of the logs by name, for the figures."""
    before, after = measured[0], measured[-1]
    # A replayed gap is part of the logged command: against that, noise alone would look like a gain.
    replayed = before.signal.startswith("command")
    velocities = location.series["velocity"]
    return {
        "logs": list(logs),
        "time": [log.time for log in logs],
        "gap_before": before.series,
        "gap_after": after.series,
        "mask": before.masks,
        "position": [log.position for log in logs],
        "velocity": velocities,
        "acceleration": [
            np.gradient(moving_average(velocity, round(GAP.smoothing / float(np.median(np.diff(log.time))))), log.time)
            for velocity, log in zip(velocities, logs, strict=True)
        ],
        "command": [log.command - (gap if replayed else 0.0) for log, gap in zip(logs, before.series, strict=True)],
    }


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
                larger = with_term(found, dict(term.curve), final, logs.given, logs.confirm)[0]
                final = with_intervals(larger, found.estimate)
            except NoTerm:
                effect = replace(effect, shape_term=replace(term, curve=None))
        told.append(effect)
    return final, told


def _named(found: Search, place: int, left: Sequence[Shape]) -> NamedEffect:
    term = found.added[place].large
    return named(found, place, left) if term is None else named_large(found, place, term)


def _large_notes(found: Search, model: Model) -> list[str]:
    """What is to be said of large effects."""
    if found.large is None:
        return []
    note = map_note(found.estimate.model.effects[len(model.effects) :], model)
    return [] if note is None else [note]


def _separating(effects: Sequence[NamedEffect], vocabulary: Mapping[str, Effect], logs: Sequence[Log]) -> str | None:
    """The motion that would tell effects from their alternatives; None where none has any."""
    if not any(effect.alternatives for effect in effects):
        return None
    names = sorted({name for effect in effects for name in (effect.name, *effect.alternatives)})
    return separating(names, vocabulary, logs)


def _ledger(found: Search, measured: Measured) -> list[Step]:
    """What was added, with the gaps without and with it, then what was refused."""
    given, confirm = measured.given, measured.confirm
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
