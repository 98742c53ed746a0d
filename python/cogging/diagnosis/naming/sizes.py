"""How much of the gap each named effect makes: what would be missing without it, the largest first."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from cogging._core import DivergedError
from cogging.diagnosis.entries import NamedEffect
from cogging.diagnosis.large.balance import Balances
from cogging.effects.effect import Wave, kind_of
from cogging.model.model import Model


def largest_first(effects: Sequence[NamedEffect], balances: Balances, final: Model, stated: Model) -> list[NamedEffect]:
    """The effects in the order of what the force balance lacks without each.

    Args:
        effects: effects that were named.
        balances: logs, under any model.
        final: model with all of them; its first effects are those of `stated`.
        stated: model as it was read.
    """
    whole = balances.under(final)
    ordered = [_largest_term_first(effect, final) for effect in effects]
    return sorted(ordered, key=lambda effect: -_size(effect, whole, stated))


def _largest_term_first(effect: NamedEffect, final: Model) -> NamedEffect:
    """The effect with its terms, where it has several waves, in the order of their amplitudes."""
    wave = next((kind for one in final.effects if effect.name == one.NAME and (kind := kind_of(one, Wave))), None)
    if not effect.further or wave is None:
        return effect
    parts = (wave.sine, wave.cosine)
    terms = [effect.parameters, *effect.further]
    terms.sort(key=lambda term: -float(np.linalg.norm([np.ravel(term[part].value) for part in parts])))
    return replace(effect, parameters=terms[0], further=tuple(terms[1:]))


def _size(effect: NamedEffect, whole: Balances, stated: Model) -> float:
    """Rms of what the balance lacks without an effect, V; 0 where the model cannot do without it."""
    try:
        less = whole.under(without(effect.name, whole.model, stated))
        return float(np.sqrt(np.mean((less.residual - whole.residual) ** 2)))
    except (DivergedError, ValueError):
        return 0.0


def without(name: str, model: Model, stated: Model) -> Model:
    """The model without what was added under a name, or with the parameter that it has changed as it was stated."""
    level = name.removesuffix("_change")
    if level != name:
        return model.replace(axis=model.axis.replace(**{level: getattr(stated.axis, level)}))
    given = len(stated.effects)
    added = tuple(effect for effect in model.effects[given:] if name != effect.NAME)
    return model.replace(effects=(*model.effects[:given], *added))
