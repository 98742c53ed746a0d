"""The effects of the vocabulary as the truth makes them: random sign, off-grid, in other shapes of each cause too."""

import numpy as np

from . import truth
from .hidden import Draw, Hidden, add_map, add_row, listed, quadratures, set_scalars, sign, sizes, wave
from .machines import Machine, log_uniform
from .motions import Motion
from .shapes import any_decay, any_profile, any_pulse, any_rise, any_spring, any_wave
from .truth import Plan

ODD = 0.6  # share of cases with another shape than the usual
DRAWN = "drawn"  # a shape of shapes.py, no two the same
#: Effects of the vocabulary that are scaled to a ratio; the three changes of nominal parameters are set in cases.py.
#: `gravity` is hidden in the large alone, where axes turn.
VOCABULARY: dict[str, Draw] = {}
CHANGES = ("mass_change", "viscous_change", "coulomb_change")


def _shape(rng: np.random.Generator, *others: str) -> str:
    return str(rng.choice(others)) if others and rng.random() < ODD else "usual"


@listed(VOCABULARY)
def constant_force(rng: np.random.Generator, machine: Machine, motion: Motion) -> Hidden:
    way = sign(rng)
    push = add_map("force", lambda plan: np.full(plan.maps.shape[1], way))
    return Hidden(*sizes(machine.peak, 1e-3, 1e-6, 0.5), push, {"force": (lambda a: way * a, "V", 1.0)})


@listed(VOCABULARY)
def cable_spring(rng: np.random.Generator, machine: Machine, motion: Motion) -> Hidden:
    shape, way, length = _shape(rng, DRAWN), float(rng.choice([-1, 1, 1, 1])), machine.length
    center = machine.travel[0] + length * rng.uniform(0.1, 0.9)
    spring = any_spring(rng)

    def pull(plan: Plan) -> np.ndarray:
        if shape == DRAWN:
            s = np.clip(machine.along(plan.positions), 0.0, 1.0)
            return -way * (spring(s) - spring(machine.along(center)))
        return -way * (plan.positions - center) / length

    fields = {"stiffness": (lambda a: way * a / length, "V/m", 1.0), "center": (center, "m", None)}
    return Hidden(*sizes(machine.peak, 2e-3, 1e-5, 0.5), add_map("force", pull), fields, shape)


@listed(VOCABULARY)
def end_effect(rng: np.random.Generator, machine: Machine, motion: Motion) -> Hidden:
    shape, way = _shape(rng, DRAWN), sign(rng)
    decay, fall = machine.length * rng.uniform(0.03, 0.12), any_decay(rng)
    # the two ends of a machine are not alike, and often one alone has a magnet's edge or a stop near
    left_side, right_side = [(1.0, 1.0), (1.0, 0.0), (0.0, 1.0), (1.0, rng.uniform(0.3, 0.9))][int(rng.integers(4))]

    def push(plan: Plan) -> np.ndarray:
        left = (plan.positions - machine.travel[0]) / decay
        right = (machine.travel[1] - plan.positions) / decay
        if shape == DRAWN:
            return way * (right_side * fall(right) - left_side * fall(left))
        return way * (np.exp(-right) - np.exp(-left))

    fields = {"force": (lambda a: way * a, "V", 1.0), "decay_length": (decay, "m", None)}
    return Hidden(*sizes(machine.peak, 5e-3, 1e-5, 0.5), add_map("force", push), fields, shape)


@listed(VOCABULARY)
def local_force(rng: np.random.Generator, machine: Machine, motion: Motion) -> Hidden:
    """At a place that the motion passes: a bell, or a pulse of any kind that is as wide."""
    shape, way, pulse = _shape(rng, DRAWN), sign(rng), any_pulse(rng)
    center = float(np.quantile(motion.position, rng.uniform(0.1, 0.9)))
    width = machine.length * log_uniform(rng, 0.004, 0.06)

    def push(plan: Plan) -> np.ndarray:
        distance = (plan.positions - center) / width
        return way * (pulse(distance / 3 + 0.5) if shape == DRAWN else np.exp(-(distance**2)))

    fields = {"force": (lambda a: way * a, "V", 1.0), "center": (center, "m", None), "width": (width, "m", None)}
    return Hidden(*sizes(machine.peak, 5e-3, 1e-5, 0.5), add_map("force", push), fields, shape)


def _free_period(rng: np.random.Generator, machine: Machine) -> float:
    while True:
        period = log_uniform(rng, 4e-3, 0.09)
        if all(abs(np.log(period / known)) > 0.12 for known in machine.periods) and period < 0.4 * machine.length:
            return period


