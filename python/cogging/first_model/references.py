"""The reference among the columns of a log, and its derivatives: what the position follows."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from cogging.arrays import FloatArray
from cogging.first_model.column_guess import ColumnGuess, placed
from cogging.first_model.headers import Header
from cogging.first_model.units import LIKELY, STATED, TRIED, UNKNOWN, Unit, stated_unit

ALIKE = 0.3  # of the position's span: rms by which a reference may leave it
DERIVATIVE = 0.1  # of its rms, by which a reference's derivative may differ from its difference


def references(
    used: dict[str, ColumnGuess],
    found: dict[str, tuple[str, str, str]],
    headers: Mapping[str, Header],
    table: Mapping[str, FloatArray],
    scale: Mapping[str, float],
    notes: list[str],
) -> None:
    """Add the reference and its derivatives, where the position follows it."""
    named = [h for h in headers.values() if h.kind == "reference" and h.label in table]
    named = [headers[found["reference"][0]]] if "reference" in found else sorted(named, key=lambda h: h.rank)
    position = used["position"]
    x = position.unit.factor * table[position.label]
    for header in named:
        unit, told = _unit_of_reference(header, position, x, table[header.label], scale)
        if unit is None:
            notes.append(f"{header.label!r} is named like a reference, but the position does not follow it: not used")
            continue
        used["reference"] = placed("reference", header, headers, unit, told, STATED)
        break
    if "reference" not in used:
        return
    reference = used["reference"]
    t = used["time"].unit.factor * table[used["time"].label]
    x = reference.unit.factor * table[reference.label]
    for name in ("reference_velocity", "reference_acceleration"):
        x = np.gradient(x, t)
        named = [h for h in headers.values() if h.kind == name and h.label in table]
        for header in named[:1]:
            factor = _factor_of_derivative(x, table[header.label])
            if factor is None:
                break
            unit = Unit(factor, "", f"the {'first' if name.endswith('y') else 'second'} derivative of it", LIKELY)
            used[name] = placed(name, header, headers, unit, "by its name", STATED)


def _unit_of_reference(
    header: Header, position: ColumnGuess, x: FloatArray, values: FloatArray, scale: Mapping[str, float]
) -> tuple[Unit | None, str]:
    """The unit in which a position follows a reference; None where it follows in none."""
    label = position.unit.label
    stated = LIKELY
    if "reference" in scale:
        return Unit(scale["reference"], label, f"times {scale['reference']:g} as stated", STATED), "as stated"
    own = stated_unit(header)
    factors = [own.factor] if own is not None else [position.unit.factor, *TRIED.get(label, TRIED["m"]).values()]
    if own is not None:
        stated = STATED
    for sign in (1.0, -1.0):
        for factor in dict.fromkeys(factors):
            off = x - sign * factor * values
            if float(np.std(off)) < ALIKE * float(np.std(x)):
                told = f"the position follows it{', with the other sign' if sign < 0.0 else ''}"
                said = (
                    f"in {header.unit} as its header says"
                    if stated == STATED
                    else "in the unit in which it is followed"
                )
                return Unit(sign * factor, label, said, stated if sign > 0.0 else UNKNOWN), told
    return None, ""


def _factor_of_derivative(difference: FloatArray, values: FloatArray) -> float | None:
    size = float(np.sqrt(np.mean(difference**2)))
    for factor in (1.0, -1.0, 1e-3, -1e-3, 1e-6, -1e-6, 60.0):
        if float(np.sqrt(np.mean((difference - factor * values) ** 2))) < DERIVATIVE * size:
            return factor
    return None
