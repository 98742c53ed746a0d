"""Logs over time: any of their columns, and the tracking errors of several."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

import numpy as np
import numpy.typing as npt

from cogging.plot.canvas import Panels, drawn, grid_of, legend, one_of
from cogging.plot.rows import UNITS, column, names_of, numbers, require_table, several
from cogging.plot.scales import scale_of, units_of
from cogging.plot.series import look, named
from cogging.plot.traces import draw_trace, is_dense

if TYPE_CHECKING:
    from matplotlib.axes import Axes

WIDTH, PANEL = 7.2, 1.9  # inches


@drawn
def log(log: Any, columns: str | Sequence[str] | None = None, *, units: Any = None, ax: Any = None) -> Panels:
    """Draw columns of a log over time, one panel each: position with its reference, tracking error, command.

    Rows that the log lacks are gaps. Of a long log each pixel shows its least and largest value, so that no peak is
    lost.

    Args:
        log: a Log, or columns by name with `time` (a mapping of arrays, a DataFrame).
        columns: names of one or more columns, `error` among them; None: what there is of position, error and command.
        units: labels of command and position (cogging.Units); None: those of the model that the log carries.
        ax: as many axes as columns, in any shape; None: a new figure.

    Returns:
        The axes, one a column.

    Raises:
        ValueError: no such column, or another number of axes.
        TypeError: `log`, `units` or `ax` are something else.

    Example:
        >>> position, error, command = cogging.plot.log(log)
        >>> error.get_ylabel()
        'error (µm)'
    """
    require_table(log)
    chosen = [columns] if isinstance(columns, str) else list(columns or _usual(log))
    found = {name: column(log, name) for name in chosen}
    panels = grid_of(ax, len(chosen), 1, size=(WIDTH, 0.7 + PANEL * len(chosen)), sharex=True)
    units = units or units_of(log)
    time = column(log, "time")
    over = scale_of("s", time)
    for panel, (name, values) in zip(panels, found.items(), strict=True):
        beside = column(log, "reference") if name == "position" and "reference" in names_of(log) else None
        scale = scale_of(UNITS.get(name, "1"), values, beside, units=units)
        dense = is_dense(panel, len(time))
        draw_trace(panel, over(time), scale(values), label=named(name), **look(0, dense))
        if beside is not None:
            draw_trace(panel, over(time), scale(beside), label="reference", **look(1, dense=False))
            legend(panel)
        panel.set_ylabel(scale.label(named(name.replace("_", " "))))
    panels[-1].set_xlabel(over.label("time"))
    return panels


def _usual(log: Any) -> list[str]:
    known = names_of(log)
    return [name for name in ("position", "error", "command") if name in known] or known


@drawn
def error(log: Any, error: npt.ArrayLike | None = None, *, units: Any = None, ax: Any = None) -> Axes:
    """Draw the tracking error, encoder reading minus reference, of one or several logs over time.

    Args:
        log: a Log; several, as a list or by the names that the legend shows; or times (s, (n,)) where `error` is given.
        error: m, (n,).
        units: labels of command and position (cogging.Units); None: those of the model that a log carries.
        ax: axes; None: a new figure.

    Returns:
        The axes.

    Raises:
        ValueError: a log has no reference, arrays are of other shapes.
        TypeError: an argument is something else.

    Example:
        >>> ax = cogging.plot.error({"first": log, "again": log})
        >>> [line.get_label() for line in ax.lines]
        ['first', 'again']
    """
    if error is None:
        logs = several(log)
    else:
        time = numbers("log", log)
        logs = {"": {"time": time, "error": numbers("error", error, time.size)}}
    errors = {name: column(one, "error", "log") for name, one in logs.items()}
    times = {name: column(one, "time") for name, one in logs.items()}
    axes = one_of(ax)
    units = units or units_of(*logs.values())
    scale, over = scale_of("m", *errors.values(), units=units), scale_of("s", *times.values())
    size = {name: float(np.nanmax(np.abs(values), initial=0.0)) for name, values in errors.items()}
    for place, (name, values) in enumerate(errors.items()):
        # Smaller errors are drawn over larger ones, which would hide them.
        order = 2.0 + sum(other > size[name] for other in size.values()) / (1.0 + len(size))
        style = look(place, is_dense(axes, values.size))
        draw_trace(axes, over(times[name]), scale(values), label=named(name) or None, zorder=order, **style)
    axes.set(xlabel=over.label("time"), ylabel=scale.label("tracking error"))
    legend(axes)
    return axes
