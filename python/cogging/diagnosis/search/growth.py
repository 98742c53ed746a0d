"""How the evidence for an effect grows with its size: the noncentrality of its T at each shape that it may have."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from cogging.arrays import FloatArray
from cogging.diagnosis.candidates.intervals import acts_in_interval
from cogging.diagnosis.candidates.signatures import Candidate, candidates
from cogging.diagnosis.candidates.sizes import Size, directions, is_share
from cogging.diagnosis.candidates.tables import whitened_each
from cogging.diagnosis.evidence.evidence import Evidence
from cogging.diagnosis.search.chance import GRID, Powers, Visibility
from cogging.diagnosis.thresholds import CHOICE, FINDING, LIMIT, SCORE_TEST
from cogging.effects.effect import Effect

Noise = tuple[float, float, FloatArray]  # spread, spread_there and bounded of a Visibility


@dataclass(frozen=True)
class View:
    """What an effect is looked for in.

    Attributes:
        evidence: of the logs under the last model.
        basis: what re-tuning can explain there (Evidence.basis), the effect that is looked for not in the model.
        other: evidence of the other motion; None where it cannot be predicted, or without.
        confirmed: whether there is other motion.
        worth: least T that is worth a name.
    """

    evidence: Evidence
    basis: FloatArray
    other: Evidence | None
    confirmed: bool
    worth: Powers


@dataclass(frozen=True)
class Growth:
    """How the noncentrality of one shape grows with the size, and how well it is seen.

    Attributes:
        shape: the shape.
        strengths: ln size, or - ln size where less does more, (k,), increasing.
        log_lambdas: ln noncentrality at each, (k,).
        visibility: how well it is seen.
    """

    shape: Candidate
    strengths: FloatArray
    log_lambdas: FloatArray
    visibility: Visibility

    def at(self, strengths: FloatArray, proportional: bool) -> FloatArray:
        """ln noncentrality at other strengths; beyond those that were tried it goes with the square of the size."""
        known = np.interp(strengths, self.strengths, self.log_lambdas)
        if not proportional:
            return np.asarray(known)
        last = self.strengths[-1] if len(self.strengths) == 1 else np.inf
        below, above = np.minimum(strengths - self.strengths[0], 0.0), np.maximum(strengths - last, 0.0)
        return np.asarray(known + 2.0 * (below + above))


def _columns(evidence: Evidence, basis: FloatArray, shapes: Sequence[Candidate]) -> list[FloatArray]:
    """Whitened columns (p, n) of each shape, freed of what re-tuning explains; 0 where that is all."""
    result = []
    for columns in whitened_each(evidence, shapes):
        left = columns - (columns @ basis.T) @ basis
        kept = np.einsum("ij,ij->i", left, left) > SCORE_TEST.untuned_share**2 * np.einsum("ij,ij->i", columns, columns)
        result.append(left * kept[:, None])
    return result


def growth_of_amplitudes(view: View, law: Effect, shapes: Sequence[Candidate], trials: float) -> list[Growth]:
    """Growth of an effect at each shape and direction of its amplitudes."""
    own = _columns(view.evidence, view.basis, shapes)
    there = _columns(view.other, view.other.basis, shapes) if view.other is not None else own
    grown = []
    for candidate, columns, other in zip(shapes, own, there, strict=True):
        gram = columns @ columns.T / view.evidence.overdispersion
        gram_there = np.zeros_like(gram) if view.other is None else other @ other.T / view.other.overdispersion
        noise, freedom = _noise(view, columns, other), _freedom(gram)
        turned = directions(candidate)
        powers = np.maximum(np.einsum("mi,ij,mj->m", turned, gram, turned), np.exp(LIMIT.unseen))
        ratio = float(np.mean(np.einsum("mi,ij,mj->m", turned, gram_there, turned) / powers))
        visibility = _visibility(view, law, trials, freedom, noise, ratio, float(np.mean(powers)))
        grown += [Growth(candidate, np.zeros(1), np.array([np.log(power)]), visibility) for power in powers]
    return grown


def growth_of_shapes(view: View, law: Effect, shapes: Sequence[Candidate], trials: float, size: Size) -> list[Growth]:
    """Growth of an effect that its shape makes, at each value of what else its shape is."""
    groups: dict[str, list[Candidate]] = {}
    for candidate in shapes:
        rest = {field: value for field, value in candidate.shape.items() if field != size.field}
        groups.setdefault(str(rest), []).append(candidate)
    grid = list(candidates(view.evidence, law))
    chosen = list(groups.values())[:: -(-len(groups) // LIMIT.growth_groups)]
    sign = 1.0 if size.grows else -1.0
    grown = []
    for group in chosen:
        group.sort(key=lambda one: sign * one.shape[size.field])
        own = _columns(view.evidence, view.basis, group)
        strengths = sign * np.log([one.shape[size.field] for one in group])
        if any(group[0].shape == one.shape for one in grid):
            powers = _powers(own, strengths, size.grows)
        else:
            powers = _reached(own, _columns(view.evidence, view.basis, grid))
        powers = powers * _share_factor(group[0], size) / view.evidence.overdispersion
        powers = np.maximum.accumulate(np.maximum(powers, np.exp(LIMIT.unseen)))
        typical = int(np.argmin(np.abs(np.log(powers / LIMIT.typical))))
        ratio, other = 0.0, own[typical]
        if view.other is not None:
            other = _columns(view.other, view.other.basis, [group[typical]])[0]
            here = max(float(np.sum(own[typical] ** 2)), 1e-300) / view.evidence.overdispersion
            ratio = float(np.sum(other**2)) / view.other.overdispersion / here
        noise = _noise(view, own[typical], other)
        visibility = _visibility(view, law, trials, 1, noise, ratio, 1.0)
        grown.append(Growth(group[typical], strengths, np.log(powers), visibility))
    return grown


def _powers(columns: Sequence[FloatArray], strengths: FloatArray, grows: bool) -> FloatArray:
    """Power of columns of one shape at several sizes, (k,).

    What does not fade with the size, as the spring of a contact does not, is not of the size: it is taken away.
    """
    powers = np.array([float(np.sum(one**2)) for one in columns])
    if grows and len(powers) > 2 and powers[1] < powers[0] * np.exp(strengths[1] - strengths[0]):
        rest = [float(np.sum((one - columns[0]) ** 2)) for one in columns[1:]]
        slope = np.exp(2.0 * (strengths[0] - strengths[1]))
        return np.array([rest[0] * slope, *rest])
    return powers


def _reached(columns: Sequence[FloatArray], tried: Sequence[FloatArray]) -> FloatArray:
    """What the likeliest of the columns that a scan tries, as they are, explains of others, (k,)."""
    powers = np.array([float(np.sum(one**2)) for one in tried])
    return np.array([max(0.0, *(2.0 * np.array([np.sum(c * t) for t in tried]) - powers)) for c in columns])


def _share_factor(candidate: Candidate, size: Size) -> float:
    """By how much the noncentrality grows when shares that are no size are LIMIT.share_behind, not what was tried."""
    roles = candidate.law.ROLES
    shares = [value for f, value in candidate.shape.items() if f != size.field and is_share(roles[f])]
    return float(np.prod([(LIMIT.share_behind / value) ** 2 for value in shares]))


def _visibility(
    view: View,
    law: Effect,
    trials: float,
    freedom: int,
    noise: tuple[float, float, FloatArray],
    ratio: float,
    power: float,
) -> Visibility:
    """How well an effect of one shape is seen, whose noncentrality at size 1 is `power`."""
    once = acts_in_interval(law)
    count = view.evidence.model.encoder.resolution if "reading" in law.HOOKS and freedom > 1 else 0.0
    needed = CHOICE.slippery if once or "friction_level" in law.HOOKS else CHOICE.unshown
    least = (FINDING.faint_counts * count) ** 2 * power
    return Visibility(trials, freedom, *noise, ratio if view.confirmed else None, least, needed, once)


def _freedom(gram: FloatArray) -> int:
    """Degrees of freedom of columns with a Gram matrix (as in Evidence.test)."""
    size = np.sqrt(np.diag(gram))
    seen = size > 0.0
    if not seen.any():
        return 1
    return int(
        (np.linalg.eigvalsh(gram[np.ix_(seen, seen)] / np.outer(size[seen], size[seen])) > SCORE_TEST.column_rank).sum()
    )


def _noise(view: View, columns: FloatArray, other: FloatArray) -> Noise:
    """Spread of T by the level of the noise here and on the other motion, and T at each of GRID allowed for it."""
    spread, bounded = _bounded(view.evidence, columns)
    return spread, spread if view.other is None else _bounded(view.other, other)[0], bounded


def _bounded(evidence: Evidence, columns: FloatArray) -> tuple[float, FloatArray]:
    """Spread of T by the level of the noise, and T at each of GRID, allowed for it (see Evidence.bounded).

    The level of a band is told by d / 2 lines, on the log that the limit is told of and on that which has the effect:
    the variance of each logarithm is 2 / d. The median of lines knows it less well, the autoregressive filter and
    neighbouring bands better: over ten noises of a blind machine ln lambda of eleven effects spread by 0.07 to 0.43, by
    0.5 to 1.3 times as much as this says, by 1.0 times where it is largest.
    """
    parts = [evidence.band_powers(column) for column in columns]
    share, freedoms = np.sum([part for part, _ in parts], axis=0), parts[0][1]
    total = float(np.sum(share))
    if total <= 0.0:
        return 0.0, GRID
    share = share / total
    d = np.maximum(freedoms - len(columns) * share, 1.0)
    spread = float(np.sqrt(2.0 * np.sum(share**2 * 2.0 / d)))
    return spread, np.minimum(GRID, (d * np.log1p(GRID[:, None] * share / d)).sum(axis=1))
