"""Covariances of fits against refits by hand, and what no row determines."""

import numpy as np
import pytest
from scipy import stats

from cogging.estimation.statistics import jackknife, spread_of, student
from cogging.estimation.whitening import Whitened

ROWS, BLOCKS = 600, 30


def whitened(columns, residual):
    block = np.repeat(np.arange(BLOCKS), ROWS // BLOCKS)
    return Whitened(residual, columns, block, np.zeros(1), 1.0)


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
    expected, freedom = spread_of(np.array(without))
    found, told = jackknife([whitened(columns, values - full @ columns)])
    np.testing.assert_allclose(found, expected, rtol=1e-6)
    assert told == pytest.approx(freedom, rel=1e-6)
    assert freedom[2] < 10.0 < freedom[0]  # of what few blocks show, little is known of the error either


def test_covariance_of_white_rows_is_the_inverse_of_the_curvature():
    random = np.random.default_rng(5)
    columns = random.normal(size=(2, ROWS))
    seen = [np.diag(jackknife([whitened(columns, random.normal(size=ROWS))])[0]) for _ in range(100)]
    white = np.diag(np.linalg.inv(columns @ columns.T))
    assert np.mean(seen, axis=0) == pytest.approx(white, rel=0.15)


@pytest.mark.parametrize("elsewhere", [0.0, 0.02])
def test_what_one_block_shows_has_the_covariance_of_white_rows(elsewhere):
    random = np.random.default_rng(6)
    columns = random.normal(size=(2, ROWS))
    columns[1, ROWS // BLOCKS :] *= elsewhere
    inside = []
    for _ in range(300):
        residual = random.normal(size=ROWS)
        error = np.linalg.lstsq(columns.T, residual, rcond=None)[0]
        covariance, freedom = jackknife([whitened(columns, residual - error @ columns)])
        inside.append(np.abs(error) < stats.t.ppf(0.975, freedom) * np.sqrt(np.diag(covariance)))
    assert np.all(np.abs(np.mean(inside, axis=0) - 0.95) < 0.04)


def test_what_no_row_determines_has_an_infinite_variance(table):
    columns, values = table
    more = np.vstack([columns, columns[0] * 7.0, np.zeros(ROWS)])
    found, _ = jackknife([whitened(more, values - values.mean())])
    assert np.isinf(np.diag(found)).tolist() == [True, False, False, True, True]


def test_freedom_of_values_of_any_size():
    shifts = np.random.default_rng(4).normal(size=(40, 2)) * np.array([1.0, 1e80])
    assert spread_of(shifts)[1] == pytest.approx(spread_of(shifts / np.array([1.0, 1e80]))[1])


def test_quantile_of_student():
    for degrees in (2.0, 2.7, 5.0, 25.0, 200.0, 1e6):
        for confidence in (0.5, 0.95, 0.999):
            assert student(degrees, confidence) == pytest.approx(stats.t.ppf(0.5 + 0.5 * confidence, degrees), rel=1e-9)
    assert student(0.3) == student(1.0) == pytest.approx(4.302652729749464, rel=1e-9)
