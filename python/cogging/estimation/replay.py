"""Residuals of the closed-loop replay from the reference alone."""

from __future__ import annotations

from collections.abc import Sequence
from functools import cached_property
from typing import Any

import numpy as np
import numpy.typing as npt

from cogging._core import DivergedError, Sampled, closed_loop
from cogging.arrays import FloatArray, real_array
from cogging.effects.effect import Effect, laws_of
from cogging.estimation.innovations import Innovations, initial_velocity
from cogging.estimation.residuals import quiet, steps_needed
from cogging.logs.log import Log
from cogging.model.model import Model
from cogging.model.parameters import Scales
from cogging.simulation.reductions import kept_of_runs

INVERSIONS = 20  # fixed-point iterations on the encoder error, whose slope is small


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
        self.log, self.period = log, sample_time
        self.added_command = None if added_command is None else real_array("added_command", added_command)
        time = np.arange(len(log)) * sample_time
        self.reference = Sampled(time, log.reference, log.reference_velocity, log.reference_acceleration)
        self.duration = float(time[-1])
        self._model = model
        # Below the width of the friction law the axis counts as at rest.
        start = initial_velocity(log)
        rests = abs(start) <= model.axis.coulomb_width or abs(start) <= self._seen.rest
        self.initial_velocity = 0.0 if rests else start

    @cached_property
    def _seen(self) -> Innovations:
        """The one-step prediction, used by fits alone."""
        return Innovations(self.log, self._model)

    @property
    def mask(self) -> FloatArray:
        """1 in rows that count, else 0, (n,)."""
        return self._seen.mask

    @property
    def scales(self) -> Scales:
        """Typical sizes of the log's quantities."""
        return self._seen.scales

    def as_run(self, model: Model) -> Model:
        """The model as it is run: without noise, and free to leave the travel."""
        model = quiet(model)
        # A run may leave the travel, but effects keep the parameters they take from it.
        effects = tuple(effect.resolved(model.axis, model.cogging) for effect in model.effects)
        return model.replace(axis=model.axis.replace(travel=[-np.inf, np.inf]), effects=effects)

    def run(self, model: Model) -> dict[str, FloatArray]:
        """The simulated columns of one model."""
        model = self.as_run(model)
        start = place_of_reading(float(self.log.position[0]), model.effects)
        options: dict[str, Any] = {"initial_position": start, "initial_velocity": self.initial_velocity}
        options |= {"added_command": self.added_command, "steps_per_sample": steps_needed(model, self.period)}
        return closed_loop(model.plant(), model.make_controller(), self.reference, duration=self.duration, **options)

    def of(self, models: Sequence[Model]) -> FloatArray:
        """Residuals (V) of each model, (models, n); DivergedError: a replay diverged."""
        as_run = [self.as_run(model) for model in models]
        kept = kept_of_runs(
            [model.plant() for model in as_run],
            [model.make_controller() for model in as_run],
            [self.reference],
            durations=[self.duration],
            seeds=(),
            steps_per_sample=[steps_needed(model, self.period) for model in as_run],
            columns=["command"],
            keeps_refused=True,
            initial_positions=[place_of_reading(float(self.log.position[0]), model.effects) for model in as_run],
            initial_velocity=self.initial_velocity,
            added_command=[] if self.added_command is None else self.added_command.tolist(),
        )
        for failure in kept.failures:
            self.run(models[failure.run])  # raises what ended it
        commands = np.array(kept.columns["command"])
        if not np.isfinite(commands).all():
            raise DivergedError("the replay diverged")
        return np.asarray(self.log.command - commands)


def place_of_reading(reading: float, effects: Sequence[Effect]) -> float:
    """The position (m) at which an encoder with these effects gives a reading (m)."""
    erring = [laws_of(effect) for effect in effects if "reading" in effect.HOOKS]
    place = reading
    for _ in range(INVERSIONS if erring else 0):
        place = reading - sum([float(np.ravel(effect.reading_at(position=[place]))[0]) - place for effect in erring])
    return place
