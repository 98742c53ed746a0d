"""Waves along the travel that go with something else."""

import numpy as np
import pytest

import cogging
from cogging import EFFECTS
from cogging.diagnosis.candidates.findings import profiled
from cogging.diagnosis.candidates.scan import scan
from cogging.diagnosis.evidence.null import fit_null
from cogging.diagnosis.residual.modulated_look_alikes import modulated_look_alikes
from cogging.effects.effect import VOCABULARY
from tests.fixtures.moving_axis import machine, motion, record


def test_a_force_with_the_square_of_the_command_is_no_ripple():
    """As reluctance makes it: on one log nearly a ripple of some other period, and no effect of the vocabulary."""
    nominal, reference = machine(), motion(23)
    log = record(nominal, 23)
    added = -0.5 * (log.command / np.abs(log.command).max()) ** 2 * np.sin(2.0 * np.pi * log.position / 0.02 + 0.4)
    columns = cogging.closed_loop(
        nominal.plant(), nominal.make_controller(), reference, seed=23, duration=8.0, steps_per_sample=4,
        added_command=added,
    )  # fmt: skip
    logged = cogging.Log(columns.time, columns.position, columns.command - added)
    evidence = fit_null([logged], nominal)[1]
    best = max(
        scan(evidence, [VOCABULARY["force_constant_ripple"], VOCABULARY["cogging_harmonic"]]), key=lambda one: one.score
    )
    found = {shape.coordinate.split(" every ")[0]: shape for shape in modulated_look_alikes(evidence, best)}
    square = found.pop("square of the command")
    assert square.coordinate.endswith(" mm")
    assert float(square.coordinate.split()[-2]) == pytest.approx(20.0, rel=0.15)  # few places see a large command
    assert square.score > best.score + 6.0
    assert all(square.test.statistic > other.test.statistic for other in found.values())
    assert np.ptp(square.force) == pytest.approx(2.0 * 0.5, rel=0.3)
    spring = max(scan(evidence, [VOCABULARY["cable_spring"]]), key=lambda one: one.score)
    assert modulated_look_alikes(evidence, spring) == []


def test_a_true_ripple_has_no_better_look_alike():
    hidden = machine([EFFECTS["force_constant_ripple"](period=0.02, sine=0.05)])
    evidence = fit_null([record(hidden, 24)], machine())[1]
    (ripple,) = profiled(evidence, scan(evidence, [VOCABULARY["force_constant_ripple"]]))
    assert ripple.candidate.shape["period"] == pytest.approx(0.02, rel=0.01)
    assert all(look_alike.score < ripple.score for look_alike in modulated_look_alikes(evidence, ripple))
