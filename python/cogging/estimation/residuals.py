"""What a model leaves unexplained of a log, row by row, in force units: by prediction, or by replaying the loop."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Protocol

import numpy as np
import numpy.typing as npt

from cogging._core import (
    DivergedError,
    EncoderParameters,
    NoiseParameters,
    Plant,
    Prediction,
    Predictor,
    Sampled,
    closed_loop,
    friction_slope_max,
)
from cogging.arrays import FloatArray, Mask
from cogging.effects.effect import Effect, Wave, for_core, kind_of, laws_of
from cogging.logs.log import Log
from cogging.model.difference_steps import central, one_sided
from cogging.model.model import Model
from cogging.model.parameters import Parameter, Scales, effect_at
from cogging.threads import on_threads

WIDE = 0.03  # of a parameter: the step of a difference quotient through contacts
SETTLED = 6.0  # time constants of the observer, after which what it did not know (7 exp(-6) of it) is forgotten
START = 0.06  # s, left out at the start and after a gap: what acted before the first row is not known


class Residuals(Protocol):
    """One log seen by models: rows that count, and what each model leaves unexplained of them, V."""

    log: Log
    counts: FloatArray  # 1 where a row counts, 0 where it does not, (n,)
    scales: Scales

    def of(self, models: Sequence[Model]) -> FloatArray:
        """Residuals (V) of each model, (models, n)."""


class Innovations:
    """Residuals by one-step prediction: command and position alone, no controller, no reference.

    The plant is driven by the recorded command and held to the reading by an observer of fixed gain; what it did not
    foresee is turned into the constant force that would leave the same innovation, M (2 pi bandwidth)^2 innovation.

    Rows count when the axis moves faster than `rest`, does so since six time constants of the observer, and the
    record is continuous: at rest, friction takes any force up to its level and shows nothing.

    Args:
        log: with at least time, position and command.
        model: gives mass and friction width for the scaling; what is judged is given to `of`.
        bandwidth: of the observer, Hz.
        rest: m/s; None: the larger of the friction's width and 0.3 % of the largest speed.
        quick_starts: rows count sooner after a start that is quicker than the observer (see settling).
    """

    def __init__(
        self,
        log: Log,
        model: Model,
        *,
        bandwidth: float = 20.0,
        rest: float | None = None,
        steps_per_sample: int | None = None,
        quick_starts: bool = False,
    ) -> None:
        self.log, self.bandwidth, self.quick_starts = log, bandwidth, quick_starts
        steps = np.diff(log.time)
        sample_time = float(np.median(steps))
        plant = quiet_plant(model)
        if steps_per_sample is None:
            steps_per_sample = steps_needed(model, sample_time)
        self.initial_velocity = initial_velocity(log)
        self.predictor = Predictor(
            log.time,
            log.position,
            log.command,
            bandwidth=bandwidth,
            gap=max(5.0 * sample_time, 0.1 / bandwidth),
            initial_velocity=self.initial_velocity,
            steps_per_sample=steps_per_sample,
        )
        self.scale = model.axis.mass * (2.0 * np.pi * bandwidth) ** 2
        self.along = self.predictor.predict(plant)
        self.velocity = self.along.velocity
        smooth = max(1, round(0.1 / bandwidth / sample_time))
        speed = np.abs(moving_average(self.velocity, smooth))
        speed_max = float(speed.max())
        self.rest = max(model.axis.coulomb_width, 3e-3 * speed_max) if rest is None else rest
        turned = np.concatenate([[False], self.velocity[1:] * self.velocity[:-1] < 0.0])  # between two rows
        still = (np.abs(self.velocity) < self.rest) | turned
        self.settle = settle = SETTLED / (2.0 * np.pi * bandwidth)
        broken = np.concatenate([[True], steps > max(5.0 * sample_time, 0.1 / bandwidth)])
        waits = settling(still, log.time, self.velocity, self.rest, bandwidth) if quick_starts else settle
        counts = ~(since(still, log.time) < waits) & ~(since(broken, log.time) < max(START, settle))
        self.counts = counts.astype(float)
        acceleration = np.gradient(moving_average(self.velocity, 4 * smooth), log.time)
        self.scales = Scales(
            force=float(np.sqrt(np.mean(log.command**2))) or 1.0,
            position=float(np.ptp(log.position)) or 1.0,
            velocity=speed_max or 1.0,
            acceleration=float(np.quantile(np.abs(acceleration), 0.99)) or 1.0,
            time=float(log.time[-1] - log.time[0]),
            sample_time=sample_time,
        )

    def of(self, models: Sequence[Model]) -> FloatArray:
        """Residuals (V) of each model, (models, n).

        Raises:
            DivergedError: a prediction diverged.
        """
        return self.scale * self.predictor.innovations([quiet_plant(model) for model in models])

    def columns(self, model: Model, parameters: Sequence[Parameter], scales: Scales) -> tuple[FloatArray, FloatArray]:
        """Residual (n,) and derivatives (p, n) by the parameters.

        Parameters of forces are differentiated along the prediction and passed through the observer's loop; those with
        a memory, of the amplifier or of the encoder by central differences of whole predictions.

        Raises:
            ValueError: a parameter that no step may move.
        """
        plant = quiet_plant(model)
        along = self.predictor.predict(plant)
        columns = np.zeros((len(parameters), len(self.log)))
        indexes = range(len(parameters))
        forces = [i for i in indexes if is_force(model, parameters[i].path)]
        readings = [i for i in indexes if is_reading(model, parameters[i].path)]
        others = [i for i in indexes if i not in forces and i not in readings]
        if forces:
            steps = [one_sided(model, parameters[i], scales.step(parameters[i])) for i in forces]
            plants = [quiet_plant(step.above) for step in steps]
            columns[forces] = self.rows_of_plants(along, plant, plants, [step.span for step in steps])
        if readings:
            steps = [one_sided(model, parameters[i], scales.step(parameters[i])) for i in readings]
            errors = [reading_difference(step.above, model, along.position) / step.span for step in steps]
            columns[readings] = self.rows_of_readings(along, np.array(errors), plant.axis.mass)
        if others:
            steps = [central(model, parameters[i], step_through(model, parameters[i], scales)) for i in others]
            table = self.of([side for step in steps for side in (step.above, step.below)])
            columns[others] = (table[0::2] - table[1::2]) / np.array([step.span for step in steps])[:, None]
        return self.scale * along.innovation, columns

    def rows_of_plants(
        self, along: Prediction, plant: Plant, others: Sequence[Plant], spans: Sequence[float]
    ) -> FloatArray:
        """What the residuals gain, to first order, from a plant to others that differ in forces alone, (p, n).

        Args:
            along: prediction of `plant` on this log.
            plant: (without quantiser and noise, as the others: see quiet_plant).
            others: p of them. One of another mass counts by the acceleration that its forces make.
            spans: what each row is divided by, (p,): rows are V per unit of it.
        """
        force = self.predictor.net_force([plant, *others], along.middle_position, along.middle_velocity)
        # The same acceleration, as a force on the plant's own mass.
        force *= (plant.axis.mass / np.array([p.axis.mass for p in (plant, *others)]))[:, None]
        force = (force[1:] - force[:1]) / np.asarray(spans)[:, None]
        return self.rows_of_forces(along, force, plant.axis.mass)

    def rows_of_effects(
        self, along: Prediction, plant: Plant, effects: Sequence[Effect], units: Sequence[float]
    ) -> FloatArray:
        """What the residuals gain, to first order, when each effect joins a plant, V per unit of it, (p, n).

        Only the effect's own law is evaluated, so this is much quicker than `rows_of_plants`.

        Args:
            along: prediction of `plant` on this log.
            plant: (see quiet_plant).
            effects: p of them, each such that `Predictor.is_addable`.
            units: what each row is divided by, (p,), above 0.

        Raises:
            ValueError: an effect that is not addable.
        """
        rows = np.asarray(self.predictor.added(along, plant, for_core(effects), units))
        rows *= self.scale
        return rows

    def rows_of_forces(self, along: Prediction, forces: FloatArray, mass: float) -> FloatArray:
        """What small forces (V, one an interval, (p, n)) add to the residuals of a prediction, V, (p, n)."""
        return np.asarray(self.scale * self.predictor.propagate(along, mass, forces))

    def rows_of_readings(self, along: Prediction, errors: FloatArray, mass: float) -> FloatArray:
        """What small errors of the reading (m, one a row, (p, n)) add to the residuals of a prediction, V, (p, n)."""
        return np.asarray(self.scale * self.predictor.propagate(along, mass, np.zeros_like(errors), errors))


class Replay:
    """Residuals by closed-loop replay from the reference alone: logged less simulated command, V.

    The quantiser and the noise are off in the replay. It starts at the first reading, with the speed of the first.

    Raises:
        ValueError: the log has no reference, the model no controller, or the rows are not evenly spaced.
    """

    def __init__(self, log: Log, model: Model, *, added_command: npt.ArrayLike | None = None) -> None:
        if log.reference is None:
            raise ValueError("reference: must be in the log to replay it, got none")
        if model.controller is None:
            raise ValueError("controller: must be given to replay a log, got a model without [controller]")
        steps = np.diff(log.time)
        sample_time = 1.0 / model.controller.sample_rate
        if np.abs(log.time - log.time[0] - np.arange(len(log)) * sample_time).max() > 0.5 * sample_time:
            raise ValueError(
                f"time: must be evenly spaced by the controller's 1 / sample_rate = {sample_time:g} s to be replayed, "
                f"got steps from {steps.min():g} to {steps.max():g} s"
            )
        self.log, self.added_command = log, None if added_command is None else np.asarray(added_command, dtype=float)
        time = np.arange(len(log)) * sample_time
        self.reference = Sampled(time, log.reference, log.reference_velocity, log.reference_acceleration)
        self.duration = float(time[-1])
        seen = Innovations(log, model)
        self.counts, self.scales, self.velocity = seen.counts, seen.scales, seen.velocity
        self.initial_velocity = seen.initial_velocity if abs(seen.initial_velocity) > seen.rest else 0.0

    def run(self, model: Model) -> dict[str, FloatArray]:
        """The simulated columns of one model."""
        model = quiet(model)
        # A run may leave the travel, but what an effect takes from the travel stays.
        effects = tuple(effect.resolved(model.axis, model.cogging) for effect in model.effects)
        axis = model.axis.replace(travel=[-np.inf, np.inf])
        steps = steps_needed(model, 1.0 / model.make_controller().sample_rate)
        return closed_loop(
            model.replace(axis=axis, effects=effects).plant(),
            model.make_controller(),
            self.reference,
            duration=self.duration,
            initial_position=float(self.log.position[0]),
            initial_velocity=self.initial_velocity,
            added_command=self.added_command,
            steps_per_sample=steps,
        )

    def of(self, models: Sequence[Model]) -> FloatArray:
        """Residuals (V) of each model, (models, n).

        Raises:
            DivergedError: a replay diverged.
        """
        runs = on_threads(self.run, models)
        commands = np.array([run["command"] for run in runs])
        if not np.isfinite(commands).all():
            raise DivergedError("the replay diverged")
        return np.asarray(self.log.command - commands)


#: What acts on the axis through a force or the gain of the command alone, without a memory.
LINEAR_HOOKS = {"force", "friction_level", "command_gain"}


def is_force(model: Model, path: str) -> bool:
    """Whether a parameter acts through a force or the gain of the command alone, without a memory."""
    if not path.startswith("effects."):
        return True
    return set(effect_at(model, path).HOOKS) <= LINEAR_HOOKS


def step_through(model: Model, parameter: Parameter, scales: Scales) -> float:
    """The step of a difference quotient; wide for what has states: contacts make the residual jump in the small."""
    step = scales.step(parameter)
    if parameter.path.startswith("effects.") and "state" in effect_at(model, parameter.path).HOOKS:
        return max(step, WIDE * abs(parameter.value))
    return step


def is_reading(model: Model, path: str) -> bool:
    """Whether a parameter is that of a wave in the encoder's reading: an error that is small and comes and goes.

    One that grows along the travel (a scale) is nearly what mass and friction do, and is predicted exactly instead.
    """
    if not path.startswith("effects."):
        return False
    effect = effect_at(model, path)
    return "reading" in effect.HOOKS and kind_of(effect, Wave) is not None


def quiet(model: Model) -> Model:
    """The model without quantiser and noise: what is expected of it."""
    return model.replace(encoder=EncoderParameters(), noise=NoiseParameters())


def quiet_plant(model: Model) -> Plant:
    """The plant of a model without quantiser and noise: what predicts."""
    return quiet(model).plant()


def reading_difference(model: Model, other: Model, position: FloatArray) -> FloatArray:
    """By how much the encoder of one model reads more than that of another with the same effects, m, (n,)."""
    difference = np.zeros(len(position))
    for mine, its in zip(model.effects, other.effects, strict=True):
        if "reading" in mine.HOOKS:
            difference += laws_of(mine).reading_at(position) - laws_of(its).reading_at(position)
    return difference


def initial_velocity(log: Log) -> float:
    """Slope in the first row of the parabola through the first readings, m/s."""
    few = max(6, min(len(log) // 10, round(0.02 / float(np.median(np.diff(log.time))))))
    time, position = log.time[:few] - log.time[0], log.position[:few] - log.position[0]
    return float(np.polyfit(time / time[-1], position, 2)[1] / time[-1])


def steps_needed(model: Model, sample_time: float) -> int:
    """Runge-Kutta steps a sample so that the friction's slope at rest stays well inside the stable region."""
    width = model.axis.coulomb_width
    if width == 0.0:
        return 1
    rate = friction_slope_max(width) * model.axis.coulomb / model.axis.mass
    return int(np.clip(np.ceil(rate * sample_time), 1, 20))


