"""Scans of the cogging of Lu, Chen, Yao, Wang 2008 (Figs. 5, 6), the harmonics in their spectrum, Figs. 2 and 3.

The paper measures the blocking force every millimetre, applies an FFT and keeps the harmonics 1, 2, 3, 6, 12 of the
pitch without stating a rule. Here the rule is that of `cogging map` (cogging.mapping): a harmonic is kept when noise
alone would lift any line of the spectrum as high once in a hundred scans.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from cogging._core import BSpline, CoggingModel
from cogging.arrays import FloatArray
from cogging.mapping.cogging_spectrum import HarmonicSpectrum
from cogging.mapping.fit_map import fit_map
from cogging.mapping.map_fit import MapFit
from cogging.papers.lu2008.gantry import HARMONICS, ORDER, PITCH, TRAVEL, GantryAxis
from cogging.papers.result import Row, Table, explored
from cogging.plot.canvas import drawn, legend, new_figure
from cogging.plot.characteristics import spectrum
from cogging.plot.scales import scale_of
from cogging.plot.series import FITTED, LIMIT, MEASURED

if TYPE_CHECKING:
    from matplotlib.figure import Figure

SIZE = (8.0, 3.4)  # inches
SCAN_STEP = 0.001  # m (section "System Identification")
SCAN_NOISE = 0.003  # V rms, not reported, assumed: of the force sensor
HIGHEST = 19  # harmonic: the last of which points 1 mm apart lie more than 2.5 in a period
FALSE_ALARM = 0.01  # not reported, assumed: of a scan of noise alone
BESIDE = 0.3  # harmonics: how far the lines of one that is modulated along the travel are looked for


@drawn
def figure_spline(order: int, number: int) -> Figure:
    """Figs. 2, 3: f_S(x) of order 1 and 3 over five magnets; the control points are of our choice."""
    magnets = 5
    points = np.array([0.6, 1.0, 0.4, 0.8, 0.5, 0.9, 0.7])[: magnets + order - 1]
    spline = BSpline(order=order, origin=0.0, pitch=PITCH, control_points=len(points))
    x = np.linspace(0.0, spline.end, 1001)[:-1]
    middles = (np.arange(len(points)) + 1 - order / 2) * PITCH  # of each control point's support
    along = scale_of("m", x)
    figure = new_figure(SIZE)
    axes = figure.subplots()
    axes.plot(along(x), spline.design_matrix(x) @ points, color=MEASURED, label="f_S(x)")
    axes.plot(along(middles), points, "o", color=LIMIT, markersize=6, label="control points")
    for magnet in range(magnets + 1):
        axes.axvline(float(along(magnet * PITCH)), color="0.6", linestyle=":", linewidth=0.9)
    axes.set(xlabel=along.label("position"), ylabel="f_S (V)")
    axes.set_title(f"Fig. {number}: B-spline of order {order}; dotted: the knots", loc="left")
    legend(axes)
    return figure


@drawn
def figure_map(axis: GantryAxis, scan: CoggingScan, fit: MapFit, number: int) -> Figure:
    """Figs. 5, 6: the scan of the assumed map over the whole travel, and its fit with the paper's five harmonics."""
    along, up = scale_of("m", scan.position), scale_of("V", scan.force)
    figure = new_figure(SIZE)
    axes = figure.subplots()
    axes.plot(along(scan.position), up(scan.force), ".", color=MEASURED, markersize=4, label="scan at 1 mm")
    x = np.linspace(scan.position[0], scan.position[-1], 4 * scan.position.size)
    fitted = fit.cogging.force(x) + fit.offset + fit.trend * (x - x.mean())
    axes.plot(along(x), up(fitted), color=FITTED, linewidth=0.9, label="fitted, order 3")
    axes.set(xlabel=along.label("position"), ylabel=up.label("force"))
    axes.set_title(f"Fig. {number}: cogging force of the {axis.name} axis (assumed)", loc="left")
    axes.margins(x=0.01)
    legend(axes)
    return figure


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
    listed = sorted({*HARMONICS, *kept})
    rest = [harmonic for harmonic in range(1, HIGHEST + 1) if harmonic not in listed]
    rows = [_row(harmonic, amplitude, "kept" if harmonic in kept else "hidden") for harmonic in listed]
    if rest:
        rows.append(_row(max(rest, key=lambda harmonic: amplitude[harmonic - 1]), amplitude, "largest of the rest"))
    threshold = float(np.median(at_harmonic(fit, fit.line_threshold)))
    rows.append(explored("rule", "threshold", "V", threshold))
    hidden = noise_hiding(cogging)
    weakest = min(hidden, key=lambda harmonic: hidden[harmonic])
    rows.append(explored("rule", "noise", "V", hidden[weakest], {"harmonic": f"{weakest}, at which it is lost"}))
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
    return explored("scan", "amplitude", "V", amplitude[harmonic - 1], label)


@drawn
def figure_fft(fits: Mapping[str, MapFit]) -> Figure:
    """The spectrum of each axis's scan over the harmonic of the pitch, with what the rule asks for and what it keeps.

    A kept harmonic is marked at its highest line: one whose amplitude changes its sign along the travel has a line on
    either side and none at its own place.

    Args:
        fits: of the scans, by axis.
    """
    figure = new_figure((8.0, 2.9 * len(fits)))
    panels = figure.subplots(len(fits), 1, sharex=True, squeeze=False)[:, 0]
    for axes, (name, fit) in zip(panels, fits.items(), strict=True):
        spectrum(fit, ax=axes)
        axes.lines[0].set_label("scan")
        marks = next(line for line in axes.lines if line.get_label() == "harmonics")
        line, height = axes.lines[0].get_xdata(), np.asarray(axes.lines[0].get_ydata())
        near = [np.where(np.abs(line - harmonic) <= BESIDE, height, 0.0).argmax() for harmonic in chosen(fit)]
        marks.set_data(line[near], height[near])
        marks.set_label("kept, at its highest line")
        legend(axes)
        kept = ", ".join(map(str, chosen(fit)))
        axes.set_title(f"{name} axis: {kept} are kept", loc="left")
        axes.set_xlim(0.0, HIGHEST + 0.5)
        axes.set_xticks(range(HIGHEST + 1))
        for harmonic in HARMONICS:
            axes.axvline(harmonic, color="0.6", linestyle=":", linewidth=0.9, zorder=0)
        axes.grid(visible=False, axis="x")
        axes.label_outer()
    figure.suptitle("FFT of the scans of Figs. 5 and 6; dotted: the paper's harmonics")
    return figure
