"""What is hidden in the large: each effect of a size that its share of the command sets, up to what is physical."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace

import numpy as np

from .. import truth
from ..hidden import Hidden, Parameters, add_map, add_row, quadratures, set_scalars, times
from ..machines import log_uniform
from ..shapes import any_pulse
from ..truth import Plan
from .machines import LargeMachine

MOVES = ("slow", "strokes", "sine", "mixed")
FAST = ("strokes", "sine", "mixed", "multisine", "open")
SMOOTH_LAWS = ("tanh", "algebraic", "arctangent")


@dataclass(frozen=True)
class Scene:
    """What an effect is drawn for.

    Attributes:
        machine: the axis.
        command: rms and largest of the command without effects on the main motion.
        speed: largest of the main motion.
    """

    machine: LargeMachine
    command: tuple[float, float]
    speed: float

    @property
    def slowest_turn(self) -> float:
        """Shortest period that the sampling of the main motion, the encoder and the map resolve."""
        machine = self.machine
        counts = 40 * machine.scalars["resolution"]
        return max(8 * self.speed / machine.rate, counts, machine.room.length / 800)


Draw = Callable[[np.random.Generator, Scene], Hidden]


def _sign(rng: np.random.Generator) -> float:
    return float(rng.choice([-1.0, 1.0]))


def _force(
    name: str, scene: Scene, shape: Callable[[Plan], np.ndarray], parameters: Callable[[float], Parameters]
) -> Hidden:
    """A force over the travel; the amplitude is its largest value."""
    size = scene.command[0]
    return Hidden(name, "usual", size, 1e-3 * size, 30 * size, add_map("force", shape), parameters)


def cogging_harmonic(rng: np.random.Generator, scene: Scene) -> Hidden:
    """One to four harmonics of one pitch, up to the hundredth a turn; the amplitude is the largest harmonic's."""
    length, turn = scene.machine.room.length, 2 * np.pi
    longest = turn / 2 if scene.machine.rotary else 0.5 * length  # once a turn it would be gravity
    known = [period for period, _, _ in scene.machine.known]
    while True:
        order = int(rng.integers(1, 5))
        multiples = np.sort(rng.choice([1, 2, 3, 4, 5, 6, 8, 12], order, replace=False))
        if scene.machine.rotary:
            pitch = turn / int(np.exp(rng.uniform(0, np.log(100))))
        else:
            pitch = log_uniform(rng, scene.slowest_turn, longest) if scene.slowest_turn < longest else longest
        periods = pitch / multiples
        periods = periods[(periods >= scene.slowest_turn) & (periods <= longest)]
        if scene.slowest_turn >= longest:
            periods = np.array([longest])
        if len(periods) and all(abs(np.log(p / k)) > 0.03 for p in periods for k in known):
            break
    sizes = rng.uniform(0.2, 1.0, len(periods))
    sizes /= sizes.max()
    phases = rng.uniform(0, turn, len(periods))

    def shape(plan: Plan) -> np.ndarray:
        return -np.sum(sizes[:, None] * np.sin(turn * plan.positions / periods[:, None] + phases[:, None]), axis=0)

    def parameters(a: float) -> Parameters:
        told: Parameters = {}
        for place, i in enumerate(np.argsort(-sizes), start=1):
            told[f"period {place}"] = (float(periods[i]), "m", None)
            told[f"sine {place}"] = (float(a * sizes[i] * np.cos(phases[i])), "V", None)
            told[f"cosine {place}"] = (float(a * sizes[i] * np.sin(phases[i])), "V", None)
        return told

    return _force("cogging_harmonic", scene, shape, parameters)


def constant_force(rng: np.random.Generator, scene: Scene) -> Hidden:
    """Gravity."""
    sign = _sign(rng)
    return _force(
        "constant_force",
        scene,
        lambda plan: np.full(plan.maps.shape[1], sign),
        lambda a: {"force": (sign * a, "V", None)},
    )


def cable_spring(rng: np.random.Generator, scene: Scene) -> Hidden:
    """A spring, sometimes one that pushes away."""
    room, sign = scene.machine.room, float(rng.choice([-1, 1, 1, 1]))
    center = room.travel[0] + room.length * rng.uniform(0.1, 0.9)
    return _force(
        "cable_spring",
        scene,
        lambda plan: -sign * 2 * (plan.positions - center) / room.length,
        lambda a: {"stiffness": (sign * 2 * a / room.length, "V/m", None), "center": (center, "m", None)},
    )


