"""`diagnose`: compare logs with a model, name the missing effects, and patch the model."""

from __future__ import annotations

import os
from collections.abc import Mapping, Sequence
from dataclasses import replace
from typing import Any

import numpy as np

from cogging._core import DivergedError
from cogging.calls import check_arguments
from cogging.diagnosis.balance.decision import Outcome, search
from cogging.diagnosis.balance.evidence import LARGEST_CHANGE, TooLittleMotion
from cogging.diagnosis.detection_limits import limits, unmeasured
from cogging.diagnosis.diagnosis_result import Diagnosis
from cogging.diagnosis.entries import Gap, Limit, Step
from cogging.diagnosis.generic_force import predicted
from cogging.diagnosis.locate import location_of
from cogging.diagnosis.named_effects import final_verdict, named, unlisted
from cogging.diagnosis.patched_model import Term, merged, paths_without, terms_of, with_intervals, without
from cogging.diagnosis.physical import AT_END, seconds_of_motion, unphysical
from cogging.diagnosis.places import empirical_term
from cogging.diagnosis.preparation import Logs, Prepared, prepared, whole_logs
from cogging.diagnosis.running_controller import running_controller
from cogging.diagnosis.separating import separating
from cogging.diagnosis.yardstick import Discrepancy, Yardstick, growth, replayable
from cogging.effects.custom import Custom, by_name, refuse_two_of_one_name
from cogging.effects.effect import VOCABULARY, Effect
from cogging.identification.misreading import misreading
from cogging.log_check.log_audit import SLOW
from cogging.model.model import Model
from cogging.model.parameters import renamed_path
from cogging.model.units import Units
from cogging.progress import Progress, steps
from cogging.resources import on_one_blas_thread, on_threads, require_rows
from cogging.simulation.arguments import LOGS, MODEL

MOTION_MIN = 1.0  # s: minimum time in motion, over all given logs
NOISE = 0.01  # of a gap's power: where a generic force predicts less, the replayed loop leaves only noise
CONTRADICTED = 1.25  # largest growth of a gap's power with all effects, or with one effect by replay
LOUD = 0.5  # of the rms command: noise of the balance that hides what moves the axis
FOLLOWED = 3.0  # noise floors: a replay with a larger gap does not follow the logs


