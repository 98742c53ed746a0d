"""Entries of a result: parameters, named effects, the gap, and what was tried."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any

from cogging.diagnosis.thresholds import GAP


@dataclass(frozen=True)
class Value:
    """A parameter with its unit and 95 % interval."""

    value: float | list[float]
    unit: str
    ci95: tuple[Any, Any]

    def to_dict(self) -> dict[str, Any]:
        """Numbers for JSON."""
        return {"value": self.value, "unit": self.unit, "ci95": list(self.ci95)}


@dataclass(frozen=True)
class ShapeTerm:
    """The law of a named effect where it is another than the plainest: what it has beside that.

    Attributes:
        coordinate: name of what it depends on.
        unit: unit of the coordinate.
        places: values of the coordinate at which it is told.
        force: what the plainest law lacks there: V, or the effect's own unit (m of a reading, 1 of a gain).
        deviation: 1-sigma of each.
        statistic: T of it beside the plainest law.
        share: share of the whitened residual's power below 60 Hz that it explains.
        curve: the same as `coordinate`, `places` and `force` of a function of position or time alone, by which the
            patched model has it where that pays; None where it is none, or did not pay.
    """

    coordinate: str
    unit: str
    places: list[float]
    force: list[float]
    deviation: list[float]
    statistic: float
    share: float
    curve: Mapping[str, Any] | None = None

    def to_dict(self) -> dict[str, Any]:
        """Numbers for JSON."""
        return dict(vars(self))


@dataclass(frozen=True)
class NearRest:
    """Friction near rest that is not the model's, of a law that the logs cannot tell.

    Attributes:
        statistic: T of the shapes of slow friction beside all that is re-tuned.
        freedom: degrees of freedom.
        log_p_value: ln of the probability that noise alone shows as much (`log_chance` in JSON).
        confirm_log_p_value: the same on the confirm logs; None without.
        candidates: names of the effects that look like this.
        experiment: motion that would tell them apart.
    """

    statistic: float
    freedom: int
    log_p_value: float
    confirm_log_p_value: float | None
    candidates: tuple[str, ...]
    experiment: str

    def text(self) -> str:
        """In words."""
        return (
            f"near rest the friction is not the model's (T = {self.statistic:.0f} of {self.freedom} shapes); "
            "this motion cannot tell which law it follows"
        )

    def to_dict(self) -> dict[str, Any]:
        """Numbers for JSON."""
        return {
            "statistic": self.statistic,
            "freedom": self.freedom,
            "log_chance": self.log_p_value,
            "confirm_log_chance": self.confirm_log_p_value,
            "candidates": list(self.candidates),
            "text": self.text(),
            "experiment": self.experiment,
        }


@dataclass(frozen=True)
class NamedEffect:
    """An effect that the model lacks.

    Attributes:
        name: name in the vocabulary.
        alternatives: other names that these logs cannot tell from it.
        confidence: stated probability that the name is right.
        parameters: values by field; of a change: `change` = new / old - 1.
        where: coordinate and range in which it sits.
        statistic: T of its score test.
        log_p_value: ln of the probability that noise alone shows as much (`log_chance` in JSON).
        further: parameters of further terms of the same name (harmonics).
        share: of the power of the gap before, what it takes.
        differs: by how much the alternatives would do something else along these logs, rms over that of the gap.
        apart: standard deviations by which these logs tell it from an alternative, by the alternative's name.
        shape_term: law that it has beside the plainest, where its shape is another; None else.
    """

    name: str
    alternatives: tuple[str, ...]
    confidence: float
    parameters: Mapping[str, Value]
    where: Mapping[str, Any]
    statistic: float
    log_p_value: float
    further: tuple[Mapping[str, Value], ...] = ()
    apart: Mapping[str, float] = field(default_factory=dict)
    shape_term: ShapeTerm | None = None
    share: float | None = None
    differs: Mapping[str, float] = field(default_factory=dict)

    def to_dict(self) -> dict[str, Any]:
        """The effect as an entry of the JSON result."""
        other = {} if self.shape_term is None else {"shape": "other", "shape_term": self.shape_term.to_dict()}
        told = {
            "name": self.name,
            "alternatives": list(self.alternatives),
            "confidence": self.confidence,
            "share": self.share,
            "parameters": {name: value.to_dict() for name, value in self.parameters.items()},
            "where": dict(self.where),
            "statistic": self.statistic,
            "log_chance": self.log_p_value,
            "further": [{name: value.to_dict() for name, value in term.items()} for term in self.further],
            "apart": dict(self.apart),
            "differs": dict(self.differs),
        }
        return told | other


@dataclass(frozen=True)
class Step:
    """One line of the ledger: an effect that was tried.

    Attributes:
        name: name of the effect.
        accepted: whether it was added.
        reason: sentence on why it was added or refused.
        statistic: T of its score test.
        gap_before, gap_after: gaps of the models without and with it, V; None where it was refused.
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
        name: name of the effect.
        statistic: T on the logs.
        confirm_gain: gain of 2 ln likelihood on the confirm logs with frozen amplitudes; negative: worse than without.
    """

    name: str
    statistic: float
    confirm_gain: float | None


@dataclass(frozen=True)
class Gap:
    """The gap: rms over rows in motion of what the model leaves unexplained, in the unit of the command.

    Attributes:
        unit: unit of the command.
        floor: gap that noise and quantiser alone would leave.
        given: gap of the model as it was read, before any re-tuning; None where it cannot be measured.
        before, after: gaps of the re-tuned model, and of that with what was found.
        confirm_before, confirm_after: the same on the confirm logs; None without.
        signal: name of what was compared.
        position_before, position_after: rms of measured less replayed position, m; None where no loop is replayed.
        share: `after` over the rms command in motion; None where nothing was measured.
        predictable: of the power that is left after, the share that a generic force of place, speed, direction,
            acceleration and command, fitted to the given logs, predicts on the confirm logs; None without any.
    """

    unit: str
    floor: float
    before: float
    after: float
    confirm_before: float | None
    confirm_after: float | None
    signal: str
    position_before: float | None = None
    position_after: float | None = None
    given: float | None = None
    share: float | None = None
    predictable: float | None = None

    @property
    def closed(self) -> float | None:
        """Share of the gap's power above the floor that the found effects take away; None where there is none."""
        above = self.before**2 - self.floor**2
        return (
            (self.before**2 - self.after**2) / above
            if above > GAP.closed_min * self.before**2 and self.before > 0.0
            else None
        )

    @property
    def confirmed(self) -> float | None:
        """Gap after over gap before on the confirm logs; None without any."""
        return (
            self.confirm_after / self.confirm_before if self.confirm_before and self.confirm_after is not None else None
        )

    def to_dict(self) -> dict[str, Any]:
        """Numbers for JSON."""
        return {
            "unit": self.unit,
            "floor": self.floor,
            "given": self.given,
            "before": self.before,
            "after": self.after,
            "confirm_before": self.confirm_before,
            "confirm_after": self.confirm_after,
            "share": self.share,
            "predictable": self.predictable,
            "signal": self.signal,
            "tracking_error_before": self.position_before,
            "tracking_error_after": self.position_after,
        }


