"""A ball-screw axis under cascade control (Janot, Gautier, Brunot, nonlinear benchmark workshop 2019).

Public through nonlinearbenchmark.org. The command is recorded in volts; the force is 35.15065 N/V times it, which is
taken as the command unit here, so that masses are kilograms.
"""

import itertools
from pathlib import Path

import numpy as np

import cogging

FOLDER = Path(__file__).parents[1] / ".." / "shared" / "data" / "emps"
FORCE_CONSTANT = GAIN = 35.15065  # N/V
SCREW = 2.5e-3  # m, one turn of the screw
PULSE = 1.08  # V for each unit of `pulses_N`
COLUMNS = {"time": "t", "position": "qm", "reference": "qg", "command": "vir"}
PUBLISHED = {"axis.mass": 95.11, "axis.viscous": 203.5, "axis.coulomb": 20.39, "effects.constant_force.force": 3.16}
AUTHORS = {"position": 1.38e-4, "velocity": 2.3e-3, "command": 5.85e-2}  # relative errors of their own simulation
AUTHORS_PULSES = {"position": 8.0e-5, "velocity": 4.8e-3, "command": 8.94e-2}


def read(name="DATA_EMPS.mat"):
    """A log in newtons."""
    return cogging.read_log(
        FOLDER / (name if name.endswith(".mat") else f"{name}.mat"), columns=COLUMNS, scale={"command": FORCE_CONSTANT}
    )


def pulses():
    """What was added to the command of the second log, N, (n,)."""
    from scipy.io import loadmat

    table = loadmat(FOLDER / "DATA_EMPS_PULSES.mat")
    return PULSE * FORCE_CONSTANT * np.asarray(table["pulses_N"], dtype=float).ravel()


def prior(coulomb_width=0.0):
    """A wrong guess, and the controller as it is published."""
    return cogging.Model(
        axis=cogging.AxisParameters(mass=90.0, viscous=180.0, coulomb=25.0, coulomb_width=coulomb_width),
        effects=(cogging.effects.ConstantForce(),),
        controller=cogging.CascadeParameters(
            sample_rate=1000.0, kp=160.18, kv=243.45 * FORCE_CONSTANT, command_limit=10.0 * FORCE_CONSTANT
        ),
        controller_type="cascade",
    )


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
