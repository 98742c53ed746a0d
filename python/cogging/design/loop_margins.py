"""Machines drawn for tuning, and how much delay and gain their loop tolerates."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from typing import Any, NamedTuple

import numpy as np

from cogging._core import Reference, effects
from cogging.arrays import FloatArray, Mask
from cogging.design.error_prediction import DRAWS_MAX
from cogging.effects.effect import Effect
from cogging.files import FieldError
from cogging.model.controller import AnyController
from cogging.model.intervals import Intervals
from cogging.resources import require_machines
from cogging.simulation.reductions import kept_of_runs
from cogging.simulation.varied import BOUNDS, SEED, Setup, Variation, refuse_unknown_paths, variation_of, with_numbers


class Machine(NamedTuple):
    """A machine with its motion, and the seed of its noise."""

    setup: Setup
    seed: int


def variations_of(setup: Setup, vary: Mapping[str, Any] | str) -> tuple[list[Variation], list[str]]:
    """The variations between machines, and remarks; FieldError or ValueError where a number cannot be varied here."""
    notes = []
    if vary == BOUNDS:
        intervals = Intervals(setup.model)
        vary = {}
        for path in intervals.paths:
            try:
                interval = intervals.of(path)
            except ValueError as error:
                notes.append(f"held: {error}")
                continue
            if interval is not None and interval[0] < interval[1]:
                vary[path] = BOUNDS
        if not vary:
            notes.append("the model has neither [bounds] nor [axis.uncertainty]: the machines differ in noise alone")
    if not isinstance(vary, Mapping):
        raise FieldError("", "vary", f'must be a table of numbers by path, or "bounds", got {vary!r}')
    refuse_unknown_paths(setup, vary)
    for path in vary:
        if path == SEED or path.startswith("controller."):
            rule = "each machine has noise of its own" if path == SEED else "the controller is one for all machines"
            raise FieldError("vary", path, f"must be a number of machine or motion: {rule}")
    return [variation_of(path, how, setup.model) for path, how in vary.items()], notes


def machines_of(setup: Setup, variations: list[Variation], count: int, seed: int, stream: int) -> list[Machine]:
    """Draw machines on a Latin hypercube; values that break a rule are drawn again. Deterministic.

    Machines of different `stream`s of a seed are independent. ValueError: there is hardly a valid machine.
    """
    from scipy.stats import qmc

    require_machines("machines", count, len(variations))
    numbers = np.random.default_rng([seed, stream])
    seeds = numbers.integers(2**63, size=count)
    if not variations:
        return [Machine(setup, int(own)) for own in seeds]
    drawn = qmc.LatinHypercube(len(variations), seed=numbers).random(count)
    machines = []
    for shares, own in zip(drawn, seeds, strict=True):
        for _ in range(DRAWS_MAX):
            values = {one.path: float(one.of_shares(shares[[i]])[0]) for i, one in enumerate(variations)}
            try:
                made = with_numbers(setup, values)
                made.model.plant()
                break
            except ValueError as error:
                reason, shares = error, numbers.random(len(variations))
        else:
            raise ValueError(f"vary: {DRAWS_MAX} draws gave no valid machine; the last: {reason}")
        machines.append(Machine(made, int(own)))
    return machines


GROWN = 5.0  # times the largest response of the unchanged loop: a larger response has grown
FORGOTTEN = 0.3  # of the largest response in the first half of the motion after a push: allowed in the second
COUNTS = 10.0  # of the encoder: smaller responses are rounding
PUSH_SHARE = 0.2  # of the largest command
PUSH_SAMPLES = 50
MOVING = 0.05  # of the largest reference speed: above it friction does not hold the response
HALVINGS = 5  # of the step in which the loop fails: a margin is accurate to 3 %
GAIN_MOST = 1024.0
DELAY_SHARE = 0.25  # of the run: the longest delay tried
ROWS = 4000  # kept of a run
FAR = 1e9  # m: a period much longer than any travel


class Push(NamedTuple):
    """A force pulse on the machine while it moves."""

    force: float  # V
    start: float  # start, stop: s
    stop: float
    duration: float  # of the run, s; 0 = the motion's own end
    every: int  # rows per kept row
    moving: Mask  # kept rows in which the reference moves


def push_of(motion: Reference, sample_rate: float, duration: float, command_max: float) -> Push:
    """A fifth of the largest command for 50 samples, from half the largest speed; duration 0 = the motion's own end."""
    end = duration or motion.end
    rows = max(2, int(end * sample_rate))
    every = max(1, rows // ROWS)
    time = np.arange(0, rows, every) / sample_rate
    speed = np.abs(motion.sample(time)[1])
    start = float(time[np.argmax(speed >= 0.5 * speed.max())])
    stop = start + min(PUSH_SAMPLES / sample_rate, 0.05 * end)
    return Push(PUSH_SHARE * command_max, start, stop, duration, every, speed >= MOVING * speed.max())


class Loops:
    """Machines under one controller, pushed with more delay and gain than they have.

    The trace of a push is the difference of the true position (of the velocity if no unchanged loop holds, as for a
    speed loop) between two runs with and without it. The loop holds on a machine if both runs complete, the trace is at
    most GROWN times the largest of the unchanged loop, and its rms in the second half of the moving rows after the push
    is at most FORGOTTEN of its largest in the first half, and of that in the unchanged loop.
    """

    def __init__(self, machines: Sequence[Machine], controller: AnyController, push: Push, *, threads: int = 0) -> None:
        self._machines, self._controller, self._push, self._threads = machines, controller, push, threads
        self._behind = int(push.start * controller.sample_rate / push.every)
        counts = np.array([COUNTS * machine.setup.model.encoder.resolution for machine in machines])
        for quantity, rounding in (("true_position", counts), ("true_velocity", counts / (push.stop - push.start))):
            self._quantity, self._rounding = quantity, rounding
            as_it_is = self._traces(0.0, 1.0)
            largest = [np.nan if one is None else np.abs(one[self._behind :]).max(initial=0.0) for one in as_it_is]
            self._size: FloatArray = np.maximum(np.array(largest), rounding)
            self._holds_as_it_is = bool(self._held(as_it_is).all())
            if self._holds_as_it_is or any(one is None for one in as_it_is):
                break

    def share_lost(self, delay: float = 0.0, gain: float = 1.0) -> float:
        """The share of the machines on which the loop does not hold with more delay (s), or gain of the command."""
        return float(1.0 - self._held(self._traces(delay, gain)).mean())

    def delay_margin(self) -> float:
        """The largest delay (s) with which the loop holds on every machine, to 3 %, below it at every one tried."""
        sample_time = 1.0 / self._controller.sample_rate
        end = self._push.duration or min(machine.setup.reference.end for machine in self._machines)
        return self._largest(lambda delay: self.share_lost(delay=delay) == 0.0, 0.0, sample_time, DELAY_SHARE * end)

    def gain_margin(self) -> float:
        """The largest factor on the command with which the loop holds on every machine, likewise; 0 for none."""
        return self._largest(lambda gain: self.share_lost(gain=gain) == 0.0, 1.0, 2.0, GAIN_MOST)

    def _largest(self, holds: Callable[[float], bool], held: float, tried: float, most: float) -> float:
        """Doubled until the loop is lost, then halved in."""
        if not self._holds_as_it_is:
            return 0.0
        while holds(tried):
            held, tried = tried, 2.0 * tried
            if tried > most:
                return held
        for _ in range(HALVINGS):
            middle = 0.5 * (held + tried)
            held, tried = (middle, tried) if holds(middle) else (held, middle)
        return held

    def _traces(self, delay: float, gain: float) -> list[FloatArray | None]:
        """The trace of the push on each machine, m or m/s; None where a run did not come to its end."""
        more: list[Effect] = [effects.CommandDelay(delay=delay)] * (delay > 0.0)
        more += [effects.ForceConstantRipple(period=FAR, cosine=gain - 1.0)] * (gain != 1.0)
        push = self._push
        pushed = effects.DisturbanceStep(force=push.force, start=push.start, stop=push.stop)
        models = [machine.setup.model for machine in self._machines]
        changed = [(model, (*model.effects, *more, *added)) for model in models for added in ((), (pushed,))]
        plants = [model.replace(effects=listed).plant() for model, listed in changed]
        kept = kept_of_runs(
            plants,
            [self._controller] * len(plants),
            [machine.setup.reference for machine in self._machines for _ in range(2)],
            durations=[push.duration],
            seeds=[machine.seed for machine in self._machines for _ in range(2)],
            steps_per_sample=[models[0].steps_per_sample],
            threads=self._threads,
            columns=[self._quantity],
            every=push.every,
            keeps_refused=True,
        )
        failed = {failure.run // 2 for failure in kept.failures}
        columns = kept.columns[self._quantity]
        pairs = zip(columns[::2], columns[1::2], strict=True)
        return [None if place in failed else hit - free for place, (free, hit) in enumerate(pairs)]

    def _held(self, traces: Sequence[FloatArray | None]) -> FloatArray:
        held = np.zeros(len(traces))
        for place, (trace, size) in enumerate(zip(traces, self._size, strict=True)):
            if trace is None or not math.isfinite(size) or np.abs(trace).max(initial=0.0) > GROWN * size:
                continue
            rows = np.flatnonzero(self._push.moving[: len(trace)])
            rows = rows[rows > self._behind]
            middle = rows[len(rows) // 2] if len(rows) else len(trace)
            early, late = np.abs(trace[self._behind : middle]).max(initial=0.0), trace[rows[len(rows) // 2 :]]
            left = float(np.sqrt(np.mean(late**2))) if late.size else 0.0
            held[place] = left <= FORGOTTEN * max(min(early, size), self._rounding[place])
        return held
