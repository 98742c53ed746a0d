"""Shapes drawn at random: splines, mixtures and laws of many kinds, of which the usual ones are single points.

Each function draws once and gives a function that is fixed from then on. What is drawn is smooth where a machine is,
and has a size of about one: the amplitude stands elsewhere.
"""

from collections.abc import Callable

import numpy as np
from scipy.interpolate import CubicSpline, PchipInterpolator

Shape = Callable[[np.ndarray], np.ndarray]


def any_wave(rng: np.random.Generator) -> Shape:
    """A periodic function of an angle (rad) whose strongest line is its first: harmonics, flats, pulses, splines."""
    while True:
        wave = _wave(rng)
        values = wave(np.linspace(0.0, 2 * np.pi, 720, endpoint=False))
        lines = np.abs(np.fft.rfft(values - values.mean()))
        if lines[1] > 1.3 * lines[2:].max():
            middle, size = float(values.mean()), float(np.abs(values - values.mean()).max())
            return lambda at: (wave(at) - middle) / size


def _wave(rng: np.random.Generator) -> Shape:
    kind, shift = rng.choice(["harmonics", "square", "triangle", "pulse", "spline"]), rng.uniform(0, 2 * np.pi)
    if kind == "harmonics":
        orders = np.arange(1, int(rng.integers(3, 7)))
        sizes = orders ** -rng.uniform(0.8, 2.5) * rng.uniform(0.3, 1.0, len(orders))
        sizes[0], phases = 1.0, rng.uniform(0, 2 * np.pi, len(orders))
        return lambda a: sum(s * np.sin(k * a + p) for s, k, p in zip(sizes, orders, phases, strict=True))
    if kind == "square":  # with a duty of its own, and edges that are not steep
        steep, level = rng.uniform(1.5, 8.0), rng.uniform(-0.4, 0.4)
        return lambda a: np.tanh(steep * (np.sin(a + shift) - level))
    if kind == "triangle":  # rising for one part, falling for the other
        top = rng.uniform(0.2, 0.8)
        return lambda a: np.interp(np.mod((a + shift) / (2 * np.pi), 1.0), [0.0, top, 1.0], [-1.0, 1.0, -1.0])
    if kind == "pulse":
        sharp = rng.uniform(0.8, 3.0)
        return lambda a: np.exp(sharp * (np.cos(a + shift) - 1.0))
    knots = np.linspace(0.0, 1.0, int(rng.integers(5, 8)))
    values = np.sin(2 * np.pi * knots) + 0.5 * rng.standard_normal(len(knots))
    values[-1] = values[0]
    spline = CubicSpline(knots, values, bc_type="periodic")
    return lambda a: spline(np.mod((a + shift) / (2 * np.pi), 1.0))


def any_profile(rng: np.random.Generator) -> Shape:
    """A function of the share of the travel, 0 to 1, of size one: splines, bells, edges, waves, and mixtures of two."""
    parts = [_profile(rng) for _ in range(1 + int(rng.random() < 0.4))]
    weights = rng.uniform(0.4, 1.0, len(parts)) * rng.choice([-1.0, 1.0], len(parts))
    at = np.linspace(0.0, 1.0, 400)

    def mixture(s: np.ndarray) -> np.ndarray:
        return sum(weight * part(s) for weight, part in zip(weights, parts, strict=True))

    middle = float(mixture(at).mean())
    size = float(np.abs(mixture(at) - middle).max())
    return lambda s: (mixture(s) - middle) / size


def _profile(rng: np.random.Generator) -> Shape:
    kind, place = rng.choice(["spline", "bell", "edge", "wave"]), rng.uniform(0.15, 0.85)
    width, shift = rng.uniform(0.06, 0.25), rng.uniform(0, 2 * np.pi)
    if kind == "spline":
        knots = np.linspace(-0.1, 1.1, int(rng.integers(4, 8)))
        spline = CubicSpline(knots, rng.standard_normal(len(knots)))
        return lambda s: spline(np.clip(s, -0.1, 1.1))
    if kind == "bell":
        return lambda s: np.exp(-(((s - place) / width) ** 2))
    if kind == "edge":
        return lambda s: np.tanh((s - place) / width)
    turns = rng.uniform(0.5, 1.8)
    return lambda s: np.sin(2 * np.pi * turns * s + shift)


