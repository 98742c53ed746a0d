"""Effects that act in an interval of time: where one began and ended, found at once by the cumulated adjoint."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from typing import Any

import numpy as np

from cogging.diagnosis.candidates.signatures import Candidate
from cogging.diagnosis.candidates.waves import adjoint
from cogging.diagnosis.evidence.evidence import Evidence
from cogging.diagnosis.thresholds import DISTRIBUTION, INTERVAL
from cogging.effects.effect import Effect, Window, kind_of


def acts_in_interval(effect: Effect) -> bool:
    """Whether an effect is a force between two moments."""
    return kind_of(effect, Window) is not None and "force" in effect.HOOKS


def long_enough(effect: Effect, shape: Mapping[str, Any]) -> bool:
    """Whether a shape that begins and ends lasts."""
    window = kind_of(effect, Window)
    return window is None or bool(shape[window.stop] - shape[window.start] >= INTERVAL.shortest)


def intervals(evidence: Evidence, law: Effect, grid: list[Candidate]) -> tuple[list[Candidate], float]:
    """The likeliest intervals beside those of a grid, and how many independent ones were tried."""
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
