"""Detection limits: the smallest size of each effect that these logs would have shown with a stated chance.

Of each shape that an effect may have, the noncentrality lambda of its T grows with the square of its size (of a size
that the shape makes: as the columns at several sizes say). The chance that a search accepts it (search.chance) is
averaged over the shapes; the limit is the size at which it is LIMIT.chance_shown.
"""

from __future__ import annotations

import os
from collections.abc import Mapping, Sequence
from concurrent.futures import ThreadPoolExecutor
from dataclasses import replace

import numpy as np

from cogging._core import DivergedError
from cogging.arrays import FloatArray
from cogging.diagnosis.candidates.signatures import Candidate
from cogging.diagnosis.candidates.sizes import Size, is_sought, likely_shapes, range_of, size_of, told_shape
from cogging.diagnosis.entries import Limit
from cogging.diagnosis.evidence.allowance import AXIS_PARAMETERS
from cogging.diagnosis.evidence.score_test import orthonormal
from cogging.diagnosis.naming.parameter_changes import parameter_estimates
from cogging.diagnosis.residual.shapes import low_power
from cogging.diagnosis.search.chance import LAMBDAS, Powers, chances
from cogging.diagnosis.search.growth import Growth, View, growth_of_amplitudes, growth_of_shapes
from cogging.diagnosis.search.state import Search
from cogging.diagnosis.thresholds import CHOICE, LIMIT, PARAMETER_CHANGE
from cogging.effects.effect import Effect
from cogging.model.model import Model

UNMEASURED = "nothing was measured"


def limits(found: Search, model: Model, confirmed: bool) -> dict[str, Limit]:
    """The detection limit of each effect that was looked for, and of mass, viscous and Coulomb friction.

    Args:
        found: search, whose last model the limits are told of: beside what was found.
        model: given model, with what it states to know of its nuisances.
        confirmed: whether there were logs of other motion.
    """
    evidence, other = found.evidence, found.confirm_evidence
    power = CHOICE.worth * low_power(other) if other is not None else 0.0
    worth = Powers(CHOICE.worth * low_power(evidence), power)
    _ = evidence.scales, evidence.overdispersion, evidence.freedom  # made here once, not by every thread
    if other is not None:
        _ = other.scales, other.overdispersion, other.freedom

    def one(law: Effect) -> Limit:
        return limit(View(evidence, _basis_without(found, law), other, confirmed, worth), law)

    laws = [law for law in found.vocabulary.values() if is_sought(law)]
    with ThreadPoolExecutor(os.cpu_count(), initializer=lambda: np.seterr(all="ignore")) as threads:
        told = dict(zip((law.NAME for law in laws), threads.map(one, laws), strict=True))
    return told | change_limits(found, model)


def unmeasured(vocabulary: Mapping[str, Effect]) -> dict[str, Limit]:
    """No limit of any effect, where nothing was measured."""
    none = {}
    for law in vocabulary.values():
        size = size_of(law)
        if is_sought(law) and size is not None:
            none[law.NAME] = Limit(size.field, size.unit, None, UNMEASURED, size.meaning, not size.grows)
    return none | {f"{name}_change": Limit("change", "1", why=UNMEASURED) for name in AXIS_PARAMETERS}


def _basis_without(found: Search, law: Effect) -> FloatArray:
    """What re-tuning could explain if the effect had not been found."""
    if all(added.finding.name != law.NAME for added in found.added):
        return found.evidence.basis
    names = (f"effects.{law.NAME}.", f"effects.{law.NAME}[")
    own = [i for i, path in enumerate(found.estimate.paths) if path.startswith(names)]
    return orthonormal(np.delete(found.evidence.columns, own, axis=0))


def limit(view: View, law: Effect) -> Limit:
    """The detection limit of one effect."""
    size = size_of(law)
    if size is None:
        return Limit("", "", why="no field of it starts from doing nothing")
    none = Limit(size.field, size.unit, None, "", size.meaning, not size.grows)
    shapes, trials = likely_shapes(view.evidence, law)
    if not shapes:
        return replace(none, why="the logs, or the model, leave no shape of it to look for")
    try:
        grown = grown_of(view, law, shapes, trials, size)
    except (DivergedError, ValueError):
        return replace(none, why="it cannot be simulated along these logs")
    least, bound = range_of(view.evidence, law, size)
    if not 0.0 < bound < np.inf or all(one.log_lambdas[-1] <= LIMIT.unseen for one in grown):
        return replace(none, why="it does nothing in this motion that a search would tell from what is re-tuned")
    sign = 1.0 if size.grows else -1.0
    strengths = sign * np.log(bound) - np.arange(0.0, LIMIT.size_depth, LIMIT.size_step)[::-1]
    strengths = strengths[strengths >= (sign * np.log(least) if 0.0 < least < np.inf else -np.inf)]
    return solved(grown, view.worth, none, strengths)


