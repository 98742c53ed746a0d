"""Gains of a controller for an uncertain machine: the smallest rms error within limits on command and robustness."""

from __future__ import annotations

import importlib.metadata
import math
import os
from collections.abc import Callable, Mapping
from typing import Any, NamedTuple

import numpy as np

from cogging._core import Reference
from cogging.calls import Kind, did_you_mean, takes
from cogging.design.tuning.gains import Gain, Tuned, tuned_of_function, tuned_of_model
from cogging.design.tuning.limits import ALL_END, Limit, asked_limits, excesses, limits_of
from cogging.design.tuning.machines import BOUNDS, machines_of, variations_of
from cogging.design.tuning.margins import Push, push_of
from cogging.design.tuning.reached import INDEXES, MARGINS, Course, Judge, Reached
from cogging.design.tuning.trials import (
    RULE,
    KeptTrials,
    Trial,
    best_of,
    failures_of,
    front_of,
    nearest_of,
    optuna,
    run_trials,
    some_of,
)
from cogging.design.tuning.tuning import Setting, Tuning
from cogging.files import FieldError
from cogging.model.controller import AnyController
from cogging.model.model import Model
from cogging.progress import Progress, steps
from cogging.shown import quoted
from cogging.simulation.arguments import MODEL, REFERENCE
from cogging.simulation.reference import read_reference, reference_from, reference_to_dict
from cogging.simulation.varied import Setup

FRONT_MOST = 8  # points of the trade-off whose margins are measured
INDEXES_SHOWN = ("error_rms", "command_max", "command_chatter")  # of each
AT_END = 0.01  # of a range, or of its logarithm: so near its end a gain counts as at it
MOST = 1_000_000
CONTROLLER = Kind((Callable, type(None)), "a function that makes a controller of gains")  # type: ignore[arg-type]
TABLE = Kind((Mapping, type(None)), "a table of gains by path")


class Task(NamedTuple):
    """All that a tuning needs while it runs."""

    tuned: Tuned
    limits: tuple[Limit, ...]
    judge: Judge
    held_out: Judge
    push: Push
    present: Trial
    against: str
    notes: list[str]


