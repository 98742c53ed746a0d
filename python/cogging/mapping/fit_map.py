"""Fit the cogging model F_cogging(x) to a measured force-against-position scan (Lu et al. 2008, eq. 3 to 7)."""

from __future__ import annotations

import os
from collections.abc import Sequence
from dataclasses import dataclass, field, fields, replace
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt

from cogging._core import CoggingModel, SplineHarmonics
from cogging.arrays import FloatArray
from cogging.calls import check_arguments
from cogging.files import InputError
from cogging.mapping import cogging_spectrum
from cogging.mapping.cogging_spectrum import FLOOR, HarmonicSpectrum, Line, SplineFit, fit_splines, rows_of
from cogging.mapping.scan import Scan, is_number, read_scan, require
from cogging.model.model import cogging_to_dict
from cogging.model.units import UNITS, Units
from cogging.outputs import same_file, to_toml, write_files
from cogging.plot.canvas import grid_to_write, plot_method, png
from cogging.plot.results import WHOLE_MAP, whole_map_fit
from cogging.resources import on_one_blas_thread
from cogging.tables import frame_of, html_table
from cogging.values import ByValue


@dataclass(frozen=True)
class HarmonicAmplitude:
    """One harmonic of the map: amplitude sin(2 pi harmonic x / pitch + phase)."""

    harmonic: int  # of the pitch
    amplitude: float  # V; of a modulated harmonic the rms over the points of its local sqrt(f_S^2 + f_C^2)
    standard_error: float  # V, of the amplitude
    phase: float  # rad; of a modulated harmonic that of the means of f_S and f_C
    false_alarm: float  # probability that noise alone lifts any line of the spectrum as far as this one


@dataclass(frozen=True)
class CrossValidation:
    """How well a model predicts the parts of the scan that its fit did not see."""

    order: int  # of the B-splines; 0 = periodic
    coefficients: int  # number of sines and cosines
    rms: float  # V, of the prediction errors
    standard_error: float  # V, of that rms, from its scatter between the blocks left out