@check_arguments(logs=LOGS, model=MODEL, confirm=LOGS)
@np.errstate(all="ignore")  # invalid values are rejected, not warned about
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
    """Find where logs and model disagree, name the missing effects, and add them to the model.

    The residual of the force balance along the measured motion is whitened and made orthogonal to everything that
    re-tuning the model could explain. Each effect of the vocabulary is then tried at all its shapes. An effect is
    added if the given and confirm logs together support it and neither contradicts it. The gap before and after is
    measured by replaying the closed loop if its controller is known, otherwise by the force balance.

    Args:
        logs: one log or several, or their files.
        model: model to compare with the logs, or its file.
        confirm: logs of other motion; an effect that they contradict is not added. Rows that occur in several logs
            count once.
        names, confirm_names: names of the logs in messages; their files by default.
        empirical: whether to add an unexplained force to the model as an empirical term, if it makes the gap smaller
            on given and confirm logs. The gap of the result excludes this term.
        also: user-defined effects (cogging.effects.Custom) to try beside the vocabulary.
        progress: True shows a progress line; a function receives the name of each step.

    Returns:
        Verdict, missing effects with confidence and parameters, and the patched model; print it to read them.

    Raises:
        ValueError: a log or the model is invalid, `also` has two effects of one name, or a confirm log shares rows
            with a given log.
        InputError: a file cannot be read.

    Example:
        >>> short = cogging.Log(log.time[:600], log.position[:600], log.command[:600])
        >>> result = cogging.diagnose(short, model)
        >>> print(result.verdict, result.notes[-1])
        insufficient_excitation the axis moves for only ... s: at rest, friction hides every force
    """
    own = by_name(also)
    if not isinstance(model, Model):
        model = Model.read(model, effects=list(own.values()))
    refuse_two_of_one_name([*own.values(), *model.effects])
    vocabulary = VOCABULARY | {name: effect.neutral() for name, effect in own.items()}
    ready = prepared(logs, model, confirm, names, confirm_names)
    require_rows("diagnose", [*ready.given, *ready.confirm])
    called = [*ready.names, *ready.confirm_names]
    if (misread := misreading([*ready.given, *ready.confirm], model, called)) is not None:
        return _unmeasured("data_mismatch", model, ready.notes, vocabulary, misread.to_dict())
    running = running_controller(ready.given, model)
    model, notes = running.model, (*ready.notes, *running.notes)
    if running.contradiction is not None:
        notes = (*notes, f"{running.contradiction}: resolve this before diagnosing the plant")
        return _unmeasured("controller_mismatch", model, notes, vocabulary)
    ready = whole_logs(replace(ready, notes=notes), model)
    moving = sum(seconds_of_motion(log) for log in ready.given)
    if moving < MOTION_MIN:
        rest = f"the axis moves for only {moving:.2g} s: at rest, friction hides every force"
        return _unmeasured("insufficient_excitation", model, (*ready.notes, rest), vocabulary)
    if any(np.median(np.diff(log.time)) > SLOW for log in ready.given):  # a note says how far apart
        return _unmeasured("insufficient_excitation", model, ready.notes, vocabulary)
    for name, log in zip(ready.names, ready.given, strict=True):
        if not np.any(log.command):
            unit = model.units.command
            raise ValueError(f"{name}: command: must act on an axis that moves, got 0 {unit} in every row")
    with steps(progress, "diagnose") as begin:
        begin("searching for missing effects")
        try:
            found = search(ready.given, ready.confirm, model, own)
        except TooLittleMotion as error:
            return _unmeasured("insufficient_excitation", model, (*ready.notes, str(error)), vocabulary)
        begin("measuring the gap")
        replay = running.replay and replayable(ready.given, ready.confirm, model)
        return _result(found, ready, model, vocabulary, replay=replay, wanted=empirical)


def _unmeasured(
    verdict: str,
    model: Model,
    notes: Sequence[str],
    vocabulary: Mapping[str, Effect],
    mismatch: Mapping[str, Any] | None = None,
) -> Diagnosis:
    """Return a result with a verdict that was reached before the search."""
    gap = Gap(model.units.command, 0.0, 0.0, 0.0, None, None, "not measured")
    unseen = _labelled(unmeasured(vocabulary), model.units)
    more: dict[str, Any] = {"notes": tuple(notes), "vocabulary": vocabulary, "limits": unseen, "mismatch": mismatch}
    return Diagnosis(verdict, (), None, gap, None, model, model, **more)


def _labelled(known: Mapping[str, Limit], units: Units) -> dict[str, Limit]:
    """Return the limits with the unit labels of the model."""
    return {name: replace(limit, unit=units.of(limit.unit)) for name, limit in known.items()}