@takes(model=MODEL, reference=REFERENCE, gains=TABLE, controller=CONTROLLER)
def tune(
    model: Model | str | os.PathLike[str],
    reference: Reference | Mapping[str, Any] | str | os.PathLike[str],
    gains: Mapping[str, Any] | None = None,
    *,
    controller: Callable[..., AnyController] | None = None,
    limits: Mapping[str, Any] | None = None,
    vary: Mapping[str, Any] | str = BOUNDS,
    machines: int = 32,
    held_out: int = 32,
    quantile: float = 0.9,
    trials: int = 100,
    against: str | None = None,
    seed: int = 0,
    duration: float = 0.0,
    start: float = -np.inf,
    stop: float = np.inf,
    out: str | os.PathLike[str] | None = None,
    threads: int = 0,
    progress: Progress = False,
) -> Tuning:
    """Find the gains with the smallest rms error for a machine that is known within intervals.

    Minimised is the quantile of rms error over drawn machines, the same machines and noise in every trial, subject to
    limits that must be kept on every one of them. Optuna's TPE sampler proposes the gains and is told by how much each
    limit is broken; the present gains come first. What is found is judged on machines that it has not seen.

    Margins of delay and gain are measured by pushing each machine, so that they hold for any controller: the largest
    delay of the command, and the largest factor on it, with which every machine forgets a push (docs/tune.md). Where
    the controller has a linear part, `modulus_margin` is the smallest |1 + L| beside them.

    With `out`, finished trials stand beside it (`OUT.trials`) until all is done: after an interruption or a crash the
    same call goes on where it was. When it is interrupted, the best gains so far are written to `out`.

    Args:
        model: a Model, or the path of a model file; its controller is tuned.
        reference: a motion, the fields of a reference file, or the path of one.
        gains: by path (`controller.kp`) a table with `from` and `to`, optional `scale` ("log" where both ends are above
            0, or "linear") and `start`, the present value; None: the usual gains of the controller, each from a tenth
            to ten times its present value.
        controller: for one of one's own: a function that makes it of the gains by keyword; their present values are its
            defaults.
        limits: by name (error_max, command_max, command_rms, command_chatter: at most; delay_margin, gain_margin,
            modulus_margin: at least) a number, or `{"present": 1.1}` for 1.1 times what the present gains reach.
        vary: how machines differ, as for `sweep`; "bounds": all that the model has [bounds] or an uncertainty for.
        machines: to tune with.
        held_out: further machines, to judge what was found.
        quantile: of rms error over the machines, above 0 and at most 1.
        trials: how many.
        against: a second objective, by the name of a limit: then the trials spread along the trade-off of both.
        seed: of machines, noise and trials.
        duration: s; 0 = that of the reference file, or the motion's own end.
        start, stop: s; error and command are judged over the rows with start <= time < stop.
        out: the model file to write; None: none.
        threads: 0 = all cores. The result does not depend on it.
        progress: see cogging.progress.

    Returns:
        The present and the tuned gains, what both reach and cost, and the trade-off.

    Raises:
        ValueError: an argument breaks its rule, a path is none (with the nearest), or the present gains cannot run.
        InputError: a file cannot be used or written; finished trials stand.
        ImportError: Optuna is not there; names the extra that brings it.

    Example:
        >>> gains = {"controller.kp": {"from": 5e3, "to": 2e4}, "controller.kd": {"from": 20.0, "to": 100.0}}
        >>> few = {"trials": 8, "machines": 2, "held_out": 2, "duration": 0.3}
        >>> tuning = cogging.tune(model, move, gains, limits={"delay_margin": 1e-3}, **few)
        >>> tuning.tuned.drawn.error_rms < tuning.present.drawn.error_rms, tuning.tuned.drawn.delay_margin >= 1e-3
        (True, True)
    """
    optuna()
    _require_numbers(machines, held_out, trials, seed, quantile, against)
    model = model if isinstance(model, Model) else Model.read(model)
    motion, own_duration = _motion(reference)
    setup = Setup(model, motion)
    tuned = tuned_of_model(model, motion, gains) if controller is None else tuned_of_function(controller, gains)
    variations, notes = variations_of(setup, vary)
    asked = asked_limits(limits or {})
    course = Course(duration or own_duration, start, stop, quantile, threads)
    drawn, fresh = (machines_of(setup, variations, n, seed, i) for i, n in enumerate((machines, held_out)))
    judge, other = Judge(drawn, tuned, course), Judge(fresh, tuned, course)
    present, push = _present(judge, tuned, motion, course)
    known = limits_of(asked, present)
    first = Trial(tuned.present, present, excesses(known, tuned.present, present, judge, push))
    task = Task(tuned, known, judge, other, push, first, against or "command_chatter", notes)
    described: dict[str, Any] = {
        "vary": dict(vary) if isinstance(vary, Mapping) else vary,
        "limits": asked,
        "seed": seed,
    }
    described |= {"machines": machines, "quantile": quantile, "against": against, "course": list(course[:4])}
    kept = None
    if out is not None and controller is None:
        kept = KeptTrials(out, _asked(setup, tuned, described))
    found = _trials(task, trials, seed, against, out, kept, progress)
    result = _result(task, found, {"quantile": quantile, "seed": seed}, progress)
    if out is not None and result.model is not None:
        result.model.write(out)
    if kept is not None:
        kept.remove()
    return result


