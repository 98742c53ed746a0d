"""Figs. 2, 3, 5 to 10 of Lu, Chen, Yao, Wang 2008."""

from __future__ import annotations

from collections.abc import Iterator
from typing import TYPE_CHECKING, Any

import numpy as np

from cogging._core import BSpline, CoggingModel
from cogging.arrays import FloatArray
from cogging.logs.log import Log
from cogging.mapping.fit import fit_map
from cogging.papers.lu2008.setup import (
    HARMONICS,
    ORDER,
    PITCH,
    START,
    TRAVEL,
    GantryAxis,
    reference,
)
from cogging.plot.canvas import drawn, new_figure

if TYPE_CHECKING:
    from matplotlib.figure import Figure

SCAN_STEP = 0.001  # m: the maps were measured at 1 mm (section "System Identification")
SCAN_NOISE = 0.003  # V rms, not reported, assumed: of the force sensor in Figs. 5 and 6


def _figure(title: str, panels: int) -> tuple[Figure, list[Any]]:
    figure = new_figure((8.0, 1.6 + 1.9 * panels))
    axes = figure.subplots(panels, 1, sharex=True, sharey=True, squeeze=False)[:, 0]
    figure.suptitle(title)
    return figure, list(axes)


@drawn
def figure_spline(order: int, number: int) -> Figure:
    """Figs. 2, 3: f_S(x) of order 1 and 3 over five magnets; the control points are of our choice."""
    magnets = 5
    points = np.array([0.6, 1.0, 0.4, 0.8, 0.5, 0.9, 0.7])[: magnets + order - 1]
    spline = BSpline(order=order, origin=0.0, pitch=PITCH, control_points=len(points))
    x = np.linspace(0.0, spline.end, 1001)[:-1]
    figure, (axes,) = _figure(f"Fig. {number}: B-spline of order {order}", 1)
    axes.plot(x, spline.design_matrix(x) @ points)
    middles = (np.arange(len(points)) + 1 - order / 2) * PITCH  # of each control point's support
    axes.plot(middles, points, "go", label="control points")
    axes.set(xlabel="position (m)", ylabel="f_S (V)")
    axes.legend()
    return figure


@drawn
def figure_map(axis: GantryAxis, cogging: CoggingModel, number: int) -> Figure:
    """Figs. 5, 6: a scan of the assumed map at 1 mm with an assumed sensor noise, and its fit by `cogging map`."""
    x = np.arange(START, START + 0.4 + SCAN_STEP / 2, SCAN_STEP)
    measured = cogging.force(x) + np.random.default_rng(2008).normal(0.0, SCAN_NOISE, x.size)
    fit = fit_map(x, measured, pitch=PITCH, harmonics=list(HARMONICS), order=ORDER, origin=TRAVEL[0])
    figure, (axes,) = _figure(f"Fig. {number}: cogging force of the {axis.name} axis (assumed) and its fit", 1)
    axes.plot(x, measured, ".", markersize=3, label="scan at 1 mm")
    axes.plot(x, fit.cogging.force(x) + fit.offset, label="fitted, order 3")
    axes.set(xlabel="position (m)", ylabel="force (V)")
    axes.legend()
    return figure


@drawn
def figure_errors(axis: GantryAxis, logs: dict[str, Log], number: int, last_period: bool = False) -> Figure:
    """Figs. 7 and 9: the tracking errors of C1 to C3 over the whole run; 8 and 10: over the last period."""
    motion = reference(axis)
    title = f"Fig. {number}: tracking errors, {axis.name} axis" + (", one period" if last_period else "")
    figure, panels = _figure(title, 3)
    for axes, (name, time, error) in zip(panels, _errors(logs), strict=True):
        shown = time >= motion.end - motion.period if last_period else slice(None)
        axes.plot(time[shown], 1e6 * error[shown], linewidth=0.6)
        axes.set(ylabel=f"{name} (µm)")
        axes.grid(alpha=0.3)
    panels[-1].set(xlabel="time (s)")
    return figure


def _errors(
    logs: dict[str, Log],
) -> Iterator[tuple[str, FloatArray, FloatArray]]:
    for name, log in logs.items():
        yield name, log.time, log.error
