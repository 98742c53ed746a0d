"""What a diagnosis comes to, said so that headline, shares and confidences agree: the page and the screen say the same.

Three things are kept apart: that something is there (how far it stands out of the noise), what it is called (the
stated chance that the name is right), and how much of the gap it explains.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING

import numpy as np

from cogging.diagnosis.report.words import plain
from cogging.effects.effect import Effect
from cogging.shown import shortened

if TYPE_CHECKING:
    from cogging.diagnosis.entries import Gap, NamedEffect
    from cogging.diagnosis.result import Diagnosis

PLAIN_HEADLINES = {
    "no_gap": "Nothing is missing: the model explains these logs",
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
        "Something stands out of the noise, but these logs do not say with nine chances in ten what all of it is."
    ),
    "unlisted": "What is left is not noise, and none of the known effects explains it.",
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
#: Along what an effect acts, by the quantities of what is sought of it.
ALONG = {
    "position": "position",
    "distance": "position",
    "angle": "position",
    "force_per_position": "position",
    "velocity": "velocity",
    "force_per_velocity": "velocity",
    "force_per_velocity_squared": "velocity",
    "friction": "velocity",
    "stiffness": "velocity",
    "time": "time",
    "command": "command",
    "sample_time": "frequency",
    "frequency": "frequency",
}
HARDLY = "hardly any of the gap"
SURE = 0.9  # confidence from which a name is stated (contract)
LITTLE = 0.05  # of the gap: a smaller share is hardly any
IN_HEADLINE, LONGEST = 2, 60  # effects that a headline names, and characters of a name in it
OF_CHANGES = {"mass_change": "acceleration", "viscous_change": "velocity", "coulomb_change": "velocity"}


def headline(result: Diagnosis) -> str:
    """The result in one sentence: what was found, as sure as it is, then what remains."""
    if result.verdict in PLAIN_HEADLINES:
        return PLAIN_HEADLINES[result.verdict]
    if not result.effects:
        return "The model and the machine disagree in a way that no known effect explains"
    found = f"The model lacks {names_text(result.effects)}"
    if result.verdict != "unlisted":
        return found
    share = explained_text(result.gap)
    if not share:
        return f"{found}; what is left has no name"
    rest = "most of it has no name" if share == HARDLY else "what is left has no name"
    return f"{found}; that explains {share}, {rest}"


def meaning(result: Diagnosis) -> list[str]:
    """What the verdict means here: of names that are not sure, which, and how sure; the rest where each is told."""
    told = [MEANINGS[result.verdict]]
    if result.verdict == "unlisted" and result.effects:
        told[0] = "Beside what was found, something stands out of the noise that no known effect explains."
    doubts = [doubt for effect in result.effects if (doubt := doubt_text(effect, result.vocabulary))]
    more = len(doubts) - IN_HEADLINE
    told += doubts[:IN_HEADLINE]
    return [*told, f"{more} more {'is' if more == 1 else 'are'} told below."] if more > 0 else told


def names_text(effects: Sequence[NamedEffect]) -> str:
    """The names of effects in their order, each as sure as it is, with its share of the gap; beyond a few, how many."""
    told, more = effects[:IN_HEADLINE], effects[IN_HEADLINE:]
    phrases = [name_text(one) if is_sure(one) else f"something that is {_doubted(one)}" for one in told]
    phrases = [f"{phrase}{_share_text(one)}" for phrase, one in zip(phrases, told, strict=True)]
    open_ones = "" if all(map(is_sure, more)) else ", not all of them sure"
    return joined([*phrases, *([f"{len(more)} more{open_ones}"] if more else [])])


def _share_text(effect: NamedEffect) -> str:
    return "" if effect.share is None else f" ({percent(min(effect.share, 1.0))} of the gap)"


def is_sure(effect: NamedEffect) -> bool:
    """Whether a name may be said without a doubt, as the contract has it."""
    return effect.confidence >= SURE and not effect.alternatives


def name_text(effect: NamedEffect) -> str:
    """The name as words for a headline, with what its law has of its own."""
    return shortened(plain(effect.name), LONGEST) + (" of a shape of its own" if effect.shape else "")


def _doubted(effect: NamedEffect) -> str:
    if effect.alternatives:
        others = [shortened(plain(other), LONGEST) for other in effect.alternatives]
        return joined([name_text(effect), *others], "or")
    word = "probably" if effect.confidence >= 0.5 else "perhaps"
    return f"{word} {name_text(effect)} ({percent(effect.confidence)})"


def explained_text(gap: Gap) -> str:
    """How much of the gap's power above the noise has a name, in words; empty where nothing stands above it."""
    if gap.closed is None:
        return ""
    share = float(np.clip(gap.closed, 0.0, 1.0))
    return f"{percent(share)} of the gap" if share >= LITTLE else HARDLY


