"""Fitted parameters with their 95 % intervals, beside what they were before."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from cogging.calls import described
from cogging.plot.canvas import drawn, legend, one_of
from cogging.plot.scales import labelled, pretty
from cogging.plot.series import COLOURS, FITTED, LIMIT, named

if TYPE_CHECKING:
    from matplotlib.axes import Axes


@drawn
def intervals(fit: Any, *, units: Any = None, ax: Any = None) -> Axes:
    """Draw the parameters of a fit with their 95 % intervals and what the model had before, in per cent of each.

    Args:
        fit: an Identification.
        units: labels of command and position (cogging.Units); None: those of the model.
        ax: axes; None: a new figure.

    Returns:
        The axes: one row a parameter, from the top down; 0 is the fitted value. Per cent are of the largest of value,
        prior and half interval.

    Raises:
        TypeError: an argument is something else.

    Example:
        >>> ax = cogging.plot.intervals(cogging.identify(log, model, free=["axis.mass", "axis.viscous"]))
        >>> len(ax.get_yticks())
        2
    """
    entries = getattr(fit, "parameters", None)
    if not isinstance(entries, tuple) or not entries or not all(hasattr(one, "ci95") for one in entries):
        raise TypeError(f"fit: must be an Identification, got {described(fit)}")
    axes = one_of(ax, size=(7.2, 1.0 + 0.34 * len(entries)))
    labels, widest = [], 1e-3
    for row, one in enumerate(entries):
        low, high = one.ci95
        known = bool(np.isfinite([low, high]).all())
        size = max(abs(one.value), abs(one.prior), 0.5 * (high - low) if known else 0.0) or 1.0
        labels.append(_label(one, units))
        if known:
            ends = 100.0 * np.array([low - one.value, high - one.value]) / size
            widest = max(widest, float(np.abs(ends).max()))
            axes.plot(
                ends, [row, row], color=COLOURS[0], linewidth=3.0, solid_capstyle="butt", label=_once(axes, "95 %")
            )
        axes.plot([0.0], [row], "o", color=FITTED, markersize=5, label=_once(axes, "fitted"))
        before = 100.0 * (one.prior - one.value) / size
        widest = max(widest, min(abs(before), 100.0))
        axes.plot([before], [row], "D", color=LIMIT, markersize=5, markerfacecolor="none", label=_once(axes, "before"))
    axes.set_yticks(range(len(labels)), labels)
    axes.set_ylim(len(labels) - 0.4, -0.6)
    axes.set_xlim(-1.15 * widest, 1.15 * widest)
    axes.set_xlabel("beside the fitted value (%)")
    legend(axes)
    return axes


def _once(ax: Axes, label: str) -> str | None:
    return None if label in ax.get_legend_handles_labels()[1] else label


def _label(one: Any, units: Any) -> str:
    unit = "" if one.unit == "1" else f" {pretty(labelled(one.unit, units))}"
    path = named(one.path.removeprefix("axis.").removeprefix("effects."))
    return f"{path}: {one.value:.4g}{unit}" + ("" if one.determined else " (not determined)")
