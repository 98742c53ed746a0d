"""Figs. 2 to 6 of Xu and Yao 2001."""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING

import numpy as np

from cogging.logs.log import Log
from cogging.papers.xu2001.setup import (
    CONTROLLERS,
    fast_reference,
)
from cogging.plot.canvas import drawn, new_figure

if TYPE_CHECKING:
    from matplotlib.figure import Figure


@drawn
def figure_errors(logs: Mapping[str, Mapping[str, Log]], set_name: str, title: str) -> Figure:
    """Figs. 2, 3, 4, 6: the tracking errors of PID and ARC."""
    figure = new_figure((8.0, 5.0))
    figure.suptitle(title)
    for axes, name in zip(figure.subplots(2, 1, sharex=True), CONTROLLERS, strict=True):
        log = logs[name][set_name]
        axes.plot(log.time, 1e6 * log.error, linewidth=0.6)
        axes.set(ylabel=f"{name} (µm)", xlabel="time (s)" if name == "ARC" else None)
        axes.grid(alpha=0.3)
    return figure


@drawn
def figure_reference() -> Figure:
    """Fig. 5: the fast point-to-point motion."""
    motion = fast_reference()
    time = np.linspace(0.0, motion.end, 2001)
    figure = new_figure((8.0, 5.0))
    figure.suptitle("Fig. 5: fast point-to-point motion (stroke and rests assumed)")
    names = ("position (m)", "velocity (m/s)", "acceleration (m/s^2)")
    for axes, values, name in zip(figure.subplots(3, 1, sharex=True), motion.sample(time), names, strict=True):
        axes.plot(time, values, linewidth=0.8)
        axes.set(ylabel=name)
    figure.axes[-1].set(xlabel="time (s)")
    return figure
