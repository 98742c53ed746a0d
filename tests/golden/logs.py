"""The closed loops that the golden comparison runs: every controller, every effect, every motion, by fields alone.

Only `cogging.Model.from_dict`, `cogging.simulate` and a log's `time`, `position` and `command` are used, so that what
stands behind them may be rebuilt.
"""

from __future__ import annotations

import hashlib
from typing import Any

import numpy as np

import cogging

WIDTHS = {"sticking": 0.0, "smooth": 1.11e-3}  # m/s, of S(v)
COLUMNS = ("time", "position", "command")

# The X axis of Lu et al. 2008, near enough: M 0.12, B 0.166, Fc 0.15, a pitch of 50 mm.
FRICTION = {"mass": 0.12, "viscous": 0.166, "coulomb": 0.15, "coulomb_width": 1.11e-3}
ADAPTIVE = FRICTION | {
    "sample_rate": 5000.0,
    "mass_adaptation": 1e-3,
    "viscous_adaptation": 0.05,
    "coulomb_adaptation": 2.0,
    "disturbance": 0.01,
    "disturbance_adaptation": 50.0,
    "cogging_harmonics": [1, 2],
    "cogging_control_points": 13,
    "cogging_origin": -0.05,
    "cogging_adaptation": 20.0,
    "epsilon": 0.05,
    "disturbance_bound": 0.02,
}
CONTROLLERS: dict[str, dict[str, Any]] = {
    "pid": FRICTION
    | {"sample_rate": 5000.0, "kp": 9600.0, "ki": 1e5, "kd": 48.0, "feedforward_velocity": "measured"}
    | {"command_limit": 1.5},
    "cascade": FRICTION | {"sample_rate": 5000.0, "kp": 160.0, "kv": 40.0},
    "speed": FRICTION | {"sample_rate": 5000.0, "kp": 30.0, "delay": 5e-4},
    "arc": ADAPTIVE,
    "dcarc": ADAPTIVE,
    "output_feedback_arc": {
        "sample_rate": 5000.0,
        "theta": [1 / 0.12, 0.166 / 0.12, 0.0],
        "theta_min": [5.0, 0.0, -10.0],
        "theta_max": [10.0, 10.0, 10.0],
        "coulomb": 0.15,
        "coulomb_width": 1.11e-3,
    },
    "observer_based": {
        "sample_rate": 5000.0,
        "periods": [0.05, 0.025, 0.05 / 3],
        "observer_gain": [
            *(875.271, 406594.0, 16382100.0, 54587200.0, 9999140.0),
            *(39986800.0, 41501700.0, -5471680.0, 51261100.0),
        ],
        "position_gain": 9e4,
        "velocity_gain": 600.0 - 0.166 / 0.12,
        "mass": 0.12,
        "viscous": 0.166 / 0.12,
        "velocity_min": 5e-3,
    },
}
TIMES = np.arange(0.0, 1.2005, 5e-4)
MOTIONS: dict[str, dict[str, Any]] = {
    "point_to_point": {"start": 0.05, "distance": 0.2, "velocity": 0.5, "acceleration": 10.0, "jerk": 1000.0}
    | {"dwell": 0.1, "repeats": 1},
    "sine": {"center": 0.2, "amplitude": 0.1, "frequency": 0.9, "duration": 1.2},
    "filtered_sine": {"center": 0.2, "amplitude": 0.05, "duration": 1.2},
    "sampled": {"time": TIMES.tolist(), "reference": (0.2 + 0.08 * np.sin(3 * TIMES) ** 3).tolist()},
}

