"""What the setup of Lu et al. 2008 lacks, and how far its claim reaches: `python -m studies.lu2008.study`.

Prints four things: what each assumption about the unreported setup, the shape of the map first, does to the maxima
(amplitudes calibrated anew on the rms values each time), the share of random cogging maps on which C3 beats C2 beats
C1, what halving the integration step changes, and the smallest eigenvalue of the matrix (29) with the printed gains.
"""

from __future__ import annotations

import sys
from collections.abc import Callable, Iterator
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from cogging._core import (
    CoggingModel,
    EncoderParameters,
    Plant,
    friction_slope_max,
)
from cogging.arrays import FloatArray
from cogging.papers.lu2008.claims import claim_table, errors_on_maps
from cogging.papers.lu2008.condition import matrix_condition
from cogging.papers.lu2008.setup import (
    AXES,
    CONTROLLERS,
    COULOMB_WIDTH,
    RESOLUTION,
    GantryAxis,
    cogging_map,
    indexes,
    last_errors,
    plant,
    reference,
    run,
    share_of_bound,
    shipped_amplitudes,
    shipped_shape,
)
from cogging.papers.lu2008.shapes import FIRST_SHAPE, MapShape
from cogging_command import run_command
from studies.lu2008.calibration import calibrate

MANY_MAPS = 200  # an axis
#: Values of the shape that are tried, each alone.
SHAPES = {
    "decay": (1.0, 1.25, 1.75, 2.0),
    "half_waves": (1.0, 2.0, 3.0),
    "begin": (0.0, np.pi / 2, 3 * np.pi / 2),
    "shift": (0.0, 1 / 16, 1 / 4),
}


@dataclass(frozen=True)
class Variation:
    """One assumption changed: of the motion, the plant, the encoder, the controller or the map (None: as shipped)."""

    name: str
    motion: dict[str, Any]
    axis: dict[str, Any]
    controller: dict[str, Any]
    encoder_noise: float = 0.0
    shape: MapShape | None = None


def variations(axis: GantryAxis) -> Iterator[Variation]:
    """The assumptions that were tried."""
    for dwell in (0.0, 0.05, 0.3):
        yield Variation(f"dwell {dwell:g} s", {"dwell": dwell}, {}, {})
    for factor in (0.3, 3.0):
        yield Variation(f"jerk times {factor:g}", {"jerk": factor * axis.jerk}, {}, {})
    for factor in (0.5, 2.0):
        repeats = round(factor * axis.repeats)
        yield Variation(f"index over move {repeats}", {"repeats": repeats}, {}, {})
    yield Variation("plant friction 5000 v", {}, {"coulomb_width": 1 / 5000}, {})
    yield Variation("plant friction 300 v", {}, {"coulomb_width": 1 / 300}, {})
    bounds = ("mass", "viscous", "coulomb")
    for end, name in ((0, "lower"), (1, "upper")):
        start = {key: bound[end] for key, bound in zip(bounds, axis.bounds, strict=False)}
        yield Variation(f"estimates start at {name} bounds", {}, {}, start)
    yield Variation("encoder noise 0.5 um rms", {}, {}, {}, encoder_noise=0.5e-6)


def shape_variations() -> Iterator[Variation]:
    """Shapes of the map that were tried, and other harmonics of C2."""
    shipped = shipped_shape()
    yield Variation("shape as shipped", {}, {}, {})
    yield Variation("shape as assumed at first", {}, {}, {}, shape=FIRST_SHAPE)
    for name, values in SHAPES.items():
        for value in values:
            yield Variation(f"{name} {value:.3g}", {}, {}, {}, shape=replace(shipped, **{name: value}))
    yield Variation("C2: the fundamental alone", {}, {}, {"periodic": (1,)})
    both = {"periodic": (1,)}
    yield Variation("C2: the fundamental alone, decay 2", {}, {}, both, shape=replace(shipped, decay=2.0))


def vary(axis: GantryAxis, variation: Variation) -> tuple[FloatArray, FloatArray, float]:
    """Ratios simulated / paper of the three maxima and the three rms values, amplitudes calibrated anew on the latter.

    The third is the largest control point of the map that C3 compensates, as a share of the printed bound.
    """
    motion = reference(axis, **variation.motion)

    def machine(cogging: CoggingModel) -> Plant:
        exact = plant(axis, cogging, **variation.axis)
        encoder = EncoderParameters(resolution=RESOLUTION, noise=variation.encoder_noise)
        return Plant(exact.axis, cogging=cogging, encoder=encoder)

    amplitudes = calibrate(axis, shape=variation.shape, motion=motion, machine=machine, **variation.controller)
    cogging = cogging_map(axis, amplitudes, variation.shape)
    found = last_errors(axis, [machine(cogging)], motion, **variation.controller)[0]
    return found[:, 0] / axis.error_max, found[:, 1] / axis.error_rms, share_of_bound(axis, cogging)


def step_halving(axis: GantryAxis) -> tuple[float, float]:
    """What halving the integration step changes: largest relative change of an rms, of a maximum in counts."""
    machine, motion = plant(axis, cogging_map(axis, shipped_amplitudes(axis))), reference(axis)
    one, two = (run(axis, machine, motion, steps_per_sample=steps) for steps in (1, 2))
    found = np.array([[indexes(logs[name], motion) for name in CONTROLLERS] for logs in (one, two)])
    change = np.abs(found[1] - found[0])
    return float((change[:, 1] / found[0][:, 1]).max()), float(change[:, 0].max() / RESOLUTION)


def main(show: Callable[[str], None] = print) -> None:
    """Print the study."""
    for axis in AXES.values():
        show(f"{axis.name} axis: ratio simulated / paper, amplitudes calibrated anew for each row")
        show(
            f"{'':4}{'assumption':<34}{'e_inf C1':>9}{'C2':>6}{'C3':>6}{'e_2 C1':>9}{'C2':>7}{'C3':>7}{'of bound':>12}"
        )
        for variation in (*shape_variations(), *variations(axis)):
            maxima, rms, share = vary(axis, variation)
            numbers = "{:9.2f}{:6.2f}{:6.2f}".format(*maxima) + "{:9.3f}{:7.3f}{:7.3f}".format(*rms)
            show(f"{'':4}{variation.name:<34}{numbers}{share:12.2f}")
        show(claim_table({axis.name: errors_on_maps(axis, MANY_MAPS)}).text())
        rms_change, counts = step_halving(axis)
        show(f"{'':4}half the integration step: rms changes by {rms_change:.2%} at most, maxima by {counts:.2f} counts")
        steep = friction_slope_max(COULOMB_WIDTH)
        for name, slope, share in (("friction and cogging slopes", steep, 1.0), ("no friction slope", 0.0, 0.05)):
            eigenvalue, rate = matrix_condition(axis, slope, share)
            show(f"{'':4}matrix (29), {name}: smallest eigenvalue {eigenvalue:.4g}, decay rate {rate:.4g} 1/s")


if __name__ == "__main__":
    sys.exit(run_command(main))
