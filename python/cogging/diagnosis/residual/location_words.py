"""Where a gap sits, in words: ranges of a coordinate, from rest, periods, shares."""

from __future__ import annotations

import numpy as np

from cogging.arrays import FloatArray
from cogging.diagnosis.residual.shape import JUMPS, MOMENTS, Shape
from cogging.diagnosis.thresholds import LOCATION


def shape_text(shape: Shape) -> str:
    """One line: coordinate, share of the gap, and the ranges in which the force differs from zero."""
    if shape.coordinate in MOMENTS:
        return f"{shape.coordinate}: {ranges(shape)}"
    return f"{shape.coordinate} explains {share_text(shape.share)} of the gap: {ranges(shape)}"


def ranges(shape: Shape) -> str:
    """In which ranges of a coordinate its force differs from zero, in words."""
    if shape.coordinate in MOMENTS:
        return _moments(shape)
    m = len(shape.places)
    sides = [("", shape.force, shape.deviation)]
    if len(shape.force) == 2 * m:
        sides = [
            ("forward", shape.force[:m], shape.deviation[:m]),
            ("backward", shape.force[m:], shape.deviation[m:]),
        ]
    if shape.coordinate == "velocity":
        return _about_rest(shape)
    told = []
    for side, force, deviation in sides:
        spans = [_span(shape, force, deviation, peak) for peak in _peaks(force, deviation)]
        if spans:
            told.append(((side + " ") if side else "") + ", ".join(spans))
    return "; ".join(told) or "spread over its whole range, strong nowhere"


def _moments(shape: Shape) -> str:
    """The largest of what happened, each with its moment."""
    order = sorted(range(len(shape.places)), key=lambda i: -abs(shape.force[i]))[: LOCATION.moments_told]
    size = length_text if shape.coordinate == JUMPS else (lambda value: f"{value:.2g} V")
    told = [f"{'+-'[int(shape.force[i] < 0.0)]}{size(abs(shape.force[i]))} at {shape.places[i]:.4g} s" for i in order]
    more = len(shape.places) - len(order)
    return ", ".join(told) + (f", and {more} more" if more > 0 else "")


def _peaks(force: FloatArray, deviation: FloatArray) -> list[int]:
    """The strongest place of each run of one sign, at most two runs, those of a tenth of the strongest and above."""
    strong = np.abs(force) > LOCATION.place_strong * np.where(deviation > 0.0, deviation, np.inf)
    runs, current = [], -1
    for i in range(len(force)):
        if not strong[i]:
            current = -1
        elif current < 0 or force[i] * force[current] < 0.0:
            runs.append(i)
            current = i
        elif abs(force[i]) > abs(force[runs[-1]]):
            runs[-1] = current = i
    runs.sort(key=lambda i: -abs(force[i]))
    return [i for i in runs[: LOCATION.runs_told] if abs(force[i]) >= LOCATION.run_strong * abs(force[runs[0]])]


def _span(shape: Shape, force: FloatArray, deviation: FloatArray, peak: int) -> str:
    strong = (np.abs(force) > LOCATION.place_strong * np.where(deviation > 0.0, deviation, np.inf)) & (
        force * force[peak] > 0.0
    )
    first = last = peak
    while first > 0 and strong[first - 1]:
        first -= 1
    while last + 1 < len(force) and strong[last + 1]:
        last += 1
    low, high = shape.places[first], shape.places[last]
    size = f"{force[peak]:+.2g} {'' if shape.coordinate.startswith(('friction', 'gain', 'drag')) else 'V'}".strip()
    if first == 0 and last == len(force) - 1:
        return f"{size} at most, of one sign over the whole range"
    if first == last:
        return f"{size} about {quantity_text(shape.places[peak], shape.unit)}"
    return f"{size} from {quantity_text(low, shape.unit)} to {quantity_text(high, shape.unit)}"


def _about_rest(shape: Shape) -> str:
    """Velocities are told from rest: how far, and in which direction."""
    told = {}
    for label, side in (("forward", 1.0), ("backward", -1.0)):
        mine = side * shape.places >= 0.0
        force, deviation = shape.force[mine], shape.deviation[mine]
        speed = np.abs(shape.places[mine])
        strong = np.abs(force) > LOCATION.place_strong * np.where(deviation > 0.0, deviation, np.inf)
        if (strong & (speed > 0.0)).any() or (strong.any() and len(speed) == 1):
            peak = int(np.argmax(np.abs(force) * strong))
            order = np.argsort(speed)
            ranked = strong[order] & (force[order] * force[peak] > 0.0)
            place = int(np.flatnonzero(order == peak)[0])
            first = last = place
            while first > 0 and ranked[first - 1]:
                first -= 1
            while last + 1 < len(order) and ranked[last + 1]:
                last += 1
            told[label] = (speed[order][first], speed[order][last], force[peak], last == len(order) - 1)
    if not told:
        rest = np.abs(shape.force) > LOCATION.place_strong * np.where(shape.deviation > 0.0, shape.deviation, np.inf)
        return "at rest" if rest.any() else "spread over its whole range, strong nowhere"
    parts = []
    for label, (low, high, force, to_the_end) in told.items():
        if low <= np.min(np.abs(shape.places)[shape.places != 0.0]):
            reach = "at any speed" if to_the_end else f"within {quantity_text(high, 'm/s')} of rest"
        elif to_the_end and high > LOCATION.speeds_apart * low:
            reach = f"above {quantity_text(low, 'm/s')}"
        elif high <= LOCATION.speeds_apart * low:
            reach = f"about {quantity_text(high, 'm/s')}"
        else:
            reach = f"from {quantity_text(low, 'm/s')} to {quantity_text(high, 'm/s')}"
        parts.append((reach, label, force))
    if len(parts) == 2 and parts[0][0].split()[0] == parts[1][0].split()[0]:
        reach = max((part[0] for part in parts), key=len)
        return f"{reach}, both directions: {parts[0][2]:+.2g} V forward, {parts[1][2]:+.2g} V backward"
    return "; ".join(f"{reach}, {label}: {force:+.2g} V" for reach, label, force in parts)


def quantity_text(value: float, unit: str) -> str:
    """A number with its unit, in milli where that reads better."""
    if unit in ("m", "m/s") and 0.0 < abs(value) < LOCATION.told_below:
        return f"{1e3 * value:.3g} m{unit}"
    return f"{value:.3g} {unit}"


def length_text(value: float) -> str:
    """A length in m, mm or um, four digits, since periods are known well."""
    if value < LOCATION.micro_below:
        return f"{1e6 * value:.4g} um"
    return f"{1e3 * value:.4g} mm" if value < LOCATION.told_below else f"{value:.4g} m"


def share_text(share: float) -> str:
    """A share in whole percent."""
    return f"{100.0 * share:.0f} %" if share >= LOCATION.share_told else "under 1 %"