@dataclass(frozen=True, eq=False, repr=False)
class MapFit(ByValue):
    """A cogging model fitted to a scan.

    force = F_cogging(x) + offset + trend (x - centre) + direction (coulomb + g(x)).

    Attributes:
        cogging: F_cogging(x), V; zero where no harmonic was found.
        order: of the B-splines; 0 = periodic.
        sine_standard_error: V, (terms, control points), as `cogging.sine`; likewise cosine_standard_error. That of a
            control point in `unexcited` is the prior's.
        amplitudes: one entry a harmonic.
        offset: V, at the centre of the travel; offset_standard_error likewise.
        coulomb, coulomb_standard_error: V, half of the difference of the two directions; None where the scan goes one
            way only.
        direction_amplitudes: of g(x), which changes its sign with the direction of motion, one entry a harmonic; empty
            where there is none, or the scan goes one way only.
        direction_rms: V, of g(x) over the scan's points.
        direction_lag: m, by which a map that follows the motion would give the same: F_cogging(x - lag direction); None
            where no single lag does.
        trend, trend_standard_error: V/m; both 0 where the trend is within 3 standard errors of none and therefore left
            out.
        residual_rms: V, of the averaged points.
        noise: V rms of one averaged point, from the median of the residual's spectrum; where residual_rms is larger,
            the scan has structure that the model lacks.
        cross_validation: the models that were compared, simplest first.
        unexcited: control points (from 0) that the scan determines by less than half; the rest is the prior, which
            continues the neighbours.
        notes: remarks on the fit.
        position, force, direction: the averaged points of the scan: m, V, +1 or -1, (n,).
        fitted: V, (n,), the model with offset, trend and friction at these points.
        line, line_amplitude, line_threshold: the spectrum: f pitch (whole at harmonics), V, and V above which a line is
            found, each (lines,).
        units: labels of force and position.
    """

    cogging: CoggingModel
    order: int
    sine_standard_error: FloatArray
    cosine_standard_error: FloatArray
    amplitudes: tuple[HarmonicAmplitude, ...]
    offset: float
    offset_standard_error: float
    coulomb: float | None
    coulomb_standard_error: float | None
    direction_amplitudes: tuple[HarmonicAmplitude, ...]
    direction_rms: float
    direction_lag: float | None
    trend: float
    trend_standard_error: float
    residual_rms: float
    noise: float
    cross_validation: tuple[CrossValidation, ...]
    unexcited: tuple[int, ...]
    notes: tuple[str, ...]
    position: FloatArray
    force: FloatArray
    direction: FloatArray
    fitted: FloatArray
    line: FloatArray
    line_amplitude: FloatArray
    line_threshold: FloatArray
    units: Units = field(default_factory=Units)

    def _brief(self) -> str:
        which = ", ".join(str(entry.harmonic) for entry in self.amplitudes) or "none"
        kind = f"splines of order {self.order}" if self.order else "periodic"
        pitch = f"{self.cogging.basis.pitch:g} {self.units.position}"
        return f"harmonics {which} of {pitch}, {kind}; residual {self.residual_rms:.4g} {self.units.command} rms"

    def text(self) -> str:
        """The fit in a few lines for the screen."""
        v, m = self.units.command, self.units.position
        spline, pitch = self.cogging.basis.spline, self.cogging.basis.pitch
        kind = f"order {self.order}, {spline.control_points} control points" if self.order else "periodic"
        lines = [
            f"cogging map: {len(self.position)} points over {np.ptp(self.position):.4g} {m}, pitch {pitch:.4g} {m}, "
            f"{kind}",
            f"harmonic  {f'amplitude ({v})':>13}{f'+- ({v})':>9}  phase (rad)  false alarm",
        ]
        lines += _table(self.amplitudes)
        values = [("coulomb", self.coulomb, self.coulomb_standard_error, v)] if self.coulomb is not None else []
        values.append(("offset", self.offset, self.offset_standard_error, v))
        if self.trend_standard_error > 0.0:
            values.append(("trend", self.trend, self.trend_standard_error, self.units.of("V/m")))
        lines += [f"{name:8s}  {value:13.5g}  {error:7.1g}  {unit}" for name, value, error, unit in values]
        if self.direction_amplitudes:
            lines += ["changes sign with the direction of motion:", *_table(self.direction_amplitudes)]
        lines.append(f"residual  {self.residual_rms:13.5g}  {v} rms; noise {self.noise:.3g} {v} rms")
        for c in self.cross_validation:
            name, mark = (f"order {c.order}" if c.order else "periodic"), "  <- chosen" * (c.order == self.order)
            compared = f"{v} rms, {name}, {c.coefficients} coefficients{mark}"
            lines.append(f"predicts  {c.rms:13.5g}  {c.standard_error:7.1g}  {compared}")
        return "\n".join(lines + [f"note: {note}" for note in self.notes])

    def to_dict(self) -> dict[str, Any]:
        """What `cogging map --json` writes: the fit without the points of the scan and of the spectrum."""
        names = [entry.name for entry in fields(self)]
        document = {name: getattr(self, name) for name in names[: names.index("notes")]}
        for name in ("amplitudes", "direction_amplitudes", "cross_validation"):
            document[name] = [vars(entry) for entry in document[name]]
        points = {"points": len(self.position), "notes": self.notes}
        return document | {"cogging": cogging_to_dict(self.cogging)} | points

    def to_frame(self) -> Any:
        """The harmonics as a pandas DataFrame (extra `frames`), a row each, with units in `attrs["units"]`."""
        columns = {one.name: [getattr(a, one.name) for a in self.amplitudes] for one in fields(HarmonicAmplitude)}
        return frame_of(columns, dict.fromkeys(("amplitude", "standard_error"), self.units.command) | {"phase": "rad"})

    def _repr_html_(self) -> str:
        v = self.units.command
        headers = ["harmonic", f"amplitude ({v})", f"standard error ({v})", "phase (rad)", "false alarm"]
        rows = [list(vars(entry).values()) for entry in self.amplitudes]
        return html_table(f"MapFit: {self._brief()}", headers, rows, self.notes)

    plot = plot_method(whole_map_fit, "Draw the map with its 95 % band, the residual and the spectrum.", "three axes")

    def write(self, path: str | os.PathLike[str]) -> None:
        """Write the `[cogging]` section of a model file, and the figure beside it as .png.

        Labels of units other than V and m are written too, as `[units]`.

        Raises:
            InputError: a file cannot be written, or both are one: a model called `.png`.
        """
        labels = {} if self.units == Units() else {"units": self.units.to_dict()}
        text = to_toml({"cogging": cogging_to_dict(self.cogging), **labels})
        figure = os.fspath(Path(path).with_suffix(".png"))
        if same_file(path, figure):
            raise InputError(f"{path}: must not be where its figure is written, got {figure}")
        write_files({os.fspath(path): [text.encode()], figure: [png(self.plot(ax=grid_to_write(3, 1, WHOLE_MAP)))]})


