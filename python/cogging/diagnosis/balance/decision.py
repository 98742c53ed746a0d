"""Decision: the search for missing effects on given and confirm logs together, one effect at a time.

Each round finds candidates in the given logs, ranks the best of them by the likelihood of all logs, drops those that a
log contradicts, and adds the likeliest to the model, which is then re-tuned.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from copy import copy
from dataclasses import dataclass, field, replace
from functools import partial
from itertools import combinations, dropwhile, pairwise
from math import log, prod

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import minimize_scalar

from cogging.arrays import FloatArray
from cogging.diagnosis.balance.candidates import CELLS, JUMPS, LATE, NESTED, Found, search_once
from cogging.diagnosis.balance.differenced_balance import DifferencedBalance
from cogging.diagnosis.balance.evidence import BLOCKS, LARGEST_CHANGE, Evidence, Maximum, orthonormal
from cogging.diagnosis.balance.evidence import beside as orthogonal
from cogging.effects.effect import Effect
from cogging.logs.log import Log
from cogging.model.model import Model
from cogging.resources import on_threads

THRESHOLD = 30.0  # minimum score of an accepted candidate: most false alarms score 20 to 28 (docs/evidence.md)
PREFERRED = 0.5  # of the score of a force without a law: a law that explains more is accepted, the rest may follow
EQUAL = 0.9  # of the gain: the same of a law of another name
MINOR = 0.05  # of the largest gain or force: less may come from a law that is only nearly right
NAMELESS = 0.15  # the same for forces of several amplitudes without a law
SHARE = 0.05  # minimum probability of an alternative name
RESAMPLED = 2000  # bootstrap samples
CHANCE = 2.0  # inflation that the few blocks of a log show by chance
COLUMN_ERROR = 0.01  # relative error of a gain: accuracy of the columns under an inexact friction law
ROUNDS = 10  # maximum number of rounds, the last of which accepts nothing
SURVIVORS = 24  # candidates of a round that are pre-selected for all logs
CLOSE = 8  # of these, candidates that are fitted with whitening filters of their own
FIRST, SHAPES = 3, 2  # always among them: the best of the given logs; maximum number of shapes of one name
FAINT = 0.02  # of the largest T: smaller candidates are skipped
WIDE = 2  # amplitudes: what has more may stand in for several effects
RETUNED = 3  # maximum number of Gauss-Newton steps of a scale error
SHOWN = 10.0  # minimum expected gain in 2 ln likelihood of logs that can contradict a candidate
REPEATED = (  # may occur several times, with another period, frequency or time
    *("cogging_harmonic", "force_constant_ripple", "encoder_periodic_error", "disturbance_tone", "disturbance_step"),
)
CONTACTS = (
    "presliding_friction",
    "backlash",
)  # stay columns: re-tuning would move their instants
OF_A_WINDOW = ("local_force", "disturbance_step")  # at a place or a time of their own: no error of another law
COUPLINGS = ("backlash", "flexible_mode")  # of motor and load: an axis has at most one


@dataclass
class Contender:
    """A candidate fitted to all logs."""

    found: Found
    fit: Maximum = field(repr=False)  # of the candidate and, as `none`, without it
    inflation: float  # of the variance of its score, by which the gain is divided
    force: float  # root mean square of its force, V
    net: float  # the same of its part that the effects of the model cannot explain, V
    ratio: float = 0.0  # gain in 2 ln likelihood over the model without it
    score: float = 0.0  # `ratio` less the expected gain of its amplitudes and trials under the null hypothesis
    alone: float = 0.0  # score in the noise that the candidate itself leaves
    blocks: FloatArray = field(default_factory=lambda: np.zeros(0), repr=False)  # gain of each block of motion
    gains: tuple[float, float] = (0.0, 0.0)  # of the given and of the confirm logs
    expected: tuple[float, float] = (0.0, 0.0)  # the same if the candidate is true

    @property
    def is_lawful(self) -> bool:
        """Whether the candidate is a law, or a change of the axis."""
        return self.found.columns is None or self.found.effect is not None

    @property
    def gain(self) -> float:
        """Gain in 2 ln likelihood over the model without the candidate, as if all rows were independent."""
        return self.ratio * self.inflation

    @property
    def is_contradicted(self) -> bool:
        """Whether logs that can show the candidate show the contrary."""
        return any(e > SHOWN and g < 0.0 for g, e in zip(self.gains, self.expected, strict=True))


@dataclass
class Accepted:
    """An accepted candidate."""

    found: Found  # `effect(amplitudes)` is its law, None without one
    score: float  # gain in 2 ln likelihood less the expected gain under the null hypothesis
    force: float  # root mean square of its force, V
    net: float  # the same of its part that the effects before it cannot explain, V
    share: float  # probability of the candidate over resampled motion
    alternatives: list[tuple[str, float]]  # their names and probabilities


@dataclass
class Outcome:
    """Result of the search."""

    nominal: Evidence  # of the given logs under the re-tuned model without any candidate
    evidence: Evidence  # of the given logs with the accepted candidates: those with a law in `model`, others in `extra`
    both: Evidence  # the same of given and confirm logs; `evidence` without confirm logs
    accepted: list[Accepted]  # in order
    #: Contradicted candidates: name, gains of given and confirm logs, expected gains.
    refused: list[tuple[str, tuple[float, float], tuple[float, float]]]
    found: list[Found]  # candidates of the last round, the highest score first
    shift: float = 0.0  # of the zero of the confirm logs, m
    late: float = 0.0  # delay between the action of a command and its time stamp, s


def search(
    given: Sequence[Log],
    confirm: Sequence[Log],
    model: Model,
    also: Mapping[str, Effect] | None = None,
    progress: Callable[[str], None] = lambda step: None,
) -> Outcome:
    """Search for the effects that a model lacks.

    Args:
        given: logs that provide the candidates.
        confirm: logs of other motion, which rank and may contradict the candidates.
        model: stated model.
        also: user-defined effects by name.
        progress: function that receives one line per round.

    Raises:
        TooLittleMotion: the given logs, or the confirm logs, have too few valid rows.
    """
    width, quantum = model.axis.coulomb_width, model.encoder.resolution
    balances = [DifferencedBalance(log, width, quantum) for log in given]
    others = [DifferencedBalance(log, width, quantum) for log in confirm]
    sought: list[Found] = []  # accepted effects that were sought again
    kept: tuple[Model, Outcome] | None = None  # before the last of them was taken out
    excluded = {e.NAME for e in model.effects if "state" in e.HOOKS}
    excluded.update(COUPLINGS if excluded & set(COUPLINGS) else ())
    outcome: Outcome | None = None
    current = model
    for step in range(ROUNDS):
        uniform = outcome is not None and outcome.nominal.largely
        evidence = Evidence(balances, model, current, *beside_model(outcome), uniform=uniform)
        evidence.prepare(2 if step == 0 else 3, listen=step == 0)
        current = evidence.model
        found = [f for f in search_once(evidence, also or {}) if f.name not in excluded]
        found += sought[-1:] if kept else []
        progress(f"round {step}: " + "; ".join(f"{f.name} {f.label} T {f.T:.0f}" for f in found[:5]))
        if outcome is None:
            for b in others:
                b.listen(b.residual(current), current.axis, evidence.largely)
            outcome = Outcome(evidence, evidence, evidence, [], [], found)
        outcome.evidence = outcome.both = evidence
        outcome.found = found
        outcome.both = with_logs(evidence, others, uniform=outcome.nominal.largely)
        if step == ROUNDS - 1:
            break

        # compare the best candidates on all logs, each with its own whitening filter
        compared = [f for f in found if max(4.0, FAINT * found[0].T) < f.T][:SURVIVORS]
        close, pairs = closest(outcome.both, compared)
        contenders = contenders_of(outcome.both, close, len(given))
        seeks_zero = bool(others) and not outcome.shift and model.cogging is None
        shift = shift_of_zero(outcome.both, contenders, len(given)) if seeks_zero else 0.0
        if shift:
            outcome.shift, others = shift, [b.moved(shift) for b in others]
            outcome.both = with_logs(evidence, others, uniform=outcome.nominal.largely)
            contenders, kept = contenders_of(outcome.both, close, len(given)), None

        outcome.refused += [
            (c.found.name, c.gains, c.expected) for c in contenders if c.is_contradicted and c.score > 0
        ]
        contenders = ranked(outcome.both, contenders)
        contenders = beside_second(outcome.both, compared, pairs, contenders, len(given))
        progress("  all logs: " + "; ".join(f"{c.found.name} {c.found.label} {c.score:.0f}" for c in contenders[:5]))
        fit = list(dropwhile(partial(is_weak, outcome.accepted, sought), contenders))
        part = shares(fit) if fit else np.zeros(0)
        alternatives = [(c.found.name, float(p)) for c, p in zip(fit[1:], part[1:], strict=True) if p > SHARE]
        if kept and fit and (fit[0].found.name, fit[0].found.k) == (sought[-1].name, sought[-1].k):
            current, outcome = kept
            (at,) = (k for k, one in enumerate(outcome.accepted) if one.found is sought[-1])
            same, later = outcome.accepted[at], outcome.accepted[at + 1 :]
            same.score, same.share, same.alternatives = fit[0].alone, float(part[0]), alternatives
            excluded.update({same.found.name}.difference(REPEATED))
            fit, kept = [], None
            errors = [one for one in later if one.net < MINOR * same.force]  # they came, but did not take its place
            for one in errors:
                current = without(current, len(model.effects), outcome.accepted, one)
                outcome.accepted = [other for other in outcome.accepted if other is not one]
                excluded.add(one.found.name)
            if errors:
                continue
        kept = None
        if not fit:
            # what was found before the others may have stood in for several effects: seek it once more beside them
            known = (*CONTACTS, *(f.name for f in sought))
            wide = (one for one in outcome.accepted[:-1] if one.found.k > WIDE and one.found.name not in known)
            again = next(wide, None)
            if again is None or step > ROUNDS - 3:
                break
            kept = current, copy(outcome)
            current = without(current, len(model.effects), outcome.accepted, again)
            outcome.accepted = [one for one in outcome.accepted if one is not again]
            excluded.discard(again.found.name)
            sought.append(again.found)
            progress(f"  again: {again.found.name} {again.found.label}")
            continue

        first = fit[0]
        if first.found.name == LATE:
            seconds = likeliest_lateness(outcome.both, -float(first.found.amplitudes[0]))
            balances, others = ([b.earlier(seconds) for b in logs] for logs in (balances, others))
            outcome.late += seconds
            continue
        f = owned(first.found, outcome.accepted)
        outcome.accepted.append(Accepted(f, first.alone, first.force, first.net, float(part[0]), alternatives))
        if f.columns is not None and not is_column(f):
            current = current.replace(effects=(*current.effects, *f.laws(f.amplitudes)))
        excluded.update({*COUPLINGS} if f.name in COUPLINGS else {f.name}.difference(REPEATED))
    assert outcome is not None
    plain = Evidence(balances, model, current, *beside_model(outcome), plainly=True)
    whitened = replace(outcome.evidence, with_width=True)
    outcome.evidence = (plain if outcome.nominal.largely else whitened).prepare(3, orthogonal=True)
    without_each_other(outcome.accepted)
    return outcome


def one_of_each_name(contenders: Sequence[Contender]) -> list[Contender]:
    """Return the best shape of each name, without shapes that have no law where a law stands for them.

    A law that explains less than NESTED of such a shape gets this share as its likeness, which lowers its confidence.
    """
    best: dict[str, Contender] = {}
    for c in contenders:
        rivals = [law for law in contenders if c.found.k > 1 and not c.is_lawful and stands_for(law, c)]
        if rivals:
            rival = max(rivals, key=lambda law: law.score)
            share = float((rival.ratio - rival.found.k) / (c.ratio - c.found.k))
            if share < NESTED:
                rival.found = replace(rival.found, likeness=min(rival.found.likeness, share))
        else:
            best.setdefault(c.found.name, c)
    return sorted(best.values(), key=lambda c: -c.score)


def stands_for(law: Contender, c: Contender) -> bool:
    """Return whether a law explains enough of a shape without a law to be accepted instead.

    A law of another name, of the same coordinate, has to explain nearly as much.
    """
    name, other = law.found.name, c.found.name
    if name.startswith("~") or law.score < PREFERRED * c.score:
        return False
    alike = law.is_lawful and any(name in names and other in names for names in CELLS.values())
    return other.startswith("~") or (law.is_lawful and name == other) or (alike and law.gain >= EQUAL * c.gain)


def in_one_noise(evidence: Evidence, contenders: Sequence[Contender]) -> list[Contender]:
    """Return the contenders with the likeliest first: those that are significant compared in the noise that it leaves.

    A candidate on which what is still missing has little influence is not likelier for it.
    """
    for c in contenders:
        c.alone = c.score
    significant = [c for c in contenders if c.score > THRESHOLD]
    inflation = max(significant, key=lambda c: c.gain).inflation if significant else 1.0
    for c in significant:
        c.inflation = inflation
        weighed(evidence, c)
    return sorted(contenders, key=lambda c: -c.score)


def simplest_first(evidence: Evidence, contenders: Sequence[Contender]) -> list[Contender]:
    """Return the contenders with the simplest first that is as likely as the one of the highest score.

    A simpler candidate of the same gain, within COLUMN_ERROR, that explains what the first does goes before it. All are
    then compared in the noise that it leaves.
    """
    contenders = list(contenders)
    good = [c for c in contenders if c.score > THRESHOLD and c.gain >= (1.0 - COLUMN_ERROR) * contenders[0].gain]
    if not good:
        return contenders
    first = contenders[0]
    simplest = max(good, key=lambda c: (score_of(0.0, max(c.found.k, 1), c.found.N, len(c.blocks)), c.gain))
    if simplest is first or simplest.found.near_rest != first.found.near_rest:
        return contenders
    own = evidence.near_rest if first.found.near_rest else evidence
    free = [c.found.effect for c in (first, simplest) if c.found.columns is None]
    tables = [c.found.rows(evidence)[1] for c in (first, simplest) if c.found.columns is not None]
    both = released(own, free, [np.vstack(rows) for rows in zip(*tables, strict=True)] if tables else None)
    if simplest.fit.cost - both.cost > max(MINOR * first.gain, THRESHOLD):
        return contenders
    for c in contenders:
        c.inflation = simplest.inflation
        weighed(evidence, c)
    return [simplest, *sorted((c for c in contenders if c is not simplest), key=lambda c: -c.score)]


def owned(f: Found, accepted: Sequence[Accepted]) -> Found:
    """Return the candidate, renamed after an accepted law of the same coordinate if it has no law of its own."""
    if f.columns is None or f.effect is not None or f.name in OF_A_WINDOW:
        return f
    taken = {one.found.name for one in accepted} - {f.name}
    names = next((names for cell, names in CELLS.items() if f.name in (cell, *names)), ())
    owner = next((name for name in names if name in taken), None)
    return f if owner is None else replace(f, name=owner, label="other shape")


def beside_model(outcome: Outcome | None) -> tuple[list[Found], tuple[str, ...]]:
    """Return the accepted columns without a law in the model, and the paths of the changes of the axis."""
    found = [one.found for one in outcome.accepted] if outcome else []
    return [f for f in found if is_column(f)], tuple(f.effect for f in found if f.columns is None)


def without(model: Model, stated: int, accepted: Sequence[Accepted], again: Accepted) -> Model:
    """Return a model, whose first `stated` effects are not accepted ones, without the laws of an accepted effect."""
    counts = [0 if is_column(one.found) else len(one.found.laws(one.found.amplitudes)) for one in accepted]
    (at,) = (k for k, one in enumerate(accepted) if one is again)
    first = stated + sum(counts[:at])
    return model.replace(effects=(*model.effects[:first], *model.effects[first + counts[at] :]))


def is_column(f: Found) -> bool:
    """Return whether an accepted candidate is a column beside the model, which has no law of it.

    Presliding stays a column: beside its stiffness, re-tuned in steps, a wave that is no harmonic of the shaft was
    found in a real motor.
    """
    return f.columns is not None and (not f.laws(f.amplitudes) or f.name in CONTACTS)


def is_weak(accepted: Sequence[Accepted], sought: Sequence[Found], c: Contender) -> bool:
    """Return whether a candidate may be chance or, if it is not sought again, an error of an accepted law."""
    missing = {f.name for f in sought} - {one.found.name for one in accepted}
    known = [] if c.found.name in missing else accepted
    least, force = (MINOR, c.force) if c.is_lawful else (NAMELESS, c.net)
    return c.alone < THRESHOLD or any(force < least * one.force for one in known)


def without_each_other(accepted: Sequence[Accepted]) -> None:
    """Remove from the alternatives of an effect names that are accepted, or likelier as an alternative of another."""
    rivals = sorted((p, k, name) for k, one in enumerate(accepted) for name, p in one.alternatives)
    home = {name: accepted[k] for _, k, name in rivals}  # the likeliest last
    home |= {one.found.name: one for one in accepted}
    for one in accepted:
        apart = sum(p for name, p in one.alternatives if home[name] is not one)
        one.alternatives = [(name, p) for name, p in one.alternatives if home[name] is one]
        one.share = min(1.0, one.share / max(1.0 - apart, one.share))


def score_of(ratio: float, k: int, trials: float, blocks: int) -> float:
    """Return a gain in 2 ln likelihood less penalties for k amplitudes (by the number of blocks) and for trials."""
    return float(ratio - k * max(np.log1p(max(ratio, 0.0) / k), np.log(blocks)) - 2 * log(max(trials, 1)))


def contenders_of(evidence: Evidence, found: Sequence[Found], given: int) -> list[Contender]:
    """Fit the candidates to all logs on threads; drop implausible changes of the axis.

    The rivals of the likeliest are also fitted behind its whitening filter: they must not differ by their filters.
    """
    made = [c for c in on_threads(lambda f: contender(evidence, f, given), found) if c is not None]
    first: Contender | None = None
    while made and first is not (likeliest := max(made, key=lambda c: c.score)):
        first = likeliest
        made = on_threads(partial(beside, evidence, first, given), made)
    for c in made:
        if c.found.name == "encoder_scale_error" and c.score > PREFERRED * max(one.score for one in made):
            retune(evidence, c)
    return made


def beside(evidence: Evidence, first: Contender, given: int, c: Contender) -> Contender:
    """Return a rival of the likeliest candidate as fitted behind that one's filter, if it is likelier so."""
    if c is first or c.score < PREFERRED * first.score or c.found.near_rest != first.found.near_rest:
        return c
    other = contender(evidence, c.found, given, first.fit.taps)
    return c if other is None or other.fit.cost >= c.fit.cost else other