def end_effect(rng: np.random.Generator, scene: Scene) -> Hidden:
    """Forces at both ends."""
    room, sign = scene.machine.room, _sign(rng)
    decay = room.length * rng.uniform(0.05, 0.25)

    def shape(plan: Plan) -> np.ndarray:
        left, right = plan.positions - room.travel[0], room.travel[1] - plan.positions
        return sign * (np.exp(-right / decay) - np.exp(-left / decay))

    return _force(
        "end_effect", scene, shape, lambda a: {"force": (sign * a, "V", None), "decay_length": (decay, "m", None)}
    )


def local_force(rng: np.random.Generator, scene: Scene) -> Hidden:
    """A snag, or a joint: a bell, or a pulse of any kind that is as wide."""
    room, sign, pulse, usual = scene.machine.room, _sign(rng), any_pulse(rng), rng.random() < 0.4
    center, width = room.travel[0] + room.length * rng.uniform(0.2, 0.8), room.length * log_uniform(rng, 0.01, 0.08)

    def shape(plan: Plan) -> np.ndarray:
        distance = (plan.positions - center) / width
        return sign * (np.exp(-(distance**2)) if usual else pulse(distance / 3 + 0.5))

    def parameters(a: float) -> Parameters:
        if not usual:
            return {}
        return {"force": (sign * a, "V", None), "center": (center, "m", None), "width": (width, "m", None)}

    return replace(_force("local_force", scene, shape, parameters), shape="usual" if usual else "drawn")


def gravity(rng: np.random.Generator, scene: Scene) -> Hidden:
    """An arm, or a wheel whose weight is not in its middle."""
    angle = rng.uniform(-np.pi, np.pi)
    return _force(
        "gravity",
        scene,
        lambda plan: -np.sin(plan.positions - angle),
        lambda a: {"moment": (a, "V", None), "angle": (angle, "rad", None)},
    )


def _of_friction(name: str, key: str, unit: str, level: float, rng: np.random.Generator, most: float) -> Hidden:
    """Friction that differs with direction: the amplitude is the difference."""
    sign = _sign(rng)

    def apply(plan: Plan, amplitude: float) -> None:
        plan[key] = sign * amplitude

    return Hidden(
        name, "usual", level, 1e-3 * level, most * level, apply, lambda a: {"difference": (sign * a, unit, None)}
    )


def coulomb_asymmetry(rng: np.random.Generator, scene: Scene) -> Hidden:
    """One way rubs up to nine times as much as the other."""
    return _of_friction("coulomb_asymmetry", "coulomb_asymmetry", "V", scene.machine.scalars["coulomb"], rng, 1.6)


def viscous_asymmetry(rng: np.random.Generator, scene: Scene) -> Hidden:
    """The same of the viscous slope."""
    level = scene.machine.scalars["viscous"]
    return _of_friction("viscous_asymmetry", "viscous_asymmetry", "V/(m/s)", level, rng, 1.6)


def stribeck_friction(rng: np.random.Generator, scene: Scene) -> Hidden:
    """Up to twice the Coulomb level more at slow speed."""
    level, speed = scene.machine.scalars["coulomb"], scene.speed * log_uniform(rng, 0.03, 0.4)
    exponent = float(rng.choice([1.0, 2.0]))
    return Hidden(
        "stribeck_friction",
        "usual",
        level,
        1e-3 * level,
        2.0 * level,
        set_scalars("stribeck", stribeck_velocity=speed, stribeck_exponent=exponent),
        lambda a: {
            "static_excess": (a, "V", None),
            "velocity": (speed, "m/s", None),
            "exponent": (exponent, "", None),
        },
    )


def quadratic_drag(rng: np.random.Generator, scene: Scene) -> Hidden:
    """A fan, a boat, a fast belt; the amplitude is the drag at the largest speed."""
    size, unit = scene.command[0], 1 / scene.speed**2

    def apply(plan: Plan, amplitude: float) -> None:
        plan["drag"] = amplitude * unit

    return Hidden(
        "quadratic_drag",
        "usual",
        size,
        1e-3 * size,
        10 * size,
        apply,
        lambda a: {"coefficient": (a * unit, "V/(m/s)^2", None)},
    )


