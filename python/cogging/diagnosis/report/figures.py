"""Figures of a gap: over time, against each coordinate with 95 % bands, over frequency, and folded at a period."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

from cogging.arrays import FloatArray, Mask
from cogging.diagnosis.residual.events import MOMENTS
from cogging.diagnosis.residual.shapes import Shape
from cogging.estimation.statistics import moving_average
from cogging.model.intervals import SIGMAS_95

if TYPE_CHECKING:
    from matplotlib.figure import Figure

Series = Mapping[str, Sequence[FloatArray]]

BLOCK = 0.25  # s: rows closer than this say much the same, so that bands are computed from blocks
COLOURS = ("#c2571a", "#1f5fa8", "#4a4a4a")  # told apart by the colour-blind and in grey
SMOOTH = 0.01  # s, over which traces are averaged
POINTS = 4000  # of a trace: more cannot be seen


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
        values, gap, block = _rows(series, name, direction)
        if len(values) < 100:
            axes.text(0.5, 0.5, "no such motion", transform=axes.transAxes, ha="center")
            continue
        places, mean, half = binned(values, gap, block, bins_of(values, name))
        axes.fill_between(places, mean - half, mean + half, color=colour, alpha=0.25, linewidth=0)
        axes.plot(places, mean, color=colour, linewidth=1.4, label=label)


def _rows(series: Series, name: str, direction: float = 0.0) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Values of a coordinate, gap and block of the rows that count, of all logs."""
    values, gaps, blocks = [], [], []
    offset = 0.0
    for i, gap in enumerate(series["gap"]):
        kept = np.asarray(series["mask"][i]) > 0
        if direction:
            kept = kept & (direction * np.asarray(series["velocity"][i]) > 0.0)
        block = np.floor((series["time"][i] - series["time"][i][0]) / BLOCK)
        values.append(np.asarray(series[name][i])[kept])
        gaps.append(np.asarray(gap)[kept])
        blocks.append(block[kept] + offset)
        offset += float(block[-1]) + 1.0
    return np.concatenate(values), np.concatenate(gaps), np.concatenate(blocks)


def bins_of(values: FloatArray, name: str) -> FloatArray:
    """Edges of bins: of equal width in position and time, denser where there are more rows elsewhere."""
    if name in ("position", "time"):
        return np.linspace(float(values.min()), float(values.max()), 41)
    low, high = float(values.min()), float(values.max())
    both = np.union1d(np.quantile(values, np.linspace(0.0, 1.0, 33)), np.linspace(low, high, 17))
    kept = [low]  # cruising fills many quantiles with one value: no bin is narrower than one percent
    for edge in both[1:]:
        if edge - kept[-1] > 1e-2 * (high - low):
            kept.append(float(edge))
    return np.array(kept) if len(kept) > 2 else np.linspace(low, high, 4)


def binned(
    values: FloatArray, gap: FloatArray, block: FloatArray, edges: FloatArray
) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Places, means and half widths of 95 % intervals in bins; rows of one block count as one observation."""
    count = len(edges) - 1
    place = np.clip(np.searchsorted(edges, values, side="right") - 1, 0, count - 1)
    blocks, block_of = np.unique(block, return_inverse=True)
    cell = place * len(blocks) + block_of
    rows = np.bincount(cell, minlength=count * len(blocks)).reshape(count, -1).astype(float)
    sums = np.bincount(cell, gap, count * len(blocks)).reshape(count, -1)
    total = rows.sum(axis=1)
    middle = np.bincount(place, values, count)
    kept = total >= 20  # the mean of fewer rows is noise
    total, rows, sums, middle = total[kept], rows[kept], sums[kept], middle[kept] / total[kept]
    mean = sums.sum(axis=1) / total
    seen = (rows > 0).sum(axis=1)
    spread = ((sums - mean[:, None] * rows) ** 2).sum(axis=1) / total**2
    half = SIGMAS_95 * np.sqrt(spread * np.where(seen > 1, seen / np.maximum(seen - 1.0, 1.0), np.nan))
    return middle, mean, half


def draw_spectrum(axes: Any, gaps: Mapping[str, Series]) -> None:
    """Amplitude density of the gap of the longest log; rows at rest count as zero."""
    for (label, series), colour in zip(gaps.items(), COLOURS, strict=False):
        i = int(np.argmax([len(gap) for gap in series["gap"]]))
        frequency, density = spectrum(series["time"][i], np.where(series["mask"][i], series["gap"][i], 0.0))
        axes.loglog(frequency, density, color=colour, linewidth=1.0, label=label)
    axes.set(xlabel="frequency (Hz)", ylabel="gap (V/√Hz)")


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


def limits(shape: Shape) -> tuple[float, float]:
    """A range of force that shows the places that are known, and cuts the bars of those that are hardly seen."""
    known = shape.deviation < 4.0 * float(np.median(shape.deviation))
    reach = np.abs(shape.force[known]) + 2.2 * shape.deviation[known] if known.any() else np.abs(shape.force)
    top = float(np.max(reach)) or 1.0
    return -1.1 * top, 1.1 * top


def time_figure(gaps: Mapping[str, Series], log: int = 0) -> Figure:
    """The gap over time, and a stretch of it from close by; averaged over SMOOTH, so that noise does not hide it."""
    from matplotlib.figure import Figure

    figure = Figure(figsize=(11.0, 5.2), layout="constrained")
    whole, near = figure.subplots(2, 1)
    for (label, series), colour in zip(gaps.items(), COLOURS, strict=False):
        time, gap = series["time"][log] - series["time"][log][0], series["gap"][log]
        gap = np.where(series["mask"][log], smoothed(gap, time), np.nan)
        few = max(1, len(time) // POINTS)
        middle, low, high = envelope(time, gap, few)
        whole.fill_between(middle, low, high, color=colour, alpha=0.75, linewidth=0.3, label=label)
        strip = liveliest(series["gap"][log], np.asarray(series["mask"][log]), len(time) // 12)
        near.plot(time[strip], gap[strip], color=colour, linewidth=0.8, label=label)
    whole.set(xlabel="time (s)", ylabel="gap (V)")
    near.set(xlabel="time (s), a twelfth of the log", ylabel="gap (V)")
    whole.legend(loc="upper right", fontsize=8)
    return figure


def smoothed(values: FloatArray, time: FloatArray) -> FloatArray:
    """Running mean over SMOOTH."""
    return moving_average(values, round(SMOOTH / float(np.median(np.diff(time)))))


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
            scale, unit = (1e3, "mm") if period < 0.1 else (1.0, "m")
            for (label, series), colour in zip(gaps.items(), COLOURS, strict=False):
                position, gap, block = _rows(series, "position")
                along = sign * _rows(series, "velocity")[0] > 0.0
                if not along.any():
                    continue
                edges = np.linspace(0.0, period, 33)
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
    for panel in panels[len(shapes) :]:
        panel.remove()
    return figure
