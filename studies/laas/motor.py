"""What the logs of a motor that cogs say, one by one: axis, measured speed, speed loop and timing of the current.

Rows are irregular and some were lost, so nothing is differentiated twice and nothing needs a sample rate.
"""

from __future__ import annotations

import itertools
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any, NamedTuple

import numpy as np
from scipy.interpolate import BSpline
from scipy.optimize import minimize

from cogging._core import CoggingModel
from cogging.arrays import FloatArray, Mask
from cogging.datasets.laas import RotaryLog

STEP = 2e-4  # s, of the fine grids on which a log is integrated
GAP = 1.45e-3  # s: a longer step between two rows is a lost packet
SETTLED = 0.05  # s after a lost packet: then the loop has forgotten it


def settled(rows: RotaryLog) -> Mask:
    """Rows further than SETTLED from the last lost packet: bool, (n,)."""
    lost = rows.time[1:][np.diff(rows.time) > GAP]
    before = np.searchsorted(lost, rows.time, side="right")
    kept: Mask = (before == 0) | (rows.time - lost[np.maximum(before, 1) - 1] > SETTLED)
    return kept


@dataclass(frozen=True)
class Estimate:
    """A least-squares value with a 95 % interval."""

    value: float
    low: float
    high: float


class WeakForm(NamedTuple):
    """A force balance integrated against windows: their centres (s), and the integrals of each term, each (n,)."""

    centre: FloatArray
    acceleration: FloatArray
    current: FloatArray
    direction: FloatArray
    velocity: FloatArray
    one: FloatArray
    integrate: Callable[[Callable[[FloatArray], FloatArray]], FloatArray]  # of any force of position


def weak_form(rows: RotaryLog, width: float, shift: float) -> WeakForm:
    """Force balance integrated against smooth windows, so that nothing is differentiated twice.

    For a window w of compact support, int w x'' dt = int w'' x dt. Windows are quartic B-splines of `width` (s), four
    in each width; those that hold a lost packet are left out. The current is taken `shift` (s) later than the position.
    """
    window = BSpline.basis_element(np.linspace(0.0, width, 6))
    grid = np.arange(0.0, width + 0.5 * STEP, STEP)
    w, w2 = window(grid) * STEP, window.derivative(2)(grid) * STEP
    starts = np.arange(rows.time[0] + 0.01, rows.time[-1] - width - 0.01, width / 4)
    first, last = np.searchsorted(rows.time, starts) - 1, np.searchsorted(rows.time, starts + width)
    lost = np.concatenate([[0], np.cumsum(np.diff(rows.time) > 2.5e-3)])
    starts = starts[lost[last] == lost[first]]
    at = starts[:, None] + grid
    x = np.interp(at, rows.time, rows.position)
    # A difference over 2 ms tells the direction well enough: friction's sign is wrong for a fraction of a millisecond.
    v = (np.interp(at + 1e-3, rows.time, rows.position) - np.interp(at - 1e-3, rows.time, rows.position)) / 2e-3
    current = np.interp(at + shift, rows.time, rows.current) @ w
    integrals = ((x - x[:, :1]) @ w2, current, np.sign(v) @ w, v @ w, np.full(len(starts), w.sum()))
    return WeakForm(starts + width / 2, *integrals, lambda force: force(x.ravel()).reshape(x.shape) @ w)