#: Every effect at values that show in the motion of LOOP, by name.
EFFECTS: dict[str, dict[str, Any]] = {
    "constant_force": {"force": -0.7},
    "cable_spring": {"stiffness": 13.0, "center": 0.04},
    "end_effect": {"force": 0.9, "decay_length": 0.06},
    "local_force": {"force": -0.6, "center": 0.12, "width": 0.02},
    "gravity": {"moment": 0.8, "angle": 0.4},
    "cogging_harmonic": {"period": 0.023, "sine": 0.9, "cosine": -0.4},
    "cogging_modulation": {"period": 0.025, "sine": [0.5, 0.2, -0.4, 0.8, 0.1], "cosine": [-0.3, 0.6, 0.2, 0.0, 0.4]}
    | {"pitch": 0.04, "order": 4, "origin": 0.005},
    "coulomb_asymmetry": {"difference": 0.3},
    "viscous_asymmetry": {"difference": 2.4},
    "stribeck_friction": {"static_excess": 0.5, "velocity": 0.03, "exponent": 1.3},
    "presliding_friction": {"stiffness": 3e3, "damping": 2.0},
    "position_dependent_friction": {"nodes": [0.03, 0.05, 0.06, 0.2], "levels": [0.1, 0.5, -0.1, 0.3]},
    "quadratic_drag": {"coefficient": 6.0},
    "force_constant_ripple": {"period": 0.031, "sine": 0.12, "cosine": -0.07},
    "force_constant_drift": {"change": -0.3, "time_constant": 0.15},
    "command_delay": {"delay": 1.37e-3},
    "actuator_lag": {"time_constant": 1.3e-3},
    "command_saturation": {"limit": 2.4},
    "command_dead_zone": {"width": 0.2},
    "encoder_periodic_error": {"period": 0.004, "sine": 3e-5, "cosine": -2e-5},
    "encoder_scale_error": {"scale": 0.004},
    "backlash": {"gap": 4e-4, "mass_ratio": 0.4, "contact_frequency": 40.0, "contact_damping_ratio": 0.2},
    "flexible_mode": {"frequency": 23.0, "damping_ratio": 0.05, "mass_ratio": 0.35},
    "disturbance_step": {"force": 2.0, "start": 0.1037, "stop": 0.2291},
    "disturbance_tone": {"frequency": 11.0, "sine": 0.8, "cosine": -1.1},
    "empirical_force": {
        "position_nodes": [0.03, 0.05, 0.2],
        "position_forces": [0.1, -0.5, 0.3],
        "velocity_nodes": [-0.4, 0.0, 0.1, 0.6],
        "velocity_forces": [0.2, 0.0, 0.4, -0.3],
        "time_nodes": [0.1, 0.3],
        "time_forces": [-0.2, 0.7],
    },
}
#: An axis has one load, and a command that is cut does not hold all of these.
TOGETHER = sorted(set(EFFECTS) - {"backlash", "command_saturation"})
LOOP = {  # M (s + 80)^3 = M s^3 + (B + kd) s^2 + kp s + ki
    "controller": {"type": "pid", "sample_rate": 2000.0, "kp": 5760.0, "ki": 153600.0, "kd": 70.0},
    "encoder": {"resolution": 1e-7, "noise": 1e-7},
    "noise": {"force": 0.02, "bandwidth": 40.0},
}
STROKE = {"type": "point_to_point", "start": 0.01, "distance": 0.2, "velocity": 0.4, "acceleration": 4.0, "jerk": 200.0}


def controller_log(controller: str, motion: str, friction: str) -> Any:
    """A controller on the axis of Lu et al., with cogging whose amplitude changes along the travel."""
    rows = np.array([[0.06, 0.03], [0.02, -0.01]])
    along = 1 + 0.4 * np.sin(0.9 * np.arange(13))
    document = {
        "axis": FRICTION | {"coulomb_width": WIDTHS[friction], "travel": [0.0, 0.51]},
        "cogging": {"pitch": 0.05, "harmonics": [1, 2], "order": 3, "origin": -0.05}
        | {
            name: [[float(a * s) for s in along] for a in row]
            for name, row in zip(("sine", "cosine"), rows, strict=True)
        },
        "encoder": {"resolution": 0.5e-6, "noise": 2e-7},
        "noise": {"force": 0.01, "bandwidth": 50.0},
        "controller": {"type": controller, **CONTROLLERS[controller]},
    }
    return cogging.simulate(cogging.Model.from_dict(document), {"type": motion, **MOTIONS[motion]}, seed=11)


def effect_log(names: list[str], friction: str) -> Any:
    """A PID on an axis with these effects."""
    document = LOOP | {
        "axis": {"mass": 0.3, "viscous": 2.0, "coulomb": 0.6, "coulomb_width": 10 * WIDTHS[friction]}
        | {"travel": [-0.15, 0.55]},
        "effects": [{"name": name, **EFFECTS[name]} for name in names],
    }
    return cogging.simulate(cogging.Model.from_dict(document), STROKE, seed=12, steps_per_sample=2)


def known() -> dict[str, set[str]]:
    """What the package itself lists: controllers, motions and effects by name."""
    parts = cogging.schema()["$defs"]
    controllers = parts["model"]["properties"]["controller"]["oneOf"]
    return {
        "controllers": {one["properties"]["type"]["const"] for one in controllers},
        "motions": {one["properties"]["type"]["const"] for one in parts["reference"]["oneOf"]},
        "effects": set(cogging.EFFECTS),
    }


def summary(log: Any) -> dict[str, Any]:
    """The bytes' hash and some numbers of each column of a log."""
    told: dict[str, Any] = {"rows": len(log.time)}
    for name in COLUMNS:
        column = np.ascontiguousarray(getattr(log, name), dtype=np.float64)
        told[name] = {
            "sha256": hashlib.sha256(column.tobytes()).hexdigest(),
            "rms": float(np.sqrt(np.mean(column**2))),
            "largest": float(np.abs(column).max()),
            "middle": float(column[len(column) // 2]),
            "last": float(column[-1]),
        }
    return told


def summaries() -> dict[str, Any]:
    """Of every controller on every motion, and of every effect and of all together, with both kinds of friction."""
    told = {}
    for friction in WIDTHS:
        for controller in CONTROLLERS:
            for motion in MOTIONS:
                log = controller_log(controller, motion, friction)
                told[f"controller {controller}, {motion}, {friction}"] = summary(log)
        for name in EFFECTS:
            told[f"effect {name}, {friction}"] = summary(effect_log([name], friction))
        told[f"effects together, {friction}"] = summary(effect_log(TOGETHER, friction))
    return told
