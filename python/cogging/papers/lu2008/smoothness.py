"""What is left of the cogging in the error at constant speed: how Lu, Chen, Yao, Wang 2008 read Figs. 8 and 10."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from cogging.arrays import FloatArray
from cogging.logs.log import Log
from cogging.papers.lu2008.setup import HARMONICS, PITCH, SAMPLE_RATE, GantryAxis, reference
from cogging.papers.result import Row, Table

AT_SPEED = 1.0 - 1e-9  # of the largest velocity


def at_constant_speed(axis: GantryAxis, log: Log) -> FloatArray:
    """The error (m) at constant speed in the last move forth, by whole pitches: (pitches, rows of one)."""
    motion = reference(axis)
    assert log.reference_velocity is not None
    rows = np.flatnonzero(
        (log.time >= motion.end - motion.period) & (log.reference_velocity > AT_SPEED * axis.velocity)
    )
    of_pitch = round(PITCH / axis.velocity * SAMPLE_RATE)
    pitches = len(rows) // of_pitch
    return log.error[rows[: pitches * of_pitch]].reshape(pitches, of_pitch)


def rms_at(error: FloatArray, harmonics: tuple[int, ...]) -> float:
    """The rms (m) of the parts of an error at harmonics of the pitch, pitch by pitch.

    Args:
        error: m, (pitches, rows of one).
        harmonics: of the pitch.
    """
    lines = np.abs(np.fft.rfft(error, axis=1)[:, list(harmonics)]) / error.shape[1]
    return float(np.sqrt(2.0 * np.sum(lines**2) / len(error)))


def smoothness_table(axis: GantryAxis, logs: Mapping[str, Log]) -> Table:
    """The rms error of C1, C2, C3 at constant speed: all of it, at the harmonics that C3 compensates, at the others."""
    others = tuple(harmonic for harmonic in HARMONICS if harmonic not in axis.compensated)
    rows = []
    for name, log in logs.items():
        error = at_constant_speed(axis, log)
        for part, found in (
            ("all", float(np.sqrt(np.mean(error**2)))),
            (_listed(axis.compensated), rms_at(error, axis.compensated)),
            (_listed(others), rms_at(error, others)),
        ):
            rows.append(Row(name, "e_2", "m", None, found, "exploratory", {"harmonics": part}))
    return Table(f"constant_speed_{axis.name}", f"The error at constant speed, {axis.name} axis", rows)


def _listed(harmonics: tuple[int, ...]) -> str:
    return " ".join(map(str, harmonics))
