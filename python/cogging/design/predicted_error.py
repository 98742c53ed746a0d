"""What is predicted of the tracking error: indexes with intervals, as a table and as JSON."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any

import numpy as np
import numpy.typing as npt

from cogging import plot
from cogging.arrays import FloatArray
from cogging.calls import did_you_mean
from cogging.model.intervals import Interval
from cogging.model.units import Units
from cogging.tables import frame_of, to_pandas
from cogging.values import ByValue

if TYPE_CHECKING:
    from matplotlib.figure import Figure

#: Indexes of a prediction: over the window, and the largest of the whole run.
INDEXES = ("rms", "max", "max_whole")


@dataclass(frozen=True)
class PredictedIndex:
    """One index of the error over the drawn machines.

    Attributes:
        median: m; infinite where more than half the runs diverged.
        interval: m, between which the index of one more machine lies (see ErrorPrediction.coverage).
        values: m, (samples,), one a machine, in the order drawn; infinite where the run diverged.
    """

    median: float
    interval: Interval
    values: FloatArray = field(repr=False)


@dataclass(frozen=True)
class ControllerPrediction:
    """What a controller would reach.

    Attributes:
        name: of the controller.
        rms, max: of encoder reading minus reference, m, over the window.
        max_whole: largest over the whole run, m.
        diverged: share of the machines on which the run diverged.
    """

    name: str
    rms: PredictedIndex
    max: PredictedIndex
    max_whole: PredictedIndex
    diverged: float


@dataclass(frozen=True, eq=False, repr=False)
class ErrorPrediction(ByValue):
    """The predicted tracking error of each controller.

    Attributes:
        controllers: one entry a controller.
        window: of `rms` and `max`, s: the last period of a periodic motion of two or more, else the whole run.
        samples, seed: of the drawn machines.
        coverage: chance that the index of one more machine drawn likewise lies in its interval: 0.95, or
            (samples - 1) / (samples + 1) where fewer than 39 samples cannot tell so far out.
        notes: which parameters had no interval, which controllers were left out and why.
        machines: what was drawn, by path, and `seed` of the noise: arrays (samples,) in the order drawn, as the
            `values` of each index.
        units: labels of the model's units.

    Example:
        >>> prediction = cogging.predict_error(model, move, ["own"], samples=4)
        >>> prediction["own"].diverged
        0.0
    """

    controllers: tuple[ControllerPrediction, ...]
    window: Interval
    samples: int
    seed: int
    coverage: float
    notes: tuple[str, ...] = ()
    machines: Mapping[str, npt.NDArray[Any]] = field(default_factory=dict)
    units: Units = field(default_factory=Units)

    def _brief(self) -> str:
        told = [f"{one.name} {1e6 * one.rms.median:.3g} {self.units.of('um')} rms" for one in self.controllers]
        return f"{', '.join(told)}; {self.samples} machines"

    def __getitem__(self, name: str) -> ControllerPrediction:
        """The prediction of a controller.

        Raises:
            KeyError: no such controller.
        """
        for controller in self.controllers:
            if controller.name == name:
                return controller
        known = [controller.name for controller in self.controllers]
        raise KeyError(f"{name}: is no controller of it; {did_you_mean(name, known)}")

    def plot(self, index: str = "rms", *, units: Any = None, ax: Any = None) -> Figure:
        """Draw the error that each controller would reach (cogging.plot.prediction).

        Args:
            index: `rms`, `max` or `max_whole`.
            units: labels of command and position (cogging.Units).
            ax: axes; None: a new figure.

        Returns:
            The figure.
        """
        return plot.prediction(self, index, units=units, ax=ax).figure.figure

    def table(self) -> dict[str, Any]:
        """One row a controller and machine: its names and places, what was drawn, and the indexes (m).

        Returns:
            Arrays by name: `controller`, `machine`, the paths, `seed`, `rms`, `max`, `max_whole`.
        """
        count = len(self.controllers)
        drawn = {path: np.tile(values, count) for path, values in self.machines.items()}
        found = {name: np.concatenate([getattr(one, name).values for one in self.controllers]) for name in INDEXES}
        names = np.repeat(np.array([one.name for one in self.controllers], dtype=object), self.samples)
        return {"controller": names, "machine": np.tile(np.arange(self.samples), count), **drawn, **found}

    def to_pandas(self) -> Any:
        """The table as a pandas DataFrame.

        Raises:
            ImportError: pandas is not there; names the extra that brings it.
        """
        return to_pandas(self.table())

    def to_frame(self) -> Any:
        """The table as a pandas DataFrame, with the units of the indexes in `attrs["units"]`.

        Raises:
            ImportError: pandas is not there; names the extra that brings it.
        """
        return frame_of(self.table(), dict.fromkeys(INDEXES, self.units.of("m")))

    def text(self) -> str:
        """The table for the screen, um."""
        width = max(10, *(len(controller.name) for controller in self.controllers))
        titles, unit = ("rms", "max", "max of the whole run"), self.units.of("um")
        lines = [
            f"Predicted tracking error, {unit}: median and {100 * self.coverage:.0f} % interval over {self.samples} "
            f"machines; rms and max from {self.window[0]:g} to {self.window[1]:g} s",
            f"    {'controller':<{width}}" + "".join(f"{title:>30}" for title in titles) + f"{'diverged':>10}",
        ]
        for controller in self.controllers:
            cells = [_cell(getattr(controller, index)) for index in INDEXES]
            lines.append(f"    {controller.name:<{width}}" + "".join(cells) + f"{controller.diverged:>10.0%}")
        return "\n".join([*lines, *(f"  note: {note}" for note in self.notes)])

    def to_dict(self) -> dict[str, Any]:
        """What `cogging predict --json` writes; null stands for infinite, of runs that diverged."""
        controllers = []
        for controller in self.controllers:
            entry: dict[str, Any] = {"controller": controller.name, "diverged": controller.diverged}
            for name in INDEXES:
                index: PredictedIndex = getattr(controller, name)
                numbers = [_finite(value) for value in (index.median, *index.interval)]
                entry[name] = {"unit": self.units.of("m"), "median": numbers[0], "interval": numbers[1:]}
            controllers.append(entry)
        return {
            "controllers": controllers,
            "window": list(self.window),
            "samples": self.samples,
            "seed": self.seed,
            "coverage": self.coverage,
            "notes": list(self.notes),
        }


def _finite(value: float) -> float | None:
    return value if np.isfinite(value) else None


def _cell(index: PredictedIndex) -> str:
    low, high = (f"{1e6 * end:.3g}" for end in index.interval)
    return f"{f'{1e6 * index.median:.3g} [{low}, {high}]':>30}"
