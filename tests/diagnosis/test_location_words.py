"""Where a gap sits, in words."""

import numpy as np

from cogging.diagnosis.residual.location_words import length_text, ranges
from cogging.diagnosis.residual.shape import Shape


def test_ranges_in_words():
    def shape(coordinate, unit, places, force):
        force = np.array(force)
        return Shape(coordinate, unit, None, np.array(places), force, np.full(force.size, 0.01), -50.0, 0.4)

    slow = shape("velocity", "m/s", [-0.2, -0.004, 0.0, 0.004, 0.2], [0.0, -0.5, 0.2, 0.5, 0.0])
    assert ranges(slow) == "within 4 mm/s of rest, both directions: +0.5 V forward, -0.5 V backward"
    fast = shape("velocity", "m/s", [-0.2, -0.01, 0.0, 0.01, 0.1, 0.2], [0.0, 0.0, 0.0, 0.0, 0.1, 0.3])
    assert ranges(fast) == "above 0.1 m/s, forward: +0.3 V"
    ends = shape("position", "m", [0.0, 0.1, 0.2], [0.3, 0.0, 0.0, 0.0, 0.0, 0.0])
    assert ranges(ends) == "forward +0.3 V about 0 m"
    flat = shape("time", "s", [0.0, 1.0, 2.0], [0.0, 0.0, 0.0])
    assert ranges(flat) == "spread over its whole range, strong nowhere"
    assert [length_text(v) for v in (20e-6, 2.5e-3, 0.3)] == ["20 um", "2.5 mm", "0.3 m"]
