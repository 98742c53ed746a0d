"""The loops of the benchmark do the same arithmetic: a ratio between them compares like with like.

All but the core take one Runge-Kutta step a sample, whatever it errs by. The core takes more where friction reverses
within less than a step; with friction that is wide enough it takes the same, and gives the same.
"""

import lu2008_loop
import numpy as np
import pytest

from cogging import _core

WIDE = 0.2  # m/s, of the friction's smoothing


@pytest.fixture(scope="module", params=["as timed", "wide friction"])
def short(request):
    setup = {**lu2008_loop.SETUP, "repeats": 2.0}
    if request.param == "wide friction":
        setup["coulomb_width"] = WIDE
    coefficients = lu2008_loop.random_coefficients()
    core = _core.closed_loop(*lu2008_loop.core_arguments(setup, coefficients))
    return setup, coefficients, core


def check(core, other, tolerance):
    position, command = lu2008_loop.largest_difference(core, other)
    assert position < tolerance  # m
    np.testing.assert_allclose(other["reference"], core["reference"], atol=1e-15)
    return command


def test_hand_written_loop_agrees(short):
    setup, coefficients, core = short
    wide = setup["coulomb_width"] == WIDE
    tolerance = 1e-12 if wide else setup["resolution"]  # a reading may move by a count
    command = check(core, lu2008_loop.compile_hand_written()(setup, coefficients, len(core["time"])), tolerance)
    assert not wide or command < 1e-9  # V


def test_numba_loop_agrees(short):
    setup, coefficients, core = short
    # Another sine moves a reading by a count now and then, and the loop follows by a fraction of it.
    check(core, lu2008_loop.compile_numba()(setup, coefficients, len(core["time"])), setup["resolution"])
