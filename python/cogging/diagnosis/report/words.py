"""Lines of a result in words, for the screen and the page."""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING, Any

import numpy as np

from cogging.diagnosis.places import COORDINATE_UNITS
from cogging.effects.effect import Effect
from cogging.model.units import Units

if TYPE_CHECKING:
    from cogging.diagnosis.entries import Limit, NamedEffect, Step


def term_text(term: Mapping[str, Any], unit: str) -> str:
    """What an empirical term makes of the gap, in words."""
    text = f"added to the model as {term['name']}, which is empirical and names no cause: gap "
    text += f"({term['signal']}) {term['gap_before']:.4g} to {term['gap_after']:.4g} {unit}"
    if term["confirm_after"] is not None:
        text += f", on the confirm logs {term['confirm_before']:.4g} to {term['confirm_after']:.4g} {unit}"
    return text


def other_shape_text(effect: NamedEffect, units: Units) -> str:
    """What is said of an effect whose law is not the plainest; empty of others."""
    if not effect.shape:
        return ""
    told = "of another shape than its plainest law"
    if effect.curve is None:
        return f"{told}, which no function of one coordinate gives: it is not in the model"
    places, force = effect.curve["places"], effect.curve["force"]
    most = int(np.argmax(np.abs(force)))
    coordinate = str(effect.curve["coordinate"])
    place = f"{places[most]:.3g} {units.of(COORDINATE_UNITS[coordinate])}"
    held = "; the model has it as an empirical force" if effect.in_model else ""
    return f"{told}: {force[most]:+.2g} {units.command} at most, about {coordinate} {place}{held}"


def step_text(step: Step, unit: str) -> str:
    """A line of the ledger in words."""
    if not step.accepted:
        return f"refused {step.name}: {step.reason}"
    gap = f"gap {step.gap_before:.4g} to {step.gap_after:.4g} {unit}"
    if step.confirm_after is not None:
        gap += f", on the confirm logs {step.confirm_before:.4g} to {step.confirm_after:.4g} {unit}"
    return f"added   {step.name}: {gap}; {step.reason}"


def limit_lines(limits: Mapping[str, Limit]) -> list[str]:
    """The detection limits, a line an effect, then those that have none."""
    shown = {name: limit for name, limit in limits.items() if limit.value is not None}
    unseen = [name for name in limits if name not in shown]
    lines = []
    if shown:
        lines.append("would have been shown with 95 % chance, from this size on:")
        wide = max(len(name) for name in shown)
        lines += [f"  {name:<{wide}}  {limit_text(limit)}" for name, limit in shown.items()]
    if unseen:
        lines.append(f"cannot be seen in this motion: {', '.join(unseen)}")
    return lines


def limit_text(limit: Limit) -> str:
    """Size, unit and shape of a detection limit."""
    unit, held = "" if limit.unit == "1" else limit.unit, shape_words(limit)
    size = f"{limit.parameter} {numbers(limit.value)} {unit}".rstrip() + (" or less" if limit.smaller_shows else "")
    return f"{size} ({held})" if held else size


def shape_words(limit: Limit) -> str:
    """The shape for which a detection limit holds, as words."""
    return ", ".join(
        f"{field} {value[0]:.3g} to {value[1]:.3g}" if isinstance(value, list) else f"{field} {value:.3g}"
        for field, value in limit.shape.items()
    )


def plain(name: str) -> str:
    """A name of the vocabulary as words."""
    return name.replace("_", " ")


def law(vocabulary: Mapping[str, Effect], name: str) -> str:
    """The formula of an effect as it states it; of a change, what changed."""
    if name in vocabulary:
        return vocabulary[name].LAW
    return f"{plain(name.removesuffix('_change'))} of the axis differs from what the model states"


def numbers(value: Any) -> str:
    """A number, or a list of numbers, for a table; a dash where it is not known."""
    if value is None:
        return "–"
    if isinstance(value, int | float):
        return f"{value:.4g}" if np.isfinite(value) else "–"
    return ", ".join(numbers(one) for one in value)


def where_words(where: Mapping[str, Any], units: Units) -> str:
    """Coordinate and range as words."""
    span, coordinate = where.get("range"), where.get("coordinate", "")
    if not coordinate:
        return "everywhere"
    if not span:
        return f"along the {coordinate}"
    unit = units.of(COORDINATE_UNITS.get(coordinate, ""))
    return f"along the {coordinate}, from {span[0]:.3g} to {span[1]:.3g} {unit}".rstrip()


def unlisted_advice(coordinate: str) -> str:
    """What to measure next where a gap of no known effect depends on a coordinate."""
    return (
        f"What no known effect explains depends on {coordinate}: repeat the motion with that alone changed, and see "
        "whether the gap follows."
    )