@np.errstate(all="ignore")
def contender(evidence: Evidence, f: Found, given: int, tried: list[FloatArray] | None = None) -> Contender | None:
    """Fit a candidate to all logs, the first `given` of which are given logs; None for an implausible change.

    A filter of each log that was tried with another candidate is a further starting point.
    """
    if f.columns is None:
        if f.effect not in evidence.paths:
            return None
        best, name = released(evidence, [f.effect]), f.effect.removeprefix("axis.")
        stated = getattr(evidence.given.axis, name)
        value = getattr(evidence.model.axis, name) + best.theta[evidence.paths.index(f.effect)]
        if not stated / LARGEST_CHANGE < value < stated * LARGEST_CHANGE:
            return None
        best.none = evidence.null
        at = evidence.paths.index(f.effect)
        force = root_mean_square(evidence, [t[[at]] for t in evidence.nuisances], np.array([value - stated]))
        return weighed(evidence, Contender(f, best, evidence.alike, force, force))
    own, rows = f.rows(evidence)
    best = own.maximised(rows, tried, f.sudden)
    # what each log says of the candidate: behind one filter, as expected is, which then cannot absorb it in one log
    of_log = (best.same.by_row() - best.by_row()) / best.inflation
    expected = best.explained**2 / best.inflation
    first = sum(int(m.sum()) for m in own.counted[:given])
    gains, show = ((float(x[:first].sum()), float(x[first:].sum())) for x in (of_log, expected))
    amplitudes = best.theta[-len(rows[0]) :]
    force, net = root_mean_square(own, rows, amplitudes), root_mean_square(own, rows, amplitudes, net=True)
    return weighed(evidence, Contender(f, best, best.inflation, force, net, gains=gains, expected=show))


