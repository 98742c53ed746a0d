"""What is left beside a named effect, where it is the same cause with another law: the name stands, and has a shape."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

from cogging.arrays import FloatArray
from cogging.diagnosis.candidates.forms import Form, form_of
from cogging.diagnosis.candidates.intervals import acts_in_interval
from cogging.diagnosis.entries import ShapeTerm
from cogging.diagnosis.evidence.evidence import Evidence
from cogging.diagnosis.evidence.gather import with_columns
from cogging.diagnosis.evidence.log_p_value import log_survival
from cogging.diagnosis.residual.events import with_events
from cogging.diagnosis.residual.shape import MOMENTS, Shape
from cogging.diagnosis.residual.shapes import best_test, low_power, shapes
from cogging.diagnosis.search.state import Search
from cogging.diagnosis.thresholds import FORM, NAME, VERDICT
from cogging.model.parameters import effect_paths


@dataclass(frozen=True)
class Fitted:
    """A form fitted to what an effect leaves.

    Attributes:
        place: number of the effect among what was added.
        form: where it acts and on what.
        tables: its columns in the given logs. amplitudes: of them.
        score: 2 ln likelihood less what its freedom costs.
        term: what is told of it.
    """

    place: int
    form: Form
    tables: list[FloatArray]
    amplitudes: FloatArray
    score: float
    term: ShapeTerm


def with_shape_terms(found: Search) -> tuple[Search, dict[int, ShapeTerm]]:
    """The search with what other laws of the named effects explain taken out of what is left, and these laws.

    An effect is asked for its form only where something significant is left. The form must stand on the given and the
    confirm logs as any residual shape must (verdict.standing), and take most of what was left in whatever coordinate:
    if a free law of the cause does as well as a free shape anywhere, the cause is the named one.
    """
    terms: dict[int, ShapeTerm] = {}
    while len(terms) < FORM.shaped_max:
        left = left_over(found.residual_shapes)
        if not left:
            break
        tried = [one for place in range(len(found.added)) if place not in terms and (one := _fitted(found, place))]
        best = max(tried, key=lambda one: one.score, default=None)
        again = None if best is None else _freed(found, best)
        if best is None or again is None:
            break
        before, after = (max((one.score for one in some), default=0.0) for some in (left, left_over(again)))
        if after > FORM.left * before:
            break
        terms[best.place] = best.term
        found = _standing(found, best, again)
    return found, terms


def left_over(found: Sequence[Shape]) -> list[Shape]:
    """Of residual shapes those that would speak against the names; what happens at moments has no law."""
    return [one for one in found if one.log_p_value < VERDICT.left_over and one.coordinate not in MOMENTS]


def _fitted(found: Search, place: int) -> Fitted | None:
    """The form of what was added at a place; None where it has none, or the logs do not both show it.

    What acts between two moments need not come again.
    """
    _, effect = effect_paths(found.estimate.model.effects)[-len(found.added) + place]
    evidence = found.evidence
    form = form_of(effect, evidence)
    if form is None:
        return None
    tables = form.tables(evidence)
    test, share = best_test(evidence, tables, [], low_power(evidence))
    if test is None:
        return None
    mine, its = log_survival(test.statistic, test.freedom), 0.0
    if found.confirm_evidence is not None and not acts_in_interval(effect):
        again = found.confirm_evidence.test(found.confirm_evidence.whitened(form.tables(found.confirm_evidence)))
        its = log_survival(found.confirm_evidence.bounded(again), again.freedom) if again.freedom else 0.0
        if max(mine, its) > VERDICT.again or mine + its > VERDICT.together:
            return None
    elif mine > VERDICT.left_over:
        return None
    term = ShapeTerm(
        form.coordinate,
        form.unit,
        form.places.tolist(),
        (-test.amplitudes).tolist(),
        test.deviations.tolist(),
        float(test.statistic),
        share,
        form.patch(-test.amplitudes),
    )
    return Fitted(place, form, tables, test.amplitudes, test.statistic - FORM.cost * test.freedom, term)


def _freed(found: Search, fitted: Fitted) -> list[Shape]:
    """Residual shapes with the columns of a form among what a fit may move."""
    evidence = with_columns(found.evidence, fitted.tables, fitted.amplitudes)
    return with_events(evidence, shapes(evidence, plain=True))


def _standing(found: Search, fitted: Fitted, left: list[Shape]) -> Search:
    """The search with a form among what a fit may move, on all logs, and its effect not doubted for its form."""
    added = list(found.added)
    one = added[fitted.place]
    total = one.finding.score + fitted.score
    added[fitted.place] = replace(one, shapes=[s for s in one.shapes if s.score > total + NAME.formless])
    confirm = None if found.confirm_evidence is None else _on(found.confirm_evidence, fitted)
    evidence = with_columns(found.evidence, fitted.tables, fitted.amplitudes)
    return replace(found, added=added, evidence=evidence, confirm_evidence=confirm, residual_shapes=left)


def _on(confirm: Evidence, fitted: Fitted) -> Evidence:
    return with_columns(confirm, fitted.form.tables(confirm), fitted.amplitudes)
