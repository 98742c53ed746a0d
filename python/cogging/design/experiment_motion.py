"""The motion of an experiment: one recipe for every machine, scaled to its limits."""

from __future__ import annotations

from collections.abc import Callable
from itertools import count, cycle
from typing import Any, NamedTuple

import numpy as np

from cogging._core import PointToPoint, PointToPointParameters, Sampled
from cogging.arrays import FloatArray
from cogging.design.motion_limits import MotionLimits
from cogging.resources import LOG_COLUMNS, require_table

SHARE = 0.9  # of each limit, used by a reference; the machine exceeds it a little
MARGIN = 0.02  # of the travel, kept from each end
REST = 0.03  # s, after a move
SPEEDS = (0.4, 0.16, 1.0)  # of strokes, relative to the limit
SLOWEST = 0.2  # of random moves, relative to the limit
CREEP, CREEP_TIME = 0.02, 0.3  # speed of creep relative to the limit, and duration of one of its moves, s
SWEEP_START, SWEEP_END = 5.0, 0.1  # first frequency of the sweep, Hz, and last, relative to the sample rate
SWEEP_SIZE = 0.1  # of the travel: largest amplitude of the sweep


class Element(NamedTuple):
    """A part of the motion: its kind (strokes, random_moves, creep or sweep), start and end, s."""

    kind: str
    start: float
    end: float


class Track:
    """A reference built move by move, from rest in the middle of the travel; `limits` have travel and jerk."""

    def __init__(self, limits: MotionLimits, rate: float, scale: float) -> None:
        assert limits.travel is not None
        low, high = limits.travel
        margin = MARGIN * (high - low)
        self.low, self.high, self.rate = low + margin, high - margin, rate
        self.middle = self.place = 0.5 * (low + high)
        self.velocity, self.acceleration = SHARE * scale * limits.velocity, SHARE * scale * limits.acceleration
        self.jerk = SHARE * scale * (limits.jerk or np.inf)
        self.rows = self.end = max(3, int(limits.duration * rate) + 1)  # of the motion, and last of its present part
        require_table("duration", self.rows, LOG_COLUMNS)
        self.used, self.pieces = 0, list[tuple[FloatArray, ...]]()
        self.rest(0.1)

    def add(self, *columns: FloatArray) -> None:
        """Append rows of position, velocity and acceleration."""
        self.pieces.append(columns)
        self.used += len(columns[0])

    def rest(self, seconds: float) -> None:
        """Stay, at most to the end of the motion."""
        rows = min(round(seconds * self.rate), self.rows - self.used)
        self.add(np.full(rows, self.place), np.zeros(rows), np.zeros(rows))

    def move(self, goal: float, speed: float = 1.0, acceleration: float = 1.0) -> bool:
        """Move to a position (m) at shares of the limits, then rest; False, without a move, if time is too short."""
        goal = min(max(goal, self.low), self.high)
        if abs(goal - self.place) < 1e-9 * (self.high - self.low):
            return self.used < self.end
        way: dict[str, Any] = {"start": self.place, "distance": goal - self.place, "jerk": self.jerk}
        way |= {"velocity": speed * self.velocity, "acceleration": acceleration * self.acceleration}
        motion = PointToPoint(PointToPointParameters(**way))
        rows = int(np.ceil(0.5 * motion.period * self.rate))
        if self.used + rows > self.end:
            return False
        self.add(*motion.sample(np.minimum(np.arange(1, rows + 1) / self.rate, 0.5 * motion.period)))
        self.place = goal
        self.rest(REST)
        return True

    def approach(self, goal: float) -> bool:
        """Move to a position, or only a part of the way where time is short."""
        return any(self.move(self.place + part * (goal - self.place)) for part in (1.0, 0.3, 0.1))


def strokes(track: Track, random: np.random.Generator) -> None:
    """Move over the whole travel, both ways at several speeds; once at full speed, however long that takes."""
    end, track.end = track.end, track.rows
    fits = track.move(track.low) and track.move(track.high)
    track.end = end
    for speed in cycle(SPEEDS):
        fits = track.move(track.low, speed) and track.move(track.high, speed)
        if not fits and speed == 1.0:
            break


def random_moves(track: Track, random: np.random.Generator) -> None:
    """Move at random, at random speeds and accelerations: the same places at other times and under other commands."""
    fits = True
    while fits:
        goal = random.uniform(track.low, track.high)
        fits = track.move(goal, SLOWEST ** random.random(), random.uniform(0.3, 1.0)) or track.approach(goal)


def creep(track: Track, random: np.random.Generator) -> None:
    """Creep forward and back with small reversals."""
    track.approach(track.middle)
    step = CREEP_TIME * CREEP * track.velocity
    for number in count(1):
        step = -step if number % 24 == 0 else step
        if not track.move(track.place + step * (-0.4 if number % 3 == 0 else 1.0), CREEP):
            break


def sweep(track: Track, random: np.random.Generator) -> None:
    """Oscillate about one place at rising frequency, with the amplitude that the limits allow."""
    from scipy.interpolate import make_interp_spline

    track.approach(track.middle)
    rows, growth = track.end - track.used - 2, np.log(SWEEP_END * track.rate / SWEEP_START)
    room = min(SWEEP_SIZE * (track.high - track.low), track.place - track.low, track.high - track.place)
    if rows < track.rate / SWEEP_START or growth <= 0.0 or room <= 0.0:
        return
    time = np.arange(rows) / track.rate
    part = time / time[-1]
    omega = 2.0 * np.pi * SWEEP_START * np.exp(growth * part)
    phase = (omega - omega[0]) * time[-1] / growth
    ramp = np.minimum(1.0, 5.0 * np.minimum(part, 1.0 - part))
    ends = np.array([room, track.velocity, track.acceleration, track.jerk])
    needed = np.sum(omega ** np.arange(4)[:, None] / ends[:, None], axis=0)
    size = ramp**3 * (10.0 - 15.0 * ramp + 6.0 * ramp**2) / needed
    spline = make_interp_spline(time, size * np.sin(phase), k=5)
    columns = np.array([spline.derivative(order)(time) for order in range(3)])
    largest = np.append(np.abs(columns).max(axis=1), track.rate * np.abs(np.diff(columns[2])).max())
    columns *= min(1.0, float(np.min(ends / largest)))
    track.add(track.place + columns[0], columns[1], columns[2])


#: The parts in order, with the share of the remaining time that each may use.
RECIPE: dict[Callable[[Track, np.random.Generator], None], float]
RECIPE = {strokes: 0.4, random_moves: 0.5, creep: 0.6, sweep: 1.0}


def motion_within(
    limits: MotionLimits, rate: float, *, scale: float = 1.0, seed: int = 0
) -> tuple[Sampled, tuple[Element, ...]]:
    """Return the motion of an experiment, from rest to rest, and its parts.

    `limits` have travel and jerk (MotionLimits.of), `rate` is that of the samples, Hz; a `scale` of speed, acceleration
    and jerk below 1 is for a machine that would exceed its limits.
    """
    track, random, elements = Track(limits, rate, scale), np.random.default_rng(seed), []
    for part, share in RECIPE.items():
        begun = track.used
        track.end = track.used + int(share * (track.rows - track.used))
        part(track, random)
        if track.used > begun:
            elements.append(Element(part.__name__, begun / rate, track.used / rate))
    track.rest((track.rows - track.used) / rate)
    columns = (np.concatenate(column) for column in zip(*track.pieces, strict=True))
    return Sampled(np.arange(track.rows) / rate, *columns), tuple(elements)
