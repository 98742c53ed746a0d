"""How far rivals would stand apart on a motion: noncentrality of the one beside the other and all that is re-tuned."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np

from cogging._core import DivergedError
from cogging.arrays import FloatArray
from cogging.diagnosis.candidates.findings import judged
from cogging.diagnosis.candidates.scan import begun, scan, sharpen
from cogging.diagnosis.candidates.signatures import Candidate
from cogging.diagnosis.evidence.evidence import Evidence
from cogging.diagnosis.evidence.null import nuisances
from cogging.diagnosis.experiment.expectation import Expectation
from cogging.diagnosis.experiment.observation import (
    as_residual,
    evidence_of,
    freed,
    gram_of,
    left_by,
    looked_for,
    louder,
)
from cogging.diagnosis.experiment.rivals import CHANGES, Found, with_others
from cogging.diagnosis.thresholds import EXPERIMENT
from cogging.effects.effect import Effect, Window, kind_of
from cogging.estimation.whitening import NothingCounts
from cogging.logs.log import Log
from cogging.model.model import Model


@dataclass(frozen=True)
class Separation:
    """An effect against each of its alternatives, refitted to the same motion.

    lambda = min over b and nuisances of |a - b|^2: a is the whitened residual that the effect leaves of a model without
    it, b what the alternative at its best shape and size, with all that a fit re-tunes, makes of that. 2 ln of the
    likelihood of the effect over that of the alternative has mean lambda and deviation 2 lambda^(1/2) where the effect
    is there; the two then stand lambda^(1/2) standard deviations apart (Atkinson and Fedorov 1975).

    Attributes:
        found: the effect.
        truth: model with all that was found.
        model: model without the effect.
        paths: what a fit of it re-tunes.
        laws: the alternatives by name that are effects; a change of the axis is re-tuned anyhow.
        rest: speed below which rows do not count, m/s.
        loudness: power of the noise over that of the model's.
        shapes: at which each alternative is looked for on every motion.
    """

    found: Found
    truth: Model
    model: Model
    paths: tuple[str, ...]
    laws: Mapping[str, Effect]
    rest: float
    loudness: float = 1.0
    shapes: Mapping[str, Sequence[Candidate]] | None = None

    @classmethod
    def of(
        cls, found: Sequence[Found], one: Found, model: Model, vocabulary: Mapping[str, Effect], rest: float
    ) -> Separation:
        """The question which of its names an effect has, beside all else that was found."""
        base = with_others(model, found, one)
        held = f"axis.{CHANGES[one.name]}" if one.name in CHANGES else ""
        paths = tuple(path for path in nuisances(base) if path != held)
        laws = {name: vocabulary[name] for name in one.alternatives if name not in CHANGES}
        return cls(one, one.added_to(base), base, paths, laws, rest)

    def looking(self, log: Log) -> Separation:
        """The same with the shapes of the alternatives that a survey of the travel gives."""
        model, truth = self._within(log)
        evidence, signal = evidence_of(log, model, self.paths, self.rest, truth)
        other = self.found.terms[0] if self.found.terms else None
        seen = as_residual(evidence, signal)
        shapes = {}
        for name, law in self.laws.items():
            best = [finding.candidate for finding in scan(seen, [law])[:1]]
            shapes[name] = [*looked_for(evidence, law, other), *(near for one in best for near in about(one))]
        return replace(self, shapes=shapes)

    def gram(self, log: Log) -> FloatArray | None:
        """Information of a log on the question, which adds up over logs; None where it holds none."""
        model, truth = self._within(log)
        try:
            evidence, signal = evidence_of(log, model, self.paths, self.rest, truth)
            wanted = [candidate for shapes in (self.shapes or {}).values() for candidate in shapes]
            return gram_of(evidence, signal, wanted) / self.loudness
        except (DivergedError, NothingCounts, ValueError):
            return None

    def utility(self, gram: FloatArray) -> float:
        """What a motion is worth: large where the worst pair stands far apart; from the sum of grams."""
        return pooled(list(self.squares(gram).values()), _enough())

    def squares(self, gram: FloatArray) -> dict[str, float]:
        """lambda of each pair by the alternative's name, over the shapes that were looked for."""
        total = sum(len(c.amplitudes) or 1 for shapes in (self.shapes or {}).values() for c in shapes)
        first = len(gram) - total
        left = freed(gram, range(1, first))
        result, place = {name: float(left[0, 0]) for name in self.found.alternatives}, first
        for name, shapes in (self.shapes or {}).items():
            for candidate in shapes:
                columns = range(place, place + (len(candidate.amplitudes) or 1))
                place = columns.stop
                if not candidate.amplitudes:
                    result[name] = min(result[name], _of_fixed_size(left[np.ix_([0, *columns], [0, *columns])]))
                    continue
                result[name] = min(
                    result[name],
                    float(freed(left[np.ix_([0, *columns], [0, *columns])], range(1, len(columns) + 1))[0, 0]),
                )
        return {name: self._known(max(value, 0.0)) for name, value in result.items()}

    def worth(self, log: Log, gram: FloatArray) -> float:
        """What a whole motion is worth, the shapes of the alternatives searched through on its log."""
        squares = self._searched(log)
        return pooled(list(squares.values()), _enough()) if squares else self.utility(gram)

    def expectations(self, log: Log) -> list[Expectation]:
        """How far each pair would stand apart on a log, the alternative's shape searched through."""
        squares = self._searched(log)
        told = {name: squares.get(name) for name in self.found.alternatives}
        return [
            Expectation(
                self.found.name,
                name,
                "",
                "sigma",
                None if square is None else round(float(np.sqrt(square)), 3),
                self.found.apart.get(name),
            )
            for name, square in told.items()
        ]

    def _searched(self, log: Log) -> dict[str, float]:
        """lambda of each pair by the alternative's name, by the scan that diagnose makes; empty where it cannot be."""
        model, truth = self._within(log)
        try:
            evidence, signal = evidence_of(log, model, self.paths, self.rest, truth)
            seen = as_residual(evidence, signal)
            own = self._own(seen, signal)
            return {name: self._square(seen, own, name) / self.loudness for name in self.found.alternatives}
        except (DivergedError, NothingCounts, ValueError):
            return {}

    def _own(self, seen: Evidence, signal: FloatArray) -> float:
        """T of the effect itself: as it is, or as a scan of this log alone finds it, whichever is less."""
        test = seen.test(signal[None, :])
        own = min(test.statistic, seen.bounded(test))
        if len(self.found.terms) == 1:
            findings = scan(seen, [self.found.terms[0]])
            own = min(own, max((finding.test.statistic for finding in findings), default=0.0))
        return own

    def _square(self, seen: Evidence, own: float, name: str) -> float:
        """lambda of a pair: of what the alternative at its best shape leaves, the level of each band's noise free."""
        if name not in self.laws:
            return self._known(max(own, 0.0))
        # A scan keeps to what the log alone can hold; beside other logs the alternative may have any of its shapes.
        known = judged(seen, list((self.shapes or {}).get(name, ())), 1.0)
        if known and not known[0].candidate.amplitudes:  # its size is as its shape says
            known = judged(seen, [begun(finding) for finding in known], 1.0, exact=True)
        best = sorted(known, key=lambda finding: -finding.score)[:1]
        findings = [*scan(seen, [self.laws[name]]), *(sharpen(seen, finding) for finding in best)]
        squares = [own, *(louder(seen, left_by(seen, finding)) for finding in findings)]
        # Among so many shapes, noise alone makes one of them as likely as this.
        squares += [own - 2.0 * float(np.log(max(finding.trials, 1.0))) for finding in findings]
        return self._known(max(min(squares), 0.0))

    def _known(self, square: float) -> float:
        """lambda of a change of the axis that is beyond what is stated: the statement explains some of it too."""
        if self.found.name not in CHANGES or square <= 0.0:
            return square
        stated = self.model.uncertainty.get(CHANGES[self.found.name], np.inf)
        return float(1.0 / (1.0 / square + (stated / self.found.change) ** 2)) if self.found.change else 0.0

    def _within(self, log: Log) -> tuple[Model, Model]:
        """The models with each disturbance inside the log's time."""
        end = float(log.time[-1] - log.time[0])
        return within(self.model, end), within(self.truth, end)


