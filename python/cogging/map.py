"""The cogging map: the model F_cogging(x) of a measured force-against-position scan (Lu et al. 2008, eq. 3 to 7)."""

from __future__ import annotations

import io
import operator
import os
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np
import numpy.typing as npt

from cogging._core import CoggingModel, SplineHarmonics
from cogging.files import to_toml, write_bytes, write_text
from cogging.model import cogging_to_dict
from cogging.scan import Scan, read_scan
from cogging.spectrum import HarmonicSpectrum, Line, normal_equations

if TYPE_CHECKING:
    from matplotlib.figure import Figure

FloatArray = npt.NDArray[np.float64]

ORDERS = (0, 1, 2, 3, 4)  # compared where none is given; 0 = periodic
MOST_TERMS = 32  # of SplineHarmonics
MOST_COEFFICIENTS = 4000  # of one fit: its normal matrix is dense
FOLDS = 8
SLIVER = 0.05  # of a pitch: a shorter rest of the travel gets no span of its own
SIGNIFICANT = 3.0  # standard errors from which a trend is kept


@dataclass(frozen=True)
class HarmonicAmplitude:
    """One harmonic of the map: amplitude sin(2 pi harmonic x / pitch + phase).

    Attributes:
        harmonic: of the pitch.
        amplitude: V; of a modulated harmonic the rms over the scan of its local amplitude sqrt(f_S^2 + f_C^2).
        standard_error: V, of the amplitude.
        phase: rad; of a modulated harmonic that of the means of f_S and f_C.
        false_alarm: probability that noise alone lifts any line of the spectrum as far as this one.
    """

    harmonic: int
    amplitude: float
    standard_error: float
    phase: float
    false_alarm: float


@dataclass(frozen=True)
class CrossValidation:
    """How well a model predicts the parts of the scan that its fit did not see.

    Attributes:
        order: of the B-splines; 0 = periodic.
        coefficients: number of sines and cosines.
        rms: V, of the prediction errors.
        standard_error: V, of that rms, from its scatter between the blocks left out.
    """

    order: int
    coefficients: int
    rms: float
    standard_error: float


