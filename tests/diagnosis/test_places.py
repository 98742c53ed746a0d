"""Where a gap sits, in words and without a name, and as an empirical force."""

import json

import numpy as np
import pytest

import cogging
from cogging.diagnosis.places import Shape, empirical_term, length_text, ranges
from tests.fixtures.pid_axis import MODEL, other, run

UNITS = cogging.Units()
effects = cogging.effects


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
    assert ranges(shape("time", "s", [0.0, 1.0, 2.0], [0.0, 0.0, 0.0]), UNITS) == "small over the whole range"
    assert [length_text(v, UNITS) for v in (20e-6, 2.5e-3, 0.3)] == ["20 um", "2.5 mm", "0.3 m"]


def test_a_curve_as_an_effect():
    """Of position, speed or time; of both directions the mean; of a command, or of what has no places, none."""
    curve = {"coordinate": "position", "places": [0.0, 0.1], "force": [0.1, 0.2, 0.3, 0.4]}
    assert np.allclose(empirical_term(curve).force_at(position=np.array([0.0, 0.1])), [0.2, 0.3])
    assert empirical_term(curve | {"coordinate": "time"}) is not None
    assert empirical_term(curve | {"coordinate": "command"}) is None
    assert empirical_term({"coordinate": "time", "shape": "bursts"}) is None


def test_the_gap_is_located_without_a_name():
    located = cogging.locate_gap(run(effects.CoggingHarmonic(period=0.03, sine=0.03)), MODEL)
    (wave, *_) = located.waves
    assert wave.coordinate == "spatial period"
    assert wave.value == pytest.approx(0.03, rel=1e-2)
    assert wave.amplitude == pytest.approx(0.03, rel=0.1)
    assert "every 30" in located.text()
    json.dumps(located.to_dict(), allow_nan=False)
    located = cogging.locate_gap(run(effects.DisturbanceTone(frequency=17.0, sine=0.03)), MODEL)
    assert located.waves[0].coordinate == "frequency"
    assert "at 17" in located.text()
    assert len(located.plot().axes) == 4


def test_what_no_effect_explains_is_added_where_it_is_asked_for(tmp_path):
    """A magnetic strip under a part of the travel, say, which pulls where it begins and where it ends."""
    places = np.linspace(0.0, 0.51, 103)
    pull = 0.08 * (np.exp(-(((places - 0.17) / 0.03) ** 2)) - np.exp(-(((places - 0.31) / 0.03) ** 2)))
    hidden = effects.EmpiricalForce(position_nodes=list(places), position_forces=list(pull))
    result = cogging.diagnose(run(hidden), MODEL, confirm=other(hidden), empirical=True)
    assert result.verdict == "unlisted"
    assert result.unlisted["coordinate"] == "position"
    told = result.unlisted["added"]
    assert told["name"] == "empirical_force"
    assert told["signal"] == result.gap.signal
    assert told["gap_before"] == result.gap.after
    assert told["gap_after"] < 0.8 * told["gap_before"]
    assert told["confirm_after"] < 0.9 * told["confirm_before"]
    assert "empirical and names no cause" in result.text()
    assert "empirical and names no cause" in result.html()
    within = np.linspace(0.1, 0.38, 57)
    found = sum(effect.force_at(position=within) for effect in result.model.effects if hasattr(effect, "force_at"))
    assert np.corrcoef(found, np.interp(within, places, pull))[0, 1] > 0.95
    path = tmp_path / "patched.toml"
    result.model.write(path)
    again = cogging.Model.read(path)
    assert again.effects == result.model.effects
    assert len(run(*again.effects, duration=0.5)) > 500
