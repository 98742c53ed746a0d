"""The claim of Lu, Chen, Yao, Wang 2008, C3 before C2 before C1, on random cogging maps, which are not calibrated."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np
from matplotlib.figure import Figure
from scipy.stats import binomtest

from cogging._core import CoggingModel, Plant
from cogging.arrays import FloatArray
from cogging.effects import CoggingHarmonic
from cogging.papers.lu2008 import gantry
from cogging.papers.lu2008.gantry import AXES, CONTROL_POINTS, HARMONICS, GantryAxis
from cogging.papers.result import Table, explored
from cogging.plot.canvas import drawn, legend, new_figure
from cogging.plot.series import look, marker

MAPS = 8  # of each axis and kind in `reproduce`; the study draws more
#: Kinds of maps: in the spline space of C3, which can then be exact, and with a line beside each harmonic.
KINDS = ("splines", "lines beside")
BESIDE = 0.2  # largest distance of a line from its harmonic's number; C3's splines can follow it
BESIDE_SIZES = (0.2, 1.5)  # of a line over the scale of its harmonic
LEVEL = 0.06  # V, of the fundamental: about two thirds of the largest coefficient within the bounds of the X axis
#: Field of GantryAxis with the printed errors, by index.
_PRINTED = {"e_inf": "error_max", "e_2": "error_rms"}


def random_machine(axis: GantryAxis, seed: int, kind: str = KINDS[0]) -> Plant:
    """Return an axis with a random map of one of KINDS: harmonics of random strength and phase that change with x."""
    random = np.random.default_rng([2008, seed])
    strength = LEVEL * random.lognormal(0.0, 0.4, len(HARMONICS)) / np.array(HARMONICS)
    phase = random.uniform(0.0, 2.0 * np.pi, len(HARMONICS))
    depth = random.uniform(0.2, 0.8, len(HARMONICS))
    profile = 1.0 + depth[:, None] * random.uniform(-1.0, 1.0, (len(HARMONICS), CONTROL_POINTS))
    sine, cosine = ((strength * part(phase))[:, None] * profile for part in (np.cos, np.sin))
    lines, random = [], np.random.default_rng([2008, 1, seed])
    for harmonic in HARMONICS if kind == KINDS[1] else ():
        period = gantry.PITCH / (harmonic + random.uniform(-BESIDE, BESIDE))
        size, angle = LEVEL / harmonic * random.uniform(*BESIDE_SIZES), random.uniform(0.0, 2.0 * np.pi)
        lines.append(CoggingHarmonic(period=period, sine=size * np.sin(angle), cosine=size * np.cos(angle)))
    return gantry.plant(axis, CoggingModel(gantry.cogging_basis(), sine, cosine), lines)


def errors_on_maps(axis: GantryAxis, maps: int = MAPS, kind: str = KINDS[0]) -> dict[str, FloatArray]:
    """Return e_inf and e_2 (m) of C1, C2, C3 over the last move on random maps, (maps, 3) each."""
    found = gantry.last_errors(axis, [random_machine(axis, seed, kind) for seed in range(maps)])
    return {"e_inf": found[..., 0], "e_2": found[..., 1]}


def orders(errors: FloatArray) -> dict[str, int]:
    """Return on how many maps C3 beats C2, C2 beats C1, and both, of the errors of C1, C2, C3, (maps, 3)."""
    c1, c2, c3 = errors.T
    claims = {"C3 < C2": c3 < c2, "C2 < C1": c2 < c1, "C3 < C2 < C1": (c3 < c2) & (c2 < c1)}
    return {claim: int(np.count_nonzero(holds)) for claim, holds in claims.items()}


def claim_table(errors: Mapping[str, Mapping[str, Mapping[str, FloatArray]]]) -> Table:
    """Tabulate the share of maps on which each part of the claim holds, and on which C3 / C2 is below the paper's."""
    rows = []
    for kind, by_axis in errors.items():
        for axis, by_index in by_axis.items():
            for index, found in by_index.items():
                _, second, third = getattr(AXES[axis], _PRINTED[index])
                below = int(np.count_nonzero(found[:, 2] / found[:, 1] < third / second))
                for claim, hits in {**orders(found), f"C3 / C2 < {third / second:.2f}": below}.items():
                    interval = binomtest(hits, len(found)).proportion_ci(0.95, method="wilson")
                    labels = {"map": kind, "axis": axis, "by": index, "ci95": "{:.2f} to {:.2f}".format(*interval)}
                    labels["maps"] = str(len(found))
                    rows.append(explored(claim, "share", "1", hits / len(found), **labels))
    return Table("claim", "Share of random cogging maps on which a controller is better", rows)


@drawn
def figure_claim(errors: Mapping[str, Mapping[str, FloatArray]]) -> Figure:
    """Draw C2 / C1 and C3 / C2 of errors_on_maps, by axis, beside the paper's own machine."""
    figure = new_figure((8.0, 3.8))
    panels = figure.subplots(1, 2, sharey=True)
    largest = 1.0
    for axes, index in zip(panels, _PRINTED, strict=True):
        names: list[str] = []
        for name, by_index in errors.items():
            c1, c2, c3 = by_index[index].T
            p1, p2, p3 = getattr(AXES[name], _PRINTED[index])
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
    legend(panels[-1], 2)
    figure.suptitle("C3 before C2 before C1 on random cogging maps with lines beside the harmonics")
    return figure
