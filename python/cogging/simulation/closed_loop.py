"""One run of a plant, its controller and a reference, each made by hand."""

from __future__ import annotations

import numpy.typing as npt

from cogging import _core
from cogging._core import Plant, Reference
from cogging.arrays import real_array
from cogging.calls import check_arguments
from cogging.logs.log import Log
from cogging.model.controller import AnyController
from cogging.simulation.arguments import MOTION, PLANT


@check_arguments(plant=PLANT, reference=MOTION)
def closed_loop(
    plant: Plant,
    controller: AnyController,
    reference: Reference,
    *,
    duration: float = 0.0,
    seed: int = 0,
    steps_per_sample: int = 1,
    record_estimates: bool = False,
    initial_position: float | None = None,
    initial_velocity: float = 0.0,
    added_command: npt.ArrayLike | None = None,
) -> Log:
    """Run a plant under a controller along a reference; `simulate` does the same for a model.

    A pure function: the controller given is copied, the noise comes from `seed`, the same call gives the same bits.
    Between samples the command is held and the axis integrated by Runge-Kutta steps of fourth order:
    `steps_per_sample`, or as many more as keep what they err by below 1e-6 of the motion. The axis starts at rest on
    the reference unless told otherwise. The log carries no metadata: `repeat` wants one that `simulate` made.

    Args:
        plant: the machine.
        controller: what computes the command, once a sample: of the core, compiled (CompiledController), or any object
            that is a Controller. It is not changed: the run works on a copy.
        reference: the motion.
        duration: s; 0 = the reference's own end.
        seed: of force and encoder noise.
        steps_per_sample: the fewest integration steps between two samples.
        record_estimates: also keep what the controller believed, one row a sample.
        initial_position: m; the reference's first position when None.
        initial_velocity: m/s.
        added_command: V, (n,), added to what the controller computes, before the limit: test pulses.

    Returns:
        The log, with the plant's true position and velocity beside the readings.

    Raises:
        ValueError: the reference leaves the travel, or a motion without an end and no duration.
        TypeError: the controller is none, or cannot be copied; says what it lacks.
        DivergedError: the state left the travel by half its length, is not finite, or is so fast that a sample needs
            more than 1e5 steps; says when and where, or how fast.
        ControllerError: a controller of one's own raised, or gave no finite number; says when and in which row.

    Example:
        >>> plant = cogging.Plant(cogging.AxisParameters(mass=0.12, viscous=0.2))
        >>> pid = cogging.Pid(cogging.PidParameters(kp=9600.0, kd=48.0))
        >>> move = cogging.Sine(cogging.SineParameters(amplitude=0.01, frequency=2.0))
        >>> log = cogging.closed_loop(plant, pid, move, duration=0.5)
        >>> print(f"{len(log)} rows, largest error {1e6 * abs(log.error).max():.0f} um")
        2501 rows, largest error 209 um
    """
    columns = _core.closed_loop(
        plant,
        controller,
        reference,
        duration=duration,
        seed=seed,
        steps_per_sample=steps_per_sample,
        record_estimates=record_estimates,
        initial_position=initial_position,
        initial_velocity=initial_velocity,
        added_command=None if added_command is None else real_array("added_command", added_command),
    )
    return Log.of(columns)