def root_mean_square(
    evidence: Evidence, tables: Sequence[FloatArray], amplitudes: FloatArray, *, net: bool = False
) -> float:
    """Return the root mean square (V) of the force of columns with amplitudes, over the valid rows.

    `net`: of its part that the effects of the model cannot explain.
    """
    force = np.hstack([amplitudes @ t[:, m] for t, m in zip(tables, evidence.counted, strict=True)])
    if net:
        of_effects = [path.startswith("effects.") for path in evidence.paths]
        known = np.hstack([t[:, m] for t, m in zip(evidence.nuisances, evidence.counted, strict=True)])
        force = orthogonal(force[None], orthonormal(known[[*of_effects, *[True] * (len(known) - len(of_effects))]]))
    return float(np.sqrt(np.mean(force**2)))


def weighed(evidence: Evidence, c: Contender) -> Contender:
    """Return a contender with gain, score and blocks from its fit."""
    edges, fit = block_edges(evidence, c.found.near_rest), c.fit
    c.ratio = (fit.none.cost - fit.cost) / c.inflation
    c.score = score_of(c.ratio, max(c.found.k, 1), c.found.N, len(edges))
    c.blocks = np.add.reduceat((fit.none.by_row() - fit.by_row()) / c.inflation, edges)
    fit.x = fit.r = fit.gram = np.zeros(0)  # free the rows of many candidates
    return c


