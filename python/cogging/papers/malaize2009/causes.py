"""Conditions that Malaize and Levine 2009 do not report, each of which would explain the observers' accuracy.

As believed, the observers are 7 and 5 times better than printed. Each of CAUSES is one property of the machine that the
controllers do not know. Its size on a motor is the one at which the observer's accuracy is the printed one, with the
amplitude of the cogging calibrated again for the PID's (studies.malaize2009.causes_calibration writes conditions.toml).
A cause that explains both motors with one value says more than one that needs a value for each:
`accuracies.held_out` applies the value of each motor to the other.

Section V says that the ironcore's spectrum holds much more than three periods: lines that the observer lacks. Neither
these nor the phases of the cogging are reported, so both are drawn with fixed seeds, and an accuracy is the mean over
draws. The periods were read off a Fourier transform and used as whole millimetres: the true ones may differ.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from cogging import effects
from cogging._core import Plant
from cogging.arrays import FloatArray
from cogging.files import shipped_toml
from cogging.papers.malaize2009 import linear_motors
from cogging.papers.malaize2009.linear_motors import MOTORS, Calibrated, Motor, shipped

LINE_COUNT, LINE_PERIODS = 8, (4e-3, 60e-3)  # number of unmodelled lines, and range of their periods (m), assumed
DRAWS = 10
DRAWN_STROKES = 4  # of each draw; later the errors repeat
SEED = 2009
STEP_DRAWS = 5


@dataclass(frozen=True)
class Conditions:
    """What the controllers do not know of their machine: nothing by default."""

    lines: float = 0.0  # rms of the unmodelled lines over that of the modelled cogging
    period_error: float = 0.0  # relative excess of the periods that the observer believes
    thrust: float = 0.0  # relative excess of the motor's thrust
    delay: float = 0.0  # s, of the command beyond the believed one
    noise: float = 0.0  # m rms, of the encoder
    step: float | None = None  # m, of the encoder, varied by a tenth from draw to draw; None: the motor's
    width: float = 0.0  # m/s, S(v) = (2/pi) atan(v / width) in place of sgn(v); 0: sgn
    any_phases: bool = False  # the phases of the cogging are drawn, in place of those of linear_motors.plant


def unmodelled_lines(draw: int, rms: float) -> list[effects.CoggingHarmonic]:
    """Draw lines of one size with evenly distributed logarithms of periods, and phases; rms: of all, m/s^2."""
    random = np.random.default_rng([SEED, draw])
    shortest, longest = np.log(LINE_PERIODS)
    periods = np.exp(random.uniform(shortest, longest, LINE_COUNT))
    phases, size = random.uniform(0.0, 2.0 * np.pi, LINE_COUNT), rms * np.sqrt(2.0 / LINE_COUNT)
    return [
        effects.CoggingHarmonic(period=period, sine=size * np.cos(phase), cosine=size * np.sin(phase))
        for period, phase in zip(periods, phases, strict=True)
    ]


def machine(motor: Motor, amplitude: float, conditions: Conditions, draw: int = 0) -> Plant:
    """Return the machine of a draw under some conditions; amplitude: of the first period, m/s^2."""
    true = replace(motor, periods=tuple(period / (1.0 + conditions.period_error) for period in motor.periods))
    phases, lines = None, list[effects.CoggingHarmonic]()
    if conditions.any_phases:
        random = np.random.default_rng([SEED, list(MOTORS).index(motor.name), draw])
        phases = random.uniform(0.0, 2.0 * np.pi, len(motor.periods))
    if conditions.lines > 0.0:
        lines = unmodelled_lines(draw, conditions.lines * linear_motors.cogging_rms(motor, amplitude))
    if conditions.step is not None:  # the accuracy depends on where on the grid the strokes end
        step = conditions.step * (1.0 + np.random.default_rng([SEED, draw]).uniform(-0.1, 0.1))
        true = replace(true, resolution=step)
    late = linear_motors.DELAY + conditions.delay
    options: dict[str, Any] = {"phases": phases, "delay": late, "width": conditions.width, "noise": conditions.noise}
    return linear_motors.plant(true, amplitude, lines, **options)


def strokes_of(draws: int) -> int:
    """Return the number of strokes that are run in each of some draws; 0: all."""
    return DRAWN_STROKES if draws > 1 else 0


def drawn_accuracies(
    motor: Motor, gains: Calibrated, conditions: Conditions, controller: str, draws: int = DRAWS
) -> FloatArray:
    """Return the accuracy (m) of "PID" or "observer" in each draw, (draws,), with the cogging of gains.amplitude."""
    machines = [machine(motor, gains.amplitude, conditions, draw) for draw in range(draws)]
    law = linear_motors.controllers(motor, gains, 1.0 + conditions.thrust)[controller]
    return linear_motors.batch_errors(machines, [law] * draws, motor, strokes=strokes_of(draws))


def pair(motor: Motor, gains: Calibrated, conditions: Conditions, draws: int) -> dict[str, FloatArray]:
    """Return the accuracy (m) of PID and observer in each draw, (draws,) each."""
    return {name: drawn_accuracies(motor, gains, conditions, name, draws) for name in linear_motors.CONTROLLERS}


@dataclass(frozen=True)
class Cause:
    """One property that the controllers do not know."""

    name: str
    field: str  # of Conditions
    unit: str  # SI
    sizes: tuple[float, float]  # range in which its size is searched
    verdict: str  # on its plausibility; studies.malaize2009.causes_study has the reasons
    draws: int = 1  # over which an accuracy is the mean
    any_phases: bool = False  # the phases are drawn too: its size follows the amplitude, which depends on them

    def of(self, size: float) -> Conditions:
        """Return the conditions with this cause alone."""
        return replace(Conditions(any_phases=self.any_phases), **{self.field: size})  # type: ignore[arg-type]


CAUSES = (
    Cause("unmodelled lines", "lines", "1", (0.004, 0.1), "likely", DRAWS, any_phases=True),
    Cause("period error", "period_error", "1", (0.003, 0.05), "possible", DRAWS, any_phases=True),
    Cause("thrust error", "thrust", "1", (1e-4, 1e-2), "unlikely alone"),
    Cause("delay", "delay", "s", (1e-6, 1e-4), "unlikely alone"),
    Cause("encoder noise", "noise", "m", (1e-8, 1e-6), "unlikely"),
    Cause("encoder step", "step", "m", (3e-8, 3e-6), "unlikely", STEP_DRAWS),
    Cause("smooth friction", "width", "m/s", (1e-5, 1e-3), "possible"),
)


def conditions_file() -> dict[str, Any]:
    """Return the sizes and amplitudes that studies.malaize2009.causes_calibration wrote."""
    return shipped_toml("papers/malaize2009/conditions.toml")


#: The two that serve both motors with one size: Table I is shown under each.
LINES, FRICTION = CAUSES[0], CAUSES[-1]


def shipped_table_1(motor: Motor, cause: Cause = LINES) -> tuple[Calibrated, Conditions]:
    """Return the gains calibrated under the conditions of Table I, and these: a cause of one size on both motors."""
    part = conditions_file()["table_1"][cause.field]
    return replace(shipped(motor), amplitude=part[motor.name]), cause.of(part["size"])


@dataclass(frozen=True)
class Explanation:
    """A cause at the size that explains the observer's accuracy on one motor."""

    cause: Cause
    motor: Motor
    size: float  # SI
    amplitude: float  # m/s^2, of the cogging's first period on this motor
    accuracy: FloatArray  # m, the observer's on this motor, (draws,)
    elsewhere: FloatArray  # m, the observer's on the other motor with the same size, (draws,)

    @property
    def labels(self) -> dict[str, str]:
        """Motor and cause, as in the tables' rows."""
        return {"motor": self.motor.name, "cause": self.cause.name}


def other(motor: Motor) -> Motor:
    """Return the other one of the two motors."""
    (found,) = (each for each in MOTORS.values() if each.name != motor.name)
    return found


def explained() -> list[Explanation]:
    """Run the shipped sizes."""
    found = []
    for cause in CAUSES:
        for motor in MOTORS.values():
            part, accuracies = conditions_file()[cause.field][motor.name], []
            for each, amplitude in ((motor, part["amplitude"]), (other(motor), part["amplitude_elsewhere"])):
                gains, conditions = replace(shipped(each), amplitude=amplitude), cause.of(part["size"])
                accuracies.append(drawn_accuracies(each, gains, conditions, "observer", cause.draws))
            found.append(Explanation(cause, motor, part["size"], part["amplitude"], *accuracies))
    return found
