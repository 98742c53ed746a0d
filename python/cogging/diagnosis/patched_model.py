"""Patched model: the re-fitted laws of accepted candidates with 95 % intervals, and curves of those without a law."""

from __future__ import annotations

from collections.abc import Collection, Mapping, Sequence
from dataclasses import dataclass, replace
from itertools import islice
from typing import Any

import numpy as np
from scipy.stats import chi2

from cogging.arrays import FloatArray
from cogging.diagnosis.balance.cells import hats
from cogging.diagnosis.balance.decision import COLUMN_ERROR, Accepted, Outcome
from cogging.diagnosis.balance.evidence import Evidence
from cogging.diagnosis.physical import fields_with_role
from cogging.diagnosis.places import empirical_term
from cogging.effects.effect import Effect
from cogging.model.intervals import SIGMAS_95
from cogging.model.model import Model
from cogging.model.parameters import effect_paths, parameters_of, renamed_path

NODES = (21, 81, 321)  # numbers of nodes of an empirical force, of which the smallest sufficient one is used
FOLLOWED = 0.95  # minimum share of a force's power that a function of one coordinate reproduces


@dataclass(frozen=True)
class Term:
    """An accepted candidate in the patched model."""

    accepted: Accepted
    effect: Effect | None  # its re-fitted law; None for a change of the axis or without a law
    path: str  # of its effect in the patched model, or of the changed axis parameter; "" without either
    force: float  # rms of its force over the rows in motion, V
    curve: Mapping[str, Any] | None = None  # coordinate, places and force (V) of a candidate without a law
    certain: bool = True  # whether its interval excludes zero


def paths_without(whole: Model, gone: Collection[str]) -> dict[str, str]:
    """Return the path of each remaining effect by its path in the whole model: effects of one name are numbered."""
    kept = [(path, effect) for path, effect in effect_paths(whole.effects) if path not in gone]
    now = effect_paths([effect for _, effect in kept])
    return {path: new for (path, _), (new, _) in zip(kept, now, strict=True)}


def with_intervals(model: Model, evidence: Evidence, whole: Model, names: Mapping[str, str]) -> Model:
    """Return the model with 95 % intervals of the fitted parameters, its `[bounds]`.

    Args:
        model: patched model.
        evidence: evidence with all accepted terms.
        whole: model with all of them, some of which the patched model lacks.
        names: see `paths_without`.
    """
    known, fitted = parameters_of(model), parameters_of(evidence.model, together=True)
    intervals = {path: interval for path, interval in model.intervals.items() if path in known}
    for k, (path, own) in enumerate(zip(evidence.paths_in(whole), evidence.paths, strict=True)):
        path = renamed_path(path, names)
        low, high = evidence.interval(k) if path in known else (-np.inf, np.inf)
        if np.isfinite(high - low):
            value = known[path].value
            centre = fitted[own].value + float(evidence.null.theta[k]) if own in fitted else value
            low, high = min(centre + low, value), max(centre + high, value)
            intervals[path] = (max(0.0, low) if known[path].positive else low, high)
    return model.replace(intervals=intervals)


def merged(model: Model, stated: Model) -> tuple[Model, list[str]]:
    """Return the model with each effect of the stated model and its correction merged into one, and notes on these."""
    effects, notes = dict(enumerate(model.effects)), []
    intervals, paths = dict(model.intervals), [path for path, _ in effect_paths(model.effects)]
    for k, effect in enumerate(stated.effects):
        fields = fields_with_role(effect, "amplitude")
        for j, more in list(effects.items())[len(stated.effects) :]:
            alike = type(more) is type(effect) and all(isinstance(getattr(more, name), float) for name in fields)
            if not alike or more.replace(**{name: getattr(effect, name) for name in fields}) != effect:
                continue
            sums = {name: getattr(effects[k], name) + getattr(more, name) for name in fields}
            changes = ", ".join(f"{name} {getattr(effect, name):.4g} -> {sums[name]:.4g}" for name in fields)
            notes.append(f"{effect.NAME} of the stated model is corrected: {changes}")
            for name in fields:
                ends = intervals.pop(f"{paths[j]}.{name}", None)
                if ends is not None:
                    intervals[f"{paths[k]}.{name}"] = ends[0] + getattr(effect, name), ends[1] + getattr(effect, name)
            effects[k] = effects[k].replace(**sums)
            del effects[j]
    renamed = {paths[k]: path for k, (path, _) in zip(effects, effect_paths(effects.values()), strict=True)}
    kept = {new: ends for path, ends in intervals.items() if (new := renamed_path(path, renamed))}
    return model.replace(effects=tuple(effects.values()), intervals=kept), notes


def without(model: Model, terms: Sequence[Term], gone: Sequence[Term], found: Outcome) -> Model:
    """Return the model without some of its terms, re-fitted."""
    remain = {(t.accepted.found.name, t.accepted.found.label) for t in terms if t.path and t not in gone}
    kept = [k for k, column in enumerate(found.evidence.extra) if (column.name, column.label) in remain]
    return found.evidence.settled(model, [t.path for t in gone if t.path], kept)


