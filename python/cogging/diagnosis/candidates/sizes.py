"""What the size of an effect is, and at which shapes it may hide: the middle half of each range that is searched."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from cogging.arrays import FloatArray
from cogging.diagnosis.candidates.intervals import intervals
from cogging.diagnosis.candidates.signatures import (
    Candidate,
    candidates,
    known_periods,
    list_fields,
    quantities,
    shape_range,
)
from cogging.diagnosis.candidates.waves import is_spatial_wave, is_wave, wave_of, wave_range
from cogging.diagnosis.evidence.evidence import Evidence
from cogging.diagnosis.thresholds import LIMIT, SPECTRUM
from cogging.effects.effect import Effect, Wave, Window, kind_of


@dataclass(frozen=True)
class Size:
    """What is called the size of an effect.

    Attributes:
        field: the field that has it, or the first of several.
        unit: of the field.
        meaning: how several fields make one size; empty where it is the field alone.
        made_by_shape: whether it is a field of the shape, as of a delay; else of the amplitudes.
        grows: whether more of it does more; of a stiffness, or a limit, less does.
    """

    field: str
    unit: str
    meaning: str = ""
    made_by_shape: bool = False
    grows: bool = True


def is_sought(law: Effect) -> bool:
    """Whether a search looks for an effect: not for one whose amplitudes stand at places of the user's own choice."""
    return any(
        role["role"] == "shape" or (role["role"] == "amplitude" and not isinstance(getattr(law, field), list))
        for field, role in law.ROLES.items()
    )


def size_of(law: Effect) -> Size | None:
    """What the size of an effect is; None where no field of it starts from doing nothing."""
    amplitudes = [field for field, role in law.ROLES.items() if role["role"] == "amplitude"]
    if amplitudes:
        wave, first = kind_of(law, Wave), amplitudes[0]
        meaning = f"sqrt({wave.sine}^2 + {wave.cosine}^2)" if wave else ""
        if isinstance(getattr(law, first), list):
            meaning = f"largest {meaning or first} along the travel"
        return Size(first, law.FIELDS[first][0], meaning)
    shapes = [field for field, role in law.ROLES.items() if role["role"] == "shape"]
    for neutral in (0.0, np.inf):
        for field in shapes:
            if law.ROLES[field]["neutral"] == neutral:
                return Size(field, law.FIELDS[field][0], made_by_shape=True, grows=neutral == 0.0)
    return None


def directions(candidate: Candidate) -> FloatArray:
    """Amplitudes (m, p) of size 1: a wave at several phases, a list along the travel as drawn at random.

    Of several amplitudes that are no wave, the first alone: their units need not be the same.
    """
    first = candidate.amplitudes[0][0]
    length = candidate.length(first)
    drawn = (
        np.random.default_rng(0).standard_normal((LIMIT.list_draws, length))
        if length > 1
        else np.ones((LIMIT.phases, 1))
    )
    drawn = drawn / np.abs(drawn).max(axis=1, keepdims=True)
    turns = np.pi * (np.arange(len(drawn)) % LIMIT.phases)[:, None] / LIMIT.phases
    if kind_of(candidate.law, Wave) is not None and len(candidate.amplitudes) == 2 * length:
        return np.concatenate([np.cos(turns) * drawn, np.sin(turns) * drawn], axis=1)
    alone = np.zeros((len(drawn) if length > 1 else 1, len(candidate.amplitudes)))
    alone[:, :length] = drawn[: len(alone)]
    return alone


def likely_shapes(evidence: Evidence, law: Effect) -> tuple[list[Candidate], float]:
    """Shapes at which an effect may hide, at all its sizes where its shape makes it; and how many a scan tries."""
    if is_wave(law):
        return _likely_waves(evidence, law)
    grid = list(candidates(evidence, law))
    _, trials = intervals(evidence, law, grid)
    size, window = size_of(law), kind_of(law, Window)
    left = [*list_fields(law), *([window.start, window.stop] if window else []), size.field if size else ""]
    for field, role in law.ROLES.items():
        if role["role"] != "shape" or role["quantity"] in ("exponent", "one", "relative") or field in left:
            continue
        values = sorted({float(one.shape[field]) for one in grid})
        if size and size.made_by_shape and role["low"] == 0.0:  # what may be absent is, as a damping
            grid = [replace(one, shape={**one.shape, field: 0.0}) for one in grid if one.shape[field] == values[0]]
        else:
            kept = _middle(values, bool(role["logarithmic"]))
            grid = [one for one in grid if one.period is not None or one.shape[field] in kept]
    if not (size and size.made_by_shape):
        grid = grid[:: -(-len(grid) // LIMIT.likely_count) or 1]
    return grid, max(trials, 1.0)


def _middle(values: Sequence[float], logarithmic: bool) -> set[float]:
    """Of values that are even, or have even logarithms, those in the middle half of their range."""
    if len(values) < LIMIT.middle_values:
        return set(values)
    places = np.log(values) if logarithmic else np.array(values)
    low, high = (places[0] + part * (places[-1] - places[0]) for part in LIMIT.middle)
    return {value for value, where in zip(values, places, strict=True) if low <= where <= high}


def _likely_waves(evidence: Evidence, law: Effect) -> tuple[list[Candidate], float]:
    """Waves in the middle half of their range but for periods that the model knows; and how many a scan tries."""
    low, high = wave_range(evidence, law)
    if not 0.0 < low < high:
        return [], 1.0
    waves = np.exp([np.log(low) + part * np.log(high / low) for part in np.linspace(*LIMIT.middle, LIMIT.likely_waves)])
    if not is_spatial_wave(law):
        return [wave_of(evidence, law, float(wave)) for wave in waves], max(1.0, (high - low) * evidence.scales.time)
    span = evidence.scales.position
    known = [1.0 / period for period in known_periods(evidence.model)]
    free = [wave for wave in waves if all(abs(wave - one) > 1.0 / span for one in known)]
    trials = (min(high, 0.5 * SPECTRUM.bins / span) - low) * span
    return [wave_of(evidence, law, float(1.0 / wave)) for wave in free], max(1.0, trials)


def told_shape(law: Effect, found: Sequence[Candidate], size: Size) -> dict[str, Any]:
    """Each number of the shapes beside the size: its value, or the range that the shapes span."""
    told: dict[str, Any] = {}
    for field, role in law.ROLES.items():
        if role["role"] != "shape" or field in list_fields(law) or field == size.field:
            continue
        values = [float(one.shape[field]) for one in found]
        low, high = min(values), max(values)
        told[field] = low if low == high else [low, high]
        if size.made_by_shape and is_share(role):
            told[field] = LIMIT.share_behind
    return told


def is_share(role: Any) -> bool:
    """Whether a shape is a share that starts from nothing: what an effect does is nearly proportional to it."""
    return bool(role["quantity"] == "relative" and role["neutral"] == 0.0)


def range_of(evidence: Evidence, law: Effect, size: Size) -> tuple[float, float]:
    """The least and the strongest size that a search looks for; where less does more, the strongest is the smallest."""
    role = law.ROLES[size.field]
    if not size.made_by_shape:
        return 0.0, float(role["high"]) * quantities(evidence)[role["quantity"]]
    low, high = shape_range(evidence, role)
    if not size.grows:
        return high, low
    return (0.5 * low if role["logarithmic"] else 0.0), high
