"""What a log of a planned motion would say: evidence of a model that lacks an effect, and what the effect does."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from cogging.arrays import FloatArray
from cogging.diagnosis.candidates.findings import Finding
from cogging.diagnosis.candidates.signatures import Candidate, candidates, place
from cogging.diagnosis.candidates.tables import tables, whitened_each
from cogging.diagnosis.candidates.waves import is_spatial_wave, is_wave, wave_of, wave_range
from cogging.diagnosis.evidence.column_memory import ColumnMemory
from cogging.diagnosis.evidence.evidence import Evidence, Unweighted
from cogging.diagnosis.evidence.gather import slow_friction, weighed
from cogging.diagnosis.evidence.noise_filter import periodogram_length
from cogging.diagnosis.evidence.null import sources_of
from cogging.diagnosis.evidence.score_test import ScoreTest
from cogging.diagnosis.thresholds import EXPERIMENT
from cogging.effects.effect import Effect, Wave, kind_of
from cogging.estimation.gauss_newton import columns_of
from cogging.logs.log import Log
from cogging.model.model import Model
from cogging.model.parameters import parameters_of


def evidence_of(log: Log, model: Model, paths: Sequence[str], rest: float, truth: Model) -> tuple[Evidence, FloatArray]:
    """Evidence of a model that lacks an effect, and the whitened residual that the effect alone leaves, (n,).

    The filters are those of the noise: they come from what the model with the effect leaves.

    Args:
        log: simulated, with the effect and noise.
        model: model without the effect.
        paths: parameters of it that a fit would re-tune.
        rest: speed below which rows do not count, m/s.
        truth: model with the effect.

    Raises:
        DivergedError: a model diverges on the log.
        NothingCounts: no row shows the axis in motion.
    """
    source = sources_of([log], model, rest=rest, quick=True)[0]
    known = parameters_of(model, together=True)
    residuals, columns = columns_of(model, [known[path] for path in paths], [source], source.scales)
    shapes = source.rows_of_forces(source.along, slow_friction(source, model), model.axis.mass)
    part = Unweighted(source.along, residuals[0], np.vstack([columns[0], shapes]))
    signal = residuals[0] - (residuals[0] if truth == model else source.of([truth])[0])
    evidence = weighed(model, [source], [part], [signal], ColumnMemory())
    return evidence, evidence.whitened([signal[None, :]])[0]


def as_residual(evidence: Evidence, signal: FloatArray) -> Evidence:
    """The evidence as it would be if the whitened signal were all that is left: what a scan then finds is its mean."""
    other = replace(evidence, residual=signal)
    other.__dict__["overdispersion"] = evidence.overdispersion  # of the noise, not of the signal
    return other


def left_by(evidence: Evidence, finding: Finding) -> FloatArray:
    """What a finding leaves of the whitened residual, freed of what the free parameters explain, (n,).

    An effect that its shape alone makes takes what that shape says, no more and no less.
    """
    if finding.candidate.amplitudes:
        return np.asarray(evidence.free_residual - finding.test.explained)
    column = evidence.whitened(tables(evidence, [finding.candidate])[0])
    return np.asarray(evidence.free_residual + evidence.project(column)[0])


def louder(evidence: Evidence, added: FloatArray) -> float:
    """2 ln likelihood that is lost where so much (n,) is left beside white noise, the level of each band free.

    sum over bands of d ln(1 + |added|^2 / d), as for the bounded T of an effect.
    """
    none = np.zeros(1)
    return min(float(added @ added) / evidence.overdispersion, evidence.bounded(ScoreTest(0.0, 1, none, added, none)))


def band_powers(evidence: Evidence, rows: FloatArray) -> FloatArray:
    """Power of whitened rows (n,) in each band of each log, as Evidence.freedom has them."""
    powers: list[float] = []
    start = 0
    for source, (parts, _) in zip(evidence.sources, evidence.freedom, strict=True):
        n = len(source.log)
        length = periodogram_length(n)
        power = np.abs(np.fft.rfft(rows[start : start + n], length)) ** 2 / length
        powers += [2.0 * float(power[part].sum()) for part in parts]
        start += n
    return np.asarray(np.maximum(np.array(powers), 1e-300))


def gram_of(evidence: Evidence, signal: FloatArray, wanted: Sequence[Candidate]) -> FloatArray:
    """Products of the signal, the free parameters' columns and those of candidates, in that order, over phi, (q, q)."""
    rows = [signal[None, :], evidence.columns]
    rows += whitened_each(evidence, wanted)
    table = np.vstack(rows)
    return np.asarray(table @ table.T / evidence.overdispersion)


def freed(gram: FloatArray, free: Sequence[int]) -> FloatArray:
    """A Gram matrix without what some of its columns explain of the others (their own rows become 0)."""
    index = np.asarray(free, dtype=int)
    inner, outer = gram[np.ix_(index, index)], gram[index]
    size = np.sqrt(np.maximum(np.diag(inner), 1e-300))
    inverse = np.linalg.pinv(inner / np.outer(size, size), rcond=EXPERIMENT.column_singular, hermitian=True)
    scaled = outer / size[:, None]
    return np.asarray(gram - scaled.T @ inverse @ scaled)


def looked_for(evidence: Evidence, law: Effect, other: Effect | None = None) -> list[Candidate]:
    """The shapes of an effect at which it is looked for on any motion; a wave also at the period of another effect."""
    period = _period(other)
    if not is_wave(law):
        return list(candidates(evidence, law, [] if period is None else [period]))
    low, high = wave_range(evidence, law)
    if is_spatial_wave(law):
        ends = place(evidence)
        values = [turns / (ends[1] - ends[0]) for turns in EXPERIMENT.turns_tried]
        if period is not None:
            near = np.array([-0.5, -0.25, 0.0, 0.25, 0.5]) / (ends[1] - ends[0])
            values += [float(one) for one in 1.0 / period + near if one > 0.0]
        return [wave_of(evidence, law, 1.0 / value) for value in values if low <= value <= high]
    values = [cycles / evidence.scales.time for cycles in EXPERIMENT.cycles_tried]
    return [wave_of(evidence, law, value) for value in values if low <= value <= high]


def _period(effect: Effect | None) -> float | None:
    """Of what has a period along the travel, m."""
    wave = None if effect is None else kind_of(effect, Wave)
    if effect is None or wave is None or effect.ROLES[wave.shape]["quantity"] != "distance":
        return None
    return float(getattr(effect, wave.shape))