def _table(entries: tuple[HarmonicAmplitude, ...]) -> list[str]:
    return ["{:8d}  {:13.5g}  {:7.1g}  {:11.3f}  {:11.1g}".format(*vars(entry).values()) for entry in entries]


@dataclass(frozen=True)
class Noise:
    """The noise of a fit."""

    level: FloatArray  # V^2, of every line
    turned: FloatArray  # V^2, likewise of direction times residual: what differs between the directions
    degrees: float  # degrees of freedom of the levels
    covariance: FloatArray  # V^2, of the coefficients, (p + q, p + q)
    standard_errors: FloatArray  # V, of the coefficients, (p + q,)

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
        points = 0 if fit.basis is None else fit.basis.spline.control_points
        columns = np.tile(np.repeat(level[terms, middle], 2), points)
        columns = np.concatenate([columns, [slowest, *of_directions, slowest]])[: len(fit.coefficients)]
        least = fit.variance
        if spectrum.few:  # too few lines for a level of slow noise: use the correlation of neighbours
            squares = max(float(fit.residual @ fit.residual), np.finfo(float).tiny)
            correlation = float(fit.residual[1:] @ fit.residual[:-1]) / squares
            least *= max(1.0, (1.0 + correlation) / (1.0 - correlation))
        covariance = fit.covariance(np.maximum(columns, least))
        return cls(level, turned, degrees, covariance, np.sqrt(np.diag(covariance)))


def amplitudes(spectrum: HarmonicSpectrum, scan: Scan, fit: SplineFit, noise: Noise) -> tuple[HarmonicAmplitude, ...]:
    """The table of the harmonics."""
    if fit.basis is None:
        return ()
    basis, entries = fit.basis, []
    weights = basis.spline.design_matrix(scan.position)
    gram, mean = weights.T @ weights / len(weights), weights.mean(axis=0)
    for i, harmonic in enumerate(basis.harmonics):
        chosen = [slice(2 * i + part, basis.coefficients, 2 * basis.terms) for part in (0, 1)]
        s, c = (fit.coefficients[part] for part in chosen)
        covariance = np.block([[noise.covariance[a, b] for b in chosen] for a in chosen])
        amplitude = float(np.sqrt(s @ gram @ s + c @ gram @ c))
        gradient = np.concatenate([gram @ s, gram @ c]) / max(amplitude, np.finfo(float).tiny)
        own = np.zeros(basis.coefficients)
        own[chosen[0]], own[chosen[1]] = s, c
        rows = slice(harmonic, harmonic + 1)
        power = spectrum.power(fit.residual + cogging_spectrum.cogging_of(basis, own).force(scan.position), rows)
        ratio = np.max(np.where(spectrum.near[rows], power / noise.level[rows], 0.0))
        error, phase = float(np.sqrt(gradient @ covariance @ gradient)), float(np.arctan2(mean @ c, mean @ s))
        alarm = float(spectrum.false_alarm(ratio, noise.degrees))
        entries.append(HarmonicAmplitude(harmonic, amplitude, error, phase, alarm))
    return tuple(entries)


