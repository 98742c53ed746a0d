"""The force balance of logs, which needs no good model: what acts, less mass times acceleration, row by row."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from typing import Any

import numpy as np

from cogging._core import AxisParameters
from cogging.arrays import FloatArray, Mask
from cogging.diagnosis.thresholds import BALANCE
from cogging.effects.effect import Effect, laws_of
from cogging.estimation.residuals import quiet_plant
from cogging.identification.force_balance import ForceBalance
from cogging.identification.two_estimators import noise_floor
from cogging.logs.log import Log
from cogging.model.difference_steps import central
from cogging.model.model import Model
from cogging.model.parameters import Parameter, Scales

WEAKENING = {"command_gain", "shape_command", "lag"}  # what may take a command away


@dataclass(frozen=True)
class LogBalance:
    """The force balance of one log.

    Attributes:
        balance: filtered force balance, with its rows in motion.
        rest: speed below which rows do not count, m/s.
    """

    balance: ForceBalance
    rest: float

    @property
    def log(self) -> Log:
        """The measured log."""
        return self.balance.log

    @property
    def settle(self) -> float:
        """Time after which the filter has forgotten what was, s."""
        return 1.0 / self.balance.dynamics.cutoff

    @property
    def mask(self) -> Mask:
        """Rows of the even grid that count, (n,)."""
        return self.balance.mask

    def of(self, models: Sequence[Model], *, as_command: bool = True) -> FloatArray:
        """What each model leaves unexplained, V, positive where it lacks a force towards -x, (models, n).

        Args:
            models: models that are held against the log.
            as_command: whether as the command that would make it (see _as_command), else as a force.
        """
        dynamics = self.balance.dynamics
        table = dynamics.of(models)
        for i, model in enumerate(models):
            for effect in model.effects:
                if is_load(effect):
                    table[i] += dynamics.filtered(self._borne_by_load(model.axis.mass, effect)[None, :])[0]
            if as_command:
                table[i] = self._as_command(table[i], model)
        return table

    def _as_command(self, residual: FloatArray, model: Model) -> FloatArray:
        """What is left, V, as the command that would make it: an effect that lets little of a command act hides more.

        Behind a gain 1 + g it is the residual over that; behind a lag T, residual + T d residual / dt; behind what cuts
        commands, the residual over the share of the command that still acts.
        """
        motion, dynamics = self.balance.dynamics.motion, self.balance.dynamics
        cutting = []
        for effect in model.effects:
            if "command_gain" in effect.HOOKS:
                law = laws_of(effect.resolved(model.axis, model.cogging)).gain_at
                gain = 1.0 + np.asarray(law(position=motion.middle_position, time=dynamics.even - dynamics.even[0]))
                residual = residual / np.maximum(np.abs(gain), BALANCE.gain_min)
            elif "lag" in effect.HOOKS:
                residual = residual + float(getattr(effect, "time_constant", 0.0)) * np.gradient(
                    residual, dynamics.even
                )
            elif "shape_command" in effect.HOOKS:
                cutting.append(effect)
        if cutting:
            residual = residual * self._command / max(self._acting(cutting), 1e-3 * self._command)
        return residual

    @cached_property
    def _command(self) -> float:
        """Rms of the filtered command in rows that count, V."""
        return self._acting(())

    def _acting(self, effects: Sequence[Effect]) -> float:
        """Rms of what acts of the command behind effects that shape it, V."""
        dynamics = self.balance.dynamics
        plant = quiet_plant(Model(axis=AxisParameters(mass=1.0), effects=tuple(effects)))
        motion = dynamics.motion
        acts = dynamics.filtered(dynamics.predictor.net_force([plant], motion.middle_position, motion.middle_velocity))
        return float(np.sqrt(np.mean(acts[0, self.mask] ** 2)))

    def _borne_by_load(self, mass: float, effect: Any) -> FloatArray:
        """Inertia of the load that does not follow the motor: mass_ratio M (a - H a), V, (n,).

        H is the load's answer to the motor: (2 z w s + w^2) / (s^2 + 2 z w s + w^2) at the antiresonance w, which with
        the free-free resonance w_r is w_r sqrt(1 - mass_ratio); z is damping_ratio sqrt(1 - mass_ratio).
        """
        acceleration = self.balance.dynamics.motion.acceleration
        if not np.isfinite(effect.frequency) or effect.mass_ratio <= 0.0:
            return np.zeros(len(acceleration))
        share = 1.0 - float(effect.mass_ratio)
        answer = self.load_acceleration(float(effect.frequency) * share**0.5, float(effect.damping_ratio) * share**0.5)
        return np.asarray(mass * effect.mass_ratio * (acceleration - answer))

    def load_acceleration(self, antiresonance: float, damping_ratio: float) -> FloatArray:
        """Acceleration of a load that hangs on the motor, m/s^2, (n,); `antiresonance` in Hz."""
        from scipy.signal import lfilter

        dynamics = self.balance.dynamics
        # The bilinear transform s = 2 / h (z - 1) / (z + 1) bends frequencies: at this one it shall be right.
        w = np.tan(min(np.pi * antiresonance * dynamics.sample_time, BALANCE.turn_max))  # omega h / 2
        damped, squared = 2.0 * damping_ratio * w, w * w
        numerator = np.array([damped + squared, 2.0 * squared, squared - damped])
        denominator = np.array([1.0 + damped + squared, 2.0 * squared - 2.0, 1.0 - damped + squared])
        return np.asarray(lfilter(numerator, denominator, dynamics.motion.acceleration))


@dataclass(frozen=True)
class Balances:
    """The force balances of several logs under one model: what a search for large effects looks at.

    Attributes:
        model: model that is held against the logs.
        sources: balance of each log.
    """

    model: Model
    sources: tuple[LogBalance, ...]

    @cached_property
    def scales(self) -> Scales:
        """Sizes of all logs together."""
        return Scales.largest(source.balance.scales for source in self.sources)

    @cached_property
    def residual(self) -> FloatArray:
        """What the model leaves unexplained in rows that count, V, logs one after the other, (n,)."""
        return self.joined([source.of([self.model])[0] for source in self.sources])

    @cached_property
    def force(self) -> float:
        """Rms of what the model leaves unexplained as a force, V: behind a lag, noise is large as a command."""
        return float(
            np.sqrt(np.mean(self.joined([s.of([self.model], as_command=False)[0] for s in self.sources]) ** 2))
        )

    @property
    def rms(self) -> float:
        """Rms of the residual, V."""
        return float(np.sqrt(np.mean(self.residual**2)))

    @property
    def independent_rows(self) -> float:
        """Rows that count, as many as know nothing of each other behind the filter."""
        parts = [(source.balance.dynamics, int(source.mask.sum())) for source in self.sources]
        return float(sum(rows * min(1.0, 2.0 * one.cutoff * one.sample_time) for one, rows in parts))

    @cached_property
    def noise(self) -> float:
        """What quantiser and noise of the encoder make of the balance, rms, V."""
        rows = [int(source.mask.sum()) for source in self.sources]
        powers = [noise_floor(source.balance, self.model) ** 2 for source in self.sources]
        return float(np.sqrt(np.dot(rows, powers) / max(sum(rows), 1)))

    @cached_property
    def command(self) -> float:
        """Rms of the filtered command less its mean in rows that count, V."""
        rows = [s.balance.dynamics.filtered(s.balance.dynamics.command[None, :])[0] for s in self.sources]
        return float(np.std(self.joined(rows)))

    def joined(self, rows: Sequence[FloatArray]) -> FloatArray:
        """Rows (..., n of a log) of each log, those that count, one log after the other."""
        return np.concatenate([row[..., s.mask] for row, s in zip(rows, self.sources, strict=True)], axis=-1)

    def columns(self, parameters: Sequence[Parameter]) -> FloatArray:
        """Derivatives of the residual by parameters, V per unit, (p, n)."""
        steps = [central(self.model, parameter, self.scales.step(parameter)) for parameter in parameters]
        models = [side for step in steps for side in (step.above, step.below)]
        table = self.joined([source.of(models) for source in self.sources])
        return np.asarray((table[0::2] - table[1::2]) / np.array([step.span for step in steps])[:, None])

    def added(self, effects: Sequence[Effect]) -> FloatArray:
        """What each effect would add to the residual, V, (effects, n)."""
        models = [self.model.replace(effects=(*self.model.effects, effect)) for effect in effects]
        return self.joined([source.of(models) for source in self.sources]) - self.residual

    def under(self, model: Model) -> Balances:
        """The same logs under another model."""
        return Balances(model, self.sources)


def is_load(effect: Effect) -> bool:
    """Whether an effect is a load that hangs on the motor by a spring: its only states are that load's."""
    fields = {"frequency", "damping_ratio", "mass_ratio"}
    return "state" in effect.HOOKS and fields == set(effect.ROLES)


