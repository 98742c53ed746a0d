"""The result of tune: what the present and the tuned gains reach, and the trade-off."""

from __future__ import annotations

import os
from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from cogging.file_schema import TUNE_INDEXES
from cogging.model.model import Model
from cogging.model.units import Units
from cogging.outputs import write_bytes
from cogging.plot.canvas import grid_to_write, plot_method, png
from cogging.plot.results import WHOLE_TUNING, whole_tuning
from cogging.tables import frame_of
from cogging.values import ByValue

MARGINS = ("delay_margin", "gain_margin", "modulus_margin")
ROWS = ("error_rms", *TUNE_INDEXES)
SCALED = {"error_rms": (1e6, "um"), "error_max": (1e6, "um"), "delay_margin": (1e3, "ms")}  # for the screen


@dataclass(frozen=True)
class Reached:
    """What gains reach on a set of machines; a margin is the smallest over them, None where it is not measured."""

    error_rms: float  # m, the quantile over the machines; infinite where a run did not complete
    error_max: float  # m, the largest of all machines, as are the command's indexes
    command_max: float  # V
    command_rms: float  # V
    command_chatter: float  # of the command (see Performance)
    failed: int = 0  # number of machines on which the run did not complete
    delay_margin: float | None = None  # s
    gain_margin: float | None = None  # factor
    modulus_margin: float | None = None  # None also for a controller without a linear part


@dataclass(frozen=True)
class Setting:
    """Gains and what they reach."""

    gains: Mapping[str, float]  # by path
    drawn: Reached  # on the machines tuned with
    held_out: Reached  # on machines held out


@dataclass(frozen=True, eq=False, repr=False)
class Tuning(ByValue):
    """Tuned gains for an uncertain machine, with the present ones.

    Attributes:
        present: the present gains.
        tuned: the best gains that keep all limits on every machine tuned with (the present ones, if none is better);
            None if no trial keeps them.
        improved: whether they differ from the present ones.
        model: the model with the tuned gains; None if there are none, or for a user's own controller.
        trials: arrays by name, one entry a trial: the gains by path, the indexes, `kept` (all limits).
        front: the trade-off: arrays by name, one entry a point: `trial`, rms error, the index it is traded against,
            the gains, command_chatter and delay_margin; no trial is better than a point in both.
        against: the index of the trade-off.
        limits: in words.
        machines, held_out: how many.
        quantile: of rms error over machines.
        seed: of machines, noise and trials.
        notes: limits that no trial keeps, gains at the end of their range, and the like.
        units: labels of the model's units.
    """

    present: Setting
    tuned: Setting | None
    improved: bool
    model: Model | None
    trials: Mapping[str, Any]
    front: Mapping[str, Any]
    against: str
    limits: tuple[str, ...]
    machines: int
    held_out: int
    quantile: float
    seed: int
    notes: tuple[str, ...] = ()
    units: Units = field(default_factory=Units)

    def _brief(self) -> str:
        before, unit = 1e6 * self.present.drawn.error_rms, self.units.of("um")
        if self.tuned is None:
            return f"no gains keep the limits, present {before:.3g} {unit} rms"
        return f"{before:.3g} to {1e6 * self.tuned.drawn.error_rms:.3g} {unit} rms over {self.machines} machines"

    def text(self) -> str:
        """The result for the screen."""
        trials, kept = len(self.trials["kept"]), int(np.sum(self.trials["kept"]))
        lines = [
            f"{trials} trials on {self.machines} drawn machines, {kept} within the limits; checked on "
            f"{self.held_out} machines held out (rms: {100 * self.quantile:g} % quantile; others: the worst machine)"
        ]
        lines += [f"    limit {limit}" for limit in self.limits]
        after = self.tuned
        width = max(len(path) for path in (*self.present.gains, *ROWS)) + 6
        lines.append(f"    {'gain':<{width}}{'present':>12}" + f"{'tuned':>12}" * (after is not None))
        for path, value in self.present.gains.items():
            lines.append(f"    {path:<{width}}{value:>12.5g}" + (f"{after.gains[path]:>12.5g}" if after else ""))
        settings = {"present": self.present, **({} if after is None else {"tuned": after})}
        columns = {name: setting.drawn for name, setting in settings.items()}
        columns |= {f"{name}, held out": setting.held_out for name, setting in settings.items()}
        lines.append(f"    {'':<{width}}" + "".join(f"{title:>19}" for title in columns))
        for row in ROWS:
            cells = [getattr(reached, row) for reached in columns.values()]
            factor, unit = SCALED.get(row) or (1.0, TUNE_INDEXES[row][0])
            name = row if unit == "1" else f"{row}, {self.units.of(unit)}"
            if any(cell is not None for cell in cells):
                shown = ["-" if cell is None else f"{factor * cell:.4g}" for cell in cells]
                lines.append(f"    {name:<{width}}" + "".join(f"{cell:>19}" for cell in shown))
        if after is not None and self.improved:
            pairs = {
                name: (getattr(self.present.drawn, name), getattr(after.drawn, name))
                for name in ("error_rms", "command_chatter", *MARGINS)
            }
            changes = [
                f"{name} {100 * (new / old - 1):+.0f} %"
                for name, (old, new) in pairs.items()
                if old is not None and new is not None and np.isfinite([old, new]).all() and old > 0.0
            ]
            lines.append(f"    tuned against present: {', '.join(changes or ['the present gains do not run'])}")
        return "\n".join([*lines, *(f"  note: {note}" for note in self.notes)])

    def to_frame(self, what: str = "trials") -> Any:
        """The `trials` or the `front` as a pandas DataFrame (extra `frames`), with units in `attrs["units"]`.

        Raises:
            ValueError: `what` is neither.
        """
        if what not in ("trials", "front"):
            raise ValueError(f"what: must be trials or front, got {what!r}")
        units = {"error_rms": "m", **{name: unit for name, (unit, *_) in TUNE_INDEXES.items() if unit != "1"}}
        labels = {name: self.units.of(unit) for name, unit in units.items()}
        return frame_of(self.trials if what == "trials" else self.front, labels)

    def to_dict(self) -> dict[str, Any]:
        """What `cogging tune --json` writes; null stands for infinite and for not measured."""

        def entry_of(setting: Setting) -> dict[str, Any]:
            return {"gains": dict(setting.gains), "drawn": vars(setting.drawn), "held_out": vars(setting.held_out)}

        names = ("improved", "against", "front", "trials", "limits", "machines", "held_out", "quantile", "seed")
        settings = {"present": self.present, "tuned": self.tuned}
        entries = {name: None if setting is None else entry_of(setting) for name, setting in settings.items()}
        return {**entries, **{name: getattr(self, name) for name in (*names, "notes")}}

    plot = plot_method(whole_tuning, "Draw the trade-off, rms error over its index, and over the margin.", "two axes")

    def write_figure(self, path: str | os.PathLike[str]) -> None:
        """Write the trade-off as PNG.

        Raises:
            InputError: the file cannot be written.
        """
        write_bytes(path, png(self.plot(ax=grid_to_write(1, 2, WHOLE_TUNING))))
