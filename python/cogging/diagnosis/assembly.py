"""From a search to a result: the models with their gaps, the names, the verdict and what was tried."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from cogging.diagnosis.discrepancy import Discrepancy, discrepancies, floor_of, follows, source_of
from cogging.diagnosis.entries import Gap, NamedEffect, Step
from cogging.diagnosis.evidence.preparation import Prepared
from cogging.diagnosis.evidence.running_controller import obeys
from cogging.diagnosis.experiment.separating import separating
from cogging.diagnosis.limits import limits
from cogging.diagnosis.locate import location_of
from cogging.diagnosis.location import Location
from cogging.diagnosis.naming.level_changes import CHANGED, changes, look_alikes
from cogging.diagnosis.naming.masking import masking_notes
from cogging.diagnosis.naming.names import changed, merged, named
from cogging.diagnosis.naming.verdict import unlisted, verdict
from cogging.diagnosis.patched import with_intervals
from cogging.diagnosis.residual.location_words import shape_text
from cogging.diagnosis.residual.shape import FRICTION_INTERVALS
from cogging.diagnosis.result import Diagnosis
from cogging.diagnosis.search.empirical import NoTerm, with_term
from cogging.diagnosis.search.levels import with_levels
from cogging.diagnosis.search.placebo import placebos
from cogging.diagnosis.search.search import LEFT_OVER
from cogging.diagnosis.search.state import Added, Search
from cogging.effects.effect import Effect
from cogging.estimation.statistics import moving_average
from cogging.logs.log import Log
from cogging.model.model import Model
from cogging.model.parameters import parameters_of, with_values

WHERE = -7.0  # log p-value below which a coordinate is told


def assemble(found: Search, logs: Prepared, model: Model, replay: bool) -> Diagnosis:
    """The result of a search.

    Args:
        found: the search.
        logs: logs that it saw.
        model: given model, with the controller that was running.
        replay: whether the loop can be replayed.
    """
    beyond = [change for change in changes(found, model) if abs(change[3]) > CHANGED]
    retuned, final = file_form(found.tuned, model), with_intervals(file_form(last_model(found), model), found.estimate)
    nominal = _as_stated(found, retuned, model, [f"axis.{change[0]}" for change in beyond])
    models = [nominal, *(file_form(added.model, model) for added in found.added[:-1]), final]
    measured = measure(logs, models, found.nominal.model, replay=replay)
    effects = _effects(found, model, beyond)
    residual_shape = unlisted(found, effects, checked=bool(logs.confirm))
    location = location_of(found.nominal_evidence, found.nominal.model, found.nominal_shapes)
    return Diagnosis(
        verdict=verdict(effects, residual_shape),
        effects=tuple(effects),
        unlisted=residual_shape,
        gap=_gap(measured, logs.given, final),
        separating_experiment=_separating(effects, found.vocabulary, logs.given),
        model=final,
        nominal=nominal,
        location=location,
        where_text=tuple(shape_text(shape) for shape in location.shapes if shape.log_p_value < WHERE),
        ledger=tuple(_ledger(found, measured)),
        notes=(*logs.notes, *masking_notes(retuned, final), *measured.notes),
        placebo=placebos(found),
        series=_series(logs.given, measured.given, location) | {"given": model},
        vocabulary=found.vocabulary,
        limits=limits(found, model, bool(logs.confirm)),
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
    """

    given: list[Discrepancy]
    confirm: list[Discrepancy] | None
    notes: tuple[str, ...]


def measure(logs: Prepared, models: Sequence[Model], fitted: Model, *, replay: bool) -> Measured:
    """Measure the gaps of models, the last of which is the final one, by the replayed loop where it follows the logs.

    Args:
        logs: given and confirm logs.
        models: models whose gaps are measured.
        fitted: model whose controller the confirm logs must obey to be replayed.
        replay: whether the loop can be replayed on the given logs.
    """
    notes = []
    given = discrepancies(logs.given, models, replay=replay)
    if replay and not follows(given[-1], logs.given, models[-1]):
        replay = False
        given = discrepancies(logs.given, models, replay=False)
        notes.append("the replayed loop does not follow the log closely enough to measure with: friction at reversals")
    loops = replay and all(obeys(log, fitted) for log in logs.confirm)
    confirm = discrepancies(logs.confirm, models, replay=loops) if logs.confirm else None
    if confirm and loops is not replay:
        notes.append("a confirm log does not obey the controller: its gap is that of an observer's innovations")
    return Measured(given, confirm, tuple(notes))


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
            np.gradient(moving_average(velocity, round(0.02 / float(np.median(np.diff(log.time))))), log.time)
            for velocity, log in zip(velocities, logs, strict=True)
        ],
        "command": [log.command - (gap if replayed else 0.0) for log, gap in zip(logs, before.series, strict=True)],
    }


# Effects --------------------------------------------------------------------------------------------------------------


def _effects(found: Search, model: Model, beyond: Sequence[tuple[str, float, float, float]]) -> list[NamedEffect]:
    """What was added, by name, and what of mass and friction has changed."""
    left = [
        shape
        for shape in found.residual_shapes
        if shape.log_p_value < LEFT_OVER and shape.coordinate != FRICTION_INTERVALS
    ]
    effects = merged([named(found, place, left) for place in range(len(found.added))])
    return effects + [changed(change, look_alikes(found, model, change[0]), left) for change in beyond]


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
