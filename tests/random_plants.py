"""Machines drawn at random, gentle to stiff, with every effect: the same one for the simulator and for scipy."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

import cogging
from scipy_plant import ScipyPlant


@dataclass
class Driven:
    """A plant under given commands: sample rate (Hz), commands (V), where it starts (m, m/s), and what it is like."""

    rate: float
    commands: np.ndarray
    position: float
    velocity: float
    plant: ScipyPlant

    @property
    def time(self):
        return np.arange(len(self.commands)) / self.rate

    @property
    def stiffness(self):
        """The fastest rate at which friction may brake the motor, times the sample time."""
        p = self.plant
        level = p.coulomb * 2.5  # what asymmetry, Stribeck and the level along the travel add
        slope = p.viscous + (2 / np.pi * level / p.width if p.width > 0 else 0.0)
        return slope / (p.mass * (1 - p.ratio)) / self.rate

    def simulated(self, **options):
        """True positions and velocities of the simulator, (n, 2)."""
        still = np.zeros_like(self.time)
        log = cogging.closed_loop(
            plant_of(self.plant),
            cogging.Pid(cogging.PidParameters(sample_rate=self.rate, mass=1.0)),
            cogging.Sampled(self.time, still, still, self.commands),
            initial_position=self.position,
            initial_velocity=self.velocity,
            **options,
        )
        return np.column_stack([log["true_position"], log["true_velocity"]])

    def expected(self):
        """The same by scipy."""
        return self.plant.run(self.time, self.commands, self.position, self.velocity)


def plant_of(plant):
    """The simulator's plant of a ScipyPlant."""
    axis = cogging.AxisParameters(
        mass=plant.mass, viscous=plant.viscous, coulomb=plant.coulomb, coulomb_width=plant.width
    )
    model = None
    if plant.cogging is not None:
        pitch, harmonics, order, origin, sine, cosine = plant.cogging
        knots = {"order": order, "origin": origin, "control_points": sine.shape[1]}
        model = cogging.CoggingModel(cogging.SplineHarmonics(pitch=pitch, harmonics=harmonics, **knots), sine, cosine)
    effects = [cogging.EFFECTS[name](**fields) for name, fields in plant.effects]
    return cogging.Plant(axis, cogging=model, effects=effects)


def between(rng, low, high):
    return float(10 ** rng.uniform(np.log10(low), np.log10(high)))


def draw(seed, fastest):
    """A machine whose viscous rate, times the sample time, is from 0.001 to `fastest`."""
    rng = np.random.default_rng(seed)
    rate, rows = between(rng, 400, 10_000), int(rng.integers(25, 60))
    size, speed = between(rng, 0.05, 5), between(rng, 1e-2, 1)  # V, m/s
    viscous = size / speed
    quick = between(rng, 1, fastest) if rng.random() < 0.5 else between(rng, 0.001, 1)
    coulomb = size * rng.uniform(0, 0.8) * (rng.random() < 0.8)
    width = 0.0 if rng.random() < 0.35 else speed * between(rng, 1e-4, 0.3)
    duration = rows / rate
    plant = ScipyPlant(viscous / rate / quick, viscous, coulomb, width)
    plant = ScipyPlant(
        plant.mass,
        viscous,
        coulomb,
        width,
        cogging=drawn_cogging(rng, size, speed * duration),
        effects=drawn_effects(rng, rate, duration, size, speed, coulomb),
    )
    t = np.arange(rows) / rate
    commands = [
        size * np.sin(2 * np.pi * t / duration * rng.uniform(0.5, 4) + rng.uniform(0, 6)),
        size * np.repeat(rng.normal(size=rows), 5)[:rows],
        size * rng.uniform(-1, 1) * np.ones(rows),
    ][rng.integers(3)]
    velocity = 0.0 if rng.random() < 0.5 else speed * rng.normal() * 0.3
    return Driven(rate, commands, speed * duration * rng.normal() * 0.2, velocity, plant)


def drawn_cogging(rng, size, travel):
    if rng.random() < 0.4:
        return None
    pitch, order = travel * between(rng, 1e-2, 3), int(rng.integers(1, 5))
    points = int(rng.integers(order, order + 6)) if rng.random() < 0.6 else 1
    harmonics = sorted(int(i) for i in rng.choice([1, 2, 3, 6, 12], size=int(rng.integers(1, 4)), replace=False))
    amplitudes = size * rng.uniform(0.02, 0.4) * rng.normal(size=(2, len(harmonics), points))
    return pitch, harmonics, order, -0.5 * points * pitch * rng.random(), *amplitudes


