"""How far re-tuning may move mass and friction: as far as the model says that they are known."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field

from cogging.diagnosis.thresholds import ALLOWANCE
from cogging.model.model import Model

AXIS_PARAMETERS = ("mass", "viscous", "coulomb")


@dataclass(frozen=True)
class Allowance:
    """What the statement of a model leaves open.

    Attributes:
        floors, ceilings: ends of each parameter by path, in its unit.
        exact: paths of nuisances that are stated to be exact.
        most: what no machine that made the logs is above, by path.
    """

    floors: Mapping[str, float]
    ceilings: Mapping[str, float]
    exact: tuple[str, ...]
    most: Mapping[str, float] = field(default_factory=dict)

    def inside(self, path: str, value: float) -> bool:
        """Whether the statement allows a value; anything, of what it says nothing about."""
        room = ALLOWANCE.at_end * abs(value)
        return self.floors.get(path, -float("inf")) - room <= value <= self.ceilings.get(path, float("inf")) + room

    def far_outside(self, path: str, value: float) -> bool:
        """Whether a value is beyond what is allowed by more than a parameter itself is likely to have changed."""
        if path not in self.floors:
            return False  # amplitudes, of either sign
        high = self.ceilings.get(path, float("inf"))
        return value > ALLOWANCE.far * high or value < self.floors[path] / ALLOWANCE.far

    def nearest(self, path: str, value: float) -> float:
        """The allowed value that is nearest to one."""
        return min(max(value, self.floors.get(path, -float("inf"))), self.ceilings.get(path, float("inf")))

    def at_end(self, path: str, value: float) -> bool:
        """Whether a value stands at an end of what is allowed, or beyond."""
        room = ALLOWANCE.at_end * abs(value)
        low, high = self.floors.get(path, -float("inf")), self.ceilings.get(path, float("inf"))
        return value <= low + room or value >= high - room

    def without(self, paths: tuple[str, ...]) -> Allowance:
        """The allowance with some nuisances let go: farther, but as far as one machine may be from another."""
        far = ALLOWANCE.let_go
        return Allowance(
            {
                path: low if path not in paths else low / far if path == "axis.mass" else 0.0
                for path, low in self.floors.items()
            },
            {
                path: high if path not in paths else min(far * high, self.most.get(path, float("inf")))
                for path, high in self.ceilings.items()
            },
            tuple(path for path in self.exact if path not in paths),
            self.most,
        )


def allowance(model: Model, most: Mapping[str, float] | None = None) -> Allowance:
    """How far mass, viscous and Coulomb friction may be from what a model states, not above `most` by path.

    Within some of its stated deviations (ALLOWANCE.stated); not at all where it is stated to be exact; within a factor
    where nothing is stated (ALLOWANCE.unstated). A friction of zero that is not stated to be exact is not known at all.
    """
    floors: dict[str, float] = {}
    ceilings: dict[str, float] = {}
    exact: list[str] = []
    for name in AXIS_PARAMETERS:
        path, value, stated = f"axis.{name}", float(getattr(model.axis, name)), model.uncertainty.get(name)
        floors[path] = 0.0
        if stated == 0.0:
            exact.append(path)
            floors[path] = ceilings[path] = value
        elif stated is not None and value > 0.0:
            least = value / ALLOWANCE.let_go if name == "mass" else 0.0
            floors[path] = max(least, value * (1.0 - ALLOWANCE.stated * stated))
            ceilings[path] = value * (1.0 + ALLOWANCE.stated * stated)
        elif value > 0.0:
            floors[path], ceilings[path] = value / ALLOWANCE.unstated, value * ALLOWANCE.unstated
    for path, high in (most or {}).items():
        if path not in exact and floors[path] < high:
            ceilings[path] = min(ceilings.get(path, float("inf")), high)
    return Allowance(floors, ceilings, tuple(exact), most or {})
