"""What a hidden effect is to the generator: a name, a shape, an amplitude that is scaled, and its true parameters."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field

import numpy as np

from . import truth
from .machines import Machine
from .truth import Plan

Apply = Callable[[Plan, float], None]
#: Field name: value, unit, and the share of the value that is its standard deviation at lambda = 1 (None: not simple).
Parameters = dict[str, tuple[float, str, float | None]]


@dataclass
class Hidden:
    """An effect of one case before and after scaling.

    Attributes:
        name: of the vocabulary, or of the list of effects outside it.
        shape: "usual", or which other form of the same cause.
        start: first amplitude tried; low, high: physical range. What the amplitude is depends on the effect.
        apply: puts the effect of an amplitude into a plan, in place.
        parameters: fields of the contract at an amplitude; empty where the shape has none.
        tolerated: names that are no error where this effect, outside the vocabulary, is hidden.
        law: friction law that the machine must have.
    """

    name: str
    shape: str
    start: float
    low: float
    high: float
    apply: Apply
    parameters: Callable[[float], Parameters] = field(default=lambda amplitude: {})
    tolerated: tuple[str, ...] = ()


def wave(x: np.ndarray, period: float, phase: float, form: Callable[[np.ndarray], np.ndarray] = np.sin) -> np.ndarray:
    """A wave over x: a form of its angle, a sine or one of shapes.any_wave."""
    return form(2 * np.pi * x / period + phase)


def quadratures(period_field: str, period: float, unit: str, phase: float, size: float, key: str = "m") -> Parameters:
    """Parameters of size sin(2 pi x / period + phase) as sine and cosine; each is known to size / sqrt(lambda)."""
    sine, cosine = size * np.cos(phase), size * np.sin(phase)
    return {
        period_field: (period, key, None),
        "sine": (sine, unit, abs(size / sine)),
        "cosine": (cosine, unit, abs(size / cosine)),
    }


def shares(plan: Plan, machine: Machine) -> np.ndarray:
    """Position along the travel, 0 to 1, at the points of the maps."""
    return (plan.positions - machine.travel[0]) / (machine.travel[1] - machine.travel[0])


def times(plan: Plan) -> np.ndarray:
    """Time of the samples from the first row, s."""
    return plan.instants - plan.instants[0]


def add_map(name: str, shape: Callable[[Plan], np.ndarray]) -> Apply:
    """Make an effect that adds amplitude times a shape to a map over the travel."""
    row = truth.MAPS.index(name)

    def apply(plan: Plan, amplitude: float) -> None:
        plan.maps[row] += amplitude * shape(plan)

    return apply


def add_row(name: str, shape: Callable[[Plan], np.ndarray]) -> Apply:
    """Make an effect that adds amplitude times a shape to a row over the samples."""
    column = truth.ROWS.index(name)

    def apply(plan: Plan, amplitude: float) -> None:
        plan.rows[:, column] += amplitude * shape(plan)

    return apply


def set_scalars(amplitude_field: str, **others: float) -> Apply:
    """Make an effect whose amplitude is one scalar of the plan, beside others that are fixed."""

    def apply(plan: Plan, amplitude: float) -> None:
        plan[amplitude_field] = amplitude
        for name, value in others.items():
            plan[name] = value

    return apply
