"""Whether a fit can tell an effect from none."""

from __future__ import annotations

import numpy as np

from cogging.effects.effect import Effect
from cogging.estimation.gauss_newton import Estimate
from cogging.model.parameters import effect_paths, parameters_of, role_of


def excludes_none(estimate: Estimate, neutral: Effect) -> bool:
    """Whether the 95 % region of the amplitudes of the last effect excludes those of the `neutral` one."""
    from scipy.stats import f as f_distribution

    model = estimate.model
    prefix, known = effect_paths(model.effects)[-1][0], parameters_of(model)
    rows, sizes = [], []
    for row, path in enumerate(estimate.paths):
        if path.rpartition(".")[0] != prefix or role_of(model, path) != "amplitude":
            continue
        end = np.ravel(getattr(neutral, path.rpartition(".")[2].partition("[")[0]))
        size = known[path].value - (float(end[0]) if len(end) == 1 else 0.0)
        if np.isfinite([size, estimate.covariance[row, row]]).all():
            rows.append(row)
            sizes.append(size)
    if not rows:
        return True  # infinite where it vanishes, or an interval that nobody can state
    spread = estimate.covariance[np.ix_(rows, rows)]
    freedom = float(np.min(estimate.freedom[rows]))
    within = float(f_distribution.ppf(0.95, len(rows), max(freedom, 1.0)))
    far = float(np.array(sizes) @ np.linalg.pinv(spread, hermitian=True) @ sizes) / len(rows)
    return far > within
