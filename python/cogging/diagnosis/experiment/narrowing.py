"""How narrow the intervals of a fit would become on a motion."""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import cache

import numpy as np

from cogging._core import DivergedError
from cogging.arrays import FloatArray
from cogging.diagnosis.candidates.movable import effect_parameters
from cogging.diagnosis.evidence.null import nuisances
from cogging.diagnosis.experiment.expectation import Expectation
from cogging.diagnosis.experiment.observation import evidence_of, gram_of
from cogging.diagnosis.thresholds import EXPERIMENT, WHITENING
from cogging.estimation.statistics import student
from cogging.estimation.whitening import NothingCounts
from cogging.logs.log import Log
from cogging.model.model import Model
from cogging.model.parameters import Scales, parameters_of

SLOW_SHAPES = len(WHITENING.friction_decays) + len(WHITENING.friction_tails)  # slow friction, which a fit has not


@cache
def quantile() -> float:
    """Half of a 95 % interval in standard deviations."""
    return student(EXPERIMENT.interval_rows)


@dataclass(frozen=True)
class Narrowing:
    """Intervals of a fit: D-optimal, the volume of the ellipsoid of all parameters together (Fedorov 1972).

    Information adds up: that of the motion, F = X X' / phi, to that of the intervals which the model states.

    Attributes:
        model: model that is fitted.
        paths: its free parameters.
        prior: information that is there before the motion, (p, p), from the model's intervals.
        rest: speed below which rows do not count, m/s.
        loudness: power of the noise over that of the model's.
    """

    model: Model
    paths: tuple[str, ...]
    prior: FloatArray
    rest: float
    loudness: float = 1.0

    @classmethod
    def of(cls, model: Model, rest: float) -> Narrowing:
        """The question how well a fit of the model would determine it."""
        paths = dict.fromkeys([*nuisances(model), *effect_parameters(model)])
        return cls(model, tuple(paths), np.zeros((len(paths), len(paths))), rest)

    @property
    def truth(self) -> Model:
        """What is simulated."""
        return self.model

    def looking(self, log: Log) -> Narrowing:
        """The same with what is known before the motion, in the sizes of a survey."""
        evidence, _ = evidence_of(log, self.model, self.paths, self.rest, self.truth)
        return replace(self, prior=np.diag([self._known(path, evidence.scales) for path in self.paths]))

    def gram(self, log: Log) -> FloatArray | None:
        """Information of a log on the parameters, which adds up over logs; None where it holds none."""
        try:
            evidence, signal = evidence_of(log, self.model, self.paths, self.rest, self.truth)
        except (DivergedError, NothingCounts, ValueError):
            return None
        gram = gram_of(evidence, signal, [])
        return np.asarray(gram[1 : len(gram) - SLOW_SHAPES, 1 : len(gram) - SLOW_SHAPES] / self.loudness)

    def utility(self, gram: FloatArray) -> float:
        """ln det of the information over that which is there before, a parameter; from the sum of grams."""
        size = np.sqrt(np.diag(self.prior))
        _, logarithm = np.linalg.slogdet((gram + self.prior) / np.outer(size, size))
        return float(logarithm) / max(len(gram), 1)

    def worth(self, log: Log, gram: FloatArray) -> float:
        """What a whole motion is worth."""
        return self.utility(gram)

    def expectations(self, log: Log) -> list[Expectation]:
        """Half of each 95 % interval on a log and what is known before it, those that gain least first."""
        gram = self.gram(log)
        if gram is None:
            return []
        size = np.sqrt(np.diag(self.prior))
        inverse = np.linalg.inv((gram + self.prior) / np.outer(size, size))
        halves = quantile() * np.sqrt(np.maximum(np.diag(inverse), 0.0)) / size
        known = parameters_of(self.model, together=True)
        entries = []
        for path, half, before in zip(self.paths, halves, quantile() / size, strict=True):
            stated = path in self.model.intervals and np.isfinite(self.model.intervals[path]).all()
            told = stated or half < EXPERIMENT.determined * before
            entries.append(
                Expectation(
                    path,
                    "",
                    "",
                    known[path].dimension,
                    float(f"{half:.4g}") if told else None,
                    float(f"{before:.4g}") if stated else None,
                )
            )
        return entries

    def _known(self, path: str, scales: Scales) -> float:
        """Information on a parameter before the motion: of its 95 % interval, else next to none."""
        low, high = self.model.intervals.get(path, (-np.inf, np.inf))
        if np.isfinite([low, high]).all() and high > low:
            return float((0.5 * (high - low) / quantile()) ** -2)
        parameter = parameters_of(self.model, together=True)[path]
        return float((EXPERIMENT.vague * (abs(parameter.value) or scales.of(parameter.dimension))) ** -2)
