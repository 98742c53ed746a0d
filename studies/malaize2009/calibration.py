"""Calibrates Malaize and Levine 2009: `python -m studies.malaize2009.calibration [FILE]` (extra `design`).

For each motor the amplitude of the cogging is found so that the PID has the accuracy of Table I, and the pole radius of
the observer's design so that lambda* is that of Table I. The observer's accuracy takes no part. The result, with the
gains, comes with the package as gains.toml.
"""

from __future__ import annotations

import sys
from dataclasses import asdict

import numpy as np

from cogging.arrays import FloatArray
from cogging.design.observer import design_observer
from cogging.outputs import to_toml
from cogging.papers.malaize2009.linear_motors import MOTORS, Calibrated, Motor, accuracy, pid, plant, problem, run
from studies.command import run_calibration
from studies.fitting import fit_logarithms, round_to_digits


def calibrate(motor: Motor) -> Calibrated:
    """Find amplitude and pole radius of a motor."""

    def pid_gap(values: FloatArray) -> FloatArray:
        machine = plant(motor, round_to_digits(values[0]))
        return np.log([accuracy(run(machine, pid(), motor), motor) / motor.accuracy[0]])

    def lambda_gap(values: FloatArray) -> FloatArray:
        design = design_observer(problem(motor, round_to_digits(values[0])))
        return np.log([design.lambda_equal / motor.lambda_star])

    start = 2e4 * motor.accuracy[0]
    amplitude = round_to_digits(fit_logarithms(pid_gap, np.array([start]), step=0.05, tolerance=0.005)[0][0])
    radius = round_to_digits(fit_logarithms(lambda_gap, np.array([400.0]), step=0.05, tolerance=0.005)[0][0])
    design = design_observer(problem(motor, radius))
    gain = tuple(round_to_digits(value, 6) for value in design.observer_gain)
    return Calibrated(amplitude, radius, round_to_digits(design.lambda_equal), gain)


def gains_toml() -> str:
    """The text of gains.toml."""
    head = "# Amplitude (m/s^2), pole radius (1/s), lambda* (m/s^2) and gains, by studies.malaize2009.calibration.\n"
    return head + to_toml({motor.name: asdict(calibrate(motor)) for motor in MOTORS.values()})


if __name__ == "__main__":
    sys.exit(run_calibration(__doc__, gains_toml, "cogging.papers.malaize2009", "gains.toml"))
