"""Every effect of the list tried on the evidence, each at its best shape."""

from __future__ import annotations

import os
from collections.abc import Mapping, Sequence
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from cogging._core import EFFECTS, DivergedError
from cogging.arrays import FloatArray
from cogging.diagnosis.candidates.intervals import intervals, long_enough
from cogging.diagnosis.candidates.signatures import Candidate, candidates, quantities, shape_range, tables
from cogging.diagnosis.candidates.waves import beside_known, is_spatial_wave, is_wave, peaks, refine
from cogging.diagnosis.evidence.evidence import Evidence, Test
from cogging.diagnosis.evidence.log_p_value import log_survival

STANDS_OUT = -3.0  # ln of the chance
HOPE = -6.0  # of the score, from which a sharper shape may yet make something of it
ROUNDS = {False: 3, True: 6}  # of moving one shape; where the shape alone makes the effect, it is also its size
COUNTS = 0.06  # of the encoder, that a wave in its reading must have: on 281 blind nulls rounding made one of 0.03
REFINED = 4  # peaks of a spectrum whose width is looked through
PROFILED = 8  # findings that are judged against the noise that they leave
PROMISING = 6.0  # T from which that is worth the time
NEAR = 60.0  # of the score: what is farther from the best is not looked at more closely


@dataclass(frozen=True)
class Finding:
    """An effect at its best shape.

    Attributes:
        candidate: effect and shape.
        test: score test of its columns.
        amplitudes: what the effect would need, (p,); (1,) near 1 where the shape alone makes it.
        trials: number of independent shapes that were tried (the look-elsewhere effect).
        log_p_value: ln of the probability that noise alone shows as much anywhere in this scan.
        score: 2 ln likelihood, less what the free parameters and the number of trials cost.
        faint: whether it is a wave in the reading so small that rounding may have made it: no effect.
    """

    candidate: Candidate
    test: Test
    amplitudes: FloatArray
    trials: float
    log_p_value: float
    score: float
    faint: bool = False

    @property
    def name(self) -> str:
        """Of the effect."""
        return self.candidate.name

    def effect(self) -> object:
        """The effect with its amplitudes."""
        return self.candidate.effect([float(a) for a in self.amplitudes] if self.candidate.amplitudes else [])


def judge(
    evidence: Evidence, candidate: Candidate, columns: FloatArray, trials: float, exact: bool = False
) -> Finding | None:
    """Test one candidate; None where what it would take is not physical.

    An effect that its shape alone makes is a column of finite size. On the grid that size is free; when `exact`, it
    is as the shape says, for a lag of half the time constant taken twice would else pass for a delay.
    """
    test = evidence.test(columns)
    if test.freedom == 0:
        return None
    if exact and not candidate.amplitudes:
        size = test.statistic / float(test.amplitudes[0]) ** 2
        value = test.statistic - size * (1.0 + float(test.amplitudes[0])) ** 2
        test = replace(test, statistic=max(value, 0.0), amplitudes=-np.ones(1))
    amplitudes = -test.amplitudes
    if candidate.amplitudes:
        sizes = quantities(evidence)
        for (field, _), value in zip(candidate.amplitudes, amplitudes, strict=True):
            role = EFFECTS[candidate.name].ROLES[field]
            if not role["low"] <= value / sizes[role["quantity"]] <= role["high"]:
                return None
    elif not size_range(candidate)[0] < amplitudes[0] < size_range(candidate)[1]:
        return None  # the finite size that was tried is not what the log shows
    # What rounding does at a steady speed repeats itself too, and is far smaller than a count.
    count = evidence.model.encoder.resolution if "reading" in EFFECTS[candidate.name].HOOKS else 0.0
    faint = len(amplitudes) > 1 and bool(np.linalg.norm(amplitudes) < COUNTS * count)
    return _finding(candidate, test, amplitudes, trials, faint)


def _finding(candidate: Candidate, test: Test, amplitudes: FloatArray, trials: float, faint: bool) -> Finding:
    shapes = sum(
        1
        for field, role in EFFECTS[candidate.name].ROLES.items()
        if role["role"] == "shape" and not isinstance(candidate.shape.get(field), list)
    )
    looking = float(np.log(max(trials, 1.0)))
    return Finding(
        candidate,
        test,
        amplitudes,
        trials,
        min(0.0, log_survival(test.statistic, test.freedom) + looking),
        test.statistic - 2.0 * test.freedom - 2.0 * looking - shapes,
        faint,
    )


