"""The search for a motion: a dictionary, the best of its combinations, and the parameters of these moved."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, replace
from typing import Any, Protocol

import numpy as np

from cogging._core import Sampled
from cogging.arrays import FloatArray
from cogging.diagnosis.experiment.expectation import Expectation
from cogging.diagnosis.experiment.feasibility import Run, run_on
from cogging.diagnosis.experiment.limits import MotionLimits
from cogging.diagnosis.experiment.motion import Element, dictionary, planned
from cogging.diagnosis.thresholds import MOTION, PROPOSAL
from cogging.logs.log import Log
from cogging.model.controller import AnyController
from cogging.model.model import Model
from cogging.threads import on_threads

#: Parameters that a refinement moves, and between which values.
MOVED = {
    "speed": PROPOSAL.speed_range,
    "reach": PROPOSAL.reach_range,
    "step": PROPOSAL.step_range,
    "acceleration": PROPOSAL.acceleration_range,
    "low": PROPOSAL.low_range,
    "high": PROPOSAL.high_range,
    "slowest": PROPOSAL.slowest_range,
}


class Question(Protocol):
    """What a motion is to answer: information of parts adds up, and is worth something."""

    @property
    def truth(self) -> Model:
        """What is simulated."""

    @property
    def loudness(self) -> float:
        """Power of the noise over that of the model's."""

    def looking(self, log: Log) -> Any:
        """The same, made ready by a survey of the travel."""

    def gram(self, log: Log) -> FloatArray | None:
        """Information of a log."""

    def utility(self, gram: FloatArray) -> float:
        """What a motion of such information is worth."""

    def worth(self, log: Log, gram: FloatArray) -> float:
        """What a whole motion with this log and its information is worth."""

    def expectations(self, log: Log) -> list[Expectation]:
        """What a log would tell."""


@dataclass(frozen=True)
class Machine:
    """What runs a motion.

    Attributes:
        model: model with all that is thought to be there.
        controller: controller; None: the model's.
        limits: with travel and jerk (MotionLimits.of).
        seed: of the noise.
    """

    model: Model
    controller: AnyController | None
    limits: MotionLimits
    seed: int

    @property
    def rate(self) -> float:
        """Of a reference's samples, Hz."""
        controller = self.model.make_controller() if self.controller is None else self.controller
        return min(controller.sample_rate, MOTION.reference_rate)

    def run(self, elements: tuple[Element, ...], seconds: float, scale: float = 1.0) -> tuple[Sampled, Run | None]:
        """The motion of some elements, and its run; None where the axis does not move or the loop diverges."""
        motion = planned(elements, replace(self.limits, duration=seconds), self.rate, scale)
        if float(np.ptp(motion.samples["reference"])) == 0.0:
            return motion, None
        return motion, run_on(self.model, self.controller, motion, self.limits, self.seed)

    def feasible(self, elements: tuple[Element, ...], seconds: float) -> tuple[float, Sampled, Run] | None:
        """The largest scale at which the machine keeps to its limits, with motion and run; None where there is none."""
        for scale in PROPOSAL.slower:
            motion, run = self.run(elements, seconds, scale)
            if run is not None and run.worst <= 1.0:
                return scale, motion, run
        return None


@dataclass(frozen=True)
class Proposal:
    """A motion, and what it is worth.

    Attributes:
        elements: what is run one after another.
        motion: the reference.
        run: simulated on the machine.
        worth: sum of the utilities.
    """

    elements: tuple[Element, ...]
    motion: Sampled
    run: Run
    worth: float


@dataclass(frozen=True)
class Part:
    """One element of the dictionary on the machine, with its information on each question."""

    element: Element
    grams: tuple[FloatArray, ...]


def survey(machine: Machine) -> Run | None:
    """A run over the whole travel at several speeds: what shapes of effects there are to look for."""
    element = Element("strokes", {"reach": 1.0, "speed": 1.0, "speeds": 3.0, "ratio": 0.4})
    found = machine.feasible((element,), machine.limits.duration)
    return None if found is None else found[2]


def propose(machine: Machine, questions: Sequence[Question], begin: Callable[[str], None]) -> Proposal | None:
    """The best motion for the questions; None where no motion keeps to the limits.

    Every element of the dictionary is run for a share of the time; information adds up, so that the best combination
    is found by exchanging one element at a time (Fedorov 1972). The best few are simulated as a whole, and the numbers
    of the best are moved (Nelder and Mead 1965).
    """
    count = max(1, min(PROPOSAL.parts, int(machine.limits.duration / PROPOSAL.part_min)))
    parts = list(_parts(machine, questions, machine.limits.duration / count, begin))
    best: Proposal | None = None
    for number, elements in enumerate(_unlike(_combinations(parts, questions, count)), start=1):
        begin(f"whole motion {number} of {PROPOSAL.whole_motions}")
        best = _better(best, _whole(machine, questions, elements))
    return None if best is None else _refined(machine, questions, best, begin)


