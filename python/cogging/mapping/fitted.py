"""A fitted map with its spectrum and noise: what is to be noted of it, and the result made of it."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from cogging._core import SplineHarmonics
from cogging.arrays import FloatArray
from cogging.mapping.direction import DirectionContent, direction_columns, find_direction_lines
from cogging.mapping.noise import Noise, amplitudes
from cogging.mapping.result import CrossValidation, MapFit
from cogging.mapping.scan import Scan
from cogging.mapping.spectrum import FLOOR, HarmonicSpectrum, Line
from cogging.mapping.spline_fit import SplineFit, cogging_of, fit_splines, rows_of
from cogging.model.units import Units

SIGNIFICANT = 3.0  # standard errors from which a trend is kept
TREND_TRAVEL = 2.0  # pitches: over a shorter travel a trend looks like the first harmonic and is not tried


@dataclass(frozen=True)
class FittedMap:
    """A fit that is decided on.

    Attributes:
        spectrum: of the scan.
        scan: what was fitted.
        terms: the harmonics.
        odd: harmonics of what changes sign with the direction of motion.
        order: of the splines; 0 = periodic.
        nuisance: columns beside the map, (n, q).
        fit: coefficients; noise: of them.
        trend: V/m, and its standard error; 0 where there is none.
    """

    spectrum: HarmonicSpectrum
    scan: Scan
    terms: list[int]
    odd: list[int]
    order: int
    nuisance: FloatArray
    fit: SplineFit
    noise: Noise
    trend: tuple[float, float]

    @classmethod
    def of(
        cls, spectrum: HarmonicSpectrum, scan: Scan, terms: list[int], odd: list[int], order: int, fit: SplineFit
    ) -> FittedMap:
        """Keep the trend where the scan shows one, else fit once more without it."""
        noise = Noise.of(spectrum, scan, fit, terms, order, odd)
        trend, error = float(fit.coefficients[-1] / scan.travel), float(noise.standard_errors[-1] / scan.travel)
        if scan.spans(TREND_TRAVEL * spectrum.pitch) and abs(trend) > SIGNIFICANT * error:
            nuisance = nuisance_columns(scan, spectrum.pitch, odd, trend=True)
            return cls(spectrum, scan, terms, odd, order, nuisance, fit, noise, (trend, error))
        nuisance = nuisance_columns(scan, spectrum.pitch, odd, trend=False)
        fit = fit_splines(fit.basis, scan.position, scan.force, nuisance)
        noise = Noise.of(spectrum, scan, fit, terms, order, odd)
        return cls(spectrum, scan, terms, odd, order, nuisance, fit, noise, (0.0, 0.0))

    @property
    def coefficients(self) -> int:
        """Of the map alone."""
        return 0 if self.fit.basis is None else self.fit.basis.coefficients

    @property
    def direction(self) -> DirectionContent:
        """What changes sign with the direction of motion."""
        return DirectionContent.of(self.spectrum, self.scan, self.fit, self.noise, self.odd)

    @property
    def coulomb(self) -> tuple[float, float] | tuple[None, None]:
        """V, and its standard error; None where it is not told from the offset."""
        if not self.scan.both_ways:
            return None, None
        place = self.coefficients + 1
        return float(self.fit.coefficients[place]), float(self.noise.standard_errors[place])

    def notes(self, false_alarm: float) -> list[str]:
        """What the reader has to know about this fit."""
        notes, of = [], self.scan.units.of
        if self.trend != (0.0, 0.0):
            trend, error = self.trend
            size = f"{trend:.3g} +- {error:.1g} {of('V/m')}"
            notes.append(f"the force also has a trend of {size}, which is not part of the map")
        if np.std(self.fit.residual) > FLOOR * np.std(self.scan.force):
            taken = self.spectrum.taken_by(self.terms, modulated=self.order > 0)
            lines = self.spectrum.find(self.fit.residual, self.nuisance, false_alarm, taken)
            notes += _unmodelled(lines, self.terms, self.spectrum.pitch, self.scan.units)
        coulomb, error_of_it = self.coulomb
        notes += self.direction.notes(coulomb, self.scan.units)
        for line in find_direction_lines(self.spectrum, self.scan, self.fit.residual, false_alarm)[:1]:
            if line.harmonic is None:
                period = f"period {1.0 / line.frequency:.3g} {of('m')}, which is none of the pitch"
                notes.append(f"{line.amplitude:.2g} {of('V')} change sign with the direction of motion with {period}")
        if coulomb is not None and error_of_it is not None and coulomb < -SIGNIFICANT * error_of_it:
            notes.append(
                f"the force is lower in the direction of motion ({coulomb:.3g} {of('V')}): is force_sign right?"
            )
        if unexcited := _unexcited(self.fit):
            which = ", ".join(map(str, unexcited))
            notes.append(f"the scan does not determine control points {which}: they continue their neighbours")
        return notes

    def result(self, scores: Sequence[CrossValidation], notes: Sequence[str], false_alarm: float) -> MapFit:
        """All of it, with the cross-validation that led to it."""
        spectrum, scan, fit, noise, p = self.spectrum, self.scan, self.fit, self.noise, self.coefficients
        # No harmonic: the one map that says nothing.
        basis = fit.basis or SplineHarmonics(pitch=spectrum.pitch, harmonics=[1])
        values, errors = (a[:p] if p else np.zeros(2) for a in (fit.coefficients, noise.standard_errors))
        sine_error, cosine_error = rows_of(basis, errors)
        coulomb, coulomb_error = self.coulomb
        direction = self.direction
        explained = scan.force - self.nuisance @ fit.coefficients[p:]
        return MapFit(
            cogging=cogging_of(basis, values),
            order=self.order,
            sine_standard_error=sine_error,
            cosine_standard_error=cosine_error,
            amplitudes=amplitudes(spectrum, scan, fit, noise),
            offset=float(fit.coefficients[p]),
            offset_standard_error=float(noise.standard_errors[p]),
            coulomb=coulomb,
            coulomb_standard_error=coulomb_error,
            direction_amplitudes=direction.amplitudes,
            direction_rms=direction.rms,
            direction_lag=direction.lag,
            trend=self.trend[0],
            trend_standard_error=self.trend[1],
            residual_rms=float(np.sqrt(np.mean(fit.residual**2))),
            noise=float(np.sqrt(np.median(noise.level[spectrum.present]))),
            cross_validation=tuple(scores),
            unexcited=_unexcited(fit),
            notes=tuple(notes),
            position=scan.position,
            force=scan.force,
            direction=scan.direction,
            fitted=scan.force - fit.residual,
            line=spectrum.pitch * spectrum.frequency[spectrum.present],
            line_amplitude=spectrum.amplitude(spectrum.power(explained))[spectrum.present],
            line_threshold=noise.threshold(spectrum, false_alarm),
            units=scan.units,
        )


def nuisance_columns(scan: Scan, pitch: float, odd: list[int], trend: bool) -> FloatArray:
    """Columns of the offset, of friction where it can be told from it, of a trend over the travel; (n, 1 or more).

    Args:
        scan: the points.
        pitch: m.
        odd: harmonics of the friction, or of what else changes sign with the direction of motion.
        trend: whether there is a column of it, the last.
    """
    x = (scan.position - 0.5 * (scan.position.min() + scan.position.max())) / scan.travel
    ways = [scan.direction, *direction_columns(scan, pitch, odd).T] if scan.both_ways else []
    return np.stack([np.ones_like(x), *ways, *([x] if trend else [])], axis=1)


def _unmodelled(lines: list[Line], terms: list[int], pitch: float, units: Units) -> list[str]:
    """Say what stands out and is not in the model: changes of its harmonics, the three strongest of other lines."""
    notes = []
    for line in sorted((line for line in lines if line.harmonic not in terms), key=lambda line: -line.amplitude)[:3]:
        which = (
            f"harmonic {line.harmonic}" if line.harmonic is not None else f"{line.frequency * pitch:.3g} times a pitch"
        )
        size, period = f"{line.amplitude:.2g} {units.command}", f"{1.0 / line.frequency:.4g} {units.position}"
        notes.append(f"not in the map: {size} with period {period} ({which})")
    changing = [str(line.harmonic) for line in lines if line.harmonic in terms]
    if changing:
        notes.append(f"harmonics {', '.join(changing)} change along the travel in a way that the map does not follow")
    return notes


def _unexcited(fit: SplineFit) -> tuple[int, ...]:
    """Control points of which the scan decides less than half, the mean over their coefficients."""
    if fit.basis is None:
        return ()
    points = fit.basis.spline.control_points
    decided = fit.determined[: fit.basis.coefficients].reshape(points, -1).mean(axis=1)
    return tuple(int(point) for point in np.flatnonzero(decided < 0.5))
