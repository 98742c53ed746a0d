"""Pitch and periods of a cogging model, whichever of them it is given by."""

from __future__ import annotations

import math

import numpy as np

from cogging._core import SplineHarmonics

PERIODS_IN_PITCH = 64  # how many times the longest period may go into the common pitch of a list of periods


def periods_of(basis: SplineHarmonics) -> list[float]:
    """The spatial periods of a cogging model, m, whether given as such or as harmonics of a pitch."""
    return [2.0 * math.pi / wavenumber for wavenumber in basis.wavenumbers]


def pitch_and_harmonics(basis: SplineHarmonics) -> tuple[float, list[int]]:
    """The pitch (m) and harmonics of a cogging model: of periods, a pitch of which all are whole fractions.

    Raises:
        ValueError: there is no such pitch; with several control points it must be the distance of the knots.
    """
    if basis.harmonics:
        return basis.pitch, list(basis.harmonics)
    periods = np.array(basis.periods)
    if basis.spline.control_points > 1:
        pitches = [basis.spline.pitch]
    else:
        pitches = [times * float(periods.max()) for times in range(1, PERIODS_IN_PITCH + 1)]
    for pitch in pitches:
        ratio = pitch / periods
        if (np.round(ratio) >= 1).all() and np.abs(ratio - np.round(ratio)).max() < 1e-6:
            return pitch, [int(n) for n in np.round(ratio)]
    raise ValueError(
        "cogging.periods: must be whole fractions of one pitch (with several control points: of the distance of the "
        f"knots) for arc and dcarc, got {periods.tolist()}"
    )
