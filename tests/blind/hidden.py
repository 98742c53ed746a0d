"""What a hidden effect is to the generator: a name, a shape, an amplitude that is scaled, and its true parameters."""

from collections.abc import Callable
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from . import truth
from .machines import Machine
from .motions import Motion
from .truth import Plan

Apply = Callable[[Plan, float], None]
#: Field name: value, unit, and the share of the value that is its standard deviation at lambda = 1 (None: not simple).
#: What depends on the amplitude is a function of it.
Parameters = dict[str, tuple[Any, str, Any]]


@dataclass
class Hidden:
    """An effect of one case before and after scaling.

    Attributes:
        start: first amplitude tried; low, high: physical range. What the amplitude is depends on the effect.
        apply: puts the effect of an amplitude into a plan, in place.
        fields: of the contract, for the usual shape, or where `any_shape_has_fields` for all.
        shape: "usual", or which other form of the same cause.
        tolerated: names that are no error where this effect, outside the vocabulary, is hidden.
        name: of the vocabulary, or of the list of effects outside it.
    """

    start: float
    low: float
    high: float
    apply: Apply
    fields: Parameters = field(default_factory=dict)
    shape: str = "usual"
    any_shape_has_fields: bool = False
    tolerated: tuple[str, ...] = ()
    name: str = ""

    def parameters(self, amplitude: float) -> Parameters:
        """Fields of the contract at an amplitude; empty where the shape has none."""
        fields = self.fields if self.shape == "usual" or self.any_shape_has_fields else {}
        return {
            name: tuple(part(amplitude) if callable(part) else part for part in entry) for name, entry in fields.items()
        }


Draw = Callable[[np.random.Generator, Machine, Motion], Hidden]


def listed(effects: dict[str, Draw]) -> Callable[[Draw], Draw]:
    """Decorate a function that draws an effect: it is listed under its name, which the effect bears."""

    def decorate(draw: Draw) -> Draw:
        def named(rng: np.random.Generator, machine: Machine, motion: Motion) -> Hidden:
            effect = draw(rng, machine, motion)
            effect.name = draw.__name__
            return effect

        effects[draw.__name__] = named
        return named

    return decorate


def sign(rng: np.random.Generator) -> float:
    return float(rng.choice([-1.0, 1.0]))


def sizes(unit: float, start: float, low: float, high: float) -> tuple[float, float, float]:
    """Amplitudes given as shares of a unit."""
    return start * unit, low * unit, high * unit


def wave(x: np.ndarray, period: float, phase: float, form: Callable[[np.ndarray], np.ndarray]) -> np.ndarray:
    """A wave over x: a form of its angle, a sine or one of shapes.any_wave."""
    return form(2 * np.pi * x / period + phase)


def quadratures(phase: float, unit: str) -> Parameters:
    """Fields of a wave of this phase as sine and cosine; each is known to amplitude / sqrt(lambda)."""
    cos, sin = np.cos(phase), np.sin(phase)
    return {
        "sine": (lambda a: a * cos, unit, lambda a: abs(a / (a * cos))),
        "cosine": (lambda a: a * sin, unit, lambda a: abs(a / (a * sin))),
    }


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


def set_scalars(amplitude_field: str, factor: float = 1.0, **others: float) -> Apply:
    """Make an effect whose amplitude times `factor` is one scalar of the plan, beside others that are fixed."""
    return lambda plan, amplitude: plan.set(**{amplitude_field: factor * amplitude}, **others)
