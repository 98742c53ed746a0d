"""Figs. 2, 3, 5 to 10 of Lu, Chen, Yao, Wang 2008."""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING

import numpy as np

from cogging._core import BSpline
from cogging.logs.log import Log
from cogging.mapping.map_fit import MapFit
from cogging.papers.compared import Trace, compared
from cogging.papers.lu2008.harmonics import CoggingScan
from cogging.papers.lu2008.setup import PITCH, GantryAxis, reference
from cogging.plot.canvas import drawn, legend, new_figure
from cogging.plot.scales import scale_of
from cogging.plot.series import FITTED, LIMIT, MEASURED

if TYPE_CHECKING:
    from matplotlib.figure import Figure

SIZE = (8.0, 3.4)  # inches


@drawn
def figure_spline(order: int, number: int) -> Figure:
    """Figs. 2, 3: f_S(x) of order 1 and 3 over five magnets; the control points are of our choice."""
    magnets = 5
    points = np.array([0.6, 1.0, 0.4, 0.8, 0.5, 0.9, 0.7])[: magnets + order - 1]
    spline = BSpline(order=order, origin=0.0, pitch=PITCH, control_points=len(points))
    x = np.linspace(0.0, spline.end, 1001)[:-1]
    middles = (np.arange(len(points)) + 1 - order / 2) * PITCH  # of each control point's support
    along = scale_of("m", x)
    figure = new_figure(SIZE)
    axes = figure.subplots()
    axes.plot(along(x), spline.design_matrix(x) @ points, color=MEASURED, label="f_S(x)")
    axes.plot(along(middles), points, "o", color=LIMIT, markersize=6, label="control points")
    for magnet in range(magnets + 1):
        axes.axvline(float(along(magnet * PITCH)), color="0.6", linestyle=":", linewidth=0.9)
    axes.set(xlabel=along.label("position"), ylabel="f_S (V)")
    axes.set_title(f"Fig. {number}: B-spline of order {order}; dotted: the knots", loc="left")
    legend(axes)
    return figure


@drawn
def figure_map(axis: GantryAxis, scan: CoggingScan, fit: MapFit, number: int) -> Figure:
    """Figs. 5, 6: the scan of the assumed map over the whole travel, and its fit with the paper's five harmonics."""
    along, up = scale_of("m", scan.position), scale_of("V", scan.force)
    figure = new_figure(SIZE)
    axes = figure.subplots()
    axes.plot(along(scan.position), up(scan.force), ".", color=MEASURED, markersize=4, label="scan at 1 mm")
    x = np.linspace(scan.position[0], scan.position[-1], 4 * scan.position.size)
    fitted = fit.cogging.force(x) + fit.offset + fit.trend * (x - x.mean())
    axes.plot(along(x), up(fitted), color=FITTED, linewidth=0.9, label="fitted, order 3")
    axes.set(xlabel=along.label("position"), ylabel=up.label("force"))
    axes.set_title(f"Fig. {number}: cogging force of the {axis.name} axis (assumed)", loc="left")
    axes.margins(x=0.01)
    legend(axes)
    return figure


def figure_errors(axis: GantryAxis, logs: Mapping[str, Log], number: int, last_period: bool = False) -> Figure:
    """Figs. 7 and 9: the tracking errors of C1 to C3 over the whole run, and the last move forth; 8, 10: last period.

    The maxima of Tables 1 and 2 are marked.
    """
    motion = reference(axis)
    begin = motion.end - motion.period
    traces = []
    for (name, log), printed in zip(logs.items(), axis.error_max, strict=True):
        shown = log.time >= (begin if last_period else 0.0)
        traces.append(Trace(name, log.time[shown], log.error[shown], printed))
    said = "one period" if last_period else "whole run and the last move forth"
    zoom = None if last_period else (begin, begin + 0.5 * motion.period)
    title = f"Fig. {number}: tracking errors, {axis.name} axis, {said}"
    return compared(title, traces, quantity="error", zoom=zoom)
