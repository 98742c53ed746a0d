"""Detection limits: the smallest size of each effect that these logs would have shown with a chance of 95 %.

What an effect of size 1 puts into the force balance, freed of all that re-tuning explains, has a noncentrality lambda
that grows with the square of the size. The limit is the size at which the search accepts it 95 times in 100.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from scipy.optimize import brentq
from scipy.stats import ncx2, norm

from cogging.arrays import FloatArray
from cogging.diagnosis.balance.cells import dahl, load_response
from cogging.diagnosis.balance.decision import THRESHOLD, Outcome, block_edges, score_of
from cogging.diagnosis.balance.evidence import Evidence, orthonormal
from cogging.diagnosis.entries import Limit
from cogging.effects.effect import Effect, Knots, SplineKnots, Wave, kind_of

CHANCE = 0.95  # with which an effect of the size of its limit would have been shown
PARTS = (0.25, 0.5, 0.75)  # of the range of its shape: where an effect is looked at
SIZES = 12  # of an effect that its shape makes, as a delay, between the least and the most that its range has
LEFT = 0.02  # of a column: with less left beside what is re-tuned, the search does not look at it
TRIALS = {"wave": 1000, "shape": 16, "": 1}  # shapes among which an effect must stand out
CHANGES = ("mass", "viscous", "coulomb")
MOST_CHANGED = 2.0  # relative change beyond which a machine is another
UNSEEN = "it does nothing in this motion that would be told from what is re-tuned"


@dataclass(frozen=True)
class Size:
    """What is called the size of an effect: its field, unit, what several fields make, and whether more does more."""

    field: str
    unit: str
    meaning: str = ""
    of_shape: bool = False
    grows: bool = True


def is_sought(law: Effect) -> bool:
    """Whether a search looks for an effect: not for one whose amplitudes stand at places of the user's own choice."""
    return any(
        role["role"] == "shape" or (role["role"] == "amplitude" and not isinstance(getattr(law, field), list))
        for field, role in law.ROLES.items()
    )


def size_of(law: Effect) -> Size | None:
    """What the size of an effect is; None where no field of it starts from doing nothing."""
    amplitudes = [field for field, role in law.ROLES.items() if role["role"] == "amplitude"]
    if amplitudes:
        wave, first = kind_of(law, Wave), amplitudes[0]
        meaning = f"sqrt({wave.sine}^2 + {wave.cosine}^2)" if wave else ""
        if isinstance(getattr(law, first), list):
            meaning = f"largest {meaning or first} along the travel"
        return Size(first, law.FIELDS[first][0], meaning)
    for neutral in (0.0, np.inf):
        for field, role in law.ROLES.items():
            if role["role"] == "shape" and role["neutral"] == neutral:
                return Size(field, law.FIELDS[field][0], of_shape=True, grows=neutral == 0.0)
    return None


def unmeasured(vocabulary: Mapping[str, Effect]) -> dict[str, Limit]:
    """No limit of any effect, where nothing was measured."""
    why, none = "nothing was measured", {}
    for law in vocabulary.values():
        size = size_of(law)
        if is_sought(law) and size is not None:
            none[law.NAME] = Limit(size.field, size.unit, None, why, size.meaning, not size.grows)
    return none | {f"{name}_change": Limit("change", "1", why=why) for name in CHANGES}


def limits(found: Outcome, vocabulary: Mapping[str, Effect]) -> dict[str, Limit]:
    """The detection limit of each effect that was looked for, and of mass, viscous and Coulomb friction."""
    evidence = found.both
    told, columns, of = {}, [], []
    for law in vocabulary.values():
        size = size_of(law)
        if not is_sought(law) or size is None:
            continue
        told[law.NAME] = Limit(size.field, size.unit, None, UNSEEN, size.meaning, not size.grows)
        try:
            for amount, shape, rows in _looked_at(evidence, law, size):
                columns.append([b.rows(row)[0] for b, row in zip(evidence.balances, rows, strict=True)])
                of.append((law.NAME, amount, shape))
        except NotImplementedError as why:
            told[law.NAME] = replace(told[law.NAME], why=str(why))
        except ValueError:
            told[law.NAME] = replace(told[law.NAME], why="it cannot be evaluated along these logs")
    tables = [np.array(rows) for rows in zip(*columns, strict=True)]
    names = [name for name, _, _ in of]
    lambdas = noncentralities(evidence, tables)
    for name in {one.found.name for one in found.accepted} & set(names):  # beside all else that was found
        mine = [i for i, one in enumerate(names) if one == name]
        lambdas[mine] = noncentralities(evidence, [table[mine] for table in tables], name)
    blocks = len(block_edges(evidence))
    for name, none in told.items():
        law = vocabulary[name]
        mine = [i for i, (one, _, _) in enumerate(of) if one == name]
        kind = (
            "wave" if kind_of(law, Wave) else "shape" if any(r["role"] == "shape" for r in law.ROLES.values()) else ""
        )
        least = needed(2 if kind == "wave" else 1, TRIALS[kind], blocks)
        told[name] = _solved(none, law, [(of[i][1], of[i][2], float(lambdas[i])) for i in mine], least)
    return told | _change_limits(evidence, blocks)


