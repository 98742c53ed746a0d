"""The next experiment: a motion that separates rivals, lowers detection limits or narrows a fit, computed."""

from __future__ import annotations

import os
from collections.abc import Mapping, Sequence
from dataclasses import replace
from typing import Any

import numpy as np

from cogging._core import PidParameters
from cogging.blas_threads import on_one_blas_thread
from cogging.calls import PATH, Kind, takes
from cogging.design.pid import pid_gains
from cogging.diagnosis.candidates.signatures import vocabulary_of
from cogging.diagnosis.experiment.detection import Detection
from cogging.diagnosis.experiment.expectation import GOALS
from cogging.diagnosis.experiment.experiment_plan import ExperimentPlan
from cogging.diagnosis.experiment.feasibility import Run
from cogging.diagnosis.experiment.limits import MotionLimits
from cogging.diagnosis.experiment.narrowing import Narrowing
from cogging.diagnosis.experiment.proposal import Machine, Question, propose, survey
from cogging.diagnosis.experiment.result_file import read_result
from cogging.diagnosis.experiment.rivals import Found, found_in
from cogging.diagnosis.experiment.separation import Separation, within
from cogging.diagnosis.labelled import labelled
from cogging.diagnosis.result import Diagnosis
from cogging.diagnosis.thresholds import EXPERIMENT, OBSERVER
from cogging.effects.custom import Custom, by_name, refuse_two_of_one_name
from cogging.effects.effect import Effect
from cogging.estimation.innovations import Innovations
from cogging.estimation.residuals import quiet
from cogging.model.controller import AnyController
from cogging.model.model import Model
from cogging.progress import Progress, steps
from cogging.shown import nearest
from cogging.simulation.arguments import MODEL

LIMITS = Kind((MotionLimits, *PATH), "a MotionLimits or the path of a limits file")
RESULT = Kind((Diagnosis, Mapping, type(None), *PATH), "a Diagnosis, what its JSON holds, or the path of that JSON")


class NoMotion(ValueError):
    """No motion keeps to the limits."""

    def __init__(self, why: str) -> None:
        self.why = why
        super().__init__(f"limits: {why}")


