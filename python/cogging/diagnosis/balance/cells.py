"""Functions along a measured motion that make up columns: basis functions, and the states of contacts and loads."""

from __future__ import annotations

import numpy as np
from scipy.interpolate import BSpline
from scipy.signal import lfilter

from cogging.arrays import FloatArray

LONGEST_FLIGHT = 0.5  # s: longest simulated flight of a load through a gap


def hats(values: FloatArray, places: FloatArray) -> FloatArray:
    """Return the hat functions of linear interpolation between places (k,) at values (n,), (k, n); constant outside."""
    table = np.zeros((len(places), len(values)))
    left = np.clip(np.searchsorted(places, values, side="right") - 1, 0, len(places) - 2)
    share = np.clip((values - places[left]) / np.diff(places)[left], 0.0, 1.0)
    rows = np.arange(len(values))
    table[left, rows], table[left + 1, rows] = 1.0 - share, share
    return table


def splines(values: FloatArray, low: float, high: float, count: int) -> FloatArray:
    """Return `count` cubic B-splines at values (n,), (count, n); equally spaced knots divide [low, high] into spans."""
    knots = low + (high - low) / (count - 3) * np.arange(-3, count + 1)
    x = np.clip(values, low, high - 1e-9 * (high - low))
    return np.asarray(BSpline.design_matrix(x, knots, 3).toarray().T)


def dahl(x: FloatArray, length: float) -> FloatArray:
    """Return the normalised bristle deflection z of a Dahl contact along positions x (n,), -1 to 1, (n,).

    dz/dx = (1 - z sign(dx)) / length, in closed form between reversals: z - sign(dx) decays as exp(-|dx| / length).
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
    """Return the acceleration of a load behind a spring, (n,), for the motor acceleration a (n,) with time step `step`.

    The transfer function is (2 d w s + w^2) / (s^2 + 2 d w s + w^2) with w = 2 pi antiresonance (Hz), discretised by
    the bilinear transform with prewarping at w.
    """
    w = np.tan(min(np.pi * antiresonance * step, 1.5))
    d, s = 2.0 * damping * w, w * w
    return np.asarray(lfilter([d + s, 2 * s, s - d], [1 + d + s, 2 * s - 2, 1 - d + s], a))


def lost_motion(a: FloatArray, step: float, gap: float) -> FloatArray:
    """Return the speed of a motor relative to a load with backlash, m/s, (n,); 0 while they touch.

    The load coasts when the motor stops pushing it, and takes the motor's speed when it meets either side again.

    Args:
        a: acceleration of the motor, m/s^2, (n,); 0 at rest.
        step: time step, s.
        gap: full width of the gap, m.
    """
    apart, free_until, side = np.zeros(len(a)), 0, float(np.sign(a[0]) or 1.0)
    longest = max(2, round(LONGEST_FLIGHT / step))
    for i in (np.flatnonzero(np.diff(np.sign(a))) + 1).tolist():
        if i < free_until or side * a[i] >= 0.0:
            continue
        speed = np.cumsum(a[i : i + longest]) * step
        way = side * np.cumsum(speed) * step  # 0 on the side that the load left, -gap on the other
        met = np.flatnonzero((way < -gap) | (way > 0.0))
        flight = int(met[0]) if len(met) else len(way)
        apart[i : i + flight] = speed[:flight]
        if len(met):  # part of the row in which they meet: the force must be continuous in the gap
            before, wall = way[flight - 1] if flight else 0.0, -gap if way[flight] < 0.0 else 0.0
            apart[i + flight] = speed[flight] * (wall - before) / (way[flight] - before)
        side = -side if len(met) and way[flight] < 0.0 else side
        free_until = i + flight
    return apart