def _parts(
    machine: Machine, questions: Sequence[Question], seconds: float, begin: Callable[[str], None]
) -> Iterator[Part]:
    """The elements of the dictionary that the machine can run, with their information."""
    elements = list(dictionary())

    def look(element: Element) -> Part | None:
        found = machine.feasible((element,), seconds)
        if found is None:
            return None
        grams = [question.gram(found[2].log) for question in questions]
        if any(gram is None for gram in grams):
            return None
        slower = replace(element, scale=found[0])
        return Part(slower, tuple(gram for gram in grams if gram is not None))

    for first in range(0, len(elements), 4):
        begin(f"motion {first + 1} of {len(elements)} of the dictionary")
        yield from (part for part in on_threads(look, elements[first : first + 4]) if part is not None)


def _combinations(parts: Sequence[Part], questions: Sequence[Question], count: int) -> list[tuple[Element, ...]]:
    """Combinations of so many elements, the best first: from each of the best single ones by exchange."""
    if not parts:
        return []

    def worth(chosen: Sequence[int]) -> float:
        total = 0.0
        for place, question in enumerate(questions):
            total += question.utility(np.sum([parts[i].grams[place] for i in chosen], axis=0))
        return total

    known: dict[tuple[int, ...], float] = {}

    def valued(chosen: Sequence[int]) -> float:
        key = tuple(sorted(chosen))
        if key not in known:
            known[key] = worth(key)
        return known[key]

    alone = sorted(range(len(parts)), key=lambda i: -valued([i] * count))
    for start in alone[: PROPOSAL.whole_motions]:
        chosen = [start] * count
        for _ in range(PROPOSAL.exchange_passes):
            before = valued(chosen)
            for slot in range(count):
                trials = [[*chosen[:slot], i, *chosen[slot + 1 :]] for i in range(len(parts))]
                chosen = max(trials, key=valued)
            if valued(chosen) <= before:
                break
    full = [key for key in known if len(key) == count]
    ranked = sorted(full, key=lambda key: -known[key])
    return [tuple(parts[i].element for i in key) for key in ranked]


def _unlike(ranked: Sequence[tuple[Element, ...]]) -> list[tuple[Element, ...]]:
    """The best few of ranked combinations of which no two share all but one element."""
    chosen: list[tuple[Element, ...]] = []
    for elements in ranked:
        if all(sum(one not in other for one in elements) > min(1, len(elements) - 1) for other in chosen):
            chosen.append(elements)
        if len(chosen) == PROPOSAL.whole_motions:
            break
    return chosen


def _whole(machine: Machine, questions: Sequence[Question], elements: tuple[Element, ...]) -> Proposal | None:
    """A combination simulated as a whole; None where the machine exceeds its limits at any scale."""
    found = machine.feasible(elements, machine.limits.duration)
    if found is None:
        return None
    scale, motion, run = found
    grams = [question.gram(run.log) for question in questions]
    if any(gram is None for gram in grams):
        return None
    worth = sum(q.worth(run.log, gram) for q, gram in zip(questions, grams, strict=True) if gram is not None)
    slower = tuple(replace(element, scale=scale * element.scale) for element in elements)
    return Proposal(slower, motion, run, worth)


def _better(one: Proposal | None, other: Proposal | None) -> Proposal | None:
    if one is None or other is None:
        return one or other
    return other if other.worth > one.worth else one


def _refined(machine: Machine, questions: Sequence[Question], best: Proposal, begin: Callable[[str], None]) -> Proposal:
    """The proposal with the numbers of its elements moved while that makes it better."""
    from scipy.optimize import minimize

    places = [(i, name) for i, element in enumerate(best.elements) for name in element.parameters if name in MOVED]
    if not places:
        return best
    start = np.log([best.elements[i].parameters[name] for i, name in places])
    tried = 0

    def cost(logarithms: FloatArray) -> float:
        nonlocal best, tried
        tried += 1
        begin(f"refinement {tried} of {PROPOSAL.refinements}")
        trial = _whole(machine, questions, _moved(best.elements, places, logarithms))
        if trial is None:
            return 1e6
        best = _better(best, trial) or best
        return -trial.worth

    # One direction a parameter would take a simplex that alone is all that there is time for.
    directions = _directions(len(places), min(len(places), PROPOSAL.refinements // 3))
    minimize(
        lambda weights: cost(start + weights @ directions),
        np.zeros(len(directions)),
        method="Nelder-Mead",
        options={
            "maxfev": PROPOSAL.refinements,
            "initial_simplex": np.vstack(
                [np.zeros(len(directions)), PROPOSAL.refinement_step * np.eye(len(directions))]
            ),
        },
    )
    return best


def _directions(size: int, count: int) -> FloatArray:
    """Orthonormal directions in which several parameters move together, the same on every call, (count, size)."""
    random = np.random.default_rng(size)
    return np.asarray(np.linalg.qr(random.normal(size=(size, count)))[0].T * np.sqrt(size / count))


def _moved(
    elements: tuple[Element, ...], places: Sequence[tuple[int, str]], logarithms: FloatArray
) -> tuple[Element, ...]:
    """Elements with other numbers, each inside its range."""
    changed: list[dict[str, float]] = [dict(element.parameters) for element in elements]
    for (i, name), logarithm in zip(places, logarithms, strict=True):
        low, high = MOVED[name]
        changed[i][name] = float(np.clip(np.exp(logarithm), low, high))
    for numbers in changed:
        if "low" in numbers and "high" in numbers:
            numbers["high"] = max(numbers["high"], 1.2 * numbers["low"])
    return tuple(replace(element, parameters=numbers) for element, numbers in zip(elements, changed, strict=True))
