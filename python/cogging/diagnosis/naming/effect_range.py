"""Where a found effect acts: the coordinate and the range that hold most of its force."""

from __future__ import annotations

from typing import Any

import numpy as np

from cogging.diagnosis.evidence.evidence import Evidence
from cogging.diagnosis.thresholds import PARAMETER_CHANGE
from cogging.effects.effect import Effect, laws_of


def where_of(effect: Effect, evidence: Evidence) -> dict[str, Any]:
    """Coordinate and range of an effect: where it makes 90 % of its force, or the coordinate of what it acts on."""
    hooks = effect.HOOKS
    source = evidence.sources[0]
    along = source.along
    if "force" in hooks or "friction_level" in hooks:
        where = {"position": along.middle_position, "velocity": along.middle_velocity, "time": source.log.time}
        resolved = laws_of(effect.resolved(evidence.model.axis, evidence.model.cogging))
        law = resolved.force_at if "force" in hooks else resolved.friction_level_at
        time = source.log.time - source.log.time[0]
        force = np.abs(np.asarray(law(position=along.middle_position, velocity=along.middle_velocity, time=time)))
        force = force * source.mask
        if force.sum() > 0:
            # The coordinate whose range holds the force most tightly, against how the rows spread over it.
            best, tightest = ("position", [0.0, 0.0]), np.inf
            for name, values in where.items():
                values = values - (source.log.time[0] if name == "time" else 0.0)
                order = np.argsort(values)
                heap = np.cumsum(force[order]) / force.sum()
                rows = np.cumsum(source.mask[order]) / source.mask.sum()
                low, high = (
                    min(int(np.searchsorted(heap, tail)), len(order) - 1) for tail in PARAMETER_CHANGE.range_tails
                )
                tight = rows[high] - rows[low]
                if tight < tightest - PARAMETER_CHANGE.range_tighter:
                    tightest = tight
                    best = (name, [float(values[order[low]]), float(values[order[high]])])
            return {"coordinate": best[0], "range": best[1]}
    if "reading" in hooks:
        return {"coordinate": "position", "range": [float(along.position.min()), float(along.position.max())]}
    if "command_gain" in hooks or "shape_command" in hooks:
        return {"coordinate": "command", "range": [float(source.log.command.min()), float(source.log.command.max())]}
    if "state" in hooks:
        return {"coordinate": "velocity", "range": [-source.rest, source.rest]}
    return {"coordinate": "frequency", "range": [PARAMETER_CHANGE.dynamics_from, 0.5 / source.scales.sample_time]}
