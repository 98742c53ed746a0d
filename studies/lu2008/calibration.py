"""Calibrates the cogging maps of Lu et al. 2008: `python -m studies.lu2008.calibration [FILE]`.

The paper prints no map. One family of maps, chosen among those of families.py, is fitted to the tables within the
printed bound of A_r, and comes with the package as maps.toml, bit for bit:

- present: to all twelve numbers and to where the maxima stand, by steps on the simulation;
- late: to all twelve, with e' of p as the reading's difference minus the velocity of x_d, on the linear answers alone;
- from_rms, from_table1, from_table2, without_c3: likewise to a part of them, the others being left to predict
  (tables.SPLITS).
"""

from __future__ import annotations

import sys
from collections.abc import Mapping
from dataclasses import asdict, replace
from typing import Any

import numpy as np

from cogging.arrays import FloatArray
from cogging.outputs import to_toml
from cogging.papers.lu2008.gantry import AXES, LATE, PRESENT
from cogging.papers.lu2008.tracking import SPLITS
from studies.command import run_calibration
from studies.fitting import round_to_digits
from studies.lu2008.families import EVERY, Family, Responses, Surrogate, polished

#: Of the cells with the fewest free amplitudes that bring 11 of the 12 numbers within 15 %, the one of least misfit.
FAMILY = Family(error_difference=True, decay=1.0, half_waves=2.0, begin=np.pi, sharing="one fundamental")
PARTS = ("periodic", "modulated", "uncompensated")


def section(amplitudes: Mapping[str, FloatArray]) -> dict[str, dict[str, float]]:
    """A fit as maps.toml has it."""
    return {
        axis: {part: round_to_digits(value, 3) for part, value in zip(PARTS, each.tolist(), strict=True)}
        for axis, each in amplitudes.items()
    }


def maps_toml() -> str:
    """The text of maps.toml."""
    late = replace(FAMILY, error_difference=False)
    answers = {
        family: Surrogate(
            family, {name: Responses(axis, family.error_difference, EVERY[name]) for name, axis in AXES.items()}
        )
        for family in (FAMILY, late)
    }
    document: dict[str, Any] = {"shape": asdict(FAMILY.shape)}
    document[PRESENT] = section(FAMILY.amplitudes(polished(FAMILY, answers[FAMILY].fit())))
    document[LATE] = section(late.amplitudes(answers[late].fit()))
    for split, (_, seen) in SPLITS.items():
        document[split] = section(FAMILY.amplitudes(answers[FAMILY].fit(seen)))
    head = "# Assumed cogging maps (amplitudes in V, begin in rad), written by studies.lu2008.calibration.\n"
    return head + to_toml(document)


if __name__ == "__main__":
    sys.exit(run_calibration(__doc__, maps_toml, "cogging.papers.lu2008", "maps.toml"))
