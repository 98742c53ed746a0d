"""Mass, friction and amplitudes tuned to the gap itself: every frequency weighs as it does in the gap."""

from __future__ import annotations

from collections.abc import Callable, Sequence

import numpy as np

from cogging._core import DivergedError
from cogging.diagnosis.candidates.findings import Finding
from cogging.diagnosis.candidates.movable import effect_parameters
from cogging.diagnosis.evidence.allowance import Allowance
from cogging.diagnosis.evidence.null import limits_of
from cogging.diagnosis.thresholds import ACCEPTANCE, REFIT
from cogging.estimation.gauss_newton import Estimate, columns_of, fit
from cogging.estimation.innovations import Innovations
from cogging.linear import least_squares_of_long_rows
from cogging.model.model import Model
from cogging.model.parameters import Scales, parameters_of, paths_in, role_of, with_values

Gap = Callable[[Model], float]
Tune = Callable[[Model], Model]


def tuned_together(
    before: Model,
    fitted: Estimate,
    finding: Finding,
    gap: Gap,
    nuisances: Tune,
    everything: Tune,
    logs: Sequence[Innovations],
) -> tuple[Estimate, Model]:
    """A fit with an effect in it, and its model tuned to the gap, which is not larger than without the effect.

    A fit of whitened residuals takes little account of what is slow, and moves what was found before: the gap may grow
    by it. Then all is tuned to the gap together, from the model before on, with nothing yet of an effect that has
    amplitudes: no step of least squares from there makes the gap larger.

    Args:
        before: tuned model without the effect.
        fitted: fit with it.
        finding: the effect.
        gap: size of a model's gap; a growth of its power within ACCEPTANCE.power_growth is none.
        nuisances, everything: tunes to that gap what is no missing effect, or amplitudes too; never to a larger one.
        logs: that the fit was of.
    """
    tuned = nuisances(fitted.model)
    if gap(tuned) ** 2 <= (1.0 + ACCEPTANCE.power_growth) * gap(before) ** 2:
        return fitted, tuned
    candidate = finding.candidate
    tuned = everything(before.replace(effects=(*before.effects, candidate.effect([0.0] * len(candidate.amplitudes)))))
    return fit(tuned, fitted.paths, logs, iterations=0), tuned


def amplitude_paths(model: Model) -> list[str]:
    """Paths of the amplitudes of all effects."""
    return [path for path in effect_parameters(model) if role_of(model, path) == "amplitude"]


def gap_size(model: Model, sources: Sequence[Innovations]) -> float:
    """Root of the sum of the squared innovations in rows that count, V."""
    return float(np.sqrt(sum(float(np.sum(s.of([model])[0, s.mask > 0] ** 2)) for s in sources)))


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

    best = gap_size(model, sources)
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
                after = gap_size(moved, sources)
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
