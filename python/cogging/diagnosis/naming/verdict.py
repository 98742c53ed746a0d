"""The verdict: named, ambiguous, unlisted or no gap, and what no effect explains."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import replace
from typing import Any

from cogging.diagnosis.entries import Gap, NamedEffect
from cogging.diagnosis.naming.effect_range import where_of
from cogging.diagnosis.predictable import Predicted
from cogging.diagnosis.residual.bursts import bursts, variance_jumps
from cogging.diagnosis.residual.events import with_events
from cogging.diagnosis.residual.location_words import shape_text
from cogging.diagnosis.residual.shape import FRICTION_INTERVALS, JUMPS, Shape
from cogging.diagnosis.residual.shapes import shapes
from cogging.diagnosis.search.state import Search
from cogging.diagnosis.thresholds import NAME, VERDICT


def unlisted(found: Search, effects: Sequence[NamedEffect], *, checked: bool) -> dict[str, Any] | None:
    """What no effect explains: a residual shape, significant on these logs and in the same coordinate on the others.

    Or what an effect was taken for that hardly anybody would bet on, where a force of any shape explains more.
    """
    others: dict[str, Shape] = {}
    factor = VERDICT.weakened if found.evidence.rounding > VERDICT.rounding else 1.0
    if found.confirm_evidence is not None:
        again = with_events(found.confirm_evidence, shapes(found.confirm_evidence, plain=True))
        others = {shape.coordinate: weakened(shape, factor) for shape in again}
    for shape in found.residual_shapes:
        confirmed = standing(weakened(shape, factor), others.get(shape.coordinate), checked)
        if confirmed is not None:
            return _entry(shape, confirmed)
    if JUMPS in others and others[JUMPS].log_p_value < VERDICT.jump:
        return _entry(others[JUMPS], True) | {"shape": f"on the other motion, {shape_text(others[JUMPS])}"}
    confidence = {effect.name: effect.confidence for effect in effects}
    for added in found.added:
        if not added.shapes:
            continue
        shape = max(added.shapes, key=lambda one: one.score)
        if confidence[added.finding.name] < VERDICT.doubted and shape.score > added.finding.score + NAME.formless:
            return _entry(shape, None)
    return _bursts(found, checked, factor)


def not_noise(rest: Predicted, gap: Gap) -> dict[str, Any] | None:
    """What is left, where it is neither small beside the command nor noise, and most of it is not what has a name."""
    left = rest.share * gap.after**2
    if (gap.share or 0.0) * math.sqrt(rest.share) < VERDICT.systematic or left < gap.before**2 - gap.after**2:
        return None
    return _entry(rest.shape, None if rest.elsewhere is None else rest.elsewhere > 0.0)


def seen_and_refused(found: Search) -> dict[str, Any]:
    """What stood most out of the noise, where adding what it is most like makes the model worse."""
    place = max(range(len(found.added)), key=lambda one: found.added[one].finding.score)
    strongest = found.added[place].finding
    effect = found.estimate.model.effects[place - len(found.added)]
    coordinate = where_of(effect, found.nominal_evidence)["coordinate"]
    name = strongest.name.replace("_", " ")
    return {
        "coordinate": coordinate,
        "shape": f"something acts along the {coordinate} (T = {strongest.test.statistic:.0f}), most like "
        f"{name}, but the model is worse with that added",
        "share": None,
        "statistic": strongest.test.statistic,
        "confirmed": None,
    }


def weakened(shape: Shape, factor: float) -> Shape:
    """The shape with its log p-value divided by a factor of at least 1."""
    return replace(shape, log_p_value=shape.log_p_value / factor)


def _bursts(found: Search, checked: bool, factor: float) -> dict[str, Any] | None:
    """Noise that comes in bursts: at frequencies of forces on both logs, or so loud that nothing else is."""
    mine = bursts(found.evidence) / factor
    its = bursts(found.confirm_evidence) / factor if found.confirm_evidence is not None else 0.0
    both = max(mine, its) < VERDICT.burst and mine + its < VERDICT.bursts_together
    if not both:
        mine = min(variance_jumps(found.evidence) / factor, mine if not checked and mine < VERDICT.lonely else 0.0)
        if mine > VERDICT.variance:
            return None
    return {
        "coordinate": "time",
        "shape": f"bursts: in some tenths of a second the residual is louder than elsewhere (ln chance {mine:.0f})",
        "share": None,
        "statistic": -2.0 * mine,
        "confirmed": True if both else None,
    }


def _entry(shape: Shape, confirmed: bool | None) -> dict[str, Any]:
    return {
        "coordinate": shape.coordinate,
        "shape": shape_text(shape),
        "places": shape.places.tolist(),
        "force": shape.force.tolist(),
        "deviation": shape.deviation.tolist(),
        "share": shape.share,
        "statistic": shape.test.statistic,
        "confirmed": confirmed,
        "empirical": (
            "readings that jump, by the encoder or the clock; no effect of the vocabulary"
            if shape.coordinate == JUMPS
            else "a force of any shape in this coordinate; no effect of the vocabulary"
        ),
    }


def standing(shape: Shape, other: Shape | None, checked: bool) -> bool | None:
    """Whether the confirm logs (if any were `checked`) show what is left in the same coordinate too.

    None where both together do not show enough of it.
    """
    mine = shape.log_p_value
    its = 0.0 if other is None else other.log_p_value
    if shape.coordinate == JUMPS:
        both = max(mine, its) < VERDICT.again and mine + its < VERDICT.jumps_together
        return its < VERDICT.again if mine < VERDICT.jump or both else None
    if shape.coordinate == FRICTION_INTERVALS:
        both = max(mine, its) < VERDICT.interval and mine + its < VERDICT.intervals_together
        return True if both or (not checked and mine < VERDICT.lonely) else None
    if its < VERDICT.again and mine < VERDICT.again and (mine < VERDICT.left_over or mine + its < VERDICT.together):
        return True
    once = not checked or "time" in shape.coordinate  # what depends on time need not come again
    return False if once and mine < (VERDICT.lonely if checked else VERDICT.left_over) else None


def verdict(effects: Sequence[NamedEffect], residual_shape: dict[str, Any] | None, *, explained: bool = False) -> str:
    """In one word: the contract's verdicts that need a search.

    Where most of a large gap is `explained`, what is left beside it does not name the whole.
    """
    if explained and effects:
        residual_shape = None
    if not effects:
        return "unlisted" if residual_shape else "no_gap"
    if residual_shape is not None and (
        all(e.confidence < VERDICT.sure for e in effects)
        or residual_shape["statistic"] > VERDICT.own_cause * max(e.statistic for e in effects)
    ):
        return "unlisted"
    if any(e.alternatives or e.confidence < VERDICT.sure for e in effects):
        return "ambiguous"
    return "unlisted" if residual_shape is not None else "named"