@listed(VOCABULARY)
def cogging_harmonic(rng: np.random.Generator, machine: Machine, motion: Motion) -> Hidden:
    shape, phase = _shape(rng, DRAWN), rng.uniform(0, 2 * np.pi)
    period, form = _free_period(rng, machine), any_wave(rng)
    push = add_map("force", lambda plan: -wave(plan.positions, period, phase, form if shape == DRAWN else np.sin))
    fields = {"period": (period, "m", None)} | quadratures(phase, "V")
    return Hidden(*sizes(machine.peak, 2e-3, 1e-5, 0.3), push, fields, shape)


@listed(VOCABULARY)
def cogging_modulation(rng: np.random.Generator, machine: Machine, motion: Motion) -> Hidden:
    shape = _shape(rng, DRAWN, DRAWN, "unknown_period")
    index, phase = int(rng.integers(len(machine.periods))), rng.uniform(0, 2 * np.pi)
    period = _free_period(rng, machine) if shape == "unknown_period" else machine.periods[index]
    waves, shift, profile = rng.uniform(0.4, 1.3), rng.uniform(0, 2 * np.pi), any_profile(rng)

    def force(plan: Plan) -> np.ndarray:
        s = machine.along(plan.positions)
        envelope = profile(s) if shape == DRAWN else np.sin(2 * np.pi * waves * s + shift)
        if shape == "unknown_period":
            envelope = 1 + 0.8 * envelope
        return -envelope * np.sin(2 * np.pi * plan.positions / period + phase)

    fields = {"period": (period, "m", None)}
    return Hidden(*sizes(machine.peak, 4e-3, 1e-5, 0.3), add_map("force", force), fields, shape, True)


@listed(VOCABULARY)
def coulomb_asymmetry(rng: np.random.Generator, machine: Machine, motion: Motion) -> Hidden:
    way, amplitudes = sign(rng), sizes(machine.scalars["coulomb"], 0.02, 1e-5, 1.2)
    return Hidden(*amplitudes, set_scalars("coulomb_asymmetry", way), {"difference": (lambda a: way * a, "V", 1.0)})


@listed(VOCABULARY)
def viscous_asymmetry(rng: np.random.Generator, machine: Machine, motion: Motion) -> Hidden:
    way, amplitudes = sign(rng), sizes(machine.scalars["viscous"], 0.05, 1e-5, 1.5)
    fields = {"difference": (lambda a: way * a, "V/(m/s)", 1.0)}
    return Hidden(*amplitudes, set_scalars("viscous_asymmetry", way), fields)


@listed(VOCABULARY)
def stribeck_friction(rng: np.random.Generator, machine: Machine, motion: Motion) -> Hidden:
    shape = _shape(rng, "rational", "hyperbolic", "two_speeds")
    speed, exponent = log_uniform(rng, 3e-3, 0.05), float(rng.choice([1.0, 2.0, rng.uniform(0.7, 2.5)]))
    form = float(truth.STRIBECK_SHAPES.index(shape))
    apply = set_scalars("stribeck", stribeck_velocity=speed, stribeck_exponent=exponent, stribeck_shape=form)

    fields = {"static_excess": (lambda a: a, "V", None), "velocity": (speed, "m/s", None)}
    return Hidden(*sizes(machine.scalars["coulomb"], 0.05, 1e-5, 1.5), apply, fields, shape)


@listed(VOCABULARY)
def presliding_friction(rng: np.random.Generator, machine: Machine, motion: Motion) -> Hidden:
    """The amplitude is the presliding distance Coulomb / stiffness; without the effect the bristles are rigid."""
    shape = str(rng.choice(["lugre", "dahl"]))
    level, mass = machine.scalars["coulomb"], machine.scalars["mass"]
    ratio = rng.uniform(0.3, 0.9)

    def apply(plan: Plan, amplitude: float) -> None:
        damping = ratio * np.sqrt(level / amplitude * mass) if shape == "lugre" else 0.0
        plan.set(bristle=amplitude, bristle_damping=damping)

    low = max(3.0 * machine.scalars["bristle"], 2 * machine.scalars["resolution"], 5e-7)  # below, it is sticking
    return Hidden(3 * low, low, 1e-3, apply, {"stiffness": (lambda a: level / a, "V/m", None)}, shape, True)


@listed(VOCABULARY)
def position_dependent_friction(rng: np.random.Generator, machine: Machine, motion: Motion) -> Hidden:
    shape, way = _shape(rng, DRAWN), sign(rng)
    nodes = np.array([0.0, *np.sort(rng.uniform(0.15, 0.85, int(rng.integers(1, 4)))), 1.0])
    heights = rng.uniform(-1.0, 1.0, len(nodes))
    heights = (heights - heights.mean()) / np.abs(heights - heights.mean()).max()
    profile = any_profile(rng)

    def extra(plan: Plan) -> np.ndarray:
        s = machine.along(plan.positions)
        return way * (profile(s) if shape == DRAWN else np.interp(s, nodes, heights))

    return Hidden(*sizes(machine.scalars["coulomb"], 0.05, 1e-4, 0.8), add_map("coulomb", extra), shape=shape)


