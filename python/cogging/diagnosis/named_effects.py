"""Entries of a result: named effects with parameters, confidence and place, and the unlisted force."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace
from typing import Any

import numpy as np

from cogging.arrays import FloatArray
from cogging.diagnosis.balance.decision import NAMELESS
from cogging.diagnosis.balance.evidence import LARGELY, Evidence
from cogging.diagnosis.entries import SURE, Gap, NamedEffect, Value
from cogging.diagnosis.generic_force import Predicted
from cogging.diagnosis.patched_model import Term
from cogging.diagnosis.places import COORDINATE_UNITS, Shape, ranges, shape_text
from cogging.effects.effect import laws_of
from cogging.model.model import Model
from cogging.model.parameters import effect_paths
from cogging.model.units import Units

NOT_SURE = 0.89  # highest confidence of an effect beside a force without a name
HELD_OUT = 0.5  # highest confidence of an effect that is not in the model
RELIABLE = 0.92  # share of right names among those with a probability of at least 0.98, drawn logs: docs/evidence.md
RELIABLE_BESIDE = 0.89  # the same where a model lacks most of the command, beside other likely names
RELIABLE_MINOR, MINOR_SHARE = 0.5, 0.1  # the same of those that take less than this share of the gap
SEEN = 0.02  # of the remaining power: minimum share of a curve that is reported
SYSTEMATIC = 0.1  # of the rms command: smaller predictable forces are negligible
TAILS = (0.05, 0.95)  # quantiles of an effect's force that limit its range
TIGHTER = 0.02  # of the rows: minimum improvement of the range by another coordinate
DYNAMIC = 10.0  # Hz: lowest frequency at which a delay, a lag or a mode shows
#: Coordinate of a generic force, by a word of its name.
ALONG = {"speed": "velocity", "travel": "position", "wave": "position", "time": "time", "command": "command"}


def named(
    terms: Sequence[Term], final: Model, evidence: Evidence, shares: Sequence[float | None], held_out: Mapping[int, str]
) -> list[NamedEffect]:
    """Return the named effects in the order of their forces; terms of one name are one effect.

    Args:
        terms: accepted terms.
        final: patched model.
        evidence: evidence of the given logs with the accepted terms.
        shares: share of the gap's power that each term explains.
        held_out: reason why a term is not in the model, by index.
    """
    kept = [term.accepted for place, term in enumerate(terms) if place not in held_out]
    several = evidence.plainly and len({one.found.name for one in kept if one.share >= SURE}) > 1
    taken: dict[str, float] = {}
    for term, share in zip(terms, shares, strict=True):
        taken[term.accepted.found.name] = taken.get(term.accepted.found.name, 0.0) + (share or 0.0)
    unnamed = any(term.accepted.found.name.startswith("~") for term in weighty(terms))
    effects: dict[str, NamedEffect] = {}
    by_size: dict[str, list[tuple[float, dict[str, Value]]]] = {}
    for place, (term, share) in enumerate(zip(terms, shares, strict=True)):
        name = term.accepted.found.name
        if name.startswith("~"):
            continue
        parameters = _parameters(term, final, evidence, place in held_out)
        roles = {} if term.effect is None else term.effect.ROLES
        sizes = [parameters[q].value for q in roles if roles[q]["role"] == "amplitude" and q in parameters]
        by_size.setdefault(name, []).append((float(np.linalg.norm(np.hstack([0.0, *sizes]))), parameters))
        one = term.accepted
        others = dict.fromkeys([*(other for other, _ in one.alternatives), *one.found.others])
        beside = RELIABLE_BESIDE if taken[name] > MINOR_SHARE else RELIABLE_MINOR
        confidence = (beside if several else RELIABLE) * one.share * one.found.likeness
        other = term.effect is None and term.accepted.found.columns is not None
        entry = NamedEffect(
            name,
            tuple(other for other in others if not other.startswith("~") and other != name),
            min(confidence, HELD_OUT if place in held_out else NOT_SURE if unnamed else 1.0),
            parameters,
            _where(term, evidence),
            float(term.accepted.score),
            share=share,
            shape="other" if other else "",
            curve=term.curve,
            in_model=place not in held_out and (not other or term.path != ""),
        )
        if name in effects:  # keep the confidence of the largest term
            first = effects[name]
            largest = max(first, entry, key=lambda one: one.statistic)
            both = (first.share or 0.0) + share if share is not None else first.share
            entry = replace(largest, share=both)
        effects[name] = entry
    for name, entry in effects.items():
        ordered = [one for _, one in sorted(by_size[name], key=lambda pair: -pair[0])]
        effects[name] = replace(entry, parameters=ordered[0], further=tuple(ordered[1:]))
    power = {name: sum(t.force**2 for t in terms if t.accepted.found.name == name) for name in effects}
    return sorted(effects.values(), key=lambda one: -power[one.name])


def weighty(terms: Sequence[Term]) -> list[Term]:
    """Return the terms without minor generic forces, which a slightly wrong law of a named effect leaves."""
    most = max((t.force for t in terms if not t.accepted.found.name.startswith("~")), default=0.0)
    return [t for t in terms if not t.accepted.found.name.startswith("~") or t.force > NAMELESS * most]


def _parameters(term: Term, final: Model, evidence: Evidence, held_out: bool) -> dict[str, Value]:
    """Return values and intervals by field; for a change of the axis, new / old - 1."""
    units = final.units
    if term.accepted.found.columns is None:
        name = term.path.removeprefix("axis.")
        old = float(getattr(evidence.given.axis, name))
        new = float(getattr(evidence.model.axis if held_out else final.axis, name))
        low, high = final.intervals.get(term.path, (np.nan, np.nan))
        if old <= 0.0:
            return {}
        return {"change": Value(new / old - 1.0, "1", _ends(low / old - 1.0, high / old - 1.0))}
    if term.effect is None:
        return {}
    effect, known = term.effect, dict(effect_paths(final.effects))
    if not held_out:
        effect = known.get(term.path, effect)
    values = {}
    for field, role in effect.ROLES.items():
        if role["role"] == "setting":
            continue
        value, unit = getattr(effect, field), units.of(effect.FIELDS[field][0])
        none = (np.nan, np.nan)
        if isinstance(value, list):
            ends = [final.intervals.get(f"{term.path}.{field}[{k}]", none) for k in range(len(value))]
            pairs = [_ends(*one) for one in ends]
            values[field] = Value([float(v) for v in value], unit, ([p[0] for p in pairs], [p[1] for p in pairs]))
        else:
            values[field] = Value(float(value), unit, _ends(*final.intervals.get(f"{term.path}.{field}", none)))
    return values


def _ends(low: float, high: float) -> tuple[float | None, float | None]:
    """Return the ends of an interval, or None for both if it is not finite."""
    return (float(low), float(high)) if np.isfinite(high - low) else (None, None)


# Where an effect acts -------------------------------------------------------------------------------------------------


def _where(term: Term, evidence: Evidence) -> dict[str, Any]:
    """Return coordinate and range of a term: of 90 % of its force, or of the quantity that it acts on."""
    effect, motion = term.effect, _motion(evidence)
    hooks = set() if effect is None else set(effect.HOOKS)
    if effect is not None and {"force", "friction_level", "command_gain"} & hooks:
        law = laws_of(effect.resolved(evidence.model.axis, evidence.model.cogging))
        rows = {name: motion[name] for name in ("position", "velocity", "time")}
        if {"force", "friction_level"} & hooks:
            return _held_by(law.force_at if "force" in hooks else law.friction_level_at, rows)
        return _held_by(law.gain_at, {name: rows[name] for name in ("position", "time")})
    if effect is None and term.accepted.found.columns is None:
        name = "acceleration" if term.path == "axis.mass" else "velocity"
    elif effect is None:
        name = "position" if term.curve is None else str(term.curve["coordinate"])
    elif {"reading", "shape_command"} & hooks:
        name = "position" if "reading" in hooks else "command"
    elif "state" in hooks:
        slow = evidence.model.axis.coulomb_width
        return {"coordinate": "velocity", "range": [-slow, slow]}
    else:
        fastest = 0.5 / float(np.median(np.diff(evidence.balances[0].log.time)))
        return {"coordinate": "frequency", "range": [DYNAMIC, fastest]}
    return {"coordinate": name, "range": [float(motion[name].min()), float(motion[name].max())]}


def _motion(evidence: Evidence) -> dict[str, FloatArray]:
    """Return the coordinates of the rows in motion of the longest log."""
    b = max(evidence.balances, key=lambda one: len(one.time))
    names = ("position", "velocity", "acceleration", "time", "command")
    return {name: getattr(b, name)[b.keep > 0] for name in names}


def _held_by(law: Callable[..., Any], rows: Mapping[str, FloatArray]) -> dict[str, Any]:
    """Return the coordinate of a law, and its range, in which its force is most concentrated."""
    whole = np.asarray(law(**rows)) * np.ones(len(rows["position"]))
    depends = []
    for name, values in rows.items():
        for held in (float(np.median(values)), float(np.min(values))):
            if np.max(np.abs(law(**{**rows, name: np.full_like(values, held)}) - whole)) > TIGHTER * np.ptp(whole):
                depends.append(name)
                break
    force = np.abs(whole) if np.any(whole) else np.ones(len(whole))
    best, tightest = {}, np.inf
    for name in depends or ["position"]:
        order = np.argsort(rows[name])
        heap = np.cumsum(force[order]) / force.sum()
        low, high = (min(int(np.searchsorted(heap, tail)), len(order) - 1) for tail in TAILS)
        if (high - low) / len(order) < tightest - TIGHTER:
            tightest = (high - low) / len(order)
            best = {"coordinate": name, "range": [float(rows[name][order[low]]), float(rows[name][order[high]])]}
    return best


# Unlisted force -------------------------------------------------------------------------------------------------------


def unlisted(
    terms: Sequence[Term], rest: Predicted, gap: Gap, units: Units, *, confirmed: bool
) -> dict[str, Any] | None:
    """Return the force that no effect explains: an accepted generic force or a large predictable gap; None if neither.

    Args:
        terms: accepted terms.
        rest: prediction of the remaining gap by a generic force.
        gap: gap before and after.
        units: labels.
        confirmed: whether confirm logs took part in the acceptance of the terms.
    """
    for term in weighty(terms):
        cell = term.accepted.found
        if cell.name.startswith("~"):
            words = cell.name[1:]
            coordinate = next((along for word, along in ALONG.items() if word in words), "position")
            where = cell.label if cell.period is None else f"period {cell.period:.4g} {units.of('m')}"
            entry: dict[str, Any] = {
                "coordinate": coordinate,
                "shape": f"{words}{f' ({where})' if where else ''}, which no known effect describes",
                "share": None,
            }
            if term.curve is not None:
                places, force = np.array(term.curve["places"]), np.array(term.curve["force"])
                coordinate = str(term.curve["coordinate"])
                small = 0.05 * np.abs(force).max() * np.ones(len(force))
                shape = Shape(coordinate, COORDINATE_UNITS[coordinate], places, force, small, 0.0, 0.0, 0.0)
                entry |= {"coordinate": coordinate, "shape": f"{words}: {ranges(shape, units)}"}
                entry |= {"places": term.curve["places"], "force": term.curve["force"]}
            elif rest.curves[0].share > SEEN:
                curve = rest.curves[0]
                entry |= {"coordinate": curve.coordinate, "share": curve.share}
                entry |= {"places": curve.places.tolist(), "force": curve.force.tolist()}
            return entry | {"statistic": float(term.accepted.score), "confirmed": confirmed or None}
    share, of_command = rest.share, gap.share or 0.0
    if of_command > LARGELY:  # no noise, though what fits one part of the motion does not predict another
        share = max(share, 1.0 - (gap.floor / gap.after) ** 2)
    left = share * gap.after**2
    systematic = of_command * np.sqrt(share)
    if systematic < SYSTEMATIC or (systematic < LARGELY and left < gap.before**2 - gap.after**2):
        return None
    curve = rest.curves[0]
    return {
        "coordinate": curve.coordinate,
        "shape": shape_text(curve, units),
        "share": curve.share,
        "places": curve.places.tolist(),
        "force": curve.force.tolist(),
        "deviation": curve.deviation.tolist(),
        "statistic": None,
        "confirmed": None if rest.elsewhere is None else rest.elsewhere > 0.0,
    }


def final_verdict(effects: Sequence[NamedEffect], rest: Mapping[str, Any] | None) -> str:
    """Return the verdict of a search: unlisted, no_gap, named or ambiguous."""
    if rest is not None:
        return "unlisted"
    if not effects:
        return "no_gap"
    return "named" if all(effect.is_sure for effect in effects) else "ambiguous"
