"""References of a blind case: jerk-limited moves, sines, slow creep with small reversals, in random order."""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

Segment = tuple[float, Callable[[np.ndarray], tuple[np.ndarray, np.ndarray, np.ndarray]], float]


@dataclass(frozen=True)
class Motion:
    """Reference position (m), velocity and acceleration over the samples, (n,) each."""

    position: np.ndarray
    velocity: np.ndarray
    acceleration: np.ndarray


def move(distance: float, velocity: float, acceleration: float) -> Segment:
    """A move at rest at both ends: velocity rises as V s^2 (3 - 2 s), cruises, falls likewise."""
    size = abs(distance)
    peak = min(velocity, np.sqrt(size * acceleration / 1.5))
    ramp = 1.5 * peak / acceleration
    cruise = max(size / peak - ramp, 0.0)
    duration, sign = 2 * ramp + cruise, np.sign(distance)

    def at(t: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        rising = np.clip(t / ramp, 0.0, 1.0)
        falling = np.clip((duration - t) / ramp, 0.0, 1.0)
        middle = np.clip(t - ramp, 0.0, cruise)
        x = peak * (ramp * (rising**3 - rising**4 / 2) + middle + ramp * (0.5 - falling**3 + falling**4 / 2))
        v = peak * np.minimum(rising**2 * (3 - 2 * rising), falling**2 * (3 - 2 * falling))
        a = peak / ramp * 6 * (rising * (1 - rising) - falling * (1 - falling))
        return sign * x, sign * v, sign * a

    return duration, at, distance


def sine(amplitude: float, frequency: float, cycles: int) -> Segment:
    """Cycles of a sine that swells and fades within one period each."""
    omega, duration = 2 * np.pi * frequency, cycles / frequency

    def at(t: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        side = np.where(t < duration / 2, 1.0, -1.0)
        s = np.clip(np.minimum(t, duration - t) * frequency, 0.0, 1.0)
        w = s**3 * (10 - 15 * s + 6 * s**2)
        dw = side * frequency * 30 * s**2 * (1 - s) ** 2
        ddw = frequency**2 * 60 * s * (1 - s) * (1 - 2 * s)
        sin, cos = np.sin(omega * t), np.cos(omega * t)
        x = amplitude * w * sin
        v = amplitude * (dw * sin + w * omega * cos)
        a = amplitude * (ddw * sin + 2 * dw * omega * cos - w * omega**2 * sin)
        return x, v, a

    return duration, at, 0.0


def rest(duration: float) -> Segment:
    return duration, lambda t: (np.zeros_like(t), np.zeros_like(t), np.zeros_like(t)), 0.0


def play(start: float, segments: list[Segment], time: np.ndarray) -> Motion:
    """Put segments after each other and read them at the samples; at rest after the last."""
    x, v, a = np.full_like(time, start), np.zeros_like(time), np.zeros_like(time)
    begin, place = 0.0, start
    for duration, at, distance in segments:
        inside = (time >= begin) & (time < begin + duration)
        dx, v[inside], a[inside] = at(time[inside] - begin)
        x[inside] = place + dx
        begin, place = begin + duration, place + distance
        x[time >= begin] = place
    return Motion(x, v, a)


def draw_motion(
    rng: np.random.Generator,
    time: np.ndarray,
    travel: tuple[float, float],
    velocity: float,
    acceleration: float,
    *,
    poor: bool = False,
) -> Motion:
    """Draw a motion that fills the time: sweeps of the travel, moves, sines, creep; `poor`: one kind of move only."""
    low = travel[0] + 0.03 * (travel[1] - travel[0])
    high = travel[1] - 0.03 * (travel[1] - travel[0])
    place = float(rng.uniform(low, high))
    start, left = place, float(time[-1]) - 0.1
    segments = [rest(0.1)]

    def add(segment: Segment) -> bool:
        nonlocal left, place
        if segment[0] > left:
            return False
        segments.append(segment)
        left -= segment[0]
        place += segment[2]
        return True

    def sweep(share: float) -> None:
        for goal in (low, high)[:: rng.choice([-1, 1])]:
            if abs(goal - place) > 1e-3:
                add(move(goal - place, share * velocity, acceleration * rng.uniform(0.4, 1.0)))
        if rng.random() < 0.5:
            add(rest(rng.uniform(0.02, 0.15)))

    def hop() -> None:
        goal = rng.uniform(low, high)
        if abs(goal - place) > 1e-3:
            add(move(goal - place, velocity * rng.uniform(0.15, 1.0), acceleration * rng.uniform(0.3, 1.0)))
        if rng.random() < 0.5:
            add(rest(rng.uniform(0.02, 0.2)))

    def swing() -> None:
        frequency = np.exp(rng.uniform(np.log(0.8), np.log(12.0)))
        omega = 2 * np.pi * frequency
        room = min(place - low, high - place)
        reach = min(0.8 * acceleration / omega**2, 0.8 * velocity / omega, 0.8 * room)
        if reach > 2e-4:
            add(sine(reach * rng.uniform(0.4, 1.0), frequency, max(3, int(rng.uniform(0.6, 1.6) * frequency))))

    def creep() -> None:
        for _ in range(int(rng.integers(2, 5))):
            speed = np.exp(rng.uniform(np.log(1e-3), np.log(8e-3)))
            step = speed * rng.uniform(0.15, 0.5) * rng.choice([-1, 1])
            if low < place + step < high:
                add(move(step, speed, 0.1 * acceleration))

    if poor:
        share = rng.uniform(0.4, 0.9)
        reach = rng.uniform(0.3, 0.7) * (high - low)
        place = start = float(rng.uniform(low, high - reach))
        side = 1
        while add(move(side * reach, share * velocity, 0.7 * acceleration)):
            side = -side
            add(rest(0.1))
        return play(start, segments, time)
    kinds = [lambda s=s: sweep(s) for s in (0.2, 0.45, 1.0)] + [creep, creep, swing, swing, swing, hop, hop]
    while left > 0.3:
        before = left
        for index in rng.permutation(len(kinds)):
            kinds[index]()
        if before - left < 0.2:
            break
    return play(start, segments, time)
