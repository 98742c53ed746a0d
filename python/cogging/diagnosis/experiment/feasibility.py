"""Whether a machine keeps to its limits on a motion: by the reference, and by the simulated closed loop."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from cogging._core import DivergedError, Sampled, closed_loop
from cogging.arrays import FloatArray
from cogging.diagnosis.experiment.limits import MotionLimits
from cogging.diagnosis.thresholds import MOTION
from cogging.estimation.statistics import moving_average
from cogging.logs.log import Log
from cogging.model.controller import AnyController
from cogging.model.model import Model


@dataclass(frozen=True)
class Run:
    """A simulated run, and what it takes of each limit.

    Attributes:
        log: readings and commands, noise included.
        taken: largest of each quantity over its limit, by the limit's name; above 1 it is exceeded.
    """

    log: Log
    taken: dict[str, float]

    @property
    def worst(self) -> float:
        """The largest share that is taken of any limit."""
        return max(self.taken.values())


def run_on(
    model: Model, controller: AnyController | None, motion: Sampled, limits: MotionLimits, seed: int
) -> Run | None:
    """Run the model along a motion and hold it against limits; None where the loop diverges or leaves the travel.

    Args:
        model: what runs.
        controller: controller; None: the model's.
        motion: its reference.
        limits: with travel and jerk (MotionLimits.of).
        seed: of the noise.
    """
    try:
        columns = closed_loop(
            model.plant(),
            model.make_controller() if controller is None else controller,
            motion,
            duration=motion.end,
            seed=seed,
            steps_per_sample=model.steps_per_sample,
        )
    except (DivergedError, ValueError):
        return None
    log = Log.of(columns)
    return Run(log, taken_of(motion, log, limits))


def taken_of(motion: Sampled, log: Log, limits: MotionLimits) -> dict[str, float]:
    """What a reference, and a run along it, take of each limit (see Run).

    The machine's acceleration is the mean over 20 ms of what its true speed does; the jerk is the reference's alone,
    for each new command makes the machine's jump. The axis must be able to stop inside its travel wherever it is:
    x +- v^2 / (2 a) is held against the ends.
    """
    samples = motion.samples
    time, asked_velocity = samples["time"], samples["reference_velocity"]
    asked_acceleration = samples["reference_acceleration"]
    position = log.true_position if log.true_position is not None else log.position
    velocity = log.true_velocity if log.true_velocity is not None else np.gradient(position, log.time)
    step = float(np.median(np.diff(log.time)))
    window = max(1, round(MOTION.lasting / step))
    acceleration = moving_average(np.gradient(velocity, log.time), window)
    taken = {
        "velocity": max(_largest(asked_velocity), _largest(velocity)) / limits.velocity,
        "acceleration": max(_largest(asked_acceleration), _largest(acceleration)) / limits.acceleration,
        "duration": float(time[-1]) / limits.duration,
    }
    if limits.jerk is not None:
        taken["jerk"] = _largest(np.diff(asked_acceleration) / np.diff(time)) / limits.jerk
    if limits.command is not None:
        taken["command"] = _largest(log.command) / limits.command
    if limits.travel is not None:
        low, high = limits.travel
        stop = velocity * np.abs(velocity) / (2.0 * limits.acceleration)
        half = 0.5 * (high - low)
        taken["travel"] = _largest(np.concatenate([position, position + stop]) - low - half) / half
    return taken


def _largest(values: FloatArray) -> float:
    return float(np.abs(values).max())