@np.errstate(all="ignore")
def retune(evidence: Evidence, c: Contender) -> None:
    """Compare the model with a scale error and without it after Gauss-Newton steps, behind the same filters.

    Its column is the slope at the model without it, whose known cogging is turned and too small: the scale error, which
    it lacks, moves the cogging along the travel. Other laws are linear in their amplitudes, or nearly so.
    """
    linear = c.fit
    law = c.found.effect(linear.theta[-1:])
    at = retuned(evidence, evidence.model.replace(effects=(*evidence.model.effects, law)), linear)
    without = retuned(evidence, evidence.model, evidence.null)
    if at is not evidence:
        fits = [at.fitted(linear.taps)]
        fits.append(at.fitted(at.taps_of(fits[0].theta)))
        c.fit = min(fits, key=lambda fit: fit.cost)
    taps = c.fit.taps
    c.fit.none = min(linear.none, evidence.fitted(taps), without.fitted(taps), key=lambda fit: fit.cost)
    weighed(evidence, c)


def retuned(evidence: Evidence, model: Model, fit: Maximum) -> Evidence:
    """Return the evidence of a model after Gauss-Newton steps from a linear fit; `evidence` itself if none is better.

    The model is that of `evidence`, possibly with a further law. All have the noise of `evidence`, since a smaller mass
    would have less.
    """
    at = evidence
    for _ in range(RETUNED):
        model = at.moved(model, dict(zip(at.paths, map(float, fit.theta), strict=False)))
        after = replace(evidence, model=model, base=evidence)
        after.levels = evidence.levels
        after.make()
        better = after.fitted(fit.taps)
        if after.largely != evidence.largely or better.cost >= fit.cost:
            break
        at, fit = after, better
    return at


