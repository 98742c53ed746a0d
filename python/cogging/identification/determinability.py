"""Which parameters of a model the logs determine, predicted before the fit."""

from __future__ import annotations

import re
from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np

from cogging._core import DivergedError
from cogging.arrays import FloatArray, IntArray, Mask
from cogging.estimation.force_balance import ForceBalance
from cogging.estimation.gauss_newton import columns_of
from cogging.estimation.residuals import Residuals, whitened
from cogging.model.model import Model
from cogging.model.parameters import Parameter, Scales, effect_at, parameters_of, role_at

UNDETERMINED = 0.2  # relative 1-sigma above which a parameter is not determined
PARALLEL = 1e3  # variance inflation beyond which model errors exceed the difference between collinear parameters
TRADE = 0.95  # correlation above which two parameters trade against each other
_Table = tuple[FloatArray, FloatArray, IntArray]  # columns (p, n), residual (n,), block (n,) of a log
Sources = Callable[[], Sequence[Residuals]]  # makes the output errors of logs


@dataclass(frozen=True)
class Determinability:
    """Which parameters the logs determine."""

    sigma: dict[str, float]  # by path: predicted 1-sigma, all others free, over the size; infinite if no row shows it
    in_balance: dict[str, bool]  # by path: whether the force balance depends on it, else only the output error may
    notes: dict[str, str]  # by path: a sentence

    def determined(self, path: str) -> bool:
        """Whether the logs determine the parameter at a path."""
        return self.sigma[path] < UNDETERMINED

    @property
    def classes(self) -> list[tuple[bool, bool]]:
        """Whether each parameter is determined, and in the force balance."""
        return [(self.determined(path), self.in_balance[path]) for path in self.sigma]


def determinability(
    model: Model, paths: Sequence[str], balances: Sequence[ForceBalance], scales: Scales, sources: Sources = tuple
) -> Determinability:
    """Predict from a linearised fit which parameters the logs determine.

    Where a log can be simulated its noise-free motion is used: noise in the measured motion is no excitation.
    `sources` makes the output errors of the logs, used where the force balance does not depend on a parameter.
    """
    known = parameters_of(model)
    parameters = [known[path] for path in paths]
    sizes = np.array([size_of(model, parameter, scales) for parameter in parameters])

    def without_effect(tables: Sequence[_Table]) -> Mask:
        """Which parameters change no row, (p,)."""
        power = sum((columns**2).sum(axis=1) for columns, _, _ in tables)
        return np.asarray(np.sqrt(power / sum(columns.shape[1] for columns, _, _ in tables)) * sizes < 1e-9)

    tables: list[_Table] = []
    for balance in balances:
        residual, columns = balance.columns(model, parameters, scales)
        simulated = balance.instruments(model, parameters, scales)
        columns = columns if simulated is None else simulated
        rows = balance.mask
        weight = 1.0 / max(float(np.sqrt(np.mean(residual[rows] ** 2))), 1e-300)
        tables.append((weight * columns[:, rows], weight * residual[rows], balance.block[rows]))
    dead = without_effect(tables)
    deviation, correlation = predicted_errors(tables, dead)
    others: list[_Table] = []
    try:
        logs = sources() if dead.any() else ()
        pairs = zip(logs, *columns_of(model, parameters, logs, scales), strict=True) if logs else ()
        seen = [whitened(log, residual, columns) for log, residual, columns in pairs]
        if all(np.isfinite(s.columns).all() and np.isfinite(s.residual).all() for s in seen):
            others = [(s.columns, s.residual, s.block) for s in seen]
    except (ValueError, DivergedError):  # the model cannot be run
        pass
    if others:
        by_output, among = predicted_errors(others, without_effect(others))
        deviation = np.where(dead, by_output, deviation)
        correlation = np.where(dead[:, None], among, correlation)
    sigma = deviation / sizes
    away = np.abs(correlation) * (1.0 - np.eye(len(paths)))
    while (drawn := (sigma < UNDETERMINED) & (away[:, sigma >= UNDETERMINED] > TRADE).any(axis=1)).any():
        sigma[drawn] = np.inf  # its estimate would follow the prior of the parameter it trades against
    notes, names = {}, [re.sub(r"^(axis|effects)\.", "", path) for path in paths]
    for i, parameter in enumerate(parameters):
        k = int(np.argmax(away[i]))
        other = names[k] if away[i, k] > TRADE else ""
        if sigma[i] < UNDETERMINED:
            unit = f" {parameter.unit}" if parameter.unit != "1" else ""
            is_relative = sizes[i] <= abs(parameter.value) * (1.0 + 1e-12)
            to = f"{100 * sigma[i]:.2g} %" if is_relative else f"{sigma[i] * sizes[i]:.2g}{unit}"
            said = f"determined to {to}" + (f", in exchange with {other}" if other else "")
        elif other:
            said = f"not determined, trades against {other}: {_span(model, (parameter, parameters[k]), balances)}"
        else:
            said = "not determined, this motion hardly shows it"
        notes[parameter.path] = f"{names[i]}: {said}"
    in_balance = dict(zip(paths, (~dead).tolist(), strict=True))
    return Determinability(dict(zip(paths, sigma.tolist(), strict=True)), in_balance, notes)


