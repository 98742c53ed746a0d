"""Gauss-Newton fits on whitened residuals, with jackknife errors that allow for remaining correlation."""

from __future__ import annotations

import contextlib
from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from cogging._core import DivergedError, whiten
from cogging.arrays import FloatArray
from cogging.estimation.innovations import Innovations
from cogging.estimation.residuals import HALVES, Residuals, Whitened, whitened
from cogging.estimation.statistics import SINGULAR, jackknife
from cogging.model.model import Model
from cogging.model.parameters import Parameter, Scales, central, parameters_of, with_values

TOLERANCE = 1e-3  # of the last step, in 1-sigma


class Estimate(NamedTuple):
    """The result of a fit."""

    paths: tuple[str, ...]  # the free parameters
    values: FloatArray  # (p,)
    covariance: FloatArray  # of the values, from leaving out blocks, (p, p)
    freedom: FloatArray  # degrees of freedom of each variance, (p,)
    cost: float  # sum over logs and rows of log rms of the whitened residual


def columns_of(
    model: Model, parameters: Sequence[Parameter], logs: Sequence[Residuals], scales: Scales
) -> tuple[list[FloatArray], list[FloatArray]]:
    """Residuals (n,) and their derivatives (p, n), one of each a log, by prediction or central differences of runs."""
    predicted = [log for log in logs if isinstance(log, Innovations)]
    if len(predicted) == len(logs):
        pairs = [log.columns(model, parameters, scales) for log in predicted]
        return [residual for residual, _ in pairs], [columns for _, columns in pairs]
    steps = [central(model, parameter, scales.step(parameter)) for parameter in parameters]
    models = [model, *(side for step in steps for side in (step.above, step.below))]
    spans = np.array([step.span for step in steps])
    residuals, columns = [], []
    for log in logs:
        table = log.of(models)
        residuals.append(table[0])
        columns.append((table[1::2] - table[2::2]) / spans[:, None])
    return residuals, columns


def fit(model: Model, paths: Sequence[str], logs: Sequence[Residuals], *, iterations: int) -> Estimate:
    """Least squares of the whitened residuals of all logs, by Gauss-Newton with step halving.

    The whitening filters are re-estimated in each iteration. DivergedError: the model diverges on a log.
    """
    scales = Scales.largest(log.scales for log in logs)
    done = 0
    while True:
        known = parameters_of(model, together=True)
        parameters = [known[path] for path in paths]
        residuals, columns = columns_of(model, parameters, logs, scales)
        seen = [whitened(log, r, c) for log, r, c in zip(logs, residuals, columns, strict=True)]
        with np.errstate(over="ignore", invalid="ignore"):
            curvature = np.asarray(sum(s.columns @ s.columns.T for s in seen))
            gradient = np.asarray(sum(s.columns @ s.residual for s in seen))
        bad = ~(np.isfinite(np.diag(curvature)) & np.isfinite(gradient))
        if bad.any():
            rule = "the change that it makes in the motion has no bound: the log is not of this model"
            raise DivergedError(f"{paths[int(np.argmax(bad))]}: {rule}")
        values = np.array([p.value for p in parameters])
        if done >= iterations or not paths:
            break
        size = np.sqrt(np.maximum(np.diag(curvature), 1e-300))
        scaled = curvature / np.outer(size, size)
        step = -np.linalg.pinv(scaled, rcond=SINGULAR, hermitian=True) @ (gradient / size) / size
        done += 1
        before = _cost(logs, residuals, seen)
        for length in HALVES:  # the longest step that lowers the cost under the same filters
            moves = {p.path: p.clipped(p.value + length * s) for p, s in zip(parameters, step, strict=True)}
            with contextlib.suppress(ValueError, DivergedError):
                moved = with_values(model, moves)
                after = _cost(logs, [log.of([moved])[0] for log in logs], seen)
                if np.isfinite(after) and after <= before:
                    model = moved
                    break
        else:
            length = 0.0
        deviation = np.sqrt(np.diag(np.linalg.pinv(scaled, hermitian=True))) / size
        if length == 0.0 or np.all(np.abs(length * step) < TOLERANCE * deviation + 1e-12 * np.abs(values)):
            iterations = done  # one more evaluation, at the final values
    cost = float(sum(len(w.residual) * np.log(w.rms) for w in seen))
    return Estimate(tuple(paths), values, *jackknife(seen), cost)


def _cost(logs: Sequence[Residuals], residuals: Sequence[FloatArray], seen: Sequence[Whitened]) -> float:
    """Sum over logs and rows of the log mean square of residuals under the filters of `seen`."""
    total = 0.0
    for log, residual, one in zip(logs, residuals, seen, strict=True):
        white = np.asarray(whiten(residual[None, :], list(one.coefficients)))[0, log.mask > 0]
        with np.errstate(over="ignore", invalid="ignore"):  # a step too long has infinite cost
            total += len(white) * float(np.log(np.mean(white**2)))
    return total
