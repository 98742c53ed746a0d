"""One closed-loop run of a model."""

from __future__ import annotations

import os
from collections.abc import Mapping, Sequence
from typing import Any

import numpy.typing as npt

from cogging._core import Reference, closed_loop
from cogging.arrays import real_array
from cogging.calls import check_arguments
from cogging.effects.custom import Custom
from cogging.logs.log import Log
from cogging.model.controller import AnyController
from cogging.model.model import CONTROLLERS, Model
from cogging.simulation.arguments import LOG, MODEL, REFERENCE
from cogging.simulation.reference import read_reference, reference_from, reference_to_dict


@check_arguments(model=MODEL, reference=REFERENCE)
def simulate(
    model: Model | str | os.PathLike[str],
    reference: Reference | Mapping[str, Any] | str | os.PathLike[str],
    *,
    controller: AnyController | None = None,
    duration: float = 0.0,
    seed: int = 0,
    steps_per_sample: int | None = None,
    record_estimates: bool = False,
    initial_position: float | None = None,
    initial_velocity: float = 0.0,
    added_command: npt.ArrayLike | None = None,
) -> Log:
    """Run an axis under its controller along a reference: reference -> controller -> axis -> encoder -> log.

    A pure function: the same arguments give the same bits. Between samples the command is held and the axis is
    integrated by Runge-Kutta steps of fourth order, as many as keep what they err by below 1e-6 of the motion; with
    coulomb_width = 0 it sticks and slips.

    Args:
        model: a Model, or the path of a model file.
        reference: a motion, the fields of a reference file, or the path of one.
        controller: one to use in place of the model's own: of the core, compiled (CompiledController), or any object
            that is a Controller. It is not changed: the run works on a copy.
        duration: s; 0 = that of the reference file, or the motion's own end.
        seed: of force and encoder noise.
        steps_per_sample: the fewest integration steps between two samples; the model's own when None.
        record_estimates: also keep what the controller believed, one row a sample.
        initial_position: m; the reference's first position when None.
        initial_velocity: m/s.
        added_command: V, (n,), added to what the controller computes: test pulses.

    Returns:
        The log, with the true motion beside the readings, and in its metadata what `repeat` needs.

    Raises:
        ValueError: an argument breaks its rule, the reference leaves the travel, or no controller is known.
        TypeError: the controller is none, or cannot be copied; says what it lacks.
        DivergedError: the run left the travel by half its length, is not finite, or is so fast that a sample needs more
            than 1e5 steps; says when and where, or how fast.
        ControllerError: a controller of one's own raised, or gave no finite number; says when and in which row.

    Example:
        >>> log = cogging.simulate(model, move, seed=1)
        >>> print(f"{len(log)} rows, largest error {1e6 * abs(log.error).max():.0f} um")
        13201 rows, largest error 28 um
    """
    if not isinstance(model, Model):
        model = Model.read(model)
    motion, own_duration = _motion(reference)
    duration = duration or own_duration
    steps_per_sample = model.steps_per_sample if steps_per_sample is None else steps_per_sample
    metadata: dict[str, Any] = {"seed": seed, "steps_per_sample": steps_per_sample}
    if controller is not None:
        model, told = _stating(model, controller)
        metadata |= told
    start = {"initial_position": (initial_position, None), "initial_velocity": (initial_velocity, 0.0)}
    metadata |= {name: value for name, (value, usual) in start.items() if value != usual}
    metadata["reference"] = reference_to_dict(motion) | ({"duration": duration} if duration else {})
    metadata["model"] = model.to_dict()
    columns = closed_loop(
        model.plant(),
        model.make_controller() if controller is None else controller,
        motion,
        duration=duration,
        seed=seed,
        steps_per_sample=steps_per_sample,
        record_estimates=record_estimates,
        initial_position=initial_position,
        initial_velocity=initial_velocity,
        added_command=None if added_command is None else real_array("added_command", added_command),
    )
    return Log.of(columns, metadata)


def _motion(reference: Reference | Mapping[str, Any] | str | os.PathLike[str]) -> tuple[Reference, float]:
    """A motion, and the duration that its file states, 0 where it states none."""
    if isinstance(reference, Reference):
        return reference, 0.0
    return reference_from(reference) if isinstance(reference, Mapping) else read_reference(reference)


def _stating(model: Model, controller: Any) -> tuple[Model, dict[str, Any]]:
    """The model with the parameters of a given controller, none where it has none, and what a log tells of it."""
    told = {"controller": "given"}  # whatever it had learned is not in the log
    for kind, (_, made) in CONTROLLERS.items():
        if type(controller) is made:
            return model.replace(controller=controller.parameters, controller_type=kind), told
    told["controller_class"] = f"{type(controller).__module__}.{type(controller).__qualname__}"
    return model.replace(controller=None, controller_type=None), told


@check_arguments(log=LOG)
def repeat(log: Log, *, effects: Sequence[Custom] = ()) -> Log:
    """Run a simulated log again from what it carries: model, reference, seed; the same bits on the same version.

    Args:
        log: that `simulate` made, or that was read from a file it was written to.
        effects: definitions of the model's own effects (cogging.effects.Custom), which a log cannot hold.

    Returns:
        The same run once more.

    Raises:
        ValueError: the log was not simulated, or its controller was given as an object, which a log does not hold.

    Example:
        >>> bool((cogging.repeat(log).position == log.position).all())
        True
    """
    told = log.metadata
    for name in ("model", "reference", "seed"):
        if name not in told:
            raise ValueError(f"metadata: {name}: must be there to repeat a log, got {', '.join(told) or 'nothing'}")
    if told.get("controller") == "given":
        raise ValueError("metadata: controller: must be the model's to repeat a log, got one given as an object")
    return simulate(
        Model.from_dict(told["model"], effects=effects),
        told["reference"],
        seed=told["seed"],
        steps_per_sample=told.get("steps_per_sample", 1),
        initial_position=told.get("initial_position"),
        initial_velocity=told.get("initial_velocity", 0.0),
    )
