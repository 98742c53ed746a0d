"""How far a sampled linear loop is from instability, from its frequency response."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np
import numpy.typing as npt

from cogging.arrays import FloatArray
from cogging.values import ByValue

POINTS = 4000  # frequencies at which the loop is looked at
AROUND = 60  # more of them about each resonance
REFINED = 60  # halvings of a crossing


@dataclass(frozen=True, eq=False, repr=False)
class LoopMargins(ByValue):
    """Margins of a loop; all 0 of an unstable one.

    Attributes:
        stable: whether the closed loop is.
        gain: the smallest factor above 1 on the command with which it is not; infinite where there is none.
        gain_down: the largest factor below 1; 0 where there is none.
        phase: degrees, by which the loop may lag more, the least of all crossings of |L| = 1.
        delay: s, by which the command may come later, the least of all crossings.
        modulus: smallest distance of L from -1: 1 over the largest sensitivity.
        crossover: Hz, highest frequency at which |L| = 1; 0 where it never is.
    """

    stable: bool
    gain: float
    gain_down: float
    phase: float
    delay: float
    modulus: float
    crossover: float

    def _brief(self) -> str:
        return self.text().replace("\n", "; ")

    def text(self) -> str:
        """The margins in one line."""
        if not self.stable:
            return "unstable"
        return (
            f"gain margin {self.gain:.4g} (down to {self.gain_down:.3g}), phase margin {self.phase:.4g} degrees, "
            f"delay margin {self.delay:.4g} s, modulus margin {self.modulus:.4g}, crossover {self.crossover:.5g} Hz"
        )


def margins_of(
    response: Callable[[FloatArray], Any], sample_rate: float, lowest: float, poles: npt.ArrayLike, *, stable: bool
) -> LoopMargins:
    """Margins of the loop with this frequency response.

    Args:
        response: L at frequencies in Hz.
        sample_rate: Hz.
        lowest: of the frequencies, over the sample rate.
        poles: of the loop, in z: about lightly damped ones it is looked at more closely.
        stable: whether the closed loop is.
    """
    if not stable:
        return LoopMargins(False, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0)
    frequency = _frequencies(sample_rate, lowest, np.asarray(poles, dtype=complex))
    loop = np.asarray(response(frequency))
    unity = _crossings(lambda f: np.log(np.abs(response(f))), frequency, np.log(np.abs(loop)))
    lag = np.angle(-np.asarray(response(unity))) % (2.0 * np.pi) if unity.size else np.empty(0)
    lead = np.minimum(lag, 2.0 * np.pi - lag)
    real = _crossings(lambda f: np.imag(response(f)), frequency, loop.imag)
    factors = -1.0 / np.real(np.asarray(response(real))) if real.size else np.empty(0)
    nyquist = float(np.real(response(np.array([0.5 * sample_rate]))[0]))
    factors = np.append(factors, -1.0 / nyquist if nyquist != 0.0 else -1.0)
    modulus = float(np.abs(1.0 + loop).min())
    return LoopMargins(
        True,
        float(factors[factors > 1.0].min(initial=math.inf)),
        float(factors[(factors > 0.0) & (factors < 1.0)].max(initial=0.0)),
        float(np.degrees(lead.min(initial=np.pi))),
        float((lag / (2.0 * np.pi * unity)).min(initial=math.inf)) if unity.size else math.inf,
        modulus,
        float(unity.max(initial=0.0)),
    )


def _frequencies(sample_rate: float, lowest: float, poles: npt.NDArray[np.complex128]) -> FloatArray:
    """Evenly on a logarithmic scale up to half the sample rate, and closer about the poles that ring."""
    parts = [np.geomspace(lowest, 0.5, POINTS)]
    for pole in poles[(poles.imag > 0.0) & (np.abs(poles) > 0.0)]:
        place, width = np.angle(pole) / (2.0 * np.pi), max(-math.log(abs(pole)) / (2.0 * np.pi), 1e-9)
        near = width * np.geomspace(1e-2, 1e2, AROUND)
        parts.append(np.concatenate([[place], place + near, place - near]))
    found = np.unique(np.concatenate(parts))
    return np.asarray(sample_rate * found[(found >= lowest) & (found <= 0.5)], dtype=np.float64)


def _crossings(value: Callable[[FloatArray], Any], frequency: FloatArray, at: FloatArray) -> FloatArray:
    """Frequencies at which a value changes its sign, halved in."""
    places = np.flatnonzero(np.sign(at[1:]) * np.sign(at[:-1]) < 0.0)
    low, high, sign = frequency[places], frequency[places + 1], np.sign(at[places])
    for _ in range(REFINED if places.size else 0):
        middle = np.sqrt(low * high)
        same = np.sign(np.asarray(value(middle))) == sign
        low, high = np.where(same, middle, low), np.where(same, high, middle)
    return np.asarray(np.sqrt(low * high), dtype=np.float64)
