"""The fit of a model with an effect in it: what may move, and how far."""

from __future__ import annotations

import numpy as np

from cogging.diagnosis.candidates.findings import Finding
from cogging.diagnosis.candidates.movable import effect_parameters, shape_limits, shape_paths
from cogging.diagnosis.candidates.scan import in_range
from cogging.diagnosis.candidates.signatures import quantities
from cogging.diagnosis.evidence.allowance import Allowance
from cogging.diagnosis.evidence.evidence import Evidence
from cogging.diagnosis.evidence.null import limits_of
from cogging.diagnosis.physical import unphysical
from cogging.diagnosis.thresholds import REFIT
from cogging.estimation.gauss_newton import Estimate, fit
from cogging.model.parameters import effect_paths, role_of


def refit(
    estimate: Estimate, finding: Finding, evidence: Evidence, given: int, allowed: Allowance | None = None
) -> Estimate:
    """Fit the model with the effect in it: nuisances, amplitudes, and shapes that are numbers.

    Of the effects that the model was `given`, the amplitudes are fitted, as they are without anything added. Mass and
    friction move as far as they are `allowed` to; None: freely, to be tested afterwards.
    """
    model = estimate.model.replace(effects=(*estimate.model.effects, finding.effect()))
    own = {prefix for prefix, _ in effect_paths(model.effects)[:given]}
    paths = [p for p in estimate.paths if not p.startswith("effects.")]
    paths += [
        p for p in effect_parameters(model) if p.rpartition(".")[0] not in own or role_of(model, p) == "amplitude"
    ]
    limits = shape_limits(model, evidence), limits_of(evidence.sources, allowed)
    floors, ceilings = (shape | nuisance for shape, nuisance in zip(*limits, strict=True))
    fitted = fit(model, paths, evidence.sources, iterations=REFIT.iterations, floors=floors, ceilings=ceilings)
    sizes = quantities(evidence)
    if said := unphysical(fitted.model, given, [source.log for source in evidence.sources]):
        raise ValueError(said)
    for effect in fitted.model.effects[given:]:
        for name, role in effect.ROLES.items():
            value = getattr(effect, name)
            if (
                role["role"] == "amplitude"
                and np.max(np.abs(value)) > REFIT.amplitude_excess * role["high"] * sizes[role["quantity"]]
            ):
                raise ValueError(f"its {name} runs to {np.max(np.abs(value)):.3g}")
            if role["role"] == "shape" and isinstance(value, float) and not in_range(evidence, role, value):
                # The shape runs off where the log does not hold it: shapes stay where the scan found them.
                held = [p for p in paths if p not in shape_paths(model)]
                return fit(model, held, evidence.sources, iterations=REFIT.iterations, floors=floors, ceilings=ceilings)
    return fitted
