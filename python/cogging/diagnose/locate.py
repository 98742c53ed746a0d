"""Where a gap sits, in words and ranges."""

from __future__ import annotations

from typing import Any

import numpy as np

from cogging.diagnose.evidence import Evidence
from cogging.diagnose.rest import Shape


def describe(shape: Shape) -> str:
    """One line: coordinate, share of the gap, and the ranges in which the force differs from zero by 3 sigma."""
    m = len(shape.places)
    parts = []
    halves = [("", slice(0, len(shape.force)))]
    if len(shape.force) == 2 * m:
        halves = [("forward ", slice(0, m)), ("backward ", slice(m, 2 * m))]
    for label, half in halves:
        force, deviation = shape.force[half], shape.deviation[half]
        if len(force) != m:
            continue
        strong = np.abs(force) > 3.0 * np.where(deviation > 0, deviation, np.inf)
        if not strong.any():
            continue
        peak = int(np.argmax(np.abs(force) * strong))
        first = last = peak
        while first > 0 and strong[first - 1] and force[first - 1] * force[peak] > 0:
            first -= 1
        while last + 1 < m and strong[last + 1] and force[last + 1] * force[peak] > 0:
            last += 1
        parts.append(
            f"{label}{force[peak]:+.3g} V near {shape.places[peak]:.3g} {shape.unit} "
            f"({shape.places[first]:.3g} to {shape.places[last]:.3g})"
        )
    text = "; ".join(parts) or "spread over its whole range"
    return f"{shape.coordinate}: {100 * shape.share:.0f} % of the gap (ln chance {shape.log_chance:.0f}): {text}"


def where_of(effect: Any, evidence: Evidence) -> dict[str, Any]:
    """Coordinate and range of an effect: where it makes 90 % of its force, or the coordinate of what it acts on."""
    hooks = effect.HOOKS
    source = evidence.sources[0]
    along = source.along
    if "force" in hooks or "friction_level" in hooks:
        where = {"position": along.middle_position, "velocity": along.middle_velocity, "time": source.log.time}
        resolved = effect
        if hasattr(effect, "resolved"):
            try:
                resolved = effect.resolved(evidence.model.axis, evidence.model.cogging)
            except (ValueError, TypeError):
                resolved = effect
        law = resolved.force_at if "force" in hooks else resolved.friction_level_at
        time = source.log.time - source.log.time[0]
        force = np.abs(np.asarray(law(position=along.middle_position, velocity=along.middle_velocity, time=time)))
        force = force * source.counts
        if force.sum() > 0:
            # The coordinate whose range holds the force most tightly, against how the rows spread over it.
            best, tightest = ("position", [0.0, 0.0]), np.inf
            for name, values in where.items():
                values = values - (source.log.time[0] if name == "time" else 0.0)
                order = np.argsort(values)
                heap = np.cumsum(force[order]) / force.sum()
                rows = np.cumsum(source.counts[order]) / source.counts.sum()
                low, high = int(np.searchsorted(heap, 0.05)), min(int(np.searchsorted(heap, 0.95)), len(order) - 1)
                tight = rows[high] - rows[low]
                if tight < tightest - 0.02:
                    tightest = tight
                    best = (name, [float(values[order[low]]), float(values[order[high]])])
            return {"coordinate": best[0], "range": best[1]}
    if "reading" in hooks:
        return {"coordinate": "position", "range": [float(along.position.min()), float(along.position.max())]}
    if "command_gain" in hooks or "shape_command" in hooks:
        return {"coordinate": "command", "range": [float(source.log.command.min()), float(source.log.command.max())]}
    if "state" in hooks:
        return {"coordinate": "velocity", "range": [-source.rest, source.rest]}
    return {"coordinate": "frequency", "range": [10.0, 0.5 / source.scales.sample_time]}
