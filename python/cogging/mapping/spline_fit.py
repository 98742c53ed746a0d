"""Least squares of the cogging model's coefficients, with a prior, a covariance and cross-validation."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from cogging._core import CoggingModel, SplineHarmonics
from cogging.arrays import FloatArray

FOLDS = 8
LEAST_PRIOR = 1e-8  # of the mean diagonal of the normal matrix: keeps it regular where there is no noise


@dataclass(frozen=True)
class SplineFit:
    """force = A_r^T S_r(x) + nuisance columns, fitted.

    Attributes:
        basis: S_r(x), p coefficients; None = the nuisance columns alone, p = 0.
        coefficients: (p + q,), V: A_r as CoggingModel stores it, then those of the nuisance columns.
        residual: V, (n,).
        variance: V^2, of the residual, with the degrees of freedom that the fit took.
        determined: (p + q,), the part of each coefficient that the points decide and not the prior, 0 to 1.
        prior: weight of the prior, (p + q, p + q), added to the normal matrix.
    """

    basis: SplineHarmonics | None
    coefficients: FloatArray
    residual: FloatArray
    variance: float
    determined: FloatArray
    prior: FloatArray
    _normal: FloatArray
    _inverse: FloatArray

    def covariance(self, level: FloatArray) -> FloatArray:
        """Covariance of the coefficients, V^2, (p + q, p + q).

        A^-1 (D N D + variance prior) A^-1 with N the normal matrix, A = N + prior and D^2 the noise level (V^2) at each
        column's own frequency, (p + q,): a regressor that lives at one frequency feels the noise of that frequency, so
        correlated noise is accounted for. Along coefficients that the points do not decide it is the prior's.
        """
        root = np.sqrt(level)
        noise = self._normal * np.outer(root, root) + self.variance * self.prior
        covariance: FloatArray = self._inverse @ noise @ self._inverse
        return covariance


def fit_splines(
    basis: SplineHarmonics | None, position: FloatArray, force: FloatArray, nuisance: FloatArray
) -> SplineFit:
    """Fit the coefficients of the cogging model and of the nuisance columns.

    The prior: neighbouring control points of a harmonic differ by 0 +- the standard deviation of the force, all
    harmonics alike. Its weight is therefore the residual's variance over that of the force: little, where the points
    decide.

    Args:
        basis: S_r(x); None for the nuisance columns alone.
        position: m, (n,).
        force: V, (n,).
        nuisance: (n, q), columns of order 1; the first is constant.
    """
    normal, right = normal_equations(basis, position, force, nuisance)
    p = len(normal) - nuisance.shape[1]
    spread = max(float(np.var(force)), np.finfo(float).tiny)
    least = LEAST_PRIOR * float(np.trace(normal)) / len(normal)
    shape = _difference_penalty(basis, len(normal))
    weight = 0.0
    for _ in range(2):  # once for the residual's variance, once with it
        prior = (weight + least) * shape
        prior[:p, :p] += 1e-3 * least * np.eye(p)
        inverse = np.asarray(np.linalg.inv(normal + prior), dtype=np.float64)
        coefficients = inverse @ right
        residual = force - predict(basis, coefficients, position, nuisance)
        determined = np.einsum("ij,ji->i", inverse, normal)
        variance = float(residual @ residual) / max(len(force) - float(determined.sum()), 1.0)
        weight = variance / spread
    return SplineFit(basis, coefficients, residual, variance, determined, prior, normal, inverse)


def cross_validate(
    fit: SplineFit, position: FloatArray, force: FloatArray, nuisance: FloatArray, block: float
) -> tuple[float, float]:
    """Rms of the errors with which parts of the scan are predicted from the rest, and its standard error, V.

    The travel is cut in blocks (m) that hold all passes; of each eight neighbouring blocks one, at random, is in each
    of eight folds, so that a fold's blocks do not stand at one phase of a period.
    """
    blocks = np.floor((position - position.min()) / block).astype(np.int64)
    groups = int(blocks.max()) // FOLDS + 1
    tiles = np.tile(np.arange(FOLDS), (groups, 1))
    folds = np.random.default_rng(0).permuted(tiles, axis=1).ravel()[blocks]
    normal, right = normal_equations(fit.basis, position, force, nuisance)
    error = np.zeros(len(force))
    for fold in range(FOLDS):
        out = folds == fold
        if not out.any():
            continue
        normal_out, right_out = normal_equations(fit.basis, position[out], force[out], nuisance[out])
        seen = normal - normal_out + fit.prior
        coefficients = np.asarray(np.linalg.solve(seen, right - right_out), dtype=np.float64)
        error[out] = force[out] - predict(fit.basis, coefficients, position[out], nuisance[out])
    counts = np.bincount(blocks)
    squares = np.bincount(blocks, error**2)
    mean = float(squares.sum() / len(error))
    used = int(np.count_nonzero(counts))
    spread = float(np.sqrt(np.sum((squares - mean * counts) ** 2) * used / max(used - 1, 1))) / len(error)
    rms = float(np.sqrt(mean))
    return rms, 0.5 * spread / rms if rms > 0.0 else 0.0


def predict(
    basis: SplineHarmonics | None, coefficients: FloatArray, position: FloatArray, nuisance: FloatArray
) -> FloatArray:
    """The force (V) of coefficients as SplineFit holds them, at positions (m) with their nuisance columns."""
    p = 0 if basis is None else basis.coefficients
    force: FloatArray = nuisance @ coefficients[p:]
    if basis is not None:
        force = force + cogging_of(basis, coefficients[:p]).force(position)
    return force


def cogging_of(basis: SplineHarmonics, coefficients: FloatArray) -> CoggingModel:
    """The model of coefficients in the order of `SplineHarmonics.regressor`."""
    return CoggingModel(basis, *rows_of(basis, coefficients))


def rows_of(basis: SplineHarmonics, coefficients: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Sines and cosines, each (terms, control points), of coefficients in the order of the regressor."""
    table = coefficients.reshape(basis.spline.control_points, basis.terms, 2)
    return np.ascontiguousarray(table[:, :, 0].T), np.ascontiguousarray(table[:, :, 1].T)


