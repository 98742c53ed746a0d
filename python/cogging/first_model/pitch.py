"""A spatial period that stands out of what mass and friction leave of a command."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from cogging.arrays import FloatArray
from cogging.mapping.spectrum import HarmonicSpectrum

ROWS = 3000  # independent enough, and enough for a spectrum
FEWEST_PERIODS = 3  # in the travel: a longer wave may be a slope
MOST_PERIODS = 400
A_PERIOD = 8  # rows, at least, in the shortest period that is sought
SHARE = 0.1  # of what is left, that the wave must explain to be worth a line
LEAST = 0.03  # of the rms command, that its amplitude must be
ALIKE = 0.4  # of its amplitude, by which the wave of one half of the rows may differ from the other's
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
    """The strongest wave of a force over position that both halves of the rows show alike; None where there is none.

    Args:
        position: m, (n,).
        force: V, (n,).
        command_rms: V, of all that the command does: a wave that is small beside it is not worth a line.
    """
    travel = float(np.ptp(position)) if len(position) else 0.0
    if len(position) < 200 or travel == 0.0:
        return None
    taken = np.linspace(0, len(position) - 1, min(len(position), ROWS)).astype(int)
    x, f = position[taken], force[taken]
    nuisance = np.column_stack([np.ones(len(x)), (x - x.mean()) / travel])
    rest = f - nuisance @ np.linalg.lstsq(nuisance, f, rcond=None)[0]
    spectrum = HarmonicSpectrum(x, 2.0 * travel, 2 * min(MOST_PERIODS, len(x) // A_PERIOD))  # lines half as far apart
    power = spectrum.power(rest)
    power[: 2 * FEWEST_PERIODS] = 0.0
    frequency = float(spectrum.frequency.ravel()[int(np.argmax(power))])
    wave = _refined(x, rest, frequency, 0.5 / travel)
    worth = wave.share > SHARE and math.hypot(wave.sine, wave.cosine) > LEAST * command_rms
    return wave if worth and _stays(x, rest, wave) else None


def _stays(x: FloatArray, rest: FloatArray, wave: Wave) -> bool:
    """Whether the first half of the rows shows the same wave as the second: what is bound to the place does."""
    phase = 2.0 * np.pi * x / wave.period
    columns = np.column_stack([np.sin(phase), np.cos(phase)])
    half = len(x) // 2
    weights = [np.linalg.lstsq(columns[rows], rest[rows], rcond=None)[0] for rows in (slice(half), slice(half, None))]
    return bool(np.linalg.norm(weights[0] - weights[1]) < ALIKE * math.hypot(wave.sine, wave.cosine))


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
