"""Effects with a state at their limits; in drawn plants beside scipy: test_fast_plants.py."""

import math

import numpy as np
import pytest

import cogging
from tests.fixtures.plants_by_hand import driven, effect, exact_axis


@pytest.mark.parametrize("stiffness", [1e2, 1e5, 1e9])
def test_it_is_stable_however_stiff_and_tends_to_the_exact_form(stiffness):
    commands = 1.5 * np.sin(4 * np.pi * np.arange(1001) / 1000.0)
    axis = exact_axis(viscous=0.3)
    exact = driven(cogging.Plant(axis), commands, 1000.0).true_position
    bristle = effect("presliding_friction", stiffness=stiffness, damping=0.5)
    log = driven(cogging.Plant(axis, effects=[bristle]), commands, 1000.0)
    assert np.abs(log.true_velocity).max() < 1.0
    # The contact gives way by g / stiffness at a period of sqrt(M / stiffness): a speed of g / sqrt(M stiffness).
    assert np.abs(log.true_position - exact).max() < 0.8 / math.sqrt(0.5 * stiffness)
