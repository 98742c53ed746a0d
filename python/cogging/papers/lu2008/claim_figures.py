"""Figures of what Lu, Chen, Yao, Wang 2008 say and do not draw: the FFT, the claim on other maps, Theorem 1."""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING

import numpy as np

from cogging._core import Arc, Dcarc
from cogging.arrays import FloatArray
from cogging.mapping.map_fit import MapFit
from cogging.papers.lu2008.condition import sufficient_gains
from cogging.papers.lu2008.harmonics import HIGHEST, chosen
from cogging.papers.lu2008.setup import AXES, HARMONICS, GantryAxis
from cogging.papers.lu2008.theorem import Law, draw
from cogging.plot.canvas import drawn, legend, new_figure
from cogging.plot.characteristics import spectrum
from cogging.plot.scales import scale_of
from cogging.plot.series import LIMIT, look, marker

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

SHOWN = 24  # the machine of Theorem 1 A that is drawn: one that breaks both bounds without u_s2
SHOWN_FOR = 0.12  # s of it
LEGEND_COLUMNS = 2
BESIDE = 0.3  # harmonics: how far the lines of one that is modulated along the travel are looked for


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


@drawn
def figure_claim(errors: Mapping[str, Mapping[str, FloatArray]]) -> Figure:
    """How much better C2 is than C1, and C3 than C2, on each random map, beside the paper's own machine.

    Args:
        errors: of each axis by name, as errors_on_maps gives them.
    """
    figure = new_figure((8.0, 3.8))
    panels = figure.subplots(1, 2, sharey=True)
    printed = {"e_inf": "error_max", "e_2": "error_rms"}
    largest = 1.0
    for axes, index in zip(panels, printed, strict=True):
        names: list[str] = []
        for name, by_index in errors.items():
            c1, c2, c3 = by_index[index].T
            p1, p2, p3 = getattr(AXES[name], printed[index])
            for said, ratio, paper in ((f"{name}: C2 / C1", c2 / c1, p2 / p1), (f"{name}: C3 / C2", c3 / c2, p3 / p2)):
                place = len(names) + 0.25 * (np.linspace(-1.0, 1.0, len(ratio)) if len(ratio) > 1 else np.zeros(1))
                first = not names
                axes.plot(place, ratio, marker(0), **{**look(0), "linestyle": "none"}, label="map" if first else None)
                mark = {**look(4), "linestyle": "none", "markersize": 9}
                axes.plot(len(names), paper, marker(3), **mark, label="paper's tables" if first else None)
                names.append(said)
                largest = max(largest, float(ratio.max()), paper)
        axes.axhline(1.0, color="black", linewidth=1.0)
        axes.set_xticks(range(len(names)), names, rotation=20)
        axes.set_title("maximum" if index == "e_inf" else "rms", loc="left")
        axes.set_ylim(0.0, 1.08 * largest)
    panels[0].set_ylabel("ratio of errors, below 1: better")
    legend(panels[-1], LEGEND_COLUMNS)
    figure.suptitle("C3 before C2 before C1 on random cogging maps with lines beside the harmonics")
    return figure


@drawn
def figure_theorem(decays: Mapping[str, Mapping[str, FloatArray]]) -> Figure:
    """Theorem 1: above V with u_s2 on and off and its bound, of ARC and DCARC; below the error of each period.

    Args:
        decays: of each axis by name, as theorem_b.decays gives them.
    """
    figure = new_figure((8.4, 6.6))
    panels = figure.subplots(2, 2)
    axis = AXES["X"]
    _draw_bound(panels[0][0], axis, Arc, {}, "A, ARC, printed gains")
    _draw_bound(panels[0][1], axis, Dcarc, sufficient_gains(axis), "A, DCARC, sufficient gains")
    for axes, (name, found) in zip(panels[1], decays.items(), strict=True):
        scale = scale_of("m", *found.values())
        for place, (case, errors) in enumerate(found.items()):
            axes.plot(1 + np.arange(len(errors)), scale(errors), label=case, marker=marker(place), **look(place))
        axes.set_yscale("log")
        axes.set(xlabel="move there and back", ylabel=scale.label("rms error"))
        axes.set_title(f"B, {name} axis", loc="left", pad=36.0)
        axes.xaxis.get_major_locator().set_params(integer=True)
        _label_decades(axes)
        legend(axes, LEGEND_COLUMNS)
    figure.suptitle("Theorem 1: V and its bound (X axis, one drawn machine), and the error without d~")
    return figure


def _draw_bound(axes: Axes, axis: GantryAxis, law: Law, gains: dict[str, float], said: str) -> None:
    trial = draw(axis, SHOWN, law, **gains)
    on, off = trial.run(), trial.run(epsilon=0.0)
    shown = on.time <= SHOWN_FOR
    time = 1e3 * on.time[shown]
    curves = {
        "u_s2 on": trial.lyapunov(on),
        "u_s2 off": trial.lyapunov(off),
        "bound (23)": trial.bound(on, float(trial.lyapunov(on)[0])),
    }
    looks = (look(0), look(2), {"color": LIMIT, "linestyle": (0, (6, 3)), "linewidth": 2.0})
    for (name, values), style in zip(curves.items(), looks, strict=True):
        axes.plot(time, values[shown], label=name, **style)
    axes.set_yscale("log")
    axes.set_ylim(1e-4 * float(curves["bound (23)"][shown].max()), None)
    axes.set(xlabel="time (ms)", ylabel="V (V m)")
    axes.set_title(said, loc="left", pad=22.0)
    legend(axes, 3)


def _label_decades(axes: Axes) -> None:
    from matplotlib.ticker import FuncFormatter, LogLocator

    axes.yaxis.set_major_locator(LogLocator(subs=(1.0, 2.0, 5.0)))
    axes.yaxis.set_major_formatter(FuncFormatter(lambda value, _: f"{value:g}"))
    axes.yaxis.set_minor_formatter(FuncFormatter(lambda value, _: ""))
