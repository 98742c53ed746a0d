"""Plan the next experiment: one rich motion within the machine's limits, and what it would show."""

from __future__ import annotations

import json
import os
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from cogging._core import DivergedError, Sampled, closed_loop
from cogging.calls import PATH, Kind, check_arguments
from cogging.design.experiment_motion import Element, motion_within
from cogging.design.motion_limits import MotionLimits, shares_of_limits
from cogging.design.pid import ASSUMED, assumed_pid
from cogging.diagnosis.balance.decision import Outcome
from cogging.diagnosis.balance.differenced_balance import DifferencedBalance
from cogging.diagnosis.balance.evidence import Evidence, TooLittleMotion, deviation, noise_filter
from cogging.diagnosis.detection_limits import CHANGES
from cogging.diagnosis.detection_limits import limits as detection_limits
from cogging.diagnosis.diagnosis_result import Diagnosis
from cogging.diagnosis.separating import separating
from cogging.effects.custom import Custom, by_name, refuse_two_of_one_name
from cogging.effects.effect import VOCABULARY, Effect, Turn, kind_of
from cogging.files import FieldError, InputError, read_text
from cogging.logs.log import Log
from cogging.model.controller import AnyController
from cogging.model.intervals import SIGMAS_95
from cogging.model.model import Model
from cogging.model.parameters import parameters_of
from cogging.model.units import Units
from cogging.outputs import to_json, to_toml, write_files
from cogging.plot.canvas import plot_method
from cogging.plot.results import whole_plan
from cogging.progress import Progress, steps
from cogging.resources import on_one_blas_thread
from cogging.shown import nearest, not_one_of, quoted
from cogging.simulation.arguments import MODEL
from cogging.values import ByValue

LIMITS = Kind((MotionLimits, *PATH), "a MotionLimits or the path of a limits file")
RESULT = Kind((Diagnosis, Mapping, type(None), *PATH), "a Diagnosis, what its JSON holds, or the path of that JSON")
GOALS = ("separate", "detect", "fit")
RATE = 2000.0  # Hz, largest rate of a reference's samples, with cubics between them
SCALES = (1.0, 0.7, 0.5, 0.35, 0.2)  # of speed, acceleration and jerk, tried until the machine keeps its limits
COPIES = 8  # simulated logs with other noise, from which the noise of the force balance is estimated
QUIET = 0.01  # of the force of the largest acceleration: assumed noise without a stated one
UNKNOWN = 1e3  # times the 1-sigma of a parameter with all others known: a larger one counts as not determined


class NoMotion(ValueError):
    """The motion of this machine does not keep the limits."""


class Expectation(NamedTuple):
    """What a planned motion is expected to show of one effect or parameter."""

    name: str  # of the effect; for a fit, the path of the parameter
    parameter: str  # field that measures the size of the effect; empty for a fit
    unit: str  # of the numbers
    #: Smallest size that `diagnose` finds with probability 95 %; for a fit, half of the 95 % interval. None: not shown.
    expected: float | None
    today: float | None = None  # the same before the motion; None: unknown
    why: str = ""  # why there is no number; empty if there is one

    def text(self) -> str:
        """One line."""
        unit = f" {self.unit}" if self.unit != "1" else ""
        today = "" if self.today is None else f"; today {self.today:.2g}{unit}"
        if self.expected is None:
            return f"{self.name}: not shown, {self.why}{today}"
        if self.parameter:
            return f"{self.name}: {self.parameter} of {self.expected:.3g}{unit} would be detected{today}"
        return f"{self.name}: to +- {self.expected:.3g}{unit}{today}"


