"""Evidence gathered from a fit: residuals, the filters that whiten them, and what the free parameters could explain."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from cogging._core import whiten
from cogging.arrays import FloatArray
from cogging.diagnosis.evidence.column_memory import ColumnMemory
from cogging.diagnosis.evidence.evidence import Evidence, Unweighted, joined
from cogging.diagnosis.evidence.noise_filter import Filter, coloured, robust_rms, spectrum
from cogging.diagnosis.evidence.score_test import orthonormal
from cogging.diagnosis.thresholds import WHITENING
from cogging.estimation.gauss_newton import Estimate, columns_of
from cogging.estimation.innovations import Innovations
from cogging.estimation.whitening import BLOCK, whitening_filter
from cogging.linear import least_squares_of_long_rows
from cogging.model.model import Model
from cogging.model.parameters import Scales, parameters_of


def gather(
    estimate: Estimate,
    sources: Sequence[Innovations],
    memory: ColumnMemory | None = None,
    plain: bool = False,
) -> Evidence:
    """Make evidence of a fit: residuals, whitening, and the basis of all that the free parameters can explain.

    Args:
        estimate: fit of the model.
        sources: logs that it was fitted to.
        memory: columns of earlier evidence of these logs (see Evidence).
        plain: whether not to whiten: all frequencies then weigh as they do in the gap itself.
    """
    model = estimate.model
    known = parameters_of(model, together=True)
    scales = Scales.largest(source.scales for source in sources)
    residuals, columns = columns_of(model, [known[path] for path in estimate.paths], sources, scales)
    parts, memory = [], ColumnMemory() if memory is None else memory
    for i, source in enumerate(sources):
        along = source.prediction(model)
        shapes = source.rows_of_forces(along, slow_friction(source, model), model.axis.mass)
        parts.append(Unweighted(along, residuals[i], np.vstack([columns[i], shapes])))
    return weighed(model, sources, parts, [np.zeros(len(source.log)) for source in sources], memory, plain)


def refiltered(evidence: Evidence, explained: Sequence[FloatArray]) -> Evidence:
    """The evidence with filters from what an effect leaves: a strong effect would else be taken for noise.

    Args:
        evidence: residuals, columns and earlier filters.
        explained: force (V), one (n,) a log, taken from the residual before the filters are estimated.
    """
    return weighed(evidence.model, evidence.sources, evidence.parts, explained, evidence.memory)


def weighed(
    model: Model,
    sources: Sequence[Innovations],
    parts: Sequence[Unweighted],
    explained: Sequence[FloatArray],
    memory: ColumnMemory,
    plain: bool = False,
) -> Evidence:
    """Whiten; the filters come from the residuals less what is `explained` (V, one (n,) a log)."""
    rows, bases, blocks, filters = [], [], [], []
    offset = 0
    for source, part, taken in zip(sources, parts, explained, strict=True):
        noise = part.residual - taken
        a = np.zeros(1) if plain else whitening_filter(source, noise - refitted(source, part, noise))
        table = np.asarray(whiten(np.vstack([noise[None, :], part.residual[None, :], part.columns]), list(a)))
        rms = robust_rms(table[0, source.mask > 0])
        table *= source.mask / rms
        table[0] = np.clip(table[0], -WHITENING.outlier, WHITENING.outlier)
        table[1] = np.clip(table[1], -WHITENING.glitch, WHITENING.glitch)
        level = spectrum(_freed(table[0], table[2:]), source)
        filter_ = Filter(a, rms, level[0], np.ones_like(level[1]) if plain else level[1])
        table = coloured(table[1:], source, filter_)
        rows.append(table[0])
        bases.append(table[1:])
        block = np.floor((source.log.time - source.log.time[0]) / BLOCK).astype(np.int64)
        blocks.append(block + offset)
        offset += int(block[-1]) + 1
        filters.append(filter_)
    columns = joined(bases)
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


def _freed(row: FloatArray, columns: FloatArray) -> FloatArray:
    """A row (n,) without what columns (p, n) explain of it."""
    basis = orthonormal(columns)
    return np.asarray(row - (basis @ row) @ basis)


def with_columns(evidence: Evidence, tables: Sequence[FloatArray], amplitudes: FloatArray) -> Evidence:
    """The evidence with further columns among what a fit may move, and filters from what these leave.

    Args:
        evidence: residuals, columns and filters.
        tables: what they add to the residuals, V per unit, one (p, n) a log.
        amplitudes: of them in the residual, (p,).
    """
    parts = [
        replace(part, columns=np.vstack([part.columns, table]))
        for part, table in zip(evidence.parts, tables, strict=True)
    ]
    explained = [amplitudes @ table for table in tables]
    made = weighed(evidence.model, evidence.sources, parts, explained, evidence.memory)
    return replace(made, turns=evidence.turns)


def refitted(source: Innovations, part: Unweighted, noise: FloatArray) -> FloatArray:
    """What re-tuning makes of a residual (V, (n,)) from which an effect was taken: it had made up for the effect."""
    a = whitening_filter(source, noise)
    table = np.asarray(whiten(np.vstack([noise[None, :], part.columns]), list(a)))
    table *= source.mask
    return np.asarray(least_squares_of_long_rows(table[1:], table[0], rcond=WHITENING.refit_rank) @ part.columns)


def slow_friction(source: Innovations, model: Model) -> FloatArray:
    """Forces (V) of shapes that friction may have close to rest, odd in velocity, (6, n): nobody states them so well.

    S(v) is a convention. Where another machine's friction rises sooner or later, the difference fades over some widths,
    as exp(-(v / w)^2) or slower, as v w / (v^2 + w^2) does.
    """
    shapes = slow_shapes(source.along.middle_velocity, slow_width(source, model))
    return shapes * max(model.axis.coulomb, 1e-12)


def slow_width(source: Innovations, model: Model) -> float:
    """Speed (m/s) by which the shapes of slow friction are scaled."""
    return max(model.axis.coulomb_width, source.rest)


def slow_shapes(velocity: FloatArray, width: float) -> FloatArray:
    """The shapes of slow friction at velocities (n,), without a size, (6, n)."""
    shapes = [np.sign(velocity) * np.exp(-((velocity / (factor * width)) ** 2)) for factor in WHITENING.friction_decays]
    tails = [factor * width for factor in WHITENING.friction_tails]
    shapes += [2.0 * velocity * w / (velocity**2 + w**2) for w in tails]
    return np.array(shapes)
