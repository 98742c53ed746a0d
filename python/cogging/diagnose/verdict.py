"""The verdict: named, ambiguous, unlisted or no gap, and what no effect explains."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

from cogging.diagnose.location_words import shape_text
from cogging.diagnose.naming import FORMLESS
from cogging.diagnose.rest import Shape, shapes, variance_jumps
from cogging.diagnose.result import NamedEffect
from cogging.diagnose.search import Search

SURE = 0.9  # confidence from which a name is stated
DOUBTED = 0.7  # confidence below which a name does not stand against a better shape without a name
HALF = 0.5  # of the strongest effect: a rest that is as strong as that has a cause of its own
AGAIN = -5.0  # ln of the chance of the same coordinate on the confirm logs
LONELY = -40.0  # ln of the chance of a shape in time, which other motion need not show
VARIANCE = -80.0  # ln of the chance of a burst; where an encoder is coarse, the noise goes with speed


def unlisted(found: Search, effects: Sequence[NamedEffect], left: Sequence[Shape]) -> dict[str, Any] | None:
    """What no effect explains: a rest that is significant on these logs, and in the same coordinate on the others.

    Or what an effect was taken for that hardly anybody would bet on, where a force of any shape explains more.
    """
    others = shapes(found.confirm_evidence) if left and found.confirm_evidence is not None else []
    for shape in left:
        again = _on_others(others, shape)
        if again or (again is None and (found.confirm_evidence is None or shape.log_chance < LONELY)):
            return _entry(shape, bool(again))
    confidence = {effect.name: effect.confidence for effect in effects}
    for added in found.added:
        shape = max(added.shapes, key=lambda one: one.score)
        if confidence[added.finding.name] < DOUBTED and shape.score > added.finding.score + FORMLESS:
            return _entry(shape, None)
    burst = variance_jumps(found.evidence)
    if burst > VARIANCE:
        return None
    return {
        "coordinate": "time",
        "shape": f"bursts: the residual's power jumps (ln chance {burst:.0f})",
        "share": None,
        "statistic": -2.0 * burst,
        "confirmed": None,
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
        "empirical": "a force of any shape in this coordinate; no effect of the vocabulary",
    }


def _on_others(others: Sequence[Shape], shape: Shape) -> bool | None:
    """Whether the same coordinate is significant on the confirm logs too; None where they cannot tell."""
    for other in others:
        if other.coordinate == shape.coordinate:
            if other.log_chance < AGAIN:
                return True
            return False if "time" not in shape.coordinate else None
    return None


def verdict(effects: Sequence[NamedEffect], rest: dict[str, Any] | None) -> str:
    """In one word: the contract's verdicts that need a search."""
    if not effects:
        return "unlisted" if rest else "no_gap"
    if rest is not None and (
        all(e.confidence < SURE for e in effects) or rest["statistic"] > HALF * max(e.statistic for e in effects)
    ):
        return "unlisted"
    if any(e.alternatives or e.confidence < SURE for e in effects):
        return "ambiguous"
    return "unlisted" if rest is not None else "named"
