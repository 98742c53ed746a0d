"""Detection limits: the smallest size of each effect that the logs would have shown with a probability of 95 %.

The column of an effect of size 1, orthogonal to the nuisance parameters, has a noncentrality lambda that grows with the
square of the size. The limit is the size at which the search accepts the effect in 95 of 100 cases.
"""

from __future__ import annotations

from bisect import bisect_left
from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace
from operator import itemgetter
from typing import Any

import numpy as np
from scipy.optimize import brentq
from scipy.stats import ncx2, norm

from cogging.arrays import FloatArray
from cogging.diagnosis.balance.candidates import NEAR_REST, SHORTEST
from cogging.diagnosis.balance.decision import THRESHOLD, Outcome, block_edges, score_of
from cogging.diagnosis.balance.evidence import Evidence, beside, nuisance_basis
from cogging.diagnosis.entries import Limit
from cogging.diagnosis.physical import fields_with_role
from cogging.effects.effect import Effect, Knots, SplineKnots, Wave, kind_of
from cogging.resources import on_threads

CHANCE = 0.95  # detection probability of an effect at its limit
PARTS = (0.25, 0.5, 0.75)  # of the range of a shape parameter: values at which an effect is evaluated
SIZES = 12  # grid of the size of an effect without amplitude, such as a delay
LEFT = 0.02  # of a column's norm: a smaller part orthogonal to the nuisance parameters is ignored, as in the search
TRIALS = {"wave": 1000, "shape": 16, "": 1}  # number of shapes that the search tries
CHANGES = ("mass", "viscous", "coulomb")
MOST_CHANGED = 2.0  # largest relative change of the axis that is reported
UNSEEN = "in this motion its force is zero or indistinguishable from re-tuning"


def size_of(law: Effect, why: str) -> Limit | None:
    """Return the limit of an effect without a value, for a reason; None if the search does not try the effect.

    It does not if all amplitudes are lists at places that the user chose. The size is an amplitude, else a shape
    parameter that is neutral at 0 or infinity.
    """
    amplitudes, shapes = fields_with_role(law, "amplitude"), fields_with_role(law, "shape")
    if not shapes and all(isinstance(getattr(law, field), list) for field in amplitudes):
        return None
    if amplitudes:
        wave, first = kind_of(law, Wave), amplitudes[0]
        meaning = f"sqrt({wave.sine}^2 + {wave.cosine}^2)" if wave else ""
        if isinstance(getattr(law, first), list):
            meaning = f"largest {meaning or first} along the travel"
        return Limit(first, law.FIELDS[first][0], None, why, meaning)
    for neutral in (0.0, np.inf):
        for field in shapes:
            if law.ROLES[field]["neutral"] == neutral:
                return Limit(field, law.FIELDS[field][0], None, why, smaller_shows=neutral == np.inf)
    return None


def is_shape(law: Effect, size: Limit) -> bool:
    """Return whether the size of an effect is a shape parameter: the effect has no amplitude."""
    return bool(law.ROLES[size.parameter]["role"] == "shape")


def unmeasured(vocabulary: Mapping[str, Effect], why: str = "nothing was measured") -> dict[str, Limit]:
    """Return the limits of all effects and changes of the axis without a value, for a reason."""
    none = {law.NAME: size for law in vocabulary.values() if (size := size_of(law, why)) is not None}
    return none | {f"{name}_change": Limit("change", "1", why=why) for name in CHANGES}


