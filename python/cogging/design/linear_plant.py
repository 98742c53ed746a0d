"""The axis as a linear system about a position and a speed, and the linear part of its controller."""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import Any, NamedTuple

import numpy as np

from cogging._core import effects, smooth_sign
from cogging.arrays import FloatArray
from cogging.effects.effect import Effect, laws_of, steady_friction
from cogging.model.model import Model

STEP = 1e-6  # of the derivatives of a law, in units of the place and of the speed
LINEAR_EVERYWHERE = (
    effects.ConstantForce,
    effects.CableSpring,
    effects.CommandDelay,
    effects.ActuatorLag,
    effects.FlexibleMode,
    effects.EncoderScaleError,
)
#: Forces and levels of friction that are the same at every place.
OF_SPEED = (effects.StribeckFriction, effects.CoulombAsymmetry, effects.ViscousAsymmetry, effects.QuadraticDrag)


class LinearPlant(NamedTuple):
    """x' = a x + b u(t - delay), reading = c x: deviations from the place and the speed."""

    a: FloatArray  # (n, n); states: position m, velocity m/s, of a mode its deflection m and rate m/s, of a lag its V
    b: FloatArray  # (n, 1)
    c: FloatArray  # (1, n)
    delay: float  # s
    left_out: tuple[str, ...]  # nonlinear parts that are not included


class HeldPlant(NamedTuple):
    """The plant from sample to sample: x[k+1] = transition x[k] + now u[k - whole] + before u[k - whole - 1]."""

    transition: FloatArray  # (n, n)
    now: FloatArray  # (n, 1), of the command that acts in the rest of a sample
    before: FloatArray  # (n, 1), of the one before, which acts in its first part
    output: FloatArray  # (1, n)
    whole: int  # samples of delay


def linear_plant(model: Model, *, speed: float | None = None, position: float | None = None) -> LinearPlant:
    """Linearise M x'' = gain u - friction(x, v) - F_cogging(x) + effects about a place (m) and a speed (m/s).

    Without a speed only viscous friction counts; without a position only springs and a scale of the encoder, which are
    the same everywhere. ValueError: at this speed friction has no slope.
    """
    axis, width = model.axis, model.axis.coulomb_width
    known = [one.resolved(axis, model.cogging) for one in model.effects]

    def friction(effects: list[Effect], x: float, v: float) -> FloatArray:
        """Return the force that opposes the motion, V."""
        own = axis.viscous * v + axis.coulomb * smooth_sign(v, width)
        return np.asarray(own + steady_friction(effects, v, width=width, position=x))

    if speed is not None and width == 0.0 and speed == 0.0:
        raise ValueError("speed: must be other than 0 where coulomb_width is 0: sticking has no slope, got 0")
    if position is None:
        stiffness = sum(one.stiffness for one in known if isinstance(one, effects.CableSpring))
    else:
        stiffness = _slope(lambda x: friction(known, x, speed or 0.0), position, STEP)
        stiffness += float(model.cogging.slope(position)) if model.cogging is not None else 0.0
    damping = axis.viscous
    if speed is not None:
        there = [one for one in known if position is not None or isinstance(one, OF_SPEED)]
        damping = _slope(lambda v: friction(there, position or 0.0, v), speed, STEP * max(abs(speed), width))
    gain, reading = 1.0 / axis.mass, 1.0
    for one in known:
        if isinstance(one, effects.EncoderScaleError):
            reading += one.scale
        elif "reading" in one.HOOKS and position is not None:
            reading += _slope(laws_of(one).reading_at, position, STEP) - 1.0
    a = np.array([[0.0, 1.0], [-stiffness / axis.mass, -damping / axis.mass]])
    c = np.array([[reading, 0.0]])
    for one in known:
        if isinstance(one, effects.FlexibleMode) and one.mass_ratio > 0.0 and math.isfinite(one.frequency):
            # Motor and load on a spring: m1 x'' = forces + k q + c q', m2 (x + q)'' = -k q - c q'.
            w, load = 2.0 * math.pi * one.frequency, one.mass_ratio * axis.mass
            motor = (1.0 - one.mass_ratio) * axis.mass
            reduced = motor * load / axis.mass
            spring, damper = w * w * reduced, 2.0 * one.damping_ratio * w * reduced
            motor_row = np.array([-stiffness, -damping, spring, damper]) / motor
            load_row = np.array([0.0, 0.0, -spring, -damper]) / load - motor_row
            a = np.array([[0.0, 1.0, 0.0, 0.0], motor_row, [0.0, 0.0, 0.0, 1.0], load_row])
            c, gain = np.hstack([c[:, :2], np.zeros((1, 2))]), 1.0 / motor
    if position is not None:
        gains = (laws_of(one).gain_at(position=position) for one in known if "command_gain" in one.HOOKS)
        gain *= 1.0 + sum(map(float, gains))
    b = np.zeros((a.shape[0], 1))
    b[1:, 0] = [gain, *([0.0, -gain] if a.shape[0] == 4 else [])]
    for one in known:
        if isinstance(one, effects.ActuatorLag) and one.time_constant > 0.0:
            # Behind one more current loop, T u' = command - u, whose u is the last state.
            a = np.block([[a, b], [np.zeros((1, a.shape[0])), -1.0 / one.time_constant]])
            b = np.append(np.zeros((len(b), 1)), [[1.0 / one.time_constant]], axis=0)
            c = np.hstack([c, np.zeros((1, 1))])
    delay = sum(one.delay for one in known if isinstance(one, effects.CommandDelay))
    return LinearPlant(a, b, c, delay, _left_out(model, speed, position))


