"""Plan the next experiment: a motion that separates rivals, lowers detection limits or narrows a fit."""

from __future__ import annotations

import json
import os
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from cogging._core import Sampled
from cogging.arrays import FloatArray
from cogging.calls import PATH, Kind, check_arguments
from cogging.design.experiment_motion import (
    CHANGES,
    SCALES,
    SURVEY,
    Element,
    Look,
    Machine,
    Run,
    Shape,
    drawn,
    is_known,
    shapes,
)
from cogging.design.motion_limits import MotionLimits
from cogging.design.pid import ASSUMED, assumed_pid
from cogging.diagnosis.balance.decision import BLOCK, THRESHOLD, score_of
from cogging.diagnosis.balance.evidence import orthonormal
from cogging.diagnosis.diagnosis_result import Diagnosis
from cogging.effects.custom import Custom, by_name, refuse_two_of_one_name
from cogging.effects.effect import VOCABULARY, Effect, Travel, Turn, kind_of
from cogging.files import FieldError, InputError, read_text
from cogging.logs.log import Log
from cogging.model.controller import AnyController
from cogging.model.model import Model, is_number
from cogging.model.parameters import parameters_of
from cogging.model.units import Units
from cogging.outputs import to_json, to_toml, write_files
from cogging.plot.canvas import plot_method
from cogging.plot.results import whole_plan
from cogging.progress import Progress, steps
from cogging.resources import on_one_blas_thread, on_threads
from cogging.shown import nearest, quoted
from cogging.simulation.arguments import MODEL
from cogging.values import ByValue

COPIES = 1000  # simulated copies of a motion, for the frequency of a correct decision
HOPELESS = 0.6  # frequency of a correct decision below which a motion does not separate rivals
LOUD = 100.0  # noncentrality assumed for an effect of unknown size
TRIALS = 20  # independent shapes of an effect, for the detection threshold
CHANCE = 0.95  # detection probability at a detection limit
FAR = 4.0  # largest change of the logarithm of a detection limit that counts
BEYOND = 100.0  # times a hundredth of the machine's force: larger limits count as not detectable
HALF = 1.96  # standard deviations in half of a 95 % interval


@dataclass(frozen=True)
class Expectation:
    """What a planned motion is expected to show of one effect or parameter.

    Attributes:
        name: of the effect; for a fit, the path of the parameter.
        alternative: name of the rival; empty if there is none.
        parameter: field with a detection limit; empty if there is none.
        unit: of the numbers.
        expected: for rivals, the frequency of a correct decision in simulated copies of the motion; the smallest size
            detected with probability 95 %; or half of a 95 % interval. None: not identifiable from the motion.
        today: the same before the motion; None: unknown.
    """

    name: str
    alternative: str
    parameter: str
    unit: str
    expected: float | None
    today: float | None = None

    def text(self) -> str:
        """One line."""
        unit = f" {self.unit}" if self.unit != "1" else ""
        today = "" if self.today is None else f"; today {self.today:.2g}{unit}"
        if self.alternative:
            often = f"the right one is the likelier in {100 * (self.expected or 0.0):.0f} % of simulated runs"
            none = ": no tried motion separates them" if (self.expected or 0.0) < HOPELESS else ""
            return f"{self.name} or {self.alternative}: {often}{none}"
        if self.expected is None:
            return f"{self.name}: {'cannot be seen in' if self.parameter else 'not determined by'} this motion{today}"
        if self.parameter:
            return f"{self.name}: {self.parameter} of {self.expected:.3g}{unit} would be detected{today}"
        return f"{self.name}: to +- {self.expected:.3g}{unit}{today}"


class Found(NamedTuple):
    """An effect of a result (None for a change of the axis), the size of a change, and its alternatives."""

    name: str
    effect: Effect | None
    change: float
    alternatives: tuple[str, ...]

    def added_to(self, model: Model) -> Model:
        """The model with it."""
        if self.effect is not None:
            return model.replace(effects=(*model.effects, self.effect))
        field = CHANGES[self.name]
        return model.replace(axis=model.axis.replace(**{field: getattr(model.axis, field) * (1.0 + self.change)}))


class Goal(NamedTuple):
    """The value of a run, and what it is expected to show."""

    worth: Callable[[Run], float]
    expectations: Callable[[Run], list[Expectation]]