def _result(
    found: Outcome, logs: Prepared, stated: Model, vocabulary: Mapping[str, Effect], *, replay: bool, wanted: bool
) -> Diagnosis:
    """Decide which effects enter the model, measure the gaps, and assemble the result of a search."""
    units, notes = stated.units, list(logs.notes)
    yardstick = Yardstick(found, logs.given, logs.confirm, stated, replay)
    whole, terms = terms_of(found, stated)
    nominal = found.nominal.settled(found.nominal.model)

    # 1. exclude terms; measure the gaps of the re-tuned model, the patched model and the latter less each family
    held_out, refused = _objections(terms, whole, logs, stated)
    families = [[k for k, term in enumerate(terms) if term.accepted is one] for one in found.accepted]
    families = [family for family in families if terms[family[0]].path and not set(family) <= {*held_out, *refused}]
    harmed = True
    while harmed:
        gone = [terms[k] for k in {**held_out, **refused}]
        less = [without(whole, terms, [*gone, *(terms[k] for k in family)], found) for family in families]
        models = [nominal, without(whole, terms, gone, found) if terms else nominal, *less]
        replayed, doubt = _replayed(yardstick, models) if replay else (None, "")
        shown = replayed is not None and not any(one and two and growth(one, two) for one, two, *_ in replayed)
        given, confirm = replayed if replayed is not None and shown else _gaps(yardstick.by_balance(), models)
        harm, why = _harm(given, confirm, units)
        if harmed := any(harm):
            worst = int(np.argmax(harm))
            held_out |= dict.fromkeys(set(families.pop(worst)) - {*held_out, *refused}, why[worst])
    if replayed is not None and not families:
        given, confirm = replayed
    elif replay and not shown:
        notes.append(f"{doubt}: the gap is that of the force balance")
        yardstick = yardstick.by_balance()
    noise = replayed is not None and bool(held_out) and predicted(replayed[0][0], replayed[1][0]).share < NOISE
    contradicted = held_out if noise else {}  # the replayed loop agrees with the model without these terms
    out = {**held_out, **refused}
    enters = any(term.path and place not in out for place, term in enumerate(terms))
    before, before_there = given[0], confirm[0]
    if logs.confirm and before_there is None:
        notes.append("the encoder resolves too little motion in the confirm logs: they confirm nothing")
    read = _as_read(yardstick, stated)
    if read is not None and read.rms < before.rms:  # discard re-tuning that makes the gap larger
        nominal, before, before_there = stated, read, yardstick.on_confirm(stated)
    names = paths_without(whole, {terms[k].path for k in out})
    final = with_intervals(models[1], found.evidence, whole, names) if enters else nominal
    terms = [replace(term, path=renamed_path(term.path, names)) for term in terms]
    after, after_there = (given[1], confirm[1]) if enters else (before, before_there)
    ends = [(one, two) for one, two in ((before, after), (before_there, after_there)) if one and two]
    if any(two.rms**2 > CONTRADICTED * one.rms**2 for one, two in ends):
        notes.append("all effects together make the gap larger: the model is left without them")
        final, after, after_there = nominal, before, before_there
        out |= {k: "all effects together make the gap larger" for k in range(len(terms)) if k not in out}

    # 2. the remaining gap, the named effects and the unlisted force
    rest = predicted(after, after_there)
    rms = after.rms_of("command")
    gap = Gap(
        units.command,
        min(rest.noise, after.rms),
        before.rms,
        after.rms,
        None if before_there is None else before_there.rms,
        None if after_there is None else after_there.rms,
        before.signal,
        before.position,
        after.position,
        None if read is None else read.rms,
        after.rms / rms if rms > 0.0 else None,
        rest.elsewhere,
    )
    # the closed part of the gap is shared by the power of the forces; what stands beside the model takes its own
    closed = 1.0 - (after.rms / before.rms) ** 2 if before.rms else 0.0
    power = sum(term.force**2 for k, term in enumerate(terms) if term.path and k not in out)
    shares = [
        None
        if k in out or not before.rms
        else max(closed, 0.0) * term.force**2 / max(power, 1e-300)
        if term.path
        else min((term.force / before.rms) ** 2, 1.0)
        for k, term in enumerate(terms)
    ]
    kept = [k for k in range(len(terms)) if k not in refused and k not in contradicted]
    left_out = {kept.index(k): why for k, why in out.items() if k in kept}
    effects = named([terms[k] for k in kept], final, found.evidence, [shares[k] for k in kept], left_out)
    without_name = unlisted([terms[k] for k in kept], rest, gap, units, confirmed=before_there is not None)
    if without_name is None and refused and not effects:
        first = terms[min(refused)]
        without_name = _refused_entry(first, refused[min(refused)])
    if wanted and without_name is not None:
        final, without_name = _with_empirical(final, without_name, yardstick, after, after_there)
    zero = f"the phase of a wave shows that the zero of the confirm logs is {found.shift:.4g} {units.position} off"
    late = f"the command is logged {found.late:.2g} s after it acts, which is corrected here"
    loud = (
        f"the balance has a noise of {gap.floor:.3g} {units.command} for a command of {rms:.3g}: it hides small effects"
    )
    said = ((found.shift, zero), (found.late, late), (gap.floor > LOUD * rms > 0.0, loud))
    notes += [note for holds, note in said if holds]
    notes += [f"{terms[k].accepted.found.name}: {why}; it is not in the model" for k, why in sorted(out.items())]
    final, of_stated = merged(final, stated)
    notes += of_stated
    untouched = yardstick.by_balance().on_given(found.nominal.model)
    location = location_of(found.nominal, untouched, predicted(untouched))
    alike = sorted({name for one in effects if one.alternatives for name in (one.name, *one.alternatives)})
    return Diagnosis(
        final_verdict(effects, without_name),
        tuple(effects),
        without_name,
        gap,
        separating(alike, vocabulary, logs.given) if alike else None,
        final,
        nominal,
        location,
        tuple(location.lines()),
        tuple(_ledger(terms, families, out, given, confirm, found)),
        tuple(notes),
        before.columns
        | {"gap_before": before.series, "gap_after": after.series, "mask": before.masks, "given": stated},
        vocabulary,
        _labelled(limits(found, vocabulary), units),
    )


