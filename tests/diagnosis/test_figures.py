"""Figures of a gap: bands, spectra, directions."""

import numpy as np
import pytest
from matplotlib.figure import Figure

from cogging.diagnosis.report.figures import NO_MOTION, direction_of, draw_profile, spectrum
from cogging.plot.gaps import Rows, binned


def test_a_profile_without_a_direction_says_so():
    time = np.arange(2000) / 1000.0
    series = {name: [np.linspace(0.0, 1.0, 2000)] for name in ("gap", "position", "acceleration", "command")}
    series |= {"time": [time], "velocity": [np.ones(2000)], "mask": [np.ones(2000, bool)]}
    forward, backward = Figure().subplots(1, 2)
    for axes, way in ((forward, "forward"), (backward, "backward")):
        draw_profile(axes, {"one way": series}, "position", direction_of(way))
    assert [text.get_text() for text in forward.texts] == []
    assert [text.get_text() for text in backward.texts] == [NO_MOTION]


def test_bands_hold_the_truth_and_the_spectrum_its_scale():
    rng = np.random.default_rng(0)
    inside = []
    for _ in range(200):
        block = np.repeat(np.arange(60), 50)
        gap = 0.3 + np.repeat(rng.normal(0.0, 1.0, 60), 50) + rng.normal(0.0, 0.1, 3000)
        _, mean, half = binned(Rows(gap, {"place": rng.uniform(0.0, 1.0, 3000)}, block), "place")
        inside.append(np.abs(mean - 0.3) < half)
    assert 0.9 < np.mean(inside) < 0.98  # rows of a block say the same; bands of single rows would hold 25 %
    frequency, density = spectrum(np.arange(20000) / 1000.0, rng.normal(0.0, 2.0, 20000))
    assert frequency[-1] == pytest.approx(500.0, rel=1e-2)
    assert np.sqrt(np.mean(density**2)) == pytest.approx(2.0 / np.sqrt(500.0), rel=0.05)
