"""Effects outside the vocabulary: none of its names is right, and the honest verdict is `unlisted`."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from scipy.signal import lfilter

from . import truth
from .hidden import Hidden, add_map, add_row, set_scalars, shares, times
from .machines import Machine, log_uniform
from .motions import Motion
from .truth import Plan


def _sign(rng: np.random.Generator) -> float:
    return float(rng.choice([-1.0, 1.0]))


def missing_counts(rng: np.random.Generator, machine: Machine, motion: Motion) -> Hidden:
    """The encoder loses counts each time it passes a spot of its scale forwards."""
    spot = float(np.quantile(motion.position, rng.uniform(0.3, 0.7)))
    return Hidden("missing_counts", "usual", 2e-6, 1e-8, 5e-4, set_scalars("lost_counts", lost_at=spot))


def intermittent_rub(rng: np.random.Generator, machine: Machine, motion: Motion) -> Hidden:
    """Extra Coulomb friction that comes and goes in bursts of some tenths of a second."""
    seed = int(rng.integers(2**31))

    def bursts(plan: Plan) -> np.ndarray:
        draws = np.random.default_rng(seed)
        t, level = times(plan), np.zeros(len(plan.instants))
        for _ in range(int(0.8 * t[-1])):
            begin = draws.uniform(0.2, t[-1])
            level[(t > begin) & (t < begin + draws.uniform(0.05, 0.4))] = 1.0
        return level

    level = machine.scalars["coulomb"]
    return Hidden("intermittent_rub", "usual", 0.1 * level, 1e-4 * level, 3 * level, add_row("coulomb", bursts))


def held_packets(rng: np.random.Generator, machine: Machine, motion: Motion) -> Hidden:
    """The amplifier misses a share of the commands and repeats the last one."""
    seed = int(rng.integers(2**31))

    def apply(plan: Plan, amplitude: float) -> None:
        draws = np.random.default_rng(seed).random(len(plan.instants))
        plan.rows[:, truth.R_HELD] = draws < amplitude

    return Hidden("held_packets", "usual", 0.05, 5e-4, 0.7, apply)


def warming_friction(rng: np.random.Generator, machine: Machine, motion: Motion) -> Hidden:
    """Viscous friction that falls as the lubricant warms up."""
    tau = rng.uniform(2.0, 6.0)
    level = machine.scalars["viscous"]
    shape = add_row("viscous", lambda plan: np.exp(-times(plan) / tau))
    return Hidden("warming_friction", "usual", 0.1 * level, 1e-4 * level, 3 * level, shape)


def eddy_cogging(rng: np.random.Generator, machine: Machine, motion: Motion) -> Hidden:
    """A force that is periodic in position and proportional to speed."""
    phase, level = rng.uniform(0, 2 * np.pi), machine.scalars["viscous"]
    shape = add_map("viscous", lambda plan: np.sin(2 * np.pi * plan.positions / machine.pitch + phase))
    return Hidden("eddy_cogging", "usual", 0.1 * level, 1e-4 * level, 2 * level, shape)


def position_dependent_viscous(rng: np.random.Generator, machine: Machine, motion: Motion) -> Hidden:
    """Viscous friction that changes along the travel."""
    waves, shift, level = rng.uniform(0.5, 1.5), rng.uniform(0, 2 * np.pi), machine.scalars["viscous"]
    shape = add_map("viscous", lambda plan: np.sin(2 * np.pi * waves * shares(plan, machine) + shift))
    return Hidden("position_dependent_viscous", "usual", 0.1 * level, 1e-4 * level, 0.9 * level, shape)


def reluctance_force(rng: np.random.Generator, machine: Machine, motion: Motion) -> Hidden:
    """A force with the square of the command, periodic in position."""
    phase, peak = rng.uniform(0, 2 * np.pi), machine.peak
    period = machine.pitch * rng.uniform(0.5, 1.5)
    shape = add_map("reluctance", lambda plan: np.sin(2 * np.pi * plan.positions / period + phase) / peak)
    return Hidden("reluctance_force", "usual", 0.01, 1e-5, 0.3, shape)


def dither_burst(rng: np.random.Generator, machine: Machine, motion: Motion) -> Hidden:
    """Bursts of band-limited force noise, each of some tenths of a second."""
    seed, peak = int(rng.integers(2**31)), machine.peak

    def bursts(plan: Plan) -> np.ndarray:
        draws = np.random.default_rng(seed)
        t = times(plan)
        noise = lfilter([1.0], [1.0, -0.6], draws.standard_normal(len(t)))
        window = np.zeros(len(t))
        for _ in range(4):
            begin = draws.uniform(0.5, t[-1] - 0.5)
            window[(t > begin) & (t < begin + draws.uniform(0.1, 0.4))] = 1.0
        return noise * window

    return Hidden("dither_burst", "usual", 2e-3 * peak, 1e-5 * peak, 0.3 * peak, add_row("force", bursts))


def magnetic_hysteresis(rng: np.random.Generator, machine: Machine, motion: Motion) -> Hidden:
    """A force that remembers the direction of the last millimetres and changes sign with position."""
    length, period = log_uniform(rng, 3e-4, 3e-3), machine.pitch * rng.uniform(0.7, 1.4)
    apply = set_scalars("hysteresis", hysteresis_length=length, hysteresis_period=period)
    level = machine.peak
    return Hidden("magnetic_hysteresis", "usual", 5e-3 * level, 1e-5 * level, 0.3 * level, apply)


def hysteretic_spring(rng: np.random.Generator, machine: Machine, motion: Motion) -> Hidden:
    """A cable chain whose spring force lags behind the position by centimetres."""
    span = machine.travel[1] - machine.travel[0]
    length, center = span * rng.uniform(0.03, 0.12), machine.travel[0] + span * rng.uniform(0.2, 0.8)
    peak = machine.peak

    def apply(plan: Plan, amplitude: float) -> None:
        plan["hysteresis"], plan["hysteresis_length"] = amplitude, length
        plan.maps[truth.M_FORCE] -= 0.5 * amplitude * (plan.positions - center) / span

    return Hidden(
        "hysteretic_spring",
        "usual",
        5e-3 * peak,
        1e-5 * peak,
        0.3 * peak,
        apply,
        tolerated=("cable_spring", "presliding_friction"),
    )


def clock_glitch(rng: np.random.Generator, machine: Machine, motion: Motion) -> Hidden:
    """The controller's clock stumbles some times; the log's time stamps do not show it."""
    seed = int(rng.integers(2**31))

    def apply(plan: Plan, amplitude: float) -> None:
        draws = np.random.default_rng(seed)
        count = len(plan.instants)
        late = np.zeros(count)
        for _ in range(8):
            late[int(draws.uniform(0.05, 0.98) * count) :] += amplitude
        plan.instants = plan.instants + late

    return Hidden("clock_glitch", "usual", 0.3 / machine.rate, 1e-3 / machine.rate, 10 / machine.rate, apply)


def random_walk_force(rng: np.random.Generator, machine: Machine, motion: Motion) -> Hidden:
    """An offset force that wanders."""
    seed, peak = int(rng.integers(2**31)), machine.peak

    def walk(plan: Plan) -> np.ndarray:
        t = times(plan)
        knots = np.arange(0.0, t[-1] + 0.5, 0.25)
        path = np.cumsum(np.random.default_rng(seed).standard_normal(len(knots)))
        return np.interp(t, knots, path - path.mean()) / np.sqrt(len(knots))

    return Hidden("random_walk_force", "usual", 3e-3 * peak, 1e-5 * peak, 0.3 * peak, add_row("force", walk))


def speed_dependent_gain(rng: np.random.Generator, machine: Machine, motion: Motion) -> Hidden:
    """The force constant falls with speed."""
    sign = float(rng.choice([-1, -1, 1]))

    def apply(plan: Plan, amplitude: float) -> None:
        plan["gain_speed"] = sign * amplitude / machine.velocity

    return Hidden("speed_dependent_gain", "usual", 0.02, 1e-4, 0.4, apply)


def encoder_slip(rng: np.random.Generator, machine: Machine, motion: Motion) -> Hidden:
    """The scale slips once by some micrometres while the axis moves."""
    moment, sign = rng.uniform(0.3, 0.7), _sign(rng)

    def jump(plan: Plan) -> np.ndarray:
        after = np.arange(len(plan.instants)) >= int(moment * len(plan.instants))
        return sign * after

    return Hidden("encoder_slip", "usual", 1e-5, 1e-7, 3e-3, add_row("reading", jump))


OUTSIDE: dict[str, Callable[[np.random.Generator, Machine, Motion], Hidden]] = {
    draw.__name__: draw
    for draw in (
        missing_counts,
        intermittent_rub,
        held_packets,
        warming_friction,
        eddy_cogging,
        position_dependent_viscous,
        reluctance_force,
        dither_burst,
        magnetic_hysteresis,
        hysteretic_spring,
        clock_glitch,
        random_walk_force,
        speed_dependent_gain,
        encoder_slip,
    )
}