@np.errstate(all="ignore")
def closest(evidence: Evidence, found: Sequence[Found]) -> tuple[list[Found], dict[tuple[Found, ...], float]]:
    """Return the candidates worth a complete fit, and the score of each pair of candidates by one least-squares step.

    The former are the best of the given logs and the likeliest on all logs.
    """
    blocks, worth = len(block_edges(evidence)), {f: f.score for f in found}  # a jump is in one log only
    pairs: dict[tuple[Found, ...], float] = {}
    for near_rest in (False, True):
        free = [f for f in found if f.near_rest == near_rest and f.columns is not None and f.name != JUMPS]
        if not free:
            continue
        own = evidence.near_rest if near_rest else evidence
        rows = on_threads(lambda f: f.rows(evidence)[1], free)
        ends = np.cumsum([0, *(len(t[0]) for t in rows)])
        groups = dict(zip(free, (np.arange(*ends) for ends in pairwise(ends)), strict=True))
        sets = [(f,) for f in free] + ([] if near_rest else list(combinations(free, 2)))
        tables = [np.vstack(t) for t in zip(*rows, strict=True)]
        costs = own.costs_with(tables, [np.hstack([groups[f] for f in one]) for one in sets]).min(axis=0)
        none = min(base.cost for base in own.bases)
        for one, cost in zip(sets, costs, strict=True):
            score = score_of(none - cost, sum(f.k for f in one), prod(f.N for f in one), blocks)
            if len(one) == 1:
                worth[one[0]] = score
            else:
                pairs[one] = score
    near: list[Found] = []
    for f in [*found[:FIRST], *sorted(found, key=lambda f: -worth[f])]:
        if f not in near and sum(other.name == f.name for other in near) < SHAPES:
            near.append(f)
    return near[:CLOSE], pairs


