"""The PID with its poles at -320 of Xu and Yao 2001 (section 4.3): unstable in their experiments, and possible causes.

On a rigid axis with the calibrated delay both -300 and -320 are stable. Two properties that the paper does not report
would make only -320 unstable: a longer delay, or a structural mode (`effects.FlexibleMode`).
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from itertools import pairwise, product

import numpy as np

from cogging import effects
from cogging._core import AxisParameters, OutputFeedbackArc, Pid, Plant, smooth_sign
from cogging.design.linear_plant import held, linear_plant
from cogging.model.controller import ListedController
from cogging.model.model import Model
from cogging.papers.result import Table, explored
from cogging.papers.xu2001 import epoxy_motor
from cogging.papers.xu2001.epoxy_motor import MASSES, SAMPLE_RATE, Unknowns, pid_parameters
from cogging.simulation.batch import closed_loop_batch

POLES = (-300.0, -320.0)  # 1/s: of Table 1, and those that the paper found unstable (section 4.3)
DAMPING = 0.01  # of the mode, assumed
FREQUENCIES = (250.0, 300.0, 400.0)  # Hz: possible modes
SIMULATED = 300.0  # Hz: the mode that is simulated
BELOW = 0.995  # of the load that makes -300 unstable: the load that is simulated


@dataclass(frozen=True)
class Loop:
    """The PID (57) about a speed on an axis with a delay and, if its load is above 0, a mode."""

    pole: float  # 1/s, all three
    mass: float  # V/(m/s^2)
    delay: float  # s, from reading to acting command
    frequency: float = 0.0  # Hz, of the mode
    mass_ratio: float = 0.0  # load over total
    at_rest: bool = False  # friction and its compensation have the slope of rest; otherwise that of motion, none

    def radius(self) -> float:
        """Return the largest |eigenvalue| from sample to sample, exact for a held command; above 1 it is unstable.

        The states are those of the axis, the commands that still act, the previous error and the sum of the errors.
        """
        slope = epoxy_motor.FRICTION_LEVEL * float(smooth_sign(1e-9, epoxy_motor.FRICTION_WIDTH)) / 1e-9
        friction = slope if self.at_rest else 0.0
        axis = AxisParameters(mass=self.mass, viscous=epoxy_motor.VISCOUS + friction)
        model = Model(axis, effects=[effects.CommandDelay(delay=self.delay), *self.modes()])
        machine = held(linear_plant(model), 1.0 / SAMPLE_RATE)
        p = pid_parameters(pole=self.pole)
        rate = (p.kd - p.viscous - friction) * SAMPLE_RATE
        states, late = machine.transition.shape[0], machine.whole + 1
        size = states + late + 2
        output = np.append(machine.output[0], np.zeros(late + 2))
        previous, total = np.eye(size)[size - 2], np.eye(size)[size - 1]
        law = -(p.kp + p.ki / SAMPLE_RATE + rate) * output + rate * previous - p.ki / SAMPLE_RATE * total
        commands = np.vstack([law, np.eye(size)[states : states + late]])  # of this sample, and of those before
        step = np.zeros((size, size))
        step[:states, :states] = machine.transition
        now, before = commands[machine.whole][None], commands[machine.whole + 1][None]
        step[:states] += machine.now @ now + machine.before @ before
        step[states : states + late] = commands[:late]
        step[size - 2], step[size - 1] = output, total + output
        return float(np.abs(np.linalg.eigvals(step)).max())

    def modes(self) -> list[effects.FlexibleMode]:
        """Return the mode as an effect of a plant; empty if there is none."""
        if self.mass_ratio == 0.0:
            return []
        return [effects.FlexibleMode(frequency=self.frequency, damping_ratio=DAMPING, mass_ratio=self.mass_ratio)]


def edge(radius: Callable[[float], float], values: Sequence[float]) -> float:
    """Return the value at which a loop becomes unstable, within rising coarse values from a stable one; NaN: none."""
    from scipy.optimize import brentq

    for below, above in pairwise(values):
        if radius(above) >= 1.0:
            return float(brentq(lambda value: radius(value) - 1.0, below, above, xtol=1e-4 * above))
    return float("nan")


def delay_limit(pole: float, mass: float, at_rest: bool = False) -> float:
    """Return the delay (s) from which the rigid axis is unstable."""
    return edge(lambda delay: Loop(pole, mass, delay, at_rest=at_rest).radius(), [0.0, 1e-3, 2e-3])


def load_limit(pole: float, mass: float, delay: float, frequency: float) -> float:
    """Return the load over the total mass from which a mode (Hz) is unstable; NaN: stable up to 0.3."""
    return edge(lambda ratio: Loop(pole, mass, delay, frequency, ratio).radius(), [1e-4, 0.05, 0.1, 0.2, 0.3])


def just_below(unknowns: Unknowns, frequency: float, limit: float) -> Loop:
    """Return a mode just below the load that makes -300 unstable."""
    return Loop(POLES[0], MASSES["1"], unknowns.delay, frequency, BELOW * limit)


def simulated(
    unknowns: Unknowns, mode: Loop, duration: float = epoxy_motor.DURATION
) -> dict[str, tuple[str, str, float]]:
    """Run set 1 on the calibrated plant with a mode; return index, unit and value: e_M, or when the run diverges."""
    laws: dict[str, ListedController] = {f"PID at {pole:g}": Pid(pid_parameters(pole=pole)) for pole in POLES}
    laws["ARC"] = OutputFeedbackArc(epoxy_motor.arc_parameters())
    rigid = epoxy_motor.plant(unknowns, "1")
    machine = Plant(rigid.axis, effects=[*rigid.effects, *mode.modes()], encoder=rigid.encoder)
    motion, seeds = epoxy_motor.reference(), [epoxy_motor.SEED] * len(laws)
    batch = closed_loop_batch([machine] * len(laws), list(laws.values()), motion, duration=duration, seeds=seeds)
    found = dict(zip(laws, (("e_M", "m", error) for error in batch.indexes["error_max"].tolist()), strict=True))
    return found | {list(laws)[failure.run]: ("diverges_at", "s", failure.time) for failure in batch.failures}


def pid_poles_table(unknowns: Unknowns) -> Table:
    """Tabulate where -300 and -320 become unstable: by a delay, by a mode; and one such mode simulated."""
    rows = []
    for (set_name, where), pole in product((("1", "in motion"), ("2", "at rest")), POLES):
        limit = delay_limit(pole, MASSES[set_name], where == "at rest")
        rows.append(explored(f"PID at {pole:g}", "delay_limit", "s", limit, set=set_name, friction=where))
    limits = {}
    for frequency, pole in product(FREQUENCIES, POLES):
        limit = limits[frequency, pole] = load_limit(pole, MASSES["1"], unknowns.delay, frequency)
        rows.append(explored(f"PID at {pole:g}", "load_limit", "1", limit, set="1", mode=f"{frequency:g} Hz"))
    mode = just_below(unknowns, SIMULATED, limits[SIMULATED, POLES[0]])
    said = f"{SIMULATED:g} Hz, load {100 * mode.mass_ratio:.1f} %"
    rows += [explored(name, *found, set="1", mode=said) for name, found in simulated(unknowns, mode).items()]
    return Table("pid_poles", "PID poles at -320: what makes them unstable and those at -300 not", rows)
