"""A parameter of an effect of the user's own."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any, Literal

from cogging.shown import nearest

#: What an amplitude without bounds is measured against, by its unit, and up to how many times that.
BY_UNIT = {
    "V": ("force", 1.0),
    "V/m": ("force_per_position", 1.0),
    "V/(m/s)": ("force_per_velocity", 1.0),
    "V/(m/s)^2": ("force_per_velocity_squared", 1.0),
    "1": ("relative", 1.0),
    "m": ("distance", 0.01),
}
QUANTITIES = (
    *("one", "relative", "exponent", "force", "command", "friction", "force_per_position", "force_per_velocity"),
    *("force_per_velocity_squared", "stiffness", "position", "distance", "angle", "velocity", "time", "sample_time"),
    *("frequency", "absolute"),
)


@dataclass(frozen=True)
class Parameter:
    """A parameter of an effect of the user's own, and what a search may do with it.

    Attributes:
        value: a number, or a list of numbers.
        unit: SI and the command unit, as "V/(m/s)"; "1" has none.
        meaning: in a few words.
        role: "amplitude": the law is linear in it and vanishes at 0; "shape": it is not; "setting": chosen,
            never searched for.
        low, high: where to search, in the parameter's own unit, or in multiples of `quantity` where that is given. An
            amplitude may leave them out: then its unit says what size is plausible.
        quantity: what low and high are multiples of (see cogging.effects), None: of 1 in the parameter's own unit.
        logarithmic: whether to step in the logarithm.
        neutral: of a shape, the value at which the effect does nothing, if there is one.
    """

    value: float | Sequence[float]
    unit: str = "1"
    meaning: str = ""
    role: Literal["amplitude", "shape", "setting"] = "amplitude"
    low: float | None = None
    high: float | None = None
    quantity: str | None = None
    logarithmic: bool = False
    neutral: float | None = None

    def __post_init__(self) -> None:
        if self.role not in ("amplitude", "shape", "setting"):
            raise ValueError(f"role: must be amplitude, shape or setting, got {self.role!r}")
        if self.quantity is not None and self.quantity not in QUANTITIES:
            got = f"{self.quantity!r}{nearest(self.quantity, QUANTITIES)}"
            raise ValueError(f"quantity: must be one of {', '.join(QUANTITIES)}, got {got}")
        if (self.low is None) != (self.high is None):
            raise ValueError(f"low, high: both or neither must be given, got {self.low} and {self.high}")
        if self.low is not None and self.high is not None:
            if not (math.isfinite(self.low) and math.isfinite(self.high) and self.low < self.high):
                raise ValueError(f"low, high: must be finite, low below high, got {self.low} and {self.high}")
            if self.logarithmic and self.low <= 0.0:
                raise ValueError(f"low: must be above 0 where steps are logarithmic, got {self.low}")
        listed = not isinstance(self.value, int | float)
        if self.role == "shape" and self.low is None and not listed:
            raise ValueError("low, high: must be given for a shape, got neither")
        if self.role == "amplitude":
            if self.low is None and self.quantity is None and self.unit not in BY_UNIT:
                raise ValueError(f"low, high: must be given for an amplitude in {self.unit!r}, got neither")
            if self.low is not None and not self.low <= 0.0 < float(self.high or 0.0):
                raise ValueError(f"low, high: must hold 0 for an amplitude, got {self.low} and {self.high}")
            if self.neutral not in (None, 0.0):
                raise ValueError(f"neutral: must be 0 for an amplitude, got {self.neutral}")


def role_of_parameter(parameter: Parameter, rubs: bool = False) -> dict[str, Any]:
    """The entry of ROLES; `rubs`: of a friction level alone."""
    listed = isinstance(parameter.value, Sequence)
    role: dict[str, Any] = {"role": parameter.role, "quantity": parameter.quantity or "absolute"}
    if parameter.role == "setting":
        return role | {"quantity": "one", "low": None, "high": None, "logarithmic": False, "neutral": None}
    low, high, neutral = parameter.low, parameter.high, parameter.neutral
    if parameter.role == "amplitude":
        neutral = [0.0] * len(parameter.value) if isinstance(parameter.value, Sequence) else 0.0  # type: ignore[assignment]
        if low is None:
            quantity, most = BY_UNIT.get(parameter.unit, ("one", 1.0))
            if rubs and quantity == "force":
                quantity, most = "friction", 2.0
            role["quantity"] = parameter.quantity or quantity
            low, high = -most, most
    elif low is None and listed:  # places along the travel
        role["quantity"], low, high = parameter.quantity or "position", 0.0, 1.0
    return role | {"low": low, "high": high, "logarithmic": parameter.logarithmic, "neutral": neutral}


def valid_value(effect: str, name: str, parameter: Parameter, value: Any) -> float | list[float]:
    """A value of a parameter, as a float or a list of floats."""
    listed = not isinstance(parameter.value, int | float)
    try:
        numbers = [float(one) for one in value] if listed else [float(value)]
    except (TypeError, ValueError):
        kind = "a list of numbers" if listed else "a number"
        raise ValueError(f"{effect}.{name}: must be {kind}, got {value!r}") from None
    for number in numbers:
        if not math.isfinite(number):
            raise ValueError(f"{effect}.{name}: must be a finite number, got {number:g}")
        if parameter.role == "shape" and not listed and parameter.low is not None and parameter.low > 0.0 >= number:
            raise ValueError(f"{effect}.{name}: must be above 0, got {number:g}")
    return numbers if listed else numbers[0]
