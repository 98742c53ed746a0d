"""Conditions that Malaize and Levine 2009 do not report, each of which would explain the observers' accuracy.

As believed, the observers are 7 and 5 times better than printed. Each of CAUSES is one thing that the controllers do
not know of their machine. Its size on a motor is the one at which the observer's accuracy is the printed one, with the
amplitude of the cogging calibrated anew so that the PID keeps its own (studies.malaize2009.causes_calibration, which
writes conditions.toml). A cause that explains both motors by one value says more than one that needs a value for each:
`accuracies.held_out` gives the value of each motor to the other.

Section V says that the ironcore's spectrum holds much more than three periods: lines that the observer lacks. Neither
these nor the phases of the cogging are reported, so both are drawn with fixed seeds, and an accuracy is the mean over
draws. The periods were read off a Fourier transform, and used as whole millimetres: the true ones may differ.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from cogging import effects
from cogging._core import CoggingModel, EncoderParameters, Plant, SplineHarmonics
from cogging.arrays import FloatArray
from cogging.papers.calibrated import shipped_toml
from cogging.papers.malaize2009.linear_motors import (
    DELAY,
    MOTORS,
    Calibrated,
    Motor,
    batch_errors,
    cogging_rms,
    controllers,
    plant,
    shipped,
)

LINE_COUNT, LINE_PERIODS = 8, (4e-3, 60e-3)  # how many unmodelled lines, and between which periods (m), assumed
DRAWS = 10
DRAWN_STROKES = 4  # of every draw; behind them the errors repeat
SEED = 2009
STEP_DRAWS = 5


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
        any_phases: the phases of the cogging are drawn, in the place of those that linear_motors.plant assumes.
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
    periods = np.exp(random.uniform(shortest, longest, LINE_COUNT))
    phases, size = random.uniform(0.0, 2.0 * np.pi, LINE_COUNT), rms * np.sqrt(2.0 / LINE_COUNT)
    return [
        effects.CoggingHarmonic(period=period, sine=size * np.cos(phase), cosine=size * np.sin(phase))
        for period, phase in zip(periods, phases, strict=True)
    ]


def machine(motor: Motor, amplitude: float, conditions: Conditions, draw: int = 0) -> Plant:
    """The machine under some conditions, of a draw; amplitude: of the first period, m/s^2."""
    true = [period / (1.0 + conditions.period_error) for period in motor.periods]
    believed = plant(replace(motor, periods=tuple(true)), amplitude)
    cogging = believed.cogging
    if conditions.any_phases:
        random = np.random.default_rng([SEED, list(MOTORS).index(motor.name), draw])
        phases = random.uniform(0.0, 2.0 * np.pi, len(motor.periods))
        sizes = -amplitude * np.array(motor.shape)
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


def strokes_of(draws: int) -> int:
    """How many strokes are run in each of so many draws; 0: all."""
    return DRAWN_STROKES if draws > 1 else 0


def drawn_accuracies(
    motor: Motor, gains: Calibrated, conditions: Conditions, controller: str, draws: int = DRAWS
) -> FloatArray:
    """Accuracy (m) of "PID" or "observer" in each draw, (draws,); gains.amplitude is that of the cogging."""
    machines = [machine(motor, gains.amplitude, conditions, draw) for draw in range(draws)]
    law = controllers(motor, gains, 1.0 + conditions.thrust)[controller]
    return batch_errors(machines, [law] * draws, motor, strokes=strokes_of(draws))


@dataclass(frozen=True)
class Cause:
    """One thing that the controllers do not know.

    Attributes:
        name: as the tables call it.
        field: of Conditions.
        unit: SI.
        sizes: between which it is looked for.
        verdict: on its plausibility, and `reason`.
        draws: over which an accuracy is the mean.
        any_phases: the phases are drawn too: its size goes with the amplitude, and that with the phases.
    """

    name: str
    field: str
    unit: str
    sizes: tuple[float, float]
    verdict: str
    reason: str
    draws: int = 1
    any_phases: bool = False

    def of(self, size: float) -> Conditions:
        """The conditions with this alone."""
        return replace(Conditions(any_phases=self.any_phases), **{self.field: size})  # type: ignore[arg-type]


CAUSES = (
    Cause(
        "unmodelled lines",
        "lines",
        "1",
        (0.004, 0.1),
        "likely",
        "section V calls the ironcore's spectrum much more chaotic; one share nearly serves both motors",
        DRAWS,
        any_phases=True,
    ),
    Cause(
        "period error",
        "period_error",
        "1",
        (0.003, 0.05),
        "possible",
        "whole millimetres, from a transform over a stroke; but 7 and 24 % of the PID's lines would be left, where "
        "section V sees none",
        DRAWS,
        any_phases=True,
    ),
    Cause(
        "thrust error",
        "thrust",
        "1",
        (1e-4, 1e-2),
        "unlikely alone",
        "nine times less on the ironless, 0.04 %, and no motor's constant is known that well",
    ),
    Cause(
        "delay",
        "delay",
        "s",
        (1e-6, 1e-4),
        "unlikely alone",
        "seven times less on the ironless, 4 us, where like drives would have like delays",
    ),
    Cause(
        "encoder noise",
        "noise",
        "m",
        (1e-8, 1e-6),
        "unlikely",
        "three and four counts of the assumed encoders, most of it at rest too, where Table I has the same accuracy",
    ),
    Cause(
        "encoder step",
        "step",
        "m",
        (3e-8, 3e-6),
        "unlikely",
        "two and four times the printed accuracy, which such an encoder cannot show",
        STEP_DRAWS,
    ),
    Cause(
        "smooth friction",
        "width",
        "m/s",
        (1e-5, 1e-3),
        "possible",
        "one value serves both motors, but under assumed levels of friction, with errors where the motion turns alone, "
        "and section II calls friction a lesser limitation",
    ),
)


def conditions_file() -> dict[str, Any]:
    """What studies.malaize2009.causes_calibration wrote: sizes and amplitudes."""
    return shipped_toml("cogging.papers.malaize2009", "conditions.toml")


#: The two that serve both motors with one size: Table I is shown under each.
LINES, FRICTION = CAUSES[0], CAUSES[-1]


def shipped_table_1(motor: Motor, cause: Cause = LINES) -> tuple[Conditions, Calibrated]:
    """The conditions of Table I, a cause of one size on both motors, and the gains with the amplitude under them."""
    part = conditions_file()["table_1"][cause.field]
    return cause.of(part["size"]), replace(shipped(motor), amplitude=part[motor.name])


@dataclass(frozen=True)
class Explanation:
    """A cause at the size that explains the observer's accuracy on one motor.

    Attributes:
        cause, motor: which.
        size: SI.
        amplitude: m/s^2, of the cogging's first period on this motor.
        accuracy: m, the observer's on this motor, (draws,).
        elsewhere: m, the observer's on the other motor under the same size, (draws,).
    """

    cause: Cause
    motor: Motor
    size: float
    amplitude: float
    accuracy: FloatArray
    elsewhere: FloatArray

    @property
    def labels(self) -> dict[str, str]:
        """Motor and cause, as the tables' rows bear them."""
        return {"motor": self.motor.name, "cause": self.cause.name}


def other(motor: Motor) -> Motor:
    """The other one of the two motors."""
    (found,) = (each for each in MOTORS.values() if each.name != motor.name)
    return found


def explained() -> list[Explanation]:
    """The shipped sizes, run."""
    found = []
    for cause in CAUSES:
        for motor in MOTORS.values():
            part = conditions_file()[cause.field][motor.name]
            amplitudes = {motor.name: part["amplitude"], other(motor).name: part["amplitude_elsewhere"]}
            runs = [
                drawn_accuracies(
                    each,
                    replace(shipped(each), amplitude=amplitudes[each.name]),
                    cause.of(part["size"]),
                    "observer",
                    cause.draws,
                )
                for each in (motor, other(motor))
            ]
            found.append(Explanation(cause, motor, part["size"], part["amplitude"], *runs))
    return found
