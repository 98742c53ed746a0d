"""Figures of the page: `cogging.plot` as inline SVG, in the colours of page.css for light and dark."""

from __future__ import annotations

import io
import re
import warnings
from collections.abc import Callable
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from scipy.signal import welch

from cogging import plot
from cogging.arrays import FloatArray
from cogging.diagnosis.places import COORDINATE_UNITS, length_text
from cogging.diagnosis.report.words import other_shape_text, plain
from cogging.model.units import Units
from cogging.plot.canvas import legend, styled
from cogging.plot.gaps import GAPS
from cogging.plot.scales import scale_of
from cogging.plot.series import look
from cogging.plot.traces import draw_trace

if TYPE_CHECKING:
    from cogging.diagnosis.diagnosis_result import Diagnosis
    from cogging.diagnosis.entries import NamedEffect

STYLE = Path(__file__).with_name("page.css")
PERIODS = 2  # maximum number of spatial periods on a page
AVERAGED = 0.01  # s of a point over time
SIZE = (5.2, 2.7)  # inches; a point of the fonts is then 0.9 px wide on a phone
AXES = (0.145, 0.19, 0.84, 0.71)  # of the figure: left, bottom, width, height
OPTIONS: dict[Any, Any] = {
    "svg.fonttype": "none",
    "svg.hashsalt": "cogging",
    "figure.facecolor": "none",
    "axes.facecolor": "none",
}
#: Variables of page.css for the colours of `cogging.plot`.
COLOURS = {
    "#0072b2": "--first",
    "#e69f00": "--second",
    "#000000": "--ink",
    "#202020": "--ink",
    "#404040": "--soft",
    "#d9d9d9": "--line",
}
METADATA = re.compile(r"<metadata>.*?</metadata>", re.DOTALL)
IDENTIFIER = re.compile(r'<g id="[^"]*_\d+">')  # the same in every figure
BREAK = re.compile(r"\s*\n\s*")
PATH = re.compile(r' d="[^"]*"')
VARIABLE = re.compile(r"(--\w+): (#\w+)")
USED = re.compile(r"var\((--\w+)\)")
DECIMALS = re.compile(r"(\.\d\d)\d+")


@dataclass(frozen=True)
class Picture:
    """A figure of the page.

    Attributes:
        svg: its element.
        finding: sentence on what it shows.
    """

    svg: str
    finding: str


def pictures_of(result: Diagnosis) -> dict[str, list[Picture]]:
    """Return the figures of a result by part of the page: those of the first screen, and the others."""
    if "gap_before" not in result.series:
        return {"first": [], "coordinates": []}
    along = [str(effect.where.get("coordinate")) for effect in result.effects]
    along += [] if result.unlisted is None else [str(result.unlisted["coordinate"])]
    names = list(dict.fromkeys([name for name in along if name in COORDINATE_UNITS and name != "frequency"]))
    names += [name for name in ("position", "velocity", "acceleration", "command") if name not in names]
    by_name = [name for name in names if name != "time"]
    waves = [] if result.location is None else result.location.waves
    periods = [wave.value for wave in waves if wave.coordinate == "spatial period"][:PERIODS]
    return {
        "first": [_profile(result, by_name[0]), _over_time(result)],
        "coordinates": [_profile(result, name) for name in by_name[1:]]
        + [_profile(result, "position", period) for period in periods]
        + [_spectrum(result)],
    }


def curve_picture(effect: NamedEffect, units: Units) -> Picture | None:
    """Return the figure of the force of an effect with a non-standard law; None if it has no curve."""
    if effect.curve is None:
        return None
    curve, name = effect.curve, str(effect.curve["coordinate"])

    def draw(axes: Any) -> None:
        axes.plot(curve["places"], curve["force"])
        axes.set(xlabel=f"{name} ({units.of(COORDINATE_UNITS[name])})", ylabel=f"force ({units.command})")

    return picture(draw, f"{plain(effect.name)}: {other_shape_text(effect, units)}.")


