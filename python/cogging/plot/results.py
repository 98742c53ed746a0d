"""Figures of results with several panels, for their `.plot()`."""

from __future__ import annotations

from typing import Any

from cogging.plot.canvas import Panels, drawn, grid_of, legend
from cogging.plot.characteristics import DIRECTIONS, cogging_map, friction_curve, spectrum
from cogging.plot.many_runs import trade_off
from cogging.plot.over_time import log
from cogging.plot.scales import scale_of, units_of
from cogging.plot.series import look

WHOLE_MAP, WHOLE_TUNING = (7.2, 8.0), (9.0, 4.2)  # inches
MOTION = ("reference", "reference_velocity", "reference_acceleration")


@drawn
def whole_map_fit(fit: Any, *, units: Any = None, ax: Any = None) -> Panels:
    """Plot the map of a MapFit with its points, the residual over position, and the spectrum."""
    units = units or units_of(fit)
    panels = grid_of(ax, 3, size=WHOLE_MAP)
    cogging_map(fit, units=units, ax=panels[0])
    left = fit.force - fit.fitted
    along, up = scale_of("m", fit.position, units=units), scale_of("V", left, units=units)
    for place, (way, name) in enumerate(DIRECTIONS):
        kept = fit.direction == way
        if kept.any():
            style = {"linewidth": 0.7, **look(place, dense=True)}
            panels[1].plot(along(fit.position[kept]), up(left[kept]), label=name, **style)
    panels[1].set(xlabel=along.label("position"), ylabel=up.label("residual"))
    legend(panels[1])
    spectrum(fit, units=units, ax=panels[2])
    return panels


@drawn
def whole_model(model: Any, *, units: Any = None, ax: Any = None) -> Panels:
    """Plot the cogging of a model, if it has one, and its friction."""
    count = 1 if model.cogging is None else 2
    panels = grid_of(ax, count, size=(7.2, 0.6 + 2.6 * count))
    if model.cogging is not None:
        cogging_map(model, units=units, ax=panels[0])
    friction_curve(model, units=units, ax=panels[-1])
    return panels


@drawn
def whole_tuning(tuning: Any, *, units: Any = None, ax: Any = None) -> Panels:
    """Plot the trade-off of a tuning, and its points over the delay margin or the chatter."""
    panels = grid_of(ax, 2, 2, size=WHOLE_TUNING)
    beside = "delay_margin" if tuning.against != "delay_margin" else "command_chatter"
    for panel, index in zip(panels, (tuning.against, beside), strict=True):
        trade_off(tuning, index, units=units, ax=panel)
    return panels


@drawn
def whole_plan(plan: Any, *, units: Any = None, ax: Any = None) -> Panels:
    """Plot position, velocity and acceleration of a planned motion over time."""
    units = units or units_of(plan)
    return log(dict(plan.motion.samples), MOTION, units=units, ax=ax)
