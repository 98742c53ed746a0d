"""The next experiment: a motion that separates rivals, lowers detection limits or narrows a fit."""

from __future__ import annotations

import json
import os
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from cogging._core import PidParameters, Sampled
from cogging.calls import PATH, Kind, takes
from cogging.design.experiment.goals import Expectation, Found, detect, fit, separate
from cogging.design.experiment.limits import MotionLimits
from cogging.design.experiment.look import CHANGES, Machine, Run
from cogging.design.experiment.motion import SURVEY, Element, drawn, is_known
from cogging.design.pid import pid_gains
from cogging.diagnosis.result import Diagnosis
from cogging.effects.custom import Custom, by_name, refuse_two_of_one_name
from cogging.effects.effect import VOCABULARY, Effect, Travel, Turn, kind_of
from cogging.files import FieldError, InputError, read_text
from cogging.logs.log import Log
from cogging.model.controller import AnyController
from cogging.model.model import Model, is_number
from cogging.model.units import Units
from cogging.outputs import to_json, to_toml, write_files
from cogging.plot.results import whole_plan
from cogging.progress import Progress, steps
from cogging.resources import on_one_blas_thread, on_threads
from cogging.shown import nearest, quoted
from cogging.simulation.arguments import MODEL
from cogging.values import ByValue

if TYPE_CHECKING:
    from matplotlib.figure import Figure

LIMITS = Kind((MotionLimits, *PATH), "a MotionLimits or the path of a limits file")
RESULT = Kind((Diagnosis, Mapping, type(None), *PATH), "a Diagnosis, what its JSON holds, or the path of that JSON")
PURPOSE = {
    "separate": "a motion to tell rivals apart",
    "detect": "a motion to see small effects",
    "fit": "a motion to narrow the intervals of a fit",
}
ROUNDS, FRESH, TOGETHER = 9, 5, 4  # of drawn motions, those that owe nothing to the best so far, and motions in each
PARTS, PART_MIN = 3, 2.0  # elements one after another, at most, and s of each, at least
POLE, POLE_RATE = 60.0, 1000.0  # 1/s and Hz, of the loop of a model that states none
QUIET = 0.01  # of the force of the largest acceleration: noise of a model that states none


class NoMotion(ValueError):
    """No motion keeps to the limits."""

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
        limits: what the machine may do, with what the model stated of it.
        taken: largest of each quantity in the simulated loop over its limit, by the limit's name.
        expected: what the motion is expected to show.
        notes: sentences on what was assumed.
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
        lines += [f"of the limits it takes: {shares}", "to be expected:"]
        lines += [f"  {entry.text()}" for entry in self.expected] or ["  nothing that can be told"]
        return "\n".join([*lines, *(f"note: {note}" for note in self.notes)])

    def to_dict(self) -> dict[str, Any]:
        """The plan without its samples: what stands beside the reference file."""
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

    def plot(self, *, units: Any = None, ax: Any = None) -> Figure:
        """Draw position, speed and acceleration of the motion over time.

        Args:
            units: labels of command and position (cogging.Units).
            ax: three axes; None: a new figure.

        Returns:
            The figure.
        """
        return whole_plan(self, units=units, ax=ax).figure

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


@takes(model=MODEL, limits=LIMITS, result=RESULT)
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
    """Compute a motion within a machine's limits that tells most, and what is to be expected of it.

    Motions are drawn: strokes, creep with reversals, short steps, random moves. Each is simulated in closed loop, with
    noise and encoder, and held against the limits: travel with room to stop, speed, acceleration, jerk, time and
    command. Its log is seen as `diagnose` would see it; the best motion is varied.

    Goals: `separate` makes an effect and its alternatives, refitted to the same motion, stand as far apart as can be
    (T-optimal, Atkinson and Fedorov 1975); `detect` lowers the detection limits; `fit` narrows the intervals of the
    model's parameters (D-optimal), with what its `[bounds]` know already.

    Args:
        model: model that the result is of, or its file. Without a controller a plain PID tracks the motion: a note
            says so.
        limits: what the machine may do, or its file.
        result: what `diagnose` found, or the JSON that it wrote.
        logs: logs that the result is of: their motion is not proposed again.
        goal: separate, detect or fit; None: separate where the result has alternatives, else detect.
        controller: one to use in place of the model's own (see simulate).
        also: effects of your own that the result names.
        seed: of the noise and the drawn motions.
        progress: True shows a line of what is being done, a function is told each step in words.

    Returns:
        The motion with what it is expected to show; print it to read it, `write` it to run it.

    Raises:
        ValueError: a goal that is none, a result without alternatives for `separate`, limits that no motion keeps to.
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
            raise NoMotion("no motion of this machine keeps to them, not even at a fifth of the speed")
        machine = machine.listening(whole, survey)
        if goal == "separate":
            told = separate(machine, model, found, vocabulary, survey)
        elif goal == "detect":
            told = detect(machine, whole, vocabulary, survey, (document or {}).get("limits") or {})
        else:
            told = fit(machine, model.replace(effects=()), whole, survey)
        best = _best(machine, whole, told.worth, logs, begin)
        if best is None:
            raise NoMotion("no motion that was drawn keeps to them, or none lets the axis move for long enough")
        begin("what is to be expected")
        expected = tuple(told.expectations(best))
    plan = goal, best.elements, best.motion, limits, best.taken, expected, tuple(notes), seed, model.units
    return ExperimentPlan(*plan)


def _best(
    machine: Machine, truth: Model, worth: Callable[[Run], float], logs: Sequence[Log], begin: Callable[[str], None]
) -> Run | None:
    """The best of motions drawn anew and then near the best so far; None where none keeps to the limits."""
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
    """The model with a controller and noise: its own, or a plain PID and a hundredth of the force; notes say so."""
    mass, viscous = model.axis.mass, model.axis.viscous
    if controller is None and model.controller is None:
        kp, ki, kd = pid_gains([-POLE] * 3, mass)
        own = PidParameters(sample_rate=POLE_RATE, kp=kp, ki=ki, kd=kd, mass=mass, viscous=viscous)
        model = model.replace(controller=own, controller_type="pid")
        notes.append(
            f"the model states no controller: planned with a PID of three poles at {POLE:g} 1/s at {POLE_RATE:g} Hz; "
            "what yours makes of the motion may exceed the limits"
        )
    if model.noise.force == 0.0 and model.encoder.resolution == 0.0 and model.encoder.noise == 0.0:
        force = QUIET * mass * limits.acceleration
        model = model.replace(noise=model.noise.replace(force=force))
        notes.append(
            f"the model states neither noise nor the encoder's resolution: {force:.3g} {model.units.of('V')} rms "
            "assumed, 1 % of the force of the largest acceleration"
        )
    return model


def read_result(path: str | os.PathLike[str]) -> dict[str, Any]:
    """Read what `diagnose --json` wrote.

    Raises:
        InputError: the file cannot be read, or is no such result.
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
    """Values of parameters by field; those that are not known are left out."""
    if not isinstance(table, Mapping):
        raise FieldError("", place, f"must be a table, got {quoted(table)}")
    values: dict[str, Any] = {}
    for key, told in table.items():
        value = told.get("value") if isinstance(told, Mapping) else told
        if key not in fields:
            raise FieldError(place, key, f"is no field of {name}{nearest(key, fields)}")
        if value is None:
            continue
        if not all(map(is_number, value if isinstance(value, list) else [value])):
            raise FieldError(place, key, f"must have a number as its value, got {quoted(value)}")
        values[key] = list(map(float, value)) if isinstance(value, list) else float(value)
    return values