def moving_average(values: FloatArray, length: int) -> FloatArray:
    """Centred mean over `length` rows (odd from here), shorter at the ends."""
    half = length // 2
    if half == 0:
        return values
    total = np.concatenate([[0.0], np.cumsum(values)])
    rows = np.arange(len(values))
    first, last = np.maximum(rows - half, 0), np.minimum(rows + half + 1, len(values))
    return np.asarray((total[last] - total[first]) / (last - first))


def settling(still: Mask, time: FloatArray, velocity: FloatArray, rest: float, bandwidth: float) -> FloatArray:
    """Seconds for which each row must wait after the last that was still, (n,).

    What friction does below `rest` is not known. It has 2 rest / a to act in, at an acceleration a, and leaves a speed
    that the observer forgets as (1 + s) exp(-s) over time constants s. The wait is that in which as much is left as
    SETTLED time constants leave of what acted for one or longer; one time constant at least.
    """
    constant = 1.0 / (2.0 * np.pi * bandwidth)
    last = np.maximum(np.maximum.accumulate(np.where(still, np.arange(len(time)), -1)), 0)
    starts = np.unique(last)
    ahead = np.minimum(np.searchsorted(time, time[starts] + 0.5 * SETTLED * constant), len(time) - 1)
    acceleration = np.abs(velocity[ahead] - velocity[starts]) / np.maximum(time[ahead] - time[starts], 1e-300)
    acted = 2.0 * rest / np.maximum(np.maximum(acceleration * constant, 2.0 * rest), 1e-300)
    waits = np.linspace(1.0, SETTLED, 51)
    left = (1.0 + waits) * np.exp(-waits)
    needed = np.interp(-left[-1] / np.maximum(acted, 1e-12), -left, waits)  # np.interp wants what increases
    return np.asarray(constant * needed[np.searchsorted(starts, last)])


def since(event: Mask, time: FloatArray) -> FloatArray:
    """Seconds since the last row with the event, 0 in such a row, infinite before the first, (n,)."""
    last = np.maximum.accumulate(np.where(event, np.arange(len(time)), -1))
    return np.where(last >= 0, time - time[np.maximum(last, 0)], np.inf)
