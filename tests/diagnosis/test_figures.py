"""Figures of a gap."""

import numpy as np

from cogging.diagnosis.report.figures import coordinates_figure


def test_a_profile_without_a_direction_says_so():
    time = np.arange(2000) / 1000.0
    series = {name: [np.linspace(0.0, 1.0, 2000)] for name in ("gap", "position", "acceleration", "command")}
    series |= {"time": [time], "velocity": [np.ones(2000)], "mask": [np.ones(2000, bool)]}
    figure = coordinates_figure({"one way": series})
    assert [text.get_text() for text in figure.axes[1].texts] == ["no such motion"]
