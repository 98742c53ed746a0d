"""The loop of a linear controller around the rigid axis, and how far it is from instability."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from cogging._core import effects, smooth_sign
from cogging.arrays import FloatArray
from cogging.design.linear_plant import held, linear_plant
from cogging.model.model import Model

FREQUENCIES = 2000  # at which the sensitivity is looked at, up to half the sample rate
LOWEST = 1e-4  # of them, over the sample rate
UNIT_CIRCLE = 1.0 + 1e-9

Polynomials = tuple[FloatArray, FloatArray]


def modulus_margin(model: Model) -> float | None:
    """min over the frequency of |1 + L|, L = C(z) P(z) the loop of the model's own controller; 0 where it is unstable.

    P is M x'' = u - B x' with the model's delays and current loop, its command held over a sample, exactly; friction
    but the viscous, cogging and flexibility are left out. C is the part of the controller that is linear in the error
    (see linear_controller).

    Returns:
        1, from 0 to 1, or None where the controller has no such part.
    """
    controller = linear_controller(model)
    if controller is None or model.controller is None:
        return None
    sample_time = 1.0 / model.controller.sample_rate
    numerator, denominator = controller
    plant_numerator, plant_denominator = _plant(model, sample_time)
    loop = np.polymul(numerator, plant_numerator)
    characteristic = np.polyadd(np.polymul(denominator, plant_denominator), loop)
    if not np.isfinite(characteristic).all() or np.abs(np.roots(characteristic)).max(initial=0.0) >= UNIT_CIRCLE:
        return 0.0
    z = np.exp(2j * np.pi * np.geomspace(LOWEST, 0.5, FREQUENCIES))
    open_loop = np.polyval(np.polymul(denominator, plant_denominator), z)
    return float(np.abs(np.polyval(characteristic, z) / open_loop).min())


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
    measured = -_compensated(of, speed) if of.get("feedforward_velocity") == "measured" else 0.0
    if model.controller_type == "pid":
        proportional = np.polymul([of["kp"], 0.0], [1.0, -1.0])
        integral = of["ki"] * ts * np.array([1.0, 0.0, 0.0])
        derivative = (of["kd"] + measured) * np.polymul(difference, [1.0, -1.0])
        return np.polyadd(np.polyadd(proportional, integral), derivative), np.array([1.0, -1.0, 0.0])
    if model.controller_type == "cascade":
        damping = (of["kv"] + measured) * difference
        return np.polyadd([of["kv"] * of["kp"], 0.0], damping), np.array([1.0, 0.0])
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


def _compensated(of: Mapping[str, float], speed: float | None) -> float:
    """Slope of the friction that a controller makes up for, V/(m/s)."""
    if speed is None or of["coulomb"] == 0.0:
        return of["viscous"]
    step = 1e-6 * max(abs(speed), of["coulomb_width"])
    above, below = (float(smooth_sign(speed + way * step, of["coulomb_width"])) for way in (1.0, -1.0))
    return of["viscous"] + of["coulomb"] * (above - below) / (2.0 * step)


def _plant(model: Model, sample_time: float) -> Polynomials:
    """Numerator and denominator in z of the reading over the command: the rigid axis, its delays and current loops."""
    from scipy.signal import ss2tf

    kept = [one for one in model.effects if isinstance(one, effects.CommandDelay | effects.ActuatorLag)]
    plant = held(linear_plant(model.replace(effects=kept)), sample_time)
    none = np.zeros((1, 1))
    now, denominator = ss2tf(plant.transition, plant.now, plant.output, none)
    old, _ = ss2tf(plant.transition, plant.before, plant.output, none)
    numerator = np.polyadd(np.polymul(now[0], [1.0, 0.0]), old[0])
    return numerator, np.polymul(denominator, np.eye(1, plant.whole + 2)[0])
