"""Friction near rest that is not the model's, where no motion in the logs can tell which law it has instead."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from cogging.diagnosis.entries import NearRest
from cogging.diagnosis.evidence.evidence import Evidence
from cogging.diagnosis.evidence.gather import slow_shapes, slow_width
from cogging.diagnosis.evidence.log_p_value import log_survival
from cogging.diagnosis.evidence.score_test import ScoreTest, orthonormal
from cogging.diagnosis.search.state import Search
from cogging.diagnosis.thresholds import NEAR_REST
from cogging.effects.effect import Effect, Knots, kind_of


def near_rest(found: Search) -> NearRest | None:
    """What the logs say of friction near rest beyond the model's law; None where that is nothing, or has a name.

    Shapes of friction that fade within some widths are re-tuned in every test, since nobody states them so well: what
    sticks, gives way over some micrometres or falls with speed all look like them. They are no missing effect, but
    where these logs and the confirm logs both show them, the model's law is not that of the axis.
    """
    if any(is_friction_at_rest(added.finding.candidate.law) for added in found.added):
        return None
    if found.evidence.rounding > NEAR_REST.rounded:
        return None  # readings that step as slowly as the axis creeps look like friction
    test = slow_test(found.evidence)
    mine = log_survival(test.statistic, test.freedom) if test.freedom else 0.0
    its = None
    if found.confirm_evidence is not None:
        again = slow_test(found.confirm_evidence)
        its = log_survival(again.statistic, again.freedom) if again.freedom else 0.0
    if mine > (NEAR_REST.slow_alone if its is None else NEAR_REST.slow_shown):
        return None
    if its is not None and its > NEAR_REST.slow_again:
        return None
    source = found.evidence.sources[0]
    fastest = NEAR_REST.creep_widths * slow_width(source, found.evidence.model)
    return NearRest(
        float(test.statistic),
        test.freedom,
        mine,
        its,
        tuple(sorted(name for name, law in found.vocabulary.items() if is_friction_at_rest(law))),
        f"creep at five steady speeds or more from {NEAR_REST.creep * source.rest:.2g} to {fastest:.2g} m/s in both "
        "directions, and small reversals at rest, of some counts of the encoder: presliding shows in the reversals, "
        "Stribeck friction in the creep, another width of friction in neither",
    )


def is_friction_at_rest(law: Effect) -> bool:
    """Whether an effect is one of friction near rest: of a level that goes with speed, or of a spring before motion."""
    asked = {role["quantity"] for role in law.ROLES.values() if role["role"] != "setting"}
    level = "friction_level" in law.HOOKS and "velocity" in asked and kind_of(law, Knots) is None
    return level or ("state" in law.HOOKS and "stiffness" in asked)


def slow_test(evidence: Evidence) -> ScoreTest:
    """Score test of the shapes of slow friction, beside all else that is free.

    They are the last of the columns that a fit of the evidence may move (evidence.gather).
    """
    count = len(slow_shapes(np.zeros(1), 1.0))
    without = replace(evidence, basis=orthonormal(evidence.columns[:-count]))
    test = without.test(evidence.columns[-count:])
    return replace(test, statistic=min(test.statistic, without.bounded(test)))
