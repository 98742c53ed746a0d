"""Residual shapes."""

import numpy as np
import pytest

from cogging.diagnosis.evidence.null import fit_null
from cogging.diagnosis.residual.shapes import coordinates, shapes
from tests.fixtures.moving_axis import by_coordinate, machine, pushed


def test_what_is_slow_and_large_is_measured_against_the_gap_itself():
    """Filters take it for noise: a force of time that anyone sees in the gap is then hardly seen in the evidence."""

    def drift(t, x, v):
        return 0.06 * np.sin(2.0 * np.pi * t / 3.0)

    evidence = fit_null([pushed(drift, 21)], machine())[1]
    (source,), (part,) = evidence.sources, evidence.parts
    columns = coordinates(source, evidence.model)["time"][2]()
    table = source.rows_of_forces(evidence.alongs[0], columns, evidence.model.axis.mass)
    _, share = evidence.unwhitened_fit([table])
    rows = source.mask > 0
    both = np.linalg.lstsq(np.vstack([part.columns, table])[:, rows].T, part.residual[rows], rcond=None)[0]
    alone = np.linalg.lstsq(part.columns[:, rows].T, part.residual[rows], rcond=None)[0]
    left = part.residual[rows] - both @ np.vstack([part.columns, table])[:, rows]
    tuned = part.residual[rows] - alone @ part.columns[:, rows]
    assert share == pytest.approx(1.0 - (left @ left) / (tuned @ tuned), abs=0.01)
    assert share > 0.2
    seen = [{shape.coordinate: shape for shape in shapes(evidence, plain=way)}["time"] for way in (True, False)]
    plain, usual = (shape.test.statistic for shape in seen)
    assert plain > 1.5 * usual
    again = shapes(evidence, plain=True, known=shapes(evidence))
    anew = shapes(evidence, plain=True)
    assert {one.coordinate: one.log_p_value for one in again} == {one.coordinate: one.log_p_value for one in anew}


def test_drag_over_the_pitch_is_its_own_coordinate():
    found = by_coordinate(pushed(lambda t, x, v: -1.5 * np.sin(2 * np.pi * x / 0.03) * v, 19))
    best = min(found.values(), key=lambda shape: shape.log_p_value)
    assert best.coordinate == "drag over the pitch"
    shape = -1.5 * np.sin(2 * np.pi * best.places / 0.03)
    assert best.force - best.force.mean() == pytest.approx(shape, abs=0.3)


def test_friction_that_falls_with_time_is_a_drag_over_time():
    hidden = pushed(lambda t, x, v: 1.5 * v * np.exp(-t / 2.0), 4)  # as oil that warms up: less drag in the end
    left = shapes(fit_null([hidden], machine())[1])
    found = next(shape for shape in left if shape.coordinate == "drag over time")
    assert found.log_p_value < -15.0
    assert found.log_p_value <= left[0].log_p_value + 5.0
