"""The loops of the benchmark do the same arithmetic: a ratio between them compares like with like."""

import os

import lu2008_loop
import numpy as np
import pytest

import cogging


@pytest.fixture(scope="module")
def short():
    setup = {**lu2008_loop.SETUP, "repeats": 2.0}
    coefficients = lu2008_loop.random_coefficients()
    core = cogging.closed_loop(*lu2008_loop.core_arguments(setup, coefficients))
    return setup, coefficients, core


def check(core, other, tolerance):
    position, command = lu2008_loop.largest_difference(core, other)
    assert position < tolerance  # m
    np.testing.assert_allclose(other["reference"], core["reference"], atol=1e-15)
    return command


def test_hand_written_loop_agrees(short):
    if lu2008_loop.compiler() is None:
        assert "CI" not in os.environ, "continuous integration needs a C++ compiler"
        pytest.skip("no C++ compiler here")
    setup, coefficients, core = short
    command = check(core, lu2008_loop.compile_hand_written()(setup, coefficients, len(core["time"])), 1e-12)
    assert command < 1e-9  # V


def test_numba_loop_agrees(short):
    pytest.importorskip("numba", reason="numba is not installed (extra: benchmark)")
    setup, coefficients, core = short
    # Another sine moves a reading by a count now and then, and the loop follows by a fraction of it.
    check(core, lu2008_loop.compile_numba()(setup, coefficients, len(core["time"])), setup["resolution"])
