"""`diagnose`: from logs and a model to a verdict, a better model, and what it is worth on other motion."""

from __future__ import annotations

import os
from collections.abc import Callable, Sequence
from dataclasses import replace
from typing import Any

import numpy as np

from cogging._core import EFFECTS
from cogging.audit import audit, check_against_model
from cogging.controller_check import check_controller
from cogging.controller_recovery import recover_controller
from cogging.diagnose.gap import floor_of, gaps
from cogging.diagnose.locate import describe, where_of
from cogging.diagnose.patched import with_intervals
from cogging.diagnose.rest import Shape
from cogging.diagnose.result import Diagnosis, Gap, NamedEffect, Step, Value
from cogging.diagnose.search import (
    CHANGED,
    DETECTED,
    LEFT_OVER,
    RIVAL,
    Added,
    Search,
    alike,
    changes,
    effect_parameters,
    search,
    variance_jumps,
)
from cogging.diagnose.separate import separating
from cogging.diagnose.stand_in import stood_in
from cogging.estimation import NothingCounts
from cogging.logs import Log, read_log
from cogging.model import Model
from cogging.parameters import effect_paths, parameters_of

Logs = Log | str | os.PathLike[str] | Sequence[Log | str | os.PathLike[str]]

SURE = 0.9  # confidence from which a name is stated
LOOK_ALIKE = 25.0  # of the penalised 2 ln likelihood, for a rival that explains nearly the same part of the residual
VARIANCE = -25.0  # ln of the chance of a burst
SECONDS_MIN = 1.0  # of motion


def diagnose(
    logs: Logs,
    model: Model | str | os.PathLike[str],
    *,
    confirm: Logs = (),
    progress: Callable[[str], None] = lambda step: None,
) -> Diagnosis:
    """Find where logs and model disagree, name the missing effect, add it, and say what that is worth.

    The model is driven by the logged command and held to the readings by an observer; its innovations are made white
    and freed of all that re-tuning the model could explain. Every effect of the vocabulary is then tried at all its
    shapes, by what the simulator says it does. What stands is added and refitted, up to four effects; what other
    motion (`confirm`) refutes is not.

    Args:
        logs: one or several, or their files.
        model: what is believed, or its file.
        confirm: logs of other motion, which take no part in choice or fit.
        progress: is told what is being done.

    Raises:
        ValueError: a log or model that cannot be used.
        InputError: a file that cannot be read.
    """
    if not isinstance(model, Model):
        model = Model.read(model)
    given, others = _logs(logs), _logs(confirm)
    if not given:
        raise ValueError("logs: must be at least 1, got 0")
    for i, log in enumerate((*given, *others)):
        if len(log) < 500:
            raise ValueError(f"log {i + 1}: rows: must be at least 500 to be diagnosed, got {len(log)}")
        check_against_model(log, model, f"log {i + 1}")
    notes: list[str] = []
    model, replay, mismatch = _controller(given, model, notes)
    if mismatch is not None:
        return _mismatch(given, model, mismatch, notes)
    moving = sum(_seconds_of_motion(log) for log in given)
    if moving < SECONDS_MIN:
        notes.append(f"the axis moves for {moving:.2g} s only: at rest, friction hides every force")
        return _nothing("insufficient_excitation", given, model, notes)
    try:
        found = search(given, model, others, progress)
    except NothingCounts as error:
        notes.append(str(error))
        return _nothing("insufficient_excitation", given, model, notes)
    progress("measuring the gap")
    return _assemble(found, given, others, model, replay, notes)


def _logs(logs: Logs) -> list[Log]:
    if isinstance(logs, Log | str | os.PathLike):
        logs = [logs]
    return [log if isinstance(log, Log) else read_log(log) for log in logs]


