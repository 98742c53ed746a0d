"""Masking: effects of the given model that stood for what was missing, and vanish once it is added."""

from __future__ import annotations

from collections.abc import Iterable, Iterator

from cogging.diagnosis.thresholds import PARAMETER_CHANGE
from cogging.model.model import Model
from cogging.model.parameters import effect_paths, parameters_of


def masking_notes(nominal: Model, final: Model) -> list[str]:
    """Notes on effects of the given model that nearly vanish once the missing ones are in: they were hiding those.

    Args:
        nominal: re-tuned without what was found.
        final: re-tuned with it; its effects begin with those of `nominal`.
    """
    if len(final.effects) == len(nominal.effects):
        return []
    added = ", ".join(dict.fromkeys(effect.NAME for effect in final.effects[len(nominal.effects) :]))
    return [
        f"{name} of the given model nearly vanishes ({before:.3g} to {after:.3g} {unit}) once {added} is in: "
        "it was standing in for it and hid it"
        for name, unit, before, after in _vanished(nominal, final)
    ]


def _vanished(nominal: Model, final: Model) -> Iterator[tuple[str, str, float, float]]:
    before, after = parameters_of(nominal), parameters_of(final)
    for (old, effect), (new, _) in zip(effect_paths(nominal.effects), effect_paths(final.effects), strict=False):
        amplitudes = [
            (name, index)
            for name, role in effect.ROLES.items()
            if role["role"] == "amplitude"
            for index in ([""] if f"{old}.{name}" in before else _indexes(before, f"{old}.{name}"))
        ]
        sizes = [(before[f"{old}.{n}{i}"], after[f"{new}.{n}{i}"]) for n, i in amplitudes if f"{new}.{n}{i}" in after]
        if not sizes:
            continue
        first, second = max(sizes, key=lambda pair: abs(pair[0].value))
        if 0.0 < max(abs(b.value) for _, b in sizes) < PARAMETER_CHANGE.vanished * abs(first.value):
            yield effect.NAME, first.unit, first.value, second.value


def _indexes(known: Iterable[str], path: str) -> list[str]:
    return [p[len(path) :] for p in known if p.startswith(path + "[")]
