"""Fits by Gauss and Newton on whitened residuals, with errors that allow for what whitening leaves correlated."""

from __future__ import annotations

import itertools
from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from cogging._core import DivergedError, autoregression, whiten
from cogging.arrays import FloatArray, Mask
from cogging.estimation.residuals import Innovations, Residuals
from cogging.model.difference_steps import central
from cogging.model.intervals import student
from cogging.model.model import Model
from cogging.model.parameters import Parameter, Scales, parameters_of, with_values

LOOSE = 1e-3  # of a direction that nothing determines: a parameter that has more of it is not determined
ALONE = 2.0  # times its variance, by which a parameter loses where one block is left out: that block alone shows it
SINGULAR = 1e-9  # of the largest eigenvalue of scaled curvature: in directions below it nothing is determined
BLOCK = 0.2  # s, length of the blocks over which scores are summed: above it, nothing is taken to be correlated


@dataclass(frozen=True)
class Whitened:
    """Whitened residual and columns of one log, in units of the whitened residual's rms; rows that count only.

    Attributes:
        residual: (n,).
        columns: d residual / d parameter, (p, n).
        block: number of the block of each row, (n,).
        coefficients: of the autoregressive filter.
        rms: of the whitened residual before division, V.
    """

    residual: FloatArray
    columns: FloatArray
    block: npt.NDArray[np.int64]
    coefficients: FloatArray
    rms: float


@dataclass(frozen=True)
class Estimate:
    """What a fit found.

    Attributes:
        paths: the free parameters.
        values: (p,).
        covariance: of the values, from leaving out blocks, (p, p).
        freedom: degrees of freedom of each variance, (p,).
        model: with the values.
        residuals: V, one array (n,) a log.
        whitened: at the values.
        iterations: that were needed.
    """

    paths: tuple[str, ...]
    values: FloatArray
    covariance: FloatArray
    freedom: FloatArray
    model: Model
    residuals: tuple[FloatArray, ...]
    whitened: tuple[Whitened, ...]
    iterations: int

    @property
    def cost(self) -> float:
        """Sum over logs and rows of log rms of the whitened residual: twice the difference is a likelihood ratio."""
        return float(sum(len(w.residual) * np.log(w.rms) for w in self.whitened))

    @property
    def deviation(self) -> FloatArray:
        """1-sigma of each value, (p,)."""
        return np.asarray(np.sqrt(np.maximum(np.diag(self.covariance), 0.0)))

    @property
    def half_width(self) -> FloatArray:
        """Half of each 95 % interval, (p,)."""
        return np.asarray(self.deviation * [student(float(freedom)) for freedom in self.freedom])


class NothingCounts(ValueError):
    """No row of a log shows the axis in motion for long enough."""


def order_for(log: Residuals) -> int:
    """Order of the whitening filter: 20 ms of memory, from 12 to 48 coefficients."""
    return int(np.clip(round(0.02 / log.scales.sample_time), 12, 48))


def whitening_filter(log: Residuals, residual: FloatArray) -> FloatArray:
    """Autoregressive coefficients from the rows that count, with outliers clipped at 6 times the median size."""
    counted = np.abs(residual[log.counts > 0])
    if not len(counted):
        raise NothingCounts("log: must have rows in motion, got an axis that rests or keeps turning back")
    limit = 6.0 * 1.4826 * float(np.median(counted))
    clipped = np.clip(residual, -limit, limit) if limit > 0 else residual
    return np.asarray(autoregression(clipped, log.counts, order=order_for(log)))


def whitened(
    log: Residuals, residual: FloatArray, columns: FloatArray, coefficients: FloatArray | None = None
) -> Whitened:
    """Whiten a residual and its columns, and keep the rows that count."""
    if coefficients is None:
        coefficients = whitening_filter(log, residual)
    table = np.asarray(whiten(np.vstack([residual[None, :], columns]), list(coefficients)))
    rows = log.counts > 0
    rms = float(np.sqrt(np.mean(table[0, rows] ** 2)))
    rms = rms if rms > 0 else 1.0
    block = np.floor(log.log.time[rows] / BLOCK).astype(np.int64)
    return Whitened(table[0, rows] / rms, table[1:, rows] / rms, block, coefficients, rms)


