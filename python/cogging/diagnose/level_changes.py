"""Mass and friction that differ from what the model states by more than it states to know."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from cogging.diagnose.evidence import Evidence
from cogging.diagnose.search import Search
from cogging.estimation import SINGULAR, Estimate, Whitened, jackknife
from cogging.intervals import student
from cogging.model import Model
from cogging.parameters import parameters_of

FloatArray = npt.NDArray[np.float64]

CHANGED = 4.2  # stated and found deviations together, beyond which mass, viscous or Coulomb friction has changed
VANISHING = 1e-3  # of the command: a force below it is as good as none


def changes(search_: Search, model: Model) -> list[tuple[str, float, float, float]]:
    """Mass, viscous and Coulomb friction beyond what the model states.

    Each as (name, change, half of its 95 % interval, how many deviations, found and stated, it is beyond). Shapes of
    friction close to rest are nuisances here too: what they take up is no change of the level.
    """
    values, deviations, halves = level_estimates(search_.evidence, search_.estimate)
    known = parameters_of(model)
    found = []
    for i, path in enumerate(search_.estimate.paths):
        name = path.removeprefix("axis.")
        if name not in ("mass", "viscous", "coulomb") or model.uncertainty.get(name) is None:
            continue
        prior = getattr(model.axis, name)
        if prior <= VANISHING * search_.evidence.scales.of(known[path].unit):
            continue  # a deviation relative to nothing says nothing
        if values[i] <= 0.0:
            continue  # no such machine: the logs do not tell this level from what goes with it
        stated = model.uncertainty[name] * prior
        deviation = float(np.hypot(deviations[i], stated))
        beyond = (values[i] - prior) / deviation if deviation > 0.0 else 0.0
        found.append((name, values[i] / prior - 1.0, float(halves[i]) / prior, float(beyond)))
    return found


def level_estimates(evidence: Evidence, estimate: Estimate) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Values, 1-sigma and half of the 95 % interval of the free parameters, shapes of slow friction free beside them.

    The deviations are those that leaving out blocks gives, or white residuals, whichever are larger.
    """
    columns = evidence.columns
    size = np.sqrt(np.einsum("ij,ij->i", columns, columns))
    size[size == 0.0] = 1.0
    scaled = columns / size[:, None]
    inverse = np.linalg.pinv(scaled @ scaled.T, rcond=SINGULAR, hermitian=True)
    step = -(inverse @ (scaled @ evidence.residual)) / size
    left = evidence.residual + step @ columns
    blocks = Whitened(left, columns, evidence.block, np.zeros(0), 1.0)
    covariance, freedom = jackknife([blocks])
    white = np.diag(inverse) / size**2 * evidence.excess
    deviation = np.sqrt(np.maximum(np.diag(covariance), white))
    half = deviation * [student(float(one)) for one in freedom]
    p = len(estimate.paths)
    return estimate.values + step[:p], deviation[:p], half[:p]
