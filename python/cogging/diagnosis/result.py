"""What `diagnose` found."""

from __future__ import annotations

import os
from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any

from cogging import plot
from cogging.diagnosis.entries import Gap, Limit, NamedEffect, Step
from cogging.diagnosis.location import Location
from cogging.diagnosis.next_step import NextStep
from cogging.diagnosis.report.page import html
from cogging.diagnosis.report.printed_answer import axis_line, full_text, short_text
from cogging.effects.effect import VOCABULARY, Effect
from cogging.model.model import Model
from cogging.outputs import finite, write_text
from cogging.tables import frame_of, html_table
from cogging.values import ByValue

if TYPE_CHECKING:
    from matplotlib.figure import Figure


EFFECT_COLUMNS = ("name", "confidence", "alternatives", "parameter", "value", "low", "high", "unit")


@dataclass(frozen=True, eq=False, repr=False)
class Diagnosis(ByValue):
    """What `diagnose` found. Printed, it is its `text`; `to_dict` is what `--json` writes.

    Attributes:
        verdict: no_gap, named, ambiguous, unlisted, data_mismatch, controller_mismatch or insufficient_excitation.
        effects: effects that the model lacks.
        unlisted: gap that no effect explains: coordinate, shape, share, and as `added` what an empirical term makes
            of it where one was asked for; or None.
        gap: size of the gap before and after, and its floor.
        separating_experiment: motion that would tell the alternatives apart, or None.
        model: refitted model with the effects that were found.
        nominal: refitted model without them.
        location: place of the gap before anything was named; None where nothing was measured.
        where_text: lines on that place, one a coordinate, the likeliest first.
        ledger: effects that were tried.
        notes: sentences on what else was seen.
        series: rows for the figures by name: the `given` model, and of each log time, position, velocity,
            acceleration, command (V, without the gap where that is part of it), gap_before, gap_after (V) and mask
            (rows in motion).
        vocabulary: effects that were tried, as they are when they do nothing, by name.
        limits: smallest size of each effect that these logs would have shown with a chance of 95 %; empty where
            nothing was measured.
        mismatch: column of a log that was read as something it is not, and what to do: of a data_mismatch, else None.
    """

    verdict: str
    effects: tuple[NamedEffect, ...]
    unlisted: Mapping[str, Any] | None
    gap: Gap
    separating_experiment: str | None
    model: Model
    nominal: Model
    location: Location | None = None
    where_text: tuple[str, ...] = ()
    ledger: tuple[Step, ...] = ()
    notes: tuple[str, ...] = ()
    series: Mapping[str, Any] = field(default_factory=dict)
    vocabulary: Mapping[str, Effect] = field(default_factory=lambda: VOCABULARY)
    limits: Mapping[str, Limit] = field(default_factory=dict)
    mismatch: Mapping[str, Any] | None = None

    def _brief(self) -> str:
        names = ", ".join(effect.name for effect in self.effects)
        gap = f"gap {self.gap.before:.3g} {self.gap.unit} before, {self.gap.after:.3g} {self.gap.unit} after"
        return f"{self.verdict}{': ' * bool(names)}{names}; {gap}"

    def to_dict(self) -> dict[str, Any]:
        """The result as the contract of `diagnose --json` has it, and more beside; what is not finite is None."""
        told = {
            "verdict": self.verdict,
            "nominal": self._axis_parameters(self.nominal),
            "effects": [effect.to_dict() for effect in self.effects],
            "mismatch": None if self.mismatch is None else dict(self.mismatch),
            "unlisted": None if self.unlisted is None else dict(self.unlisted),
            "gap": self.gap.to_dict(),
            "separating_experiment": self.separating_experiment,
            "limits": {name: limit.to_dict() for name, limit in self.limits.items()},
            "unseen": {name: limit.why for name, limit in self.limits.items() if limit.value is None},
            "where": list(self.where_text),
            "ledger": [vars(step) for step in self.ledger],
            "notes": list(self.notes),
        }
        return {name: finite(value) for name, value in told.items()}

    def _axis_parameters(self, model: Model) -> dict[str, dict[str, Any]]:
        """Mass and friction of a model beside what was stated of them, by path."""
        stated = self.series.get("given")
        if not isinstance(stated, Model):
            return {}
        return {
            f"axis.{name}": {
                "value": float(getattr(model.axis, name)),
                "stated": float(getattr(stated.axis, name)),
                "uncertainty": stated.uncertainty.get(name),
                "unit": self.model.units.of(type(stated.axis).FIELDS[name][0]),
            }
            for name in ("mass", "viscous", "coulomb")
        }

    def axis_lines(self) -> list[str]:
        """What became of mass and friction, a line each: old, new, 95 % interval; none where nothing was measured."""
        told = self._axis_parameters(self.model)
        return [axis_line(path, one, self.model.intervals.get(path)) for path, one in told.items()]

    def html(self, *, title: str = "", step: NextStep | None = None) -> str:
        """The report as a text: one HTML page with its figures inside.

        Args:
            title: name of what was diagnosed, such as those of the logs.
            step: what to do next, in the user's own files (next_step); by default with placeholders.

        Raises:
            ValueError: Jinja2, of the extra `report`, is not installed.
        """
        return html(self, title=title, step=step)

    def report(self, path: str | os.PathLike[str], *, title: str = "") -> None:
        """Write one HTML file that opens offline: what disagrees, where, why, what else it could be, what to do next.

        Args:
            path: path of the file.
            title: name of what was diagnosed, such as those of the logs.

        Raises:
            ValueError: Jinja2, of the extra `report`, is not installed.
            InputError: the file cannot be written.
        """
        write_text(path, self.html(title=title))

    def to_frame(self, what: str = "effects") -> Any:
        """Effects, limits or the ledger as a pandas DataFrame, a row each; units stand in their rows.

        Args:
            what: `effects` (a row a parameter), `limits` or `ledger`.

        Raises:
            ValueError: `what` is none of them.
            ImportError: pandas is not there; names the extra that brings it.
        """
        if what == "ledger":
            gaps = ("gap_before", "gap_after", "confirm_before", "confirm_after")
            return frame_of([vars(step) for step in self.ledger], dict.fromkeys(gaps, self.gap.unit))
        if what == "limits":
            names = ("parameter", "unit", "value", "why", "meaning", "smaller_shows")
            rows = [{"name": name, **{n: getattr(one, n) for n in names}} for name, one in self.limits.items()]
            return frame_of(rows, {})
        if what != "effects":
            raise ValueError(f"what: must be effects, limits or ledger, got {what!r}")
        return frame_of([dict(zip(EFFECT_COLUMNS, row, strict=True)) for row in self._effect_rows()], {})

    def _effect_rows(self) -> list[list[Any]]:
        """A row a parameter of each effect, in the order of EFFECT_COLUMNS."""
        return [
            [
                effect.name,
                effect.confidence,
                ", ".join(effect.alternatives),
                name,
                p.value,
                p.ci95[0],
                p.ci95[1],
                p.unit,
            ]
            for effect in self.effects
            for name, p in effect.parameters.items()
        ]

    def _repr_html_(self) -> str:
        title = f"Diagnosis: {self._brief()}"
        return html_table(title, EFFECT_COLUMNS, self._effect_rows(), self.where_text)

    def plot(self, what: str = "residual", *, units: Any = None, ax: Any = None) -> Figure:
        """Draw the gap before and after against position, speed, time and command, or where it goes.

        Args:
            what: `residual` (cogging.plot.residual) or `ledger` (cogging.plot.ledger).
            units: labels of command and position (cogging.Units); None: those of the model.
            ax: axes, four of a residual; None: a new figure.

        Returns:
            The figure.

        Raises:
            ValueError: the verdict came before anything was measured; `what` is neither.
        """
        if what == "ledger":
            return plot.ledger(self, ax=ax).figure.figure
        if what != "residual":
            raise ValueError(f"what: must be residual or ledger, got {what!r}")
        return plot.residual(self, units=units, ax=ax).figure

    def text(self, *, verbose: bool = False) -> str:
        """The result for the screen: what to act on, in 15 lines at most; `verbose`: all that it holds."""
        return full_text(self) if verbose else short_text(self)
