"""Calibrates the cogging maps of Lu et al. 2008: `python -m cogging.papers.lu2008.calibration [FILE]`.

The paper prints no map. For each axis three amplitudes (periodic, modulated, uncompensated part; see
setup.cogging_map) are found so that the rms errors of C1, C2 and C3 are those of the table. Nothing is fitted to the
maxima. The result is what comes with the package as maps.toml, bit for bit.
"""

from __future__ import annotations

import sys
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np

from cogging._core import CoggingModel, Plant, PointToPoint
from cogging.arrays import FloatArray
from cogging.outputs import to_toml, write_text
from cogging.papers.fitting import fit_logarithms, round_to_digits
from cogging.papers.lu2008.setup import (
    AXES,
    Amplitudes,
    GantryAxis,
    cogging_map,
    last_rms,
    plant,
)
from cogging_command import run_command

START = (0.09, 0.06, 0.05)  # V: where the search begins, for both axes
TOLERANCE = 0.002  # of the largest log-ratio of the three rms values


def rms_errors(
    axis: GantryAxis,
    amplitudes: Amplitudes,
    *,
    motion: PointToPoint | None = None,
    machine: Callable[[CoggingModel], Plant] | None = None,
    **controller_changes: Any,
) -> FloatArray:
    """The rms errors (m) of C1, C2, C3, (3,); motion and machine are the paper's unless given."""
    cogging = cogging_map(axis, amplitudes)
    truth = machine(cogging) if machine else plant(axis, cogging)
    return np.asarray(last_rms(axis, [truth], motion, **controller_changes)[0])


def calibrate(axis: GantryAxis, **setup: Any) -> Amplitudes:
    """Find the amplitudes (V) whose rms errors are the table's; `setup` goes to rms_errors.

    Differences are of 10 %, because the quantiser makes the rms values rough on a smaller scale; so are the results
    only as exact as that roughness, about 0.1 %.
    """

    def rounded(values: FloatArray) -> Amplitudes:
        periodic, modulated, uncompensated = (round_to_digits(value) for value in values)
        return periodic, modulated, uncompensated

    def gap(values: FloatArray) -> FloatArray:
        return np.log(rms_errors(axis, rounded(values), **setup) / axis.error_rms)

    return rounded(fit_logarithms(gap, np.array(START), step=0.1, tolerance=TOLERANCE)[0])


def maps_toml() -> str:
    """The text of maps.toml."""
    names = ("periodic", "modulated", "uncompensated")
    document = {axis.name: dict(zip(names, calibrate(axis), strict=True)) for axis in AXES.values()}
    head = "# Amplitudes (V) of the assumed cogging maps, written by cogging.papers.lu2008.calibration.\n"
    return head + to_toml(document)


def main(target: str) -> None:
    """Calibrate and write the file."""
    write_text(target, maps_toml())
    print(f"{target} written")


if __name__ == "__main__":
    own = str(Path(__file__).with_name("maps.toml"))
    sys.exit(run_command(lambda: main(sys.argv[1] if len(sys.argv) > 1 else own)))
