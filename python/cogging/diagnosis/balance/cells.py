"""Functions along a measured motion that make up columns: basis functions, and the states of contacts and loads."""

from __future__ import annotations

import numpy as np
from scipy.interpolate import BSpline
from scipy.signal import lfilter

from cogging.arrays import FloatArray

FLIGHT = 64  # rows of a flight that are computed first; until the load is met, four times as many


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
    """Return the speed of a motor relative to a load with backlash, m/s, and its acceleration while apart, (2, n).

    Both are 0 while they touch. The load coasts from the middle of the gap, and whenever the motor stops pushing it; it
    takes the motor's speed when it meets either side.

    Args:
        a: acceleration of the motor, m/s^2, (n,); 0 at rest.
        step: time step, s.
        gap: full width of the gap, m.
    """
    speed, alone, start, place = np.zeros(len(a)), np.zeros(len(a)), 0, 0.0
    pulls = {-1: np.flatnonzero(a > 0.0), 1: np.flatnonzero(a < 0.0)}  # rows in which the motor leaves a side
    while start < len(a):
        longest = FLIGHT
        while True:
            apart = np.cumsum(a[start : start + longest]) * step
            way = place + np.cumsum(apart) * step
            met = np.flatnonzero(np.abs(way) > 0.5 * gap)
            if len(met) or start + longest >= len(a):
                break
            longest *= 4
        flight = int(met[0]) if len(met) else len(way)
        end = start + flight
        speed[start:end], alone[start:end] = apart[:flight], a[start:end]
        if not len(met):
            break
        side = 1 if way[flight] > 0.0 else -1
        # part of the row in which they meet: the force must be continuous in the gap
        before = float(way[flight - 1]) if flight else place
        speed[end] = apart[flight] * (0.5 * side * gap - before) / (way[flight] - before)
        left = pulls[side][np.searchsorted(pulls[side], end + 1) :]
        place, start = 0.5 * side * gap, int(left[0]) if len(left) else len(a)
    return np.array([speed, alone])
