"""Machines in the large: from a galvanometer to a gantry, turning or straight, and what their users believe of them."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from .. import truth
from ..machines import log_uniform
from ..motions import Motion
from ..noises import COLOURS, draw_noise
from ..truth import Plan
from .motions import Room

ROWS_MAX = 40_000  # of a log
LAWS = ("tanh", "algebraic", "arctangent", "bristle", "stick")
#: What the model says of mass, viscous and Coulomb: nothing (a factor of 3 is meant), or a relative deviation.
STATEMENTS = ("unstated", "unstated", "loose", "loose", "tight", "exact")
DEVIATIONS = {"loose": (0.2, 0.5), "tight": (0.02, 0.08), "exact": (0.0, 0.0)}
FACTOR = 3.0


@dataclass
class LargeMachine:
    """One axis with its loop, its noise, and the model that its user has.

    Attributes:
        rotary: position is rad. room: where it moves. travel: that of the room.
        rate: Hz; duration: s, of each log; substeps: steps of integration in a sample.
        law: friction law, one of truth.LAWS; scalars: of every plan, by name.
        known: period (m), sine and cosine (command unit) of the cogging that the model has.
        colour, noise_rms, noise_corner: of the force noise; encoder_noise: m rms.
        statement: of STATEMENTS. controller_stated, reference_columns: whether the user has them.
        model: content of the model file.
    """

    rotary: bool
    room: Room
    rate: float
    duration: float
    substeps: int
    law: str
    scalars: dict[str, float]
    known: list[tuple[float, float, float]]
    colour: str
    noise_rms: float
    noise_corner: float
    encoder_noise: float
    statement: str
    controller_stated: bool
    reference_columns: bool
    model: dict[str, Any] = field(default_factory=dict)

    @property
    def travel(self) -> tuple[float, float]:
        """Of its room."""
        return self.room.travel

    @property
    def time(self) -> np.ndarray:
        """Sampling instants of a log, s."""
        return np.arange(int(self.duration * self.rate)) / self.rate

    def known_force(self, x: np.ndarray) -> np.ndarray:
        """Force of the known cogging, towards +x."""
        force = np.zeros_like(x)
        for period, sine, cosine in self.known:
            force -= sine * np.sin(2 * np.pi * x / period) + cosine * np.cos(2 * np.pi * x / period)
        return force

    def plan(self, rng: np.random.Generator, motion: Motion, *, driven: bool) -> Plan:
        """Make the plan of a motion, noise included, no effect; driven: in open loop, by the motion's command."""
        time = self.time
        plan = Plan.empty(time, self.travel, self.substeps, grid_step=self.room.length / 50_000)
        for name, value in self.scalars.items():
            plan[name] = value
        plan["law"] = truth.LAWS.index(self.law)
        plan.rows[:, truth.R_POSITION] = motion.position
        plan.rows[:, truth.R_VELOCITY] = motion.velocity
        plan.rows[:, truth.R_ACCELERATION] = motion.acceleration
        if driven:
            for name in ("kp", "ki", "kd", "kv", "ff_viscous", "ff_coulomb", "limit"):
                plan[name] = 0.0
            plan["controller"], plan["ff_mass"] = truth.PID, self.scalars["mass"]
        noise = draw_noise(rng, self.colour, len(time), 1 / self.rate, self.noise_rms, self.noise_corner)
        plan.add_noise(noise, self.encoder_noise * rng.standard_normal(len(time)))
        plan.maps[truth.M_FORCE] += self.known_force(plan.positions)
        plan["x_start"] = motion.position[0] + self.scalars["resolution"] * rng.uniform(-1.0, 1.0)
        return plan


