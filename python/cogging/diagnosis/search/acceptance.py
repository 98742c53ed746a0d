"""Whether a fit can tell an effect from none."""

from __future__ import annotations

from cogging.effects.effect import VOCABULARY
from cogging.estimation.gauss_newton import Estimate
from cogging.model.parameters import effect_paths, parameters_of, role_of


def excludes_none(estimate: Estimate) -> bool:
    """Whether the 95 % interval of an amplitude of the last effect excludes the value at which the effect vanishes."""
    model = estimate.model
    prefix, effect = effect_paths(model.effects)[-1]
    known, neutral = parameters_of(model), VOCABULARY.get(effect.NAME, effect)
    seen = []
    for path, half in zip(estimate.paths, estimate.half_width, strict=True):
        if path.rpartition(".")[0] == prefix and role_of(model, path) == "amplitude":
            end = getattr(neutral, path.rpartition(".")[2].partition("[")[0])
            seen.append(not abs(known[path].value - (0.0 if isinstance(end, list) else end)) <= half)
    return any(seen) or not seen