def position_dependent_friction(rng: np.random.Generator, scene: Scene) -> Hidden:
    """A Coulomb level that is between nothing and some times its own along the travel."""
    room, level = scene.machine.room, scene.machine.scalars["coulomb"]
    nodes = np.linspace(*room.travel, int(rng.integers(3, 7)))
    heights = rng.uniform(-0.25, 1.0, len(nodes))
    heights[rng.integers(len(nodes))] = 1.0
    most = min(0.95 / max(-heights.min(), 0.1), 6.0)
    return Hidden(
        "position_dependent_friction",
        "usual",
        level,
        1e-2 * level,
        most * level,
        add_map("coulomb", lambda plan: np.interp(plan.positions, nodes, heights)),
        lambda a: {
            **{f"node {i}": (float(node), "m", None) for i, node in enumerate(nodes)},
            **{f"level {i}": (float(a * height), "V", None) for i, height in enumerate(heights)},
        },
    )


def force_constant_ripple(rng: np.random.Generator, scene: Scene) -> Hidden:
    """The motor's constant goes up and down along the way by up to 60 %."""
    longest = 2 * np.pi if scene.machine.rotary else 0.5 * scene.machine.room.length
    period = log_uniform(rng, min(scene.slowest_turn, longest), longest)
    phase = rng.uniform(0, 2 * np.pi)
    return Hidden(
        "force_constant_ripple",
        "usual",
        0.3,
        1e-2,
        0.6,
        add_map("gain", lambda plan: np.sin(2 * np.pi * plan.positions / period + phase)),
        lambda a: quadratures("period", period, "", phase, a),
    )


def _bandwidth(machine: LargeMachine) -> float:
    s = machine.scalars
    return (s["kv"] if s["controller"] == truth.CASCADE else s["kd"]) / s["mass"]


def command_delay(rng: np.random.Generator, scene: Scene) -> Hidden:
    """As late as the loop bears."""
    most = 0.35 / _bandwidth(scene.machine)
    return Hidden(
        "command_delay",
        "usual",
        0.3 * most,
        0.01 * most,
        most,
        set_scalars("delay"),
        lambda a: {"delay": (a, "s", None)},
    )


def actuator_lag(rng: np.random.Generator, scene: Scene) -> Hidden:
    """As slow as the loop bears."""
    most = 0.4 / _bandwidth(scene.machine)
    return Hidden(
        "actuator_lag",
        "usual",
        0.3 * most,
        0.01 * most,
        most,
        set_scalars("lag"),
        lambda a: {"time_constant": (a, "s", None)},
    )


def command_saturation(rng: np.random.Generator, scene: Scene) -> Hidden:
    """The amplitude is the share of the largest command that is cut."""
    full = scene.command[1]

    def apply(plan: Plan, amplitude: float) -> None:
        plan["saturation_up"] = plan["saturation_down"] = full * (1.0 - amplitude)

    return Hidden(
        "command_saturation", "usual", 0.3, 0.02, 0.8, apply, lambda a: {"limit": (full * (1 - a), "V", None)}
    )


def command_dead_zone(rng: np.random.Generator, scene: Scene) -> Hidden:
    """Small commands do nothing; small is up to a few times the command without it."""
    size = scene.command[0]
    return Hidden(
        "command_dead_zone",
        "usual",
        size,
        1e-2 * size,
        5 * size,
        set_scalars("dead_zone"),
        lambda a: {"width": (a, "V", None)},
    )


def backlash(rng: np.random.Generator, scene: Scene) -> Hidden:
    """Play before most of the mass."""
    ratio, length = rng.uniform(0.3, 0.85), scene.machine.room.length
    lowest = max(5 * scene.machine.scalars["resolution"], 1e-4 * length)
    return Hidden(
        "backlash",
        "usual",
        1e-2 * length,
        lowest,
        max(0.05 * length, 2 * lowest),
        set_scalars("gap", coupling=truth.BACKLASH, load_ratio=ratio),
        lambda a: {"gap": (a, "m", None), "mass_ratio": (ratio, "", None)},
    )


