"""The gains of a `pid` or `cascade`, in which its command is linear, by least squares on a log."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np

from cogging._core import replay_controller
from cogging.arrays import FloatArray, Mask, least_squares
from cogging.log_check.command_comparison import Compared, doubted_commands, root_mean_square
from cogging.log_check.controller_samples import Samples
from cogging.model.model import CONTROLLERS, Model


def linear_regressors(
    kind: str, controller: Any, motion: Mapping[str, FloatArray], position: FloatArray
) -> dict[str, FloatArray]:
    """What the gains of a `pid` or `cascade` multiply, (n,) each, by the gain's name (contract, [controller]).

    Each is what the controller itself commands with this gain at 1 and the others at 0, without a limit. A `cascade`
    has kv and `kp kv`, in which it is linear.
    """
    make = CONTROLLERS[kind][1]
    gains = {"pid": ("kp", "ki", "kd"), "cascade": ("kp", "kv")}[kind] + ("mass", "viscous", "coulomb")
    bare = controller.replace(**dict.fromkeys(gains, 0.0), command_limit=0.0)

    def command(**gain: float) -> FloatArray:
        return replay_controller(make(bare.replace(**gain)), **motion, position=position)

    columns = {name: command(**{name: 1.0}) for name in gains if (kind, name) != ("cascade", "kp")}
    if kind == "cascade":
        # So small a kv that its own term vanishes beside that of the error; of powers of two the product is exactly 1.
        columns = {"kp kv": command(kp=2.0**60, kv=2.0**-60), **columns}
    return columns


def fit_columns(columns: Mapping[str, FloatArray], target: FloatArray) -> tuple[dict[str, float], float]:
    """Coefficients of columns (n,) that fit a target, and the rms of what is left."""
    table = np.stack(list(columns.values()))
    solution = least_squares(table, target, rcond=1e-12)
    return dict(zip(columns, solution.tolist(), strict=True)), root_mean_square(target - solution @ table)


def fit_samples(
    samples: Samples, columns: Mapping[str, FloatArray], rows: Mask, integral: bool
) -> tuple[dict[str, float], float, Mask]:
    """Coefficients of columns (m,) that fit the commands of some rows, the rms of what is left, and rows that counted.

    With an `integral` the rows after each gap have a constant of their own. Commands that leave and return at once do
    not count where the fit does not.
    """
    target = samples.command
    if integral and samples.segment[-1]:
        target = samples.without_means(target, rows)
        columns = {name: samples.without_means(column, rows) for name, column in columns.items()}
    elif integral:
        columns = {**columns, "start": np.ones(len(target))}
    for _ in range(2):
        fitted, rms = fit_columns({name: column[rows] for name, column in columns.items()}, target[rows])
        made = np.asarray(sum(fitted[name] * column for name, column in columns.items()))
        doubted = doubted_commands(target, made, rows)
        if not doubted.any():
            break
        rows = rows & ~doubted
    fitted.pop("start", None)
    return fitted, rms, rows


def fit_gains(
    found: Compared, model: Model, regressors: Mapping[str, FloatArray]
) -> tuple[dict[str, float], dict[str, float], float]:
    """Stated gains, those that fit the log, and the rms that these leave; only gains that are stated above zero."""
    controller: Any = model.controller
    samples, rows = found.samples, found.judged
    gains = _stated_gains(controller, ("kp", *regressors))
    columns = {name: column for name, column in regressors.items() if gains[name] != 0.0}
    if controller.command_limit > 0.0:
        rows = rows & (np.abs(samples.command) < controller.command_limit * (1.0 - 1e-6))
    if not columns or rows.sum() <= 2 * len(columns):
        return {}, {}, float("nan")
    fitted, rms, _ = fit_samples(samples, columns, rows, gains.get("ki", 0.0) > 0.0)
    product = fitted.pop("kp kv", None)
    if product is not None:
        fitted = {"kp": product / fitted["kv"] if fitted.get("kv") else 0.0, **fitted}
    stated = {name: gains[name] for name in fitted}
    return stated, fitted, rms


def _stated_gains(controller: Any, names: tuple[str, ...]) -> dict[str, float]:
    return {
        name: controller.kp * controller.kv if name == "kp kv" else float(getattr(controller, name)) for name in names
    }