def _seconds_of_motion(log: Log) -> float:
    quantum = 1e-3 * float(np.ptp(log.position))
    step = max(1, len(log) // 2000)
    position, time = log.position[::step], log.time[::step]
    speed = np.abs(np.diff(position)) / np.diff(time)
    return float(np.diff(time)[speed > max(0.01 * float(speed.max()), 0.0)].sum()) if quantum > 0 else 0.0


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
        check = audit(log, model).controller
        if check is None or check.reproduces is None:
            replay = False
            continue
        if check.reproduces is False:
            return (
                model,
                False,
                (f"the stated controller misses the logged command by {100 * (check.relative or 0.0):.1f} % rms"),
            )
        if (check.relative or 0.0) > 1e-3 and check.fitted and model.controller is not None:
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
    nominal, final = _file_form(found.nominal.model, model), _file_form(found.estimate.model, model)
    final = with_intervals(final, found.estimate)
    notes = [*notes, *stood_in(nominal, final)]
    seen = gaps(logs, [nominal, final], replay=replay)
    loops = replay and all(_obeys(log, found.nominal.model) for log in others)
    confirmed = gaps(others, [nominal, final], replay=loops) if others else None
    if confirmed and loops is not replay:
        notes.append("a confirm log does not obey the controller: its gap is that of an observer's innovations")
    floor = min(floor_of(seen[1], logs, final), seen[1].rms)
    gap = Gap(
        "V",
        floor,
        seen[0].rms,
        seen[1].rms,
        confirmed[0].rms if confirmed else None,
        confirmed[1].rms if confirmed else None,
        seen[0].signal,
        seen[0].position,
        seen[1].position,
    )
    left = [shape for shape in found.left if shape.log_chance < LEFT_OVER]
    beyond = [change for change in changes(found, model) if abs(change[3]) > CHANGED]
    effects = merged([_named(found, place, left) for place in range(len(found.added))])
    effects += [_changed(change, left) for change in beyond]
    unlisted = _unlisted(found, left)
    verdict = _verdict(effects, unlisted)
    alternatives = sorted({name for effect in effects for name in (effect.name, *effect.alternatives)})
    ambiguous = any(effect.alternatives for effect in effects)
    where = tuple(found.first_shapes)
    ledger = [
        Step(
            added.finding.name,
            True,
            _reason(added),
            added.finding.test.statistic,
            gap.before,
            gap.after,
            gap.confirm_before,
            gap.confirm_after,
        )
        for added in found.added
    ]
    ledger += [
        Step(finding.name, False, reason, finding.test.statistic, gap.before, gap.before, None, None)
        for finding, reason in found.refused
    ]
    return Diagnosis(
        verdict=verdict,
        effects=tuple(effects),
        unlisted=unlisted,
        gap=gap,
        separating_experiment=separating(alternatives, logs) if ambiguous else None,
        model=final,
        nominal=nominal,
        where=where,
        where_text=tuple(describe(shape) for shape in where if shape.log_chance < -7.0),
        ledger=tuple(ledger),
        notes=tuple(notes),
        series={
            "logs": list(logs),
            "given": model,
            "time": [log.time for log in logs],
            "gap_before": seen[0].series,
            "gap_after": seen[1].series,
            "counts": seen[0].counts,
            "position": [log.position for log in logs],
            "velocity": [source.along.velocity for source in found.nominal_evidence.sources],
        },
    )


def _file_form(fitted: Model, model: Model) -> Model:
    """The fitted model with the sections of the given one."""
    return fitted.replace(uncertainty=dict(model.uncertainty), controller=model.controller)


def _reason(added: Added) -> str:
    check = added.confirmation
    if check is None:
        return "no other motion to confirm it"
    if check.confirmed:
        return f"other motion shows {check.ratio:.2f} +- {check.deviation:.2f} of what was foreseen"
    return f"the other motion cannot show it (lambda {check.foreseen:.1f})"


def _named(found: Search, place: int, left: Sequence[Shape]) -> NamedEffect:
    added = found.added[place]
    best = added.rivals[0]
    # What explains nearly the same rows is told apart by how well its form is known, not by noise alone.
    rivals = [r for r in added.rivals[1:] if r.score > best.score - (LOOK_ALIKE if alike(r, best) > 0.85 else RIVAL)]
    prefix, effect = effect_paths(found.estimate.model.effects)[-len(found.added) + place]
    odds = sum(float(np.exp(0.5 * (r.score - best.score))) for r in added.rivals[1:])
    confidence = _confidence(added, odds, left)
    known = parameters_of(found.estimate.model)
    free = set(effect_parameters(found.estimate.model))
    values: dict[str, Value] = {}
    for name, (unit, _) in effect.FIELDS.items():
        if effect.ROLES[name]["role"] == "setting":
            continue
        paths = [p for p in known if p == f"{prefix}.{name}" or p.startswith(f"{prefix}.{name}[")]
        halves = [
            1.96 * float(found.estimate.deviation[found.estimate.paths.index(p)])
            if p in free and p in found.estimate.paths
            else float("nan")
            for p in paths
        ]
        numbers = [known[p].value for p in paths]
        if not numbers:
            continue
        low = [None if np.isnan(h) else v - h for v, h in zip(numbers, halves, strict=True)]
        high = [None if np.isnan(h) else v + h for v, h in zip(numbers, halves, strict=True)]
        if isinstance(getattr(effect, name), list):
            values[name] = Value(numbers, unit, (low, high))
        else:
            values[name] = Value(numbers[0], unit, (low[0], high[0]))
    return NamedEffect(
        effect.NAME,
        tuple(r.name for r in rivals),
        confidence,
        values,
        where_of(effect, found.evidence),
        added.finding.test.statistic,
        added.finding.log_chance,
    )


def _confidence(added: Added, odds: float, left: Sequence[Shape]) -> float:
    """The stated chance that a name is right: odds against the rivals, less what else speaks against it."""
    chance = 1.0 / (1.0 + odds)
    check = added.confirmation
    if check is None:
        chance *= 0.93
    elif check.foreseen < 10.0:
        chance *= 0.88
    elif abs(check.ratio - 1.0) > 2.0 * check.deviation:
        chance *= 0.8
    # A generic shape that explains more than the named effect does: its form is not quite that.
    generic = max((shape.score for shape in added.shapes), default=0.0)
    if generic > added.finding.score + 6.0:
        chance *= 0.7
    if left:
        chance *= 0.75
    if added.finding.test.statistic < 35.0:
        chance *= 0.9
    return round(float(np.clip(0.985 * chance, 0.01, 0.985)), 3)


def merged(effects: Sequence[NamedEffect]) -> list[NamedEffect]:
    """One entry a name: several harmonics are one cause. The strongest speaks; the others stand in `further`."""
    result: list[NamedEffect] = []
    for effect in effects:
        for i, known in enumerate(result):
            if known.name == effect.name:
                result[i] = replace(
                    known,
                    confidence=max(known.confidence, effect.confidence),
                    alternatives=known.alternatives if known.statistic > effect.statistic else effect.alternatives,
                    further=(*known.further, effect.parameters),
                )
                break
        else:
            result.append(effect)
    return result


def _changed(change: tuple[str, float, float, float], left: Sequence[Shape]) -> NamedEffect:
    name, size, deviation, beyond = change
    confidence = 0.97 if abs(beyond) > 5.0 else 0.91
    if left:
        confidence *= 0.8
    value = Value(size, "1", (size - 1.96 * deviation, size + 1.96 * deviation))
    return NamedEffect(
        f"{name}_change",
        (),
        round(confidence, 3),
        {"change": value},
        {"coordinate": {"mass": "acceleration"}.get(name, "velocity"), "range": None},
        beyond**2,
        -0.5 * beyond**2,
    )


def _unlisted(found: Search, left: Sequence[Shape]) -> dict[str, Any] | None:
    """A rest that no effect explains: significant on these logs, and in the same coordinate on the others."""
    reasons = []
    for shape in left:
        again = _on_others(found, shape)
        if again is not False:
            reasons.append((shape, again))
    burst = variance_jumps(found.evidence)
    if not reasons and burst > VARIANCE:
        return None
    if reasons:
        shape, again = reasons[0]
        return {
            "coordinate": shape.coordinate,
            "shape": describe(shape),
            "places": shape.places.tolist(),
            "force": shape.force.tolist(),
            "deviation": shape.deviation.tolist(),
            "share": shape.share,
            "confirmed": bool(again),
            "empirical": "a force of any shape in this coordinate; no effect of the vocabulary",
        }
    return {
        "coordinate": "time",
        "shape": f"bursts: the residual's power jumps (ln chance {burst:.0f})",
        "share": None,
        "confirmed": None,
    }


def _on_others(found: Search, shape: Shape) -> bool | None:
    """Whether the same coordinate is significant on the confirm logs too; None where they cannot tell."""
    if found.confirm_evidence is None:
        return None
    from cogging.diagnose.rest import shapes

    for other in shapes(found.confirm_evidence):
        if other.coordinate == shape.coordinate:
            if other.log_chance < -5.0:
                return True
            return False if "time" not in shape.coordinate else None
    return None


def _verdict(effects: Sequence[NamedEffect], unlisted: dict[str, Any] | None) -> str:
    if not effects:
        return "unlisted" if unlisted else "no_gap"
    if unlisted is not None and all(e.confidence < SURE for e in effects):
        return "unlisted"
    if any(e.alternatives or e.confidence < SURE for e in effects):
        return "ambiguous"
    return "unlisted" if unlisted is not None else "named"


__all__ = ["DETECTED", "EFFECTS", "diagnose"]
