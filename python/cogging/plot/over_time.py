"""Logs over time: columns, tracking errors, and the estimates of adaptive controllers."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np
import numpy.typing as npt

from cogging.calls import described, did_you_mean
from cogging.plot.canvas import Panels, drawn, grid_of, legend, one_of
from cogging.plot.scales import labelled, scale_of, units_of
from cogging.plot.series import LIMIT, look, named
from cogging.plot.traces import UNITS, column, draw_trace, is_dense, numbers, several, table_of

if TYPE_CHECKING:
    from matplotlib.axes import Axes

WIDTH, PANEL = 7.2, 1.9  # inches
MOST = 12  # panels by default
#: Units of the estimates of adaptive robust controllers before those of the cogging.
PLAIN = {"mass": "V/(m/s^2)", "viscous": "V/(m/s)", "coulomb": "V", "disturbance": "V"}
OBSERVED = {"position": "m", "velocity": "m/s", "disturbance": "m/s^2"}


@drawn
def log(log: Any, columns: str | Sequence[str] | None = None, *, units: Any = None, ax: Any = None) -> Panels:
    """Plot columns of a log over time, one panel each: position with its reference, tracking error, command.

    Missing rows are gaps. Each pixel of a long log shows its least and largest value, so that no peak is lost.

    Args:
        log: a Log, or columns by name with `time` (a mapping of arrays, a DataFrame).
        columns: names of one or more columns, `error` among them; None: position, error and command as available.
        units, ax: see cogging.plot; as many axes as columns.

    Raises:
        ValueError: an unknown column, or another number of axes.

    Example:
        >>> position, error, command = cogging.plot.log(log)
        >>> error.get_ylabel()
        'error (µm)'
    """
    table = table_of(log)
    usual: list[str] = [name for name in ("position", "error", "command") if name in table]
    usual = usual or [name for name in table if name != "time"]
    chosen = [columns] if isinstance(columns, str) else list(columns or usual)
    found = {name: column(table, name) for name in chosen}
    panels = grid_of(ax, len(chosen), size=(WIDTH, 0.7 + PANEL * len(chosen)), sharex=True)
    units = units or units_of(log)
    time = column(table, "time")
    over = scale_of("s", time)
    for panel, (name, values) in zip(panels, found.items(), strict=True):
        beside = column(table, "reference") if name == "position" and "reference" in table else None
        scale = scale_of(UNITS.get(name, "1"), values, beside, units=units)
        draw_trace(panel, over(time), scale(values), label=named(name), **look(0, is_dense(panel, len(time))))
        if beside is not None:
            draw_trace(panel, over(time), scale(beside), label="reference", **look(1))
            legend(panel)
        panel.set_ylabel(scale.label(named(name.replace("_", " "))))
    panels[-1].set_xlabel(over.label("time"))
    return panels


@drawn
def error(log: Any, error: npt.ArrayLike | None = None, *, units: Any = None, ax: Any = None) -> Axes:
    """Plot the tracking error, encoder reading minus reference, of one or several logs over time.

    Args:
        log: a Log; several, as a list or by name for the legend; or times (s, (n,)) if `error` is given.
        error: m, (n,).
        units, ax: see cogging.plot.

    Raises:
        ValueError: a log without reference, or arrays of other shapes.

    Example:
        >>> ax = cogging.plot.error({"first": log, "again": log})
        >>> [line.get_label() for line in ax.lines]
        ['first', 'again']
    """
    if error is None:
        logs = several(log)
    else:
        time = numbers("log", log)
        logs = {"": {"time": time, "error": numbers("error", error, time.size)}}
    tables = {name: table_of(one) for name, one in logs.items()}
    errors = {name: column(one, "error", "log") for name, one in tables.items()}
    times = {name: column(one, "time") for name, one in tables.items()}
    axes = one_of(ax)
    units = units or units_of(*logs.values())
    scale, over = scale_of("m", *errors.values(), units=units), scale_of("s", *times.values())
    size = {name: float(np.nanmax(np.abs(values), initial=0.0)) for name, values in errors.items()}
    for place, (name, values) in enumerate(errors.items()):
        # Smaller errors above larger ones, which would hide them.
        order = 2.0 + sum(other > size[name] for other in size.values()) / (1.0 + len(size))
        style = look(place, is_dense(axes, values.size))
        draw_trace(axes, over(times[name]), scale(values), label=named(name) or None, zorder=order, **style)
    axes.set(xlabel=over.label("time"), ylabel=scale.label("tracking error"))
    legend(axes)
    return axes


class Estimate(NamedTuple):
    """Name, unit and bounds of an estimate."""

    name: str
    unit: str
    low: float = -math.inf
    high: float = math.inf


@drawn
def adaptation(
    log: Any,
    bounds: Any = None,
    *,
    names: Sequence[str] | None = None,
    which: Sequence[str | int] | None = None,
    units: Any = None,
    ax: Any = None,
) -> Panels:
    """Plot the estimates of an adaptive controller over time, one panel each, with their bounds.

    The true value of an estimate at its bound may be outside: the bound is too narrow, or the controller's model does
    not describe the machine.

    Args:
        log: a Log with estimates (simulate(..., record_estimates=True)), of p columns.
        bounds: the controller or its parameters; a Model with one; low and high by name; an array (p, 2); None: of the
            controller in the log's metadata, if any.
        names: of the estimates, (p,); None: those of the controller.
        which: estimates to plot, by name or by number from 0; None: the first twelve.
        units, ax: see cogging.plot; as many axes as estimates.

    Raises:
        ValueError: a log without estimates, other numbers of names, bounds or axes, or an unknown estimate.

    Example:
        >>> parameters = cogging.AdaptiveRobustParameters(mass_adaptation=1.0, epsilon=0.1)
        >>> log = cogging.simulate(model, move, controller=cogging.Arc(parameters), record_estimates=True)
        >>> mass, = cogging.plot.adaptation(log, which=["mass"])
        >>> mass.get_ylabel()
        'mass (V/(m/s²))'
    """
    values = getattr(log, "estimates", None)
    if values is None:
        rule = "must be in the log (simulate(..., record_estimates=True))"
        raise ValueError(f"estimates: {rule}, got {described(log)} without")
    units = units or units_of(log)
    if bounds is None:  # those of the controller of the model in the metadata
        bounds = ((getattr(log, "metadata", None) or {}).get("model") or {}).get("controller")
    known = _estimates(bounds, values.shape[1], names, units)
    places = {one.name: place for place, one in enumerate(known)}
    wanted = [which] if isinstance(which, str | int) else range(min(len(known), MOST)) if which is None else list(which)
    if not wanted:
        raise ValueError("which: must name at least one estimate, got none")
    for name in wanted:
        if name not in places and name not in range(len(known)):
            raise ValueError(f"which: must be estimates, got {name!r}: {did_you_mean(str(name), places)}")
    chosen = [places[name] if isinstance(name, str) else int(name) for name in wanted]
    wide = 1 if len(chosen) < 3 else 2 if len(chosen) < 7 else 3
    size = (7.2 if wide < 3 else 9.0, 0.6 + 1.7 * -(-len(chosen) // wide))
    panels = grid_of(ax, len(chosen), wide, size=size, sharex=True)
    over = scale_of("s", log.time)
    for place, (panel, number) in enumerate(zip(panels, chosen, strict=True)):
        one = known[number]
        ends = [end for end in (one.low, one.high) if math.isfinite(end)]
        scale = scale_of(one.unit, values[:, number], ends, units=units)
        style = look(0, is_dense(panel, len(log.time)))
        draw_trace(panel, over(log.time), scale(values[:, number]), label=named(one.name), **style)
        for end in ends:
            panel.axhline(float(scale(end)), color=LIMIT, linestyle="--", linewidth=1.0, label="bound")
        panel.set_ylabel(scale.label(named(one.name)))
        if place >= len(chosen) - wide:
            panel.set_xlabel(over.label("time"))
            if ax is None:
                panel.tick_params(labelbottom=True)
    return panels


def _estimates(stated: Any, count: int, names: Sequence[str] | None, units: Any) -> list[Estimate]:
    """Return names, units and bounds of `count` estimates; `stated`: the bounds in any form of `adaptation`."""
    fields = _controller_fields(stated)
    own = [] if fields is None else _of_controller(fields, count, units)
    if len(own) != count:
        own = [Estimate(f"[{i}]", "1") for i in range(count)]
    if names is not None:
        if len(names) != count:
            raise ValueError(f"names: must be {count}, one an estimate, got {len(names)}")
        own = [one._replace(name=str(name)) for one, name in zip(own, names, strict=True)]
    if stated is None or fields is not None:
        return own
    if isinstance(stated, Mapping):
        for name in stated:
            if name not in {one.name for one in own}:
                raise ValueError(f"bounds: must be of estimates: {did_you_mean(name, [one.name for one in own])}")
        table = np.array([stated.get(one.name, (one.low, one.high)) for one in own], dtype=np.float64)
    elif isinstance(stated, Sequence | np.ndarray):
        table = np.asarray(stated, dtype=np.float64)
    else:
        raise TypeError(f"bounds: must be a controller, its parameters, a Model or pairs, got {described(stated)}")
    if table.shape != (count, 2):
        raise ValueError(f"bounds: must have the shape ({count}, 2), got {table.shape}")
    return [one._replace(low=float(low), high=float(high)) for one, (low, high) in zip(own, table, strict=True)]


def _controller_fields(stated: Any) -> Mapping[str, Any] | None:
    """Return the parameters of a controller by name, from any object that holds them."""
    if isinstance(stated, Mapping):
        return stated if "type" in stated or "cogging_bounds" in stated or "theta_min" in stated else None
    for holder in (stated, getattr(stated, "parameters", None), getattr(stated, "controller", None)):
        if holder is not None and "sample_rate" in getattr(holder, "FIELDS", ()):
            fields: Mapping[str, Any] = holder.to_dict()
            return fields
    return None


def _of_controller(fields: Mapping[str, Any], count: int, units: Any) -> list[Estimate]:
    """Return the estimates of a controller with these parameters; another number of them where it is unknown."""
    if "cogging_bounds" in fields:
        found = [Estimate(name, unit, *fields[f"{name}_bounds"]) for name, unit in PLAIN.items()]
        points = int(fields["cogging_control_points"])
        for point in range(points):
            for harmonic in fields["cogging_harmonics"]:
                place = f"{harmonic}" + f", point {point}" * (points > 1)
                found += [Estimate(f"{part} {place}", "V", *fields["cogging_bounds"]) for part in ("sine", "cosine")]
        return found
    if "theta_min" in fields:
        ends = zip(fields["theta_min"], fields["theta_max"], strict=True)
        return [Estimate(f"theta[{i}]", "1", low, high) for i, (low, high) in enumerate(ends)]
    if "observer_gain" in fields:
        lengths = [f"{1e3 * period:.4g} {labelled('mm', units)}" for period in fields["periods"]]
        waves = [f"{part}, {length}" for length in lengths for part in ("sine", "cosine")]
        return [Estimate(*one) for one in OBSERVED.items()] + [Estimate(wave, "m/s^2") for wave in waves]
    return []