@listed(VOCABULARY)
def quadratic_drag(rng: np.random.Generator, machine: Machine, motion: Motion) -> Hidden:
    shape, way = _shape(rng, "other_power"), float(rng.choice([-1, 1, 1, 1]))
    exponent = 2.0 if shape == "usual" else float(rng.choice([rng.uniform(1.6, 1.85), rng.uniform(2.2, 3.0)]))
    unit = machine.peak / machine.velocity**exponent
    fields = {"coefficient": (lambda a: way * a * unit, "V/(m/s)^2", 1.0)}
    amplitudes = 0.01, 1e-5, 0.4 if way > 0 else 0.05
    return Hidden(*amplitudes, lambda plan, a: plan.set(drag=way * a * unit, drag_exponent=exponent), fields, shape)


@listed(VOCABULARY)
def force_constant_ripple(rng: np.random.Generator, machine: Machine, motion: Motion) -> Hidden:
    shape, phase, form = _shape(rng, DRAWN), rng.uniform(0, 2 * np.pi), any_wave(rng)
    period = machine.pitch * float(rng.choice([1.0, 0.5, rng.uniform(0.6, 1.7)]))
    gain = add_map("gain", lambda plan: wave(plan.positions, period, phase, form if shape == DRAWN else np.sin))
    return Hidden(5e-3, 1e-5, 0.3, gain, {"period": (period, "m", None)} | quadratures(phase, ""), shape)


@listed(VOCABULARY)
def force_constant_drift(rng: np.random.Generator, machine: Machine, motion: Motion) -> Hidden:
    shape, way, tau = _shape(rng, DRAWN), sign(rng), rng.uniform(2.0, 8.0)
    rise = any_rise(rng)

    def change(plan: Plan) -> np.ndarray:
        t = plan.times
        return way * (rise(t / t[-1]) if shape == DRAWN else 1 - np.exp(-t / tau))

    fields = {"change": (lambda a: way * a, "", None), "time_constant": (tau, "s", None)}
    return Hidden(5e-3, 1e-5, 0.3, add_row("gain", change), fields, shape)


@listed(VOCABULARY)
def command_delay(rng: np.random.Generator, machine: Machine, motion: Motion) -> Hidden:
    high = min(6e-3, 0.25 / machine.bandwidth)
    return Hidden(3e-4, 2e-6, high, set_scalars("delay"), {"delay": (lambda a: a, "s", 1.0)})


@listed(VOCABULARY)
def actuator_lag(rng: np.random.Generator, machine: Machine, motion: Motion) -> Hidden:
    shape, ratio = _shape(rng, "two_lags", "second_order"), rng.uniform(0.3, 1.0)
    damping = rng.uniform(0.4, 0.95)

    def apply(plan: Plan, amplitude: float) -> None:
        second = ratio * amplitude if shape == "two_lags" else 0.0
        plan.set(lag=amplitude, second_lag=second, lag_damping=damping if shape == "second_order" else 0.0)

    high = min(8e-3, 0.3 / machine.bandwidth)
    return Hidden(5e-4, 5e-6, high, apply, {"time_constant": (lambda a: a, "s", 1.0)}, shape)


@listed(VOCABULARY)
def command_saturation(rng: np.random.Generator, machine: Machine, motion: Motion) -> Hidden:
    """The amplitude is the share of the largest command of the motion that is cut; for a soft one, largest / limit."""
    shape, s = _shape(rng, "one_sided", "soft", "knee"), machine.scalars
    inertia = s["mass"] * motion.acceleration + s["viscous"] * motion.velocity
    full = float(np.abs(inertia + s["coulomb"] * np.sign(motion.velocity)).max())
    side, knee = str(rng.choice(["saturation_up", "saturation_down"])), rng.uniform(3.0, 12.0)

    def apply(plan: Plan, amplitude: float) -> None:
        limit = full * (1.1 - amplitude)
        if shape == "soft":
            plan.set(saturation_soft=full / amplitude, saturation_knee=2.0)
        elif shape == "knee":
            plan.set(saturation_soft=limit, saturation_knee=knee)
        else:
            sides = [side] if shape == "one_sided" else ["saturation_up", "saturation_down"]
            plan.set(**dict.fromkeys(sides, limit))

    return Hidden(0.2, 0.01, 0.7, apply, {"limit": (lambda a: full * (1.1 - a), "V", None)}, shape)


@listed(VOCABULARY)
def command_dead_zone(rng: np.random.Generator, machine: Machine, motion: Motion) -> Hidden:
    shape, level = _shape(rng, "one_sided", "rounded"), machine.scalars["coulomb"]
    apply = set_scalars("dead_zone", dead_zone_shape=float(truth.DEAD_ZONES.index(shape)))
    return Hidden(0.05 * level, 1e-5 * level, 0.15 * machine.peak, apply, {"width": (lambda a: a, "V", None)}, shape)


