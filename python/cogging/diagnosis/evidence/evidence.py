"""What logs say against a model: whitened residuals, freed of all that re-tuning the model could explain."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np
import numpy.typing as npt

from cogging._core import Prediction, whiten
from cogging.arrays import FloatArray
from cogging.diagnosis.evidence.noise_filter import (
    CLIP,
    Filter,
    bands,
    coloured,
    filtered,
    periodogram,
    robust_rms,
    spectrum,
)
from cogging.estimation.gauss_newton import Estimate, columns_of
from cogging.estimation.innovations import Innovations
from cogging.estimation.residuals import quiet_plant
from cogging.estimation.statistics import least_squares
from cogging.estimation.whitening import BLOCK, whitening_filter
from cogging.identification.inverse_dynamics import fast_length
from cogging.model.model import Model
from cogging.model.parameters import Scales, parameters_of

TOGETHER = 8  # columns that are whitened at once
GLITCH = 20.0  # rms of the whitened residual, beyond which a row is no effect


@dataclass(frozen=True)
class Evidence:
    """Logs under one model, whitened and projected.

    Attributes:
        model: that was fitted.
        sources: one a log.
        filters: that make each log's residual white.
        residual: whitened to rms 1, rows of all logs one after the other, 0 where none counts, (n,).
        basis: orthonormal, spans what the free parameters could explain, (q, n).
        columns: whitened, of the free parameters and of the shapes of slow friction, (p + 6, n).
        block: number of the block of each row, (n,).
        parts: what was whitened, one a log.
        memory: what effects with a memory do, as predicted under an earlier model of these logs.
        turns: whether a wave along the travel may come with another phase than in the logs it was found in.
    """

    model: Model
    sources: tuple[Innovations, ...]
    filters: tuple[Filter, ...]
    residual: FloatArray
    basis: FloatArray
    columns: FloatArray
    block: npt.NDArray[np.int64]
    parts: tuple[Unweighted, ...]
    memory: dict[Any, list[FloatArray]]
    turns: bool = True

    @property
    def residuals(self) -> tuple[FloatArray, ...]:
        """Not whitened, V, one (n,) a log."""
        return tuple(part.residual for part in self.parts)

    @property
    def alongs(self) -> tuple[Prediction, ...]:
        """The model's prediction along each log."""
        return tuple(part.along for part in self.parts)

    def cleaned(self, explained: Sequence[FloatArray]) -> Evidence:
        """The evidence with filters from what an effect leaves: a strong effect would else be taken for noise.

        Args:
            explained: V, one (n,) a log, taken from the residual before the filters are estimated.
        """
        return weighed(self.model, self.sources, self.parts, explained, self.memory)

    def unwhitened_fit(self, tables: Sequence[FloatArray]) -> tuple[FloatArray, float]:
        """Amplitudes (p,) of columns (p, n of a log) that make the gap itself smallest, and the share they explain.

        Nothing is whitened here: what is slow and large is taken for noise by filters, and hardly seen beside what is
        fast.
        """
        rows, right = [], []
        for source, part, table in zip(self.sources, self.parts, tables, strict=True):
            rows.append(np.vstack([part.columns, table]) * source.counts)
            right.append(part.residual * source.counts)
        columns, gap = np.concatenate(rows, axis=1), np.concatenate(right)
        p = len(tables[0])
        tuned = gap - least_squares(columns[:-p], gap) @ columns[:-p]
        weights = least_squares(columns, gap)
        left = gap - weights @ columns
        return weights[-p:], 1.0 - float(left @ left) / max(float(tuned @ tuned), 1e-300)

    @cached_property
    def freedom(self) -> tuple[tuple[list[slice], FloatArray], ...]:
        """Of each log, bands of its periodogram and degrees of freedom by which the level of each is known."""
        result, start = [], 0
        for source in self.sources:
            n = len(source.log)
            length = fast_length(n)
            parts = bands(np.asarray(np.fft.rfftfreq(length, source.scales.sample_time)))
            taken = np.zeros(length // 2 + 1)
            for row in self.basis:
                taken += 2.0 / length * np.abs(np.fft.rfft(row[start : start + n], length)) ** 2
            lines = 2.0 * float(source.counts.sum()) / length
            free = [lines * (part.stop - part.start) - float(taken[part].sum()) for part in parts]
            result.append((parts, np.maximum(np.array(free), 1.0)))
            start += n
        return tuple(result)

    def bounded(self, test: Test) -> float:
        """T allowed for levels of noise that are known from few lines: sum over bands of d ln(1 + T_band / d).

        It is the likelihood ratio with the level of each band free; d are its degrees of freedom, less those that the
        columns take there.
        """
        powers, freedoms, start = [], [], 0
        for source, (parts, freedom) in zip(self.sources, self.freedom, strict=True):
            n = len(source.log)
            length = fast_length(n)
            power = np.abs(np.fft.rfft(test.explained[start : start + n], length)) ** 2 / (length * self.overdispersion)
            powers += [float(power[0]) + 2.0 * float(power[parts[0]].sum())]
            powers += [2.0 * float(power[part].sum()) for part in parts[1:]]
            freedoms += list(freedom)
            start += n
        each, total = np.array(powers), max(float(np.sum(powers)), 1e-300)
        d = np.maximum(np.array(freedoms) - test.freedom * each / total, 1.0)
        return float(np.sum(d * np.log1p(each / d)))

    @cached_property
    def scales(self) -> Scales:
        """Sizes over all logs."""
        return Scales.largest(source.scales for source in self.sources)

    @cached_property
    def rounding(self) -> float:
        """Share of the residual's power that the encoder's rounding makes, q^2 / 12 a reading, of the log with most.

        It goes with the motion: it is no noise that comes as it likes.
        """
        shares = [0.0]
        for source, part in zip(self.sources, self.parts, strict=True):
            power = float(np.mean((part.residual[source.counts > 0] / source.scale) ** 2))
            shares.append(self.model.encoder.resolution**2 / 12.0 / max(power, 1e-300))
        return min(1.0, max(shares))

    @cached_property
    def free_residual(self) -> FloatArray:
        """The whitened residual freed of what the free parameters explain, (n,)."""
        return self.residual - (self.basis @ self.residual) @ self.basis

    @cached_property
    def overdispersion(self) -> float:
        """Variance of the scores over that which white residuals would give them, at least 1.

        From the periodogram below 60 Hz, where effects are: its median level over one. What the filters left
        correlated there would otherwise pass as signal.
        """
        worst, start = 1.0, 0
        for source in self.sources:
            n = len(source.log)
            power, frequency = periodogram(self.free_residual[start : start + n], source)
            start += n
            low = power[(frequency > 0.5) & (frequency < 60.0)]
            if len(low) > 20:
                worst = max(worst, float(np.median(low) / np.log(2.0)))
        return worst

    def whitened(self, tables: Sequence[FloatArray]) -> FloatArray:
        """Columns (p, n of a log), one table a log, as this evidence sees them: whitened, not yet projected, (p, n)."""
        parts = [
            filtered(table, source, filter_)
            for source, filter_, table in zip(self.sources, self.filters, tables, strict=True)
        ]
        return np.concatenate(parts, axis=1)

    def whitened_each(self, made: Sequence[Sequence[FloatArray]]) -> Iterator[FloatArray]:
        """`whitened` of many tables; TOGETHER columns and more at a time, which is quicker than a few."""
        for first, last in groups([len(tables[0]) for tables in made], TOGETHER):
            parts = zip(*made[first:last], strict=True)
            white = self.whitened([np.concatenate(part) for part in parts])
            ends = np.cumsum([len(tables[0]) for tables in made[first:last]])
            yield from np.split(white, ends[:-1])

    def project(self, columns: FloatArray) -> FloatArray:
        """Take from whitened columns (p, n) what the free parameters could explain."""
        return columns - (columns @ self.basis.T) @ self.basis

    def test(self, columns: FloatArray) -> Test:
        """Score test of whitened columns (p, n): how much of the residual they explain that re-tuning cannot."""
        shares = columns @ self.basis.T  # of what the free parameters could explain, (p, q)
        gram = columns @ columns.T
        size = np.sqrt(np.diag(gram))
        gram -= shares @ shares.T
        left = np.sqrt(np.maximum(np.diag(gram), 0.0))
        seen = left > 2e-3 * np.where(size > 0.0, size, 1.0)  # the rest is what linear columns cannot tell
        amplitudes = np.zeros(len(columns))
        if not seen.any():
            return Test(0.0, 0, amplitudes, np.zeros(len(self.residual)), np.full(len(columns), np.inf))
        values, vectors = np.linalg.eigh(gram[np.ix_(seen, seen)] / np.outer(left[seen], left[seen]))
        good = values > 1e-4
        inverse = (vectors[:, good] / values[good]) @ vectors[:, good].T
        score = (columns @ self.free_residual)[seen] / left[seen]
        solution = inverse @ score
        amplitudes[seen] = solution / left[seen]
        deviations = np.full(len(columns), np.inf)
        deviations[seen] = np.sqrt(np.diag(inverse) * self.overdispersion) / left[seen]
        return Test(
            float(score @ solution) / self.overdispersion,
            int(good.sum()),
            amplitudes,
            amplitudes @ columns - (amplitudes @ shares) @ self.basis,
            deviations,
        )


@dataclass(frozen=True)
class Test:
    """A score test.

    Attributes:
        statistic: T, chi-square with `freedom` degrees of freedom where there is no effect.
        freedom: p.
        amplitudes: by which the columns would have to be multiplied, (p,), with the sign of the residual.
        explained: the part of the whitened residual that the columns explain, (n,).
        deviations: of each amplitude beside the others, (p,); infinite where nothing is seen of it.
    """

    statistic: float
    freedom: int
    amplitudes: FloatArray
    explained: FloatArray
    deviations: FloatArray


def groups(sizes: Sequence[int], together: int) -> Iterator[tuple[int, int]]:
    """First and last number (excluded) of neighbours that sum up to `together` or more, the last fewer."""
    first, total = 0, 0
    for i, size in enumerate(sizes):
        total += size
        if total >= together or i + 1 == len(sizes):
            yield first, i + 1
            first, total = i + 1, 0


def cosine(one: FloatArray, other: FloatArray) -> float:
    """Cosine between two rows, without sign."""
    size = float(np.sqrt((one @ one) * (other @ other)))
    return abs(float(one @ other)) / size if size > 0.0 else 0.0


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
    """Forces (V) of shapes that friction may have close to rest, odd in velocity, (6, n): nobody states them so well.

    S(v) is a convention. Where another machine's friction rises sooner or later, the difference fades over some widths,
    as exp(-(v / w)^2) or slower, as v w / (v^2 + w^2) does.
    """
    velocity = source.along.middle_velocity
    width = max(model.axis.coulomb_width, source.rest)
    shapes = [np.sign(velocity) * np.exp(-((velocity / (factor * width)) ** 2)) for factor in (0.5, 1.0, 2.0, 4.0)]
    shapes += [2.0 * velocity * w / (velocity**2 + w**2) for w in (width, 3.0 * width)]
    return np.array(shapes) * max(model.axis.coulomb, 1e-12)


@dataclass(frozen=True)
class Unweighted:
    """What a fit says of one log before anything is whitened.

    Attributes:
        along: the model's prediction.
        residual: V, (n,).
        columns: V per unit, of the free parameters and of the shapes of slow friction, (p + 6, n).
    """

    along: Prediction
    residual: FloatArray
    columns: FloatArray


def gather(
    estimate: Estimate,
    sources: Sequence[Innovations],
    memory: dict[Any, list[FloatArray]] | None = None,
    plain: bool = False,
) -> Evidence:
    """Make evidence of a fit: residuals, whitening, and the basis of all that the free parameters can explain.

    Args:
        estimate: the fit.
        sources: its logs.
        memory: of earlier evidence of these logs.
        plain: do not whiten: all frequencies weigh as they do in the gap itself.
    """
    model = estimate.model
    known = parameters_of(model, together=True)
    scales = Scales.largest(source.scales for source in sources)
    residuals, columns = columns_of(model, [known[path] for path in estimate.paths], sources, scales)
    parts, memory = [], {} if memory is None else memory
    for i, source in enumerate(sources):
        along = source.predictor.predict(quiet_plant(model))
        shapes = source.rows_of_forces(along, slow_friction(source, model), model.axis.mass)
        parts.append(Unweighted(along, residuals[i], np.vstack([columns[i], shapes])))
    return weighed(model, sources, parts, [np.zeros(len(source.log)) for source in sources], memory, plain)


def weighed(
    model: Model,
    sources: Sequence[Innovations],
    parts: Sequence[Unweighted],
    explained: Sequence[FloatArray],
    memory: dict[Any, list[FloatArray]],
    plain: bool = False,
) -> Evidence:
    """Whiten; the filters come from the residuals less what is `explained` (V, one (n,) a log)."""
    rows, bases, blocks, filters = [], [], [], []
    offset = 0
    for source, part, taken in zip(sources, parts, explained, strict=True):
        noise = part.residual - taken
        a = np.zeros(1) if plain else whitening_filter(source, noise - refitted(source, part, noise))
        table = np.asarray(whiten(np.vstack([noise[None, :], part.residual[None, :], part.columns]), list(a)))
        rms = robust_rms(table[0, source.counts > 0])
        table *= source.counts / rms
        table[0] = np.clip(table[0], -CLIP, CLIP)
        table[1] = np.clip(table[1], -GLITCH, GLITCH)
        basis = orthonormal(table[2:])
        level = spectrum(table[0] - (basis @ table[0]) @ basis, source)
        filter_ = Filter(a, rms, level[0], np.ones_like(level[1]) if plain else level[1])
        table = coloured(table[1:], source, filter_)
        rows.append(table[0])
        bases.append(table[1:])
        block = np.floor((source.log.time - source.log.time[0]) / BLOCK).astype(np.int64)
        blocks.append(block + offset)
        offset += int(block[-1]) + 1
        filters.append(filter_)
    columns = np.concatenate(bases, axis=1)
    return Evidence(
        model,
        tuple(sources),
        tuple(filters),
        np.concatenate(rows),
        orthonormal(columns),
        columns,
        np.concatenate(blocks),
        tuple(parts),
        memory,
    )


def refitted(source: Innovations, part: Unweighted, noise: FloatArray) -> FloatArray:
    """What re-tuning makes of a residual (V, (n,)) from which an effect was taken: it had made up for the effect."""
    a = whitening_filter(source, noise)
    table = np.asarray(whiten(np.vstack([noise[None, :], part.columns]), list(a))) * source.counts
    return np.asarray(least_squares(table[1:], table[0], rcond=1e-9) @ part.columns)
