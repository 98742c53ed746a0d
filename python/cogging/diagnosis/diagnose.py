"""`diagnose`: from logs and a model to a verdict, a better model, and what it is worth on other motion."""

from __future__ import annotations

import os
from collections.abc import Mapping, Sequence
from dataclasses import replace

import numpy as np

from cogging._core import DivergedError
from cogging.blas_threads import on_one_blas_thread
from cogging.calls import takes
from cogging.diagnosis.assembly import assemble, with_empirical_term
from cogging.diagnosis.candidates.signatures import vocabulary_of
from cogging.diagnosis.entries import Gap
from cogging.diagnosis.evidence.given_logs import Logs
from cogging.diagnosis.evidence.preparation import Prepared, prepared, whole_logs
from cogging.diagnosis.evidence.running_controller import obeys, running_controller
from cogging.diagnosis.labelled import labelled
from cogging.diagnosis.limits import unmeasured
from cogging.diagnosis.physical import seconds_of_motion
from cogging.diagnosis.result import Diagnosis
from cogging.diagnosis.search.search import search
from cogging.diagnosis.thresholds import PREPARATION
from cogging.effects.custom import Custom, by_name, refuse_two_of_one_name
from cogging.effects.effect import Effect
from cogging.estimation.whitening import NothingCounts
from cogging.identification.misreading.misreading import misreading
from cogging.memory import require_rows
from cogging.model.model import Model
from cogging.model.units import Units
from cogging.progress import Progress, steps
from cogging.simulation.arguments import LOGS, MODEL

#: Parts of a result that write in their model's or their plan's units by themselves, or have no words.
IN_THEIR_OWN_UNITS = ("location", "series", "vocabulary")


@takes(logs=LOGS, model=MODEL, confirm=LOGS)
@np.errstate(all="ignore")  # what wild numbers lead to is refused, not warned of
@on_one_blas_thread(scipy=True)
def diagnose(
    logs: Logs,
    model: Model | str | os.PathLike[str],
    *,
    confirm: Logs = (),
    names: Sequence[str] | None = None,
    confirm_names: Sequence[str] | None = None,
    empirical: bool = False,
    also: Sequence[Custom] = (),
    progress: Progress = False,
) -> Diagnosis:
    """Find where logs and model disagree, name the missing effect, add it, and say what that is worth.

    The model is driven by the logged command and held to the readings by an observer; its innovations are made white
    and freed of all that re-tuning the model could explain. Every effect of the vocabulary is then tried at all its
    shapes, by what the simulator says it does. What stands in the logs, or in them and other motion (`confirm`)
    together, is added and refitted, up to four effects; what other motion refutes is not.

    Args:
        logs: one log or several, or their files.
        model: model that is held against them, or its file.
        confirm: logs of other motion, which take no part in choice or fit.
            Rows that stand in several logs of one kind count once.
        names, confirm_names: names of the logs in messages; their files by default.
        empirical: whether to add what no effect explains to the model as a force of any shape, where it does not make
            the gap on the confirm logs larger. It is no effect of the vocabulary; the result's gap is that without it.
        also: effects of your own (cogging.effects.Custom) that are tried beside the vocabulary: what stands of them
            bears their names.
        progress: True shows a line of what is being done, a function is told each step in words.

    Returns:
        Verdict, missing effects with confidence and parameters, and the patched model; print it to read them.

    Raises:
        ValueError: a log or model that cannot be used, `also` with two effects of one name, or a confirm log with rows
            of a given one.
        InputError: a file that cannot be read.

    Example:
        >>> short = cogging.Log(log.time[:600], log.position[:600], log.command[:600])
        >>> result = cogging.diagnose(short, model)
        >>> print(result.verdict, result.notes[-1])
        insufficient_excitation the axis moves for ... s only: at rest, friction hides every force
    """
    model, vocabulary = _with_vocabulary(model, also)
    ready = prepared(logs, model, confirm, names, confirm_names)
    require_rows("diagnose", [*ready.given, *ready.confirm])
    told = _diagnosed(ready, model, vocabulary, empirical=empirical, progress=progress)
    return labelled(told, model.units, [*ready.names, *ready.confirm_names], apart=IN_THEIR_OWN_UNITS)


def _diagnosed(
    ready: Prepared,
    model: Model,
    vocabulary: Mapping[str, Effect],
    *,
    empirical: bool,
    progress: Progress,
) -> Diagnosis:
    """The result in V and m."""
    if (misread := misreading([*ready.given, *ready.confirm], model, [*ready.names, *ready.confirm_names])) is not None:
        return replace(_unmeasured("data_mismatch", model, ready.notes, vocabulary), mismatch=misread.to_dict())
    running = running_controller(ready.given, model)
    model, notes = running.model, (*ready.notes, *running.notes)
    if running.contradiction is not None:
        notes = (*notes, f"{running.contradiction}: no model of the plant can help before that is settled")
        return _unmeasured("controller_mismatch", model, notes, vocabulary)
    ready = whole_logs(replace(ready, notes=notes), model)
    moving = sum(seconds_of_motion(log) for log in ready.given)
    if moving < PREPARATION.motion_min:
        rest = f"the axis moves for {moving:.2g} s only: at rest, friction hides every force"
        return _unmeasured("insufficient_excitation", model, (*ready.notes, rest), vocabulary)
    _require_commands(ready, model.units)
    with steps(progress, "diagnose") as begin:
        try:
            loops = running.replay and all(obeys(log, model) for log in ready.confirm)
            found = search(ready.given, model, ready.confirm, begin, loops, vocabulary=vocabulary)
        except NothingCounts as error:
            return _unmeasured("insufficient_excitation", model, (*ready.notes, str(error)), vocabulary)
        except DivergedError as error:
            raise DivergedError("; ".join((str(error), *ready.notes))) from None
        begin("measuring the gap")
        result = assemble(found, ready, model)
    wanted = empirical and result.unlisted is not None
    return with_empirical_term(result, found, model, ready) if wanted else result


def _with_vocabulary(model: Model | str | os.PathLike[str], also: Sequence[Custom]) -> tuple[Model, dict[str, Effect]]:
    """The model, and all effects that are tried by name, as they are when they do nothing.

    Raises:
        ValueError: two effects of one name.
        InputError: the model's file cannot be read.
    """
    own = by_name(also)
    if not isinstance(model, Model):
        model = Model.read(model, effects=list(own.values()))
    refuse_two_of_one_name([*own.values(), *model.effects])
    return model, vocabulary_of(model, [effect.neutral() for effect in own.values()])


def _require_commands(logs: Prepared, units: Units) -> None:
    """Refuse a log of an axis that moves without a command."""
    for name, log in zip(logs.names, logs.given, strict=True):
        if not np.any(log.command):
            raise ValueError(f"{name}: command: must act on an axis that moves, got 0 {units.command} in every row")


def _unmeasured(verdict: str, model: Model, notes: Sequence[str], vocabulary: Mapping[str, Effect]) -> Diagnosis:
    """A verdict that comes before anything can be measured."""
    gap = Gap("V", 0.0, 0.0, 0.0, None, None, "not measured")
    limits = unmeasured(vocabulary)
    return Diagnosis(verdict, (), None, gap, None, model, model, notes=tuple(notes), limits=limits)