def normal_equations(
    basis: SplineHarmonics | None, position: FloatArray, force: FloatArray, nuisance: FloatArray
) -> tuple[FloatArray, FloatArray]:
    """A^T A and A^T force of the columns A = [S_r(x), nuisance], span by span, since few control points act in each.

    Args:
        basis: S_r(x), p coefficients; None for p = 0.
        position: m, (n,).
        force: V, (n,).
        nuisance: further columns, (n, q).

    Returns:
        Arrays (p + q, p + q) and (p + q,).
    """
    p = 0 if basis is None else basis.coefficients
    normal = np.zeros((p + nuisance.shape[1],) * 2)
    right = np.zeros(len(normal))
    if basis is not None:
        width, spline = 2 * basis.terms, basis.spline
        spans = spline.control_points - spline.order + 1
        span = np.minimum(np.argmax(spline.design_matrix(position) != 0.0, axis=1), spans - 1)
        order = np.argsort(span, kind="stable")
        for s, rows in enumerate(np.split(order, np.searchsorted(span[order], np.arange(1, spans)))):
            acting = slice(s * width, (s + spline.order) * width)
            columns = basis.regressor(position[rows])[:, acting]
            normal[acting, acting] += columns.T @ columns
            normal[acting, p:] += columns.T @ nuisance[rows]
            right[acting] += columns.T @ force[rows]
    normal[p:, :p] = normal[:p, p:].T
    normal[p:, p:] = nuisance.T @ nuisance
    right[p:] = nuisance.T @ force
    return normal, right


def _difference_penalty(basis: SplineHarmonics | None, size: int) -> FloatArray:
    """The sum of squared differences of neighbouring control points as a quadratic form, (size, size)."""
    penalty = np.zeros((size, size))
    if basis is not None:
        difference = np.diff(np.eye(basis.spline.control_points), axis=0)
        p = basis.coefficients
        penalty[:p, :p] = np.kron(difference.T @ difference, np.eye(2 * basis.terms))
    return penalty