@takes(model=MODEL, limits=LIMITS, result=RESULT)
@on_one_blas_thread(scipy=True)
def plan_experiment(
    model: Model | str | os.PathLike[str],
    limits: MotionLimits | str | os.PathLike[str],
    *,
    result: Diagnosis | Mapping[str, Any] | str | os.PathLike[str] | None = None,
    goal: str | None = None,
    controller: AnyController | None = None,
    also: Sequence[Custom] = (),
    seed: int = 0,
    progress: Progress = False,
) -> ExperimentPlan:
    """Compute a motion within a machine's limits that tells most, and what is to be expected of it.

    Motions that engineers run (strokes at several speeds, creep with reversals, swept sines and sums of sines, steps,
    random moves, rests) are simulated in closed loop, with noise and encoder, and held against the limits: travel with
    room to stop, speed, acceleration, jerk, time and command. The best combination of three is then refined.

    Goals: `separate` makes the worst pair of an effect and its alternative, refitted to the same motion, stand as far
    apart as it can (T-optimal, Atkinson and Fedorov 1975); `detect` lowers the worst detection limit; `fit` narrows
    the intervals of the model's parameters (D-optimal), with what its `[bounds]` know already.

    Args:
        model: model that the result is of, or its file. Without a controller a plain PID tracks the motion: a note
            says so.
        limits: what the machine may do, or its file.
        result: what `diagnose` found, or the JSON that it wrote.
        goal: separate, detect or fit; None: separate where the result has alternatives, else detect.
        controller: one to use in place of the model's own (see simulate).
        also: effects of your own that the result names.
        seed: of the noise.
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
    if not isinstance(limits, MotionLimits):
        limits = MotionLimits.read(limits)
    if isinstance(result, str | os.PathLike):
        result = read_result(result)
    vocabulary = vocabulary_of(model, [effect.neutral() for effect in own.values()])
    limits = limits.of(model)
    found = found_in(result, model, vocabulary)
    goal = _goal(goal, found)
    notes: list[str] = []
    model = _with_loop(model, controller, notes)
    model, loudness_of = _with_noise(model, result, limits, notes)
    with steps(progress, "experiment") as begin:
        begin("surveying the travel")
        questions = _questions(goal, model, found, vocabulary, limits, result)
        machine, first = _surveyed([questions[0].truth, model], controller, limits, seed, notes)
        loudness = loudness_of(machine, first.log)
        ready = [replace(question, loudness=loudness).looking(first.log) for question in questions]  # type: ignore[type-var]
        best = propose(machine, ready, begin)
        if best is None:
            raise NoMotion("no motion of the dictionary keeps to them, or none lets the axis move for long enough")
        begin("what is to be expected")
        expected = [entry for question in ready for entry in question.expectations(best.run.log)]
    plan = ExperimentPlan(goal, best.elements, best.motion, limits, best.run.taken, tuple(expected), tuple(notes), seed)
    return labelled(plan, model.units, apart=("elements", "motion", "limits", "taken"))


def _surveyed(
    truths: Sequence[Model], controller: AnyController | None, limits: MotionLimits, seed: int, notes: list[str]
) -> tuple[Machine, Run]:
    """The first of several models that keeps to the limits at all, as a machine, and its run over the travel.

    Raises:
        NoMotion: none does.
    """
    for truth in truths:
        machine = Machine(within(truth, limits.duration), controller, limits, seed)
        first = survey(machine)
        if first is not None:
            if truth is not truths[0]:
                notes.append("with the effects of the result no motion keeps to the limits: simulated without them")
            return machine, first
    raise NoMotion("no motion of this machine keeps to them, not even at a fifth of the speed")


def _goal(goal: str | None, found: Sequence[Found]) -> str:
    """What the motion is for.

    Raises:
        ValueError: no such goal, or nothing to separate.
    """
    ambiguous = any(one.alternatives for one in found)
    if goal is None:
        return "separate" if ambiguous else "detect"
    if goal not in GOALS:
        raise ValueError(f"goal: must be one of {', '.join(GOALS)}, got {goal!r}{nearest(goal, GOALS)}")
    if goal == "separate" and not ambiguous:
        raise ValueError("goal: separate needs a result with alternatives, got none; detect and fit need none")
    return goal


def _questions(
    goal: str,
    model: Model,
    found: Sequence[Found],
    vocabulary: Mapping[str, Effect],
    limits: MotionLimits,
    result: Any,
) -> list[Question]:
    """What the motion is to answer."""
    rest = max(model.axis.coulomb_width, OBSERVER.rest_of_speed * limits.velocity)
    if goal == "separate":
        return [Separation.of(found, one, model, vocabulary, rest) for one in found if one.alternatives]
    for one in found:
        model = one.added_to(model)
    if goal == "fit":
        return [Narrowing.of(model, rest)]
    document = result.to_dict() if isinstance(result, Diagnosis) else result or {}
    return [Detection.of(model, vocabulary, rest, document.get("limits") or {})]


def _with_loop(model: Model, controller: AnyController | None, notes: list[str]) -> Model:
    """The model with a controller: its own, or a PID that tracks."""
    if controller is not None or model.controller is not None:
        return model
    pole, rate = EXPERIMENT.tracking_pole, EXPERIMENT.tracking_rate
    kp, ki, kd = pid_gains([-pole] * 3, model.axis.mass)
    tracking = PidParameters(sample_rate=rate, kp=kp, ki=ki, kd=kd, mass=model.axis.mass, viscous=model.axis.viscous)
    notes.append(
        f"the model states no controller: planned with a PID of three poles at {pole:g} 1/s at {rate:g} Hz; "
        "what yours makes of the motion may exceed the limits"
    )
    return model.replace(controller=tracking, controller_type="pid")


def _with_noise(model: Model, result: Any, limits: MotionLimits, notes: list[str]) -> tuple[Model, Any]:
    """The model with the noise that is to be expected, and what tells how much louder a machine was measured to be."""
    document = result.to_dict() if isinstance(result, Diagnosis) else result or {}
    gap = document.get("gap") or {}
    floor, signal = gap.get("floor"), str(gap.get("signal", ""))
    floor = float(floor) if isinstance(floor, int | float) and np.isfinite(floor) and floor > 0.0 else 0.0
    silent = model.noise.force == 0.0 and model.encoder.resolution == 0.0 and model.encoder.noise == 0.0
    if silent:
        force = floor or EXPERIMENT.quiet_force * model.axis.mass * limits.acceleration
        source = "as the result's floor" if floor else "1 % of the force of the largest acceleration"
        notes.append(
            f"the model states neither noise nor the encoder's resolution: {force:.3g} V rms assumed, {source}"
        )
        model = model.replace(noise=model.noise.replace(force=force))

    def loudness(machine: Machine, log: Any) -> float:
        return _loudness(machine, log, floor, signal) if floor else 1.0

    return model, loudness


def _loudness(machine: Machine, log: Any, floor: float, signal: str) -> float:
    """Power of the noise that a result measured over that which the model would show in the same signal."""
    if signal.startswith("command"):
        silent = Machine(quiet(machine.model), machine.controller, machine.limits, machine.seed)
        other = survey(silent)
        difference = log.command - other.log.command if other is not None and len(other.log) == len(log) else None
    else:
        difference = Innovations(log, machine.model, bandwidth=OBSERVER.gap_bandwidth).of([machine.model])[0]
    if difference is None:
        return 1.0
    rms = float(np.sqrt(np.mean(difference**2)))
    most = EXPERIMENT.loudness_max
    return float(np.clip((floor / rms) ** 2, 1.0 / most, most)) if rms > 0.0 else 1.0
