"""Random motions within a machine's limits, and their simulated runs as diagnose sees them."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from itertools import islice, product
from typing import Any

import numpy as np
from scipy.signal import lfilter

from cogging._core import DivergedError, PointToPoint, PointToPointParameters, Sampled, closed_loop
from cogging.arrays import FloatArray
from cogging.design.motion_limits import MotionLimits, taken_of
from cogging.diagnosis.balance.differenced_balance import DifferencedBalance
from cogging.diagnosis.balance.evidence import Evidence, deviation, noise_filter
from cogging.effects.effect import Effect, Knots, Place, SplineKnots, Travel, Wave, kind_of
from cogging.estimation.residuals import quiet
from cogging.logs.log import Log
from cogging.model.controller import AnyController
from cogging.model.model import Model
from cogging.resources import LOG_COLUMNS, require_table

SHARE = 0.9  # of each limit, used by a reference; the machine exceeds it a little
MARGIN = 0.02  # of the travel, kept from each end
REST = 0.03  # s, after a move
NEAR = 0.35  # standard deviation of the logarithm of a number drawn near its old value
SAME = 0.1  # of the rms motion: references that differ by less are the same


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
    """A motion built move by move, from the middle of the travel.

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
        """The motion, at rest until the end of its time."""
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
        fits |= done % speeds > 0  # after a slow stroke without room a fast one may fit
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
    """Short moves at the limits, back and forth about several positions."""
    length, places, done = p["step"] * (track.high - track.low), (0.5, 0.2, 0.8, 0.35, 0.65, 0.05, 0.95), 0
    while track.move(track.at(places[done % len(places)]), 0.5):
        for sign in (1.0, -1.0, -1.0, 1.0) * 3:
            track.move(track.place + sign * length)
            track.rest(p["rest"])
        done += 1


def random_moves(track: Track, p: Mapping[str, float]) -> None:
    """Moves between random positions at random speeds and accelerations, which decorrelate time and position."""
    random, fits = np.random.default_rng(round(p["seed"])), True
    while fits:
        speed, acceleration = p["slowest"] ** random.random(), random.uniform(0.3, 1.0)
        goal = track.at(random.random())
        fits = track.move(goal, speed, acceleration) or track.move(goal)
        track.rest(REST)


Ends = tuple[float, float]
#: The kinds, each with its numbers and the ends of their log-uniform distribution.
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
#: Strokes over the whole travel at three speeds: the survey of a machine.
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


RATE = 2000.0  # Hz, largest rate of a reference's samples, with cubics between them
SCALES = (1.0, 0.7, 0.5, 0.35, 0.2)  # of speed and acceleration, tried until the limits hold
NOISES = 8  # copies of the survey that give the noise
SHAPES = 12  # shapes of an effect that are tried at most
COUNT = 6  # amplitudes along the travel, of an effect with a list of them
CHANGES = {"mass_change": "mass", "viscous_change": "viscous", "coulomb_change": "coulomb"}  # fields of the axis


@dataclass(frozen=True)
class Run:
    """A simulated motion, and the largest of each quantity over its limit, by the limit's name."""

    elements: tuple[Element, ...]
    motion: Sampled
    log: Log
    taken: dict[str, float]


