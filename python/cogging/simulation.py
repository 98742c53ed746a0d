"""One closed-loop run of a model."""

from __future__ import annotations

import os
from collections.abc import Mapping
from typing import Any

import numpy as np
import numpy.typing as npt

from cogging._core import Reference, closed_loop
from cogging.logs import Log
from cogging.model import Controller, Model
from cogging.reference import read_reference, reference_from


def simulate(
    model: Model | str | os.PathLike[str],
    reference: Reference | Mapping[str, Any] | str | os.PathLike[str],
    *,
    controller: Controller | None = None,
    duration: float = 0.0,
    seed: int = 0,
    steps_per_sample: int = 1,
    record_estimates: bool = False,
    initial_position: float | None = None,
    initial_velocity: float = 0.0,
    added_command: npt.ArrayLike | None = None,
) -> Log:
    """Run an axis under its controller along a reference: reference -> controller -> axis -> encoder -> log.

    A pure function: the same arguments give the same bits. Between samples the command is held and the axis is
    integrated by `steps_per_sample` Runge-Kutta steps of fourth order; with coulomb_width = 0 it sticks and slips.

    Args:
        model: a Model, or the path of a model file.
        reference: a motion, the fields of a reference file, or the path of one.
        controller: a controller to use in place of the model's own; it is not changed.
        duration: s; 0 = that of the reference file, or the motion's own end.
        seed: of force and encoder noise.
        steps_per_sample: integration steps between two samples.
        record_estimates: also keep what the controller believed, one row a sample.
        initial_position: m; the reference's first position when None.
        initial_velocity: m/s.
        added_command: V, (n,), added to what the controller computes: test pulses.

    Raises:
        ValueError: an argument breaks its rule, the reference leaves the travel, or no controller is known.
        DivergedError: the run left the travel by half its length, or is not finite; says when and where.
    """
    metadata: dict[str, Any] = {"seed": seed, "steps_per_sample": steps_per_sample}
    if not isinstance(model, Model):
        model = Model.read(model)
    metadata["model"] = model.to_dict()
    if isinstance(reference, Mapping):
        metadata["reference"] = dict(reference)
        reference, own_duration = reference_from(reference)
        duration = duration or own_duration
    elif not isinstance(reference, Reference):
        metadata["reference_file"] = os.fspath(reference)
        reference, own_duration = read_reference(reference)
        duration = duration or own_duration
    columns = closed_loop(
        model.plant(),
        controller if controller is not None else model.make_controller(),
        reference,
        duration=duration,
        seed=seed,
        steps_per_sample=steps_per_sample,
        record_estimates=record_estimates,
        initial_position=initial_position,
        initial_velocity=initial_velocity,
        added_command=None if added_command is None else np.asarray(added_command, dtype=float),
    )
    return Log.of(columns, metadata)