def separate(machine: Machine, model: Model, found: Sequence[Found], laws: Mapping[str, Effect], survey: Run) -> Goal:
    """Effects against their alternatives: noncentrality of the one beside the other refitted, either way round.

    lambda = min over shapes and sizes of b, and over what is re-tuned, of |a - b|^2, whitened: 2 ln of the likelihood
    of the right one over the other has the mean lambda (Atkinson and Fedorov 1975). The rival has the shape most
    similar to it on the survey, and the same power there.
    """
    alike: dict[tuple[str, str], tuple[FloatArray, int, FloatArray]] = {}

    def pairs(run: Run) -> Iterator[tuple[str, str, list[FloatArray], list[FloatArray], list[FloatArray], Any]]:
        """Two rivals, their columns at their shapes, those of all other names, and what each rival does (m,)."""
        for one in (one for one in found if one.alternatives):
            given = whole = one.added_to(model)
            for other in found:
                whole = whole if other is one else other.added_to(whole)
            look = Look(machine, run, given, whole)
            size = 1.0 / one.change if one.effect is None and one.change else 1.0
            own = [Shape((one.effect or one.name,), np.full(1, size))]
            own += shapes(laws.get(one.name, one.name), model, machine.limits, one.effect)
            names = {one.name, *one.alternatives}
            rest = [law for law in laws.values() if law.NAME not in names and "state" not in law.HOOKS]
            beside = [shape for law in rest for shape in shapes(law, model, machine.limits, one.effect)[:1]]
            aside = look.columns(beside)
            for name in one.alternatives:
                others = shapes(laws.get(name, name), model, machine.limits, one.effect)
                columns = look.columns([*own, *others])
                first, second = columns[: len(own)], columns[len(own) :]
                if (one.name, name) not in alike:
                    a = first[0][0]
                    scale = np.zeros(0)
                    if not np.any(a):  # of no known size
                        a = first[1].sum(axis=0)
                        scale = np.full(len(first[1]), np.sqrt(LOUD) / max(float(np.linalg.norm(a)), 1e-300))
                        a = scale @ first[1]
                    power, number, amplitudes = explained(second, a)
                    amplitudes *= np.sqrt(float(a @ a) / max(power, 1e-12))
                    alike[one.name, name] = scale, number, amplitudes
                scale, number, amplitudes = alike[one.name, name]
                signals = scale @ first[1] if len(scale) else first[0][0], amplitudes @ second[number]
                yield one.name, name, first, second, aside, signals

    def worth(run: Run) -> float:
        def likeness_of(groups: Sequence[FloatArray], signal: FloatArray) -> float:
            return 1.0 / (1.0 + max(float(signal @ signal) - explained(groups, signal)[0], 0.0))

        likeness = []
        for _, _, first, second, rest, (signal, rival) in pairs(run):
            likeness += [likeness_of(second, signal), likeness_of(first, rival)]
            # names that the old logs have ruled out are not to come back: all together count as one
            likeness.append(float(np.mean([likeness_of([group], signal) for group in rest])))
        return -float(np.log(np.mean(likeness)))  # the weakest counts most, a hopeless one not alone

    def expectations(run: Run) -> list[Expectation]:
        entries = []
        for name, alternative, first, second, _, (signal, rival) in pairs(run):
            right = frequency(first, second, signal, blocks_of(run), machine.seed)
            right += frequency(second, first, rival, blocks_of(run), machine.seed + 1)
            entries.append(Expectation(name, alternative, "", "1", round(0.5 * right, 3)))
        return entries

    list(pairs(survey))
    return Goal(worth, expectations)


def blocks_of(run: Run) -> int:
    """Number of blocks of motion of a run, which penalise amplitudes."""
    return max(2, round(run.motion.end / BLOCK))


def explained(groups: Sequence[FloatArray], signal: FloatArray) -> tuple[float, int, FloatArray]:
    """Power of a signal that the best of groups of columns explains, the group, and its amplitudes."""
    best = (0.0, 0, np.zeros(len(groups[0])))
    for number, columns in enumerate(groups):
        size = np.linalg.norm(columns, axis=1) + 1e-300
        w = np.linalg.lstsq((columns / size[:, None]).T, signal, rcond=1e-6)[0] / size
        best = max(best, (float(signal @ signal - np.sum((signal - w @ columns) ** 2)), number, w), key=lambda t: t[0])
    return best