def picture(draw: Callable[[Any], object], finding: str) -> Picture:
    """Return what a function draws on axes as a picture with a sentence on what it shows."""
    import matplotlib as mpl
    from matplotlib.figure import Figure

    written = io.StringIO()
    with styled(), mpl.rc_context(OPTIONS), warnings.catch_warnings():
        warnings.filterwarnings("ignore", "Glyph")  # the font that measures may lack a letter of a name
        figure = Figure(figsize=SIZE)
        figure.set_layout_engine("none")  # fixed margins: a layout takes half of the time
        draw(figure.add_axes(AXES))
        figure.savefig(written, format="svg", metadata={"Date": None}, facecolor="none", edgecolor="none")
    svg = written.getvalue()
    svg = IDENTIFIER.sub("<g>", METADATA.sub("", svg[svg.index("<svg") :]))
    svg = BREAK.sub(" ", svg)
    svg = PATH.sub(lambda path: DECIMALS.sub(r"\1", path[0]), svg)
    for colour, variable in COLOURS.items():
        svg = svg.replace(colour, f"var({variable})")
    return Picture(svg, finding)


def in_schemes(svg: str) -> dict[str, str]:
    """Return a picture's SVG as files of their own, light and dark: with the colours of page.css for its variables."""
    light, dark = (rule.split("}")[0] for rule in STYLE.read_text(encoding="utf-8").split(":root {")[1:3])
    files = {}
    for scheme, rule in (("light", light), ("dark", dark)):
        colours = dict(VARIABLE.findall(rule))
        files[scheme] = USED.sub(partial(lambda of, used: str(of[used[1]]), colours), svg)
    return files


def _labels(result: Diagnosis) -> dict[str, str]:
    return {name: GAPS[name] for name in ("gap_before", "gap_after") if name == "gap_before" or result.effects}


def _profile(result: Diagnosis, name: str, period: float | None = None) -> Picture:
    within = "" if period is None else f" within {length_text(period, result.model.units)}"
    draw = partial(plot.residual, result, against=name, period=period)
    return picture(lambda axes: draw(ax=axes), f"Mean gap against {name}{within}, with 95 % bands.")


def _over_time(result: Diagnosis) -> Picture:
    """Return the gap of the first log over time, without rows at rest."""
    series, units = result.series, result.model.units
    time = np.asarray(series["time"][0]) - series["time"][0][0]
    moving = np.asarray(series["mask"][0]) > 0
    few = max(1, round(AVERAGED / float(np.median(np.diff(time)))))
    gaps = {name: _means(np.where(moving, series[name][0], np.nan), few) for name in _labels(result)}
    up = scale_of("V", *gaps.values(), units=units)

    def draw(axes: Any) -> None:
        for place, (name, gap) in enumerate(gaps.items()):
            draw_trace(axes, _means(time, few), up(gap), label=GAPS[name], **look(place, dense=True))
        axes.set(xlabel="time (s)", ylabel=up.label("gap"))
        legend(axes)

    return picture(draw, f"Gap of the first log over time, averaged over {1e3 * AVERAGED:.0f} ms.")


def _spectrum(result: Diagnosis) -> Picture:
    """Return the amplitude density of the gap of the longest log, zero at rest."""
    series = result.series
    longest = int(np.argmax([len(time) for time in series["time"]]))

    def draw(axes: Any) -> None:
        for place, (name, label) in enumerate(_labels(result).items()):
            gap = np.where(np.asarray(series["mask"][longest]) > 0, series[name][longest], 0.0)
            axes.loglog(*spectrum(series["time"][longest], gap), label=label, **look(place, dense=True))
        for axis in (axes.xaxis, axes.yaxis):
            axis.set_major_formatter("{x:g}")  # powers of ten are formulas, which take long to set
        axes.set(xlabel="frequency (Hz)", ylabel=f"gap ({result.model.units.of('V/√Hz')})")
        legend(axes)

    return picture(draw, "Amplitude density of the gap.")


def spectrum(time: FloatArray, values: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Return frequencies and amplitude density (per √Hz), by Welch's method with Hann windows of an eighth."""
    length = min(len(values), max(256, 2 * (len(values) // 16)))
    frequencies, density = welch(values, 1.0 / np.median(np.diff(time)), nperseg=length)
    return frequencies[1:], np.sqrt(density[1:])


def _means(values: FloatArray, few: int) -> FloatArray:
    """Return the mean of every `few` values; nan if one of them is."""
    whole = values[: len(values) // few * few]
    return np.asarray(whole.reshape(-1, few).mean(axis=1))