def flexible_mode(rng: np.random.Generator, scene: Scene) -> Hidden:
    """A belt or a coupling whose resonance lies within what the motion shakes; the amplitude is the load's share."""
    low, high = scene.machine.room.band
    frequency, damping = log_uniform(rng, max(4 * low, 0.15 * high), 0.7 * high), log_uniform(rng, 0.01, 0.08)

    def parameters(a: float) -> Parameters:
        return {
            "frequency": (frequency, "Hz", None),
            "damping_ratio": (damping, "", None),
            "mass_ratio": (a, "", None),
        }

    return Hidden(
        "flexible_mode",
        "usual",
        0.4,
        0.05,
        0.75,
        set_scalars("load_ratio", coupling=truth.FLEXIBLE, mode_frequency=frequency, mode_damping=damping),
        parameters,
    )


def disturbance_tone(rng: np.random.Generator, scene: Scene) -> Hidden:
    """A fan or a pump beside the axis."""
    size, phase = scene.command[0], rng.uniform(0, 2 * np.pi)
    frequency = log_uniform(rng, 1.0, min(60.0, scene.machine.rate / 12))
    return Hidden(
        "disturbance_tone",
        "usual",
        size,
        1e-3 * size,
        10 * size,
        add_row("force", lambda plan: np.sin(2 * np.pi * frequency * times(plan) + phase)),
        lambda a: quadratures("frequency", frequency, "V", phase, a, "Hz"),
    )


def disturbance_step(rng: np.random.Generator, scene: Scene) -> Hidden:
    """Something leans on the axis for a while."""
    size, sign, whole = scene.command[0], _sign(rng), scene.machine.duration
    begin = rng.uniform(0.1, 0.5) * whole
    end = begin + rng.uniform(0.2, 0.4) * whole
    return Hidden(
        "disturbance_step",
        "usual",
        size,
        1e-3 * size,
        10 * size,
        add_row("force", lambda plan: sign * ((times(plan) >= begin) & (times(plan) < end))),
        lambda a: {"force": (sign * a, "V", None), "start": (begin, "s", None), "stop": (end, "s", None)},
    )


def mass_change(rng: np.random.Generator, scene: Scene) -> Hidden:
    """A payload beyond what the model states of its mass."""
    nominal = scene.machine.model["axis"]["mass"]
    bare = scene.machine.scalars["mass"]

    def apply(plan: Plan, amplitude: float) -> None:
        plan["mass"] = bare * (1 + amplitude)

    return Hidden(
        "mass_change",
        "usual",
        1.0,
        0.5,
        6.0,
        apply,
        lambda a: {"change": (bare * (1 + a) / nominal - 1, "", None)},
    )


#: Effects by name, with the motions that show them in the large.
EFFECTS: dict[str, tuple[Draw, Sequence[str]]] = {
    "cogging_harmonic": (cogging_harmonic, MOVES),
    "constant_force": (constant_force, MOVES),
    "cable_spring": (cable_spring, MOVES),
    "end_effect": (end_effect, ("slow", "strokes", "mixed")),
    "local_force": (local_force, ("slow", "strokes", "mixed")),
    "gravity": (gravity, MOVES),
    "coulomb_asymmetry": (coulomb_asymmetry, MOVES),
    "viscous_asymmetry": (viscous_asymmetry, ("strokes", "sine", "mixed")),
    "stribeck_friction": (stribeck_friction, ("mixed", "sine")),
    "quadratic_drag": (quadratic_drag, ("strokes", "sine", "mixed")),
    "position_dependent_friction": (position_dependent_friction, ("slow", "strokes", "mixed")),
    "force_constant_ripple": (force_constant_ripple, MOVES),
    "flexible_mode": (flexible_mode, ("multisine", "open")),
    "command_delay": (command_delay, ("sine", "multisine", "open")),
    "actuator_lag": (actuator_lag, ("sine", "multisine", "open")),
    "command_dead_zone": (command_dead_zone, (*MOVES, "multisine", "open")),
    "command_saturation": (command_saturation, FAST),
    "backlash": (backlash, ("strokes", "sine", "mixed")),
    "disturbance_tone": (disturbance_tone, (*MOVES, "multisine")),
    "disturbance_step": (disturbance_step, MOVES),
    "mass_change": (mass_change, FAST),
}
#: Effects of machines with smooth friction and one coupling: no two of them together.
COUPLED = ("flexible_mode", "backlash")
#: Effects of machines that turn.
TURNING = ("gravity",)
