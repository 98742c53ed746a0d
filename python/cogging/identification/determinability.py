"""What logs can tell about the parameters of a model, and what not: known before a fit, in words."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from cogging._core import DivergedError
from cogging.arrays import FloatArray, Mask
from cogging.estimation.gauss_newton import columns_of
from cogging.estimation.residuals import Residuals
from cogging.estimation.whitening import whitened
from cogging.identification.force_balance import ForceBalance, Simulator
from cogging.model.model import Model
from cogging.model.parameters import Parameter, Scales, effect_at, parameters_of, role_at

UNDETERMINED = 0.2  # 1-sigma, relative to the parameter's size, above which a log does not determine it
PARALLEL = 1e3  # by which the others inflate a variance; beyond, model errors are larger than what tells them apart
TRADE = 0.95  # correlation above which two parameters are said to trade against each other


@dataclass(frozen=True)
class Determinability:
    """What logs determine of some parameters.

    Attributes:
        paths: of the parameters.
        sigma: foreseen 1-sigma with all others free, relative to its size, (p,); infinite where no row shows it.
        in_balance: whether the force balance shows it, else only the output error may, (p,).
        notes: a sentence each.
    """

    paths: tuple[str, ...]
    sigma: FloatArray
    in_balance: tuple[bool, ...]
    notes: tuple[str, ...]

    def determined(self, path: str) -> bool:
        """Whether the logs determine the parameter at a path."""
        return bool(self.sigma[self.paths.index(path)] < UNDETERMINED)

    def seen_by_balance(self, path: str) -> bool:
        """Whether the force balance shows the parameter at a path."""
        return self.in_balance[self.paths.index(path)]


def determinability(
    model: Model,
    paths: Sequence[str],
    balances: Sequence[ForceBalance],
    scales: Scales,
    simulate: Sequence[Simulator | None],
    sources: Callable[[], Sequence[Residuals]] = tuple,
) -> Determinability:
    """What a linear fit from the model foresees.

    Where a simulated run is at hand, it alone counts as motion: what noise made of the measured one, shows nothing.

    Args:
        model: where to look.
        paths: of the parameters.
        balances: force balances of the logs.
        scales: of all of them.
        simulate: for each log, the noise-free run of a model, or None.
        sources: makes the output errors of the logs, asked where the force balance does not show a parameter.
    """
    known = parameters_of(model)
    parameters = [known[path] for path in paths]
    sizes = np.array([size_of(model, parameter, scales) for parameter in parameters])
    tables = _of_balances(model, parameters, balances, scales, simulate)
    dead = _dead(tables, sizes)
    deviation, correlation = foreseen(tables, dead)
    others = _of_outputs(model, parameters, sources, scales) if dead.any() else []
    if others:
        by_output, among = foreseen(others, _dead(others, sizes))
        deviation = np.where(dead, by_output, deviation)
        correlation = np.where(dead[:, None], among, correlation)
    sigma = deviation / sizes
    away = np.abs(correlation) * (1.0 - np.eye(len(paths)))
    while (drawn := (sigma < UNDETERMINED) & (away[:, sigma >= UNDETERMINED] > TRADE).any(axis=1)).any():
        sigma[drawn] = np.inf  # it would be found at whatever value suits the prior of what it trades against
    notes = []
    for i, parameter in enumerate(parameters):
        partner = int(np.argmax(away[i]))
        trades = parameters[partner] if away[i, partner] > TRADE else None
        notes.append(_sentence(model, parameter, float(sigma[i]), float(sizes[i]), trades, balances))
    return Determinability(tuple(paths), sigma, tuple(bool(not d) for d in dead), tuple(notes))


def size_of(model: Model, parameter: Parameter, scales: Scales) -> float:
    """Against what an error of the parameter is judged: itself, or what would do as much as the command."""
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


_Table = tuple[FloatArray, FloatArray, npt.NDArray[np.int64]]  # columns (p, n), residual (n,), block (n,) of a log


def _of_balances(
    model: Model,
    parameters: Sequence[Parameter],
    balances: Sequence[ForceBalance],
    scales: Scales,
    simulate: Sequence[Simulator | None],
) -> list[_Table]:
    """The force balances, along simulated runs where there are some, in units of the residual's rms."""
    tables = []
    for balance, run in zip(balances, simulate, strict=True):
        residual, columns = balance.columns(model, parameters, scales)
        shown = balance.instruments(model, parameters, scales, run)
        columns = columns if shown is None else shown
        rows = balance.mask
        weight = 1.0 / max(float(np.sqrt(np.mean(residual[rows] ** 2))), 1e-300)
        tables.append((weight * columns[:, rows], weight * residual[rows], balance.block[rows]))
    return tables


