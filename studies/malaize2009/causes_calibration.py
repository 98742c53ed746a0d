"""Calibrates conditions.toml: `python -m studies.malaize2009.causes_calibration [FILE]`.

For each of CAUSES and each motor the size at which the observer has the accuracy of Table I, the PID's calibrated anew
at every size; and the one share of unmodelled lines, and the one width of smooth friction, that serve both motors best,
which Table I is shown under. Some minutes.
"""

from __future__ import annotations

import sys
from collections.abc import Callable
from dataclasses import replace
from typing import Any

import numpy as np

from cogging.arrays import FloatArray
from cogging.outputs import to_toml
from cogging.papers.malaize2009 import causes
from cogging.papers.malaize2009.linear_motors import MOTORS, Calibrated, Motor, batch_errors, controllers, shipped
from studies.command import run_calibration
from studies.fitting import fit_logarithms, round_to_digits

STEPS = 7  # sizes of a curve
DIGITS = 3
CLOSE, NEAR = 0.003, 0.03  # of the printed accuracy: how near the PID's is brought to it, and may stay where it jumps
TABLE_1_STARTS = {causes.LINES: 0.032, causes.FRICTION: 1.4e-4}  # where the search for the one size begins


def recalibrated(motor: Motor, gains: Calibrated, conditions: causes.Conditions, draws: int = 1) -> Calibrated:
    """The gains with the amplitude (4 digits) by which the PID's mean accuracy is that of Table I.

    Raises:
        ValueError: there is none, as where the PID errs by more than printed without any cogging.
    """
    amplitude, printed = gains.amplitude, motor.accuracy[0]
    controller = controllers(motor, gains, 1.0 + conditions.thrust)["PID"]
    tried: dict[float, float] = {}
    for _ in range(8):
        machines = [causes.machine(motor, amplitude, conditions, draw) for draw in range(draws)]
        errors = batch_errors(machines, [controller] * draws, motor, strokes=causes.strokes_of(draws))
        ratio = float(errors.mean()) / printed
        tried[amplitude] = abs(ratio - 1.0)
        if tried[amplitude] < CLOSE:
            break
        amplitude = round_to_digits(amplitude / ratio)
        if amplitude in tried:
            amplitude = round_to_digits(amplitude / np.sqrt(ratio))
    best = min(tried, key=lambda each: tried[each])
    if tried[best] > NEAR:
        raise ValueError(f"{motor.name}: no amplitude gives the PID the printed accuracy under {conditions}")
    return replace(gains, amplitude=best)


def curve(cause: causes.Cause, motor: Motor) -> list[tuple[float, float]]:
    """Size and the observer's accuracy over the printed one, the PID's calibrated anew at each size.

    It ends where it is four times the printed one, or where no amplitude calibrates the PID.
    """
    found: list[tuple[float, float]] = []
    gains = shipped(motor)
    for size in np.geomspace(*cause.sizes, STEPS):
        try:
            gains = recalibrated(motor, gains, cause.of(float(size)), cause.draws)
        except ValueError:
            break
        found.append((float(size), _ratio(cause, motor, gains, float(size))))
        if found[-1][1] > 4.0:
            break
    return found


def _ratio(cause: causes.Cause, motor: Motor, gains: Calibrated, size: float) -> float:
    accuracies = causes.drawn_accuracies(motor, gains, cause.of(size), "observer", cause.draws)
    return float(accuracies.mean()) / motor.accuracy[1]


def explaining_size(cause: causes.Cause, motor: Motor, points: list[tuple[float, float]]) -> float | None:
    """The size (3 digits) at which the observer's accuracy is the printed one, by bisection; None: no size of a curve.

    Where the curve crosses it more than once, as quantisers make it, the last crossing counts: beyond it stays above.
    """
    below = [i for i, (_, ratio) in enumerate(points) if ratio < 1.0]
    if not below or below[-1] + 1 == len(points):
        return None
    low, high = points[below[-1]][0], points[below[-1] + 1][0]
    gains = shipped(motor)
    while high / low > 1.008:
        middle = float(np.sqrt(low * high))
        gains = recalibrated(motor, gains, cause.of(middle), cause.draws)
        low, high = (middle, high) if _ratio(cause, motor, gains, middle) < 1.0 else (low, middle)
    return round_to_digits(float(np.sqrt(low * high)), DIGITS)


def calibrated_cause(cause: causes.Cause, show: Callable[[str], None]) -> dict[str, dict[str, float]]:
    """Size, amplitude of this motor, and amplitude of the other under the same size, by motor."""
    found: dict[str, dict[str, float]] = {}
    for motor in MOTORS.values():
        points = curve(cause, motor)
        show(f"{cause.name}, {motor.name}: " + ", ".join(f"{size:.3g} {ratio:.3g}" for size, ratio in points))
        size = explaining_size(cause, motor, points)
        if size is None:
            continue
        amplitudes = []
        for each in (motor, causes.other(motor)):
            try:
                amplitudes.append(recalibrated(each, shipped(each), cause.of(size), cause.draws).amplitude)
            except ValueError:
                amplitudes.append(0.0)
        found[motor.name] = {"size": size, "amplitude": amplitudes[0], "amplitude_elsewhere": amplitudes[1]}
        show(f"    {size:g}")
    return found


def calibrated_table_1(cause: causes.Cause) -> dict[str, float]:
    """The size of a cause that serves both motors best (least squares of logarithms), and the amplitudes under it."""
    gains = {motor.name: shipped(motor) for motor in MOTORS.values()}

    def recalibrate(size: float) -> float:
        rounded = round_to_digits(size, DIGITS)
        for motor in MOTORS.values():
            gains[motor.name] = recalibrated(motor, gains[motor.name], cause.of(rounded), cause.draws)
        return rounded

    def gap(values: FloatArray) -> FloatArray:
        size = recalibrate(values[0])
        return np.log([_ratio(cause, motor, gains[motor.name], size) for motor in MOTORS.values()])

    # The accuracies grow nearly with the size: one step is enough.
    size = fit_logarithms(gap, np.array([TABLE_1_STARTS[cause]]), step=0.1, iterations=1)[0][0]
    return {"size": recalibrate(size)} | {name: each.amplitude for name, each in gains.items()}


def conditions_toml(show: Callable[[str], None] = print) -> str:
    """Return the text of conditions.toml."""
    table_1 = {cause.field: calibrated_table_1(cause) for cause in TABLE_1_STARTS}
    show(f"Table I: {table_1}")
    document: dict[str, Any] = {"table_1": table_1}
    document |= {cause.field: calibrated_cause(cause, show) for cause in causes.CAUSES}
    head = "# Sizes (SI) and amplitudes (m/s^2), by python -m studies.malaize2009.causes_calibration.\n"
    return head + to_toml(document)


if __name__ == "__main__":
    sys.exit(run_calibration(__doc__, conditions_toml, "cogging.papers.malaize2009", "conditions.toml"))
