"""Motions made of strokes, creep, short steps and random moves that keep to a machine's limits, drawn at random."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from cogging._core import PointToPoint, PointToPointParameters, Sampled
from cogging.arrays import FloatArray
from cogging.design.experiment.limits import MotionLimits
from cogging.logs.log import Log
from cogging.resources import LOG_COLUMNS, require_table

SHARE = 0.9  # of each limit, that a reference takes: its machine does a little more
MARGIN = 0.02  # of the travel, kept from each end
REST = 0.03  # s, after a move
NEAR = 0.35  # deviation of the logarithm of a number that is drawn near its old value
SAME = 0.1  # of the rms motion: references that differ by less are one


@dataclass(frozen=True)
class Element:
    """A kind of motion with its numbers.

    Attributes:
        kind: name of the kind, a key of KINDS.
        parameters: its numbers by name: shares of the limits or of the travel, s or counts.
        scale: of speed, acceleration and jerk: below 1 for a machine that would exceed its limits.
    """

    kind: str
    parameters: Mapping[str, float]
    scale: float = 1.0

    def text(self) -> str:
        """In a few words."""
        return f"{self.kind.replace('_', ' ')} ({', '.join(f'{k} {v:.3g}' for k, v in self.parameters.items())})"


class Track:
    """A motion that grows move by move, from the middle of the travel.

    Args:
        limits: with travel and jerk (MotionLimits.of).
        rate: of the samples, Hz.
        duration: s, after which nothing more is added.
    """

    def __init__(self, limits: MotionLimits, rate: float, duration: float) -> None:
        low, high = limits.travel or (0.0, 0.0)
        margin = MARGIN * (high - low)
        self.limits, self.low, self.high, self.scale = limits, low + margin, high - margin, SHARE
        self.rate, self.rows = rate, max(3, int(np.floor(duration * rate)) + 1)
        require_table("duration", self.rows, LOG_COLUMNS)
        self.place = 0.5 * (low + high)
        self.used = 1  # rows, that before the first move included
        self.pieces: list[tuple[FloatArray, FloatArray, FloatArray]] = []

    def at(self, share: float) -> float:
        """The position at a share of the travel, m."""
        return self.low + (self.high - self.low) * min(max(share, 0.0), 1.0)

    def rest(self, seconds: float) -> None:
        """Stay."""
        count = min(round(seconds * self.rate), self.rows - self.used)
        self._add(np.full(count, self.place), np.zeros(count), np.zeros(count))

    def move(self, goal: float, speed: float = 1.0, acceleration: float = 1.0) -> bool:
        """Move to a position (m) at shares of the limits; False, and no move, where too little time is left."""
        goal = min(max(goal, self.low), self.high)
        if abs(goal - self.place) < 1e-9 * (self.high - self.low):
            return self.used < self.rows
        motion = PointToPoint(
            PointToPointParameters(
                start=self.place,
                distance=goal - self.place,
                velocity=self.scale * speed * self.limits.velocity,
                acceleration=self.scale * acceleration * self.limits.acceleration,
                jerk=self.scale * (self.limits.jerk or np.inf),
            )
        )
        count = int(np.ceil(0.5 * motion.period * self.rate))
        if self.used + count > self.rows:
            return False
        self._add(*motion.sample(np.minimum(np.arange(1, count + 1) / self.rate, 0.5 * motion.period)))
        self.place = goal
        return True

    def motion(self) -> Sampled:
        """What was put together, at rest from there to the end of its time."""
        self.rest((self.rows - self.used) / self.rate)
        position, velocity, acceleration = (np.concatenate(column) for column in zip(*self.pieces, strict=True))
        rows = [
            np.append(first, rest) for first, rest in ((position[0], position), (0.0, velocity), (0.0, acceleration))
        ]
        return Sampled(np.arange(len(rows[0])) / self.rate, *rows)

    def _add(self, position: FloatArray, velocity: FloatArray, acceleration: FloatArray) -> None:
        self.pieces.append((position, velocity, acceleration))
        self.used += len(position)


def strokes(track: Track, p: Mapping[str, float]) -> None:
    """There and back over a share of the travel, at speeds that fall from stroke to stroke and begin again."""
    half, speeds, done = 0.5 * p["reach"], max(1, round(p["speeds"])), 0
    center = min(max(p["middle"], half), 1.0 - half)
    fits = track.move(track.at(center - half))
    while fits:
        for share in (center + half, center - half):
            fits = track.move(track.at(share), p["speed"] * 0.4 ** (done % speeds), p["acceleration"])
            track.rest(p["rest"] if fits else 0.0)
        fits |= done % speeds > 0  # a slow stroke that has no room may leave room for a quick one
        done += 1


def creep(track: Track, p: Mapping[str, float]) -> None:
    """Slowly forward with small reversals, then the same way back."""
    step, done = p["step"] * (track.high - track.low), 0
    fits = track.move(track.at(p["middle"]), 0.5)
    while fits:
        done += 1
        if done % 12 == 0 or not track.low < track.place + step < track.high:
            step = -step
        fits = track.move(track.place + step * (-0.4 if done % 3 == 0 else 1.0), p["speed"])


def steps(track: Track, p: Mapping[str, float]) -> None:
    """Short moves as quick as may be, to and fro about places along the travel."""
    length, places, done = p["step"] * (track.high - track.low), (0.5, 0.2, 0.8, 0.35, 0.65, 0.05, 0.95), 0
    while track.move(track.at(places[done % len(places)]), 0.5):
        for sign in (1.0, -1.0, -1.0, 1.0) * 3:
            track.move(track.place + sign * length)
            track.rest(p["rest"])
        done += 1


def random_moves(track: Track, p: Mapping[str, float]) -> None:
    """Moves between random places at random speeds and accelerations: what comes with time does not come with place."""
    random, fits = np.random.default_rng(round(p["seed"])), True
    while fits:
        speed, acceleration = p["slowest"] ** random.random(), random.uniform(0.3, 1.0)
        goal = track.at(random.random())
        fits = track.move(goal, speed, acceleration) or track.move(goal)
        track.rest(REST)


Ends = tuple[float, float]
#: The kinds, each with its numbers and the ends between which they are drawn, evenly in their logarithm.
KINDS: dict[str, tuple[Callable[[Track, Mapping[str, float]], None], dict[str, Ends]]] = {
    "strokes": (
        strokes,
        {"reach": (0.06, 1.0), "middle": (0.1, 0.9), "speed": (0.1, 1.0), "speeds": (1.0, 4.0)}
        | {"acceleration": (0.2, 1.0), "rest": (0.03, 0.5)},
    ),
    "creep": (creep, {"speed": (0.004, 0.1), "step": (0.001, 0.05), "middle": (0.1, 0.9)}),
    "steps": (steps, {"step": (0.003, 0.2), "rest": (0.03, 0.3)}),
    "random_moves": (random_moves, {"seed": (1.0, 1e6), "slowest": (0.03, 0.7)}),
}
#: Strokes over the whole travel at three speeds, by which a machine is surveyed.
SURVEY = Element(
    "strokes", {"reach": 1.0, "middle": 0.5, "speed": 1.0, "speeds": 3.0, "acceleration": 1.0, "rest": REST}
)


def drawn(random: np.random.Generator, near: Element | None = None) -> Element:
    """An element drawn at random; `near`: of its kind, with numbers near its own."""
    kind = str(random.choice(list(KINDS))) if near is None else near.kind
    numbers = {}
    for name, (low, high) in KINDS[kind][1].items():
        value = low * (high / low) ** random.random()
        if near is not None:
            value = min(max(near.parameters[name] * np.exp(NEAR * random.normal()), low), high)
        numbers[name] = float(f"{value:.3g}")
    return Element(kind, numbers)


def planned(elements: Sequence[Element], limits: MotionLimits, rate: float) -> Sampled:
    """The elements one after another in even shares of the time, from rest in the middle of the travel to rest.

    Args:
        elements: what is run, in its order.
        limits: with travel and jerk (MotionLimits.of).
        rate: of the samples, Hz.
    """
    track = Track(limits, rate, limits.duration)
    track.rest(0.1)
    rows = track.rows
    for number, element in enumerate(elements):
        track.rows = track.used + (rows - track.used) // (len(elements) - number)
        track.scale = SHARE * element.scale
        KINDS[element.kind][0](track, element.parameters)
    track.rows = rows
    return track.motion()


def is_known(motion: Sampled, logs: Sequence[Log]) -> bool:
    """Whether a log has followed this motion already."""
    for log in logs:
        time = log.time - log.time[0]
        asked = motion.sample(time[time <= motion.end])[0]
        done = (log.position if log.reference is None else log.reference)[: len(asked)]
        if motion.end <= 1.1 * time[-1] and np.std(asked - done) < SAME * np.std(asked):
            return True
    return False
