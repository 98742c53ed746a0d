"""The quantile that intervals are made with."""

import pytest
from scipy import stats

from cogging.estimation.statistics import student


@pytest.mark.parametrize("degrees", [2.0, 2.7, 5.0, 25.0, 200.0, 1e6])
@pytest.mark.parametrize("confidence", [0.5, 0.95, 0.999])
def test_student(degrees, confidence):
    assert student(degrees, confidence) == pytest.approx(stats.t.ppf(0.5 + 0.5 * confidence, degrees), rel=1e-9)


def test_fewer_than_two_degrees_count_as_two():
    assert student(0.3) == student(1.0) == pytest.approx(4.302652729749464, rel=1e-9)
