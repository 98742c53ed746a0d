"""Figures of a gap."""

import numpy as np
from matplotlib.figure import Figure

from cogging.diagnosis.report.figures import NO_MOTION, direction_of, draw_profile


def test_a_profile_without_a_direction_says_so():
    time = np.arange(2000) / 1000.0
    series = {name: [np.linspace(0.0, 1.0, 2000)] for name in ("gap", "position", "acceleration", "command")}
    series |= {"time": [time], "velocity": [np.ones(2000)], "mask": [np.ones(2000, bool)]}
    forward, backward = Figure().subplots(1, 2)
    for axes, way in ((forward, "forward"), (backward, "backward")):
        draw_profile(axes, {"one way": series}, "position", direction_of(way))
    assert [text.get_text() for text in forward.texts] == []
    assert [text.get_text() for text in backward.texts] == [NO_MOTION]
