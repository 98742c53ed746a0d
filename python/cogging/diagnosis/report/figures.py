"""Figures of a gap: over time, against each coordinate with 95 % bands, over frequency, and folded at a period.

Each drawing returns the figures that its alternative text states.
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
Peak = tuple[float, float] | None  # largest value of a curve and its place; None without a significant one
COLOURS = ("#c2571a", "#1f5fa8", "#4a4a4a")  # distinct for the colour-blind and in grey
FEWEST = 100  # minimum number of rows in motion
SHOWN = 4.0  # median standard deviations of a shape: longer error bars are cut
POINTS = 4000  # maximum number of points of a trace
MILLI = 0.1  # m: shorter periods are drawn in mm
TRACE = 0.01  # s: averaging time of a trace
NO_MOTION = "no such motion"
PANELS = (  # coordinate, label, unit, direction of motion
    ("position", "position, moving forward", "m", "forward"),
    ("position", "position, moving backward", "m", "backward"),
    ("velocity", "velocity", "m/s", ""),
    ("acceleration", "acceleration", "m/s²", ""),
    ("command", "command", "V", ""),
)


def direction_of(way: str) -> float:
    """Return the sign of a direction of motion; 0 for both."""
    return {"forward": 1.0, "backward": -1.0}.get(way, 0.0)


def moving(series: Series, direction: float) -> Rows:
    """Return the rows in motion of all logs in one direction, or in both (0)."""
    ways = zip(series["mask"], series["velocity"], strict=True)
    kept = [(np.asarray(m) > 0) & ((direction == 0.0) | (direction * np.asarray(v) > 0.0)) for m, v in ways]
    return joined({**series, "mask": kept}, "gap")


def draw_profile(axes: Any, gaps: Mapping[str, Series], name: str, direction: float = 0.0) -> dict[str, Peak]:
    """Draw the mean gap in bins of a coordinate with 95 % bands; return its largest significant value by label."""
    peaks: dict[str, Peak] = {}
    axes.axhline(0.0, color="black", linewidth=0.6)
    for (label, series), colour in zip(gaps.items(), COLOURS, strict=False):
        rows = moving(series, direction)
        if len(rows.residual) < FEWEST:
            axes.text(0.5, 0.5, NO_MOTION, transform=axes.transAxes, ha="center")
            continue
        places, mean, half = binned(rows, name)
        axes.fill_between(places, mean - half, mean + half, color=colour, alpha=0.25, linewidth=0)
        axes.plot(places, mean, color=colour, linewidth=1.4, label=label)
        size = np.where(np.abs(mean) > half, np.abs(mean), 0.0)  # an unknown band is nan
        peak = int(np.argmax(size)) if np.max(size, initial=0.0) > 0.0 else None
        peaks[label] = None if peak is None else (float(mean[peak]), float(places[peak]))
    return peaks


def draw_spectrum(axes: Any, gaps: Mapping[str, Series], units: Units) -> dict[str, Peak]:
    """Draw the amplitude density of the gap of the longest log, zero at rest; return its largest value by label."""
    peaks: dict[str, Peak] = {}
    for (label, series), colour in zip(gaps.items(), COLOURS, strict=False):
        i = int(np.argmax([len(gap) for gap in series["gap"]]))
        frequency, density = spectrum(series["time"][i], np.where(series["mask"][i], series["gap"][i], 0.0))
        axes.loglog(frequency, density, color=colour, linewidth=1.0, label=label)
        peak = int(np.argmax(density))
        peaks[label] = (float(density[peak]), float(frequency[peak]))
    axes.set(xlabel="frequency (Hz)", ylabel=f"gap ({units.of('V/√Hz')})")
    return peaks


def draw_trace(axes: Any, gaps: Mapping[str, Series], units: Units, *, near: bool, log: int = 0) -> dict[str, float]:
    """Draw the gap over time, or an enlarged part of it, averaged and without rows at rest; return its rms by label."""
    rms = {}
    for (label, series), colour in zip(gaps.items(), COLOURS, strict=False):
        time, mask = series["time"][log] - series["time"][log][0], np.asarray(series["mask"][log]) > 0
        rms[label] = float(np.sqrt(np.mean(series["gap"][log][mask] ** 2))) if mask.any() else 0.0
        mean = moving_average(series["gap"][log], round(TRACE / float(np.median(np.diff(time)))))
        gap = np.where(mask, mean, np.nan)
        if near:
            strip = liveliest(series["gap"][log], mask, len(time) // 12)
            axes.plot(time[strip], gap[strip], color=colour, linewidth=0.8, label=label)
            continue
        middle, low, high = envelope(time, gap, max(1, len(time) // POINTS))
        axes.fill_between(middle, low, high, color=colour, alpha=0.75, linewidth=0.3, label=label)
    axes.set(xlabel="time (s), a twelfth of the log" if near else "time (s)", ylabel=f"gap ({units.of('V')})")
    return rms


def draw_folded(
    axes: Any, gaps: Mapping[str, Series], period: float, sign: float, units: Units
) -> dict[str, float | None]:
    """Draw the gap folded at a period of position (m), in one direction of motion.

    Returns:
        Amplitude of the wave of that period by label, V; None without motion in that direction.
    """
    amplitudes: dict[str, float | None] = {}
    axes.axhline(0.0, color="black", linewidth=0.6)
    scale, unit = (1e3, "mm") if period < MILLI else (1.0, "m")
    for (label, series), colour in zip(gaps.items(), COLOURS, strict=False):
        rows = moving(series, sign)
        amplitudes[label] = None
        if not len(rows.residual):
            continue
        place, mean, half = binned(
            Rows(rows.residual, {"place": rows.coordinates["position"] % period}, rows.block), "place"
        )
        axes.fill_between(scale * place, mean - half, mean + half, color=colour, alpha=0.25, linewidth=0)
        axes.plot(scale * place, mean, color=colour, linewidth=1.4, label=label)
        if np.isfinite(mean).any():
            amplitudes[label] = 2.0 * float(np.abs(np.nanmean(mean * np.exp(-2j * np.pi * place / period))))
    axes.set(ylabel=f"mean gap {'forward' if sign > 0.0 else 'backward'} ({units.of('V')})")
    axes.set(xlabel=f"position within {scale * period:.4g} {units.of(unit)}")
    return amplitudes


def draw_curve(panel: Any, effect: NamedEffect, units: Units) -> None:
    """Draw the force over one coordinate of an effect with a non-standard law."""
    curve = effect.curve or {}
    panel.axhline(0.0, color="black", linewidth=0.6)
    panel.plot(curve["places"], curve["force"], color=COLOURS[1], linewidth=1.4)
    name = str(curve["coordinate"])
    panel.set(xlabel=f"{name} ({units.of(COORDINATE_UNITS[name])})", ylabel=f"force ({units.command})")


def draw_shape(panel: Any, shape: Shape, units: Units) -> None:
    """Draw the missing force along one coordinate with 95 % bars, by direction if it depends on it."""
    panel.axhline(0.0, color="black", linewidth=0.6)
    known = shape.deviation < SHOWN * float(np.median(shape.deviation))
    reach = np.abs(shape.force[known]) + 2.2 * shape.deviation[known] if known.any() else np.abs(shape.force)
    top = 1.1 * (float(np.max(reach)) or 1.0)
    panel.set_ylim(-top, top)
    for (label, force, deviation), colour, marker in zip(shape.sides, COLOURS[1:], "os", strict=False):
        finite = np.isfinite(deviation)
        panel.errorbar(
            shape.places[finite],
            force[finite],
            SIGMAS_95 * deviation[finite],
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


# Rows -----------------------------------------------------------------------------------------------------------------


def spectrum(time: FloatArray, values: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Return frequencies and amplitude density (per √Hz), by Welch's method with Hann windows of an eighth."""
    step = float(np.median(np.diff(time)))
    length = max(256, 2 * (len(values) // 16))
    length = min(length, len(values))
    window = np.hanning(length)
    parts = [values[first : first + length] for first in range(0, len(values) - length + 1, max(1, length // 2))]
    power = np.mean([np.abs(np.fft.rfft(window * (part - part.mean()))) ** 2 for part in parts], axis=0)
    density = np.sqrt(2.0 * power * step / float((window**2).sum()))
    return np.asarray(np.fft.rfftfreq(length, step)[1:]), np.asarray(density[1:])


def liveliest(gap: FloatArray, mask: Mask, rows: int) -> slice:
    """Return a slice of `rows` rows near the middle of the log in which the axis moves most of the time."""
    moving = np.concatenate([[0], np.cumsum(mask > 0)])
    starts = np.arange(0, max(1, len(gap) - rows), max(1, rows // 4))
    share = moving[np.minimum(starts + rows, len(gap))] - moving[starts]
    good = starts[share >= 0.95 * share.max()]
    first = int(good[len(good) // 2])
    return slice(first, first + rows)


def envelope(time: FloatArray, values: FloatArray, few: int) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Return time, minimum and maximum of every `few` rows, so that no peak is lost; nan if all are nan."""
    if few < 2:
        return time, values, values
    end = len(time) // few * few
    rows = values[:end].reshape(-1, few)
    missing = np.isnan(rows).all(axis=1)
    low = np.where(missing, np.nan, np.min(np.where(np.isnan(rows), np.inf, rows), axis=1))
    high = np.where(missing, np.nan, np.max(np.where(np.isnan(rows), -np.inf, rows), axis=1))
    return time[:end].reshape(-1, few).mean(axis=1), low, high
