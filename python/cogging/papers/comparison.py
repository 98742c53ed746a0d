"""The controllers of the three papers on the same machines: `cogging reproduce --compare`. No paper has these tables.

First on the X axis of Lu et al. 2008 with its calibrated cogging, encoder, sampling and moves, each controller tuned by
its own paper's rule. Then at equal delay margin: the bandwidth of every controller is scaled until its loop tolerates
the same delay of the command, on both axes and on a machine that no controller can represent. All rows are exploratory.
"""

from __future__ import annotations

import time
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from matplotlib.figure import Figure

from cogging import _core, effects
from cogging._core import Arc, Dcarc, DivergedError, ObserverBased, OutputFeedbackArc, Pid, Plant
from cogging.design.observer import ObserverProblem, design_observer
from cogging.design.pid import pid_gains
from cogging.files import shipped_toml
from cogging.logs.log import Log
from cogging.model.controller import ListedController
from cogging.papers.lu2008 import gantry
from cogging.papers.lu2008.gantry import AXES, COULOMB_WIDTH, SAMPLE_RATE, GantryAxis
from cogging.papers.result import Reproduction, Table, explored
from cogging.papers.xu2001 import epoxy_motor
from cogging.plot.canvas import drawn, titled_panels
from cogging.plot.series import look, marker

AXIS = AXES["X"]
POLE = -300.0  # 1/s: of the PID for the smallest mass (Xu and Yao 2001, section 4.3), and of the observer's position
# loop, which takes the PID's real part (Malaize and Levine 2009, section IV.C)
VELOCITY_RATIO = 0.25
DECAY_RATE, SLOW_DECAY_RATE = 3.0, 0.6  # 1/s, assumed; the second where the bandwidth is scaled
# 1/s: the paper states no bound on the poles. The first makes lambda* 1.25 times the nominal acceleration, as in its
# Table I (5 for 4 m/s^2); the second is about as fast as the solver certifies here, to show the effect of this choice.
POLE_RADII = {"observer_based": 450.0, "observer_based fast": 1200.0}
#: The controllers that are compared at equal delay margin, and that margin: the PID's on X by its own rule.
SCALED = ("pid", "arc C3", "dcarc C1", "dcarc C2", "dcarc C3", "output_feedback_arc", "observer_based")
DELAY_MARGIN = 1.3e-3  # s
#: Cogging at periods that no controller knows (m, V), a thrust that varies along the travel, and a lag of the current.
OUTSIDE = [
    effects.CoggingHarmonic(period=0.0137, sine=0.03),
    effects.CoggingHarmonic(period=0.0313, cosine=0.03),
    effects.ForceConstantRipple(period=0.041, sine=0.03),
    effects.ActuatorLag(time_constant=2e-4),
]
#: Machines at equal margin: an axis, and further effects.
MACHINES: dict[str, tuple[GantryAxis, Sequence[Any]]] = {name: (axis, ()) for name, axis in AXES.items()}
MACHINES["X outside"] = (AXIS, OUTSIDE)
PAYLOADS = {"rms_light": 0.8, "rms_heavy": 1.2}  # factors on the mass
#: Indexes and their units: rms, maximum and chatter over the last period, largest error of the first, rms with other
#: masses, and the time of a step on this computer (noisy).
UNITS = dict.fromkeys(("rms", "max", "transient"), "m") | dict.fromkeys(("u_rms", "chatter"), "V")
UNITS |= dict.fromkeys(PAYLOADS, "m") | {"step": "s"}
#: Index and machine by which the winner of each use is chosen; None: the worst of all machines.
USES = {
    "the motor of the model, fast moves": ("rms", "X"),
    "the motor of the model, slow moves": ("rms", "Y"),
    "a motor outside all models": ("rms", "X outside"),
    "the largest error, any motor": ("max", None),
    "the first move": ("transient", None),
    "a changing payload": ("rms_heavy", None),
    "a quiet command": ("chatter", None),
}
#: Controllers by their papers' own rules, and the steps that reproduce() reports.
OWN = ("pid", *(f"{law} {name}" for name in gantry.CONTROLLERS for law in ("arc", "dcarc")), "output_feedback_arc")
STEPS = len((*OWN, *POLE_RADII, *SCALED))
#: Indexes of a controller by machine and name.
Found = Mapping[tuple[str, str], Mapping[str, float]]