def noncentralities(evidence: Evidence, tables: Sequence[FloatArray], name: str = "") -> FloatArray:
    """Lambda of each column, freed of what re-tuning explains, but for the parameters of an effect of this name."""
    null = evidence.screen
    own = (f"effects.{name}.", f"effects.{name}[")
    kept = [k for k in range(len(null.x)) if not (k < len(evidence.paths) and evidence.paths[k].startswith(own))]
    root, sigma = np.sqrt(null.weight / null.variance), null.prior[0][kept]
    finite = np.isfinite(sigma)
    prior = np.diag(1.0 / np.where(finite, sigma, 1.0))[:, finite]
    q = orthonormal(np.hstack([null.x[kept] * root, prior]))
    columns = evidence.filtered(tables, null.taps) * root
    before = np.linalg.norm(columns, axis=1)
    columns = np.hstack([columns, np.zeros((len(columns), int(finite.sum())))])
    after = np.linalg.norm(columns - (columns @ q.T) @ q, axis=1)
    return np.asarray(np.where(after > LEFT * before, after**2, 0.0))


def needed(freedom: int, trials: int, blocks: int) -> float:
    """The noncentrality with which an effect of so many amplitudes is accepted with a chance of 95 %."""
    least = accepted(freedom, trials, blocks)
    return float(brentq(lambda one: ncx2.sf(least, freedom, one) - CHANCE, 1e-6, 10.0 * least + 100.0))


def accepted(freedom: int, trials: int, blocks: int) -> float:
    """The likelihood ratio from which an effect of so many amplitudes, the best of so many trials, is accepted."""
    return float(brentq(lambda t: score_of(t, freedom, trials, blocks) - THRESHOLD, 1e-6, 1e6))


