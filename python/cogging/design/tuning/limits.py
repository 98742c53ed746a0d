"""What gains must keep to on every machine."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any

from cogging.design.tuning.margins import GAIN_MOST, Push
from cogging.design.tuning.reached import INDEXES, MARGINS, Judge, Reached
from cogging.files import FieldError, refuse_unknown_keys
from cogging.model.model import is_number
from cogging.model.units import Units
from cogging.shown import quoted

PRESENT = "present"
ALL_END = "all runs come to their end"
BEYOND = 1e3  # times a limit: farther counts the same


@dataclass(frozen=True)
class Limit:
    """One limit.

    Attributes:
        name: of INDEXES.
        value: the largest that is allowed, or for a margin the smallest.
        units: labels of the model's units.
    """

    name: str
    value: float
    units: Units = field(default_factory=Units)

    @property
    def upper(self) -> bool:
        """Whether it is the largest that is allowed."""
        return INDEXES[self.name][1]

    def excess(self, value: float | None) -> float:
        """By how much a value breaks it, relative; 0 or less where it does not."""
        if value is None or not math.isfinite(value):
            return BEYOND
        ratio = value / self.value - 1.0 if self.upper else 1.0 - value / self.value
        return min(ratio, BEYOND)

    def text(self, value: float | None = None) -> str:
        """The limit in words, or beside it what was reached."""
        unit = INDEXES[self.name][0]
        unit = "" if unit == "1" else f" {self.units.of(unit)}"
        rule = f"{self.name}: {'at most' if self.upper else 'at least'} {self.value:.4g}{unit}"
        return rule if value is None else f"{rule}, reached {value:.4g}{unit}"


def asked_limits(told: Mapping[str, Any]) -> dict[str, float | Mapping[str, float]]:
    """Limits as they are told: a number each, or `{"present": factor}`.

    Raises:
        FieldError: one that is none, or whose value breaks a rule.
    """
    if not isinstance(told, Mapping):
        raise FieldError("", "limits", f"must be a table of limits by name, got {quoted(told)}")
    refuse_unknown_keys(told, INDEXES, "limits")
    for name, value in told.items():
        number = value
        if isinstance(value, Mapping):
            refuse_unknown_keys(value, (PRESENT,), f"limits.{name}")
            number = value.get(PRESENT)
        if not is_number(number) or not math.isfinite(number) or number <= 0:
            rule = 'must be a number above 0, or {"present": a number} times the present value'
            raise FieldError("limits", name, f"{rule}, got {quoted(value)}")
    if is_number(told.get("gain_margin")) and not 1.0 < told["gain_margin"] <= GAIN_MOST:
        raise FieldError("limits", "gain_margin", f"must be above 1, at most {GAIN_MOST:g}, got {told['gain_margin']}")
    if is_number(told.get("modulus_margin")) and told["modulus_margin"] >= 1.0:
        raise FieldError("limits", "modulus_margin", f"must be below 1, got {told['modulus_margin']}")
    return dict(told)


def limits_of(asked: Mapping[str, Any], present: Reached, units: Units) -> tuple[Limit, ...]:
    """The limits as numbers.

    Raises:
        FieldError: a limit stands on a present value that there is not.
    """
    limits = []
    for name, told in asked.items():
        now = getattr(present, name)
        if name == "modulus_margin" and now is None:
            raise FieldError("limits", name, "must be one of a controller with a linear part, which this one has not")
        if isinstance(told, Mapping):
            if now is None or not math.isfinite(now) or now <= 0:
                raise FieldError(
                    "limits", name, f"must be a number: the present gains have none to stand on, got {now}"
                )
            told = told[PRESENT] * now
        limits.append(Limit(name, float(told), units))
    return tuple(limits)


def excesses(
    limits: tuple[Limit, ...], gains: Mapping[str, float], reached: Reached, judge: Judge, push: Push
) -> dict[str, float]:
    """By how much gains break each limit, relative; 0 or less where they do not.

    A margin of delay or gain is asked for where its limit stands: the excess is the share of the machines on which the
    loop does not hold there.
    """
    found = {ALL_END: reached.failed / len(judge.machines)}
    loops = None
    for limit in limits:
        if limit.name not in MARGINS or getattr(reached, limit.name) is not None:
            found[limit.name] = limit.excess(getattr(reached, limit.name))
        elif reached.failed:
            found[limit.name] = 1.0
        elif limit.name == "modulus_margin":
            found[limit.name] = limit.excess(judge.modulus_margin(gains))
        else:
            loops = loops or judge.loops(gains, push)
            more = {"delay" if limit.name == "delay_margin" else "gain": limit.value}
            found[limit.name] = loops.share_lost(**more)
    return found


def kept_all(excess: Mapping[str, float]) -> bool:
    """Whether all limits are kept."""
    return all(value <= 0.0 for value in excess.values())
