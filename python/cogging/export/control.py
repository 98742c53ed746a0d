"""The linearised axis and its loop as python-control objects: poles, frequency response, margins."""

from __future__ import annotations

import importlib
import math
from dataclasses import dataclass
from typing import Any

import numpy as np
import numpy.typing as npt

from cogging.arrays import FloatArray
from cogging.design.linear_plant import HeldPlant, held, linear_plant
from cogging.design.tuning.linear_loop import LOWEST, UNIT_CIRCLE, Polynomials, linear_controller
from cogging.export.margins import LoopMargins, margins_of
from cogging.model.model import Model
from cogging.shown import quoted
from cogging.values import ByValue

ComplexArray = npt.NDArray[np.complex128]
MOST_DELAY = 1000  # samples: each is a state
#: Why a controller has no transfer function from the error to the command.
NOT_LINEAR = {
    "output_feedback_arc": "its filters and gains follow its estimates and the reference",
    "observer_based": "its observer turns with the motion and is fed with the commands that acted",
}


@dataclass(frozen=True, eq=False, repr=False)
class ControlLoop(ByValue):
    """The linear loop u = C (reference - reading), reading = P u, as python-control objects.

    Those with a sample time are exact for a command that is held over each sample and a delay of any length; they
    hold at the samples. Deviations from the place and the speed that were given: feedforward has no part in them.

    Attributes:
        plant: P(z), reading over command, m/V, StateSpace.
        continuous: P(s), the same in continuous time, with the delay as a Pade approximation, StateSpace.
        controller: C(z), command over error, V/m, TransferFunction; None of a model without a controller. Likewise
            loop: L = C P; sensitivity: 1/(1 + L), what is left of a disturbance of the reading, with the other sign of
            the error; complementary: L/(1 + L), reading over reference without feedforward.
        left_out: what of the model is not linear and has no part in it.
        sampled: the plant's matrices, its delay apart.
        polynomials: of C(z), numerator and denominator.
    """

    plant: Any
    continuous: Any
    controller: Any
    loop: Any
    sensitivity: Any
    complementary: Any
    left_out: tuple[str, ...]
    sampled: HeldPlant
    polynomials: Polynomials | None

    def _brief(self) -> str:
        kind = "with a controller" if self.controller is not None else "no controller"
        return f"{1.0 / self.plant.dt:g} Hz, {self.plant.nstates} states of the plant, {kind}"

    def margins(self) -> LoopMargins:
        """How far the loop is from instability: gain, phase, delay and modulus margins.

        Raises:
            ValueError: there is no controller.
        """
        if self.loop is None:
            raise ValueError("controller: must be given for margins, got a model without [controller]")
        stable = bool(np.abs(self.sensitivity.poles()).max(initial=0.0) < UNIT_CIRCLE)
        poles = np.linalg.eigvals(self.sampled.transition)
        return margins_of(self.response, 1.0 / self.plant.dt, LOWEST, poles, stable=stable)

    def response(self, frequency: FloatArray) -> ComplexArray:
        """L(e^(i 2 pi f Ts)), or P of a model without a controller.

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
    """Linearise a model and its controller (see Model.to_control)."""
    control = _library()
    if sample_rate is None:
        if model.controller is None:
            raise ValueError("sample_rate: must be given for a model without [controller], got nothing")
        sample_rate = float(model.controller.sample_rate)
    if not (math.isfinite(sample_rate) and sample_rate > 0.0):
        raise ValueError(f"sample_rate: must be finite and above 0, got {quoted(sample_rate)}")
    if not 0 <= pade <= 20:
        raise ValueError(f"pade: must be from 0 to 20, got {quoted(pade)}")
    for name, value in (("speed", speed), ("position", position)):
        if value is not None and not math.isfinite(value):
            raise ValueError(f"{name}: must be finite, got {quoted(value)}")
    linear = linear_plant(model, speed=speed, position=position)
    time = 1.0 / sample_rate
    sampled = held(linear, time)
    if sampled.whole > MOST_DELAY:
        raise ValueError(f"command_delay: must be at most {MOST_DELAY} samples, got {linear.delay / time:g}")
    plant = control.ss(*_with_delay(sampled), time)
    continuous = control.ss(linear.a, linear.b, linear.c, 0.0)
    if linear.delay > 0.0 and pade > 0:
        continuous = continuous * control.tf2ss(*control.pade(linear.delay, pade))
    found = _polynomials(model, speed, sample_rate)
    if found is None:
        return ControlLoop(plant, continuous, None, None, None, None, linear.left_out, sampled, None)
    controller = control.tf(*found, time)
    loop, one = plant * control.tf2ss(controller), control.ss([], [], [], [[1.0]], time)
    sensitivity, complementary = control.feedback(one, loop), control.feedback(loop, one)
    return ControlLoop(plant, continuous, controller, loop, sensitivity, complementary, linear.left_out, sampled, found)


def _polynomials(model: Model, speed: float | None, sample_rate: float) -> Polynomials | None:
    """Numerator and denominator of C(z), or None of a model without a controller."""
    if model.controller is None:
        return None
    found = linear_controller(model, speed=speed)
    if found is None:
        kind = str(model.controller_type)
        why = NOT_LINEAR.get(kind, "it is not linear in the error")
        raise ValueError(f"controller: must be linear in the error, got {kind}: {why}")
    if sample_rate != model.controller.sample_rate:
        own = f"{model.controller.sample_rate:g}"
        raise ValueError(f"sample_rate: must be that of the controller, {own}, got {quoted(sample_rate)}")
    return found


def _with_delay(plant: HeldPlant) -> tuple[FloatArray, FloatArray, FloatArray, FloatArray]:
    """The plant with the commands that are still to act as states, newest first: a, b, c, d."""
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


def _library() -> Any:
    """python-control."""
    try:
        return importlib.import_module("control")
    except ImportError as error:
        need = "python-control is needed for this and is not there: pip install 'cogging[control]'"
        raise ImportError(need) from error
