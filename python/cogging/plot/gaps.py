"""What a model leaves unexplained, against position, speed, time and command: means in bins with 95 % bands."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np
import numpy.typing as npt

from cogging.arrays import FloatArray, IntArray
from cogging.calls import described, did_you_mean
from cogging.plot.canvas import Panels, drawn, grid_of, legend
from cogging.plot.rows import numbers
from cogging.plot.scales import scale_of, units_of
from cogging.plot.series import look, marker

if TYPE_CHECKING:
    from matplotlib.axes import Axes

SIGMAS_95 = 1.959963984540054  # deviations of a normal variable, of a two-sided interval of 95 %
COORDINATES = {"position": "m", "velocity": "m/s", "time": "s", "command": "V", "acceleration": "m/s^2"}
USUAL = ("position", "velocity", "time", "command")
BINS = 40
FEWEST = 20  # rows of a bin: the mean of fewer is noise
BLOCK = 0.25  # s: closer rows say much the same, and count as one
BLOCKS = 100  # of rows whose time is not known


class Rows(NamedTuple):
    """Rows of one residual: V, coordinates by name, and the block that each row belongs to, each (n,)."""

    residual: FloatArray
    coordinates: Mapping[str, FloatArray]
    block: IntArray


@drawn
def residual(
    found: Any,
    residual: npt.ArrayLike | None = None,
    against: str | Sequence[str] | None = None,
    *,
    units: Any = None,
    ax: Any = None,
) -> Panels:
    """Draw what a model leaves unexplained against coordinates: its mean in bins, with 95 % bands.

    The band is that of the mean of rows in blocks of a quarter of a second, which count as one observation each. Of a
    Diagnosis the residual is drawn as re-tuned and with what was found.

    Args:
        found: a Diagnosis, a Location, or coordinates by name (arrays, (n,); `time` makes the blocks); or one
            coordinate (n,) where `against` names it.
        residual: V, (n,), of coordinates.
        against: one or more of position, velocity, time, command, acceleration; None: what there is of the first four.
        units: labels of command and position (cogging.Units); None: those of the model.
        ax: as many axes as coordinates; None: a new figure.

    Returns:
        The axes, one a coordinate.

    Raises:
        ValueError: no such coordinate, nothing was measured, arrays or axes of another number.
        TypeError: an argument is something else.

    Example:
        >>> speed, = cogging.plot.residual(log.reference_velocity, 0.01 * log.command, "velocity")
        >>> speed.get_xlabel(), speed.get_ylabel()
        ('velocity (m/s)', 'mean residual (mV)')
    """
    rows = _of_arrays(found, residual, against) if residual is not None else _of_result(found)
    known = [name for name in COORDINATES if all(name in one.coordinates for one in rows.values())]
    known += [name for name in next(iter(rows.values())).coordinates if name not in known]
    chosen = [against] if isinstance(against, str) else list(against or [name for name in known if name in USUAL])
    for name in chosen:
        if name not in known:
            raise ValueError(f"against: must be coordinates, got {name!r}: {did_you_mean(name, known)}")
    units = units or units_of(found)
    wide = min(2, len(chosen))
    panels = (
        grid_of(ax, -(-len(chosen) // wide), wide, size=(7.2, 0.6 + 2.3 * -(-len(chosen) // wide)))
        if (ax is None)
        else grid_of(ax, len(chosen), 1)
    )
    for spare in panels[len(chosen) :]:
        spare.remove()
    panels = Panels(panels[: len(chosen)])
    means = {name: {label: binned(one, name) for label, one in rows.items()} for name in chosen}
    up = scale_of("V", *(part for each in means.values() for one in each.values() for part in one[1:2]), units=units)
    for panel, name in zip(panels, chosen, strict=True):
        along = scale_of(COORDINATES.get(name, "1"), *(one[0] for one in means[name].values()), units=units)
        _draw(panel, means[name], along, up)
        panel.set(xlabel=along.label(name), ylabel=up.label("mean residual"))
    legend(panels[0])
    return panels


def _draw(panel: Axes, means: Mapping[str, tuple[FloatArray, FloatArray, FloatArray]], along: Any, up: Any) -> None:
    panel.axhline(0.0, color="black", linewidth=0.6)
    for place, (label, (x, mean, half)) in enumerate(means.items()):
        style = look(place)
        low, high = up(mean - half), up(mean + half)
        panel.fill_between(along(x), low, high, color=style["color"], alpha=0.25, linewidth=0)
        panel.plot(along(x), up(mean), label=label, marker=marker(place), markersize=2.0, **style)
    if not any(x.size for x, _, _ in means.values()):
        panel.text(0.5, 0.5, "too few rows", transform=panel.transAxes, ha="center")


def binned(rows: Rows, name: str) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Places, means and half widths of 95 % intervals in bins of equal width; rows of a block count as one.

    Args:
        rows: of one residual.
        name: of the coordinate.

    Returns:
        Arrays (bins,), nan in bins of few rows; a half width is nan too where one block alone stands in a bin.
    """
    x = rows.coordinates[name]
    finite = np.isfinite(x) & np.isfinite(rows.residual)
    x, y, block = x[finite], rows.residual[finite], rows.block[finite]
    if x.size < FEWEST:
        return np.empty(0), np.empty(0), np.empty(0)
    low, span = float(x.min()), float(np.ptp(x)) or 1.0
    place = np.minimum(((x - low) / span * BINS).astype(int), BINS - 1)
    cells, cell = np.unique(np.stack([place, block]), axis=1, return_inverse=True)
    count = np.bincount(cell.ravel())
    total = np.bincount(place, minlength=BINS).astype(float)
    kept = total >= FEWEST
    size = np.maximum(total, 1.0)
    mean = np.bincount(place, y, BINS) / size
    sums = np.bincount(cell.ravel(), y) - mean[cells[0]] * count
    seen = np.bincount(cells[0], minlength=BINS)
    spread = np.bincount(cells[0], sums**2, BINS) / size**2
    with np.errstate(divide="ignore", invalid="ignore"):
        half = SIGMAS_95 * np.sqrt(np.where(seen > 1, spread * seen / (seen - 1.0), np.nan))
    middle = np.bincount(place, x, BINS) / size
    return tuple(np.where(kept, values, np.nan) for values in (middle, mean, half))  # type: ignore[return-value]