@dataclass(frozen=True)
class Limit:
    """The smallest size of an effect that the logs would have shown with a chance of 95 %.

    Attributes:
        parameter: field that is the size, or the first of several; `change` of a parameter, new / old - 1.
        unit: of the size.
        value: the size; None where this motion cannot show it.
        why: why there is no value; empty where there is one.
        meaning: how several fields make one size; empty where it is the field alone.
        smaller_shows: whether a smaller value does more: of a stiffness, or of a limit.
        shape: numbers of the shape for which it holds, or the range over which the chance is an average.
        sizes, chances: sizes from the least to the strongest, and with what chance the logs would have shown each.
    """

    parameter: str
    unit: str
    value: float | None = None
    why: str = ""
    meaning: str = ""
    smaller_shows: bool = False
    shape: Mapping[str, Any] = field(default_factory=dict)
    sizes: tuple[float, ...] = ()
    chances: tuple[float, ...] = ()

    def to_dict(self) -> dict[str, Any] | None:
        """The limit as an entry of the JSON result; None where there is none."""
        if self.value is None:
            return None
        told = {"parameter": self.parameter, "value": self.value, "unit": self.unit, "shape": dict(self.shape)}
        return told | ({"meaning": self.meaning} if self.meaning else {}) | {"smaller_shows": self.smaller_shows}


@dataclass(frozen=True)
class Outcome:
    """What became of one thing that a planned experiment was to show.

    Attributes:
        name: of the effect; of a fit, the path of the parameter.
        alternative: name that it was to be told from; empty where there is none.
        unit: of the numbers; "sigma" of rivals.
        expected: what the plan expected: standard deviations, a detection limit, or half of an interval.
        measured: the same of these logs; below 0 where they speak for the alternative; None where they do not tell.
        came_true: whether it came true; None where nothing was expected or nothing can be told.
    """

    name: str
    alternative: str
    unit: str
    expected: float | None
    measured: float | None
    came_true: bool | None

    def text(self) -> str:
        """One line."""
        if self.expected is None or self.measured is None:
            return f"{self.name}{' and ' * bool(self.alternative)}{self.alternative}: these logs do not tell"
        word = "it came true" if self.came_true else "it did not come true"
        if not self.alternative:
            unit = f" {self.unit}" if self.unit not in ("", "1") else ""
            return f"{self.name}: {self.expected:.3g}{unit} expected, {self.measured:.3g}{unit} found: {word}"
        for_ = self.name if self.measured > 0.0 else self.alternative
        return (
            f"{self.name} and {self.alternative}: {self.expected:.2g} sigma apart expected, "
            f"{abs(self.measured):.2g} found, for {for_}: {word}"
        )
