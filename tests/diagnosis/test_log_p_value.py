"""Tails of the chi-square distribution in logarithms."""

import pytest
from scipy import stats

from cogging.diagnosis.evidence.log_p_value import log_survival


@pytest.mark.parametrize("freedom", [1, 2, 3, 7, 12, 24])
@pytest.mark.parametrize("statistic", [0.5, 10.0, 60.0, 600.0])
def test_log_survival_is_that_of_scipy(freedom, statistic):
    assert log_survival(statistic, freedom) == pytest.approx(stats.chi2.logsf(statistic, freedom), rel=1e-9, abs=1e-12)


def test_log_survival_far_out_is_finite_and_falls():
    assert -5100 < log_survival(1e4, 3) < log_survival(9e3, 3) < -4000