def size_of(model: Model, parameter: Parameter, scales: Scales) -> float:
    """The size that an error of the parameter is relative to: its value, or what equals the command in effect."""
    value = abs(parameter.value)
    if parameter.path.startswith("effects."):
        role = role_at(model, parameter.path)
        if role["logarithmic"] and value > 0.0:
            return value
        if role["quantity"] == "sample_time":
            return max(value, scales.sample_time)
        if role["quantity"] == "distance" and role["role"] == "amplitude":  # of an encoder's error
            return max(value, 1e-3 * scales.position)
        if role["quantity"] == "friction":
            return max(value, model.axis.coulomb) or scales.force
    elif parameter.positive and value > 0.0:
        return value
    return max(value, scales.of(parameter.dimension))


def predicted_errors(tables: Sequence[_Table], dead: Mask) -> tuple[FloatArray, FloatArray]:
    """1-sigma (p,) of a linear fit, by a sandwich over blocks, and correlation (p, p) of its parameters."""
    p = len(dead)
    curvature, right = np.zeros((p, p)), np.zeros(p)
    for columns, residual, _ in tables:
        curvature += columns @ columns.T
        right += columns @ residual
    size = np.sqrt(np.diag(curvature)).copy()
    size[dead] = 1.0
    scaled = curvature / np.outer(size, size)
    scaled[dead, :] = scaled[:, dead] = 0.0
    scaled[dead, dead] = 1.0
    values, vectors = np.linalg.eigh(scaled)
    values = np.maximum(values, 1e-13)  # rounding, in a direction that no row depends on
    inverse = (vectors / values) @ vectors.T
    step = -inverse @ np.where(dead, 0.0, right / size)
    meat, blocks = np.zeros((p, p)), 0
    for columns, residual, block in tables:
        starts = np.flatnonzero(np.diff(block, prepend=-1))
        scores = np.add.reduceat(columns / size[:, None] * (residual + (step / size) @ columns), starts, axis=1)
        scores[dead] = 0.0
        meat += scores @ scores.T
        blocks += len(starts)
    covariance = inverse @ meat @ inverse * blocks / max(blocks - p, 1)
    deviation = np.sqrt(np.maximum(np.diag(covariance), 0.0)) / size
    # A direction with hardly any effect has hardly any score either, which must not pass for certainty.
    deviation[np.diag(inverse) > PARALLEL] = np.inf
    deviation[dead] = np.inf
    spread = np.sqrt(np.diag(inverse))
    return deviation, inverse / np.outer(spread, spread)


def _span(model: Model, pair: Sequence[Parameter], balances: Sequence[ForceBalance]) -> str:
    """What the motion lacks, so that two parameters trade against each other."""
    motions = [(b.motion, b.mask) for b in balances]
    if any(p.path == "axis.mass" for p in pair):
        top = max(float(np.quantile(np.abs(m.acceleration[rows]), 0.99)) for m, rows in motions)
        return f"accelerations reach only {top:.2g} {model.units.of('m/s^2')}"
    velocity = np.concatenate([m.middle_velocity[rows] for m, rows in motions])
    if not 0.001 < np.mean(velocity > 0.0) < 0.999:
        return "the axis moves one way only"
    by_speed = (
        p.path.startswith("axis.")
        or "m/s" in p.dimension
        or (p.path.startswith("effects.") and "friction_level" in effect_at(model, p.path).HOOKS)
        for p in pair
    )
    if all(by_speed):
        low, high = np.quantile(np.abs(velocity), [0.02, 0.98])
        return f"speeds span only a factor {high / max(low, 1e-12):.2g}"
    low = min(float(m.position[rows].min()) for m, rows in motions)
    high = max(float(m.position[rows].max()) for m, rows in motions)
    return f"positions span only {low:.4g} to {high:.4g} {model.units.position}"
