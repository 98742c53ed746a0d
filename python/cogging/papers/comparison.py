"""The controllers of the three papers on one machine: `cogging reproduce --compare`. No paper has this table.

The X axis of Lu et al. 2008 with its calibrated cogging, encoder, sampling and moves; each controller tuned by its own
paper's rule. Nothing here is in a paper: every row is exploratory.
"""

from __future__ import annotations

import importlib.resources
import time
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from cogging._core import (
    Arc,
    Dcarc,
    DivergedError,
    ObserverBased,
    ObserverBasedParameters,
    OutputFeedbackArc,
    Pid,
    PidParameters,
    Plant,
    closed_loop,
    performance,
)
from cogging.design.observer import ObserverProblem, design_observer
from cogging.design.pid import pid_gains
from cogging.files import parse_toml
from cogging.logs.log import Log
from cogging.model.controller import ListedController
from cogging.papers.compared import Trace, compared
from cogging.papers.fitting import round_to_digits
from cogging.papers.lu2008 import setup as lu2008
from cogging.papers.result import Reproduction, Row, Table
from cogging.papers.xu2001 import setup as xu2001_setup

if TYPE_CHECKING:
    from matplotlib.figure import Figure

AXIS = lu2008.AXES["X"]
POLE = -300.0  # 1/s: of the PID for the smallest mass (Xu and Yao 2001, section 4.3), and of the observer's position
# loop, which takes the PID's real part (Malaize and Levine 2009, section IV.C)
VELOCITY_RATIO = 0.25
# 1/s: the paper states no bound on the poles. The first makes lambda* 1.25 times the nominal acceleration, as in its
# Table I (5 for 4 m/s^2); the second is about as fast as the solver certifies here, to show what lies in that choice.
POLE_RADII = {"observer_based": 450.0, "observer_based fast": 1200.0}


def observer_problem(pole_radius: float) -> ObserverProblem:
    """Theorem 3 of Malaize and Levine 2009 for this axis: its first three harmonics as periods."""
    return ObserverProblem(
        periods=[lu2008.PITCH / harmonic for harmonic in AXIS.compensated],
        velocity_min=VELOCITY_RATIO * AXIS.velocity,
        velocity_max=AXIS.velocity,
        viscous=AXIS.viscous / AXIS.mass,
        omega=-POLE,
        decay_rate=3.0,
        pole_radius=pole_radius,
    )


def gains_toml() -> str:
    """The text of comparison_gains.toml, which comes with the package (extra `design` to write it anew)."""
    lines = ["# Observer gains of the comparison, by cogging.papers.comparison.gains_toml."]
    for name, radius in POLE_RADII.items():
        gain = [round_to_digits(value, 6) for value in design_observer(observer_problem(radius)).observer_gain]
        lines.append(f'"{name}" = {gain}')
    return "\n".join(lines) + "\n"


def controllers() -> dict[str, ListedController]:
    """Each family, tuned by its own paper's rule on what is known of this axis."""
    made: dict[str, ListedController] = {"pid": _pid()}
    for name in lu2008.CONTROLLERS:
        made[f"arc {name}"] = Arc(lu2008.controller_parameters(AXIS, name))
        made[f"dcarc {name}"] = Dcarc(lu2008.controller_parameters(AXIS, name))
    made["output_feedback_arc"] = _output_feedback_arc()
    gains = parse_toml(
        importlib.resources.files("cogging.papers").joinpath("comparison_gains.toml").read_text(encoding="utf-8")
    )
    for name, radius in POLE_RADII.items():
        made[name] = _observer_based(observer_problem(radius), gains[name])
    return made


def _pid() -> Pid:
    kp, ki, kd = pid_gains([POLE] * 3, AXIS.bounds[0][0])  # Xu and Yao 2001, eq. 56
    return Pid(
        PidParameters(
            sample_rate=lu2008.SAMPLE_RATE,
            kp=kp,
            ki=ki,
            kd=kd,
            mass=AXIS.mass,
            viscous=AXIS.viscous,
            coulomb=AXIS.coulomb,
            coulomb_width=lu2008.COULOMB_WIDTH,
        )
    )


def _output_feedback_arc() -> OutputFeedbackArc:
    mass, viscous, _, disturbance = AXIS.bounds
    inverse = (1.0 / mass[1], 1.0 / mass[0])
    return OutputFeedbackArc(
        xu2001_setup.arc_parameters(
            sample_rate=lu2008.SAMPLE_RATE,
            theta=[1.0 / AXIS.mass, AXIS.viscous / AXIS.mass, 0.0],
            theta_min=[inverse[0], viscous[0] / mass[1], disturbance[0] / mass[0]],
            theta_max=[inverse[1], viscous[1] / mass[0], disturbance[1] / mass[0]],
            coulomb=AXIS.coulomb,
            coulomb_width=lu2008.COULOMB_WIDTH,
        )
    )


