"""What of a model's effects a fit may move, and how far."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np

from cogging.diagnosis.candidates.intervals import acts_in_interval
from cogging.diagnosis.candidates.signatures import Seen, quantities
from cogging.diagnosis.physical import ends
from cogging.diagnosis.thresholds import REFIT
from cogging.effects.effect import Effect
from cogging.model.model import Model
from cogging.model.parameters import effect_paths, parameters_of


def shape_limits(model: Model, evidence: Seen) -> tuple[dict[str, float], dict[str, float]]:
    """Values that shapes keep between while a fit moves them: twice the range in which their effect is looked for.

    An amplitude that has a sign keeps it.

    Beyond it a log holds them no more, and what is stiff (a contact, a mode) would be simulated in ever finer steps.
    """
    floors, ceilings = {}, {}
    sizes, logs = quantities(evidence), [source.log for source in evidence.sources]
    for prefix, effect in effect_paths(model.effects):
        for name, role in effect.ROLES.items():
            if role["role"] == "shape" and role["quantity"] not in ("position", "angle") and not is_held(effect, role):
                size, (least, most) = sizes[role["quantity"]], ends(logs, role)
                low = max(REFIT.floor_of_range * role["low"], REFIT.floor_of_high * role["high"]) * size
                room = 1.0 if role["quantity"] == "relative" else REFIT.ceiling_of_range
                floors[f"{prefix}.{name}"] = max(low, least)
                ceilings[f"{prefix}.{name}"] = min(room * role["high"] * size, most)
            elif role["role"] == "amplitude" and role["low"] == 0.0:
                floors[f"{prefix}.{name}"] = 0.0
    return floors, ceilings


def is_held(effect: Effect, role: Mapping[str, Any]) -> bool:
    """Whether a fit leaves a parameter where the scan found it: an exponent, or an edge in time."""
    return role["quantity"] == "exponent" or (role["quantity"] == "time" and acts_in_interval(effect))


def shape_paths(model: Model) -> set[str]:
    """Paths of the effects' shapes."""
    return {
        f"{prefix}.{name}"
        for prefix, effect in effect_paths(model.effects)
        for name, role in effect.ROLES.items()
        if role["role"] == "shape"
    }


def effect_parameters(model: Model) -> list[str]:
    """Paths of the effects' amplitudes and shapes that a fit can move."""
    known = parameters_of(model)
    paths = []
    for prefix, effect in effect_paths(model.effects):
        for name, role in effect.ROLES.items():
            value = getattr(effect, name)
            if role["role"] == "setting" or (role["role"] == "shape" and isinstance(value, list)):
                continue
            if is_held(effect, role):
                continue
            paths += [p for p in known if p == f"{prefix}.{name}" or p.startswith(f"{prefix}.{name}[")]
    return [p for p in paths if np.isfinite(known[p].value)]


def conditional_paths(model: Model) -> set[str]:
    """Paths of shapes that were fitted under settings which nobody stated, of an effect with states (a contact).

    Under other settings they come out differently, by more than their intervals would say.
    """
    return {
        f"{prefix}.{name}"
        for prefix, effect in effect_paths(model.effects)
        if "state" in effect.HOOKS and any(role["role"] == "setting" for role in effect.ROLES.values())
        for name, role in effect.ROLES.items()
        if role["role"] == "shape"
    }
