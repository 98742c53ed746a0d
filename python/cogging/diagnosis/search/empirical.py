"""What no effect explains, as a force of any shape: added where it is asked for, and called empirical."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np

from cogging._core import DivergedError
from cogging.diagnosis.discrepancy import source_of
from cogging.diagnosis.search.state import Search, turns_of
from cogging.diagnosis.search.tuning import with_nuisances_tuned
from cogging.effects.effect import empirical_law
from cogging.logs.log import Log
from cogging.model.model import Model
from cogging.model.parameters import effect_paths, parameters_of


class NoTerm(ValueError):
    """Why nothing was added."""


def with_term(
    found: Search, residual_shape: Mapping[str, Any], model: Model, logs: Sequence[Log]
) -> tuple[Model, dict[str, Any]]:
    """The model with a force at the nodes of the residual shape, refitted, and what it makes of the gap.

    Args:
        found: the search.
        residual_shape: entry of what no effect explains (verdict.unlisted).
        model: model with all that was named.
        logs: given logs.

    Raises:
        NoTerm: no term has this coordinate, or it does not pay on the other motion.
    """
    coordinate = str(residual_shape["coordinate"])
    law, knots = empirical_law(coordinate)
    if law is None or knots is None:
        raise NoTerm(f"no empirical term is a function of {coordinate}: it is described, not added")
    if "places" not in residual_shape:
        raise NoTerm("no empirical term stands for what has no places: it is described, not added")
    places = np.asarray(residual_shape["places"], dtype=float)
    shape = np.asarray(residual_shape["force"], dtype=float)
    if len(shape) == 2 * len(places):  # told apart by direction, of which the term knows nothing
        shape = shape.reshape(2, -1).mean(axis=0)
    term = law.replace(**{knots.nodes: places.tolist(), knots.levels: np.nan_to_num(shape).tolist()})
    larger = model.replace(effects=(*model.effects, term))
    prefix = effect_paths(larger.effects)[-1][0]
    own = [path for path in parameters_of(larger) if path.startswith(f"{prefix}.{knots.levels}[")]
    try:
        tuned = with_nuisances_tuned(
            larger, [*found.nominal.paths, *own], [source_of(log, found.nominal.model) for log in logs]
        )
        measured = found.yardstick.measure([model, tuned], [*turns_of(found.added), 0.0])
    except (DivergedError, ValueError) as error:
        raise NoTerm(f"the model with an empirical term cannot be fitted: {error}") from None
    if why := measured.objection():
        raise NoTerm(f"an empirical term does not pay: {why}")
    before, after = (gap.rms for gap in measured.given)
    elsewhere = [gap.rms for gap in measured.confirm] if measured.confirm else [None, None]
    told = {"name": law.NAME, "signal": measured.given[0].signal, "gap_before": before, "gap_after": after}
    return tuned, told | {"confirm_before": elsewhere[0], "confirm_after": elsewhere[1]}