MOST_DIRECTION_TERMS = 32  # harmonics that are fitted in direction g(x)
LAG_SHARE = 0.9  # of the power of g(x) that one lag must explain to be called one
LAGS = 2001  # that are tried over one period of the highest harmonic


def direction_content(
    spectrum: HarmonicSpectrum, scan: Scan, fit: SplineFit, noise: Noise, harmonics: list[int]
) -> tuple[tuple[HarmonicAmplitude, ...], float, float | None]:
    """Amplitudes, rms (V) and lag (m) of g(x), which changes its sign with the direction of motion (see MapFit)."""
    if not harmonics:
        return (), 0.0, None
    first = (0 if fit.basis is None else fit.basis.coefficients) + 2
    coefficients = fit.coefficients[first : first + 2 * len(harmonics)]
    content = direction_columns(scan, spectrum.pitch, harmonics) @ coefficients
    turned = spectrum.power((fit.residual + content) * scan.direction)
    entries, middle = [], turned.shape[1] // 2
    parts = dict(zip(harmonics, coefficients.reshape(-1, 2), strict=True))
    for place, (harmonic, (sine, cosine)) in enumerate(parts.items()):
        own = slice(first + 2 * place, first + 2 * place + 2)
        amplitude = float(np.hypot(sine, cosine))
        gradient = parts[harmonic] / max(amplitude, np.finfo(float).tiny)
        error, phase = gradient @ noise.covariance[own, own] @ gradient, np.arctan2(cosine, sine)
        alarm = spectrum.false_alarm(float(turned[harmonic, middle] / noise.turned[harmonic, middle]), noise.degrees)
        entries.append(HarmonicAmplitude(harmonic, amplitude, float(np.sqrt(error)), float(phase), alarm))
    return tuple(entries), float(np.sqrt(np.mean(content**2))), _lag(fit, scan, spectrum.pitch, parts)


def direction_columns(scan: Scan, pitch: float, harmonics: list[int]) -> FloatArray:
    """Columns direction sin(2 pi h x / pitch), direction cos(...), harmonic by harmonic, (n, 2 harmonics)."""
    angles = np.outer(scan.position, 2.0 * np.pi * np.array(harmonics) / pitch)
    waves = np.stack([np.sin(angles), np.cos(angles)], axis=2).reshape(len(angles), -1)
    return np.asarray(scan.direction[:, None] * waves)


def find_direction_lines(spectrum: HarmonicSpectrum, scan: Scan, left: FloatArray, false_alarm: float) -> list[Line]:
    """Find the significant lines of direction times residual; none in a scan that goes one way only."""
    if not scan.both_ways or np.std(left) <= FLOOR * np.std(scan.force):
        return []
    steady = np.stack([np.ones_like(left), scan.direction], axis=1)
    return spectrum.find(left * scan.direction, steady, false_alarm)


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
    moved = np.tan(np.outer(lags, wave_numbers))[:, :, None] * np.stack([even[:, 1], -even[:, 0]], axis=1)
    left = ((seen - moved) ** 2).sum(axis=(1, 2))
    best = int(np.argmin(left))
    return float(lags[best]) if left[best] <= (1.0 - LAG_SHARE) * float((seen**2).sum()) else None


SIGNIFICANT = 3.0  # standard errors from which a trend is kept
TREND_TRAVEL = 2.0  # pitches: over a shorter travel a trend looks like the first harmonic and is not tried


def nuisance_columns(scan: Scan, pitch: float, odd: list[int], trend: bool) -> FloatArray:
    """Return the columns of offset, friction where it is separable, and a trend over the travel, (n, 1 or more)."""
    x = (scan.position - 0.5 * (scan.position.min() + scan.position.max())) / scan.travel
    ways = [scan.direction, *direction_columns(scan, pitch, odd).T] if scan.both_ways else []
    return np.stack([np.ones_like(x), *ways, *([x] if trend else [])], axis=1)