def within(model: Model, seconds: float) -> Model:
    """The model with each disturbance that would begin too late in a motion put into its middle."""
    effects = []
    for effect in model.effects:
        window = kind_of(effect, Window)
        if window is not None and getattr(effect, window.start) > EXPERIMENT.window_late * seconds:
            fields = {
                window.start: EXPERIMENT.window_moved[0] * seconds,
                window.stop: EXPERIMENT.window_moved[1] * seconds,
            }
            effect = effect.replace(**fields)
        elif window is not None:
            effect = effect.replace(**{window.stop: min(getattr(effect, window.stop), 0.95 * seconds)})
        effects.append(effect)
    return model.replace(effects=tuple(effects))


def about(candidate: Candidate) -> list[Candidate]:
    """A candidate, and itself at neighbouring values of each of its shapes that is a size."""
    found = [candidate]
    for field, value in candidate.shape.items():
        role = candidate.law.ROLES[field]
        if role["role"] == "shape" and isinstance(value, float) and (role["logarithmic"] or role["neutral"] == 0.0):
            found += [
                replace(candidate, shape={**candidate.shape, field: factor * value})
                for factor in EXPERIMENT.shapes_near
            ]
    return found


def _of_fixed_size(gram: FloatArray) -> float:
    """lambda of the signal beside a column of an effect that its shape alone makes, of nearly that size, (2, 2)."""
    signal, both, size = float(gram[0, 0]), float(gram[0, 1]), float(gram[1, 1])
    if size <= 0.0:
        return signal
    most = EXPERIMENT.shape_beside
    factor = float(np.clip(-both / size, 1.0 / most, most))  # what an effect adds takes from the residual
    return signal + 2.0 * factor * both + factor**2 * size


def _enough() -> float:
    """lambda, beyond which more is worth hardly anything."""
    return (EXPERIMENT.enough_apart * EXPERIMENT.told_apart) ** 2


def pooled(squares: Sequence[float], enough: float = np.inf) -> float:
    """One number for several noncentralities, to be made large: the weakest counts most, a hopeless one not alone.

    minus ln of the mean of 1 / (1 + lambda) + 1 / enough.
    """
    return -float(np.log(np.mean(1.0 / (1.0 + np.array(squares))) + 1.0 / enough)) if squares else 0.0