def frequency(
    own: Sequence[FloatArray], other: Sequence[FloatArray], signal: FloatArray, blocks: int, seed: int
) -> float:
    """Frequency with which the right one of two effects has the larger score in white noise.

    Args:
        own: whitened columns of the right one at its shapes, a group a shape.
        other: those of the rival.
        signal: of the right one.
        blocks: of motion, which penalise amplitudes.
        seed: of the noise.
    """
    seen = [[group for group in side if np.any(group)] for side in (own, other)]
    if not np.any(signal) or not all(seen):
        return 0.5 if not np.any(signal) else float(bool(seen[0]))
    base = orthonormal(np.vstack([*seen[0], *seen[1], signal[None]]))
    copies = base @ signal + np.random.default_rng(seed).normal(size=(COPIES, len(base)))
    scores = []
    for side in seen:
        units = [orthonormal(group @ base.T) for group in side]
        ratios = [(len(unit), np.sum((copies @ unit.T) ** 2, axis=1)) for unit in units]
        scores.append(np.max([[score_of(one, k, 1, blocks) for one in ratio] for k, ratio in ratios], axis=0))
    return float(np.mean(scores[0] > scores[1]))


def detect(machine: Machine, model: Model, laws: Mapping[str, Effect], survey: Run, today: Mapping[str, Any]) -> Goal:
    """Lower the detection limits: the mean of their logarithms. `today`: the limits in a result."""
    wanted = {name: shapes(law, model, machine.limits)[:3] for name, law in laws.items()}
    wanted = {name: groups for name, groups in wanted.items() if groups}

    def limits(run: Run) -> dict[str, tuple[str, float]]:
        look = Look(machine, run, model, model)
        columns = iter(look.columns([shape for groups in wanted.values() for shape in groups]))
        return {
            name: smallest(laws[name], [(shape, next(columns)) for shape in groups], blocks_of(run))
            for name, groups in wanted.items()
        }

    first = limits(survey)

    def worth(run: Run) -> float:
        pairs = [(first[name][1], limit) for name, (_, limit) in limits(run).items()]
        gains = [1.0 if before == limit else before / limit for before, limit in pairs]
        return float(np.mean(np.log(np.clip(gains, np.exp(-FAR), np.exp(FAR)))))

    def expectations(run: Run) -> list[Expectation]:
        entries = []
        for name, (size, limit) in limits(run).items():
            known = today.get(name) or {}
            before = known.get("value") if known.get("parameter") == size else None
            value = float(f"{limit:.4g}") if limit < np.inf else None
            entries.append(Expectation(name, "", size, model.units.of(laws[name].FIELDS[size][0]), value, before))
        return sorted(entries, key=lambda one: (one.expected is not None, one.name))

    return Goal(worth, expectations)


def smallest(law: Effect, seen: Sequence[tuple[Shape, FloatArray]], blocks: int) -> tuple[str, float]:
    """The field of an effect's size, and the median over shapes of the smallest size that is detected.

    Detected: above the engine's threshold with probability 95 %; 2 ln of the likelihood is noncentral chi-square.
    """
    from scipy.optimize import brentq
    from scipy.stats import ncx2

    roles = law.ROLES
    sized = [f for f, r in roles.items() if r["role"] == "amplitude"]
    sized += [f for neutral in (0.0, np.inf) for f, r in roles.items() if r["neutral"] == neutral]
    found = []
    for shape, columns in seen:
        k = len(columns)
        least = brentq(lambda ratio, k=k: score_of(ratio, k, TRIALS, blocks) - THRESHOLD, 1e-3, 1e4)
        needed = brentq(lambda square, k=k, least=least: ncx2.sf(least, k, square) - CHANCE, 1e-3, 1e5)
        factor = float(np.sqrt(needed * k / max(float(np.sum(columns**2)), 1e-12)))
        size = factor
        if roles[sized[0]]["role"] != "amplitude":
            value = float(getattr(shape.parts[0], sized[0]))
            size = value * factor if roles[sized[0]]["neutral"] == 0.0 else value / max(factor, 1.0)
        found.append(size if factor < BEYOND * float(np.max(shape.units)) else np.inf)
    return sized[0], float(np.median(found))


