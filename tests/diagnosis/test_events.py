"""What happens at moments: jumps of the reading, intervals of other friction."""

import numpy as np
import pytest

import cogging
from cogging.diagnosis.evidence.null import fit_null
from cogging.diagnosis.residual.events import events
from cogging.diagnosis.residual.location_words import shape_text
from cogging.diagnosis.residual.shape import FRICTION_INTERVALS, JUMPS
from cogging.diagnosis.thresholds import VERDICT
from tests.fixtures.moving_axis import by_coordinate, machine, pushed, record


def test_readings_that_jump_are_told_with_their_moment_and_size():
    log = record(machine(), 17)
    speed = np.gradient(log.position, log.time)
    row = int(np.argmax((np.abs(speed) > 0.1) & (log.time > 3.0)))
    position = log.position.copy()
    position[row:] += 6e-7
    evidence = fit_null([cogging.Log(log.time, position, log.command)], machine())[1]
    (jump,) = [shape for shape in events(evidence) if shape.coordinate == JUMPS]
    assert jump.log_p_value < VERDICT.jump
    largest = int(np.argmax(np.abs(jump.force)))
    assert jump.places[largest] == pytest.approx(log.time[row], abs=0.005)
    assert jump.force[largest] == pytest.approx(6e-7, abs=4.0 * jump.deviation[largest])
    assert f"+{1e6 * jump.force[largest]:.4g} um at" in shape_text(jump)


def test_a_blow_is_no_jump_of_the_reading():
    found = by_coordinate(pushed(lambda t, x, v: 0.8 * ((t > 3.0) & (t < 3.02)), 17))
    assert JUMPS not in found or found[JUMPS].log_p_value > VERDICT.jump


def test_friction_that_comes_and_goes_is_told_in_intervals():
    found = by_coordinate(pushed(lambda t, x, v: -0.15 * np.sign(v) * (np.mod(t, 1.7) < 0.3), 18))
    assert found[FRICTION_INTERVALS].log_p_value < -20.0
    assert np.median(found[FRICTION_INTERVALS].force[np.abs(found[FRICTION_INTERVALS].force) > 0.05]) < -0.05
