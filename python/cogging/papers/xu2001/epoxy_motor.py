"""The setup of Xu and Yao 2001: printed numbers, plant, controllers, references and indexes of Table 1.

Sources are cited as (Table 1), (eq. n), (section). Values that the paper does not report are calibrated
(studies.xu2001.calibration): the plant on the PID columns; plant, scale of the adaptation rates and previous knowledge
of the ARC on all columns.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from cogging import _core, effects
from cogging._core import FilteredSine, OutputFeedbackArc, OutputFeedbackArcParameters, Pid, PidParameters, Plant
from cogging.arrays import FloatArray
from cogging.design.pid import pid_gains
from cogging.files import shipped_toml
from cogging.logs.log import Log
from cogging.model.controller import ListedController
from cogging.simulation.batch import closed_loop_batch

SAMPLE_RATE = 2500.0  # Hz (section 4.3)
RESOLUTION = 1e-6  # m (section 4.1)
FRICTION_LEVEL = 0.1  # V: (0.2 / pi) arctan(900 v) = 0.1 S(v) (section 4.3, both controllers)
FRICTION_WIDTH = 1.0 / 900.0  # m/s (same)
#: What the parameters of both controllers share.
OF_BOTH = {"sample_rate": SAMPLE_RATE, "coulomb": FRICTION_LEVEL, "coulomb_width": FRICTION_WIDTH}
VISCOUS = 2.73 / 10.0  # V/(m/s): theta_2 / theta_1 of (52); assumed without payload too
MASSES = {"1": 1.0 / 37.0, "2": 1.0 / 10.0, "3": 1.0 / 37.0}  # V/(m/s^2) (sections 4.1, 4.3)
DISTURBANCE = (0.5, 2.2, 7.2)  # V, s, s: set 3 (section 4.3)
PID_POLE, PID_MASS = -300.0, 0.02  # 1/s, V/(m/s^2): three poles (section 4.3)
PERIOD = np.pi / 2.0  # s, of the sine of case 1
DURATION = 10.0  # s: T_f, not reported; the rms commands of the PID give 9.6 to 10.6
FINAL_WINDOW = 2.0  # s (section 4.2)
TRAVEL = (-0.3, 0.5)  # m: not reported, no run comes near its ends
SEED = 2001  # of the encoder noise of a run in a figure
SEEDS = tuple(range(SEED, SEED + 8))  # Table 1 is fitted and shown as the mean over these

SETS = ("1", "2", "3")
CONTROLLERS = ("PID", "ARC")
INDEXES = ("e_M", "e_F", "e_rms", "u_rms", "du_rms", "c_u")
CORE_INDEXES = ("error_max", "error_final_max", "error_rms", "command_rms", "command_change_rms", "command_chatter")
UNITS = ("m", "m", "m", "V", "V", "1")

#: Table 1: e_M, e_F, e_rms (m), u_rms, du_rms (V), c_u by controller and set.
TABLE_1: dict[str, dict[str, Sequence[float]]] = shipped_toml("papers/xu2001/printed.toml")["table_1"]

JOINT_LAW = "smooth_coulomb_without_offset"
#: The numbers of Table 1 that a fit uses: sets by controller; those of a held-out fit, which predicts the others.
PID: Mapping[str, Sequence[str]] = {"PID": SETS}
ALL: Mapping[str, Sequence[str]] = {"PID": SETS, "ARC": SETS}
HELD_OUT: dict[str, Mapping[str, Sequence[str]]] = {
    "set_2": {"PID": ("1", "3"), "ARC": ("1", "3")},
    "arc_sets_2_3": {"PID": SETS, "ARC": ("1",)},
}
#: The fitted indexes: du_rms = c_u u_rms is printed to one digit.
FITTED = ("e_M", "e_F", "e_rms", "u_rms", "c_u")


@dataclass(frozen=True)
class Unknowns:
    """Properties of the plant that the paper does not report; calibrated."""

    coulomb: float  # V
    coulomb_width: float  # m/s; 0 = sgn with sticking
    static_excess: float  # V, (3) with exponent 2
    stribeck_velocity: float  # m/s
    offset: float  # V, a constant force
    delay: float  # s, from reading to acting command
    encoder_noise: float  # m rms
    ripple: float  # V, of one spatial harmonic
    ripple_period: float  # m


#: Free parameters of the fits to the PID's numbers and to all; earlier_runs is chosen among 0 to 3.
PID_FREE = tuple(Unknowns.__dataclass_fields__)
FIXED = ("static_excess", "stribeck_velocity", "offset")  # those that JOINT_LAW lacks
JOINT_FREE = (*(name for name in PID_FREE if name not in FIXED), "adaptation_factor", "earlier_runs")


def shipped_unknowns(law: str = "smooth_stribeck") -> Unknowns:
    """Return the unknowns calibrated on the PID columns, by friction law."""
    return Unknowns(**shipped_file()[law]["unknowns"])


def plant(unknowns: Unknowns, set_name: str, **axis_changes: Any) -> Plant:
    """Return the machine of a set: payload in set 2, the 0.5 V step in set 3."""
    friction = {"viscous": VISCOUS, "coulomb": unknowns.coulomb, "coulomb_width": unknowns.coulomb_width}
    axis = _core.AxisParameters(mass=MASSES[set_name], travel=list(TRAVEL), **friction)
    listed: list[Any] = [
        effects.ConstantForce(force=unknowns.offset),
        effects.CommandDelay(delay=unknowns.delay),
        effects.CoggingHarmonic(period=unknowns.ripple_period, sine=unknowns.ripple),
    ]
    if unknowns.static_excess > 0.0:
        excess, velocity = unknowns.static_excess, unknowns.stribeck_velocity
        listed.append(effects.StribeckFriction(static_excess=excess, velocity=velocity))
    if set_name == "3":
        force, start, stop = DISTURBANCE
        listed.append(effects.DisturbanceStep(force=force, start=start, stop=stop))
    encoder = _core.EncoderParameters(resolution=RESOLUTION, noise=unknowns.encoder_noise)
    return Plant(axis.replace(**axis_changes), effects=listed, encoder=encoder)


def pid_parameters(pole: float = PID_POLE, **changes: Any) -> PidParameters:
    """Return the PID (57): three equal poles for M_min = 0.02; M(0) = 0.05, B(0) = 0.24, of the measured velocity."""
    kp, ki, kd = pid_gains([pole] * 3, PID_MASS)
    own = {"kp": kp, "ki": ki, "kd": kd, "mass": 0.05, "viscous": 0.24, "feedforward_velocity": "measured"}
    return PidParameters(**{**OF_BOTH, **own, **changes})


def arc_parameters(**changes: Any) -> OutputFeedbackArcParameters:
    """Return the ARC as printed (section 4.3) without robust terms, which cannot run (backstepping.py)."""
    return OutputFeedbackArcParameters(**{**OF_BOTH, **shipped_toml("papers/xu2001/printed.toml")["arc"], **changes})


def reference() -> FilteredSine:
    """Return case 1: 0.05 sin(4 t) through the generator (58) with beta_1 = 100, beta_2 = 2500."""
    generator = {"frequency": 4.0 / (2.0 * np.pi), "beta_1": 100.0, "beta_2": 2500.0}
    return FilteredSine(_core.FilteredSineParameters(amplitude=0.05, **generator))


def fast_reference() -> _core.PointToPoint:
    """Return case 2: 1 m/s and 12 m/s^2 back and forth; stroke 0.4 m, dwell 0.5 s and no jerk limit are assumed."""
    limits = {"velocity": 1.0, "acceleration": 12.0}
    return _core.PointToPoint(_core.PointToPointParameters(distance=0.4, dwell=0.5, repeats=3, **limits))


def indexes(log: Log) -> dict[str, float]:
    """Return the six indexes of section 4.2, of the encoder reading minus the reference and of the whole command."""
    found = _core.performance(log.time, log.error, log.command, final_window=FINAL_WINDOW)
    return dict(zip(INDEXES, (getattr(found, name) for name in CORE_INDEXES), strict=True))


def run(unknowns: Unknowns, controller: ListedController, *, seed: int = SEED, earlier_runs: int = 0) -> dict[str, Log]:
    """Return the logs of a controller in the sets of case 1, each after some earlier runs of the same set."""
    machines = [plant(unknowns, name) for name in SETS]
    laws = [after_earlier_runs(machine, controller, earlier_runs, seed) for machine in machines]
    seeds = [seed] * len(machines)
    batch = closed_loop_batch(machines, laws, reference(), duration=DURATION, seeds=seeds, logs=True)
    return dict(zip(SETS, batch, strict=True))


def after_earlier_runs(machine: Plant, controller: ListedController, earlier_runs: int, seed: int) -> ListedController:
    """Return the controller at the start of the run after some runs of the same machine; a PID is unchanged.

    Each next run keeps the estimates of theta_1 and theta_2, of motor and payload; assumed, the paper does not say it.
    """
    if not isinstance(controller, OutputFeedbackArc):
        return controller
    first = controller.parameters
    for number in range(earlier_runs):
        options: dict[str, Any] = {"seed": seed - 1 - number, "record_estimates": True}
        columns = _core.closed_loop(machine, controller, reference(), duration=DURATION, **options)
        theta_1, theta_2, _ = columns["estimates"][-1]
        controller = OutputFeedbackArc(first.replace(theta=[theta_1, theta_2, first.theta[2]]))
    return controller


@dataclass(frozen=True)
class Conditions:
    """One set of unreported conditions."""

    unknowns: Unknowns
    adaptation_factor: float = 1.0  # on the printed rates Gamma (section 4.3)
    earlier_runs: int = 0  # of the same set, from which the ARC keeps theta_1 and theta_2; 0 = the printed theta_hat(0)
    changes: Mapping[str, Any] = field(default_factory=dict)  # of further printed numbers of the ARC

    def arc_parameters(self) -> OutputFeedbackArcParameters:
        """Return the ARC of the first of the runs."""
        adaptation = [self.adaptation_factor * rate for rate in arc_parameters().adaptation]
        return arc_parameters(**{"adaptation": adaptation, **self.changes})

    def controller(self, name: str) -> ListedController:
        """Return a controller of Table 1 at the start of the first of the runs."""
        return Pid(pid_parameters()) if name == "PID" else OutputFeedbackArc(self.arc_parameters())

    def logs(self, controller: str, seed: int = SEED) -> dict[str, Log]:
        """Return the recorded runs of a controller of Table 1, by set."""
        return run(self.unknowns, self.controller(controller), seed=seed, earlier_runs=self.earlier_runs)

    def by_seed(self, controller: str, sets: Sequence[str] = SETS, seeds: Sequence[int] = SEEDS) -> FloatArray:
        """Return the indexes of a controller by set, seed of the encoder noise and index, (sets, seeds, 6)."""
        machines = [plant(self.unknowns, name) for name in sets]
        made = self.controller(controller)
        prepared = [after_earlier_runs(machine, made, self.earlier_runs, seeds[0]) for machine in machines]
        plants, laws = zip(*(pair for pair in zip(machines, prepared, strict=True) for _ in seeds), strict=True)
        options: dict[str, Any] = {"seeds": list(seeds) * len(sets), "final_window": FINAL_WINDOW}
        batch = closed_loop_batch(plants, laws, reference(), duration=DURATION, **options)
        if batch.failures:
            raise _core.DivergedError(batch.failures[0].reason)
        return np.stack([batch.indexes[name] for name in CORE_INDEXES], axis=-1).reshape(len(sets), len(seeds), -1)

    def table(self) -> dict[str, FloatArray]:
        """Return the means of the indexes over SEEDS by controller, (3, 6)."""
        return {controller: self.by_seed(controller).mean(axis=1) for controller in CONTROLLERS}


def shipped_file() -> dict[str, Any]:
    """Return the content of plant.toml (by studies.xu2001.calibration)."""
    return shipped_toml("papers/xu2001/plant.toml")


def conditions_of(part: Mapping[str, Any]) -> Conditions:
    """Return the conditions that a part of plant.toml states."""
    fields = {name: part[name] for name in ("adaptation_factor", "earlier_runs", "changes") if name in part}
    return Conditions(Unknowns(**part["unknowns"]), **fields)


def joint_conditions() -> Conditions:
    """Return the conditions fitted to all numbers of Table 1: those of the reproduced table."""
    return conditions_of(shipped_file()["joint"][JOINT_LAW])
