"""What a machine may do in an experiment: the limits file, and how much of each limit a run uses."""

from __future__ import annotations

import math
import os
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from cogging._core import Sampled
from cogging.calls import PATHS, check_arguments, check_constructor
from cogging.estimation.statistics import moving_average
from cogging.file_schema import LIMITS, LIMITS_NEEDED
from cogging.files import LARGEST, FieldError, errors_of, read_toml, refuse_unknown_keys
from cogging.log_check.log_audit import audit
from cogging.logs.log import Log
from cogging.model.model import Model, is_number
from cogging.shown import quoted
from cogging.values import ByValue

DURATION = (2.0, 600.0)  # s, of a motion
JERK_RISE = 0.01  # s, in which the acceleration rises to its limit without a stated jerk
STROKE, RAMP = 0.5, 0.2  # travels a second, and s to that velocity, of drafted limits
LASTING = 0.02  # s, over which a machine's acceleration is averaged, against held commands and noise


@check_constructor
@dataclass(frozen=True, eq=False, repr=False)
class MotionLimits(ByValue):
    """The limits of a machine in an experiment.

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
        if not DURATION[0] <= self.duration <= DURATION[1]:
            rule = f"must be from {DURATION[0]:g} to {DURATION[1]:g} s"
            raise FieldError("", "duration", f"{rule}, got {quoted(self.duration)}")
        if (ends := self.travel) is not None:
            good = isinstance(ends, list | tuple) and len(ends) == 2 and all(is_number(end) for end in ends)
            if not good or max(map(abs, ends)) > LARGEST or not ends[0] < ends[1]:
                raise FieldError("", "travel", f"must be its lower and its upper end, m, got {quoted(ends)}")
            object.__setattr__(self, "travel", (float(ends[0]), float(ends[1])))

    def _brief(self) -> str:
        place = "" if self.travel is None else f"{self.travel[0]:g} to {self.travel[1]:g} m, "
        return f"{place}{self.velocity:g} m/s, {self.acceleration:g} m/s^2, {self.duration:g} s"

    @classmethod
    @check_arguments(path=PATHS)
    def read(cls, path: str | os.PathLike[str]) -> MotionLimits:
        """Read a limits file (TOML): `velocity`, `acceleration`, `duration`, and optional the others.

        Args:
            path: of the file.

        Returns:
            The limits.

        Raises:
            InputError: the file cannot be used; names file, line, field, rule and value.
        """
        with errors_of(path):
            return cls.from_dict(read_toml(path))

    @classmethod
    def from_dict(cls, document: Mapping[str, Any]) -> MotionLimits:
        """Make limits from the fields of a limits file; raises FieldError, which names field, rule and value."""
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
        """The limits, completed from the model.

        Raises:
            FieldError: the travel is stated neither here nor by the model, or is not inside the model's.
        """
        low, high = (float(end) for end in model.axis.travel)
        travel = self.travel or (low, high)
        if not all(map(math.isfinite, travel)):
            raise FieldError("", "travel", "must be given where the model states none, got nothing")
        if not (low <= travel[0] and travel[1] <= high):
            rule = f"must be inside the model's, {low:g} to {high:g} {model.units.position}"
            raise FieldError("", "travel", f"{rule}, got {list(travel)}")
        own = 0.0 if model.controller is None else model.controller.command_limit
        command = min((limit for limit in (self.command, own) if limit), default=None)
        return replace(self, travel=travel, jerk=self.jerk or self.acceleration / JERK_RISE, command=command)


def draft_limits(model: Model, logs: Sequence[Log] = ()) -> str:
    """Return the text of a limits file with what the model and logs show, and what is assumed."""
    found = [audit(log) for log in logs]
    low, high = model.axis.travel
    if not math.isfinite(high - low):
        if not found:
            rule = "must be given in the model, or a log in --logs, to draft limits"
            raise ValueError(f"axis.travel: {rule}, got neither")
        low, high = (end(one.travel[i] for one in found) for i, end in enumerate((min, max)))
    velocity, acceleration, command = STROKE * (high - low), STROKE * (high - low) / RAMP, 0.0
    source, ramp = f"assumed: the travel in {1.0 / STROKE:g} s", f"assumed: {RAMP:g} s to that velocity"
    if found:
        velocity, acceleration, command = (
            max(max(map(abs, getattr(one, name))) for one in found) for name in ("speed", "acceleration", "command")
        )
        source = ramp = "found: the largest in these logs"
    rows = [
        (f"velocity = {velocity:.3g}", "m/s", source),
        (f"acceleration = {acceleration:.3g}", "m/s^2", ramp),
        ("duration = 20.0", "s, of the whole motion", "assumed"),
        (f"travel = [{low:.6g}, {high:.6g}]", "m", "of the model" + " or these logs" * bool(found)),
        (f"# jerk = {acceleration / JERK_RISE:.3g}", "m/s^3", "what counts if it is not given"),
        *([(f"command = {command:.3g}", "V", source)] if command else []),
    ]
    lines = [f"{line:<27} # {model.units.of(unit)}; {meaning}" for line, unit, meaning in rows]
    return "\n".join(["## What the machine may do, drafted by `cogging experiment`: check each line.", *lines, ""])


def shares_of_limits(motion: Sampled, log: Log, limits: MotionLimits) -> dict[str, float]:
    """Largest of each quantity of a reference and a run along it, over its limit; above 1 the limit is exceeded.

    The machine's acceleration is averaged over 20 ms; the jerk is the reference's alone. The axis must be able to stop
    inside its travel: x +- v^2 / (2 a) counts.
    """
    planned = motion.samples
    position = log.true_position if log.true_position is not None else log.position
    velocity = log.true_velocity if log.true_velocity is not None else np.gradient(position, log.time)
    window = max(1, round(LASTING / float(np.median(np.diff(log.time)))))
    rows = {
        "velocity": (planned["reference_velocity"], velocity),
        "acceleration": (planned["reference_acceleration"], moving_average(np.gradient(velocity, log.time), window)),
        "duration": (planned["time"],),
        "jerk": (np.diff(planned["reference_acceleration"]) / np.diff(planned["time"]),),
        "command": (log.command,),
    }
    stated = {name: getattr(limits, name) for name in rows if getattr(limits, name) is not None}
    taken = {name: max(float(np.abs(each).max()) for each in rows[name]) / most for name, most in stated.items()}
    if limits.travel is not None:
        low, half = limits.travel[0], 0.5 * (limits.travel[1] - limits.travel[0])
        stop = position + velocity * np.abs(velocity) / (2.0 * limits.acceleration)
        taken["travel"] = float(np.abs(np.concatenate([position, stop]) - low - half).max()) / half
    return taken
