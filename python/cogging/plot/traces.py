"""Data of plots: columns of logs and tables, and long traces reduced to what a pixel shows."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Any

import numpy as np
import numpy.typing as npt

from cogging.arrays import FloatArray, Mask
from cogging.calls import described, did_you_mean

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.lines import Line2D

#: Units of the columns of a log.
UNITS = {"position": "m", "reference": "m", "error": "m", "command": "V"}
UNITS |= {"reference_velocity": "m/s", "reference_acceleration": "m/s^2"}
UNITS |= {"true_position": "m", "true_velocity": "m/s"}
LOST = 1.75  # median steps: a longer step has lost a row
JITTER = 1.5  # times the 95 % quantile of the steps, if they are uneven
ROWS_PER_PIXEL = 4  # first, least, largest and last


def gaps(time: FloatArray) -> Mask:
    """Return after which rows a row is missing, (n - 1,)."""
    step = np.diff(time)
    if step.size < 2:
        return np.zeros(step.size, dtype=bool)
    usual = max(LOST * float(np.median(step)), JITTER * float(np.quantile(step, 0.95)))
    return np.asarray(step > usual)


def trace(time: FloatArray, values: FloatArray, pixels: int) -> tuple[FloatArray, FloatArray]:
    """Return the points of a line: all rows with NaN in each gap, or the envelope of each pixel of a long trace."""
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
    """Plot rows over time as a line."""
    x, y = trace(time, values, pixels_of(ax))
    (line,) = ax.plot(x, y, **look)
    return line


def pixels_of(ax: Axes) -> int:
    """Return twice the width of axes in pixels, for a high-resolution screen; at least 800."""
    return max(800, int(2.0 * ax.bbox.width))


def is_dense(ax: Axes, rows: int) -> bool:
    """Return whether there are several rows to a pixel, so that dashes would not show."""
    return rows > pixels_of(ax)


def numbers(name: str, values: npt.ArrayLike, length: int | None = None) -> FloatArray:
    """Return values (n,) as an array of real numbers; NaN is a gap. `length`: required n, or None."""
    try:
        array = np.asarray(values, dtype=np.float64)
    except (TypeError, ValueError):
        raise ValueError(f"{name}: must be an array of real numbers, got {described(values)}") from None
    if array.ndim != 1 or not array.size:
        raise ValueError(f"{name}: must have the shape (n,) with at least 1 entry, got {array.shape}")
    if length is not None and array.size != length:
        raise ValueError(f"{name}: must be as long as what it is drawn over ({length}), got {array.size}")
    return array


def table_of(log: Any) -> dict[str, Any]:
    """Return the columns of a Log or of a mapping such as a DataFrame by name, with `error` if it has a reference."""
    if hasattr(log, "keys") and "time" in log:
        table = {str(name): log[name] for name in log}
    elif hasattr(log, "time") and hasattr(log, "position"):
        table = {name: getattr(log, name, None) for name in ("time", *UNITS) if name != "error"}
        table = {name: values for name, values in table.items() if values is not None}
    else:
        raise TypeError(f"log: must be a Log, or columns by name with `time`, got {described(log)}")
    if "error" not in table and {"position", "reference"} <= set(table):
        table["error"] = column(table, "position") - column(table, "reference")
    return table


def column(table: Mapping[str, Any], name: str, argument: str = "columns") -> FloatArray:
    """Return a column of table_of."""
    if name not in table:
        known = [one for one in table if one != "time"]
        raise ValueError(f"{argument}: must be columns of the log, got {name!r}: {did_you_mean(name, known)}")
    return numbers(name, table[name], None if name == "time" else len(table["time"]))


def several(logs: Any) -> dict[str, Any]:
    """Return logs by name, of one log, a sequence of logs, or a mapping."""
    if isinstance(logs, Mapping) and "time" not in logs:
        found = {str(name): log for name, log in logs.items()}
    elif isinstance(logs, Sequence) and not isinstance(logs, str):
        found = {f"run {place}": log for place, log in enumerate(logs)}
    else:
        found = {"": logs}
    if not found:
        raise ValueError("log: must be at least one, got none")
    return found
