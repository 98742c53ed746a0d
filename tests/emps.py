"""A ball-screw axis under cascade control (Janot, Gautier, Brunot, nonlinear benchmark workshop 2019).

Public through nonlinearbenchmark.org. The command is recorded in volts; the force is 35.15065 N/V times it, which is
taken as the command unit here, so that masses are kilograms.
"""

from pathlib import Path

import numpy as np

import cogging

FOLDER = Path(__file__).parents[1] / ".." / "shared" / "data" / "emps"
FORCE_CONSTANT = 35.15065  # N/V
PULSE = 1.08  # V for each unit of `pulses_N`
COLUMNS = {"time": "t", "position": "qm", "reference": "qg", "command": "vir"}
PUBLISHED = {"axis.mass": 95.11, "axis.viscous": 203.5, "axis.coulomb": 20.39, "effects.constant_force.force": 3.16}
AUTHORS = {"position": 1.38e-4, "velocity": 2.3e-3, "command": 5.85e-2}  # relative errors of their own simulation
AUTHORS_PULSES = {"position": 8.0e-5, "velocity": 4.8e-3, "command": 8.94e-2}


def read(name="DATA_EMPS.mat"):
    """A log in newtons."""
    return cogging.read_log(FOLDER / name, columns=COLUMNS, scale={"command": FORCE_CONSTANT})


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