def _remarks(found: MapFit, spectrum: HarmonicSpectrum, scan: Scan, fit: SplineFit, false_alarm: float) -> list[str]:
    """Remarks on a fit: what the map does not contain, and what speaks against it."""
    notes, of, v = [], scan.units.of, scan.units.command
    terms = [entry.harmonic for entry in found.amplitudes]
    if found.trend:
        size = f"{found.trend:.3g} +- {found.trend_standard_error:.1g} {of('V/m')}"
        notes.append(f"the force also has a trend of {size}, which is not part of the map")
    lines: list[Line] = []
    if np.std(fit.residual) > FLOOR * np.std(scan.force):
        taken = spectrum.taken_by(terms, modulated=found.order > 0)
        lines = spectrum.find(fit.residual, fit.nuisance, false_alarm, taken)
    for line in sorted((line for line in lines if line.harmonic not in terms), key=lambda line: -line.amplitude)[:3]:
        times = f"{line.frequency * spectrum.pitch:.3g} times a pitch"
        which = times if line.harmonic is None else f"harmonic {line.harmonic}"
        period = f"period {1.0 / line.frequency:.4g} {of('m')}"
        notes.append(f"not in the map: {line.amplitude:.2g} {v} with {period} ({which})")
    if changing := [str(line.harmonic) for line in lines if line.harmonic in terms]:
        notes.append(f"harmonics {', '.join(changing)} change along the travel in a way that the map does not follow")
    if found.direction_amplitudes:
        notes.append(_direction_remark(found))
    for line in find_direction_lines(spectrum, scan, fit.residual, false_alarm)[:1]:
        if line.harmonic is None:
            period = f"period {1.0 / line.frequency:.3g} {of('m')}, which is none of the pitch"
            notes.append(f"{line.amplitude:.2g} {v} change sign with the direction of motion with {period}")
    coulomb, error = found.coulomb, found.coulomb_standard_error
    if coulomb is not None and error is not None and coulomb < -SIGNIFICANT * error:
        notes.append(f"the force is lower in the direction of motion ({coulomb:.3g} {v}): is force_sign right?")
    if found.unexcited:
        which = ", ".join(map(str, found.unexcited))
        notes.append(f"the scan does not determine control points {which}: they continue their neighbours")
    return notes


def _direction_remark(found: MapFit) -> str:
    v, largest = found.units.command, sorted(found.direction_amplitudes, key=lambda entry: -entry.amplitude)[:8]
    which = ", ".join(str(entry.harmonic) for entry in largest)
    against = f", Coulomb friction is {found.coulomb:.3g} {v}" if found.coulomb is not None else ""
    cause = "friction that ripples along the travel, or hysteresis"
    if found.direction_lag is not None:
        lag = f"{abs(found.direction_lag):.3g} {found.units.position}"
        way = "late" if found.direction_lag > 0.0 else "early"
        cause = f"as of a map that comes {lag} {way} each way: hysteresis, play or a late reading"
    return (
        f"{found.direction_rms:.3g} {v} rms of the force change sign with the direction of motion (harmonics {which}"
        f"{against}): {cause}; not in the map, which is the mean of both ways"
    )


MOST_COEFFICIENTS = 4000  # of one fit: its normal matrix is dense
SLIVER = 0.05  # of a pitch: a shorter rest of the travel gets no span


