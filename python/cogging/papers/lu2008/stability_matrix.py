"""Matrix (29) of Lu, Chen, Yao, Wang 2008 with the printed gains of C3, and gains that make it positive definite.

The paper requires a k_s1 that makes (29) positive definite, and does not report the slope of its S_f. That of
(2/pi) atan(900 v) is 573 s/m at rest. Mass, viscous and Coulomb friction take all values within the printed bounds,
the entries of A_r likewise.
"""

from __future__ import annotations

from typing import Any

import numpy as np
from scipy.optimize import brentq

from cogging import _core
from cogging._core import CoggingModel, Dcarc, Plant, friction_slope_max
from cogging.arrays import FloatArray
from cogging.logs.log import Log
from cogging.papers.lu2008 import gantry
from cogging.papers.lu2008.gantry import COULOMB_WIDTH, GantryAxis, known
from cogging.papers.result import Row, Table

MARGIN = 1.3  # of k_s1 over the least that makes (29) positive, in `sufficient_gains`
ERROR_GAINS = np.geomspace(10.0, 5000.0, 1001)  # 1/s: candidates for k_1


def steepest(axis: GantryAxis) -> tuple[float, float]:
    """Return the largest g_f of (24), 1/(m/s), and |theta_4b^T g_r| of (25), V/m, within the bounds."""
    basis = gantry.cogging_basis(axis.compensated)
    return friction_slope_max(COULOMB_WIDTH), _core.cogging_slope_max(basis, axis.cogging_bound)


def matrix_condition(axis: GantryAxis, friction_slope: float, share: float = 1.0, **gains: Any) -> tuple[float, float]:
    """Return the smallest eigenvalue of (29) over the printed bounds, in SI units, and its decay rate, 1/s.

    friction_slope: the largest g_f, 1/(m/s); share: of the largest |theta_4b^T g_r|; gains: in place of the printed.
    """
    parameters, slope = gantry.controller_parameters(axis, "C3", **gains), share * steepest(axis)[1]
    return _core.desired_compensation_condition(parameters, friction_slope=friction_slope, cogging_slope=slope)


def least_feedback_gain(axis: GantryAxis, error_gain: Any, friction_slope: float, cogging_slope: float) -> FloatArray:
    """Return the k_s1 above which (29) is positive definite over the printed bounds, V/(m/s), for each k_1 (1/s).

    With F = theta_2 + theta_3 g_f and s = theta_4b^T g_r the determinant is positive if
    k_s1 > M k_1 - F + (k_1 F - s)^2 / (2 M k_1^3): convex in each of M, F and s, so that the largest value is at a
    corner of the box. The slopes are the largest g_f (1/(m/s)) and |s| (V/m).
    """
    k = np.asarray(error_gain, dtype=np.float64)
    masses, viscous, coulomb, _ = axis.bounds
    found = [
        mass * k - friction + (k * friction - slope) ** 2 / (2.0 * mass * k**3)
        for mass in masses
        for friction in (viscous[0], viscous[1] + coulomb[1] * friction_slope)
        for slope in (-cogging_slope, cogging_slope)
    ]
    return np.asarray(np.max(found, axis=0))


def sufficient_gains(axis: GantryAxis) -> dict[str, float]:
    """Return the k_1 (1/s) that needs the least k_s1 (V/(m/s)) at the steepest slopes, and MARGIN times that k_s1."""
    least = least_feedback_gain(axis, ERROR_GAINS, *steepest(axis))
    place = int(np.argmin(least))
    return {"error_gain": float(ERROR_GAINS[place]), "feedback_gain": MARGIN * float(least[place])}


def largest_friction_slope(axis: GantryAxis) -> float:
    """Return the largest g_f (1/(m/s)) at which the printed gains make (29) positive, with the steepest cogging."""
    steep = steepest(axis)[0]
    return float(brentq(lambda slope: matrix_condition(axis, slope)[0], 0.0, steep, xtol=1e-9))


def largest_cogging_share(axis: GantryAxis) -> float:
    """Return the same for the cogging slope without any of friction, over the largest within the bounds."""
    return float(brentq(lambda share: matrix_condition(axis, 0.0, share)[0], 0.0, 1e4, xtol=1e-9))