def limits(found: Outcome, vocabulary: Mapping[str, Effect]) -> dict[str, Limit]:
    """Return the detection limit of each effect that the search tries, and of mass, viscous and Coulomb friction."""
    evidence = found.both
    result, blocks = unmeasured(vocabulary, UNSEEN), len(block_edges(evidence))
    sought = [name for name in result if name in vocabulary]
    # what was accepted is seen beside the other effects
    apart = {*NEAR_REST, *(one.found.name for one in found.accepted)} & set(sought)
    own = {name: visibility(evidence.near_rest if name in NEAR_REST else evidence, name) for name in apart}
    whole = visibility(evidence)

    @np.errstate(all="ignore")
    def limit_of(name: str) -> Limit:
        law, size, visible = vocabulary[name], result[name], own.get(name, whole)
        kind = "wave" if kind_of(law, Wave) else "shape" if fields_with_role(law, "shape") else ""
        freedom = 2 if kind == "wave" else 1
        least = accepted_ratio(freedom, TRIALS[kind], blocks)
        # noncentrality at which the effect is accepted with a probability of CHANCE
        needed = float(brentq(lambda c: ncx2.sf(least, freedom, c) - CHANCE, 1e-6, 10.0 * least + 100.0))
        seen: list[tuple[float, dict[str, Any], float]] = []

        def shows(trial: tuple[float, dict[str, Any]]) -> bool:
            amount, shape = trial
            seen.append((amount, shape, visible(_rows(evidence, law, shape, size))))
            return seen[-1][2] >= needed

        try:
            trials = _trials(evidence, law, size)
            if is_shape(law, size):  # every size beyond the first that shows does too
                bisect_left(sorted(trials, key=itemgetter(0), reverse=size.smaller_shows), True, key=shows)
            else:
                list(map(shows, trials))
        except ValueError:
            return replace(size, why="it cannot be evaluated along these logs")
        return _solve(size, law, seen, needed)

    done = on_threads(limit_of, sought)
    return result | dict(zip(sought, done, strict=True)) | _change_limits(evidence, blocks)


def visibility(evidence: Evidence, name: str = "") -> Callable[[Sequence[FloatArray]], float]:
    """Return a function of the force along each log (V) of an effect that returns its noncentrality lambda.

    It is orthogonal to the nuisance parameters, except those of the effect `name`.
    """
    null = evidence.screen
    own = (f"effects.{name}.", f"effects.{name}[")
    kept = [k for k in range(len(null.x)) if not (k < len(evidence.paths) and evidence.paths[k].startswith(own))]
    root = np.sqrt(null.weight / null.spread)
    q = nuisance_basis(null.x[kept] * root, null.prior[0][kept])

    def visible(forces: Sequence[FloatArray]) -> float:
        rows = [b.rows(force) for b, force in zip(evidence.balances, forces, strict=True)]
        column = evidence.filtered(rows, null.taps) * root
        after = float(np.linalg.norm(beside(column, q)))
        return after**2 if after > LEFT * np.linalg.norm(column) else 0.0

    return visible


def accepted_ratio(freedom: int, trials: int, blocks: int) -> float:
    """Return the likelihood ratio (2 ln) at which the search accepts the best of `trials` candidates."""
    return float(brentq(lambda t: score_of(t, freedom, trials, blocks) - THRESHOLD, 1e-6, 1e6))


