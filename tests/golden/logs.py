"""The closed loops that the golden comparison runs: every controller and every effect, by fields alone.

Only `cogging.Model.from_dict`, `cogging.simulate` and a log's `time`, `position` and `command` are used, so that what
is behind them may be rebuilt.
"""

from typing import Any

import numpy as np

import cogging
from tests.fixtures.plants_by_hand import EXAMPLES

WIDTHS = {"sticking": 0.0, "smooth": 1.11e-3}  # m/s, of S(v)

# The X axis of Lu et al. 2008, near enough: M 0.12, B 0.166, Fc 0.15, a pitch of 50 mm.
FRICTION = {"mass": 0.12, "viscous": 0.166, "coulomb": 0.15, "coulomb_width": 1.11e-3}
RATE = {"sample_rate": 5000.0}
ADAPTIVE = FRICTION | RATE
ADAPTIVE |= {"mass_adaptation": 1e-3, "viscous_adaptation": 0.05, "coulomb_adaptation": 2.0, "disturbance": 0.01}
ADAPTIVE |= {"disturbance_adaptation": 50.0, "cogging_harmonics": [1, 2], "cogging_control_points": 13}
ADAPTIVE |= {"cogging_origin": -0.05, "cogging_adaptation": 20.0, "epsilon": 0.05, "disturbance_bound": 0.02}
PID = {"kp": 9600.0, "ki": 1e5, "kd": 48.0, "feedforward_velocity": "measured", "command_limit": 1.5}
OBSERVER = [875.271, 406594.0, 16382100.0, 54587200.0, 9999140.0, 39986800.0, 41501700.0, -5471680.0, 51261100.0]
CONTROLLERS: dict[str, dict[str, Any]] = {
    "pid": FRICTION | RATE | PID,
    "cascade": FRICTION | RATE | {"kp": 160.0, "kv": 40.0},
    "speed": FRICTION | RATE | {"kp": 30.0, "delay": 5e-4},
    "arc": ADAPTIVE,
    "dcarc": ADAPTIVE,
    "output_feedback_arc": RATE
    | {"theta": [1 / 0.12, 0.166 / 0.12, 0.0], "theta_min": [5.0, 0.0, -10.0]}
    | {"theta_max": [10.0, 10.0, 10.0], "coulomb": 0.15, "coulomb_width": 1.11e-3},
    "observer_based": RATE
    | {"periods": [0.05, 0.025, 0.05 / 3], "observer_gain": OBSERVER, "position_gain": 9e4}
    | {"velocity_gain": 600.0 - 0.166 / 0.12, "mass": 0.12, "viscous": 0.166 / 0.12, "velocity_min": 5e-3},
}
MOTION = {"type": "point_to_point", "start": 0.05, "distance": 0.2, "velocity": 0.5, "acceleration": 10.0}
MOTION |= {"jerk": 1000.0, "dwell": 0.1, "repeats": 1}

#: Every effect at values that show in the motion of LOOP, by name: those of the tests of the plant, but for these.
OTHERS = {"end_effect": {"force": 0.9, "decay_length": 0.06}, "command_delay": {"delay": 1.37e-3}}
OTHERS |= {"actuator_lag": {"time_constant": 1.3e-3}, "command_saturation": {"limit": 2.4}}
LAST = "empirical_force"
NAMES = [*(name for name in EXAMPLES if name != LAST), LAST]  # in the order of values.json
EFFECTS: dict[str, dict[str, Any]] = {name: OTHERS.get(name, EXAMPLES[name][0]) for name in NAMES}
LOOP = {  # M (s + 80)^3 = M s^3 + (B + kd) s^2 + kp s + ki
    "controller": {"type": "pid", "sample_rate": 2000.0, "kp": 5760.0, "ki": 153600.0, "kd": 70.0},
    "encoder": {"resolution": 1e-7, "noise": 1e-7},
    "noise": {"force": 0.02, "bandwidth": 40.0},
}
STROKE = {"type": "point_to_point", "start": 0.01, "distance": 0.2, "velocity": 0.4, "acceleration": 4.0, "jerk": 200.0}


def controller_log(controller: str, friction: str) -> Any:
    """A controller on the axis of Lu et al., with cogging whose amplitude changes along the travel."""
    sine, cosine = np.multiply.outer([[0.06, 0.03], [0.02, -0.01]], 1 + 0.4 * np.sin(0.9 * np.arange(13))).tolist()
    document = {
        "axis": FRICTION | {"coulomb_width": WIDTHS[friction], "travel": [0.0, 0.51]},
        "cogging": {"pitch": 0.05, "harmonics": [1, 2], "order": 3, "origin": -0.05, "sine": sine, "cosine": cosine},
        "encoder": {"resolution": 0.5e-6, "noise": 2e-7},
        "noise": {"force": 0.01, "bandwidth": 50.0},
        "controller": {"type": controller, **CONTROLLERS[controller]},
    }
    return cogging.simulate(cogging.Model.from_dict(document), MOTION, seed=11)


def effect_log(names: list[str], friction: str) -> Any:
    """A PID on an axis with these effects."""
    document = LOOP | {
        "axis": {"mass": 0.3, "viscous": 2.0, "coulomb": 0.6, "coulomb_width": 10 * WIDTHS[friction]}
        | {"travel": [-0.15, 0.55]},
        "effects": [{"name": name, **EFFECTS[name]} for name in names],
    }
    return cogging.simulate(cogging.Model.from_dict(document), STROKE, seed=12, steps_per_sample=2)


def summary(log: Any) -> list[float]:
    """Number of rows, and the rms and last value of the position and the command."""
    columns = np.array([log.position, log.command])
    return [len(log.time), *np.sqrt(np.mean(columns**2, axis=1)).tolist(), *columns[:, -1].tolist()]
