"""The loops written by hand do the arithmetic of the core's: a ratio between them compares like with like.

They take one Runge-Kutta step a sample, whatever its error. The core takes more where friction reverses within less
than a step; with friction that is wide enough it takes the same, and gives the same.
"""

import numpy as np
import pytest

import cogging
from cogging import _core
from tests.benchmarks import lu2008_loop

WIDE = 0.2  # m/s, of the friction's smoothing


@pytest.mark.parametrize("instructions", ["", *list(_core.instruction_sets())[-1:]])
def test_loops_by_hand_agree_with_the_core(instructions, monkeypatch):
    setup = {**lu2008_loop.SETUP, "repeats": 1.0, "coulomb_width": WIDE}
    if instructions:
        monkeypatch.setenv("COGGING_INSTRUCTIONS", instructions)
        machines = lu2008_loop.drawn_machines(8, setup)
        logs = lu2008_loop.run_core(lu2008_loop.core_batch(setup, machines), instructions)
        assert all(logs.in_lanes)
    else:
        machines = lu2008_loop.nominal_machine(setup)
        logs = [cogging.closed_loop(*lu2008_loop.core_arguments(setup, lu2008_loop.random_coefficients()))]
    by_hand = lu2008_loop.compile_hand_written(instructions=instructions)(setup, machines, len(logs[0]))
    for log, position, command in zip(logs, by_hand["true_position"], by_hand["command"], strict=True):
        np.testing.assert_allclose(position, log.true_position, rtol=0, atol=1e-11)  # roundings, of half a metre
        np.testing.assert_allclose(command, log.command, rtol=0, atol=1e-9)
