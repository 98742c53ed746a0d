"""From trials to what is told of them: the best on fresh machines, the trade-off, and why there may be none."""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import Any, NamedTuple

import numpy as np

from cogging.design.tuning.gains import Gain, Tuned
from cogging.design.tuning.limits import Limit
from cogging.design.tuning.margins import Push
from cogging.design.tuning.reached import INDEXES, Judge
from cogging.design.tuning.trials import RULE, Trial, best_of, failures_of, front_of, nearest_of, some_of
from cogging.design.tuning.tuning import Setting, Tuning
from cogging.model.units import Units
from cogging.progress import Progress, steps

FRONT = ("error_rms", "command_max", "command_chatter")  # of each point of the trade-off
FRONT_MOST = 8  # points whose margins are measured
AT_END = 0.01  # of a range, or of its logarithm: so near its end a gain counts as at it


class Task(NamedTuple):
    """All that a tuning needs while it runs.

    Attributes:
        tuned: the gains.
        limits: that must be kept.
        judge: of the machines that are tuned with.
        held_out: of those that are not.
        push: by which margins are measured.
        present: the present gains, as a trial.
        against: the index of the trade-off.
        notes: what is to be said besides.
        units: labels of the model's units.
    """

    tuned: Tuned
    limits: tuple[Limit, ...]
    judge: Judge
    held_out: Judge
    push: Push
    present: Trial
    against: str
    notes: list[str]
    units: Units


def result_of(task: Task, found: list[Trial], shown: Mapping[str, Any], progress: Progress) -> Tuning:
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
    table = _table(task, found)
    front = {name: table[name][places] for name in dict.fromkeys((*FRONT, *task.tuned.present, task.against))}
    front |= {"trial": np.array(places, dtype=int), "delay_margin": np.array(margins, dtype=float)}
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
        units=task.units,
        **shown,
    )


def _table(task: Task, found: list[Trial]) -> dict[str, Any]:
    """The trials as arrays; indexes that not every trial has are left out."""
    table: dict[str, Any] = {path: np.array([trial.gains[path] for trial in found]) for path in task.tuned.present}
    for name in ("error_rms", *INDEXES):
        numbers = [getattr(trial.reached, name) for trial in found]
        if all(number is not None for number in numbers):
            table[name] = np.array(numbers, dtype=float)
    return table | {"kept": np.array([trial.kept for trial in found], dtype=bool)}


def _setting(task: Task, trial: Trial) -> Setting:
    drawn = task.judge.with_margins(trial.gains, trial.reached, task.push)
    fresh = task.held_out.with_margins(trial.gains, task.held_out.run(trial.gains), task.push)
    return Setting(dict(trial.gains), drawn, fresh)


def _why_none(task: Task, found: list[Trial]) -> list[str]:
    """Which limit failed most, and by how much."""
    nearest = nearest_of([task.present, *found])
    failures = failures_of(found, [limit.name for limit in task.limits])
    name = max(failures, key=lambda one: failures[one])
    count, least = failures[name]
    by = f"at best by {100 * least:.3g} %" if least > 0.0 else "none in all of them at once"
    notes = [f"no trial keeps all limits; the one that failed most is {name}: in {count} of {len(found)} trials, {by}"]
    gains = ", ".join(f"{path} = {value:.4g}" for path, value in nearest.gains.items())
    if RULE in nearest.excess:
        return [*notes, f"nearest is {gains}: they break a rule of the controller"]
    reached = task.judge.with_margins(nearest.gains, nearest.reached, task.push)
    broken = [limit.text(getattr(reached, limit.name)) for limit in task.limits if nearest.excess[limit.name] > 0.0]
    if reached.failed:
        broken.append(f"{reached.failed} of {len(task.judge.machines)} machines do not come to their end")
    return [*notes, f"nearest is {gains}: {'; '.join(broken)}"]


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
