"""Machines of the blind suite: axes small and large, their controllers, noise and nominal models."""

from collections.abc import Callable
from dataclasses import dataclass, field
from typing import Any

import numpy as np
from scipy.interpolate import BSpline

from . import truth
from .motions import Motion, draw_motion
from .noises import DRAWN_COLOURS, draw_noise
from .shapes import any_profile
from .truth import Plan

#: Families of nulls: each forces one trait, all else is drawn.
NULL_FAMILIES = (
    *("plain", "other_friction", "sticking", "bristles", "sharp_friction", "wide_friction", "coloured_noise"),
    *("pink_noise", "heavy_tails", "loud_noise", "quiet_noise", "jitter", "fine_steps", "coarse_encoder"),
    *("wrong_nominals", "no_controller", "poor_motion"),
)


def log_uniform(rng: np.random.Generator, low: float, high: float) -> float:
    """Draw from low to high, even in the logarithm."""
    return float(np.exp(rng.uniform(np.log(low), np.log(high))))


def rounded(value: float, digits: int) -> float:
    """A number as a user would write it: so many digits."""
    return float(f"{value:.{digits}g}")


@dataclass
class Machine:
    """One axis with its controller, noise, and what its user believes.

    Attributes:
        family: the trait that was forced.
        travel: m. velocity, acceleration: largest of its motions, m/s and m/s^2. peak: command of that acceleration.
        scalars: of every plan of this machine, by name.
        law: friction law, one of truth.LAWS.
        periods: of the known cogging, m; pitch: its knots. sine, cosine: amplitudes at its control points, (K, points).
        uncertainty: stated relative 1-sigma.
        model: the model file's content, as given to the user.
    """

    family: str
    travel: tuple[float, float]
    velocity: float
    acceleration: float
    peak: float
    rate: float
    duration: float
    substeps: int
    law: str
    scalars: dict[str, float]
    pitch: float
    harmonics: list[int]
    sine: np.ndarray
    cosine: np.ndarray
    drift: Callable[[np.ndarray], np.ndarray]
    colour: str
    noise: float
    noise_corner: float
    encoder_noise: float
    poor_motion: bool
    stated_controller: bool
    jitter: float
    uncertainty: dict[str, float]
    reference_columns: bool = True
    model: dict[str, Any] = field(default_factory=dict)

    @property
    def periods(self) -> list[float]:
        """Of the known cogging, m."""
        return [self.pitch / h for h in self.harmonics]

    @property
    def length(self) -> float:
        """Of the travel, m."""
        return self.travel[1] - self.travel[0]

    @property
    def bandwidth(self) -> float:
        """Cross-over of the loop, rad/s."""
        return self.scalars["kv" if self.scalars["controller"] == truth.CASCADE else "kd"] / self.scalars["mass"]

    def along(self, x: np.ndarray) -> np.ndarray:
        """Share of the travel at x, 0 to 1."""
        return (x - self.travel[0]) / self.length

    def cogging(self, x: np.ndarray, index: int, *, cosine: bool) -> np.ndarray:
        """One unit harmonic of the known cogging over x, with its drift, as force towards +x."""
        phase = 2 * np.pi * x / self.periods[index]
        return -self.drift(x) * (np.cos(phase) if cosine else np.sin(phase))

    def draw_motion(self, rng: np.random.Generator) -> tuple[np.ndarray, Motion]:
        """Draw a motion of this machine and its nominal sampling instants."""
        time = np.arange(int(self.duration * self.rate)) / self.rate
        return time, draw_motion(rng, time, self.travel, self.velocity, self.acceleration, poor=self.poor_motion)

    def plan(self, rng: np.random.Generator, motion: Motion, time: np.ndarray) -> Plan:
        """Make the plan of this machine on a motion, noise included, no effect."""
        plan = Plan.empty(time, self.travel, self.substeps)
        plan.set(**self.scalars, law=truth.LAWS.index(self.law))
        if self.jitter > 0.0:
            plan.instants += np.clip(self.jitter * rng.standard_normal(len(time)), -0.3, 0.3) / self.rate
            plan.instants -= plan.instants[0]
            plan.stamps = plan.instants.copy()
        plan.follow(motion)
        noise = draw_noise(rng, self.colour, len(time), 1 / self.rate, self.noise, self.noise_corner)
        plan.add_noise(noise, self.encoder_noise * rng.standard_normal(len(time)))
        for index in range(len(self.harmonics)):
            plan.maps[truth.M_FORCE] += self.sine[index] * self.cogging(plan.positions, index, cosine=False)
            plan.maps[truth.M_FORCE] += self.cosine[index] * self.cogging(plan.positions, index, cosine=True)
        plan.set(x_start=motion.position[0] + self.scalars["resolution"] * rng.uniform(-1.0, 1.0))
        return plan


