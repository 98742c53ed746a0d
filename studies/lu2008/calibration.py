"""Calibrates the cogging maps of Lu et al. 2008: `python -m studies.lu2008.calibration [FILE]`.

The paper prints no map. Five sets of conditions are found, which come with the package as maps.toml, bit for bit:

- first: an assumed shape; for each axis three amplitudes (periodic, modulated, uncompensated part; see
  shapes.MapShape) so that the rms errors of C1, C2 and C3 are those of the table. Nothing is fitted to the maxima.
- present: one shape for both axes and three amplitudes for each, fitted to all twelve numbers within the printed bound
  of A_r (search.py).
- from_table1, from_table2: shape and amplitudes fitted to all six numbers of one table, then the amplitudes of the
  other axis to its three rms values: the maxima of the other axis took no part.
- without_c3: as present, fitted to the eight numbers of C1 and C2 alone.
"""

from __future__ import annotations

import sys
from collections.abc import Callable, Mapping, Sequence
from dataclasses import asdict
from pathlib import Path
from typing import Any

import numpy as np

import cogging.papers.lu2008
from cogging._core import CoggingModel, Plant, PointToPoint
from cogging.arrays import FloatArray
from cogging.outputs import to_toml, write_text
from cogging.papers.fitting import fit_logarithms, round_to_digits
from cogging.papers.lu2008.setup import (
    AXES,
    FIRST,
    PRESENT,
    WITHOUT_C3,
    GantryAxis,
    cogging_map,
    last_rms,
    plant,
)
from cogging.papers.lu2008.shapes import FIRST_SHAPE, Amplitudes, MapShape
from cogging_command import run_command
from studies.lu2008.search import Fit, Responses, search

START = (0.09, 0.06, 0.05)  # V: where the search begins, for both axes
TOLERANCE = 0.002  # of the largest log-ratio of the three rms values


def rms_errors(
    axis: GantryAxis,
    amplitudes: Amplitudes,
    *,
    shape: MapShape | None = None,
    motion: PointToPoint | None = None,
    machine: Callable[[CoggingModel], Plant] | None = None,
    **controller_changes: Any,
) -> FloatArray:
    """The rms errors (m) of C1, C2, C3, (3,); shape, motion and machine are those of the tables unless given."""
    cogging = cogging_map(axis, amplitudes, shape)
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


#: Sections of maps.toml whose shape was fitted to one table alone, and that table's axis.
HELD_OUT = {"from_table1": "X", "from_table2": "Y"}
EVERY = {"X": 2, "Y": 8}  # sample of those that the search looks at


def _section(shape: MapShape, amplitudes: Mapping[str, Amplitudes]) -> dict[str, Any]:
    names = ("periodic", "modulated", "uncompensated")
    return {"shape": asdict(shape)} | {name: dict(zip(names, amplitudes[name], strict=True)) for name in AXES}


def first_section() -> dict[str, Any]:
    """The conditions assumed at first."""
    return _section(FIRST_SHAPE, {name: calibrate(axis, shape=FIRST_SHAPE) for name, axis in AXES.items()})


def both_section(responses: Sequence[Responses], controllers: int = 3) -> dict[str, Any]:
    """A shape and amplitudes fitted to the numbers of so many controllers, from C1 on, in both tables."""
    fit = search(list(AXES.values()), responses, controllers)
    return _section(fit.shape, {name: fit.amplitudes(i) for i, name in enumerate(AXES)})


def held_out_section(fit: Fit, fitted: str) -> dict[str, Any]:
    """A shape fitted to one axis, and the other axis with it."""
    amplitudes = {
        name: fit.amplitudes(0) if name == fitted else calibrate(axis, shape=fit.shape) for name, axis in AXES.items()
    }
    return _section(fit.shape, amplitudes)


def maps_toml() -> str:
    """The text of maps.toml."""
    responses = {name: Responses(axis, EVERY[name]) for name, axis in AXES.items()}
    present = both_section(list(responses.values()))
    document = {
        FIRST: first_section(),
        PRESENT: present,
        WITHOUT_C3: both_section(list(responses.values()), controllers=2),
    }
    for section, name in HELD_OUT.items():
        document[section] = held_out_section(search([AXES[name]], [responses[name]]), name)
    head = "# Assumed cogging maps (amplitudes in V, begin in rad), written by studies.lu2008.calibration.\n"
    return head + to_toml(document)


def main(target: str) -> None:
    """Calibrate and write the file."""
    write_text(target, maps_toml())
    print(f"{target} written")


if __name__ == "__main__":
    own = str(Path(cogging.papers.lu2008.__file__).with_name("maps.toml"))
    sys.exit(run_command(lambda: main(sys.argv[1] if len(sys.argv) > 1 else own)))