def _present(judge: Judge, tuned: Tuned, motion: Reference, course: Course) -> tuple[Reached, Push]:
    """What the present gains reach, with all margins, and the push that was used for them."""
    gains = tuned.present
    reached = judge.run(gains)
    command = reached.command_max if math.isfinite(reached.command_max) else 0.0
    if command == 0.0:
        command = judge.machines[0].setup.model.axis.mass  # of 1 m/s^2: a loop that fails has no command to go by
    push = push_of(motion, judge.controller(gains).sample_rate, course.duration, command)
    return judge.with_margins(gains, reached, push), push


def _trials(
    task: Task, count: int, seed: int, against: str | None, out: Any, kept: KeptTrials | None, progress: Progress
) -> list[Trial]:
    """All trials; where they are ended before their time, the best so far is written."""
    found: list[Trial] = []
    try:
        with steps(progress, "tune", count) as step:
            judged = _judge_of(task, against)
            for trial in run_trials(task.tuned.gains, count, seed, against, judged, kept, step):
                found.append(trial)
    except BaseException:
        if kept is not None:
            kept.write()
        best = best_of([task.present, *found])
        better = task.tuned.model(best.gains) if best is not None and best is not task.present else None
        if out is not None and better is not None:
            better.write(out)
        raise
    return found


def _judge_of(task: Task, against: str | None) -> Callable[[Mapping[str, float]], Trial]:
    """What judges the gains of a trial."""

    def judged(values: Mapping[str, float]) -> Trial:
        if values == task.present.gains:
            return task.present
        try:
            reached = task.judge.run(values)
        except ValueError:  # gains that go with each other by no rule of the controller
            margins = dict.fromkeys(MARGINS, 0.0) if against in MARGINS else {}
            worst = _nothing(len(task.judge.machines), margins)
            broken = {limit.name: 1.0 for limit in task.limits}
            return Trial(values, worst, {ALL_END: 1.0, **broken, RULE: 1.0})
        if against in MARGINS:
            reached = task.judge.with_margins(values, reached, task.push, (against,))
        return Trial(values, reached, excesses(task.limits, values, reached, task.judge, task.push))

    return judged


def _nothing(machines: int, margins: Mapping[str, float]) -> Reached:
    """What gains reach with which no run can begin."""
    return Reached(math.inf, math.inf, math.inf, math.inf, math.inf, machines, **margins)


def _result(task: Task, found: list[Trial], shown: Mapping[str, Any], progress: Progress) -> Tuning:
    """Judge what was found on fresh machines, with all margins."""
    best = best_of([task.present, *found])
    places = some_of(front_of(found, task.against), FRONT_MOST)
    notes = list(task.notes)
    with steps(progress, "tune: margins", len(places) + 2) as step:
        present = _setting(task, task.present)
        step("of the present gains")
        tuned = present if best is task.present else None if best is None else _setting(task, best)
        step("of the tuned gains")
        margins = []
        for place in places:
            margins.append(task.judge.loops(found[place].gains, task.push).delay_margin())
            step(f"of trial {place}")
    if best is None:
        notes += _why_none(task, found)
    else:
        notes += _notes(task, best)
    names = [gain.path for gain in task.tuned.gains]
    table: dict[str, Any] = {name: np.array([trial.gains[name] for trial in found]) for name in names}
    for name in ("error_rms", *INDEXES):
        numbers = [getattr(trial.reached, name) for trial in found]
        if all(number is not None for number in numbers):
            table[name] = np.array(numbers, dtype=float)
    table["kept"] = np.array([trial.kept for trial in found], dtype=bool)
    front: dict[str, Any] = {"trial": np.array(places, dtype=int)}
    front |= {name: table[name][places] for name in dict.fromkeys((*names, *INDEXES_SHOWN, task.against))}
    front["delay_margin"] = np.array(margins, dtype=float)
    return Tuning(
        present=present,
        tuned=tuned,
        improved=best is not None and best.gains != task.present.gains,
        model=None if best is None else task.tuned.model(best.gains),
        trials=table,
        front=front,
        against=task.against,
        limits=tuple(limit.text() for limit in task.limits),
        machines=len(task.judge.machines),
        held_out=len(task.held_out.machines),
        notes=tuple(notes),
        **shown,
    )


