"""Columns of candidates: made in groups, tested together and let go."""

import tracemalloc
from dataclasses import replace

import numpy as np
import pytest

from cogging.diagnosis.candidates.findings import explained_by, judge, judged
from cogging.diagnosis.candidates.signatures import candidates
from cogging.diagnosis.candidates.tables import in_groups, tables, whitened_each
from cogging.diagnosis.evidence.column_memory import ColumnMemory
from cogging.diagnosis.residual.shapes import coordinates, shapes
from cogging.diagnosis.thresholds import SCORE_TEST
from cogging.effects.effect import VOCABULARY

NAMES = ("cable_spring", "flexible_mode", "force_constant_ripple", "cogging_modulation", "encoder_periodic_error")


def grid(evidence, *names):
    return [one for name in names for one in candidates(evidence, VOCABULARY[name], [])]


def test_columns_are_whitened_together_as_they_are_alone(quiet_evidence):
    wanted = grid(quiet_evidence, *NAMES)
    assert len(list(in_groups(wanted))) > 5
    assert [one for group in in_groups(wanted) for one in group] == wanted
    for candidate, white in zip(wanted, whitened_each(quiet_evidence, wanted), strict=True):
        alone = quiet_evidence.whitened(tables(quiet_evidence, [candidate])[0])
        np.testing.assert_allclose(white, alone, rtol=1e-9, atol=1e-12 * float(np.abs(alone).max()))


@pytest.mark.parametrize("name", NAMES)
@pytest.mark.parametrize("exact", [False, True])
def test_candidates_are_judged_together_as_they_are_alone(quiet_evidence, name, exact):
    wanted = grid(quiet_evidence, name)
    found = judged(quiet_evidence, wanted, 10.0, exact)
    alone = []
    for candidate in wanted:
        test = quiet_evidence.test(quiet_evidence.whitened(tables(quiet_evidence, [candidate])[0]))
        finding = judge(quiet_evidence, candidate, test, 10.0, exact)
        alone += [] if finding is None else [finding]
    assert [one.candidate for one in found] == [one.candidate for one in alone]
    for mine, its in zip(found, alone, strict=True):
        assert mine.score == pytest.approx(its.score, rel=1e-7, abs=1e-7)
        np.testing.assert_allclose(mine.amplitudes, its.amplitudes, rtol=1e-6)


def test_what_a_finding_explains_is_the_same_whenever_it_is_made(quiet_evidence):
    found = judged(quiet_evidence, grid(quiet_evidence, "flexible_mode", "force_constant_ripple"), 10.0)
    kinds = {}
    for finding in found:
        kinds.setdefault((finding.name, finding.faint), []).append(finding)
    for same in kinds.values():
        best, last = max(same, key=lambda one: one.score), same[-1]
        for finding in (best, last, same[len(same) // 2]):
            again = explained_by(quiet_evidence, finding.candidate, finding.test.amplitudes)
            size = float(np.abs(again).max())
            assert size > 0.0
            np.testing.assert_allclose(finding.test.explained, again, atol=1e-7 * size)
            assert finding.test.explained is finding.test.explained  # kept once it is made
            free = quiet_evidence.basis @ finding.test.explained
            assert np.abs(free).max() < 1e-6 * np.linalg.norm(again)  # nothing that re-tuning could explain


def peak_of(work, row):
    """Memory that work allocates at most, in rows of the log."""
    tracemalloc.start()
    try:
        kept = work()
        held, peak = tracemalloc.get_traced_memory()
    finally:
        tracemalloc.stop()
    assert kept
    return peak / row, held / row


def test_memory_does_not_grow_with_the_number_of_shapes(quiet_evidence):
    row = quiet_evidence.residual.nbytes
    waves = grid(quiet_evidence, "cogging_harmonic")  # of force alone: nothing of them is kept for another scan
    shapes = [one for period in waves for one in [period] * 8]
    few, many = shapes[:8], shapes
    assert len(many) > 8 * len(few)
    judged(quiet_evidence, few, 10.0)  # what is made once
    small, _ = peak_of(lambda: judged(quiet_evidence, few, 10.0), row)
    large, held = peak_of(lambda: judged(quiet_evidence, many, 10.0), row)
    assert large < small + 8.0
    assert large < 8.0 * SCORE_TEST.columns_together
    assert 0.0 < held < 0.25 * len(many)


def under(evidence, model):
    """The evidence under another model, with the columns that are kept of these logs."""
    parts = [
        replace(part, along=source.prediction(model))
        for part, source in zip(evidence.parts, evidence.sources, strict=True)
    ]
    return replace(evidence, model=model, parts=tuple(parts))


@pytest.mark.parametrize("kept", [0.0, 2.5, np.inf])
def test_columns_with_a_memory_are_kept_or_made_again_to_the_same_bits(quiet_evidence, monkeypatch, kept):
    """Under a changed model too they are those of the first; what acts at once is evaluated under the new one."""
    few = replace(SCORE_TEST, bytes_kept=kept * quiet_evidence.residual.nbytes)
    monkeypatch.setattr("cogging.diagnosis.evidence.column_memory.SCORE_TEST", few)
    evidence = replace(quiet_evidence, memory=ColumnMemory())
    axis = evidence.model.axis
    other = under(evidence, evidence.model.replace(axis=axis.replace(viscous=1.4 * axis.viscous)))
    names = ("flexible_mode", "actuator_lag", "command_delay", "backlash", "presliding_friction")
    wanted = [one for name in names for one in grid(evidence, name)[::5]]
    first = [table[0].copy() for table in tables(evidence, wanted)]
    for again in (evidence, other):
        for candidate, was, table in zip(wanted, first, tables(again, wanted), strict=True):
            assert np.array_equal(was, table[0]), candidate
    alone = replace(other, memory=ColumnMemory())
    moved = [np.abs(was - now[0]).max() for was, now in zip(first, tables(alone, wanted), strict=True)]
    assert all(size > 0.0 for size in moved)
    force = grid(evidence, "cable_spring")[:1]
    assert not np.array_equal(tables(evidence, force)[0][0], tables(other, force)[0][0])


def test_columns_of_a_coordinate_are_hats_over_its_places(quiet_evidence):
    source = quiet_evidence.sources[0]
    for name, (_, places, make, values) in coordinates(source, quiet_evidence.model).items():
        columns = make()
        if name in ("velocity", "time", "command", "acceleration"):
            expected = np.array([np.interp(values, places, one) for one in np.eye(len(places))])
            np.testing.assert_allclose(columns, expected, atol=1e-14)
        assert len(columns) in (len(places), 2 * len(places))  # for each direction


def test_memory_of_the_residual_shapes_is_that_of_one_coordinate(quiet_evidence, monkeypatch):
    monkeypatch.setattr("os.cpu_count", lambda: 1)
    row = quiet_evidence.residual.nbytes
    source = quiet_evidence.sources[0]
    made = [len(one[2]()) for one in coordinates(source, quiet_evidence.model).values()]
    _ = quiet_evidence.freedom
    peak, _ = peak_of(lambda: shapes(quiet_evidence), row)
    own = len(quiet_evidence.columns)  # filters that are estimated again weigh these, too
    assert sum(made) > 3 * max(made)
    assert peak < 3.0 * (max(made) + own) + 4.0 * SCORE_TEST.columns_together
