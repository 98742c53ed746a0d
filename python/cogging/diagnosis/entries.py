"""Entries of a result: parameters, named effects, the gap, the ledger and detection limits."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any

SURE = 0.9  # minimum confidence of a named effect (contract)
CLOSED_MIN = 1e-3  # of the squared gap: minimum power above the floor


@dataclass(frozen=True)
class Value:
    """A parameter with its unit and 95 % interval."""

    value: float | list[float]
    unit: str
    ci95: tuple[Any, Any]

    def to_dict(self) -> dict[str, Any]:
        """Return the entry of the JSON result."""
        return {"value": self.value, "unit": self.unit, "ci95": list(self.ci95)}


@dataclass(frozen=True)
class NamedEffect:
    """An effect that the model lacks.

    Attributes:
        name: name in the vocabulary.
        alternatives: other names that these logs cannot distinguish from it.
        confidence: stated probability that the name is right.
        parameters: values by field; for a change of the axis, `change` = new / old - 1.
        where: coordinate and range in which it acts.
        statistic: 2 ln likelihood ratio against the null hypothesis, less the penalty for amplitudes and trials.
        further: parameters of further terms of the same name (harmonics).
        share: share of the power of the gap before that it explains.
        shape: "other" if its force deviates from the basic law; else "".
        curve: that force over one coordinate (`coordinate`, `places`, `force` in V); None if it is no function of one
            coordinate.
        in_model: whether the patched model has it.
    """

    name: str
    alternatives: tuple[str, ...]
    confidence: float
    parameters: Mapping[str, Value]
    where: Mapping[str, Any]
    statistic: float
    further: tuple[Mapping[str, Value], ...] = ()
    share: float | None = None
    shape: str = ""
    curve: Mapping[str, Any] | None = None
    in_model: bool = True

    @property
    def is_sure(self) -> bool:
        """Whether the contract allows a verdict of `named`."""
        return self.confidence >= SURE and not self.alternatives

    def to_dict(self) -> dict[str, Any]:
        """Return the entry of the JSON result."""
        entry = {
            "name": self.name,
            "alternatives": list(self.alternatives),
            "confidence": self.confidence,
            "share": self.share,
            "parameters": {name: value.to_dict() for name, value in self.parameters.items()},
            "where": dict(self.where),
            "statistic": self.statistic,
            "further": [{name: value.to_dict() for name, value in term.items()} for term in self.further],
            "in_model": self.in_model,
        }
        shape = {"shape": self.shape} if self.shape else {}
        return entry | shape | ({} if self.curve is None else {"curve": dict(self.curve)})


@dataclass(frozen=True)
class Step:
    """One line of the ledger: an effect that was tried.

    Attributes:
        name: name of the effect.
        accepted: whether it was added.
        reason: why it was added or refused.
        statistic: 2 ln likelihood ratio, less the penalty for amplitudes and trials.
        gap_before, gap_after: gaps of the models without and with it, V; None if it is not in the model.
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
class Gap:
    """The gap: rms of the unexplained force over rows in motion, in the unit of the command.

    Attributes:
        unit: unit of the command.
        floor: gap that noise and quantisation alone would leave.
        given: gap of the model as read, before re-tuning; None if it cannot be measured.
        before, after: gaps of the re-tuned model and of the patched model.
        confirm_before, confirm_after: the same on the confirm logs; None without any.
        signal: compared signal.
        position_before, position_after: rms of measured less replayed position, m; None without replay.
        share: `after` over the rms command in motion; None if nothing was measured.
        predictable: share of the power of `after` that a generic force of position, speed, direction, acceleration
            and command, fitted to the given logs, predicts on the confirm logs; None without any.
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
        """Share of the gap's power above the floor that the found effects explain; None without such power."""
        above = self.before**2 - self.floor**2
        if self.before <= 0.0 or above <= CLOSED_MIN * self.before**2:
            return None
        return (self.before**2 - self.after**2) / above

    def to_dict(self) -> dict[str, Any]:
        """Return the entry of the JSON result."""
        names = ("unit", "floor", "given", "before", "after", "confirm_before", "confirm_after", "share", "predictable")
        errors = {f"tracking_error_{when}": getattr(self, f"position_{when}") for when in ("before", "after")}
        return {name: getattr(self, name) for name in (*names, "signal")} | errors


@dataclass(frozen=True)
class Limit:
    """Detection limit: the smallest size of an effect that the logs would have shown with a probability of 95 %.

    Attributes:
        parameter: field that measures the size, or the first of several; `change` (new / old - 1) of the axis.
        unit: unit of the size.
        value: detection limit; None if this motion cannot show the effect.
        why: why there is no value; empty if there is one.
        meaning: formula of the size if it has several fields; else empty.
        smaller_shows: whether a smaller value has a larger effect, as for a stiffness or a command limit.
        shape: shape parameters for which the limit holds, or their ranges.
    """

    parameter: str
    unit: str
    value: float | None = None
    why: str = ""
    meaning: str = ""
    smaller_shows: bool = False
    shape: Mapping[str, Any] = field(default_factory=dict)

    def to_dict(self) -> dict[str, Any] | None:
        """Return the entry of the JSON result, or None without a limit."""
        if self.value is None:
            return None
        entry = {"parameter": self.parameter, "value": self.value, "unit": self.unit, "shape": dict(self.shape)}
        return entry | ({"meaning": self.meaning} if self.meaning else {}) | {"smaller_shows": self.smaller_shows}
