"""Least squares do not depend on units, and give undetermined directions no weight."""

import numpy as np
import pytest

from cogging.arrays import least_squares


@pytest.mark.parametrize("seed", range(4))
def test_least_squares_do_not_depend_on_units(seed):
    rng = np.random.default_rng(seed)
    p, n = rng.integers(1, 8), rng.integers(20, 200)
    columns, units = rng.normal(size=(p, n)), 10.0 ** rng.uniform(-12, 12, p)
    truth, noise = rng.normal(size=p), rng.normal(size=n)
    found = least_squares(units[:, None] * columns, truth @ columns + noise)
    assert found * units == pytest.approx(np.linalg.solve(columns @ columns.T, columns @ noise) + truth, rel=1e-10)


@pytest.mark.parametrize(("apart", "determined"), [(1e-9, True), (1e-14, False)])
def test_undetermined_directions_have_no_weight(apart, determined):
    wave = np.sin(np.arange(100.0))
    found = least_squares(np.stack([wave, np.zeros(100), 4.0 * wave]), 6.0 * wave)
    assert found == pytest.approx([3.0, 0.0, 0.75])
    one, other = np.random.default_rng(3).normal(size=(2, 300))
    found = least_squares(np.stack([one, one + apart * other]), other)
    assert (abs(found[1]) == pytest.approx(1.0 / apart, rel=1e-4)) == determined
    assert determined or np.abs(found).max() < 1.0
