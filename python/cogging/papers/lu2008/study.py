"""What the setup of Lu et al. 2008 lacks, and how far its claim reaches: `python -m cogging.papers.lu2008.study`.

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
    SplineHarmonics,
    cogging_slope_max,
    desired_compensation_condition,
    friction_slope_max,
)
from cogging.arrays import FloatArray
from cogging.papers.lu2008.calibration import calibrate
from cogging.papers.lu2008.setup import (
    AXES,
    CONTROL_POINTS,
    CONTROLLERS,
    COULOMB_WIDTH,
    HARMONICS,
    ORDER,
    PITCH,
    RESOLUTION,
    TRAVEL,
    GantryAxis,
    cogging_basis,
    cogging_map,
    controller_parameters,
    indexes,
    last_errors,
    last_rms,
    plant,
    reference,
    run,
    share_of_bound,
    shipped_amplitudes,
    shipped_shape,
)
from cogging.papers.lu2008.shapes import FIRST_SHAPE, MapShape
from cogging_command import run_command

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


def random_map(seed: int, level: float) -> CoggingModel:
    """A random cogging map: harmonics of random strength and phase, each changing at random along the travel.

    Args:
        seed: of the map.
        level: V, scale of the fundamental; harmonic h is smaller by h on average.
    """
    random = np.random.default_rng([2008, seed])
    strength = level * random.lognormal(0.0, 0.4, len(HARMONICS)) / np.array(HARMONICS)
    phase = random.uniform(0.0, 2.0 * np.pi, len(HARMONICS))
    depth = random.uniform(0.2, 0.8, len(HARMONICS))
    profile = 1.0 + depth[:, None] * random.uniform(-1.0, 1.0, (len(HARMONICS), CONTROL_POINTS))
    sine = (strength * np.cos(phase))[:, None] * profile
    cosine = (strength * np.sin(phase))[:, None] * profile
    return CoggingModel(cogging_basis(), sine, cosine)


def claim_shares(axis: GantryAxis, maps: int = 40, level: float = 0.06) -> tuple[float, float, float]:
    """Shares of random maps on which, by rms, C3 beats C2, C2 beats C1, and both."""
    c1, c2, c3 = last_rms(axis, [plant(axis, random_map(seed, level)) for seed in range(maps)]).T
    third, second, both = np.mean([c3 < c2, c2 < c1, (c3 < c2) & (c2 < c1)], axis=1)
    return float(third), float(second), float(both)


def step_halving(axis: GantryAxis) -> tuple[float, float]:
    """What halving the integration step changes: largest relative change of an rms, of a maximum in counts."""
    machine, motion = plant(axis, cogging_map(axis, shipped_amplitudes(axis))), reference(axis)
    one, two = (run(axis, machine, motion, steps_per_sample=steps) for steps in (1, 2))
    found = np.array([[indexes(logs[name], motion) for name in CONTROLLERS] for logs in (one, two)])
    change = np.abs(found[1] - found[0])
    return float((change[:, 1] / found[0][:, 1]).max()), float(change[:, 0].max() / RESOLUTION)


def matrix_condition(axis: GantryAxis, friction_slope: float, share: float = 1.0) -> tuple[float, float]:
    """Smallest eigenvalue of (29) and the decay rate (1/s) with the printed gains of C3.

    Args:
        axis: the axis.
        friction_slope: the largest g_f, 1/(m/s).
        share: of the largest |theta_4b^T g_r| that the printed bounds allow.
    """
    parameters = controller_parameters(axis, "C3")
    slope = share * cogging_slope_max(_controller_basis(axis), axis.cogging_bound)
    return desired_compensation_condition(parameters, friction_slope=friction_slope, cogging_slope=slope)


def _controller_basis(axis: GantryAxis) -> SplineHarmonics:
    return SplineHarmonics(
        pitch=PITCH,
        harmonics=list(axis.compensated),
        order=ORDER,
        origin=TRAVEL[0],
        control_points=CONTROL_POINTS,
    )


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
        third, second, both = claim_shares(axis)
        show(f"{'':4}40 random maps, by rms: C3 < C2 on {third:.0%}, C2 < C1 on {second:.0%}, both on {both:.0%}")
        rms_change, counts = step_halving(axis)
        show(f"{'':4}half the integration step: rms changes by {rms_change:.2%} at most, maxima by {counts:.2f} counts")
        steep = friction_slope_max(COULOMB_WIDTH)
        for name, slope, share in (("friction and cogging slopes", steep, 1.0), ("no friction slope", 0.0, 0.05)):
            eigenvalue, rate = matrix_condition(axis, slope, share)
            show(f"{'':4}matrix (29), {name}: smallest eigenvalue {eigenvalue:.4g}, decay rate {rate:.4g} 1/s")


if __name__ == "__main__":
    sys.exit(run_command(main))
