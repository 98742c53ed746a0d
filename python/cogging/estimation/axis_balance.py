"""Mass, viscous and Coulomb friction in the force balance of one log, beside a free force of position."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from cogging._core import smooth_sign
from cogging.arrays import FloatArray, IntArray
from cogging.estimation.force_balance import REST, ForceBalance
from cogging.log_check.encoder_readings import encoder_quantum
from cogging.logs.log import Log
from cogging.model.model import Model

AXIS = ("mass", "viscous", "coulomb")
CUTOFFS = (0.1, 0.05, 0.025, 0.0125, 0.006, 0.003, 0.0015)  # of the row rate; the highest that noise allows is used
HIGHEST = 60.0  # Hz: faster motion says little about mass and friction
PER_PERIOD = 16.0  # rows kept in a period of the highest cut-off
NOISE = 0.02  # of the acceleration's power below the cut-off: share that noise of the readings may have
ROWS = 10_000  # used at most, evenly spaced
FEWEST = 50
NODES = 0.12  # of the free force of position, for each independent row
MOST_NODES = 400
DRIFT = 3  # terms of a slow force in time, beside the constant
PADDED = 8  # spectra of this many times the rows, for the frequency of a wave
BLOCK = 4.0  # periods of the cut-off in a block

FACTOR = 3.0  # by which a parameter without stated uncertainty may be wrong, either way
SIGMAS = 3.0  # of a stated uncertainty

Bounds = Mapping[str, tuple[float, float]]


def cutoff_share(log: Log) -> float:
    """Highest cut-off, relative to the row rate, below which noise of the readings is small in the acceleration."""
    position, n = log.position, len(log)
    spectrum = np.abs(np.fft.rfft((position - np.linspace(position[0], position[-1], n)) * np.hanning(n))) ** 2
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
    """The log at the row rate that the highest cut-off needs: readings smoothed, commands averaged."""
    from scipy.ndimage import uniform_filter1d

    every = int(1.0 / (PER_PERIOD * HIGHEST * float(np.median(np.diff(log.time)))))
    if every < 2 or len(log) < ROWS:
        return log
    first = np.arange(0, len(log) - every, every)
    smooth = {n: uniform_filter1d(c, every + 1 - every % 2, mode="nearest")[first] for n, c in log.columns().items()}
    command = np.add.reduceat(log.command, np.append(first, len(log) - every))[:-1] / every
    return Log.of({**smooth, "time": log.time[first], "command": command})


@dataclass(frozen=True)
class AxisFit:
    """Least squares of a command on mass and friction within bounds."""

    whole: float  # power of the command, V^2
    free: float  # power that free forces of position and slow time leave, V^2
    left: float  # power that the parameters leave of that, V^2
    values: Mapping[str, float]  # of the parameters, and of drag
    by_block: FloatArray  # `left` by block, V^2

    @property
    def ratio(self) -> float:
        """Unexplained share of the power that free forces of position and time leave."""
        return self.left / self.free if self.free > 0.0 else 1.0


@dataclass(frozen=True)
class AxisBalance:
    """Command and the force that mass and friction need along the motion, low-pass filtered."""

    command: FloatArray  # as logged, V, one entry an even row, (n,)
    known: FloatArray  # contribution of the model's cogging and effects, V, (n,)
    taken: IntArray  # rows in motion that are used, (m,)
    needs: Mapping[str, FloatArray]  # force for a unit of mass, viscous and Coulomb friction in these, by name, (m,)
    position: FloatArray  # m, (m,); speed: m/s, (m,)
    speed: FloatArray
    block: IntArray  # number of the block of each, (m,)
    independent: float  # approximate number of independent rows
    step: float  # s, from row to row
    _acceleration: FloatArray

    @classmethod
    def of(cls, log: Log, model: Model, share: float | None = None) -> AxisBalance | None:
        """The balance of a log at the highest cut-off that noise allows, or `share` of the row rate; None at rest."""
        share = cutoff_share(log) if share is None else share
        balance = ForceBalance(log, cutoff=share / float(np.median(np.diff(log.time))))
        free = model.replace(axis=model.axis.replace(viscous=0.0, coulomb=0.0))
        speed, acceleration = balance.motion.middle_velocity, balance.motion.acceleration
        width = model.axis.coulomb_width
        sign = smooth_sign(speed, width) if width > 0.0 else np.sign(speed)
        command, *needs = balance.filtered(np.array([balance.command, acceleration, speed, sign]))
        fast = np.abs(needs[1])
        rows = balance.away_from_gaps(1.0 / balance.cutoff, 1.0 / balance.cutoff)
        rows &= fast > REST * float(np.quantile(fast, 0.99))
        if rows.sum() < FEWEST:
            return None
        taken = np.flatnonzero(rows)[:: 1 + int(rows.sum()) // ROWS]
        block = np.floor((balance.even[taken] - balance.even[0]) * balance.cutoff / BLOCK)
        return cls(
            command=command,
            known=balance.of([free])[0] + model.axis.mass * needs[0] - command,
            taken=taken,
            needs={name: need[taken] for name, need in zip(AXIS, needs, strict=True)},
            position=balance.motion.middle_position[taken],
            speed=needs[1][taken],
            block=np.unique(block, return_inverse=True)[1],
            independent=2.0 * share * float(rows.sum()),
            step=balance.sample_time,
            _acceleration=needs[0],
        )

    def fit(self, bounds: Bounds, *, shift: int = 0, beside: FloatArray | None = None) -> AxisFit:
        """Least squares of the command, taken `shift` rows later, on mass and friction within their bounds.

        Free beside them: forces of position and slow time, friction that differs with direction, drag if unbounded, and
        orthonormal rows `beside` (q, m).
        """
        command = self.command[np.clip(self.taken + shift, 0, len(self.command) - 1)]
        target = self.freed((command + self.known[self.taken])[None])[0]
        limits = np.array([*(bounds[name] for name in AXIS), bounds.get("drag", (0.0, np.inf))])
        rest, columns = target, self._columns
        if beside is not None:
            rest, columns = (rows - (rows @ beside.T) @ beside for rows in (rest, columns))
        weights = bounded(columns, rest, limits)
        left = (rest - weights @ columns) ** 2
        return AxisFit(
            whole=float(np.mean(command**2)),
            free=float(np.mean(target**2)),
            left=float(np.mean(left)),
            values=dict(zip((*AXIS, "drag"), weights.tolist(), strict=True)),
            by_block=np.bincount(self.block, left) / len(left),
        )

    def gain(self, values: Mapping[str, float]) -> float:
        """Factor on the command at which it is nearest to the force that these parameters need."""
        columns, target = self._columns, self.freed((self.command + self.known)[self.taken][None])[0]
        needed = np.array([values[name] for name in AXIS]) @ columns[:3]
        product = float(needed @ target)
        return float(needed @ needed) / product if product else 0.0

    @property
    def work(self) -> float:
        """Mean power of the command in motion, V m/s: positive for a correctly read one, since friction dissipates."""
        return float(np.mean(self.command[self.taken] * self.speed))

    @property
    def quarter_period(self) -> float:
        """A quarter of the period of the motion, s: the largest shift that can be told from another wave."""
        acceleration = float(np.sqrt(np.mean(self.needs["mass"] ** 2)))
        return 0.5 * math.pi * float(np.sqrt(np.mean(self.speed**2))) / max(acceleration, 1e-300)

    def wave(self, values: Mapping[str, float]) -> FloatArray:
        """Sine and cosine in time, orthonormal (2, m), of the frequency at which these parameters leave the most."""
        left = self.freed((self.command + self.known)[self.taken][None])[0]
        left = left - np.array([values[name] for name in (*AXIS, "drag")]) @ self._columns
        rows = np.zeros(len(self.command))
        rows[self.taken] = left
        size = PADDED * len(rows)
        turns = 2.0 * np.pi * float(np.argmax(np.abs(np.fft.rfft(rows, size)))) / size
        pair = self.freed(np.array([np.sin(turns * self.taken), np.cos(turns * self.taken)]))
        return np.linalg.qr(pair.T)[0].T

    @cached_property
    def _columns(self) -> FloatArray:
        """Columns of the parameters and of drag without the free forces, (4, m)."""
        return self.freed(np.array([*self.needs.values(), self.speed * np.abs(self.speed)]))

    def freed(self, rows: FloatArray) -> FloatArray:
        """Rows (p, m) orthogonal to the free forces."""
        rows = self._without_position(rows)
        basis = self._free_basis
        return np.asarray(rows - (rows @ basis) @ basis.T)

    @cached_property
    def _free_basis(self) -> FloatArray:
        """Orthonormal columns (m, q): slow forces in time, and friction that differs with direction."""
        phase = 2.0 * self.taken / len(self.command) - 1.0
        slow = np.polynomial.legendre.legvander(phase, DRIFT)[:, 1:].T
        free = self._without_position(np.array([np.abs(self.speed), *slow]))
        size = np.sqrt(np.mean(free**2, axis=1))
        return np.linalg.qr((free[size > 0.0] / size[size > 0.0, None]).T)[0]

    def _without_position(self, rows: FloatArray) -> FloatArray:
        """Rows (p, m) without the part that a force of position explains."""
        from scipy.linalg import solveh_banded

        node, right, matrix = self._nodes
        left, count = 1.0 - right, matrix.shape[1]
        sums = [np.bincount(node, left * row, count) + np.bincount(node + 1, right * row, count) for row in rows]
        weights = solveh_banded(matrix, np.array(sums).T).T
        return np.asarray(rows - (weights[:, node] * left + weights[:, node + 1] * right))

    @cached_property
    def _nodes(self) -> tuple[IntArray, FloatArray, FloatArray]:
        """The node before each row, the weight of the next node, and the banded normal equations."""
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


def bounded(columns: FloatArray, target: FloatArray, limits: FloatArray) -> FloatArray:
    """Least-squares weights (p,) of columns (p, m) on a target (m,), within limits (p, 2)."""
    from scipy.optimize import lsq_linear

    size = np.sqrt(np.mean(columns**2, axis=1))
    size[size == 0.0] = 1.0
    orthogonal, triangle = np.linalg.qr((columns / size[:, None]).T)
    low, high = limits.T * size
    high = np.maximum(high, low + 1e-12 * np.abs(low) + 1e-300)  # a parameter that is exact
    return np.asarray(lsq_linear(triangle, target @ orthogonal, bounds=(low, high), method="bvls").x / size)


@np.errstate(all="ignore")  # extreme values are refused where they are used
def explained_share(logs: Sequence[Log], model: Model) -> float | None:
    """Share of the command's power in motion that a model explains, with mass and friction as uncertain as stated.

    1 - sum (u - F)^2 / sum u^2 over rows in motion of all logs: u is the low-pass filtered command, F the force that
    the model needs along the measured motion, through the same filter. None where no log moves or acts. ValueError: the
    rows of a log cover too little of its time.
    """
    balances = [balance for log in logs if (balance := AxisBalance.of(thinned(log), model)) is not None]
    if not balances:
        return None
    command = np.concatenate([balance.command[balance.taken] for balance in balances])
    target = np.concatenate([(balance.command + balance.known)[balance.taken] for balance in balances])
    columns = np.array([np.concatenate([balance.needs[name] for balance in balances]) for name in AXIS])
    power = float(np.mean(command**2))
    if power == 0.0:
        return None
    bounds = []
    for name in AXIS:  # within the stated uncertainty: 0 is exact; without one, within a factor of three
        value, sigma = getattr(model.axis, name), model.uncertainty.get(name)
        exact = None if sigma is None else (value * max(1.0 - SIGMAS * sigma, 0.0), value * (1.0 + SIGMAS * sigma))
        bounds.append(exact or (value / FACTOR, value * FACTOR))
    left = target - bounded(columns, target, np.array(bounds)) @ columns
    return 1.0 - float(np.mean(left**2)) / power