def balances_of(logs: Sequence[Log], model: Model) -> Balances:
    """The balances of logs, each at the highest cut-off at which the encoder does not drown the command."""
    return Balances(model, tuple(_balance_of(log, model) for log in logs))


def _balance_of(log: Log, model: Model) -> LogBalance:
    step = float(np.median(np.diff(log.time)))
    longest = (log.time[-1] - log.time[0]) / step
    shares = [share for share in BALANCE.cutoffs if longest * share / BALANCE.cutoffs[0] <= BALANCE.rows_max] or [
        BALANCE.cutoffs[-1]
    ]
    balance = None
    for share in shares:
        balance = ForceBalance.of(log, cutoff=max(BALANCE.lowest_cutoff, share / step))
        if noise_floor(balance, model) < BALANCE.noise * float(np.std(log.command)):
            break
    assert balance is not None
    balance = _away_from_rest(_thinned(balance))
    counted = np.abs(balance.dynamics.motion.middle_velocity[balance.mask])
    return LogBalance(balance, float(counted.min()) if len(counted) else 0.0)


def _away_from_rest(balance: ForceBalance) -> ForceBalance:
    """The balance without the rows into which the filter brings what friction did at rest; with, where few are left."""
    dynamics = balance.dynamics
    reach = max(1, round(BALANCE.filter_reach / (dynamics.cutoff * dynamics.sample_time)))
    slow = np.abs(dynamics.motion.middle_velocity) <= BALANCE.slow_rows * balance.scales.velocity
    near = np.round(np.convolve(slow.astype(float), np.ones(2 * reach + 1), mode="same")) > 0
    mask = balance.mask & ~near
    return replace(balance, mask=mask) if mask.sum() > BALANCE.rows_left * balance.mask.sum() else balance


def _thinned(balance: ForceBalance) -> ForceBalance:
    """The balance on as few rows as its cut-off needs: what is faster was taken out of them."""
    dynamics = balance.dynamics
    every = int(BALANCE.cutoffs[0] / (dynamics.cutoff * dynamics.sample_time))
    if every < 2 or dynamics.pauses:
        return balance
    rows = len(dynamics.even) // every * every
    command = dynamics.command[:rows].reshape(-1, every).mean(axis=1)
    log = Log(dynamics.even[:rows:every], dynamics.motion.position[:rows:every], command)
    return ForceBalance.of(log, cutoff=dynamics.cutoff, rest=BALANCE.slow_rows * balance.scales.velocity)