def columns_of(
    model: Model, parameters: Sequence[Parameter], logs: Sequence[Residuals], scales: Scales
) -> tuple[list[FloatArray], list[FloatArray]]:
    """Residuals (n,) and their derivatives (p, n), one of each a log.

    Derivatives by what the log's own `columns` offers, else by central differences of whole runs.

    Raises:
        ValueError: a parameter that no step may move.
    """
    if all(isinstance(log, Innovations) for log in logs):
        pairs = [log.columns(model, parameters, scales) for log in logs if isinstance(log, Innovations)]
        return [pair[0] for pair in pairs], [pair[1] for pair in pairs]
    steps = [central(model, parameter, scales.step(parameter)) for parameter in parameters]
    models = [model, *(side for step in steps for side in (step.above, step.below))]
    spans = np.array([step.span for step in steps])
    residuals, columns = [], []
    for log in logs:
        table = log.of(models)
        residuals.append(table[0])
        columns.append((table[1::2] - table[2::2]) / spans[:, None])
    return residuals, columns


def jackknife(logs: Sequence[Whitened]) -> tuple[FloatArray, FloatArray]:
    """Covariance (p, p) from leaving out one block of rows after the other, and its degrees of freedom (p,).

    Blocks, so that what whitening leaves correlated within one counts; each is left out, for a parameter that a few
    blocks show follows them, and is surer of itself than it should be. Nothing holds it above the covariance that
    white residuals would have: with few blocks it scatters to either side, which the degrees of freedom allow for.
    What one block alone shows (a limit that was reached once) does not move where another is left out: that has the
    covariance of white residuals, widened by as much as those of the other parameters are.
    What no row determines has an infinite variance.
    """
    curvature = sum(log.columns @ log.columns.T for log in logs)
    size = np.sqrt(np.diag(curvature))
    size[size == 0.0] = 1.0
    scaled = curvature / np.outer(size, size)
    white = np.diag(np.linalg.pinv(scaled, rcond=SINGULAR, hermitian=True))
    hangs = np.zeros(len(size), dtype=bool)  # on one block
    shifts = []
    for log in logs:
        edges = [*np.flatnonzero(np.diff(log.block, prepend=log.block[0] - 1)), len(log.residual)]
        for first, last in itertools.pairwise(edges):
            part = log.columns[:, first:last] / size[:, None]
            without = np.linalg.pinv(scaled - part @ part.T, rcond=SINGULAR, hermitian=True)
            shifts.append(without @ (part @ log.residual[first:last]))
            left = np.diag(without)  # less than with the block: no row is left that shows it
            hangs |= (left > ALONE * white) | (left < 0.99 * white)
    covariance, freedom = spread_of(np.array(shifts) / size)
    covariance, freedom = widened(covariance, freedom, white / size**2, hangs, max(len(shifts) - len(size), 1))
    values, vectors = np.linalg.eigh(scaled)
    open_to = np.abs(vectors[:, values < SINGULAR * max(values[-1], 1e-300)]).max(axis=1, initial=0.0)
    loose = np.flatnonzero(open_to > LOOSE)
    covariance[loose, loose] = np.inf
    return covariance, freedom


def widened(
    covariance: FloatArray, freedom: FloatArray, white: FloatArray, hangs: Mask, blocks: int
) -> tuple[FloatArray, FloatArray]:
    """The covariance (p, p) with that of white residuals for what `hangs` on one block, and its freedom (p,).

    Args:
        covariance, freedom: from leaving out blocks.
        white: variances of white residuals, (p,).
        hangs: which parameters do, (p,).
        blocks: less the number of parameters: the freedom of those variances.
    """
    own = np.diag(covariance)
    usual = own[~hangs & (white > 0.0)] / white[~hangs & (white > 0.0)]
    floor = white * max(1.0, float(np.median(usual)) if len(usual) else 1.0)
    alone = np.flatnonzero(hangs)
    covariance, freedom = covariance.copy(), freedom.copy()
    covariance[alone, :] = covariance[:, alone] = 0.0
    covariance[alone, alone] = floor[alone]
    freedom[alone] = blocks
    return covariance, freedom


