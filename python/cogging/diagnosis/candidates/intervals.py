"""Effects that act in an interval of time, or at one place: when, and where, found at once by sums of the adjoint."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import replace
from typing import Any

import numpy as np

from cogging.arrays import FloatArray
from cogging.diagnosis.candidates.signatures import Candidate, Seen, shape_range
from cogging.diagnosis.candidates.waves import adjoint
from cogging.diagnosis.evidence.evidence import Evidence
from cogging.diagnosis.thresholds import DISTRIBUTION, INTERVAL
from cogging.effects.effect import Effect, Place, Window, kind_of


def acts_in_interval(effect: Effect) -> bool:
    """Whether an effect is a force between two moments."""
    return kind_of(effect, Window) is not None and "force" in effect.HOOKS


def long_enough(effect: Effect, shape: Mapping[str, Any]) -> bool:
    """Whether a shape that begins and ends lasts."""
    window = kind_of(effect, Window)
    return window is None or bool(shape[window.stop] - shape[window.start] >= INTERVAL.shortest)


def intervals(evidence: Evidence, law: Effect, grid: list[Candidate]) -> tuple[list[Candidate], float]:
    """The likeliest intervals, or places, beside those of a grid, and how many independent ones were tried."""
    if grid and acts_at_place(law):
        return _places(evidence, law, grid)
    window = kind_of(law, Window)
    if not grid or window is None or not acts_in_interval(law):
        return grid, float(max(1, len(grid)))
    found, trials, start = list(grid), 0.0, 0
    for source, filter_, along in zip(evidence.sources, evidence.filters, evidence.alongs, strict=True):
        n = len(source.log)
        force, _ = adjoint(source, filter_, along, evidence.model.axis.mass, evidence.free_residual[start : start + n])
        start += n
        total = np.concatenate([[0.0], np.cumsum(force)])
        time = source.log.time - source.log.time[0]
        step = source.scales.sample_time
        lengths = np.unique(
            np.geomspace(max(2.0, INTERVAL.shortest / step), INTERVAL.longest * n, INTERVAL.lengths_tried).astype(int)
        )
        best: list[tuple[float, int, int]] = []
        for length in lengths:
            score = (total[length:] - total[:-length]) ** 2
            level = float(np.median(score)) / DISTRIBUTION.chi_square_median
            if level <= 0.0:
                continue
            trials += n / length
            place = int(np.argmax(score))
            best.append((float(score[place]) / level, place, int(length)))
        for _, place, length in sorted(best, reverse=True)[: INTERVAL.intervals_exact]:
            shape = {window.start: float(time[place]), window.stop: float(time[min(place + length, n - 1)])}
            found.append(replace(grid[0], shape={**grid[0].shape, **shape}))
    return found, max(trials, float(len(grid)))


def acts_at_place(effect: Effect) -> bool:
    """Whether an effect is a force in one stretch of the travel."""
    return kind_of(effect, Place) is not None and "force" in effect.HOOKS


def _places(evidence: Evidence, law: Effect, grid: list[Candidate]) -> tuple[list[Candidate], float]:
    pushes, positions, start = [], [], 0
    for source, filter_, along in zip(evidence.sources, evidence.filters, evidence.alongs, strict=True):
        n = len(source.log)
        rows = source.mask > 0
        residual = evidence.free_residual[start : start + n]
        pushes.append(adjoint(source, filter_, along, evidence.model.axis.mass, residual)[0][rows])
        positions.append(along.middle_position[rows])
        start += n
    found, trials = [], 0.0
    for shape, power in bumps(evidence, law, np.concatenate(positions), np.concatenate(pushes)):
        level = float(np.median(power)) / DISTRIBUTION.chi_square_median
        trials += len(power) / INTERVAL.bins_of_width
        if level > 0.0:
            found.append((float(power.max()) / level, replace(grid[0], shape={**grid[0].shape, **shape})))
    best = sorted(found, key=lambda pair: -pair[0])[: INTERVAL.intervals_exact]
    return [*grid, *(one for _, one in best)], max(trials, float(len(grid)))


def bumps(
    seen: Seen, law: Effect, positions: FloatArray, pushes: FloatArray
) -> Iterator[tuple[dict[str, float], FloatArray]]:
    """For each width of a force at one place the likeliest center, and of how much of `pushes` (n,) each is the cause.

    The forces are taken as bells: what is left of a law is a matter of the exact test.
    """
    kind = kind_of(law, Place)
    if kind is None or len(positions) == 0:
        return
    low, high = float(positions.min()), float(positions.max())
    for width in np.geomspace(*shape_range(seen, law.ROLES[kind.width]), INTERVAL.widths_tried):
        edges = np.linspace(low, high, max(2, int(INTERVAL.bins_of_width * (high - low) / width)) + 1)
        total, _ = np.histogram(positions, edges, weights=pushes)
        count, _ = np.histogram(positions, edges)
        reach = 3 * INTERVAL.bins_of_width
        bell = np.exp(-((np.arange(-reach, reach + 1) / INTERVAL.bins_of_width) ** 2))
        score, weight = (np.convolve(row, k, mode="full")[reach:-reach] for row, k in ((total, bell), (count, bell**2)))
        power = score**2 / np.maximum(weight, 1e-3 * weight.max())
        center = float(0.5 * (edges[:-1] + edges[1:])[int(np.argmax(power))])
        yield {kind.center: center, kind.width: float(width)}, power
