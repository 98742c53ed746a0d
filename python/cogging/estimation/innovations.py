"""Residuals of one-step prediction, from command and position alone."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np

from cogging._core import Prediction, Predictor
from cogging.arrays import FloatArray
from cogging.effects.effect import Wave, kind_of, laws_of
from cogging.estimation.residuals import START, quiet_plant, scales_of, since, steps_needed
from cogging.estimation.statistics import moving_average
from cogging.logs.log import Log
from cogging.model.model import Model
from cogging.model.parameters import Parameter, Scales, central, effect_at, one_sided

BANDWIDTH = 20.0  # Hz, of the observer
SETTLED = 6.0  # time constants after which the observer has forgotten its initial error (7 exp(-6) remains)
WIDE = 0.03  # relative step of a difference quotient through contacts

#: Hooks that act through a force or the command gain alone, without memory.
LINEAR_HOOKS = {"force", "friction_level", "command_gain"}


class Innovations:
    """Residuals by one-step prediction: command and position alone, no controller, no reference.

    The plant is driven by the recorded command and corrected by an observer of fixed gain; the innovation is expressed
    as the constant force that would cause it, M (2 pi BANDWIDTH)^2 innovation.

    Rows count if the axis has moved faster than `rest` (m/s; None: the larger of the friction's width and 0.3 % of the
    largest speed) for six time constants of the observer and the record has no gap: at rest, friction balances any
    force up to its level.
    """

    def __init__(self, log: Log, model: Model, *, rest: float | None = None) -> None:
        self.log = log
        sample_time = float(np.median(np.diff(log.time)))
        self.gap = max(5.0 * sample_time, 0.1 / BANDWIDTH)
        time = log.time - log.time[0]  # time counts from the first row
        options: dict[str, Any] = {"bandwidth": BANDWIDTH, "gap": self.gap, "initial_velocity": initial_velocity(log)}
        options["steps_per_sample"] = steps_needed(model, sample_time)
        self.predictor = Predictor(time, log.position, log.command, **options)
        self.scale = model.axis.mass * (2.0 * np.pi * BANDWIDTH) ** 2
        self._predicted = ((model, self.predictor.predict(quiet_plant(model))),) * 2
        self.along, self.velocity = self._predicted[0][1], self._predicted[0][1].velocity
        smooth = max(1, round(0.1 / BANDWIDTH / sample_time))
        speed = moving_average(self.velocity, smooth)
        self.scales = scales_of(log, speed, np.gradient(moving_average(self.velocity, 4 * smooth), log.time))
        self.rest = max(model.axis.coulomb_width, 3e-3 * float(np.abs(speed).max())) if rest is None else rest
        # Rows after long enough motion without a gap.
        turned = np.concatenate([[False], self.velocity[1:] * self.velocity[:-1] < 0.0])  # between two rows
        still = (np.abs(self.velocity) < self.rest) | turned
        broken = np.concatenate([[True], np.diff(log.time) > self.gap])
        settle = SETTLED / (2.0 * np.pi * BANDWIDTH)
        self.mask = (~(since(still, log.time) < settle) & ~(since(broken, log.time) < max(START, settle))).astype(float)

    def prediction(self, model: Model) -> Prediction:
        """The prediction of a model along this log; cached for the first model and the last. DivergedError."""
        for known, along in self._predicted:
            if known is model:
                return along
        along = self.predictor.predict(quiet_plant(model))
        self._predicted = (self._predicted[0], (model, along))
        return along

    def of(self, models: Sequence[Model]) -> FloatArray:
        """Residuals (V) of each model, (models, n); DivergedError: a prediction diverged."""
        if len(models) == 1:
            return np.asarray(self.scale * self.prediction(models[0]).innovation[None, :])
        return np.asarray(self.scale * self.predictor.innovations([quiet_plant(model) for model in models]))

    def columns(self, model: Model, parameters: Sequence[Parameter], scales: Scales) -> tuple[FloatArray, FloatArray]:
        """Residual (n,) and derivatives (p, n) by the parameters.

        Forces are differentiated along the prediction and propagated through the observer, other parameters by central
        differences of whole predictions.
        """
        plant, along = quiet_plant(model), self.prediction(model)
        columns = np.zeros((len(parameters), len(self.log)))
        kinds = [_kind(model, parameter.path) for parameter in parameters]
        forces, readings, others = (
            [i for i, its in enumerate(kinds) if its == kind] for kind in ("force", "reading", "other")
        )
        if forces:
            steps = [one_sided(model, parameters[i], scales.step(parameters[i])) for i in forces]
            plants = [plant, *(quiet_plant(step.above) for step in steps)]
            force = self.predictor.net_force(plants, along.middle_position, along.middle_velocity)
            # The same acceleration, as a force on the plant's own mass.
            force *= (plant.axis.mass / np.array([one.axis.mass for one in plants]))[:, None]
            force[1:] -= force[0]
            force = force[1:]
            force /= np.array([step.span for step in steps])[:, None]
            columns[forces] = self.scale * self.predictor.propagate(along, plant.axis.mass, force)
        if readings:
            errors = np.zeros((len(readings), len(self.log)))
            for row, i in zip(errors, readings, strict=True):
                step = one_sided(model, parameters[i], scales.step(parameters[i]))
                for mine, its in zip(step.above.effects, model.effects, strict=True):
                    if "reading" in mine.HOOKS:
                        row += laws_of(mine).reading_at(along.position) - laws_of(its).reading_at(along.position)
                row /= step.span
            columns[readings] = self.predictor.propagate(along, plant.axis.mass, np.zeros_like(errors), errors)
            columns[readings] *= self.scale
        if others:
            steps = []
            for parameter in (parameters[i] for i in others):
                width = scales.step(parameter)
                if parameter.path.startswith("effects.") and "state" in effect_at(model, parameter.path).HOOKS:
                    width = max(width, WIDE * abs(parameter.value))  # contacts make the residual jump
                steps.append(central(model, parameter, width))
            table = self.of([side for step in steps for side in (step.above, step.below)])
            columns[others] = (table[0::2] - table[1::2]) / np.array([step.span for step in steps])[:, None]
        return self.scale * along.innovation, columns


def _kind(model: Model, path: str) -> str:
    """Whether a parameter acts through forces without memory, as a small error of the reading, or otherwise."""
    if not path.startswith("effects."):
        return "force"
    effect = effect_at(model, path)
    if set(effect.HOOKS) <= LINEAR_HOOKS:
        return "force"
    # An error that grows along the travel (a scale) resembles mass and friction and is predicted exactly instead.
    return "reading" if "reading" in effect.HOOKS and kind_of(effect, Wave) is not None else "other"


def initial_velocity(log: Log) -> float:
    """Slope in the first row of the parabola through the first readings, m/s."""
    few = max(6, min(len(log) // 10, round(0.02 / float(np.median(np.diff(log.time))))))
    time, position = log.time[:few] - log.time[0], log.position[:few] - log.position[0]
    return float(np.polyfit(time / time[-1], position, 2)[1] / time[-1])