def any_decay(rng: np.random.Generator) -> Shape:
    """One at 0, none far off: how a force falls with the distance (in lengths) from an end, or friction with speed."""
    kind, power = rng.choice(["stretched", "rational", "tanh", "ramp", "two"]), rng.uniform(1.3, 3.0)
    if kind == "stretched":
        exponent = rng.uniform(0.8, 2.5)
        return lambda d: np.exp(-(np.maximum(d, 0.0) ** exponent))
    if kind == "rational":
        return lambda d: 1.0 / (1.0 + np.maximum(d, 0.0) ** power)
    if kind == "tanh":
        return lambda d: 1.0 - np.tanh(np.maximum(d, 0.0)) ** 2
    if kind == "ramp":  # that ends, with a rounded corner
        return lambda d: np.clip(1.0 - np.maximum(d, 0.0) / (1.2 * power), 0.0, 1.0) ** power
    far, share = rng.uniform(2.0, 3.0), rng.uniform(0.2, 0.5)
    return lambda d: (1 - share) * np.exp(-np.maximum(d, 0.0)) + share * np.exp(-np.maximum(d, 0.0) / far)


def any_rise(rng: np.random.Generator) -> Shape:
    """From 0 at 0 to 1 at 1, never falling: exponentials, roots, an S, a spline."""
    kind, tau, power = rng.choice(["exponential", "power", "logistic", "spline"]), rng.uniform(0.1, 0.6), None
    if kind == "exponential":
        return lambda s: (1 - np.exp(-s / tau)) / (1 - np.exp(-1 / tau))
    if kind == "power":
        power = rng.uniform(0.4, 1.6)
        return lambda s: np.maximum(s, 0.0) ** power
    if kind == "logistic":
        place, width = rng.uniform(0.25, 0.7), rng.uniform(0.08, 0.2)

        def logistic(s: np.ndarray) -> np.ndarray:
            return np.tanh((s - place) / width)

        low, high = logistic(np.zeros(1))[0], logistic(np.ones(1))[0]
        return lambda s: (logistic(s) - low) / (high - low)
    return any_spring(rng)


def any_spring(rng: np.random.Generator) -> Shape:
    """A force over the share of the travel that never falls, of slope about one: softer here, harder there."""
    steps = rng.uniform(0.15, 1.0, int(rng.integers(3, 6)))
    knots = np.linspace(0.0, 1.0, len(steps) + 1)
    return PchipInterpolator(knots, np.concatenate([[0.0], np.cumsum(steps)]) / steps.sum(), extrapolate=True)


def any_pulse(rng: np.random.Generator) -> Shape:
    """A push over the share of its time, 0 to 1: trapezoid, half sine, sawtooth, one that fades, two levels."""
    kind, rise = rng.choice(["trapezoid", "half_sine", "sawtooth", "fading", "levels"]), rng.uniform(0.05, 0.4)

    def inside(s: np.ndarray) -> np.ndarray:
        return ((s >= 0.0) & (s <= 1.0)).astype(float)

    if kind == "trapezoid":
        return lambda s: np.clip(s / rise, 0, 1) * np.clip((1 - s) / rise, 0, 1)
    if kind == "half_sine":
        return lambda s: inside(s) * np.sin(np.pi * np.clip(s, 0.0, 1.0))
    if kind == "sawtooth":
        return lambda s: inside(s) * np.clip(s, 0.0, 1.0)
    if kind == "fading":
        return lambda s: inside(s) * np.exp(-2.5 * np.clip(s, 0.0, 1.0))
    first, level = rng.uniform(0.3, 0.7), rng.uniform(0.3, 0.7)
    return lambda s: inside(s) * np.where(s < first, 1.0, level)
