"""Characteristics of an axis: cogging map, spectrum, friction curve, fitted parameters."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np
import numpy.typing as npt

from cogging._core import CoggingModel, smooth_sign
from cogging.arrays import SIGMAS_95, FloatArray
from cogging.calls import described
from cogging.effects.effect import steady_friction
from cogging.plot.canvas import drawn, legend, one_of
from cogging.plot.scales import labelled, pretty, scale_of, units_of
from cogging.plot.series import COLOURS, FITTED, GREY, LIMIT, MEASURED, look, marker, named
from cogging.plot.traces import numbers

if TYPE_CHECKING:
    from matplotlib.axes import Axes

POINTS_PER_WAVE = 24  # of the shortest period
FEWEST, MOST = 401, 20_001  # points of a map
DIRECTIONS = ((1.0, "forward"), (-1.0, "backward"))
POINTS = 400  # of a friction law
FASTEST = 0.5  # m/s, up to which the friction of a model is plotted
LABELLED = 4  # spectral lines with their period beside them


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
    """Plot a cogging force over position, with its 95 % band if its uncertainty is known.

    The band of a MapFit follows from the standard errors of its amplitudes and their correlation in the scan; that of a
    Model from its `[bounds]`, taken as independent. For a MapFit the points of the scan are plotted too, without
    offset, trend and friction.

    Args:
        cogging: a MapFit, a Model or a CoggingModel; or positions (m, (n,)) where `force` is given.
        force: V, (n,).
        deviation: standard deviation of `force`, V, (n,), for its band.
        position: at which a map is plotted, m, (n,); None: over the scan, the travel, or three pitches.
        units, ax: see cogging.plot.

    Raises:
        ValueError: a model without cogging, or arrays of other shapes.

    Example:
        >>> ax = cogging.plot.cogging_map(model)
        >>> ax.get_xlabel(), ax.get_ylabel()
        ('position (mm)', 'cogging force (V)')
    """
    scan = None  # position, force without offset, trend and friction, direction
    if force is not None:
        x = numbers("cogging", cogging)
        y = numbers("force", force, x.size)
        half = None if deviation is None else SIGMAS_95 * numbers("deviation", deviation, x.size)
    else:
        known = cogging if isinstance(cogging, CoggingModel) else getattr(cogging, "cogging", cogging)
        if known is None:
            raise ValueError("cogging: must be in the model to be drawn, got a model without [cogging]")
        if not isinstance(known, CoggingModel):
            raise TypeError(f"cogging: must be a MapFit, a Model or a CoggingModel, got {described(cogging)}")
        if position is None:
            low, high = _range(cogging, known)
            waves = (high - low) * max(known.basis.wavenumbers) / (2.0 * np.pi)
            x = np.linspace(low, high, int(np.clip(POINTS_PER_WAVE * waves, FEWEST, MOST)))
        else:
            x = numbers("position", position)
        y, half = np.asarray(known.force(x), dtype=np.float64), _half_band(cogging, known, x)
        if hasattr(cogging, "fitted"):
            left = cogging.force - cogging.fitted + np.asarray(known.force(cogging.position))
            scan = (cogging.position, left, cogging.direction)
    units = units or units_of(cogging)
    axes = one_of(ax)
    along = scale_of("m", x, units=units)
    up = scale_of("V", y, None if scan is None else scan[1], units=units)
    for place, (way, name) in enumerate(DIRECTIONS):
        if scan is not None and (kept := scan[2] == way).any():
            dots = {**look(place), "linestyle": "none", "marker": "os"[place], "markersize": 2.5, "alpha": 0.6}
            axes.plot(along(scan[0][kept]), up(scan[1][kept]), label=f"measured, {name}", **dots)
    if half is not None:
        # Above the points and below the map.
        band: dict[str, Any] = {"color": GREY, "alpha": 0.6, "linewidth": 0, "zorder": 2.2}
        axes.fill_between(along(x), up(y - half), up(y + half), label="95 %", **band)
    axes.plot(along(x), up(y), color=FITTED, label="map", linewidth=1.0, zorder=2.3)
    axes.set(xlabel=along.label("position"), ylabel=up.label("cogging force"))
    legend(axes)
    return axes


def _range(thing: Any, cogging: CoggingModel) -> tuple[float, float]:
    """Return where a map is plotted: over the scan, the travel, the spline, or three pitches, m."""
    scan = getattr(thing, "position", None)
    if scan is not None:
        return float(np.min(scan)), float(np.max(scan))
    travel = getattr(getattr(thing, "axis", None), "travel", None)
    if travel is not None and np.all(np.isfinite(travel)) and travel[1] > travel[0]:
        return float(travel[0]), float(travel[1])
    basis = cogging.basis
    if basis.spline.control_points > 1:
        return float(basis.spline.origin), float(basis.spline.end)
    return 0.0, 3.0 * (basis.pitch if basis.pitch > 0.0 else max(2.0 * np.pi / wave for wave in basis.wavenumbers))


def _half_band(thing: Any, cogging: CoggingModel, x: FloatArray) -> FloatArray | None:
    """Return the half width of the 95 % band, V, from the deviations of the amplitudes and their correlation."""
    tables = []
    for part in ("sine", "cosine"):
        table = getattr(thing, f"{part}_standard_error", None)
        if table is None:  # from the model's 95 % intervals
            intervals, table = getattr(thing, "intervals", None) or {}, np.zeros_like(cogging.sine)
            for row, point in np.ndindex(*table.shape):
                low, high = intervals.get(f"cogging.{part}[{row}][{point}]", (np.nan, np.nan))
                table[row, point] = 0.5 * (high - low) / SIGMAS_95
        tables.append(np.asarray(table))
    if not np.isfinite(tables).all() or not np.any(tables[0]):
        return None
    deviation = np.stack(tables, axis=-1).transpose(1, 0, 2).ravel()
    rows = np.asarray(cogging.basis.regressor(x)) * deviation
    scan = getattr(thing, "position", None)
    together = np.eye(deviation.size)
    if scan is not None:  # correlation of the least-squares amplitudes, none for those that no point determines
        design = np.asarray(cogging.basis.regressor(scan))
        gram = design.T @ design
        covariance = np.linalg.inv(gram + 1e-6 * float(np.max(np.diag(gram))) * np.eye(len(gram)))
        size = np.sqrt(np.diag(covariance))
        together = covariance / np.outer(size, size)
    variance = np.maximum(np.sum((rows @ together) * rows, axis=1), 0.0)
    return np.asarray(SIGMAS_95 * np.sqrt(variance))


@drawn
def friction_curve(
    curve: Any,
    force: npt.ArrayLike | None = None,
    *,
    fastest: float = FASTEST,
    by_speed: bool = False,
    units: Any = None,
    ax: Any = None,
) -> Axes:
    """Plot friction over velocity: measured points and fitted laws, or the friction of a model.

    For a FrictionCurve each fitted law is plotted, the best one solid. For a Model: Coulomb and viscous friction, and
    the velocity-dependent part of its effects, at steady speed.

    Args:
        curve: a FrictionCurve or a Model; or velocities (m/s, (n,)) where `force` is given.
        force: V, (n,), positive forward.
        fastest: m/s, up to which the friction of a model is plotted.
        by_speed: plot both directions over the speed, each force along the direction of motion.
        units, ax: see cogging.plot.

    Raises:
        ValueError: arrays of other shapes, or `fastest` is not above 0.

    Example:
        >>> ax = cogging.plot.friction_curve(model)
        >>> ax.get_xlabel(), ax.get_ylabel()
        ('velocity (m/s)', 'friction (V)')
    """
    points: dict[str, tuple[FloatArray, FloatArray]] = {}  # velocity and force by name
    lines: dict[str, tuple[FloatArray, FloatArray]] = {}  # the best one last
    if not (isinstance(fastest, int | float | np.floating) and 0.0 < fastest < np.inf):
        raise ValueError(f"fastest: must be above 0 and finite, got {fastest!r}")
    if force is not None:
        v = numbers("curve", curve)
        points["measured"] = (v, numbers("force", force, v.size))
    elif hasattr(curve, "models") and hasattr(curve, "best"):
        v, f = curve.velocity, curve.force
        points = {name: (v[kept], f[kept]) for name, kept in (("forward", v > 0), ("backward", v < 0)) if kept.any()}
        fine = np.linspace(0.5 * np.abs(v).min(), np.abs(v).max(), POINTS)
        grid = np.concatenate([side * fine[:: int(side)] for side in (-1.0, 1.0) if np.any(side * v > 0)])
        for law in sorted(curve.models, key=lambda law: law.name == curve.best.name):
            lines[law.name.replace("_", " ")] = (grid, law.force(grid))
    elif hasattr(curve, "axis") and hasattr(curve, "effects"):
        v = fastest * np.concatenate([-np.geomspace(1.0, 1e-4, POINTS), np.geomspace(1e-4, 1.0, POINTS)])
        axis, width = curve.axis, curve.axis.coulomb_width
        moving, resting = (steady_friction(curve.effects, speed, width=width) for speed in (v, np.zeros_like(v)))
        lines["model"] = (v, axis.coulomb * smooth_sign(v, width) + axis.viscous * v + moving - resting)
    else:
        raise TypeError(f"curve: must be a FrictionCurve, a Model or velocities with a force, got {described(curve)}")
    units = units or units_of(curve)
    axes = one_of(ax)
    along = scale_of("m/s", *(x for x, _ in (*points.values(), *lines.values())), units=units)
    up = scale_of("V", *(y for _, y in (*points.values(), *lines.values())), units=units)
    for place, (name, (x, y)) in enumerate(points.items()):
        way = np.where(by_speed, np.sign(x), 1.0)
        style = {"color": look(place)["color"], "marker": marker(place), "linestyle": "none"}
        axes.plot(along(way * x), up(way * y), label=name, **style)
    for place, (name, (x, y)) in enumerate(reversed(lines.items())):
        style = {**look(place + 2), "linestyle": "-" if place == 0 else look(place)["linestyle"]}
        for number, side in enumerate((x < 0.0, x > 0.0)):
            if side.any():
                way = np.where(by_speed, np.sign(x[side]), 1.0)
                axes.plot(along(way * x[side]), up(way * y[side]), label=named(name) if number else None, **style)
    axes.set(xlabel=along.label("speed" if by_speed else "velocity"), ylabel=up.label("friction"))
    legend(axes, columns=3)
    return axes


@drawn
def spectrum(
    spectrum: Any, amplitude: npt.ArrayLike | None = None, *, units: Any = None, unit: str = "m", ax: Any = None
) -> Axes:
    """Plot amplitudes over spatial frequency on a logarithmic scale, with significant lines.

    For a TrackingSpectrum: the tracking error over 1/m, the noise and the proposed periods. For a MapFit: the force
    over harmonics of the pitch, the detection threshold and the harmonics of the map.

    Args:
        spectrum: a TrackingSpectrum or a MapFit; or frequencies (1/m, (n,)) where `amplitude` is given.
        amplitude: (n,), in `unit`.
        units, ax: see cogging.plot.
        unit: of `amplitude`, in the terms of this package: "m", "V".

    Raises:
        ValueError: arrays of other shapes.

    Example:
        >>> ax = cogging.plot.spectrum(cogging.tracking_spectrum(log))
        >>> ax.get_xlabel(), ax.get_ylabel()
        ('spatial frequency (1/m)', 'tracking error (µm)')
    """
    units = units or units_of(spectrum)
    along = scale_of("1/m", units=units).label("spatial frequency")
    if amplitude is not None:
        x, name = numbers("spectrum", spectrum), "amplitude"
        y = numbers("amplitude", amplitude, x.size)
    elif hasattr(spectrum, "period_amplitudes"):
        x, y, unit, name = spectrum.frequency, spectrum.amplitude, "m", "tracking error"
    elif hasattr(spectrum, "line_threshold"):
        x, y, unit, name, along = spectrum.line, spectrum.line_amplitude, "V", "force", "harmonic of the pitch"
    else:
        raise TypeError(f"spectrum: must be a TrackingSpectrum, a MapFit or frequencies, got {described(spectrum)}")
    axes, scale = one_of(ax), scale_of(unit, y, units=units)
    axes.plot(x, scale(y), color=MEASURED, linewidth=0.9, label="measured")
    if np.any(y > 0.0):
        axes.set_yscale("log")
    axes.set(xlabel=along, ylabel=scale.label(name))
    peaks: dict[str, Any] = {"color": "black", "markersize": 6}
    if hasattr(spectrum, "period_amplitudes"):
        if spectrum.noise > 0.0:
            axes.axhline(float(scale(spectrum.noise)), color=LIMIT, linestyle="--", label="noise")
        if spectrum.periods:
            periods, sizes = np.array(spectrum.periods), np.array(spectrum.period_amplitudes)
            axes.plot(1.0 / periods, scale(sizes), "v", label="proposed periods", **peaks)
            length = scale_of("m", periods, units=units)
            for period, size in list(zip(periods, sizes, strict=True))[:LABELLED]:
                text, place = f"{length(period):.4g} {length.unit}", (1.0 / period, float(scale(size)))
                axes.annotate(text, place, xytext=(4, 3), textcoords="offset points", fontsize="small")
        legend(axes)
    elif hasattr(spectrum, "line_threshold"):
        axes.plot(x, scale(spectrum.line_threshold), color=LIMIT, linestyle="--", label="found from here")
        if spectrum.amplitudes and x.size:
            harmonics = [entry.harmonic for entry in spectrum.amplitudes]
            at = [int(np.argmin(np.abs(x - harmonic))) for harmonic in harmonics]
            axes.plot(harmonics, scale(y[at]), "v", label="harmonics", **peaks)
        largest = float(y.max())
        if largest > 0.0:
            lowest = max(0.03 * float(spectrum.line_threshold.min()), 1e-6 * largest)
            axes.set_ylim(float(scale(lowest)), float(scale(3.0 * largest)))
        legend(axes)
    return axes


@drawn
def intervals(fit: Any, *, units: Any = None, ax: Any = None) -> Axes:
    """Plot the parameters of a fit with their 95 % intervals and prior values, in per cent of each.

    One row for each parameter from the top; 0 is the fitted value, 100 % the largest of value, prior and half interval.

    Args:
        fit: an Identification.
        units, ax: see cogging.plot.

    Example:
        >>> ax = cogging.plot.intervals(cogging.identify(log, model, free=["axis.mass", "axis.viscous"]))
        >>> len(ax.get_yticks())
        2
    """
    entries = getattr(fit, "parameters", None)
    if not isinstance(entries, tuple) or not entries or not all(hasattr(one, "ci95") for one in entries):
        raise TypeError(f"fit: must be an Identification, got {described(fit)}")
    axes = one_of(ax, size=(7.2, 1.0 + 0.34 * len(entries)))
    bar: dict[str, Any] = {"color": COLOURS[0], "linewidth": 3.0, "solid_capstyle": "butt"}
    prior: dict[str, Any] = {"color": LIMIT, "markersize": 5, "markerfacecolor": "none"}
    labels, widest = [], 1e-3
    for row, one in enumerate(entries):
        low, high = one.ci95
        known = bool(np.isfinite([low, high]).all())
        size = max(abs(one.value), abs(one.prior), 0.5 * (high - low) if known else 0.0) or 1.0
        unit = "" if one.unit == "1" else f" {pretty(labelled(one.unit, units))}"
        path = named(one.path.removeprefix("axis.").removeprefix("effects."))
        labels.append(f"{path}: {one.value:.4g}{unit}" + ("" if one.determined else " (not determined)"))
        if known:
            ends = 100.0 * np.array([low - one.value, high - one.value]) / size
            widest = max(widest, float(np.abs(ends).max()))
            axes.plot(ends, [row, row], label=_once(axes, "95 %"), **bar)
        axes.plot([0.0], [row], "o", color=FITTED, markersize=5, label=_once(axes, "fitted"))
        before = 100.0 * (one.prior - one.value) / size
        widest = max(widest, min(abs(before), 100.0))
        axes.plot([before], [row], "D", label=_once(axes, "before"), **prior)
    axes.set_yticks(range(len(labels)), labels)
    axes.set_ylim(len(labels) - 0.4, -0.6)
    axes.set_xlim(-1.15 * widest, 1.15 * widest)
    axes.set_xlabel("beside the fitted value (%)")
    legend(axes)
    return axes


def _once(ax: Axes, label: str) -> str | None:
    return None if label in ax.get_legend_handles_labels()[1] else label