def fit(machine: Machine, given: Model, model: Model, survey: Run) -> Goal:
    """Intervals of a fit: the volume of the ellipsoid of all parameters (D-optimal, Fedorov 1972), with `[bounds]`."""
    known = parameters_of(model, together=True)

    def information(run: Run) -> tuple[list[str], FloatArray]:
        """Parameters, and the information of a run about them with the friction law free."""
        evidence = Look(machine, run, given, model).evidence
        rows = evidence.filtered(evidence.nuisances, evidence.screen.taps) * evidence.basis[0]
        own = np.array([path in known for path in evidence.paths])
        gram = rows @ rows.T + np.diag(np.where(own, 0.0, evidence.prior_sigma**-2.0))
        beside = np.linalg.lstsq(gram[np.ix_(~own, ~own)], gram[np.ix_(~own, own)], rcond=None)[0]
        schur = gram[np.ix_(own, own)] - gram[np.ix_(own, ~own)] @ beside
        return [path for path in evidence.paths if path in known], np.asarray(schur)

    paths, first = information(survey)
    ends = np.array([model.intervals.get(path, (-np.inf, np.inf)) for path in paths]).reshape(-1, 2)
    stated = (0.5 * (ends[:, 1] - ends[:, 0]) / HALF) ** -2.0
    before = np.diag(np.maximum(stated, 1e-6 * np.diag(first)))
    size = np.sqrt(np.diag(first + before))

    def worth(run: Run) -> float:
        seen, gram = information(run)
        return float(np.linalg.slogdet((gram + before) / np.outer(size, size))[1]) if seen == paths else -np.inf

    def expectations(run: Run) -> list[Expectation]:
        scaled = (information(run)[1] + before) / np.outer(size, size)
        variance = np.diag(np.linalg.inv(scaled)) / size**2
        entries = []
        for path, square, one, prior in zip(paths, variance, stated, np.diag(before), strict=True):
            half = float(f"{HALF * np.sqrt(square):.4g}") if one or square < 0.1 / prior else None
            today = float(f"{HALF * one**-0.5:.4g}") if one else None
            entries.append(Expectation(path, "", "", known[path].unit, half, today))
        return entries

    return Goal(worth, expectations)


LIMITS = Kind((MotionLimits, *PATH), "a MotionLimits or the path of a limits file")
RESULT = Kind((Diagnosis, Mapping, type(None), *PATH), "a Diagnosis, what its JSON holds, or the path of that JSON")
PURPOSE = {
    "separate": "a motion to tell rivals apart",
    "detect": "a motion to see small effects",
    "fit": "a motion to narrow the intervals of a fit",
}
ROUNDS, FRESH, TOGETHER = 9, 5, 4  # rounds of drawn motions, those independent of the best so far, motions per round
PARTS, PART_MIN = 3, 2.0  # largest number of elements, and shortest duration of each, s
QUIET = 0.01  # of the force of the largest acceleration: assumed noise without a stated one


class NoMotion(ValueError):
    """No motion keeps the limits."""

    def __init__(self, why: str) -> None:
        self.why = why
        super().__init__(f"limits: {why}")


