"""Causes that would each explain the observers' accuracy in Table I of Malaize and Levine 2009, and their effects.

As believed, the observers are 7 and 5 times better than printed. Each of CAUSES is one thing that the controllers do
not know. Its size on a motor is the one at which the observer's accuracy is the printed one, with the amplitude of the
cogging calibrated anew so that the PID keeps its own (causes_calibration.py, which writes conditions.toml). A cause
that explains both motors by one value says more than one that needs a value for each: `held_out` gives the value of
each motor to the other.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Any

from cogging.arrays import FloatArray
from cogging.papers.fitting import shipped_toml
from cogging.papers.malaize2009.conditions import DRAWS, Conditions, drawn_accuracies
from cogging.papers.malaize2009.setup import MOTORS, Calibrated, Motor, shipped

STEP_DRAWS = 5


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
    """What causes_calibration.py wrote: sizes and amplitudes."""
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
