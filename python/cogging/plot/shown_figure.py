"""Figures and axes that show themselves in a notebook, without pyplot and without a magic line.

The one module here that imports matplotlib when it is imported: others import it when something is drawn.
"""

from __future__ import annotations

import io

from matplotlib.axes import Axes
from matplotlib.figure import Figure


def picture(figure: Figure) -> bytes:
    """The PNG of a figure, the same bytes of the same figure."""
    content = io.BytesIO()
    figure.savefig(content, format="png", dpi=figure.dpi, metadata={"Software": None})
    return content.getvalue()


class ShownFigure(Figure):
    """A figure that a notebook shows as the value of its cell, in any kernel."""

    def _repr_png_(self) -> bytes:
        return picture(self)


class ShownAxes(Axes):
    """Axes that a notebook shows, as the figure that they stand in."""

    def _repr_png_(self) -> bytes:
        return picture(self.figure.figure)
