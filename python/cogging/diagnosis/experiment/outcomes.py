"""What became of a planned experiment: its expectations held against the logs that were made."""

from __future__ import annotations

import os
from collections.abc import Mapping, Sequence
from dataclasses import replace
from typing import Any

import numpy as np

from cogging.calls import PATH, Kind
from cogging.diagnosis.candidates.findings import Finding, cleaned, judged, profiled
from cogging.diagnosis.candidates.scan import scan
from cogging.diagnosis.candidates.tables import tables
from cogging.diagnosis.entries import Outcome
from cogging.diagnosis.evidence.evidence import Evidence
from cogging.diagnosis.evidence.score_test import orthonormal
from cogging.diagnosis.experiment.detection import Detection
from cogging.diagnosis.experiment.expectation import Expectation
from cogging.diagnosis.experiment.experiment_plan import ExperimentPlan, plan_path
from cogging.diagnosis.experiment.observation import band_powers, gram_of, left_by, looked_for
from cogging.diagnosis.experiment.result_file import read_json
from cogging.diagnosis.experiment.rivals import CHANGES
from cogging.diagnosis.result import Diagnosis
from cogging.diagnosis.search.state import Search
from cogging.diagnosis.thresholds import EXPERIMENT
from cogging.effects.effect import Effect
from cogging.files import FieldError, InputError

PLANNED = Kind((ExperimentPlan, Mapping, type(None), *PATH), "an ExperimentPlan or the path of its reference file")


def read_plan(planned: ExperimentPlan | Mapping[str, Any] | str | os.PathLike[str] | None) -> list[Expectation]:
    """What a plan expects, from the plan or from the file beside the reference that it was written to.

    Raises:
        InputError: the file cannot be read or is no plan.
        FieldError: a ValueError: what was given is no plan.
    """
    if planned is None:
        return []
    if isinstance(planned, ExperimentPlan):
        return list(planned.expected)
    if isinstance(planned, Mapping):
        return _expectations(planned)
    path = plan_path(planned)
    document = read_json(path, "the plan of cogging experiment")
    try:
        return _expectations(document)
    except FieldError as error:
        raise InputError(f"{path}: {error}") from None


def _expectations(document: Mapping[str, Any]) -> list[Expectation]:
    """The expectations of a plan.

    Raises:
        FieldError: a ValueError that names field, rule and value.
    """
    entries = document.get("expected")
    if not isinstance(entries, list):
        raise FieldError("", "expected", "must be the list of what a plan expects, got none")
    return [Expectation.from_dict(entry, f"expected[{i}]") for i, entry in enumerate(entries)]


def with_outcomes(result: Diagnosis, expected: Sequence[Expectation], found: Search) -> Diagnosis:
    """A result that says what became of each expectation, by what the search found."""
    return replace(result, planned=outcomes(expected, found)) if expected else result


def outcomes(expected: Sequence[Expectation], found: Search) -> tuple[Outcome, ...]:
    """What became of each expectation, by what a search found in the logs."""
    evidence, vocabulary = found.nominal_evidence, found.vocabulary
    wanted = {one.name for one in expected if one.parameter}
    limits = _limits(evidence, {name: law for name, law in vocabulary.items() if name in wanted}, found)
    halves = {path: float(half) for path, half in zip(found.nominal.paths, found.nominal.half_width, strict=True)}
    told = []
    for one in expected:
        if one.alternative:
            told.append(_apart(one, [other.name for other in expected], evidence, vocabulary))
            continue
        measured = limits.get(one.name) if one.parameter else halves.get(one.name)
        came = None if measured is None or one.expected is None else measured <= EXPERIMENT.came_wider * one.expected
        told.append(Outcome(one.name, "", one.unit, one.expected, measured, came))
    return tuple(told)


def _limits(evidence: Evidence, laws: Mapping[str, Effect], found: Search) -> dict[str, float | None]:
    """Detection limits of logs by the effect's name."""
    if not laws:
        return {}
    shapes = {name: looked_for(evidence, law) for name, law in laws.items()}
    shapes = {name: candidates for name, candidates in shapes.items() if candidates}
    question = Detection(found.nominal.model, tuple(found.nominal.paths), laws, 0.0, shapes=shapes)
    silent = np.zeros(len(evidence.residual))
    gram = gram_of(evidence, silent, [candidate for candidates in shapes.values() for candidate in candidates])
    return {one.name: one.expected for one in question.limits(gram)}


def _apart(one: Expectation, planned: Sequence[str], evidence: Evidence, vocabulary: Mapping[str, Effect]) -> Outcome:
    """How far logs tell an effect from its alternative: the root of what their score tests differ by."""
    names = (one.name, one.alternative)
    if one.name in CHANGES or one.name not in vocabulary:
        return Outcome(one.name, one.alternative, one.unit, one.expected, None, None)
    others = {name for name in planned if name not in names and name in vocabulary}
    for name in sorted(others):  # what was found beside it explains its own part
        best = _best(evidence, vocabulary[name])
        if best is not None:
            columns = evidence.whitened(tables(evidence, [best.candidate])[0])
            evidence = replace(evidence, basis=orthonormal(np.vstack([evidence.basis, columns])))
    difference = _difference(evidence, [vocabulary.get(name) for name in names])
    measured = round(float(np.sign(difference) * np.sqrt(abs(difference))), 3)
    if one.expected is None:
        return Outcome(*names, one.unit, None, measured, None)
    came = abs(measured) >= EXPERIMENT.came_short * one.expected - EXPERIMENT.distance_scatter
    return Outcome(*names, one.unit, one.expected, measured, came)


def _difference(evidence: Evidence, laws: Sequence[Effect | None]) -> float:
    """2 ln likelihood of the first of two effects over the second: sum over bands of d ln(power left by it / by that).

    Each at its best shape, both against the filters of the noise that the better one leaves; None: nothing is added.
    """
    found = [None if law is None else _best(evidence, law) for law in laws]
    best = max((one for one in found if one is not None), key=lambda one: one.score, default=None)
    if best is None:
        return 0.0
    quiet = cleaned(evidence, best)
    left = []
    for one in found:
        again = [] if one is None else judged(quiet, [one.candidate], 1.0, exact=True)
        left.append(left_by(quiet, again[0]) if again else quiet.free_residual)
    first, second = (band_powers(quiet, rows) for rows in left)
    return float(np.sum(np.concatenate([d for _, d in quiet.freedom]) * np.log(second / first)))


def _best(evidence: Evidence, law: Effect) -> Finding | None:
    """The effect at its best shape, against the noise that it leaves."""
    return next(iter(profiled(evidence, scan(evidence, [law]))), None)
