"""The pictures of a page: one panel each, so that they stack on a phone, with the finding as text."""

from __future__ import annotations

import base64
import io
import warnings
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

from cogging.diagnosis.places import Shape, length_text, quantity_text, shape_text
from cogging.diagnosis.report.figures import (
    NO_MOTION,
    PANELS,
    Extreme,
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
    from cogging.diagnosis.entries import NamedEffect
    from cogging.diagnosis.location import Location
    from cogging.diagnosis.result import Diagnosis

PERIODS, SHAPES = 3, 6  # folded periods, and coordinates, on a page at most


@dataclass(frozen=True)
class Picture:
    """A panel as a page takes it.

    Attributes:
        source: data address of a PNG.
        finding: what it shows, in a sentence.
    """

    source: str
    finding: str


def gaps_of(result: Diagnosis) -> dict[str, dict[str, Any]]:
    """Rows of the logs by name, with the gap before and after; empty where nothing was measured."""
    series = result.series
    if "gap_before" not in series:
        return {}
    shared = {name: series[name] for name in ("time", "position", "velocity", "acceleration", "command", "mask")}
    labels = {"before: re-tuned model": "gap_before"}
    if result.effects:
        labels["after: with what was found"] = "gap_after"
    return {label: {**shared, "gap": series[name]} for label, name in labels.items()}


def pictures_of(result: Diagnosis) -> dict[str, list[Picture]]:
    """The pictures of a result by the part of the page that they stand in."""
    gaps, units = gaps_of(result), result.model.units
    told: dict[str, list[Picture]] = {"shapes": [], "time": [], "folded": [], "coordinates": []}
    if not gaps:
        return told
    told["time"] = [_trace(gaps, units, near=near) for near in (False, True)]
    told["coordinates"] = [_profile(gaps, units, *panel) for panel in PANELS] + [_spectrum(gaps, units)]
    if result.location is not None:
        told["shapes"] = shape_pictures(result.location)
        waves = [wave.value for wave in result.location.waves if wave.coordinate == "spatial period"]
        told["folded"] = [_folded(gaps, units, period, sign) for period in waves[:PERIODS] for sign in (1.0, -1.0)]
    # Of a way that the axis did not move there is nothing to see.
    return {part: [one for one in pictures if NO_MOTION not in one.finding] for part, pictures in told.items()}


def shape_pictures(location: Location) -> list[Picture]:
    """The force that the re-tuned model lacks, as the whitened residual asks for it, in each coordinate that tells."""
    units = location.model.units

    def drawn(shape: Shape) -> Picture:
        return picture(lambda axes: draw_shape(axes, shape, units), f"Missing: {shape_text(shape, units)}.")

    return [drawn(shape) for shape in location.significant[:SHAPES]]


def curve_picture(effect: NamedEffect, units: Units) -> Picture | None:
    """The force of an effect whose law is not the plainest; None where it has none over one coordinate."""
    if effect.curve is None:
        return None
    finding = f"{plain(effect.name)} is {other_shape_text(effect, units)}."
    return picture(lambda axes: draw_curve(axes, effect, units), finding)


def picture(draw: Callable[[Any], object], finding: str = "") -> Picture:
    """A panel drawn and written as a data address, of a size whose letters can be read at the width of a phone.

    Args:
        draw: draws on axes.
        finding: what it shows; what the drawing returns where nothing is said.
    """
    from matplotlib.figure import Figure

    figure = Figure(figsize=(5.6, 3.1), layout="constrained", facecolor="none")
    axes = figure.subplots()
    axes.set_facecolor("none")  # the card behind it is light or a little darker, as the page is
    returned = draw(axes)
    buffer = io.BytesIO()
    with warnings.catch_warnings():
        warnings.filterwarnings("ignore", "Glyph")  # a letter that the font lacks is a box: the page's text has it
        figure.savefig(buffer, format="png", dpi=140, facecolor="none")
    source = "data:image/png;base64," + base64.b64encode(buffer.getvalue()).decode()
    return Picture(source, finding or str(returned))


def _trace(gaps: Mapping[str, Series], units: Units, *, near: bool) -> Picture:
    def draw(axes: Any) -> str:
        rms = draw_trace(axes, gaps, units, near=near)
        told = ", ".join(f"{_when(label)} {value:.3g} {units.of('V')} rms" for label, value in rms.items())
        return "A twelfth of that from close by." if near else f"Gap over time: {told}."

    return picture(draw)


def _profile(gaps: Mapping[str, Series], units: Units, name: str, label: str, unit: str, way: str) -> Picture:
    def draw(axes: Any) -> str:
        told = draw_profile(axes, gaps, name, direction_of(way))
        axes.set(xlabel=f"{label} ({units.of(unit)})", ylabel=f"mean gap ({units.of('V')})")
        words = ", ".join(f"{_when(which)} {_extreme(one, unit, units)}" for which, one in told.items())
        return f"Gap against {label}: {words or NO_MOTION}."

    return picture(draw)


def _spectrum(gaps: Mapping[str, Series], units: Units) -> Picture:
    def draw(axes: Any) -> str:
        told = draw_spectrum(axes, gaps, units)
        words = ", ".join(f"{_when(which)} largest at {one[1]:.3g} Hz" for which, one in told.items() if one)
        return f"Spectrum of the gap: {words}."

    return picture(draw)


def _folded(gaps: Mapping[str, Series], units: Units, period: float, sign: float) -> Picture:
    way = "forward" if sign > 0.0 else "backward"

    def draw(axes: Any) -> str:
        told = draw_folded(axes, gaps, period, sign, units)
        sizes = [f"{size:.2g} {units.of('V')}" for size in told.values() if size is not None]
        words = f"a wave of {sizes[0]}" if sizes else NO_MOTION
        words += f", of which {sizes[1]} is left" if len(sizes) > 1 else ""
        return f"Gap within {length_text(period, units)} of position, moving {way}: {words}."

    return picture(draw)


def _when(label: str) -> str:
    return label.partition(":")[0]


def _extreme(one: Extreme, unit: str, units: Units) -> str:
    if one is None:
        return "nothing that stands out"
    place = quantity_text(one[1], unit, units)
    return f"{one[0]:+.2g} {units.of('V')} at most, about {place}"
