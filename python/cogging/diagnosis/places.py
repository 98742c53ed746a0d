"""A missing force along one coordinate: its ranges and share of the gap in words, and as an empirical effect."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np

from cogging.arrays import FloatArray
from cogging.effects.effect import VOCABULARY, Effect, Knots
from cogging.model.units import Units
from cogging.plot.gaps import COORDINATES

COORDINATE_UNITS = {**COORDINATES, "frequency": "Hz"}
STRONG = 3.0  # standard deviations of a significant force
WEAKER = 0.1  # of the strongest force: weaker ranges are omitted
RUNS = 2  # maximum number of ranges
MILLI, MICRO = 0.1, 1e-4  # m or m/s: upper ends of milli- and micro-units


@dataclass(frozen=True)
class Shape:
    """An unexplained force along one coordinate.

    Attributes:
        coordinate: coordinate that the force depends on.
        unit: its unit in terms of V and m.
        places: nodes, (m,).
        force: missing force at the nodes, V, (m,), or (2 m,) for a position: first forward, then backward.
        deviation: standard deviation of each force.
        statistic: score statistic T of a generic force along this coordinate; 0 without a test.
        log_p_value: ln of the probability of such a statistic under the null hypothesis; 0 without a test.
        share: share of the gap's power that the force explains, cross-validated.
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
        """Direction of motion ("" for both), force and standard deviation of each."""
        m = len(self.places)
        if len(self.force) != 2 * m:
            return [("", self.force, self.deviation)]
        return [("forward", self.force[:m], self.deviation[:m]), ("backward", self.force[m:], self.deviation[m:])]


def shape_text(shape: Shape, units: Units) -> str:
    """Return coordinate, share of the gap and the ranges with a significant force in one line."""
    return f"{shape.coordinate} explains {share_text(shape.share)} of the gap: {ranges(shape, units)}"


def ranges(shape: Shape, units: Units) -> str:
    """Return the ranges of a coordinate with a significant force in words."""
    sides = []
    for side, force, deviation in shape.sides:
        strong = np.abs(force) > STRONG * np.where(deviation > 0.0, deviation, np.inf)
        signs = np.sign(force) * strong
        parts = np.split(np.arange(len(force)), np.flatnonzero(np.diff(signs)) + 1)
        runs = [(int(part[0]), int(part[-1])) for part in parts if len(part) and signs[part[0]]]
        size = {run: float(np.abs(force[run[0] : run[1] + 1]).max()) for run in runs}
        runs.sort(key=lambda run: -size[run])
        runs = [run for run in runs[:RUNS] if size[run] >= WEAKER * size[runs[0]]]
        words = ", ".join(_run_text(shape, force, run, units) for run in runs)
        if words:
            sides.append(f"{side} {words}".strip())
    return "; ".join(sides) or "small over the whole range"


def _run_text(shape: Shape, force: FloatArray, run: tuple[int, int], units: Units) -> str:
    first, last = run
    peak = first + int(np.argmax(np.abs(force[first : last + 1])))
    size = f"{force[peak]:+.2g} {units.command}"
    if (first, last) == (0, len(force) - 1):
        return f"up to {size}, of one sign over the whole range"
    if first == last:
        return f"{size} near {quantity_text(shape.places[peak], shape.unit, units)}"
    low, high = (quantity_text(shape.places[at], shape.unit, units) for at in (first, last))
    return f"{size} from {low} to {high}"


def quantity_text(value: float, unit: str, units: Units) -> str:
    """Return a number with its unit, in milli-units if small."""
    if unit in ("m", "m/s") and 0.0 < abs(value) < MILLI:
        return f"{1e3 * value:.3g} {units.of('m' + unit)}"
    return f"{value:.3g} {units.of(unit)}"


def length_text(value: float, units: Units) -> str:
    """Return a length in m, mm or um with four digits."""
    if value < MICRO:
        return f"{1e6 * value:.4g} {units.of('um')}"
    return f"{1e3 * value:.4g} {units.of('mm')}" if value < MILLI else f"{value:.4g} {units.of('m')}"


def share_text(share: float) -> str:
    """Return a share in whole percent."""
    return f"{100.0 * share:.0f} %" if share >= 0.01 else "under 1 %"


def empirical_term(curve: Mapping[str, Any] | None) -> Effect | None:
    """Return the effect that interpolates the force of a curve along its coordinate, or None without such an effect."""
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