Gaps = tuple[list[Discrepancy], list[Discrepancy | None]]  # of given and confirm logs, one per model


def _gaps(yardstick: Yardstick, models: Sequence[Model]) -> Gaps:
    """Return the gaps of each model on given and confirm logs."""
    quiet = np.errstate(all="ignore")  # each thread has its own
    return on_threads(quiet(yardstick.on_given), models), on_threads(quiet(yardstick.on_confirm), models)


def _replayed(yardstick: Yardstick, models: Sequence[Model]) -> tuple[Gaps | None, str]:
    """Return the gaps by replay of the loop, or None if the replay fails, and a clause with the reason."""
    try:
        gaps = _gaps(yardstick, models)
    except (DivergedError, ValueError) as error:
        return None, str(error)
    followed = min(one.rms for one in gaps[0]) <= FOLLOWED * max(predicted(gaps[0][1]).noise, 1e-300)
    does = "show these effects" if followed else "follow the logs closely enough"
    return gaps if followed else None, f"the replayed loop does not {does}"


def _objections(
    terms: Sequence[Term], whole: Model, logs: Prepared, stated: Model
) -> tuple[dict[int, str], dict[int, str]]:
    """Return by index why a term of the re-tuned model is uncertain, and why another is unphysical."""
    named = {place: term for place, term in enumerate(terms) if not term.accepted.found.name.startswith("~")}
    refused: dict[int, str] = {}
    for place, term in named.items():
        factor = whole.axis.mass / stated.axis.mass
        if term.path == "axis.mass" and abs(np.log(factor)) > np.log(LARGEST_CHANGE) - AT_END:
            refused[place] = f"the mass would be {factor:.3g} of its stated value"
        if term.effect is not None and (why := unphysical(stated.replace(effects=[term.effect]), 0, logs.given)):
            refused[place] = why
    uncertain = {place for place, term in named.items() if not term.certain and place not in refused}
    return dict.fromkeys(uncertain, "its interval includes zero"), refused


def _harm(
    given: Sequence[Discrepancy], confirm: Sequence[Discrepancy | None], units: Units
) -> tuple[list[float], list[str]]:
    """Return the relative growth of the gap's power with each family (0 within chance), and a clause on it.

    Args:
        given: gaps of the nominal model, the patched one and the latter without each family.
        confirm: the same of the confirm logs. On the given logs, an inexact friction law lets the gap grow by chance.
        units: labels.
    """
    count = len(given) - 2
    harm, why = [0.0] * count, [""] * count
    for which, (_, full, *less) in (("", given), (" on the other motion", confirm)):
        for place, one in enumerate(less):
            if one is None or full is None:
                continue
            more = (full.rms**2 - one.rms**2) / max(one.rms**2, 1e-300)
            harmful = growth(one, full) if which else more > CONTRADICTED - 1.0
            if harmful and more > harm[place]:
                change = f"({full.signal}) grows from {one.rms:.4g} to {full.rms:.4g} {units.command}"
                harm[place], why[place] = more, f"with it the gap{which} {change}"
    return harm, why


