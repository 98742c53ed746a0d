"""The setup of Malaize and Levine 2009: printed numbers, machines, controllers, motion and the accuracy of Table I.

Forces are accelerations in the paper: the mass is 1 and the command unit m/s^2. Lambda pushes (+), so F_cogging of this
project is -Lambda. Values that are not reported are assumed and marked as such; the amplitudes are calibrated on the
PID row and the pole radii on lambda* (studies.malaize2009.calibration). The observer row that follows is far better
than the printed one; causes.py has what the controllers may not have known.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from cogging import _core, effects
from cogging._core import CoggingModel, ObserverBased, Pid, Plant, PointToPoint, SplineHarmonics
from cogging.arrays import FloatArray
from cogging.design.observer import ObserverProblem
from cogging.design.pid import pid_gains
from cogging.files import shipped_toml
from cogging.logs.log import Log
from cogging.model.controller import ListedController
from cogging.papers.result import known, with_tuples
from cogging.simulation.batch import closed_loop_batch

# Not reported, assumed.
SAMPLE_RATE = 10_000.0  # Hz
DELAY = 1e-4  # s: one sample of computing
VISCOUS = 1.0  # 1/s
PID_POLE = -120.0  # 1/s, three times; the observer's position loop has the same real part (section IV.C)
OMEGA, DAMPING = 120.0, 1.0
DECAY_RATE = 3.0  # 1/s
VELOCITY_RATIO = 0.25  # velocity_min / velocity_max of the certificate
RAMP = 0.02  # s in which the acceleration rises: its jerk limit
DWELL, REPEATS = 0.2, 5

CONTROLLERS = ("PID", "observer")


@dataclass(frozen=True)
class Motor:
    """One motor of Table I."""

    name: str  # "ironcore" or "ironless"
    periods: tuple[float, ...]  # m (Table I)
    shape: tuple[float, ...]  # relative amplitudes, assumed; scaled to the PID's accuracy
    friction: float  # m/s^2, assumed
    resolution: float  # m, of the encoder, assumed
    velocity: float  # m/s, top speed, assumed
    acceleration: float  # m/s^2 (section V)
    stroke: float  # m, assumed
    accuracy: tuple[float, float]  # m, of PID and observer (Table I)
    lambda_star: float  # m/s^2 (Table I)


#: The motors by name (motors.toml).
_STATED = with_tuples(shipped_toml("papers/malaize2009/motors.toml"))
MOTORS = {name: Motor(name=name, **fields) for name, fields in _STATED.items()}


@dataclass(frozen=True)
class Calibrated:
    """The calibrated values of a motor (gains.toml)."""

    amplitude: float  # m/s^2, of the first period; the others follow by Motor.shape
    pole_radius: float  # r, 1/s
    lambda_star: float  # m/s^2, that the design certifies when all lambda_n are equal
    observer_gain: tuple[float, ...]  # K


def shipped(motor: Motor) -> Calibrated:
    """Return the calibrated values that come with the package (by studies.malaize2009.calibration)."""
    return Calibrated(**with_tuples(shipped_toml("papers/malaize2009/gains.toml")[motor.name]))


def problem(motor: Motor, pole_radius: float, **changes: Any) -> ObserverProblem:
    """Return the observer's design problem for a motor."""
    fields: dict[str, Any] = {"periods": list(motor.periods), "viscous": VISCOUS, "pole_radius": pole_radius}
    fields |= {"velocity_min": VELOCITY_RATIO * motor.velocity, "velocity_max": motor.velocity}
    fields |= {"omega": OMEGA, "damping": DAMPING, "decay_rate": DECAY_RATE}
    return ObserverProblem(**{**fields, **changes})


