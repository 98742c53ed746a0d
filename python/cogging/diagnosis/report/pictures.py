"""Pictures of the page: one panel each, with its finding as text."""

from __future__ import annotations

import base64
import io
import warnings
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from functools import partial
from typing import TYPE_CHECKING, Any

from cogging.diagnosis.places import length_text, quantity_text, shape_text
from cogging.diagnosis.report.figures import (
    NO_MOTION,
    PANELS,
    Peak,
    Series,
    direction_of,
    draw_curve,
    draw_folded,
    draw_profile,
    draw_shape,
    draw_spectrum,
    draw_trace,
)
from cogging.diagnosis.report.words import other_shape_text, plain
from cogging.model.units import Units

if TYPE_CHECKING:
    from cogging.diagnosis.diagnosis_result import Diagnosis
    from cogging.diagnosis.entries import NamedEffect

PERIODS, SHAPES = 3, 6  # maximum number of folded periods and of coordinates on a page


@dataclass(frozen=True)
class Picture:
    """A panel of the page.

    Attributes:
        source: data URL of a PNG.
        finding: sentence on what it shows.
    """

    source: str
    finding: str


def gaps_of(result: Diagnosis) -> dict[str, dict[str, Any]]:
    """Return the rows of the logs by name with the gap before and after; empty if nothing was measured."""
    series = result.series
    if "gap_before" not in series:
        return {}
    shared = {name: series[name] for name in ("time", "position", "velocity", "acceleration", "command", "mask")}
    labels = {"before: re-tuned model": "gap_before"}
    if result.effects:
        labels["after: patched model"] = "gap_after"
    return {label: {**shared, "gap": series[name]} for label, name in labels.items()}


def pictures_of(result: Diagnosis) -> dict[str, list[Picture]]:
    """Return the pictures of a result by part of the page."""
    gaps, units = gaps_of(result), result.model.units
    parts: dict[str, list[Picture]] = {"shapes": [], "time": [], "folded": [], "coordinates": []}
    if not gaps:
        return parts
    parts["time"] = [_trace(gaps, units, near=near) for near in (False, True)]
    parts["coordinates"] = [_profile(gaps, units, *panel) for panel in PANELS] + [_spectrum(gaps, units)]
    if result.location is not None:
        for shape in result.location.significant[:SHAPES]:
            finding = f"Missing: {shape_text(shape, units)}."
            parts["shapes"].append(picture(partial(draw_shape, shape=shape, units=units), finding))
        waves = [wave.value for wave in result.location.waves if wave.coordinate == "spatial period"]
        parts["folded"] = [_folded(gaps, units, period, sign) for period in waves[:PERIODS] for sign in (1.0, -1.0)]
    # skip directions in which the axis did not move
    return {part: [one for one in pictures if NO_MOTION not in one.finding] for part, pictures in parts.items()}


def curve_picture(effect: NamedEffect, units: Units) -> Picture | None:
    """Return the picture of the force of an effect with a non-standard law; None if it has no curve."""
    if effect.curve is None:
        return None
    finding = f"{plain(effect.name)}: {other_shape_text(effect, units)}."
    return picture(lambda axes: draw_curve(axes, effect, units), finding)


def picture(draw: Callable[[Any], object], finding: str = "") -> Picture:
    """Return a drawing as a picture that is readable at the width of a phone.

    Args:
        draw: function that draws on axes.
        finding: sentence on what it shows; by default the value that `draw` returns.
    """
    from matplotlib.figure import Figure

    figure = Figure(figsize=(5.6, 3.1), layout="constrained", facecolor="none")
    axes = figure.subplots()
    axes.set_facecolor("none")  # the background of the page is light or dark
    returned = draw(axes)
    buffer = io.BytesIO()
    with warnings.catch_warnings():
        warnings.filterwarnings("ignore", "Glyph")  # the font may lack a letter of a name
        figure.savefig(buffer, format="png", dpi=140, facecolor="none")
    source = "data:image/png;base64," + base64.b64encode(buffer.getvalue()).decode()
    return Picture(source, finding or str(returned))


def _trace(gaps: Mapping[str, Series], units: Units, *, near: bool) -> Picture:
    def draw(axes: Any) -> str:
        rms = draw_trace(axes, gaps, units, near=near)
        sizes = ", ".join(f"{_when(label)} {value:.3g} {units.of('V')} rms" for label, value in rms.items())
        return "A twelfth of the log, enlarged." if near else f"Gap over time: {sizes}."

    return picture(draw)


def _profile(gaps: Mapping[str, Series], units: Units, name: str, label: str, unit: str, way: str) -> Picture:
    def draw(axes: Any) -> str:
        peaks = draw_profile(axes, gaps, name, direction_of(way))
        axes.set(xlabel=f"{label} ({units.of(unit)})", ylabel=f"mean gap ({units.of('V')})")
        words = ", ".join(f"{_when(which)} {_peak_text(one, unit, units)}" for which, one in peaks.items())
        return f"Gap against {label}: {words or NO_MOTION}."

    return picture(draw)


def _spectrum(gaps: Mapping[str, Series], units: Units) -> Picture:
    def draw(axes: Any) -> str:
        peaks = draw_spectrum(axes, gaps, units)
        words = ", ".join(f"{_when(which)} largest at {one[1]:.3g} Hz" for which, one in peaks.items() if one)
        return f"Spectrum of the gap: {words}."

    return picture(draw)


def _folded(gaps: Mapping[str, Series], units: Units, period: float, sign: float) -> Picture:
    way = "forward" if sign > 0.0 else "backward"

    def draw(axes: Any) -> str:
        amplitudes = draw_folded(axes, gaps, period, sign, units)
        sizes = [f"{size:.2g} {units.of('V')}" for size in amplitudes.values() if size is not None]
        words = f"amplitude {sizes[0]}" if sizes else NO_MOTION
        words += f", {sizes[1]} after" if len(sizes) > 1 else ""
        return f"Gap within {length_text(period, units)} of position, moving {way}: {words}."

    return picture(draw)


def _when(label: str) -> str:
    return label.partition(":")[0]


def _peak_text(peak: Peak, unit: str, units: Units) -> str:
    if peak is None:
        return "not significant"
    return f"peak of {peak[0]:+.2g} {units.of('V')} near {quantity_text(peak[1], unit, units)}"
