"""Effects outside the vocabulary: none of its names is right, and the honest verdict is `unlisted`."""

import numpy as np
from scipy.signal import lfilter

from . import truth
from .hidden import Draw, Hidden, add_map, add_row, listed, set_scalars, sign, sizes
from .machines import Machine, log_uniform
from .motions import Motion
from .truth import Plan

OUTSIDE: dict[str, Draw] = {}


@listed(OUTSIDE)
def missing_counts(rng: np.random.Generator, machine: Machine, motion: Motion) -> Hidden:
    """The encoder loses counts each time it passes a spot of its scale forwards."""
    spot = float(np.quantile(motion.position, rng.uniform(0.3, 0.7)))
    return Hidden(2e-6, 1e-8, 5e-4, set_scalars("lost_counts", lost_at=spot))


@listed(OUTSIDE)
def intermittent_rub(rng: np.random.Generator, machine: Machine, motion: Motion) -> Hidden:
    """Extra Coulomb friction that comes and goes in bursts of some tenths of a second."""
    seed = int(rng.integers(2**31))

    def bursts(plan: Plan) -> np.ndarray:
        draws = np.random.default_rng(seed)
        t, level = plan.times, np.zeros(len(plan.instants))
        for _ in range(int(0.8 * t[-1])):
            begin = draws.uniform(0.2, t[-1])
            level[(t > begin) & (t < begin + draws.uniform(0.05, 0.4))] = 1.0
        return level

    return Hidden(*sizes(machine.scalars["coulomb"], 0.1, 1e-4, 3), add_row("coulomb", bursts))


@listed(OUTSIDE)
def held_packets(rng: np.random.Generator, machine: Machine, motion: Motion) -> Hidden:
    """The amplifier misses a share of the commands and repeats the last one."""
    seed = int(rng.integers(2**31))

    def apply(plan: Plan, amplitude: float) -> None:
        plan.rows[:, truth.R_HELD] = np.random.default_rng(seed).random(len(plan.instants)) < amplitude

    return Hidden(0.05, 5e-4, 0.7, apply)


@listed(OUTSIDE)
def warming_friction(rng: np.random.Generator, machine: Machine, motion: Motion) -> Hidden:
    """Viscous friction that falls as the lubricant warms up."""
    tau = rng.uniform(2.0, 6.0)
    falling = add_row("viscous", lambda plan: np.exp(-plan.times / tau))
    return Hidden(*sizes(machine.scalars["viscous"], 0.1, 1e-4, 3), falling)


@listed(OUTSIDE)
def eddy_cogging(rng: np.random.Generator, machine: Machine, motion: Motion) -> Hidden:
    """A force that is periodic in position and proportional to speed."""
    phase = rng.uniform(0, 2 * np.pi)
    waves = add_map("viscous", lambda plan: np.sin(2 * np.pi * plan.positions / machine.pitch + phase))
    return Hidden(*sizes(machine.scalars["viscous"], 0.1, 1e-4, 2), waves)


@listed(OUTSIDE)
def position_dependent_viscous(rng: np.random.Generator, machine: Machine, motion: Motion) -> Hidden:
    waves, shift, level = rng.uniform(0.5, 1.5), rng.uniform(0, 2 * np.pi), machine.scalars["viscous"]
    shape = add_map("viscous", lambda plan: np.sin(2 * np.pi * waves * machine.along(plan.positions) + shift))
    return Hidden(*sizes(level, 0.1, 1e-4, 0.9), shape)


@listed(OUTSIDE)
def reluctance_force(rng: np.random.Generator, machine: Machine, motion: Motion) -> Hidden:
    """A force with the square of the command, periodic in position."""
    phase, period = rng.uniform(0, 2 * np.pi), machine.pitch * rng.uniform(0.5, 1.5)
    waves = add_map("reluctance", lambda plan: np.sin(2 * np.pi * plan.positions / period + phase) / machine.peak)
    return Hidden(0.01, 1e-5, 0.3, waves)