def _is_whole(value: object, lowest: int, highest: int = 10_000) -> bool:
    return isinstance(value, int | np.integer) and not isinstance(value, bool) and bool(lowest <= value <= highest)


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
    is what else changes its sign with the direction: friction ripple, hysteresis; it is not part of the map.

    Harmonics are found in the least-squares spectrum (HarmonicSpectrum.find). Periodic and orders 1 to 4 are compared
    by 8-fold cross-validation on blocks of an eighth of a pitch, both directions together; the one with the fewest
    coefficients within one standard error of the best is chosen. Standard errors use the residual's spectrum at a
    harmonic's own frequency, and at least the residual's mean square.

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
    require(is_number(pitch) and pitch > 0.0, "pitch", "must be finite and above 0", pitch)
    require(is_number(false_alarm) and 0.0 < false_alarm < 1.0, "false_alarm", "must lie between 0 and 1", false_alarm)
    require(_is_whole(highest_harmonic, 1), "highest_harmonic", "must be a whole number from 1", highest_harmonic)
    given = []
    if harmonics is not None:
        whole = isinstance(harmonics, Sequence | np.ndarray) and all(_is_whole(one, 1) for one in harmonics)
        require(whole, "harmonics", "must be a list of whole numbers from 1", harmonics)
        given = [int(harmonic) for harmonic in harmonics]
        SplineHarmonics(pitch=pitch, harmonics=given)  # checks its own rules
    rule = "must be a whole number from 1 to 16, or 0 for a periodic map"
    require(order is None or _is_whole(order, 0, 16), "order", rule, order)
    require(origin is None or is_number(origin), "origin", "must be a finite number", origin)
    highest = max(highest_harmonic, *given, 1)
    scan = read_scan(position, force, units, pitch=pitch, force_sign=force_sign, highest_harmonic=highest)
    rule = f"must be at most {scan.resolvable} with points this far apart"
    require(max(given, default=1) <= scan.resolvable, "harmonics", rule, max(given, default=1))
    first_knot, end = float(scan.position.min()) if origin is None else origin, float(scan.position.max())
    require(first_knot < end, "origin", f"must lie below the scan's highest position {end:g} {units.position}", origin)
    notes = list(scan.notes)
    spectrum = HarmonicSpectrum(scan.position, pitch, scan.highest)
    trend = scan.spans(TREND_TRAVEL * pitch)
    nuisance = nuisance_columns(scan, pitch, [], trend)
    if spectrum.few:
        short = f"the travel of {scan.travel / pitch:.3g} pitches is too short to tell slow noise from cogging"
        notes.append(f"{short}: standard errors may be too small")
    terms = given
    if harmonics is None:
        found = [line.harmonic for line in spectrum.find(scan.force, nuisance, false_alarm)]
        of_pitch = [harmonic for harmonic in found if harmonic is not None]
        terms = sorted(of_pitch[:MOST_TERMS])
        if not terms:
            notes.append("no harmonic of the pitch stands out of the noise: the map is zero")
        if len(of_pitch) > MOST_TERMS:
            notes.append(f"{len(of_pitch)} harmonics found, the first {MOST_TERMS} of them kept")
    chosen, fit, scores, said = _choose(scan, pitch, terms, order, first_knot, nuisance)
    lines = find_direction_lines(spectrum, scan, fit.residual, false_alarm)
    odd = sorted([line.harmonic for line in lines if line.harmonic is not None][:MOST_DIRECTION_TERMS])
    if odd:
        nuisance = nuisance_columns(scan, pitch, odd, trend)
        chosen, fit, scores, said = _choose(scan, pitch, terms, order, first_knot, nuisance)
    noise = Noise.of(spectrum, scan, fit, terms, chosen, odd)
    slope, slope_error = (float(values[-1] / scan.travel) for values in (fit.coefficients, noise.standard_errors))
    if not (trend and abs(slope) > SIGNIFICANT * slope_error):
        slope = slope_error = 0.0
        fit = fit_splines(fit.basis, scan.position, scan.force, nuisance_columns(scan, pitch, odd, trend=False))
        noise = Noise.of(spectrum, scan, fit, terms, chosen, odd)
    basis, p = fit.basis or SplineHarmonics(pitch=pitch, harmonics=[1]), len(fit.coefficients) - fit.nuisance.shape[1]
    # Without a harmonic, p = 0, the map is zero.
    values, errors = (a[:p] if p else np.zeros(2) for a in (fit.coefficients, noise.standard_errors))
    decided = fit.determined[:p].reshape(basis.spline.control_points, -1).mean(axis=1) if p else np.ones(1)
    sine_error, cosine_error = rows_of(basis, errors)
    direction_amplitudes, direction_rms, direction_lag = direction_content(spectrum, scan, fit, noise, odd)
    shown, power = spectrum.present, spectrum.power(scan.force - fit.nuisance @ fit.coefficients[p:])
    result = MapFit(
        cogging=cogging_spectrum.cogging_of(basis, values),
        order=chosen,
        sine_standard_error=sine_error,
        cosine_standard_error=cosine_error,
        amplitudes=amplitudes(spectrum, scan, fit, noise),
        offset=float(fit.coefficients[p]),
        offset_standard_error=float(noise.standard_errors[p]),
        coulomb=float(fit.coefficients[p + 1]) if scan.both_ways else None,
        coulomb_standard_error=float(noise.standard_errors[p + 1]) if scan.both_ways else None,
        direction_amplitudes=direction_amplitudes,
        direction_rms=direction_rms,
        direction_lag=direction_lag,
        trend=slope,
        trend_standard_error=slope_error,
        residual_rms=float(np.sqrt(np.mean(fit.residual**2))),
        noise=float(np.sqrt(np.median(noise.level[shown]))),
        cross_validation=tuple(scores),
        unexcited=tuple(np.flatnonzero(decided < 0.5).tolist()),  # determined by less than half on average
        notes=(),
        position=scan.position,
        force=scan.force,
        direction=scan.direction,
        fitted=scan.force - fit.residual,
        line=pitch * spectrum.frequency[shown],
        line_amplitude=spectrum.amplitude(power[shown]),
        line_threshold=spectrum.amplitude(noise.level[shown] * spectrum.threshold(false_alarm, noise.degrees)),
        units=scan.units,
    )
    return replace(result, notes=(*notes, *said, *_remarks(result, spectrum, scan, fit, false_alarm)))


