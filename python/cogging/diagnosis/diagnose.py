"""`diagnose`: from logs and a model to a verdict, a better model, and what it is worth on other motion."""

from __future__ import annotations

import os
from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from cogging.calls import takes
from cogging.diagnosis.discrepancy import discrepancies, floor_of, follows, source_of
from cogging.diagnosis.evidence.given_logs import Logs, read_logs
from cogging.diagnosis.experiment.separating import separating
from cogging.diagnosis.naming.level_changes import CHANGED, changes, look_alikes
from cogging.diagnosis.naming.masking import masking_notes
from cogging.diagnosis.naming.names import changed, merged, named
from cogging.diagnosis.naming.verdict import unlisted, verdict
from cogging.diagnosis.patched import with_intervals
from cogging.diagnosis.residual.events import FRICTION_INTERVALS
from cogging.diagnosis.residual.location_words import shape_text
from cogging.diagnosis.result import Diagnosis, Gap, Step
from cogging.diagnosis.search.empirical import NoTerm, with_term
from cogging.diagnosis.search.levels import with_levels
from cogging.diagnosis.search.placebo import placebos
from cogging.diagnosis.search.search import LEFT_OVER, Added, Search, search
from cogging.estimation.whitening import NothingCounts
from cogging.log_check.audit import check_against_model
from cogging.log_check.controller import check_controller
from cogging.log_check.missing_rows import with_missing_rows
from cogging.log_check.recovery import recover_controller
from cogging.logs.log import Log
from cogging.logs.pauses import without_pauses
from cogging.logs.repeated_rows import counted_once, repeated, repeated_text
from cogging.logs.spikes import repaired, spikes
from cogging.model.model import Model
from cogging.model.parameters import parameters_of, with_values
from cogging.progress import Progress, steps
from cogging.simulation.arguments import LOGS, MODEL

SECONDS_MIN = 1.0  # of motion
ROWS_MIN = 500
WHERE = -7.0  # ln of the chance from which a coordinate is told


@takes(logs=LOGS, model=MODEL, confirm=LOGS)
def diagnose(
    logs: Logs,
    model: Model | str | os.PathLike[str],
    *,
    confirm: Logs = (),
    names: Sequence[str] | None = None,
    confirm_names: Sequence[str] | None = None,
    empirical: bool = False,
    progress: Progress = False,
) -> Diagnosis:
    """Find where logs and model disagree, name the missing effect, add it, and say what that is worth.

    The model is driven by the logged command and held to the readings by an observer; its innovations are made white
    and freed of all that re-tuning the model could explain. Every effect of the vocabulary is then tried at all its
    shapes, by what the simulator says it does. What stands in the logs, or in them and other motion (`confirm`)
    together, is added and refitted, up to four effects; what other motion refutes is not.

    Args:
        logs: one or several, or their files.
        model: what is believed, or its file.
        confirm: logs of other motion, which take no part in choice or fit.
            Rows that stand in several logs of one kind count once.
        names, confirm_names: what the logs are called in messages; their files by default.
        empirical: add what no effect explains to the model as a force of any shape, where it does not make the gap on
            the confirm logs larger. It is no effect of the vocabulary, and the result's gap is that without it.
        progress: True shows a line of what is being done, a function is told each step in words.

    Returns:
        Verdict, missing effects with confidence and parameters, and the patched model; print it to read them.

    Raises:
        ValueError: a log or model that cannot be used, or a confirm log with rows of a given one.
        InputError: a file that cannot be read.

    Example:
        >>> short = cogging.Log(log.time[:600], log.position[:600], log.command[:600])
        >>> result = cogging.diagnose(short, model)
        >>> print(result.verdict, result.notes[-1])
        insufficient_excitation the axis moves for ... s only: at rest, friction hides every force
    """
    if not isinstance(model, Model):
        model = Model.read(model)
    given, called = read_logs(logs, names)
    others, others_called = read_logs(confirm, confirm_names, "confirm log")
    if not given:
        raise ValueError("logs: must be at least 1, got 0")
    for name, log in zip((*called, *others_called), (*given, *others), strict=True):
        if len(log) < ROWS_MIN:
            raise ValueError(f"{name}: rows: must be at least {ROWS_MIN} to be diagnosed, got {len(log)}")
        check_against_model(log, model, name)
    given, called, others, others_called, repeats = _counted_once(given, called, others, others_called)
    notes: list[str] = list(repeats)
    given = [_without_pauses(log, name, notes) for log, name in zip(given, called, strict=True)]
    others = [_without_pauses(log, name, notes) for log, name in zip(others, others_called, strict=True)]
    model, replay, mismatch = _controller(given, model, notes)
    if mismatch is not None:
        return _mismatch(given, model, mismatch, notes)
    given = [_repaired(log, model, name, notes) for log, name in zip(given, called, strict=True)]
    others = [_repaired(log, model, name, notes) for log, name in zip(others, others_called, strict=True)]
    moving = sum(_seconds_of_motion(log) for log in given)
    if moving < SECONDS_MIN:
        notes.append(f"the axis moves for {moving:.2g} s only: at rest, friction hides every force")
        return _nothing("insufficient_excitation", given, model, notes)
    for name, log in zip(called, given, strict=True):
        if not np.any(log.command):
            raise ValueError(f"{name}: command: must act on an axis that moves, got 0 V in every row")
    with steps(progress, "diagnose") as begin:
        try:
            loops = replay and all(_obeys(log, model) for log in others)
            found = search(given, model, others, begin, loops)
        except NothingCounts as error:
            notes.append(str(error))
            return _nothing("insufficient_excitation", given, model, notes)
        begin("measuring the gap")
        result = _assemble(found, given, others, model, replay, notes)
    return _with_term(result, found, model, given, others) if empirical and result.unlisted is not None else result