# Controllers ----------------------------------------------------------------------------------------------------------


def shipped() -> dict[str, Any]:
    """Return comparison_gains.toml: observer gains by the papers' rules, and what gives DELAY_MARGIN by axis."""
    return shipped_toml("papers/comparison_gains.toml")


def controllers() -> dict[str, ListedController]:
    """Return each controller, tuned by its own paper's rule for the X axis."""
    made = {name: scaled(name, AXIS) for name in OWN}
    for name, radius in POLE_RADII.items():
        fields = {"sample_rate": SAMPLE_RATE, "mass": AXIS.mass}
        made[name] = ObserverBased(observer_problem(radius).controller_parameters(shipped()["own"][name], **fields))
    return made


def at_equal_margin(axis: GantryAxis) -> dict[str, ListedController]:
    """Return the controllers of SCALED with the bandwidth at which the loop of an axis tolerates DELAY_MARGIN."""
    found = shipped()[axis.name]
    return {name: scaled(name, axis, found["factors"][name], found["observer_gain"]) for name in SCALED}


def scaled(
    name: str, axis: GantryAxis, factor: float = 1.0, observer_gain: Sequence[float] | None = None
) -> ListedController:
    """Return a controller of SCALED or OWN tuned by its paper's rule for an axis, all poles times a factor.

    observer_gain: of observer_based at this factor; None: designed here (extra `design`).
    """
    known: dict[str, Any] = {"sample_rate": SAMPLE_RATE, "coulomb": axis.coulomb, "coulomb_width": COULOMB_WIDTH}
    if name == "pid":
        kp, ki, kd = pid_gains([POLE * factor] * 3, axis.bounds[0][0])  # Xu and Yao 2001, eq. 56
        return Pid(_core.PidParameters(kp=kp, ki=ki, kd=kd, mass=axis.mass, viscous=axis.viscous, **known))
    if name == "output_feedback_arc":
        mass, viscous, _, disturbance = axis.bounds
        printed = epoxy_motor.arc_parameters()
        known["theta"] = [1.0 / axis.mass, axis.viscous / axis.mass, 0.0]
        known["theta_min"] = [1.0 / mass[1], viscous[0] / mass[1], disturbance[0] / mass[0]]
        known["theta_max"] = [1.0 / mass[0], viscous[1] / mass[0], disturbance[1] / mass[0]]
        known |= {gain: factor * getattr(printed, gain) for gain in ("gain_1", "gain_2", "observer_gain_1")}
        known["observer_gain_2"] = factor**2 * printed.observer_gain_2
        known["adaptation"] = [(factor * AXIS.mass / axis.mass) ** 2 * rate for rate in printed.adaptation]
        return OutputFeedbackArc(printed.replace(**known))
    if name == "observer_based":
        problem = observer_problem(POLE_RADII[name], axis, factor, SLOW_DECAY_RATE)
        gain = design_observer(problem).observer_gain if observer_gain is None else observer_gain
        return ObserverBased(problem.controller_parameters(list(gain), sample_rate=SAMPLE_RATE, mass=axis.mass))
    law, structure = name.split()
    gains: dict[str, Any] = {"error_gain": factor * axis.error_gain, "feedback_gain": factor * axis.feedback_gain}
    return (Arc if law == "arc" else Dcarc)(gantry.controller_parameters(axis, structure, **gains))


