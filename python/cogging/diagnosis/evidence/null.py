"""The null: the model as it stands, re-tuned as far as its statement allows."""

from __future__ import annotations

from collections.abc import Sequence
from functools import partial

import numpy as np

from cogging._core import DivergedError, whiten
from cogging.diagnosis.evidence.allowance import Allowance
from cogging.diagnosis.evidence.evidence import Evidence
from cogging.diagnosis.evidence.gather import gather
from cogging.diagnosis.evidence.noise_filter import robust_rms
from cogging.diagnosis.physical import physical_ceilings
from cogging.diagnosis.thresholds import NULL, OBSERVER, WHITENING
from cogging.estimation.gauss_newton import Estimate, fit
from cogging.estimation.innovations import Innovations
from cogging.estimation.statistics import moving_average
from cogging.estimation.whitening import whitening_filter
from cogging.logs.log import Log
from cogging.model.model import Model
from cogging.model.parameters import parameters_of, role_of


def sources_of(
    logs: Sequence[Log], model: Model, *, rest: float | None = None, quick: bool = False
) -> list[Innovations]:
    """The logs as this model predicts them; `quick` with rows soon after each quick start."""
    limit = OBSERVER.quick_bandwidth if quick else OBSERVER.calm_bandwidth
    return [
        Innovations(
            log,
            model,
            bandwidth=min(limit, OBSERVER.bandwidth_of_rate / _sample_time(log)),
            rest=rest,
            quick_starts=quick,
        )
        for log in logs
    ]


def _sample_time(log: Log) -> float:
    """The mean step, s, of those that are no gap."""
    steps = np.diff(log.time)
    long = steps > NULL.time_gap * float(np.median(steps))
    return float(steps[~long].mean()) if long.any() else float((log.time[-1] - log.time[0]) / (len(log) - 1))


def nuisances(model: Model) -> list[str]:
    """Paths that a fit may re-tune without that being a missing effect: axis, and amplitudes of the known cogging.

    Fields of the effects that the model already has are re-tuned too.
    """
    paths = []
    # Along the travel a known harmonic may be wrong in size and phase; that its amplitude changes otherwise is an
    # effect, or an error of its map (see map_errors).
    whole = model.cogging is not None and model.cogging.sine.shape[1] > 1
    for path, parameter in parameters_of(model, together=whole).items():
        if whole and path.startswith("cogging.") and not path.startswith(("cogging.gain", "cogging.phase")):
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

    Real sticking is no missing effect, and a model's width of friction is a convention. Rows soon after a start count
    where the model that is tuned without them foresees them as well as the others: a machine whose friction gives way
    over some micrometres, or has more than one, shows that there.
    """
    forms = [model]
    if model.axis.coulomb > 0.0 and not stated_exact(model):
        other = 0.0 if model.axis.coulomb_width > 0.0 else NULL.other_width * max(_speed(log) for log in logs)
        forms.append(model.replace(axis=model.axis.replace(coulomb_width=other)))
    # Both are judged on the same rows.
    seen = [sources_of(logs, form) for form in forms]
    rest = max(source.rest for sources in seen for source in sources)
    best: tuple[Estimate, list[Innovations]] | None = None
    failure: Exception | None = None
    for form, own in zip(forms, seen, strict=True):
        try:
            sources = [source.with_rest(rest) for source in own]
            floors, ceilings = limits_of(sources)
            fitted = partial(fit, form, nuisances(form), sources, floors=floors, ceilings=ceilings)
            if best is not None and fitted(iterations=NULL.first_iterations).cost > best[0].cost + NULL.hopeless:
                continue
            estimate = fitted()
        except (DivergedError, ValueError) as error:
            failure = error
            continue
        if best is None or estimate.cost < best[0].cost - NULL.form_gain:
            best = (estimate, sources)
    if best is None:
        raise failure or ValueError("logs: could not be predicted")
    estimate, calm = best
    quick = sources_of(logs, estimate.model, rest=rest, quick=True)
    if starts_fit(estimate.model, calm, quick):
        try:
            floors, ceilings = limits_of(quick)
            again = fit(estimate.model, estimate.paths, quick, floors=floors, ceilings=ceilings)
            return again, gather(again, quick)
        except DivergedError:
            pass
    return estimate, gather(estimate, calm)


def starts_fit(model: Model, calm: Sequence[Innovations], quick: Sequence[Innovations]) -> bool:
    """Whether rows that only `quick` counts are foreseen with about the precision of the others."""
    soon, others = [], []
    for slow, fast in zip(calm, quick, strict=True):
        residual = fast.of([model])[0]
        white = np.asarray(whiten(residual[None, :], list(whitening_filter(slow, residual))))[0]
        rows, late = fast.mask > 0, slow.mask > 0
        limit = WHITENING.outlier * robust_rms(white[rows & late])
        soon.append(np.minimum(white[rows & ~late] ** 2, limit**2))
        others.append(np.minimum(white[rows & late] ** 2, limit**2))
    extra, usual = np.concatenate(soon), np.concatenate(others)
    if len(extra) == 0 or len(usual) == 0:
        return False
    return float(usual.mean()) / NULL.starts_power < float(extra.mean()) < NULL.starts_power * float(usual.mean())


def limits_of(
    sources: Sequence[Innovations], allowed: Allowance | None = None
) -> tuple[dict[str, float], dict[str, float]]:
    """Floors and ceilings of a fit by path: of nuisances as far as they are `allowed`, or else as they are physical.

    A width of friction far below the slowest rows that count is an axis that sticks: that form stands beside.
    """
    floors = {"axis.coulomb_width": NULL.width_of_rest * min(source.rest for source in sources)}
    if allowed is None:
        return floors, physical_ceilings([source.log for source in sources])
    return floors | dict(allowed.floors), dict(allowed.ceilings)


def _speed(log: Log) -> float:
    window = max(1, round(NULL.speed_window / _sample_time(log)))
    return float(np.abs(np.gradient(moving_average(log.position, window), log.time)).max())