@listed(VOCABULARY)
def encoder_periodic_error(rng: np.random.Generator, machine: Machine, motion: Motion) -> Hidden:
    shape, phase = _shape(rng, "triangular", "harmonics"), rng.uniform(0, 2 * np.pi)
    period, second, turn = log_uniform(rng, 5e-4, 0.03), rng.uniform(0.2, 0.6), rng.uniform(0, 2 * np.pi)

    others = {"encoder_period": period, "encoder_turn": turn, "encoder_triangular": float(shape == "triangular")}
    others["encoder_harmonics"] = second if shape == "harmonics" else 0.0

    def apply(plan: Plan, amplitude: float) -> None:
        start = plan["x_start"]
        start -= amplitude * np.sin(2 * np.pi * start / period + phase) * (shape == "usual")
        waves = {"encoder_sine": amplitude * np.cos(phase), "encoder_cosine": amplitude * np.sin(phase)}
        plan.set(**waves, **others, x_start=start)

    high = min(1e-4, period / 20)
    return Hidden(1e-6, 1e-8, high, apply, {"period": (period, "m", None)} | quadratures(phase, "m"), shape)


@listed(VOCABULARY)
def encoder_scale_error(rng: np.random.Generator, machine: Machine, motion: Motion) -> Hidden:
    """reading = x (1 + scale); the axis rests where its reading is the reference."""
    way = sign(rng)

    def apply(plan: Plan, amplitude: float) -> None:
        plan.set(encoder_scale=way * amplitude, x_start=plan["x_start"] / (1 + way * amplitude))

    return Hidden(1e-3, 1e-6, 0.03, apply, {"scale": (lambda a: way * a, "", 1.0)})


@listed(VOCABULARY)
def backlash(rng: np.random.Generator, machine: Machine, motion: Motion) -> Hidden:
    ratio = log_uniform(rng, 0.02, 0.5)
    apply = set_scalars("gap", coupling=truth.BACKLASH, load_ratio=ratio)
    return Hidden(2e-5, 1e-6, 2e-3, apply, {"gap": (lambda a: a, "m", None), "mass_ratio": (ratio, "", None)})


@listed(VOCABULARY)
def flexible_mode(rng: np.random.Generator, machine: Machine, motion: Motion) -> Hidden:
    shape, frequency = _shape(rng, "hardening"), log_uniform(rng, 15.0, min(150.0, machine.rate / 10))
    damping, hardness = log_uniform(rng, 0.01, 0.08), log_uniform(rng, 0.1, 1.0)
    deflection = machine.acceleration / (2 * np.pi * frequency) ** 2
    mode = {"coupling": truth.FLEXIBLE, "mode_frequency": frequency, "mode_damping": damping}
    mode["hardening"] = hardness / deflection**2 if shape == "hardening" else 0.0
    known = {"frequency": (frequency, "Hz", None), "damping_ratio": (damping, "", None)}
    apply = set_scalars("load_ratio", **mode)
    return Hidden(0.02, 1e-4, 0.6, apply, known | {"mass_ratio": (lambda a: a, "", None)}, shape)


@listed(VOCABULARY)
def disturbance_step(rng: np.random.Generator, machine: Machine, motion: Motion) -> Hidden:
    shape, way = _shape(rng, DRAWN), sign(rng)
    begin = rng.uniform(0.1, 0.6) * machine.duration
    end = begin + rng.uniform(0.1, 0.35) * machine.duration
    pulse = any_pulse(rng)

    def force(plan: Plan) -> np.ndarray:
        t = plan.times
        return way * (pulse((t - begin) / (end - begin)) if shape == DRAWN else (t >= begin) & (t <= end))

    fields = {"force": (lambda a: way * a, "V", 1.0), "start": (begin, "s", None), "stop": (end, "s", None)}
    return Hidden(*sizes(machine.peak, 2e-3, 1e-5, 0.5), add_row("force", force), fields, shape)


@listed(VOCABULARY)
def disturbance_tone(rng: np.random.Generator, machine: Machine, motion: Motion) -> Hidden:
    shape, phase = _shape(rng, DRAWN), rng.uniform(0, 2 * np.pi)
    frequency, form = log_uniform(rng, 2.0, min(120.0, machine.rate / 12)), any_wave(rng)
    push = add_row("force", lambda plan: wave(plan.times, 1 / frequency, phase, form if shape == DRAWN else np.sin))
    fields = {"frequency": (frequency, "Hz", None)} | quadratures(phase, "V")
    return Hidden(*sizes(machine.peak, 2e-3, 1e-6, 0.3), push, fields, shape)
