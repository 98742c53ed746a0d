"""Conditions that Malaize and Levine 2009 do not report: machines that are not quite what their controllers believe.

Of the ironcore's spectrum section V says that it holds much more than three periods: lines that the observer lacks.
Neither these nor the phases of the cogging are reported, so both are drawn with fixed seeds, and an accuracy is the
mean over draws. The periods were read off a Fourier transform, and used as whole millimetres: the true ones may be
others.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from cogging import effects
from cogging._core import CoggingModel, EncoderParameters, Plant, SplineHarmonics
from cogging.arrays import FloatArray
from cogging.model.controller import ListedController
from cogging.papers.fitting import round_to_digits
from cogging.papers.malaize2009.imperfections import cogging_rms
from cogging.papers.malaize2009.setup import DELAY, MOTORS, Calibrated, Motor, observer, pid, plant, reference
from cogging.simulation.batch import closed_loop_batch

LINES, LINE_PERIODS = 8, (4e-3, 60e-3)  # how many unmodelled lines, and between which periods (m), assumed
DRAWS = 10
DRAWN_STROKES = 4  # of every draw; behind them the errors repeat
SEED = 2009
CLOSE, NEAR = 0.003, 0.03  # of the printed accuracy: how near the PID's is brought to it, and may stay where it jumps


@dataclass(frozen=True)
class Conditions:
    """What the controllers do not know of their machine. By default there is nothing.

    Attributes:
        lines: rms of the unmodelled lines over that of the modelled cogging.
        period_error: by which all periods that the observer believes are longer than the true ones, relative.
        thrust: by which the motor pushes more than believed, relative.
        delay: s, by which the command acts later than believed.
        noise: m, rms, of the encoder.
        step: m, of the encoder, up to a tenth more or less by the draw, since it counts where on its grid the strokes
            end; the motor's own when None.
        width: m/s, S(v) = (2/pi) atan(v / width) in the place of sgn(v); 0: sgn.
        any_phases: the phases of the cogging are drawn, in the place of those that setup.plant assumes.
    """

    lines: float = 0.0
    period_error: float = 0.0
    thrust: float = 0.0
    delay: float = 0.0
    noise: float = 0.0
    step: float | None = None
    width: float = 0.0
    any_phases: bool = False


def unmodelled_lines(draw: int, rms: float) -> list[effects.CoggingHarmonic]:
    """Lines of one size at periods drawn evenly over their logarithm, phases drawn too; rms: of all, m/s^2."""
    random = np.random.default_rng([SEED, draw])
    shortest, longest = np.log(LINE_PERIODS)
    periods = np.exp(random.uniform(shortest, longest, LINES))
    phases, size = random.uniform(0.0, 2.0 * np.pi, LINES), rms * np.sqrt(2.0 / LINES)
    return [
        effects.CoggingHarmonic(period=period, sine=size * np.cos(phase), cosine=size * np.sin(phase))
        for period, phase in zip(periods, phases, strict=True)
    ]


def drawn_phases(motor: Motor, draw: int) -> FloatArray:
    """Phases (rad) of the cogging's periods, evenly over the turn, (periods,)."""
    random = np.random.default_rng([SEED, list(MOTORS).index(motor.name), draw])
    return random.uniform(0.0, 2.0 * np.pi, len(motor.periods))


def machine(motor: Motor, amplitude: float, conditions: Conditions, draw: int = 0) -> Plant:
    """The machine under some conditions, of a draw; amplitude: of the first period, m/s^2."""
    true = [period / (1.0 + conditions.period_error) for period in motor.periods]
    believed = plant(replace(motor, periods=tuple(true)), amplitude)
    cogging = believed.cogging
    if conditions.any_phases:
        phases, sizes = drawn_phases(motor, draw), -amplitude * np.array(motor.shape)
        sine, cosine = sizes * np.cos(phases), sizes * np.sin(phases)
        cogging = CoggingModel(SplineHarmonics(periods=true), sine[:, None], cosine[:, None])
    listed: list[Any] = [effects.CommandDelay(delay=DELAY + conditions.delay)]
    if conditions.lines > 0.0:
        listed += unmodelled_lines(draw, conditions.lines * cogging_rms(motor, amplitude))
    step = motor.resolution
    if conditions.step is not None:
        step = conditions.step * (1.0 + np.random.default_rng([SEED, draw]).uniform(-0.1, 0.1))
    return Plant(
        believed.axis.replace(coulomb_width=conditions.width),
        cogging=cogging,
        effects=listed,
        encoder=EncoderParameters(resolution=step, noise=conditions.noise),
    )


def controllers_under(motor: Motor, gains: Calibrated, conditions: Conditions) -> dict[str, ListedController]:
    """PID and observer of Table I, which know nothing of the conditions."""
    thrust = 1.0 + conditions.thrust
    return {"PID": pid(thrust), "observer": observer(motor, gains, thrust=thrust)}


def batch_accuracies(
    machines: Sequence[Plant], controller: ListedController, motor: Motor, strokes: int = 0
) -> FloatArray:
    """setup.accuracy (m) of each machine under one controller, (n,); infinite where the run diverged.

    Args:
        machines: of machine().
        controller: copied for each.
        motor: whose strokes are run.
        strokes: how many, from the start; 0: all.
    """
    period = reference(motor).period
    found = closed_loop_batch(
        machines,
        [controller] * len(machines),
        reference(motor),
        duration=0.5 * strokes * period,
        seeds=range(len(machines)),
        start=0.5 * period,
        reductions=["true_error_max"],
    )
    return np.nan_to_num(found.indexes["true_error_max"], nan=np.inf)


def strokes_of(draws: int) -> int:
    """How many strokes are run in each of so many draws; 0: all."""
    return DRAWN_STROKES if draws > 1 else 0


def drawn_accuracies(
    motor: Motor, gains: Calibrated, conditions: Conditions, controller: str, draws: int = DRAWS
) -> FloatArray:
    """Accuracy (m) of "PID" or "observer" in each draw, (draws,); gains.amplitude is that of the cogging."""
    machines = [machine(motor, gains.amplitude, conditions, draw) for draw in range(draws)]
    return batch_accuracies(machines, controllers_under(motor, gains, conditions)[controller], motor, strokes_of(draws))


def recalibrated(motor: Motor, gains: Calibrated, conditions: Conditions, draws: int = 1) -> Calibrated:
    """The gains with the amplitude (4 digits) by which the PID's mean accuracy is that of Table I.

    Raises:
        ValueError: there is none, as where the PID errs by more than printed without any cogging.
    """
    amplitude, printed = gains.amplitude, motor.accuracy[0]
    controller = controllers_under(motor, gains, conditions)["PID"]
    tried: dict[float, float] = {}
    for _ in range(8):
        machines = [machine(motor, amplitude, conditions, draw) for draw in range(draws)]
        ratio = float(batch_accuracies(machines, controller, motor, strokes_of(draws)).mean()) / printed
        tried[amplitude] = abs(ratio - 1.0)
        if tried[amplitude] < CLOSE:
            break
        amplitude = round_to_digits(amplitude / ratio)
        if amplitude in tried:
            amplitude = round_to_digits(amplitude / np.sqrt(ratio))
    best = min(tried, key=lambda each: tried[each])
    if tried[best] > NEAR:
        raise ValueError(f"{motor.name}: no amplitude gives the PID the printed accuracy under {conditions}")
    return replace(gains, amplitude=best)