def _choose(
    scan: Scan, pitch: float, terms: list[int], order: int | None, first_knot: float, nuisance: FloatArray
) -> tuple[int, SplineFit, list[CrossValidation], list[str]]:
    """Return the order of fewest coefficients within one standard error of the best, its fit, scores and notes."""
    notes: list[str] = []
    fits: dict[int, SplineFit] = {}
    scores: list[CrossValidation] = []
    n, spans = scan.position.size, int(np.ceil((scan.position.max() - first_knot) / pitch - SLIVER))
    for tried in (ORDERS if order is None else (order,)) if terms else ():
        points = max(1, spans) + tried - 1 if tried else 1
        size = 2 * len(terms) * points
        if order is not None:
            limit = min(MOST_COEFFICIENTS, n - 4)
            got = f"{size} for order {order} from origin {first_knot:g} {scan.units.position}"
            require(size <= limit, "order", f"must need at most {limit} coefficients ({n} points)", got)
        elif tried and size > min(MOST_COMPARED, n // 2):
            notes.append(f"order {tried} not tried: {size} coefficients for {n} points")
            continue
        elif tried and points == 1:
            continue  # one span and one control point: the periodic map once more
        form: dict[str, Any] = {"order": max(tried, 1), "origin": first_knot, "control_points": points}
        basis = SplineHarmonics(pitch=pitch, harmonics=terms, **form)
        fits[tried] = fit_splines(basis, scan.position, scan.force, nuisance)
        # Long enough that noise of neighbours does not leak, short enough that a spline is held from both sides.
        block = min(pitch / 8.0, scan.travel / (8.0 * cogging_spectrum.FOLDS))
        rms, error = cogging_spectrum.cross_validate(fits[tried], scan.position, scan.force, block)
        scores.append(CrossValidation(tried, size, rms, error))
    if not scores:
        return 0, fit_splines(None, scan.position, scan.force, nuisance), scores, notes
    best = min(scores, key=lambda score: score.rms)
    good = [score for score in scores if score.rms <= best.rms + best.standard_error]
    chosen = min(good, key=lambda score: score.coefficients).order
    return chosen, fits[chosen], scores, notes
