"""Calibrates the cogging maps of Lu et al. 2008: `python -m cogging.papers.lu2008_calibration [FILE]`.

The paper prints no map. For each axis three amplitudes (periodic, modulated, uncompensated part; see
lu2008.cogging_map) are found so that the rms errors of C1, C2 and C3 are those of the table. Nothing is fitted to the
maxima. The result is what comes with the package as lu2008_maps.toml, bit for bit.
"""

from __future__ import annotations

import sys
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt

from cogging._core import CoggingModel, Plant, PointToPoint
from cogging.files import to_toml, write_text
from cogging.papers.lu2008 import (
    AXES,
    CONTROLLERS,
    Amplitudes,
    GantryAxis,
    cogging_map,
    indexes,
    plant,
    reference,
    run,
)

START = (0.09, 0.06, 0.05)  # V: where the search begins, for both axes
TOLERANCE = 0.002  # of the largest log-ratio of the three rms values
DIGITS = 4  # significant digits that are kept: 0.01 % of an amplitude moves an rms by less


def rms_errors(
    axis: GantryAxis,
    amplitudes: Amplitudes,
    *,
    motion: PointToPoint | None = None,
    machine: Callable[[CoggingModel], Plant] | None = None,
    **controller_changes: Any,
) -> npt.NDArray[np.float64]:
    """The rms errors (m) of C1, C2, C3, (3,); motion and machine are the paper's unless given."""
    motion = motion or reference(axis)
    cogging = cogging_map(axis, amplitudes)
    truth = machine(cogging) if machine else plant(axis, cogging)
    logs = run(axis, truth, motion, **controller_changes)
    return np.array([indexes(logs[name], motion)[1] for name in CONTROLLERS])


def calibrate(axis: GantryAxis, **setup: Any) -> Amplitudes:
    """Find the amplitudes (V) by damped Newton steps on the logarithms; `setup` goes to rms_errors.

    Steps are of 10 %, because the quantiser makes the rms values rough on a smaller scale; so are the results only
    as exact as that roughness, about 0.1 %.
    """

    def gap(logs: npt.NDArray[np.float64]) -> npt.NDArray[np.float64]:
        return np.log(rms_errors(axis, _amplitudes(logs), **setup) / axis.error_rms)

    x = np.log(START)
    y = gap(x)
    for _ in range(12):
        if np.abs(y).max() < TOLERANCE:
            break
        jacobian = np.column_stack([(gap(x + step) - y) / 0.1 for step in 0.1 * np.eye(3)])
        normal = jacobian.T @ jacobian + 1e-3 * np.eye(3)
        step = np.clip(np.linalg.solve(normal, -jacobian.T @ y), -0.7, 0.7)
        for fraction in (1.0, 0.5, 0.25, 0.125):
            candidate = gap(x + fraction * step)
            if np.abs(candidate).max() < np.abs(y).max():
                x, y = x + fraction * step, candidate
                break
        else:
            break
    return _amplitudes(x)


def _amplitudes(logs: npt.NDArray[np.float64]) -> Amplitudes:
    periodic, modulated, uncompensated = (float(f"{value:.{DIGITS}g}") for value in np.exp(logs))
    return periodic, modulated, uncompensated


def maps_toml() -> str:
    """The text of lu2008_maps.toml."""
    names = ("periodic", "modulated", "uncompensated")
    document = {axis.name: dict(zip(names, calibrate(axis), strict=True)) for axis in AXES.values()}
    head = "# Amplitudes (V) of the assumed cogging maps, written by cogging.papers.lu2008_calibration.\n"
    return head + to_toml(document)


if __name__ == "__main__":
    target = sys.argv[1] if len(sys.argv) > 1 else str(Path(__file__).with_name("lu2008_maps.toml"))
    write_text(target, maps_toml())
    print(f"{target} written")