def _of_arrays(found: Any, residual: npt.ArrayLike, against: Any) -> dict[str, Rows]:
    values = numbers("residual", residual)
    if hasattr(found, "keys"):
        coordinates = {str(name): numbers(str(name), found[name], values.size) for name in found}
    elif isinstance(against, str):
        coordinates = {against: numbers(against, found, values.size)}
    else:
        raise ValueError("against: must name the coordinate of an array, got none or several")
    if "time" in coordinates:
        block = np.floor((coordinates["time"] - coordinates["time"][0]) / BLOCK).astype(int)
    else:
        block = np.arange(values.size) * BLOCKS // values.size
    return {"residual": Rows(values, coordinates, block)}


def _of_result(found: Any) -> dict[str, Rows]:
    """Residuals of a Diagnosis or a Location, by their labels."""
    series = getattr(found, "series", None)
    if not isinstance(series, Mapping):
        raise TypeError(
            f"found: must be a Diagnosis, a Location or coordinates with a residual, got {described(found)}"
        )
    gaps = {"gap_before": "as re-tuned", "gap_after": "with what was found", "gap": "as re-tuned"}
    if not any(name in series for name in gaps):
        raise ValueError(f"plot: needs a gap that was measured, got the verdict {getattr(found, 'verdict', 'none')}")
    same = "gap_after" in series and not getattr(found, "effects", ()) and not getattr(found, "unlisted", None)
    names = [name for name in gaps if name in series and not (same and name == "gap_after")]
    return {gaps[name]: joined(series, name) for name in names}


def joined(series: Mapping[str, Any], name: str) -> Rows:
    """Rows in motion of all logs, one after the other.

    Args:
        series: of a Diagnosis or a Location.
        name: of the residual in it.
    """
    blocks, offset = [], 0
    kept = [np.asarray(mask) > 0 for mask in series["mask"]]
    for time, rows in zip(series["time"], kept, strict=True):
        block = np.floor((np.asarray(time) - time[0]) / BLOCK).astype(int) + offset
        offset = int(block[-1]) + 1
        blocks.append(block[rows])

    def whole(column: str) -> FloatArray:
        parts = [np.asarray(one, dtype=np.float64)[rows] for one, rows in zip(series[column], kept, strict=True)]
        return np.concatenate(parts)

    return Rows(whole(name), {one: whole(one) for one in COORDINATES if one in series}, np.concatenate(blocks))
