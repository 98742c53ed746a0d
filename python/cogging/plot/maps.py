"""Maps of the cogging force over position, with 95 % bands where they have them, and what they were fitted to."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np
import numpy.typing as npt

from cogging._core import CoggingModel
from cogging.arrays import FloatArray
from cogging.calls import described
from cogging.plot.canvas import drawn, legend, one_of
from cogging.plot.rows import numbers
from cogging.plot.scales import scale_of, units_of
from cogging.plot.series import FITTED, GREY, look

if TYPE_CHECKING:
    from matplotlib.axes import Axes

SIGMAS_95 = 1.959963984540054  # deviations of a normal variable, of a two-sided interval of 95 %
POINTS_PER_WAVE = 24  # of the shortest period that is drawn
FEWEST, MOST = 401, 20_001
SHARES = ((1.0, "forward"), (-1.0, "backward"))


@drawn
def cogging_map(
    cogging: Any,
    force: npt.ArrayLike | None = None,
    *,
    deviation: npt.ArrayLike | None = None,
    position: npt.ArrayLike | None = None,
    units: Any = None,
    ax: Any = None,
) -> Axes:
    """Draw a cogging force over position, with its 95 % band where its deviations are known.

    Of a MapFit the band comes from the standard errors of its amplitudes and from how the points of the scan join
    them; of a Model from the intervals in its `[bounds]`, taken as independent. Of a MapFit the points of the scan are
    drawn too, less offset, trend and friction.

    Args:
        cogging: a MapFit, a Model or a CoggingModel; or positions (m, (n,)) where `force` is given.
        force: V, (n,).
        deviation: standard deviation of `force`, V, (n,), for its band.
        position: places at which a map is drawn, m, (n,); None: those of the scan, of the travel, or three pitches.
        units: labels of command and position (cogging.Units); None: those of the model.
        ax: axes; None: a new figure.

    Returns:
        The axes.

    Raises:
        ValueError: a model without cogging, arrays of other shapes.
        TypeError: an argument is something else.

    Example:
        >>> ax = cogging.plot.cogging_map(model)
        >>> ax.get_xlabel(), ax.get_ylabel()
        ('position (mm)', 'cogging force (V)')
    """
    if force is not None:
        x = numbers("cogging", cogging)
        y = numbers("force", force, x.size)
        half = None if deviation is None else SIGMAS_95 * numbers("deviation", deviation, x.size)
        points = None
    else:
        known = model_of(cogging)
        x = _places(cogging, known) if position is None else numbers("position", position)
        y, half = np.asarray(known.force(x), dtype=np.float64), _half_band(cogging, known, x)
        points = _points(cogging, known)
    units = units or units_of(cogging)
    axes = one_of(ax)
    along = scale_of("m", x, units=units)
    up = scale_of("V", y, None if points is None else points[1], units=units)
    for place, (way, name) in enumerate(SHARES if points is not None else ()):
        assert points is not None
        kept = points[2] == way
        if kept.any():
            dots = {**look(place), "linestyle": "none", "marker": "os"[place], "markersize": 2.5, "alpha": 0.6}
            axes.plot(along(points[0][kept]), up(points[1][kept]), label=f"measured, {name}", **dots)
    if half is not None:
        # Over the points, which would hide it, and under the map.
        band: dict[str, Any] = {"color": GREY, "alpha": 0.6, "linewidth": 0, "zorder": 2.2}
        axes.fill_between(along(x), up(y - half), up(y + half), label="95 %", **band)
    axes.plot(along(x), up(y), color=FITTED, label="map", linewidth=1.0, zorder=2.3)
    axes.set(xlabel=along.label("position"), ylabel=up.label("cogging force"))
    legend(axes)
    return axes


def model_of(thing: Any) -> CoggingModel:
    """The cogging model that a thing is or has."""
    found = thing if isinstance(thing, CoggingModel) else getattr(thing, "cogging", thing)
    if found is None:
        raise ValueError("cogging: must be in the model to be drawn, got a model without [cogging]")
    if not isinstance(found, CoggingModel):
        raise TypeError(f"cogging: must be a MapFit, a Model or a CoggingModel, got {described(thing)}")
    return found


def _places(thing: Any, cogging: CoggingModel) -> FloatArray:
    basis = cogging.basis
    periods = [2.0 * np.pi / wave for wave in basis.wavenumbers]
    low, high = _range(thing, cogging)
    points = int(np.clip(POINTS_PER_WAVE * (high - low) / min(periods), FEWEST, MOST))
    return np.linspace(low, high, points)


def _range(thing: Any, cogging: CoggingModel) -> tuple[float, float]:
    scan = getattr(thing, "position", None)
    if scan is not None:
        return float(np.min(scan)), float(np.max(scan))
    travel = getattr(getattr(thing, "axis", None), "travel", None)
    if travel is not None and np.all(np.isfinite(travel)) and travel[1] > travel[0]:
        return float(travel[0]), float(travel[1])
    basis = cogging.basis
    if basis.spline.control_points > 1:
        return float(basis.spline.origin), float(basis.spline.end)
    longest = basis.pitch if basis.pitch > 0.0 else max(2.0 * np.pi / wave for wave in basis.wavenumbers)
    return 0.0, 3.0 * longest


def _half_band(thing: Any, cogging: CoggingModel, x: FloatArray) -> FloatArray | None:
    """Half width of the 95 % band, V, from deviations of the amplitudes and from how the points of a scan join them."""
    tables = [getattr(thing, f"{part}_standard_error", None) for part in ("sine", "cosine")]
    if tables[0] is None:
        tables = [_of_intervals(getattr(thing, "intervals", None), part, cogging) for part in ("sine", "cosine")]
    if any(table is None for table in tables) or not np.any(tables[0]):
        return None
    deviation = np.stack([np.asarray(table) for table in tables], axis=-1).transpose(1, 0, 2).ravel()
    rows = np.asarray(cogging.basis.regressor(x)) * deviation
    scan = getattr(thing, "position", None)
    together = np.eye(deviation.size) if scan is None else _correlation(np.asarray(cogging.basis.regressor(scan)))
    variance = np.maximum(np.sum((rows @ together) * rows, axis=1), 0.0)
    return np.asarray(SIGMAS_95 * np.sqrt(variance))


def _correlation(design: FloatArray) -> FloatArray:
    """Correlation of least-squares amplitudes of points with white noise; none of those that no point determines."""
    gram = design.T @ design
    ridge = 1e-6 * float(np.max(np.diag(gram))) * np.eye(len(gram))
    covariance = np.linalg.inv(gram + ridge)
    size = np.sqrt(np.diag(covariance))
    return np.asarray(covariance / np.outer(size, size))


def _of_intervals(intervals: Any, part: str, cogging: CoggingModel) -> FloatArray | None:
    """Deviations of amplitudes from the model's 95 % intervals; None where any has none."""
    found = np.zeros_like(cogging.sine)
    for row, point in np.ndindex(*found.shape):
        low, high = (intervals or {}).get(f"cogging.{part}[{row}][{point}]", (np.nan, np.nan))
        found[row, point] = 0.5 * (high - low) / SIGMAS_95
    return found if np.isfinite(found).all() else None


def _points(thing: Any, cogging: CoggingModel) -> tuple[FloatArray, FloatArray, FloatArray] | None:
    """Position, force less offset, trend and friction, and direction of a scan's points."""
    if not hasattr(thing, "fitted"):
        return None
    left = thing.force - thing.fitted
    return thing.position, left + np.asarray(cogging.force(thing.position)), thing.direction
