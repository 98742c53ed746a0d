"""What `diagnose` found."""

from __future__ import annotations

import os
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any

from cogging.diagnosis.location import Location, locate_gap
from cogging.diagnosis.report.page import html, overview
from cogging.diagnosis.report.words import step_text, term_text
from cogging.diagnosis.residual.shapes import Shape
from cogging.model.model import Model
from cogging.outputs import finite, write_text
from cogging.values import ByValue

if TYPE_CHECKING:
    from matplotlib.figure import Figure


@dataclass(frozen=True)
class Value:
    """A parameter with its unit and 95 % interval."""

    value: float | list[float]
    unit: str
    ci95: tuple[Any, Any]


@dataclass(frozen=True)
class NamedEffect:
    """An effect that the model lacks.

    Attributes:
        name: of the vocabulary.
        alternatives: other names that these logs cannot tell from it.
        confidence: the stated chance that the name is right.
        parameters: by field; of a change: `change` = new / old - 1.
        where: coordinate and range in which it sits.
        statistic: T of its score test.
        log_p_value: ln of the probability that noise alone shows as much (`log_chance` in JSON).
        further: parameters of further terms of the same name (harmonics).
    """

    name: str
    alternatives: tuple[str, ...]
    confidence: float
    parameters: Mapping[str, Value]
    where: Mapping[str, Any]
    statistic: float
    log_p_value: float
    further: tuple[Mapping[str, Value], ...] = ()


@dataclass(frozen=True)
class Step:
    """One line of the ledger: an effect that was tried.

    Attributes:
        name: of the effect.
        accepted: whether it was added.
        reason: for either.
        statistic: T of its score test.
        gap_before, gap_after: V, of the models without and with it; None where it was refused.
        confirm_before, confirm_after: the same on the confirm logs.
    """

    name: str
    accepted: bool
    reason: str
    statistic: float
    gap_before: float | None
    gap_after: float | None
    confirm_before: float | None
    confirm_after: float | None


@dataclass(frozen=True)
class Placebo:
    """An effect that was not found, fitted all the same: what noise gives to a term that explains nothing.

    Attributes:
        name: of the effect.
        statistic: T on the logs.
        confirm_gain: of 2 ln likelihood on the confirm logs with frozen amplitudes; negative: worse than without it.
    """

    name: str
    statistic: float
    confirm_gain: float | None


@dataclass(frozen=True)
class Gap:
    """Rms over rows in motion of what the model leaves unexplained, V."""

    unit: str
    floor: float
    before: float
    after: float
    confirm_before: float | None
    confirm_after: float | None
    signal: str
    position_before: float | None = None
    position_after: float | None = None


