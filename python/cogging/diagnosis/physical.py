"""What no machine that made these logs can be, however well it explains them: for every candidate, search and refit."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np

from cogging.arrays import FloatArray
from cogging.effects.effect import Effect, laws_of
from cogging.logs.log import Log
from cogging.model.model import Model

PERIODS = 3.0  # of a tone or a resonance, that the time of motion holds: fewer are a drift
LEVELS = 20  # of the command, at which is seen whether what is beyond them acts
AVERAGED = (1, 2, 4, 8, 16, 32)  # rows over which commands and readings are averaged
FEWEST = 40  # times the rows averaged, that a log has at least
OBEYED = 0.5  # of what a V up to a level does, that a V beyond it does if there is no limit
CERTAIN = 8.0  # deviations by which what is beyond a level acts
AT_END = 1e-3  # relative: so near to an end a parameter stands at it
PLACES = 60  # of the travel, at which the level of friction is looked at
PUSHES = 0.02  # of the largest command: so far below nothing friction may come out
STEPS, MOVES = 2000, 0.01  # into which a log is cut; share of the largest mean speed from which the axis moves in one


def ends(logs: Sequence[Log], role: Mapping[str, Any]) -> tuple[float, float]:
    """Lowest and highest value that logs allow a parameter of an effect (see cogging.effects, ROLES).

    No resonance or tone of fewer than PERIODS in the time of motion is told from a drift, and none that is
    damped more than its effect says rings; a command that was obeyed is below the limit of commands; and no friction is
    above the largest command that moved the axis.
    """
    if role["quantity"] == "frequency":
        return PERIODS / max(max(map(seconds_of_motion, logs)), 1e-300), np.inf
    if role["quantity"] == "command" and role["neutral"] == np.inf:
        return obeyed_command(logs), np.inf
    if role["quantity"] == "one" and role["role"] == "shape":
        return -np.inf, role["high"]
    if role["quantity"] == "friction":
        most = moving_command(logs)
        return -most, most
    return -np.inf, np.inf


def at_end(effect: Effect, logs: Sequence[Log]) -> str:
    """Which parameter of a fitted effect stands at an end of what logs allow, a clause; empty where none does."""
    for name, role in effect.ROLES.items():
        if role["role"] == "setting":
            continue
        least, most = ends(logs, role)
        values = np.ravel(np.asarray(getattr(effect, name), dtype=float))
        for value, end, room in ((values.min(initial=np.inf), least, 1.0), (values.max(initial=-np.inf), most, -1.0)):
            if np.isfinite(end) and room * (value - end) <= AT_END * abs(end):
                return f"its {name} runs to {value:.4g}, the end of what these logs allow"
    return ""


def unphysical(model: Model, given: int, logs: Sequence[Log]) -> str:
    """What of a fitted model, `given` with so many effects, no machine that made the logs has; empty: nothing."""
    said = next((said for effect in model.effects[given:] if (said := at_end(effect, logs))), "")
    laws = [laws_of(effect) for effect in model.effects if "friction_level" in effect.HOOKS]
    if said or not laws:
        return said
    place = np.concatenate([np.quantile(log.position, np.linspace(0.0, 1.0, PLACES)) for log in logs])
    top = max(float(np.ptp(log.position)) / seconds_of_motion(log) for log in logs)
    x, v = np.tile(place, 2), np.repeat([-top, top], len(place))
    levels = np.array([law.friction_level_at(position=x, velocity=v) for law in laws])
    least = model.axis.coulomb + float(levels.sum(axis=0).min())
    if least < -PUSHES * moving_command(logs):
        return f"its friction falls to {least:.4g}: it would push the axis"
    return ""


def seconds_of_motion(log: Log) -> float:
    """Time in which the mean speed over some rows is above a hundredth of the largest."""
    step = max(1, len(log) // STEPS)
    steps, moved = np.diff(log.time[::step]), np.abs(np.diff(log.position[::step]))
    return float(steps[moved / steps > MOVES * float((moved / steps).max())].sum())


def moving_command(logs: Sequence[Log]) -> float:
    """The largest command under which the axis moved, V."""
    return max(float(np.abs(log.command[:-1] * (np.diff(log.position) != 0.0)).max()) for log in logs)


def obeyed_command(logs: Sequence[Log]) -> float:
    """The highest level beyond which commands still moved the axis, V; 0 where none is.

    At each level the acceleration is explained by the command up to it and by what is beyond, beside place, speed and
    direction: what is beyond a limit would do nothing. All is averaged over as many rows as show most of the command.
    """
    largest = max(float(np.abs(log.command).max()) for log in logs)
    rows = max(AVERAGED, key=lambda one: _weights(logs, one, np.inf)[2])
    for level in largest * np.linspace(1.0, 0.0, LEVELS, endpoint=False)[1:]:
        below, beyond, certain = _weights(logs, rows, float(level))
        if beyond > OBEYED * below > 0.0 and certain > CERTAIN:
            return float(level)
    return 0.0


def _weights(logs: Sequence[Log], rows: int, level: float) -> tuple[float, float, float]:
    """Acceleration per V of commands up to a level, and beyond it; and the latter's size over its deviation.

    For an infinite level the same of the whole command. The acceleration is the second difference of positions `rows`
    apart, which is that of the same triangular mean of whatever acts.
    """
    parts = [_balance(log, rows, level) for log in logs if len(log) > FEWEST * rows]
    if not parts:
        return 0.0, 0.0, 0.0
    table = np.concatenate(parts, axis=1)
    if np.count_nonzero(table[0]) < FEWEST:
        return 0.0, 0.0, 0.0
    size = np.sqrt(np.mean(table**2, axis=1))
    table = table[size > 0.0] / size[size > 0.0, None]
    if not size[0] or not size[-1]:
        return 0.0, 0.0, 0.0
    columns, acceleration = table[:-1], table[-1]
    inverse = np.linalg.pinv(columns @ columns.T, hermitian=True)
    weights = inverse @ (columns @ acceleration)
    left = acceleration - weights @ columns
    deviation = np.sqrt(inverse[0, 0] * float(left @ left) / max(len(left) - len(columns), 1))
    below = weights[1] / size[1] if np.isfinite(level) and size[1] else weights[0] / size[0]
    return float(below), float(weights[0] / size[0]), float(weights[0] / max(deviation, 1e-300))


def _balance(log: Log, rows: int, level: float) -> FloatArray:
    """Command beyond a level (of an infinite one the whole) and up to it, what is beside, and the acceleration."""
    from scipy.ndimage import uniform_filter1d

    up_to = np.clip(log.command, -level, level) if np.isfinite(level) else np.zeros(len(log))
    held = [0.5 * (one + np.append(one[:1], one[:-1])) for one in (log.command - up_to, up_to)]  # from row to row
    acts = [uniform_filter1d(uniform_filter1d(one, rows), rows)[::rows][1:-1] for one in held]
    x, step = log.position[::rows], rows * float(np.median(np.diff(log.time)))
    speed, place = 0.5 * (x[2:] - x[:-2]) / step, (x[1:-1] - np.mean(x)) / max(float(np.ptp(x)), 1e-300)
    beside = [np.ones(len(speed)), speed, np.sign(speed), place, place**2, place**3]
    return np.array([*acts, *beside, (x[2:] - 2.0 * x[1:-1] + x[:-2]) / step**2])
