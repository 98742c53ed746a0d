"""Mass, friction and known amplitudes tuned to the gap itself: every frequency weighs as it does in the gap."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from cogging._core import DivergedError
from cogging.diagnosis.evidence.allowance import Allowance
from cogging.diagnosis.evidence.null import limits_of
from cogging.diagnosis.thresholds import REFIT
from cogging.estimation.gauss_newton import columns_of
from cogging.estimation.innovations import Innovations
from cogging.linear import least_squares_of_long_rows
from cogging.model.model import Model
from cogging.model.parameters import Scales, parameters_of, paths_in, with_values


def with_nuisances_tuned(
    model: Model, paths: Sequence[str], sources: Sequence[Innovations], allowed: Allowance | None = None
) -> Model:
    """The model after least squares of the innovations over `paths`, effects that were found as they are.

    Mass and friction move as far as they are `allowed` to; None: freely, to be tested afterwards.

    A fit of whitened residuals weighs high frequencies, where the noise is low: what is slightly wrong there bends the
    nuisances, and the gap with them. Models are compared by their gaps, each with nuisances that make its own smallest.
    """
    paths = paths_in(model, paths)
    scales = Scales.largest(source.scales for source in sources)
    floors, ceilings = limits_of(sources, allowed)
    masks = [source.mask > 0 for source in sources]
    if not paths or not any(rows.any() for rows in masks):
        return model

    def gap(one: Model) -> float:
        return sum(float(np.sum(s.of([one])[0, rows] ** 2)) for s, rows in zip(sources, masks, strict=True))

    best = gap(model)
    for _ in range(REFIT.tuning_iterations):
        known = parameters_of(model, together=True)
        parameters = [known[path] for path in paths]
        residuals, columns = columns_of(model, parameters, sources, scales)
        right = np.concatenate([r[rows] for r, rows in zip(residuals, masks, strict=True)])
        table = np.concatenate([c[:, rows] for c, rows in zip(columns, masks, strict=True)], axis=1)
        step = -least_squares_of_long_rows(table, right)
        for halving in range(REFIT.tuning_halvings):
            values = {
                p.path: min(
                    max(p.clipped(p.value + 0.5**halving * s), floors.get(p.path, -np.inf)),
                    ceilings.get(p.path, np.inf),
                )
                for p, s in zip(parameters, step, strict=True)
            }
            try:
                moved = with_values(model, values)
                after = gap(moved)
            except (DivergedError, ValueError):
                continue
            if after < best:
                break
        else:
            return model
        gained, best, model = best - after, after, moved
        if gained < REFIT.tuning_gain * best:
            break
    return model