def _observer_based(problem: ObserverProblem, observer_gain: Sequence[float]) -> ObserverBased:
    return ObserverBased(
        ObserverBasedParameters(
            sample_rate=lu2008.SAMPLE_RATE,
            periods=list(problem.periods),
            observer_gain=list(observer_gain),
            position_gain=problem.omega**2,
            velocity_gain=2 * problem.omega - problem.viscous,
            mass=AXIS.mass,
            viscous=problem.viscous,
            velocity_min=0.01 * AXIS.velocity,
        )
    )


def machine(mass_factor: float = 1.0) -> Plant:
    """The X axis with its calibrated cogging; mass_factor: a payload, or less of the coil."""
    cogging = lu2008.cogging_map(AXIS, lu2008.shipped_amplitudes(AXIS))
    return lu2008.plant(AXIS, cogging, mass=mass_factor * AXIS.mass)


def measure(controller: ListedController) -> tuple[dict[str, float], Log | None]:
    """The indexes of a controller over the last move there and back, and its log; infinite where it diverges."""
    motion = lu2008.reference(AXIS)
    begin = time.perf_counter()
    try:
        log = Log.of(closed_loop(machine(), controller, motion))
    except DivergedError:
        return dict.fromkeys(UNITS, float("inf")), None
    seconds = time.perf_counter() - begin
    last = performance(log.time, log.error, log.command, start=motion.end - motion.period)
    found = {
        "rms": last.error_rms,
        "max": last.error_max,
        "transient": float(np.abs(log.error[log.time < motion.period]).max()),
        "u_rms": last.command_rms,
        "chatter": last.command_change_rms,
        "step": seconds / len(log),
    }
    for name, factor in (("rms_light", 0.8), ("rms_heavy", 1.2)):
        try:
            other = Log.of(closed_loop(machine(factor), controller, motion))
            found[name] = performance(
                other.time, other.error, other.command, start=motion.end - motion.period
            ).error_rms
        except DivergedError:
            found[name] = float("inf")
    return found, log


#: The indexes and their units: rms, max and chatter over the last period, the largest error of the first, the rms with
#: 0.8 and 1.2 times the mass, and the time of a step on this machine (noisy).
UNITS = {
    "rms": "m",
    "max": "m",
    "transient": "m",
    "u_rms": "V",
    "chatter": "V",
    "rms_light": "m",
    "rms_heavy": "m",
    "step": "s",
}


@dataclass(frozen=True, eq=False, repr=False)
class Comparison(Table):
    """A table with a row a controller and a column an index on the screen."""

    lines: Sequence[str] = ()

    def text(self) -> str:
        """The table for the screen."""
        return "\n".join([self.title, *self.lines])


#: What compare() tells its progress: the controllers, in their order.
STEPS = ("pid", *(f"{law} {name}" for name in lu2008.CONTROLLERS for law in ("arc", "dcarc")), "output", *POLE_RADII)


def compare(progress: Callable[[str], None] = lambda step: None) -> Reproduction:
    """Run every controller; `progress` is told each name."""
    rows, logs = [], {}
    for name, controller in controllers().items():
        found, log = measure(controller)
        rows += [Row(name, index, unit, None, found[index], "exploratory") for index, unit in UNITS.items()]
        if log is not None:
            logs[name] = log
        progress(name)
    width = 11
    lines = [f"{'':4}{'controller':<21}" + "".join(f"{index:>{width}}" for index in UNITS)]
    lines.append(
        f"{'':25}" + "".join(f"{'um' if u == 'm' else 'ns' if u == 's' else u:>{width}}" for u in UNITS.values())
    )
    for start in range(0, len(rows), len(UNITS)):
        part = rows[start : start + len(UNITS)]
        scales = [1e6 if row.unit == "m" else 1e9 if row.unit == "s" else 1.0 for row in part]
        numbers = "".join(f"{row.simulated * scale:11.4g}" for row, scale in zip(part, scales, strict=True))
        lines.append(f"{'':4}{part[0].controller:<21}{numbers}")
    title = "The three papers' controllers on one axis (X of Lu et al. 2008); exploratory"
    return Reproduction(
        "comparison", [Comparison("comparison", title, rows, lines=lines)], {"comparison": figure(logs)}
    )


def figure(logs: dict[str, Log]) -> Figure:
    """The tracking errors of the last move there and back."""
    motion = lu2008.reference(AXIS)
    traces = []
    for name, log in logs.items():
        shown = log.time >= motion.end - motion.period
        traces.append(Trace(name, log.time[shown], log.error[shown]))
    return compared("Tracking errors over the last move there and back", traces)
