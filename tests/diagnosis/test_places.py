"""Where a gap sits, in words, and as an empirical force."""

import numpy as np

import cogging
from cogging.diagnosis.places import Shape, empirical_term, length_text, ranges

UNITS = cogging.Units()


def test_ranges_in_words():
    def shape(coordinate, unit, places, force):
        force = np.array(force)
        return Shape(coordinate, unit, np.array(places), force, np.full(force.size, 0.01), 100.0, -50.0, 0.4)

    fast = shape("velocity", "m/s", [-0.2, -0.01, 0.0, 0.01, 0.1, 0.2], [0.0, 0.0, 0.0, 0.0, 0.1, 0.3])
    assert ranges(fast, UNITS) == "+0.3 V from 0.1 m/s to 0.2 m/s"
    ends = shape("position", "m", [0.0, 0.1, 0.2], [0.3, 0.0, 0.0, 0.0, 0.0, 0.0])
    assert ranges(ends, UNITS) == "forward +0.3 V near 0 m"
    assert ranges(ends, cogging.Units("A", "rad")) == "forward +0.3 A near 0 rad"
    two = shape("time", "s", [0.0, 1.0, 2.0, 3.0], [0.3, 0.2, 0.0, -0.5])
    assert ranges(two, UNITS) == "-0.5 V near 3 s, +0.3 V from 0 s to 1 s"
    flat = shape("time", "s", [0.0, 1.0, 2.0], [0.0, 0.0, 0.0])
    assert ranges(flat, UNITS) == "small over the whole range"
    assert [length_text(v, UNITS) for v in (20e-6, 2.5e-3, 0.3)] == ["20 um", "2.5 mm", "0.3 m"]


def test_a_curve_as_an_effect():
    """Of position, speed or time; of both directions the mean; of a command, or of what has no places, none."""
    curve = {"coordinate": "position", "places": [0.0, 0.1], "force": [0.1, 0.2, 0.3, 0.4]}
    assert np.allclose(empirical_term(curve).force_at(position=np.array([0.0, 0.1])), [0.2, 0.3])
    assert empirical_term(curve | {"coordinate": "time"}) is not None
    assert empirical_term(curve | {"coordinate": "command"}) is None
    assert empirical_term({"coordinate": "time", "shape": "bursts"}) is None
