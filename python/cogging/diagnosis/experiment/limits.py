"""What a machine may do in an experiment: the limits file."""

from __future__ import annotations

import math
import os
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

from cogging.calls import PATHS, takes, told_constructor
from cogging.diagnosis.thresholds import MOTION
from cogging.file_schema import LIMITS, LIMITS_NEEDED
from cogging.files import LARGEST, FieldError, read_text, read_toml, refuse_unknown_keys
from cogging.model.model import Model, is_number
from cogging.shown import quoted
from cogging.values import ByValue


@told_constructor
@dataclass(frozen=True, eq=False, repr=False)
class MotionLimits(ByValue):
    """What a machine may do in an experiment.

    Attributes:
        velocity: largest speed, m/s.
        acceleration: largest acceleration, m/s^2.
        duration: of the whole motion, s, from 2 to 600.
        travel: lower and upper end of where the axis may be, m; None: the model's.
        jerk: largest jerk of the reference, m/s^3; None: such that the acceleration takes 10 ms to its limit.
        command: largest command, V; None: the controller's own limit, none where it has none.

    Raises:
        FieldError: a ValueError that names field, rule and value.

    Example:
        >>> cogging.MotionLimits(velocity=0.5, acceleration=5.0, duration=20.0, travel=(0.0, 0.5))
        MotionLimits(0 to 0.5 m, 0.5 m/s, 5 m/s^2, 20 s)
    """

    velocity: float
    acceleration: float
    duration: float
    travel: tuple[float, float] | None = None
    jerk: float | None = None
    command: float | None = None

    def __post_init__(self) -> None:
        for name in ("velocity", "acceleration", "duration", "jerk", "command"):
            value = getattr(self, name)
            if value is None and name not in LIMITS_NEEDED:
                continue
            if not is_number(value) or not 0.0 < value <= LARGEST:
                raise FieldError("", name, f"must be a number above 0, at most {LARGEST:g}, got {quoted(value)}")
            object.__setattr__(self, name, float(value))
        if not MOTION.duration_min <= self.duration <= MOTION.duration_max:
            rule = f"must be from {MOTION.duration_min:g} to {MOTION.duration_max:g} s"
            raise FieldError("", "duration", f"{rule}, got {quoted(self.duration)}")
        if self.travel is not None:
            object.__setattr__(self, "travel", _travel(self.travel))

    def _brief(self) -> str:
        place = "" if self.travel is None else f"{self.travel[0]:g} to {self.travel[1]:g} m, "
        return f"{place}{self.velocity:g} m/s, {self.acceleration:g} m/s^2, {self.duration:g} s"

    @classmethod
    @takes(path=PATHS)
    def read(cls, path: str | os.PathLike[str]) -> MotionLimits:
        """Read a limits file (TOML): `velocity`, `acceleration`, `duration`, and optional the others.

        Args:
            path: of the file.

        Returns:
            The limits.

        Raises:
            InputError: the file cannot be used; names file, line, field, rule and value.

        Example:
            >>> with open("limits.toml", "w") as file:
            ...     _ = file.write("travel = [0.0, 0.5]\\nvelocity = 0.5\\nacceleration = 5.0\\nduration = 20.0")
            >>> cogging.MotionLimits.read("limits.toml")
            MotionLimits(0 to 0.5 m, 0.5 m/s, 5 m/s^2, 20 s)
        """
        document = read_toml(path)
        try:
            return cls.from_dict(document)
        except FieldError as error:
            raise error.in_file(path, read_text(path)) from None

    @classmethod
    def from_dict(cls, document: Mapping[str, Any]) -> MotionLimits:
        """Make limits of the fields of a limits file.

        Raises:
            FieldError: a ValueError that names field, rule and value.
        """
        refuse_unknown_keys(document, LIMITS, "")
        for name in LIMITS_NEEDED:
            if name not in document:
                raise FieldError("", name, "must be given, got nothing")
        return cls(**document)

    def to_dict(self) -> dict[str, Any]:
        """The fields of a limits file that are stated: what from_dict reads."""
        stated = {name: getattr(self, name) for name in LIMITS}
        return {name: list(v) if name == "travel" else v for name, v in stated.items() if v is not None}

    def of(self, model: Model) -> MotionLimits:
        """The limits with what they leave open taken from the model.

        Raises:
            FieldError: the travel is stated neither here nor by the model, or is not inside the model's.
        """
        low, high = (float(end) for end in model.axis.travel)
        travel = (low, high) if self.travel is None else self.travel
        if not (math.isfinite(travel[0]) and math.isfinite(travel[1])):
            raise FieldError("", "travel", "must be given where the model states none, got nothing")
        if not (low <= travel[0] and travel[1] <= high):
            raise FieldError(
                "",
                "travel",
                f"must be inside the model's, {low:g} to {high:g} {model.units.position}, got {list(travel)}",
            )
        own = 0.0 if model.controller is None else model.controller.command_limit
        command = min(self.command or math.inf, own or math.inf)
        jerk = self.acceleration / MOTION.jerk_rise if self.jerk is None else self.jerk
        return MotionLimits(
            self.velocity, self.acceleration, self.duration, travel, jerk, command if math.isfinite(command) else None
        )


def _travel(value: Any) -> tuple[float, float]:
    """The travel as two numbers.

    Raises:
        FieldError: it is none.
    """
    good = isinstance(value, list | tuple) and len(value) == 2 and all(is_number(end) for end in value)
    if not good or not all(abs(end) <= LARGEST for end in value) or not value[0] < value[1]:
        raise FieldError("", "travel", f"must be its lower and its upper end, m, got {quoted(value)}")
    return float(value[0]), float(value[1])
