"""The loop of a linear controller around the rigid axis, and how far it is from instability."""

from __future__ import annotations

import numpy as np

from cogging._core import effects
from cogging.arrays import FloatArray
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


def linear_controller(model: Model) -> Polynomials | None:
    """Numerator and denominator in z of u = -C(z) e, or None where the controller has no such form.

    PID: kp + ki Ts z/(z - 1) + kd (z - 1)/(Ts z). Cascade: kv (kp + (z - 1)/(Ts z)). Speed: kp (z - 1)/(Ts z), later by
    its delay. Both adaptive robust ones: (k_s1 + Gamma_d Ts/(z - 1)) (k_1 + (z - 1)/(Ts z)), Gamma_d that of the
    disturbance; what else adapts is held. Less viscous (z - 1)/(Ts z) where viscous friction is compensated at the
    measured velocity; `arc` also computes the acceleration that it asks for from it: plus mass k_1 (z - 1)/(Ts z).
    """
    p = model.controller
    if p is None:
        return None
    ts = 1.0 / p.sample_rate
    of = p.to_dict()
    difference = np.array([1.0, -1.0]) / ts  # over z
    measured = -of["viscous"] if of.get("feedforward_velocity") == "measured" else 0.0
    if model.controller_type == "pid":
        proportional = np.polymul([of["kp"], 0.0], [1.0, -1.0])
        integral = of["ki"] * ts * np.array([1.0, 0.0, 0.0])
        derivative = (of["kd"] + measured) * np.polymul(difference, [1.0, -1.0])
        return np.polyadd(np.polyadd(proportional, integral), derivative), np.array([1.0, -1.0, 0.0])
    if model.controller_type == "cascade":
        damping = (of["kv"] + measured) * difference
        return np.polyadd([of["kv"] * of["kp"], 0.0], damping), np.array([1.0, 0.0])
    if model.controller_type == "speed":
        later = np.zeros(round(of["delay"] / ts) + 2)
        later[0] = 1.0
        return (of["kp"] + measured) * difference, later
    if model.controller_type in ("arc", "dcarc"):
        switching = np.polyadd([of["error_gain"], 0.0], difference)
        feedback, adaptation = of["feedback_gain"], of["disturbance_adaptation"]
        gain = np.array([feedback, adaptation * ts - feedback])
        known = of["mass"] * of["error_gain"] - of["viscous"] if model.controller_type == "arc" else 0.0
        model_part = known * np.polymul(difference, [1.0, -1.0])
        return np.polyadd(np.polymul(switching, gain), model_part), np.array([1.0, -1.0, 0.0])
    return None


def _plant(model: Model, sample_time: float) -> Polynomials:
    """Numerator and denominator in z of the reading over the command."""
    from scipy.linalg import expm
    from scipy.signal import ss2tf

    delay = sum(one.delay for one in model.effects if isinstance(one, effects.CommandDelay))
    lags = [one.time_constant for one in model.effects if isinstance(one, effects.ActuatorLag)]
    lags = [lag for lag in lags if lag > 0.0]
    order = 2 + len(lags)
    a, b = np.zeros((order, order)), np.zeros((order, 1))
    a[0, 1], a[1, 1] = 1.0, -model.axis.viscous / model.axis.mass
    drives = 1
    for place, lag in enumerate(lags, start=2):  # each the input of the one before
        a[drives, place] = 1.0 / model.axis.mass if drives == 1 else 1.0 / lags[place - 3]
        a[place, place] = -1.0 / lag
        drives = place
    b[drives, 0] = 1.0 / lags[-1] if lags else 1.0 / model.axis.mass
    whole, part = divmod(delay / sample_time, 1.0)
    late, early = _held(a, b, (1.0 - part) * sample_time), _held(a, b, part * sample_time)
    # The command of the sample before acts for the first part of a sample, that of the sample for the rest.
    transition = expm(a * sample_time)
    before = expm(a * (1.0 - part) * sample_time) @ early
    output, none = np.eye(1, order), np.zeros((1, 1))
    now, denominator = ss2tf(transition, late, output, none)
    old, _ = ss2tf(transition, before, output, none)
    numerator = np.polyadd(np.polymul(now[0], [1.0, 0.0]), old[0])
    return numerator, np.polymul(denominator, np.eye(1, int(whole) + 2)[0])


def _held(a: FloatArray, b: FloatArray, time: float) -> FloatArray:
    """What a command of 1 that is held for a time leaves in the state."""
    from scipy.linalg import expm

    size = a.shape[0]
    both = np.zeros((size + 1, size + 1))
    both[:size, :size], both[:size, size:] = a, b
    held: FloatArray = expm(both * time)[:size, size:]
    return held
