"""Figures of a gap: over time, against each coordinate with 95 % bands, over frequency, and folded at a period.

Each drawing says in words what it shows, for those who cannot see it.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING, Any

import numpy as np

from cogging.arrays import FloatArray
from cogging.diagnosis.places import COORDINATE_UNITS, Shape
from cogging.diagnosis.report.binning import (
    QUANTILES,
    Series,
    binned,
    bins_of,
    envelope,
    liveliest,
    rows_of,
    smoothed,
    spectrum,
)
from cogging.model.intervals import SIGMAS_95
from cogging.model.units import Units

if TYPE_CHECKING:
    from cogging.diagnosis.entries import NamedEffect

#: The largest of a curve and where it is; None where nothing stands out.
Extreme = tuple[float, float] | None
COLOURS = ("#c2571a", "#1f5fa8", "#4a4a4a")  # told apart by the colour-blind and in grey


FEWEST = 100  # rows: fewer are no such motion
SHOWN = 4.0  # median deviations of a shape: larger bars are cut
POINTS = 4000  # of a trace: more cannot be seen
MILLI = 0.1  # m: shorter periods are drawn in mm
NO_MOTION = "no such motion"  # of a way that the axis did not move
PANELS = (  # coordinate, what the axis is called, its unit, direction of motion
    ("position", "position, moving forward", "m", "forward"),
    ("position", "position, moving backward", "m", "backward"),
    ("velocity", "velocity", "m/s", ""),
    ("acceleration", "acceleration", "m/s²", ""),
    ("command", "command", "V", ""),
)


def direction_of(way: str) -> float:
    """The sign of a direction of motion by its word; 0 of both."""
    return {"forward": 1.0, "backward": -1.0}.get(way, 0.0)


def draw_profile(axes: Any, gaps: Mapping[str, Series], name: str, direction: float = 0.0) -> dict[str, Extreme]:
    """Mean gap in bins of a coordinate, with 95 % bands from blocks of rows; its largest by label, beyond its band."""
    told = {}
    axes.axhline(0.0, color="black", linewidth=0.6)
    for (label, series), colour in zip(gaps.items(), COLOURS, strict=False):
        values, gap, block = rows_of(series, name, direction)
        if len(values) < FEWEST:
            axes.text(0.5, 0.5, NO_MOTION, transform=axes.transAxes, ha="center")
            continue
        places, mean, half = binned(values, gap, block, bins_of(values, name))
        axes.fill_between(places, mean - half, mean + half, color=colour, alpha=0.25, linewidth=0)
        axes.plot(places, mean, color=colour, linewidth=1.4, label=label)
        told[label] = extreme(places, mean, half)
    return told


def extreme(places: FloatArray, mean: FloatArray, half: FloatArray) -> Extreme:
    """The largest mean that stands out of its band, and where; None where none does."""
    clear = np.where(np.abs(mean) > half, np.abs(mean), 0.0)  # a band that is not known is nan: not clear
    if not len(clear) or not np.max(clear) > 0.0:
        return None
    peak = int(np.argmax(clear))
    return float(mean[peak]), float(places[peak])


def draw_spectrum(axes: Any, gaps: Mapping[str, Series], units: Units) -> dict[str, Extreme]:
    """Amplitude density of the gap of the longest log; rows at rest count as zero. Its largest by label."""
    told: dict[str, Extreme] = {}
    for (label, series), colour in zip(gaps.items(), COLOURS, strict=False):
        i = int(np.argmax([len(gap) for gap in series["gap"]]))
        frequency, density = spectrum(series["time"][i], np.where(series["mask"][i], series["gap"][i], 0.0))
        axes.loglog(frequency, density, color=colour, linewidth=1.0, label=label)
        peak = int(np.argmax(density))
        told[label] = (float(density[peak]), float(frequency[peak]))
    axes.set(xlabel="frequency (Hz)", ylabel=f"gap ({units.of('V/√Hz')})")
    return told


def limits(shape: Shape) -> tuple[float, float]:
    """A range of force that shows the places that are known, and cuts the bars of those that are hardly seen."""
    known = shape.deviation < SHOWN * float(np.median(shape.deviation))
    reach = np.abs(shape.force[known]) + 2.2 * shape.deviation[known] if known.any() else np.abs(shape.force)
    top = float(np.max(reach)) or 1.0
    return -1.1 * top, 1.1 * top


def draw_trace(axes: Any, gaps: Mapping[str, Series], units: Units, *, near: bool, log: int = 0) -> dict[str, float]:
    """The gap over time, or a stretch of it from close by, averaged a little so that noise does not hide it; its rms.

    Rows at rest are left out.
    """
    told = {}
    for (label, series), colour in zip(gaps.items(), COLOURS, strict=False):
        time, mask = series["time"][log] - series["time"][log][0], np.asarray(series["mask"][log]) > 0
        told[label] = float(np.sqrt(np.mean(series["gap"][log][mask] ** 2))) if mask.any() else 0.0
        gap = np.where(mask, smoothed(series["gap"][log], time), np.nan)
        if near:
            strip = liveliest(series["gap"][log], mask, len(time) // 12)
            axes.plot(time[strip], gap[strip], color=colour, linewidth=0.8, label=label)
            continue
        middle, low, high = envelope(time, gap, max(1, len(time) // POINTS))
        axes.fill_between(middle, low, high, color=colour, alpha=0.75, linewidth=0.3, label=label)
    axes.set(xlabel="time (s), a twelfth of the log" if near else "time (s)", ylabel=f"gap ({units.of('V')})")
    return told


def draw_folded(
    axes: Any, gaps: Mapping[str, Series], period: float, sign: float, units: Units
) -> dict[str, float | None]:
    """The gap within one period of position (m), moving one way: what repeats itself, stands still here.

    Each direction by itself: an observer shows a ripple late, which is to one side forward and to the other backward.

    Returns:
        Amplitude of the wave of that period by label, V; None where no row moves that way.
    """
    told: dict[str, float | None] = {}
    axes.axhline(0.0, color="black", linewidth=0.6)
    scale, unit = (1e3, "mm") if period < MILLI else (1.0, "m")
    for (label, series), colour in zip(gaps.items(), COLOURS, strict=False):
        position, gap, block = rows_of(series, "position")
        along = sign * rows_of(series, "velocity")[0] > 0.0
        told[label] = None
        if not along.any():
            continue
        edges = np.linspace(0.0, period, QUANTILES)
        place, mean, half = binned(position[along] % period, gap[along], block[along], edges)
        axes.fill_between(scale * place, mean - half, mean + half, color=colour, alpha=0.25, linewidth=0)
        axes.plot(scale * place, mean, color=colour, linewidth=1.4, label=label)
        if len(mean):
            told[label] = 2.0 * float(np.abs(np.mean(mean * np.exp(-2j * np.pi * place / period))))
    axes.set(ylabel=f"mean gap {'forward' if sign > 0.0 else 'backward'} ({units.of('V')})")
    axes.set(xlabel=f"position within {scale * period:.4g} {units.of(unit)}")
    return told


def draw_curve(panel: Any, effect: NamedEffect, units: Units) -> None:
    """The force over one coordinate of an effect whose law is not the plainest."""
    curve = effect.curve or {}
    panel.axhline(0.0, color="black", linewidth=0.6)
    panel.plot(curve["places"], curve["force"], color=COLOURS[1], linewidth=1.4)
    name = str(curve["coordinate"])
    panel.set(xlabel=f"{name} ({units.of(COORDINATE_UNITS[name])})", ylabel=f"force ({units.command})")


def draw_shape(panel: Any, shape: Shape, units: Units) -> None:
    """One residual shape with 95 % bars, each direction by itself where it is told by direction."""
    panel.axhline(0.0, color="black", linewidth=0.6)
    panel.set_ylim(*limits(shape))
    for (label, force, deviation), colour, marker in zip(shape.sides, COLOURS[1:], "os", strict=False):
        told = np.isfinite(deviation)
        panel.errorbar(
            shape.places[told],
            force[told],
            SIGMAS_95 * deviation[told],
            color=colour,
            marker=marker,
            markersize=3,
            linewidth=1.0,
            elinewidth=1.0,
            capsize=2,
            label=label or None,
        )
    if len(shape.sides) > 1:
        panel.legend(fontsize=8)
    panel.set(
        xlabel=f"{shape.coordinate} ({units.of(shape.unit)})",
        ylabel=f"missing ({units.command})",
        title=f"{shape.coordinate}: {100.0 * shape.share:.0f} %",
    )
