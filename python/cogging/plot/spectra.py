"""Amplitudes over spatial frequency, with the lines that were found in them."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np
import numpy.typing as npt

from cogging.calls import described
from cogging.plot.canvas import drawn, legend, one_of
from cogging.plot.rows import numbers
from cogging.plot.scales import Scale, scale_of, units_of
from cogging.plot.series import LIMIT, MEASURED

if TYPE_CHECKING:
    from matplotlib.axes import Axes

NAMED = 4  # lines whose period is written beside them


@drawn
def spectrum(
    spectrum: Any, amplitude: npt.ArrayLike | None = None, *, units: Any = None, unit: str = "m", ax: Any = None
) -> Axes:
    """Draw amplitudes over spatial frequency, on a logarithmic scale, with the lines that stand out.

    Of a TrackingSpectrum: the tracking error over 1/m, the noise, the periods that it proposes. Of a MapFit: the force
    over harmonics of the pitch, what a line has to reach to be found, the harmonics of the map.

    Args:
        spectrum: a TrackingSpectrum or a MapFit; or frequencies (1/m, (n,)) where `amplitude` is given.
        amplitude: (n,), in `unit`.
        units: labels of command and position (cogging.Units).
        unit: of `amplitude`, in the terms of this package: "m", "V".
        ax: axes; None: a new figure.

    Returns:
        The axes.

    Raises:
        ValueError: arrays of other shapes.
        TypeError: an argument is something else.

    Example:
        >>> ax = cogging.plot.spectrum(cogging.tracking_spectrum(log))
        >>> ax.get_xlabel(), ax.get_ylabel()
        ('spatial frequency (1/m)', 'tracking error (µm)')
    """
    units = units or units_of(spectrum)
    if amplitude is not None:
        x = numbers("spectrum", spectrum)
        y = numbers("amplitude", amplitude, x.size)
        axes, scale = one_of(ax), scale_of(unit, y, units=units)
        _draw(axes, x, scale(y), scale.label("amplitude"), scale_of("1/m", units=units).label("spatial frequency"))
        return axes
    if hasattr(spectrum, "period_amplitudes"):
        return _of_tracking(spectrum, units, one_of(ax))
    if hasattr(spectrum, "line_threshold"):
        return _of_map(spectrum, units, one_of(ax))
    raise TypeError(f"spectrum: must be a TrackingSpectrum, a MapFit or frequencies, got {described(spectrum)}")


def _of_tracking(found: Any, units: Any, ax: Axes) -> Axes:
    scale = scale_of("m", found.amplitude, units=units)
    _draw(
        ax,
        found.frequency,
        scale(found.amplitude),
        scale.label("tracking error"),
        scale_of("1/m", units=units).label("spatial frequency"),
    )
    if found.noise > 0.0:
        ax.axhline(float(scale(found.noise)), color=LIMIT, linestyle="--", label="noise")
    if found.periods:
        periods, sizes = np.array(found.periods), np.array(found.period_amplitudes)
        ax.plot(1.0 / periods, scale(sizes), "v", color="black", markersize=6, label="proposed periods")
        length = scale_of("m", periods, units=units)
        for period, size in list(zip(periods, sizes, strict=True))[:NAMED]:
            _name(ax, 1.0 / period, scale(size), f"{length(period):.4g} {length.unit}")
    legend(ax)
    return ax


def _of_map(fit: Any, units: Any, ax: Axes) -> Axes:
    scale: Scale = scale_of("V", fit.line_amplitude, units=units)
    _draw(ax, fit.line, scale(fit.line_amplitude), scale.label("force"), "harmonic of the pitch")
    ax.plot(fit.line, scale(fit.line_threshold), color=LIMIT, linestyle="--", label="found from here")
    known = [entry for entry in fit.amplitudes if fit.line.size]
    if known:
        at = [int(np.argmin(np.abs(fit.line - entry.harmonic))) for entry in known]
        sizes = scale(fit.line_amplitude[at])
        ax.plot([entry.harmonic for entry in known], sizes, "v", color="black", markersize=6, label="harmonics")
    largest = float(fit.line_amplitude.max())
    if largest > 0.0:
        lowest = max(0.03 * float(fit.line_threshold.min()), 1e-6 * largest)
        ax.set_ylim(float(scale(lowest)), float(scale(3.0 * largest)))
    legend(ax)
    return ax


def _draw(ax: Axes, x: Any, y: Any, label: str, along: str) -> None:
    ax.plot(x, y, color=MEASURED, linewidth=0.9, label="measured")
    if np.any(np.asarray(y) > 0.0):
        ax.set_yscale("log")
    ax.set(xlabel=along, ylabel=label)


def _name(ax: Axes, x: float, y: Any, text: str) -> None:
    ax.annotate(text, (x, float(y)), xytext=(4, 3), textcoords="offset points", fontsize="small")
