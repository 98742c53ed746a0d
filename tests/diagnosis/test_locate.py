"""Where a gap sits, without a name."""

import json

import pytest

import cogging
from tests.fixtures.pid_axis import MODEL, run

effects = cogging.effects


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
