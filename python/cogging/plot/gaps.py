"""The gap between a model and logs: residuals against coordinates, and how the gap is composed."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np
import numpy.typing as npt

from cogging.arrays import SIGMAS_95, FloatArray, IntArray
from cogging.calls import described, did_you_mean
from cogging.plot.canvas import Panels, drawn, grid_of, legend, one_of
from cogging.plot.scales import scale_of, units_of
from cogging.plot.series import FITTED, GREY, LIMIT, MEASURED, look, marker, named
from cogging.plot.traces import numbers

if TYPE_CHECKING:
    from matplotlib.axes import Axes

COORDINATES = {"position": "m", "velocity": "m/s", "time": "s", "command": "V", "acceleration": "m/s^2"}
#: Labels of the residuals of a Diagnosis or a Location.
GAPS = {"gap_before": "before: re-tuned", "gap_after": "after: patched", "gap": "re-tuned"}
USUAL = ("position", "velocity", "time", "command")
BINS = 40
FEWEST = 20  # rows of a bin; the mean of fewer is noise
BLOCK = 0.25  # s; closer rows are correlated and count as one observation
BLOCKS = 100  # of rows without time
SMALL = 0.005  # of the whole: a smaller part is not plotted
#: Colour and hatching of a bar by its kind.
KINDS = {"retuned": (GREY, "//"), "effect": (MEASURED, ""), "rest": (LIMIT, "xx"), "floor": ("#e8e8e8", "..")}


class Rows(NamedTuple):
    """Rows of one residual (V), coordinates by name, and the block of each row, each (n,)."""

    residual: FloatArray
    coordinates: Mapping[str, FloatArray]
    block: IntArray


@drawn
def residual(
    found: Any,
    residual: npt.ArrayLike | None = None,
    against: str | Sequence[str] | None = None,
    *,
    period: float | None = None,
    units: Any = None,
    ax: Any = None,
) -> Panels:
    """Plot the residual of a model against coordinates: its mean in bins, with 95 % bands.

    Rows within a quarter of a second count as one observation of the mean. For a Diagnosis the residual is plotted with
    re-tuned parameters, and with the effects found.

    Args:
        found: a Diagnosis, a Location, or coordinates by name (arrays, (n,); `time` makes the blocks); or one
            coordinate (n,) where `against` names it.
        residual: V, (n,), of coordinates.
        against: one or more of position, velocity, time, command, acceleration; None: the first four as available.
        period: m; the position is plotted modulo this period.
        units, ax: see cogging.plot; as many axes as coordinates.

    Raises:
        ValueError: an unknown coordinate, no measured gap, or arrays or axes of another number.

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
    size = (7.2, 0.6 + 2.3 * -(-len(chosen) // wide))
    panels = grid_of(ax, len(chosen), wide, size=size)
    if period is not None:
        if not period > 0.0:
            raise ValueError(f"period: must be positive, got {period:g}")
        if "position" not in known:
            raise ValueError("period: needs the coordinate position, got none")
        for label, one in rows.items():
            folded = {**one.coordinates, "position": one.coordinates["position"] % period}
            rows[label] = one._replace(coordinates=folded)
    means = {name: {label: binned(one, name) for label, one in rows.items()} for name in chosen}
    up = scale_of("V", *(part for each in means.values() for one in each.values() for part in one[1:2]), units=units)
    for panel, name in zip(panels, chosen, strict=True):
        along = scale_of(COORDINATES.get(name, "1"), *(one[0] for one in means[name].values()), units=units)
        panel.axhline(0.0, color="black", linewidth=0.6)
        for place, (label, (x, mean, half)) in enumerate(means[name].items()):
            style = look(place)
            low, high = up(mean - half), up(mean + half)
            panel.fill_between(along(x), low, high, color=style["color"], alpha=0.25, linewidth=0)
            panel.plot(along(x), up(mean), label=label, marker=marker(place), markersize=2.0, **style)
        if not any(x.size for x, _, _ in means[name].values()):
            panel.text(0.5, 0.5, "too few rows", transform=panel.transAxes, ha="center")
        shown = f"{name} modulo the period" if period is not None and name == "position" else name
        panel.set(xlabel=along.label(shown), ylabel=up.label("mean residual"))
    legend(panels[0])
    return panels


def binned(rows: Rows, name: str) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Return places, means and half widths of 95 % intervals in bins of a coordinate, NaN in bins of too few rows."""
    x = rows.coordinates[name]
    finite = np.isfinite(x) & np.isfinite(rows.residual)
    x, y, block = x[finite], rows.residual[finite], rows.block[finite]
    if x.size < FEWEST:
        return np.empty(0), np.empty(0), np.empty(0)
    place = np.minimum(((x - x.min()) / (float(np.ptp(x)) or 1.0) * BINS).astype(int), BINS - 1)
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
    """Return the residuals of a Diagnosis or a Location by label, in the rows in motion of all logs."""
    series = getattr(found, "series", None)
    if not isinstance(series, Mapping):
        raise TypeError(
            f"found: must be a Diagnosis, a Location or coordinates with a residual, got {described(found)}"
        )
    names = [name for name in GAPS if name in series]
    if not names:
        raise ValueError(f"plot: needs a gap that was measured, got the verdict {getattr(found, 'verdict', 'none')}")
    if "gap_after" in names and not getattr(found, "effects", ()) and not getattr(found, "unlisted", None):
        names.remove("gap_after")  # the same
    kept = [np.asarray(mask) > 0 for mask in series["mask"]]
    blocks, offset = [], 0
    for time, rows in zip(series["time"], kept, strict=True):
        block = np.floor((np.asarray(time) - time[0]) / BLOCK).astype(int) + offset
        offset = int(block[-1]) + 1
        blocks.append(block[rows])
    columns = {
        one: np.concatenate([np.asarray(x, dtype=np.float64)[rows] for x, rows in zip(series[one], kept, strict=True)])
        for one in (*names, *COORDINATES)
        if one in series
    }
    coordinates = {name: values for name, values in columns.items() if name in COORDINATES}
    return {GAPS[name]: Rows(columns[name], coordinates, np.concatenate(blocks)) for name in names}


def shares(diagnosis: Any) -> list[tuple[str, str, float]]:
    """Return name, kind and share of each part of a diagnosis' gap, in power, which add up to 1.

    The whole is the larger gap of the given and the re-tuned model. Kinds: see KINDS; a negative share enlarged it.
    """
    gap, steps = getattr(diagnosis, "gap", None), getattr(diagnosis, "ledger", None)
    if gap is None or steps is None:
        raise TypeError(f"diagnosis: must be a Diagnosis, got {described(diagnosis)}")
    if not gap.before > 0.0 or not np.isfinite(gap.before):
        raise ValueError(f"plot: needs a gap that was measured, got the verdict {diagnosis.verdict}")
    given = gap.given if gap.given is not None and gap.given > gap.before else gap.before
    whole = given**2
    parts = [("re-tuning", "retuned", (given**2 - gap.before**2) / whole)] * bool(given > gap.before)
    left = gap.before**2
    for step in steps:
        if step.accepted and step.gap_before is not None and step.gap_after is not None:
            taken = step.gap_before**2 - step.gap_after**2
            parts.append((step.name.replace("_", " "), "effect", taken / whole))
            left -= taken
    together = left - gap.after**2  # by the final fit of all parameters
    if abs(together) > SMALL * whole:
        parts.append(("fitted together", "retuned", together / whole))
    floor = min(gap.floor, gap.after) ** 2
    rest = 1.0 - sum(share for *_, share in parts) - floor / whole
    parts.append(("not explained", "rest", rest))
    return [*parts, ("noise and quantiser", "floor", floor / whole)]


@drawn
def ledger(diagnosis: Any, *, ax: Any = None) -> Axes:
    """Plot the composition of a diagnosis' gap: a bar for each effect and for the rest, in shares of its power.

    Bars from the top are in the order in which they were found.

    Args:
        diagnosis: a Diagnosis.
        ax: see cogging.plot.

    Raises:
        ValueError: no gap was measured.

    Example:
        >>> lean = model.replace(effects=[], intervals={})
        >>> ax = cogging.plot.ledger(cogging.diagnose(log, lean))
        >>> ax.get_xlabel()
        "share of the gap's power (%)"
    """
    parts = shares(diagnosis)
    axes = one_of(ax, size=(7.2, 0.9 + 0.36 * len(parts)))
    place = np.arange(len(parts))
    percent = 100.0 * np.array([share for _, _, share in parts])
    start = 0.0
    for row, (_, kind, _), width in zip(place, parts, percent, strict=True):
        colour, hatch = KINDS[kind]
        axes.barh(row, width, left=start, color=colour, hatch=hatch, edgecolor=FITTED, linewidth=0.6, height=0.7)
        end = max(start, start + width)
        text = f"{width:.1f} %" if abs(width) >= 0.1 or width == 0.0 else f"{'-' if width < 0.0 else ''}< 0.1 %"
        axes.annotate(text, (end, row), xytext=(4, 0), textcoords="offset points", va="center")
        start += width
    axes.set_yticks(place, [named(name) for name, _, _ in parts])
    axes.invert_yaxis()
    axes.margins(x=0.12)
    axes.grid(visible=False, axis="y")
    axes.axvline(0.0, color=FITTED, linewidth=0.6)
    axes.set_xlabel("share of the gap's power (%)")
    return axes