def bounded(evidence: Evidence, finding: Finding) -> Finding:
    """The finding with what its statistic is worth when the level of the noise is known from few lines only."""
    value = min(finding.test.statistic, evidence.bounded(finding.test))
    return _finding(
        finding.candidate, replace(finding.test, statistic=value), finding.amplitudes, finding.trials, finding.faint
    )


def cleaned(evidence: Evidence, finding: Finding) -> Evidence:
    """The evidence with filters estimated from what an effect leaves."""
    made = tables(evidence, [finding.candidate])[0]
    weights = finding.amplitudes if finding.candidate.amplitudes else np.ones(1)
    return evidence.cleaned([-(weights @ table) for table in made])


def profiled(evidence: Evidence, findings: Sequence[Finding]) -> list[Finding]:
    """The findings, the likeliest each against the noise that it would leave itself, best score first.

    What is missing makes the residual louder where it acts: measured against that, no effect at low frequencies would
    ever stand out. Each is given the level of noise that is left once it is taken away, and the level's own freedom.
    """
    ranked = [bounded(evidence, finding) for finding in sorted(findings, key=lambda f: -f.score)]

    def sharper(finding: Finding) -> Finding:
        if finding.test.statistic <= PROMISING:
            return finding
        quiet = cleaned(evidence, finding)
        again = [bounded(quiet, f) for f in judged(quiet, [finding.candidate], finding.trials, exact=True)]
        return max([finding, *again], key=lambda f: f.score)

    with ThreadPoolExecutor(os.cpu_count()) as threads:
        first = list(threads.map(sharper, ranked[:PROFILED]))
    return sorted([*first, *ranked[PROFILED:]], key=lambda f: -f.score)


def size_range(candidate: Candidate) -> tuple[float, float]:
    """By how much a finite column may be multiplied on the grid: far, where a shape starts from nothing in proportion.

    From there the search begins, with the effect as its shape says (see begun).
    """
    roles = EFFECTS[candidate.name].ROLES
    proportional = any(roles[f]["role"] == "shape" and roles[f]["neutral"] == 0.0 for f in candidate.shape)
    return (0.02, 50.0) if proportional else (0.25, 2.5)


def scan(evidence: Evidence, names: Sequence[str] | None = None) -> list[Finding]:
    """The best shape of each effect, best score first; beside it the best faint one, where there is one.

    Effects are tried on as many threads as there are cores (core, FFT and BLAS let others go on); what is found does
    not depend on how many.
    """
    best: dict[tuple[str, bool], Finding] = {}
    wanted = list(EFFECTS if names is None else names)
    periods: dict[float, float] = {}  # of the waves along the travel that stand out, and among how many they do
    _ = evidence.scales, evidence.overdispersion  # made here once, not by every thread
    with ThreadPoolExecutor(os.cpu_count()) as threads:
        for waves in (True, False):  # the waves first: the others look at their periods too
            tried = [name for name in wanted if is_wave(EFFECTS[name]) == waves]
            for name, found in zip(tried, threads.map(lambda one: _of(evidence, one, periods), tried), strict=True):
                for finding in found:
                    kind = (name, finding.faint)
                    if kind not in best or finding.score > best[kind].score:
                        best[kind] = finding
            for name in tried if waves else ():
                wave = best.get((name, False))
                if wave is not None and is_spatial_wave(EFFECTS[name]) and wave.log_p_value < STANDS_OUT:
                    periods[float(next(iter(wave.candidate.shape.values())))] = wave.trials
        faint = [finding for finding in best.values() if finding.faint]
        ranked = sorted((finding for finding in best.values() if not finding.faint), key=lambda f: -f.score)
        if not ranked:
            return faint
        top = ranked[0].score
        sharpened = list(
            threads.map(
                lambda f: sharpen(evidence, f) if f.score > top - NEAR and f.score > HOPE else f,
                ranked,
            )
        )
    return sorted([*sharpened, *faint], key=lambda f: -f.score)