def _of_outputs(
    model: Model, parameters: Sequence[Parameter], sources: Callable[[], Sequence[Residuals]], scales: Scales
) -> list[_Table]:
    """The whitened output errors; none where the model cannot be run: nothing is seen then."""
    try:
        logs = sources()
        residuals, slopes = columns_of(model, parameters, logs, scales)
        seen = [whitened(log, r, c) for log, r, c in zip(logs, residuals, slopes, strict=True)]
    except (ValueError, DivergedError):
        return []
    if not all(np.isfinite(s.columns).all() and np.isfinite(s.residual).all() for s in seen):
        return []  # it ran away without end
    return [(s.columns, s.residual, s.block) for s in seen]


def _dead(tables: Sequence[_Table], sizes: FloatArray) -> Mask:
    """Which parameters move no row, (p,)."""
    power = sum((columns**2).sum(axis=1) for columns, _, _ in tables)
    rows = sum(columns.shape[1] for columns, _, _ in tables)
    return np.asarray(np.sqrt(power / rows) * sizes < 1e-9)


def foreseen(tables: Sequence[_Table], dead: Mask) -> tuple[FloatArray, FloatArray]:
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
    values = np.maximum(values, 1e-13)  # what rounding leaves of a direction that no row shows
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
    # A direction that hardly a row shows has hardly a score either, which would pass for knowledge.
    deviation[np.diag(inverse) > PARALLEL] = np.inf
    deviation[dead] = np.inf
    spread = np.sqrt(np.diag(inverse))
    return deviation, inverse / np.outer(spread, spread)


def _sentence(
    model: Model,
    parameter: Parameter,
    sigma: float,
    size: float,
    partner: Parameter | None,
    balances: Sequence[ForceBalance],
) -> str:
    name = _short(parameter)
    if sigma < UNDETERMINED:
        text = f"{name}: determined to "
        if size <= abs(parameter.value) * (1.0 + 1e-12):
            text += f"{100 * sigma:.2g} %"
        else:
            text += f"{sigma * size:.2g}" + (f" {parameter.unit}" if parameter.unit != "1" else "")
        return text + (f", in exchange with {_short(partner)}" if partner else "")
    if partner is None:
        return f"{name}: not determined, this motion hardly shows it"
    return f"{name}: not determined, trades against {_short(partner)}: {_span(model, (parameter, partner), balances)}"


def _short(parameter: Parameter) -> str:
    return parameter.path.removeprefix("axis.").removeprefix("effects.")


def _span(model: Model, pair: Sequence[Parameter], balances: Sequence[ForceBalance]) -> str:
    """The poverty of the motion that makes two parameters trade."""
    motions = [(b.dynamics.motion, b.mask) for b in balances]
    if any(p.path == "axis.mass" for p in pair):
        top = max(float(np.quantile(np.abs(m.acceleration[rows]), 0.99)) for m, rows in motions)
        return f"accelerations reach only {top:.2g} {model.units.of('m/s^2')}"
    velocity = np.concatenate([m.middle_velocity[rows] for m, rows in motions])
    if not 0.001 < np.mean(velocity > 0.0) < 0.999:
        return "the axis moves one way only"
    if all(_by_speed(model, p) for p in pair):
        low, high = np.quantile(np.abs(velocity), [0.02, 0.98])
        return f"speeds span only a factor {high / max(low, 1e-12):.2g}"
    low = min(float(m.position[rows].min()) for m, rows in motions)
    high = max(float(m.position[rows].max()) for m, rows in motions)
    return f"positions span only {low:.4g} to {high:.4g} {model.units.position}"


def _by_speed(model: Model, parameter: Parameter) -> bool:
    if parameter.path.startswith("axis."):
        return True
    if "m/s" in parameter.dimension:
        return True
    return parameter.path.startswith("effects.") and "friction_level" in effect_at(model, parameter.path).HOOKS
