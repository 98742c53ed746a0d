"""Errors of controllers that a paper compares: a panel each on one scale, with the value that its table prints."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np

from cogging.arrays import FloatArray
from cogging.plot.canvas import drawn, new_figure
from cogging.plot.scales import Scale, scale_of
from cogging.plot.series import LIMIT, look
from cogging.plot.traces import draw_trace

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

WIDTH, HEAD, PANEL = 8.0, 1.3, 1.7  # inches
HEADROOM = 1.12  # of the scale over the largest value


@dataclass(frozen=True)
class Trace:
    """One controller's panel.

    Attributes:
        name: of the controller.
        time: s, (n,).
        values: SI, (n,).
        printed: largest size that the paper's table prints, SI; None where it prints none.
    """

    name: str
    time: FloatArray
    values: FloatArray
    printed: float | None = None


@drawn
def compared(
    title: str,
    traces: Sequence[Trace],
    *,
    unit: str = "m",
    quantity: str = "error",
    zoom: tuple[float, float] | None = None,
    limit: float | None = None,
) -> Figure:
    """Draw what controllers are compared by, each in a panel, all on one scale.

    A dense trace is drawn as the envelope of each pixel. The table's value is a pair of dashed lines.

    Args:
        title: of the figure.
        traces: one a panel, from the top.
        unit: of the values, such as "m" or "V".
        quantity: what they are, for the axis.
        zoom: part (s) of the time that a second column shows; None: there is none.
        limit: where the scale ends (SI), as where a paper cuts it off; None: all is shown.
    """
    sizes = [np.nanmax(np.abs(trace.values)) for trace in traces]
    sizes += [trace.printed for trace in traces if trace.printed is not None]
    scale, over = scale_of(unit, sizes), scale_of("s", *(trace.time for trace in traces))
    end = limit if limit is not None else HEADROOM * float(max(sizes))
    columns = 1 if zoom is None else 2
    figure = new_figure((WIDTH, HEAD + PANEL * len(traces)))
    panels = figure.subplots(len(traces), columns, sharex="col", sharey=True, squeeze=False)
    figure.suptitle(title)
    for row, trace in zip(panels, traces, strict=True):
        _draw(row[0], trace, scale, over, trace.time >= -np.inf)
        row[0].set(ylabel=scale.label(quantity), ylim=(-scale(end), scale(end)))
        row[0].set_title(trace.name, fontsize="small", loc="left", pad=3.0)
        if zoom is not None:
            _draw(row[1], trace, scale, over, (trace.time >= zoom[0]) & (trace.time <= zoom[1]))
    for axes in panels[-1]:
        axes.set_xlabel(over.label("time"))
        axes.locator_params(axis="x", nbins=6)
    return figure


def set_ticks(axis: Any, places: Sequence[float]) -> None:
    """Label an axis at some places and nowhere else."""
    axis.set_ticks(places, [f"{place:g}" for place in places])
    axis.set_ticks([], minor=True)


def _draw(axes: Axes, trace: Trace, scale: Scale, over: Scale, shown: Any) -> None:
    draw_trace(axes, over(trace.time[shown]), scale(trace.values[shown]), linewidth=0.8, **look(0, dense=True))
    axes.margins(x=0.01)
    if trace.printed is None:
        return
    size = float(scale(trace.printed))
    for side in (-size, size):
        axes.axhline(side, color=LIMIT, linestyle=(0, (6, 3)), linewidth=1.0)
    if axes.get_subplotspec().is_first_col():  # type: ignore[union-attr]
        axes.set_title(f"dashed: the paper's table, {size:.3g} {scale.unit}", fontsize="small", loc="right", pad=3.0)