def beside_second(
    evidence: Evidence,
    found: Sequence[Found],
    pairs: Mapping[tuple[Found, ...], float],
    contenders: list[Contender],
    given: int,
) -> list[Contender]:
    """Return the contenders beside the lesser of the likeliest pair of candidates where they need it, else themselves.

    Two effects may hide each other, and a third may stand in for both: then the pair is likelier than the first of the
    contenders, alone and with any other candidate.
    """
    first = next((c for c in contenders[:1] if c.alone > THRESHOLD), None)
    pair, beside_first = max(pairs, key=lambda pair: pairs[pair], default=()), -np.inf
    if first is not None:
        of_first = (s for one, s in pairs.items() if any(f.columns is first.found.columns for f in one))
        beside_first = max(of_first, default=-np.inf)
    # what is smaller beside the first may be an error of its law
    if not pair or pairs[pair] < beside_first + max(THRESHOLD, MINOR * beside_first):
        return contenders
    a, b = pair
    joined = Found(f"{a.name} + {b.name}", "", a.T + b.T, a.k + b.k, a.N * b.N, None, None)
    joined.columns = lambda c: [np.vstack(both) for both in zip(a.columns(c), b.columns(c), strict=True)]
    both, rows = contender(evidence, joined, given), [f.rows(evidence)[1] for f in pair]
    assert both is not None
    if both.score < THRESHOLD + (0.0 if first is None else first.alone):
        return contenders
    parts = np.split(both.fit.theta[-len(rows[0][0]) - len(rows[1][0]) :], [len(rows[0][0])])
    force = {f: root_mean_square(evidence, t, part) for f, t, part in zip(pair, rows, parts, strict=True)}
    second = min(pair, key=lambda f: force[f])
    beside = replace(evidence, extra=[*evidence.extra, second]).prepare()
    close, _ = closest(beside, [f for f in found if f is not second])
    return ranked(beside, contenders_of(beside, close, given))