def observer_problem(
    pole_radius: float, axis: GantryAxis = AXIS, factor: float = 1.0, decay_rate: float = DECAY_RATE
) -> ObserverProblem:
    """Return Theorem 3 of Malaize and Levine 2009 for an axis: its first three harmonics; factor: on all poles."""
    fields: dict[str, Any] = {"periods": [gantry.PITCH / harmonic for harmonic in axis.compensated]}
    fields |= {"velocity_min": VELOCITY_RATIO * axis.velocity, "velocity_max": axis.velocity}
    fields |= {"viscous": axis.viscous / axis.mass, "omega": -POLE * factor, "pole_radius": pole_radius * factor}
    return ObserverProblem(decay_rate=decay_rate, **fields)


# Runs and tables ------------------------------------------------------------------------------------------------------


def machine(mass_factor: float = 1.0, axis: GantryAxis = AXIS, more: Sequence[Any] = ()) -> Plant:
    """Return an axis with its calibrated cogging, a payload or less mass, and further effects."""
    cogging = gantry.cogging_map(axis, gantry.shipped_amplitudes(axis))
    return gantry.plant(axis, cogging, more, mass=mass_factor * axis.mass)


def measure(
    controller: ListedController,
    axis: GantryAxis = AXIS,
    more: Sequence[Any] = (),
    payloads: Mapping[str, float] = PAYLOADS,
) -> tuple[dict[str, float], Log | None]:
    """Return the indexes of a controller over the last move there and back, and its log; infinite if it diverges."""
    motion = gantry.reference(axis)

    def run(mass_factor: float) -> Log | None:
        try:
            return Log.of(_core.closed_loop(machine(mass_factor, axis, more), controller, motion))
        except DivergedError:
            return None

    begin = time.perf_counter()
    log = run(1.0)
    seconds = time.perf_counter() - begin
    if log is None:
        return dict.fromkeys(UNITS, float("inf")), None
    last = gantry.last_performance(log, motion)
    found = {"rms": last.error_rms, "max": last.error_max, "u_rms": last.command_rms}
    found |= {"chatter": last.command_change_rms, "step": seconds / len(log)}
    found["transient"] = float(np.abs(log.error[log.time < motion.period]).max())
    for name, factor in payloads.items():
        other = run(factor)
        found[name] = float("inf") if other is None else gantry.last_performance(other, motion).error_rms
    return found, log


@dataclass(frozen=True, eq=False, repr=False)
class Comparison(Table):
    """A table with a row for each controller and a column for each index on the screen."""

    def text(self) -> str:
        """Return the table for the screen."""
        units = {row.index: row.unit for row in self.rows}
        shown = {"m": ("um", 1e6), "s": ("ns", 1e9)}
        width = max(21, *(len(row.name) for row in self.rows))
        lines = [self.title, f"{'':4}{'controller':<{width}}" + "".join(f"{index:>11}" for index in units)]
        lines.append(f"{'':{width + 4}}" + "".join(f"{shown.get(unit, (unit, 1.0))[0]:>11}" for unit in units.values()))
        for start in range(0, len(self.rows), len(units)):
            part = self.rows[start : start + len(units)]
            numbers = (f"{row.simulated * shown.get(row.unit, ('', 1.0))[1]:11.4g}" for row in part)
            lines.append(f"{'':4}{part[0].name:<{width}}" + "".join(numbers))
        return "\n".join(lines)


def winners_table(found: Found) -> Table:
    """Tabulate for each of USES the controller with the smallest (worst relative) index, and the next one's lag."""
    rows = []
    for use, (index, place) in USES.items():
        shown = [place] if place else list(MACHINES)
        best = {each: min(found[each, name][index] for name in SCALED) for each in shown}
        worst = {name: max(found[each, name][index] / best[each] for each in shown) for name in SCALED}
        first, second = sorted(worst, key=lambda name: worst[name])[:2]
        labels = {"for": use, "next": second, "machine": place or "all"}
        rows.append(explored(first, f"{index}, lead", "1", worst[second] / worst[first], **labels))
    title = "The winner by use, at equal delay margin, and by how much the next is behind"
    return Table("winners", title, rows)


