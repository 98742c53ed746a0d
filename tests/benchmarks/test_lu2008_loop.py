"""The loops of the benchmark do the same arithmetic: a ratio between them compares like with like."""

import os

import lu2008_loop
import numpy as np
import pytest

import cogging

COUNT = lu2008_loop.SETUP["resolution"]


@pytest.fixture(scope="module")
def short():
    setup = {**lu2008_loop.SETUP, "repeats": 2.0}
    coefficients = lu2008_loop.random_coefficients()
    core = cogging.closed_loop(*lu2008_loop.core_arguments(setup, coefficients))
    return setup, coefficients, core


def check(core, other):
    # Rounding moves a reading by a count now and then, and the loop follows by a fraction of it.
    position, _ = lu2008_loop.largest_difference(core, other)
    assert position < COUNT
    error = core["position"] - core["reference"]
    assert np.std(error - (other["position"] - other["reference"])) < 0.2 * np.std(error)
    np.testing.assert_allclose(other["reference"], core["reference"], atol=1e-12)


def test_hand_written_loop_agrees(short):
    if lu2008_loop.compiler() is None:
        assert "CI" not in os.environ, "continuous integration needs a C++ compiler"
        pytest.skip("no C++ compiler here")
    setup, coefficients, core = short
    check(core, lu2008_loop.compile_hand_written()(setup, coefficients, len(core["time"])))


def test_numba_loop_agrees(short):
    pytest.importorskip("numba", reason="numba is not installed (extra: benchmark)")
    setup, coefficients, core = short
    check(core, lu2008_loop.compile_numba()(setup, coefficients, len(core["time"])))