def _with_term(result: Diagnosis, found: Search, model: Model, logs: Sequence[Log], others: Sequence[Log]) -> Diagnosis:
    """The result with an empirical term in its model, or with a note why there is none."""
    residual_shape = dict(result.unlisted or {})
    last = found.added[-1].model if found.added else found.tuned
    try:
        larger, told = with_term(found, residual_shape, last, logs, others)
    except NoTerm as why:
        return replace(result, notes=(*result.notes, str(why)))
    larger = with_intervals(_file_form(larger, model), found.estimate)
    return replace(result, model=larger, unlisted=residual_shape | {"added": told})


def _counted_once(
    given: list[Log], called: list[str], others: list[Log], others_called: list[str]
) -> tuple[list[Log], list[str], list[Log], list[str], tuple[str, ...]]:
    """Given and confirm logs with their names, rows that stand in several of a kind once, and what is said of that.

    Raises:
        ValueError: a confirm log has rows of a given one: it would confirm what was found in it.
    """
    for name, log in zip(others_called, others, strict=True):
        for first, one in zip(called, given, strict=True):
            rows = repeated(log, one)
            if rows.any():
                raise ValueError(
                    f"{name}: must be other motion than {first} to confirm anything, but {repeated_text(rows)} in it"
                )
    left, kept, said = counted_once(given, called, ROWS_MIN)
    others_left, others_kept, others_said = counted_once(others, others_called, ROWS_MIN)
    names = [name for name, rows in zip(called, kept, strict=True) if rows.any()]
    others_names = [name for name, rows in zip(others_called, others_kept, strict=True) if rows.any()]
    return left, names, others_left, others_names, (*said, *others_said)


def _without_pauses(log: Log, name: str, notes: list[str]) -> Log:
    """The log as it is searched: what a pause of a day would need is not laid out row by row."""
    try:
        running, said = without_pauses(log)
    except ValueError as error:
        raise ValueError(f"{name}: {error}") from None
    if said:
        notes.append(f"{name}: {said}")
    return running


def _repaired(log: Log, model: Model, name: str, notes: list[str]) -> Log:
    """The log without single values that nobody saw, and with the rows that it lacks: an observer rings after each."""
    check = check_controller(log, model)
    commands = np.zeros(len(log), dtype=bool)
    if check is not None and check.reproduces:
        commands[list(check.doubted_commands)] = True
    whole, said = repaired(log, spikes(log.position), commands)
    whole, also = with_missing_rows(whole, model)
    notes += [f"{name}: {text}" for text in (said, also) if text]
    return whole


