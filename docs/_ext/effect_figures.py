"""The small figure of an effect: what a model without it leaves, against the coordinate that separates it best."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from coordinates import BINS, PLACES, folded
from effect_signatures import SEPARATES, Signature

from cogging.arrays import FloatArray

if TYPE_CHECKING:
    from matplotlib.figure import Figure

#: Colours of text and frame, of the two directions, and of the second curve, by scheme.
SCHEMES = {
    "light": {"ink": "#3b3f45", "forward": "#1f5fa8", "backward": "#c2571a", "frame": "#b9bec6"},
    "dark": {"ink": "#d3d7de", "forward": "#6cb2f2", "backward": "#f0a05f", "frame": "#5a616b"},
}
POINTS = 300  # rows that are drawn as points
CLOSE = (0.05, 0.5)  # s: shortest and longest close-up
CROSSINGS = 16  # of zero, in a close-up


def save(signature: Signature, folder: Path) -> dict[str, Path]:
    """Both figures of an effect, as SVG that is the same from run to run, by scheme."""
    import matplotlib as mpl

    made = {}
    with mpl.rc_context({"svg.hashsalt": "cogging", "svg.fonttype": "path", "font.size": 9}):
        for scheme in SCHEMES:
            made[scheme] = folder / f"{signature.effect.NAME}_{scheme}.svg"
            draw(signature, scheme).savefig(made[scheme], transparent=True, metadata={"Date": None})
    return made


def draw(signature: Signature, scheme: str) -> Figure:
    """The figure in the colours of a scheme."""
    from matplotlib.figure import Figure

    colours = SCHEMES[scheme]
    figure = Figure(figsize=(4.6, 2.6), layout="constrained")
    if signature.place.explained < SEPARATES:
        panels = figure.subplots(2, 1, sharex=True, height_ratios=(2, 1))
        _close_up(panels, signature, colours)
    else:
        panels = [figure.subplots()]
        _profile(panels[0], signature, colours)
    for panel in panels:
        panel.tick_params(colors=colours["ink"], which="both")
        for spine in panel.spines.values():
            spine.set_edgecolor(colours["frame"])
        for label in (panel.xaxis.label, panel.yaxis.label):
            label.set_color(colours["ink"])
        panel.spines[["top", "right"]].set_visible(False)
    return figure


def values_of(signature: Signature) -> FloatArray:
    """The coordinate of a signature, in its rows."""
    return {**signature.rows, **folded(signature.effect, signature.rows)}[signature.place.name]


def profile(signature: Signature) -> dict[str, tuple[FloatArray, FloatArray]]:
    """Places and mean residual (V) in even bins, by direction where the coordinate is the position."""
    values, place = values_of(signature), signature.place.name
    velocity = signature.rows["velocity"]
    ways = (
        {"forward": velocity > 0.0, "backward": velocity < 0.0} if place == "position" else {"": velocity == velocity}
    )
    count = PLACES if place == "position" else BINS
    edges = np.linspace(float(values.min()), float(values.max()), count + 1)
    curves = {}
    for way, kept in ways.items():
        bins = np.clip(np.searchsorted(edges, values[kept], side="right") - 1, 0, count - 1)
        rows = np.bincount(bins, minlength=count)
        seen = rows > 0
        means = np.bincount(bins, signature.residual[kept], count)[seen] / rows[seen]
        curves[way] = 0.5 * (edges[1:] + edges[:-1])[seen], means
    return curves


def _profile(panel: Any, signature: Signature, colours: dict[str, str]) -> None:
    """The rows as points and their means as lines, each direction by itself where there are two."""
    values, name = values_of(signature), signature.place.name
    panel.axhline(0.0, color=colours["frame"], linewidth=0.8)
    step = max(1, len(values) // POINTS)
    forward = signature.rows["velocity"] > 0.0
    for way, (places, means) in profile(signature).items():
        colour = colours[way or "forward"]
        kept = forward if way == "forward" else ~forward if way == "backward" else np.ones(len(values), dtype=bool)
        panel.plot(values[kept][::step], signature.residual[kept][::step], ".", color=colour, markersize=2, alpha=0.35)
        style = "--" if way == "backward" else "-"
        panel.plot(places, means, style, color=colour, linewidth=1.6, label=f"moving {way}")
    if name == "position":
        panel.legend(fontsize=8, frameon=False, labelcolor=colours["ink"])
    panel.set(xlabel=f"{name} ({signature.place.unit})", ylabel="unexplained (V)")


def _close_up(panels: Any, signature: Signature, colours: dict[str, str]) -> None:
    """Some swings about the largest value, and the command below it."""
    time, residual = signature.rows["time"], signature.residual
    middle = float(time[np.argmax(np.abs(residual))])
    turned = np.flatnonzero(residual[1:] * residual[:-1] < 0.0)
    width = CROSSINGS * float(np.median(np.diff(time[turned]))) if len(turned) > CROSSINGS else CLOSE[1]
    kept = np.abs(time - middle) <= 0.5 * min(max(width, CLOSE[0]), CLOSE[1])
    t, whole = time[kept], np.diff(time[kept], prepend=time[kept][0]) < 0.01  # a rest parts the curve
    for panel, values, colour, label in (
        (panels[0], residual[kept], colours["forward"], "unexplained (V)"),
        (panels[1], signature.rows["command"][kept], colours["backward"], "command (V)"),
    ):
        panel.axhline(0.0, color=colours["frame"], linewidth=0.8)
        panel.plot(t, np.where(whole, values, np.nan), color=colour, linewidth=1.2)
        panel.set_ylabel(label)
    panels[1].set_xlabel("time (s), close up")
