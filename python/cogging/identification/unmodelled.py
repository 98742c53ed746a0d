"""Split the residual of a force balance into noise and unmodelled forces of position, speed, direction and time."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from cogging.arrays import FloatArray, IntArray
from cogging.estimation.force_balance import ForceBalance
from cogging.estimation.statistics import student
from cogging.model.intervals import SIGMAS_95
from cogging.model.model import Model
from cogging.model.parameters import Parameter, Scales

WITH_FORCES = "with any force of position, speed, direction and time beside the model"
AS_NOISE = "with the residual as slow noise"
ROWS_PER_PERIOD = 8.0  # of the cut-off
MOST_ROWS = 20_000  # used of a log, from its middle
PLACES, TIMES = 12, 6  # nodes of the forces of position and of time
SPEEDS = (0.02, 0.07, 0.25)  # of the largest speed: decay speeds of Stribeck-like friction
LINES = 300  # spatial waves tried, half a wave over the travel apart
WAVES = 6  # kept at most
SURE = 1e-3  # probability of a wave in noise alone
ALLOWED = 3.0  # times the structured residual: 1-sigma of the prior of each force
# Set on drawn machines: good logs leave 1.0 to 1.3 times the noise.
MISSING = 2.0  # residual over noise from which the model lacks something
STRONG = 0.05  # structured residual over command, or ...
BURIED = 4.0  # ... residual over noise, from which parameters keep their prior and intervals allow for the lack


@dataclass(frozen=True)
class Unmodelled:
    """The residual of one log's force balance."""

    balance: ForceBalance
    residual: float  # rms over the rows in motion, V
    command: float  # rms of the filtered command over the same rows, V
    noise: float  # rms that no force of position, speed, direction, acceleration or time explains, V
    inflation: float  # spectral density of that noise at low frequencies over that of white noise of the same rms
    freedom: float  # number of independent rows less the forces fitted
    slow: float  # as `inflation`, of the whole residual
    forces: FloatArray  # of position, speed, direction and time, (q, m), of rms 1
    rows: IntArray  # of the balance that are used, (m,)

    @property
    def structured(self) -> float:
        """Rms of the residual that is not noise, V."""
        return float(np.sqrt(max(self.residual**2 - self.noise**2, 0.0)))

    @property
    def is_missing(self) -> bool:
        """Whether the residual is many times its noise."""
        return self.residual > MISSING * self.noise

    @property
    def is_strong(self) -> bool:
        """Whether so much of the command is unmodelled that a block jackknife cannot tell its effect."""
        return self.is_missing and (self.structured > STRONG * self.command or self.residual > BURIED * self.noise)

    @classmethod
    def of(cls, balance: ForceBalance, model: Model) -> Unmodelled:
        """Split what a fitted model leaves of a log, along the noise-free motion where it can be simulated."""
        residual = balance.of([model])[0]
        command = balance.filtered(balance.command[None, :])[0]
        every = max(1, int(1.0 / (ROWS_PER_PERIOD * balance.cutoff * balance.sample_time)))
        coarse = np.arange(0, len(residual), every)
        spare = max(0, len(coarse) - MOST_ROWS) // 2
        coarse = coarse[spare : spare + MOST_ROWS]
        counted = balance.mask[coarse]
        rows = coarse[counted]
        left = residual[rows]

        def seen(table: list[FloatArray]) -> FloatArray:
            """Filter forces, and scale them to rms 1; those that vanish are left out."""
            filtered = balance.filtered(np.array(table).reshape(-1, len(coarse)), every)[:, counted]
            size = np.sqrt(np.mean(filtered**2, axis=1)) if filtered.size else np.zeros(len(filtered))
            kept = size > 1e-9 * max(float(size.max(initial=0.0)), 1e-300)
            return np.asarray(filtered[kept] / size[kept, None])

        position, velocity = balance.motion.middle_position, balance.motion.middle_velocity[coarse]
        direction, speed = np.sign(velocity), np.abs(velocity) / balance.scales.velocity
        places = _hats(position[coarse], PLACES)
        falls = [np.exp(-speed / fall) for fall in SPEEDS]
        smooth = [*places, *(direction * place for place in places)]
        smooth += [direction, speed, direction * speed, direction * speed**2, speed**2]
        smooth += [*(direction * fall for fall in falls), *falls, *_hats(balance.even[coarse], TIMES)]
        forces = seen(smooth)
        # Of a mass error, of a command delay, and of a mass that differs with direction.
        acceleration = (balance.along(model) or balance).motion.acceleration
        inertial = seen([acceleration[coarse], np.gradient(acceleration)[coarse], acceleration[coarse] * direction])
        numbers = _waves(position, rows, left, np.vstack([forces, inertial]))
        forces = np.vstack([forces, seen([wave(k * position[coarse]) for k in numbers for wave in (np.sin, np.cos)])])
        quiet, rank = _without(left, np.vstack([forces, inertial]))
        independent, inflation = _memory(quiet)
        freedom = max(independent - rank, 0.1 * independent, 1.0)
        noise = float(np.sqrt(np.mean(quiet**2) * independent / freedom))
        rms = float(np.sqrt(np.mean(residual[balance.mask] ** 2)))
        of_command = float(np.sqrt(np.mean(command[balance.mask] ** 2)))
        return cls(balance, rms, of_command, min(noise, rms), inflation, freedom, _memory(left)[1], forces, rows)


