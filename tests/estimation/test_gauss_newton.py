"""Covariances of fits against refits by numpy, and infinite variances of what no row determines."""

import numpy as np
import pytest
from scipy import stats

from cogging.estimation.residuals import Whitened
from cogging.estimation.statistics import jackknife, spread_of

ROWS, BLOCKS = 600, 30


def whitened(columns, residual):
    return Whitened(residual, columns, np.repeat(np.arange(BLOCKS), ROWS // BLOCKS), np.zeros(1), 1.0)


@pytest.fixture
def table():
    random = np.random.default_rng(2)
    columns = random.normal(size=(3, ROWS)) * np.array([[1.0], [1e-4], [1e3]])
    columns[2, 60:] *= 0.05  # three blocks show the third
    return columns, columns.T @ [2.0, 3e4, 1e-3] + random.normal(size=ROWS)


def test_covariance_is_that_of_fits_without_each_block(table):
    columns, values = table
    full = np.linalg.lstsq(columns.T, values, rcond=None)[0]
    without = []
    for block in range(BLOCKS):
        kept = np.repeat(np.arange(BLOCKS), ROWS // BLOCKS) != block
        without.append(np.linalg.lstsq(columns[:, kept].T, values[kept], rcond=None)[0] - full)
    expected, degrees = spread_of(np.array(without))
    covariance, found = jackknife([whitened(columns, values - full @ columns)])
    np.testing.assert_allclose(covariance, expected, rtol=1e-6)
    assert found == pytest.approx(degrees, rel=1e-6)
    assert degrees[2] < 10.0 < degrees[0]  # the error of what few blocks show is poorly known too


@pytest.mark.parametrize("elsewhere", [0.0, 0.02, 1.0])
def test_intervals_of_white_rows_hold_the_truth_also_where_one_block_shows_a_column(elsewhere):
    random = np.random.default_rng(6)
    columns = random.normal(size=(2, ROWS))
    columns[1, ROWS // BLOCKS :] *= elsewhere
    errors, degrees, variances = [], [], []
    for _ in range(300):
        residual = random.normal(size=ROWS)
        error = np.linalg.lstsq(columns.T, residual, rcond=None)[0]
        covariance, known = jackknife([whitened(columns, residual - error @ columns)])
        errors.append(error)
        degrees.append(known)
        variances.append(np.diag(covariance))
    is_inside = np.abs(errors) < stats.t.ppf(0.975, degrees) * np.sqrt(variances)
    assert np.all(np.abs(np.mean(is_inside, axis=0) - 0.95) < 0.04)
    if elsewhere == 1.0:
        white = np.diag(np.linalg.inv(columns @ columns.T))
        assert np.mean(variances, axis=0) == pytest.approx(white, rel=0.15)


def test_what_no_row_determines_has_an_infinite_variance(table):
    columns, values = table
    more = np.vstack([columns, columns[0] * 7.0, np.zeros(ROWS)])
    found, _ = jackknife([whitened(more, values - values.mean())])
    assert np.isinf(np.diag(found)).tolist() == [True, False, False, True, True]