def _slope(law: Callable[[float], Any], at: float, step: float) -> float:
    """Derivative of a law by central differences."""
    return (float(law(at + step)) - float(law(at - step))) / (2.0 * step)


def held(plant: LinearPlant, sample_time: float) -> HeldPlant:
    """The plant behind a command that is held over a sample (s) and acts after its delay, exactly."""
    from scipy.linalg import expm

    size = plant.a.shape[0]
    both = np.zeros((size + 1, size + 1))
    both[:size, :size], both[:size, size:] = plant.a, plant.b
    whole, part = divmod(plant.delay / sample_time, 1.0)
    # The command of the sample before acts for the first part of a sample, that of the sample for the rest.
    now, early = (expm(both * (share * sample_time))[:size, size:] for share in (1.0 - part, part))
    before = expm(plant.a * (1.0 - part) * sample_time) @ early
    return HeldPlant(expm(plant.a * sample_time), now, before, plant.c, int(whole))


def _left_out(model: Model, speed: float | None, position: float | None) -> tuple[str, ...]:
    left = []
    if speed is None and model.axis.coulomb > 0.0:
        left.append("Coulomb friction (no speed given)")
    if position is None and model.cogging is not None:
        left.append("cogging (no position given)")
    for one in model.effects:
        if isinstance(one, LINEAR_EVERYWHERE) or (speed is not None and isinstance(one, OF_SPEED)):
            continue
        taken = {"force", "friction_level"} if speed is not None and position is not None else set()
        taken |= {"force", "reading", "command_gain"} if position is not None else set()
        if not set(one.HOOKS) <= taken or isinstance(one, effects.DisturbanceStep | effects.DisturbanceTone):
            left.append(one.NAME)
    return tuple(left)


FREQUENCIES = 2000  # of the sensitivity, up to half the sample rate
LOWEST = 1e-4  # of them, over the sample rate
UNIT_CIRCLE = 1.0 + 1e-9

Polynomials = tuple[FloatArray, FloatArray]


