"""Figs. 2 to 6 of Xu and Yao 2001, and what the robust terms do to the command."""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING

import numpy as np

from cogging.logs.log import Log
from cogging.papers.compared import Trace, compared
from cogging.papers.xu2001.fast_motion import WITHIN
from cogging.papers.xu2001.robust_terms import FACTORS, HARDWARE, PERIOD, increment
from cogging.papers.xu2001.setup import CONTROLLERS, DISTURBANCE, DURATION, TABLE_1, fast_reference, indexes
from cogging.plot.canvas import drawn, legend, new_figure
from cogging.plot.scales import pretty, scale_of
from cogging.plot.series import LIMIT, look, marker
from cogging.plot.traces import draw_trace

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

#: Number and words of the figure of each set, and the part (s) of the run that its second column shows.
OF_SET = {
    "1": (2, "without load", (DURATION - PERIOD, DURATION)),
    "2": (3, "with load (cut off, as in the paper)", (DURATION - PERIOD, DURATION)),
    "3": (4, "with disturbance", (DISTURBANCE[1] - 0.2, DISTURBANCE[1] + 0.8)),
}
#: m: where Fig. 3 is cut off. The paper says that it is, and not where; assumed: the scale of Fig. 2.
CUT_OFF = 60e-6
BAND = 5e-6  # m: scale of the rests in Fig. 6


def figure_errors(logs: Mapping[str, Mapping[str, Log]], set_name: str) -> Figure:
    """Figs. 2, 3, 4: the tracking errors of PID and ARC on one scale, and a part of them."""
    number, words, part = OF_SET[set_name]
    cut = set_name == "2"
    traces = []
    for name in CONTROLLERS:
        log, printed = logs[name][set_name], TABLE_1[name][set_name][0]
        found = indexes(log)["e_M"]
        words_of = f"{name}: largest {1e6 * found:.3g} µm, the paper's {1e6 * printed:.3g} µm" if cut else name
        traces.append(Trace(words_of, log.time, log.error, printed=None if cut else printed))
    return compared(f"Fig. {number}: sinusoidal motion {words}", traces, zoom=part, limit=CUT_OFF if cut else None)


@drawn
def figure_reference() -> Figure:
    """Fig. 5: the fast point-to-point motion; dashed: the printed largest velocity and acceleration."""
    motion = fast_reference()
    time = np.linspace(0.0, motion.end, 4001)
    figure = new_figure((8.0, 5.4))
    figure.suptitle("Fig. 5: fast point-to-point motion (stroke and rests assumed)")
    quantities = (("position", "m", 0.0), ("velocity", "m/s", 1.0), ("acceleration", "m/s^2", 12.0))
    panels = figure.subplots(3, 1, sharex=True)
    for axes, values, (name, unit, largest) in zip(panels, motion.sample(time), quantities, strict=True):
        axes.plot(time, values, **look(0))
        axes.set(ylabel=f"{name}\n({pretty(unit)})")
        for side in (-1.0, 1.0) if largest else ():
            axes.axhline(side * largest, color=LIMIT, linestyle=(0, (6, 3)), linewidth=1.0)
    panels[-1].set(xlabel="time (s)")
    figure.align_ylabels(panels)
    return figure


@drawn
def figure_fast(logs: Mapping[str, Log]) -> Figure:
    """Fig. 6: the errors of PID and ARC in the fast motion on one scale, and in one rest beside the paper's 1 um."""
    motion = fast_reference()
    rest = (motion.move_time, motion.period / 2.0)
    scale = scale_of("m", *(logs[name].error for name in CONTROLLERS))
    figure = new_figure((8.0, 4.7))
    figure.suptitle("Fig. 6: fast point-to-point motion, and its first rest")
    panels = figure.subplots(2, 2, sharex="col", sharey="col")
    for row, name in zip(panels, CONTROLLERS, strict=True):
        log = logs[name]
        for axes, (start, end) in zip(row, ((-np.inf, np.inf), rest), strict=True):
            shown = (log.time >= start) & (log.time < end)
            draw_trace(axes, log.time[shown], scale(log.error[shown]), linewidth=0.8, **look(0, dense=True))
            axes.margins(x=0.01)
        row[0].set(ylabel=scale.label("error"))
        row[0].set_title(name, fontsize="small", loc="left", pad=3.0)
        _mark_band(row[1], float(scale(WITHIN)), float(scale(BAND)))
    for axes in panels[-1]:
        axes.set(xlabel="time (s)")
    return figure


def _mark_band(axes: Axes, size: float, end: float) -> None:
    for side in (-size, size):
        axes.axhline(side, color=LIMIT, linestyle=(0, (6, 3)), linewidth=1.0)
    axes.set(ylim=(-end, end))
    axes.set_title("dashed: the paper's ±1 µm of the ARC at rest", fontsize="small", loc="right", pad=3.0)


@drawn
def figure_increment() -> Figure:
    """The rms command increment against a common factor on the printed robust terms."""
    figure = new_figure((7.2, 4.2))
    figure.suptitle("The printed robust terms times a factor; a line ends where the run diverges")
    axes = figure.subplots()
    for place, (rate, resolution) in enumerate(HARDWARE):
        values = [increment(factor, rate, resolution) for factor in FACTORS[1:]]
        length = scale_of("m", resolution)
        label = f"{rate / 1000:g} kHz, {length(resolution):g} {length.unit}"
        axes.loglog(FACTORS[1:], values, marker=marker(place), label=label, **look(place))
    printed = TABLE_1["ARC"]["1"][4]
    axes.axhline(printed, color=LIMIT, linestyle=(0, (6, 3)), linewidth=1.0, label=f"paper: {printed:g} V")
    axes.set(xlabel="factor on the printed robust terms", ylabel="rms command increment (V)", xlim=(5e-8, 2.0))
    legend(axes)
    return figure
