"""What an effect leaves in a log, and which other effects leave nearly the same: computed from the core's list.

No effect is known by name here. Each stands in the middle of the shapes at which a search looks for it, at the size at
which it makes a stated share of the command, and acts on one small machine along two motions.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from coordinates import Place, places
from small_machine import MOTIONS, REST, left_by, machine, motion

import cogging
from cogging._core import DivergedError
from cogging.arrays import FloatArray
from cogging.diagnosis.candidates.findings import Finding, judged
from cogging.diagnosis.candidates.scan import begun, sharpen
from cogging.diagnosis.candidates.signatures import Candidate, place
from cogging.diagnosis.candidates.sizes import Size, directions, is_share, is_sought, likely_shapes, range_of, size_of
from cogging.diagnosis.evidence.evidence import Evidence
from cogging.diagnosis.evidence.null import nuisances
from cogging.diagnosis.experiment.observation import as_residual, evidence_of, looked_for
from cogging.diagnosis.thresholds import LIMIT
from cogging.effects.effect import VOCABULARY, Effect, Knots, kind_of

SECONDS_DRAWN = 24.0  # of that of a figure: so long that each place is passed at many times and speeds
SHARE = 0.05  # of the rms command: what the effect of a figure makes
SMALLEST = 1e-6  # of the strongest size: where the search for the size begins
NODES = 6  # of a list along the travel of which a search makes none
HOPE = 0.03  # share from which a better shape is looked for
TRIES = 12  # until the size is found, or the largest that the machine bears
CLOSE_ENOUGH = 0.02  # of that share
SEPARATES = 0.5  # share that a coordinate has to explain; below it the residual is drawn over time, close up


@dataclass(frozen=True)
class Signature:
    """What an effect leaves of a model without it, and what else would explain that.

    Attributes:
        effect: the effect, at the size of the figure.
        residual: what the model without it does not foresee along the last of MOTIONS, in rows in motion, without noise
            and encoder, V, (n,).
        rows: `time`, `position`, `velocity`, `acceleration` and `command` of the same rows, (n,).
        place: the coordinate that separates it best.
        confusion: by the name of each motion.
    """

    effect: Effect
    residual: FloatArray
    rows: Mapping[str, FloatArray]
    place: Place
    confusion: Mapping[str, Confusion]


@dataclass(frozen=True)
class Confusion:
    """What a search would take an effect for along a motion, with noise and encoder.

    Attributes:
        retuned: share of the power of what it leaves that re-tuning axis and map takes away.
        explained: name of each other effect and the share that it explains of what then remains, largest first.
    """

    retuned: float
    explained: tuple[tuple[str, float], ...]


def signature(law: Effect) -> Signature:
    """What an effect of the list leaves, and what else leaves nearly the same."""
    effect = _sized(law)
    residual, rows = left_by(effect, motion(list(MOTIONS)[-1], SECONDS_DRAWN))
    return Signature(
        effect, residual, rows, places(effect, residual, rows)[0], {name: _confused(effect, name) for name in MOTIONS}
    )


def _confused(effect: Effect, name: str) -> Confusion:
    """What else explains what an effect leaves along a motion."""
    model = machine()
    truth = model.replace(effects=(effect,))
    log = cogging.simulate(truth, motion(name), seed=1)
    evidence, signal = evidence_of(log, model, nuisances(model), REST, truth)
    seen = as_residual(evidence, signal)
    left = max(float(seen.free_residual @ seen.free_residual), 1e-300)
    shares = {other: _explained(seen, VOCABULARY[other], effect, left) for other in VOCABULARY if other != effect.NAME}
    retuned = 1.0 - left / max(float(signal @ signal), 1e-300)
    return Confusion(retuned, tuple(sorted(shares.items(), key=lambda item: -item[1])))


def _sized(law: Effect) -> Effect:
    """The effect in the middle of its shapes, at the size that leaves SHARE of the rms command, or its strongest."""
    model, course, size = machine(), motion(list(MOTIONS)[-1], SECONDS_DRAWN), size_of(law)
    assert size is not None, law.NAME
    empty = cogging.simulate(model, course, seed=1)
    evidence, _ = evidence_of(empty, model, nuisances(model), REST, model)
    candidate = _middle(evidence, law)
    goal = SHARE * float(np.sqrt(np.mean(empty.command**2)))
    weak, strong = range_of(evidence, law, size)
    weak = weak or SMALLEST * strong
    value = float(np.sqrt(weak * strong))
    for _ in range(TRIES):
        left = _rms_left(_at(candidate, size, value), course)
        if abs(left / goal - 1.0) < CLOSE_ENOUGH:
            return _at(candidate, size, value)
        weak, strong = (weak, value) if left > goal else (value, strong)
        guess = value * (goal / left if size.grows else left / goal) if 0.0 < left < np.inf else 0.0
        value = guess if min(weak, strong) < guess < max(weak, strong) else float(np.sqrt(weak * strong))
    return _at(candidate, size, weak)


def _rms_left(effect: Effect, course: Any) -> float:
    """What an effect leaves along a motion, V; infinite where it is stronger than the machine bears."""
    try:
        residual, _ = left_by(effect, course)
    except (DivergedError, ValueError):
        return float(np.inf)
    return float(np.sqrt(np.mean(residual**2)))


def _middle(evidence: Evidence, law: Effect) -> Candidate:
    """The effect in the middle of the shapes at which it may hide; lists of which a search makes none, along x."""
    if is_sought(law):
        shapes, _ = likely_shapes(evidence, law)
        return shapes[len(shapes) // 2]
    knots = kind_of(law, Knots)
    assert knots is not None, law.NAME
    nodes = [float(value) for value in np.linspace(*place(evidence), NODES)]
    columns = tuple((knots.levels, i) for i in range(NODES))
    return Candidate(law, {knots.nodes: nodes}, columns, (1.0,) * NODES)


def _at(candidate: Candidate, size: Size, value: float) -> Effect:
    """The effect of this size."""
    if not size.made_by_shape:
        return candidate.effect([float(part) for part in value * directions(candidate)[0]])
    shares = {
        field: LIMIT.share_behind
        for field, role in candidate.law.ROLES.items()
        if role["role"] == "shape" and is_share(role) and field != size.field
    }
    return replace(candidate, shape={**candidate.shape, **shares, size.field: value}).effect()


def _explained(seen: Evidence, other: Effect, effect: Effect, left: float) -> float:
    """Share of what an effect leaves after re-tuning that another explains at its best shape and size."""
    if not is_sought(other):
        return 0.0
    findings = judged(seen, looked_for(seen, other, effect), 1.0)
    if not findings:
        return 0.0
    best = max(findings, key=lambda finding: finding.score)
    if not best.candidate.amplitudes:
        known = judged(seen, [begun(best)], 1.0, exact=True)
        best = known[0] if known else best
    share = _share(best, left)
    return _share(sharpen(seen, best), left) if share > HOPE else share


def _share(finding: Finding, left: float) -> float:
    """Of the power that was left, what a finding explains."""
    explained = finding.test.explained
    return float(min(1.0, explained @ explained / left))
