"""Every effect of the list tried on the evidence, each at its best shape."""

from __future__ import annotations

import os
from collections.abc import Iterable, Mapping
from concurrent.futures import ThreadPoolExecutor
from dataclasses import replace
from typing import Any

import numpy as np

from cogging.diagnosis.candidates.findings import Finding, judged
from cogging.diagnosis.candidates.intervals import intervals, long_enough
from cogging.diagnosis.candidates.signatures import Candidate, candidates, quantities, shape_range
from cogging.diagnosis.candidates.waves import beside_known, is_spatial_wave, is_wave, peaks, refine
from cogging.diagnosis.evidence.evidence import Evidence
from cogging.diagnosis.thresholds import SCAN
from cogging.effects.effect import Effect
from cogging.estimation.innovations import LINEAR_HOOKS


def scan(evidence: Evidence, laws: Iterable[Effect]) -> list[Finding]:
    """The best shape of each effect, best score first; beside it the best faint one, where there is one.

    Effects are tried on as many threads as there are cores (core, FFT and BLAS let others go on); what is found does
    not depend on how many.
    """
    best: dict[tuple[str, bool], Finding] = {}
    wanted = list(laws)
    periods: dict[float, float] = {}  # of the waves along the travel that stand out, and among how many they do
    _ = evidence.scales, evidence.overdispersion  # made here once, not by every thread
    with ThreadPoolExecutor(os.cpu_count(), initializer=lambda: np.seterr(all="ignore")) as threads:
        for waves in (True, False):  # the waves first: the others look at their periods too
            tried = [law for law in wanted if is_wave(law) == waves]
            # What takes long begins first, so that it is not what the others wait for.
            order = sorted(tried, key=lambda law: set(law.HOOKS) <= LINEAR_HOOKS)
            found = {law.NAME: threads.submit(_of, evidence, law, periods) for law in order}
            for law in tried:
                for finding in found[law.NAME].result():
                    kind = (law.NAME, finding.faint)
                    if kind not in best or finding.score > best[kind].score:
                        best[kind] = finding
            for law in tried if waves else ():
                wave = best.get((law.NAME, False))
                if wave is not None and is_spatial_wave(law) and wave.log_p_value < SCAN.stands_out:
                    periods[float(next(iter(wave.candidate.shape.values())))] = wave.trials
        faint = [finding for finding in best.values() if finding.faint]
        ranked = sorted((finding for finding in best.values() if not finding.faint), key=lambda f: -f.score)
        if not ranked:
            return faint
        top = ranked[0].score
        sharpened = list(
            threads.map(
                lambda f: sharpen(evidence, f) if f.score > top - SCAN.sharpened_within and f.score > SCAN.hope else f,
                ranked,
            )
        )
    return sorted([*sharpened, *faint], key=lambda f: -f.score)


def _of(evidence: Evidence, law: Effect, periods: Mapping[float, float]) -> list[Finding]:
    if is_wave(law):
        found, trials = peaks(evidence, law)
        found += beside_known(evidence, law)
        first = sorted(judged(evidence, found, trials), key=lambda f: (f.faint, -f.score))
        return first + judged(evidence, refine(evidence, [f.candidate for f in first[: SCAN.peaks_refined]]), trials)
    grid = list(candidates(evidence, law, list(periods)))
    chosen = [one for one in grid if one.period in periods]  # by the waves, which looked at many
    others, trials = intervals(evidence, law, [one for one in grid if one.period not in periods])
    trials = max(trials, float(len(grid)))
    results = judged(evidence, others, trials) + judged(evidence, chosen, trials + max(periods.values(), default=0.0))
    if not grid or grid[0].amplitudes:
        return results
    # The sizes that the grid left free are where to begin: of a large delay a tenth is no small delay.
    return judged(evidence, [begun(one) for one in results], trials, exact=True)


def begun(finding: Finding) -> Candidate:
    """The candidate with its free size put into the first shape that starts from nothing, if one does."""
    roles, shape = finding.candidate.law.ROLES, finding.candidate.shape
    for field, value in shape.items():
        if roles[field]["role"] == "shape" and roles[field]["neutral"] == 0.0:
            return replace(finding.candidate, shape={**shape, field: value * float(finding.amplitudes[0])})
    return finding.candidate


def in_range(evidence: Evidence, role: Mapping[str, Any], value: float) -> bool:
    """Whether a shape stays where its effect says that it is to be looked for."""
    if role["quantity"] == "position":
        return True
    low, high = shape_range(evidence, role)
    if role["logarithmic"] or role["neutral"] == 0.0:
        return bool(
            (SCAN.below_range * low if role["logarithmic"] else 0.0) < value <= (1.0 + SCAN.outside_range) * high
        )
    return bool((1.0 - SCAN.outside_range) * low <= value <= (1.0 + SCAN.outside_range) * high)


def sharpen(evidence: Evidence, finding: Finding) -> Finding:
    """Move the shape to where it explains most: steps of each shape parameter that shrink."""
    roles = finding.candidate.law.ROLES
    fields = [f for f, v in finding.candidate.shape.items() if roles[f]["role"] == "shape" and isinstance(v, float)]
    if not fields:
        return finding
    wave = is_wave(finding.candidate.law)
    exact = not finding.candidate.amplitudes
    ratio = SCAN.first_step
    rounds = SCAN.rounds_of_size if exact else SCAN.rounds
    for _ in range(rounds + SCAN.rounds_more * (len(fields) - 1)):
        tried = []
        for field in fields:
            value = finding.candidate.shape[field]
            role = roles[field]
            sizes = quantities(evidence)
            for sign in (-1.0, 1.0):
                if wave:
                    span = evidence.scales.position if role["quantity"] == "distance" else evidence.scales.time
                    turns = span / value if role["quantity"] == "distance" else span * value
                    turns += SCAN.wave_step * sign * ratio
                    moved = span / turns if role["quantity"] == "distance" else turns / span
                elif role["logarithmic"] or role["neutral"] == 0.0:
                    moved = value * float(np.exp(sign * ratio))
                else:
                    step = sign * SCAN.linear_step * ratio
                    moved = value + step * sizes[role["quantity"]] * (role["high"] - role["low"])
                if in_range(evidence, role, moved):
                    shape = {**finding.candidate.shape, field: moved}
                    if long_enough(finding.candidate.law, shape):
                        tried.append(replace(finding.candidate, shape=shape))
        better = [f for f in judged(evidence, tried, finding.trials, exact) if f.score > finding.score]
        if better:
            finding = max(better, key=lambda f: f.score)
        else:
            ratio *= SCAN.step_shrinks
    return finding
