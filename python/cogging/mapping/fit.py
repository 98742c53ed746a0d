"""Fitting the cogging model F_cogging(x) to a measured force-against-position scan (Lu et al. 2008, eq. 3 to 7)."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from cogging._core import SplineHarmonics
from cogging.arrays import FloatArray
from cogging.calls import takes
from cogging.mapping.result import CrossValidation, HarmonicAmplitude, MapFit
from cogging.mapping.scan import Scan, read_scan
from cogging.mapping.spectrum import FLOOR, HarmonicSpectrum, Line
from cogging.mapping.spline_fit import FOLDS, SplineFit, cogging_of, cross_validate, fit_splines, predict, rows_of

ORDERS = (0, 1, 2, 3, 4)  # compared where none is given; 0 = periodic
MOST_TERMS = 32  # of SplineHarmonics
MOST_COEFFICIENTS = 4000  # of one fit: its normal matrix is dense
MOST_COMPARED = 2000  # of each fit in a comparison
SLIVER = 0.05  # of a pitch: a shorter rest of the travel gets no span of its own
SIGNIFICANT = 3.0  # standard errors from which a trend is kept
TREND_TRAVEL = 2.0  # pitches: over a shorter travel a trend looks like the first harmonic and is not tried


@takes()
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
) -> MapFit:
    """Fit the cogging model to a scan: the force that holds the axis there, over position.

    force = F_cogging(x) + offset + trend (x - centre) + coulomb direction, with (Lu et al. 2008, eq. 3 to 5)
    F_cogging(x) = sum_i (f_Si(x) sin(2 pi i x / pitch) + f_Ci(x) cos(2 pi i x / pitch)), f constant or B-splines on
    knots one pitch apart from `origin` over the travel. Least squares on points averaged over small cells, with a weak
    prior: neighbouring control points differ by 0 +- the standard deviation of the scan's force. So a control point
    that the scan does not reach continues its neighbour; it is listed in `unexcited`.

    Harmonics are found in the least-squares spectrum (HarmonicSpectrum.find). Periodic and orders 1 to 4 are compared
    by 8-fold cross-validation on blocks of an eighth of a pitch (of at most a 64th of the travel), both directions
    together; the one of fewest coefficients within one standard error of the best is taken. Noise correlated over more
    than a block is not told from a modulation. Standard errors take the noise at a harmonic's own frequency from the
    residual's spectrum, and no less than the residual's mean square.

    Args:
        position: m, (n,), in the order of measurement, irregular and repeated at will.
        force: V, (n,).
        pitch: m.
        force_sign: -1 for a sensor that reads the motor's push, -F_cogging - friction.
        harmonics: those of the model; found when None.
        order: of the B-splines, 1 to 16, or 0 = periodic; chosen when None.
        origin: m, the first knot; the lowest position when None.
        highest_harmonic: the last one that is looked for, if the points tell it from others (2.5 in a period).
        false_alarm: the probability at which a scan of noise alone yields any harmonic.

    Returns:
        The cogging model with its standard errors and how it was chosen; print it to read them.

    Raises:
        ValueError: names the field, the rule and the value: fewer than 10 points, NaN, lengths that differ, a travel
            below one pitch, points too far apart, a harmonic that they do not resolve, more coefficients than points.

    Example:
        >>> x = np.linspace(0.0, 0.4, 2001)
        >>> force = 0.1 * np.sin(2 * np.pi * x / 0.05) + 1e-3 * np.random.default_rng(1).normal(size=x.size)
        >>> fit = cogging.fit_map(x, force, pitch=0.05)
        >>> [(entry.harmonic, round(entry.amplitude, 3)) for entry in fit.amplitudes]
        [(1, 0.1)]
    """
    request = _Request(pitch, harmonics, order, origin, highest_harmonic, false_alarm)
    scan = read_scan(position, force, pitch=pitch, force_sign=force_sign, highest_harmonic=request.highest)
    request.check_against(scan)
    notes = list(scan.notes)
    spectrum = HarmonicSpectrum(scan.position, pitch, scan.highest)
    nuisance = _nuisance(scan, trend=scan.travel >= TREND_TRAVEL * pitch)
    if spectrum.few:
        short = f"the travel of {scan.travel / pitch:.3g} pitches is too short to tell slow noise from cogging"
        notes.append(f"{short}: standard errors may be too small")
    found = spectrum.find(scan.force, nuisance, false_alarm) if harmonics is None else []
    terms = _terms(request, found, notes)

    fits, scores = _compare(request, scan, terms, nuisance, notes)
    chosen = _simplest(scores)
    fit = fits.get(chosen) or fit_splines(None, scan.position, scan.force, nuisance)
    noise = _Noise.of(spectrum, scan, fit, terms, chosen)
    trend, trend_error = fit.coefficients[-1] / scan.travel, noise.standard_errors[-1] / scan.travel
    if scan.travel >= TREND_TRAVEL * pitch and abs(trend) > SIGNIFICANT * trend_error:
        notes.append(
            f"the force also has a trend of {trend:.3g} +- {trend_error:.1g} V/m, which is not part of the map"
        )
    else:
        nuisance, trend, trend_error = _nuisance(scan, trend=False), 0.0, 0.0
        fit = fit_splines(fit.basis, scan.position, scan.force, nuisance)
        noise = _Noise.of(spectrum, scan, fit, terms, chosen)
    taken = spectrum.taken_by(terms, modulated=chosen > 0)
    if np.std(fit.residual) > FLOOR * np.std(scan.force):
        notes += _unmodelled(spectrum.find(fit.residual, nuisance, false_alarm, taken), terms, pitch)

    p = 0 if fit.basis is None else fit.basis.coefficients
    errors = noise.standard_errors
    coulomb, coulomb_error = (float(fit.coefficients[p + 1]), float(errors[p + 1])) if scan.both_ways else (None, None)
    if coulomb is not None and coulomb_error is not None and coulomb < -SIGNIFICANT * coulomb_error:
        notes.append(f"the force is lower in the direction of motion ({coulomb:.3g} V): is force_sign right?")
    unexcited = _unexcited(fit)
    if unexcited:
        which = ", ".join(map(str, unexcited))
        notes.append(f"the scan does not determine control points {which}: they continue their neighbours")
    zero = SplineHarmonics(pitch=pitch, harmonics=[1])  # no harmonic: the one map that says nothing
    sine_error, cosine_error = rows_of(fit.basis or zero, errors[:p] if p else np.zeros(2))
    return MapFit(
        cogging=cogging_of(fit.basis or zero, fit.coefficients[:p] if p else np.zeros(2)),
        order=chosen,
        sine_standard_error=sine_error,
        cosine_standard_error=cosine_error,
        amplitudes=_amplitudes(spectrum, scan, fit, noise),
        offset=float(fit.coefficients[p]),
        offset_standard_error=float(errors[p]),
        coulomb=coulomb,
        coulomb_standard_error=coulomb_error,
        trend=float(trend),
        trend_standard_error=float(trend_error),
        residual_rms=float(np.sqrt(np.mean(fit.residual**2))),
        noise=float(np.sqrt(np.median(noise.level[spectrum.present]))),
        cross_validation=tuple(scores),
        unexcited=unexcited,
        notes=tuple(notes),
        position=scan.position,
        force=scan.force,
        direction=scan.direction,
        fitted=scan.force - fit.residual,
        line=pitch * spectrum.frequency[spectrum.present],
        line_amplitude=spectrum.amplitude(spectrum.power(scan.force - nuisance @ fit.coefficients[p:]))[
            spectrum.present
        ],
        line_threshold=spectrum.amplitude(noise.level * spectrum.threshold(false_alarm, noise.degrees))[
            spectrum.present
        ],
    )


@dataclass(frozen=True)
class _Request:
    """What fit_map was asked for; a wrong value is refused."""

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
        return max(self.highest_harmonic, *(self.harmonics or (1,)))

    def first_knot(self, scan: Scan) -> float:
        return float(scan.position.min()) if self.origin is None else self.origin

    def control_points(self, scan: Scan, order: int) -> int:
        spans = np.ceil((scan.position.max() - self.first_knot(scan)) / self.pitch - SLIVER)
        return max(1, int(spans)) + order - 1 if order else 1

    def check_against(self, scan: Scan) -> None:
        highest = max(self.harmonics or (1,))
        rule = f"must be at most {scan.resolvable} with points this far apart"
        _require(highest <= scan.resolvable, "harmonics", rule, highest)
        end = float(scan.position.max())
        _require(
            self.first_knot(scan) < end, "origin", f"must lie below the scan's highest position {end:g} m", self.origin
        )
        if self.harmonics is not None and self.order is not None:
            self.check_size(scan, len(self.harmonics), self.order)

    def check_size(self, scan: Scan, terms: int, order: int) -> None:
        size = 2 * terms * self.control_points(scan, order)
        limit = min(MOST_COEFFICIENTS, scan.position.size - 4)
        rule = f"must need at most {limit} coefficients ({scan.position.size} points)"
        _require(size <= limit, "order", rule, f"{size} for order {order} from origin {self.first_knot(scan):g} m")


def _terms(request: _Request, lines: list[Line], notes: list[str]) -> list[int]:
    """The harmonics of the model: those given, or those found, at most as many as a model holds."""
    if request.harmonics is not None:
        return [int(harmonic) for harmonic in request.harmonics]
    found = [line.harmonic for line in lines if line.harmonic is not None]
    if not found:
        notes.append("no harmonic of the pitch stands out of the noise: the map is zero")
    if len(found) > MOST_TERMS:
        notes.append(f"{len(found)} harmonics found, the first {MOST_TERMS} of them kept")
    return sorted(found[:MOST_TERMS])


def _compare(
    request: _Request, scan: Scan, terms: list[int], nuisance: FloatArray, notes: list[str]
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


@dataclass(frozen=True)
class _Noise:
    """The noise of a fit: level (V^2) of every line, its degrees of freedom, covariance and standard errors (V)."""

    level: FloatArray
    degrees: float
    covariance: FloatArray
    standard_errors: FloatArray

    @classmethod
    def of(cls, spectrum: HarmonicSpectrum, scan: Scan, fit: SplineFit, terms: list[int], order: int) -> _Noise:
        taken = spectrum.taken_by(terms, modulated=order > 0)
        level, degrees = spectrum.level(spectrum.power(fit.residual), taken, fit.variance)
        # What differs between the directions is noise to the Coulomb level, though a map of position hardly sees it.
        turned, _ = spectrum.level(spectrum.power(fit.residual * scan.direction), ~spectrum.present, fit.variance)
        slowest = level[spectrum.present][0]
        nuisance = [slowest, turned[spectrum.present][0] if scan.both_ways else slowest, slowest]
        points = 0 if fit.basis is None else fit.basis.spline.control_points
        columns = np.tile(np.repeat(level[terms, level.shape[1] // 2], 2), points)
        columns = np.concatenate([columns, nuisance])[: len(fit.coefficients)]
        least = fit.variance
        if spectrum.few:  # no level of its own for slow noise: what the correlation of neighbours says of it
            squares = max(float(fit.residual @ fit.residual), np.finfo(float).tiny)
            correlation = float(fit.residual[1:] @ fit.residual[:-1]) / squares
            least *= max(1.0, (1.0 + correlation) / (1.0 - correlation))
        covariance = fit.covariance(np.maximum(columns, least))
        return cls(level, degrees, covariance, np.sqrt(np.diag(covariance)))


def _nuisance(scan: Scan, trend: bool) -> FloatArray:
    """Columns of the offset, of friction where it can be told from it, of a trend over the travel; (n, 1 to 3)."""
    x = (scan.position - 0.5 * (scan.position.min() + scan.position.max())) / scan.travel
    columns = [np.ones_like(x), *([scan.direction] if scan.both_ways else []), *([x] if trend else [])]
    return np.stack(columns, axis=1)


def _unmodelled(lines: list[Line], terms: list[int], pitch: float) -> list[str]:
    """Say what stands out and is not in the model: changes of its harmonics, the three strongest of other lines."""
    notes = []
    for line in sorted((line for line in lines if line.harmonic not in terms), key=lambda line: -line.amplitude)[:3]:
        which = (
            f"harmonic {line.harmonic}" if line.harmonic is not None else f"{line.frequency * pitch:.3g} times a pitch"
        )
        notes.append(f"not in the map: {line.amplitude:.2g} V with period {1.0 / line.frequency:.4g} m ({which})")
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


def _amplitudes(spectrum: HarmonicSpectrum, scan: Scan, fit: SplineFit, noise: _Noise) -> tuple[HarmonicAmplitude, ...]:
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


def _is_number(value: object) -> bool:
    return isinstance(value, int | float | np.number) and not isinstance(value, bool) and bool(np.isfinite(value))


def _is_whole(value: object, lowest: int, highest: int = 10_000) -> bool:
    return isinstance(value, int | np.integer) and not isinstance(value, bool) and bool(lowest <= value <= highest)


def _require(holds: bool, name: str, rule: str, value: object) -> None:
    if not holds:
        raise ValueError(f"{name}: {rule}, got {value}")
