"""The harmonics of a pitch in a force measured at irregular positions, and the noise level around them."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass
from typing import Any

import numpy as np

from cogging._core import CoggingModel, SplineHarmonics, require_memory
from cogging.arrays import FloatArray, Mask
from cogging.resources import POINT

FOLDS = 8
LEAST_PRIOR = 1e-8  # of the mean diagonal of the normal matrix: keeps it regular without noise


Basis = SplineHarmonics | None  # S_r(x); None: no cogging


@dataclass(frozen=True)
class SplineFit:
    """force = A_r^T S_r(x) + nuisance columns, fitted."""

    basis: Basis  # p coefficients; None = the nuisance columns alone, p = 0
    nuisance: FloatArray  # (n, q)
    coefficients: FloatArray  # (p + q,), V: A_r as CoggingModel stores it, then those of the nuisance columns
    residual: FloatArray  # V, (n,)
    variance: float  # V^2, of the residual, per degree of freedom
    determined: FloatArray  # (p + q,), share of each coefficient determined by the points and not the prior, 0 to 1
    prior: FloatArray  # weight of the prior, (p + q, p + q), added to the normal matrix
    _normal: FloatArray
    _inverse: FloatArray

    def covariance(self, level: FloatArray) -> FloatArray:
        """Covariance of the coefficients, V^2, with the noise `level` at each column's frequency, (p + q,).

        A^-1 (D N D + variance prior) A^-1, N the normal matrix, A = N + prior, D^2 the level: noise may be correlated.
        """
        root = np.sqrt(level)
        noise = self._normal * np.outer(root, root) + self.variance * self.prior
        return np.asarray(self._inverse @ noise @ self._inverse)


def fit_splines(basis: Basis, position: FloatArray, force: FloatArray, nuisance: FloatArray) -> SplineFit:
    """Fit the coefficients of the cogging model (None: none) and of the nuisance columns (n, q), the first constant.

    The prior: neighbouring control points differ by 0 +- the standard deviation of the force, so that its weight is the
    residual's variance over that of the force.
    """
    normal, right = normal_equations(basis, position, force, nuisance)
    p = len(normal) - nuisance.shape[1]
    spread = max(float(np.var(force)), np.finfo(float).tiny)
    least = LEAST_PRIOR * float(np.trace(normal)) / len(normal)
    shape = np.zeros_like(normal)  # the sum of squared differences of neighbouring control points
    if basis is not None:
        difference = np.diff(np.eye(basis.spline.control_points), axis=0)
        shape[:p, :p] = np.kron(difference.T @ difference, np.eye(2 * basis.terms))
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
    return SplineFit(basis, nuisance, coefficients, residual, variance, determined, prior, normal, inverse)


def cross_validate(fit: SplineFit, position: FloatArray, force: FloatArray, block: float) -> tuple[float, float]:
    """Rms of the errors with which parts of the scan are predicted from the rest, and its standard error, V.

    Of each eight neighbouring blocks (m) of the travel one, at random, is in each of eight folds.
    """
    blocks = np.floor((position - position.min()) / block).astype(np.int64)
    tiles = np.tile(np.arange(FOLDS), (int(blocks.max()) // FOLDS + 1, 1))
    folds = np.random.default_rng(0).permuted(tiles, axis=1).ravel()[blocks]
    normal, right = normal_equations(fit.basis, position, force, fit.nuisance)
    error = np.zeros(len(force))
    for fold in np.unique(folds):
        out = folds == fold
        normal_out, right_out = normal_equations(fit.basis, position[out], force[out], fit.nuisance[out])
        coefficients = np.asarray(np.linalg.solve(normal - normal_out + fit.prior, right - right_out), dtype=np.float64)
        error[out] = force[out] - predict(fit.basis, coefficients, position[out], fit.nuisance[out])
    counts, squares = np.bincount(blocks), np.bincount(blocks, error**2)
    mean = float(squares.sum() / len(error))
    used = int(np.count_nonzero(counts))
    spread = float(np.sqrt(np.sum((squares - mean * counts) ** 2) * used / max(used - 1, 1))) / len(error)
    rms = float(np.sqrt(mean))
    return rms, 0.5 * spread / rms if rms > 0.0 else 0.0


def predict(basis: Basis, coefficients: FloatArray, position: FloatArray, nuisance: FloatArray) -> FloatArray:
    """The force (V) of coefficients as SplineFit holds them, at positions (m) with their nuisance columns."""
    if basis is None:
        return np.asarray(nuisance @ coefficients)
    p = basis.coefficients
    return np.asarray(nuisance @ coefficients[p:] + cogging_of(basis, coefficients[:p]).force(position))


def cogging_of(basis: SplineHarmonics, coefficients: FloatArray) -> CoggingModel:
    """The model of coefficients in the order of `SplineHarmonics.regressor`."""
    return CoggingModel(basis, *rows_of(basis, coefficients))


def rows_of(basis: SplineHarmonics, coefficients: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Sines and cosines, each (terms, control points), of coefficients in the order of the regressor."""
    table = coefficients.reshape(basis.spline.control_points, basis.terms, 2)
    return np.ascontiguousarray(table[:, :, 0].T), np.ascontiguousarray(table[:, :, 1].T)


