"""Evidence: score tests of columns, and how well the level of the noise is known."""

import numpy as np
import pytest
from scipy import stats

from cogging.diagnosis.evidence.noise_filter import periodogram_length
from cogging.diagnosis.evidence.score_test import ScoreTest


def test_score_test_of_random_columns_is_chi_square(quiet_evidence):
    random = np.random.default_rng(5)
    found = []
    for _ in range(200):
        test = quiet_evidence.test(random.normal(size=(2, len(quiet_evidence.residual))))
        found.append(test.statistic)
        assert test.freedom == 2
    assert stats.kstest(found, stats.chi2(2).cdf).pvalue > 1e-3


def test_amplitude_of_a_column_that_is_there(quiet_evidence):
    column = np.random.default_rng(6).normal(size=(1, len(quiet_evidence.residual)))
    free = quiet_evidence.project(column)[0]
    residual = quiet_evidence.residual + 0.5 * free
    moved = type(quiet_evidence)(**{**vars_of(quiet_evidence), "residual": residual})
    before, after = quiet_evidence.test(column).amplitudes[0], moved.test(column).amplitudes[0]
    assert after - before == pytest.approx(0.5, abs=1e-6)


def vars_of(evidence):
    return {name: getattr(evidence, name) for name in evidence.__dataclass_fields__}


def test_a_level_known_from_few_lines_bounds_what_a_column_is_worth(quiet_evidence):
    """All of a column's power in one narrow band: d ln(1 + T / d) there, and T where it is spread over all."""
    source = quiet_evidence.sources[0]
    ((parts, freedom),) = quiet_evidence.freedom
    assert freedom.sum() == pytest.approx(source.mask.sum() - len(quiet_evidence.basis), rel=0.01)
    n = len(source.log)
    frequency = np.fft.rfftfreq(periodogram_length(n), source.scales.sample_time)
    band = parts[6]
    middle = float(np.mean(frequency[band]))
    narrow = np.sin(2.0 * np.pi * middle * np.arange(n) * source.scales.sample_time)
    narrow *= np.sqrt(400.0 / np.sum(narrow**2))
    made = ScoreTest
    test = made(400.0, 1, np.ones(1), narrow, np.ones(1))
    expected = (freedom[6] - 1) * np.log1p(400.0 / quiet_evidence.overdispersion / (freedom[6] - 1))
    assert quiet_evidence.bounded(test) == pytest.approx(expected, rel=0.1)
    wide = np.random.default_rng(8).normal(size=n)
    wide *= np.sqrt(400.0 / np.sum(wide**2))
    assert (
        quiet_evidence.bounded(made(400.0, 1, np.ones(1), wide, np.ones(1)))
        > 0.9 * 400.0 / quiet_evidence.overdispersion
    )
