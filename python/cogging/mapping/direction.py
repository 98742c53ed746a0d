"""Content of a scan that changes its sign with the direction of motion and repeats with the pitch."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from cogging.arrays import FloatArray
from cogging.mapping.noise import Noise
from cogging.mapping.result import HarmonicAmplitude
from cogging.mapping.scan import Scan
from cogging.mapping.spectrum import FLOOR, HarmonicSpectrum, Line
from cogging.mapping.spline_fit import SplineFit, rows_of
from cogging.model.units import Units

MOST_TERMS = 32  # harmonics that are fitted in direction g(x)
LAG_SHARE = 0.9  # of the power of g(x) that one lag must explain to be called one
LAGS = 2001  # that are tried over one period of the highest harmonic


@dataclass(frozen=True)
class DirectionContent:
    """direction g(x) of a fit, g(x) = sum_h (a_h sin(2 pi h x / pitch) + b_h cos(2 pi h x / pitch)).

    Attributes:
        amplitudes: of g, one entry a harmonic.
        rms: V, of g(x) over the scan's points; 0 where there is none.
        lag: m, by which a map that follows the motion would give the same, F_cogging(x - lag direction); None where no
            single lag does.
    """

    amplitudes: tuple[HarmonicAmplitude, ...]
    rms: float
    lag: float | None

    @classmethod
    def of(
        cls, spectrum: HarmonicSpectrum, scan: Scan, fit: SplineFit, noise: Noise, harmonics: list[int]
    ) -> DirectionContent:
        """What a fit with the columns of `direction_columns` after offset and Coulomb friction found."""
        if not harmonics:
            return cls((), 0.0, None)
        first = (0 if fit.basis is None else fit.basis.coefficients) + 2
        chosen = slice(first, first + 2 * len(harmonics))
        columns, coefficients = direction_columns(scan, spectrum.pitch, harmonics), fit.coefficients[chosen]
        content = columns @ coefficients
        turned = spectrum.power((fit.residual + content) * scan.direction)
        covariance = noise.covariance[chosen, chosen]
        entries = []
        for i, harmonic in enumerate(harmonics):
            s, c = coefficients[2 * i : 2 * i + 2]
            amplitude = float(np.hypot(s, c))
            gradient = np.array([s, c]) / max(amplitude, np.finfo(float).tiny)
            own = covariance[2 * i : 2 * i + 2, 2 * i : 2 * i + 2]
            middle = turned.shape[1] // 2
            ratio = float(turned[harmonic, middle] / noise.turned[harmonic, middle])
            entries.append(
                HarmonicAmplitude(
                    harmonic=harmonic,
                    amplitude=amplitude,
                    standard_error=float(np.sqrt(gradient @ own @ gradient)),
                    phase=float(np.arctan2(c, s)),
                    false_alarm=float(spectrum.false_alarm(ratio, noise.degrees)),
                )
            )
        lag = _lag(fit, scan, spectrum.pitch, dict(zip(harmonics, coefficients.reshape(-1, 2), strict=True)))
        return cls(tuple(entries), float(np.sqrt(np.mean(content**2))), lag)

    def notes(self, coulomb: float | None, units: Units) -> list[str]:
        """What the reader has to know of it."""
        if not self.amplitudes:
            return []
        v = units.command
        which = ", ".join(str(entry.harmonic) for entry in sorted(self.amplitudes, key=lambda a: -a.amplitude)[:8])
        against = f", Coulomb friction is {coulomb:.3g} {v}" if coulomb is not None else ""
        if self.lag is None:
            cause = "friction that ripples along the travel, or hysteresis"
        else:
            way = "late" if self.lag > 0.0 else "early"
            lag = f"{abs(self.lag):.3g} {units.position}"
            cause = f"as of a map that comes {lag} {way} each way: hysteresis, play or a late reading"
        return [
            f"{self.rms:.3g} {v} rms of the force change sign with the direction of motion (harmonics {which}"
            f"{against}): {cause}; not in the map, which is the mean of both ways"
        ]


def direction_columns(scan: Scan, pitch: float, harmonics: list[int]) -> FloatArray:
    """Columns direction sin(2 pi h x / pitch), direction cos(...), harmonic by harmonic, (n, 2 harmonics)."""
    columns = np.empty((len(scan.position), 2 * len(harmonics)))
    for i, harmonic in enumerate(harmonics):
        angle = 2.0 * np.pi * harmonic / pitch * scan.position
        columns[:, 2 * i], columns[:, 2 * i + 1] = scan.direction * np.sin(angle), scan.direction * np.cos(angle)
    return columns


def find_direction_lines(
    spectrum: HarmonicSpectrum, scan: Scan, residual: FloatArray, false_alarm: float
) -> list[Line]:
    """The lines that stand out of direction times residual; none of a scan that goes one way only.

    Args:
        spectrum: of the scan.
        scan: its points.
        residual: what the map with offset, trend and Coulomb friction leaves, V, (n,).
        false_alarm: the probability at which noise alone yields any.
    """
    if not scan.both_ways or np.std(residual) <= FLOOR * np.std(scan.force):
        return []
    steady = np.stack([np.ones_like(residual), scan.direction], axis=1)
    return spectrum.find(residual * scan.direction, steady, false_alarm)


def _lag(fit: SplineFit, scan: Scan, pitch: float, odd: dict[int, FloatArray]) -> float | None:
    """The lag at which F(x - lag direction) has these parts that change sign; None where it explains too little.

    F's harmonic s sin + c cos turns into cos(k lag) (s sin + c cos) + direction sin(k lag) (c sin - s cos), k = 2 pi h
    / pitch; the map is fitted to the first part.
    """
    if fit.basis is None:
        return None
    sine, cosine = rows_of(fit.basis, fit.coefficients[: fit.basis.coefficients])
    weights = fit.basis.spline.design_matrix(scan.position).mean(axis=0)
    table = {h: (s @ weights, c @ weights) for h, s, c in zip(fit.basis.harmonics, sine, cosine, strict=True)}
    harmonics = sorted({*table, *odd})
    even = np.array([table.get(h, (0.0, 0.0)) for h in harmonics])
    seen = np.array([odd.get(h, np.zeros(2)) for h in harmonics])
    wave_numbers = 2.0 * np.pi * np.array(harmonics) / pitch
    lags = np.linspace(-0.5, 0.5, LAGS)[1:-1] * pitch / (2.0 * max(odd))
    angles = np.outer(lags, wave_numbers)
    moved = np.tan(angles)[:, :, None] * np.stack([even[:, 1], -even[:, 0]], axis=1)
    left = ((seen - moved) ** 2).sum(axis=(1, 2))
    best = int(np.argmin(left))
    return float(lags[best]) if left[best] <= (1.0 - LAG_SHARE) * float((seen**2).sum()) else None