def _as_read(yardstick: Yardstick, stated: Model) -> Discrepancy | None:
    """Return the gap of the stated model on the given logs, or None if its replay fails."""
    try:
        return yardstick.on_given(stated)
    except (DivergedError, ValueError):
        return None


def _refused_entry(term: Term, why: str) -> dict[str, Any]:
    """Return the `unlisted` entry of an unphysical effect."""
    found = term.accepted.found
    return {
        "coordinate": "position" if term.curve is None else str(term.curve["coordinate"]),
        "shape": f"the force is most like {found.name.replace('_', ' ')}, but {why}",
        "share": None,
        "statistic": float(term.accepted.score),
        "confirmed": None,
    }


def _with_empirical(
    final: Model, entry: Mapping[str, Any], yardstick: Yardstick, after: Discrepancy, there: Discrepancy | None
) -> tuple[Model, dict[str, Any]]:
    """Return the model with an empirical force if that makes the gap smaller, and the entry with its gaps."""
    term = empirical_term(entry)
    if term is None:
        note = f"no empirical term depends on {entry['coordinate']} alone: it is described, not added"
        return final, dict(entry) | {"not_added": note}
    larger = final.replace(effects=(*final.effects, term))
    try:
        with_it, with_it_there = yardstick.on_given(larger), yardstick.on_confirm(larger)
    except (DivergedError, ValueError) as error:
        return final, dict(entry) | {"not_added": f"the gap with an empirical term cannot be measured: {error}"}
    worse = with_it.rms >= after.rms or bool(there and with_it_there and with_it_there.rms >= there.rms)
    if worse:
        return final, dict(entry) | {"not_added": "an empirical term does not make the gap smaller: it is not added"}
    added = {"name": term.NAME, "signal": after.signal, "gap_before": after.rms, "gap_after": with_it.rms}
    added |= {"confirm_before": None if there is None else there.rms}
    added |= {"confirm_after": None if with_it_there is None else with_it_there.rms}
    return larger, dict(entry) | {"added": added}


def _ledger(
    terms: Sequence[Term],
    families: Sequence[Sequence[int]],
    out: Mapping[int, str],
    given: Sequence[Discrepancy],
    confirm: Sequence[Discrepancy | None],
    found: Outcome,
) -> list[Step]:
    """Return the accepted effects with the gaps without and with each, and the refused ones with the reason."""
    steps_taken = []
    family_of = {k: place for place, family in enumerate(families) for k in family}
    for k, term in enumerate(terms):
        one, score = term.accepted, float(term.accepted.score)
        name = one.found.name.lstrip("~")
        if k in out or not term.path:
            why = out.get(k, "it is significant, but has no law that the model can represent")
            steps_taken.append(Step(name, False, why, score, None, None, None, None))
            continue
        less = 2 + family_of[k]
        there = [None if d is None else d.rms for d in (confirm[less], confirm[1])]
        reason = f"probability {100.0 * one.share:.0f} % over resampled motion"
        steps_taken.append(Step(name, True, reason, score, given[less].rms, given[1].rms, *there))
    for name, gains, expected in found.refused:
        logs = ("given", "other")
        against = [
            f"{g:.0f} on the {which} motion, {e:.0f} expected"
            for g, e, which in zip(gains, expected, logs, strict=True)
        ]
        reason = f"the logs contradict it: the gain in 2 ln likelihood is {'; '.join(against)}"
        steps_taken.append(Step(name.lstrip("~"), False, reason, float(sum(gains)), None, None, None, None))
    return steps_taken
