"""One closed-loop run, of a model or of a plant and a controller."""

from __future__ import annotations

import os
from collections.abc import Mapping, Sequence
from dataclasses import replace
from typing import Any

import numpy.typing as npt

from cogging import _core
from cogging._core import Plant, Reference
from cogging.arrays import real_array
from cogging.calls import check_arguments
from cogging.effects.custom import Custom
from cogging.logs.log import Log
from cogging.model.controller import AnyController, ControllerParameters
from cogging.model.model import CONTROLLERS, PARAMETERS, Model
from cogging.simulation.arguments import LOG, MODEL, MOTION, PLANT, REFERENCE
from cogging.simulation.reference import motion_of, reference_to_dict


@check_arguments(model=MODEL, reference=REFERENCE)
def simulate(
    model: Model | str | os.PathLike[str],
    reference: Reference | Mapping[str, Any] | str | os.PathLike[str],
    *,
    controller: AnyController | ControllerParameters | None = None,
    duration: float = 0.0,
    seed: int = 0,
    steps_per_sample: int | None = None,
    record_estimates: bool = False,
    initial_position: float | None = None,
    initial_velocity: float = 0.0,
    added_command: npt.ArrayLike | None = None,
) -> Log:
    """Simulate a model in closed loop: reference -> controller -> axis -> encoder -> log.

    A pure function: the same arguments give the same bits. The command is held between samples. Runge-Kutta steps of
    fourth order integrate the axis, as many as keep their error below 1e-6 of the motion; with coulomb_width = 0 the
    axis sticks and slips.

    Args:
        model: a Model, or the path of a model file.
        reference: a motion, the fields of a reference file, or the path of one.
        controller: used instead of the model's controller: one of the core or its parameters, a CompiledController, or
            any object that is a Controller. The run works on a copy.
        duration: s; 0 = that of the reference file, or the end of the motion.
        seed: of force and encoder noise.
        steps_per_sample: least number of integration steps between two samples; None: the model's.
        record_estimates: record the controller's estimates, one row a sample.
        initial_position: m; None: the first position of the reference.
        initial_velocity: m/s.
        added_command: V, (n,), added to the controller's command: test pulses.

    Returns:
        The log with the true motion, and with the metadata that `repeat` needs.

    Raises:
        ValueError: an argument breaks its rule, the reference leaves the travel, or there is no controller.
        TypeError: the controller is not a Controller, or cannot be copied; says what it lacks.
        DivergedError: the axis left the travel by half its length, the state is not finite, or a sample needs more than
            1e5 steps; says when and where, or how fast.
        ControllerError: a user's controller raised, or returned no finite number; says when and in which row.

    Example:
        >>> log = cogging.simulate(model, move, seed=1)
        >>> print(f"{len(log)} rows, largest error {1e6 * abs(log.error).max():.0f} um")
        13201 rows, largest error 28 um
    """
    if not isinstance(model, Model):
        model = Model.read(model)
    if isinstance(controller, PARAMETERS):
        model, controller = model.replace(controller=controller, controller_type=None), None
    motion, own_duration = motion_of(reference)
    duration = duration or own_duration
    steps_per_sample = model.steps_per_sample if steps_per_sample is None else steps_per_sample
    metadata: dict[str, Any] = {"seed": seed, "steps_per_sample": steps_per_sample}
    if controller is not None:
        metadata["controller"] = "given"  # the log does not hold what it has learned
        kind = next((name for name, (_, known) in CONTROLLERS.items() if type(controller) is known), None)
        if kind is None:
            metadata["controller_class"] = f"{type(controller).__module__}.{type(controller).__qualname__}"
        parameters: Any = None if kind is None else controller.parameters  # type: ignore[union-attr]
        model = model.replace(controller=parameters, controller_type=kind)
    start = {"initial_position": (initial_position, None), "initial_velocity": (initial_velocity, 0.0)}
    metadata |= {name: value for name, (value, default) in start.items() if value != default}
    metadata["reference"] = reference_to_dict(motion) | ({"duration": duration} if duration else {})
    metadata["model"] = model.to_dict()
    own: Any = model.make_controller() if controller is None else controller
    options: dict[str, Any] = {"duration": duration, "seed": seed, "steps_per_sample": steps_per_sample}
    options |= {"initial_position": initial_position, "initial_velocity": initial_velocity}
    options |= {"record_estimates": record_estimates, "added_command": added_command}
    return replace(closed_loop(model.plant(), own, motion, **options), metadata=metadata)


@check_arguments(plant=PLANT, reference=MOTION)
def closed_loop(
    plant: Plant,
    controller: AnyController | ControllerParameters,
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
    """Simulate a plant under a controller along a reference, as `simulate` does for a model.

    The axis starts at rest on the reference unless stated otherwise. The log has no metadata, so that `repeat` does not
    apply to it.

    Args:
        plant: the machine.
        controller: one of the core or its parameters, a CompiledController, or any object that is a Controller. The run
            works on a copy.
        reference: the motion.
        duration: s; 0 = the end of the reference.
        seed, steps_per_sample, record_estimates, initial_position, initial_velocity, added_command: see simulate.

    Returns:
        The log, with the plant's true position and velocity.

    Raises:
        ValueError: the reference leaves the travel, or has no end and no duration is given.
        TypeError, DivergedError, ControllerError: as of simulate.

    Example:
        >>> plant = cogging.Plant(cogging.AxisParameters(mass=0.12, viscous=0.2))
        >>> pid = cogging.Pid(cogging.PidParameters(kp=9600.0, kd=48.0))
        >>> move = cogging.Sine(cogging.SineParameters(amplitude=0.01, frequency=2.0))
        >>> log = cogging.closed_loop(plant, pid, move, duration=0.5)
        >>> print(f"{len(log)} rows, largest error {1e6 * abs(log.error).max():.0f} um")
        2501 rows, largest error 209 um
    """
    options: dict[str, Any] = {"duration": duration, "seed": seed, "steps_per_sample": steps_per_sample}
    options |= {"initial_position": initial_position, "initial_velocity": initial_velocity}
    options |= {"record_estimates": record_estimates}
    options |= {"added_command": None if added_command is None else real_array("added_command", added_command)}
    return Log.of(_core.closed_loop(plant, controller, reference, **options))


@check_arguments(log=LOG)
def repeat(log: Log, *, effects: Sequence[Custom] = ()) -> Log:
    """Simulate a log again from its metadata: model, reference and seed; the same bits on the same version.

    Args:
        log: made by `simulate`, or read from a file to which such a log was written.
        effects: definitions of the model's custom effects (cogging.effects.Custom), which a log cannot hold.

    Returns:
        The same run.

    Raises:
        ValueError: the log was not simulated, or its controller was an object, which a log does not hold.

    Example:
        >>> bool((cogging.repeat(log).position == log.position).all())
        True
    """
    metadata = log.metadata
    for name in ("model", "reference", "seed"):
        if name not in metadata:
            got = ", ".join(metadata) or "nothing"
            raise ValueError(f"metadata: {name}: must be there to repeat a log, got {got}")
    if metadata.get("controller") == "given":
        raise ValueError("metadata: controller: must be the model's to repeat a log, got one given as an object")
    stated = ("seed", "steps_per_sample", "initial_position", "initial_velocity")
    options = {"steps_per_sample": 1} | {name: metadata[name] for name in stated if name in metadata}
    return simulate(Model.from_dict(metadata["model"], effects=effects), metadata["reference"], **options)
