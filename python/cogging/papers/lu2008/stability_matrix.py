"""Matrix (29) of Lu, Chen, Yao, Wang 2008 with the printed gains of C3, and gains that make it positive definite.

The paper asks for a k_s1 that makes (29) positive definite, and reports no slope of its S_f. Ours, (2/pi) atan(900 v),
is 573 s/m steep at rest. Mass, viscous and Coulomb friction go over the printed bounds, A_r over those of its entries.
"""

from __future__ import annotations

from typing import Any

import numpy as np
from scipy.optimize import brentq

from cogging._core import (
    CoggingModel,
    Dcarc,
    Plant,
    cogging_slope_max,
    desired_compensation_condition,
    friction_slope_max,
    smooth_sign,
)
from cogging.arrays import FloatArray
from cogging.logs.log import Log
from cogging.papers.lu2008.gantry import (
    COULOMB_WIDTH,
    GantryAxis,
    cogging_basis,
    controller_parameters,
    known,
    last_move,
    reference,
)
from cogging.papers.result import Row, Table

MARGIN = 1.3  # of k_s1 over the least that makes (29) positive, in what follows from it
ERROR_GAINS = np.geomspace(10.0, 5000.0, 1001)  # 1/s: among which k_1 is looked for


def steepest(axis: GantryAxis) -> tuple[float, float]:
    """The largest g_f of (24), 1/(m/s), and the largest |theta_4b^T g_r| of (25), V/m, that the bounds allow."""
    return friction_slope_max(COULOMB_WIDTH), cogging_slope_max(cogging_basis(axis.compensated), axis.cogging_bound)


def matrix_condition(axis: GantryAxis, friction_slope: float, share: float = 1.0, **gains: Any) -> tuple[float, float]:
    """Smallest eigenvalue of (29) (in SI units) and the decay rate (1/s) that goes with it, over the printed bounds.

    Args:
        axis: the axis.
        friction_slope: the largest g_f, 1/(m/s).
        share: of the largest |theta_4b^T g_r| that the printed bounds allow.
        gains: error_gain (1/s), feedback_gain (V/(m/s)) in place of the printed ones.
    """
    parameters = controller_parameters(axis, "C3", **gains)
    slope = share * steepest(axis)[1]
    return desired_compensation_condition(parameters, friction_slope=friction_slope, cogging_slope=slope)


