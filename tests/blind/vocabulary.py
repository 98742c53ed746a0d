"""The effects of the vocabulary as the truth makes them: random sign, off-grid, in other shapes of each cause too."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from . import truth
from .hidden import Hidden, Parameters, add_map, add_row, quadratures, set_scalars, shares, times, wave
from .machines import Machine, log_uniform
from .motions import Motion
from .truth import Plan

Draw = Callable[[np.random.Generator, Machine, Motion], Hidden]
ODD = 0.35  # share of cases with another shape than the usual


def _shape(rng: np.random.Generator, *others: str) -> str:
    return str(rng.choice(others)) if others and rng.random() < ODD else "usual"


def _sign(rng: np.random.Generator) -> float:
    return float(rng.choice([-1.0, 1.0]))


def _one(name: str, value: float, unit: str) -> Parameters:
    return {name: (value, unit, 1.0)}


def _length(machine: Machine) -> float:
    return machine.travel[1] - machine.travel[0]


def constant_force(rng: np.random.Generator, machine: Machine, motion: Motion) -> Hidden:
    sign, peak = _sign(rng), machine.peak
    return Hidden(
        "constant_force",
        "usual",
        1e-3 * peak,
        1e-6 * peak,
        0.5 * peak,
        add_map("force", lambda plan: np.full(plan.maps.shape[1], sign)),
        lambda a: _one("force", sign * a, "V"),
    )


def cable_spring(rng: np.random.Generator, machine: Machine, motion: Motion) -> Hidden:
    shape, sign, peak, length = (
        _shape(rng, "hardening"),
        float(rng.choice([-1, 1, 1, 1])),
        machine.peak,
        _length(machine),
    )
    center = machine.travel[0] + length * rng.uniform(0.1, 0.9)

    def pull(plan: Plan) -> np.ndarray:
        d = (plan.positions - center) / length
        return -sign * (d + 2 * d**3 if shape == "hardening" else d)

    def parameters(a: float) -> Parameters:
        return {} if shape != "usual" else {"stiffness": (sign * a / length, "V/m", 1.0), "center": (center, "m", None)}

    return Hidden("cable_spring", shape, 2e-3 * peak, 1e-5 * peak, 0.5 * peak, add_map("force", pull), parameters)


def end_effect(rng: np.random.Generator, machine: Machine, motion: Motion) -> Hidden:
    shape, sign, peak = _shape(rng, "bell"), _sign(rng), machine.peak
    decay = _length(machine) * rng.uniform(0.03, 0.12)

    def push(plan: Plan) -> np.ndarray:
        left = (plan.positions - machine.travel[0]) / decay
        right = (machine.travel[1] - plan.positions) / decay
        if shape == "bell":
            return sign * (np.exp(-((right / 1.5) ** 2)) - np.exp(-((left / 1.5) ** 2)))
        return sign * (np.exp(-right) - np.exp(-left))

    def parameters(a: float) -> Parameters:
        return {} if shape != "usual" else {"force": (sign * a, "V", 1.0), "decay_length": (decay, "m", None)}

    return Hidden("end_effect", shape, 5e-3 * peak, 1e-5 * peak, 0.5 * peak, add_map("force", push), parameters)


def _free_period(rng: np.random.Generator, machine: Machine) -> float:
    while True:
        period = log_uniform(rng, 4e-3, 0.09)
        if all(abs(np.log(period / known)) > 0.12 for known in machine.periods) and period < 0.4 * _length(machine):
            return period


def cogging_harmonic(rng: np.random.Generator, machine: Machine, motion: Motion) -> Hidden:
    shape, phase, peak = _shape(rng, "harmonics", "flattened"), rng.uniform(0, 2 * np.pi), machine.peak
    period = _free_period(rng, machine)
    return Hidden(
        "cogging_harmonic",
        shape,
        2e-3 * peak,
        1e-5 * peak,
        0.3 * peak,
        add_map("force", lambda plan: -wave(plan.positions, period, phase, shape)),
        lambda a: quadratures("period", period, "V", phase, a) if shape == "usual" else {},
    )


def cogging_modulation(rng: np.random.Generator, machine: Machine, motion: Motion) -> Hidden:
    shape = _shape(rng, "bump", "unknown_period")
    index, phase, peak = int(rng.integers(len(machine.periods))), rng.uniform(0, 2 * np.pi), machine.peak
    period = _free_period(rng, machine) if shape == "unknown_period" else machine.periods[index]
    waves, shift, place = rng.uniform(0.4, 1.3), rng.uniform(0, 2 * np.pi), rng.uniform(0.2, 0.8)

    def force(plan: Plan) -> np.ndarray:
        s = shares(plan, machine)
        if shape == "bump":
            envelope = np.exp(-(((s - place) / 0.15) ** 2))
        elif shape == "unknown_period":
            envelope = 1 + 0.8 * np.sin(2 * np.pi * waves * s + shift)
        else:
            envelope = np.sin(2 * np.pi * waves * s + shift)
        return -envelope * np.sin(2 * np.pi * plan.positions / period + phase)

    return Hidden(
        "cogging_modulation",
        shape,
        4e-3 * peak,
        1e-5 * peak,
        0.3 * peak,
        add_map("force", force),
        lambda a: {"period": (period, "m", None)},
    )


def coulomb_asymmetry(rng: np.random.Generator, machine: Machine, motion: Motion) -> Hidden:
    sign, level = _sign(rng), machine.scalars["coulomb"]

    def apply(plan: Plan, amplitude: float) -> None:
        plan["coulomb_asymmetry"] = sign * amplitude

    return Hidden(
        "coulomb_asymmetry",
        "usual",
        0.02 * level,
        1e-5 * level,
        1.2 * level,
        apply,
        lambda a: _one("difference", sign * a, "V"),
    )


def viscous_asymmetry(rng: np.random.Generator, machine: Machine, motion: Motion) -> Hidden:
    sign, level = _sign(rng), machine.scalars["viscous"]

    def apply(plan: Plan, amplitude: float) -> None:
        plan["viscous_asymmetry"] = sign * amplitude

    return Hidden(
        "viscous_asymmetry",
        "usual",
        0.05 * level,
        1e-5 * level,
        1.5 * level,
        apply,
        lambda a: _one("difference", sign * a, "V/(m/s)"),
    )


def stribeck_friction(rng: np.random.Generator, machine: Machine, motion: Motion) -> Hidden:
    shape, level = _shape(rng, "rational"), machine.scalars["coulomb"]
    speed, exponent = log_uniform(rng, 3e-3, 0.05), float(rng.choice([1.0, 2.0, rng.uniform(0.7, 2.5)]))
    apply = set_scalars(
        "stribeck",
        stribeck_velocity=speed,
        stribeck_exponent=exponent,
        stribeck_shape=1.0 if shape == "rational" else 0.0,
    )

    def parameters(a: float) -> Parameters:
        if shape != "usual":
            return {}
        return {"static_excess": (a, "V", None), "velocity": (speed, "m/s", None)}

    return Hidden("stribeck_friction", shape, 0.05 * level, 1e-5 * level, 1.5 * level, apply, parameters)


def presliding_friction(rng: np.random.Generator, machine: Machine, motion: Motion) -> Hidden:
    """The amplitude is the presliding distance Coulomb / stiffness; without the effect the bristles are rigid."""
    shape = str(rng.choice(["lugre", "dahl"]))
    level, mass = machine.scalars["coulomb"], machine.scalars["mass"]
    ratio = rng.uniform(0.3, 0.9)

    def apply(plan: Plan, amplitude: float) -> None:
        plan["bristle"] = amplitude
        plan["bristle_damping"] = ratio * np.sqrt(level / amplitude * mass) if shape == "lugre" else 0.0

    def parameters(a: float) -> Parameters:
        return {"stiffness": (level / a, "V/m", None)}

    low = max(3.0 * machine.scalars["bristle"], 2 * machine.scalars["resolution"], 5e-7)  # below, it is sticking
    return Hidden("presliding_friction", shape, 3 * low, low, 1e-3, apply, parameters)


def position_dependent_friction(rng: np.random.Generator, machine: Machine, motion: Motion) -> Hidden:
    shape, sign, level = _shape(rng, "bump", "wave"), _sign(rng), machine.scalars["coulomb"]
    nodes = np.array([0.0, *np.sort(rng.uniform(0.15, 0.85, int(rng.integers(1, 4)))), 1.0])
    heights = rng.uniform(-1.0, 1.0, len(nodes))
    heights = (heights - heights.mean()) / np.abs(heights - heights.mean()).max()
    place, waves = rng.uniform(0.2, 0.8), rng.uniform(0.8, 2.0)

    def extra(plan: Plan) -> np.ndarray:
        s = shares(plan, machine)
        if shape == "bump":
            return sign * np.exp(-(((s - place) / 0.12) ** 2))
        if shape == "wave":
            return sign * np.sin(2 * np.pi * waves * s + 7 * place)
        return sign * np.interp(s, nodes, heights)

    return Hidden(
        "position_dependent_friction", shape, 0.05 * level, 1e-4 * level, 0.8 * level, add_map("coulomb", extra)
    )


def quadratic_drag(rng: np.random.Generator, machine: Machine, motion: Motion) -> Hidden:
    shape, sign = _shape(rng, "other_power"), float(rng.choice([-1, 1, 1, 1]))
    exponent = 2.0 if shape == "usual" else float(rng.choice([rng.uniform(1.6, 1.85), rng.uniform(2.2, 3.0)]))
    unit = machine.peak / machine.velocity**exponent

    def apply(plan: Plan, amplitude: float) -> None:
        plan["drag"] = sign * amplitude * unit
        plan["drag_exponent"] = exponent

    return Hidden(
        "quadratic_drag",
        shape,
        0.01,
        1e-5,
        0.4 if sign > 0 else 0.05,
        apply,
        lambda a: _one("coefficient", sign * a * unit, "V/(m/s)^2") if shape == "usual" else {},
    )


def force_constant_ripple(rng: np.random.Generator, machine: Machine, motion: Motion) -> Hidden:
    shape, phase = _shape(rng, "harmonics"), rng.uniform(0, 2 * np.pi)
    period = machine.pitch * float(rng.choice([1.0, 0.5, rng.uniform(0.6, 1.7)]))
    return Hidden(
        "force_constant_ripple",
        shape,
        5e-3,
        1e-5,
        0.3,
        add_map("gain", lambda plan: wave(plan.positions, period, phase, shape)),
        lambda a: quadratures("period", period, "", phase, a) if shape == "usual" else {},
    )


def force_constant_drift(rng: np.random.Generator, machine: Machine, motion: Motion) -> Hidden:
    shape, sign, tau = _shape(rng, "linear", "square_root"), _sign(rng), rng.uniform(2.0, 8.0)

    def change(plan: Plan) -> np.ndarray:
        t = times(plan)
        if shape == "linear":
            return sign * t / t[-1]
        if shape == "square_root":
            return sign * np.sqrt(t / t[-1])
        return sign * (1 - np.exp(-t / tau))

    return Hidden(
        "force_constant_drift",
        shape,
        5e-3,
        1e-5,
        0.3,
        add_row("gain", change),
        lambda a: {"change": (sign * a, "", None), "time_constant": (tau, "s", None)} if shape == "usual" else {},
    )


def command_delay(rng: np.random.Generator, machine: Machine, motion: Motion) -> Hidden:
    high = min(6e-3, 0.25 / _bandwidth(machine))
    return Hidden(
        "command_delay",
        "usual",
        3e-4,
        2e-6,
        high,
        set_scalars("delay"),
        lambda a: _one("delay", a, "s"),
    )


def actuator_lag(rng: np.random.Generator, machine: Machine, motion: Motion) -> Hidden:
    shape, ratio = _shape(rng, "two_lags"), rng.uniform(0.3, 1.0)

    def apply(plan: Plan, amplitude: float) -> None:
        plan["lag"] = amplitude
        plan["second_lag"] = ratio * amplitude if shape == "two_lags" else 0.0

    return Hidden(
        "actuator_lag",
        shape,
        5e-4,
        5e-6,
        min(8e-3, 0.3 / _bandwidth(machine)),
        apply,
        lambda a: _one("time_constant", a, "s") if shape == "usual" else {},
    )


def _bandwidth(machine: Machine) -> float:
    """Cross-over of the loop, rad/s."""
    s = machine.scalars
    return (s["kv"] if s["controller"] == truth.CASCADE else s["kd"]) / s["mass"]


def largest_command(machine: Machine, motion: Motion) -> float:
    """Largest command that a motion asks for, without control error."""
    s = machine.scalars
    inertia = s["mass"] * motion.acceleration + s["viscous"] * motion.velocity
    return float(np.abs(inertia + s["coulomb"] * np.sign(motion.velocity)).max())


def command_saturation(rng: np.random.Generator, machine: Machine, motion: Motion) -> Hidden:
    """The amplitude is the share of the largest command of the motion that is cut."""
    full = largest_command(machine, motion)

    def apply(plan: Plan, amplitude: float) -> None:
        plan["saturation_up"] = plan["saturation_down"] = full * (1.1 - amplitude)

    return Hidden(
        "command_saturation",
        "usual",
        0.2,
        0.01,
        0.7,
        apply,
        lambda a: {"limit": (full * (1.1 - a), "V", None)},
    )


def command_dead_zone(rng: np.random.Generator, machine: Machine, motion: Motion) -> Hidden:
    level = machine.scalars["coulomb"]
    return Hidden(
        "command_dead_zone",
        "usual",
        0.05 * level,
        1e-5 * level,
        0.15 * machine.peak,
        set_scalars("dead_zone"),
        lambda a: {"width": (a, "V", None)},
    )


def encoder_periodic_error(rng: np.random.Generator, machine: Machine, motion: Motion) -> Hidden:
    shape, phase, period = _shape(rng, "triangular"), rng.uniform(0, 2 * np.pi), log_uniform(rng, 5e-4, 0.03)

    def apply(plan: Plan, amplitude: float) -> None:
        plan["encoder_period"] = period
        plan["encoder_sine"], plan["encoder_cosine"] = amplitude * np.cos(phase), amplitude * np.sin(phase)
        plan["encoder_triangular"] = 1.0 if shape == "triangular" else 0.0
        plan["x_start"] -= amplitude * np.sin(2 * np.pi * plan["x_start"] / period + phase) * (shape == "usual")

    return Hidden(
        "encoder_periodic_error",
        shape,
        1e-6,
        1e-8,
        min(1e-4, period / 20),
        apply,
        lambda a: quadratures("period", period, "m", phase, a) if shape == "usual" else {},
    )


def encoder_scale_error(rng: np.random.Generator, machine: Machine, motion: Motion) -> Hidden:
    """reading = x (1 + scale); the axis rests where its reading is the reference."""
    sign = _sign(rng)

    def apply(plan: Plan, amplitude: float) -> None:
        plan["encoder_scale"] = sign * amplitude
        plan["x_start"] /= 1 + sign * amplitude

    return Hidden("encoder_scale_error", "usual", 1e-3, 1e-6, 0.03, apply, lambda a: _one("scale", sign * a, ""))


def backlash(rng: np.random.Generator, machine: Machine, motion: Motion) -> Hidden:
    ratio = log_uniform(rng, 0.02, 0.5)
    return Hidden(
        "backlash",
        "usual",
        2e-5,
        1e-6,
        2e-3,
        set_scalars("gap", coupling=truth.BACKLASH, load_ratio=ratio),
        lambda a: {"gap": (a, "m", None), "mass_ratio": (ratio, "", None)},
    )


def flexible_mode(rng: np.random.Generator, machine: Machine, motion: Motion) -> Hidden:
    shape, frequency = _shape(rng, "hardening"), log_uniform(rng, 15.0, min(150.0, machine.rate / 10))
    damping = log_uniform(rng, 0.01, 0.08)
    deflection = machine.acceleration / (2 * np.pi * frequency) ** 2

    return Hidden(
        "flexible_mode",
        shape,
        0.02,
        1e-4,
        0.6,
        set_scalars(
            "load_ratio",
            coupling=truth.FLEXIBLE,
            mode_frequency=frequency,
            mode_damping=damping,
            hardening=0.5 / deflection**2 if shape == "hardening" else 0.0,
        ),
        lambda a: (
            {
                "frequency": (frequency, "Hz", None),
                "damping_ratio": (damping, "", None),
                "mass_ratio": (a, "", None),
            }
            if shape == "usual"
            else {}
        ),
    )


def disturbance_step(rng: np.random.Generator, machine: Machine, motion: Motion) -> Hidden:
    shape, sign, peak = _shape(rng, "ramped"), _sign(rng), machine.peak
    begin = rng.uniform(0.1, 0.6) * machine.duration
    end = begin + rng.uniform(0.1, 0.35) * machine.duration
    rise = 0.3 if shape == "ramped" else 1e-6

    def force(plan: Plan) -> np.ndarray:
        t = times(plan)
        return sign * np.clip((t - begin) / rise, 0, 1) * np.clip((end - t) / rise, 0, 1)

    def parameters(a: float) -> Parameters:
        return {"force": (sign * a, "V", 1.0), "start": (begin, "s", None), "stop": (end, "s", None)}

    return Hidden(
        "disturbance_step",
        shape,
        2e-3 * peak,
        1e-5 * peak,
        0.5 * peak,
        add_row("force", force),
        lambda a: parameters(a) if shape == "usual" else {},
    )


def disturbance_tone(rng: np.random.Generator, machine: Machine, motion: Motion) -> Hidden:
    shape, phase, peak = _shape(rng, "flattened"), rng.uniform(0, 2 * np.pi), machine.peak
    frequency = log_uniform(rng, 2.0, min(120.0, machine.rate / 12))
    return Hidden(
        "disturbance_tone",
        shape,
        2e-3 * peak,
        1e-6 * peak,
        0.3 * peak,
        add_row("force", lambda plan: wave(times(plan), 1 / frequency, phase, shape)),
        lambda a: quadratures("frequency", frequency, "V", phase, a, "Hz") if shape == "usual" else {},
    )


#: Effects of the vocabulary that are scaled to a ratio; the three changes of nominal parameters are set in cases.py.
VOCABULARY: dict[str, Draw] = {
    draw.__name__: draw
    for draw in (
        constant_force,
        cable_spring,
        end_effect,
        cogging_harmonic,
        cogging_modulation,
        coulomb_asymmetry,
        viscous_asymmetry,
        stribeck_friction,
        presliding_friction,
        position_dependent_friction,
        quadratic_drag,
        force_constant_ripple,
        force_constant_drift,
        command_delay,
        actuator_lag,
        command_saturation,
        command_dead_zone,
        encoder_periodic_error,
        encoder_scale_error,
        backlash,
        flexible_mode,
        disturbance_step,
        disturbance_tone,
    )
}
CHANGES = ("mass_change", "viscous_change", "coulomb_change")