def modulus_margin(model: Model) -> float | None:
    """min over the frequency of |1 + L|, L = C(z) P(z) the loop of the model's own controller; 0 where it is unstable.

    P is M x'' = u - B x' with the model's delays and current loop, its command held over a sample, exactly; friction
    but the viscous, cogging and flexibility are left out. C is the controller's linear part (see linear_controller).

    Returns:
        1, from 0 to 1, or None where the controller has no such part.
    """
    from scipy.signal import ss2tf

    controller = linear_controller(model)
    if controller is None or model.controller is None:
        return None
    kept = [one for one in model.effects if isinstance(one, effects.CommandDelay | effects.ActuatorLag)]
    plant, none = held(linear_plant(model.replace(effects=kept)), 1.0 / model.controller.sample_rate), np.zeros((1, 1))
    now, poles = ss2tf(plant.transition, plant.now, plant.output, none)
    old, _ = ss2tf(plant.transition, plant.before, plant.output, none)
    numerator = np.polyadd(np.polymul(now[0], [1.0, 0.0]), old[0])
    denominator = np.polymul(controller[1], np.polymul(poles, np.eye(1, plant.whole + 2)[0]))
    characteristic = np.polyadd(denominator, np.polymul(controller[0], numerator))
    if not np.isfinite(characteristic).all() or np.abs(np.roots(characteristic)).max(initial=0.0) >= UNIT_CIRCLE:
        return 0.0
    z = np.exp(2j * np.pi * np.geomspace(LOWEST, 0.5, FREQUENCIES))
    return float(np.abs(np.polyval(characteristic, z) / np.polyval(denominator, z)).min())


def linear_controller(model: Model, *, speed: float | None = None) -> Polynomials | None:
    """Numerator and denominator in z of u = -C(z) e, or None where the controller has no such form.

    PID: kp + ki Ts z/(z - 1) + kd (z - 1)/(Ts z). Cascade: kv (kp + (z - 1)/(Ts z)). Speed: kp (z - 1)/(Ts z), later by
    its delay. Both adaptive robust ones: (k_s1 + Gamma_d Ts/(z - 1)) (k_1 + (z - 1)/(Ts z)), Gamma_d that of the
    disturbance; what else adapts is held. Less viscous (z - 1)/(Ts z) where friction is compensated at the measured
    velocity, and less the slope of its Coulomb part at a speed (m/s) that is given; `arc` also computes the
    acceleration that it asks for from it: plus mass k_1 (z - 1)/(Ts z).
    """
    p = model.controller
    if p is None:
        return None
    ts = 1.0 / p.sample_rate
    of = p.to_dict()
    difference = np.array([1.0, -1.0]) / ts  # over z
    measured = 0.0
    if of.get("feedforward_velocity") == "measured":
        measured = -of["viscous"]
        if speed is not None and of["coulomb"] != 0.0:
            width = of["coulomb_width"]
            slope = _slope(lambda v: smooth_sign(v, width), speed, STEP * max(abs(speed), width))
            measured = -(of["viscous"] + of["coulomb"] * slope)
    if model.controller_type == "pid":
        proportional = np.polymul([of["kp"], 0.0], [1.0, -1.0])
        integral = of["ki"] * ts * np.array([1.0, 0.0, 0.0])
        derivative = (of["kd"] + measured) * np.polymul(difference, [1.0, -1.0])
        return np.polyadd(np.polyadd(proportional, integral), derivative), np.array([1.0, -1.0, 0.0])
    if model.controller_type == "cascade":
        return np.polyadd([of["kv"] * of["kp"], 0.0], (of["kv"] + measured) * difference), np.array([1.0, 0.0])
    if model.controller_type == "speed":
        whole, part = divmod(of["delay"] / ts, 1.0)
        later = np.zeros(int(whole) + 3)
        later[0] = 1.0
        return (of["kp"] + measured) * np.polymul(difference, [1.0 - part, part]), later
    if model.controller_type in ("arc", "dcarc"):
        switching = np.polyadd([of["error_gain"], 0.0], difference)
        feedback, adaptation = of["feedback_gain"], of["disturbance_adaptation"]
        gain = np.array([feedback, adaptation * ts - feedback])
        known = of["mass"] * of["error_gain"] - of["viscous"] if model.controller_type == "arc" else 0.0
        model_part = known * np.polymul(difference, [1.0, -1.0])
        return np.polyadd(np.polymul(switching, gain), model_part), np.array([1.0, -1.0, 0.0])
    return None
