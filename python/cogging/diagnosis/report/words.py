"""Lines of a result in words, for the screen and the page."""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING, Any

import numpy as np

from cogging.diagnosis.residual.shape import FRICTION_INTERVALS, JUMPS
from cogging.diagnosis.thresholds import REPORT
from cogging.effects.effect import Effect
from cogging.model.units import Units

if TYPE_CHECKING:
    from cogging.diagnosis.entries import Limit, ShapeTerm, Step

COORDINATE_UNITS = {
    "position": "m",
    "velocity": "m/s",
    "acceleration": "m/s^2",
    "time": "s",
    "command": "V",
    "frequency": "Hz",
}


def term_text(term: Mapping[str, Any], unit: str) -> str:
    """What an empirical term makes of the gap, in words."""
    text = f"added to the model as {term['name']}, which is empirical and names no cause: gap "
    text += f"({term['signal']}) {term['gap_before']:.4g} to {term['gap_after']:.4g} {unit}"
    if term["confirm_after"] is not None:
        text += f", on the confirm logs {term['confirm_before']:.4g} to {term['confirm_after']:.4g} {unit}"
    return text


def other_shape_text(term: ShapeTerm) -> str:
    """What is said of an effect whose law is not the plainest, and where most of the difference is."""
    sizes = [abs(f) / d if d > 0.0 and np.isfinite(d) else 0.0 for f, d in zip(term.force, term.deviation, strict=True)]
    most = int(np.argmax(sizes))
    told = f"of another shape than its plainest law, T = {term.statistic:.0f} in {term.coordinate}: "
    return f"{told}{term.force[most]:+.2g} more about {term.places[most]:.3g} {term.unit.removesuffix('1')}".rstrip()


def step_text(step: Step, unit: str) -> str:
    """A line of the ledger in words."""
    if not step.accepted:
        return f"refused {step.name}: T = {step.statistic:.0f}, {step.reason}"
    gap = f"gap {step.gap_before:.4g} to {step.gap_after:.4g} {unit}"
    if step.confirm_after is not None:
        gap += f", on the confirm logs {step.confirm_before:.4g} to {step.confirm_after:.4g} {unit}"
    return f"added   {step.name}: T = {step.statistic:.0f}, {gap}; {step.reason}"


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


def chance_text(log_p_value: float) -> str:
    """A chance given as its logarithm, in words."""
    exponent = -log_p_value / np.log(10.0)
    if exponent < REPORT.chance_percent:
        return f"in {100.0 * np.exp(log_p_value):.0f} of 100 logs"
    if exponent < REPORT.chance_never:
        return f"in 1 of {10 ** int(exponent):,} logs"
    return "practically never, in less than 1 of a million logs"


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
    if coordinate == JUMPS:
        return "Readings jump at the moments told: look at the scale, at the encoder's cable, and at the log's clock."
    if coordinate == FRICTION_INTERVALS:
        return "Friction comes and goes: repeat the motion, and see whether it comes back at the same places or times."
    return (
        f"What no known effect explains depends on {coordinate}: repeat the motion with that alone changed, and see "
        "whether the gap follows."
    )
