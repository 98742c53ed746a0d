"""Mass and friction that differ from what the model states by more than it states to know."""

from __future__ import annotations

import numpy as np

from cogging.arrays import FloatArray
from cogging.diagnosis.candidates.signatures import candidates, quantities
from cogging.diagnosis.candidates.tables import tables
from cogging.diagnosis.evidence.evidence import Evidence
from cogging.diagnosis.evidence.score_test import orthonormal
from cogging.diagnosis.search.state import Search
from cogging.diagnosis.thresholds import ALLOWANCE, NAME, PARAMETER_CHANGE
from cogging.estimation.gauss_newton import Estimate
from cogging.estimation.jackknife import SINGULAR, jackknife
from cogging.estimation.statistics import student
from cogging.estimation.whitening import Whitened
from cogging.model.model import Model
from cogging.model.parameters import parameters_of


def changes(search_: Search, model: Model) -> list[tuple[str, float, float, float]]:
    """Mass, viscous and Coulomb friction beyond what the model states.

    Each as (name, change, half of its 95 % interval, how many deviations, found and stated, it is beyond). Shapes of
    friction close to rest are nuisances here too: what they take up is no change of the parameter.
    """
    values, deviations, halves = parameter_estimates(search_.evidence, search_.estimate)
    known = parameters_of(model)
    found = []
    for i, path in enumerate(search_.estimate.paths):
        name = path.removeprefix("axis.")
        if name not in ("mass", "viscous", "coulomb"):
            continue
        if search_.large is not None and path not in search_.large.let_go:
            continue  # it is held as far as the statement goes: nothing was found about it
        prior = getattr(model.axis, name)
        if prior <= PARAMETER_CHANGE.vanishing * search_.evidence.scales.of(known[path].dimension):
            continue  # a deviation relative to nothing says nothing
        if values[i] <= 0.0:
            continue  # no such machine: the logs do not tell this parameter from what goes with it
        beyond = deviations_beyond(float(values[i]), float(deviations[i]), prior, model.uncertainty.get(name))
        found.append((name, values[i] / prior - 1.0, float(halves[i]) / prior, float(beyond)))
    return found


def deviations_beyond(value: float, deviation: float, prior: float, stated: float | None) -> float:
    """By how many deviations, found and stated, a parameter is beyond what is stated of it.

    Where nothing is stated it is known to within a factor (ALLOWANCE.unstated): what is beyond that counts.
    """
    if stated is None:
        end = prior * ALLOWANCE.unstated if value > prior else prior / ALLOWANCE.unstated
        outside = value - end if (value > prior) == (value > end) else 0.0
        return outside / deviation if deviation > 0.0 else 0.0
    together = float(np.hypot(deviation, stated * prior))
    return (value - prior) / together if together > 0.0 else 0.0


def look_alikes(search_: Search, model: Model, name: str) -> tuple[str, ...]:
    """Effects of one amplitude that would do to these logs nearly what a change of mass or friction does.

    Beside all else that is free, their columns have a cosine c with that of the parameter. T (1 - c^2) of the
    change tells the two apart: of what shares most of it (c^2), one with less than the margin of what is
    alike (NAME.alike_margin), at an amplitude in its range.
    """
    evidence, estimate = search_.evidence, search_.estimate
    place = estimate.paths.index(f"axis.{name}")
    others = orthonormal(np.delete(evidence.columns, place, axis=0))
    mine = evidence.columns[place]
    mine = mine - (others @ mine) @ others
    moved = float(estimate.values[place]) - float(getattr(model.axis, name))
    power, sizes = float(mine @ mine), quantities(evidence)
    found = []
    for effect, law in search_.vocabulary.items():
        grid = list(candidates(evidence, law))
        if len(grid) != 1 or len(grid[0].amplitudes) != 1:
            continue
        column = evidence.whitened(tables(evidence, grid)[0])[0]
        column = column - (others @ column) @ others
        its, common = float(column @ column), float(mine @ column)
        if its <= 0.0 or power <= 0.0:
            continue
        role = law.ROLES[grid[0].amplitudes[0][0]]
        amplitude = moved * common / its / sizes[role["quantity"]]
        shared = common**2 / (its * power)
        apart = moved**2 * power * (1.0 - shared) / evidence.overdispersion
        if shared > PARAMETER_CHANGE.shared and apart < NAME.alike_margin and role["low"] <= amplitude <= role["high"]:
            found.append(effect)
    return tuple(found)


def parameter_estimates(evidence: Evidence, estimate: Estimate) -> tuple[FloatArray, FloatArray, FloatArray]:
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
    white = np.diag(inverse) / size**2 * evidence.overdispersion
    deviation = np.sqrt(np.maximum(np.diag(covariance), white))
    half = deviation * [student(float(one)) for one in freedom]
    p = len(estimate.paths)
    return estimate.values + step[:p], deviation[:p], half[:p]