def draw_machine(
    rng: np.random.Generator,
    *,
    statement: str,
    friction: float = 1.0,
    laws: Sequence[str] = LAWS,
    turning: bool = False,
) -> LargeMachine:
    """Draw a machine of any size; friction: a factor on it, below 1 where little may stand against a motion.

    `turning`: a rotary one; else every other.
    """
    rotary = bool(rng.random() < 0.5) or turning
    length = 2 * np.pi * rng.uniform(0.8, 4.5) if rotary else log_uniform(rng, 0.02, 30.0)
    start = float(rng.choice([0.0, -length / 2, rng.uniform(-1.0, 1.0) * length]))
    travel = (float(f"{start:.4g}"), float(f"{start:.4g}") + float(f"{length:.4g}"))
    rate = float(rng.choice([200, 400, 500, 1000, 1000, 2000, 2500, 4000, 5000]))
    duration = min(rng.uniform(8.0, 25.0), ROWS_MAX / rate)
    velocity = length / log_uniform(rng, 0.4, 4.0)
    acceleration = velocity / log_uniform(rng, 0.03, 0.3)
    mass = log_uniform(rng, 1e-3, 1e2)
    peak = mass * acceleration
    coulomb = friction * peak * log_uniform(rng, 0.03, 0.7)
    viscous = friction * peak / velocity * log_uniform(rng, 0.02, 0.4)
    substeps = max(4, int(np.ceil(1 / rate / 1e-4)))
    omega = 2 * np.pi * min(log_uniform(rng, 4.0, 40.0), rate / 30)
    law = str(rng.choice(list(laws)))
    resolution = 0.0
    if rng.random() > 0.15:
        finest, coarsest = length * 1e-7, length * 2e-5
        resolution = min(log_uniform(rng, finest, coarsest), 0.1 * (coulomb + 0.2 * peak) / (mass * omega * rate))
    scalars = {
        "mass": mass,
        "viscous": viscous,
        "coulomb": coulomb,
        # the slope of explicit friction times the step stays below 1
        "width": max(velocity * log_uniform(rng, 1e-3, 2e-2), 2 * coulomb / mass / rate / substeps),
        "resolution": float(f"{resolution:.2g}"),
        "rate": rate,
        **_bristle(coulomb, mass, 1 / rate / substeps, 1e-7 * length),
        **_loop(rng, mass, viscous, coulomb, omega, velocity),
    }
    machine = LargeMachine(
        rotary=rotary,
        room=Room(
            travel,
            velocity,
            acceleration,
            (max(0.5, 0.3 * omega / (2 * np.pi)), min(150.0, rate / 6)),
            0.5 * peak,
            mass,
        ),
        rate=rate,
        duration=duration,
        substeps=substeps,
        law=law,
        scalars=scalars,
        known=_known(rng, length, peak, rotary=rotary) if rng.random() < 0.25 else [],
        colour=str(rng.choice(list(COLOURS))),
        noise_rms=(coulomb + 0.2 * peak) * log_uniform(rng, 1e-3, 2e-2),
        noise_corner=log_uniform(rng, 5.0, min(150.0, rate / 8)),
        encoder_noise=(scalars["resolution"] or 1e-7 * length) * float(rng.choice([0.0, rng.uniform(0.1, 0.7)])),
        statement=statement,
        controller_stated=bool(rng.random() < 0.5),
        reference_columns=bool(rng.random() < 0.65),
    )
    machine.model = _model(rng, machine)
    return machine


def _bristle(coulomb: float, mass: float, step: float, finest: float) -> dict[str, float]:
    """Bristles that no encoder sees, as stiff as the step of integration allows."""
    length = max(finest, coulomb / mass * (step / 0.3) ** 2)
    return {"bristle": length, "bristle_damping": 0.7 * float(np.sqrt(coulomb / length * mass))}


def _loop(
    rng: np.random.Generator, mass: float, viscous: float, coulomb: float, omega: float, velocity: float
) -> dict[str, float]:
    """A PID or a cascade, tuned by hand: near what the mass asks for, not at it."""
    tuned = mass * log_uniform(rng, 0.7, 1.5)
    feed = rng.random() < 0.5
    loop = {
        "ff_mass": float(f"{tuned:.3g}") if feed else 0.0,
        "ff_viscous": float(f"{viscous:.3g}") if feed else 0.0,
        "ff_coulomb": float(f"{0.8 * coulomb:.3g}") if feed and rng.random() < 0.5 else 0.0,
        "ff_width": float(f"{velocity * log_uniform(rng, 3e-3, 3e-2):.3g}"),
        "ff_measured": 0.0,
    }
    if rng.random() < 0.25:
        kp, kv = float(f"{omega / 2.5:.3g}"), float(f"{tuned * omega:.3g}")
        return {**loop, "controller": truth.CASCADE, "kp": kp, "kv": kv}
    kp, kd = float(f"{tuned * omega**2 / 2:.3g}"), float(f"{tuned * omega:.3g}")
    ki = float(f"{kp * omega / rng.uniform(8, 25):.3g}") if rng.random() < 0.8 else 0.0
    return {**loop, "controller": truth.PID, "kp": kp, "ki": ki, "kd": kd}


