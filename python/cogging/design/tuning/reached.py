"""What a controller reaches on many machines: the error that is minimised, and all that limits stand on."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, fields, replace
from typing import Any, NamedTuple

import numpy as np

from cogging.arrays import FloatArray
from cogging.design.tuning.gains import Tuned
from cogging.design.tuning.linear_loop import modulus_margin
from cogging.design.tuning.machines import Machine
from cogging.design.tuning.margins import Loops, Push
from cogging.file_schema import TUNE_INDEXES
from cogging.model.controller import AnyController
from cogging.simulation.reductions import kept_of_runs, names_of

REDUCTIONS = ("command_max",)
MARGINS = ("delay_margin", "gain_margin", "modulus_margin")
INDEXES = TUNE_INDEXES


@dataclass(frozen=True)
class Reached:
    """What gains reach on some machines.

    Attributes:
        error_rms: m, the quantile over the machines; infinite where one did not come to its end.
        error_max: m, the largest of all; so are the three of the command.
        command_max, command_rms: V.
        command_chatter: of the command (see Performance).
        failed: machines on which the run did not come to its end.
        delay_margin: s, the smallest over the machines, as the other margins; None where it was not measured.
        gain_margin: factor.
        modulus_margin: None also where the controller has no linear part.
    """

    error_rms: float
    error_max: float
    command_max: float
    command_rms: float
    command_chatter: float
    failed: int = 0
    delay_margin: float | None = None
    gain_margin: float | None = None
    modulus_margin: float | None = None

    def to_dict(self) -> dict[str, Any]:
        """The numbers by name."""
        return {field.name: getattr(self, field.name) for field in fields(self)}


class Course(NamedTuple):
    """How machines are run: s each, but for the threads and the share of the quantile.

    Attributes:
        duration: 0 = the motion's own end.
        start, stop: of the rows that the indexes look at.
        quantile: of rms error over machines.
        threads: 0 = all cores.
    """

    duration: float
    start: float
    stop: float
    quantile: float
    threads: int


class Judge:
    """Runs machines under controllers.

    Attributes:
        machines: the same for all gains.
    """

    def __init__(self, machines: Sequence[Machine], tuned: Tuned, course: Course) -> None:
        self.machines, self._tuned, self._course = list(machines), tuned, course

    def run(self, gains: Mapping[str, float]) -> Reached:
        """What gains reach, without margins.

        Raises:
            ValueError: the gains break a rule of the controller, or no run can begin.
        """
        course = self._course
        controller = self._tuned.make(gains)
        kept = kept_of_runs(
            [machine.setup.model.plant() for machine in self.machines],
            [controller] * len(self.machines),
            [machine.setup.reference for machine in self.machines],
            durations=[course.duration],
            seeds=[machine.seed for machine in self.machines],
            steps_per_sample=[self.machines[0].setup.model.steps_per_sample],
            threads=course.threads,
            window=(course.start, course.stop, 2.0),
            reductions=REDUCTIONS,
            keeps_refused=True,
        )
        if len(kept.failures) == len(self.machines) and all(math.isnan(one.time) for one in kept.failures):
            raise ValueError(kept.failures[0].reason)
        values = dict(zip(names_of(REDUCTIONS), np.where(np.isnan(kept.values), np.inf, kept.values).T, strict=True))
        largest = {name: float(values[name].max()) for name in INDEXES if name in values}
        error = upper_quantile(values["error_rms"], course.quantile) if not kept.failures else math.inf
        return Reached(error, failed=len(kept.failures), **largest)

    def loops(self, gains: Mapping[str, float], push: Push) -> Loops:
        """The loops of these gains, to be pushed."""
        return Loops(self.machines, self._tuned.make(gains), push, threads=self._course.threads)

    def controller(self, gains: Mapping[str, float]) -> AnyController:
        """The controller of these gains."""
        return self._tuned.make(gains)

    def modulus_margin(self, gains: Mapping[str, float]) -> float | None:
        """The smallest over the machines, or None where there is none."""
        model = self._tuned.model(gains)
        if model is None:
            return None
        found = [modulus_margin(machine.setup.model.replace(controller=model.controller)) for machine in self.machines]
        known = [margin for margin in found if margin is not None]
        return min(known) if known else None

    def with_margins(
        self, gains: Mapping[str, float], reached: Reached, push: Push, names: Sequence[str] = MARGINS
    ) -> Reached:
        """The same with margins; those that are none for this controller stay None."""
        measured: dict[str, float | None] = {}
        loops = None if reached.failed else self.loops(gains, push)
        for name in names:
            if name == "modulus_margin":
                margin = self.modulus_margin(gains)
                measured[name] = margin if margin is None or not reached.failed else 0.0
            elif loops is None:
                measured[name] = 0.0
            else:
                measured[name] = loops.delay_margin() if name == "delay_margin" else loops.gain_margin()
        return replace(reached, **measured)  # type: ignore[arg-type]


def upper_quantile(values: FloatArray, share: float) -> float:
    """The smallest of n values that one more of the same kind exceeds with a chance of at most 1 - share: that of rank
    ceil(share (n + 1)); the largest where n is too small for that."""
    ordered = np.sort(values)
    return float(ordered[min(len(ordered), math.ceil(share * (len(ordered) + 1) - 1e-9)) - 1])
