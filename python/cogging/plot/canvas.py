"""Where a picture is drawn: on axes that are given, or on a new figure; the package's style, used as a context."""

from __future__ import annotations

import contextlib
import functools
import sys
import threading
from collections.abc import Callable, Iterator, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any, TypeVar

import numpy as np

from cogging.calls import check_arguments, described

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

F = TypeVar("F", bound=Callable[..., Any])
STYLE = Path(__file__).with_name("cogging.mplstyle")
#: The settings of matplotlib belong to the process: while they are ours, no other thread may save them as its own.
SETTINGS = threading.RLock()
#: Backends of matplotlib that write files, or that show what a notebook's cell gives back.
WINDOWLESS = {"agg", "cairo", "pdf", "pgf", "ps", "svg", "template", "inline", "widget", "ipympl"}


class Panels(tuple["Axes", ...]):
    """Axes of one figure, from the top left on. A notebook shows the figure."""

    __slots__ = ()

    @property
    def figure(self) -> Figure:
        """The figure that they stand in."""
        return figure_of(self[0])

    def _repr_png_(self) -> bytes:
        from cogging.plot.shown_figure import picture

        return picture(self.figure)


@contextlib.contextmanager
def styled() -> Iterator[None]:
    """The style of this package for a while; then the settings of matplotlib are again what they were."""
    import matplotlib.style

    with SETTINGS, matplotlib.style.context(STYLE):
        yield


def drawn(function: F) -> F:
    """Draw in the style of this package, and refuse a mistyped keyword in one line (a decorator)."""

    @functools.wraps(function)
    def asked(*given: Any, **named: Any) -> Any:
        with styled():
            return function(*given, **named)

    return check_arguments()(asked)  # type: ignore[return-value]


def new_figure(size: tuple[float, float] | None = None, *, window: bool = False) -> Figure:
    """An empty figure of a size (inches), which pyplot does not know.

    It is freed when nobody holds it any more. With `window`, where a script has pyplot and a window, it is pyplot's, so
    that `plt.show()` shows it; not in notebooks, servers, or other threads than the main one.
    """
    from cogging.plot.shown_figure import ShownFigure

    pyplot = sys.modules.get("matplotlib.pyplot")
    if window and pyplot is not None and threading.current_thread() is threading.main_thread() and _has_windows(pyplot):
        figure: Figure = pyplot.figure(figsize=size, layout="constrained", FigureClass=ShownFigure)
        return figure
    return ShownFigure(figsize=size, layout="constrained")


def _has_windows(pyplot: Any) -> bool:
    backend = str(pyplot.get_backend()).lower()
    return backend not in WINDOWLESS and not backend.startswith("module://")


def one_of(ax: Any, size: tuple[float, float] | None = None) -> Axes:
    """The axes that are given, or those of a new figure."""
    if ax is None:
        return grid_of(None, 1, 1, size=size)[0]
    from matplotlib.axes import Axes

    if isinstance(ax, list | tuple | np.ndarray) and np.size(np.array(ax, dtype=object)) == 1:
        (ax,) = np.ravel(np.array(ax, dtype=object))
    if not isinstance(ax, Axes):
        raise TypeError(f"ax: must be axes of matplotlib, as plt.subplots() gives them, got {described(ax)}")
    return ax


def grid_of(
    ax: Any,
    rows: int,
    columns: int,
    size: tuple[float, float] | None = None,
    sharex: bool = False,
    window: bool = True,
) -> Panels:
    """The axes that are given, rows times columns of them in any shape, or those of a new figure."""
    if ax is None:
        from cogging.plot.shown_figure import ShownAxes

        keywords: dict[str, Any] = {"axes_class": ShownAxes}
        figure = new_figure(size, window=window)
        return Panels(
            np.ravel(figure.subplots(rows, columns, squeeze=False, sharex=sharex, subplot_kw=keywords)).tolist()
        )
    given = ax if isinstance(ax, Sequence | np.ndarray) else [ax]
    panels = Panels(one_of(one) for one in np.ravel(np.array(given, dtype=object)).tolist())
    if len(panels) != rows * columns:
        raise ValueError(f"ax: must be {rows * columns} axes for as many panels, got {len(panels)}")
    return panels


def grid_to_write(rows: int, columns: int, size: tuple[float, float]) -> Panels:
    """Axes of a figure that is written to a file: in the style of this package, and in no window."""
    with styled():
        return grid_of(None, rows, columns, size=size, window=False)


def figure_of(ax: Axes) -> Figure:
    """The figure that axes stand in, also where that is a part of another."""
    return ax.figure.figure


def legend(ax: Axes, columns: int = 4) -> None:
    """A legend above the data, left out where there is one series alone."""
    handles, labels = ax.get_legend_handles_labels()
    if len(labels) > 1:
        place: dict[str, Any] = {"loc": "lower right", "bbox_to_anchor": (1.0, 1.0), "borderaxespad": 0.2}
        ax.legend(handles, labels, ncols=min(columns, len(labels)), **place)
