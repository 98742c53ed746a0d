"""The linearised axis and its loop as python-control objects, with stability margins."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np
import numpy.typing as npt

from cogging.arrays import FloatArray
from cogging.design import linear_plant
from cogging.export.forms import require_positive
from cogging.model.model import Model
from cogging.shown import quoted
from cogging.tables import library
from cogging.values import ByValue

ComplexArray = npt.NDArray[np.complex128]
MOST_DELAY = 1000  # samples; each is a state
POINTS = 4000  # frequencies of the response
AROUND = 60  # further ones around each resonance
REFINED = 60  # bisections of a crossing
#: Why a controller has no transfer function from the error to the command.
NOT_LINEAR = {
    "output_feedback_arc": "its filters and gains follow its estimates and the reference",
    "observer_based": "its observer turns with the motion and is fed with the commands that acted",
}


@dataclass(frozen=True, eq=False, repr=False)
class LoopMargins(ByValue):
    """Stability margins of a loop; all 0 for an unstable one.

    Attributes:
        stable: whether the closed loop is stable.
        gain: smallest destabilising factor above 1 on the command; infinite if there is none.
        gain_down: largest destabilising factor below 1; 0 if there is none.
        phase: degrees, smallest destabilising phase lag over all crossings of |L| = 1.
        delay: s, smallest destabilising delay over all crossings.
        modulus: smallest distance of L from -1, 1 over the largest sensitivity.
        crossover: Hz, highest frequency with |L| = 1; 0 if there is none.
    """

    stable: bool
    gain: float = 0.0
    gain_down: float = 0.0
    phase: float = 0.0
    delay: float = 0.0
    modulus: float = 0.0
    crossover: float = 0.0

    def _brief(self) -> str:
        return self.text().replace("\n", "; ")

    def text(self) -> str:
        """Return the margins in one line."""
        if not self.stable:
            return "unstable"
        return (
            f"gain margin {self.gain:.4g} (down to {self.gain_down:.3g}), phase margin {self.phase:.4g} degrees, "
            f"delay margin {self.delay:.4g} s, modulus margin {self.modulus:.4g}, crossover {self.crossover:.5g} Hz"
        )


@dataclass(frozen=True, eq=False, repr=False)
class ControlLoop(ByValue):
    """The linear loop u = C (reference - reading), reading = P u, as python-control objects.

    Those with a sample time are exact at the samples for a held command and any delay. Signals are deviations from the
    given position and speed, without feedforward.

    Attributes:
        plant: P(z), reading over command, m/V, StateSpace.
        continuous: P(s), the same in continuous time, with the delay as a Pade approximation, StateSpace.
        controller: C(z), command over error, V/m, TransferFunction; None for a model without a controller. Likewise
            loop: L = C P; sensitivity: 1/(1 + L), reading over a disturbance of the reading; complementary:
            L/(1 + L), reading over reference without feedforward.
        left_out: nonlinear parts of the model that were left out.
        sampled: the plant's matrices, without delay.
        polynomials: of C(z), numerator and denominator.
    """

    plant: Any
    continuous: Any
    controller: Any
    loop: Any
    sensitivity: Any
    complementary: Any
    left_out: tuple[str, ...]
    sampled: linear_plant.HeldPlant
    polynomials: linear_plant.Polynomials | None

    def _brief(self) -> str:
        kind = "with a controller" if self.controller is not None else "no controller"
        return f"{1.0 / self.plant.dt:g} Hz, {self.plant.nstates} states of the plant, {kind}"

    def margins(self) -> LoopMargins:
        """Return gain, phase, delay and modulus margins.

        Raises:
            ValueError: there is no controller.
        """
        if self.loop is None:
            raise ValueError("controller: must be given for margins, got a model without [controller]")
        stable = bool(np.abs(self.sensitivity.poles()).max(initial=0.0) < linear_plant.UNIT_CIRCLE)
        poles = np.linalg.eigvals(self.sampled.transition).astype(complex)
        return _margins_of(self.response, 1.0 / self.plant.dt, poles) if stable else LoopMargins(False)

    def response(self, frequency: FloatArray) -> ComplexArray:
        """Return L(e^(i 2 pi f Ts)), or P for a model without a controller.

        Args:
            frequency: Hz, (n,).
        """
        z = np.exp(2j * np.pi * np.asarray(frequency) * self.plant.dt)
        one = np.eye(self.sampled.transition.shape[0])
        into = self.sampled.now[None] + self.sampled.before[None] / z[:, None, None]
        state = np.linalg.solve(z[:, None, None] * one - self.sampled.transition, into)
        plant = (self.sampled.output @ state)[:, 0, 0] * z**-self.sampled.whole
        if self.polynomials is None:
            return np.asarray(plant)
        return np.asarray(plant * np.polyval(self.polynomials[0], z) / np.polyval(self.polynomials[1], z))


def to_control(
    model: Model,
    *,
    speed: float | None = None,
    position: float | None = None,
    sample_rate: float | None = None,
    pade: int = 3,
) -> ControlLoop:
    """Return the linearised model and controller (see Model.to_control)."""
    control = library("control")
    own_rate = None if model.controller is None else float(model.controller.sample_rate)
    sample_rate = own_rate if sample_rate is None else sample_rate
    if sample_rate is None:
        raise ValueError("sample_rate: must be given for a model without [controller], got nothing")
    require_positive("sample_rate", sample_rate)
    if not 0 <= pade <= 20:
        raise ValueError(f"pade: must be from 0 to 20, got {quoted(pade)}")
    for name, value in (("speed", speed), ("position", position)):
        if value is not None and not math.isfinite(value):
            raise ValueError(f"{name}: must be finite, got {quoted(value)}")
    linear = linear_plant.linear_plant(model, speed=speed, position=position)
    time = 1.0 / sample_rate
    sampled = linear_plant.held(linear, time)
    if sampled.whole > MOST_DELAY:
        raise ValueError(f"command_delay: must be at most {MOST_DELAY} samples, got {linear.delay / time:g}")
    plant = control.ss(*_with_delay(sampled), time)
    continuous = control.ss(linear.a, linear.b, linear.c, 0.0)
    if linear.delay > 0.0 and pade > 0:
        continuous = continuous * control.tf2ss(*control.pade(linear.delay, pade))
    if own_rate is None:
        return ControlLoop(plant, continuous, None, None, None, None, linear.left_out, sampled, None)
    found = linear_plant.linear_controller(model, speed=speed)
    if found is None:
        kind = str(model.controller_type)
        why = NOT_LINEAR.get(kind, "it is not linear in the error")
        raise ValueError(f"controller: must be linear in the error, got {kind}: {why}")
    if sample_rate != own_rate:
        raise ValueError(f"sample_rate: must be that of the controller, {own_rate:g}, got {quoted(sample_rate)}")
    controller = control.tf(*found, time)
    loop, one = plant * control.tf2ss(controller), control.ss([], [], [], [[1.0]], time)
    sensitivity, complementary = control.feedback(one, loop), control.feedback(loop, one)
    return ControlLoop(plant, continuous, controller, loop, sensitivity, complementary, linear.left_out, sampled, found)


def _with_delay(plant: linear_plant.HeldPlant) -> tuple[FloatArray, FloatArray, FloatArray, FloatArray]:
    """Return the plant with delayed commands as states, newest first: a, b, c, d."""
    size = plant.transition.shape[0]
    waiting = plant.whole + bool(np.any(plant.before))
    a = np.zeros((size + waiting, size + waiting))
    b, c = np.zeros((size + waiting, 1)), np.zeros((1, size + waiting))
    a[:size, :size], c[:, :size] = plant.transition, plant.output
    for ago, acts in ((plant.whole, plant.now), (plant.whole + 1, plant.before)):
        if ago == 0:
            b[:size] = acts
        elif ago <= waiting:
            a[:size, size + ago - 1 : size + ago] = acts
    if waiting:
        b[size] = 1.0
        a[range(size + 1, size + waiting), range(size, size + waiting - 1)] = 1.0
    return a, b, c, np.zeros((1, 1))


def _margins_of(response: Callable[[FloatArray], Any], sample_rate: float, poles: ComplexArray) -> LoopMargins:
    """Return the margins of a stable loop with a response L (Hz), finer around its lightly damped poles in z."""
    parts = [np.geomspace(linear_plant.LOWEST, 0.5, POINTS)]
    for pole in poles[(poles.imag > 0.0) & (np.abs(poles) > 0.0)]:
        place, width = np.angle(pole) / (2.0 * np.pi), max(-math.log(abs(pole)) / (2.0 * np.pi), 1e-9)
        near = width * np.geomspace(1e-2, 1e2, AROUND)
        parts.append(np.concatenate([[place], place + near, place - near]))
    found = np.unique(np.concatenate(parts))
    frequency = sample_rate * found[(found >= linear_plant.LOWEST) & (found <= 0.5)]
    loop = np.asarray(response(frequency))
    unity = _crossings(lambda f: np.log(np.abs(response(f))), frequency, np.log(np.abs(loop)))
    lag = np.angle(-np.asarray(response(unity))) % (2.0 * np.pi) if unity.size else np.empty(0)
    lead = np.minimum(lag, 2.0 * np.pi - lag)
    real = _crossings(lambda f: np.imag(response(f)), frequency, loop.imag)
    factors = -1.0 / np.real(np.asarray(response(real))) if real.size else np.empty(0)
    nyquist = float(np.real(response(np.array([0.5 * sample_rate]))[0]))
    factors = np.append(factors, -1.0 / nyquist if nyquist != 0.0 else -1.0)
    return LoopMargins(
        stable=True,
        gain=float(factors[factors > 1.0].min(initial=math.inf)),
        gain_down=float(factors[(factors > 0.0) & (factors < 1.0)].max(initial=0.0)),
        phase=float(np.degrees(lead.min(initial=np.pi))),
        delay=float((lag / (2.0 * np.pi * unity)).min(initial=math.inf)) if unity.size else math.inf,
        modulus=float(np.abs(1.0 + loop).min()),
        crossover=float(unity.max(initial=0.0)),
    )


def _crossings(value: Callable[[FloatArray], Any], frequency: FloatArray, at: FloatArray) -> FloatArray:
    """Return the frequencies at which a value changes sign, by bisection."""
    places = np.flatnonzero(np.sign(at[1:]) * np.sign(at[:-1]) < 0.0)
    low, high, sign = frequency[places], frequency[places + 1], np.sign(at[places])
    for _ in range(REFINED if places.size else 0):
        middle = np.sqrt(low * high)
        same = np.sign(np.asarray(value(middle))) == sign
        low, high = np.where(same, middle, low), np.where(same, high, middle)
    return np.asarray(np.sqrt(low * high), dtype=np.float64)