def doubt_text(effect: NamedEffect, vocabulary: Mapping[str, Effect]) -> str:
    """Of a name that is not sure: which names it may be, which of them is how sure, what they share; else empty."""
    name, sure = plain(effect.name), percent(effect.confidence)
    if is_sure(effect):
        return ""
    if not effect.alternatives:
        return f"{capital(name)}: no other known effect fits as well, but the name has a chance of {sure} only."
    others = [plain(other) for other in effect.alternatives]
    return (
        f"{capital(joined([name, *others], 'or'))}: these logs cannot tell which. "
        f"{capital(name)} has a chance of {sure}; {shared_text(effect, vocabulary)}."
    )


def shared_text(effect: NamedEffect, vocabulary: Mapping[str, Effect]) -> str:
    """What an effect and those that it may be instead have in common, a clause."""
    names = [effect.name, *effect.alternatives]
    along = [along_of(name, vocabulary) for name in names]
    if all(one == along[0] for one in along):
        both = "both" if len(names) == 2 else f"all {len(names)}"
        return f"{both} act along the {along[0]}" if along[0] else f"{both} push alike everywhere"
    each = joined(
        [
            f"{plain(name)} along the {one}" if one else f"{plain(name)} everywhere"
            for name, one in zip(names, along, strict=True)
        ]
    )
    return f"{each}, which go together in this motion"


def along_of(name: str, vocabulary: Mapping[str, Effect]) -> str:
    """Along which coordinate an effect acts, as what it acts on and its parameters say; empty where everywhere."""
    if name not in vocabulary:
        return OF_CHANGES.get(name, "")
    law = vocabulary[name]
    if "reading" in law.HOOKS:
        return "position"
    roles = [role for role in law.ROLES.values() if role["role"] != "setting"]
    wave = any(role["role"] == "shape" and role["quantity"] == "frequency" for role in roles)
    if wave and "force" in law.HOOKS:
        return "time"
    # What shapes an effect says where it acts; where it has no shape, what it is an amount of does.
    for kind in ("shape", "amplitude"):
        told = [ALONG[role["quantity"]] for role in roles if role["role"] == kind and role["quantity"] in ALONG]
        if "state" in law.HOOKS and "frequency" in told:
            return "frequency"
        if told:
            return "velocity" if "state" in law.HOOKS else told[0]
    return "command" if {"command_gain", "shape_command"} & set(law.HOOKS) else ""


def standing_text(effect: NamedEffect) -> str:
    """That something is there, which is not yet a name: how far it stands out of the noise."""
    deviations = float(np.sqrt(max(effect.statistic, 0.0)))
    return (
        f"That something is there: it stands {deviations:.0f} standard deviations out of the noise "
        f"(T = {effect.statistic:.0f}, the logarithm of how much likelier the logs are with it, twice, less its cost)."
    )


def certainty_text(effect: NamedEffect, vocabulary: Mapping[str, Effect]) -> str:
    """What it is called, and how sure that is: another thing than how far it stands out."""
    name, sure = plain(effect.name), percent(effect.confidence)
    if is_sure(effect):
        return f"That it is {name}: {sure}."
    if effect.alternatives:
        others = joined([plain(other) for other in effect.alternatives], "or")
        return f"That it is {name}: {sure}; it may be {others} instead. {capital(shared_text(effect, vocabulary))}."
    return f"That it is {name}: {sure}, which is not enough to call it so."


def joined(phrases: list[str], word: str = "and") -> str:
    """Phrases with commas, and a word before the last."""
    return f" {word} ".join([", ".join(phrases[:-1]), phrases[-1]] if len(phrases) > 1 else phrases)


def percent(share: float) -> str:
    """A share in whole percent; what is not all is never 100 %, what is not sure never as much as what is."""
    if 0.0 < share < 0.01:
        return "under 1 %"
    whole = round(100.0 * share)
    below = [edge for edge in (SURE, 1.0) if share < edge <= whole * 0.01]
    return f"{whole - bool(below)} %"


def capital(text: str) -> str:
    """A sentence with a capital first letter, the rest as it is."""
    return text[:1].upper() + text[1:]