def terms_of(found: Outcome, stated: Model) -> tuple[Model, list[Term]]:
    """Return the re-tuned model with the accepted candidates that have a name, and a term for each candidate."""
    evidence, retuned = found.evidence, found.evidence.model
    names = [path for path, _ in effect_paths(retuned.effects)]

    def force_of(less: Model) -> float:
        """Return the rms force that a model lacks beside the re-tuned one."""
        return _rms(evidence, [a - b for a, b in zip(evidence.raw_of(less), evidence.raw, strict=True)])

    model, of_laws = evidence.model, list(effect_paths(evidence.model.effects))[len(stated.effects) :]
    steps = evidence.null.theta
    at, laws, extra = len(evidence.paths), iter(of_laws), iter(evidence.extra)
    terms: list[Term] = []
    for one in found.accepted:
        candidate = one.found
        if candidate.columns is None:
            path = candidate.effect if isinstance(candidate.effect, str) else ""
            name = path.removeprefix("axis.")
            force = force_of(retuned.replace(axis=retuned.axis.replace(**{name: getattr(stated.axis, name)})))
            terms.append(Term(one, None, path, force, certain=_is_certain([path], [], evidence)))
        elif any(candidate.name == e.name and candidate.label == e.label for e in evidence.extra):
            column = next(extra)
            amplitudes = steps[at : at + len(column.amplitudes)]
            # what was judged near rest has few of its rows here
            certain = column.near_rest or _excludes_zero(range(at, at + len(amplitudes)), amplitudes, evidence)
            effect, first = next(iter(column.laws(amplitudes)), None), at
            at += len(amplitudes)
            forces = [amplitudes @ rows for rows in column.columns(evidence)]
            curve = None if effect is not None else curve_of(evidence, forces)
            term = effect if effect is not None else None if candidate.name.startswith("~") else empirical_term(curve)
            path = ""
            if term is not None:
                model = model.replace(effects=(*model.effects, term))
                path = str(len(model.effects) - 1)
            if effect is not None and len(amplitudes) == 1:  # the interval of the field that the amplitude is
                wider = SIGMAS_95 * COLUMN_ERROR * amplitudes[0]  # impacts and flights are not exactly the column's
                sides = (np.copysign(np.hypot(end, wider), end) for end in evidence.interval(first))
                ends = [(column.laws(amplitudes + side) or (effect,))[0].to_dict() for side in sides]
                last = effect_paths(model.effects)[-1][0]
                pairs = {f"{last}.{k}": (ends[0][k], ends[-1][k]) for k in ends[0] if ends[0][k] != ends[-1][k]}
                model = model.replace(intervals={**model.intervals, **pairs})
            terms.append(Term(one, effect, path, _rms(evidence, forces), curve, certain))
            continue
        for prefix, effect in islice(laws, len(candidate.laws(candidate.amplitudes)) * (candidate.columns is not None)):
            fields = fields_with_role(effect, "amplitude")
            paths = [p for p in evidence.paths if p.startswith(prefix + ".")]
            paths = [p for p in paths if p[len(prefix) + 1 :].split("[")[0] in fields]
            values = [parameters_of(evidence.model)[p].value for p in paths]
            certain = _is_certain(paths, values, evidence)
            at_path = names.index(prefix)
            force = force_of(retuned.replace(effects=[e for k, e in enumerate(retuned.effects) if k != at_path]))
            terms.append(Term(one, effect, str(at_path), force, certain=certain))
    names = [path for path, _ in effect_paths(model.effects)]  # effects of one name are numbered
    return model, [replace(t, path=names[int(t.path)]) if t.path.isdigit() else t for t in terms]


def _is_certain(paths: Sequence[str], values: Sequence[float], evidence: Evidence) -> bool:
    """Return whether parameters differ jointly from zero, or an axis parameter from its stated value, at 95 %."""
    rows = [evidence.paths.index(p) for p in paths if p in evidence.paths]
    if not rows or len(rows) != len(paths):
        return True  # an effect without amplitude, such as a delay
    if not values:
        name = paths[0].removeprefix("axis.")
        values = [getattr(evidence.model.axis, name) - getattr(evidence.given.axis, name)]
    return _excludes_zero(rows, np.array(values) + evidence.null.theta[rows], evidence)


def _excludes_zero(rows: Sequence[int], values: FloatArray, evidence: Evidence) -> bool:
    return evidence.loss(rows, -values) - evidence.loss((), 0.0) > float(chi2.ppf(0.95, len(values)))


def _in_motion(evidence: Evidence, rows: Sequence[FloatArray]) -> FloatArray:
    """Return rows (n,) of each log over the valid rows of all logs."""
    return np.concatenate([row[b.keep > 0] for b, row in zip(evidence.balances, rows, strict=True)])


def _rms(evidence: Evidence, forces: Sequence[FloatArray]) -> float:
    return float(np.sqrt(np.mean(_in_motion(evidence, forces) ** 2)))


def curve_of(evidence: Evidence, forces: Sequence[FloatArray]) -> dict[str, Any] | None:
    """Return a force (V, (n,) of each log) as a function of one coordinate, or None if no such function fits."""
    force = _in_motion(evidence, forces)
    best: dict[str, Any] | None = None
    most = FOLLOWED
    for coordinate in ("position", "velocity", "time"):
        values = _in_motion(evidence, [getattr(b, coordinate) for b in evidence.balances])
        for count in NODES if coordinate == "position" else NODES[:1]:
            places = np.linspace(float(values.min()), float(values.max()), count)
            table = hats(values, places)
            gram = table @ table.T
            levels = np.linalg.solve(gram + 1e-6 * np.trace(gram) / count * np.eye(count), table @ force)
            share = 1.0 - float(np.sum((force - levels @ table) ** 2) / max(float(force @ force), 1e-300))
            if share > most:
                most, best = share, {"coordinate": coordinate, "places": places.tolist(), "force": levels.tolist()}
                break
    return best
