"""The coordinate that separates a residual best: the one whose bins foretell most of it."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np

from cogging.arrays import FloatArray
from cogging.effects.effect import Effect, Wave, kind_of

BINS = 40  # of a coordinate: time is told to half a second
PLACES = 80  # bins of the position, of each direction: half of the shortest period that the machine's map has
BLOCK = 0.05  # s: rows that come one after the other, of which the next ones are foretold
CLEARLY = 0.1  # share


@dataclass(frozen=True)
class Place:
    """A coordinate against which a residual is drawn.

    Attributes:
        name, unit: of the coordinate.
        explained: share of the residual's power that its means in bins foretell (see foretold).
    """

    name: str
    unit: str
    explained: float


UNITS = {"position": "m", "velocity": "m/s", "acceleration": "m/s²", "command": "V", "time": "s"}


def places(effect: Effect, residual: FloatArray, rows: Mapping[str, FloatArray]) -> list[Place]:
    """Every coordinate with what it explains of a residual, the best first; time only where it is better by CLEARLY.

    A time is hardly ever passed twice, so that it foretells what comes with anything that changes slowly.
    """
    found = []
    for name, values in {**rows, **folded(effect, rows)}.items():
        count = PLACES if name == "position" else BINS
        bins = np.minimum(((values - values.min()) / np.ptp(values) * count).astype(int), count - 1)
        if name == "position":  # each direction by itself
            bins = bins + count * (rows["velocity"] < 0.0)
        found.append(Place(name, UNITS[name.split()[0]], foretold(residual, bins, rows["time"])))
    return sorted(found, key=lambda one: (one.name == "time") * CLEARLY - one.explained)


def foretold(residual: FloatArray, bins: Any, time: FloatArray) -> float:
    """Share of a residual's power that the bins of every second BLOCK foretell in the others, and the other way round.

    What happens once, at a place that is passed once, is thus not explained by that place.
    """
    second = np.floor(time / BLOCK).astype(int) % 2 == 1
    left = residual.copy()
    for known, asked in ((second, ~second), (~second, second)):
        rows = np.bincount(bins[known], minlength=int(bins.max()) + 1)
        sums = np.bincount(bins[known], residual[known], len(rows))
        left[asked] -= (sums / np.maximum(rows, 1))[bins[asked]]
    return max(0.0, 1.0 - float(left @ left) / max(float(residual @ residual), 1e-300))


def folded(effect: Effect, rows: Mapping[str, FloatArray]) -> dict[str, FloatArray]:
    """The position, or the time, within the period of an effect that has one."""
    wave = kind_of(effect, Wave)
    if wave is None:
        return {}
    value, spatial = float(getattr(effect, wave.shape)), effect.ROLES[wave.shape]["quantity"] == "distance"
    name, period = ("position", value) if spatial else ("time", 1.0 / value)
    return {f"{name} within the period": np.mod(rows[name], period)}
