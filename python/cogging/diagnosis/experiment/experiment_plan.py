"""A planned experiment: the motion, what it is expected to show, and the files that it is written to."""

from __future__ import annotations

import os
from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from cogging._core import Sampled
from cogging.diagnosis.experiment.expectation import Expectation
from cogging.diagnosis.experiment.limits import MotionLimits
from cogging.diagnosis.experiment.motion import Element
from cogging.model.units import Units
from cogging.outputs import to_json, to_toml, write_files
from cogging.plot.results import whole_plan
from cogging.values import ByValue

if TYPE_CHECKING:
    from matplotlib.figure import Figure

PURPOSE = {
    "separate": "a motion to tell rivals apart",
    "detect": "a motion to see small effects",
    "fit": "a motion to narrow the intervals of a fit",
}


@dataclass(frozen=True, eq=False, repr=False)
class ExperimentPlan(ByValue):
    """A planned experiment. Printed, it is its `text`.

    Attributes:
        goal: separate, detect or fit.
        elements: motions one after another, each a kind with its parameters.
        motion: the reference.
        limits: what the machine may do, with what the model stated of it.
        taken: largest of each quantity in the simulated loop over its limit, by the limit's name.
        expected: what the motion is expected to show.
        notes: sentences on what was assumed.
        seed: of the noise that was simulated.
        units: labels of the model's units.

    Example:
        >>> limits = cogging.MotionLimits(velocity=0.3, acceleration=5.0, duration=3.0)
        >>> plan = cogging.plan_experiment(model, limits, goal="fit")
        >>> log = cogging.simulate(model, plan.motion)
        >>> bool(abs(log.command).max() > 0.0)
        True
    """

    goal: str
    elements: tuple[Element, ...]
    motion: Sampled
    limits: MotionLimits
    taken: Mapping[str, float]
    expected: tuple[Expectation, ...]
    notes: tuple[str, ...] = ()
    seed: int = 0
    units: Units = field(default_factory=Units)

    def _brief(self) -> str:
        return f"{self.goal}, {self.motion.end:.4g} s: {', '.join(element.kind for element in self.elements)}"

    def text(self) -> str:
        """The plan for the screen."""
        lines = [f"{PURPOSE[self.goal]}, {self.motion.end:.4g} s:"]
        lines += [f"  {number}. {element.text()}" for number, element in enumerate(self.elements, start=1)]
        shares = ", ".join(f"{name} {100 * share:.0f} %" for name, share in self.taken.items())
        lines.append(f"of the limits it takes: {shares}")
        lines.append("to be expected:")
        lines += [f"  {entry.text()}" for entry in self.expected] or ["  nothing that can be told"]
        lines += [f"note: {note}" for note in self.notes]
        return "\n".join(lines)

    def to_dict(self) -> dict[str, Any]:
        """The plan without its samples: what stands beside the reference file."""
        return {
            "goal": self.goal,
            "expected": [vars(entry) for entry in self.expected],
            "elements": [{"kind": one.kind, **one.parameters, "scale": one.scale} for one in self.elements],
            "limits": self.limits.to_dict(),
            "taken": dict(self.taken),
            "duration": self.motion.end,
            "seed": self.seed,
            "notes": list(self.notes),
        }

    def plot(self, *, units: Any = None, ax: Any = None) -> Figure:
        """Draw position, speed and acceleration of the motion over time.

        Args:
            units: labels of command and position (cogging.Units).
            ax: three axes; None: a new figure.

        Returns:
            The figure.
        """
        return whole_plan(self, units=units, ax=ax).figure

    def write(self, path: str | os.PathLike[str]) -> None:
        """Write the motion as a reference file (TOML), and beside it its samples (.csv) and the plan (.plan.json).

        Args:
            path: path of the reference file, which `simulate` and `read_reference` take.

        Raises:
            InputError: a file cannot be written; none then is.
        """
        write_files({name: [content.encode()] for name, content in self.files(path).items()})

    def files(self, path: str | os.PathLike[str]) -> dict[str, str]:
        """The files of the plan by path: reference, samples and plan."""
        samples, plan = samples_path(path), plan_path(path)
        columns = self.motion.samples
        names = ("time", "reference", "reference_velocity", "reference_acceleration")
        table = np.column_stack([columns[name] for name in names]).tolist()
        rows = "\n".join([",".join(names), *(",".join(f"{value:.12g}" for value in row) for row in table)])
        reference = {"type": "sampled", "file": Path(samples).name, "duration": self.motion.end}
        return {os.fspath(path): to_toml(reference), samples: rows + "\n", plan: to_json(self.to_dict())}


def samples_path(path: str | os.PathLike[str]) -> str:
    """The table of samples beside a reference file: its name with .csv."""
    return os.path.splitext(os.fspath(path))[0] + ".csv"


def plan_path(path: str | os.PathLike[str]) -> str:
    """The plan beside a reference file: its name with .plan.json."""
    return os.path.splitext(os.fspath(path))[0] + ".plan.json"