def grown_of(view: View, law: Effect, shapes: Sequence[Candidate], trials: float, size: Size) -> list[Growth]:
    """How the noncentrality grows with the size at each shape."""
    if size.made_by_shape:
        return growth_of_shapes(view, law, shapes, trials, size)
    return growth_of_amplitudes(view, law, shapes, trials)


def solved(grown: Sequence[Growth], worth: Powers, none: Limit, strengths: FloatArray) -> Limit:
    """The limit from the chance of each size, averaged over the shapes.

    Where even the largest would not be shown at all shapes, those that are seen least are left out, up to half.
    """
    logs = np.log(LAMBDAS)
    known = {id(one.visibility): one.visibility for one in grown}
    shown = {key: chances(visibility, worth) for key, visibility in known.items()}
    each = [np.interp(g.at(strengths, not none.smaller_shows), logs, shown[id(g.visibility)]) for g in grown]
    shapes = list({id(one.shape): one.shape for one in grown}.values())
    by_shape = [
        np.mean([chance for one, chance in zip(grown, each, strict=True) if one.shape is shape], axis=0)
        for shape in shapes
    ]
    order = sorted(range(len(shapes)), key=lambda i: -by_shape[i][-1])
    fewest = (len(shapes) + 1) // 2
    while len(order) > fewest and np.mean([by_shape[i][-1] for i in order]) < LIMIT.chance_shown:
        order.pop()
    chance = np.maximum.accumulate(np.mean([by_shape[i] for i in order], axis=0))
    sizes = np.exp(-strengths if none.smaller_shows else strengths)
    size = Size(none.parameter, none.unit, made_by_shape=not shapes[0].amplitudes)
    told = told_shape(shapes[0].law, [shapes[i] for i in order], size)
    curve = replace(none, shape=told, sizes=tuple(sizes.tolist()), chances=tuple(chance.tolist()))
    if chance[-1] < LIMIT.chance_shown:
        unit = "" if none.unit == "1" else f" {none.unit}"
        text = f"{'below' if none.smaller_shows else 'beyond'} {sizes[-1]:.3g}{unit}"
        return replace(curve, why=f"it would have to be {text}")
    return replace(curve, value=float(sizes[int(np.searchsorted(chance, LIMIT.chance_shown))]))


# Changes of the axis --------------------------------------------------------------------------------------------------


def change_limits(found: Search, model: Model) -> dict[str, Limit]:
    """The smallest changes of mass, viscous and Coulomb friction that would have been told.

    A change is told where it is PARAMETER_CHANGE.changed deviations, found and stated, from what the model states.
    """
    _, deviations, _ = parameter_estimates(found.evidence, found.estimate)
    known = {path: float(one) for path, one in zip(found.estimate.paths, deviations, strict=False)}
    return {f"{name}_change": _change_limit(known.get(f"axis.{name}"), model, name) for name in AXIS_PARAMETERS}


def _change_limit(deviation: float | None, model: Model, name: str) -> Limit:
    none, prior, stated = Limit("change", "1"), float(getattr(model.axis, name)), model.uncertainty.get(name)
    if stated is None:
        return replace(none, why="the model does not state how well it knows it")
    if deviation is None or prior <= 0.0:
        return replace(none, why="it is not fitted to these logs")
    if not np.isfinite(deviation):
        return replace(none, why="these logs do not tell it from what else is re-tuned")
    own = deviation / prior
    least = PARAMETER_CHANGE.changed * float(np.hypot(own, stated))
    sizes = np.maximum(least + own * np.linspace(-LIMIT.normal_tail, LIMIT.normal_tail, 121), 0.0)
    from scipy.special import ndtr

    chance = ndtr((sizes - least) / max(own, 1e-12))
    curve = replace(none, sizes=tuple(sizes.tolist()), chances=tuple(chance.tolist()))
    value = least + LIMIT.chance_quantile * own
    if value > LIMIT.change_factor:
        return replace(curve, why=f"it would have to be beyond {LIMIT.change_factor:g}")
    return replace(curve, value=value)