def reproduce(progress: Callable[[str], None] = lambda step: None) -> Reproduction:
    """Run every controller; `progress` is called with each step."""
    own = {}
    for name, controller in controllers().items():
        own[name], _ = measure(controller)
        progress(name)
    rows = [explored(name, index, unit, own[name][index]) for name in own for index, unit in UNITS.items()]
    title = "The three papers' controllers on one axis (X of Lu et al. 2008), by their own rules; exploratory"
    tables: list[Table] = [Comparison("comparison", title, rows)]

    equal = {name: at_equal_margin(axis) for name, axis in AXES.items()}
    heavy = {"rms_heavy": PAYLOADS["rms_heavy"]}
    found, logs = {}, {}
    for name in SCALED:
        for place, (axis, more) in MACHINES.items():
            found[place, name], logs[place, name] = measure(equal[axis.name][name], axis, more, heavy)
        progress(f"{name}, equal margin")
    rows = [
        explored(name, index, unit, found[place, name][index], machine=place)
        for place in MACHINES
        for name in SCALED
        for index, unit in UNITS.items()
        if index not in ("step", "rms_light")
    ]
    title = f"The same at equal delay margin ({1e3 * DELAY_MARGIN:g} ms), on both axes and outside all models"
    tables += [Comparison("equal_margin", title, rows), winners_table(found)]
    figures = {"comparison": figure_errors(logs), "comparison_trade": figure_trade(own, found)}
    return Reproduction("comparison", tables, figures)


# Figures --------------------------------------------------------------------------------------------------------------


@drawn
def figure_errors(logs: Mapping[tuple[str, str], Log | None]) -> Figure:
    """Draw the errors of the last move forth over the position, cut off at three times the median of the largest."""
    title = f"Tracking errors of the last move forth at equal delay margin ({1e3 * DELAY_MARGIN:g} ms), cut off"
    figure, panels = titled_panels(title, (8.0, 2.6 * len(MACHINES)), len(MACHINES), sharex=True)
    for axes, (place, (axis, _)) in zip(panels, MACHINES.items(), strict=True):
        motion = gantry.reference(axis)
        start, largest = motion.end - motion.period, []
        for number, name in enumerate(SCALED):
            if (log := logs[place, name]) is not None:
                rows = (log.time >= start) & (log.time < start + motion.move_time)
                colour = look(number)["color"]
                axes.plot(1e3 * log.position[rows], 1e6 * log.error[rows], color=colour, linewidth=0.7, label=name)
                largest.append(1e6 * float(np.abs(log.error[rows]).max()))
        end = 3.0 * float(np.median(largest))
        axes.set(ylabel="error (µm)", ylim=(-end, end))
        axes.set_title(f"machine {place}", loc="left", fontsize="small")
    panels[-1].set(xlabel="position (mm)")
    figure.legend(*panels[0].get_legend_handles_labels(), loc="outside lower center", ncols=4, frameon=False)
    return figure


@drawn
def figure_trade(own: Mapping[str, Mapping[str, float]], found: Found) -> Figure:
    """Draw rms error against chatter: filled at equal delay margin, hollow by the papers' own rules on X."""
    title = f"Rms error and chatter at equal delay margin ({1e3 * DELAY_MARGIN:g} ms); hollow: by the own rule"
    figure, panels = titled_panels(title, (9.0, 4.2), 1, len(MACHINES), sharey=True)
    for axes, place in zip(panels, MACHINES, strict=True):
        for number, name in enumerate(SCALED):
            style = {**look(number), "linestyle": "none", "markersize": 8}
            point, hollow = found[place, name], {**style, "markerfacecolor": "none"}
            if place == "X":
                axes.loglog(own[name]["chatter"], 1e6 * own[name]["rms"], marker(number), **hollow)
            axes.loglog(point["chatter"], 1e6 * point["rms"], marker(number), **style, label=name)
        axes.set(xlabel="chatter (V)")
        axes.set_title(f"machine {place}", loc="left", fontsize="small")
    panels[0].set(ylabel="rms error (µm)")
    figure.legend(*panels[0].get_legend_handles_labels(), loc="outside lower center", ncols=4, frameon=False)
    return figure
