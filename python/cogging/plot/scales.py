"""Units of plots: labels of the model, a suitable prefix, micro sign and superscripts."""

from __future__ import annotations

import re
from dataclasses import dataclass
from typing import Any

import numpy as np
import numpy.typing as npt

from cogging.arrays import FloatArray
from cogging.calls import described

#: Units with prefixes, and the magnitude (in the unit) from which no prefix is used.
PREFIXED = {"m": 1.0, "rad": 1.0, "s": 1.0, "V": 0.1, "A": 0.1, "N": 0.1, "Nm": 0.1, "m/s": 0.1, "rad/s": 0.1}
PREFIXES = ((1.0, ""), (1e-3, "m"), (1e-6, "u"), (1e-9, "n"))
MICRO = re.compile(r"(?<![A-Za-z])u(?=(?:m|rad|V|A|N|Nm|s)(?![A-Za-z]))")


@dataclass(frozen=True)
class Scale:
    """Factor and unit of a plotted quantity."""

    factor: float  # from values to `unit`
    unit: str  # in a label; empty for a pure number

    def __call__(self, values: npt.ArrayLike) -> FloatArray:
        """Return values in this unit."""
        return np.asarray(values, dtype=np.float64) * self.factor

    def label(self, name: str) -> str:
        """Return name and unit, for an axis."""
        return f"{name} ({self.unit})" if self.unit else name


def scale_of(unit: str, *values: npt.ArrayLike | None, units: Any = None) -> Scale:
    """Return the scale that suits the largest of some values; unit: in V and m; units: labels of the model, or None."""
    label = labelled(unit, units)
    if unit == "1":
        return Scale(1.0, "")
    if label not in PREFIXED:
        return Scale(1.0, pretty(label))
    sizes = [np.abs(np.asarray(one, dtype=np.float64)) for one in values if one is not None]
    largest = max((float(np.max(size, initial=0.0, where=np.isfinite(size))) for size in sizes), default=0.0)
    fitting = (one for one in PREFIXES if largest >= one[0] * PREFIXED[label])
    size, prefix = next(fitting, PREFIXES[-1]) if largest > 0.0 else PREFIXES[0]
    # 0.3 V stays 0.3 V; values in mm are at least 1 mm.
    return Scale(round(1.0 / size), pretty(f"{prefix}{label}"))


def labelled(unit: str, units: Any) -> str:
    """Return a unit in V and m with the labels of a model (cogging.Units), if any."""
    if units is None:
        return unit
    if not callable(getattr(units, "of", None)):
        raise TypeError(f"units: must be cogging.Units(command=..., position=...), got {described(units)}")
    return str(units.of(unit))


def pretty(unit: str) -> str:
    """Return a unit with micro sign and superscripts: um, V/(m/s^2), V/sqrt(Hz)."""
    shown = MICRO.sub("µ", unit).replace("^2", "²").replace("^3", "³").replace("sqrt(Hz)", "√Hz")
    return shown.replace("$", r"\$")


def units_of(*things: Any) -> Any:
    """Return the unit labels of the first object that has any, or whose model has."""
    for thing in things:
        for holder in (thing, getattr(thing, "model", None)):
            units = getattr(holder, "units", None)
            if callable(getattr(units, "of", None)):
                return units
    return None
