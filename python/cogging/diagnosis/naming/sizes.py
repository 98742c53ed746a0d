"""How much of the gap each named effect takes, the largest first."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from cogging.diagnosis.discrepancy import Discrepancy
from cogging.diagnosis.entries import NamedEffect
from cogging.effects.effect import Wave, kind_of
from cogging.model.model import Model


def with_shares(
    effects: Sequence[NamedEffect], names: Sequence[str], gaps: Sequence[Discrepancy], final: Model
) -> list[NamedEffect]:
    """The effects, each with what it takes of the power of the gap before, the largest first.

    Args:
        effects: effects that were named.
        names: what each model but the first has beyond the one before.
        gaps: gap of each model.
        final: the last model.
    """
    powers = [gap.rms**2 for gap in gaps]
    taken = dict.fromkeys(names, 0.0)
    for name, before, after in zip(names, powers[:-1], powers[1:], strict=True):
        taken[name] += max(0.0, before - after) / powers[0]
    told = []
    for effect in effects:
        share = taken.get(effect.name, 0.0)
        differs = {name: part * share**0.5 for name, part in effect.differs.items()}
        told.append(replace(_largest_term_first(effect, final), share=share, differs=differs))
    return sorted(told, key=lambda effect: -(effect.share or 0.0))


def _largest_term_first(effect: NamedEffect, final: Model) -> NamedEffect:
    """The effect with its terms, where it has several waves, in the order of their amplitudes."""
    wave = next((kind for one in final.effects if effect.name == one.NAME and (kind := kind_of(one, Wave))), None)
    if not effect.further or wave is None:
        return effect
    parts = (wave.sine, wave.cosine)
    terms = [effect.parameters, *effect.further]
    terms.sort(key=lambda term: -float(np.linalg.norm([np.ravel(term[part].value) for part in parts])))
    return replace(effect, parameters=terms[0], further=tuple(terms[1:]))