@dataclass(frozen=True)
class Machine:
    """What runs a motion.

    Attributes:
        controller: controller; None: the model's.
        limits: with travel and jerk (MotionLimits.of).
        seed: of the noise.
        corner: of the balance, Hz (DifferencedBalance.corner).
        taps: filter that makes the noise of the balance white.
    """

    controller: AnyController | None
    limits: MotionLimits
    seed: int
    corner: float = 0.0
    taps: FloatArray | None = None

    def listening(self, model: Model, survey: Run) -> Machine:
        """The machine with the noise of its balance, estimated from copies of the survey."""
        logs = [survey.log, *(replace(self, seed=self.seed + n).log(model, survey.motion) for n in range(1, NOISES))]
        width, resolution = model.axis.coulomb_width, model.encoder.resolution
        balances = [DifferencedBalance(log, width, resolution) for log in logs if log is not None]
        balances[0].set_corner(balances[0].residual(model), model.axis.mass)
        for balance in balances[1:]:
            balance.corner = balances[0].corner
        left = np.concatenate([balance.rows(balance.residual(model))[0] for balance in balances])
        mask = np.concatenate([balance.mask for balance in balances])
        taps = noise_filter(left, mask, balances[0].rate)
        taps = np.asarray(taps / deviation(lfilter(taps, 1.0, left)[mask]))
        return replace(self, corner=float(balances[0].corner), taps=taps)

    def log(self, model: Model, motion: Sampled) -> Log | None:
        """The log of a model on a motion; None where the loop diverges or leaves the travel."""
        controller = model.make_controller() if self.controller is None else self.controller
        plant, steps = model.plant(), model.steps_per_sample
        try:
            return Log.of(
                closed_loop(plant, controller, motion, duration=motion.end, seed=self.seed, steps_per_sample=steps)
            )
        except (DivergedError, ValueError):
            return None

    def run(self, model: Model, elements: Sequence[Element]) -> Run | None:
        """Run the elements at the largest scale that keeps the limits; None if there is none, or nothing moves."""
        runs = (self.at_scale(model, elements, scale) for scale in SCALES)
        return next((run for run in runs if run is not None and max(run.taken.values()) <= 1.0), None)

    def at_scale(self, model: Model, elements: Sequence[Element], scale: float) -> Run | None:
        """Run the elements slowed by a scale, whatever limits it breaks; None if nothing moves or the loop diverges."""
        controller = model.make_controller() if self.controller is None else self.controller
        slower = tuple(replace(element, scale=scale * element.scale) for element in elements)
        motion = planned(slower, self.limits, min(controller.sample_rate, RATE))
        log = self.log(model, motion) if np.ptp(motion.samples["reference"]) > 0.0 else None
        return None if log is None else Run(slower, motion, log, taken_of(motion, log, self.limits))


@dataclass(frozen=True)
class Shape:
    """An effect, or the name of a change of the axis, at one shape: a part for each amplitude, made with its unit."""

    parts: tuple[Effect | str, ...]
    units: FloatArray


class Look:
    """A run of `model` in the force balance, with its parameters but those of the effects of `given` re-tuned."""

    def __init__(self, machine: Machine, run: Run, given: Model, model: Model) -> None:
        self.machine, self.run, self.model = machine, run, model
        self.balance = DifferencedBalance(run.log, model.axis.coulomb_width, model.encoder.resolution)
        self.balance.corner = machine.corner
        self.evidence = Evidence([self.balance], given, model).prepare()
        assert machine.taps is not None
        self.evidence.screen = self.evidence.fitted([machine.taps])

    def columns(self, shapes: Sequence[Shape]) -> list[FloatArray]:
        """Whitened columns of each shape, orthogonal to the re-tuned parameters, for amplitudes of 1, (k, m)."""
        table = np.array([self.force(part) for shape in shapes for part in shape.parts])
        found = self.evidence.project([self.balance.rows(table)])[0]
        found = found / np.concatenate([shape.units for shape in shapes])[:, None]
        return np.split(found, np.cumsum([len(shape.parts) for shape in shapes])[:-1])

    def force(self, part: Effect | str) -> FloatArray:
        """Contribution of an effect to the balance, or of a doubled parameter of the axis, V, (n,)."""
        balance, model = self.balance, self.model
        if part == "mass_change":
            return np.asarray(-model.axis.mass * self.evidence.accelerations[0])
        if isinstance(part, str):
            twice = {CHANGES[part]: 2.0 * getattr(model.axis, CHANGES[part])}
            return np.asarray(
                balance.residual(model) - balance.residual(model.replace(axis=model.axis.replace(**twice)))
            )
        more = model.replace(effects=(*model.effects, part))
        if "state" in part.HOOKS:  # no column of the balance: the loop is run with and without it
            return self._missing(more) - self._quiet
        if "reading" in part.HOOKS:
            return np.asarray(balance.residual(model) - balance.residual(more))
        return np.asarray(balance.added(model, [part], self.evidence.drives[0])[0])

    @cached_property
    def _quiet(self) -> FloatArray:
        return self._missing(self.model)

    def _missing(self, truth: Model) -> FloatArray:
        """Residual of the model along a noise-free run of the truth, V, (n,)."""
        log = self.machine.log(quiet(truth), self.run.motion)
        if log is None:
            return np.zeros(len(self.balance.time))
        width, resolution = self.model.axis.coulomb_width, self.model.encoder.resolution
        return np.asarray(DifferencedBalance(log, width, resolution).residual(self.model))


