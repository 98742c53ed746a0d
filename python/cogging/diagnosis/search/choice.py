"""The choice among findings: which stand out, which confirm logs refute, and which of several alike is the one."""

from __future__ import annotations

from collections.abc import Collection, Sequence
from dataclasses import replace

import numpy as np

from cogging.diagnosis.candidates.findings import Finding, compared, judged
from cogging.diagnosis.candidates.intervals import acts_in_interval
from cogging.diagnosis.candidates.waves import is_spatial_wave, is_wave
from cogging.diagnosis.evidence.evidence import Evidence
from cogging.diagnosis.evidence.gather import gather
from cogging.diagnosis.evidence.score_test import cosine
from cogging.diagnosis.search.confirmation import Confirmation, confirmation
from cogging.diagnosis.thresholds import CHOICE, CONFIRMATION
from cogging.estimation.gauss_newton import Estimate


def told_apart(findings: Sequence[Finding]) -> tuple[list[Finding], list[Finding]]:
    """Findings, and those that rounding may have made."""
    return [f for f in findings if not f.faint], [f for f in findings if f.faint]


def is_rounding(finding: Finding, faint: Sequence[Finding]) -> bool:
    """Whether a wave in the reading that rounding may have made explains more of what a finding does."""
    return any(other.score > finding.score and alike(other, finding) > CHOICE.like for other in faint)


def is_seen(finding: Finding, check: Confirmation | None, power: float, other_power: float) -> bool:
    """Whether an effect stands out of the logs, or of both motions together, and is worth a name there.

    Args:
        finding: the effect in the logs.
        check: its test on the other motion.
        power, other_power: power of the residuals below 60 Hz, in the logs and in the other motion (low_power).
    """
    if finding.log_p_value <= CHOICE.detected:
        return finding.test.statistic >= CHOICE.worth * power
    if check is None or finding.log_p_value + check.log_p_value > CHOICE.joint:
        return False
    return check.shown >= CHOICE.worth * other_power


def needed(finding: Finding) -> float:
    """Log p-value below which an effect must lie where the confirm logs cannot show it."""
    effect = finding.candidate.law
    return CHOICE.slippery if acts_in_interval(effect) or "friction_level" in effect.HOOKS else CHOICE.unshown


def refusal(finding: Finding, check: Confirmation | None) -> str | None:
    """Why other motion refuses a finding; None where it does not."""
    if check is None:
        return None
    if check.refuted:
        return f"other motion shows {check.ratio:.2f} of what was foreseen"
    if check.noncentrality < CONFIRMATION.informative and finding.log_p_value > needed(finding):
        return f"the other motion cannot show it (lambda {check.noncentrality:.1f})"
    return None


def worths(estimate: Estimate, evidence: Evidence, findings: Sequence[Finding]) -> dict[str, float]:
    """What each effect explains of the gap itself, as T of rows that are not whitened; empty where none stands out.

    Where the evidence is overwhelming, every imperfection of the model is significant: then that is the order to take.
    """
    if max((f.score for f in findings), default=0.0) < CHOICE.overwhelming:
        return {}
    plain = gather(estimate, evidence.sources, memory=evidence.memory, plain=True)
    worth = {}
    for finding in findings:
        if finding.log_p_value < CHOICE.detected:
            again = judged(plain, [finding.candidate], 1.0)
            worth[finding.name] = compared(again[0].test.statistic) if again else 0.0
    return worth


def choose(
    findings: Sequence[Finding],
    best: Finding,
    check: Confirmation | None,
    confirm_evidence: Evidence | None,
    barred: set[str],
    worth: dict[str, float],
    unpaid: Collection[str] = (),
) -> tuple[list[Finding], Finding, Confirmation | None]:
    """Of the effects that explain about as much, the one that both motions favour; and those within reach of it.

    One that was refused because it does not pay (`unpaid`) is not chosen again, but what comes in its place may be it.
    """
    reach = max(CHOICE.reach, CHOICE.form * best.test.statistic)
    seen = CHOICE.near_best if best.log_p_value < CHOICE.detected else CHOICE.possible
    near = [
        f
        for f in findings
        if f is best
        or (
            f.score > best.score - reach
            and f.name not in barred
            and f.log_p_value < seen
            and alike(f, best) > CHOICE.like
        )
    ]
    checks = {f.name: check if f is best else confirmation(confirm_evidence, f) for f in near}

    def gain(f: Finding) -> float:
        c = checks[f.name]
        return 0.0 if c is None else float(np.clip(c.gain, -CHOICE.loss_max, None))

    standing = [f for f in near if f is best or not (checks[f.name] is not None and checks[f.name].refuted)]  # type: ignore[union-attr]
    ranked = sorted(
        standing, key=lambda f: compared(worth.get(f.name, 0.0 if worth else f.score) + gain(f)), reverse=True
    )
    chosen = plainer([f for f in ranked if f.name not in unpaid or f is best])
    top = max(f.score + gain(f) for f in ranked)
    rivals = [
        replace(chosen, score=top),
        *(replace(f, score=f.score + gain(f)) for f in ranked if f is not chosen),
    ]
    return rivals, chosen, checks[chosen.name]


def plainer(ranked: Sequence[Finding]) -> Finding:
    """The likeliest finding, or a plainer one that explains nearly as much.

    Many amplitudes along the travel always explain more: an effect of one or two that explains nearly all of it comes
    first, and of a period that the model has not, the plain wave that is most of it.
    """
    first = ranked[0]
    if len(first.candidate.amplitudes) > CHOICE.many:
        for other in ranked[1:]:
            if (
                len(other.candidate.amplitudes) <= CHOICE.few
                and other.test.statistic > CHOICE.nearly * first.test.statistic
            ):
                return other
    period = first.candidate.period
    if period is None or is_wave(first.candidate.law) or len(first.candidate.amplitudes) <= CHOICE.few:
        return first
    for other in ranked[1:]:
        if is_spatial_wave(other.candidate.law) and other.candidate.law.HOOKS == first.candidate.law.HOOKS:
            other_period = other.candidate.period or 0.0
            if (
                abs(other_period / period - 1.0) < CHOICE.same_period
                and other.test.statistic > CHOICE.mostly * first.test.statistic
            ):
                return other
    return first


def alike(one: Finding, other: Finding) -> float:
    """Cosine between the parts of the residual that two findings explain."""
    return cosine(one.test.explained, other.test.explained)
