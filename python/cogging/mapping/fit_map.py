"""Fit the cogging model F_cogging(x) to a measured force-against-position scan (Lu et al. 2008, eq. 3 to 7)."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from cogging._core import SplineHarmonics
from cogging.arrays import FloatArray
from cogging.calls import check_arguments
from cogging.mapping.cogging_spectrum import (
    FLOOR,
    FOLDS,
    HarmonicSpectrum,
    Line,
    SplineFit,
    cogging_of,
    cross_validate,
    fit_splines,
    predict,
    rows_of,
)
from cogging.mapping.map_fit import CrossValidation, HarmonicAmplitude, MapFit
from cogging.mapping.scan import Scan, read_scan
from cogging.model.units import UNITS, Units
from cogging.resources import on_one_blas_thread


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


MOST_DIRECTION_TERMS = 32  # harmonics that are fitted in direction g(x)
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
        """Remarks on it."""
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
        """V, and its standard error; None if it is not separable from the offset."""
        if not self.scan.both_ways:
            return None, None
        place = self.coefficients + 1
        return float(self.fit.coefficients[place]), float(self.noise.standard_errors[place])

    def notes(self, false_alarm: float) -> list[str]:
        """Remarks on the fit."""
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
    """Remarks on significant lines outside the model: modulated harmonics, the three strongest other lines."""
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
    """Control points whose coefficients the scan determines by less than half on average."""
    if fit.basis is None:
        return ()
    points = fit.basis.spline.control_points
    decided = fit.determined[: fit.basis.coefficients].reshape(points, -1).mean(axis=1)
    return tuple(int(point) for point in np.flatnonzero(decided < 0.5))


MOST_COEFFICIENTS = 4000  # of one fit: its normal matrix is dense
SLIVER = 0.05  # of a pitch: a shorter rest of the travel gets no span of its own


@dataclass(frozen=True)
class MapRequest:
    """The options of fit_map, checked."""

    pitch: float
    harmonics: Sequence[int] | None
    order: int | None
    origin: float | None
    highest_harmonic: int
    false_alarm: float

    def __post_init__(self) -> None:
        _require(_is_number(self.pitch) and self.pitch > 0.0, "pitch", "must be finite and above 0", self.pitch)
        within = _is_number(self.false_alarm) and 0.0 < self.false_alarm < 1.0
        _require(within, "false_alarm", "must lie between 0 and 1", self.false_alarm)
        _require(
            _is_whole(self.highest_harmonic, 1),
            "highest_harmonic",
            "must be a whole number from 1",
            self.highest_harmonic,
        )
        if self.harmonics is not None:
            given = list(self.harmonics) if isinstance(self.harmonics, Sequence | np.ndarray) else [None]
            whole = all(_is_whole(harmonic, 1) for harmonic in given)
            _require(whole, "harmonics", "must be a list of whole numbers from 1", self.harmonics)
            object.__setattr__(self, "harmonics", given)
            SplineHarmonics(pitch=self.pitch, harmonics=self.harmonics)  # has rules of its own
        if self.order is not None:
            rule = "must be a whole number from 1 to 16, or 0 for a periodic map"
            _require(_is_whole(self.order, 0, 16), "order", rule, self.order)
        if self.origin is not None:
            _require(_is_number(self.origin), "origin", "must be a finite number", self.origin)

    @property
    def highest(self) -> int:
        """The last harmonic searched."""
        return max(self.highest_harmonic, *(self.harmonics or (1,)))

    def first_knot(self, scan: Scan) -> float:
        """m."""
        return float(scan.position.min()) if self.origin is None else self.origin

    def control_points(self, scan: Scan, order: int) -> int:
        """How many an order needs over the travel of a scan; 1 of a periodic map."""
        spans = np.ceil((scan.position.max() - self.first_knot(scan)) / self.pitch - SLIVER)
        return max(1, int(spans)) + order - 1 if order else 1

    def check_against(self, scan: Scan) -> None:
        """Refuse options that the scan does not support.

        Raises:
            ValueError: names the field, the rule and the value.
        """
        highest = max(self.harmonics or (1,))
        rule = f"must be at most {scan.resolvable} with points this far apart"
        _require(highest <= scan.resolvable, "harmonics", rule, highest)
        end, unit = float(scan.position.max()), scan.units.position
        _require(
            self.first_knot(scan) < end,
            "origin",
            f"must lie below the scan's highest position {end:g} {unit}",
            self.origin,
        )
        if self.harmonics is not None and self.order is not None:
            self.check_size(scan, len(self.harmonics), self.order)

    def check_size(self, scan: Scan, terms: int, order: int) -> None:
        """Refuse more coefficients than the scan has points for.

        Raises:
            ValueError: names the field, the rule and the value.
        """
        size = 2 * terms * self.control_points(scan, order)
        limit = min(MOST_COEFFICIENTS, scan.position.size - 4)
        rule = f"must need at most {limit} coefficients ({scan.position.size} points)"
        origin = f"{self.first_knot(scan):g} {scan.units.position}"
        _require(size <= limit, "order", rule, f"{size} for order {order} from origin {origin}")


def _is_number(value: object) -> bool:
    return isinstance(value, int | float | np.number) and not isinstance(value, bool) and bool(np.isfinite(value))


def _is_whole(value: object, lowest: int, highest: int = 10_000) -> bool:
    return isinstance(value, int | np.integer) and not isinstance(value, bool) and bool(lowest <= value <= highest)


def _require(holds: bool, name: str, rule: str, value: object) -> None:
    if not holds:
        raise ValueError(f"{name}: {rule}, got {value}")


ORDERS = (0, 1, 2, 3, 4)  # compared where none is given; 0 = periodic
MOST_TERMS = 32  # of SplineHarmonics
MOST_COMPARED = 2000  # coefficients of each fit in a comparison


@check_arguments(units=UNITS)
@on_one_blas_thread(scipy=False)
def fit_map(
    position: npt.ArrayLike,
    force: npt.ArrayLike,
    *,
    pitch: float,
    force_sign: int = 1,
    harmonics: Sequence[int] | None = None,
    order: int | None = None,
    origin: float | None = None,
    highest_harmonic: int = 200,
    false_alarm: float = 0.01,
    units: Units | None = None,
) -> MapFit:
    """Fit the cogging model to a scan: the force that holds the axis there, over position.

    force = F_cogging(x) + offset + trend (x - centre) + direction (coulomb + g(x)), with (Lu et al. 2008, eq. 3 to 5)
    F_cogging(x) = sum_i (f_Si(x) sin(2 pi i x / pitch) + f_Ci(x) cos(2 pi i x / pitch)), f constant or B-splines on
    knots one pitch apart from `origin` over the travel. Least squares on points averaged over small cells, with a weak
    prior: neighbouring control points differ by 0 +- the standard deviation of the scan's force. So a control point
    that the scan does not reach continues its neighbour; it is listed in `unexcited`.

    Friction is separated from the offset if the scan goes there and back over one pitch or more. g(x), also periodic,
    is what else changes its sign with the direction: friction ripple, hysteresis. It is searched in the residual,
    reported in `direction_amplitudes` and not part of the map.

    Harmonics are found in the least-squares spectrum (HarmonicSpectrum.find). Periodic and orders 1 to 4 are compared
    by 8-fold cross-validation on blocks of an eighth of a pitch (of at most a 64th of the travel), both directions
    together; the one with the fewest coefficients within one standard error of the best is chosen. Noise correlated
    over more than a block resembles a modulation. Standard errors use the residual's spectrum at a harmonic's own
    frequency, and at least the residual's mean square.

    Args:
        position: m, (n,), in the order of measurement, irregular and repeated at will.
        force: V, (n,).
        pitch: m.
        force_sign: -1 for a sensor that reads the motor's push, -F_cogging - friction.
        harmonics: those of the model; found when None.
        order: of the B-splines, 1 to 16, or 0 = periodic; chosen when None.
        origin: m, the first knot; the lowest position when None.
        highest_harmonic: the last one searched, if the points resolve it (2.5 in a period).
        false_alarm: the probability at which a scan of noise alone yields any harmonic.
        units: labels of force and position for the result.

    Returns:
        The cogging model with its standard errors and how it was chosen.

    Raises:
        ValueError: names the field, the rule and the value: fewer than 10 points, NaN, lengths that differ, a travel
            below one pitch (less the last spacing of a closed turn), points too far apart, a harmonic that they do not
            resolve, more coefficients than points.

    Example:
        >>> x = np.linspace(0.0, 0.4, 2001)
        >>> force = 0.1 * np.sin(2 * np.pi * x / 0.05) + 1e-3 * np.random.default_rng(1).normal(size=x.size)
        >>> fit = cogging.fit_map(x, force, pitch=0.05)
        >>> [(entry.harmonic, round(entry.amplitude, 3)) for entry in fit.amplitudes]
        [(1, 0.1)]
    """
    units = units or Units()
    request = MapRequest(pitch, harmonics, order, origin, highest_harmonic, false_alarm)
    scan = read_scan(position, force, units, pitch=pitch, force_sign=force_sign, highest_harmonic=request.highest)
    request.check_against(scan)
    notes = list(scan.notes)
    spectrum = HarmonicSpectrum(scan.position, pitch, scan.highest)
    trend = scan.spans(TREND_TRAVEL * pitch)
    nuisance = nuisance_columns(scan, pitch, [], trend)
    if spectrum.few:
        short = f"the travel of {scan.travel / pitch:.3g} pitches is too short to tell slow noise from cogging"
        notes.append(f"{short}: standard errors may be too small")
    found = spectrum.find(scan.force, nuisance, false_alarm) if harmonics is None else []
    terms = _terms(request, found, notes)
    chosen, fit, scores, said = _choose(request, scan, terms, nuisance)
    lines = find_direction_lines(spectrum, scan, fit.residual, false_alarm)
    odd = sorted([line.harmonic for line in lines if line.harmonic is not None][:MOST_DIRECTION_TERMS])
    if odd:
        nuisance = nuisance_columns(scan, pitch, odd, trend)
        chosen, fit, scores, said = _choose(request, scan, terms, nuisance)
    fitted = FittedMap.of(spectrum, scan, terms, odd, chosen, fit)
    return fitted.result(scores, [*notes, *said, *fitted.notes(false_alarm)], false_alarm)


def _terms(request: MapRequest, lines: list[Line], notes: list[str]) -> list[int]:
    """The harmonics of the model: those given, or those found, at most as many as a model holds."""
    if request.harmonics is not None:
        return [int(harmonic) for harmonic in request.harmonics]
    found = [line.harmonic for line in lines if line.harmonic is not None]
    if not found:
        notes.append("no harmonic of the pitch stands out of the noise: the map is zero")
    if len(found) > MOST_TERMS:
        notes.append(f"{len(found)} harmonics found, the first {MOST_TERMS} of them kept")
    return sorted(found[:MOST_TERMS])


def _choose(
    request: MapRequest, scan: Scan, terms: list[int], nuisance: FloatArray
) -> tuple[int, SplineFit, list[CrossValidation], list[str]]:
    """The order, its fit, how the orders compare, and what to note of that."""
    notes: list[str] = []
    fits, scores = _compare(request, scan, terms, nuisance, notes)
    chosen = _simplest(scores)
    return chosen, fits.get(chosen) or fit_splines(None, scan.position, scan.force, nuisance), scores, notes


def _compare(
    request: MapRequest, scan: Scan, terms: list[int], nuisance: FloatArray, notes: list[str]
) -> tuple[dict[int, SplineFit], list[CrossValidation]]:
    """Fit and cross-validate the order asked for, or all of ORDERS that the scan has points for, simplest first."""
    fits: dict[int, SplineFit] = {}
    scores: list[CrossValidation] = []
    for order in (ORDERS if request.order is None else (request.order,)) if terms else ():
        points = request.control_points(scan, order)
        size = 2 * len(terms) * points
        if request.order is not None:
            request.check_size(scan, len(terms), order)
        elif order and size > min(MOST_COMPARED, scan.position.size // 2):
            notes.append(f"order {order} not tried: {size} coefficients for {scan.position.size} points")
            continue
        elif order and points == 1:
            continue  # one span and one control point: the periodic map once more
        basis = SplineHarmonics(
            pitch=request.pitch,
            harmonics=terms,
            order=max(order, 1),
            origin=request.first_knot(scan),
            control_points=points,
        )
        fits[order] = fit_splines(basis, scan.position, scan.force, nuisance)
        # Long enough that noise of neighbours does not leak, short enough that a spline is held from both sides.
        block = min(request.pitch / 8.0, scan.travel / (8.0 * FOLDS))
        rms, error = cross_validate(fits[order], scan.position, scan.force, nuisance, block)
        scores.append(CrossValidation(order, size, rms, error))
    return fits, scores


def _simplest(scores: list[CrossValidation]) -> int:
    """The order of fewest coefficients whose error is within one standard error of the smallest; 0 of none."""
    if not scores:
        return 0
    best = min(scores, key=lambda score: score.rms)
    good = [score for score in scores if score.rms <= best.rms + best.standard_error]
    return min(good, key=lambda score: score.coefficients).order
