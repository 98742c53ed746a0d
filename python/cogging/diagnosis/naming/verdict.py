"""The verdict: named, ambiguous, unlisted or no gap, and what no effect explains."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from typing import Any

from cogging.diagnosis.entries import NamedEffect
from cogging.diagnosis.naming.names import FORMLESS
from cogging.diagnosis.residual.bursts import bursts, variance_jumps
from cogging.diagnosis.residual.events import with_events
from cogging.diagnosis.residual.location_words import shape_text
from cogging.diagnosis.residual.shape import FRICTION_INTERVALS, JUMPS, Shape
from cogging.diagnosis.residual.shapes import shapes
from cogging.diagnosis.search.search import LEFT_OVER
from cogging.diagnosis.search.state import Search

SURE = 0.9  # confidence from which a name is stated
DOUBTED = 0.7  # confidence below which a name does not stand against a better shape without a name
HALF = 0.5  # of the strongest effect: a residual shape that is as strong as that has a cause of its own
AGAIN = -5.0  # log p-value of the same coordinate on the confirm logs
TOGETHER = -26.0  # the same of both at once, where each is below AGAIN
JUMP = -18.0  # the same of readings that jump, on any log: nothing that a model may get wrong does that
JUMPS_TOGETHER = -12.0  # the same of both logs
INTERVAL = -12.0  # the same of intervals of friction: what friction laws differ by comes and goes too
INTERVALS_TOGETHER = -60.0  # the same of both logs
LONELY = -100.0  # log p-value of a shape in time, which other motion need not show
VARIANCE = -80.0  # log p-value of a burst at any frequency; where an encoder is coarse, the noise goes with speed
BURST = -12.0  # the same of bursts: noise has its own
BURSTS_TOGETHER = -60.0  # the same of both logs
ROUNDING = 0.07  # of the residual's power, from which the encoder's rounding is no white noise beside other noise:
WEAKENED = 2.0  # what is left must then stand out by as many times the log p-value


def unlisted(found: Search, effects: Sequence[NamedEffect], *, checked: bool) -> dict[str, Any] | None:
    """What no effect explains: a residual shape, significant on these logs and in the same coordinate on the others.

    Or what an effect was taken for that hardly anybody would bet on, where a force of any shape explains more.
    """
    others: dict[str, Shape] = {}
    factor = WEAKENED if found.evidence.rounding > ROUNDING else 1.0
    if found.confirm_evidence is not None:
        again = with_events(found.confirm_evidence, shapes(found.confirm_evidence, plain=True))
        others = {shape.coordinate: weakened(shape, factor) for shape in again}
    for shape in found.residual_shapes:
        confirmed = standing(weakened(shape, factor), others.get(shape.coordinate), checked)
        if confirmed is not None:
            return _entry(shape, confirmed)
    if JUMPS in others and others[JUMPS].log_p_value < JUMP:
        return _entry(others[JUMPS], True) | {"shape": f"on the other motion, {shape_text(others[JUMPS])}"}
    confidence = {effect.name: effect.confidence for effect in effects}
    for added in found.added:
        shape = max(added.shapes, key=lambda one: one.score)
        if confidence[added.finding.name] < DOUBTED and shape.score > added.finding.score + FORMLESS:
            return _entry(shape, None)
    return _bursts(found, checked, factor)


def weakened(shape: Shape, factor: float) -> Shape:
    """The shape with its log p-value divided by a factor of at least 1."""
    return replace(shape, log_p_value=shape.log_p_value / factor)


def _bursts(found: Search, checked: bool, factor: float) -> dict[str, Any] | None:
    """Noise that comes in bursts: at frequencies of forces on both logs, or so loud that nothing else is."""
    mine = bursts(found.evidence) / factor
    its = bursts(found.confirm_evidence) / factor if found.confirm_evidence is not None else 0.0
    both = max(mine, its) < BURST and mine + its < BURSTS_TOGETHER
    if not both:
        mine = min(variance_jumps(found.evidence) / factor, mine if not checked and mine < LONELY else 0.0)
        if mine > VARIANCE:
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
        both = max(mine, its) < AGAIN and mine + its < JUMPS_TOGETHER
        return its < AGAIN if mine < JUMP or both else None
    if shape.coordinate == FRICTION_INTERVALS:
        both = max(mine, its) < INTERVAL and mine + its < INTERVALS_TOGETHER
        return True if both or (not checked and mine < LONELY) else None
    if its < AGAIN and mine < AGAIN and (mine < LEFT_OVER or mine + its < TOGETHER):
        return True
    once = not checked or "time" in shape.coordinate  # what depends on time need not come again
    return False if once and mine < (LONELY if checked else LEFT_OVER) else None


def verdict(effects: Sequence[NamedEffect], residual_shape: dict[str, Any] | None) -> str:
    """In one word: the contract's verdicts that need a search."""
    if not effects:
        return "unlisted" if residual_shape else "no_gap"
    if residual_shape is not None and (
        all(e.confidence < SURE for e in effects)
        or residual_shape["statistic"] > HALF * max(e.statistic for e in effects)
    ):
        return "unlisted"
    if any(e.alternatives or e.confidence < SURE for e in effects):
        return "ambiguous"
    return "unlisted" if residual_shape is not None else "named"
