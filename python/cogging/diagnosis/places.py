"""A force that the model lacks, over one coordinate: where, how much of the gap; in words, and as an effect."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np

from cogging.arrays import FloatArray, Mask
from cogging.effects.effect import VOCABULARY, Effect, Knots
from cogging.model.units import Units

COORDINATE_UNITS = {
    "position": "m",
    "velocity": "m/s",
    "acceleration": "m/s^2",
    "time": "s",
    "command": "V",
    "frequency": "Hz",
}
STRONG = 3.0  # deviations from which a force at a place is told
WEAKER = 0.1  # of the strongest place: weaker runs of one sign are not told
RUNS = 2  # runs that are told
MILLI, MICRO = 0.1, 1e-4  # m or m/s below which lengths and speeds are told in milli, and lengths in micro


@dataclass(frozen=True)
class Shape:
    """A force of any shape in one coordinate, as far as what is left asks for one.

    Attributes:
        coordinate: name of what the force depends on.
        unit: unit of the coordinate, of V and m.
        places: values of the coordinate at which the force is told, (m,).
        force: force that the model lacks there, V, (m,) or (2 m,): of a position first forward, then backward.
        deviation: 1-sigma of each force.
        statistic: T of the score test of a force of any shape in this coordinate.
        log_p_value: ln of the probability that noise alone shows as much.
        share: of the gap's power, what this force explains of rows that it was not fitted to.
    """

    coordinate: str
    unit: str
    places: FloatArray
    force: FloatArray
    deviation: FloatArray
    statistic: float
    log_p_value: float
    share: float

    @property
    def sides(self) -> list[tuple[str, FloatArray, FloatArray]]:
        """Direction of motion ("" for both), force and deviation of each."""
        m = len(self.places)
        if len(self.force) != 2 * m:
            return [("", self.force, self.deviation)]
        return [("forward", self.force[:m], self.deviation[:m]), ("backward", self.force[m:], self.deviation[m:])]


def shape_text(shape: Shape, units: Units) -> str:
    """One line: coordinate, share of the gap, and the ranges in which the force differs from zero."""
    return f"{shape.coordinate} explains {share_text(shape.share)} of the gap: {ranges(shape, units)}"


def ranges(shape: Shape, units: Units) -> str:
    """In which ranges of a coordinate its force differs from zero, in words."""
    told = []
    for side, force, deviation in shape.sides:
        runs = _runs(force, np.abs(force) > STRONG * np.where(deviation > 0.0, deviation, np.inf))
        words = ", ".join(_run_text(shape, force, run, units) for run in runs)
        if words:
            told.append(f"{side} {words}".strip())
    return "; ".join(told) or "spread over its whole range, strong nowhere"


def _runs(force: FloatArray, strong: Mask) -> list[tuple[int, int]]:
    """First and last place of the strongest runs of one sign, the strongest first."""
    signs = np.sign(force) * strong
    edges = np.flatnonzero(np.diff(signs)) + 1
    runs = [
        (int(part[0]), int(part[-1])) for part in np.split(np.arange(len(force)), edges) if len(part) and signs[part[0]]
    ]
    size = {run: float(np.abs(force[run[0] : run[1] + 1]).max()) for run in runs}
    runs.sort(key=lambda run: -size[run])
    return [run for run in runs[:RUNS] if size[run] >= WEAKER * size[runs[0]]]


def _run_text(shape: Shape, force: FloatArray, run: tuple[int, int], units: Units) -> str:
    first, last = run
    peak = first + int(np.argmax(np.abs(force[first : last + 1])))
    size = f"{force[peak]:+.2g} {units.command}"
    if (first, last) == (0, len(force) - 1):
        return f"{size} at most, of one sign over the whole range"
    if first == last:
        return f"{size} about {quantity_text(shape.places[peak], shape.unit, units)}"
    low, high = (quantity_text(shape.places[at], shape.unit, units) for at in (first, last))
    return f"{size} from {low} to {high}"


def quantity_text(value: float, unit: str, units: Units) -> str:
    """A number with its unit, in milli where that reads better."""
    if unit in ("m", "m/s") and 0.0 < abs(value) < MILLI:
        return f"{1e3 * value:.3g} {units.of('m' + unit)}"
    return f"{value:.3g} {units.of(unit)}"


def length_text(value: float, units: Units) -> str:
    """A length in m, mm or um, four digits, since periods are known well."""
    if value < MICRO:
        return f"{1e6 * value:.4g} {units.of('um')}"
    return f"{1e3 * value:.4g} {units.of('mm')}" if value < MILLI else f"{value:.4g} {units.of('m')}"


def share_text(share: float) -> str:
    """A share in whole percent."""
    return f"{100.0 * share:.0f} %" if share >= 0.01 else "under 1 %"


def empirical_term(curve: Mapping[str, Any] | None) -> Effect | None:
    """The effect that is a force at nodes along the coordinate of a curve; None where there is none."""
    if curve is None or not {"places", "force"} <= set(curve):
        return None
    for law in VOCABULARY.values():
        for kind in law.KINDS:
            if not isinstance(kind, Knots) or law.ROLES[kind.nodes]["role"] != "setting":
                continue
            if kind.coordinate == curve["coordinate"] and "force" in law.HOOKS:
                force = np.reshape(curve["force"], (-1, len(curve["places"]))).mean(axis=0)  # of both directions
                return law.replace(**{kind.nodes: list(curve["places"]), kind.levels: np.nan_to_num(force).tolist()})
    return None