def normal_equations(
    basis: Basis, position: FloatArray, force: FloatArray, nuisance: FloatArray
) -> tuple[FloatArray, FloatArray]:
    """A^T A (p + q, p + q) and A^T force (p + q,) of the columns A = [S_r(x), nuisance (n, q)].

    Span by span, since few control points act in each.
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


WINDOW = 61  # lines of the running median that gives the noise level
FEWEST = 8  # lines needed for a median
FEWEST_FOR_SLOPE = 40  # lines needed for a slope of the noise; with fewer it is assumed white
FLOOR = 1e-6  # of the rms force: smaller noise is rounding
SIDEBAND = 0.25  # of the distance of two harmonics: a line this near to a harmonic is its modulation
ROUNDS = 100  # of the search; each removes one component


@dataclass(frozen=True)
class Line:
    """A significant line."""

    frequency: float  # 1/m, that of the harmonic where it belongs to one
    harmonic: int | None  # of the pitch, or None: no modulation of a harmonic either
    amplitude: float  # V, of the strongest line of the component


class HarmonicSpectrum:
    """The least-squares spectrum of a force around the harmonics of a pitch.

    Mask are at f = h / pitch + s / travel for h = 0, 1, .. highest and every whole s with |s| / travel below half
    the distance of two harmonics. The power of a line is half of what its sine and cosine take off the sum of squares,
    so that white noise of variance sigma^2 gives sigma^2 on average. A harmonic whose amplitude changes along the
    travel (Lu et al. 2008, eq. 3) has lines beside it; those within a quarter of the distance count as its own.

    Args:
        position: m, (n,), in any order.
        pitch: m.
        highest: the last harmonic.
    """

    def __init__(self, position: FloatArray, pitch: float, highest: int) -> None:
        self.position, self.pitch = position, pitch
        travel = float(np.ptp(position))
        reach = int(0.5 * travel / pitch - 1e-9)
        lines = float(highest + 1) + 2.0 * reach + 1.0
        size = f"{len(position)} points by {lines:g} lines"
        require_memory("position", POINT * len(position) * lines, size, f"{travel / pitch:g} pitches")
        self.harmonic = np.arange(highest + 1)
        offset = np.arange(-reach, reach + 1)
        # 1/m, (highest + 1, lines of a harmonic); row h belongs to harmonic h, row 0 to what is slower.
        self.frequency: FloatArray = self.harmonic[:, None] / pitch + offset / travel
        self.present = self.frequency > 0.0
        # Whether a line is its harmonic's own, lines are too few for a slope of the noise, modulations are separable.
        self.near = (np.abs(offset) <= SIDEBAND * travel / pitch) & (self.harmonic[:, None] > 0)
        self.few = bool(self.present.sum() < FEWEST_FOR_SLOPE)
        self.modulated = bool(self.near.sum(axis=1).max() > 1)
        # exp(i a) exp(i b) = exp(i (a + b)): two matrix products give all lines, without a loop over them.
        centred = 2j * np.pi * (position - position.mean())
        self._rows, self._columns = (np.exp(np.outer(centred, one)) for one in (self.harmonic / pitch, offset / travel))
        twice, n = (self._rows**2).T @ self._columns**2, len(position)
        self._cc, self._ss, self._cs = (n + twice.real) / 2, (n - twice.real) / 2, twice.imag / 2

    def power(self, force: FloatArray, harmonics: slice = slice(None)) -> FloatArray:
        """The power of every line, V^2, in the shape of `frequency` or of some of its rows; 0 where f <= 0."""
        sums = (self._rows[:, harmonics] * force[:, None]).T @ self._columns
        c, s, cc, ss, cs = sums.real, sums.imag, self._cc[harmonics], self._ss[harmonics], self._cs[harmonics]
        # Where all points are near zeros of a sine only its cosine is determined.
        determinant = np.maximum(cc * ss - cs**2, 1e-9 * len(self.position) ** 2)
        return np.where(self.present[harmonics], 0.5 * (c * c * ss - 2.0 * c * s * cs + s * s * cc) / determinant, 0.0)

    def amplitude(self, power: FloatArray) -> FloatArray:
        """The amplitude (V) of a sinusoid that gives a power (V^2)."""
        return np.sqrt(4.0 * power / len(self.position))

    def around(self, frequency: float, modulated: bool) -> Mask:
        """The lines that a component at a frequency (1/m) occupies, in the shape of `frequency`."""
        return np.abs(self.frequency - frequency) <= (0.5 if modulated else 1e-6) / self.pitch

    def level(self, power: FloatArray, taken: Mask, mean_square: float) -> tuple[FloatArray, float]:
        """The noise level (V^2, in the shape of `frequency`) and its degrees of freedom.

        The running median of the lines without a component, divided by ln 2 (noise power is exponentially distributed),
        after a significant power law in f is removed; with too few lines the mean square of the force.
        """
        free = np.flatnonzero((self.present & ~taken).ravel())
        smallest = np.finfo(float).tiny
        if free.size < FEWEST:
            return np.full(self.frequency.shape, max(mean_square, smallest)), float(len(self.position))
        log_frequency = np.log(np.where(self.present, self.frequency, self.frequency[self.present].min()).ravel())
        log_power = np.log(np.maximum(power.ravel()[free], smallest))
        slope = _slope(log_frequency[free], log_power)
        window = min(WINDOW, free.size)
        flat = np.lib.stride_tricks.sliding_window_view(log_power - slope * log_frequency[free], window)
        first = np.clip(np.searchsorted(free, np.arange(log_frequency.size)) - window // 2, 0, free.size - window)
        log_level = np.median(flat, axis=1)[first] - np.log(np.log(2.0)) + slope * log_frequency
        # The median of w exponential values scatters as a chi-square of 2 (ln 2)^2 w degrees of freedom does.
        return np.exp(log_level).reshape(self.frequency.shape), 2.0 * np.log(2.0) ** 2 * window

    def false_alarm(self, ratio: float, degrees: float) -> float:
        """The probability that noise alone lifts any line of the spectrum to `ratio` times its level.

        lines (1 + 2 ratio / degrees)^(-degrees / 2), at most 1: the F(2, degrees) distribution.
        """
        return min(1.0, float(self.present.sum() * np.exp(-0.5 * degrees * np.log1p(2.0 * ratio / degrees))))

    def find(
        self, force: FloatArray, nuisance: FloatArray, false_alarm: float, taken: Mask | None = None
    ) -> list[Line]:
        """The significant lines of a force (V, (n,)) in the order found; each harmonic once.

        The strongest line is removed with its modulation and the `nuisance` columns (n, q), and the rest searched
        again. `false_alarm` is the probability at which noise alone yields any line; `taken` lines are excluded.
        """
        taken, found = (~self.present if taken is None else taken.copy()), list[Line]()
        points = int(np.ceil(np.ptp(self.position) / self.pitch)) + 2 if self.modulated else 1
        form: dict[str, Any] = {"order": 3, "origin": float(self.position.min()), "control_points": points}
        rest = force - nuisance @ np.linalg.lstsq(nuisance, force, rcond=None)[0]
        arithmetic = FLOOR**2 * float(np.mean(rest**2)) or 1.0
        for _ in range(ROUNDS):
            power = self.power(rest)
            level, degrees = self.level(power, taken, float(np.mean(rest**2)))
            ratio = power / np.maximum(level, arithmetic)
            h, s = np.unravel_index(int(np.argmax(ratio)), ratio.shape)
            if self.false_alarm(float(ratio[h, s]), degrees) > false_alarm:
                break
            own = bool(self.near[h, s])
            frequency = float(h / self.pitch if own else self.frequency[h, s])
            if all(line.frequency != frequency for line in found):
                found.append(Line(frequency, int(h) if own else None, float(self.amplitude(power)[h, s])))
            # Less the least-squares part at this frequency (spline of order 3, or constant) and the nuisances.
            basis = SplineHarmonics(pitch=self.pitch, periods=[1.0 / frequency], **form)
            normal, right = normal_equations(basis, self.position, rest, nuisance)
            p = basis.coefficients
            normal[np.arange(p), np.arange(p)] += 1e-12 * float(np.max(np.diag(normal)[:p]))
            coefficients = np.asarray(np.linalg.solve(normal, right), dtype=np.float64)
            rest = rest - predict(basis, coefficients, self.position, nuisance)
            taken |= self.around(frequency, self.modulated)
        return found

    def threshold(self, false_alarm: float, degrees: float) -> float:
        """The ratio to its level at which a line has that false alarm: the inverse of `false_alarm`."""
        return float(0.5 * degrees * np.expm1(2.0 / degrees * np.log(self.present.sum() / false_alarm)))

    def taken_by(self, harmonics: Iterable[int], modulated: bool) -> Mask:
        """The lines that harmonics occupy, in the shape of `frequency`."""
        taken = ~self.present
        for harmonic in harmonics:
            taken |= self.around(harmonic / self.pitch, modulated)
        return taken


def _slope(log_frequency: FloatArray, log_power: FloatArray) -> float:
    """The exponent of a power law through the medians of equal groups of lines; 0 where it is not significant."""
    if log_frequency.size < FEWEST_FOR_SLOPE:
        return 0.0
    groups = min(12, log_frequency.size // 5)
    parts = np.array_split(np.argsort(log_frequency), groups)
    x = np.array([np.mean(log_frequency[part]) for part in parts])
    y = np.array([np.median(log_power[part]) for part in parts])
    x -= x.mean()
    slope = float(x @ y / (x @ x))
    scatter = 1.0 / (np.log(2.0) * np.sqrt(log_frequency.size / groups))  # of the log of a median
    return slope if abs(slope) > 2.0 * scatter / np.sqrt(x @ x) else 0.0