def _solved(none: Limit, law: Effect, seen: list[tuple[float, dict[str, Any], float]], least: float) -> Limit:
    size = size_of(law)
    if size is None or not any(one > 0.0 for _, _, one in seen):
        return none
    held = {k: [one[k] for _, one, _ in seen] for k in seen[0][1] if k != size.field}
    shape = {k: v[0] if min(v) == max(v) else [min(v), max(v)] for k, v in held.items()}
    if not size.of_shape:
        sizes = sorted(np.sqrt(least / one) * amount if one > 0.0 else np.inf for amount, _, one in seen)
        value = float(sizes[len(sizes) // 2])
        return replace(none, value=value, why="", shape=shape) if np.isfinite(value) else replace(none, shape=shape)
    enough = [amount for amount, _, one in seen if one >= least]
    if not enough:
        most = max(seen, key=lambda one: one[2])[0]
        unit = "" if none.unit == "1" else f" {none.unit}"
        return replace(
            none, why=f"it would have to be {'beyond' if size.grows else 'below'} {most:.3g}{unit}", shape=shape
        )
    return replace(none, value=float(min(enough) if size.grows else max(enough)), why="", shape=shape)


def _looked_at(evidence: Evidence, law: Effect, size: Size) -> Iterator[tuple[float, dict[str, Any], list[FloatArray]]]:
    """Size, shape, and force along each log (V) of an effect where it is looked at."""
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
    ranges = {field: role for field, role in law.ROLES.items() if role["role"] == "shape" and field != size.field}
    lists = [field for field in ranges if isinstance(getattr(law, field), list)]

    def between(role: Mapping[str, Any], part: float) -> float:
        first, last = float(role["low"]), float(role["high"])
        value = first + part * (last - first)
        if role["logarithmic"] and first > 0.0:
            value = first * (last / first) ** part
        offset = low if role["quantity"] == "position" else 0.0
        return float(offset + value * scales.get(role["quantity"], 1.0))

    for part in PARTS if not size.of_shape else PARTS[1:2]:
        shape = {field: between(role, part) for field, role in ranges.items() if field not in lists}
        spread = dict(shape)
        if size.of_shape:
            role = law.ROLES[size.field]
            amounts = np.geomspace(max(role["low"], 1e-3 * role["high"]), role["high"], SIZES)
            if (
                role["quantity"] == "stiffness"
            ):  # the rise of friction takes from a few readings to a part of the travel
                noise = min(b.encoder_noise for b in balances)
                amounts = model.axis.coulomb / np.geomspace(12.0 * noise, 0.03 * length, SIZES) / length
                scales["stiffness"] = length
            for amount in amounts * scales.get(role["quantity"], 1.0):
                yield float(amount), spread, _rows(evidence, law, {**shape, size.field: float(amount)}, size)
            continue
        window = [field for field, role in ranges.items() if role["quantity"] == "time" and len(ranges) == 2]
        if len(window) == 2:
            shape = {window[0]: 0.4 * scales["time"], window[1]: (0.4 + 0.4 * part) * scales["time"]}
        yield 1.0, shape, _rows(evidence, law, shape, size)


def _rows(evidence: Evidence, law: Effect, shape: dict[str, Any], size: Size) -> list[FloatArray]:
    """Force (V) of an effect along each log: of size 1, or as its shape makes it."""
    model, wave = evidence.model, kind_of(law, Wave)
    if "state" in law.HOOKS:
        return _with_state(evidence, law, shape, size)
    if kind_of(law, SplineKnots) is not None and wave is not None:  # a wave whose amplitude goes from -1 to 1
        places = [(b.position - b.position.min()) / max(float(np.ptp(b.position)), 1e-300) for b in evidence.balances]
        period = shape[wave.shape]
        return [
            (2.0 * x - 1.0) * np.sin(2.0 * np.pi * b.position / period)
            for b, x in zip(evidence.balances, places, strict=True)
        ]
    fields: dict[str, Any] = dict(shape)
    knots = kind_of(law, Knots)
    if knots is not None:
        low = min(float(b.position.min()) for b in evidence.balances)
        high = max(float(b.position.max()) for b in evidence.balances)
        fields |= {knots.nodes: np.linspace(low, high, 5).tolist(), knots.levels: [1.0, 0.5, -1.0, 0.5, 1.0]}
    elif not size.of_shape:
        fields[size.field] = 1.0
    effect = law.replace(**fields)
    if {"force", "friction_level", "command_gain"} & set(law.HOOKS):
        return [b.added(model, [effect], u)[0] for b, u in zip(evidence.balances, evidence.drives, strict=True)]
    small = 1.0 if size.of_shape else 1e-6 * max(float(np.ptp(b.position)) for b in evidence.balances)
    if not size.of_shape:
        effect = effect.replace(**{size.field: small})
    beside = model.replace(effects=(*model.effects, effect))
    return [(b.residual(model) - b.residual(beside)) / small for b in evidence.balances]


def _with_state(evidence: Evidence, law: Effect, shape: dict[str, Any], size: Size) -> list[FloatArray]:
    """Of a load behind a spring, and of a contact that bends before it slides."""
    fields = {role["quantity"]: shape[field] for field, role in law.ROLES.items() if field in shape}
    axis = evidence.model.axis
    if "frequency" in fields:
        ratio = fields.get("relative", 0.2)
        return [
            ratio * axis.mass * (a - load_response(a, b.step, fields["frequency"], 0.05))
            for b, a in zip(evidence.balances, evidence.accelerations, strict=True)
        ]
    if "stiffness" in fields and axis.coulomb > 0.0:
        length = max(axis.coulomb / fields["stiffness"], 1e-12)
        return [
            axis.coulomb * (np.tanh(b.velocity / max(axis.coulomb_width, 1e-6)) - dahl(b.position, length))
            for b in evidence.balances
        ]
    raise NotImplementedError("the force balance does not show it")


def _change_limits(evidence: Evidence, blocks: int) -> dict[str, Limit]:
    """The smallest changes of mass, viscous and Coulomb friction, beyond what is stated of them."""
    told, null, given = {}, evidence.null, evidence.given
    sigma, _ = null.prior
    free = null.gram - np.diag(1.0 / np.maximum(sigma**2 / null.variance, 1e-12))
    deviations = np.sqrt(np.maximum(null.variance * np.diag(np.linalg.pinv(free, hermitian=True)), 0.0)) / null.size
    for name in CHANGES:
        none, stated, value = Limit("change", "1"), given.uncertainty.get(name), float(getattr(given.axis, name))
        if stated is None:
            told[f"{name}_change"] = replace(none, why="the model does not state how well it knows it")
        elif f"axis.{name}" not in evidence.paths or value <= 0.0:
            told[f"{name}_change"] = replace(none, why="it is not fitted to these logs")
        else:
            own = float(deviations[evidence.paths.index(f"axis.{name}")] / value)
            least = np.sqrt(accepted(1, 1, blocks)) * np.hypot(own, stated) + norm.ppf(CHANCE) * own
            enough = replace(none, value=float(least))
            told[f"{name}_change"] = (
                enough if least < MOST_CHANGED else replace(none, why=f"it would have to be beyond {MOST_CHANGED:g}")
            )
    return told
