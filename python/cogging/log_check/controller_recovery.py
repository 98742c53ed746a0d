"""Recover the controller that made a log where none is stated."""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import NamedTuple

import numpy as np

from cogging._core import CascadeParameters, PidParameters, smooth_sign
from cogging.arrays import FloatArray, Mask
from cogging.calls import check_arguments
from cogging.log_check.controller_check import Columns, fit_columns, fit_samples, linear_regressors, root_mean_square
from cogging.log_check.controller_samples import Samples
from cogging.logs.log import Log
from cogging.logs.spikes import spikes
from cogging.model.units import Units
from cogging.resources import on_one_blas_thread
from cogging.simulation.arguments import LOG
from cogging.values import line_of

ACCEPTED = 0.005  # of the rms command: largest residual of the right controller type
FEWEST_ROWS = 200
SEARCHED = 5000  # evenly spaced rows used to search the width
WIDTHS = 25  # of the friction compensation tried
NEGLIGIBLE = 1e-3  # of the rms command: contribution below which a gain is set to zero


class RecoveredController(NamedTuple):
    """Type and parameters of a controller that reproduces a log's command, and the rms residual, V.

    `units` are the labels of the log's units.
    """

    type: str
    parameters: PidParameters | CascadeParameters
    residual_rms: float
    units: Units = Units()

    def __repr__(self) -> str:
        left = f"{self.residual_rms:.3g} {self.units.command} rms"
        return f"RecoveredController({line_of(self.parameters, self.units.of)}, leaves {left})"


@check_arguments(log=LOG)
@on_one_blas_thread(scipy=True)
def recover_controller(log: Log) -> RecoveredController | None:
    """Find the `cascade` or `pid` that made a log's command, or None if neither did.

    Least squares of the command on the regressors of the gains: error, its sum and backward difference
    (`pid`), or error and the reading's backward difference (`cascade`), with the reference's derivatives and S(v) of a
    width that is searched for. Accepted if the residual is at most 0.5 % of the rms command and no gain is negative;
    gains that contribute less than 0.1 % are set to zero. The simpler of two equal fits is returned. Missing rows and
    spikes are handled as in check_controller.

    Args:
        log: with a reference, of at least 200 rows.

    Returns:
        Type and parameters of the controller, or None.

    Example:
        >>> found = cogging.recover_controller(log)
        >>> print(f"{found.type}, kp {found.parameters.kp:.0f} V/m")
        pid, kp 9600 V/m
    """
    if log.reference is None or len(log) < FEWEST_ROWS:
        return None
    found = _recovered(log, log.reference, np.zeros(len(log), dtype=bool))
    unseen = spikes(log.position - log.reference)
    return _recovered(log, log.reference, unseen) if found is None and unseen.any() else found


def _recovered(log: Log, reference: FloatArray, unseen: Mask) -> RecoveredController | None:
    """The controller of a log, without some of its readings."""
    step = float(np.median(np.diff(log.time)))
    rate = float(f"{1.0 / step:.6g}")  # the precision of a time column
    samples = Samples.of(log, reference, 1.0 / step, unseen)
    top = float(np.abs(log.command).max())
    at_top = np.abs(log.command) >= top * (1.0 - 1e-9)
    cut = bool((at_top[:-2] & at_top[1:-1] & at_top[2:]).any()) and float(np.ptp(log.command)) > 0.0
    limit, free = (top, ~at_top) if cut else (0.0, np.ones(len(log), dtype=bool))
    free[0] = False
    rows, command_rms = free[samples.row] & samples.judged((0, 1)), root_mean_square(samples.command[samples.known])
    if rows.sum() < FEWEST_ROWS // 2 or command_rms == 0.0:
        return None
    found: list[tuple[int, RecoveredController]] = []
    for kind, struct in (("cascade", CascadeParameters), ("pid", PidParameters)):
        for velocity in ("reference", "measured"):
            base = struct(sample_rate=rate, feedforward_velocity=velocity)
            gains, rms = _fit(kind, base, samples, rows, command_rms) or ({}, math.inf)
            if rms > ACCEPTED * command_rms:
                continue
            if "kp kv" in gains:
                gains["kp"] = gains.pop("kp kv") / gains["kv"]
            recovered = RecoveredController(kind, base.replace(**gains, command_limit=limit), rms, log.units)
            found.append((sum(value != 0.0 for value in gains.values()), recovered))
    smallest = min((recovered.residual_rms for _, recovered in found), default=0.0)
    alike = [entry for entry in found if entry[1].residual_rms <= 1.05 * smallest + 1e-9 * command_rms]
    return min(alike, key=lambda entry: entry[0])[1] if alike else None


def _fit(
    kind: str, base: PidParameters | CascadeParameters, samples: Samples, rows: Mask, command_rms: float
) -> tuple[dict[str, float], float] | None:
    """Gains by name, with the width of S(v), and the rms residual; None if one is negative."""
    fixed = linear_regressors(kind, base, samples)
    believed = fit_samples(samples, fixed, rows, "ki" in fixed)[2]
    if believed.sum() < rows.sum():
        command_rms = root_mean_square(samples.command[believed])
    is_apart = "ki" in fixed and bool(samples.segment[-1])  # after each gap the integral is another constant

    def of_rows(column: FloatArray) -> FloatArray:
        return (samples.without_means(column, believed) if is_apart else column)[believed]

    known, command = {name: of_rows(column) for name, column in fixed.items()}, of_rows(samples.command)

    def solve(names: set[str], width: float, every: int = 1) -> tuple[dict[str, float], float, Columns]:
        """Gains of these names, the rms residual, and their columns, on every `every`-th row."""
        columns = {name: column[::every] for name, column in known.items() if name in names}
        if "coulomb" in columns:
            columns["coulomb"] = of_rows(smooth_sign(fixed["viscous"], width))[::every]
        if "ki" in columns and not is_apart:
            columns["start"] = np.ones(len(columns["ki"]))
        return (*fit_columns(columns, command[::every]), columns)

    every = 1 + command.size // SEARCHED
    width = _best_width(lambda width: solve(set(known), width, every)[1], fixed["viscous"][believed])
    names, useless = set(known), {""}
    for _ in range(6):  # without negligible and negative gains
        gains, rms, columns = solve(names, width)
        gains.pop("start", None)
        sizes = {name: gain * float(np.sqrt(np.mean(columns[name] ** 2))) for name, gain in gains.items()}
        useless = {name for name, size in sizes.items() if size < NEGLIGIBLE * command_rms}
        if not useless or not (set(gains) - useless):
            break
        names = set(gains) - useless
    needed = {"cascade": {"kp kv", "kv"}, "pid": {"kp"}}[kind]
    if not needed <= set(gains) or any(gain < 0.0 for gain in gains.values()) or not (set(gains) - useless):
        return None
    if "coulomb" in gains:
        gains["coulomb_width"] = width
    return gains, rms


def _best_width(cost: Callable[[float], float], velocity: FloatArray) -> float:
    """The width of S(v), m/s, of least cost; 0 for sgn(v)."""
    from scipy.optimize import minimize_scalar

    top = float(np.abs(velocity).max())
    widths = [0.0, *np.geomspace(1e-4 * top, 0.5 * top, WIDTHS).tolist()] if top > 0.0 else [0.0]
    width = min(widths, key=cost)
    if width == 0.0:
        return width
    options = {"bounds": (-0.4, 0.4), "method": "bounded", "options": {"xatol": 1e-9}}
    return width * math.exp(float(minimize_scalar(lambda shift: cost(width * math.exp(shift)), **options).x))