@dataclass(frozen=True, eq=False, repr=False)
class ExperimentPlan(ByValue):
    """A planned experiment. Printed, it is its `text`.

    Attributes:
        goal: separate, detect or fit.
        elements: motions one after another, each a kind with its parameters.
        motion: the reference.
        limits: of the machine, completed from the model.
        taken: largest of each quantity in the simulated loop over its limit, by the limit's name.
        expected: what the motion is expected to show.
        notes: assumptions.
        seed: of the noise and the drawn motions.
        units: labels of the model's units.

    Example:
        >>> limits = cogging.MotionLimits(velocity=0.3, acceleration=5.0, duration=3.0)
        >>> plan = cogging.plan_experiment(model, limits, goal="fit")
        >>> log = cogging.simulate(model, plan.motion)
        >>> bool(abs(log.command).max() > 0.0)
        True
    """

    goal: str
    elements: tuple[Element, ...]
    motion: Sampled
    limits: MotionLimits
    taken: Mapping[str, float]
    expected: tuple[Expectation, ...]
    notes: tuple[str, ...] = ()
    seed: int = 0
    units: Units = field(default_factory=Units)

    def _brief(self) -> str:
        return f"{self.goal}, {self.motion.end:.4g} s: {', '.join(element.kind for element in self.elements)}"

    def text(self) -> str:
        """The plan for the screen."""
        lines = [f"{PURPOSE[self.goal]}, {self.motion.end:.4g} s:"]
        lines += [f"  {number}. {element.text()}" for number, element in enumerate(self.elements, start=1)]
        shares = ", ".join(f"{name} {100 * share:.0f} %" for name, share in self.taken.items())
        lines += [f"shares of the limits used: {shares}", "expected:"]
        lines += [f"  {entry.text()}" for entry in self.expected] or ["  nothing identifiable"]
        return "\n".join([*lines, *(f"note: {note}" for note in self.notes)])

    def to_dict(self) -> dict[str, Any]:
        """The plan without its samples, for JSON."""
        return {
            "goal": self.goal,
            "expected": [vars(entry) for entry in self.expected],
            "elements": [{"kind": one.kind, **one.parameters, "scale": one.scale} for one in self.elements],
            "limits": self.limits.to_dict(),
            "taken": dict(self.taken),
            "duration": self.motion.end,
            "seed": self.seed,
            "notes": list(self.notes),
        }

    plot = plot_method(whole_plan, "Draw position, speed and acceleration of the motion over time.", "three axes")

    def write(self, path: str | os.PathLike[str]) -> None:
        """Write the motion as a reference file (TOML), and beside it its samples (.csv) and the plan (.plan.json).

        Args:
            path: path of the reference file, which `simulate` and `read_reference` take.

        Raises:
            InputError: a file cannot be written; none then is.
        """
        write_files({name: [content.encode()] for name, content in self.files(path).items()})

    def files(self, path: str | os.PathLike[str]) -> dict[str, str]:
        """The files of the plan by path: reference, samples and plan."""
        samples, columns = beside(path, ".csv"), self.motion.samples
        names = ("time", "reference", "reference_velocity", "reference_acceleration")
        table = np.column_stack([columns[name] for name in names]).tolist()
        rows = "\n".join([",".join(names), *(",".join(f"{value:.12g}" for value in row) for row in table)])
        reference = {"type": "sampled", "file": Path(samples).name, "duration": self.motion.end}
        plan = to_json(self.to_dict())
        return {os.fspath(path): to_toml(reference), samples: rows + "\n", beside(path, ".plan.json"): plan}


def beside(path: str | os.PathLike[str], ending: str) -> str:
    """The file beside a reference file with another ending: .csv of its samples, .plan.json of its plan."""
    return os.path.splitext(os.fspath(path))[0] + ending


