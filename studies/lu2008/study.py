"""What the setup of Lu et al. 2008 lacks, and how far its claim reaches: `python -m studies.lu2008.study`.

Prints four things: what each assumption about the unreported setup does to the twelve numbers on the shipped maps, the
share of random cogging maps on which C3 beats C2 beats C1, what halving the integration step changes, and the smallest
eigenvalue of the matrix (29) with the printed gains.
"""

from __future__ import annotations

import sys
from collections.abc import Callable, Iterator
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from cogging._core import EncoderParameters, Plant, friction_slope_max
from cogging.arrays import FloatArray
from cogging.papers.lu2008 import gantry
from cogging.papers.lu2008.theorem_1 import matrix_condition
from cogging.papers.lu2008.tracking import KINDS, claim_table, errors_on_maps
from studies.command import run_study

MANY_MAPS = 40  # an axis and kind


@dataclass(frozen=True)
class Variation:
    """One assumption changed: of the motion, the plant, the controller, the encoder's noise (m rms)."""

    name: str
    motion: dict[str, Any] = field(default_factory=dict)
    axis: dict[str, Any] = field(default_factory=dict)
    controller: dict[str, Any] = field(default_factory=dict)
    encoder_noise: float = 0.0


def variations(axis: gantry.GantryAxis) -> Iterator[Variation]:
    """The assumptions that were tried."""
    yield Variation("as shipped")
    yield Variation("e' of the reading minus v_d", controller={"error_difference": False})
    for dwell in (0.0, 0.05, 0.3):
        yield Variation(f"dwell {dwell:g} s", motion={"dwell": dwell})
    for factor in (0.3, 3.0):
        yield Variation(f"jerk times {factor:g}", motion={"jerk": factor * axis.jerk})
    for factor in (0.5, 2.0):
        repeats = round(factor * axis.repeats)
        yield Variation(f"index over move {repeats}", motion={"repeats": repeats})
    for slope in (5000, 300):
        yield Variation(f"plant friction {slope} v", axis={"coulomb_width": 1 / slope})
    bounds = ("mass", "viscous", "coulomb")
    for end, name in ((0, "lower"), (1, "upper")):
        start = {key: bound[end] for key, bound in zip(bounds, axis.bounds, strict=False)}
        yield Variation(f"estimates start at {name} bounds", controller=start)
    yield Variation("C2: the fundamental alone", controller={"periodic": (1,)})
    yield Variation("encoder noise 0.5 um rms", encoder_noise=0.5e-6)


def vary(axis: gantry.GantryAxis, variation: Variation) -> FloatArray:
    """Ratios simulated / paper of e_inf and e_2 of C1, C2, C3 on the shipped map, (3, 2)."""
    exact = gantry.plant(axis, gantry.cogging_map(axis, gantry.shipped_amplitudes(axis)), **variation.axis)
    encoder = EncoderParameters(resolution=gantry.RESOLUTION, noise=variation.encoder_noise)
    machine = Plant(exact.axis, cogging=exact.cogging, encoder=encoder)
    motion = gantry.reference(axis, **variation.motion)
    found = gantry.last_errors(axis, [machine], motion, **variation.controller)[0]
    return np.asarray(found / np.array([axis.error_max, axis.error_rms]).T)


def step_halving(axis: gantry.GantryAxis) -> tuple[float, float]:
    """What halving the integration step changes: largest relative change of an rms, of a maximum in counts."""
    cogging, motion = gantry.cogging_map(axis, gantry.shipped_amplitudes(axis)), gantry.reference(axis)
    machine = gantry.plant(axis, cogging)
    one, two = (gantry.run(axis, machine, motion, steps_per_sample=steps) for steps in (1, 2))
    found = np.array([[gantry.indexes(logs[name], motion) for name in gantry.CONTROLLERS] for logs in (one, two)])
    change = np.abs(found[1] - found[0])
    return float((change[:, 1] / found[0][:, 1]).max()), float(change[:, 0].max() / gantry.RESOLUTION)


def main(_: str = "", show: Callable[[str], None] = print) -> None:
    """Print the study."""
    for axis in gantry.AXES.values():
        show(f"{axis.name} axis: ratio simulated / paper on the shipped map")
        show(f"{'':4}{'assumption':<34}{'e_inf C1':>9}{'C2':>6}{'C3':>6}{'e_2 C1':>9}{'C2':>6}{'C3':>6}")
        for variation in variations(axis):
            maxima, rms = vary(axis, variation).T
            show(f"{'':4}{variation.name:<34}" + "{:9.2f}{:6.2f}{:6.2f}{:9.2f}{:6.2f}{:6.2f}".format(*maxima, *rms))
        errors = {kind: {axis.name: errors_on_maps(axis, MANY_MAPS, kind)} for kind in KINDS}
        show(claim_table(errors).text())
        rms_change, counts = step_halving(axis)
        show(f"{'':4}half the integration step: rms changes by {rms_change:.2%} at most, maxima by {counts:.2f} counts")
        steep = friction_slope_max(gantry.COULOMB_WIDTH)
        for name, slope, share in (("friction and cogging slopes", steep, 1.0), ("no friction slope", 0.0, 0.05)):
            eigenvalue, rate = matrix_condition(axis, slope, share)
            show(f"{'':4}matrix (29), {name}: smallest eigenvalue {eigenvalue:.4g}, decay rate {rate:.4g} 1/s")


if __name__ == "__main__":
    sys.exit(run_study(__doc__, main))
