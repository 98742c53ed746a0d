"""Where a found effect acts: the coordinate that its law is a function of, and the range that holds most of it."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import Any

import numpy as np

from cogging.arrays import FloatArray
from cogging.diagnosis.evidence.evidence import Evidence
from cogging.diagnosis.thresholds import PARAMETER_CHANGE
from cogging.effects.effect import Effect, laws_of

COORDINATES = ("position", "velocity", "time")


def where_of(effect: Effect, evidence: Evidence) -> dict[str, Any]:
    """Coordinate and range of an effect: where it makes 90 % of its force, or the coordinate of what it acts on.

    Only coordinates count that its law is a function of: a spring sits along the position, whatever the motion was.
    """
    hooks = effect.HOOKS
    source = evidence.sources[0]
    along = source.along
    resolved = laws_of(effect.resolved(evidence.model.axis, evidence.model.cogging))
    rows = {"position": along.middle_position, "velocity": along.middle_velocity}
    rows["time"] = source.log.time - source.log.time[0]
    if "force" in hooks or "friction_level" in hooks:
        law = resolved.force_at if "force" in hooks else resolved.friction_level_at
        return _held_by(law, rows, source.mask)
    if "reading" in hooks:
        return {"coordinate": "position", "range": [float(along.position.min()), float(along.position.max())]}
    if "command_gain" in hooks:
        return _held_by(resolved.gain_at, {name: rows[name] for name in ("position", "time")}, source.mask)
    if "shape_command" in hooks:
        return {"coordinate": "command", "range": [float(source.log.command.min()), float(source.log.command.max())]}
    if "state" in hooks:
        return {"coordinate": "velocity", "range": [-source.rest, source.rest]}
    return {"coordinate": "frequency", "range": [PARAMETER_CHANGE.dynamics_from, 0.5 / source.scales.sample_time]}


def depends_on(law: Callable[..., Any], rows: Mapping[str, FloatArray]) -> list[str]:
    """Of which coordinates a law is a function, as these rows show it: holding one still changes what it gives."""
    whole = np.asarray(law(**rows))
    span = float(np.ptp(whole))
    told = []
    for name, values in rows.items():
        for held in (float(np.median(values)), float(np.min(values))):
            still = np.asarray(law(**{**rows, name: np.full_like(values, held)}))
            if np.max(np.abs(still - whole)) > PARAMETER_CHANGE.range_tighter * span:
                told.append(name)
                break
    return told


def _held_by(law: Callable[..., Any], rows: Mapping[str, FloatArray], mask: FloatArray) -> dict[str, Any]:
    """The coordinate of a law whose range holds its force most tightly; position where it is a function of none."""
    force = np.abs(np.asarray(law(**rows)) * np.ones(len(mask))) * mask
    if not force.sum() > 0:
        force = np.ones(len(mask))  # it pushes in no row that counts: it acts over the whole range
    best: dict[str, Any] = {}
    tightest = np.inf
    for name in depends_on(law, rows) or ["position"]:
        values = np.asarray(rows[name])
        # The coordinate whose range holds the force most tightly, against how the rows spread over it.
        order = np.argsort(values)
        heap = np.cumsum(force[order]) / force.sum()
        counted = np.cumsum(mask[order]) / mask.sum()
        low, high = (min(int(np.searchsorted(heap, tail)), len(order) - 1) for tail in PARAMETER_CHANGE.range_tails)
        tight = counted[high] - counted[low]
        if tight < tightest - PARAMETER_CHANGE.range_tighter:
            tightest = tight
            best = {"coordinate": name, "range": [float(values[order[low]]), float(values[order[high]])]}
    return best