@dataclass(frozen=True, eq=False, repr=False)
class ExperimentPlan(ByValue):
    """A planned experiment. Printed, it is its `text`.

    Attributes:
        goal: separate, detect or fit.
        elements: parts of the motion, each a kind with its start and end, s.
        motion: the reference.
        scale: of speed, acceleration and jerk: below 1 where the machine would exceed a limit.
        limits: of the machine, completed from the model.
        taken: largest of each quantity in the simulated loop over its limit, by the limit's name.
        expected: what the motion is expected to show.
        advice: motion that distinguishes the alternatives of the result; None without any.
        notes: assumptions.
        seed: of the noise and the random moves.
        units: labels of the model's units.
    """

    goal: str
    elements: tuple[Element, ...]
    motion: Sampled
    scale: float
    limits: MotionLimits
    taken: Mapping[str, float]
    expected: tuple[Expectation, ...]
    advice: str | None = None
    notes: tuple[str, ...] = ()
    seed: int = 0
    units: Units = field(default_factory=Units)

    def _brief(self) -> str:
        return f"{self.goal}, {self.motion.end:.4g} s: {', '.join(element.kind for element in self.elements)}"

    def text(self) -> str:
        """The plan for the screen."""
        lines = [f"one motion of {self.motion.end:.4g} s for all effects:"]
        lines += [f"  {one.start:6.2f} to {one.end:6.2f} s  {one.kind.replace('_', ' ')}" for one in self.elements]
        lines.append("shares of the limits used: " + ", ".join(f"{k} {100 * v:.0f} %" for k, v in self.taken.items()))
        if self.advice:
            lines.append(f"the alternatives differ most in: {self.advice}")
            lines.append("whether this motion separates them is not predicted")
        lines += ["expected:", *(f"  {entry.text()}" for entry in self.expected)]
        return "\n".join([*lines, *(f"note: {note}" for note in self.notes)])

    def to_dict(self) -> dict[str, Any]:
        """The plan without its samples, for JSON."""
        return {
            "goal": self.goal,
            "expected": [entry._asdict() for entry in self.expected],
            "separating_experiment": self.advice,
            "elements": [element._asdict() for element in self.elements],
            "scale": self.scale,
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
        table = zip(*(columns[name].tolist() for name in names), strict=True)
        rows = "\n".join([",".join(names), *(",".join(f"{value:.12g}" for value in row) for row in table)])
        reference = to_toml({"type": "sampled", "file": Path(samples).name, "duration": self.motion.end})
        return {os.fspath(path): reference, samples: f"{rows}\n", beside(path, ".plan.json"): to_json(self.to_dict())}


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
    """Make a motion within a machine's limits that shows every effect, and compute what it is expected to show.

    The motion is one recipe for all machines and goals, simulated in closed loop and slowed down until it keeps the
    limits. `separate` and `detect` state the detection limits that `diagnose` would reach with the simulated log,
    `separate` also which motion distinguishes the alternatives of a result; `fit` states the intervals of the model's
    parameters, given its `[bounds]`.

    Args:
        model: model that the result is of, or its file; effects that only the result has are not simulated. Without a
            controller a plain PID tracks the motion: a note says so.
        limits: of the machine, or their file.
        result: of `diagnose`, or its JSON file.
        logs: of the result; each makes the random moves others.
        goal: separate, detect or fit; None: separate where the result has alternatives, else detect.
        controller: to use instead of the model's (see simulate).
        also: user-defined effects in the model or the result.
        seed: of the noise and the random moves.
        progress: True shows the current step; a function receives its name.

    Returns:
        The motion and what it is expected to show; `write` it to run it.

    Raises:
        ValueError: an unknown goal, a result without alternatives for `separate`, limits that the motion cannot keep.
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
    laws = [law for law in VOCABULARY.values() if model.units.position == "rad" or kind_of(law, Turn) is None]
    vocabulary = {law.NAME: law for law in (*laws, *(effect.neutral() for effect in own.values()))}
    if isinstance(result, str | os.PathLike):
        result = read_result(result)
    document = result.to_dict() if isinstance(result, Diagnosis) else result or {"effects": []}
    rivals = alternatives_in(document, vocabulary)
    goal = goal or ("separate" if rivals else "detect")
    if goal not in GOALS:
        raise ValueError(f"goal: {not_one_of(goal, GOALS)}")
    if goal == "separate" and not rivals:
        raise ValueError("goal: separate needs a result with alternatives, got none; detect and fit need none")
    notes: list[str] = []
    if controller is None and model.controller is None:
        model = model.replace(controller=assumed_pid(model.axis))
        assumed = f"planned with {ASSUMED}; the motion under yours may exceed the limits"
        notes.append(f"the model states no controller: {assumed}")
    if model.noise.force == model.encoder.resolution == model.encoder.noise == 0.0:
        force = QUIET * model.axis.mass * limits.acceleration
        model = model.replace(noise=model.noise.replace(force=force))
        assumed = f"{force:.3g} {model.units.command} rms assumed, 1 % of the force of the largest acceleration"
        notes.append(f"the model states neither noise nor the encoder's resolution: {assumed}")
    seed += len(logs)
    with steps(progress, "experiment") as begin:
        begin("simulating the motion")
        motion, elements, scale, log, taken = _simulated(model, controller, limits, seed)
        begin("what is to be expected")
        stated = model if goal != "fit" else model.replace(effects=())  # whose effects' amplitudes are known
        logs = [log, *(_run(model, controller, motion, seed + number) for number in range(1, COPIES))]
        try:
            evidence = _evidence(logs, stated, model)
        except TooLittleMotion as error:
            raise NoMotion(f"the motion within the limits shows too little: {error}") from None
        if goal == "fit":
            expected = _intervals(evidence, model)
        else:
            # The detection limits that `diagnose` states for a log in which nothing is hidden.
            expected = []
            for name, limit in detection_limits(Outcome(evidence, evidence, evidence, [], [], []), vocabulary).items():
                known = (document.get("limits") or {}).get(name) or {}
                before = known.get("value") if known.get("parameter") == limit.parameter else None
                value = None if limit.value is None else float(f"{limit.value:.4g}")
                unit = model.units.of(limit.unit)
                expected.append(Expectation(name, limit.parameter, unit, value, before, limit.why))
    advice = separating(rivals, vocabulary, [log]) if goal == "separate" else None
    shown, said = tuple(expected), tuple(notes)
    return ExperimentPlan(goal, elements, motion, scale, limits, taken, shown, advice, said, seed, model.units)


def _run(model: Model, controller: AnyController | None, motion: Sampled, seed: int) -> Log:
    """Return the simulated log of a motion; DivergedError or ValueError: the axis left its travel."""
    options: dict[str, Any] = {"duration": motion.end, "seed": seed, "steps_per_sample": model.steps_per_sample}
    return Log.of(closed_loop(model.plant(), controller or model.make_controller(), motion, **options))


def _simulated(
    model: Model, controller: AnyController | None, limits: MotionLimits, seed: int
) -> tuple[Sampled, tuple[Element, ...], float, Log, dict[str, float]]:
    """Return the motion at the largest scale that keeps the limits, its parts, scale, log and shares of the limits."""
    reached = "it leaves its travel"
    rate = min((controller or model.make_controller()).sample_rate, RATE)
    for scale in SCALES:
        motion, elements = motion_within(limits, rate, scale=scale, seed=seed)
        try:
            log = _run(model, controller, motion, seed)
        except (DivergedError, ValueError):
            continue
        taken = shares_of_limits(motion, log, limits)
        over = {name: share for name, share in taken.items() if share > 1.0}
        if not over:
            return motion, elements, scale, log, taken
        reached = ", ".join(f"{name} at {100.0 * share:.3g} % of its limit" for name, share in over.items())
    raise NoMotion(f"no motion of this machine keeps the limits, not even at a fifth of the speed: {reached}")


def _evidence(logs: Sequence[Log], stated: Model, model: Model) -> Evidence:
    """Return the evidence of the first log, with the noise filter of all."""
    from scipy.signal import lfilter

    balances = [DifferencedBalance(log, model.axis.coulomb_width, model.encoder.resolution) for log in logs]
    balances[0].listen(balances[0].residual(model), model.axis)
    for balance in balances[1:]:
        balance.corner = balances[0].corner
    left = np.concatenate([balance.rows(balance.residual(model))[0] for balance in balances])
    mask = np.concatenate([balance.mask for balance in balances])
    taps = noise_filter(left, mask, balances[0].rate)
    evidence = Evidence(balances[:1], stated, model).prepare()
    evidence.screen = evidence.fitted([np.asarray(taps / deviation(lfilter(taps, 1.0, left)[mask]))])
    return evidence


def _intervals(evidence: Evidence, model: Model) -> list[Expectation]:
    """Return half of each parameter's 95 % interval by least squares, with the intervals in `[bounds]` as priors."""
    known = parameters_of(model, together=True)
    rows = evidence.filtered(evidence.nuisances, evidence.screen.taps) * evidence.basis[0]
    prior = evidence.prior_sigma**-2.0
    halves = {}
    for number, path in enumerate(evidence.paths):
        if path in known:
            low, high = model.intervals.get(path, (-np.inf, np.inf))
            halves[path] = 0.5 * (high - low)
            prior[number] = (halves[path] / SIGMAS_95) ** -2.0
    information = rows @ rows.T + np.diag(prior)
    size = np.sqrt(np.diag(information))
    size[size == 0.0] = 1.0
    scaled = np.linalg.inv(information / np.outer(size, size) + UNKNOWN**-2.0 * np.eye(len(size)))
    spread = dict(zip(evidence.paths, np.sqrt(np.diag(scaled)), strict=True))
    sigma = dict(zip(evidence.paths, np.sqrt(np.diag(scaled)) / size, strict=True))
    expected = []
    for path, today in halves.items():
        is_shown = spread[path] < 0.3 * UNKNOWN
        half = float(f"{SIGMAS_95 * sigma[path]:.4g}") if is_shown else None
        why = "" if is_shown else "its effect cannot be distinguished from that of other parameters"
        before = float(f"{today:.4g}") if today < np.inf else None
        expected.append(Expectation(path, "", known[path].unit, half, before, why))
    return expected


def read_result(path: str | os.PathLike[str]) -> dict[str, Any]:
    """Read the result of `diagnose --json`; InputError: the file cannot be read, or is not such a result."""
    what = f"{path}: must be the result of diagnose --json"
    try:
        document = json.loads(read_text(path), parse_constant=lambda word: None)
    except RecursionError:
        raise InputError(f"{what}, got lists or tables nested without end") from None
    except ValueError as error:
        raise InputError(f"{what} (JSON): {error}") from None
    if not isinstance(document, dict) or not {"verdict", "effects"} <= set(document):
        got = "no verdict and effects" if isinstance(document, dict) else f"a {type(document).__name__}"
        raise InputError(f"{what}, got {got}")
    return document


def alternatives_in(result: Mapping[str, Any], vocabulary: Mapping[str, Effect]) -> list[str]:
    """Return the names of all effects of a result that have alternatives, and of these; FieldError: invalid."""
    entries = result.get("effects")
    if not isinstance(entries, list) or not all(isinstance(entry, Mapping) for entry in entries):
        raise FieldError("", "effects", f"must be the list of effects of a result of diagnose, got {quoted(entries)}")
    known, names = {*vocabulary, *(f"{name}_change" for name in CHANGES)}, set()
    for number, entry in enumerate(entries):
        name, others = entry.get("name"), entry.get("alternatives", [])
        others = others if isinstance(others, list) else [others]
        for key, one in [("name", name), *(("alternatives", one) for one in others)]:
            if not isinstance(one, str) or one not in known:
                rule = f"must be an effect of the vocabulary, got {quoted(one)}{nearest(str(one), known)}"
                raise FieldError(f"effects[{number}]", key, rule)
        if others:
            names |= {name, *others}
    return sorted(names)
