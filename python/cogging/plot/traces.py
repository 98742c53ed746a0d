"""Rows over time as they are drawn: rows that a log lacks are gaps, and long logs keep what a pixel can show."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from cogging.arrays import FloatArray, Mask

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.lines import Line2D

LOST = 1.75  # median steps: a longer one has lost a row
JITTER = 1.5  # times what nineteen of twenty steps take, where steps are not even
ROWS_PER_PIXEL = 4  # first, least, largest and last: a pixel shows no more


def gaps(time: FloatArray) -> Mask:
    """After which rows a row is missing: bool, (n - 1,)."""
    step = np.diff(time)
    if step.size < 2:
        return np.zeros(step.size, dtype=bool)
    usual = max(LOST * float(np.median(step)), JITTER * float(np.quantile(step, 0.95)))
    return np.asarray(step > usual)


def trace(time: FloatArray, values: FloatArray, pixels: int) -> tuple[FloatArray, FloatArray]:
    """The points to draw: all rows with a nan in each gap, or of more than a few a pixel the envelope of each pixel.

    Args:
        time: s, increasing, (n,); values likewise, nan where nothing is to be drawn.
        pixels: width of what is drawn.

    Returns:
        Places and values of the points, at most some five a pixel.
    """
    broken = gaps(time)
    if len(time) <= ROWS_PER_PIXEL * pixels:
        after = np.flatnonzero(broken) + 1
        return np.insert(time, after, time[after]), np.insert(values, after, np.nan)
    pixel = np.minimum(((time - time[0]) / (time[-1] - time[0]) * pixels).astype(int), pixels - 1)
    first = np.concatenate([[0], np.flatnonzero(np.diff(pixel)) + 1])
    last = np.concatenate([first[1:], [len(time)]]) - 1
    low, high = np.fmin.reduceat(values, first), np.fmax.reduceat(values, first)
    middle = 0.5 * (time[first] + time[last])
    ends = [values[first], low, high, values[last]]
    y = np.stack([*ends, np.full(len(first), np.nan)], axis=1)
    x = np.stack([time[first], middle, middle, time[last], time[last]], axis=1)
    shown = np.ones(y.shape, dtype=bool)
    shown[:, 4] = np.append(broken[last[:-1]], False)  # a pixel that ends in a gap is not joined to the next
    return x[shown], y[shown]


def draw_trace(ax: Axes, time: FloatArray, values: FloatArray, **look: Any) -> Line2D:
    """Draw rows over time as a line."""
    x, y = trace(time, values, pixels_of(ax))
    (line,) = ax.plot(x, y, **look)
    return line


def pixels_of(ax: Axes) -> int:
    """Twice the width of axes in pixels, for a sharp screen; at least 800."""
    return max(800, int(2.0 * ax.bbox.width))


def is_dense(ax: Axes, rows: int) -> bool:
    """Whether so many rows are several to a pixel, so that a dashed line would be none."""
    return rows > pixels_of(ax)