def draw_machine(
    rng: np.random.Generator,
    family: str = "plain",
    *,
    tight: bool = False,
    law: str | None = None,
    friction: float = 1.0,
) -> Machine:
    """Draw a machine.

    Args:
        tight: mass, viscous and Coulomb are stated to 1 to 3 %.
        law: the friction law, else drawn.
        friction: factor on viscous and Coulomb friction.
    """
    length = log_uniform(rng, 0.1, 1.0)
    start = float(rng.choice([0.0, 0.0, -length / 2, rng.uniform(-0.1, 0.1)]))
    travel = (round(start, 4), round(start + length, 4))
    acceleration = log_uniform(rng, 2.0, 20.0)
    velocity = min(log_uniform(rng, 0.15, 1.2), 0.7 * np.sqrt(acceleration * length))
    mass = log_uniform(rng, 0.1, 100.0)
    peak = mass * acceleration
    coulomb = friction * (peak * log_uniform(rng, 0.005, 0.2))
    viscous = friction * (peak * log_uniform(rng, 0.01, 0.15) / velocity)
    rate = float(rng.choice([1000, 1000, 2000, 2000, 2500, 4000, 5000]))
    width = log_uniform(rng, 3e-4, 3e-3)
    if family == "sharp_friction":
        width = log_uniform(rng, 5e-5, 2e-4)
    elif family == "wide_friction":
        width = log_uniform(rng, 3e-3, 8e-3)
    if law is None:
        laws = {"sticking": "stick", "bristles": "bristle", "other_friction": "tanh algebraic mixture ramp"}
        usual = "tanh algebraic arctangent arctangent mixture ramp bristle stick"
        law = str(rng.choice(laws.get(family, usual).split()))
    substeps = max(10, int(np.ceil(1 / rate / 5e-5)))
    if family == "fine_steps":
        substeps *= 4
    # explicit friction must stay stable: slope of the friction times the step below 1
    width = max(width, 2 * coulomb / mass / rate / substeps)

    # control: bandwidth well below the sampling
    omega = 2 * np.pi * min(log_uniform(rng, 12.0, 50.0), rate / 40)
    cascade = rng.random() < 0.3
    resolution = log_uniform(rng, 2e-8, 2e-6)
    if family == "coarse_encoder":
        resolution = log_uniform(rng, 1e-6, 5e-6)
    else:  # the derivative must not shout: a count is worth at most 2 % of the peak
        resolution = min(resolution, 0.02 * peak / (2 * mass * omega * rate))
    resolution = rounded(resolution, 2)

    true_of = {"mass": mass, "viscous": viscous, "coulomb": coulomb}
    sigma = dict(zip(true_of, (0.01, 0.03, 0.03) if tight else (0.03, 0.2, 0.2), strict=True))
    spread = 2.0 if family == "wrong_nominals" else 1.0
    nominal = {}
    for name, value in true_of.items():
        draw = float(np.clip(spread * rng.standard_normal(), -2.3, 2.3))
        nominal[name] = rounded(value / (1 + sigma[name] * draw), 4)
    nominal["coulomb_width"] = rounded(width * log_uniform(rng, 0.3, 3.0), 3)

    feed = rng.random() < 0.85
    scalars: dict[str, float] = {
        **true_of,
        "width": width,
        "share": rng.uniform(0.3, 0.9),
        "resolution": resolution,
        "bristle": min(resolution * log_uniform(rng, 0.05, 0.5), 1e-7),  # m; stiffer than any encoder sees
        "bristle_damping": 0.0,
        "controller": truth.CASCADE if cascade else truth.PID,
        "rate": rate,
        "ff_mass": rounded(nominal["mass"] * rng.uniform(0.9, 1.1), 3) if feed else 0.0,
        "ff_viscous": nominal["viscous"] if feed else 0.0,
        "ff_coulomb": rounded(nominal["coulomb"] * rng.uniform(0.6, 1.0), 3) if feed and rng.random() < 0.8 else 0.0,
        "ff_width": rounded(nominal["coulomb_width"] * log_uniform(rng, 1.0, 4.0), 3),
    }
    # a bristle that is too stiff for the step would ring: its frequency stays below 0.2 of the step's
    scalars["bristle"] = max(scalars["bristle"], coulomb / mass * (1 / rate / substeps / 0.3) ** 2)
    scalars["bristle_damping"] = 0.7 * np.sqrt(coulomb / scalars["bristle"] * mass)
    if cascade:
        scalars |= {"kp": rounded(omega / 2.5, 3), "kv": rounded(nominal["mass"] * omega, 3)}
    else:
        scalars |= {"kp": rounded(nominal["mass"] * omega**2 / 2, 3), "kd": rounded(nominal["mass"] * omega, 3)}
        scalars["ki"] = rounded(scalars["kp"] * omega / rng.uniform(8, 25), 3) if rng.random() < 0.8 else 0.0
    if rng.random() < 0.3:
        scalars["limit"] = rounded(8 * peak, 2)

    pitch = rounded(min(log_uniform(rng, 0.012, 0.06), length / 4), 3)
    harmonics = [list(h) for h in ([1], [1, 2], [1, 2, 3], [1, 3], [2, 6], [1, 2, 6])][int(rng.integers(6))]
    size = peak * log_uniform(rng, 0.003, 0.1)
    angle = rng.uniform(0, 2 * np.pi, len(harmonics))
    share = np.array([1.0 / (1 + i) ** rng.uniform(0.3, 1.5) for i in range(len(harmonics))])
    depth = rng.uniform(0.1, 0.3) if rng.random() < 0.5 else 0.0
    profile = any_profile(rng)

    def drift(x: np.ndarray) -> np.ndarray:
        return 1 + depth * profile((x - travel[0]) / length)

    colours = {"coloured_noise": ["second_order"], "pink_noise": ["pink"], "heavy_tails": ["heavy_tails"]}
    machine = Machine(
        family=family, travel=travel, velocity=velocity, acceleration=acceleration, peak=peak, rate=rate,
        duration=float(rng.uniform(8.0, 15.0)), substeps=substeps, law=law, scalars=scalars, pitch=pitch,
        harmonics=harmonics, sine=size * share * np.cos(angle), cosine=size * share * np.sin(angle), drift=drift,
        colour=str(rng.choice(colours.get(family, list(DRAWN_COLOURS)))),
        noise=peak * log_uniform(rng, 5e-4, 5e-3),
        noise_corner=log_uniform(rng, 15.0, min(200.0, rate / 8)),
        encoder_noise=resolution * float(rng.choice([0.0, rng.uniform(0.1, 1.0)])),
        poor_motion=family == "poor_motion" or rng.random() < 0.08,
        stated_controller=family != "no_controller" and (rng.random() < 0.7 or family != "plain"),
        jitter=log_uniform(rng, 0.003, 0.08) if family == "jitter" or rng.random() < 0.15 else 0.0,
        uncertainty=sigma,
    )  # fmt: skip
    machine.reference_columns = machine.stated_controller or rng.random() >= 0.5
    machine.model = _model(rng, machine, nominal)
    return machine


