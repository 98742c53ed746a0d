"""Sentences of a diagnosis, shared by page and screen: headline, evidence, confidence and share of the gap.

Evidence (is there an effect?), confidence (is its name right?) and share (how much of the gap?) are reported apart.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING

import numpy as np

from cogging.diagnosis.entries import SURE
from cogging.diagnosis.report.words import plain
from cogging.effects.effect import Effect
from cogging.shown import shortened

if TYPE_CHECKING:
    from cogging.diagnosis.diagnosis_result import Diagnosis
    from cogging.diagnosis.entries import Gap, NamedEffect

PLAIN_HEADLINES = {
    "no_gap": "Nothing is missing: the model explains these logs",
    "data_mismatch": "A column of these logs has the wrong sign, scale, order or timing",
    "controller_mismatch": "The stated controller did not make this log",
    "insufficient_excitation": "These logs show too little of the motion",
}
MEANINGS = {
    "no_gap": (
        "After re-tuning, the residual looks like noise in every coordinate. This motion shows no error of the model; "
        "other motion may."
    ),
    "named": (
        "Each effect is significant and fits better than every other effect of the vocabulary. With these effects in "
        "the model, nothing significant is left."
    ),
    "ambiguous": "The gap is significant, but these logs do not identify every effect with a confidence of 90 %.",
    "unlisted": "The residual is not noise, and none of the known effects explains it.",
    "data_mismatch": (
        "A log contradicts the model or itself unless one column is read differently. Correct this before diagnosing "
        "the machine."
    ),
    "controller_mismatch": (
        "The command of the stated controller differs from the logged one. Correct its law, gains or timing before "
        "diagnosing the machine."
    ),
    "insufficient_excitation": (
        "At rest, friction balances any force and hides every effect; between rows far apart, the motion is unknown. "
        "Provide a log in which the axis moves, with rows a few milliseconds apart."
    ),
}
#: Coordinate along which an effect acts, by the quantity of its parameters.
ALONG = {
    quantity: coordinate
    for coordinate, quantities in {
        "position": ("position", "distance", "angle", "force_per_position"),
        "velocity": ("velocity", "force_per_velocity", "force_per_velocity_squared", "friction", "stiffness"),
        "time": ("time",),
        "command": ("command",),
        "frequency": ("sample_time", "frequency"),
    }.items()
    for quantity in quantities
}
HARDLY = "under 5 % of the gap"
LITTLE = 0.05  # of the gap: smaller shares read as HARDLY
IN_HEADLINE, LONGEST = 2, 60  # effects that a headline names, and characters of a name in it
OF_CHANGES = {"mass_change": "acceleration", "viscous_change": "velocity", "coulomb_change": "velocity"}


def headline(result: Diagnosis) -> str:
    """Return the result in one sentence: the effects with their confidence, then the unexplained rest."""
    if result.verdict in PLAIN_HEADLINES:
        return PLAIN_HEADLINES[result.verdict]
    if not result.effects:
        return "The model and the machine disagree in a way that no known effect explains"
    found = f"The model lacks {names_text(result.effects)}"
    if result.verdict != "unlisted":
        return found
    share = explained_text(result.gap)
    if not share:
        return f"{found}; the rest is unexplained"
    rest = "most of it" if share == HARDLY else "the rest"
    return f"{found}; that explains {share}, {rest} is unexplained"


def meaning(result: Diagnosis) -> list[str]:
    """Return sentences on the meaning of the verdict and on the uncertain names."""
    sentences = [MEANINGS[result.verdict]]
    if result.verdict == "unlisted" and result.effects:
        sentences = ["Besides these effects, there is a significant force that no known effect explains."]
    doubts = [doubt for effect in result.effects if (doubt := doubt_text(effect, result.vocabulary))]
    more = len(doubts) - IN_HEADLINE
    listed = [f"{more} more uncertain {'effect is' if more == 1 else 'effects are'} listed below."] if more > 0 else []
    return [*sentences, *doubts[:IN_HEADLINE], *listed]


def names_text(effects: Sequence[NamedEffect]) -> str:
    """Return the names of the first effects with confidence and share of the gap, and the number of the others."""
    phrases = []
    for effect in effects[:IN_HEADLINE]:
        figures = [] if effect.share is None else [f"{percent(min(effect.share, 1.0))} of the gap"]
        figures += [] if effect.in_model else ["not in the model"]
        phrase = name_text(effect)
        if effect.alternatives:
            others = [shortened(plain(other), LONGEST) for other in effect.alternatives]
            phrase = f"either {joined([phrase, *others], 'or')}"
        elif not effect.is_sure:
            phrase = f"{'probably' if effect.confidence >= 0.5 else 'perhaps'} {phrase}"
            figures = [f"confidence {percent(effect.confidence)}", *figures]
        phrases.append(f"{phrase} ({', '.join(figures)})" if figures else phrase)
    more = effects[IN_HEADLINE:]
    uncertain = "" if all(effect.is_sure for effect in more) else ", some of them uncertain"
    return joined([*phrases, *([f"{len(more)} more{uncertain}"] if more else [])])


def name_text(effect: NamedEffect) -> str:
    """Return the name as words for a headline."""
    return shortened(plain(effect.name), LONGEST) + (" with a non-standard law" if effect.shape else "")


def explained_text(gap: Gap) -> str:
    """Return the share of the gap's power above the noise floor that the effects explain; empty without such power."""
    if gap.closed is None:
        return ""
    share = float(np.clip(gap.closed, 0.0, 1.0))
    return f"{percent(share)} of the gap" if share >= LITTLE else HARDLY


