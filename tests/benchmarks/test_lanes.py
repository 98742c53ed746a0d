"""Packs written by hand do the arithmetic of the core's: a ratio between them compares like with like."""

import lanes
import lu2008_loop
import numpy as np
import pytest

from cogging import _core

WIDE = 0.2  # m/s, of the friction's smoothing: the core then takes one step a sample, as the packs by hand do


def test_packs_by_hand_agree(monkeypatch):
    sets = list(_core.instruction_sets())
    if not sets:
        pytest.skip("no instruction set was compiled for this machine")
    monkeypatch.setenv("COGGING_INSTRUCTIONS", sets[-1])
    setup = lu2008_loop.SETUP | {"repeats": 1.0, "coulomb_width": WIDE}
    machines = lanes.drawn_machines(8, setup)
    core = lanes.run_core(lanes.core_arguments(setup, machines), sets[-1])
    assert all(core.in_lanes)
    by_hand = lanes.compile_by_hand(sets[-1], lanes.WIDTHS[sets[-1]])(setup, machines, len(core[0]))
    for log, position, command in zip(core, by_hand["true_position"], by_hand["command"], strict=True):
        np.testing.assert_allclose(position, log.true_position, rtol=0, atol=1e-11)  # roundings, of half a metre
        np.testing.assert_allclose(command, log.command, rtol=0, atol=1e-9)