def _solve(none: Limit, law: Effect, seen: list[tuple[float, dict[str, Any], float]], needed: float) -> Limit:
    """Return the limit from size, shape and lambda of each evaluation; `none` if this motion cannot show the effect."""
    if not any(one > 0.0 for _, _, one in seen):
        return none
    held = {k: [one[k] for _, one, _ in seen] for k in seen[0][1] if k != none.parameter}
    shape = {k: v[0] if min(v) == max(v) else [min(v), max(v)] for k, v in held.items()}
    if not is_shape(law, none):
        sizes = sorted(np.sqrt(needed / one) * amount if one > 0.0 else np.inf for amount, _, one in seen)
        value = float(sizes[len(sizes) // 2])
        return replace(none, value=value, why="", shape=shape) if np.isfinite(value) else replace(none, shape=shape)
    enough = [amount for amount, _, one in seen if one >= needed]
    if not enough:
        most = max(seen, key=lambda one: one[2])[0]
        unit = "" if none.unit == "1" else f" {none.unit}"
        why = f"only a value {'below' if none.smaller_shows else 'above'} {most:.3g}{unit} would show"
        return replace(none, why=why, shape=shape)
    return replace(none, value=float(max(enough) if none.smaller_shows else min(enough)), why="", shape=shape)


def _trials(evidence: Evidence, law: Effect, size: Limit) -> list[tuple[float, dict[str, Any]]]:
    """Return sizes and shapes at which an effect is evaluated."""
    balances, model = evidence.balances, evidence.model
    low = min(float(b.position.min()) for b in balances)
    length = max(float(b.position.max()) for b in balances) - low
    scales = {
        "position": length,
        "distance": length,
        "velocity": max(float(np.abs(b.velocity).max()) for b in balances),
        "time": max(float(b.time[-1]) for b in balances),
        "command": max(float(np.abs(b.command).max()) for b in balances),
        "sample_time": float(np.median(np.diff(balances[0].log.time))),
        "frequency": evidence.rate,
        "angle": 2.0 * np.pi,
    }
    fields = [field for field in fields_with_role(law, "shape") if field != size.parameter]
    scalars = [field for field in fields if not isinstance(getattr(law, field), list)]

    def between(field: str, part: float) -> float:
        role = law.ROLES[field]
        first, last = float(role["low"]), float(role["high"])
        value = first + part * (last - first)
        if role["logarithmic"] and first > 0.0:
            value = first * (last / first) ** part
        offset = low if role["quantity"] == "position" else 0.0
        return float(offset + value * scales.get(role["quantity"], 1.0))

    if is_shape(law, size):
        shape = {field: between(field, PARTS[1]) for field in scalars}
        role = law.ROLES[size.parameter]
        amounts = np.geomspace(max(role["low"], 1e-3 * role["high"]), role["high"], SIZES)
        if role["quantity"] == "stiffness":  # friction rises over an encoder step up to a part of the travel
            noise = min(b.encoder_noise for b in balances)
            amounts = model.axis.coulomb / np.geomspace(SHORTEST * noise, 0.03 * length, SIZES) / length
            scales["stiffness"] = length
        amounts = amounts * scales.get(role["quantity"], 1.0)
        return [(float(amount), {**shape, size.parameter: float(amount)}) for amount in amounts]
    window = [field for field in fields if law.ROLES[field]["quantity"] == "time" and len(fields) == 2]
    shapes = [{field: between(field, part) for field in scalars} for part in PARTS]
    if len(window) == 2:
        ends = [(0.4 + 0.4 * part) * scales["time"] for part in PARTS]
        shapes = [{window[0]: 0.4 * scales["time"], window[1]: end} for end in ends]
    return [(1.0, shape) for shape in shapes]


def _rows(evidence: Evidence, law: Effect, shape: dict[str, Any], size: Limit) -> list[FloatArray]:
    """Return the force (V) of an effect of size 1, or of the size that its shape sets, along each log."""
    balances, model, wave = evidence.balances, evidence.model, kind_of(law, Wave)
    if kind_of(law, SplineKnots) is not None and wave is not None:  # its amplitude grows from -1 to 1
        period, rows = shape[wave.shape], []
        for b in balances:
            place = (b.position - b.position.min()) / max(float(np.ptp(b.position)), 1e-300)
            rows.append((2.0 * place - 1.0) * np.sin(2.0 * np.pi * b.position / period))
        return rows
    fields: dict[str, Any] = dict(shape)
    pushes, knots, small = bool({"force", "friction_level", "command_gain"} & set(law.HOOKS)), kind_of(law, Knots), 1.0
    if knots is not None:
        low, high = min(float(b.position.min()) for b in balances), max(float(b.position.max()) for b in balances)
        fields |= {knots.nodes: np.linspace(low, high, 5).tolist(), knots.levels: [1.0, 0.5, -1.0, 0.5, 1.0]}
    elif not is_shape(law, size):
        small = 1.0 if pushes else 1e-6 * max(float(np.ptp(b.position)) for b in balances)
        fields[size.parameter] = small
    effect = law.replace(**fields)
    if pushes:
        return [b.added(model, [effect], u)[0] for b, u in zip(balances, evidence.drives, strict=True)]
    beside = model.replace(effects=(*model.effects, effect))
    return [one.change(b, beside, model) / small for b, one in zip(balances, evidence.instruments, strict=True)]


def _change_limits(evidence: Evidence, blocks: int) -> dict[str, Limit]:
    """Return the smallest detectable changes of mass, viscous and Coulomb friction beyond their stated uncertainty."""
    result, null, given = {}, evidence.null, evidence.given
    variances = np.diag(np.linalg.pinv(evidence.information_of_rows, hermitian=True))
    deviations = np.sqrt(np.maximum(variances, 0.0)) / null.size
    for name in CHANGES:
        stated, value, path = given.uncertainty.get(name), float(getattr(given.axis, name)), f"axis.{name}"
        least, why = None, ""
        if stated is None:
            why = "the model states no uncertainty of it"
        elif path not in evidence.paths or value <= 0.0:
            why = "it is not fitted to these logs"
        else:
            own = float(deviations[evidence.paths.index(path)] / value)
            least = float(np.sqrt(accepted_ratio(1, 1, blocks)) * np.hypot(own, stated) + norm.ppf(CHANCE) * own)
            if least >= MOST_CHANGED:
                least, why = None, f"only a change above {MOST_CHANGED:g} would show"
        result[f"{name}_change"] = Limit("change", "1", least, why)
    return result
