"""Findings: candidates judged by their score tests, each also against the noise that it leaves."""

from __future__ import annotations

import os
from collections.abc import Sequence
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass, replace

import numpy as np

from cogging._core import DivergedError
from cogging.arrays import FloatArray
from cogging.diagnosis.candidates.signatures import Candidate, quantities
from cogging.diagnosis.candidates.tables import in_groups, tables, whitened_group
from cogging.diagnosis.evidence.evidence import Evidence
from cogging.diagnosis.evidence.gather import refiltered
from cogging.diagnosis.evidence.log_p_value import log_survival
from cogging.diagnosis.evidence.score_test import Explained, ScoreTest
from cogging.diagnosis.thresholds import FINDING
from cogging.effects.effect import Effect


@dataclass(frozen=True)
class Finding:
    """An effect at its best shape.

    Attributes:
        candidate: effect and shape.
        test: score test of its columns.
        amplitudes: amplitudes that the effect would need, (p,); (1,) near 1 where the shape alone makes it.
        trials: number of independent shapes that were tried (the look-elsewhere effect).
        log_p_value: ln of the probability that noise alone shows as much anywhere in this scan.
        score: 2 ln likelihood, less the penalties for free parameters and number of trials.
        faint: whether it is a wave in the reading so small that rounding may have made it: no effect.
    """

    candidate: Candidate
    test: ScoreTest
    amplitudes: FloatArray
    trials: float
    log_p_value: float
    score: float
    faint: bool = False

    @property
    def name(self) -> str:
        """Of the effect."""
        return self.candidate.name

    def effect(self) -> Effect:
        """The effect with its amplitudes."""
        return self.candidate.effect([float(a) for a in self.amplitudes] if self.candidate.amplitudes else [])


def compared(score: float) -> float:
    """A score, in 2 ln likelihood, by which effects are ranked: to a thousandth.

    What lies behind depends on the processor. Where two effects cannot be told apart, as a constant force and a Coulomb
    force that differs by direction in motion one way, the order of the list is the same everywhere.
    """
    return round(score, 3)


def judge(
    evidence: Evidence, candidate: Candidate, test: ScoreTest, trials: float, exact: bool = False
) -> Finding | None:
    """What the test of a candidate's columns says of it; None where what it would take is not physical.

    An effect that its shape alone makes is a column of finite size. On the grid that size is free; when `exact`, it
    is as the shape says, for a lag of half the time constant taken twice would else pass for a delay.
    """
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
            role = candidate.law.ROLES[field]
            if not role["low"] <= value / sizes[role["quantity"]] <= role["high"]:
                return None
    elif not size_range(candidate)[0] < amplitudes[0] < size_range(candidate)[1]:
        return None  # the finite size that was tried is not what the log shows
    # What rounding does at a steady speed repeats itself too, and is far smaller than a count.
    count = evidence.model.encoder.resolution if "reading" in candidate.law.HOOKS else 0.0
    faint = len(amplitudes) > 1 and bool(np.linalg.norm(amplitudes) < FINDING.faint_counts * count)
    return _finding(candidate, test, amplitudes, trials, faint)


def _finding(candidate: Candidate, test: ScoreTest, amplitudes: FloatArray, trials: float, faint: bool) -> Finding:
    shapes = sum(
        1
        for field, role in candidate.law.ROLES.items()
        if role["role"] == "shape" and not isinstance(candidate.shape.get(field), list)
    )
    looking = float(np.log(max(trials, 1.0)))
    return Finding(
        candidate,
        test,
        amplitudes,
        trials,
        min(0.0, log_survival(test.statistic, test.freedom) + looking),
        compared(test.statistic - 2.0 * test.freedom - 2.0 * looking - shapes),
        faint,
    )


def judged(evidence: Evidence, found: Sequence[Candidate], trials: float, exact: bool = False) -> list[Finding]:
    """Test candidates; those that cannot be simulated or are not physical are left out."""
    results: list[Finding] = []
    best: dict[tuple[str, bool], float] = {}
    for group in in_groups(found):
        try:
            columns, sizes = whitened_group(evidence, group)
        except (DivergedError, ValueError):
            if len(group) > 1:
                results += [f for one in group for f in judged(evidence, [one], trials, exact)]
            continue
        for candidate, test in zip(group, evidence.tests(columns, sizes), strict=True):
            finding = judge(evidence, candidate, test, trials, exact)
            if finding is not None:
                results.append(_with_its_part(evidence, finding, test, best))
    return results


def _with_its_part(
    evidence: Evidence, finding: Finding, test: ScoreTest, best: dict[tuple[str, bool], float]
) -> Finding:
    """The finding; what it explains is made now where it is the best of its kind so far.

    Of the others that is hardly ever asked, and would take as much memory as a column each: it is made again then.
    """
    kind = (finding.name, finding.faint)
    if finding.score > best.get(kind, -np.inf):
        best[kind] = finding.score
        _ = test.explained
    elif isinstance(test.part, Explained):
        candidate, amplitudes = finding.candidate, test.amplitudes
        test.part.made_by(lambda: explained_by(evidence, candidate, amplitudes))
    return finding


def explained_by(evidence: Evidence, candidate: Candidate, amplitudes: FloatArray) -> FloatArray:
    """What a candidate's columns explain of the whitened residual with these amplitudes (p,), (n,)."""
    column = evidence.whitened([amplitudes[None, :] @ table for table in tables(evidence, [candidate])[0]])
    return np.asarray(evidence.project(column)[0])


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
    return refiltered(evidence, [-(weights @ table) for table in made])


def profiled(evidence: Evidence, findings: Sequence[Finding]) -> list[Finding]:
    """The findings, the likeliest each against the noise that it would leave itself, best score first.

    What is missing makes the residual louder where it acts: measured against that, no effect at low frequencies would
    ever stand out. Each is given the level of noise that is left once it is taken away, and the level's own freedom.
    """
    ranked = [bounded(evidence, finding) for finding in sorted(findings, key=lambda f: -f.score)]

    def sharper(finding: Finding) -> Finding:
        if finding.test.statistic <= FINDING.worth_profiling:
            return finding
        quiet = cleaned(evidence, finding)
        again = [bounded(quiet, f) for f in judged(quiet, [finding.candidate], finding.trials, exact=True)]
        return max([finding, *again], key=lambda f: f.score)

    with ThreadPoolExecutor(os.cpu_count(), initializer=lambda: np.seterr(all="ignore")) as threads:
        first = list(threads.map(sharper, ranked[: FINDING.findings_profiled]))
    return sorted([*first, *ranked[FINDING.findings_profiled :]], key=lambda f: -f.score)


def size_range(candidate: Candidate) -> tuple[float, float]:
    """By how much a finite column may be multiplied on the grid: far, where a shape starts from nothing in proportion.

    From there the search begins, with the effect as its shape says (see begun).
    """
    roles = candidate.law.ROLES
    proportional = any(roles[f]["role"] == "shape" and roles[f]["neutral"] == 0.0 for f in candidate.shape)
    return FINDING.size_linear if proportional else FINDING.size_finite
