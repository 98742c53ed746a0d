"""Gains of a controller for an uncertain machine: the smallest rms error within limits on command and robustness."""

from __future__ import annotations

import math
import os
from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager
from typing import Any, NamedTuple

import numpy as np

from cogging._core import Reference
from cogging.calls import Kind, did_you_mean, takes
from cogging.design.tuning.gains import Tuned, tuned_of_function, tuned_of_model
from cogging.design.tuning.limits import ALL_END, asked_limits, excesses, limits_of
from cogging.design.tuning.machines import machines_of, variations_of
from cogging.design.tuning.margins import Push, push_of
from cogging.design.tuning.reached import INDEXES, MARGINS, Course, Judge, Reached
from cogging.design.tuning.trials import RULE, KeptTrials, Trial, best_of, optuna, run_trials
from cogging.design.tuning.tuned_result import Task, result_of
from cogging.design.tuning.tuning import Tuning
from cogging.files import FieldError
from cogging.model.controller import AnyController
from cogging.model.model import Model
from cogging.progress import Progress, steps
from cogging.resources import on_one_blas_thread
from cogging.shown import quoted
from cogging.simulation.arguments import MODEL, REFERENCE
from cogging.simulation.digests import digest_of
from cogging.simulation.reference import read_reference, reference_from, reference_to_dict
from cogging.simulation.varied import BOUNDS, Setup

CHATTER = "command_chatter"  # what rms error is traded against where nothing else is asked for
MOST = 1_000_000
CONTROLLER = Kind((Callable, type(None)), "a function that makes a controller of gains")  # type: ignore[arg-type]
TABLE = Kind((Mapping, type(None)), "a table of gains by path")


class Asked(NamedTuple):
    """The numbers of a call."""

    machines: int
    held_out: int
    trials: int
    seed: int
    quantile: float
    against: str | None


@takes(model=MODEL, reference=REFERENCE, gains=TABLE, controller=CONTROLLER)
@on_one_blas_thread(scipy=True)
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
        limits: by name a number, or `{"present": 1.1}` for 1.1 times what the present gains reach; at most of
            error_max, command_max, command_rms, command_chatter, at least of delay_margin, gain_margin, modulus_margin.
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
    asked = Asked(machines, held_out, trials, seed, quantile, against)
    _require_numbers(asked)
    model = model if isinstance(model, Model) else Model.read(model)
    motion, own_duration = _motion(reference)
    setup = Setup(model, motion)
    tuned = tuned_of_model(model, motion, gains) if controller is None else tuned_of_function(controller, gains)
    course = Course(duration or own_duration, start, stop, quantile, threads)
    limited = asked_limits(limits or {})
    task = _task(setup, tuned, course, vary, limited, asked)
    digest = digest_of(model, _described(setup, tuned, course, vary, limited, asked)) if controller is None else None
    kept = None if out is None or digest is None else KeptTrials(out, digest)
    result = _run(task, asked, out, kept, progress)
    if out is not None and result.model is not None:
        result.model.write(out)
    if kept is not None:
        kept.remove()
    return result


def _task(setup: Setup, tuned: Tuned, course: Course, vary: Any, limited: Mapping[str, Any], asked: Asked) -> Task:
    """Draw the machines, and judge the present gains."""
    variations, notes = variations_of(setup, vary)
    drawn, fresh = (
        machines_of(setup, variations, count, asked.seed, stream)
        for stream, count in enumerate((asked.machines, asked.held_out))
    )
    judge, other = Judge(drawn, tuned, course), Judge(fresh, tuned, course)
    present, push = _present(judge, tuned, setup.reference, course)
    limits = limits_of(limited, present, setup.model.units)
    first = Trial(tuned.present, present, excesses(limits, tuned.present, present, judge, push))
    return Task(tuned, limits, judge, other, push, first, asked.against or CHATTER, notes, setup.model.units)


def _present(judge: Judge, tuned: Tuned, motion: Reference, course: Course) -> tuple[Reached, Push]:
    """What the present gains reach, with all margins, and the push that was used for them."""
    gains = tuned.present
    reached = judge.run(gains)
    command = reached.command_max if math.isfinite(reached.command_max) else 0.0
    if command == 0.0:
        command = judge.machines[0].setup.model.axis.mass  # of 1 m/s^2: a loop that fails has no command to go by
    push = push_of(motion, judge.controller(gains).sample_rate, course.duration, command)
    return judge.with_margins(gains, reached, push), push


def _run(task: Task, asked: Asked, out: Any, kept: KeptTrials | None, progress: Progress) -> Tuning:
    """All trials, and what comes of them."""
    found: list[Trial] = []
    with _best_in_the_end(task, found, out, kept):
        with steps(progress, "tune", asked.trials) as step:
            judged = _judge_of(task, asked.against)
            how = (asked.trials, asked.seed, asked.against)
            for trial in run_trials(task.tuned.gains, *how, judged, kept, step, task.units.of("um")):
                found.append(trial)  # one by one, so that they stand when the next is ended
        return result_of(task, found, {"quantile": asked.quantile, "seed": asked.seed}, progress)


@contextmanager
def _best_in_the_end(task: Task, found: list[Trial], out: Any, kept: KeptTrials | None) -> Iterator[None]:
    """Where a tuning is ended before its time, let its trials stand, and write the best so far."""
    try:
        yield
    except BaseException:
        if kept is not None:
            kept.write()
        best = best_of([task.present, *found])
        better = task.tuned.model(best.gains) if best is not None and best is not task.present else None
        if out is not None and better is not None:
            better.write(out)
        raise


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


def _described(
    setup: Setup, tuned: Tuned, course: Course, vary: Any, limited: Mapping[str, Any], asked: Asked
) -> dict[str, Any]:
    """What decides a trial beside the model, but for how many there are."""
    return {
        "reference": reference_to_dict(setup.reference),
        "gains": [list(vars(gain).values()) for gain in tuned.gains],
        "vary": dict(vary) if isinstance(vary, Mapping) else vary,
        "limits": dict(limited),
        "course": list(course._replace(threads=0)),
        "asked": list(asked._replace(trials=0, held_out=1)),
    }


def _require_numbers(asked: Asked) -> None:
    for name, least in (("machines", 1), ("held_out", 1), ("trials", 1), ("seed", 0)):
        value = getattr(asked, name)
        if isinstance(value, bool) or not isinstance(value, int | np.integer) or not least <= value <= MOST:
            raise FieldError("", name, f"must be a whole number from {least} to {MOST}, got {value!r}")
    if not isinstance(asked.quantile, int | float) or not 0.0 < asked.quantile <= 1.0:
        raise FieldError("", "quantile", f"must be above 0, at most 1, got {asked.quantile!r}")
    if asked.against is not None and asked.against not in INDEXES:
        raise FieldError(
            "", "against", f"is none: {quoted(asked.against)}; {did_you_mean(str(asked.against), INDEXES)}"
        )


def _motion(reference: Any) -> tuple[Reference, float]:
    if isinstance(reference, Reference):
        return reference, 0.0
    return reference_from(reference) if isinstance(reference, Mapping) else read_reference(reference)
