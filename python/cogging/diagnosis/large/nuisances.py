"""What may move beside a term while it is tried: mass and friction as far as they are allowed to, known amplitudes."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from cogging.arrays import FloatArray
from cogging.diagnosis.evidence.allowance import Allowance
from cogging.diagnosis.evidence.null import nuisances
from cogging.diagnosis.large.balance import Balances
from cogging.diagnosis.thresholds import BALANCE
from cogging.model.parameters import parameters_of


@dataclass(frozen=True)
class Nuisances:
    """Linear least squares of a force balance over its nuisance parameters, each within bounds.

    Attributes:
        paths: paths of the nuisances that may move.
        columns: derivatives of the residual by them, V per unit, (p, n).
        low, high: by how much each may move, (p,).
        residual: of the model as it stands, V, (n,).
    """

    paths: tuple[str, ...]
    columns: FloatArray
    low: FloatArray
    high: FloatArray
    residual: FloatArray

    @cached_property
    def products(self) -> FloatArray:
        """Products of the columns and the residual among themselves, (p + 1, p + 1)."""
        rows = np.vstack([self.columns, self.residual])
        return products_of(rows, rows)

    def fitted(self, columns: FloatArray, low: FloatArray, high: FloatArray) -> tuple[FloatArray, float]:
        """Amplitudes (p + q,) of the nuisances and of further columns (q, n) within bounds, and the power left."""
        p, q = len(self.columns), len(columns)
        known = self.products
        products = np.zeros((p + q + 1, p + q + 1))
        inner = [*range(p), p + q]
        products[np.ix_(inner, inner)] = known
        if q:
            products[p : p + q, :p] = products_of(columns, self.columns)
            products[p : p + q, p : p + q] = products_of(columns, columns)
            products[p + q, p : p + q] = products_of(columns, self.residual[None, :])[:, 0]
            products[:p, p : p + q] = products[p : p + q, :p].T
            products[p : p + q, p + q] = products[p + q, p : p + q]
        return bounded(products, np.append(self.low, low), np.append(self.high, high))

    def alone(self) -> tuple[FloatArray, float]:
        """The same without further columns."""
        return self.fitted(np.zeros((0, len(self.residual))), np.zeros(0), np.zeros(0))

    def moved(self, steps: FloatArray) -> FloatArray:
        """The residual once the nuisances have moved by `steps` (p,), V, (n,)."""
        return np.asarray(self.residual + steps @ self.columns)


def nuisances_of(balances: Balances, allowed: Allowance, *, effects: bool = True) -> Nuisances:
    """What may move beside a term: nuisances of the model, amplitudes of `effects` among them."""
    known = parameters_of(balances.model, together=True)
    paths = [p for p in nuisances(balances.model) if p not in allowed.exact and p != "axis.coulomb_width"]
    paths = [p for p in paths if effects or not p.startswith("effects.")]
    values = np.array([known[path].value for path in paths])
    low = np.array([allowed.floors.get(path, -np.inf) for path in paths]) - values
    high = np.array([allowed.ceilings.get(path, np.inf) for path in paths]) - values
    columns = balances.columns([known[path] for path in paths])
    return Nuisances(tuple(paths), columns, np.minimum(low, 0.0), np.maximum(high, 0.0), balances.residual)


def products_of(rows: FloatArray, others: FloatArray) -> FloatArray:
    """Products of rows (p, n) and others (q, n), (p, q).

    Few and long: threads of a matrix product would wait for each other for longer than it takes.
    """
    return np.asarray(np.einsum("in,jn->ij", rows, others))


def bounded(products: FloatArray, low: FloatArray, high: FloatArray) -> tuple[FloatArray, float]:
    """Weights (p,) between bounds of columns that make residual + weights columns smallest, and the power left.

    Args:
        products: products of columns and residual (the last) among themselves, (p + 1, p + 1).
        low, high: ends of each weight, (p,).
    """
    total, gram, right = float(products[-1, -1]), products[:-1, :-1], products[:-1, -1]
    size = np.sqrt(np.diag(gram))
    moves = (size > BALANCE.column_size * np.sqrt(total)) & (high > low)
    weights = np.zeros(len(size))
    if not moves.any():
        return weights, total
    size = size[moves]
    values, vectors = np.linalg.eigh(gram[np.ix_(moves, moves)] / np.outer(size, size))
    values = np.maximum(values, 1e-12 * values[-1])
    inside = _between(values, vectors, -right[moves] / size, low[moves] * size, high[moves] * size)
    weights[moves] = np.clip(inside / size, low[moves], high[moves])
    left = float(total + 2.0 * weights @ right + weights @ gram @ weights)
    return weights, max(left, 1e-15 * total)


def _between(values: FloatArray, vectors: FloatArray, aim: FloatArray, low: FloatArray, high: FloatArray) -> FloatArray:
    """The w (p,) between bounds that makes w C w / 2 - aim w least, C of these eigenvalues and eigenvectors."""
    from scipy.optimize import lsq_linear

    curvature = (vectors * values) @ vectors.T
    weights = vectors @ (vectors.T @ aim / values)
    below, above = weights < low, weights > high
    for _ in range(len(weights) + 1):  # hold what left its bounds, let go what would come back; mostly that ends soon
        held = below | above
        if held.any():
            weights = np.where(below, low, np.where(above, high, 0.0))
            rest = aim - curvature[:, held] @ weights[held]
            weights[~held] = np.linalg.solve(curvature[~held][:, ~held], rest[~held])
        slope = curvature @ weights - aim
        below = (weights < low) | (below & (slope >= 0.0))
        above = (weights > high) | (above & (slope <= 0.0))
        if np.array_equal(held, below | above):
            return np.asarray(weights)
    root = (vectors * np.sqrt(values)).T
    ends = (low - BALANCE.no_room, high + BALANCE.no_room)
    found = lsq_linear(root, vectors.T @ aim / np.sqrt(values), bounds=ends, method="bvls").x
    return np.asarray(np.clip(found, low, high))
