"""Pairs of models for difference quotients in one parameter, within what its field allows."""

from __future__ import annotations

from dataclasses import dataclass

from cogging.model.model import Model
from cogging.model.parameters import Parameter, with_values


@dataclass(frozen=True)
class DifferenceStep:
    """Two models that differ in one parameter: df/dp is near (f(above) - f(below)) / span.

    Attributes:
        above: the model on one side.
        below: the model on the other, or the one that was asked about.
        span: by how much the parameter differs between them; negative where only a step down is allowed.
    """

    above: Model
    below: Model
    span: float


def central(model: Model, parameter: Parameter, step: float) -> DifferenceStep:
    """A step to either side; to one side alone where the other breaks the rule of the parameter's field."""
    ends = []
    for value in (parameter.value + step, parameter.value - step):
        try:
            ends.append((with_values(model, {parameter.path: value}), value))
        except ValueError:
            ends.append((model, parameter.value))
    (above, high), (below, low) = ends
    if not high > low:
        raise _no_step(parameter, step)
    return DifferenceStep(above, below, high - low)


def one_sided(model: Model, parameter: Parameter, step: float) -> DifferenceStep:
    """A step up from the model, or down where up breaks the rule of the parameter's field: enough for what is linear."""
    for signed in (step, -step):
        try:
            return DifferenceStep(with_values(model, {parameter.path: parameter.value + signed}), model, signed)
        except ValueError:
            continue
    raise _no_step(parameter, step)


def _no_step(parameter: Parameter, step: float) -> ValueError:
    return ValueError(
        f"{parameter.path}: must be able to move by {step:g} up or down for a derivative, got {parameter.value:g}"
    )
