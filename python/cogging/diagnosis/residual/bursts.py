"""Bursts: intervals in which the residual is louder than it is elsewhere at that speed, whatever its form."""

from __future__ import annotations

import numpy as np

from cogging.diagnosis.evidence.evidence import Evidence
from cogging.diagnosis.evidence.log_p_value import log_choices, log_survival

BAND = (8.0, 60.0)  # Hz: below, the levels of friction are re-tuned; above, a coarse encoder's noise goes with speed
BLOCK = 0.1  # s
BLOCKS_MIN = 20
BURSTS_MAX = 12  # blocks
SPEEDS = 4  # ranges of speed with a level of noise each
SPEEDS_OF_ROWS = 24  # the same where every row counts
BLOW = 3.0  # rms beyond which a single row is cut: a blow is no burst
QUARTILES = 1.349  # standard deviations between the quartiles of a normal distribution


def bursts(evidence: Evidence) -> float:
    """Log p-value: ln of the probability that a white residual is as loud in any few blocks, summed over logs.

    The power of a block over the median at that speed is chi-square over its degrees of freedom; those are counted
    from the band, or from the scatter of all blocks where that is larger (heavy tails, noise that goes with more).
    """
    total, start = 0.0, 0
    for source in evidence.sources:
        n, h = len(source.log), source.scales.sample_time
        residual = np.clip(evidence.free_residual[start : start + n], -BLOW, BLOW)
        start += n
        frequency = np.fft.rfftfreq(n, h)
        inside = (frequency >= BAND[0]) & (frequency < BAND[1])
        power = np.fft.irfft(np.where(inside, np.fft.rfft(residual), 0.0), n) ** 2 * source.mask
        length = max(2, round(BLOCK / h))
        rows = len(residual) // length * length
        counted = source.mask[:rows].reshape(-1, length).sum(axis=1)
        moving = counted > 0.5 * length
        if moving.sum() < BLOCKS_MIN:
            continue
        level = power[:rows].reshape(-1, length).sum(axis=1)[moving] / counted[moving]
        speed = (np.abs(source.along.velocity) * source.mask)[:rows].reshape(-1, length).sum(axis=1)[moving]
        total += _log_p_value(
            level, speed / counted[moving], (BAND[1] - BAND[0]) * 2.0 * h * float(counted[moving].mean())
        )
    return total


def _log_p_value(level: np.ndarray, speed: np.ndarray, freedom: float) -> float:
    """Log p-value of the loudest few of these levels (m,), with `freedom` degrees of freedom in each at most."""
    place = np.empty(len(level), dtype=int)
    place[np.argsort(speed)] = np.arange(len(level)) * SPEEDS // len(level)
    usual = np.array([np.median(level[place == k]) for k in range(SPEEDS)])
    ratio = level / np.maximum(usual[place], 1e-300)
    low, high = np.quantile(np.log(np.maximum(ratio, 1e-300)), [0.25, 0.75])
    scatter = float(high - low) / QUARTILES
    d = max(1, round(min(freedom, 2.0 / max(scatter**2, 1e-9))))
    median = d * (1.0 - 2.0 / (9.0 * d)) ** 3
    chances = np.sort([log_survival(float(median * one), d) for one in ratio])[:BURSTS_MAX]
    choices = [log_choices(len(level), count) for count in range(1, len(chances) + 1)]
    return min(0.0, float(np.min(np.cumsum(chances) + choices)) + float(np.log(BURSTS_MAX)))


def variance_jumps(evidence: Evidence) -> float:
    """Log p-value: ln of the probability that a white residual's power jumps as high in any three blocks, 0.6 s.

    Against what it is at that speed: where an encoder is coarse, the noise goes with speed.
    """
    power = evidence.free_residual**2
    mask = evidence.residual != 0.0
    speed = np.concatenate([np.abs(source.along.velocity) for source in evidence.sources])
    edges = np.unique(np.quantile(speed[mask], np.linspace(0.0, 1.0, SPEEDS_OF_ROWS + 1)))
    place = np.clip(np.searchsorted(edges, speed, side="right") - 1, 0, max(len(edges) - 2, 0))
    rows = np.maximum(np.bincount(place, mask, minlength=SPEEDS_OF_ROWS), 1.0)
    level = np.maximum(np.bincount(place, power * mask, minlength=SPEEDS_OF_ROWS) / rows, 1.0)
    power = power / level[place]
    worst = 0.0
    for block in range(0, int(evidence.block[-1]) + 1, 3):
        mine = (evidence.block >= block) & (evidence.block < block + 3) & mask
        n = int(mine.sum())
        if n >= 100:
            worst = min(worst, log_survival(float(power[mine].sum()), n))
    return worst
