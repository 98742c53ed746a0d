"""Functions along a measured motion of which columns are made: bases, and the states of contacts and loads."""

from __future__ import annotations

import numpy as np
from scipy.interpolate import BSpline
from scipy.signal import lfilter

from cogging.arrays import FloatArray

LONGEST_FLIGHT = 0.5  # s: a load that has not met the motor again within it is no longer followed


def hats(values: FloatArray, places: FloatArray) -> FloatArray:
    """Hat functions of linear interpolation between places (k,), at values (n,), (k, n); constant outside."""
    table = np.zeros((len(places), len(values)))
    left = np.clip(np.searchsorted(places, values, side="right") - 1, 0, len(places) - 2)
    share = np.clip((values - places[left]) / np.diff(places)[left], 0.0, 1.0)
    rows = np.arange(len(values))
    table[left, rows], table[left + 1, rows] = 1.0 - share, share
    return table


def splines(values: FloatArray, low: float, high: float, count: int) -> FloatArray:
    """Cubic B-splines with equally spaced knots, count - 3 spans of them in [low, high], at values (n,), (count, n)."""
    knots = low + (high - low) / (count - 3) * np.arange(-3, count + 1)
    x = np.clip(values, low, high - 1e-9 * (high - low))
    return np.asarray(BSpline.design_matrix(x, knots, 3).toarray().T)


def dahl(x: FloatArray, length: float) -> FloatArray:
    """Bristle deflection z over its largest of a Dahl contact along positions x (n,), -1 to 1, (n,).

    dz/dx = (1 - z sign(dx)) / length, in closed form from reversal to reversal: z - s decays as exp(-|dx| / length).
    """
    sign = np.sign(np.diff(x))
    turns = np.flatnonzero(np.diff(sign)) + 1
    z = np.zeros(len(x))
    now = 0.0
    for a, b in zip([0, *turns], [*turns, len(x) - 1], strict=True):
        s = sign[a] if a < len(sign) else 0.0
        if s:
            z[a : b + 1] = s + (now - s) * np.exp(-np.abs(x[a : b + 1] - x[a]) / length)
        else:
            z[a : b + 1] = now
        now = z[b]
    return z


def load_response(a: FloatArray, step: float, antiresonance: float, damping: float) -> FloatArray:
    """Acceleration of a load behind a spring, given that of the motor a (n,), rows `step` (s) apart, (n,).

    (2 d w s + w^2) / (s^2 + 2 d w s + w^2) by the bilinear transform, warped so that w = 2 pi antiresonance (Hz) stays.
    """
    w = np.tan(min(np.pi * antiresonance * step, 1.5))
    d, s = 2.0 * damping * w, w * w
    return np.asarray(lfilter([d + s, 2 * s, s - d], [1 + d + s, 2 * s - 2, 1 - d + s], a))


def lost_motion(a: FloatArray, step: float, gap: float) -> FloatArray:
    """Speed of a motor relative to a load that it moves through a gap (m), m/s, (n,); 0 where they touch.

    The load flies on where the motor no longer pushes it, and takes the motor's speed where it meets either side again.

    Args:
        a: acceleration of the motor, m/s^2, (n,); 0 at rest.
        step: s, of the rows.
        gap: m, from one side to the other.
    """
    apart, free_until, side = np.zeros(len(a)), 0, float(np.sign(a[0]) or 1.0)
    longest = max(2, round(LONGEST_FLIGHT / step))
    for i in (np.flatnonzero(np.diff(np.sign(a))) + 1).tolist():
        if i < free_until or side * a[i] >= 0.0:
            continue
        speed = np.cumsum(a[i : i + longest]) * step
        way = side * np.cumsum(speed) * step  # 0 where the load left, -gap on the other side
        met = np.flatnonzero((way < -gap) | (way > 0.0))
        flight = int(met[0]) if len(met) else len(way)
        apart[i : i + flight] = speed[:flight]
        side = -side if len(met) and way[flight] < 0.0 else side
        free_until = i + flight
    return apart