def _seconds_of_motion(log: Log) -> float:
    """Time in which the mean speed over some rows is above a hundredth of the largest."""
    step = max(1, len(log) // 2000)
    steps, moved = np.diff(log.time[::step]), np.abs(np.diff(log.position[::step]))
    return float(steps[moved / steps > 0.01 * float((moved / steps).max())].sum())


def _controller(logs: Sequence[Log], model: Model, notes: list[str]) -> tuple[Model, bool, str | None]:
    """The model with the controller that the logs show, whether its loop can be replayed, and a contradiction."""
    if model.controller is None:
        found = [recover_controller(log) if log.reference is not None else None for log in logs]
        first = found[0]
        if first is None or any(one is None for one in found):
            return model, False, None
        notes.append(f"no controller is stated; the log shows a {first.type}, which is replayed")
        return model.replace(controller=first.parameters, controller_type=first.type), True, None
    replay = all(log.reference is not None for log in logs)
    for log in logs:
        check = check_controller(log, model)
        if check is None or check.reproduces is None:
            replay = False
            continue
        if check.reproduces is False:
            return (
                model,
                False,
                (f"the stated controller misses the logged command by {100 * (check.relative or 0.0):.1f} % rms"),
            )
        valid = bool(check.fitted) and min(check.fitted.values()) >= 0.0  # a motion may leave a gain to chance
        if (check.relative or 0.0) > 1e-3 and valid and model.controller is not None:
            fields = {k: v for k, v in check.fitted.items() if k in type(model.controller).FIELDS}
            notes.append(
                f"the stated controller reproduces the command to {100 * (check.relative or 0.0):.2g} %; the loop is "
                "replayed with the gains that fit: " + ", ".join(f"{k} {v:.5g}" for k, v in fields.items())
            )
            model = model.replace(controller=model.controller.replace(**fields))
    return model, replay, None


def _obeys(log: Log, model: Model) -> bool:
    check = check_controller(log, model) if log.reference is not None else None
    return check is not None and bool(check.reproduces)


def _nothing(verdict: str, logs: Sequence[Log], model: Model, notes: list[str]) -> Diagnosis:
    gap = Gap("V", 0.0, 0.0, 0.0, None, None, "not measured")
    return Diagnosis(verdict, (), None, gap, None, model, model, notes=tuple(notes))


def _mismatch(logs: Sequence[Log], model: Model, text: str, notes: list[str]) -> Diagnosis:
    notes.append(text + ": no model of the plant can help before that is settled")
    return _nothing("controller_mismatch", logs, model, notes)


def _assemble(
    found: Search, logs: Sequence[Log], others: Sequence[Log], model: Model, replay: bool, notes: list[str]
) -> Diagnosis:
    beyond = [change for change in changes(found, model) if abs(change[3]) > CHANGED]
    last = found.added[-1].model if found.added else found.tuned
    nominal, final = _file_form(found.tuned, model), _file_form(last, model)
    final = with_intervals(final, found.estimate)
    notes = [*notes, *masking_notes(nominal, final)]
    nominal = _as_stated(found, nominal, model, [f"axis.{change[0]}" for change in beyond])
    models = [nominal, *(_file_form(added.model, model) for added in found.added[:-1]), final]
    seen = discrepancies(logs, models, replay=replay)
    if replay and not follows(seen[-1], logs, final):
        replay = False
        seen = discrepancies(logs, models, replay=False)
        notes.append("the replayed loop does not follow the log closely enough to measure with: friction at reversals")
    loops = replay and all(_obeys(log, found.nominal.model) for log in others)
    confirmed = discrepancies(others, models, replay=loops) if others else None
    if confirmed and loops is not replay:
        notes.append("a confirm log does not obey the controller: its gap is that of an observer's innovations")
    floor = min(floor_of(seen[-1], logs, final), seen[-1].rms)
    gap = Gap(
        "V",
        floor,
        seen[0].rms,
        seen[-1].rms,
        confirmed[0].rms if confirmed else None,
        confirmed[-1].rms if confirmed else None,
        seen[0].signal,
        seen[0].position,
        seen[-1].position,
    )
    left = [
        shape
        for shape in found.residual_shapes
        if shape.log_p_value < LEFT_OVER and shape.coordinate != FRICTION_INTERVALS
    ]
    effects = merged([named(found, place, left) for place in range(len(found.added))])
    effects += [changed(change, look_alikes(found, model, change[0]), left) for change in beyond]
    residual_shape = unlisted(found, effects, checked=bool(others))
    alternatives = sorted({name for effect in effects for name in (effect.name, *effect.alternatives)})
    ambiguous = any(effect.alternatives for effect in effects)
    where = tuple(found.nominal_shapes)
    ledger = [
        Step(
            added.finding.name,
            True,
            _reason(added),
            added.finding.test.statistic,
            seen[i].rms,
            seen[i + 1].rms,
            confirmed[i].rms if confirmed else None,
            confirmed[i + 1].rms if confirmed else None,
        )
        for i, added in enumerate(found.added)
    ]
    ledger += [
        Step(finding.name, False, reason, finding.test.statistic, None, None, None, None)
        for finding, reason in found.refused
    ]
    return Diagnosis(
        verdict=verdict(effects, residual_shape),
        effects=tuple(effects),
        unlisted=residual_shape,
        gap=gap,
        separating_experiment=separating(alternatives, logs) if ambiguous else None,
        model=final,
        nominal=nominal,
        where=where,
        where_text=tuple(shape_text(shape) for shape in where if shape.log_p_value < WHERE),
        ledger=tuple(ledger),
        notes=tuple(notes),
        placebo=placebos(found),
        series={
            "logs": list(logs),
            "given": model,
            "time": [log.time for log in logs],
            "gap_before": seen[0].series,
            "gap_after": seen[-1].series,
            "mask": seen[0].masks,
            "position": [log.position for log in logs],
            "velocity": [source.along.velocity for source in found.nominal_evidence.sources],
        },
    )


def _file_form(fitted: Model, model: Model) -> Model:
    """The fitted model with the sections of the given one."""
    return fitted.replace(uncertainty=dict(model.uncertainty), controller=model.controller)


def _as_stated(found: Search, nominal: Model, model: Model, held: Sequence[str]) -> Model:
    """The nominal model with what was found to have changed as the given model states it, and the rest re-tuned."""
    if not held:
        return nominal
    values = {path: parameters_of(model)[path].value for path in held}
    paths = [path for path in found.nominal.paths if path not in held]
    sources = [source_of(source.log, nominal) for source in found.nominal_evidence.sources]
    return _file_form(with_levels(with_values(nominal, values), paths, sources), model)


def _reason(added: Added) -> str:
    check = added.confirmation
    if check is None:
        return "no other motion to confirm it"
    if check.confirmed:
        return f"other motion shows {check.ratio:.2f} +- {check.deviation:.2f} of what was foreseen"
    return f"the other motion cannot show it (lambda {check.noncentrality:.1f})"