def _known(rng: np.random.Generator, length: float, peak: float, *, rotary: bool) -> list[tuple[float, float, float]]:
    """Some harmonics of a pitch that the user has mapped: small beside what is missing."""
    pitch = 2 * np.pi / int(rng.integers(2, 30)) if rotary else float(f"{length / rng.uniform(3.0, 40.0):.3g}")
    harmonics = [[1], [1, 2], [1, 3], [1, 2, 6]][int(rng.integers(4))]
    size = peak * log_uniform(rng, 0.02, 0.1)
    drawn = []
    for order in harmonics:
        angle = rng.uniform(0, 2 * np.pi)
        drawn.append((pitch / order, size / order * float(np.cos(angle)), size / order * float(np.sin(angle))))
    return drawn


def _model(rng: np.random.Generator, machine: LargeMachine) -> dict[str, Any]:
    """The model file that the user has: wrong as far as it says it may be."""
    scalars, axis = machine.scalars, {}
    uncertainty: dict[str, float] = {}
    for name in ("mass", "viscous", "coulomb"):
        if machine.statement == "unstated":
            wrong = log_uniform(rng, 1 / FACTOR, FACTOR)
        else:
            low, high = DEVIATIONS[machine.statement]
            uncertainty[name] = float(f"{rng.uniform(low, high):.2g}")
            wrong = max(1 + uncertainty[name] * float(np.clip(rng.standard_normal(), -1.8, 1.8)), 1 / FACTOR)
        axis[name] = scalars[name] / wrong if machine.statement == "exact" else float(f"{scalars[name] / wrong:.4g}")
    smooth = machine.law not in ("stick", "bristle")
    axis["coulomb_width"] = float(f"{scalars['width'] * log_uniform(rng, 0.5, 2.0):.3g}") if smooth else 0.0
    model: dict[str, Any] = {"axis": axis, "units": {"position": "rad" if machine.rotary else "m"}}
    if uncertainty:
        axis["uncertainty"] = uncertainty
    if rng.random() < 0.6:
        axis["travel"] = list(machine.travel)
    if rng.random() < 0.6:
        model["encoder"] = {"resolution": scalars["resolution"], "noise": machine.encoder_noise}
    if rng.random() < 0.4:
        stated = machine.noise_rms * float(rng.choice([0.5, 1.0, 2.0]))
        model["noise"] = {"force": float(f"{stated:.2g}"), "bandwidth": float(rng.choice([30, 50, 100]))}
    if machine.known:
        pitch = machine.known[0][0]
        wrong = 1 + 0.1 * rng.standard_normal((2, len(machine.known)))
        model["cogging"] = {
            "pitch": pitch,
            "harmonics": [round(pitch / period) for period, _, _ in machine.known],
            "sine": [[float(sine * w)] for (_, sine, _), w in zip(machine.known, wrong[0], strict=True)],
            "cosine": [[float(cosine * w)] for (_, _, cosine), w in zip(machine.known, wrong[1], strict=True)],
        }
    if machine.controller_stated:
        model["controller"] = _controller(scalars)
    return model


def _controller(scalars: dict[str, float]) -> dict[str, Any]:
    cascade = scalars["controller"] == truth.CASCADE
    told: dict[str, Any] = {"type": "cascade" if cascade else "pid", "sample_rate": scalars["rate"]}
    told |= {name: scalars[name] for name in (("kp", "kv") if cascade else ("kp", "ki", "kd"))}
    names = {"mass": "ff_mass", "viscous": "ff_viscous", "coulomb": "ff_coulomb", "coulomb_width": "ff_width"}
    return {**told, **{name: scalars[own] for name, own in names.items()}}


__all__ = ["DEVIATIONS", "FACTOR", "STATEMENTS", "LargeMachine", "draw_machine"]
