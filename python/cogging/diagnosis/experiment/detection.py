"""The smallest size of each effect that a motion would show, whatever its shape."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from functools import lru_cache
from typing import Any

import numpy as np

from cogging._core import DivergedError
from cogging.arrays import FloatArray
from cogging.diagnosis.candidates.signatures import Candidate
from cogging.diagnosis.evidence.log_p_value import log_survival
from cogging.diagnosis.evidence.null import nuisances
from cogging.diagnosis.experiment.expectation import Expectation
from cogging.diagnosis.experiment.observation import evidence_of, freed, gram_of, looked_for
from cogging.diagnosis.experiment.separation import pooled
from cogging.diagnosis.thresholds import CHOICE, EXPERIMENT, LIMIT
from cogging.effects.effect import Effect
from cogging.estimation.whitening import NothingCounts
from cogging.logs.log import Log
from cogging.model.model import Model


@dataclass(frozen=True)
class Detection:
    """Detection limits: of each effect the smallest size that a scan would find with 95 % chance.

    An effect of noncentrality lambda is found where T, noncentral chi-square with p degrees of freedom and lambda,
    passes the threshold of a scan (CHOICE.detected, with the number of trials). lambda goes with the square of the
    size; the limit is the median over the shapes at which the effect is looked for.

    Attributes:
        model: model that is held against the motion, with all that was found.
        paths: what a fit of it re-tunes.
        laws: effects by name.
        rest: speed below which rows do not count, m/s.
        loudness: power of the noise over that of the model's.
        today: limits that a result states, by the effect's name.
        shapes: at which each effect is looked for on every motion.
    """

    model: Model
    paths: tuple[str, ...]
    laws: Mapping[str, Effect]
    rest: float
    loudness: float = 1.0
    today: Mapping[str, Any] | None = None
    shapes: Mapping[str, Sequence[Candidate]] | None = None

    @classmethod
    def of(cls, model: Model, vocabulary: Mapping[str, Effect], rest: float, today: Mapping[str, Any]) -> Detection:
        """The question how small an effect of the vocabulary may be."""
        return cls(model, tuple(nuisances(model)), vocabulary, rest, 1.0, today)

    @property
    def truth(self) -> Model:
        """What is simulated: nothing is hidden."""
        return self.model

    def looking(self, log: Log) -> Detection:
        """The same with the shapes that a survey of the travel gives; effects that have none there are left out."""
        evidence, _ = evidence_of(log, self.model, self.paths, self.rest, self.truth)
        shapes = {name: looked_for(evidence, law) for name, law in self.laws.items()}
        return replace(self, shapes={name: found for name, found in shapes.items() if found})

    def gram(self, log: Log) -> FloatArray | None:
        """Information of a log on the question, which adds up over logs; None where it holds none."""
        try:
            evidence, signal = evidence_of(log, self.model, self.paths, self.rest, self.truth)
            wanted = [candidate for shapes in (self.shapes or {}).values() for candidate in shapes]
            return gram_of(evidence, signal, wanted) / self.loudness
        except (DivergedError, NothingCounts, ValueError):
            return None

    def utility(self, gram: FloatArray) -> float:
        """What a motion is worth: large where the worst limit is small; from the sum of grams."""
        logarithms = {
            name: [np.log(max(float(np.trace(part)) / len(part), 1e-12)) for _, part in parts]
            for name, parts in self._parts(gram).items()
        }
        return pooled([float(np.exp(np.mean(values))) for values in logarithms.values()])

    def worth(self, log: Log, gram: FloatArray) -> float:
        """What a whole motion is worth."""
        return self.utility(gram)

    def expectations(self, log: Log) -> list[Expectation]:
        """The limits on a log, the worst first: those that cannot be seen."""
        gram = self.gram(log)
        return [] if gram is None else self.limits(gram)

    def limits(self, gram: FloatArray) -> list[Expectation]:
        """The limits by the information of a log, those that cannot be seen first."""
        found = [self._limit(name, parts) for name, parts in self._parts(gram).items()]
        return sorted(found, key=lambda one: (one.expected is not None, one.name))

    def _limit(self, name: str, parts: Sequence[tuple[Candidate, FloatArray]]) -> Expectation:
        """The limit of one effect from its shapes."""
        law = self.laws[name]
        field = next((f for f, role in law.ROLES.items() if role["role"] == "amplitude"), next(iter(law.FIELDS)))
        sizes = []
        for candidate, part in parts:
            squared = float(np.trace(part)) / len(part)
            sizes.append(_smallest(candidate, field, squared, needed(len(part))))
        told = np.array([size for size in sizes if size is not None])
        seen = 2 * len(told) > len(sizes)
        value = float(f"{np.median(told):.4g}") if seen else None
        before = (self.today or {}).get(name)
        today = before.get("value") if isinstance(before, Mapping) and before.get("parameter") == field else None
        return Expectation(name, "", field, law.FIELDS[field][0], value, today)

    def _parts(self, gram: FloatArray) -> dict[str, list[tuple[Candidate, FloatArray]]]:
        """What is left of each candidate's columns once the free parameters have taken theirs, by the effect's name."""
        shapes = self.shapes or {}
        total = sum(len(c.amplitudes) or 1 for found in shapes.values() for c in found)
        first = len(gram) - total
        left = freed(gram, range(1, first))
        parts: dict[str, list[tuple[Candidate, FloatArray]]] = {name: [] for name in shapes}
        for name, found in shapes.items():
            for candidate in found:
                last = first + (len(candidate.amplitudes) or 1)
                parts[name].append((candidate, left[first:last, first:last]))
                first = last
        return parts


@lru_cache(maxsize=64)
def needed(freedom: int) -> float:
    """Noncentrality with which an effect of so many amplitudes is found with 95 % chance among its trials."""
    from scipy.optimize import brentq
    from scipy.stats import ncx2

    def above(statistic: float) -> float:
        return log_survival(statistic, freedom) + float(np.log(EXPERIMENT.trials_typical)) - CHOICE.detected

    threshold = brentq(above, 1e-3, 1e3)
    return float(brentq(lambda square: ncx2.sf(threshold, freedom, square) - LIMIT.chance_shown, 1e-3, 1e3))


def _smallest(candidate: Candidate, field: str, squared: float, square: float) -> float | None:
    """The size of an effect at which its noncentrality is `square`; None where no size in its range has it.

    Args:
        candidate: effect at one shape.
        field: whose size is told.
        squared: noncentrality of a unit amplitude, or of the effect as its shape makes it.
        square: that is needed.
    """
    role = candidate.law.ROLES[field]
    if squared <= EXPERIMENT.signal_none:
        return None
    factor = float(np.sqrt(square / squared))
    if candidate.amplitudes:
        return factor
    value = float(candidate.shape[field])
    if role["neutral"] == 0.0:
        return value * factor if factor < EXPERIMENT.size_beyond else None
    # One that vanishes as its field grows is told by the largest value that is still seen: roughly in proportion.
    return value / factor if np.isfinite(value) and factor < EXPERIMENT.size_beyond else None
