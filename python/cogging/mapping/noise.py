"""The noise of a fitted map, line by line of its spectrum, and what it does to the coefficients."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from cogging.arrays import FloatArray
from cogging.mapping.result import HarmonicAmplitude
from cogging.mapping.scan import Scan
from cogging.mapping.spectrum import HarmonicSpectrum
from cogging.mapping.spline_fit import SplineFit, predict


@dataclass(frozen=True)
class Noise:
    """The noise of a fit.

    Attributes:
        level: V^2, of every line.
        turned: V^2, likewise of direction times residual: what differs between the directions.
        degrees: degrees of freedom of the levels.
        covariance: V^2, of the coefficients, (p + q, p + q).
        standard_errors: V, of the coefficients, (p + q,).
    """

    level: FloatArray
    turned: FloatArray
    degrees: float
    covariance: FloatArray
    standard_errors: FloatArray

    @classmethod
    def of(
        cls, spectrum: HarmonicSpectrum, scan: Scan, fit: SplineFit, terms: list[int], order: int, odd: list[int]
    ) -> Noise:
        """The noise that a fit of some harmonics leaves; `odd` are those that change sign with the direction."""
        taken = spectrum.taken_by(terms, modulated=order > 0)
        level, degrees = spectrum.level(spectrum.power(fit.residual), taken, fit.variance)
        # What differs between the directions is noise to the Coulomb level, though a map of position hardly sees it.
        gone = spectrum.taken_by(odd, modulated=False)
        turned, _ = spectrum.level(spectrum.power(fit.residual * scan.direction), gone, fit.variance)
        slowest, middle = level[spectrum.present][0], level.shape[1] // 2
        of_directions = [turned[spectrum.present][0], *np.repeat(turned[odd, middle], 2)] if scan.both_ways else []
        nuisance = [slowest, *of_directions, slowest]
        points = 0 if fit.basis is None else fit.basis.spline.control_points
        columns = np.tile(np.repeat(level[terms, middle], 2), points)
        columns = np.concatenate([columns, nuisance])[: len(fit.coefficients)]
        least = fit.variance
        if spectrum.few:  # no level of its own for slow noise: what the correlation of neighbours says of it
            squares = max(float(fit.residual @ fit.residual), np.finfo(float).tiny)
            correlation = float(fit.residual[1:] @ fit.residual[:-1]) / squares
            least *= max(1.0, (1.0 + correlation) / (1.0 - correlation))
        covariance = fit.covariance(np.maximum(columns, least))
        return cls(level, turned, degrees, covariance, np.sqrt(np.diag(covariance)))

    def threshold(self, spectrum: HarmonicSpectrum, false_alarm: float) -> FloatArray:
        """The amplitude (V) at which each line of the spectrum that is present has that false alarm."""
        power = self.level * spectrum.threshold(false_alarm, self.degrees)
        return np.asarray(spectrum.amplitude(power)[spectrum.present])


def amplitudes(spectrum: HarmonicSpectrum, scan: Scan, fit: SplineFit, noise: Noise) -> tuple[HarmonicAmplitude, ...]:
    """The table of the harmonics."""
    if fit.basis is None:
        return ()
    basis, entries = fit.basis, []
    weights = basis.spline.design_matrix(scan.position)
    gram, mean = weights.T @ weights / len(weights), weights.mean(axis=0)
    step = 2 * basis.terms
    for i, harmonic in enumerate(basis.harmonics):
        s, c = (fit.coefficients[: basis.coefficients][2 * i + part :: step] for part in (0, 1))
        chosen = [slice(2 * i + part, basis.coefficients, step) for part in (0, 1)]
        covariance = np.block([[noise.covariance[a, b] for b in chosen] for a in chosen])
        amplitude = float(np.sqrt(s @ gram @ s + c @ gram @ c))
        gradient = np.concatenate([gram @ s, gram @ c]) / max(amplitude, np.finfo(float).tiny)
        own = np.zeros_like(fit.coefficients)
        for part in chosen:
            own[part] = fit.coefficients[part]
        component = predict(basis, own, scan.position, np.zeros((len(scan.position), len(own) - basis.coefficients)))
        rows = slice(harmonic, harmonic + 1)
        power = spectrum.power(fit.residual + component, rows)
        ratio = np.max(np.where(spectrum.near[rows], power / noise.level[rows], 0.0))
        entries.append(
            HarmonicAmplitude(
                harmonic=harmonic,
                amplitude=amplitude,
                standard_error=float(np.sqrt(gradient @ covariance @ gradient)),
                phase=float(np.arctan2(mean @ c, mean @ s)),
                false_alarm=float(spectrum.false_alarm(ratio, noise.degrees)),
            )
        )
    return tuple(entries)
