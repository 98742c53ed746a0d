"""What all effects have in common, and what a program that knows none by name asks of them."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping
from typing import Any, Protocol, TypeVar, cast

from cogging._core import EFFECTS, AxisParameters, CoggingModel
from cogging._core.effects import Knots as Knots
from cogging._core.effects import Place as Place
from cogging._core.effects import SplineKnots as SplineKnots
from cogging._core.effects import Travel as Travel
from cogging._core.effects import Turn as Turn
from cogging._core.effects import Wave as Wave
from cogging._core.effects import Window as Window

Kind = Wave | Window | Knots | SplineKnots | Travel | Place | Turn
K = TypeVar("K", Wave, Window, Knots, SplineKnots, Travel, Place, Turn)


class Effect(Protocol):
    """What every effect of a plant has, built-in or `Custom`: values of its fields are attributes."""

    @property
    def NAME(self) -> str:
        """Its name in model files."""

    @property
    def LAW(self) -> str:
        """Its formula."""

    @property
    def HOOKS(self) -> tuple[str, ...]:
        """What it acts on."""

    @property
    def FIELDS(self) -> Mapping[str, tuple[str, str]]:
        """Unit and meaning of each field."""

    @property
    def ROLES(self) -> Mapping[str, Mapping[str, Any]]:
        """What each field is to a search."""

    @property
    def KINDS(self) -> tuple[Kind, ...]:
        """What fields are together."""

    def to_dict(self) -> dict[str, Any]:
        """All fields by name."""

    def replace(self, **changes: Any) -> Effect:
        """A copy with the given fields changed."""

    def resolved(self, axis: AxisParameters, cogging: CoggingModel | None = None) -> Effect:
        """A copy whose fields that stand for those of the plant are filled in."""


class Laws(Effect, Protocol):
    """An effect whose laws are functions: those that its HOOKS name, on numbers and arrays."""

    @property
    def force_at(self) -> Callable[..., Any]:
        """Force (V) at positions, velocities and times."""

    @property
    def friction_level_at(self) -> Callable[..., Any]:
        """Level (V) added to Fc at positions, velocities and times."""

    @property
    def gain_at(self) -> Callable[..., Any]:
        """What is added to the gain 1 of the command at positions and times."""

    @property
    def reading_at(self) -> Callable[..., Any]:
        """What the encoder reads at positions, m."""


def laws_of(effect: Effect) -> Laws:
    """The effect, of whose laws only those may be asked that its HOOKS name."""
    return cast(Laws, effect)


def for_core(effects: Iterable[Effect]) -> list[Any]:
    """Effects as the core takes them: by its own types, each of which is an Effect."""
    return list(effects)


def kind_of(effect: Effect, kind: type[K]) -> K | None:
    """The first of this kind among what an effect's parameters are together, or None."""
    return next((one for one in effect.KINDS if isinstance(one, kind)), None)


#: Every effect of the list by its name, as it is when it does nothing.
VOCABULARY: dict[str, Effect] = {name: kind() for name, kind in EFFECTS.items()}
