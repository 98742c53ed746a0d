"""The machine of the catalogue, its motions, and what an effect leaves on it of a model without the effect."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np

import cogging
from cogging.arrays import FloatArray
from cogging.design.experiment_motion import SURVEY, Element, planned
from cogging.design.motion_limits import MotionLimits
from cogging.effects.effect import Effect
from cogging.estimation.innovations import Innovations
from cogging.model.model import Model

SECONDS = 6.0  # of the motions
RATE = 1000.0  # Hz
REST = 0.005  # m/s, below which rows do not count
#: The motions, by what they are called: of the kinds of `cogging experiment`.
MOTIONS = {
    "even strokes": replace(SURVEY, parameters={**SURVEY.parameters, "speeds": 1.0}),
    "random moves": Element("random_moves", {"seed": 1.0, "slowest": 0.2}),
}
LIMITS = MotionLimits(travel=(0.0, 0.5), velocity=0.5, acceleration=10.0, jerk=1000.0, duration=SECONDS)


def machine() -> Model:
    """The small machine: a linear axis of a usual size with two harmonics of cogging, a PID and an encoder."""
    return cogging.Model(
        axis=cogging.AxisParameters(mass=0.12, viscous=0.166, coulomb=0.15, coulomb_width=1e-3, travel=[0.0, 0.5]),
        cogging=cogging.CoggingModel(
            cogging.SplineHarmonics(pitch=0.05, harmonics=[1, 2]), sine=[[0.08], [0.04]], cosine=[[0.0], [0.02]]
        ),
        encoder=cogging.EncoderParameters(resolution=0.5e-6),
        noise=cogging.NoiseParameters(force=0.005),
        controller=cogging.PidParameters(kp=2400.0, ki=2e4, kd=24.0, mass=0.12, viscous=0.166, sample_rate=RATE),
        controller_type="pid",
    )


def motion(name: str, seconds: float = SECONDS) -> Any:
    """One of MOTIONS."""
    return planned([MOTIONS[name]], replace(LIMITS, duration=seconds), RATE)


def left_by(effect: Effect, course: Any) -> tuple[FloatArray, dict[str, FloatArray]]:
    """What the model without the effect does not foresee, V, and where, in rows in motion; no noise, no encoder."""
    model = machine().replace(noise=cogging.NoiseParameters(), encoder=cogging.EncoderParameters())
    log = cogging.simulate(model.replace(effects=(effect,)), course)
    source = Innovations(log, model, rest=REST, quick_starts=True)
    kept, velocity = source.mask > 0, source.along.velocity
    rows = {"time": log.time, "position": log.position, "velocity": velocity}
    rows |= {"acceleration": np.gradient(velocity, log.time), "command": log.command}
    turn = 2.0 * np.pi * source.bandwidth / RATE
    as_force = ((1.0 - np.exp(-turn)) / turn) ** 2  # of the observer in steps: what a steady force of 1 V leaves is 1 V
    return as_force * source.of([model])[0][kept], {each: np.asarray(values)[kept] for each, values in rows.items()}
