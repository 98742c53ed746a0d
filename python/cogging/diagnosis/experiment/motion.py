"""Motions that engineers run, put together of moves, swings and rests that keep to a machine's limits."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass, field

import numpy as np

from cogging._core import PointToPoint, PointToPointParameters, Sampled
from cogging.arrays import FloatArray
from cogging.diagnosis.experiment.limits import MotionLimits
from cogging.diagnosis.thresholds import MOTION
from cogging.memory import LOG_COLUMNS, require_table


@dataclass(frozen=True)
class Element:
    """A kind of motion with its parameters: an entry of the dictionary.

    Attributes:
        kind: name of the kind, a key of KINDS.
        parameters: its numbers by name; shares of what the limits allow, or Hz.
        scale: of speed, acceleration and jerk: below 1 for a machine that would exceed its limits.
    """

    kind: str
    parameters: Mapping[str, float] = field(default_factory=dict)
    scale: float = 1.0

    def text(self) -> str:
        """In a few words."""
        told = ", ".join(f"{name.replace('_', ' ')} {value:.3g}" for name, value in self.parameters.items())
        return f"{self.kind.replace('_', ' ')}{' (' if told else ''}{told}{')' if told else ''}"


class Track:
    """A motion that grows piece by piece.

    Args:
        limits: with travel and jerk (MotionLimits.of).
        rate: of the samples, Hz.
        duration: s, after which nothing more is added.
        start: position, m; the middle of the travel when None.
    """

    def __init__(self, limits: MotionLimits, rate: float, duration: float, start: float | None = None) -> None:
        low, high = limits.travel or (0.0, 0.0)
        margin = MOTION.travel_margin * (high - low)
        self.limits, self.low, self.high = limits, low + margin, high - margin
        self.slow_down(1.0)
        self.rate, self.rows = rate, max(3, int(np.floor(duration * rate)) + 1)
        require_table("duration", self.rows, LOG_COLUMNS)
        self.place = 0.5 * (low + high) if start is None else start
        self.pieces: list[tuple[FloatArray, FloatArray, FloatArray]] = []
        self.used = 1  # rows, that before the first move included

    def slow_down(self, scale: float) -> None:
        """Take a share of what the limits allow from here on."""
        self.velocity = scale * MOTION.reference_share * self.limits.velocity
        self.acceleration = scale * MOTION.reference_share * self.limits.acceleration
        self.jerk = scale * MOTION.reference_share * (self.limits.jerk or np.inf)

    @property
    def left(self) -> float:
        """Seconds that are left."""
        return (self.rows - self.used) / self.rate

    def at(self, share: float) -> float:
        """The position at a share of the travel, m."""
        return self.low + (self.high - self.low) * min(max(share, 0.0), 1.0)

    def rest(self, seconds: float) -> None:
        """Stay."""
        count = min(round(seconds * self.rate), self.rows - self.used)
        if count > 0:
            self._add(np.full(count, self.place), np.zeros(count), np.zeros(count))

    def move(self, goal: float, speed: float = 1.0, acceleration: float = 1.0, until: float = 0.0) -> bool:
        """Move to a position (m) at shares of the limits; False, and no move, where less time than `until` is left."""
        goal = min(max(goal, self.low), self.high)
        distance = goal - self.place
        if abs(distance) < MOTION.move_min * (self.high - self.low):
            return True
        parameters = PointToPointParameters(
            start=self.place,
            distance=distance,
            velocity=self.velocity * speed,
            acceleration=self.acceleration * acceleration,
            jerk=self.jerk,
        )
        motion = PointToPoint(parameters)
        count = int(np.ceil(0.5 * motion.period * self.rate))
        if self.used + count > self.rows - until * self.rate:
            return False
        position, velocity, slope = motion.sample(np.minimum(np.arange(1, count + 1) / self.rate, 0.5 * motion.period))
        self._add(position, velocity, slope)
        self.place = goal
        return True

    def ride(self, shape: Callable[[FloatArray], FloatArray], seconds: float, reach: float, across: float) -> bool:
        """Move by `across` (m) in so many seconds and swing about that by a shape, as far as limits and `reach` allow.

        Args:
            shape: of the swing over time (s), any size; it swells from and fades to nothing.
            seconds: of the piece.
            reach: largest swing, m.
            across: what the piece covers, m, signed; the swing never turns a piece that covers something back.

        Returns:
            False, and nothing added, where no time or no room is left.
        """
        count = round(seconds * self.rate)
        if count < MOTION.ride_rows or self.used + count > self.rows:
            return False
        t = np.arange(count + 1) / self.rate
        end = float(t[-1])
        fade = min(0.25 * end, 0.5)
        swell = _smooth(t / fade) * _smooth((end - t) / fade)
        base = self.place + across * _even_ramp(t / end)
        swing = shape(t) * swell
        largest = float(np.abs(swing).max())
        steady = self._derivatives(base)
        moved = self._derivatives(swing)
        bounds = (self.velocity, self.acceleration, self.jerk)
        if largest <= 0.0 or any(float(np.abs(s).max()) > b for s, b in zip(steady, bounds, strict=True)):
            return False
        sizes = [
            (b - float(np.abs(s).max())) / max(float(np.abs(m).max()), 1e-300)
            for s, m, b in zip(steady, moved, bounds, strict=True)
        ]
        if across != 0.0:  # friction says nothing while an axis keeps turning back
            middle = (t > fade) & (t < end - fade)
            sizes.append(0.8 * abs(across) / end / max(float(np.abs(moved[0][middle]).max()), 1e-300))
        room = min(float((base - self.low).min()), float((self.high - base).min()))
        factor = min(*sizes, reach / largest, max(room, 0.0) / largest)
        if factor * largest < MOTION.move_min * (self.high - self.low):
            return False
        position = base + factor * swing
        velocity, acceleration, _ = self._derivatives(position)
        self._add(position[1:], velocity[1:], acceleration[1:])
        self.place = float(position[-1])
        return True

    def motion(self) -> Sampled:
        """What was put together, at rest from there to the end of its time."""
        self.rest(self.left)
        columns = [np.concatenate(column) for column in zip(*self.pieces, strict=True)]
        position = np.concatenate([columns[0][:1], columns[0]])
        zero = np.zeros(1)
        return Sampled(
            np.arange(len(position)) / self.rate,
            position,
            np.concatenate([zero, columns[1]]),
            np.concatenate([zero, columns[2]]),
        )

    def _add(self, position: FloatArray, velocity: FloatArray, acceleration: FloatArray) -> None:
        self.pieces.append((position, velocity, acceleration))
        self.used += len(position)

    def _derivatives(self, position: FloatArray) -> tuple[FloatArray, FloatArray, FloatArray]:
        """Velocity, acceleration and jerk of a smooth position that rests at its ends."""
        velocity = np.gradient(position, 1.0 / self.rate)
        velocity[[0, -1]] = 0.0
        acceleration = np.gradient(velocity, 1.0 / self.rate)
        acceleration[[0, -1]] = 0.0
        return velocity, acceleration, np.diff(acceleration, prepend=acceleration[0]) * self.rate


def _smooth(s: FloatArray) -> FloatArray:
    """From 0 to 1 with three derivatives that vanish at both ends."""
    s = np.clip(s, 0.0, 1.0)
    return np.asarray(s**4 * (35.0 - 84.0 * s + 70.0 * s**2 - 20.0 * s**3))


def _even_ramp(s: FloatArray) -> FloatArray:
    """From 0 to 1 at a speed that is even in its middle: the first and last fifth speed up and slow down."""
    speed = _smooth(s / 0.2) * _smooth((1.0 - s) / 0.2)
    covered = np.concatenate([[0.0], np.cumsum(0.5 * (speed[1:] + speed[:-1]))])
    return np.asarray(covered / covered[-1])


# The dictionary -------------------------------------------------------------------------------------------------------


def strokes(track: Track, p: Mapping[str, float]) -> None:
    """There and back over a share of the travel about a place, at speeds that fall by a ratio from stroke to stroke."""
    half = 0.5 * p.get("reach", 1.0)
    center = min(max(p.get("middle", 0.5), half), 1.0 - half)
    speed, steps, done = p.get("speed", 1.0), max(1, round(p.get("speeds", 1.0))), 0
    ends = (track.at(center - half), track.at(center + half))
    if not track.move(ends[0]):
        return
    while True:
        share = speed * p.get("ratio", 0.4) ** (done % steps)
        for goal in (ends[1], ends[0]):
            if not track.move(goal, share, p.get("acceleration", 1.0)):
                if done % steps == 0:
                    return
                break
            track.rest(p.get("rest", MOTION.rest_between))
        done += 1


def creep(track: Track, p: Mapping[str, float]) -> None:
    """Slowly forward with small reversals, then the same way back."""
    if not track.move(track.at(p.get("middle", 0.5)), 0.5):
        return
    speed, step = p.get("speed", 0.02), p.get("step", 0.02) * (track.high - track.low)
    forward, done = 1.0, 0
    while track.left > MOTION.creep_left:
        length = -0.4 * step if done % MOTION.creep_back == MOTION.creep_back - 1 else step
        goal = track.place + forward * length
        if not track.low < goal < track.high or done % MOTION.creep_turn == MOTION.creep_turn - 1:
            forward = -forward
            goal = track.place + forward * abs(length)
        if not track.move(goal, speed):
            return
        done += 1


def multisine(track: Track, p: Mapping[str, float]) -> None:
    """Slow strokes with a sum of sines on them: even lines from a low to a high frequency, phases after Schroeder."""
    low, high = p.get("low", 2.0), min(p.get("high", 20.0), 0.2 * track.rate)
    lines = np.geomspace(low, max(high, 1.05 * low), 12)
    phases = np.pi * np.arange(12) ** 2 / 12.0

    def shape(t: FloatArray) -> FloatArray:
        waves = np.sin(2.0 * np.pi * np.outer(lines, t) + phases[:, None])
        return np.asarray((waves / lines[:, None] ** p.get("slope", 1.5)).sum(axis=0))

    reach = 0.8 * (track.high - track.low)
    _rides(track, shape, reach, p.get("speed", 0.3))


def swings(track: Track, p: Mapping[str, float]) -> None:
    """A sine in place, its frequency rising through a band."""
    if not track.move(track.at(p.get("middle", 0.5)), 0.5):
        return
    low, high = p.get("low", 1.0), min(p.get("high", 10.0), 0.2 * track.rate)
    reach = 0.5 * p.get("reach", 0.3) * (track.high - track.low)
    seconds = min(4.0, track.left - 0.02)
    while track.left > MOTION.swings_left:
        length = min(seconds, track.left - 0.01)

        def shape(t: FloatArray, length: float = length) -> FloatArray:
            rate = np.log(high / low) / length
            return np.asarray(np.sin(2.0 * np.pi * low * np.expm1(rate * t) / rate) / np.exp(rate * t) ** 1.5)

        if not track.ride(shape, length, reach, 0.0):
            return


def steps(track: Track, p: Mapping[str, float]) -> None:
    """Short moves as quick as may be, to and fro about places along the travel."""
    length = p.get("step", 0.01) * (track.high - track.low)
    places = np.array([0.5, 0.2, 0.8, 0.35, 0.65, 0.05, 0.95])
    for place in np.tile(places, 1000):
        if not track.move(track.at(place), 0.5):
            return
        for sign in (1.0, -1.0, -1.0, 1.0) * 3:
            if not track.move(track.place + sign * length):
                return
            track.rest(p.get("rest", MOTION.rest_between))


def random_moves(track: Track, p: Mapping[str, float]) -> None:
    """Moves between random places at random speeds and accelerations: what comes with time does not come with place."""
    random = np.random.default_rng(round(p.get("seed", 0.0)))
    for _ in range(100_000):
        speed = float(np.exp(random.uniform(np.log(p.get("slowest", 0.05)), 0.0)))
        goal, acceleration = track.at(float(random.random())), float(random.uniform(0.3, 1.0))
        if not track.move(goal, speed, acceleration):
            if track.left < 1.0:
                return
            if not track.move(goal):
                return
        track.rest(MOTION.rest_between)


def dwell(track: Track, p: Mapping[str, float]) -> None:
    """Strokes with long rests between."""
    strokes(track, {"reach": p.get("reach", 0.5), "speed": p.get("speed", 0.5), "rest": p.get("rest", 0.5)})


def _rides(track: Track, shape: Callable[[FloatArray], FloatArray], reach: float, speed: float) -> None:
    """Strokes at a share of the speed with a swing on each."""
    side = 1.0
    span = track.high - track.low
    across = min(reach, 0.75 * (track.left - 0.5) * speed * track.velocity)
    if across <= 0.0 or not track.move(0.5 * (track.low + track.high - across), 0.5):
        return
    seconds = across / (0.8 * speed * track.velocity)
    while track.left > seconds:
        if not track.ride(shape, seconds, 0.1 * span, side * across):
            return
        side = -side
        track.rest(MOTION.rest_between)


KINDS: dict[str, Callable[[Track, Mapping[str, float]], None]] = {
    "strokes": strokes,
    "creep": creep,
    "multisine": multisine,
    "swings": swings,
    "steps": steps,
    "random_moves": random_moves,
    "dwell": dwell,
}


def dictionary() -> Iterator[Element]:
    """The motions that are tried first, in their order."""
    for speed in (1.0, 0.4, 0.15):
        yield Element("strokes", {"reach": 1.0, "speed": speed})
    yield Element("strokes", {"reach": 1.0, "speed": 1.0, "speeds": 4.0, "ratio": 0.4})
    yield Element("strokes", {"reach": 1.0, "speed": 0.4, "acceleration": 0.2})
    for reach, center in ((0.25, 0.5), (0.25, 0.125), (0.25, 0.875), (0.06, 0.5)):
        yield Element("strokes", {"reach": reach, "speed": 1.0, "middle": center})
    yield Element("strokes", {"reach": 0.3, "speed": 0.1, "middle": 0.5})
    for speed, step in ((0.05, 0.02), (0.02, 0.01), (0.01, 0.003), (0.004, 0.001)):
        yield Element("creep", {"speed": speed, "step": step})
    for low, high, speed in ((1.0, 10.0, 0.3), (5.0, 50.0, 0.2), (20.0, 200.0, 0.1), (20.0, 200.0, 0.3)):
        yield Element("multisine", {"low": low, "high": high, "speed": speed})
    for low, high, reach in ((0.5, 3.0, 0.8), (2.0, 15.0, 0.3), (10.0, 60.0, 0.1)):
        yield Element("swings", {"low": low, "high": high, "reach": reach})
    for step in (0.1, 0.02, 0.003):
        yield Element("steps", {"step": step})
    for seed in (1.0, 2.0):
        yield Element("random_moves", {"seed": seed, "slowest": 0.05})
    yield Element("random_moves", {"seed": 3.0, "slowest": 0.4})
    yield Element("dwell", {"reach": 0.5, "speed": 0.5, "rest": 0.5})


def planned(elements: tuple[Element, ...], limits: MotionLimits, rate: float, scale: float = 1.0) -> Sampled:
    """The motions one after another in even shares of the time, from rest in the middle of the travel to rest.

    Args:
        elements: what is run, in its order.
        limits: with travel and jerk (MotionLimits.of).
        rate: of the samples, Hz.
        scale: of speed, acceleration and jerk, beside that of each element.
    """
    track = Track(limits, rate, limits.duration)
    track.rest(MOTION.first_rest)
    rows = track.rows
    for number, element in enumerate(elements, start=1):
        track.rows = track.used + (rows - track.used) // (len(elements) - number + 1)
        track.slow_down(scale * element.scale)
        KINDS[element.kind](track, element.parameters)
    track.rows = rows
    return track.motion()
