"""Lines of a result in words, for the screen and the page."""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING, Any

import numpy as np

from cogging.diagnosis.residual.shape import FRICTION_INTERVALS, JUMPS
from cogging.effects.effect import Effect

if TYPE_CHECKING:
    from cogging.diagnosis.entries import Step


HEADLINES = {
    "no_gap": "Nothing is missing: the model explains these logs",
    "named": "The model lacks {names}",
    "ambiguous": "The model lacks something; the likeliest is {names}",
    "unlisted": "The model and the machine disagree in a way that no known effect explains",
    "data_mismatch": "A column of these logs is not what it was read as",
    "controller_mismatch": "The stated controller did not make this log",
    "insufficient_excitation": "These logs move too little to tell",
}
MEANINGS = {
    "no_gap": (
        "Whatever is left after re-tuning looks like noise in every coordinate. This does not prove that the model is "
        "right everywhere: only that this motion shows nothing wrong with it."
    ),
    "named": (
        "What was found stands out of the noise, fits better than every other effect that was tried, and nothing "
        "significant is left once it is in the model."
    ),
    "ambiguous": (
        "Something is missing beyond doubt, but this motion cannot tell with nine chances in ten which effect it is. "
        "The motion that would decide is described below."
    ),
    "unlisted": (
        "Something significant remains that none of the known effects explains. Effects named beside it stand; "
        "what remains is described by where it sits."
    ),
    "data_mismatch": (
        "As it was read, a log contradicts the model or itself; with one column read otherwise it does not. Until that "
        "is settled, nothing can be said of the machine."
    ),
    "controller_mismatch": (
        "The command that the stated controller would have given differs from the logged one. Until its law, gains or "
        "timing are right, no model of the machine can be judged."
    ),
    "insufficient_excitation": (
        "At rest, friction takes up any force and nothing can be seen. Give a log in which the axis moves."
    ),
}


def term_text(term: Mapping[str, Any], unit: str) -> str:
    """What an empirical term makes of the gap, in words."""
    text = f"added to the model as {term['name']}, which is empirical and names no cause: gap (innovations of an "
    text += f"observer) {term['gap_before']:.4g} to {term['gap_after']:.4g} {unit}"
    if term["confirm_after"] is not None:
        text += f", on the confirm logs {term['confirm_before']:.4g} to {term['confirm_after']:.4g} {unit}"
    return text


def step_text(step: Step, unit: str) -> str:
    """A line of the ledger in words."""
    if not step.accepted:
        return f"refused {step.name}: T = {step.statistic:.0f}, {step.reason}"
    gap = f"gap {step.gap_before:.4g} to {step.gap_after:.4g} {unit}"
    if step.confirm_after is not None:
        gap += f", on the confirm logs {step.confirm_before:.4g} to {step.confirm_after:.4g} {unit}"
    return f"added   {step.name}: T = {step.statistic:.0f}, {gap}; {step.reason}"


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
    if exponent < 2.0:
        return f"in {100.0 * np.exp(log_p_value):.0f} of 100 logs"
    if exponent < 6.0:
        return f"in 1 of {10 ** int(exponent):,} logs"
    return "practically never, in less than 1 of a million logs"


def numbers(value: Any) -> str:
    """A number, or a list of numbers, for a table; a dash where it is not known."""
    if value is None:
        return "–"
    if isinstance(value, int | float):
        return f"{value:.4g}" if np.isfinite(value) else "–"
    return ", ".join(numbers(one) for one in value)


def where_words(where: Mapping[str, Any]) -> str:
    """Coordinate and range as words."""
    span = where.get("range")
    unit = {"position": "m", "velocity": "m/s", "time": "s", "command": "V", "frequency": "Hz"}.get(
        where.get("coordinate", ""), ""
    )
    if not span:
        return f"over {where.get('coordinate', 'all')}"
    return f"in {where['coordinate']}, from {span[0]:.3g} to {span[1]:.3g} {unit}"


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