@dataclass(frozen=True)
class MapFit:
    """A cogging model fitted to a scan, force = F_cogging(x) + offset + trend (x - centre) + coulomb direction.

    Attributes:
        cogging: F_cogging(x), V; zero where no harmonic was found.
        order: of the B-splines; 0 = periodic.
        sine_standard_error: V, (terms, control points), as `cogging.sine`; likewise cosine_standard_error. That of a
            control point in `unexcited` is the prior's.
        amplitudes: one entry a harmonic.
        offset: V, at the centre of the travel; offset_standard_error likewise.
        coulomb: V, half of the difference of the two directions; None where the scan goes one way only.
        trend: V/m; 0 with the standard error 0 where it is within 3 standard errors of none and therefore left out.
        residual_rms: V, of the averaged points.
        noise: V rms of one averaged point, from the median of the residual's spectrum; where residual_rms is larger, the
            scan has structure that the model lacks.
        cross_validation: the models that were compared, simplest first.
        unexcited: control points (from 0) that the scan determines by less than half; the rest is the prior, which
            continues the neighbours.
        notes: what the reader has to know about this fit.
        position, force, direction: the averaged points of the scan: m, V, +1 or -1, (n,).
        fitted: V, (n,), the model with offset, trend and friction at these points.
        line, line_amplitude, line_threshold: the spectrum: f pitch (whole at harmonics), V, and V above which a line is
            found, each (lines,).
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

    def summary(self) -> str:
        """The fit in a few lines for the screen."""
        spline, pitch = self.cogging.basis.spline, self.cogging.basis.pitch
        kind = f"order {self.order}, {spline.control_points} control points" if self.order else "periodic"
        lines = [
            f"cogging map: {len(self.position)} points over {np.ptp(self.position):.4g} m, pitch {pitch:.4g} m, {kind}",
            "harmonic  amplitude (V)   +- (V)  phase (rad)  false alarm",
        ]
        for a in self.amplitudes:
            lines.append(
                f"{a.harmonic:8d}  {a.amplitude:13.5g}  {a.standard_error:7.1g}  {a.phase:11.3f}  {a.false_alarm:11.1g}"
            )
        values = [("offset", self.offset, self.offset_standard_error, "V")]
        if self.coulomb is not None and self.coulomb_standard_error is not None:
            values.insert(0, ("coulomb", self.coulomb, self.coulomb_standard_error, "V"))
        if self.trend_standard_error > 0.0:
            values.append(("trend", self.trend, self.trend_standard_error, "V/m"))
        lines += [f"{name:8s}  {value:13.5g}  {error:7.1g}  {unit}" for name, value, error, unit in values]
        lines.append(f"residual  {self.residual_rms:13.5g}  V rms; noise {self.noise:.3g} V rms")
        for c in self.cross_validation:
            name, mark = (f"order {c.order}" if c.order else "periodic"), "  <- chosen" * (c.order == self.order)
            lines.append(f"predicts  {c.rms:13.5g}  {c.standard_error:7.1g}  V rms, {name}, {c.coefficients} coefficients{mark}")
        return "\n".join(lines + [f"note: {note}" for note in self.notes])

    def plot(self) -> Figure:
        """Draw measured and fitted force and their difference over position (as Figs. 5, 6), and the spectrum."""
        from matplotlib.figure import Figure

        figure = Figure(figsize=(9.0, 9.0), layout="constrained")
        force, residual, spectrum = figure.subplots(3, 1)
        residual.sharex(force)
        for direction, colour, name in ((1.0, "tab:blue", "forward"), (-1.0, "tab:orange", "backward")):
            x, measured, fitted = (v[self.direction == direction] for v in (self.position, self.force, self.fitted))
            if x.size:
                force.plot(x, measured, ".", markersize=2.5, color=colour, label=f"measured, {name}")
                force.plot(x, fitted, linewidth=0.8, color="black", label=None if force.lines[2:] else "fitted")
                residual.plot(x, measured - fitted, linewidth=0.6, color=colour)
        force.set(ylabel="force (V)", title="Cogging map")
        force.legend(loc="upper right", fontsize="small")
        residual.set(xlabel="position (m)", ylabel="residual (V)")
        spectrum.semilogy(self.line, self.line_amplitude, linewidth=0.7, label="measured")
        spectrum.semilogy(self.line, self.line_threshold, linewidth=0.9, label="found from here")
        for entry in self.amplitudes:
            spectrum.axvline(entry.harmonic, color="black", linewidth=0.4, linestyle=":")
        largest = float(self.line_amplitude.max())
        spectrum.set(xlabel="harmonic of the pitch", ylabel="amplitude (V)")
        if largest > 0.0:
            spectrum.set_ylim(1e-5 * largest, 3.0 * largest)
        spectrum.legend(loc="upper right", fontsize="small")
        return figure

    def write(self, path: str | os.PathLike[str]) -> None:
        """Write the `[cogging]` section of a model file, and the figure beside it as .png.

        Raises:
            InputError: a file cannot be written.
        """
        picture = io.BytesIO()
        self.plot().savefig(picture, format="png", dpi=120)
        write_text(path, to_toml({"cogging": cogging_to_dict(self.cogging)}))
        write_bytes(Path(path).with_suffix(".png"), picture.getvalue())


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
    F_cogging(x) = sum_i (f_Si(x) sin(2 pi i x / pitch) + f_Ci(x) cos(2 pi i x / pitch)), f constant or B-splines on knots one
    pitch apart from `origin` over the travel. Least squares on points averaged over small cells, with a weak prior: the
    difference of neighbouring control points has mean 0 and the standard deviation of the scan's force, so that a control
    point that the scan does not reach continues its neighbour, and is listed in `unexcited`.

    Harmonics are found in the least-squares spectrum (HarmonicSpectrum.find). Periodic and orders 1 to 4 are compared by
    8-fold cross-validation on blocks of position half the shortest period long, both directions together; the one of
    fewest coefficients within one standard error of the best is taken. Noise correlated over more than a block is not told
    from a modulation. Standard errors take the noise at a harmonic's own frequency from the residual's spectrum, and no
    less than the residual's mean square.

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

    Raises:
        ValueError: names the field, the rule and the value: fewer than 10 points, NaN, lengths that differ, a travel
            below one pitch, points too far apart, a harmonic that they do not resolve, more coefficients than points, ...
    """
    _require(_is_number(pitch) and pitch > 0.0, "pitch", "must be finite and above 0", pitch)
    _require(_is_number(false_alarm) and 0.0 < false_alarm < 1.0, "false_alarm", "must lie between 0 and 1", false_alarm)
    _whole("highest_harmonic", highest_harmonic, 1, 10_000)
    if harmonics is not None:
        harmonics = [_whole("harmonics", harmonic, 1, 10_000) for harmonic in harmonics]
        highest_harmonic = max([highest_harmonic, *harmonics])
    scan = read_scan(position, force, pitch=pitch, force_sign=force_sign, highest_harmonic=highest_harmonic)
    if harmonics is not None:
        SplineHarmonics(pitch=pitch, harmonics=harmonics)  # its own rules
        rule = f"must be at most {scan.resolvable}, which have 2.5 points in a period"
        _require(max(harmonics) <= scan.resolvable, "harmonics", rule, max(harmonics))
    if order is not None:
        _whole("order", order, 0, 16)
    lowest, highest = float(scan.position.min()), float(scan.position.max())
    origin = lowest if origin is None else origin
    _require(_is_number(origin) and origin < highest, "origin", f"must lie below the highest position {highest:g} m", origin)

    notes = list(scan.notes)
    spectrum = HarmonicSpectrum(scan.position, pitch, scan.highest)
    nuisance = _nuisance(scan, trend=True)
    rest = scan.force - nuisance @ np.linalg.lstsq(nuisance, scan.force, rcond=None)[0]
    found: list[Line] = []
    if harmonics is None:
        found = spectrum.find(rest, false_alarm)
        harmonics = [line.harmonic for line in found if line.harmonic is not None]
        if len(harmonics) > MOST_TERMS:
            notes.append(f"{len(harmonics)} harmonics found, the {MOST_TERMS} strongest kept")
        harmonics = sorted(harmonics[:MOST_TERMS])
    if not harmonics:
        notes.append("no harmonic of the pitch stands out of the noise: the map is zero")
        order = 0
    terms = harmonics or [1]

    bases, scores = {}, []
    for candidate in ORDERS if order is None else (order,):
        points = _control_points(candidate, origin, highest, pitch)
        size = 2 * len(terms) * points
        limit = min(MOST_COEFFICIENTS, scan.position.size - 3) if order is not None else scan.position.size // 2
        if order is not None:
            rule = f"must need at most {limit} coefficients for {scan.position.size} points and origin {origin:g} m"
            _require(size <= limit, "order", rule, f"{size} with order {order}")
        if size > min(limit, MOST_COEFFICIENTS // 2):
            notes.append(f"order {candidate} left out: {size} coefficients for {scan.position.size} points")
            continue
        if candidate == 1 and points == 1 and order is None:
            continue  # one span, one control point: the periodic model again
        bases[candidate] = SplineHarmonics(
            pitch=pitch, harmonics=terms, order=candidate or 1, origin=origin, control_points=points
        )
