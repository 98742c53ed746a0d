"""What candidates would do to the residuals: the columns of their score tests."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from functools import partial
from typing import Any

import numpy as np

from cogging._core import Prediction
from cogging.arrays import FloatArray
from cogging.diagnosis.candidates.signatures import Candidate
from cogging.diagnosis.evidence.evidence import Evidence
from cogging.diagnosis.evidence.score_test import groups
from cogging.diagnosis.thresholds import SCORE_TEST
from cogging.effects.effect import Effect, for_core, laws_of
from cogging.estimation.innovations import LINEAR_HOOKS, Innovations
from cogging.estimation.residuals import quiet_plant
from cogging.model.model import Model


def tables(evidence: Evidence, wanted: Sequence[Candidate]) -> list[list[FloatArray]]:
    """What each candidate's columns do to the residuals of each log, V per unit of amplitude: [candidate][log] (p, n).

    Laws that are linear along the prediction (forces, friction levels, gains, errors of the reading) are evaluated
    along it and passed through the observer's loop, and so is what a changed command or a load of its own does there,
    of the finite size that the shape says; what remains, such as friction with a memory, is predicted anew.
    """
    result: list[list[FloatArray]] = [[] for _ in wanted]
    for number, source in enumerate(evidence.sources):
        for i, table in enumerate(_tables_of_log(evidence, number, source, wanted)):
            result[i].append(table)
    return result


def in_groups(wanted: Sequence[Candidate]) -> Iterator[Sequence[Candidate]]:
    """Neighbours whose columns are made and whitened at once: quicker than one by one, and few enough to be held."""
    sizes = [max(1, len(candidate.amplitudes)) for candidate in wanted]
    for first, last in groups(sizes, SCORE_TEST.columns_together):
        yield wanted[first:last]


def whitened_group(evidence: Evidence, wanted: Sequence[Candidate]) -> tuple[FloatArray, list[int]]:
    """Whitened columns of all candidates, one after the other, (p, n), and how many each has."""
    made = tables(evidence, wanted)
    logs = [np.concatenate([each[number] for each in made]) for number in range(len(evidence.sources))]
    return evidence.whitened(logs), [len(each[0]) for each in made]


def whitened_each(evidence: Evidence, wanted: Sequence[Candidate]) -> Iterator[FloatArray]:
    """Whitened columns (p, n) of each candidate, not yet projected."""
    for group in in_groups(wanted):
        white, sizes = whitened_group(evidence, group)
        yield from np.split(white, np.cumsum(sizes)[:-1])


def _tables_of_log(
    evidence: Evidence, number: int, source: Innovations, wanted: Sequence[Candidate]
) -> list[FloatArray]:
    """The columns of each candidate in one log, by the quickest way that its law allows."""
    linear, memory, readings = [], [], []
    for i, candidate in enumerate(wanted):
        hooks = set(candidate.law.HOOKS)
        if "reading" in hooks and len(candidate.amplitudes) > 1:
            readings.append(i)
        elif hooks <= LINEAR_HOOKS:
            linear.append(i)
        else:
            memory.append(i)
    out: dict[int, FloatArray] = {}
    if linear:
        out |= _linear(evidence, number, source, {i: wanted[i] for i in linear})
    for i in readings:
        out[i] = _reading(evidence, number, source, wanted[i])
    keys = {i: (number, wanted[i].name, *sorted(wanted[i].shape.items(), key=str)) for i in memory}
    known = {i: tuple(str(part) for part in key) for i, key in keys.items()}
    out |= {i: evidence.memory.table(known[i]) for i in memory if known[i] in evidence.memory}
    model, along = evidence.model, evidence.alongs[number]
    anew = {i: wanted[i] for i in memory if i not in out}
    for i, (table, quick) in _with_memory(model, along, source, anew).items():
        out[i] = table
        again = partial(_made_again, model, along, source, wanted[i]) if quick else None
        evidence.memory.keep(known[i], table, again)
    return [out[i] for i in range(len(wanted))]


def _linear(
    evidence: Evidence, number: int, source: Innovations, wanted: Mapping[int, Candidate]
) -> dict[int, FloatArray]:
    """Columns of laws that are evaluated along the prediction, one an amplitude."""
    made = [pair for candidate in wanted.values() for pair in _unit_effects(candidate)]
    rows = _added(evidence.model, evidence.alongs[number], source, made)
    out, start = {}, 0
    for i, candidate in wanted.items():
        columns = max(1, len(candidate.amplitudes))
        out[i] = rows[start : start + columns]
        start += columns
    return out


def _added(model: Model, along: Prediction, source: Innovations, made: Sequence[tuple[Any, float]]) -> FloatArray:
    """What effects add to the residuals of a log, V per unit of each, (p, n)."""
    effects, units = [effect for effect, _ in made], [unit for _, unit in made]
    return source.rows_of_effects(along, quiet_plant(model), effects, units)


def _reading(evidence: Evidence, number: int, source: Innovations, candidate: Candidate) -> FloatArray:
    """Columns of an error of the reading, one an amplitude."""
    along = evidence.alongs[number]
    errors = [
        (laws_of(effect).reading_at(along.position) - along.position) / unit
        for effect, unit in _unit_effects(candidate)
    ]
    return source.rows_of_readings(along, np.array(errors), evidence.model.axis.mass)


def _with_memory(
    model: Model, along: Prediction, source: Innovations, wanted: Mapping[int, Candidate]
) -> dict[int, tuple[FloatArray, bool]]:
    """Columns of effects that their shape alone makes, and whether they are quick to make again.

    They are added to the prediction if that can be, else predicted anew.
    """
    plant = quiet_plant(model)
    shown = {i: _unit_effects(candidate)[0] for i, candidate in wanted.items()}
    out: dict[int, tuple[FloatArray, bool]] = {}
    added = [i for i in shown if source.predictor.is_addable(plant, *for_core([shown[i][0]]))]
    if added:
        rows = _added(model, along, source, [shown[i] for i in added])
        out |= {i: (rows[k : k + 1].copy(), "gap" not in wanted[i].shape) for k, i in enumerate(added)}
    whole = [i for i in shown if i not in out]
    if whole:
        rows = source.of([model.replace(effects=(*model.effects, shown[i][0])) for i in whole])
        rows -= source.of([model])
        out |= {i: (rows[k : k + 1] / shown[i][1], False) for k, i in enumerate(whole)}
    return out


def _made_again(model: Model, along: Prediction, source: Innovations, candidate: Candidate) -> FloatArray:
    return _with_memory(model, along, source, {0: candidate})[0][0]


def _unit_effects(candidate: Candidate) -> list[tuple[Effect, float]]:
    """The effect once for each amplitude, at its unit alone, with that unit; or once as its shape makes it."""
    if not candidate.amplitudes:
        return [(candidate.effect(), 1.0)]
    effects = []
    for k, unit in enumerate(candidate.unit):
        values = [0.0] * len(candidate.amplitudes)
        values[k] = unit
        effects.append((candidate.effect(values), unit))
    return effects
