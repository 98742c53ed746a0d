"""Whether an effect pays: with it, no gap may grow, neither here nor on other motion."""

from __future__ import annotations

from collections.abc import Sequence

from cogging.diagnosis.discrepancy import discrepancies
from cogging.diagnosis.search.confirmation import as_there
from cogging.diagnosis.thresholds import ACCEPTANCE
from cogging.logs.log import Log
from cogging.model.model import Model
from cogging.model.parameters import parameters_of, with_values


def with_nuisances_of(before: Model, model: Model, paths: Sequence[str]) -> Model:
    """A model with the nuisances that it had before something was added."""
    known = parameters_of(before, together=True)
    return with_values(model, {path: known[path].value for path in paths if not path.startswith("effects.")})


def that_pays(
    logs: Sequence[Log],
    confirm: Sequence[Log],
    before: Model,
    tuned: Model,
    kept: Model,
    turns: Sequence[float] = (),
    replay: bool = False,
) -> tuple[Model | None, str]:
    """The model with which no gap grows, here or on the confirm logs: its nuisances re-tuned, or as they were before.

    Nuisances that are tuned with an effect follow what is particular to the logs they are tuned on; the effect itself
    may then pay where it is added alone. None, and why, where it does not pay either way. The gap is that of the
    replayed loop where it is asked for (`replay`) and can be had; waves that were added lie on the other motion where
    it shows them, turned by `turns` (rad, one an added effect, the last of the one in question).
    """
    there = [as_there(before, turns[:-1]), as_there(tuned, turns), as_there(kept, turns)]
    own = [seen.rms for seen in discrepancies(logs, [before, tuned, kept], replay=replay)]
    other = [seen.rms for seen in discrepancies(confirm, there, replay=replay)] if confirm else [0.0, 0.0, 0.0]
    for model, here, elsewhere, limit in zip(
        (tuned, kept), own[1:], other[1:], (ACCEPTANCE.gap_growth, 1.0), strict=True
    ):
        if here <= ACCEPTANCE.gap_growth * own[0] and elsewhere <= limit * other[0]:
            return model, ""
    what, grown = ("gap", own) if other[1] <= ACCEPTANCE.gap_growth * other[0] else ("gap on the other motion", other)
    return None, f"the {what} grows from {grown[0]:.4g} to {grown[1]:.4g} V with it"
