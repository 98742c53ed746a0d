"""Candidates: what may be missing, as columns along the measured motion."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from scipy.signal import lfilter


@dataclass
class Shape:
    """One candidate at one shape: columns per log at the middle rate."""

    name: str
    label: str
    columns: list  # per log (k, n)
    finite: bool = False  # the column is the whole effect: amplitude 1
    effect: Any = None  # function amplitudes -> Effect, or None
    cell: str = ""  # coordinate
    bounds: Any = None
    single: Any = None  # the same cause, one shape: its amplitudes' signs


def hats(values, places):
    """Linear interpolation between places as columns."""
    table = np.zeros((len(places), len(values)))
    left = np.clip(np.searchsorted(places, values, side="right") - 1, 0, len(places) - 2)
    share = np.clip((values - places[left]) / np.diff(places)[left], 0.0, 1.0)
    rows = np.arange(len(values))
    table[left, rows], table[left + 1, rows] = 1.0 - share, share
    return table


def splines(values, low, high, count):
    """Cubic B-splines over [low, high], (count, n)."""
    from scipy.interpolate import BSpline

    inner = np.linspace(low, high, count - 2)
    knots = np.concatenate([[low] * 3, inner, [high] * 3])
    x = np.clip(values, low, high - 1e-9 * (high - low))
    return BSpline.design_matrix(x, knots, 3).toarray().T


def dahl(x, length):
    """Bristle deflection over its largest, of a Dahl contact along x (n,): closed form from reversal to reversal."""
    sign = np.sign(np.diff(x))
    turns = np.flatnonzero(np.diff(sign)) + 1
    z = np.zeros(len(x))
    now = 0.0
    for a, b in zip([0, *turns], [*turns, len(x) - 1]):
        s = sign[a] if a < len(sign) else 0.0
        if s:
            z[a : b + 1] = s + (now - s) * np.exp(-np.abs(x[a : b + 1] - x[a]) / length)
        else:
            z[a : b + 1] = now
        now = z[b]
    return z


def load_answer(a, step, antiresonance, damping):
    """Acceleration of a load behind a spring, given the motor's (n,)."""
    w = np.tan(min(np.pi * antiresonance * step, 1.5))
    d, s = 2.0 * damping * w, w * w
    return lfilter([d + s, 2 * s, s - d], [1 + d + s, 2 * s - 2, 1 - d + s], a)


def lost_motion(a, step, gap):
    """Speed of a motor relative to a load that it moves through a gap (m), m/s, (n,); 0 where they touch.

    The load flies on where the motor no longer pushes it, and takes the motor's speed where it meets either side again.

    Args:
        a: acceleration of the motor, m/s^2, (n,); 0 at rest.
        step: s, of the rows.
    """
    apart, free_until, side = np.zeros(len(a)), 0, float(np.sign(a[0]) or 1.0)
    longest = max(2, round(0.5 / step))  # a load that has not come back within half a second is no longer followed
    for i in np.flatnonzero(np.diff(np.sign(a))) + 1:
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
