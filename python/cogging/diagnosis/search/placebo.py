"""Placebo terms: effects that were not found, fitted all the same; on other motion they must not help."""

from __future__ import annotations

from cogging.diagnosis.candidates.findings import Finding, compared
from cogging.diagnosis.entries import Placebo
from cogging.diagnosis.search.choice import alike
from cogging.diagnosis.search.confirmation import confirmation
from cogging.diagnosis.search.state import Search
from cogging.diagnosis.thresholds import ACCEPTANCE


def placebos(found: Search) -> tuple[Placebo, ...]:
    """The effects of the last scan that explain most of what is left without being significant, at their best shapes.

    Each is fitted to the logs like an effect that was found, and its amplitudes are frozen for the confirm logs.
    """
    named = {added.finding.name for added in found.added}
    chosen: list[Finding] = []
    for finding in sorted(found.unused, key=lambda one: -compared(one.test.statistic)):
        if finding.name in named or finding.log_p_value < ACCEPTANCE.placebo_suspected:
            continue
        if any(alike(finding, other) > ACCEPTANCE.placebo_like for other in chosen):
            continue
        chosen.append(finding)
        if len(chosen) == ACCEPTANCE.placebos_max:
            break
    told = []
    for finding in chosen:
        check = confirmation(found.confirm_evidence, finding)
        told.append(Placebo(finding.name, finding.test.statistic, None if check is None else check.gain))
    return tuple(told)
