"""Bursts: intervals in which the residual is louder than it is elsewhere at that speed, whatever its form."""

from __future__ import annotations

import numpy as np

from cogging.diagnosis.evidence.evidence import Evidence
from cogging.diagnosis.evidence.log_p_value import log_choices, log_survival
from cogging.diagnosis.thresholds import BURST, DISTRIBUTION


def bursts(evidence: Evidence) -> float:
    """Log p-value: ln of the probability that a white residual is as loud in any few blocks, summed over logs.

    The power of a block over the median at that speed is chi-square over its degrees of freedom; those are counted
    from the band, or from the scatter of all blocks where that is larger (heavy tails, noise that goes with more).
    """
    total, start = 0.0, 0
    for source in evidence.sources:
        n, h = len(source.log), source.scales.sample_time
        residual = np.clip(evidence.free_residual[start : start + n], -BURST.blow_cut, BURST.blow_cut)
        start += n
        frequency = np.fft.rfftfreq(n, h)
        inside = (frequency >= BURST.band[0]) & (frequency < BURST.band[1])
        power = np.fft.irfft(np.where(inside, np.fft.rfft(residual), 0.0), n) ** 2 * source.mask
        length = max(2, round(BURST.burst_block / h))
        rows = len(residual) // length * length
        counted = source.mask[:rows].reshape(-1, length).sum(axis=1)
        moving = counted > BURST.block_moving * length
        if moving.sum() < BURST.blocks_min:
            continue
        level = power[:rows].reshape(-1, length).sum(axis=1)[moving] / counted[moving]
        speed = (np.abs(source.along.velocity) * source.mask)[:rows].reshape(-1, length).sum(axis=1)[moving]
        total += _log_p_value(
            level, speed / counted[moving], (BURST.band[1] - BURST.band[0]) * 2.0 * h * float(counted[moving].mean())
        )
    return total


def _log_p_value(level: np.ndarray, speed: np.ndarray, freedom: float) -> float:
    """Log p-value of the loudest few of these levels (m,), with `freedom` degrees of freedom in each at most."""
    place = np.empty(len(level), dtype=int)
    place[np.argsort(speed)] = np.arange(len(level)) * BURST.speed_levels // len(level)
    usual = np.array([np.median(level[place == k]) for k in range(BURST.speed_levels)])
    ratio = level / np.maximum(usual[place], 1e-300)
    low, high = np.quantile(np.log(np.maximum(ratio, 1e-300)), [0.25, 0.75])
    scatter = float(high - low) / DISTRIBUTION.normal_quartiles
    d = max(1, round(min(freedom, 2.0 / max(scatter**2, 1e-9))))
    median = d * (1.0 - 2.0 / (9.0 * d)) ** 3
    chances = np.sort([log_survival(float(median * one), d) for one in ratio])[: BURST.bursts_max]
    choices = [log_choices(len(level), count) for count in range(1, len(chances) + 1)]
    return min(0.0, float(np.min(np.cumsum(chances) + choices)) + float(np.log(BURST.bursts_max)))


def variance_jumps(evidence: Evidence) -> float:
    """Log p-value: ln of the probability that a white residual's power jumps as high in any three blocks, 0.6 s.

    Against what it is at that speed: where an encoder is coarse, the noise goes with speed.
    """
    power = evidence.free_residual**2
    mask = evidence.residual != 0.0
    speed = np.concatenate([np.abs(source.along.velocity) for source in evidence.sources])
    edges = np.unique(np.quantile(speed[mask], np.linspace(0.0, 1.0, BURST.speed_levels_of_rows + 1)))
    place = np.clip(np.searchsorted(edges, speed, side="right") - 1, 0, max(len(edges) - 2, 0))
    rows = np.maximum(np.bincount(place, mask, minlength=BURST.speed_levels_of_rows), 1.0)
    level = np.maximum(np.bincount(place, power * mask, minlength=BURST.speed_levels_of_rows) / rows, 1.0)
    power = power / level[place]
    worst = 0.0
    for block in range(0, int(evidence.block[-1]) + 1, BURST.jump_blocks):
        mine = (evidence.block >= block) & (evidence.block < block + BURST.jump_blocks) & mask
        n = int(mine.sum())
        if n >= BURST.jump_rows:
            worst = min(worst, log_survival(float(power[mine].sum()), n))
    return worst