def other_answers(
    model: Model, parameters: Sequence[Parameter], left: Sequence[Unmodelled], scales: Scales, loose: FloatArray
) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Moves of parameters beside unmodelled forces, half intervals there, and those with the residual as noise, (p,).

    Beside forces: least squares with those of `left` beside the model's own columns, each with a prior of 0 +- ALLOWED
    times the structured residual (Kennedy and O'Hagan 2001). As noise: an unmodelled force biases the parameters as
    much as coloured noise of its size and bandwidth could.
    """
    p = len(parameters)
    prior = np.diag(1.0 / loose**2)
    plain, right = prior.copy(), np.zeros(p)
    bordered, beside = prior.copy(), np.zeros(p)
    information = prior.copy()
    for one in left:
        residual, columns = one.balance.columns(model, parameters, scales)
        columns, rest = columns[:, one.rows], residual[one.rows]
        weight = 1.0 / max(one.noise**2 * one.inflation, 1e-300)
        plain += weight * columns @ columns.T
        right += weight * columns @ rest
        own = weight * one.forces @ one.forces.T
        own += np.eye(len(own)) / max(ALLOWED * one.structured, 1e-3 * one.noise, 1e-150) ** 2
        cross = weight * columns @ one.forces.T
        solved = np.linalg.solve(own, np.column_stack([cross.T, weight * one.forces @ rest]))
        bordered += weight * columns @ columns.T - cross @ solved[:, :p]
        beside += weight * columns @ rest - cross @ solved[:, p]
        information += columns @ columns.T / max(one.residual**2 * one.slow, 1e-300)
    size, as_noise = np.sqrt(np.diag(plain)), np.sqrt(np.diag(information))
    inverse, without, noisy = (
        np.linalg.pinv(matrix / np.outer(scale, scale), rcond=1e-13, hermitian=True)
        for matrix, scale in ((bordered, size), (plain, size), (information, as_noise))
    )
    moved = -inverse @ (beside / size) / size + without @ (right / size) / size
    halves = student(sum(one.freedom for one in left)) * np.sqrt(np.maximum(np.diag(inverse), 0.0)) / size
    return moved, halves, SIGMAS_95 * np.sqrt(np.maximum(np.diag(noisy), 0.0)) / as_noise


def _hats(coordinate: FloatArray, number: int) -> list[FloatArray]:
    """Triangles over a coordinate that sum to 1, (m,) each."""
    nodes = np.linspace(coordinate.min(), coordinate.max(), number)
    return [np.asarray(np.interp(coordinate, nodes, row)) for row in np.eye(number)]


def _waves(position: FloatArray, rows: IntArray, left: FloatArray, forces: FloatArray) -> list[float]:
    """Wave numbers (rad/m) of the significant spatial waves in a residual, strongest first."""
    numbers = np.pi * np.arange(1, LINES + 1) / max(float(np.ptp(position)), 1e-300)
    there = np.exp(1j * np.outer(numbers, position[rows]))
    taken: list[int] = []
    for _ in range(WAVES):
        quiet, _ = _without(left, forces)
        independent, _ = _memory(quiet)
        share = 2.0 * np.abs(there @ quiet) ** 2 / (len(quiet) * max(float(quiet @ quiet), 1e-300))
        share[taken] = 0.0
        best = int(np.argmax(share))
        if share[best] * independent < 2.0 * np.log(LINES / SURE):
            break
        taken.append(best)
        forces = np.vstack([forces, there[best].real, there[best].imag])
    return [float(numbers[i]) for i in taken]


def _without(left: FloatArray, forces: FloatArray) -> tuple[FloatArray, float]:
    """A residual (m,) with forces (q, m) projected out, and the rank of these."""
    values, vectors = np.linalg.eigh(forces @ forces.T / len(left))
    good = values > 1e-6 * values.max(initial=1e-300)
    basis = (vectors[:, good] / np.sqrt(values[good])).T @ forces
    return left - (basis @ left / len(left)) @ basis, float(good.sum())


def _memory(noise: FloatArray) -> tuple[float, float]:
    """Number of independent rows of a noise, and its density at low frequencies over that of white noise."""
    n = len(noise)
    correlation = np.fft.irfft(np.abs(np.fft.rfft(noise, 2 * n)) ** 2)[: max(n // 4, 2)]
    correlation = correlation[1:] / max(correlation[0], 1e-300)
    first = np.flatnonzero(correlation <= 0.0)
    near = correlation[: int(first[0])] if len(first) else correlation
    independent = n / (1.0 + 2.0 * float(np.sum(np.maximum(near**2 - 1.0 / n, 0.0))))
    return independent, 1.0 + 2.0 * float(near.sum())
