"""The null: the model as it stands, re-tuned as far as its statement allows."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from cogging._core import DivergedError
from cogging.diagnose.evidence import Evidence, gather
from cogging.estimation import Estimate, fit
from cogging.logs import Log
from cogging.model import Model
from cogging.parameters import parameters_of, role_of
from cogging.residuals import Innovations, moving_average

BANDWIDTH = 50.0  # Hz, of the observer: above the motion, below what a coarse encoder makes noisy


def sources_of(logs: Sequence[Log], model: Model, *, rest: float | None = None) -> list[Innovations]:
    """The logs as this model predicts them."""
    return [Innovations(log, model, bandwidth=min(BANDWIDTH, 0.05 / _sample_time(log)), rest=rest) for log in logs]


def _sample_time(log: Log) -> float:
    return float((log.time[-1] - log.time[0]) / (len(log) - 1))


def nuisances(model: Model) -> list[str]:
    """Paths that a fit may re-tune without that being a missing effect: axis, and amplitudes of the known cogging.

    Fields of the effects that the model already has are re-tuned too.
    """
    paths = []
    # Along the travel a known harmonic may be wrong as a whole; that its amplitude changes otherwise is an effect.
    points = 1 if model.cogging is None else model.cogging.sine.shape[1]
    for path, parameter in parameters_of(model, together=points > 1).items():
        if points > 1 and path.startswith("cogging.") and path.count("[") == 2 and "*" not in path:
            continue
        if path == "axis.coulomb_width" and (model.axis.coulomb_width == 0.0 or stated_exact(model)):
            continue
        if parameter.value in (float("inf"), -float("inf")):
            continue
        if path.startswith("effects.") and role_of(model, path) != "amplitude":
            continue
        paths.append(path)
    return paths


def stated_exact(model: Model) -> bool:
    """Whether the model says that its friction width is exact."""
    return model.uncertainty.get("coulomb_width", None) == 0.0


def fit_null(logs: Sequence[Log], model: Model) -> tuple[Estimate, Evidence]:
    """Re-tune the model on the logs: with its smooth friction, and as an axis that sticks; the likelier stands.

    Real sticking is no missing effect, and a model's width of friction is a convention.
    """
    forms = [model]
    if model.axis.coulomb > 0.0 and not stated_exact(model):
        other = 0.0 if model.axis.coulomb_width > 0.0 else 0.005 * max(_speed(log) for log in logs)
        forms.append(model.replace(axis=model.axis.replace(coulomb_width=other)))
    # Both are judged on the same rows.
    rest = max(source.rest for form in forms for source in sources_of(logs, form))
    best: tuple[Estimate, list[Innovations]] | None = None
    failure: Exception | None = None
    for form in forms:
        try:
            sources = sources_of(logs, form, rest=rest)
            estimate = fit(form, nuisances(form), sources, floors=width_floor(sources))
        except (DivergedError, ValueError) as error:
            failure = error
            continue
        if best is None or estimate.cost < best[0].cost - 5.0:
            best = (estimate, sources)
    if best is None:
        raise failure or ValueError("logs: could not be predicted")
    return best[0], gather(best[0], best[1])


def width_floor(sources: Sequence[Innovations]) -> dict[str, float]:
    """A width of friction far below the slowest rows that count is an axis that sticks: that form stands beside."""
    return {"axis.coulomb_width": 0.2 * min(source.rest for source in sources)}


def _speed(log: Log) -> float:
    window = max(1, round(0.01 / _sample_time(log)))
    return float(np.abs(np.gradient(moving_average(log.position, window), log.time)).max())
