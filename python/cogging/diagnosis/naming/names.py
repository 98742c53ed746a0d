"""What was added to a model, as entries of the result: names, alternatives, confidence and intervals."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from typing import Any

import numpy as np

from cogging.diagnosis.candidates.findings import Finding
from cogging.diagnosis.candidates.movable import conditional_paths, effect_parameters
from cogging.diagnosis.candidates.signatures import known_periods
from cogging.diagnosis.candidates.waves import is_wave
from cogging.diagnosis.entries import NamedEffect, ShapeTerm, Value
from cogging.diagnosis.naming.effect_range import where_of
from cogging.diagnosis.residual.shape import Shape
from cogging.diagnosis.search.choice import alike
from cogging.diagnosis.search.state import Added, Search
from cogging.diagnosis.thresholds import CHOICE, CONFIRMATION, NAME, PARAMETER_CHANGE, SEARCH
from cogging.estimation.gauss_newton import Estimate
from cogging.model.parameters import effect_paths, parameters_of


def named(found: Search, place: int, residual_shapes: Sequence[Shape]) -> NamedEffect:
    """The effect that was added at a place, with its alternatives; `residual_shapes`: of what no effect explains."""
    added = found.added[place]
    best = added.rivals[0]
    # What explains nearly the same rows is told apart by how well its form is known, not by noise alone.
    rivals = [r for r in added.rivals[1:] if r.score > best.score - margin(best, r) or unresolved(best, r, found)]
    prefix, effect = effect_paths(found.estimate.model.effects)[-len(found.added) + place]
    odds = sum(float(np.exp(0.5 * (r.score - best.score))) for r in added.rivals[1:])
    confidence = _confidence(added, odds, bool(residual_shapes) or unexplained(found))
    others = fully_named(found, place)
    return NamedEffect(
        effect.NAME,
        tuple(dict.fromkeys([*(r.name for r in rivals), *others])),
        round(NAME.if_full_name * confidence, 3) if others else confidence,
        values_of(found.estimate, prefix, effect),
        where_of(effect, found.evidence),
        added.finding.test.statistic,
        added.finding.log_p_value,
        apart={r.name: sigmas_apart(best, r) for r in reversed(rivals)},
        differs={r.name: difference(best, r) for r in reversed(rivals)},
    )


def sigmas_apart(best: Finding, rival: Finding) -> float:
    """Standard deviations by which logs tell a finding from a rival: the root of what their score tests differ by."""
    return round(float(np.sqrt(max(best.test.statistic - rival.test.statistic, 0.0))), 3)


def difference(best: Finding, rival: Finding) -> float:
    """What a finding and a rival do differently along the logs, nuisances re-tuned, over what the finding does; rms."""
    mine, its = best.test.explained, rival.test.explained
    size = float(np.linalg.norm(mine))
    return float(np.linalg.norm(mine - its)) / size if size > 0.0 else 0.0


def values_of(estimate: Estimate, prefix: str, effect: Any) -> dict[str, Value]:
    """The parameters of an effect in a fitted model, with intervals of those that the fit can tell."""
    known = parameters_of(estimate.model)
    free = set(effect_parameters(estimate.model)) - conditional_paths(estimate.model)
    halves = {
        path: float(half)
        for path, half in zip(estimate.paths, estimate.half_width, strict=True)
        if path in free and not np.isnan(half)
    }
    values: dict[str, Value] = {}
    for name, (unit, _) in effect.FIELDS.items():
        paths = [p for p in known if p == f"{prefix}.{name}" or p.startswith(f"{prefix}.{name}[")]
        if effect.ROLES[name]["role"] == "setting" or not paths:
            continue
        numbers = [known[p].value for p in paths]
        low = [known[p].value - halves[p] if p in halves else None for p in paths]
        high = [known[p].value + halves[p] if p in halves else None for p in paths]
        if isinstance(getattr(effect, name), list):
            values[name] = Value(numbers, unit, (low, high))
        else:
            values[name] = Value(numbers[0], unit, (low[0], high[0]))
    return values


def fully_named(found: Search, place: int) -> list[str]:
    """For a wave, other waves of which as many terms were added as one name may have: it may be a further one of those.

    A triangular error of an encoder, say, has more harmonics than that.
    """
    names = [added.finding.name for added in found.added]
    if not is_wave(found.vocabulary[names[place]]):
        return []
    others = [name for name in names if name != names[place] and is_wave(found.vocabulary[name])]
    return [name for name in dict.fromkeys(others) if others.count(name) >= SEARCH.harmonics_max]


def margin(best: Finding, rival: Finding) -> float:
    """Of the score, within which a rival is an alternative: more where it explains nearly the same rows."""
    return (
        max(NAME.alike_margin, CHOICE.form * best.test.statistic)
        if alike(rival, best) > NAME.nearly_same_rows
        else SEARCH.rival
    )


def unresolved(best: Finding, rival: Finding, found: Search) -> bool:
    """Whether the logs are too short to tell a wave's period from one that the model knows, in which a rival changes.

    What an amplitude that changes along the travel leaves of a known period is a wave of nearly that period.
    """
    period, known = best.candidate.period, rival.candidate.period
    if (
        period is None
        or known not in known_periods(found.nominal.model)
        or rival.test.statistic < NAME.unresolved_share * best.test.statistic
    ):
        return False
    return bool(abs(1.0 / period - 1.0 / known) * found.evidence.scales.position < NAME.turns_apart)


def unexplained(found: Search) -> bool:
    """Whether more was refused than was added: what explains most of these logs is then no effect as it is listed."""
    named = max(added.finding.test.statistic for added in found.added)
    return any(one.log_p_value < NAME.refused_strong and one.test.statistic > named for one in found.unused)


def _confidence(added: Added, odds: float, shapes_left: bool) -> float:
    """The stated chance that a name is right: odds against the rivals, less what else speaks against it."""
    chance = 1.0 / (1.0 + odds)
    check = added.confirmation
    if check is None:
        chance *= NAME.if_unconfirmed
    elif check.noncentrality < CONFIRMATION.informative:
        chance *= NAME.if_uninformed
    elif abs(check.ratio - 1.0) > NAME.ratio_doubted * check.deviation:
        chance *= NAME.if_ratio_doubted
    # A generic shape that explains more than the named effect does: its form is not quite that.
    generic = max((shape.score for shape in added.shapes), default=0.0)
    if generic > added.finding.score + NAME.formless:
        chance *= NAME.if_formless
    if shapes_left:
        chance *= NAME.if_shapes_left
    if added.or_map:
        chance *= NAME.if_map
    if added.finding.test.statistic < NAME.weak:
        chance *= NAME.if_weak
    return round(float(np.clip(NAME.surest * chance, NAME.least_sure, NAME.surest)), 3)


def with_term_of(effect: NamedEffect, term: ShapeTerm | None) -> NamedEffect:
    """The effect with the law that it has beside the plainest; as it is where that is none."""
    if term is None:
        return effect
    return replace(effect, shape_term=term, confidence=round(NAME.if_other_shape * effect.confidence, 3))


def merged(effects: Sequence[NamedEffect]) -> list[NamedEffect]:
    """One entry a name: several harmonics are one cause. The strongest speaks; the others stand in `further`."""
    result: list[NamedEffect] = []
    for effect in effects:
        for i, known in enumerate(result):
            if known.name == effect.name:
                first, second = (known, effect) if known.statistic >= effect.statistic else (effect, known)
                term = first.shape_term or second.shape_term
                result[i] = replace(first, further=(*known.further, second.parameters), shape_term=term)
                break
        else:
            result.append(effect)
    return result


def changed(
    change: tuple[str, float, float, float], alternatives: tuple[str, ...], residual_shapes: Sequence[Shape]
) -> NamedEffect:
    """Mass, viscous or Coulomb friction beyond what the model states (parameter_changes.changes), as an effect."""
    name, size, half, beyond = change
    confidence = (
        PARAMETER_CHANGE.sure_of_change
        if abs(beyond) > PARAMETER_CHANGE.change_clear
        else PARAMETER_CHANGE.less_sure_of_change
    )
    if residual_shapes:
        confidence *= PARAMETER_CHANGE.if_shapes_left_too
    value = Value(size, "1", (size - half, size + half))
    return NamedEffect(
        f"{name}_change",
        alternatives,
        round(confidence, 3),
        {"change": value},
        {"coordinate": {"mass": "acceleration"}.get(name, "velocity"), "range": None},
        beyond**2,
        -0.5 * beyond**2,
    )
