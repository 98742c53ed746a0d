"""What logs say against a model: whitened residuals, freed of all that re-tuning the model could explain."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np
import numpy.typing as npt

from cogging._core import whiten
from cogging.estimation import BLOCK, Estimate, columns_of, combined_scales, whitening_filter
from cogging.model import Model
from cogging.parameters import Scales, parameters_of
from cogging.residuals import Innovations

FloatArray = npt.NDArray[np.float64]

CLIP = 6.0  # whitened residuals beyond this many rms are outliers, and are cut there


@dataclass(frozen=True)
class Evidence:
    """Logs under one model, whitened and projected.

    Attributes:
        model: that was fitted.
        sources: one a log.
        filters: autoregressive coefficients, one a log.
        rms: of each log's whitened residual, V.
        residual: whitened, over its log's rms, rows that count of all logs one after the other, (n,).
        basis: orthonormal, spans what the free parameters could explain, (q, n).
        block: number of the block of each row, (n,).
        residuals: not whitened, V, one (n,) a log.
    """

    model: Model
    sources: tuple[Innovations, ...]
    filters: tuple[FloatArray, ...]
    rms: tuple[float, ...]
    residual: FloatArray
    basis: FloatArray
    block: npt.NDArray[np.int64]
    residuals: tuple[FloatArray, ...]

    @cached_property
    def scales(self) -> Scales:
        """Sizes over all logs."""
        return combined_scales(self.sources)

    @cached_property
    def free_residual(self) -> FloatArray:
        """The whitened residual freed of what the free parameters explain, (n,)."""
        return self.residual - (self.basis @ self.residual) @ self.basis

    @cached_property
    def excess(self) -> float:
        """By how much scores scatter more than white residuals would make them, at least 1.

        From the periodogram of the whitened residual below 100 Hz, where effects are: its median level over the mean of
        all of it. What the filter left correlated there would otherwise pass as signal.
        """
        worst = 1.0
        start = 0
        for source in self.sources:
            rows = int((source.counts > 0).sum())
            part = self.free_residual[start : start + rows]
            start += rows
            power = np.abs(np.fft.rfft(part)) ** 2 / max(rows, 1)
            frequency = np.fft.rfftfreq(rows, source.scales.sample_time)
            low = power[(frequency > 0.5) & (frequency < 60.0)]
            if len(low) > 20:
                worst = max(worst, float(np.median(low) / np.log(2.0) / np.mean(part**2)))
        return worst

    def whitened(self, tables: Sequence[FloatArray]) -> FloatArray:
        """Columns (p, n of a log), one table a log, as this evidence sees them: whitened, not yet projected, (p, n)."""
        parts = []
        for source, a, rms, table in zip(self.sources, self.filters, self.rms, tables, strict=True):
            parts.append(np.asarray(whiten(table, list(a)))[:, source.counts > 0] / rms)
        return np.concatenate(parts, axis=1)

    def project(self, columns: FloatArray) -> FloatArray:
        """Take from whitened columns (p, n) what the free parameters could explain."""
        return columns - (columns @ self.basis.T) @ self.basis

    def test(self, columns: FloatArray) -> Test:
        """Score test of whitened columns (p, n): how much of the residual they explain that re-tuning cannot."""
        free = self.project(columns)
        size = np.sqrt(np.einsum("ij,ij->i", columns, columns))
        left = np.sqrt(np.einsum("ij,ij->i", free, free))
        seen = left > 1e-3 * np.where(size > 0.0, size, 1.0)  # the rest is rounding
        amplitudes = np.zeros(len(columns))
        if not seen.any():
            return Test(0.0, 0, amplitudes, 0.0, np.zeros(len(self.residual)))
        gram = free[seen] @ free[seen].T / np.outer(left[seen], left[seen])
        values, vectors = np.linalg.eigh(gram)
        good = values > 1e-4
        inverse = (vectors[:, good] / values[good]) @ vectors[:, good].T
        score = free[seen] @ self.free_residual / left[seen]
        solution = inverse @ score
        amplitudes[seen] = solution / left[seen]
        return Test(
            float(score @ solution) / self.excess,
            int(good.sum()),
            amplitudes,
            float(np.sqrt(np.diag(inverse))[0] / left[seen][0]) * np.sqrt(self.excess),
            solution / left[seen] @ free[seen],
        )


@dataclass(frozen=True)
class Test:
    """A score test.

    Attributes:
        statistic: T, chi-square with `freedom` degrees of freedom where there is no effect.
        freedom: p.
        amplitudes: by which the columns would have to be multiplied, (p,), with the sign of the residual.
        deviation: of the first of them.
        explained: the part of the whitened residual that the columns explain, (n,).
    """

    statistic: float
    freedom: int
    amplitudes: FloatArray
    deviation: float
    explained: FloatArray


def orthonormal(columns: FloatArray) -> FloatArray:
    """An orthonormal basis (q, n) of rows (p, n), directions lost to rounding left out."""
    if len(columns) == 0:
        return columns
    size = np.sqrt(np.einsum("ij,ij->i", columns, columns))
    rows = columns[size > 0.0] / size[size > 0.0, None]
    values, vectors = np.linalg.eigh(rows @ rows.T)
    good = values > 1e-9 * max(values[-1], 1e-300)
    return np.asarray((vectors[:, good] / np.sqrt(values[good])).T @ rows)


def slow_friction(source: Innovations, model: Model) -> FloatArray:
    """Forces (V) of shapes that friction may have close to rest, odd in velocity, (3, n): nobody states them so well.

    S(v) is a convention. Where another machine's friction rises sooner or later, the difference has faded at some
    widths; exp(-(v / w)^2) sgn(v) at 1, 2 and 4 widths spans such differences.
    """
    velocity = source.along.middle_velocity
    width = max(model.axis.coulomb_width, source.rest)
    shapes = [np.sign(velocity) * np.exp(-((velocity / (factor * width)) ** 2)) for factor in (1.0, 2.0, 4.0)]
    return np.array(shapes) * max(model.axis.coulomb, 1e-12)


def gather(
    estimate: Estimate, sources: Sequence[Innovations], *, filters: Sequence[FloatArray] | None = None
) -> Evidence:
    """Make evidence of a fit: residuals, whitening, and the basis of all that the free parameters can explain."""
    model = estimate.model
    known = parameters_of(model)
    scales = combined_scales(sources)
    residuals, columns = columns_of(model, [known[path] for path in estimate.paths], sources, scales)
    whole, rows, blocks, rms_all, used = [], [], [], [], []
    offset = 0
    for i, source in enumerate(sources):
        along = source.predictor.predict(model_plant(model))
        shapes = source.scale * source.predictor.propagate(along, model.axis.mass, slow_friction(source, model))
        a = whitening_filter(source, residuals[i]) if filters is None else filters[i]
        table = np.asarray(whiten(np.vstack([residuals[i][None, :], columns[i], shapes]), list(a)))
        counted = source.counts > 0
        rms = robust_rms(table[0, counted])
        whole.append(table[1:, counted] / rms)
        rows.append(np.clip(table[0, counted] / rms, -CLIP, CLIP))
        block = np.floor(source.log.time[counted] / BLOCK).astype(np.int64)
        blocks.append(block - block[0] + offset)
        offset += int(block[-1] - block[0]) + 1
        rms_all.append(rms)
        used.append(a)
    return Evidence(
        model,
        tuple(sources),
        tuple(used),
        tuple(rms_all),
        np.concatenate(rows),
        orthonormal(np.concatenate(whole, axis=1)),
        np.concatenate(blocks),
        tuple(residuals),
    )


def robust_rms(values: FloatArray) -> float:
    """Rms with outliers cut at 6 times the median size."""
    limit = CLIP * 1.4826 * float(np.median(np.abs(values)))
    rms = float(np.sqrt(np.mean(np.clip(values, -limit, limit) ** 2))) if limit > 0 else float(values.std())
    return rms if rms > 0.0 else 1.0


def model_plant(model: Model):  # type: ignore[no-untyped-def]
    """The plant that predicts, without quantiser and noise."""
    from cogging.residuals import quiet

    return quiet(model).plant()


__all__ = ["Evidence", "Test", "gather"]
