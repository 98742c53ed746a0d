"""Waves along the travel that are like a named one, but go with something else: no effect of the vocabulary.

A motor whose inductance changes along the travel pulls with the square of the current; friction, drag and hysteresis
may repeat with the magnets too. On one log each is nearly a cogging harmonic or a ripple of some other period.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from cogging.diagnosis.candidates.findings import Finding, cleaned, judged
from cogging.diagnosis.candidates.waves import Gain, is_spatial_wave, peaks
from cogging.diagnosis.evidence.evidence import Evidence
from cogging.diagnosis.evidence.score_test import ScoreTest, cosine
from cogging.diagnosis.residual.shape import Shape
from cogging.diagnosis.thresholds import LOOK_ALIKE


def kinds(evidence: Evidence) -> dict[str, Gain]:
    """What a wave may go with; the square of the command as a share of that of the largest."""
    largest = max(float(np.abs(source.log.command).max()) for source in evidence.sources)
    return {
        "square of the command": lambda source, along: (source.log.command / largest) ** 2,
        "friction": lambda source, along: np.sign(along.middle_velocity),
        "drag": lambda source, along: along.middle_velocity,
    }


def modulated_look_alikes(evidence: Evidence, finding: Finding) -> list[Shape]:
    """The best wave for each thing that it may go with, where it explains much the same as a finding.

    Its T is on the finding's own scale: that of the finding, and by how much more or less the look-alike explains
    against the same noise. None of what is no force along the travel.
    """
    effect = finding.candidate.law
    if not is_spatial_wave(effect) or "reading" in effect.HOOKS:
        return []
    quiet = cleaned(evidence, finding)
    same = judged(quiet, [finding.candidate], finding.trials)
    if not same:
        return []
    power = max(float(quiet.free_residual @ quiet.free_residual), 1e-300)
    found = []
    for kind, gain in kinds(quiet).items():
        tried = []
        for candidate in peaks(quiet, effect, gain)[0][: LOOK_ALIKE.wave_peaks]:
            (period,) = candidate.shape.values()
            test = wave_test(quiet, gain, float(period))
            if test.freedom == 2 and cosine(test.explained, same[0].test.explained) > LOOK_ALIKE.wave_alike:
                tried.append((test, float(period)))
        if not tried:
            continue
        test, period = max(tried, key=lambda one: one[0].statistic)
        places = np.linspace(0.0, period, LOOK_ALIKE.wave_places + 1)[:-1]
        waves = np.array([np.sin(2.0 * np.pi * places / period), np.cos(2.0 * np.pi * places / period)])
        statistic = finding.test.statistic + test.statistic - same[0].test.statistic
        found.append(
            Shape(
                f"{kind} every {1e3 * period:.4g} mm",
                "m",
                replace(test, statistic=float(statistic)),
                places,
                -(test.amplitudes @ waves),
                np.sqrt(test.deviations**2 @ waves**2),
                0.0,
                float(test.explained @ test.explained) / power,
            )
        )
    return found


def wave_test(evidence: Evidence, gain: Gain, period: float) -> ScoreTest:
    """Score test of a sine and a cosine of position, multiplied by a gain."""
    tables = []
    for source, along in zip(evidence.sources, evidence.alongs, strict=True):
        phase = 2.0 * np.pi * along.middle_position / period
        waves = gain(source, along) * np.array([np.sin(phase), np.cos(phase)])
        tables.append(source.rows_of_forces(along, waves, evidence.model.axis.mass))
    return evidence.test(evidence.whitened(tables))