def _setting(task: Task, trial: Trial) -> Setting:
    drawn = task.judge.with_margins(trial.gains, trial.reached, task.push)
    fresh = task.held_out.with_margins(trial.gains, task.held_out.run(trial.gains), task.push)
    return Setting(dict(trial.gains), drawn, fresh)


def _why_none(task: Task, found: list[Trial]) -> list[str]:
    """Which limit failed most, and by how much."""
    nearest = nearest_of([task.present, *found])
    reached = task.judge.with_margins(nearest.gains, nearest.reached, task.push)
    failures = failures_of(found, [limit.name for limit in task.limits])
    name = max(failures, key=lambda one: failures[one])
    count, least = failures[name]
    by = f"at best by {100 * least:.3g} %" if least > 0.0 else "none in all of them at once"
    notes = [f"no trial keeps all limits; the one that failed most is {name}: in {count} of {len(found)} trials, {by}"]
    gains = ", ".join(f"{path} = {value:.4g}" for path, value in nearest.gains.items())
    broken = [limit.text(getattr(reached, limit.name)) for limit in task.limits if nearest.excess[limit.name] > 0.0]
    if reached.failed:
        broken.append(f"{reached.failed} of {len(task.judge.machines)} machines do not come to their end")
    return [*notes, f"nearest is {gains}: {'; '.join(broken) or 'it breaks a rule of the controller'}"]


def _notes(task: Task, best: Trial) -> list[str]:
    notes = []
    if best.gains == task.present.gains:
        notes.append("the present gains are the best that were tried")
    elif not task.present.kept:
        broken = [name for name, value in task.present.excess.items() if value > 0.0]
        notes.append(f"the present gains break a limit: {', '.join(broken)}")
    for gain in task.tuned.gains:
        end = _end(gain, best.gains[gain.path])
        if end:
            notes.append(f"{gain.path}: the best is at the {end} end of its range, a wider one may do better")
    return notes


def _end(gain: Gain, value: float) -> str:
    low, high, at = gain.low, gain.high, value
    if gain.logarithmic:
        low, high, at = math.log(low), math.log(high), math.log(max(at, low)) if at > 0.0 else math.log(low)
    share = (at - low) / (high - low)
    return "lower" if 0.0 <= share < AT_END else "upper" if 1.0 - AT_END < share <= 1.0 else ""


def _asked(setup: Setup, tuned: Tuned, described: Mapping[str, Any]) -> dict[str, Any]:
    return {
        "version": importlib.metadata.version("cogging"),
        "model": setup.model.to_dict(),
        "reference": reference_to_dict(setup.reference),
        "gains": [list(vars(gain).values()) for gain in tuned.gains],
        **described,
    }


def _require_numbers(
    machines: int, held_out: int, trials: int, seed: int, quantile: float, against: str | None
) -> None:
    numbers = {"machines": (machines, 1), "held_out": (held_out, 1), "trials": (trials, 1), "seed": (seed, 0)}
    for name, (value, least) in numbers.items():
        if isinstance(value, bool) or not isinstance(value, int | np.integer) or not least <= value <= MOST:
            raise FieldError("", name, f"must be a whole number from {least} to {MOST}, got {value!r}")
    if not isinstance(quantile, int | float) or not 0.0 < quantile <= 1.0:
        raise FieldError("", "quantile", f"must be above 0, at most 1, got {quantile!r}")
    if against is not None and against not in INDEXES:
        raise FieldError("", "against", f"is none: {quoted(against)}; {did_you_mean(against, INDEXES)}")


def _motion(reference: Any) -> tuple[Reference, float]:
    if isinstance(reference, Reference):
        return reference, 0.0
    return reference_from(reference) if isinstance(reference, Mapping) else read_reference(reference)
