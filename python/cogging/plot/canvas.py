"""Axes and figures of plots, in the style of this package."""

from __future__ import annotations

import contextlib
import functools
import io
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
#: matplotlib's settings belong to the process: while ours are active, no other thread may save them as its own.
SETTINGS = threading.RLock()
#: Backends of matplotlib that write files, or show the value of a notebook's cell.
WINDOWLESS = {"agg", "cairo", "pdf", "pgf", "ps", "svg", "template", "inline", "widget", "ipympl"}


class Panels(tuple["Axes", ...]):
    """Axes of one figure, from the top left. A notebook shows the figure."""

    __slots__ = ()

    @property
    def figure(self) -> Figure:
        """The figure of the axes."""
        return self[0].figure.figure  # also of axes in a subfigure

    def _repr_png_(self) -> bytes:
        from cogging.plot.shown_figure import picture

        return picture(self.figure)


@contextlib.contextmanager
def styled() -> Iterator[None]:
    """Use the style of this package within a block."""
    import matplotlib.style

    with SETTINGS, matplotlib.style.context(STYLE):
        yield


def drawn(function: F) -> F:
    """Run a function in the style of this package, and raise TypeError for an unknown keyword (a decorator)."""

    @functools.wraps(function)
    def styled_call(*given: Any, **named: Any) -> Any:
        with styled():
            return function(*given, **named)

    return check_arguments()(styled_call)  # type: ignore[return-value]


def plot_method(draw: Callable[..., Any], doc: str, axes: str) -> Callable[..., Figure]:
    """Return the method `plot` of results; draw, doc: what it plots; axes: that `ax` gives, in words."""

    def plot(self: Any, *, units: Any = None, ax: Any = None) -> Figure:
        figure: Figure = draw(self, units=units, ax=ax).figure.figure
        return figure

    plot.__doc__ = f"""{doc} Return the figure.

        Args:
            units: labels of command and position (cogging.Units); None: those of the result.
            ax: {axes}; None: a new figure.
        """
    return plot


def new_figure(size: tuple[float, float] | None = None, *, window: bool = False) -> Figure:
    """Return an empty figure of a size (inches); with `window`, one that `plt.show()` of a script in a window shows."""
    from cogging.plot.shown_figure import ShownFigure

    pyplot = sys.modules.get("matplotlib.pyplot")
    if window and pyplot is not None and threading.current_thread() is threading.main_thread():
        backend = str(pyplot.get_backend()).lower()
        if backend not in WINDOWLESS and not backend.startswith("module://"):
            figure: Figure = pyplot.figure(figsize=size, layout="constrained", FigureClass=ShownFigure)
            return figure
    return ShownFigure(figsize=size, layout="constrained")


def titled_panels(
    title: str, size: tuple[float, float], rows: int = 1, columns: int = 1, **shared: Any
) -> tuple[Figure, Any]:
    """Return a figure of a size (inches) with a title, and its axes; shared: as of Figure.subplots."""
    figure = new_figure(size)
    figure.suptitle(title)
    return figure, figure.subplots(rows, columns, **shared)


def one_of(ax: Any, size: tuple[float, float] | None = None) -> Axes:
    """Return the given axes, or those of a new figure."""
    return grid_of(ax, 1, size=size)[0]


def grid_of(
    ax: Any,
    count: int,
    columns: int = 1,
    *,
    size: tuple[float, float] | None = None,
    sharex: bool = False,
    window: bool = True,
) -> Panels:
    """Return the given axes, `count` in any shape, or those of a new figure, in so many columns."""
    if ax is None:
        from cogging.plot.shown_figure import ShownAxes

        figure, keywords = new_figure(size, window=window), {"axes_class": ShownAxes}
        made: Any = figure.subplots(-(-count // columns), columns, squeeze=False, sharex=sharex, subplot_kw=keywords)
        for spare in made.flat[count:]:
            spare.remove()
        return Panels(made.flat[:count])
    from matplotlib.axes import Axes

    given = ax if isinstance(ax, Sequence | np.ndarray) else [ax]
    panels = Panels(np.ravel(np.array(given, dtype=object)).tolist())
    for one in panels:
        if not isinstance(one, Axes):
            raise TypeError(f"ax: must be axes of matplotlib, as plt.subplots() gives them, got {described(one)}")
    if len(panels) != count:
        raise ValueError(f"ax: must be {count} axes for as many panels, got {len(panels)}")
    return panels


def grid_to_write(rows: int, columns: int, size: tuple[float, float]) -> Panels:
    """Return axes of a figure for a file: in the style of this package, without a window."""
    with styled():
        return grid_of(None, rows * columns, columns, size=size, window=False)


def png(figure: Figure) -> bytes:
    """Return a figure as the content of a PNG file."""
    content = io.BytesIO()
    figure.savefig(content, format="png", dpi=120)
    return content.getvalue()


def legend(ax: Axes, columns: int = 4) -> None:
    """Add a legend above the data if there are several series."""
    handles, labels = ax.get_legend_handles_labels()
    if len(labels) > 1:
        place: dict[str, Any] = {"loc": "lower right", "bbox_to_anchor": (1.0, 1.0), "borderaxespad": 0.2}
        ax.legend(handles, labels, ncols=min(columns, len(labels)), **place)
