"""Scans of the cogging of Lu, Chen, Yao, Wang 2008 (Figs. 5, 6), and the harmonics that their spectrum shows.

The paper measures the blocking force every millimetre, applies an FFT and keeps the harmonics 1, 2, 3, 6, 12 of the
pitch without saying by which rule. Here the rule is that of `cogging map` (cogging.mapping): a harmonic is kept when
noise alone would lift any line of the spectrum as high once in a hundred scans.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from cogging._core import CoggingModel
from cogging.arrays import FloatArray
from cogging.mapping.cogging_spectrum import HarmonicSpectrum
from cogging.mapping.fit_map import fit_map
from cogging.mapping.map_fit import MapFit
from cogging.papers.lu2008.setup import HARMONICS, ORDER, PITCH, TRAVEL
from cogging.papers.result import Row, Table

SCAN_STEP = 0.001  # m (section "System Identification")
SCAN_NOISE = 0.003  # V rms, not reported, assumed: of the force sensor
HIGHEST = 19  # harmonic: the last of which points 1 mm apart lie more than 2.5 in a period
FALSE_ALARM = 0.01  # not reported, assumed: of a scan of noise alone


@dataclass(frozen=True)
class CoggingScan:
    """The blocking force over the whole travel.

    Attributes:
        position: m, (n,).
        force: V, (n,).
    """

    position: FloatArray
    force: FloatArray

    @classmethod
    def of(cls, cogging: CoggingModel, noise: float = SCAN_NOISE, seed: int = 2008) -> CoggingScan:
        """Scan a map with a sensor of some noise (V rms)."""
        x = np.asarray(
            TRAVEL[0] + SCAN_STEP * np.arange(round((TRAVEL[1] - TRAVEL[0]) / SCAN_STEP) + 1), dtype=np.float64
        )
        sensor = np.random.default_rng(seed).normal(0.0, noise, x.size)
        return cls(x, np.asarray(cogging.force(x) + sensor))

    def fit(self, harmonics: list[int] | None = None) -> MapFit:
        """The map by least squares, with the paper's splines; harmonics are chosen by the rule where none are given."""
        return fit_map(
            self.position,
            self.force,
            pitch=PITCH,
            harmonics=harmonics,
            order=ORDER,
            origin=TRAVEL[0],
            highest_harmonic=HIGHEST,
            false_alarm=FALSE_ALARM,
        )


def chosen(fit: MapFit) -> tuple[int, ...]:
    """The harmonics that the rule keeps."""
    return tuple(entry.harmonic for entry in fit.amplitudes)


def at_harmonic(fit: MapFit, values: FloatArray) -> FloatArray:
    """The entries of a spectrum (line_amplitude, line_threshold) at harmonics 1 to HIGHEST, (HIGHEST,)."""
    return np.array([values[np.argmin(np.abs(fit.line - harmonic))] for harmonic in range(1, HIGHEST + 1)])


def noise_hiding(cogging: CoggingModel, harmonics: Sequence[int] = HARMONICS) -> dict[int, float]:
    """The sensor noise (V rms) at which each of some harmonics stands just as high as the rule asks for.

    A line of power p stands out of white noise sigma where p >= sigma^2 times the threshold; of a modulated harmonic
    the highest of its own lines counts.
    """
    scan = CoggingScan.of(cogging, noise=0.0)
    spectrum = HarmonicSpectrum(scan.position, PITCH, HIGHEST)
    power = np.where(spectrum.near, spectrum.power(scan.force - scan.force.mean()), 0.0).max(axis=1)
    _, degrees = spectrum.level(np.ones(spectrum.frequency.shape), ~spectrum.present, 1.0)
    needed = spectrum.threshold(FALSE_ALARM, degrees)
    return {harmonic: float(np.sqrt(power[harmonic] / needed)) for harmonic in harmonics}


def harmonics_table(name: str, cogging: CoggingModel, fit: MapFit) -> Table:
    """Amplitude of each harmonic in the scan, and whether the rule keeps it: the paper's, the rule's, the next below.

    The last two rows count the paper's harmonics that the rule keeps, and those whose own line stands above the
    threshold: one whose amplitude changes its sign along the travel has a line on either side and none between.

    Args:
        name: of the axis.
        cogging: that was scanned.
        fit: of the scan, by the rule.
    """
    kept, amplitude = chosen(fit), at_harmonic(fit, fit.line_amplitude)
    told = sorted({*HARMONICS, *kept})
    rest = [harmonic for harmonic in range(1, HIGHEST + 1) if harmonic not in told]
    rows = [_row(harmonic, amplitude, "kept" if harmonic in kept else "hidden") for harmonic in told]
    if rest:
        rows.append(_row(max(rest, key=lambda harmonic: amplitude[harmonic - 1]), amplitude, "largest of the rest"))
    threshold = float(np.median(at_harmonic(fit, fit.line_threshold)))
    rows.append(Row("rule", "threshold", "V", None, threshold, "exploratory"))
    hidden = noise_hiding(cogging)
    weakest = min(hidden, key=lambda harmonic: hidden[harmonic])
    rows.append(
        Row("rule", "noise", "V", None, hidden[weakest], "exploratory", {"harmonic": f"{weakest}, at which it is lost"})
    )
    over = amplitude >= at_harmonic(fit, fit.line_threshold)
    printed = float(len(HARMONICS))
    for index, found in (
        ("kept", len(set(kept) & set(HARMONICS))),
        ("own_lines", sum(over[harmonic - 1] for harmonic in HARMONICS)),
    ):
        rows.append(Row("rule", index, "1", printed, float(found), "exploratory", {"of": "the paper's"}))
    return Table(f"harmonics_{name}", f"Spectrum of the scan, {name} axis (the map is assumed)", rows)


def _row(harmonic: int, amplitude: FloatArray, said: str) -> Row:
    label = {"harmonic": str(harmonic), "rule": said}
    return Row("scan", "amplitude", "V", None, float(amplitude[harmonic - 1]), "exploratory", label)
