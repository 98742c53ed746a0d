"""Which numbers of a controller are tuned, and between which ends."""

from __future__ import annotations

import inspect
import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Any

from cogging._core import Reference
from cogging.calls import did_you_mean
from cogging.files import FieldError, refuse_unknown_keys
from cogging.model.controller import AnyController
from cogging.model.model import Model, is_number
from cogging.shown import quoted
from cogging.simulation.varied import Setup, make_controller, numbers_of, with_numbers

#: The gains that are tuned where none is named: those of these fields that are not zero.
USUAL: dict[str, tuple[str, ...]] = {
    "pid": ("kp", "ki", "kd"),
    "cascade": ("kp", "kv"),
    "speed": ("kp",),
    "arc": ("error_gain", "feedback_gain", "disturbance_adaptation", "cogging_adaptation"),
    "dcarc": ("error_gain", "feedback_gain", "disturbance_adaptation", "cogging_adaptation"),
    "output_feedback_arc": ("gain_1", "gain_2", "adaptation[0]", "adaptation[1]", "adaptation[2]"),
    "observer_based": ("position_gain", "velocity_gain"),
}
DECADE = 10.0  # above and below the present value, where none is named
KEYS = ("from", "to", "scale", "start")
CONTROLLER = "controller."


@dataclass(frozen=True)
class Gain:
    """One number that is tuned.

    Attributes:
        path: `controller.kp` of a model, or the name of an argument of one's own function.
        low, high: its ends.
        logarithmic: whether it is searched evenly in the logarithm.
        present: its value as it is, within the ends or not.
        whole: whether it is a whole number.
    """

    path: str
    low: float
    high: float
    logarithmic: bool
    present: float
    whole: bool = False

    @property
    def inside(self) -> bool:
        """Whether the present value lies within the ends."""
        return self.low <= self.present <= self.high


@dataclass(frozen=True)
class Tuned:
    """What is tuned: the gains, and how a controller is made of them.

    Attributes:
        gains: by path.
        make: the controller of values of the gains.
        model: the model with these values in its controller, or None where the controller is one's own.
    """

    gains: tuple[Gain, ...]
    make: Callable[[Mapping[str, float]], AnyController]
    model: Callable[[Mapping[str, float]], Model | None]

    @property
    def present(self) -> dict[str, float]:
        """The values as they are."""
        return {gain.path: gain.present for gain in self.gains}


def tuned_of_model(model: Model, motion: Reference, told: Mapping[str, Any] | None) -> Tuned:
    """The gains of the model's controller; told: a table by path, None for the usual ones.

    Raises:
        ValueError: the model has no controller, or a path is no number of it (with the nearest).
        FieldError: a range breaks a rule.
    """
    make_controller(model)
    setup = Setup(model, motion)
    numbers = {path: value for path, value in numbers_of(setup).items() if path.startswith(CONTROLLER)}
    if told is None:
        told = _usual(model, numbers)
    for path in told:
        if path not in numbers:
            raise FieldError("gains", path, f"is no number of the controller; {did_you_mean(path, numbers)}")

    def with_gains(values: Mapping[str, float]) -> Model:
        return with_numbers(setup, values).model

    def make(values: Mapping[str, float]) -> AnyController:
        return with_gains(values).make_controller()

    fields = model.controller.to_dict() if model.controller is not None else {}
    gains = tuple(_gain(path, told[path], numbers[path], fields) for path in told)
    _require_some(gains)
    return Tuned(gains, make, with_gains)


def tuned_of_function(make: Callable[..., AnyController], told: Mapping[str, Any] | None) -> Tuned:
    """The gains of a controller of one's own, which a function makes of them by keyword.

    Raises:
        ValueError: no range is told, or the function has no such argument (with the nearest).
        FieldError: a range breaks a rule.
    """
    parameters = inspect.signature(make).parameters
    open_ended = any(one.kind is one.VAR_KEYWORD for one in parameters.values())
    gains = []
    for path, how in (told or {}).items():
        if path not in parameters and not open_ended:
            raise FieldError("gains", path, f"is no argument of the controller; {did_you_mean(path, parameters)}")
        value = parameters[path].default if path in parameters else None
        gains.append(_gain(path, how, value if is_number(value) else None, {}))
    _require_some(gains)
    return Tuned(tuple(gains), lambda values: make(**values), lambda values: None)


def _usual(model: Model, numbers: Mapping[str, float | None]) -> dict[str, Any]:
    names = [f"{CONTROLLER}{name}" for name in USUAL.get(model.controller_type or "", ())]
    values = {name: float(numbers.get(name) or 0.0) for name in names}
    return {
        name: {"from": value / DECADE, "to": value * DECADE, "scale": "log"}
        for name, value in values.items()
        if value > 0.0
    }


def _require_some(gains: tuple[Gain, ...] | list[Gain]) -> None:
    if not gains:
        raise FieldError("", "gains", "must name at least one, got none")


def _gain(path: str, told: Any, present: float | None, fields: Mapping[str, Any]) -> Gain:
    """One gain of what is told of it: a table of KEYS.

    Raises:
        FieldError: it breaks a rule.
    """
    if not isinstance(told, Mapping):
        raise FieldError("gains", path, f"must be a table with from and to, got {quoted(told)}")
    refuse_unknown_keys(told, KEYS, f"gains.{path}")
    for key in ("from", "to"):
        if key not in told:
            raise FieldError("gains", path, f"{key}: must be given, got nothing")
    for key, value in told.items():
        if key != "scale" and not (is_number(value) and math.isfinite(value)):
            raise FieldError("gains", path, f"{key}: must be a number, got {quoted(value)}")
    low, high = float(told["from"]), float(told["to"])
    if not low < high:
        raise FieldError("gains", path, f"from: must be below to = {high:g}, got {low:g}")
    scale = told.get("scale", "log" if low > 0.0 else "linear")
    if scale not in ("log", "linear"):
        raise FieldError("gains", path, f"scale: must be linear or log, got {quoted(scale)}")
    if scale == "log" and low <= 0.0:
        raise FieldError("gains", path, f"from: must be above 0 on a logarithmic scale, got {low:g}")
    middle = math.sqrt(low * high) if scale == "log" else 0.5 * (low + high)
    start = float(told["start"]) if "start" in told else middle if present is None else float(present)
    name, _, place = path.removeprefix(CONTROLLER).partition("[")
    entry = fields.get(name)
    if place and isinstance(entry, list):
        entry = entry[int(place.rstrip("]"))]
    whole = isinstance(entry, int) and not isinstance(entry, bool)
    if whole and (low != int(low) or high != int(high)):
        raise FieldError("gains", path, f"from, to: must be whole numbers, got {low:g} and {high:g}")
    return Gain(path, low, high, scale == "log", start, whole)
