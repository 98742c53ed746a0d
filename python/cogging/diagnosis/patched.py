"""The patched model as a file has it: with the intervals of what was fitted."""

from __future__ import annotations

import numpy as np

from cogging.diagnosis.candidates.movable import conditional_paths
from cogging.estimation.gauss_newton import Estimate
from cogging.model.intervals import SIGMAS_95
from cogging.model.model import Model
from cogging.model.parameters import parameters_of


def with_intervals(model: Model, estimate: Estimate) -> Model:
    """The model with 95 % intervals of what was fitted: its `[bounds]`."""
    known, conditional = parameters_of(model), conditional_paths(model)
    intervals = {path: interval for path, interval in model.intervals.items() if path in known}
    for path, fitted, width in zip(estimate.paths, estimate.values, estimate.half_width, strict=True):
        if path not in known:
            continue
        value = known[path].value
        # Nuisances tuned to the gap itself differ from the fit's where the model is not quite right: part of the doubt.
        half = float(np.hypot(width, SIGMAS_95 * (value - fitted)))
        if not np.isfinite(half) or path in conditional:
            intervals[path] = (-np.inf, np.inf)
            continue
        low = max(0.0, value - half) if known[path].positive else value - half
        intervals[path] = (low, value + half)
    return model.replace(intervals=intervals)
