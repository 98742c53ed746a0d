"""Result of `diagnose`."""

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
    """Result of `diagnose`. `print` shows its `text`; `--json` writes its `to_dict`.

    Attributes:
        verdict: no_gap, named, ambiguous, unlisted, data_mismatch, controller_mismatch or insufficient_excitation.
        effects: effects that the model lacks.
        unlisted: force that no effect explains (coordinate, shape, share, and `added` with the gaps of an empirical
            term if one was requested), or None.
        gap: gap before and after, and noise floor.
        separating_experiment: motion that would distinguish the alternatives, or None.
        model: patched model: re-tuned, with the missing effects.
        nominal: re-tuned model without them.
        location: location of the gap of the nominal model; None if nothing was measured.
        where_text: its lines, one per coordinate or wave, the largest share first.
        ledger: tested effects.
        notes: further observations.
        series: rows for the figures: the `given` model, and of each log time, position, velocity, acceleration,
            command (V; the replayed one with replay), gap_before, gap_after (V) and mask (rows in motion).
        vocabulary: tested effects at their neutral parameters, by name.
        limits: detection limit of each effect (probability 95 %); empty if nothing was measured.
        mismatch: misread column and its correction for a data_mismatch, else None.
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
        """Return the JSON result; None stands for values that are not finite."""
        entries = {
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
        return {name: finite(value) for name, value in entries.items()}

    def _axis_parameters(self, model: Model) -> dict[str, dict[str, Any]]:
        """Return mass and friction of a model with their stated values and uncertainties, by path."""
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
        """Return old value, new value and 95 % interval of mass and friction, one line each."""
        entries = self._axis_parameters(self.model)
        return [axis_line(path, entry, self.model.intervals.get(path)) for path, entry in entries.items()]

    def html(self, *, title: str = "", step: NextStep | None = None) -> str:
        """Return the report as an HTML page with embedded figures.

        Args:
            title: title of the report, such as the names of the logs.
            step: next step with the user's own files (next_step); by default with placeholders.

        Raises:
            ValueError: Jinja2, of the extra `report`, is not installed.
        """
        return html(self, title=title, step=step)

    def report(self, path: str | os.PathLike[str], *, title: str = "") -> None:
        """Write the report as one HTML file that opens offline.

        Args:
            path: path of the file.
            title: title of the report, such as the names of the logs.

        Raises:
            ValueError: Jinja2, of the extra `report`, is not installed.
            InputError: the file cannot be written.
        """
        write_text(path, self.html(title=title))

    def to_frame(self, what: str = "effects") -> Any:
        """Return effects, limits or the ledger as a pandas DataFrame.

        Args:
            what: `effects` (one row per parameter), `limits` or `ledger`.

        Raises:
            ValueError: `what` is none of these.
            ImportError: pandas is not installed.
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
        """Return one row per parameter of each effect, in the order of EFFECT_COLUMNS."""
        return [
            [one.name, one.confidence, ", ".join(one.alternatives), name, p.value, *p.ci95, p.unit]
            for one in self.effects
            for name, p in one.parameters.items()
        ]

    def _repr_html_(self) -> str:
        title = f"Diagnosis: {self._brief()}"
        return html_table(title, EFFECT_COLUMNS, self._effect_rows(), self.where_text)

    def plot(self, what: str = "residual", *, units: Any = None, ax: Any = None) -> Figure:
        """Draw the gap before and after against position, speed, time and command, or the ledger.

        Args:
            what: `residual` (cogging.plot.residual) or `ledger` (cogging.plot.ledger).
            units: labels of command and position (cogging.Units); by default those of the model.
            ax: axes, four for `residual`; by default a new figure.

        Returns:
            The figure.

        Raises:
            ValueError: nothing was measured, or `what` is neither.
        """
        if what == "ledger":
            return plot.ledger(self, ax=ax).figure.figure
        if what != "residual":
            raise ValueError(f"what: must be residual or ledger, got {what!r}")
        return plot.residual(self, units=units, ax=ax).figure

    def text(self, *, verbose: bool = False) -> str:
        """Return the result for the screen in at most 15 lines, or completely with `verbose`."""
        return full_text(self) if verbose else short_text(self)
