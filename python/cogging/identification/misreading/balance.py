"""The force balance of a log: what bounded mass and friction explain of a command, beside a force of any place."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np

from cogging._core import smooth_sign
from cogging.arrays import FloatArray, IntArray, Mask
from cogging.identification.inverse_dynamics import InverseDynamics
from cogging.log_check.encoder_quantum import encoder_quantum
from cogging.logs.log import Log
from cogging.model.model import Model

AXIS = ("mass", "viscous", "coulomb")
CUTOFFS = (0.1, 0.05, 0.025, 0.0125, 0.006, 0.003, 0.0015)  # of the row rate; the highest that noise leaves clear
HIGHEST = 60.0  # Hz: what is faster tells little of mass and friction
PER_PERIOD = 16.0  # rows in its period
NOISE = 0.02  # of the acceleration's power below the cut-off, that noise of the readings may make
ROWS = 10_000  # that are looked at, evenly taken
FEWEST = 50
REST = 0.02  # of the largest speed: slower rows show friction of any size
GAP = 2.5  # median steps: over longer ones nothing is bridged
NODES = 0.12  # of a force along the travel, for each independent row
MOST_NODES = 400
DRIFT = 3  # terms of a slow force in time, beside the constant
BAND = 1.2  # of a frequency, either way, that belongs to one wave
BLOCK = 4.0  # periods of the cut-off, that make a block

Bounds = Mapping[str, tuple[float, float]]


def cutoff_share(log: Log) -> float:
    """Highest cut-off, of the row rate, below which noise of the readings makes little of the acceleration."""
    position, n = log.position, len(log)
    rest = position - np.linspace(position[0], position[-1], n)
    spectrum = np.abs(np.fft.rfft(rest * np.hanning(n))) ** 2
    frequency = np.fft.rfftfreq(n)
    top = (frequency > 0.3) & (frequency < 0.49)
    quantum = encoder_quantum(position[:ROWS])
    floor = max(float(np.median(spectrum[top])) / math.log(2.0), quantum**2 / 12.0 * 0.375 * n)
    step = float(np.median(np.diff(log.time)))
    for share in CUTOFFS:
        below = frequency <= share
        noise = floor * float(np.sum(frequency[below] ** 4))
        if share <= HIGHEST * step and noise <= NOISE * float(np.sum((spectrum * frequency**4)[below])):
            return share
    return CUTOFFS[-1]


def thinned(log: Log) -> Log:
    """A log with no more rows a second than the highest cut-off needs: readings smoothed, commands averaged."""
    from scipy.ndimage import uniform_filter1d

    every = int(1.0 / (PER_PERIOD * HIGHEST * float(np.median(np.diff(log.time)))))
    if every < 2 or len(log) < ROWS:
        return log
    first = np.arange(0, len(log) - every, every)
    taken = {
        name: uniform_filter1d(column, every + 1 - every % 2, mode="nearest")[first]
        for name, column in log.columns().items()
        if name not in ("time", "command")
    }
    command = np.add.reduceat(log.command, np.append(first, len(log) - every))[:-1] / every
    return Log.of({**taken, "time": log.time[first], "command": command})


@dataclass(frozen=True)
class Fit:
    """What bounded parameters leave of a command.

    Attributes:
        whole: power of the command, V^2.
        free: power that forces of any place and slow time leave of it, V^2.
        left: power that the parameters leave of that, V^2.
        values: of the parameters, and of drag.
        by_block: what is left, by block, V^2.
    """

    whole: float
    free: float
    left: float
    values: Mapping[str, float]
    by_block: FloatArray

    @property
    def ratio(self) -> float:
        """Power that is left, of that which forces of place and time leave."""
        return self.left / self.free if self.free > 0.0 else 1.0


@dataclass(frozen=True)
class Balance:
    """What acts on an axis and what its motion needs, low-pass filtered.

    Attributes:
        command: as logged, V, one entry an even row, (n,).
        known: what the model's cogging and effects add to or take from it, V, (n,).
        taken: rows in motion that are looked at, (m,).
        needs: force that a unit of mass, viscous and Coulomb friction needs in these, by name, (m,).
        position: m, (m,); speed: m/s, (m,).
        block: number of the block of each, (m,).
        independent: about how many of the rows are independent.
        step: s, from row to row.
        one_wave: share that one wave makes of what command and acceleration have in the same frequencies.
    """

    command: FloatArray
    known: FloatArray
    taken: IntArray
    needs: Mapping[str, FloatArray]
    position: FloatArray
    speed: FloatArray
    block: IntArray
    independent: float
    step: float
    one_wave: float

    @classmethod
    def of(cls, log: Log, model: Model, share: float | None = None) -> Balance | None:
        """The balance of a log; None of one that hardly moves.

        It is filtered where noise is small, or at a `share` of the row rate.
        """
        share = cutoff_share(log) if share is None else share
        dynamics = InverseDynamics(log, cutoff=share / float(np.median(np.diff(log.time))))
        free = model.replace(axis=model.axis.replace(viscous=0.0, coulomb=0.0))
        speed, acceleration = dynamics.motion.middle_velocity, dynamics.motion.acceleration
        width = model.axis.coulomb_width
        sign = smooth_sign(speed, width) if width > 0.0 else np.sign(speed)
        command, *needs = dynamics.filtered(np.array([dynamics.command, acceleration, speed, sign]))
        known = dynamics.of([free])[0] + model.axis.mass * needs[0] - command
        rows = _in_motion(log.time, dynamics.even, needs[1], 1.0 / dynamics.cutoff)
        if rows.sum() < FEWEST:
            return None
        taken = np.flatnonzero(rows)[:: 1 + int(rows.sum()) // ROWS]
        even = dynamics.even
        block = np.floor((even[taken] - even[0]) * dynamics.cutoff / BLOCK)
        return cls(
            command=command,
            known=known,
            taken=taken,
            needs={name: need[taken] for name, need in zip(AXIS, needs, strict=True)},
            position=dynamics.motion.middle_position[taken],
            speed=needs[1][taken],
            block=np.unique(block, return_inverse=True)[1],
            independent=2.0 * share * float(rows.sum()),
            step=dynamics.sample_time,
            one_wave=_one_wave(command, needs[0]),
        )

    def fit(self, bounds: Bounds, *, shift: int = 0) -> Fit:
        """Least squares of the command, taken `shift` rows later, on mass and friction within their bounds.

        Beside them are free: a force of any place (linear between nodes), a slow one in time, friction that differs
        with direction, and drag that is not negative or within bounds of its own.
        """
        at = np.clip(self.taken + shift, 0, len(self.command) - 1)
        command = self.command[at]
        target = self.freed((command + self.known[self.taken])[None])[0]
        columns, size, triangle = self._columns
        limits = np.array([*(bounds[name] for name in AXIS), bounds.get("drag", (0.0, np.inf))])
        weights = bounded(size, triangle, target, limits)
        left = (target - weights @ columns) ** 2
        return Fit(
            whole=float(np.mean(command**2)),
            free=float(np.mean(target**2)),
            left=float(np.mean(left)),
            values=dict(zip((*AXIS, "drag"), weights.tolist(), strict=True)),
            by_block=np.bincount(self.block, left) / len(left),
        )

    def gain(self, values: Mapping[str, float]) -> float:
        """Factor on the command with which it is nearest to what these parameters need."""
        columns, target = self._columns[0], self.freed((self.command + self.known)[self.taken][None])[0]
        asked = np.array([values[name] for name in AXIS]) @ columns[:3]
        likeness = float(asked @ target)
        return float(asked @ asked) / likeness if likeness else 0.0

    @property
    def work(self) -> float:
        """Mean power of the command in motion, V m/s.

        A force of place gives back what it takes, and friction only takes: a command that was read right does work.
        """
        return float(np.mean(self.command[self.taken] * self.speed))

    @property
    def quarter_period(self) -> float:
        """A quarter of the period of the motion, s: moved by more, a wave is told from another no longer."""
        acceleration = float(np.sqrt(np.mean(self.needs["mass"] ** 2)))
        return 0.5 * math.pi * float(np.sqrt(np.mean(self.speed**2))) / max(acceleration, 1e-300)

    @cached_property
    def _columns(self) -> tuple[FloatArray, FloatArray, Any]:
        """Columns of the parameters and of drag freed of all else, (4, m), their sizes, and their QR factors."""
        columns = self.freed(np.array([*self.needs.values(), self.speed * np.abs(self.speed)]))
        size = np.sqrt(np.mean(columns**2, axis=1))
        size[size == 0.0] = 1.0
        return columns, size, np.linalg.qr((columns / size[:, None]).T)

    def freed(self, rows: FloatArray) -> FloatArray:
        """Rows (p, m) without what is free beside the parameters."""
        rows = self._placed(rows)
        basis = self._beside
        return np.asarray(rows - (rows @ basis) @ basis.T)

    @cached_property
    def _beside(self) -> FloatArray:
        """Orthonormal columns (m, q) of slow forces in time and of friction that differs with direction."""
        phase = 2.0 * self.taken / len(self.command) - 1.0
        slow = np.polynomial.legendre.legvander(phase, DRIFT)[:, 1:].T
        beside = self._placed(np.array([np.abs(self.speed), *slow]))
        size = np.sqrt(np.mean(beside**2, axis=1))
        return np.linalg.qr((beside[size > 0.0] / size[size > 0.0, None]).T)[0]

    def _placed(self, rows: FloatArray) -> FloatArray:
        """Rows (p, m) without what a force of any place makes of them."""
        from scipy.linalg import solveh_banded

        node, right, matrix = self._nodes
        left, count = 1.0 - right, matrix.shape[1]
        sums = [np.bincount(node, left * row, count) + np.bincount(node + 1, right * row, count) for row in rows]
        weights = solveh_banded(matrix, np.array(sums).T).T
        return np.asarray(rows - (weights[:, node] * left + weights[:, node + 1] * right))

    @cached_property
    def _nodes(self) -> tuple[IntArray, FloatArray, FloatArray]:
        """The node before each row, the share of the next, and the banded normal equations."""
        low, high = float(self.position.min()), float(self.position.max())
        count = int(np.clip(NODES * self.independent, 4, MOST_NODES))
        at = (self.position - low) / max(high - low, 1e-300) * (count - 1)
        node = np.minimum(at.astype(np.int64), count - 2)
        right = at - node
        left = 1.0 - right
        matrix = np.zeros((2, count))
        matrix[1] = np.bincount(node, left * left, count) + np.bincount(node + 1, right * right, count)
        matrix[0, 1:] = np.bincount(node, left * right, count)[: count - 1]
        matrix[1] += 1e-9 * float(matrix[1].max())
        return node, right, matrix


def _one_wave(command: FloatArray, acceleration: FloatArray) -> float:
    """Share of what two signals have in the same frequencies that lies within BAND of one, where that is largest."""
    power = np.abs(np.fft.rfft(acceleration - np.mean(acceleration)) * np.fft.rfft(command - np.mean(command)))
    total = np.concatenate([[0.0], np.cumsum(power)])
    frequency = np.arange(len(power))
    low, high = (
        np.floor(frequency / BAND).astype(int),
        np.minimum(np.ceil(frequency * BAND).astype(int), len(power) - 1),
    )
    return float(np.max(total[high + 1] - total[low])) / max(float(total[-1]), 1e-300)


def bounded(size: FloatArray, factors: Any, target: FloatArray, limits: FloatArray) -> FloatArray:
    """Weights (p,) of columns that come nearest to a target (m,), within limits (p, 2).

    Args:
        size: of the columns, (p,).
        factors: Q (m, p) and R (p, p) of the columns over their size.
        target: what they are to make.
        limits: lowest and highest weight of each.
    """
    from scipy.optimize import lsq_linear

    orthogonal, triangle = factors
    low, high = limits.T * size
    high = np.maximum(high, low + 1e-12 * np.abs(low) + 1e-300)  # where one is exact
    return np.asarray(lsq_linear(triangle, target @ orthogonal, bounds=(low, high), method="bvls").x / size)


def _in_motion(time: FloatArray, even: FloatArray, speed: FloatArray, memory: float) -> Mask:
    """Rows in motion, away from the ends and from gaps by the memory of the filter, s."""
    rows = (even >= even[0] + memory) & (even <= even[-1] - memory)
    steps = np.diff(time)
    for k in np.flatnonzero(steps > GAP * float(np.median(steps))):
        first, last = np.searchsorted(even, [time[k] - memory, time[k + 1] + memory])
        rows[first:last] = False
    fast = np.abs(speed)
    return np.asarray(rows & (fast > REST * float(np.quantile(fast, 0.99))))
