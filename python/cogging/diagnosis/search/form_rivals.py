"""Rivals by another law of the same cause: what a name's margin is worth when shapes are drawn, not given."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from cogging._core import DivergedError
from cogging.arrays import FloatArray
from cogging.diagnosis.candidates.findings import Finding, compared
from cogging.diagnosis.candidates.forms import Form, form_of
from cogging.diagnosis.candidates.tables import tables
from cogging.diagnosis.candidates.waves import is_wave
from cogging.diagnosis.evidence.evidence import Evidence
from cogging.diagnosis.evidence.score_test import ScoreTest, cosine
from cogging.diagnosis.thresholds import CHOICE, FORM
from cogging.effects.effect import Effect


def with_forms(
    rivals: Sequence[Finding], findings: Sequence[Finding], evidence: Evidence, confirm: Evidence | None
) -> list[Finding]:
    """The rivals of a choice, the chosen first, with those that explain as much once their law is free.

    Args:
        rivals: the chosen finding and what explains about as much as its law says (choose).
        findings: of the scan.
        evidence: what they were found in.
        confirm: evidence of the confirm logs; None without.

    The chosen one is judged with its own law free too: what joins the rivals must come near to that. A form
    costs FORM.cost for each of its columns.
    """
    chosen = rivals[0]
    best = freed(chosen, evidence, confirm)
    top = max(chosen.score, -np.inf if best is None else best.score)
    # What is as near with the plainest laws stays as near: a free law of the chosen one is no word against it.
    near = {rival.name: replace(rival, score=rival.score + top - chosen.score) for rival in rivals[1:]}
    for finding in findings:
        if finding.name == chosen.name or is_wave(finding.candidate.law):
            continue
        again = freed(finding, evidence, confirm)
        if again is None or cosine(again.test.explained, chosen.test.explained) < CHOICE.like:
            continue
        known = near.get(finding.name)
        if again.score > top - FORM.contender and (known is None or again.score > known.score):
            near[finding.name] = again
    return [replace(chosen, score=top), *sorted(near.values(), key=lambda one: -one.score)]


def freed(finding: Finding, evidence: Evidence, confirm: Evidence | None) -> Finding | None:
    """The finding with its law free, its score with what other motion says; None where it has one law only."""
    form = form_of(finding.effect(), evidence)
    if form is None:
        return None
    test = evidence.test(evidence.whitened(_with(finding, form, evidence)))
    test = replace(test, statistic=min(test.statistic, evidence.bounded(test)))
    if test.statistic <= finding.test.statistic:
        return None
    own = max(1, len(finding.candidate.amplitudes))
    cost = FORM.cost * max(0, test.freedom - own)
    gain = 0.0 if confirm is None else gain_of(test, _with(finding, form, confirm), confirm)
    score = compared(finding.score + test.statistic - finding.test.statistic - cost + gain)
    return replace(finding, test=test, score=score)


def law_instead(finding: Finding, added: Sequence[Effect], evidence: Evidence) -> str | None:
    """Name of an effect in the model whose law, were it free, would explain as much as a finding of another name."""
    for effect in added:
        form = None if finding.name == effect.NAME else form_of(effect, evidence)
        if form is None:
            continue
        test = evidence.test(evidence.whitened(form.tables(evidence)))
        score = min(test.statistic, evidence.bounded(test)) - FORM.cost * test.freedom
        if score >= finding.score and cosine(test.explained, finding.test.explained) > CHOICE.like:
            return effect.NAME
    return None


def _with(finding: Finding, form: Form, evidence: Evidence) -> list[FloatArray]:
    """Columns of the effect as its law says, and of its form, in each log."""
    own = tables(evidence, [finding.candidate])[0]
    return [np.vstack(pair) for pair in zip(own, form.tables(evidence), strict=True)]


def gain_of(test: ScoreTest, made: Sequence[FloatArray], evidence: Evidence) -> float:
    """Gain of 2 ln likelihood on other motion with the amplitudes of a test frozen, no loss above CHOICE.loss_max."""
    try:
        predicted = test.amplitudes @ evidence.project(evidence.whitened(made))
    except (DivergedError, ValueError):
        return 0.0
    gain = float(2.0 * predicted @ evidence.free_residual - predicted @ predicted) / evidence.overdispersion
    return float(np.clip(gain, -CHOICE.loss_max, None))