def speed_of_slope(slope: float) -> float:
    """Return the speed (m/s) above which S_f(v) = (2/pi) atan(v / width) is less steep than a slope (1/(m/s))."""
    return COULOMB_WIDTH * float(np.sqrt(max(friction_slope_max(COULOMB_WIDTH) / slope - 1.0, 0.0)))


def least_width(axis: GantryAxis) -> float:
    """Return the least width (m/s) of S_f(v) = (2/pi) atan(v / width) that the printed gains allow."""
    return 2.0 / (np.pi * largest_friction_slope(axis))


def positive_share(axis: GantryAxis, machine: Plant, log: Log) -> float:
    """Return the share of the last move's samples at which (29) is positive with the quotients (24), (25) there."""
    parameters, motion = gantry.controller_parameters(axis, "C3"), gantry.reference(axis)
    cogging, width = machine.cogging, machine.axis.coulomb_width
    assert isinstance(cogging, CoggingModel)
    late = log.time >= motion.end - motion.period
    columns = (log.true_position, log.true_velocity, log.reference, log.reference_velocity)
    x, v, x_d, v_d = (known(column)[late] for column in columns)

    def quotient(change: FloatArray, distance: FloatArray, at_rest: FloatArray) -> FloatArray:
        near = np.abs(distance) < 1e-12  # nothing but rounding
        return np.where(near, at_rest, change / np.where(near, 1.0, distance))

    sign_change = _core.smooth_sign(v, width) - _core.smooth_sign(v_d, width)
    at_rest = 2.0 * width / (np.pi * (width**2 + v_d**2))
    friction = machine.axis.viscous + machine.axis.coulomb * quotient(sign_change, v - v_d, at_rest)
    slope = quotient(cogging.force(x) - cogging.force(x_d), x - x_d, cogging.slope(x_d))
    mass, k = machine.axis.mass, parameters.error_gain
    corner = parameters.feedback_gain - mass * k + friction
    determinant = corner * 0.5 * mass * k**3 - 0.25 * (k * friction - slope) ** 2
    return float(np.mean((corner > 0.0) & (determinant > 0.0)))


def condition_table(axis: GantryAxis, machine: Plant, log: Log) -> Table:
    """Tabulate (29) with the printed gains on a machine and its log of C3, the slopes and the gains that it allows."""
    steep, rough = steepest(axis)
    rows = []

    def row(case: str, index: str, unit: str, value: float, paper: float | None = None) -> None:
        rows.append(Row("C3", index, unit, paper, value, "exploratory", {"case": case}))

    def rms(on: Plant, **changes: Any) -> float:
        controller = Dcarc(gantry.controller_parameters(axis, "C3", **changes))
        return float(gantry.last_move([controller], [on], gantry.reference(axis)).indexes["error_rms"][0])

    for case, slope, share in (
        ("all slopes", steep, 1.0),
        ("no friction slope", 0.0, 1.0),
        ("no slopes", 0.0, 0.0),
    ):
        eigenvalue, rate = matrix_condition(axis, slope, share)
        row(case, "eigenvalue", "SI", eigenvalue)
        row(case, "decay_rate", "1/s", rate)
    largest, gains, width = largest_friction_slope(axis), sufficient_gains(axis), least_width(axis)
    smooth = Plant(machine.axis.replace(coulomb_width=width), cogging=machine.cogging, encoder=machine.encoder)
    least = float(least_feedback_gain(axis, axis.error_gain, steep, rough))
    row("largest friction slope", "g_f", "s/m", largest)
    row("at the largest friction slope", "speed", "m/s", speed_of_slope(largest))
    row("least of S_f", "width", "m/s", width)
    row("with that S_f", "e_2", "m", rms(smooth, coulomb_width=width), axis.error_rms[2])
    row("largest without friction slope", "slope_share", "1", largest_cogging_share(axis))
    row("positive in the run", "sample_share", "1", positive_share(axis, machine, log))
    row("least at the printed k_1", "k_s1", "V/(m/s)", least, axis.feedback_gain)
    row("sufficient gains", "k_1", "1/s", gains["error_gain"], axis.error_gain)
    row("sufficient gains", "k_s1", "V/(m/s)", gains["feedback_gain"], axis.feedback_gain)
    row("sufficient gains", "e_2", "m", rms(machine, **gains), axis.error_rms[2])
    return Table(f"matrix29_{axis.name}", f"Matrix (29) of C3, {axis.name} axis", rows)