def plant(
    motor: Motor,
    amplitude: float,
    more: Sequence[Any] = (),
    *,
    phases: FloatArray | None = None,
    width: float = 0.0,
    delay: float = DELAY,
    noise: float = 0.0,
) -> Plant:
    """Return the machine (1), (2): each period one radian later, exact dry friction, one sample of delay.

    amplitude: of the first period, m/s^2; more: effects that the controllers do not know; phases: rad, (periods,);
    width: of the friction's change of sign, m/s; noise: of the encoder, m rms.
    """
    phases = np.arange(len(motor.periods), dtype=np.float64) if phases is None else phases
    sizes = -amplitude * np.array(motor.shape)
    sine, cosine = (sizes * np.cos(phases))[:, None], (sizes * np.sin(phases))[:, None]
    friction, travel = {"coulomb": motor.friction, "coulomb_width": width}, [-0.1, motor.stroke + 0.1]
    axis = _core.AxisParameters(mass=1.0, viscous=VISCOUS, travel=travel, **friction)
    cogging = CoggingModel(SplineHarmonics(periods=list(motor.periods)), sine, cosine)
    encoder = _core.EncoderParameters(resolution=motor.resolution, noise=noise)
    return Plant(axis, cogging=cogging, effects=[effects.CommandDelay(delay=delay), *more], encoder=encoder)


def cogging_rms(motor: Motor, amplitude: float) -> float:
    """Return the rms (m/s^2) of the cogging that the observer knows, by the amplitude of the first period."""
    return amplitude * float(np.sqrt(0.5 * np.sum(np.square(motor.shape))))


def reference(motor: Motor) -> PointToPoint:
    """Return strokes there and back at the motor's speed and acceleration (Fig. 2: lengths and rests are assumed)."""
    limits = {"velocity": motor.velocity, "acceleration": motor.acceleration, "jerk": motor.acceleration / RAMP}
    return PointToPoint(_core.PointToPointParameters(distance=motor.stroke, dwell=DWELL, repeats=REPEATS, **limits))


def pid(thrust: float = 1.0) -> ListedController:
    """Return the PID: three equal poles, feedforward of mass and mu; thrust: the motor's over the believed one."""
    kp, ki, kd = (thrust * gain for gain in pid_gains([PID_POLE] * 3, 1.0))
    gains: dict[str, Any] = {"kp": kp, "ki": ki, "kd": kd - thrust * VISCOUS}
    return Pid(_core.PidParameters(sample_rate=SAMPLE_RATE, **gains, mass=thrust, viscous=thrust))


def observer(motor: Motor, gains: Calibrated, *, thrust: float = 1.0, stretch: float = 1.0) -> ListedController:
    """Return the observer (6) with law (8), frozen below 1 % of the top speed; stretch: its over the true periods."""
    fields: dict[str, Any] = {"sample_rate": SAMPLE_RATE, "mass": thrust, "delay": DELAY}
    fields["periods"] = [stretch * period for period in motor.periods]
    return ObserverBased(problem(motor, gains.pole_radius).controller_parameters(gains.observer_gain, **fields))


def controllers(motor: Motor, gains: Calibrated, thrust: float = 1.0) -> dict[str, ListedController]:
    """Return PID and observer of Table I; thrust: the motor's over the one that both believe."""
    return {"PID": pid(thrust), "observer": observer(motor, gains, thrust=thrust)}


def run(machine: Plant, controller: ListedController, motor: Motor, *, strokes: int = 0) -> Log:
    """Return the log of a controller along the motor's first strokes; 0: all."""
    motion = reference(motor)
    return Log.of(_core.closed_loop(machine, controller, motion, duration=0.5 * strokes * motion.period))


def true_error(log: Log) -> FloatArray:
    """Return true position minus reference of a simulated log, m, (n,)."""
    return known(log.true_position) - known(log.reference)


def accuracy(log: Log, motor: Motor, *, cold: bool = False) -> float:
    """Return max |x - x*| (m) after the first stroke, rest included; cold: of the first stroke itself."""
    first = log.time < 0.5 * reference(motor).period
    return float(np.abs(true_error(log)[first if cold else ~first]).max())


def batch_errors(
    machines: Sequence[Plant],
    controllers: Sequence[ListedController],
    motor: Motor,
    *,
    strokes: int = 0,
    reduction: str = "true_error_max",
) -> FloatArray:
    """Return the accuracy, or the rms error, of each machine under its controller, m, (n,); infinite if it diverged.

    The number of a machine is the seed of its encoder noise; strokes: how many, from the start; 0: all.
    """
    motion, options = reference(motor), dict[str, Any](seeds=range(len(machines)), reductions=[reduction])
    half = 0.5 * motion.period
    found = closed_loop_batch(machines, controllers, motion, duration=strokes * half, start=half, **options)
    return np.nan_to_num(found.indexes[reduction], nan=np.inf)