def _of(evidence: Evidence, name: str, periods: Mapping[float, float]) -> list[Finding]:
    if is_wave(EFFECTS[name]):
        found, trials = peaks(evidence, name)
        found += beside_known(evidence, name)
        first = sorted(judged(evidence, found, trials), key=lambda f: (f.faint, -f.score))
        return first + judged(evidence, refine(evidence, [f.candidate for f in first[:REFINED]]), trials)
    grid = list(candidates(evidence, name, list(periods)))
    chosen = [one for one in grid if one.shape.get("period") in periods]  # by the waves, which looked at many
    others, trials = intervals(evidence, name, [one for one in grid if one.shape.get("period") not in periods])
    trials = max(trials, float(len(grid)))
    results = judged(evidence, others, trials) + judged(evidence, chosen, trials + max(periods.values(), default=0.0))
    if not grid or grid[0].amplitudes:
        return results
    # The sizes that the grid left free are where to begin: of a large delay a tenth is no small delay.
    return judged(evidence, [begun(one) for one in results], trials, exact=True)


def begun(finding: Finding) -> Candidate:
    """The candidate with its free size put into the first shape that starts from nothing, if one does."""
    roles, shape = EFFECTS[finding.name].ROLES, finding.candidate.shape
    for field, value in shape.items():
        if roles[field]["role"] == "shape" and roles[field]["neutral"] == 0.0:
            return replace(finding.candidate, shape={**shape, field: value * float(finding.amplitudes[0])})
    return finding.candidate


def judged(evidence: Evidence, found: Sequence[Candidate], trials: float, exact: bool = False) -> list[Finding]:
    """Test candidates; those that cannot be simulated or are not physical are left out."""
    if not found:
        return []
    try:
        made = tables(evidence, found)
    except (DivergedError, ValueError):
        if len(found) == 1:
            return []
        return [f for one in found for f in judged(evidence, [one], trials, exact)]
    columns = evidence.whitened_each(made)
    results = [judge(evidence, c, w, trials, exact) for c, w in zip(found, columns, strict=True)]
    return [result for result in results if result is not None]


def in_range(evidence: Evidence, role: dict[str, Any], value: float) -> bool:
    """Whether a shape stays where its effect says that it is to be looked for."""
    if role["quantity"] == "position":
        return True
    low, high = shape_range(evidence, role)
    if role["logarithmic"] or role["neutral"] == 0.0:
        return bool((0.5 * low if role["logarithmic"] else 0.0) < value <= 1.01 * high)
    return bool(0.99 * low <= value <= 1.01 * high)


def sharpen(evidence: Evidence, finding: Finding) -> Finding:
    """Move the shape to where it explains most: steps of each shape parameter that shrink."""
    roles = EFFECTS[finding.name].ROLES
    fields = [f for f, v in finding.candidate.shape.items() if roles[f]["role"] == "shape" and isinstance(v, float)]
    if not fields:
        return finding
    wave = is_wave(EFFECTS[finding.name])
    exact = not finding.candidate.amplitudes
    ratio = 0.35
    for _ in range(ROUNDS[exact] + 4 * (len(fields) - 1)):
        tried = []
        for field in fields:
            value = finding.candidate.shape[field]
            role = roles[field]
            sizes = quantities(evidence)
            for sign in (-1.0, 1.0):
                if wave:
                    span = evidence.scales.position if role["quantity"] == "distance" else evidence.scales.time
                    turns = (span / value if role["quantity"] == "distance" else span * value) + 0.2 * sign * ratio
                    moved = span / turns if role["quantity"] == "distance" else turns / span
                elif role["logarithmic"] or role["neutral"] == 0.0:
                    moved = value * float(np.exp(sign * ratio))
                else:
                    moved = value + sign * 0.25 * ratio * sizes[role["quantity"]] * (role["high"] - role["low"])
                if in_range(evidence, role, moved):
                    shape = {**finding.candidate.shape, field: moved}
                    if long_enough(shape):
                        tried.append(replace(finding.candidate, shape=shape))
        better = [f for f in judged(evidence, tried, finding.trials, exact) if f.score > finding.score]
        if better:
            finding = max(better, key=lambda f: f.score)
        else:
            ratio *= 0.4
    return finding