def least_feedback_gain(axis: GantryAxis, error_gain: Any, friction_slope: float, cogging_slope: float) -> FloatArray:
    """The k_s1 above which (29) is positive definite over the printed bounds, V/(m/s), in the shape of error_gain.

    With F = theta_2 + theta_3 g_f and s = theta_4b^T g_r the determinant is positive where
    k_s1 > M k_1 - F + (k_1 F - s)^2 / (2 M k_1^3): convex in each of M, F and s, so that its largest value stands at a
    corner of the box.

    Args:
        axis: the axis.
        error_gain: k_1, 1/s, any shape.
        friction_slope: largest g_f, 1/(m/s).
        cogging_slope: largest |s|, V/m.
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
    """The k_1 (1/s) that asks for the least k_s1 (V/(m/s)) with the steepest slopes, and MARGIN times that k_s1."""
    least = least_feedback_gain(axis, ERROR_GAINS, *steepest(axis))
    place = int(np.argmin(least))
    return {"error_gain": float(ERROR_GAINS[place]), "feedback_gain": MARGIN * float(least[place])}


def largest_friction_slope(axis: GantryAxis) -> float:
    """The largest g_f (1/(m/s)) at which the printed gains make (29) positive, with the steepest cogging."""
    steep = steepest(axis)[0]
    return float(brentq(lambda slope: matrix_condition(axis, slope)[0], 0.0, steep, xtol=1e-9))


def largest_cogging_share(axis: GantryAxis) -> float:
    """The same of the cogging slope without any of friction, as a multiple of the largest that the bounds allow."""
    return float(brentq(lambda share: matrix_condition(axis, 0.0, share)[0], 0.0, 1e4, xtol=1e-9))


def speed_of_slope(slope: float) -> float:
    """The speed (m/s) from which on S_f(v) = (2/pi) atan(v / width) is no steeper than a slope (1/(m/s))."""
    return COULOMB_WIDTH * float(np.sqrt(max(friction_slope_max(COULOMB_WIDTH) / slope - 1.0, 0.0)))


def least_width(axis: GantryAxis) -> float:
    """The width (m/s) from which on S_f(v) = (2/pi) atan(v / width) is nowhere steeper than the printed gains allow."""
    return 2.0 / (np.pi * largest_friction_slope(axis))


def positive_share(axis: GantryAxis, machine: Plant, log: Log) -> float:
    """The share of the samples of the last there and back at which (29) is positive with the machine's own numbers.

    g_f and theta_4b^T g_r are the quotients of (24) and (25) between the true state and the reference; the latter is of
    the whole cogging, with the harmonics that C3 lacks.
    """
    parameters, motion = controller_parameters(axis, "C3"), reference(axis)
    assert isinstance(machine.cogging, CoggingModel)
    shown = log.time >= motion.end - motion.period
    columns = (log.true_position, log.true_velocity, log.reference, log.reference_velocity)
    x, v, x_d, v_d = (known(column)[shown] for column in columns)
    width = machine.axis.coulomb_width
    friction = machine.axis.viscous + machine.axis.coulomb * _quotient(
        smooth_sign(v, width) - smooth_sign(v_d, width), v - v_d, 2.0 * width / (np.pi * (width**2 + v_d**2))
    )
    cogging = machine.cogging
    slope = _quotient(cogging.force(x) - cogging.force(x_d), x - x_d, cogging.slope(x_d))
    mass, k = machine.axis.mass, parameters.error_gain
    corner = parameters.feedback_gain - mass * k + friction
    determinant = corner * 0.5 * mass * k**3 - 0.25 * (k * friction - slope) ** 2
    return float(np.mean((corner > 0.0) & (determinant > 0.0)))


def _quotient(change: FloatArray, distance: FloatArray, at_rest: FloatArray) -> FloatArray:
    """change / distance, and its limit where the distance is nothing but rounding."""
    near = np.abs(distance) < 1e-12
    return np.where(near, at_rest, change / np.where(near, 1.0, distance))


def condition_table(axis: GantryAxis, machine: Plant, log: Log) -> Table:
    """(29) with the printed gains, the slopes that it allows, and gains that make it positive definite.

    Args:
        axis: the axis.
        machine: that the log is of.
        log: of C3 with the printed gains.
    """
    steep, rough = steepest(axis)
    cases = (("all slopes", steep, 1.0), ("no friction slope", 0.0, 1.0), ("no slopes", 0.0, 0.0))
    rows = []
    for case, slope, share in cases:
        eigenvalue, rate = matrix_condition(axis, slope, share)
        rows.append(_row("eigenvalue", "SI", eigenvalue, case))
        rows.append(_row("decay_rate", "1/s", rate, case))
    borne, gains = largest_friction_slope(axis), sufficient_gains(axis)
    least = float(least_feedback_gain(axis, axis.error_gain, steep, rough))
    width = least_width(axis)
    smooth = Plant(machine.axis.replace(coulomb_width=width), cogging=machine.cogging, encoder=machine.encoder)
    rows += [
        _row("g_f", "s/m", borne, "borne"),
        _row("speed", "m/s", speed_of_slope(borne), "from which g_f is borne"),
        _row("width", "m/s", width, "of an S_f that is borne"),
        _row("e_2", "m", _rms(axis, smooth, coulomb_width=width), "with that S_f", axis.error_rms[2]),
        _row("slope_share", "1", largest_cogging_share(axis), "borne without g_f"),
        _row("sample_share", "1", positive_share(axis, machine, log), "positive in the run"),
        _row("k_s1", "V/(m/s)", least, "least at the printed k_1", axis.feedback_gain),
        _row("k_1", "1/s", gains["error_gain"], "sufficient gains", axis.error_gain),
        _row("k_s1", "V/(m/s)", gains["feedback_gain"], "sufficient gains", axis.feedback_gain),
        _row("e_2", "m", _rms(axis, machine, **gains), "sufficient gains", axis.error_rms[2]),
    ]
    return Table(f"matrix29_{axis.name}", f"Matrix (29) of C3, {axis.name} axis", rows)


def _rms(axis: GantryAxis, machine: Plant, **changes: Any) -> float:
    controller = Dcarc(controller_parameters(axis, "C3", **changes))
    return float(last_move([controller], [machine], reference(axis)).indexes["error_rms"][0])


def _row(index: str, unit: str, value: float, case: str, paper: float | None = None) -> Row:
    return Row("C3", index, unit, paper, value, "exploratory", {"case": case})
