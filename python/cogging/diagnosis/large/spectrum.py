"""Waves along the travel, or in time, that the force balance shows: their likeliest wavenumbers."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from cogging.arrays import FloatArray
from cogging.diagnosis.candidates.signatures import turn_periods
from cogging.diagnosis.large.balance import Balances, LogBalance
from cogging.diagnosis.thresholds import PHYSICAL, SEED


def peaks(balances: Balances, residual: FloatArray, count: int, *, spatial: bool, gained: bool = False) -> list[float]:
    """Wavenumbers (1/m) or frequencies (Hz) of the waves that explain most of a residual (V, (n,)), the best first.

    Args:
        balances: logs and model.
        residual: in rows that count.
        count: how many, each farther from the others than a turn over the travel or the time.
        spatial: whether along the travel, else in time.
        gained: whether the wave multiplies the command.
    """
    ends = [_ends(source, spatial) for source in balances.sources]
    span = max(high - low for low, high in ends)
    highest = min(_highest(source, spatial, span) for source in balances.sources)
    length = int(min(SEED.spectrum_max, 2 ** np.ceil(np.log2(4.0 * SEED.fine * max(highest * span, 1.0)))))
    spacing = span * SEED.fine / length
    wave = np.arange(length // 2 + 1) / (spacing * length)
    score, power, start = np.zeros(len(wave), complex), np.zeros(len(wave)), 0
    origin = min(low for low, _ in ends)
    for source in balances.sources:
        rows = int(source.mask.sum())
        full = np.zeros(len(source.mask))
        full[source.mask] = residual[start : start + rows]
        start += rows
        gain = source.balance.dynamics.command if gained else np.ones(len(full))
        back = source.balance.dynamics.filtered(full[None, :])[0] * gain
        where = _coordinate(source, spatial) - (origin if spatial else 0.0)
        score += np.fft.rfft(np.bincount(np.clip((where / spacing).astype(int), 0, length - 1), back, length))
        power += _power(source, gain, wave, spatial)
    explained = np.where(wave <= highest, np.abs(score) ** 2 / np.maximum(power, 1e-3 * power.max()), 0.0)
    explained[wave < (SEED.turns if spatial else PHYSICAL.periods) / span] = 0.0
    for period in turn_periods(balances.model) if spatial and not gained else ():
        explained[np.abs(wave - 1.0 / period) < 1.0 / span] = 0.0
    found = []
    for _ in range(count):
        best = int(np.argmax(explained))
        if explained[best] <= 0.0:
            break
        found.append(float(wave[best]))
        explained[np.abs(wave - wave[best]) < 1.0 / span] = 0.0
    return found


def sharpened(explained: Callable[[float], float], wave: float, width: float) -> float:
    """The wavenumber within `width` of one given that explains most."""
    from scipy.optimize import minimize_scalar

    low = max(wave - width, 0.25 * wave)
    found = minimize_scalar(lambda w: -explained(float(w)), bounds=(low, wave + width), method="bounded")
    return float(found.x) if -found.fun >= explained(wave) else wave


def _coordinate(source: LogBalance, spatial: bool) -> FloatArray:
    dynamics = source.balance.dynamics
    return dynamics.motion.middle_position if spatial else dynamics.even - dynamics.even[0]


def _ends(source: LogBalance, spatial: bool) -> tuple[float, float]:
    where = _coordinate(source, spatial)[source.mask]
    return (float(where.min()), float(where.max())) if len(where) else (0.0, 1.0)


def _highest(source: LogBalance, spatial: bool, span: float) -> float:
    """The highest wavenumber (1/m) or frequency (Hz) that the rows of a log follow."""
    dynamics = source.balance.dynamics
    if not spatial:
        return min(dynamics.cutoff, 0.25 / dynamics.sample_time)
    speeds = np.abs(dynamics.motion.middle_velocity[source.mask])
    speed = max(float(np.quantile(speeds, 0.1)) if len(speeds) else 1.0, 1e-300)
    return min(max(SEED.harmonic_max / span, 1.5 * dynamics.cutoff / speed), 0.25 / (dynamics.sample_time * speed))


def _power(source: LogBalance, gain: FloatArray, wave: FloatArray, spatial: bool) -> FloatArray:
    """Half the power of a wave of amplitude 1 behind the filter, in rows that count."""
    weight = gain[source.mask] ** 2
    cutoff = source.balance.dynamics.cutoff
    if not spatial:
        return np.asarray(0.5 * weight.sum() / (1.0 + (wave / cutoff) ** 8) ** 2)
    speed = np.abs(source.balance.dynamics.motion.middle_velocity[source.mask])
    share, edges = np.histogram(speed, SEED.speeds, weights=weight)
    power = np.zeros(len(wave))
    for one, velocity in zip(share, 0.5 * (edges[1:] + edges[:-1]), strict=True):
        power += 0.5 * one / (1.0 + np.minimum(wave * velocity / cutoff, 1e6) ** 8) ** 2
    return np.asarray(power)
