"""Figures and axes that a notebook shows without pyplot.

This module imports matplotlib; the others import it only when something is plotted.
"""

from __future__ import annotations

import io

from matplotlib.axes import Axes
from matplotlib.figure import Figure


def picture(figure: Figure) -> bytes:
    """Return the PNG of a figure; the same figure gives the same bytes."""
    content = io.BytesIO()
    figure.savefig(content, format="png", dpi=figure.dpi, metadata={"Software": None})
    return content.getvalue()


class ShownFigure(Figure):
    """A figure that a notebook shows as the value of a cell."""

    def _repr_png_(self) -> bytes:
        return picture(self)


class ShownAxes(Axes):
    """Axes whose figure a notebook shows."""

    def _repr_png_(self) -> bytes:
        return picture(self.figure.figure)