def doubt_text(effect: NamedEffect, vocabulary: Mapping[str, Effect]) -> str:
    """Return sentences on an uncertain name, its confidence and its alternatives; empty for a certain one."""
    name, confidence = plain(effect.name), percent(effect.confidence)
    if effect.is_sure:
        return ""
    if not effect.alternatives:
        return f"{capital(name)}: no other known effect fits as well, but its confidence is only {confidence}."
    names = joined([name, *map(plain, effect.alternatives)], "or")
    return (
        f"{capital(names)}: these logs cannot distinguish them. "
        f"The confidence of {name} is {confidence}; {shared_text(effect, vocabulary)}."
    )


def shared_text(effect: NamedEffect, vocabulary: Mapping[str, Effect]) -> str:
    """Return a clause on the coordinates of an effect and its alternatives."""
    names = [effect.name, *effect.alternatives]
    along = [along_of(name, vocabulary) for name in names]
    if all(one == along[0] for one in along):
        both = "both" if len(names) == 2 else f"all {len(names)}"
        return f"{both} depend on {along[0]}" if along[0] else f"{both} act everywhere"
    pairs = zip(names, along, strict=True)
    each = joined(
        [f"{plain(name)} depends on {one}" if one else f"{plain(name)} acts everywhere" for name, one in pairs]
    )
    return f"{each}, which this motion does not separate"


def along_of(name: str, vocabulary: Mapping[str, Effect]) -> str:
    """Return the coordinate that an effect depends on, from its hooks and roles; empty if it acts everywhere."""
    if name not in vocabulary:
        return OF_CHANGES.get(name, "")
    law = vocabulary[name]
    if "reading" in law.HOOKS:
        return "position"
    roles = [role for role in law.ROLES.values() if role["role"] != "setting"]
    if "force" in law.HOOKS and any((r["role"], r["quantity"]) == ("shape", "frequency") for r in roles):
        return "time"
    # shape parameters determine the coordinate, or else amplitudes
    for kind in ("shape", "amplitude"):
        along = [ALONG[role["quantity"]] for role in roles if role["role"] == kind and role["quantity"] in ALONG]
        if "state" in law.HOOKS and "frequency" in along:
            return "frequency"
        if along:
            return "velocity" if "state" in law.HOOKS else along[0]
    return "command" if {"command_gain", "shape_command"} & set(law.HOOKS) else ""


def standing_text(effect: NamedEffect) -> str:
    """Return a sentence on the evidence of an effect, whatever its name."""
    deviations = float(np.sqrt(max(effect.statistic, 0.0)))
    return (
        f"Evidence: {deviations:.0f} standard deviations above the noise "
        f"(T = {effect.statistic:.0f}: twice the log likelihood ratio, less a penalty for its parameters)."
    )


def certainty_text(effect: NamedEffect, vocabulary: Mapping[str, Effect]) -> str:
    """Return sentences on the confidence of a name and on its alternatives."""
    confidence = f"Confidence that it is {plain(effect.name)}: {percent(effect.confidence)}"
    if effect.is_sure:
        return f"{confidence}."
    if effect.alternatives:
        others = joined([plain(other) for other in effect.alternatives], "or")
        return f"{confidence}; it may be {others} instead. {capital(shared_text(effect, vocabulary))}."
    return f"{confidence}, which is not enough to name it."


def joined(phrases: list[str], word: str = "and") -> str:
    """Return phrases joined by commas, and by a word before the last."""
    return f" {word} ".join([", ".join(phrases[:-1]), phrases[-1]] if len(phrases) > 1 else phrases)


def percent(share: float) -> str:
    """Return a share in whole percent, rounded so that it never crosses SURE or 100 %."""
    if 0.0 < share < 0.01:
        return "under 1 %"
    whole = round(100.0 * share)
    below = [edge for edge in (SURE, 1.0) if share < edge <= whole * 0.01]
    return f"{whole - bool(below)} %"


def capital(text: str) -> str:
    """Return a sentence with a capital first letter."""
    return text[:1].upper() + text[1:]