def drawn_effects(rng, rate, duration, size, speed, coulomb):
    """Every effect that acts on the motion, each now and then; the encoder's errors do not."""
    h, travel, viscous = 1 / rate, speed * duration, size / speed

    def force(share):
        return size * share * rng.normal()

    def nodes(scale, count=4):
        return sorted(float(value) for value in scale * rng.uniform(-1, 1, size=count))

    def forces(share, count=4):
        return [force(share) for _ in range(count)]

    start = duration * rng.uniform(0, 0.7)
    chances = {
        "constant_force": (0.1, lambda: {"force": force(0.3)}),
        "cable_spring": (0.2, lambda: {"stiffness": size / travel * between(rng, 0.01, 3), "center": force(travel)}),
        "end_effect": (
            0.1,
            lambda: {
                "force": force(0.2),
                "decay_length": travel * between(rng, 0.02, 1),
                "travel": [-2 * travel, 2 * travel],
            },
        ),
        "cogging_harmonic": (
            0.2,
            lambda: {"period": travel * between(rng, 1e-3, 1), "sine": force(0.1), "cosine": force(0.1)},
        ),
        "cogging_modulation": (
            0.1,
            lambda: {
                "period": travel * between(rng, 1e-2, 1),
                "sine": forces(0.1),
                "cosine": forces(0.1),
                "pitch": travel * between(rng, 0.1, 1),
                "order": int(rng.integers(1, 5)),
                "origin": travel * rng.uniform(-1, 0),
            },
        ),
        "coulomb_asymmetry": (0.15, lambda: {"difference": coulomb * rng.uniform(-0.9, 0.9)}),
        "viscous_asymmetry": (0.15, lambda: {"difference": viscous * rng.uniform(-0.8, 0.8)}),
        "stribeck_friction": (
            0.15,
            lambda: {
                "static_excess": coulomb * rng.uniform(0, 0.6),
                "velocity": speed * between(rng, 0.003, 0.3),
                "exponent": rng.uniform(0.5, 3),
            },
        ),
        "position_dependent_friction": (
            0.1,
            lambda: {"nodes": nodes(travel), "levels": [coulomb * rng.uniform(-0.3, 0.5) for _ in range(4)]},
        ),
        "quadratic_drag": (0.15, lambda: {"coefficient": viscous / speed * between(rng, 0.01, 1)}),
        "force_constant_ripple": (
            0.15,
            lambda: {
                "period": travel * between(rng, 1e-2, 1),
                "sine": 0.1 * rng.normal(),
                "cosine": 0.1 * rng.normal(),
            },
        ),
        "force_constant_drift": (
            0.1,
            lambda: {"change": 0.3 * rng.normal(), "time_constant": duration * between(rng, 0.01, 3)},
        ),
        "command_delay": (0.15, lambda: {"delay": h * rng.uniform(0, 5)}),
        "actuator_lag": (0.2, lambda: {"time_constant": h * between(rng, 0.01, 30)}),
        "command_saturation": (0.1, lambda: {"limit": size * rng.uniform(0.3, 1)}),
        "command_dead_zone": (0.1, lambda: {"width": size * rng.uniform(0, 0.4)}),
        "disturbance_step": (
            0.1,
            lambda: {"force": force(0.3), "start": start, "stop": start + duration * rng.uniform(0.01, 0.3)},
        ),
        "disturbance_tone": (
            0.25,
            lambda: {"frequency": rate * between(rng, 0.01, 3), "sine": force(0.3), "cosine": force(0.3)},
        ),
        "empirical_force": (
            0.1,
            lambda: {
                "position_nodes": nodes(travel),
                "position_forces": forces(0.1),
                "velocity_nodes": nodes(speed),
                "velocity_forces": forces(0.1),
                "time_nodes": [start, start + 0.1 * duration],
                "time_forces": forces(0.1, 2),
            },
        ),
        "presliding_friction": (
            0.1 * (coulomb > 0),
            lambda: {
                "stiffness": coulomb / (travel * between(rng, 1e-4, 0.1)),
                "damping": viscous * rng.uniform(0, 0.3),
            },
        ),
        "flexible_mode": (
            0.15,
            lambda: {
                "frequency": rate * between(rng, 0.002, 2),
                "damping_ratio": between(rng, 0.003, 0.5),
                "mass_ratio": rng.uniform(0.1, 0.8),
            },
        ),
        "backlash": (
            0.1,
            lambda: {
                "gap": travel * between(rng, 1e-3, 0.3),
                "mass_ratio": rng.uniform(0.1, 0.8),
                "contact_frequency": rate * between(rng, 0.01, 1),
                "contact_damping_ratio": between(rng, 0.01, 2),
            },
        ),
    }
    drawn = [(name, make()) for name, (chance, make) in chances.items() if rng.random() < chance]
    loads = [name for name, _ in drawn if name in ("flexible_mode", "backlash")]
    return [entry for entry in drawn if entry[0] not in loads[1:]]  # an axis has one load