def ranked(evidence: Evidence, contenders: Sequence[Contender]) -> list[Contender]:
    """Return the contenders that no log contradicts, the best shape of each name, the likeliest first."""
    good = sorted((c for c in contenders if c.score > 0 and not c.is_contradicted), key=lambda c: -c.score)
    return simplest_first(evidence, in_one_noise(evidence, one_of_each_name(good)))


def with_logs(evidence: Evidence, others: Sequence[DifferencedBalance], *, uniform: bool) -> Evidence:
    """Return the evidence of these and other logs under the same model; `evidence` itself without others."""
    if not others:
        return evidence
    return replace(evidence, balances=[*evidence.balances, *others], uniform=uniform).prepare()


def shift_of_zero(evidence: Evidence, contenders: Sequence[Contender], given: int) -> float:
    """Return the offset (m) of the zero of the confirm logs, from the phase of the likeliest wave; 0 if it is chance.

    `given` is the number of given logs, which have the wave. With gravity, the zero is the same in all logs.
    """
    fixed = any(c.found.name == "gravity" and c.score > THRESHOLD for c in contenders)
    waves = [c for c in contenders if c.found.period is not None and c.ratio > THRESHOLD and not fixed]
    if not waves:
        return 0.0
    first = max(waves, key=lambda c: c.ratio)
    f = first.found
    tables = f.rows(evidence)[1]
    none = [np.zeros_like(t) for t in tables]
    pairs = enumerate(zip(tables, none, strict=True))
    best = evidence.maximised([np.vstack([t, z] if i < given else [z, t]) for i, (t, z) in pairs])
    k = len(f.amplitudes)  # sine and cosine of the longest wave stand first
    here, there = (complex(cosine, sine) for sine, cosine in best.theta[-2 * k :].reshape(2, k)[:, :2])
    alike = 0.5 < abs(there) / max(abs(here), 1e-300) < 2.0
    gain = (best.none.cost - best.cost) / best.inflation
    if not alike or f.period is None or gain < first.ratio + THRESHOLD + 2.0 * np.log(f.N):
        return 0.0
    return float(np.angle(here / there)) * f.period / (2 * np.pi)


