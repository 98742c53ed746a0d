"""A spatial period that stands out of what mass and friction leave of a command."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from cogging.arrays import FloatArray
from cogging.mapping.spectrum import HarmonicSpectrum

FALSE_ALARM = 1e-3  # of a scan of noise alone
ROWS = 3000  # independent enough, and enough for a spectrum
FEWEST_PERIODS = 3  # in the travel: a longer wave may be a slope
MOST_PERIODS = 400
A_PERIOD = 8  # rows, at least, in the shortest period that is sought
SHARE = 0.05  # of what is left, that the wave must explain to be worth a line
LEAST = 0.03  # of the rms command, that its amplitude must be
STEPS = 201  # of the search between two lines of the spectrum


@dataclass(frozen=True)
class Wave:
    """A wave over position.

    Attributes:
        period: m.
        sine: V; cosine: V: force = sine sin(2 pi x / period) + cosine cos(2 pi x / period), which the command meets.
        share: of the power that mass and friction leave.
    """

    period: float
    sine: float
    cosine: float
    share: float


def strongest_wave(position: FloatArray, force: FloatArray, command_rms: float) -> Wave | None:
    """The strongest wave of a force over position that noise would not leave; None where there is none.

    Args:
        position: m, (n,).
        force: V, (n,).
        command_rms: V, of all that the command does: a wave that is small beside it is not worth a line.
    """
    travel = float(np.ptp(position)) if len(position) else 0.0
    if len(position) < 200 or travel == 0.0:
        return None
    taken = np.linspace(0, len(position) - 1, min(len(position), ROWS)).astype(int)
    x, f = position[taken], force[taken] - float(np.mean(force[taken]))
    highest = min(MOST_PERIODS, len(x) // A_PERIOD)
    spectrum = HarmonicSpectrum(x, travel, highest)
    nuisance = np.column_stack([np.ones(len(x)), (x - x.mean()) / travel])
    rest = f - nuisance @ np.linalg.lstsq(nuisance, f, rcond=None)[0]
    power = spectrum.power(rest)
    level, degrees = spectrum.level(power, ~spectrum.present, float(np.mean(rest**2)))
    power[:FEWEST_PERIODS] = 0.0
    ratio = power / np.maximum(level, 1e-300)
    strongest = np.unravel_index(int(np.argmax(power)), power.shape)
    if spectrum.false_alarm(float(ratio[strongest]), degrees) > FALSE_ALARM:
        return None
    wave = _refined(x, rest, float(spectrum.frequency[strongest]), 1.0 / travel)
    worth = wave.share > SHARE and math.hypot(wave.sine, wave.cosine) > LEAST * command_rms
    return wave if worth else None


def _refined(x: FloatArray, rest: FloatArray, frequency: float, width: float) -> Wave:
    """The wave near a line of the spectrum that leaves least."""
    best = (np.inf, frequency, np.zeros(2))
    for f in np.linspace(frequency - width, frequency + width, STEPS):
        phase = 2.0 * np.pi * f * x
        columns = np.column_stack([np.sin(phase), np.cos(phase)])
        weights = np.linalg.lstsq(columns, rest, rcond=None)[0]
        left = float(np.mean((rest - columns @ weights) ** 2))
        if left < best[0]:
            best = (left, float(f), weights)
    left, f, weights = best
    whole = max(float(np.mean(rest**2)), 1e-300)
    return Wave(1.0 / f, float(weights[0]), float(weights[1]), 1.0 - left / whole)