def spread_of(shifts: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Covariance (p, p) of values that move by `shifts` (blocks, p) where one block is left out, and its freedom (p,).

    The degrees of freedom are Satterthwaite's, of a sum of squares of unequal size.
    """
    table = shifts - shifts.mean(axis=0)
    blocks, p = table.shape
    sizes = np.abs(table).max(axis=0)
    parts = (table / np.where(sizes > 0.0, sizes, 1.0)) ** 2
    freedom = 3.0 * parts.sum(axis=0) ** 2 / np.maximum((parts**2).sum(axis=0), 1e-300)
    return np.asarray(table.T @ table * (blocks - 1) / blocks), np.clip(freedom, 1.0, max(blocks - p, 1))


def least_squares(columns: FloatArray, row: FloatArray, rcond: float = 1e-10) -> FloatArray:
    """Weights (p,) of columns (p, n) that make a row (n,), scaled so that units do not matter."""
    size = np.sqrt(np.einsum("ij,ij->i", columns, columns))
    size[size == 0.0] = 1.0
    scaled = columns / size[:, None]
    return np.asarray(np.linalg.pinv(scaled @ scaled.T, rcond=rcond, hermitian=True) @ (scaled @ row) / size)


def fit(
    model: Model,
    paths: Sequence[str],
    logs: Sequence[Residuals],
    *,
    iterations: int = 15,
    tolerance: float = 1e-3,
    floors: Mapping[str, float] | None = None,
    ceilings: Mapping[str, float] | None = None,
) -> Estimate:
    """Least squares of the whitened residuals of all logs together, by Gauss and Newton with step halving.

    The whitening filters are estimated anew in each iteration, one a log; each log weighs by its own whitened rms.

    Args:
        model: where to start.
        paths: of the free parameters.
        logs: what it is held against.
        iterations: at most.
        tolerance: of the last step, in 1-sigma.
        floors, ceilings: values below and above which a parameter does not go, by path.

    Raises:
        DivergedError: the model diverges on a log.
    """
    scales = Scales.largest(log.scales for log in logs)
    done = 0
    while True:
        known = parameters_of(model, together=True)
        parameters = [known[path] for path in paths]
        residuals, columns = columns_of(model, parameters, logs, scales)
        seen = [whitened(log, r, c) for log, r, c in zip(logs, residuals, columns, strict=True)]
        with np.errstate(over="ignore", invalid="ignore"):  # refused in the next line
            curvature = np.asarray(sum(s.columns @ s.columns.T for s in seen))
            gradient = np.asarray(sum(s.columns @ s.residual for s in seen))
        if not (np.isfinite(curvature).all() and np.isfinite(gradient).all()):
            raise DivergedError(_unbounded(paths, curvature, gradient))
        values = np.array([p.value for p in parameters])
        if done >= iterations or not paths:
            break
        size = np.sqrt(np.maximum(np.diag(curvature), 1e-300))
        scaled = curvature / np.outer(size, size)
        step = -np.linalg.pinv(scaled, rcond=SINGULAR, hermitian=True) @ (gradient / size) / size
        done += 1
        moved, length = _move(
            model, parameters, step, logs, residuals, [s.coefficients for s in seen], floors or {}, ceilings or {}
        )
        model = moved
        deviation = np.sqrt(np.diag(np.linalg.pinv(scaled, hermitian=True))) / size
        if length == 0.0 or np.all(np.abs(length * step) < tolerance * deviation + 1e-12 * np.abs(values)):
            iterations = done  # one more look, at the values themselves
    return Estimate(tuple(paths), values, *jackknife(seen), model, tuple(residuals), tuple(seen), done)


def _unbounded(paths: Sequence[str], curvature: FloatArray, gradient: FloatArray) -> str:
    bad = ~(np.isfinite(np.diag(curvature)) & np.isfinite(gradient))
    worst = paths[int(np.argmax(bad))]
    return f"{worst}: what it changes in the motion leaves all bounds: the logs cannot be of this model"


def _move(
    model: Model,
    parameters: Sequence[Parameter],
    step: FloatArray,
    logs: Sequence[Residuals],
    residuals: Sequence[FloatArray],
    filters: Sequence[FloatArray],
    floors: Mapping[str, float],
    ceilings: Mapping[str, float],
) -> tuple[Model, float]:
    """The model after the longest of the steps 1, 1/2, 1/4, ... that lowers the cost under the same filters."""

    def cost(values: Sequence[FloatArray]) -> float:
        total = 0.0
        for log, residual, a in zip(logs, values, filters, strict=True):
            white = np.asarray(whiten(residual[None, :], list(a)))[0, log.counts > 0]
            with np.errstate(over="ignore", invalid="ignore"):  # a step too far: an infinite cost refuses it
                total += len(white) * float(np.log(np.mean(white**2)))
        return total

    before = cost(residuals)
    length = 1.0
    while length > 1e-3:
        values = {
            p.path: min(max(p.clipped(p.value + length * s), floors.get(p.path, -np.inf)), ceilings.get(p.path, np.inf))
            for p, s in zip(parameters, step, strict=True)
        }
        try:
            moved = with_values(model, values)
            after = cost([log.of([moved])[0] for log in logs])
            if np.isfinite(after) and after <= before:
                return moved, length
        except (ValueError, DivergedError):
            pass
        length *= 0.5
    return model, 0.0