@check_arguments(model=MODEL, limits=LIMITS, result=RESULT)
@on_one_blas_thread(scipy=True)
def plan_experiment(
    model: Model | str | os.PathLike[str],
    limits: MotionLimits | str | os.PathLike[str],
    *,
    result: Diagnosis | Mapping[str, Any] | str | os.PathLike[str] | None = None,
    logs: Sequence[Log] = (),
    goal: str | None = None,
    controller: AnyController | None = None,
    also: Sequence[Custom] = (),
    seed: int = 0,
    progress: Progress = False,
) -> ExperimentPlan:
    """Find the most informative motion within a machine's limits, and what it is expected to show.

    Motions are drawn at random: strokes, creep with reversals, short steps, random moves. Each is simulated in closed
    loop, with noise and encoder, and checked against the limits: travel with room to stop, speed, acceleration, jerk,
    duration and command. Its log is evaluated as by `diagnose`; the best motion is then varied.

    Goals: `separate` maximises the distance of an effect from its alternatives, refitted to the same motion (T-optimal,
    Atkinson and Fedorov 1975); `detect` lowers the detection limits; `fit` narrows the intervals of the model's
    parameters (D-optimal), given its `[bounds]`.

    Args:
        model: model that the result is of, or its file. Without a controller a plain PID tracks the motion: a note
            says so.
        limits: of the machine, or their file.
        result: of `diagnose`, or its JSON file.
        logs: of the result; their motion is not proposed again.
        goal: separate, detect or fit; None: separate where the result has alternatives, else detect.
        controller: to use instead of the model's (see simulate).
        also: user-defined effects in the result.
        seed: of the noise and the drawn motions.
        progress: True shows the current step; a function receives its name.

    Returns:
        The motion and what it is expected to show; `write` it to run it.

    Raises:
        ValueError: an unknown goal, a result without alternatives for `separate`, limits that no motion keeps.
        FieldError: a ValueError: limits or a result that cannot be used with the model.
        InputError: a file that cannot be read.

    Example:
        >>> limits = cogging.MotionLimits(velocity=0.3, acceleration=5.0, duration=3.0)
        >>> plan = cogging.plan_experiment(model, limits, goal="fit")
        >>> plan.motion.end <= 3.0, plan.taken["velocity"] <= 1.0
        (True, True)
    """
    own = by_name(also)
    if not isinstance(model, Model):
        model = Model.read(model, effects=list(own.values()))
    refuse_two_of_one_name([*own.values(), *model.effects])
    limits = (limits if isinstance(limits, MotionLimits) else MotionLimits.read(limits)).of(model)
    if isinstance(result, str | os.PathLike):
        result = read_result(result)
    document = result.to_dict() if isinstance(result, Diagnosis) else result
    laws = [law for law in VOCABULARY.values() if model.units.position == "rad" or kind_of(law, Turn) is None]
    vocabulary = {law.NAME: law for law in (*laws, *(effect.neutral() for effect in own.values()))}
    found = found_in(document, model, vocabulary)
    ambiguous = any(one.alternatives for one in found)
    goal = goal or ("separate" if ambiguous else "detect")
    if goal not in PURPOSE:
        raise ValueError(f"goal: must be one of {', '.join(PURPOSE)}, got {goal!r}{nearest(goal, PURPOSE)}")
    if goal == "separate" and not ambiguous:
        raise ValueError("goal: separate needs a result with alternatives, got none; detect and fit need none")
    notes: list[str] = []
    model = _with_loop_and_noise(model, controller, limits, notes)
    machine = Machine(controller, limits, seed)
    with steps(progress, "experiment") as begin:
        begin("surveying the travel")
        whole = model
        for one in found:
            whole = one.added_to(whole)
        survey = machine.run(whole, (SURVEY,))
        if survey is None:
            slow = next(filter(None, (machine.at_scale(whole, (SURVEY,), scale) for scale in SCALES[::-1])), None)
            over = {} if slow is None else {name: share for name, share in slow.taken.items() if share > 1.0}
            reached = ", ".join(f"{name} at {100.0 * share:.3g} % of its limit" for name, share in over.items())
            why = "no motion of this machine keeps them, not even at a fifth of the speed"
            raise NoMotion(f"{why}: {reached or 'it does not move, or leaves its travel'}")
        machine = machine.listening(whole, survey)
        if goal == "separate":
            plan = separate(machine, model, found, vocabulary, survey)
        elif goal == "detect":
            plan = detect(machine, whole, vocabulary, survey, (document or {}).get("limits") or {})
        else:
            plan = fit(machine, model.replace(effects=()), whole, survey)
        best = _best(machine, whole, plan.worth, logs, begin)
        if best is None:
            raise NoMotion("no drawn motion keeps them, or none lets the axis move for long enough")
        begin("what is to be expected")
        expected = tuple(plan.expectations(best))
    return ExperimentPlan(
        goal, best.elements, best.motion, limits, best.taken, expected, tuple(notes), seed, model.units
    )


def _best(
    machine: Machine, truth: Model, worth: Callable[[Run], float], logs: Sequence[Log], begin: Callable[[str], None]
) -> Run | None:
    """The best of random motions, later drawn near the best so far; None if none keeps the limits."""
    random = np.random.default_rng(machine.seed)
    count = max(1, min(PARTS, int(machine.limits.duration / PART_MIN)))
    best: tuple[float, Run] | None = None

    def tried(elements: tuple[Element, ...]) -> tuple[float, Run] | None:
        run = machine.run(truth, elements)
        if run is None or is_known(run.motion, logs):
            return None
        try:
            value = worth(run)
        except (ValueError, IndexError, np.linalg.LinAlgError):  # too little motion for the balance
            return None
        return (value, run) if np.isfinite(value) else None

    for number in range(ROUNDS):
        begin(f"motions {TOGETHER * number + 1} to {TOGETHER * (number + 1)} of {TOGETHER * ROUNDS}")
        jobs = []
        for _ in range(TOGETHER):
            elements = [drawn(random) for _ in range(count)]
            if number >= FRESH and best is not None:
                one = int(random.integers(count))
                near = best[1].elements[one] if random.random() < 0.7 else None
                elements = list(best[1].elements)
                elements[one] = drawn(random, near)
            jobs.append(tuple(elements))
        if number == 0:
            jobs[0] = (SURVEY,) * count
        for found in on_threads(tried, jobs):
            if found is not None and (best is None or found[0] > best[0]):
                best = found
    return None if best is None else best[1]


