"""The interface of effects, for programs that know no effect by name."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from typing import Any, Protocol, TypeVar

import numpy as np
import numpy.typing as npt

from cogging._core import EFFECTS, AxisParameters, CoggingModel, smooth_sign
from cogging._core.effects import Knots as Knots
from cogging._core.effects import Place as Place
from cogging._core.effects import SplineKnots as SplineKnots
from cogging._core.effects import Travel as Travel
from cogging._core.effects import Turn as Turn
from cogging._core.effects import Wave as Wave
from cogging._core.effects import Window as Window
from cogging.arrays import FloatArray

Kind = Wave | Window | Knots | SplineKnots | Travel | Place | Turn
K = TypeVar("K", Wave, Window, Knots, SplineKnots, Travel, Place, Turn)


class Effect(Protocol):
    """Interface of every effect, built-in or `Custom`; the values of its fields are attributes."""

    @property
    def NAME(self) -> str:
        """Name in model files."""

    @property
    def LAW(self) -> str:
        """Formula."""

    @property
    def HOOKS(self) -> tuple[str, ...]:
        """Quantities it acts on."""

    @property
    def FIELDS(self) -> Mapping[str, tuple[str, str]]:
        """Unit and meaning of each field."""

    @property
    def ROLES(self) -> Mapping[str, Mapping[str, Any]]:
        """Role of each field in a search."""

    @property
    def KINDS(self) -> tuple[Kind, ...]:
        """Groups of fields."""

    def to_dict(self) -> dict[str, Any]:
        """Return all fields by name."""

    def replace(self, **changes: Any) -> Effect:
        """Return a copy with the given fields changed."""

    def resolved(self, axis: AxisParameters, cogging: CoggingModel | None = None) -> Effect:
        """Return a copy with the fields that come from the plant filled in."""


def laws_of(effect: Effect) -> Any:
    """Return the effect for its laws, functions of numbers and arrays; only those in its HOOKS exist.

    `force_at` (V) and `friction_level_at` (V, added to Fc) at positions, velocities and times; `gain_at` (added to the
    gain 1 of the command) at positions and times; `reading_at` (m) at positions.
    """
    return effect


def steady_friction(
    effects: Iterable[Effect], velocity: npt.ArrayLike, *, width: float = 0.0, position: float = 0.0
) -> FloatArray:
    """Return what effects add to friction at steady speeds (m/s), V: their levels times S(v), less their forces.

    width: of S(v), m/s; position: m.
    """
    friction, sign = np.zeros_like(velocity, dtype=np.float64), smooth_sign(velocity, width)
    for effect in effects:
        if "friction_level" in effect.HOOKS:
            friction += laws_of(effect).friction_level_at(position=position, velocity=velocity) * sign
        if "force" in effect.HOOKS:
            friction -= laws_of(effect).force_at(position=position, velocity=velocity)
    return friction


def kind_of(effect: Effect, kind: type[K]) -> K | None:
    """Return the first group of this kind of an effect's parameters, or None."""
    return next((one for one in effect.KINDS if isinstance(one, kind)), None)


#: Built-in effects by name, with neutral parameters.
VOCABULARY: dict[str, Effect] = {name: kind() for name, kind in EFFECTS.items()}