def likeliest_lateness(evidence: Evidence, estimate: float) -> float:
    """Return the delay (s) between the action of a command and its time stamp, up to twice an estimate."""

    def cost(seconds: float) -> float:
        return replace(evidence, balances=[b.earlier(seconds) for b in evidence.balances]).prepare().null.cost

    bounds, accuracy = (0.0, 2.0 * estimate), {"xatol": 0.01 * estimate}
    return float(minimize_scalar(cost, bounds=bounds, method="bounded", options=accuracy).x)


def released(evidence: Evidence, paths: Sequence[str], tables: Sequence[FloatArray] | None = None) -> Maximum:
    """Return the maximum-likelihood fit without the priors of some parameters, possibly with added columns."""
    other = copy(evidence)
    other.prior_sigma = evidence.prior_sigma.copy()
    other.prior_sigma[[evidence.paths.index(path) for path in paths]] = np.inf
    return other.maximised(tables)


def block_edges(evidence: Evidence, near_rest: bool = False) -> NDArray[np.intp]:
    """Return the first rows of the blocks of motion, also of rows that include those near rest.

    No block spans two logs.
    """
    size, own = round(BLOCKS[-1] * evidence.rate), evidence.near_rest if near_rest else evidence
    edges: list[int] = []
    at = 0
    for m, rows in zip(evidence.counted, own.counted, strict=True):
        if not rows.any():
            continue
        first = np.flatnonzero(m)[: max(1, int(m.sum()) - size // 2) : size]
        edges += [at, *(at + np.cumsum(rows)[first[1:]] - 1)]
        at += int(rows.sum())
    return np.array(edges, dtype=np.intp)


def shares(contenders: Sequence[Contender], seed: int = 1) -> FloatArray:
    """Return the probability of each candidate against the others and none, averaged over a block bootstrap.

    In half of the samples, up to CHANCE of the variance inflation counts as chance.
    """
    rng = np.random.default_rng(seed)
    blocks = np.array([c.blocks for c in contenders])
    stated = np.array([c.ratio - c.blocks.sum() for c in contenders])  # gain in the prior
    paid = np.array([c.score - c.ratio for c in contenders])
    n = blocks.shape[1]
    weights = rng.multinomial(n, np.full(n, 1.0 / n), RESAMPLED)
    ratios = np.array([c.ratio for c in contenders])
    wrong = COLUMN_ERROR * ratios * rng.standard_normal((RESAMPLED, len(contenders)))
    chance = np.minimum([c.inflation for c in contenders], CHANCE) ** rng.integers(0, 2, (RESAMPLED, 1))
    scores = np.hstack([(weights @ blocks.T + stated) * chance + paid + wrong, np.zeros((RESAMPLED, 1))])
    odds = np.exp(0.5 * (scores - scores.max(axis=1, keepdims=True)))
    return np.asarray(np.mean(odds / odds.sum(axis=1, keepdims=True), axis=0)[:-1])