def _with_loop_and_noise(
    model: Model, controller: AnyController | None, limits: MotionLimits, notes: list[str]
) -> Model:
    """The model with a controller and noise: its own, or an assumed PID and noise, with a note."""
    if controller is None and model.controller is None:
        model = model.replace(controller=assumed_pid(model.axis))
        notes.append(
            f"the model states no controller: planned with {ASSUMED}; the motion under yours may exceed the limits"
        )
    if model.noise.force == 0.0 and model.encoder.resolution == 0.0 and model.encoder.noise == 0.0:
        force = QUIET * model.axis.mass * limits.acceleration
        model = model.replace(noise=model.noise.replace(force=force))
        notes.append(
            f"the model states neither noise nor the encoder's resolution: {force:.3g} {model.units.of('V')} rms "
            "assumed, 1 % of the force of the largest acceleration"
        )
    return model


def read_result(path: str | os.PathLike[str]) -> dict[str, Any]:
    """Read the result of `diagnose --json`.

    Raises:
        InputError: the file cannot be read, or is not such a result.
    """
    what = f"{path}: must be the result of diagnose --json"
    try:
        document = json.loads(read_text(path), parse_constant=lambda word: None)
    except RecursionError:
        raise InputError(f"{what}, got lists or tables nested without end") from None
    except ValueError as error:
        raise InputError(f"{what} (JSON): {error}") from None
    if not isinstance(document, dict):
        raise InputError(f"{what}, got a {type(document).__name__}")
    if "verdict" not in document or "effects" not in document:
        raise InputError(f"{what}, got no verdict and effects")
    return document


def found_in(result: Mapping[str, Any] | None, model: Model, vocabulary: Mapping[str, Effect]) -> list[Found]:
    """The effects of a result, as its JSON holds them.

    Raises:
        FieldError: a ValueError that names field, rule and value.
    """
    entries = [] if result is None else result.get("effects")
    if not isinstance(entries, list) or not all(isinstance(entry, Mapping) for entry in entries):
        raise FieldError("", "effects", f"must be the list of effects of a result of diagnose, got {quoted(entries)}")
    known, found = {*vocabulary, *CHANGES}, []
    for number, entry in enumerate(entries):
        place, name, others = f"effects[{number}]", entry.get("name"), entry.get("alternatives", [])
        named = [("name", name), *(("alternatives", one) for one in (others if isinstance(others, list) else [others]))]
        for key, one in named:
            if not isinstance(one, str) or one not in known:
                rule = f"must be an effect of the vocabulary, got {quoted(one)}{nearest(str(one), known)}"
                raise FieldError(place, key, rule)
        fields = ["change"] if name in CHANGES else list(vocabulary[name].FIELDS)
        values = _values(entry.get("parameters", {}), f"{place}.parameters", name, fields)
        alternatives = tuple(one for one in others if one != name)
        if name in CHANGES:
            change = values.get("change")
            if not isinstance(change, float) or change <= -1.0:
                raise FieldError(f"{place}.parameters", "change", f"must be a number above -1, got {quoted(change)}")
            found.append(Found(name, None, change, alternatives))
            continue
        if (ends := kind_of(vocabulary[name], Travel)) is not None:
            values.setdefault(ends.ends, [float(end) for end in model.axis.travel])
        try:
            found.append(Found(name, vocabulary[name].replace(**values), 0.0, alternatives))
        except (TypeError, ValueError) as error:
            raise FieldError(place, "parameters", str(error)) from None
    return found


def _values(table: Any, place: str, name: str, fields: Sequence[str]) -> dict[str, Any]:
    """Values of parameters by field, without unknown ones."""
    if not isinstance(table, Mapping):
        raise FieldError("", place, f"must be a table, got {quoted(table)}")
    values: dict[str, Any] = {}
    for key, entry in table.items():
        value = entry.get("value") if isinstance(entry, Mapping) else entry
        if key not in fields:
            raise FieldError(place, key, f"is no field of {name}{nearest(key, fields)}")
        if value is None:
            continue
        if not all(map(is_number, value if isinstance(value, list) else [value])):
            raise FieldError(place, key, f"must have a number as its value, got {quoted(value)}")
        values[key] = list(map(float, value)) if isinstance(value, list) else float(value)
    return values
