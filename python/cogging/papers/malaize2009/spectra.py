"""Fig. 3 of Malaize and Levine 2009 with unmodelled lines, and whether it still shows which periods to cancel."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from cogging._core import closed_loop
from cogging.logs.log import Log
from cogging.mapping.error_spectrum import TrackingSpectrum, tracking_spectrum
from cogging.papers.malaize2009.causes import shipped_table_1
from cogging.papers.malaize2009.conditions import DRAWS, LINE_PERIODS, machine
from cogging.papers.malaize2009.setup import MOTORS, Motor, pid, reference

SAME = 0.02  # relative: how near a proposed period is to a printed one


def spectra_of(logs: Mapping[str, Mapping[str, Log]]) -> dict[str, dict[str, TrackingSpectrum]]:
    """Spectra of the tracking errors from 4 mm on, by motor and controller."""
    return {
        motor: {name: tracking_spectrum(log, shortest_period=LINE_PERIODS[0]) for name, log in pair.items()}
        for motor, pair in logs.items()
    }


def proposes_first(found: TrackingSpectrum, motor: Motor) -> bool:
    """Whether the strongest periods that a spectrum proposes are the printed ones, in any order."""
    first = sorted(found.periods[: len(motor.periods)])
    return len(first) == len(motor.periods) and bool(np.allclose(first, sorted(motor.periods), rtol=SAME, atol=0.0))


def draws_that_propose(motor: Motor, draws: int = DRAWS) -> int:
    """In how many draws of lines and phases the PID's error, there and back, proposes the printed periods first."""
    conditions, gains = shipped_table_1(motor)
    count = 0
    for draw in range(draws):
        plant = machine(motor, gains.amplitude, conditions, draw)
        log = Log.of(closed_loop(plant, pid(), reference(motor), duration=reference(motor).period))
        count += proposes_first(tracking_spectrum(log, shortest_period=LINE_PERIODS[0]), motor)
    return count


def all_propose() -> str:
    """A sentence of the counts."""
    counts = ", ".join(f"{motor.name} {draws_that_propose(motor)} of {DRAWS}" for motor in MOTORS.values())
    return f"Draws of the lines in which the spectrum proposes the printed periods first: {counts}."
