"""Figures of a gap: over time, against each coordinate with 95 % bands, over frequency, and folded at a period."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

from cogging.diagnosis.report.binning import Series, binned, bins_of, envelope, liveliest, rows_of, smoothed, spectrum
from cogging.diagnosis.residual.shape import MOMENTS, Shape
from cogging.diagnosis.thresholds import REPORT
from cogging.model.intervals import SIGMAS_95

if TYPE_CHECKING:
    from matplotlib.figure import Figure

    from cogging.diagnosis.entries import ShapeTerm

COLOURS = ("#c2571a", "#1f5fa8", "#4a4a4a")  # told apart by the colour-blind and in grey


def coordinates_figure(gaps: Mapping[str, Series]) -> Figure:
    """The gap against position (each direction), velocity, acceleration, command, time and frequency.

    Args:
        gaps: label -> rows of logs by name: gap (V), mask, time, position, velocity, acceleration, command.
    """
    from matplotlib.figure import Figure

    figure = Figure(figsize=(11.0, 9.0), layout="constrained")
    axes = figure.subplots(3, 2)
    panels = (
        ("position", "position, moving forward (m)", 1.0),
        ("position", "position, moving backward (m)", -1.0),
        ("velocity", "velocity (m/s)", 0.0),
        ("acceleration", "acceleration (m/s²)", 0.0),
        ("command", "command (V)", 0.0),
    )
    for panel, (name, label, direction) in zip(axes.flat, panels, strict=False):
        draw_profile(panel, gaps, name, direction)
        panel.set(xlabel=label, ylabel="mean gap (V)")
    draw_spectrum(axes.flat[5], gaps)
    axes.flat[0].legend(loc="best", fontsize=8)
    return figure


def draw_profile(axes: Any, gaps: Mapping[str, Series], name: str, direction: float = 0.0) -> None:
    """Mean gap in bins of a coordinate, with 95 % bands from blocks of rows."""
    axes.axhline(0.0, color="black", linewidth=0.6)
    for (label, series), colour in zip(gaps.items(), COLOURS, strict=False):
        values, gap, block = rows_of(series, name, direction)
        if len(values) < REPORT.profile_rows:
            axes.text(0.5, 0.5, "no such motion", transform=axes.transAxes, ha="center")
            continue
        places, mean, half = binned(values, gap, block, bins_of(values, name))
        axes.fill_between(places, mean - half, mean + half, color=colour, alpha=0.25, linewidth=0)
        axes.plot(places, mean, color=colour, linewidth=1.4, label=label)


def draw_spectrum(axes: Any, gaps: Mapping[str, Series]) -> None:
    """Amplitude density of the gap of the longest log; rows at rest count as zero."""
    for (label, series), colour in zip(gaps.items(), COLOURS, strict=False):
        i = int(np.argmax([len(gap) for gap in series["gap"]]))
        frequency, density = spectrum(series["time"][i], np.where(series["mask"][i], series["gap"][i], 0.0))
        axes.loglog(frequency, density, color=colour, linewidth=1.0, label=label)
    axes.set(xlabel="frequency (Hz)", ylabel="gap (V/√Hz)")


def limits(shape: Shape) -> tuple[float, float]:
    """A range of force that shows the places that are known, and cuts the bars of those that are hardly seen."""
    known = shape.deviation < REPORT.deviation_shown * float(np.median(shape.deviation))
    reach = np.abs(shape.force[known]) + 2.2 * shape.deviation[known] if known.any() else np.abs(shape.force)
    top = float(np.max(reach)) or 1.0
    return -1.1 * top, 1.1 * top


def time_figure(gaps: Mapping[str, Series], log: int = 0) -> Figure:
    """The gap over time, and a stretch of it from close by; averaged a little, so that noise does not hide it."""
    from matplotlib.figure import Figure

    figure = Figure(figsize=(11.0, 5.2), layout="constrained")
    whole, near = figure.subplots(2, 1)
    for (label, series), colour in zip(gaps.items(), COLOURS, strict=False):
        time, gap = series["time"][log] - series["time"][log][0], series["gap"][log]
        gap = np.where(series["mask"][log], smoothed(gap, time), np.nan)
        few = max(1, len(time) // REPORT.trace_points)
        middle, low, high = envelope(time, gap, few)
        whole.fill_between(middle, low, high, color=colour, alpha=0.75, linewidth=0.3, label=label)
        strip = liveliest(series["gap"][log], np.asarray(series["mask"][log]), len(time) // 12)
        near.plot(time[strip], gap[strip], color=colour, linewidth=0.8, label=label)
    whole.set(xlabel="time (s)", ylabel="gap (V)")
    near.set(xlabel="time (s), a twelfth of the log", ylabel="gap (V)")
    whole.legend(loc="upper right", fontsize=8)
    return figure


def folded_figure(gaps: Mapping[str, Series], periods: Sequence[float]) -> Figure:
    """The gap within one period of position, for each period (m): what repeats itself, stands still here.

    Each direction by itself: an observer shows a ripple late, which is to one side forward and to the other backward.
    """
    from matplotlib.figure import Figure

    figure = Figure(figsize=(11.0, 5.2), layout="constrained")
    panels = np.asarray(figure.subplots(2, len(periods), squeeze=False, sharex="col", sharey="col"))
    for line, (way, sign) in enumerate((("forward", 1.0), ("backward", -1.0))):
        for panel, period in zip(panels[line], periods, strict=True):
            panel.axhline(0.0, color="black", linewidth=0.6)
            scale, unit = (1e3, "mm") if period < REPORT.folded_milli else (1.0, "m")
            for (label, series), colour in zip(gaps.items(), COLOURS, strict=False):
                position, gap, block = rows_of(series, "position")
                along = sign * rows_of(series, "velocity")[0] > 0.0
                if not along.any():
                    continue
                edges = np.linspace(0.0, period, REPORT.bin_quantiles)
                place, mean, half = binned(position[along] % period, gap[along], block[along], edges)
                panel.fill_between(scale * place, mean - half, mean + half, color=colour, alpha=0.25, linewidth=0)
                panel.plot(scale * place, mean, color=colour, linewidth=1.4, label=label)
            panel.set(ylabel=f"mean gap {way} (V)")
            if line == 1:
                panel.set(xlabel=f"position within {scale * period:.4g} {unit}")
    panels[0, 0].legend(loc="best", fontsize=8)
    return figure


def shapes_figure(shapes: Sequence[Shape]) -> Figure:
    """The force that the model lacks, as the whitened residual asks for it, in each coordinate, with 95 % bars."""
    from matplotlib.figure import Figure

    columns = min(3, len(shapes))
    lines = (len(shapes) + columns - 1) // columns
    figure = Figure(figsize=(11.0, 2.9 * lines), layout="constrained")
    panels = np.atleast_1d(figure.subplots(lines, columns)).ravel()
    for panel, shape in zip(panels, shapes, strict=False):
        draw_shape(panel, shape)
    for panel in panels[len(shapes) :]:
        panel.remove()
    return figure


def shape_term_figure(term: ShapeTerm) -> Figure:
    """What an effect has beside its plainest law, with 95 % bars; what is told twice at a place, beside each other."""
    from matplotlib.figure import Figure

    figure = Figure(figsize=(7.0, 2.9), layout="constrained")
    panel = figure.subplots()
    panel.axhline(0.0, color="black", linewidth=0.6)
    force, deviation = np.array(term.force), np.array(term.deviation)
    told = np.isfinite(deviation)
    panel.errorbar(
        np.array(term.places)[told],
        force[told],
        SIGMAS_95 * deviation[told],
        color=COLOURS[1],
        marker="o",
        markersize=3,
        linestyle="none",
        elinewidth=1.0,
        capsize=2,
    )
    if term.curve is not None:
        panel.plot(term.curve["places"], term.curve["force"], color=COLOURS[1], linewidth=1.0)
    panel.set(xlabel=f"{term.coordinate} ({term.unit})", ylabel="beside the plainest law")
    return figure


def draw_shape(panel: Any, shape: Shape) -> None:
    """One residual shape with 95 % bars, each direction by itself where it is told by direction."""
    m = len(shape.places)
    halves = [("", slice(0, len(shape.force)))]
    if len(shape.force) == 2 * m:
        halves = [("forward", slice(0, m)), ("backward", slice(m, 2 * m))]
    at_moments = shape.coordinate in MOMENTS
    panel.axhline(0.0, color="black", linewidth=0.6)
    panel.set_ylim(*limits(shape))
    for (label, half), colour, marker in zip(halves, COLOURS[1:], "os", strict=False):
        deviation = shape.deviation[half]
        told = np.isfinite(deviation)
        panel.errorbar(
            shape.places[told],
            shape.force[half][told],
            SIGMAS_95 * deviation[told],
            color=colour,
            marker=marker,
            markersize=3,
            linewidth=1.0,
            linestyle="none" if at_moments else "-",
            elinewidth=1.0,
            capsize=2,
            label=label or None,
        )
    if len(halves) > 1:
        panel.legend(fontsize=8)
    unit = {"friction": "V of friction", "gain": "share of the command", "drag": "V per m/s", "jumps": "m"}
    panel.set(
        xlabel=f"{shape.coordinate.split()[-1]} ({shape.unit})",
        ylabel=f"missing ({unit.get(shape.coordinate.split()[0], 'V')})",
        title=shape.coordinate if at_moments else f"{shape.coordinate}: {100.0 * shape.share:.0f} %",
    )
