"""Advice on a motion that distinguishes effects, from their hooks and roles."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np

from cogging.effects.effect import Effect
from cogging.logs.log import Log


def separating(names: Sequence[str], vocabulary: Mapping[str, Effect], logs: Sequence[Log]) -> str:
    """Return advice on a motion that distinguishes effects, at most three clauses."""
    laws = [vocabulary[name] for name in names if name in vocabulary]
    kinds = {hook for law in laws for hook in law.HOOKS}
    wanted = {role["quantity"] for law in laws for role in law.ROLES.values() if role["role"] != "setting"}
    travel = max(float(np.ptp(log.position)) for log in logs)
    speed = max(float(np.quantile(np.abs(np.gradient(log.position[::10], log.time[::10])), 0.99)) for log in logs)
    advice = []
    if {"command_delay", "lag"} <= kinds:
        advice.append("a reference with content above 100 to 200 Hz (a chirp or steps of small amplitude)")
    if "reading" in kinds and kinds - {"reading"}:
        advice.append(
            f"the same stroke at {speed / 4:.2g} and {speed:.2g} m/s: a reading error grows with speed squared"
        )
    if "command_gain" in kinds and kinds & {"force", "friction_level"}:
        advice.append("the same positions under different commands: slow and fast acceleration, or an added mass")
    if "time" in wanted:
        advice.append("the same strokes again in random order: a force in time does not repeat with position")
    if "friction_level" in kinds and "force" in kinds:
        advice.append(f"both directions at several steady speeds from {speed / 50:.2g} to {speed:.2g} m/s, and at rest")
    if "state" in kinds or "velocity" in wanted:
        advice.append("creep below 5 mm/s with small reversals")
    if wanted & {"force_per_velocity", "force_per_velocity_squared"}:
        advice.append(f"speeds over a factor of 4 or more (up to {2 * speed:.2g} m/s if the axis allows)")
    if wanted & {"force_per_position", "position", "distance", "angle"}:
        advice.append(f"the full travel (this motion covers {travel:.3g} m), slowly, in both directions")
    if not advice:
        return "motion in both directions at several speeds over the whole travel; in motion these effects are equal"
    return "; ".join(advice[:3])
