"""How alike two rows are at every shift."""

import subprocess
import sys

import numpy as np
import pytest
from scipy.signal import correlate

from cogging.arrays import cross_correlation


@pytest.mark.parametrize("seed", range(10))
def test_every_shift_is_that_of_the_sum(seed):
    rng = np.random.default_rng(seed)
    row, other = (rng.normal(size=int(rng.integers(1, 300))) for _ in range(2))
    found = cross_correlation(row, other)
    assert found == pytest.approx(np.correlate(row, other, mode="full"), abs=1e-11)
    assert found == pytest.approx(correlate(row, other, mode="full", method="fft"), abs=1e-12)


@pytest.mark.parametrize("lag", [-37, 0, 1, 250])
def test_a_row_is_most_alike_where_it_was_moved_to(lag):
    rng = np.random.default_rng(4)
    long = rng.normal(size=3000)
    other = long[1000 : 1000 + 800]
    row = long[1000 - lag : 1000 - lag + 900]
    assert int(np.argmax(cross_correlation(row, other))) - (len(other) - 1) == lag


def test_it_loads_no_package_of_signals():
    code = (
        "import sys, numpy as np; from cogging.arrays import cross_correlation as c; "
        "c(np.ones(9), np.ones(4)); print(any(name.startswith('scipy.signal') for name in sys.modules))"
    )
    assert subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True).stdout == "False\n"