def shapes(law: Effect | str, model: Model, limits: MotionLimits, near: Effect | None = None) -> list[Shape]:
    """Typical shapes of an effect for a machine, first those of another effect with the same fields (`near`)."""
    if isinstance(law, str):
        return [Shape((law,), np.ones(1))]
    low, high = limits.travel or (0.0, 0.0)
    length, speed, axis = high - low, limits.velocity, model.axis
    force = axis.mass * limits.acceleration + axis.viscous * speed + axis.coulomb
    rate = 1000.0 if model.controller is None else float(model.controller.sample_rate)
    sizes = {
        "position": [low + share * length for share in (0.2, 0.5, 0.8)],
        "distance": [share * length for share in (0.02, 0.05, 0.12, 0.3)],
        "velocity": [share * speed for share in (0.01, 0.05, 0.2)],
        "exponent": [1.0, 2.0],
        "time": [share * limits.duration for share in (0.1, 0.4, 1.0)],
        "sample_time": [0.5 / rate],
        "command": [0.7 * force, 0.9 * force],
        "stiffness": [max(axis.coulomb, 0.1 * force) / (share * length) for share in (1e-4, 1e-3)],
        "frequency": [min(hertz, 0.1 * rate) for hertz in (1.0, 7.0, 40.0, 100.0)],
        "relative": [0.1],
        "one": [0.05],
        "angle": [0.0, 0.5 * np.pi],
    }
    vanishing = {"distance": [1e-4 * length], "command": [0.02 * force]}  # of what is nothing at size 0
    small = 1e-2 * force
    units = {"force_per_position": small / length, "force_per_velocity": small / speed, "relative": 1e-3}
    units |= {"force_per_velocity_squared": small / speed**2, "distance": 1e-5 * length}
    ends, knots, spline = kind_of(law, Travel), kind_of(law, Knots), kind_of(law, SplineKnots)
    if knots is not None and law.ROLES[knots.nodes]["role"] == "setting":
        return []  # user-defined nodes are not searched
    fixed: dict[str, Any] = {} if ends is None else {ends.ends: [low, high]}
    if knots is not None:
        fixed |= {knots.nodes: list(np.linspace(low, high, COUNT))}
    if spline is not None:
        fixed |= {spline.pitch: length / (COUNT - 2), spline.order: 3, spline.origin: low}
    values: dict[str, list[float]] = {}
    for name, role in law.ROLES.items():
        if role["role"] != "shape" or name in fixed:
            continue
        quantity = role["quantity"]
        values[name] = (vanishing if role["neutral"] == 0.0 else sizes).get(quantity, sizes.get(quantity, [0.0]))
        other: Mapping[str, Any] = {} if near is None else near.ROLES.get(name, {})
        if (other.get("role"), other.get("quantity")) == ("shape", quantity):
            value = float(getattr(near, name))
            around = [0.7 * value, 1.4 * value] if role["logarithmic"] else []
            if kind_of(law, Wave) is not None and quantity == "distance":  # a part of a turn more or less
                around = [value / (1.0 + part * value / length) for part in (-0.3, 0.3)]
            values[name] = [value, *around, *values[name]]
    turned = next((n for n in values if law.ROLES[n]["quantity"] == "angle"), None)
    placed = next((n for n in values if law.ROLES[n]["quantity"] == "position" and kind_of(law, Place) is None), None)
    joint: list[dict[str, float]] = [{}]  # shapes that are one of two amplitudes: angles, or centres of no place
    if one := turned or placed:
        joint = [{one: value} for value in (sizes["angle"] if turned else (low, high))]
        del values[one]
    many = knots is not None or spline is not None
    amplitudes = {n: units.get(r["quantity"], small) for n, r in law.ROLES.items() if r["role"] == "amplitude"}
    nothing = {n: [0.0] * COUNT if many else 0.0 for n in amplitudes}
    found = []
    for shape in islice(product(*values.values()), SHAPES):
        parts: list[Effect | str] = []
        try:
            base = law.replace(**fixed, **nothing, **dict(zip(values, shape, strict=True)))
            for more, (name, unit), row in product(joint, amplitudes.items(), np.eye(COUNT if many else 1)):
                amplitude = list(map(float, unit * row)) if many else unit
                parts.append(base.replace(**{**more, **nothing, name: amplitude}))
        except ValueError:  # a window that ends before it begins
            continue
        sizes_of = np.repeat([u for _ in joint for u in amplitudes.values()], COUNT if many else 1)
        found.append(Shape(tuple(parts), sizes_of) if parts else Shape((base,), np.ones(1)))
    return found
