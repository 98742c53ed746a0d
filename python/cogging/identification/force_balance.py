"""Inverse dynamics with instruments: the parameters at which the filtered force balance closes.

The idea of IDIM-IV (Janot, Vandanjon, Gautier 2014): the force that the model needs along the measured motion is
compared with the force that was applied, both through one low-pass filter; the instruments are the same columns along
a simulated, noise-free run, so that noise in the measured motion and command does not bias the fit.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from cogging._core import DivergedError
from cogging.arrays import FloatArray, Mask
from cogging.estimation.jackknife import shares_of_blocks, spread_of
from cogging.estimation.rows_in_motion import START
from cogging.identification.inverse_dynamics import InverseDynamics
from cogging.logs.log import Log
from cogging.model.model import Model
from cogging.model.parameters import Parameter, Scales, central, parameters_of, with_values

Simulator = Callable[[Model], Log]  # the noise-free run of a model, at a log's times

TOLERANCE = 1e-6  # of a value, by which the last step moves it
REST = 0.02  # of the largest speed: slower rows do not count
GAP = 2.5  # median steps: over longer ones nothing is bridged
NARROW = 0.05  # of the slowest rows that count: narrower friction is the same to them, to 3 % and less


@dataclass(frozen=True)
class ForceBalance:
    """One log's force balance: what the fit looks at.

    Attributes:
        log: measured.
        dynamics: its filtered force balance.
        mask: rows in motion, away from the ends and from gaps, (n,).
        block: number of the block of each row, (n,).
        scales: sizes of the log.
        rest: slower rows do not count, m/s.
    """

    log: Log
    dynamics: InverseDynamics
    mask: Mask
    block: npt.NDArray[np.int64]
    scales: Scales
    rest: float

    @classmethod
    def of(cls, log: Log, *, cutoff: float, rest: float | None = None, hold: float | None = None) -> ForceBalance:
        """Filter a log's motion; rows slower than `rest` (m/s; None: 2 % of the largest speed) do not count.

        `hold`: see InverseDynamics.
        """
        dynamics = InverseDynamics(log, cutoff=cutoff, hold=hold)
        motion, even = dynamics.motion, dynamics.even
        edge = max(START, 0.5 / cutoff)
        mask = (even >= even[0] + edge) & (even <= even[-1] - edge)
        moved = np.ones(len(even), dtype=bool)  # by the axis, not by a line across a pause that was cut
        for k in np.flatnonzero(np.diff(log.time) > GAP * dynamics.sample_time):
            # What is interpolated across the gap passes through the filter to its neighbours: its memory is left out.
            first, last = np.searchsorted(even, [log.time[k] - 2.0 / cutoff, log.time[k + 1] + 2.0 / cutoff])
            mask[first:last] = False
            if dynamics.pauses:
                moved[first:last] = False
        if not moved.any():
            moved[:] = True
        scales = Scales(
            force=float(np.sqrt(np.mean(log.command**2))) or 1.0,
            position=float(np.ptp(log.position)) or 1.0,
            velocity=float(np.abs(motion.middle_velocity[moved]).max()) or 1.0,
            acceleration=float(np.quantile(np.abs(motion.acceleration[moved]), 0.99)) or 1.0,
            time=float(log.time[-1] - log.time[0]),
            sample_time=dynamics.sample_time,
        )
        rest = REST * scales.velocity if rest is None else rest
        mask &= np.abs(motion.middle_velocity) > rest
        block = np.floor((even - even[0]) / max(0.2, 4.0 / cutoff)).astype(np.int64)
        return cls(log, dynamics, mask, block, scales, rest)

    def columns(
        self, model: Model, parameters: Sequence[Parameter], scales: Scales, dynamics: InverseDynamics | None = None
    ) -> tuple[FloatArray, FloatArray]:
        """Residual (n,) and derivatives (p, n), V, of the rows of this motion or another.

        Raises:
            ValueError: a parameter that no step may move.
        """
        steps = [central(model, parameter, scales.step(parameter)) for parameter in parameters]
        return (self.dynamics if dynamics is None else dynamics).columns(model, steps)

    def along(self, model: Model, run: Simulator | None) -> InverseDynamics | None:
        """The force balance along a simulated run; None where there is none, or the model cannot be run."""
        if run is None:
            return None
        try:
            simulated = run(model)
        except (DivergedError, ValueError):  # such as friction too steep for any step, of a mass that all but went
            return None
        return InverseDynamics(simulated, cutoff=self.dynamics.cutoff, hold=self.dynamics.hold)

    def instruments(
        self, model: Model, parameters: Sequence[Parameter], scales: Scales, run: Simulator | None
    ) -> FloatArray | None:
        """The derivatives (p, n) along a simulated run, V; None where there is none, or the model cannot be run."""
        dynamics = self.along(model, run)
        return None if dynamics is None else self.columns(model, parameters, scales, dynamics)[1]

    def residual_rms(self, model: Model) -> float:
        """Rms of the balance over the rows that count, V."""
        return float(np.sqrt(np.mean(self.dynamics.of([model])[0, self.mask] ** 2)))


@dataclass(frozen=True)
class BalanceEstimate:
    """What the fit of the force balance found.

    Attributes:
        values: (p,).
        covariance: jackknife over blocks, and what the prior leaves open, (p, p).
        freedom: degrees of freedom of each variance, (p,): few where few blocks tell.
        model: with the values.
        residual_rms: V, one a log, rows in motion, below the cut-off.
        instruments: whether simulated instruments were used in all logs.
    """

    values: FloatArray
    covariance: FloatArray
    freedom: FloatArray
    model: Model
    residual_rms: tuple[float, ...]
    instruments: bool


@dataclass(frozen=True)
class _Equations:
    """Z^T r = 0 of all logs, linearised.

    Attributes:
        bread: Z^T d r / d parameter, with the prior's share, (p, p).
        right: Z^T r, likewise, (p,).
        parts: instruments (p, n), columns (p, n), residual (n,) and weight of each log, rows that count.
        instruments: whether all logs have simulated ones.
    """

    bread: FloatArray
    right: FloatArray
    parts: list[tuple[FloatArray, FloatArray, FloatArray, float]]
    instruments: bool

    def solved(self, right: FloatArray, bread: FloatArray | None = None) -> FloatArray:
        """bread^-1 right, scaled so that units do not matter."""
        size = np.sqrt(np.maximum(np.abs(np.diag(self.bread)), 1e-300))
        scaled = (self.bread if bread is None else bread) / np.outer(size, size)
        solution: FloatArray = np.linalg.lstsq(scaled, (right.T / size).T, rcond=1e-12)[0]
        return np.asarray((solution.T / size).T)

    def step(self, lowest: FloatArray) -> FloatArray:
        """Newton step (p,), none of it below `lowest` (p,): what would be ends there, and the others allow for that."""
        held = np.zeros(len(self.right), dtype=bool)
        while True:
            bread = np.where(held | held[:, None], np.diag(np.diag(self.bread)), self.bread)
            right = self.right + np.where(held, 0.0, self.bread[:, held] @ lowest[held])
            step = np.where(held, lowest, -self.solved(right, bread))
            beyond = ~held & (step < lowest)
            if not beyond.any():
                return step
            held |= beyond


def fit_force_balance(
    model: Model,
    paths: Sequence[str],
    balances: Sequence[ForceBalance],
    scales: Scales,
    simulate: Sequence[Simulator | None],
    *,
    loose: FloatArray | None = None,
    iterations: int = 12,
) -> BalanceEstimate:
    """Instrumental variables, Z^T r = 0, by Newton steps; least squares where no run can be simulated.

    Args:
        model: where to start.
        paths: of the free parameters.
        balances: the logs.
        scales: for the difference steps.
        simulate: for each log, the noise-free run of a model at the log's times, or None.
        loose: 1-sigma about its start that is assumed of each parameter, (p,); infinite: none. With it, parameters that
            the logs hardly determine stay where the others need them, and the covariance tells what that costs.
        iterations: at most.
    """
    if not paths:
        rms = tuple(balance.residual_rms(model) for balance in balances)
        return BalanceEstimate(np.empty(0), np.empty((0, 0)), np.empty(0), model, rms, False)
    prior = np.array([parameters_of(model)[path].value for path in paths])
    weight = np.zeros(len(paths)) if loose is None else 1.0 / np.asarray(loose) ** 2
    problem = (paths, balances, scales)
    if any(simulate):  # first near, by steps that cannot be led astray by a run that is far from the log's
        model = _newton(model, *problem, [None] * len(balances), weight, prior, iterations)
    model = _newton(model, *problem, simulate, weight, prior, iterations)
    values = np.array([parameters_of(model)[path].value for path in paths])
    equations = _equations(model, paths, balances, scales, simulate, weight, weight * (values - prior))
    covariance, freedom = _spread(equations, balances)
    open_by_prior = equations.solved(equations.solved(np.diag(weight)).T)
    rms = tuple(float(np.sqrt(np.mean(r**2))) for _, _, r, _ in equations.parts)
    return BalanceEstimate(values, covariance + open_by_prior, freedom, model, rms, equations.instruments)


def _newton(
    model: Model,
    paths: Sequence[str],
    balances: Sequence[ForceBalance],
    scales: Scales,
    simulate: Sequence[Simulator | None],
    weight: FloatArray,
    prior: FloatArray,
    iterations: int,
) -> Model:
    """The model after Newton steps towards Z^T r = 0, halved while they raise the residual."""
    cost = _cost(model, balances)
    narrow = min(model.axis.coulomb_width, NARROW * min(balance.rest for balance in balances))
    for _ in range(iterations):
        known = parameters_of(model)
        values = np.array([known[path].value for path in paths])
        equations = _equations(model, paths, balances, scales, simulate, weight, weight * (values - prior))
        lowest = {path: known[path].clipped(-np.inf) for path in paths}
        if "axis.coulomb_width" in lowest:
            lowest["axis.coulomb_width"] = max(lowest["axis.coulomb_width"], narrow)
        step = equations.step(np.array(list(lowest.values())) - values)
        length, moved = 1.0, None
        while length > 1e-3:
            try:
                wanted = zip(paths, values + length * step, strict=True)
                trial = with_values(model, dict(wanted))
                trial_cost = _cost(trial, balances)
            except ValueError:
                length *= 0.5
                continue
            if trial_cost <= 1.02 * cost:  # instruments may leave a little more than least squares
                moved, cost = trial, trial_cost
                break
            length *= 0.5
        if moved is None:
            break
        model = moved
        small = np.array([scales.of(known[path].dimension) for path in paths])
        if np.all(np.abs(step) <= TOLERANCE * (np.abs(values) + 1e-3 * small)):
            break
    return model


def _spread(equations: _Equations, balances: Sequence[ForceBalance]) -> tuple[FloatArray, FloatArray]:
    """Covariance (p, p) from leaving out one block after the other, and its degrees of freedom (p,).

    A sandwich alone is too sure of a parameter that a few blocks show (mass, in a log with few hard accelerations):
    there the fit follows what it is judged by.
    """
    shifts = []
    for balance, (z, columns, residual, weight) in zip(balances, equations.parts, strict=True):
        for bread, right in shares_of_blocks(weight * z, columns, residual, balance.block[balance.mask]):
            shifts.append(equations.solved(right, equations.bread - bread))
    return spread_of(np.array(shifts))


def _equations(
    model: Model,
    paths: Sequence[str],
    balances: Sequence[ForceBalance],
    scales: Scales,
    simulate: Sequence[Simulator | None],
    prior_weight: FloatArray,
    prior_right: FloatArray,
) -> _Equations:
    known = parameters_of(model)
    parameters = [known[path] for path in paths]
    bread, right = np.diag(prior_weight), np.array(prior_right)
    parts, instruments = [], True
    for balance, run in zip(balances, simulate, strict=True):
        rows = balance.mask
        residual, columns = balance.columns(model, parameters, scales)
        simulated = balance.instruments(model, parameters, scales, run)
        instruments &= simulated is not None
        z = columns if simulated is None else simulated
        weight = 1.0 / max(float(np.mean(residual[rows] ** 2)), 1e-300)
        bread = bread + weight * z[:, rows] @ columns[:, rows].T
        right += weight * z[:, rows] @ residual[rows]
        parts.append((z[:, rows], columns[:, rows], residual[rows], weight))
    return _Equations(bread, right, parts, instruments)


def _cost(model: Model, balances: Sequence[ForceBalance]) -> float:
    """Geometric mean over the logs' rows of the residual's rms, V."""
    rows = [int(balance.mask.sum()) for balance in balances]
    logs = [np.log(max(balance.residual_rms(model), 1e-300)) for balance in balances]
    return float(np.exp(np.dot(rows, logs) / sum(rows)))
