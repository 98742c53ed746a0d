"""What a motion is worth for each goal, and what is to be expected of it."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import Any, NamedTuple

import numpy as np

from cogging.arrays import FloatArray
from cogging.design.experiment.look import CHANGES, Look, Machine, Run, Shape, shapes
from cogging.diagnosis.balance.decision import BLOCK, THRESHOLD, score_of
from cogging.diagnosis.balance.evidence import orthonormal
from cogging.effects.effect import Effect
from cogging.model.model import Model
from cogging.model.parameters import parameters_of

COPIES = 1000  # of rivals along a motion, from which a frequency is read
HOPELESS = 0.6  # frequency of being right below which a motion does not tell rivals apart
LOUD = 100.0  # noncentrality of an effect whose size a result does not tell
TRIALS = 20  # independent shapes of an effect, among which it must stand out
CHANCE = 0.95  # of being seen, of a detection limit
FAR = 4.0  # of the logarithm of a detection limit: farther from that of the survey counts no more
BEYOND = 100.0  # small amplitudes, a hundredth of the machine's force each: what is seen from there on is not seen
HALF = 1.96  # deviations: half of a 95 % interval


@dataclass(frozen=True)
class Expectation:
    """What is expected of one thing that a plan is for.

    Attributes:
        name: of the effect; of a fit, the path of the parameter.
        alternative: the other name that it is held against; empty where there is none.
        parameter: field whose smallest visible size is told; empty where there is none.
        unit: of the numbers.
        expected: of rivals, how often the right one is the likelier in simulated copies of the motion; the smallest
            size that would be seen with 95 % chance; or half of a 95 % interval. None: the motion cannot tell.
        today: the same of what is known before the motion; None where that is not known.
    """

    name: str
    alternative: str
    parameter: str
    unit: str
    expected: float | None
    today: float | None = None

    def text(self) -> str:
        """One line."""
        unit = f" {self.unit}" if self.unit != "1" else ""
        today = "" if self.today is None else f"; today {self.today:.2g}{unit}"
        if self.alternative:
            often = f"the right one is the likelier in {100 * (self.expected or 0.0):.0f} % of simulated runs"
            none = ": no motion that was tried tells them apart" if (self.expected or 0.0) < HOPELESS else ""
            return f"{self.name} or {self.alternative}: {often}{none}"
        if self.expected is None:
            return f"{self.name}: {'cannot be seen in' if self.parameter else 'not determined by'} this motion{today}"
        if self.parameter:
            return f"{self.name}: {self.parameter} of {self.expected:.3g}{unit} would be seen{today}"
        return f"{self.name}: to +- {self.expected:.3g}{unit}{today}"


class Found(NamedTuple):
    """An effect of a result (None for a change of the axis), the size of a change, and its alternatives."""

    name: str
    effect: Effect | None
    change: float
    alternatives: tuple[str, ...]

    def added_to(self, model: Model) -> Model:
        """The model with it."""
        if self.effect is not None:
            return model.replace(effects=(*model.effects, self.effect))
        field = CHANGES[self.name]
        return model.replace(axis=model.axis.replace(**{field: getattr(model.axis, field) * (1.0 + self.change)}))


class Goal(NamedTuple):
    """What a run is worth, and what is to be expected of it."""

    worth: Callable[[Run], float]
    expectations: Callable[[Run], list[Expectation]]


class Pair(NamedTuple):
    """Columns of two rivals at their shapes and of all other names, what each rival does (m,), and blocks of motion."""

    name: str
    alternative: str
    first: list[FloatArray]
    second: list[FloatArray]
    rest: list[FloatArray]
    signals: tuple[FloatArray, FloatArray]
    blocks: int


def separate(machine: Machine, model: Model, found: Sequence[Found], laws: Mapping[str, Effect], survey: Run) -> Goal:
    """Effects against their alternatives: noncentrality of the one beside the other refitted, either way round.

    lambda = min over shapes and sizes of b, and over what is re-tuned, of |a - b|^2, whitened: 2 ln of the likelihood
    of the right one over the other has the mean lambda (Atkinson and Fedorov 1975). The other one is taken to look
    as much alike as it can on the survey, and to be as loud there.
    """
    alike: dict[tuple[str, str], tuple[FloatArray, int, FloatArray]] = {}

    def pairs(run: Run) -> Iterator[Pair]:
        for one in (one for one in found if one.alternatives):
            given = whole = one.added_to(model)
            for other in found:
                whole = whole if other is one else other.added_to(whole)
            look = Look(machine, run, given, whole)
            size = 1.0 / one.change if one.effect is None and one.change else 1.0
            own = [Shape((one.effect or one.name,), np.full(1, size))]
            own += shapes(laws.get(one.name, one.name), model, machine.limits, one.effect)
            names = {one.name, *one.alternatives}
            rest = [law for law in laws.values() if law.NAME not in names and "state" not in law.HOOKS]
            beside = [shape for law in rest for shape in shapes(law, model, machine.limits, one.effect)[:1]]
            aside = look.columns(beside)
            for name in one.alternatives:
                others = shapes(laws.get(name, name), model, machine.limits, one.effect)
                columns = look.columns([*own, *others])
                first, second = columns[: len(own)], columns[len(own) :]
                if (one.name, name) not in alike:
                    a = first[0][0]
                    scale = np.zeros(0)
                    if not np.any(a):  # of no known size
                        a = first[1].sum(axis=0)
                        scale = np.full(len(first[1]), np.sqrt(LOUD) / max(float(np.linalg.norm(a)), 1e-300))
                        a = scale @ first[1]
                    taken, number, amplitudes = explained(second, a)
                    amplitudes *= np.sqrt(float(a @ a) / max(taken, 1e-12))
                    alike[one.name, name] = scale, number, amplitudes
                scale, number, amplitudes = alike[one.name, name]
                signals = scale @ first[1] if len(scale) else first[0][0], amplitudes @ second[number]
                blocks = max(2, round(run.motion.end / BLOCK))
                yield Pair(one.name, name, first, second, aside, signals, blocks)

    def worth(run: Run) -> float:
        def likeness_of(groups: Sequence[FloatArray], signal: FloatArray) -> float:
            return 1.0 / (1.0 + max(float(signal @ signal) - explained(groups, signal)[0], 0.0))

        likeness = []
        for p in pairs(run):
            likeness += [likeness_of(p.second, p.signals[0]), likeness_of(p.first, p.signals[1])]
            # names that the old logs have ruled out are not to come back: all together count as one
            likeness.append(float(np.mean([likeness_of([group], p.signals[0]) for group in p.rest])))
        return -float(np.log(np.mean(likeness)))  # the weakest counts most, a hopeless one not alone

    def expectations(run: Run) -> list[Expectation]:
        told = []
        for p in pairs(run):
            right = frequency(p.first, p.second, p.signals[0], p.blocks, machine.seed)
            right += frequency(p.second, p.first, p.signals[1], p.blocks, machine.seed + 1)
            told.append(Expectation(p.name, p.alternative, "", "1", round(0.5 * right, 3)))
        return told

    list(pairs(survey))
    return Goal(worth, expectations)


def explained(groups: Sequence[FloatArray], signal: FloatArray) -> tuple[float, int, FloatArray]:
    """How much of a signal the best of groups of columns takes, which group, and its amplitudes."""
    best = (0.0, 0, np.zeros(len(groups[0])))
    for number, columns in enumerate(groups):
        size = np.linalg.norm(columns, axis=1) + 1e-300
        w = np.linalg.lstsq((columns / size[:, None]).T, signal, rcond=1e-6)[0] / size
        best = max(best, (float(signal @ signal - np.sum((signal - w @ columns) ** 2)), number, w), key=lambda t: t[0])
    return best


def frequency(
    own: Sequence[FloatArray], other: Sequence[FloatArray], signal: FloatArray, blocks: int, seed: int
) -> float:
    """How often the right one of two effects is the likelier in white noise, by the score of the engine.

    Args:
        own: whitened columns of the right one at its shapes, a group a shape.
        other: those of the other one.
        signal: what the right one does.
        blocks: of motion, by which amplitudes cost.
        seed: of the noise.
    """
    seen = [[group for group in side if np.any(group)] for side in (own, other)]
    if not np.any(signal) or not all(seen):
        return 0.5 if not np.any(signal) else float(bool(seen[0]))
    base = orthonormal(np.vstack([*seen[0], *seen[1], signal[None]]))
    copies = base @ signal + np.random.default_rng(seed).normal(size=(COPIES, len(base)))
    scores = []
    for side in seen:
        units = [orthonormal(group @ base.T) for group in side]
        ratios = [(len(unit), np.sum((copies @ unit.T) ** 2, axis=1)) for unit in units]
        scores.append(np.max([[score_of(one, k, 1, blocks) for one in ratio] for k, ratio in ratios], axis=0))
    return float(np.mean(scores[0] > scores[1]))


def detect(machine: Machine, model: Model, laws: Mapping[str, Effect], survey: Run, today: Mapping[str, Any]) -> Goal:
    """Detection limits, lowered on the whole: the mean of their logarithms. `today`: limits as a result states them."""
    wanted = {name: shapes(law, model, machine.limits)[:3] for name, law in laws.items()}
    wanted = {name: groups for name, groups in wanted.items() if groups}

    def limits(run: Run) -> dict[str, tuple[str, float]]:
        look = Look(machine, run, model, model)
        columns = iter(look.columns([shape for groups in wanted.values() for shape in groups]))
        blocks = max(2, round(run.motion.end / BLOCK))
        return {
            name: smallest(laws[name], [(shape, next(columns)) for shape in groups], blocks)
            for name, groups in wanted.items()
        }

    first = limits(survey)

    def worth(run: Run) -> float:
        pairs = [(first[name][1], limit) for name, (_, limit) in limits(run).items()]
        gains = [1.0 if before == limit else before / limit for before, limit in pairs]
        return float(np.mean(np.log(np.clip(gains, np.exp(-FAR), np.exp(FAR)))))

    def expectations(run: Run) -> list[Expectation]:
        told = []
        for name, (field, limit) in limits(run).items():
            known = today.get(name) or {}
            before = known.get("value") if known.get("parameter") == field else None
            value = float(f"{limit:.4g}") if limit < np.inf else None
            told.append(Expectation(name, "", field, model.units.of(laws[name].FIELDS[field][0]), value, before))
        return sorted(told, key=lambda one: (one.expected is not None, one.name))

    return Goal(worth, expectations)


def smallest(law: Effect, seen: Sequence[tuple[Shape, FloatArray]], blocks: int) -> tuple[str, float]:
    """The field that tells the size of an effect, and the median over shapes of the smallest size that is seen.

    Seen is what passes the engine's threshold with 95 % chance: 2 ln of the likelihood is noncentral chi-square.
    """
    from scipy.optimize import brentq
    from scipy.stats import ncx2

    roles = law.ROLES
    sized = [f for f, r in roles.items() if r["role"] == "amplitude"]
    sized += [f for neutral in (0.0, np.inf) for f, r in roles.items() if r["neutral"] == neutral]
    told = []
    for shape, columns in seen:
        k = len(columns)
        least = brentq(lambda ratio, k=k: score_of(ratio, k, TRIALS, blocks) - THRESHOLD, 1e-3, 1e4)
        needed = brentq(lambda square, k=k, least=least: ncx2.sf(least, k, square) - CHANCE, 1e-3, 1e5)
        factor = float(np.sqrt(needed * k / max(float(np.sum(columns**2)), 1e-12)))
        size = factor
        if roles[sized[0]]["role"] != "amplitude":
            value = float(getattr(shape.parts[0], sized[0]))
            size = value * factor if roles[sized[0]]["neutral"] == 0.0 else value / max(factor, 1.0)
        told.append(size if factor < BEYOND * float(np.max(shape.units)) else np.inf)
    return sized[0], float(np.median(told))


def fit(machine: Machine, given: Model, model: Model, survey: Run) -> Goal:
    """Intervals of a fit: the volume of the ellipsoid of all parameters (D-optimal, Fedorov 1972), with `[bounds]`."""
    known = parameters_of(model, together=True)

    def information(run: Run) -> tuple[list[str], FloatArray]:
        """Parameters, and what a run tells of them beside the friction law that is free too."""
        evidence = Look(machine, run, given, model).evidence
        rows = evidence.filtered(evidence.nuisances, evidence.screen.taps) * evidence.basis[0]
        own = np.array([path in known for path in evidence.paths])
        gram = rows @ rows.T + np.diag(np.where(own, 0.0, evidence.prior_sigma**-2.0))
        beside = np.linalg.lstsq(gram[np.ix_(~own, ~own)], gram[np.ix_(~own, own)], rcond=None)[0]
        told = gram[np.ix_(own, own)] - gram[np.ix_(own, ~own)] @ beside
        return [path for path in evidence.paths if path in known], np.asarray(told)

    paths, first = information(survey)
    ends = np.array([model.intervals.get(path, (-np.inf, np.inf)) for path in paths]).reshape(-1, 2)
    stated = (0.5 * (ends[:, 1] - ends[:, 0]) / HALF) ** -2.0
    before = np.diag(np.maximum(stated, 1e-6 * np.diag(first)))
    size = np.sqrt(np.diag(first + before))

    def worth(run: Run) -> float:
        told, gram = information(run)
        return float(np.linalg.slogdet((gram + before) / np.outer(size, size))[1]) if told == paths else -np.inf

    def expectations(run: Run) -> list[Expectation]:
        scaled = (information(run)[1] + before) / np.outer(size, size)
        variance = np.diag(np.linalg.inv(scaled)) / size**2
        told = []
        for path, square, one, prior in zip(paths, variance, stated, np.diag(before), strict=True):
            half = float(f"{HALF * np.sqrt(square):.4g}") if one or square < 0.1 / prior else None
            today = float(f"{HALF * one**-0.5:.4g}") if one else None
            told.append(Expectation(path, "", "", known[path].unit, half, today))
        return told

    return Goal(worth, expectations)