def _model(rng: np.random.Generator, machine: Machine, nominal: dict[str, float]) -> dict[str, Any]:
    """The model file that the user has: wrong within its stated uncertainty."""
    low, high = machine.travel
    pitch = max(machine.pitch, machine.length / 12)
    points = int(np.ceil(machine.length / pitch)) + 2
    knots, x = low + pitch * np.arange(-2, points + 1), np.linspace(low, high, 40 * points)
    basis = BSpline.design_matrix(np.clip(x, low, high - 1e-9), knots, 2).toarray()[:, :points]
    shape = np.linalg.lstsq(basis, machine.drift(x), rcond=None)[0]
    if np.ptp(shape) < 1e-6:
        shape = np.ones(1)
    else:
        # The axis has the drift that the map can hold: what the spline misses of another would be a missing effect.
        held = BSpline(knots, shape, 2)
        machine.drift = lambda at: held(np.clip(at, low, high - 1e-9))
    amplitudes = []
    for sine, cosine in zip(machine.sine, machine.cosine, strict=True):
        wrong = (1 + 0.1 * rng.standard_normal()) * np.exp(0.1j * rng.standard_normal())
        amplitudes.append((sine + 1j * cosine) * wrong)
    cogging: dict[str, Any] = {"pitch": pitch, "order": 3, "origin": low}
    cogging |= {"harmonics": machine.harmonics} if pitch == machine.pitch else {"periods": machine.periods}
    cogging["sine"] = [(one.real * shape).tolist() for one in amplitudes]
    cogging["cosine"] = [(one.imag * shape).tolist() for one in amplitudes]
    scalars = machine.scalars
    model: dict[str, Any] = {
        "axis": {**nominal, "travel": list(machine.travel), "uncertainty": machine.uncertainty},
        "cogging": cogging,
        "encoder": {"resolution": scalars["resolution"], "noise": machine.encoder_noise},
    }
    stated = {"loud_noise": 1 / 3, "quiet_noise": 3.0}.get(machine.family, float(rng.choice([1.0, 1.0, 0.7, 1.5, 3.0])))
    if rng.random() > 0.3 or machine.family in ("loud_noise", "quiet_noise"):
        force = rounded(stated * machine.noise, 2)
        model["noise"] = {"force": force, "bandwidth": float(rng.choice([30, 50, 100]))}
    if machine.stated_controller:
        fed = {"mass": "ff_mass", "viscous": "ff_viscous", "coulomb": "ff_coulomb", "coulomb_width": "ff_width"}
        cascade = scalars["controller"] == truth.CASCADE
        controller: dict[str, Any] = {"type": "cascade" if cascade else "pid", "sample_rate": machine.rate}
        controller |= {key: float(scalars.get(key, 0.0)) for key in (("kp", "kv") if cascade else ("kp", "ki", "kd"))}
        controller |= {key: float(scalars[name]) for key, name in fed.items()}
        if scalars.get("limit"):
            controller["command_limit"] = scalars["limit"]
        model["controller"] = controller
    return model
