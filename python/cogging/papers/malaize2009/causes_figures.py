"""The map of causes of Malaize and Levine 2009 as figures."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING

import numpy as np

from cogging.papers.malaize2009.causes import CAUSES, Explanation, other
from cogging.papers.malaize2009.setup import MOTORS
from cogging.plot.canvas import drawn, legend, new_figure
from cogging.plot.series import GREY, look, marker

if TYPE_CHECKING:
    from matplotlib.figure import Figure

RATIOS = (0.1, 0.2, 0.5, 1, 2, 5, 10)
SHOWN = {"1": (100.0, "%"), "s": (1e6, "µs"), "m": (1e6, "µm"), "m/s": (1e3, "mm/s")}  # factor and label by unit


@drawn
def figure_held_out(found: Sequence[Explanation]) -> Figure:
    """The observer's accuracy over the printed one on the motor that took no part, by cause."""
    figure = new_figure((8.0, 4.5))
    figure.suptitle("One value for both motors? Each cause fitted on one motor, given to the other")
    axes = figure.subplots()
    names = [cause.name for cause in CAUSES]
    for place, motor in enumerate(MOTORS.values()):
        chosen = [each for each in found if each.motor is motor]
        ratios = [each.elsewhere.mean() / other(motor).accuracy[1] for each in chosen]
        rows = [names.index(each.cause.name) for each in chosen]
        label = f"fitted on {motor.name}, {other(motor).name} predicted"
        axes.semilogx(ratios, rows, marker(place), color=look(place)["color"], markersize=8, label=label)
    axes.axvspan(1 / 1.15, 1.15, color=GREY, alpha=0.35, linewidth=0.0)
    axes.axvline(1.0, color=GREY, linewidth=0.8)
    axes.set_yticks(range(len(names)), names)
    axes.invert_yaxis()
    axes.set_xticks(RATIOS, [f"{ratio:g}" for ratio in RATIOS])
    axes.set_xticks([], minor=True)
    axes.set(xlim=(RATIOS[0], RATIOS[-1]), xlabel="observer's accuracy over the printed one (grey: within 15 %)")
    legend(axes)
    return figure


@drawn
def figure_causes(curves: Mapping[tuple[str, str], Sequence[tuple[float, float]]]) -> Figure:
    """The observer's accuracy over the printed one against the size of each cause, the PID's calibrated at each size.

    Args:
        curves: size and ratio by name of cause and motor, those of causes_calibration.curve.
    """
    figure = new_figure((8.0, 10.0))
    figure.suptitle("What alone would explain the observer's accuracy; the PID's is calibrated at every size")
    panels = figure.subplots(4, 2, sharey=True).ravel()
    for axes, cause in zip(panels, CAUSES, strict=False):
        factor, unit = SHOWN[cause.unit]
        for place, motor in enumerate(MOTORS.values()):
            sizes, ratios = np.transpose(curves[cause.name, motor.name])
            axes.loglog(factor * sizes, ratios, label=motor.name, marker=marker(place), markersize=4, **look(place))
        axes.axhline(1.0, color=GREY, linewidth=0.8)
        axes.set_xlabel(f"{cause.name} ({unit})")
        low, high = axes.get_xlim()
        ticks = [digit * 10.0**power for power in range(-4, 4) for digit in (1, 2, 5)]
        inside = [tick for tick in ticks if low <= tick <= high]
        axes.set_xticks(inside, [f"{tick:g}" for tick in inside])
        axes.set_xticks([], minor=True)
        axes.set_yticks(RATIOS, [f"{ratio:g}" for ratio in RATIOS])
        axes.set_yticks([], minor=True)
    for axes in panels[::2]:
        axes.set_ylabel("over the printed one")
    legend(panels[0])
    panels[-1].remove()
    return figure
