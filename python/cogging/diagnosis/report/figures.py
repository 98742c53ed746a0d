"""Figures of a gap: over time, against each coordinate with 95 % bands, over frequency, and folded at a period.

Each drawing says in words what it shows, for those who cannot see it.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

from cogging.arrays import FloatArray, Mask
from cogging.diagnosis.places import COORDINATE_UNITS, Shape
from cogging.estimation.statistics import moving_average
from cogging.model.intervals import SIGMAS_95
from cogging.model.units import Units
from cogging.plot.gaps import Rows, binned, joined

if TYPE_CHECKING:
    from cogging.diagnosis.entries import NamedEffect

Series = Mapping[str, Sequence[FloatArray]]
#: The largest of a curve and where it is; None where nothing stands out.
Extreme = tuple[float, float] | None
COLOURS = ("#c2571a", "#1f5fa8", "#4a4a4a")  # told apart by the colour-blind and in grey
FEWEST = 100  # rows: fewer are no such motion
SHOWN = 4.0  # median deviations of a shape: larger bars are cut
POINTS = 4000  # of a trace: more cannot be seen
MILLI = 0.1  # m: shorter periods are drawn in mm
TRACE = 0.01  # s over which traces are averaged
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


def moving(series: Series, direction: float) -> Rows:
    """Rows in motion one way, or both (0), of all logs."""
    ways = zip(series["mask"], series["velocity"], strict=True)
    kept = [(np.asarray(m) > 0) & ((direction == 0.0) | (direction * np.asarray(v) > 0.0)) for m, v in ways]
    return joined({**series, "mask": kept}, "gap")


def draw_profile(axes: Any, gaps: Mapping[str, Series], name: str, direction: float = 0.0) -> dict[str, Extreme]:
    """Mean gap in bins of a coordinate, with 95 % bands from blocks of rows; its largest by label, beyond its band."""
    told = {}
    axes.axhline(0.0, color="black", linewidth=0.6)
    for (label, series), colour in zip(gaps.items(), COLOURS, strict=False):
        rows = moving(series, direction)
        if len(rows.residual) < FEWEST:
            axes.text(0.5, 0.5, NO_MOTION, transform=axes.transAxes, ha="center")
            continue
        places, mean, half = binned(rows, name)
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
        rows = moving(series, sign)
        told[label] = None
        if not len(rows.residual):
            continue
        place, mean, half = binned(
            Rows(rows.residual, {"place": rows.coordinates["position"] % period}, rows.block), "place"
        )
        axes.fill_between(scale * place, mean - half, mean + half, color=colour, alpha=0.25, linewidth=0)
        axes.plot(scale * place, mean, color=colour, linewidth=1.4, label=label)
        if np.isfinite(mean).any():
            told[label] = 2.0 * float(np.abs(np.nanmean(mean * np.exp(-2j * np.pi * place / period))))
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


# Rows as they are drawn -----------------------------------------------------------------------------------------------


def spectrum(time: FloatArray, values: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Frequencies and amplitude density (per √Hz), averaged over half-overlapping Hann windows of an eighth."""
    step = float(np.median(np.diff(time)))
    length = max(256, 2 * (len(values) // 16))
    length = min(length, len(values))
    window = np.hanning(length)
    parts = [values[first : first + length] for first in range(0, len(values) - length + 1, max(1, length // 2))]
    power = np.mean([np.abs(np.fft.rfft(window * (part - part.mean()))) ** 2 for part in parts], axis=0)
    density = np.sqrt(2.0 * power * step / float((window**2).sum()))
    return np.asarray(np.fft.rfftfreq(length, step)[1:]), np.asarray(density[1:])


def smoothed(values: FloatArray, time: FloatArray) -> FloatArray:
    """Running mean over TRACE."""
    return moving_average(values, round(TRACE / float(np.median(np.diff(time)))))


def liveliest(gap: FloatArray, mask: Mask, rows: int) -> slice:
    """A stretch of that many rows in the middle of the log in which the axis moves most of the time."""
    moving = np.concatenate([[0], np.cumsum(mask > 0)])
    starts = np.arange(0, max(1, len(gap) - rows), max(1, rows // 4))
    share = moving[np.minimum(starts + rows, len(gap))] - moving[starts]
    good = starts[share >= 0.95 * share.max()]
    first = int(good[len(good) // 2])
    return slice(first, first + rows)


def envelope(time: FloatArray, values: FloatArray, few: int) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Smallest and largest of every `few` rows, so that a long trace loses no peak; nan where all are nan."""
    if few < 2:
        return time, values, values
    end = len(time) // few * few
    rows = values[:end].reshape(-1, few)
    missing = np.isnan(rows).all(axis=1)
    low = np.where(missing, np.nan, np.min(np.where(np.isnan(rows), np.inf, rows), axis=1))
    high = np.where(missing, np.nan, np.max(np.where(np.isnan(rows), -np.inf, rows), axis=1))
    return time[:end].reshape(-1, few).mean(axis=1), low, high
