"""What an adaptive controller learned while it ran, against the bounds that it keeps."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from typing import Any, NamedTuple

import numpy as np

from cogging.calls import described, did_you_mean
from cogging.plot.canvas import Panels, drawn, grid_of
from cogging.plot.scales import labelled, scale_of, units_of
from cogging.plot.series import LIMIT, look, named
from cogging.plot.traces import draw_trace, is_dense

MOST = 12  # panels, where none are named
#: Estimates of the adaptive robust controllers before those of the cogging, with their units.
PLAIN = {"mass": "V/(m/s^2)", "viscous": "V/(m/s)", "coulomb": "V", "disturbance": "V"}
TRIPLE = ("theta[0]", "theta[1]", "theta[2]")
OBSERVED = {"position": "m", "velocity": "m/s", "disturbance": "m/s^2"}


class Estimate(NamedTuple):
    """What is known of a column of estimates."""

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
    """Draw what an adaptive controller learned over time, one panel an estimate, with the bounds that it keeps.

    Where an estimate stands at its bound, what it stands for may lie outside: the bound is then too narrow, or the
    model behind the controller is not the machine's.

    Args:
        log: a Log with estimates (simulate(..., record_estimates=True)), of p columns.
        bounds: the controller or its parameters; a Model with one; low and high by name; an array (p, 2); None: of the
            controller of the model that the log carries, else none.
        names: of the estimates, (p,); None: the controller's own.
        which: estimates to draw, by name or by number from 0; None: the first twelve.
        units: labels of command and position (cogging.Units); None: those of the model that the log carries.
        ax: as many axes as estimates; None: a new figure.

    Returns:
        The axes, one an estimate.

    Raises:
        ValueError: a log without estimates, other numbers of names, bounds or axes, no such estimate.
        TypeError: an argument is something else.

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
    known = estimates_of(_stated(log) if bounds is None else bounds, values.shape[1], names, units)
    chosen = _chosen(known, which)
    wide = 1 if len(chosen) < 3 else 2 if len(chosen) < 7 else 3
    panels = grid_of(ax, len(chosen), 1) if ax is not None else _grid(len(chosen), wide)
    over = scale_of("s", log.time)
    for place, (panel, column) in enumerate(zip(panels, chosen, strict=True)):
        one = known[column]
        ends = [end for end in (one.low, one.high) if math.isfinite(end)]
        scale = scale_of(one.unit, values[:, column], ends, units=units)
        dense = is_dense(panel, len(log.time))
        draw_trace(panel, over(log.time), scale(values[:, column]), label=named(one.name), **look(0, dense))
        for end in ends:
            panel.axhline(float(scale(end)), color=LIMIT, linestyle="--", linewidth=1.0, label="bound")
        panel.set_ylabel(scale.label(named(one.name)))
        if place >= len(chosen) - wide:
            panel.set_xlabel(over.label("time"))
    return panels


def _grid(count: int, wide: int) -> Panels:
    rows = -(-count // wide)
    panels = grid_of(None, rows, wide, size=(7.2 if wide < 3 else 9.0, 0.6 + 1.7 * rows), sharex=True)
    for spare in panels[count:]:
        spare.remove()
    for panel in panels[max(0, count - wide) : count]:
        panel.tick_params(labelbottom=True)
    return Panels(panels[:count])


def _stated(log: Any) -> Any:
    """The section `[controller]` of the model that a simulated log carries, or none."""
    model = (getattr(log, "metadata", None) or {}).get("model") or {}
    return model.get("controller")


def _chosen(known: Sequence[Estimate], which: Sequence[str | int] | None) -> list[int]:
    names = [one.name for one in known]
    if which is None:
        return list(range(min(len(known), MOST)))
    found = []
    for wanted in [which] if isinstance(which, str | int) else which:
        if isinstance(wanted, str) and wanted in names:
            found.append(names.index(wanted))
        elif isinstance(wanted, int | np.integer) and 0 <= wanted < len(known):
            found.append(int(wanted))
        else:
            raise ValueError(f"which: must be estimates, got {wanted!r}: {did_you_mean(str(wanted), names)}")
    if not found:
        raise ValueError("which: must name at least one estimate, got none")
    return found


def estimates_of(stated: Any, count: int, names: Sequence[str] | None = None, units: Any = None) -> list[Estimate]:
    """Names, units and bounds of the columns of estimates.

    Args:
        stated: what is known of the bounds (see `adaptation`), or None.
        count: of columns.
        names: of the columns, or None.
        units: labels of command and position, or None.
    """
    fields = _fields(stated)
    own = [Estimate(f"[{i}]", "1") for i in range(count)] if fields is None else _of_controller(fields, count, units)
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
        return [
            one._replace(low=stated[one.name][0], high=stated[one.name][1]) if one.name in stated else one
            for one in own
        ]
    table = np.asarray(stated, dtype=np.float64) if isinstance(stated, Sequence | np.ndarray) else None
    if table is None:
        raise TypeError(f"bounds: must be a controller, its parameters, a Model or pairs, got {described(stated)}")
    if table.shape != (count, 2):
        raise ValueError(f"bounds: must have the shape ({count}, 2), got {table.shape}")
    return [one._replace(low=float(low), high=float(high)) for one, (low, high) in zip(own, table, strict=True)]


def _fields(stated: Any) -> Mapping[str, Any] | None:
    """The parameters of a controller by name, of whatever holds them."""
    if isinstance(stated, Mapping):
        return stated if "type" in stated or "cogging_bounds" in stated or "theta_min" in stated else None
    for holder in (stated, getattr(stated, "parameters", None), getattr(stated, "controller", None)):
        if holder is not None and hasattr(holder, "FIELDS"):
            fields: Mapping[str, Any] = holder.to_dict()
            if "sample_rate" in fields:
                return fields
    return None


def _of_controller(fields: Mapping[str, Any], count: int, units: Any) -> list[Estimate]:
    if "cogging_bounds" in fields and count >= len(PLAIN):
        plain = [Estimate(name, unit, *fields[f"{name}_bounds"]) for name, unit in PLAIN.items()]
        points = int(fields["cogging_control_points"])
        harmonics = [str(harmonic) for harmonic in fields["cogging_harmonics"]]
        low, high = fields["cogging_bounds"]
        made = [
            Estimate(f"{part} {harmonic}" + f", point {point}" * (points > 1), "V", low, high)
            for point in range(points)
            for harmonic in harmonics
            for part in ("sine", "cosine")
        ]
        if len(made) == count - len(plain):
            return plain + made
    elif "theta_min" in fields and count == len(TRIPLE):
        ends = zip(TRIPLE, fields["theta_min"], fields["theta_max"], strict=True)
        return [Estimate(name, "1", low, high) for name, low, high in ends]
    elif "observer_gain" in fields and count == len(OBSERVED) + 2 * len(fields["periods"]):
        lengths = [f"{1e3 * period:.4g} {labelled('mm', units)}" for period in fields["periods"]]
        waves = [f"{part}, {length}" for length in lengths for part in ("sine", "cosine")]
        return [Estimate(*one) for one in OBSERVED.items()] + [Estimate(wave, "m/s^2") for wave in waves]
    return [Estimate(f"[{i}]", "1") for i in range(count)]
