"""Evidence: whitened residuals of logs under a model, freed of all that re-tuning the model could explain."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np
import numpy.typing as npt

from cogging._core import Prediction
from cogging.arrays import FloatArray
from cogging.diagnosis.evidence.column_memory import ColumnMemory
from cogging.diagnosis.evidence.noise_filter import (
    Filter,
    bands,
    filtered,
    periodogram,
    periodogram_length,
)
from cogging.diagnosis.evidence.score_test import Explained, ScoreTest
from cogging.diagnosis.thresholds import SCORE_TEST
from cogging.estimation.innovations import Innovations
from cogging.linear import row_sizes, solved
from cogging.model.model import Model
from cogging.model.parameters import Scales


@dataclass(frozen=True)
class Unweighted:
    """What a fit says of one log before anything is whitened.

    Attributes:
        along: prediction of the model.
        residual: innovations in force units, V, (n,).
        columns: derivatives by the free parameters and shapes of slow friction, V per unit, (p + 6, n).
    """

    along: Prediction
    residual: FloatArray
    columns: FloatArray


def joined(parts: Sequence[FloatArray]) -> FloatArray:
    """Columns (p, n of a log) of all logs, the rows of one after those of the other, (p, n)."""
    return parts[0] if len(parts) == 1 else np.concatenate(parts, axis=1)


@dataclass(frozen=True)
class Evidence:
    """Logs under one model, whitened and projected.

    Attributes:
        model: fitted model.
        sources: logs as the model predicts them, one a log.
        filters: filters that make each log's residual white.
        residual: residual whitened to rms 1, rows of all logs one after the other, 0 where the mask is, (n,).
        basis: orthonormal rows that span what the free parameters could explain, (q, n).
        columns: whitened columns of the free parameters and of the shapes of slow friction, (p + 6, n).
        block: number of the block of each row, (n,).
        parts: residuals and columns before they were whitened, one a log.
        memory: columns of effects with a memory, as predicted under an earlier model of these logs.
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
    memory: ColumnMemory
    turns: bool = True

    @property
    def residuals(self) -> tuple[FloatArray, ...]:
        """Not whitened, V, one (n,) a log."""
        return tuple(part.residual for part in self.parts)

    @property
    def alongs(self) -> tuple[Prediction, ...]:
        """The model's prediction along each log."""
        return tuple(part.along for part in self.parts)

    def unwhitened_fit(self, tables: Sequence[FloatArray]) -> tuple[FloatArray, float]:
        """Amplitudes (p,) of columns (p, n of a log) that make the gap itself smallest, and the share they explain.

        Nothing is whitened here: what is slow and large is taken for noise by filters, and hardly seen beside what is
        fast.
        """
        rows = [np.vstack([part.columns, table]) for part, table in zip(self.parts, tables, strict=True)]
        for its, source in zip(rows, self.sources, strict=True):
            its *= source.mask
        columns = joined(rows)
        gap = np.concatenate(
            [part.residual * source.mask for source, part in zip(self.sources, self.parts, strict=True)]
        )
        size = row_sizes(columns)
        columns /= size[:, None]
        gram, right = columns @ columns.T, columns @ gap
        own = len(columns) - len(tables[0])  # of the free parameters
        tuned = gap - solved(gram[:own, :own], right[:own]) @ columns[:own]
        weights = solved(gram, right)
        left = gap - weights @ columns
        return (weights / size)[own:], 1.0 - float(left @ left) / max(float(tuned @ tuned), 1e-300)

    @cached_property
    def freedom(self) -> tuple[tuple[list[slice], FloatArray], ...]:
        """Of each log, bands of its periodogram and degrees of freedom by which the level of each is known."""
        result, start = [], 0
        for source in self.sources:
            n = len(source.log)
            length = periodogram_length(n)
            parts = bands(np.asarray(np.fft.rfftfreq(length, source.scales.sample_time)))
            taken = np.zeros(length // 2 + 1)
            for row in self.basis:
                taken += 2.0 / length * np.abs(np.fft.rfft(row[start : start + n], length)) ** 2
            lines = 2.0 * float(source.mask.sum()) / length
            free = [lines * (part.stop - part.start) - float(taken[part].sum()) for part in parts]
            result.append((parts, np.maximum(np.array(free), 1.0)))
            start += n
        return tuple(result)

    def bounded(self, test: ScoreTest) -> float:
        """T allowed for levels of noise that are known from few lines: sum over bands of d ln(1 + T_band / d).

        It is the likelihood ratio with the level of each band free; d are its degrees of freedom, less those that the
        columns take there.
        """
        each, freedoms = self.band_powers(test.explained)
        total = max(float(np.sum(each)), 1e-300)
        d = np.maximum(freedoms - test.freedom * each / total, 1.0)
        return float(np.sum(d * np.log1p(each / d)))

    def band_powers(self, explained: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Power of a row (n,) in each band of each log, over the overdispersion; and the bands' degrees of freedom."""
        powers, freedoms, start = [], [], 0
        for source, (parts, freedom) in zip(self.sources, self.freedom, strict=True):
            n = len(source.log)
            length = periodogram_length(n)
            power = np.abs(np.fft.rfft(explained[start : start + n], length)) ** 2 / (length * self.overdispersion)
            powers += [float(power[0]) + 2.0 * float(power[parts[0]].sum())]
            powers += [2.0 * float(power[part].sum()) for part in parts[1:]]
            freedoms += list(freedom)
            start += n
        return np.array(powers), np.array(freedoms)

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
            power = float(np.mean((part.residual[source.mask > 0] / source.scale) ** 2))
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
            low = power[(frequency > SCORE_TEST.effects_above) & (frequency < SCORE_TEST.effects_below)]
            if len(low) > SCORE_TEST.scatter_lines:
                worst = max(worst, float(np.median(low) / np.log(2.0)))
        return worst

    def whitened(self, tables: Sequence[FloatArray]) -> FloatArray:
        """Columns (p, n of a log), one table a log, as this evidence sees them: whitened, not yet projected, (p, n)."""
        parts = [
            filtered(table, source, filter_)
            for source, filter_, table in zip(self.sources, self.filters, tables, strict=True)
        ]
        return joined(parts)

    def project(self, columns: FloatArray) -> FloatArray:
        """Take from whitened columns (p, n) what the free parameters could explain."""
        return columns - (columns @ self.basis.T) @ self.basis

    def test(self, columns: FloatArray) -> ScoreTest:
        """Score test of whitened columns (p, n): how much of the residual they explain that re-tuning cannot."""
        test = self.tests(columns, [len(columns)])[0]
        return replace(test, part=test.explained)

    def tests(self, columns: FloatArray, sizes: Sequence[int]) -> list[ScoreTest]:
        """Score tests of several candidates, whose whitened columns (sum of the sizes, n) follow each other.

        What each explains is made from the columns where it is asked for; it holds them until then.
        """
        shares = columns @ self.basis.T  # of what the free parameters could explain, (p, q)
        scores = columns @ self.free_residual
        ends = np.cumsum(sizes)
        parts = [slice(int(end) - size, int(end)) for size, end in zip(sizes, ends, strict=True)]
        return [self._test(columns[part], shares[part], scores[part]) for part in parts]

    def _test(self, columns: FloatArray, shares: FloatArray, scores: FloatArray) -> ScoreTest:
        gram = columns @ columns.T
        size = np.sqrt(np.diag(gram))
        gram -= shares @ shares.T
        left = np.sqrt(np.maximum(np.diag(gram), 0.0))
        # The rest is what linear columns cannot tell.
        seen = left > SCORE_TEST.untuned_share * np.where(size > 0.0, size, 1.0)
        amplitudes = np.zeros(len(columns))
        deviations = np.full(len(columns), np.inf)
        if not seen.any():
            return ScoreTest(0.0, 0, amplitudes, Explained(lambda: np.zeros(len(self.residual))), deviations)
        values, vectors = np.linalg.eigh(gram[np.ix_(seen, seen)] / np.outer(left[seen], left[seen]))
        good = values > SCORE_TEST.column_rank
        inverse = (vectors[:, good] / values[good]) @ vectors[:, good].T
        score = scores[seen] / left[seen]
        solution = inverse @ score
        amplitudes[seen] = solution / left[seen]
        deviations[seen] = np.sqrt(np.diag(inverse) * self.overdispersion) / left[seen]
        return ScoreTest(
            float(score @ solution) / self.overdispersion,
            int(good.sum()),
            amplitudes,
            Explained(lambda: amplitudes @ columns - (amplitudes @ shares) @ self.basis),
            deviations,
        )