def axis_from_acceleration(rows: RotaryLog) -> dict[str, Estimate]:
    """J, B and Fc (all over Kt) from the 2 Hz log, by least squares on the weak form.

    Current = J acceleration + Fc sgn(v) + B v + offset; the cogging goes by far above 2 Hz and averages out. Errors
    are not white: covariance from sums over whole periods (0.5 s). The interval is the union over two widths of the
    window and over a current that is 0 or 0.5 ms late, since the data do not say which is right.
    """
    found = []
    for width, shift in itertools.product((0.05, 0.1), (0.0, 0.5e-3)):
        form = weak_form(rows, width, shift)
        design = np.stack([form.acceleration, form.direction, form.velocity, form.one], axis=1)
        value = np.linalg.lstsq(design, form.current, rcond=None)[0]
        scores = design * (form.current - design @ value)[:, None]
        period = np.floor(form.centre / 0.5).astype(int)
        sums = np.stack([scores[period == k].sum(axis=0) for k in np.unique(period)])
        inverse = np.linalg.inv(design.T @ design)
        found.append((value, 1.96 * np.sqrt(np.diag(inverse @ sums.T @ sums @ inverse))))
    values, halves = (np.array(part) for part in zip(*found, strict=True))
    middle, low, high = values.mean(axis=0), (values - halves).min(axis=0), (values + halves).max(axis=0)
    return dict(zip(("mass", "coulomb", "viscous", "offset"), map(Estimate, middle, low, high), strict=True))


def mean_velocity(time: FloatArray, position: FloatArray, start: float, width: float) -> FloatArray:
    """The speed (rad/s) of a motion as a drive reports it: v(t) = (x(t - start) - x(t - start - width)) / width."""
    newer, older = (np.interp(time - before, time, position) for before in (start, start + width))
    return (newer - older) / width


def velocity_window(rows: RotaryLog) -> tuple[float, float, float]:
    """How the drive measures speed: start and width (s) of `mean_velocity`.

    Fitted to the reported speed of the rows, with the root mean square of what is left (rad/s).
    """
    inner = rows.time > rows.time[0] + 0.02

    def left(window: FloatArray) -> float:
        difference = mean_velocity(rows.time, rows.position, window[0], window[1]) - rows.velocity
        return float(np.sqrt(np.mean(difference[inner] ** 2)))

    found = minimize(lambda ms: left(1e-3 * ms), [0.0, 3.5], method="Nelder-Mead", options={"xatol": 1e-3})
    start, width = 1e-3 * found.x
    return start, width, float(found.fun)


def speed_law(rows: RotaryLog) -> tuple[float, float, float, float]:
    """Gain (A/(rad/s)), reference (rad/s) and delay (s) of current(t) = gain (reference - v(t - delay)).

    And what is left. v is the reported speed; what is left is over the rms of the current's variation.
    """

    def fit(delay: float) -> tuple[Any, float]:
        delayed = np.interp(rows.time - delay, rows.time, rows.velocity)[20:]
        design = np.stack([np.ones_like(delayed), delayed], axis=1)
        value, squares, *_ = np.linalg.lstsq(design, rows.current[20:], rcond=None)
        return value, float(np.sqrt(squares[0] / len(delayed)))

    delays = np.arange(1.0, 3.0, 0.02) * 1e-3
    delay = delays[np.argmin([fit(delay)[1] for delay in delays])]
    (offset, slope), left = fit(delay)
    return -slope, -offset / slope, float(delay), left / rows.current.std()


def current_lateness(rows: RotaryLog, cogging_map: CoggingModel) -> tuple[float, float, float, float]:
    """By how much (s) the logged current is late on the force: where the force balance with the map leaves least.

    Returns it with the share of the current that is left there, the scale of the map that fits best and J.
    """
    shifts = np.arange(-0.5, 1.3, 0.1) * 1e-3
    left, values = [], []
    for shift in shifts:
        form = weak_form(rows, 0.015, shift)
        design = np.stack([form.acceleration, form.integrate(cogging_map.force), form.direction, form.one], axis=1)
        value = np.linalg.lstsq(design, form.current, rcond=None)[0]
        left.append(np.std(form.current - design @ value) / np.std(form.current))
        values.append(value)
    best = int(np.argmin(left))
    near = slice(best - 2, best + 3)
    bend, slope, _ = np.polyfit(shifts[near] - shifts[best], np.square(left)[near], 2)
    return shifts[best] - 0.5 * slope / bend, left[best], values[best][1], values[best][0]
