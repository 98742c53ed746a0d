"""Bounds that the logs set on effects, and the check of a fitted effect against them."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np

from cogging.arrays import FloatArray
from cogging.effects.effect import Effect, laws_of
from cogging.logs.log import Log
from cogging.model.model import Model

PERIODS = 3.0  # minimum periods of a tone or a resonance in the time of motion; fewer are a drift
LEVELS = 20  # levels at which the command beyond is tested for an effect
AVERAGED = (1, 2, 4, 8, 16, 32)  # rows over which commands and readings are averaged
FEWEST = 40  # minimum number of averaged rows in a log
OBEYED = 0.5  # minimum gain of the command beyond a level, relative to the gain below it
CERTAIN = 8.0  # minimum standard deviations of that gain
REACHED = 0.01  # of the force of an effect: less within the motion says nothing about it
AT_END = 1e-3  # relative distance at which a parameter is at a bound
PLACES = 60  # positions at which the level of friction is checked
PUSHES = 0.02  # of the largest command: tolerance of a negative friction level
STEPS, MOVES = 2000, 0.01  # intervals of a log; minimum share of the largest mean speed in an interval of motion


def fields_with_role(effect: Effect, kind: str) -> list[str]:
    """Return the fields of an effect with a role: "amplitude", "shape" or "setting"."""
    return [field for field, role in effect.ROLES.items() if role["role"] == kind]


def ends(logs: Sequence[Log], role: Mapping[str, Any]) -> tuple[float, float]:
    """Return the lowest and highest value that logs allow a parameter with a role (see cogging.effects, ROLES).

    A resonance or tone has at least PERIODS periods in the time of motion, and a resonance is damped less than its
    effect allows; a command limit exceeds every command that was obeyed; friction is below the largest command that
    moved the axis.
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
    """Return a clause that names a parameter of a fitted effect at a bound set by the logs; empty without one."""
    for name, role in effect.ROLES.items():
        if role["role"] == "setting":
            continue
        least, most = ends(logs, role)
        values = np.ravel(np.asarray(getattr(effect, name), dtype=float))
        for value, end, room in ((values.min(initial=np.inf), least, 1.0), (values.max(initial=-np.inf), most, -1.0)):
            if np.isfinite(end) and room * (value - end) <= AT_END * abs(end):
                return f"its {name} is {value:.4g}, at the bound that these logs set"
    return ""


def out_of_reach(effect: Effect, logs: Sequence[Log]) -> str:
    """Return a clause on an effect of which the logs reach only a hundredth of its force or less; else empty."""
    sizes = [np.ravel(getattr(effect, name)) for name, role in effect.ROLES.items() if role["quantity"] == "force"]
    if "force" not in effect.HOOKS or not sizes:
        return ""
    size, reached = float(np.max(np.abs(np.concatenate(sizes)))), 0.0
    for log in logs:
        rows = {"position": log.position, "velocity": np.gradient(log.position, log.time), "time": log.time}
        reached = max(reached, float(np.max(np.abs(laws_of(effect).force_at(**rows)))))
    return f"its force is {size:.4g}, of which the motion reaches {reached:.4g}" if reached < REACHED * size else ""


def unphysical(model: Model, given: int, logs: Sequence[Log]) -> str:
    """Return a clause on what is unphysical in a fitted model; empty if nothing is.

    Args:
        model: fitted model.
        given: number of its effects that were given.
        logs: logs that it was fitted to.
    """
    new = model.effects[given:]
    reason = next((reason for effect in new if (reason := at_end(effect, logs) or out_of_reach(effect, logs))), "")
    laws = [laws_of(effect) for effect in model.effects if "friction_level" in effect.HOOKS]
    if reason or not laws:
        return reason
    place = np.concatenate([np.quantile(log.position, np.linspace(0.0, 1.0, PLACES)) for log in logs])
    top = max(float(np.ptp(log.position)) / seconds_of_motion(log) for log in logs)
    x, v = np.tile(place, 2), np.repeat([-top, top], len(place))
    levels = np.array([law.friction_level_at(position=x, velocity=v) for law in laws])
    least = model.axis.coulomb + float(levels.sum(axis=0).min())
    if least < -PUSHES * moving_command(logs):
        return f"its friction falls to {least:.4g}: it would push the axis"
    return ""


def seconds_of_motion(log: Log) -> float:
    """Return the time (s) in which the mean speed of an interval exceeds a hundredth of the largest."""
    step = max(1, len(log) // STEPS)
    steps, moved = np.diff(log.time[::step]), np.abs(np.diff(log.position[::step]))
    return float(steps[moved / steps > MOVES * float((moved / steps).max())].sum())


def moving_command(logs: Sequence[Log]) -> float:
    """Return the largest command under which the axis moved, V."""
    return max(float(np.abs(log.command[:-1] * (np.diff(log.position) != 0.0)).max()) for log in logs)


def obeyed_command(logs: Sequence[Log]) -> float:
    """Return the highest level beyond which the command still accelerates the axis, V; 0 without one.

    At each level the acceleration is regressed on the command up to the level, the command beyond it, position, speed
    and direction; beyond a saturation the gain would be zero. The averaging is the one that shows the command best.
    """
    largest = max(float(np.abs(log.command).max()) for log in logs)
    rows = max(AVERAGED, key=lambda one: _fit_gains(logs, one, np.inf)[2])
    for level in largest * np.linspace(1.0, 0.0, LEVELS, endpoint=False)[1:]:
        below, beyond, certain = _fit_gains(logs, rows, float(level))
        if beyond > OBEYED * below > 0.0 and certain > CERTAIN:
            return float(level)
    return 0.0


def _fit_gains(logs: Sequence[Log], rows: int, level: float) -> tuple[float, float, float]:
    """Return acceleration per V of the command up to a level and beyond it, and the latter over its deviation.

    An infinite level gives the gain of the whole command. The acceleration is the second difference of positions
    `rows` apart, which equals the triangular mean of the acceleration.
    """
    parts = [_regression_rows(log, rows, level) for log in logs if len(log) > FEWEST * rows]
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


def _regression_rows(log: Log, rows: int, level: float) -> FloatArray:
    """Return the command beyond a level and up to it, the other regressors and the acceleration, averaged."""
    from scipy.ndimage import uniform_filter1d

    up_to = np.clip(log.command, -level, level) if np.isfinite(level) else np.zeros(len(log))
    held = [0.5 * (one + np.append(one[:1], one[:-1])) for one in (log.command - up_to, up_to)]  # from row to row
    acts = [uniform_filter1d(uniform_filter1d(one, rows), rows)[::rows][1:-1] for one in held]
    x, step = log.position[::rows], rows * float(np.median(np.diff(log.time)))
    speed, place = 0.5 * (x[2:] - x[:-2]) / step, (x[1:-1] - np.mean(x)) / max(float(np.ptp(x)), 1e-300)
    beside = [np.ones(len(speed)), speed, np.sign(speed), place, place**2, place**3]
    return np.array([*acts, *beside, (x[2:] - 2.0 * x[1:-1] + x[:-2]) / step**2])
