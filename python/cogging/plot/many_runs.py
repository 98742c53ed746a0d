"""Many runs: sweeps, predicted errors of controllers, and trade-offs of tunings."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from cogging.arrays import FloatArray
from cogging.calls import described, did_you_mean
from cogging.plot.canvas import drawn, legend, one_of
from cogging.plot.scales import scale_of, units_of
from cogging.plot.series import COLOURS, FITTED, GREY, LIMIT, MEASURED, look, marker, named

if TYPE_CHECKING:
    from matplotlib.axes import Axes

#: Units of indexes, in V and m, whose name does not begin with `error` or `command`.
UNITS = {"delay_margin": "s", "rms": "m", "max": "m", "max_whole": "m", "command_chatter": "1"}
FEW = 8  # values of a second number, up to which each is a line
WIDE = 30.0  # ratio of largest to smallest value from which the scale is logarithmic


def _unit_of(index: str) -> str:
    """Return the unit of an index by its name, in V and m."""
    return UNITS.get(index) or {"error": "m", "command": "V"}.get(index.split("(")[0].split("_")[0], "1")


@drawn
def sweep(
    runs: Any, index: str = "error_rms", against: str | None = None, *, units: Any = None, ax: Any = None
) -> Axes:
    """Plot an index of a sweep over a varied number.

    On a grid of two numbers each value of the second is a line; otherwise runs are points, with the median and the
    central 90 % in ten parts of the range. Failed runs are marked at the top.

    Args:
        runs: SweepRuns.
        index: `error_rms`, `error_max`, `command_rms` or another column of the table.
        against: path of the number; None: the one that explains most of the index's spread.
        units, ax: see cogging.plot.

    Raises:
        ValueError: an unknown index or number.

    Example:
        >>> ax = cogging.plot.sweep(cogging.sweep(model, move, {"axis.mass": [0.11, 0.12, 0.13]}))
        >>> ax.get_xlabel(), ax.get_ylabel()
        ('axis.mass (V/(m/s²))', 'error rms (µm)')
    """
    if not hasattr(runs, "table") or not hasattr(runs, "varied"):
        raise TypeError(f"runs: must be SweepRuns, got {described(runs)}")
    numeric = [name for name in runs.table if name not in ("run", "reason", "seed", *runs.varied)]
    for argument, name, known in (("index", index, numeric), ("against", against or runs.varied[0], runs.varied)):
        if name not in known:
            raise ValueError(f"{argument}: must be of these runs, got {name!r}: {did_you_mean(name, known)}")
    against = against or next(iter(runs.influence(index)))
    x, y = (np.asarray(runs.table[name], dtype=np.float64) for name in (against, index))
    along = scale_of(runs.units.get(against, "1"), x, units=units)
    up = scale_of(runs.units.get(index, _unit_of(index)), y, units=units)
    axes = one_of(ax)
    others = [name for name in runs.varied if name != against]
    if not _draw_lines(axes, runs, along(x), up(y), others):
        axes.plot(along(x), up(y), "o", color=GREY, markersize=3, label="runs")
        _draw_range(axes, along(x), up(y))
    failed = ~np.isfinite(y)
    if failed.any():
        top = axes.get_xaxis_transform()
        axes.plot(along(x[failed]), np.full(int(failed.sum()), 0.98), "x", color=LIMIT, transform=top, label="failed")
    axes.set(xlabel=along.label(named(against)), ylabel=up.label(named(index.replace("_", " "))))
    legend(axes, columns=3)
    return axes


def _draw_lines(ax: Axes, runs: Any, x: FloatArray, y: FloatArray, others: list[str]) -> bool:
    """Plot one line, or one for each value of a second number; return whether the runs are on such a grid."""
    if len(others) > 1:
        return False
    second = np.asarray(runs.table[others[0]], dtype=np.float64) if others else np.zeros(x.size)
    values = np.unique(second)
    if values.size > FEW or values.size * np.unique(x).size > x.size:
        return False
    for place, value in enumerate(values):
        kept = second == value
        order = np.argsort(x[kept], kind="stable")
        label = f"{named(others[0])} {value:.4g}" if others else None
        ax.plot(x[kept][order], y[kept][order], label=label, marker=marker(place), **look(place))
    return True


def _draw_range(ax: Axes, x: FloatArray, y: FloatArray) -> None:
    """Plot the median and the central 90 % of the runs in ten parts of the range."""
    good = np.isfinite(y)
    x, y = x[good], y[good]
    parts = min(10, x.size // 10)
    if parts < 2:
        return
    groups = np.array_split(np.argsort(x, kind="stable"), parts)
    middle = [float(np.mean(x[rows])) for rows in groups]
    low, half, high = (np.array([np.quantile(y[rows], q) for rows in groups]) for q in (0.05, 0.5, 0.95))
    ax.fill_between(middle, low, high, color=MEASURED, alpha=0.25, linewidth=0, label="nine of ten runs")
    ax.plot(middle, half, color=FITTED, label="median")


@drawn
def prediction(prediction: Any, index: str = "rms", *, units: Any = None, ax: Any = None) -> Axes:
    """Plot the predicted tracking error of each controller: median, interval, and each drawn machine.

    Args:
        prediction: an ErrorPrediction.
        index: `rms`, `max` or `max_whole`.
        units, ax: see cogging.plot.

    Raises:
        ValueError: an unknown index.

    Example:
        >>> ax = cogging.plot.prediction(cogging.predict_error(model, move, ["own"], samples=4))
        >>> ax.get_xlabel()
        'rms of the tracking error (µm)'
    """
    controllers = getattr(prediction, "controllers", None)
    if not isinstance(controllers, tuple) or not hasattr(prediction, "coverage"):
        raise TypeError(f"prediction: must be an ErrorPrediction, got {described(prediction)}")
    names = {"rms": "rms", "max": "largest", "max_whole": "largest of the whole run"}
    if index not in names:
        raise ValueError(f"index: must be one of {', '.join(names)}, got {index!r}")
    found = [getattr(one, index) for one in controllers]
    scale = scale_of("m", *(one.values for one in found), units=units or units_of(prediction))
    axes = one_of(ax, size=(7.2, 1.0 + 0.4 * len(found)))
    for row, one in enumerate(found):
        values = scale(one.values[np.isfinite(one.values)])
        axes.plot(values, np.full(values.size, row + 0.22), "|", color=GREY, markersize=5)
        ends = scale(one.interval)
        if np.isfinite(ends).all():
            axes.plot(ends, [row, row], color=MEASURED, linewidth=3.0, solid_capstyle="butt")
        if np.isfinite(one.median):
            axes.plot([float(scale(one.median))], [row], "o", color=FITTED, markersize=5)
    labels = [named(one.name) + f" ({one.diverged:.0%} diverged)" * bool(one.diverged) for one in controllers]
    axes.set_yticks(range(len(labels)), labels)
    axes.set_ylim(len(labels) - 0.4, -0.6)
    values = np.concatenate([one.values[np.isfinite(one.values) & (one.values > 0.0)] for one in found])
    if values.size and values.max() > WIDE * values.min():
        axes.set_xscale("log")
    axes.set_xlabel(scale.label(f"{names[index]} of the tracking error"))
    return axes


@drawn
def trade_off(tuning: Any, index: str | None = None, *, units: Any = None, ax: Any = None) -> Axes:
    """Plot the trade-off of a tuning: trials, the Pareto front, and the gains before and after.

    Args:
        tuning: a Tuning.
        index: abscissa; None: the one that the error was traded against.
        units, ax: see cogging.plot.

    Raises:
        ValueError: an unknown index.

    Example:
        >>> few = {"trials": 2, "machines": 2, "held_out": 2, "duration": 0.2}
        >>> tuning = cogging.tune(model, move, {"controller.kp": {"from": 5e3, "to": 2e4}}, **few)
        >>> cogging.plot.trade_off(tuning).get_ylabel()
        'rms error (µm)'
    """
    if not hasattr(tuning, "front") or not hasattr(tuning, "against"):
        raise TypeError(f"tuning: must be a Tuning, got {described(tuning)}")
    index = index or tuning.against
    known = [name for name in (*tuning.trials, *tuning.front) if name not in ("kept", "trial", "error_rms")]
    if index not in known:
        raise ValueError(f"index: must be of these trials, got {index!r}: {did_you_mean(index, known)}")
    units = units or units_of(tuning)
    trials: dict[str, Any] = dict(tuning.trials)
    front = {name: np.asarray(tuning.front[name], dtype=np.float64) for name in ("error_rms", index)}
    errors = np.asarray(trials["error_rms"], dtype=np.float64)
    up = scale_of("m", np.median(errors[np.isfinite(errors)]) if np.isfinite(errors).any() else None, units=units)
    along = scale_of(_unit_of(index), front[index], units=units)
    axes = one_of(ax)
    if index in trials:
        x, y, kept = along(trials[index]), up(errors), np.asarray(trials["kept"], dtype=bool)
        series = ((~kept, "x", GREY, "beyond a limit"), (kept, ".", MEASURED, "within the limits"))
        for which, mark, colour, name in series:
            shown = which & np.isfinite(x) & np.isfinite(y)
            if shown.any():
                axes.plot(x[shown], y[shown], mark, markersize=4, color=colour, label=name)
    order = np.argsort(front[index], kind="stable") if index in trials else slice(None)
    style: dict[str, Any] = {"color": FITTED, "marker": "o", "linestyle": "-" if index == tuning.against else "none"}
    axes.plot(along(front[index])[order], up(front["error_rms"])[order], linewidth=0.8, label="none is better", **style)
    settings = ((tuning.present, "s", LIMIT, "present"), (tuning.tuned, "*", COLOURS[5], "tuned"))
    for setting, mark, colour, name in settings:
        reached = None if setting is None else getattr(setting.drawn, index, None)
        if reached is not None and np.isfinite(setting.drawn.error_rms):
            at = ([float(along(reached))], [float(up(setting.drawn.error_rms))])
            axes.plot(*at, mark, color=colour, markeredgecolor=FITTED, markersize=9, label=name)
    axes.set(xlabel=along.label(named(index.replace("_", " "))), ylabel=up.label("rms error"), yscale="log")
    legend(axes, columns=3)
    return axes
