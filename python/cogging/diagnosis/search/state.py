"""What a search was given, where it stands, and what it found."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field

from cogging.diagnosis.candidates.findings import Finding
from cogging.diagnosis.evidence.allowance import Allowance
from cogging.diagnosis.evidence.evidence import Evidence
from cogging.diagnosis.large.search import Large, LargeTerm
from cogging.diagnosis.residual.shape import Shape
from cogging.diagnosis.search.confirmation import Confirmation
from cogging.diagnosis.search.gaps import Yardstick
from cogging.effects.effect import Effect
from cogging.estimation.gauss_newton import Estimate
from cogging.estimation.innovations import Innovations
from cogging.logs.log import Log
from cogging.model.model import Model


@dataclass(frozen=True)
class Task:
    """What a search was given (see search)."""

    logs: Sequence[Log]
    model: Model
    confirm: Sequence[Log]
    progress: Callable[[str], None]
    replay: bool
    free_map: bool
    vocabulary: Mapping[str, Effect]


@dataclass
class Added:
    """An effect that was accepted, and what stood against it.

    Attributes:
        finding: the effect as the scan found it.
        rivals: it and what explains about as much, the likeliest first.
        shapes: residual shapes of what was missing before it, and its modulated look-alikes.
        confirmation: its test on other motion; None without.
        model: model refitted with it, with nuisances tuned to its gap.
        or_map: whether errors of the cogging map explain nearly as much.
        large: what the force balance said of it, of a large effect; None else.
    """

    finding: Finding
    rivals: list[Finding]
    shapes: list[Shape]
    confirmation: Confirmation | None
    model: Model
    or_map: bool = False
    large: LargeTerm | None = None


def turns_of(added: Sequence[Added]) -> list[float]:
    """Angle (rad) by which the other motion turns each of what was added; 0 of what is no wave."""
    return [0.0 if one.confirmation is None else one.confirmation.turn for one in added]


@dataclass(frozen=True)
class Scanned:
    """One scan of the evidence.

    Attributes:
        findings: best shape of each effect, best score first.
        faint: waves in the reading that rounding may have made.
        shapes: residual shapes.
        seen: evidence that the shapes were found in.
    """

    findings: list[Finding]
    faint: list[Finding]
    shapes: list[Shape]
    seen: Evidence


@dataclass(frozen=True)
class Choice:
    """The finding that is tried next.

    Attributes:
        finding: the effect.
        check: its test on other motion; None without.
        rivals: it and what explains about as much, the likeliest first.
    """

    finding: Finding
    check: Confirmation | None
    rivals: list[Finding]


@dataclass
class State:
    """Where a search stands.

    Attributes:
        task: logs, model and options.
        nominal: fit of the given model.
        nominal_evidence: its evidence.
        tuned_nominal: nominal model with nuisances tuned to its gap (with_nuisances_tuned).
        tuning_sources: logs to which nuisances are tuned.
        quick: whether rows soon after a quick start count (see fit_null).
        estimate: fit with all that was added.
        evidence: its evidence; once something stands out of it, with filters estimated without that.
        tuned: last model with nuisances tuned to its gap.
        yardstick: how gaps are measured.
        confirm_evidence: evidence of the confirm logs under the last model; None where they cannot be predicted.
        added: accepted effects in their order.
        refused: refused effects, each with the reason.
        unpaid: names of the refused that nothing speaks against but what became of the model.
        nominal_shapes: residual shapes, and events, of the nominal model.
        large: search for large effects; None where what the model leaves unexplained is small.
    """

    task: Task
    nominal: Estimate
    nominal_evidence: Evidence
    tuned_nominal: Model
    tuning_sources: list[Innovations]
    quick: bool
    estimate: Estimate
    evidence: Evidence
    tuned: Model
    yardstick: Yardstick
    confirm_evidence: Evidence | None = None
    added: list[Added] = field(default_factory=list)
    refused: list[tuple[Finding, str]] = field(default_factory=list)
    unpaid: set[str] = field(default_factory=set)
    nominal_shapes: list[Shape] = field(default_factory=list)
    large: Large | None = None

    @property
    def allowed(self) -> Allowance | None:
        """How far mass and friction may move; None: freely, to be tested afterwards."""
        return None if self.large is None else self.large.allowed

    @property
    def turns(self) -> list[float]:
        """Angle (rad) by which the other motion turns each of what was added; 0 of what is no wave."""
        return turns_of(self.added)


@dataclass
class Search:
    """All that was found on the way.

    Attributes:
        nominal: fit of the model as it was given.
        nominal_evidence: its evidence.
        tuned: nominal model with nuisances tuned to its gap (with_nuisances_tuned).
        estimate: fit with all that was added.
        evidence: its evidence.
        added: accepted effects in their order.
        refused: refused effects, each with the reason.
        nominal_shapes: residual shapes, and events, of the nominal model.
        residual_shapes: the same of the last model.
        unused: last scan, of which nothing was added.
        confirm_evidence: evidence of the confirm logs under the last model; None without.
        vocabulary: effects that were tried, by name.
        yardstick: how gaps are measured.
        large: search for large effects; None where what the model leaves unexplained is small.
    """

    nominal: Estimate
    nominal_evidence: Evidence
    tuned: Model
    estimate: Estimate
    evidence: Evidence
    added: list[Added]
    refused: list[tuple[Finding, str]]
    nominal_shapes: list[Shape]
    residual_shapes: list[Shape]
    unused: list[Finding]
    confirm_evidence: Evidence | None
    vocabulary: Mapping[str, Effect]
    yardstick: Yardstick
    large: Large | None = None
