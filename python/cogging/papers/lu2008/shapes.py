"""Assumed shapes of the cogging maps of Lu et al. 2008, of which the paper shows pictures alone (Figs. 5 and 6)."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from cogging.arrays import FloatArray

#: Periodic, modulated and uncompensated part of a map, V.
Amplitudes = tuple[float, float, float]


@dataclass(frozen=True)
class MapShape:
    """What makes an assumed map beside its three amplitudes; none of it is reported.

    F(x) = sum_h f_h(x) sin(2 pi h (x / P + shift)), V. A compensated harmonic has
    f_h = (periodic + modulated a(s)) / h^decay, one that is not f_h = uncompensated (1 + a(s) / 2) / h^decay, with
    a(s) = cos(pi half_waves s + begin), where s runs from 0 at the first magnet to 1 at the last.

    Attributes:
        decay: exponent by which harmonics fall with their number.
        half_waves: of the modulation, from the first magnet to the last.
        begin: rad, where the modulation begins.
        shift: share of a pitch from a zero of all sines to the first magnet. At 0 all of a harmonic lies in its sine,
            whose coefficient the paper bounds; at 1/8 that of the fundamental is shared with its cosine.
    """

    decay: float
    half_waves: float
    begin: float
    shift: float


def control_points(
    shape: MapShape, amplitudes: Amplitudes, harmonics: Sequence[int], compensated: Sequence[int], count: int
) -> tuple[FloatArray, FloatArray]:
    """Control points (V) of the sines and of the cosines of a map, each (harmonics, count).

    Args:
        shape: of the map.
        amplitudes: periodic, modulated and uncompensated part, V.
        harmonics: of the map.
        compensated: those of them that C3 compensates.
        count: of control points; those outside the travel continue the modulation.
    """
    periodic, modulated, uncompensated = amplitudes
    number = np.array(harmonics, dtype=float)
    # s = 0 and 1 at the control points 1 and count - 1.
    along = np.cos(np.pi * shape.half_waves * (np.arange(count) - 1) / (count - 2) + shape.begin)
    known = np.isin(harmonics, compensated)[:, None]
    strength = np.where(known, periodic + modulated * along, uncompensated * (1 + along / 2))
    strength = strength / number[:, None] ** shape.decay
    phase = 2 * np.pi * number[:, None] * shape.shift
    return strength * np.cos(phase), strength * np.sin(phase)
