"""Motions of machines of any size: slow moves, strokes, sines, multisines in closed and in open loop."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from ..machines import log_uniform
from ..motions import Motion, Segment, move, play, rest, sine

#: What a log may hold. `open` has no loop: its command is the multisine, logged without a reference.
KINDS = ("slow", "strokes", "sine", "mixed", "multisine", "open")


@dataclass(frozen=True)
class Room:
    """Where and how fast an axis moves.

    Attributes:
        travel: m, or rad.
        velocity, acceleration: largest of its motions.
        band: lowest and highest frequency of its multisines, Hz.
        force: rms of the command that its multisines ask for, command unit; mass: its mass.
    """

    travel: tuple[float, float]
    velocity: float
    acceleration: float
    band: tuple[float, float]
    force: float
    mass: float

    @property
    def length(self) -> float:
        """Of the travel."""
        return self.travel[1] - self.travel[0]


def draw_motion(rng: np.random.Generator, kind: str, room: Room, time: np.ndarray) -> Motion:
    """Draw a motion of a kind that fills the time; of `open`, acceleration holds the command over the mass."""
    if kind in ("multisine", "open"):
        return _multisine(rng, room, time, closed=kind == "multisine")
    if kind == "sine":
        return _sines(rng, room, time)
    low, high = room.travel[0] + 0.03 * room.length, room.travel[1] - 0.03 * room.length
    place = start = float(rng.choice([low, high]))
    left = float(time[-1]) - 0.05
    segments: list[Segment] = [rest(0.05)]
    side = 1.0 if start == low else -1.0
    slow = room.velocity * log_uniform(rng, 0.05, 0.6)
    while left > 0.0:
        if kind == "slow":
            goal, speed = (high if side > 0 else low), slow
        else:
            goal = float(rng.uniform(low, high)) if rng.random() < 0.5 else (high if side > 0 else low)
            speed = room.velocity * (log_uniform(rng, 0.02, 1.0) if kind == "mixed" else rng.uniform(0.3, 1.0))
        side = -side
        speed = max(speed, abs(goal - place) / (0.45 * float(time[-1])))  # there and back within the log
        if abs(goal - place) < 0.02 * room.length:
            continue
        segment = move(goal - place, speed, room.acceleration * (0.5 if kind == "slow" else rng.uniform(0.4, 1.0)))
        pause = rest(rng.uniform(0.02, 0.15))
        segments += [segment, pause]
        left -= segment[0] + pause[0]
        place = goal
    return play(start, segments, time)


def _sines(rng: np.random.Generator, room: Room, time: np.ndarray) -> Motion:
    """Sines of several frequencies about one place."""
    place = room.travel[0] + room.length * rng.uniform(0.4, 0.6)
    left = float(time[-1]) - 0.05
    segments: list[Segment] = [rest(0.05)]
    while left > 0.0:
        fastest = room.velocity / (2 * np.pi * 0.05 * room.length)  # whose amplitude is a twentieth of the travel
        frequency = log_uniform(rng, max(2.0 / float(time[-1]), 0.05 * fastest), fastest)
        omega = 2 * np.pi * frequency
        reach = min(room.velocity / omega, room.acceleration / omega**2, 0.35 * room.length) * rng.uniform(0.5, 1.0)
        cycles = max(2, int(min(rng.uniform(0.15, 0.4) * float(time[-1]), left) * frequency))
        segments.append(sine(reach, frequency, cycles))
        left -= segments[-1][0]
    return play(place, segments, time)


def _multisine(rng: np.random.Generator, room: Room, time: np.ndarray, *, closed: bool) -> Motion:
    """Many tones of random phase, even in acceleration, that swell and fade; wide enough to shake a resonance loose."""
    span = float(time[-1])
    lines = np.unique(np.round(np.geomspace(room.band[0], room.band[1], 60) * span)) / span
    omega, phase = 2 * np.pi * lines, rng.uniform(0, 2 * np.pi, len(lines))
    size = room.force / room.mass * np.sqrt(2 / len(lines))
    s = np.clip(np.minimum(time, span - time) / (0.04 * span), 0.0, 1.0)
    angle = np.outer(time, omega) + phase
    middle = 0.5 * (room.travel[0] + room.travel[1])
    still = np.full_like(time, middle)
    if not closed:
        zero = np.zeros_like(time)
        return Motion(still, zero, s**2 * (3 - 2 * s) * (size * np.cos(angle)).sum(axis=1))
    rate = np.where(time < span / 2, 1.0, -1.0) / (0.04 * span)
    w, dw, ddw = s**3 * (10 - 15 * s + 6 * s**2), 30 * s**2 * (1 - s) ** 2, 60 * s * (1 - s) * (1 - 2 * s)
    dw, ddw = dw * rate, ddw * rate**2
    x = (-size / omega**2 * np.cos(angle)).sum(axis=1)
    v = (size / omega * np.sin(angle)).sum(axis=1)
    a = (size * np.cos(angle)).sum(axis=1)
    return Motion(still + w * x, dw * x + w * v, ddw * x + 2 * dw * v + w * a)
