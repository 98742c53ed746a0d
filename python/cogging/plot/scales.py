"""Units of what is drawn: the model's labels, a prefix that suits the size, micro sign and superscripts."""

from __future__ import annotations

import re
from dataclasses import dataclass
from typing import Any

import numpy as np
import numpy.typing as npt

from cogging.arrays import FloatArray
from cogging.calls import described

#: Units whose name takes a prefix, and from which size on (in itself) a quantity keeps its unit as it is.
PREFIXED = {"m": 1.0, "rad": 1.0, "s": 1.0, "V": 0.1, "A": 0.1, "N": 0.1, "Nm": 0.1, "m/s": 0.1, "rad/s": 0.1}
PREFIXES = ((1.0, ""), (1e-3, "m"), (1e-6, "u"), (1e-9, "n"))
MICRO = re.compile(r"(?<![A-Za-z])u(?=(?:m|rad|V|A|N|Nm|s)(?![A-Za-z]))")


@dataclass(frozen=True)
class Scale:
    """How a quantity is drawn.

    Attributes:
        factor: on its values, to be in `unit`.
        unit: as a label shows it; empty of a pure number.
    """

    factor: float
    unit: str

    def __call__(self, values: npt.ArrayLike) -> FloatArray:
        """Values in this unit."""
        return np.asarray(values, dtype=np.float64) * self.factor

    def label(self, name: str) -> str:
        """Name and unit, for an axis."""
        return f"{name} ({self.unit})" if self.unit else name


def scale_of(unit: str, *values: npt.ArrayLike | None, units: Any = None) -> Scale:
    """The scale that suits the largest of some values.

    Args:
        unit: of the values, in the terms of this package: "m", "V", "V/(m/s)"; "1" of a pure number.
        values: arrays of any shape; None and what is not finite count for nothing.
        units: labels of the model (cogging.Units), or None.
    """
    label = labelled(unit, units)
    if unit == "1":
        return Scale(1.0, "")
    if label not in PREFIXED:
        return Scale(1.0, pretty(label))
    largest = _largest(values)
    for size, prefix in PREFIXES:
        if largest >= size * PREFIXED[label] or (prefix == "n"):
            break
    if largest == 0.0:
        size, prefix = PREFIXES[0]
    # 0.3 of a volt is 300 mV and stays 0.3 V; what is shown in mm is at least 1 mm.
    return Scale(round(1.0 / size), pretty(f"{prefix}{label}"))


def labelled(unit: str, units: Any) -> str:
    """A unit of this package in the labels of a model (cogging.Units), or as it is without any."""
    if units is None:
        return unit
    if not callable(getattr(units, "of", None)):
        raise TypeError(f"units: must be cogging.Units(command=..., position=...), got {described(units)}")
    return str(units.of(unit))


def pretty(unit: str) -> str:
    """A unit with micro sign and superscripts: um, V/(m/s^2), V/sqrt(Hz)."""
    shown = MICRO.sub("µ", unit).replace("^2", "²").replace("^3", "³").replace("sqrt(Hz)", "√Hz")
    return shown.replace("$", r"\$")


def units_of(*things: Any) -> Any:
    """The labels of the first of these that has any: a model, or what holds one."""
    for thing in things:
        for holder in (thing, getattr(thing, "model", None)):
            units = getattr(holder, "units", None)
            if callable(getattr(units, "of", None)):
                return units
    return None


def _largest(values: tuple[npt.ArrayLike | None, ...]) -> float:
    sizes = [np.abs(np.asarray(one, dtype=np.float64)) for one in values if one is not None]
    return max((float(np.max(size, initial=0.0, where=np.isfinite(size))) for size in sizes), default=0.0)
