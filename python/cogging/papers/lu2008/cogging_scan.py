"""Scans of the cogging of Lu, Chen, Yao, Wang 2008 (Figs. 5, 6), the harmonics in their spectrum, Figs. 2 and 3.

The paper measures the blocking force every millimetre, applies an FFT and keeps the harmonics 1, 2, 3, 6, 12 of the
pitch without stating a rule. The rule here is that of `cogging map` (cogging.mapping): a harmonic is kept if noise
alone would raise a line of the spectrum as high in one scan of a hundred.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
from matplotlib.figure import Figure

from cogging._core import BSpline, CoggingModel
from cogging.arrays import FloatArray
from cogging.mapping.cogging_spectrum import HarmonicSpectrum
from cogging.mapping.fit_map import MapFit, fit_map
from cogging.papers.lu2008.gantry import HARMONICS, ORDER, PITCH, TRAVEL, GantryAxis
from cogging.papers.result import Row, Table, explored
from cogging.plot.canvas import drawn, legend, new_figure, titled_panels
from cogging.plot.characteristics import spectrum
from cogging.plot.scales import scale_of
from cogging.plot.series import FITTED, LIMIT, MEASURED

SIZE = (8.0, 3.4)  # inches
SCAN_STEP = 0.001  # m (section "System Identification")
POSITION: FloatArray = np.arange(TRAVEL[0], TRAVEL[1] + 0.5 * SCAN_STEP, SCAN_STEP)  # m, of a scan
SCAN_NOISE = 0.003  # V rms of the force sensor, not reported, assumed
HIGHEST = 19  # highest harmonic of which points 1 mm apart sample a period more than 2.5 times
FALSE_ALARM = 0.01  # of a scan of noise alone, not reported, assumed
BESIDE = 0.3  # harmonics: how far from its number the lines of a modulated harmonic are searched


def scan_force(cogging: CoggingModel, noise: float = SCAN_NOISE, seed: int = 2008) -> FloatArray:
    """Return the blocking force (V) at POSITION as measured by a sensor with noise (V rms)."""
    sensor = np.random.default_rng(seed).normal(0.0, noise, POSITION.size)
    return np.asarray(cogging.force(POSITION) + sensor)


def fit_scan(force: FloatArray, harmonics: list[int] | None = None) -> MapFit:
    """Fit a map with the paper's splines to the force (V) at the first positions; harmonics: None for the rule's."""
    options: dict[str, Any] = {"order": ORDER, "origin": TRAVEL[0], "highest_harmonic": HIGHEST}
    options |= {"false_alarm": FALSE_ALARM, "harmonics": harmonics}
    return fit_map(POSITION[: force.size], force, pitch=PITCH, **options)


def chosen(fit: MapFit) -> tuple[int, ...]:
    """Return the harmonics that the rule keeps."""
    return tuple(entry.harmonic for entry in fit.amplitudes)


def noise_hiding(cogging: CoggingModel, harmonics: Sequence[int] = HARMONICS) -> dict[int, float]:
    """Return the sensor noise (V rms) at which the highest line of each harmonic equals the rule's threshold."""
    force = scan_force(cogging, noise=0.0)
    lines = HarmonicSpectrum(POSITION, PITCH, HIGHEST)
    power = np.where(lines.near, lines.power(force - force.mean()), 0.0).max(axis=1)
    _, degrees = lines.level(np.ones(lines.frequency.shape), ~lines.present, 1.0)
    needed = lines.threshold(FALSE_ALARM, degrees)
    return {harmonic: float(np.sqrt(power[harmonic] / needed)) for harmonic in harmonics}


