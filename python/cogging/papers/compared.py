"""Tracking errors of several controllers on one scale, with the values that a paper's table prints."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any, NamedTuple

import numpy as np
from matplotlib.figure import Figure

from cogging.arrays import FloatArray
from cogging.plot.canvas import drawn, titled_panels
from cogging.plot.scales import scale_of
from cogging.plot.series import LIMIT, look
from cogging.plot.traces import draw_trace

WIDTH, HEAD, PANEL = 8.0, 1.3, 1.7  # inches
HEADROOM = 1.12  # the scale ends at so many times the largest value
#: Line of a printed value.
PRINTED: dict[str, Any] = {"color": LIMIT, "linestyle": (0, (6, 3)), "linewidth": 1.0}


class Trace(NamedTuple):
    """The error of one controller."""

    name: str
    time: FloatArray  # s, (n,)
    error: FloatArray  # m, (n,)
    printed: float | None = None  # m, its largest size in the paper's table


@drawn
def compared(
    title: str, traces: Sequence[Trace], *, zoom: tuple[float, float] | None = None, limit: float | None = None
) -> Figure:
    """Return a figure of errors, a panel each; dashed lines mark the printed values.

    zoom: start and end (s) of a second column; limit: end of the scale, m.
    """
    sizes = [np.nanmax(np.abs(trace.error)) for trace in traces]
    sizes += [trace.printed for trace in traces if trace.printed is not None]
    scale, over = scale_of("m", sizes), scale_of("s", *(trace.time for trace in traces))
    end = scale(limit if limit is not None else HEADROOM * float(max(sizes)))
    parts = [(-np.inf, np.inf), *([zoom] if zoom else [])]
    size, shared = (WIDTH, HEAD + PANEL * len(traces)), {"sharex": "col", "sharey": True, "squeeze": False}
    figure, panels = titled_panels(title, size, len(traces), len(parts), **shared)
    for row, trace in zip(panels, traces, strict=True):
        for axes, (start, stop) in zip(row, parts, strict=True):
            shown = (trace.time >= start) & (trace.time <= stop)
            draw_trace(axes, over(trace.time[shown]), scale(trace.error[shown]), linewidth=0.8, **look(0, dense=True))
            axes.margins(x=0.01)
            if trace.printed is not None:
                for side in (-1.0, 1.0):
                    axes.axhline(side * float(scale(trace.printed)), **PRINTED)
        row[0].set(ylabel=scale.label("error"), ylim=(-end, end))
        row[0].set_title(trace.name, fontsize="small", loc="left", pad=3.0)
        if trace.printed is not None:
            said = f"dashed: the paper's table, {float(scale(trace.printed)):.3g} {scale.unit}"
            row[0].set_title(said, fontsize="small", loc="right", pad=3.0)
    for axes in panels[-1]:
        axes.set_xlabel(over.label("time"))
        axes.locator_params(axis="x", nbins=6)
    return figure


def set_ticks(axis: Any, places: Sequence[float]) -> None:
    """Label an axis at some places and nowhere else."""
    axis.set_ticks(places, [f"{place:g}" for place in places])
    axis.set_ticks([], minor=True)
