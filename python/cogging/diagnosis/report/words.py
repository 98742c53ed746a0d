"""Clauses and lines of a result, for the screen and the page."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

from cogging.diagnosis.places import COORDINATE_UNITS
from cogging.effects.effect import Effect
from cogging.model.model import Model
from cogging.model.units import Units

if TYPE_CHECKING:
    from cogging.diagnosis.entries import Limit, NamedEffect, Step

HARMONIC = 0.01  # largest relative difference from a harmonic of the known pitch
DIGITS = 4  # of a number without an interval, and fewest of one with an interval
WHOLE = 6  # digits before the point of a number with an interval that is written without a power of ten


def term_text(term: Mapping[str, Any], unit: str) -> str:
    """Return a clause on an empirical term and the gaps without and with it."""
    text = f"added to the model as {term['name']}, which is empirical and names no cause: gap "
    text += f"({term['signal']}) {term['gap_before']:.4g} -> {term['gap_after']:.4g} {unit}"
    if term["confirm_after"] is not None:
        text += f", on the confirm logs {term['confirm_before']:.4g} -> {term['confirm_after']:.4g} {unit}"
    return text


def other_shape_text(effect: NamedEffect, units: Units) -> str:
    """Return a clause on an effect with a non-standard law; empty for others."""
    if not effect.shape:
        return ""
    text = "the force deviates from the standard law"
    if effect.curve is None:
        return f"{text} and is not a function of one coordinate: it is not in the model"
    places, force = effect.curve["places"], effect.curve["force"]
    most = int(np.argmax(np.abs(force)))
    coordinate = str(effect.curve["coordinate"])
    place = f"{places[most]:.3g} {units.of(COORDINATE_UNITS[coordinate])}"
    held = "; the model has it as an empirical force" if effect.in_model else ""
    return f"{text}, with a peak of {force[most]:+.2g} {units.command} near {coordinate} {place}{held}"


def harmonic_text(effect: NamedEffect, model: Model) -> str:
    """Return a clause on which harmonic of the known pitch or of a turn a wave is; empty if it is none."""
    rotary = model.units.position == "rad"
    pitch = None if model.cogging is None else 2.0 * np.pi / min(model.cogging.basis.wavenumbers)
    longest = 2.0 * np.pi if rotary else pitch
    if "period" not in effect.parameters or longest is None:
        return ""
    ratio = longest / float(np.ravel(effect.parameters["period"].value)[0])
    order = round(ratio)
    if order < 1 or abs(ratio / order - 1.0) > HARMONIC:
        return ""
    return f" ({order} a turn)" if rotary else f" (harmonic {order} of the known {longest:.4g} {model.units.position})"


def step_text(step: Step, unit: str) -> str:
    """Return one line of the ledger."""
    if not step.accepted:
        return f"refused {step.name}: {step.reason}"
    gap = f"gap {step.gap_before:.4g} -> {step.gap_after:.4g} {unit}"
    if step.confirm_after is not None:
        gap += f", on the confirm logs {step.confirm_before:.4g} -> {step.confirm_after:.4g} {unit}"
    return f"added   {step.name}: {gap}; {step.reason}"


def limit_lines(limits: Mapping[str, Limit]) -> list[str]:
    """Return the detection limits, one line per effect, and the effects without one."""
    shown = {name: limit for name, limit in limits.items() if limit.value is not None}
    unseen = [name for name in limits if name not in shown]
    lines = []
    if shown:
        lines.append("detection limits (probability 95 %):")
        wide = max(len(name) for name in shown)
        lines += [f"  {name:<{wide}}  {limit_text(limit)}" for name, limit in shown.items()]
    if unseen:
        lines.append(f"cannot be seen in this motion: {', '.join(unseen)}")
    return lines


def limit_text(limit: Limit) -> str:
    """Return size, unit and shape of a detection limit."""
    unit, held = "" if limit.unit == "1" else limit.unit, shape_words(limit)
    size = f"{limit.parameter} {numbers(limit.value)} {unit}".rstrip() + (" or less" if limit.smaller_shows else "")
    return f"{size} ({held})" if held else size


def shape_words(limit: Limit) -> str:
    """Return the shape parameters for which a detection limit holds."""
    return ", ".join(
        f"{field} {value[0]:.3g} to {value[1]:.3g}" if isinstance(value, list) else f"{field} {value:.3g}"
        for field, value in limit.shape.items()
    )


def plain(name: str) -> str:
    """Return a name of the vocabulary as words."""
    return name.replace("_", " ")


def law(vocabulary: Mapping[str, Effect], name: str) -> str:
    """Return the formula of an effect, or a clause for a change of the axis."""
    if name in vocabulary:
        return vocabulary[name].LAW
    return f"{plain(name.removesuffix('_change'))} of the axis differs from its stated value"


def numbers(value: Any, interval: Sequence[Any] = (None, None)) -> str:
    """Return a number for a table; a dash for an unknown one, and two digits of the width of an interval."""
    if value is None or not np.isfinite(value):
        return "–"
    low, high = interval
    if low is None or high is None or not 0.0 < high - low < np.inf:
        return f"{value:.{DIGITS}g}"
    places = np.floor(np.log10([max(abs(low), abs(high)), high - low]))
    whole = places[0] + 1 if places[0] < WHOLE else 0
    digits = int(np.clip(places[0] - places[1] + 2, max(DIGITS, whole), 12))
    return f"{value:#.{digits}g}".removesuffix(".")


def where_words(where: Mapping[str, Any], units: Units) -> str:
    """Return coordinate and range as words."""
    span, coordinate = where.get("range"), where.get("coordinate", "")
    if not coordinate:
        return "everywhere"
    if not span:
        return f"along the {coordinate}"
    unit = units.of(COORDINATE_UNITS.get(coordinate, ""))
    return f"along the {coordinate}, from {span[0]:.3g} to {span[1]:.3g} {unit}".rstrip()


def unlisted_advice(coordinate: str) -> str:
    """Return advice on a measurement for a gap that depends on a coordinate and has no known cause."""
    return (
        f"The unexplained force depends on {coordinate}: repeat the motion with only that changed, and check whether "
        "the gap follows."
    )
