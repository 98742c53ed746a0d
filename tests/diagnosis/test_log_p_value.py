"""Tails of the chi-square distribution in logarithms."""

import numpy as np
import pytest
from scipy import stats
from scipy.special import gammaln

from cogging.diagnosis.evidence.log_p_value import log_survival


@pytest.mark.parametrize("freedom", [1, 2, 3, 7, 12, 24])
@pytest.mark.parametrize("statistic", [0.5, 10.0, 60.0, 600.0, 1400.0])
def test_log_survival_is_that_of_scipy(freedom, statistic):
    assert log_survival(statistic, freedom) == pytest.approx(stats.chi2.logsf(statistic, freedom), rel=1e-11, abs=1e-14)


@pytest.mark.parametrize("statistic", [1e4, 1e7])
def test_log_survival_far_beyond_a_double(statistic):
    """The first terms of the tail: (x / 2)^(k / 2 - 1) exp(-x / 2) / Gamma(k / 2) (1 + (k - 2) / x + ...)."""
    for freedom in range(1, 13):
        half = 0.5 * freedom
        leading = (half - 1.0) * np.log(0.5 * statistic) - 0.5 * statistic - gammaln(half)
        leading += np.log1p((freedom - 2) / statistic * (1.0 + (freedom - 4) / statistic))
        assert log_survival(statistic, freedom) == pytest.approx(leading, rel=1e-11)
