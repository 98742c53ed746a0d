"""Intervals of the patched model."""

import numpy as np
import pytest

from cogging import EFFECTS
from cogging.diagnosis.candidates.movable import conditional_paths
from cogging.diagnosis.patched import with_intervals
from cogging.estimation.gauss_newton import Estimate
from tests.fixtures.moving_axis import machine


def test_what_hangs_on_an_assumed_contact_has_no_interval():
    model = machine([EFFECTS["backlash"](gap=1e-5, mass_ratio=0.2), EFFECTS["cable_spring"](stiffness=1.5)])
    paths = ("effects.backlash.gap", "effects.backlash.mass_ratio", "effects.cable_spring.stiffness")
    values = np.array([1e-5, 0.2, 1.5])
    assert conditional_paths(model) == set(paths[:2])
    estimate = Estimate(paths, values, np.diag((0.01 * values) ** 2), np.full(3, 1e6), model, (), (), 1)
    intervals = with_intervals(model, estimate).intervals
    assert intervals[paths[0]] == intervals[paths[1]] == (-np.inf, np.inf)
    assert intervals[paths[2]] == pytest.approx((1.5 * (1 - 0.0196), 1.5 * (1 + 0.0196)), rel=1e-4)
