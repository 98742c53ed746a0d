"""Fig. 3 of Malaize and Levine 2009 with unmodelled lines, and whether it still shows which periods to cancel."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from cogging._core import closed_loop
from cogging.logs.log import Log
from cogging.mapping.error_spectrum import TrackingSpectrum, tracking_spectrum
from cogging.papers.malaize2009.causes import conditions_file
from cogging.papers.malaize2009.conditions import DRAWS, LINE_PERIODS, Conditions, controllers_under, machine
from cogging.papers.malaize2009.setup import MOTORS, Calibrated, Motor, reference, shipped

SAME = 0.02  # relative: how near a proposed period is to a printed one


def with_lines(motor: Motor) -> tuple[Conditions, Calibrated]:
    """The unmodelled lines that alone explain the observer's accuracy, and the gains with the amplitude under them."""
    part = conditions_file()["lines"][motor.name]
    return Conditions(lines=part["size"]), replace(shipped(motor), amplitude=part["amplitude"])


def spectrum_with_lines(motor: Motor, controller: str, draw: int = 0, *, strokes: int = 0) -> TrackingSpectrum:
    """The spectrum of a controller's error on a machine with unmodelled lines.

    Args:
        motor: one of MOTORS.
        controller: "PID" or "observer".
        draw: of the lines.
        strokes: from the start; 0: all.
    """
    conditions, gains = with_lines(motor)
    log = Log.of(
        closed_loop(
            machine(motor, gains.amplitude, conditions, draw),
            controllers_under(motor, gains, conditions)[controller],
            reference(motor),
            duration=0.5 * strokes * reference(motor).period,
        )
    )
    return tracking_spectrum(log, shortest_period=LINE_PERIODS[0])


def spectra_with_lines() -> dict[str, dict[str, TrackingSpectrum]]:
    """Those of the first draw, by motor and controller."""
    return {
        motor.name: {name: spectrum_with_lines(motor, name) for name in ("PID", "observer")}
        for motor in MOTORS.values()
    }


def proposes_first(found: TrackingSpectrum, motor: Motor) -> bool:
    """Whether the strongest periods that a spectrum proposes are the printed ones, in any order."""
    first = sorted(found.periods[: len(motor.periods)])
    return len(first) == len(motor.periods) and bool(np.allclose(first, sorted(motor.periods), rtol=SAME, atol=0.0))


def draws_that_propose(motor: Motor, draws: int = DRAWS) -> int:
    """Of so many draws of the lines, those whose PID's error, there and back, proposes the printed periods first."""
    return sum(proposes_first(spectrum_with_lines(motor, "PID", draw, strokes=2), motor) for draw in range(draws))
