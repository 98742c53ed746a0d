"""What was added as a large effect, by name; and what many harmonics of one pitch are together."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from cogging.diagnosis.candidates.waves import is_spatial_wave
from cogging.diagnosis.entries import Gap, NamedEffect
from cogging.diagnosis.large.search import LargeTerm
from cogging.diagnosis.naming.effect_range import where_of
from cogging.diagnosis.naming.names import values_of
from cogging.diagnosis.residual.location_words import length_text
from cogging.diagnosis.search.state import Added, Search
from cogging.diagnosis.thresholds import LARGE, NAME
from cogging.effects.effect import Effect, Wave, kind_of
from cogging.model.model import Model
from cogging.model.parameters import effect_paths


def named_large(found: Search, place: int, term: LargeTerm) -> NamedEffect:
    """The large effect that was added at a place, with the names that leave about as little."""
    prefix, effect = effect_paths(found.estimate.model.effects)[-len(found.added) + place]
    added = found.added[place]
    return NamedEffect(
        effect.NAME,
        term.alternatives,
        confidence_of(added, term, found.large.start.rms if found.large is not None else 0.0),
        values_of(found.estimate, prefix, effect),
        where_of(effect, found.evidence),
        added.finding.test.statistic,
        added.finding.log_p_value,
    )


def confidence_of(added: Added, term: LargeTerm, start: float) -> float:
    """The stated chance that the name of a large effect is right; `start`: rms of the balance before any, V."""
    chance = NAME.surest
    if term.before < LARGE.shape_doubt * start:
        chance *= NAME.if_shapes_left  # what a large effect has of another shape looks like one more
    if term.alternatives:
        chance /= 1.0 + len(term.alternatives)
    if added.confirmation is None:
        chance *= NAME.if_unconfirmed
    elif added.confirmation.noncentrality == 0.0:
        chance *= NAME.if_uninformed
    if (term.balances.rms / term.before) ** 2 > LARGE.half_explained:
        chance *= NAME.if_shapes_left  # most of the gap is something else still
    return round(float(chance), 3)


def unsettled(effects: Sequence[NamedEffect], gap: Gap) -> list[NamedEffect]:
    """The effects with less confidence in each where much of a large gap is left: another cause may take its place.

    A change of mass or friction is told by what it does to the fit, not by the gap.
    """
    if gap.after < max(LARGE.settled * gap.before, LARGE.settled_noise * gap.floor):
        return list(effects)
    return [
        one if one.name.endswith("_change") else replace(one, confidence=round(NAME.if_shapes_left * one.confidence, 3))
        for one in effects
    ]


def map_note(added: Sequence[Effect], model: Model) -> str | None:
    """That waves along the travel are harmonics of one pitch, the model's or one that it lacks; None if not."""
    waves = [effect for effect in added if is_spatial_wave(effect) and set(effect.HOOKS) == {"force"}]
    kinds = [(effect, kind) for effect in waves if (kind := kind_of(effect, Wave)) is not None]
    periods = [float(getattr(effect, kind.shape)) for effect, kind in kinds]
    if model.cogging is not None:
        return _of_known_pitch(periods, float(model.cogging.basis.pitch), list(model.cogging.basis.harmonics))
    if len(periods) < LARGE.map_harmonics:
        return None
    sizes = [float(np.hypot(getattr(effect, kind.sine), getattr(effect, kind.cosine))) for effect, kind in kinds]
    pitch = common_pitch(periods)
    if pitch is None:
        return None
    order = np.argsort(sizes)[::-1]
    numbers = [round(pitch / periods[i]) for i in order]
    strong = ", ".join(f"{periods[i]:.4g}" for i in order[:2])
    return (
        f"strong periods {strong} m, all harmonics of one pitch: a map of the cogging is what lacks. "
        f"[cogging] with pitch = {pitch:.6g} and harmonics = {sorted(numbers)} holds them"
    )


def _of_known_pitch(periods: Sequence[float], pitch: float, known: Sequence[int]) -> str | None:
    """Which further harmonics of the pitch that a model knows waves are; None where they are none."""
    orders = [pitch / period for period in periods]
    further = {round(n) for n in orders if round(n) and abs(n - round(n)) < LARGE.pitch_within * n} - {*known}
    if not known or not further:
        return None
    told = " and ".join(f"the {_ordinal(n)} harmonic of your {length_text(pitch)} pitch" for n in sorted(further))
    return f"what lacks is {told}: [cogging] with harmonics = {sorted({*known, *further})} holds it"


def _ordinal(number: int) -> str:
    tens, last = divmod(number, 10)
    return str(number) + ("th" if tens == 1 else {1: "st", 2: "nd", 3: "rd"}.get(last, "th"))


def common_pitch(periods: Sequence[float]) -> float | None:
    """The shortest length of which all periods are whole parts, to within what a fit tells; None where none is near."""
    longest = max(periods)
    for whole in range(1, LARGE.pitch_max + 1):
        parts = whole * longest / np.array(periods)
        if np.all(np.abs(parts - np.round(parts)) < LARGE.pitch_within * np.maximum(parts, 1.0)):
            return float(np.mean(np.round(parts) * np.array(periods)))
    return None
