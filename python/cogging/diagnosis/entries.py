"""Entries of a result: parameters, named effects, the gap, and what was tried."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any

CLOSED_MIN = 1e-3  # of the squared gap: less above the floor is no share to close


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
class NamedEffect:
    """An effect that the model lacks.

    Attributes:
        name: name in the vocabulary.
        alternatives: other names that these logs cannot tell from it.
        confidence: stated probability that the name is right.
        parameters: values by field; of a change: `change` = new / old - 1.
        where: coordinate and range in which it sits.
        statistic: twice the log-likelihood ratio of it against none, less what its amplitudes and its scan cost.
        further: parameters of further terms of the same name (harmonics).
        share: of the power of the gap before, what it takes.
        shape: "other" where its law is not the plainest; else "".
        curve: the force that it then is over one coordinate (`coordinate`, `places`, `force` in V); None where no
            function of one coordinate gives it.
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

    def to_dict(self) -> dict[str, Any]:
        """The effect as an entry of the JSON result."""
        told = {
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
        other = {"shape": self.shape} if self.shape else {}
        return told | other | ({} if self.curve is None else {"curve": dict(self.curve)})


@dataclass(frozen=True)
class Step:
    """One line of the ledger: an effect that was tried.

    Attributes:
        name: name of the effect.
        accepted: whether it was added.
        reason: sentence on why it was added or refused.
        statistic: twice its log-likelihood ratio, less what its amplitudes and its scan cost.
        gap_before, gap_after: gaps of the models without and with it, V; None where it is not in the model.
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
            if above > CLOSED_MIN * self.before**2 and self.before > 0.0
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
        shape: numbers of the shape for which it holds, or the range of those that were looked at.
    """

    parameter: str
    unit: str
    value: float | None = None
    why: str = ""
    meaning: str = ""
    smaller_shows: bool = False
    shape: Mapping[str, Any] = field(default_factory=dict)

    def to_dict(self) -> dict[str, Any] | None:
        """The limit as an entry of the JSON result; None where there is none."""
        if self.value is None:
            return None
        told = {"parameter": self.parameter, "value": self.value, "unit": self.unit, "shape": dict(self.shape)}
        return told | ({"meaning": self.meaning} if self.meaning else {}) | {"smaller_shows": self.smaller_shows}