@dataclass(frozen=True, eq=False, repr=False)
class Diagnosis(ByValue):
    """What `diagnose` found. Printed, it is its `text`; `to_dict` is what `--json` writes.

    Attributes:
        verdict: no_gap, named, ambiguous, unlisted, controller_mismatch or insufficient_excitation.
        effects: that are missing.
        unlisted: a gap that no effect explains: coordinate, shape, share, and as `added` what an empirical term makes
            of it where one was asked for; or None.
        gap: before, after, floor.
        separating_experiment: the motion that would tell the alternatives apart, or None.
        model: refitted, with the effects that were found.
        nominal: refitted, without them.
        where: the gap before anything was named, by coordinate, the likeliest first; where_text: the same in words.
        ledger: the effects that were tried.
        placebo: what terms that explain nothing would have gained.
        notes: in words.
        series: for the figures, by name: `logs`, the `given` model, and of each log time, position, velocity (m/s),
            gap_before, gap_after (V) and mask (rows in motion).
    """

    verdict: str
    effects: tuple[NamedEffect, ...]
    unlisted: Mapping[str, Any] | None
    gap: Gap
    separating_experiment: str | None
    model: Model
    nominal: Model
    where: tuple[Shape, ...] = ()
    where_text: tuple[str, ...] = ()
    ledger: tuple[Step, ...] = ()
    notes: tuple[str, ...] = ()
    placebo: tuple[Placebo, ...] = ()
    series: Mapping[str, Any] = field(default_factory=dict)

    def _brief(self) -> str:
        names = ", ".join(effect.name for effect in self.effects)
        gap = f"gap {self.gap.before:.3g} {self.gap.unit} before, {self.gap.after:.3g} {self.gap.unit} after"
        return f"{self.verdict}{': ' * bool(names)}{names}; {gap}"

    def to_dict(self) -> dict[str, Any]:
        """The result as the contract of `diagnose --json` has it, and more beside; what is not finite is None."""
        told = {
            "verdict": self.verdict,
            "effects": [
                {
                    "name": effect.name,
                    "alternatives": list(effect.alternatives),
                    "confidence": effect.confidence,
                    "parameters": {
                        name: {"value": p.value, "unit": p.unit, "ci95": list(p.ci95)}
                        for name, p in effect.parameters.items()
                    },
                    "where": dict(effect.where),
                    "statistic": effect.statistic,
                    "log_chance": effect.log_p_value,
                    "further": [
                        {name: {"value": p.value, "unit": p.unit, "ci95": list(p.ci95)} for name, p in term.items()}
                        for term in effect.further
                    ],
                }
                for effect in self.effects
            ],
            "unlisted": None if self.unlisted is None else dict(self.unlisted),
            "gap": {
                "unit": self.gap.unit,
                "floor": self.gap.floor,
                "before": self.gap.before,
                "after": self.gap.after,
                "confirm_before": self.gap.confirm_before,
                "confirm_after": self.gap.confirm_after,
                "signal": self.gap.signal,
                "tracking_error_before": self.gap.position_before,
                "tracking_error_after": self.gap.position_after,
            },
            "separating_experiment": self.separating_experiment,
            "where": list(self.where_text),
            "ledger": [vars(step) for step in self.ledger],
            "placebo": [vars(entry) for entry in self.placebo],
            "notes": list(self.notes),
        }
        return {name: finite(value) for name, value in told.items()}

    def html(self, *, title: str = "") -> str:
        """The report as a text: one HTML page with its figures inside.

        Raises:
            ValueError: Jinja2, of the extra `report`, is not installed.
        """
        return html(self, self._location(), title=title)

    def _location(self) -> Location | None:
        logs = self.series.get("logs")
        return None if not logs else locate_gap(logs, self.nominal)

    def report(self, path: str | os.PathLike[str], *, title: str = "") -> None:
        """Write one HTML file that opens offline: what disagrees, where, why, what else it could be, what to do next.

        Args:
            path: of the file.
            title: what was diagnosed, such as the names of the logs.

        Raises:
            ValueError: Jinja2, of the extra `report`, is not installed.
            InputError: the file cannot be written.
        """
        write_text(path, self.html(title=title))

    def plot(self) -> Figure:
        """The gap before and after against every coordinate, with 95 % bands, and its spectrum.

        Raises:
            ValueError: the verdict came before anything was measured.
        """
        return overview(self)

    def text(self) -> str:
        """The result for the screen."""
        lines = [f"verdict: {self.verdict}"]
        for effect in self.effects:
            others = f" or {', '.join(effect.alternatives)}" if effect.alternatives else ""
            lines.append(f"  {effect.name}{others}: confidence {effect.confidence:.2f}")
            for name, p in effect.parameters.items():
                lines.append(
                    f"    {name} = {_number(p.value)} {p.unit}, 95 % {_number(p.ci95[0])} to {_number(p.ci95[1])}"
                )
        if self.unlisted is not None:
            lines.append(f"  unlisted: {self.unlisted['shape']}")
            if "added" in self.unlisted:
                lines.append(f"    {term_text(self.unlisted['added'], self.gap.unit)}")
        g = self.gap
        lines.append(f"gap ({g.signal}): {g.before:.4g} {g.unit} before, {g.after:.4g} after, floor {g.floor:.4g}")
        if g.confirm_before is not None and g.confirm_after is not None:
            lines.append(f"  on the confirm logs: {g.confirm_before:.4g} {g.unit} before, {g.confirm_after:.4g} after")
        if self.where_text:
            lines.append("where the gap sits:")
            lines += [f"  {line}" for line in self.where_text]
        if self.ledger:
            lines.append("ledger:")
            lines += [f"  {step_text(step, g.unit)}" for step in self.ledger]
        if self.placebo:
            lines.append("placebo terms, T here and gain of 2 ln likelihood on the confirm logs:")
            lines += [f"  {p.name}: T = {p.statistic:.1f}, {_number(p.confirm_gain)}" for p in self.placebo]
        if self.separating_experiment:
            lines.append(f"what would tell them apart: {self.separating_experiment}")
        lines += [f"note: {note}" for note in self.notes]
        return "\n".join(lines)


def _number(value: float | Sequence[float | None] | None) -> str:
    if value is None:
        return "not known"
    if isinstance(value, int | float):
        return f"{value:.4g}"
    return "[" + ", ".join("?" if v is None else f"{v:.3g}" for v in value) + "]"
