"""What a map of the cogging may be wrong by beside the size and phase of its harmonics.

Re-tuning, where it explains as much as any effect.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from cogging._core import DivergedError
from cogging.arrays import FloatArray
from cogging.diagnosis.evidence.evidence import Evidence
from cogging.diagnosis.evidence.gather import gather, refiltered
from cogging.diagnosis.evidence.log_p_value import log_survival
from cogging.diagnosis.evidence.null import limits_of
from cogging.diagnosis.evidence.score_test import ScoreTest
from cogging.diagnosis.thresholds import MAP_ERROR
from cogging.estimation.gauss_newton import Estimate, columns_of, fit
from cogging.linear import least_squares_of_long_rows
from cogging.model.model import Model
from cogging.model.parameters import parameters_of


@dataclass(frozen=True)
class MapError:
    """What errors of the map, of a size that maps have, explain of the evidence.

    Attributes:
        statistic: T, twice the ln likelihood that the likeliest error of the map gains.
        score: the same for all errors of that size together: 2 ln of their mean likelihood.
    """

    statistic: float
    score: float

    def rivals(self, score: float, margin: float) -> bool:
        """Whether an error of the map explains as much as an effect of this score, to within a margin of the score."""
        return self.score > score - margin


def error_paths(model: Model) -> dict[str, float]:
    """Paths of a constant error of each harmonic, and of its sines and cosines scaled each by itself; with 1-sigma.

    Empty where the amplitude of a harmonic does not change along the travel: there size and phase say all.
    """
    if model.cogging is None or model.cogging.sine.shape[1] == 1:
        return {}
    deviations: dict[str, float] = {}
    for row, (sine, cosine) in enumerate(zip(model.cogging.sine, model.cogging.cosine, strict=True)):
        size = MAP_ERROR.error_size * float(np.sqrt(np.mean(sine**2 + cosine**2)))
        deviations |= {f"cogging.{part}[{row}][*]": size for part in ("sine", "cosine") if size > 0.0}
        deviations |= {f"cogging.{part}[{row}]": MAP_ERROR.error_size for part in ("stretch", "shear") if size > 0.0}
    return deviations


def map_error(estimate: Estimate, evidence: Evidence) -> MapError | None:
    """What errors of the map explain, against the noise that they would leave; None where none is seen."""
    paths = error_paths(estimate.model)
    if not paths:
        return None
    known = parameters_of(estimate.model, together=True)
    _, columns = columns_of(estimate.model, [known[path] for path in paths], evidence.sources, evidence.scales)
    deviations = np.array(list(paths.values()))[:, None]
    columns = [table * deviations for table in columns]
    test, spread = likeliest(evidence, columns)
    explained = [test.amplitudes @ table for table in columns]
    quiet = refiltered(evidence, beyond_tuning(evidence, explained))
    test, spread = max((test, spread), likeliest(quiet, columns), key=lambda one: one[0].statistic)
    if not log_survival(test.statistic, test.freedom) < MAP_ERROR.error_seen:
        return None
    return MapError(test.statistic, test.statistic - spread)


def beyond_tuning(evidence: Evidence, explained: list[FloatArray]) -> list[FloatArray]:
    """What is explained (V, one (n,) a log) less what re-tuning could: errors of a map are largely its size."""
    weights = least_squares_of_long_rows(evidence.columns, evidence.whitened([row[None, :] for row in explained])[0])
    return [row - weights @ part.columns for row, part in zip(explained, evidence.parts, strict=True)]


def likeliest(evidence: Evidence, columns: list[FloatArray]) -> tuple[ScoreTest, float]:
    """The likeliest of errors of 1-sigma 1, and ln det (I + curvature), which their mean likelihood is smaller by."""
    free = evidence.project(evidence.whitened(columns))
    curvature = np.eye(len(free)) + free @ free.T / evidence.overdispersion
    amplitudes = np.asarray(
        np.linalg.solve(curvature, free @ evidence.free_residual / evidence.overdispersion), np.float64
    )
    statistic = float(amplitudes @ curvature @ amplitudes)
    test = ScoreTest(statistic, len(free), amplitudes, amplitudes @ free, np.full(len(free), np.inf))
    test = replace(test, statistic=min(statistic, evidence.bounded(test)))
    return test, float(np.linalg.slogdet(curvature)[1])


def freed(estimate: Estimate, evidence: Evidence) -> tuple[Estimate, Evidence]:
    """The fit with errors of the map free, and its evidence; as it was where that cannot be fitted."""
    paths = [*estimate.paths, *error_paths(estimate.model)]
    try:
        floors, ceilings = limits_of(evidence.sources)
        again = fit(estimate.model, paths, evidence.sources, floors=floors, ceilings=ceilings)
    except (DivergedError, ValueError):
        return estimate, evidence
    return again, gather(again, evidence.sources, memory=evidence.memory)
