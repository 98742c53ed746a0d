"""Fitting the cogging model F_cogging(x) to a measured force-against-position scan (Lu et al. 2008, eq. 3 to 7)."""

from __future__ import annotations

from collections.abc import Sequence

import numpy.typing as npt

from cogging._core import SplineHarmonics
from cogging.arrays import FloatArray
from cogging.calls import takes
from cogging.mapping.direction import MOST_TERMS as MOST_DIRECTION_TERMS
from cogging.mapping.direction import find_direction_lines
from cogging.mapping.fitted import TREND_TRAVEL, FittedMap, nuisance_columns
from cogging.mapping.request import MapRequest
from cogging.mapping.result import CrossValidation, MapFit
from cogging.mapping.scan import Scan, read_scan
from cogging.mapping.spectrum import HarmonicSpectrum, Line
from cogging.mapping.spline_fit import FOLDS, SplineFit, cross_validate, fit_splines
from cogging.model.units import UNITS, Units
from cogging.resources import on_one_blas_thread

ORDERS = (0, 1, 2, 3, 4)  # compared where none is given; 0 = periodic
MOST_TERMS = 32  # of SplineHarmonics
MOST_COMPARED = 2000  # coefficients of each fit in a comparison


@takes(units=UNITS)
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

    Friction is told from the offset where the scan goes there and back over one pitch or more. g(x), periodic too, is
    what else changes its sign with the direction: friction that ripples, hysteresis. It is looked for in what the map
    leaves, told in `direction_amplitudes` and is no part of the map.

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
        units: labels of force and position that the result is told in.

    Returns:
        The cogging model with its standard errors and how it was chosen; print it to read them.

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