@listed(OUTSIDE)
def dither_burst(rng: np.random.Generator, machine: Machine, motion: Motion) -> Hidden:
    """Bursts of band-limited force noise, each of some tenths of a second."""
    seed = int(rng.integers(2**31))

    def bursts(plan: Plan) -> np.ndarray:
        draws, t = np.random.default_rng(seed), plan.times
        noise = lfilter([1.0], [1.0, -0.6], draws.standard_normal(len(t)))
        window = np.zeros(len(t))
        for _ in range(4):
            begin = draws.uniform(0.5, t[-1] - 0.5)
            window[(t > begin) & (t < begin + draws.uniform(0.1, 0.4))] = 1.0
        return noise * window

    return Hidden(*sizes(machine.peak, 2e-3, 1e-5, 0.3), add_row("force", bursts))


@listed(OUTSIDE)
def magnetic_hysteresis(rng: np.random.Generator, machine: Machine, motion: Motion) -> Hidden:
    """A force that remembers the direction of the last millimetres and changes sign with position."""
    length, period = log_uniform(rng, 3e-4, 3e-3), machine.pitch * rng.uniform(0.7, 1.4)
    apply = set_scalars("hysteresis", hysteresis_length=length, hysteresis_period=period)
    return Hidden(*sizes(machine.peak, 5e-3, 1e-5, 0.3), apply)


@listed(OUTSIDE)
def hysteretic_spring(rng: np.random.Generator, machine: Machine, motion: Motion) -> Hidden:
    """A cable chain whose spring force lags behind the position by centimetres."""
    span = machine.length
    length, center = span * rng.uniform(0.03, 0.12), machine.travel[0] + span * rng.uniform(0.2, 0.8)

    def apply(plan: Plan, amplitude: float) -> None:
        plan.set(hysteresis=amplitude, hysteresis_length=length)
        plan.maps[truth.M_FORCE] -= 0.5 * amplitude * (plan.positions - center) / span

    return Hidden(*sizes(machine.peak, 5e-3, 1e-5, 0.3), apply, tolerated=("cable_spring", "presliding_friction"))


@listed(OUTSIDE)
def clock_glitch(rng: np.random.Generator, machine: Machine, motion: Motion) -> Hidden:
    """The controller's clock stumbles some times; the log's time stamps do not show it."""
    seed = int(rng.integers(2**31))

    def apply(plan: Plan, amplitude: float) -> None:
        late = np.zeros(len(plan.instants))
        for share in np.random.default_rng(seed).uniform(0.05, 0.98, 8):
            late[int(share * len(late)) :] += amplitude
        plan.instants = plan.instants + late

    return Hidden(0.3 / machine.rate, 1e-3 / machine.rate, 10 / machine.rate, apply)


@listed(OUTSIDE)
def random_walk_force(rng: np.random.Generator, machine: Machine, motion: Motion) -> Hidden:
    """An offset force that wanders."""
    seed = int(rng.integers(2**31))

    def walk(plan: Plan) -> np.ndarray:
        knots = np.arange(0.0, plan.times[-1] + 0.5, 0.25)
        path = np.cumsum(np.random.default_rng(seed).standard_normal(len(knots)))
        return np.interp(plan.times, knots, path - path.mean()) / np.sqrt(len(knots))

    return Hidden(*sizes(machine.peak, 3e-3, 1e-5, 0.3), add_row("force", walk))


@listed(OUTSIDE)
def speed_dependent_gain(rng: np.random.Generator, machine: Machine, motion: Motion) -> Hidden:
    way = float(rng.choice([-1, -1, 1]))
    return Hidden(0.02, 1e-4, 0.4, lambda plan, a: plan.set(gain_speed=way * a / machine.velocity))


@listed(OUTSIDE)
def encoder_slip(rng: np.random.Generator, machine: Machine, motion: Motion) -> Hidden:
    """The scale slips once by some micrometres while the axis moves."""
    moment, way = rng.uniform(0.3, 0.7), sign(rng)

    def jump(plan: Plan) -> np.ndarray:
        return way * (np.arange(len(plan.instants)) >= int(moment * len(plan.instants)))

    return Hidden(1e-5, 1e-7, 3e-3, add_row("reading", jump))