def harmonics_table(name: str, cogging: CoggingModel, fit: MapFit) -> Table:
    """Tabulate the harmonics in the scan of an axis's map, which of them the rule keeps, and whose own line exceeds it.

    A harmonic whose amplitude changes its sign along the travel has a line on either side and none between.
    """
    kept = chosen(fit)
    lines = [int(np.argmin(np.abs(fit.line - harmonic))) for harmonic in range(1, HIGHEST + 1)]
    amplitude, threshold = fit.line_amplitude[lines], fit.line_threshold[lines]
    listed = sorted({*HARMONICS, *kept})
    words = {harmonic: "kept" if harmonic in kept else "hidden" for harmonic in listed}
    if rest := [harmonic for harmonic in range(1, HIGHEST + 1) if harmonic not in listed]:
        words[max(rest, key=lambda harmonic: amplitude[harmonic - 1])] = "largest of the rest"
    rows = [
        explored("scan", "amplitude", "V", amplitude[n - 1], harmonic=str(n), rule=word) for n, word in words.items()
    ]
    hidden = noise_hiding(cogging)
    weakest = min(hidden, key=lambda harmonic: hidden[harmonic])
    rows.append(explored("rule", "threshold", "V", float(np.median(threshold))))
    rows.append(explored("rule", "noise", "V", hidden[weakest], harmonic=f"{weakest}, at which it is lost"))
    own_lines = sum((amplitude >= threshold)[harmonic - 1] for harmonic in HARMONICS)
    for index, count in (("kept", len(set(kept) & set(HARMONICS))), ("own_lines", own_lines)):
        printed = float(len(HARMONICS))
        rows.append(Row("rule", index, "1", printed, float(count), "exploratory", {"of": "the paper's"}))
    return Table(f"harmonics_{name}", f"Spectrum of the scan, {name} axis (the map is assumed)", rows)


@drawn
def figure_spline(order: int, number: int) -> Figure:
    """Draw Fig. 2 or 3: f_S(x) of order 1 or 3 over five magnets, with control points of our choice."""
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
def figure_map(axis: GantryAxis, force: FloatArray, number: int) -> Figure:
    """Draw Fig. 5 or 6: a scan of the assumed map, and its fit with the paper's five harmonics."""
    fit = fit_scan(force, list(HARMONICS))
    along, up = scale_of("m", POSITION), scale_of("V", force)
    figure = new_figure(SIZE)
    axes = figure.subplots()
    axes.plot(along(POSITION), up(force), ".", color=MEASURED, markersize=4, label="scan at 1 mm")
    x = np.linspace(POSITION[0], POSITION[-1], 4 * POSITION.size)
    fitted = fit.cogging.force(x) + fit.offset + fit.trend * (x - x.mean())
    axes.plot(along(x), up(fitted), color=FITTED, linewidth=0.9, label="fitted, order 3")
    axes.set(xlabel=along.label("position"), ylabel=up.label("force"))
    axes.set_title(f"Fig. {number}: cogging force of the {axis.name} axis (assumed)", loc="left")
    axes.margins(x=0.01)
    legend(axes)
    return figure


@drawn
def figure_fft(fits: Mapping[str, MapFit]) -> Figure:
    """Draw the spectra of the scans by axis, the rule's threshold and the kept harmonics at their highest lines."""
    title = "FFT of the scans of Figs. 5 and 6; dotted: the paper's harmonics"
    figure, panels = titled_panels(title, (8.0, 2.9 * len(fits)), len(fits), sharex=True, squeeze=False)
    for axes, (name, fit) in zip(panels[:, 0], fits.items(), strict=True):
        spectrum(fit, ax=axes)
        axes.lines[0].set_label("scan")
        marks = next(line for line in axes.lines if line.get_label() == "harmonics")
        line, height = axes.lines[0].get_xdata(), np.asarray(axes.lines[0].get_ydata())
        near = [np.where(np.abs(line - harmonic) <= BESIDE, height, 0.0).argmax() for harmonic in chosen(fit)]
        marks.set_data(line[near], height[near])
        marks.set_label("kept, at its highest line")
        legend(axes)
        axes.set_title(f"{name} axis: {', '.join(map(str, chosen(fit)))} are kept", loc="left")
        axes.set_xlim(0.0, HIGHEST + 0.5)
        axes.set_xticks(range(HIGHEST + 1))
        for harmonic in HARMONICS:
            axes.axvline(harmonic, color="0.6", linestyle=":", linewidth=0.9, zorder=0)
        axes.grid(visible=False, axis="x")
        axes.label_outer()
    return figure
