"""A ball-screw axis measured by others (EMPS): its two logs and the model that was published for them, in newton.

A. Janot, M. Gautier, M. Brunot, "Data Set and Reference Models of EMPS" (2019), public through nonlinearbenchmark.org.
test_diagnose_real.py and notebook 06 both use what stands here.
"""

from __future__ import annotations

import itertools
from pathlib import Path

import numpy as np

import cogging

FOLDER = Path(__file__).parents[1] / ".." / "shared" / "data" / "emps"
GAIN = 35.15065  # N/V, of the drive: the logs hold volts
SCREW = 2.5e-3  # m, one turn of the screw


def read(name):
    """DATA_EMPS or DATA_EMPS_PULSES, with the command in newton."""
    columns = {"time": "t", "position": "qm", "command": "vir", "reference": "qg"}
    return cogging.read_log(FOLDER / f"{name}.mat", columns=columns, scale={"command": GAIN})


def published(controller=True):
    """The four published parameters, with the sign function and a stated uncertainty of 3, 20 and 20 %.

    The controller is the published cascade; its limit of 10 V is the drive's.
    """
    cascade = cogging.CascadeParameters(sample_rate=1000.0, kp=160.18, kv=243.45 * GAIN, command_limit=10.0 * GAIN)
    return cogging.Model(
        axis=cogging.AxisParameters(mass=95.11, viscous=203.5, coulomb=20.39, coulomb_width=0.0),
        effects=(cogging.effects.ConstantForce(force=3.16),),
        controller=cascade if controller else None,
        controller_type="cascade" if controller else None,
        uncertainty={"mass": 0.03, "viscous": 0.2, "coulomb": 0.2},
    )


def laps(log):
    """The rows of each lap from rest to rest at the start, as the reference repeats itself: a list of slices."""
    span = log.reference - log.reference.min()
    below = span < 0.02 * span.max()
    edges = np.flatnonzero(np.diff(below.astype(int)))
    leave = edges[~below[edges + 1]]  # from below the mark to above it
    return [slice(int(first), int(last)) for first, last in itertools.pairwise(leave)]
