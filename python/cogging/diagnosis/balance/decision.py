"""Decision: the search for what a model lacks, on given and confirm logs together, one effect at a time.

Each round looks for candidates in the given logs, ranks the best of them by the likelihood of all logs, drops what logs
that can show it contradict, and adds the likeliest to the model, which is then re-tuned.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from copy import copy
from dataclasses import dataclass, field, replace

import numpy as np
from numpy.typing import NDArray

from cogging.arrays import FloatArray
from cogging.diagnosis.balance.candidates import CELLS, LATE, NESTED, UNNAMED, Found, search_once
from cogging.diagnosis.balance.evidence import Evidence, Maximum
from cogging.diagnosis.balance.force_balance import ForceBalance
from cogging.effects.effect import Effect
from cogging.logs.log import Log
from cogging.model.model import Model
from cogging.resources import on_threads

THRESHOLD = 20.0  # score from which on a candidate is taken: above those of 36 drawn logs with nothing missing
MINOR = 0.1  # of the largest score: what is less is a trait of a law that is nearly right
SHARE = 0.05  # probability from which on another name is an alternative
BLOCK = 0.5  # s, of motion that is resampled: a stroke or so
RESAMPLED = 2000  # motions
CHANCE = 2.0  # inflation that the few blocks of a log show by chance: it tells no two candidates apart
COLUMN_ERROR = 0.01  # of a gain: columns of rivals are right to some per cent where friction is not the model's
ROUNDS = 10  # effects at most, and a last look at what is left
SURVIVORS = 24  # candidates of a look that are compared on all logs
CLOSE = 8  # of these that are compared with noise filters of their own
FIRST, SHAPES = 3, 2  # the best of the given logs that are among them, and shapes of one name
FAINT = 0.1  # of the largest T: candidates below are not compared
SHOWN = 10.0  # expected gain in 2 ln likelihood from which on logs can contradict a candidate
LARGEST_CHANGE = 10.0  # of mass or friction against what is stated, as a factor either way
REPEATED = (  # may be found again, at another period, frequency or time
    *("cogging_harmonic", "force_constant_ripple", "encoder_periodic_error", "disturbance_tone", "disturbance_step"),
)
COUPLINGS = ("backlash", "flexible_mode")  # of motor and load: an axis has one


@dataclass
class Contender:
    """A candidate on all logs.

    Attributes:
        found: the candidate.
        ratio: gain in 2 ln likelihood over the model without it.
        score: the same less what amplitudes and trials gain without any cause.
        inflation: of the variance of its score, by which its gain is divided.
        blocks: gain of each block of motion.
        gains: of given and of confirm logs.
        expected: what these would show if the candidate is right.
    """

    found: Found
    ratio: float
    score: float
    inflation: float
    blocks: FloatArray = field(repr=False)
    gains: tuple[float, float] = (0.0, 0.0)
    expected: tuple[float, float] = (0.0, 0.0)

    @property
    def is_contradicted(self) -> bool:
        """Logs that can show it show the contrary."""
        return any(e > SHOWN and g < 0.0 for g, e in zip(self.gains, self.expected, strict=True))


@dataclass
class Accepted:
    """What was added to the model.

    Attributes:
        found: candidate, with the amplitudes of its columns; `effect(amplitudes)` is its law, None without one.
        score: gain in 2 ln likelihood less what amplitudes and trials gain without any cause.
        share: probability that it is this one, over resampled motion.
        alternatives: other names with the same.
    """

    found: Found
    score: float
    share: float
    alternatives: list[tuple[str, float]]


@dataclass
class Outcome:
    """What the search came to.

    Attributes:
        nominal: evidence of the given logs under the re-tuned model, before anything was added.
        evidence: the same with all that was accepted: `model` holds what has a law, `extra` what has none.
        both: given and confirm logs together, with all that was accepted; `evidence` without confirm logs.
        accepted: what was added, in that order.
        refused: name, gains on given and confirm logs and what these can show, of what logs contradict.
        found: last candidates, the highest score first.
        shift: distance by which the zero of the confirm logs lies elsewhere, m.
        late: time after which a command that acts is logged, s.
    """

    nominal: Evidence
    evidence: Evidence
    both: Evidence
    accepted: list[Accepted]
    refused: list[tuple[str, tuple[float, float], tuple[float, float]]]
    found: list[Found]
    shift: float = 0.0
    late: float = 0.0


def search(
    given: Sequence[Log],
    confirm: Sequence[Log],
    model: Model,
    also: Mapping[str, Effect] | None = None,
    progress: Callable[[str], None] = lambda step: None,
) -> Outcome:
    """Search for what a model lacks.

    Args:
        given: logs that are searched.
        confirm: logs of other motion: they rank what was found, and may contradict it.
        model: stated model.
        also: own effects by name.
        progress: is called with what was found in each round, in a line.

    Raises:
        TooLittleMotion: the given logs, or the confirm logs, have too few rows that count.
    """
    width, quantum = model.axis.coulomb_width, model.encoder.resolution
    balances = [ForceBalance(log, width, quantum) for log in given]
    others = [ForceBalance(log, width, quantum) for log in confirm]
    extra: list[Found] = []
    free: list[str] = []
    excluded = {e.NAME for e in model.effects if "state" in e.HOOKS}
    excluded.update(COUPLINGS if excluded & set(COUPLINGS) else ())
    outcome: Outcome | None = None
    current = model
    for step in range(ROUNDS):
        evidence = Evidence(balances, model, current, list(extra), tuple(free))
        evidence.prepare(2 if step == 0 else 3, listen=step == 0)
        current = evidence.model
        found = [f for f in search_once(evidence, also or {}) if f.name not in excluded]
        progress(f"round {step}: " + "; ".join(f"{f.name} {f.label} T {f.T:.0f}" for f in found[:5]))
        if outcome is None:
            for b in others:
                b.set_corner(b.residual(current), current.axis.mass, evidence.largely)
            outcome = Outcome(evidence, evidence, evidence, [], [], found)
        outcome.evidence = outcome.both = evidence
        outcome.found = found
        extra = with_amplitudes(extra, evidence)
        if others:
            outcome.both = Evidence([*balances, *others], model, current, list(extra), tuple(free)).prepare()
        if step == ROUNDS - 1:
            break

        # those that may be the likeliest on all logs, each with its own noise filter
        compared = [f for f in found if max(4.0, FAINT * found[0].T) < f.T][:SURVIVORS]
        compared = closest(outcome.both, compared)
        contenders = contenders_of(outcome.both, compared, len(given))
        if others and not outcome.shift and model.cogging is None:
            # gravity has the same zero on all motions
            same = any(c.found.name == "gravity" and c.score > THRESHOLD for c in contenders)
            waves = [c for c in contenders if c.found.period is not None and c.ratio > THRESHOLD and not same]
            top = max(waves, key=lambda c: c.ratio, default=None)
            outcome.shift = 0.0 if top is None else shift_of_zero(outcome.both, top.found, len(given), top.ratio)
            if outcome.shift:
                others = [b.moved(outcome.shift) for b in others]
                outcome.both = Evidence([*balances, *others], model, current, list(extra), tuple(free)).prepare()
                contenders = contenders_of(outcome.both, compared, len(given))

        contenders = sorted((c for c in contenders if c.score > 0), key=lambda c: -c.score)
        if others:
            outcome.refused += [(c.found.name, c.gains, c.expected) for c in contenders if c.is_contradicted]
            contenders = [c for c in contenders if not c.is_contradicted]
        contenders = one_of_each_name(contenders)
        progress("  all logs: " + "; ".join(f"{c.found.name} {c.found.label} {c.score:.0f}" for c in contenders[:5]))
        least = max([THRESHOLD, *(MINOR * one.score for one in outcome.accepted)])
        if not contenders or contenders[0].score < least:
            break

        if contenders[0].found.name == LATE:
            seconds = -float(contenders[0].found.amplitudes[0])
            balances, others = ([b.earlier(seconds) for b in logs] for logs in (balances, others))
            outcome.late += seconds
            continue
        part = shares(contenders)
        alternatives = [(c.found.name, float(p)) for c, p in zip(contenders[1:], part[1:], strict=True) if p > SHARE]
        f = owned(contenders[0].found, outcome.accepted)
        outcome.accepted.append(Accepted(f, contenders[0].score, float(part[0]), alternatives))
        current = added_to(current, f, extra, free)
        if f.name not in REPEATED:
            excluded.update(COUPLINGS if f.name in COUPLINGS else (f.name,))
    assert outcome is not None
    plain = Evidence(balances, model, current, list(extra), tuple(free), plainly=True)
    outcome.evidence = plain.prepare(3) if outcome.nominal.largely else outcome.evidence
    without_each_other(outcome.accepted)
    return outcome


def one_of_each_name(contenders: Sequence[Contender]) -> list[Contender]:
    """The best shape of each name, but no shape without a law where a law explains nearly as much.

    That is any law beside a force of any shape without a name, and one along the same coordinate beside another.
    """
    lawful = [c for c in contenders if c.found.columns is None or c.found.effect is not None]
    named = max((c.ratio for c in contenders if not c.found.name.startswith("~")), default=0.0)
    best: dict[str, Contender] = {}
    for c in contenders:
        name, has_law = c.found.name, c in lawful
        along = {name}.union(*(names for names in CELLS.values() if name in names))
        most = max((other.ratio for other in lawful if other.found.name in along), default=0.0)
        enough = named / UNNAMED if name.startswith("~") else most / NESTED
        if c.found.k > 1 and not has_law and enough >= c.ratio:
            continue
        best.setdefault(name, c)
    return sorted(best.values(), key=lambda c: -c.score)


def owned(f: Found, accepted: Sequence[Accepted]) -> Found:
    """The candidate, or, where it has no law, what it shows an accepted law of the same coordinate to lack."""
    if f.columns is None or f.effect is not None:
        return f
    taken = {one.found.name for one in accepted} - {f.name}
    names = next((names for cell, names in CELLS.items() if f.name in (cell, *names)), ())
    owner = next((name for name in names if name in taken), None)
    return f if owner is None else replace(f, name=owner, label="other shape")


def added_to(model: Model, f: Found, extra: list[Found], free: list[str]) -> Model:
    """The model with the law of a candidate; what has none, or a state, is kept as columns, a change as a free path."""
    if f.columns is None:
        free.append(f.effect)
        return model
    laws = f.laws(f.amplitudes)
    if not laws or any("state" in effect.HOOKS for effect in laws):
        extra.append(f)
        return model
    return model.replace(effects=(*model.effects, *laws))


def with_amplitudes(extra: Sequence[Found], evidence: Evidence) -> list[Found]:
    """What was accepted without a law, with its amplitudes as they are fitted beside all else."""
    at, out = len(evidence.paths), []
    for f in extra:
        k = len(f.amplitudes)
        out.append(replace(f, amplitudes=evidence.null.theta[at : at + k]))
        at += k
    return out


def without_each_other(accepted: Sequence[Accepted]) -> None:
    """Take from the alternatives of each effect what was found beside it."""
    names = {one.found.name for one in accepted}
    for one in accepted:
        apart = sum(p for name, p in one.alternatives if name in names)
        one.alternatives = [(name, p) for name, p in one.alternatives if name not in names]
        one.share = min(1.0, one.share / max(1.0 - apart, one.share))


def score_of(ratio: float, k: int, trials: int, blocks: int) -> float:
    """What is left of a gain in 2 ln likelihood after paying for k amplitudes (blocks of motion count) and trials."""
    return float(ratio - k * max(np.log1p(max(ratio, 0.0) / k), np.log(blocks)) - 2 * np.log(max(trials, 1)))


def contenders_of(evidence: Evidence, found: Sequence[Found], given: int) -> list[Contender]:
    """The candidates on all logs, compared on threads, without changes that no machine can have."""
    made = on_threads(lambda f: contender(evidence, f, given), found)
    return [c for c in made if c is not None]


@np.errstate(all="ignore")
def contender(evidence: Evidence, f: Found, given: int) -> Contender | None:
    """The candidate on all logs, the first of which are given; None for a change that no machine can have."""
    edges = block_edges(evidence)
    if f.columns is None:
        if f.effect not in evidence.paths:
            return None
        best, name = released(evidence, f.effect), f.effect.removeprefix("axis.")
        stated = getattr(evidence.given.axis, name)
        value = getattr(evidence.model.axis, name) + best.theta[evidence.paths.index(f.effect)]
        if not stated / LARGEST_CHANGE < value < stated * LARGEST_CHANGE:
            return None
        ratio = (evidence.null.cost - best.cost) / evidence.alike
        by_row = (evidence.null.by_row() - best.by_row()) / evidence.alike
        blocks = np.add.reduceat(by_row, edges)
        return Contender(f, ratio, score_of(ratio, max(f.k, 1), f.N, len(edges)), evidence.alike, blocks)
    best = evidence.maximised([b.rows(x) for b, x in zip(evidence.balances, f.columns(evidence), strict=True)])
    ratio = (best.none.cost - best.cost) / best.inflation
    by_row = (best.none.by_row() - best.by_row()) / best.inflation
    expected = best.told**2 / best.inflation
    first = sum(int(m.sum()) for m in evidence.counted[:given])
    return Contender(
        f,
        ratio,
        score_of(ratio, max(f.k, 1), f.N, len(edges)),
        best.inflation,
        np.add.reduceat(by_row, edges),
        (float(by_row[:first].sum()), float(by_row[first:].sum())),
        (float(expected[:first].sum()), float(expected[first:].sum())),
    )


def closest(evidence: Evidence, found: Sequence[Found]) -> list[Found]:
    """Those that a closer look may find to be the likeliest on all logs, the best of the given logs among them."""
    blocks = len(block_edges(evidence))

    @np.errstate(all="ignore")
    def worth(f: Found) -> float:
        if f.columns is None:
            return f.score
        tables = [b.rows(x) for b, x in zip(evidence.balances, f.columns(evidence), strict=True)]
        return score_of(evidence.quick_ratio(tables), max(f.k, 1), f.N, blocks)

    assert evidence.bases  # made once, before threads share them
    worths = on_threads(worth, found)
    near: list[Found] = []
    for f in [*found[:FIRST], *(found[k] for k in np.argsort(worths, kind="stable")[::-1])]:
        if f not in near and sum(other.name == f.name for other in near) < SHAPES:
            near.append(f)
    return near[:CLOSE]


def shift_of_zero(evidence: Evidence, f: Found, given: int, joint: float) -> float:
    """Distance (m) by which the zero of the confirm logs lies elsewhere by a wave of place; 0 where none shows.

    Args:
        evidence: all logs.
        f: wave that was found in the given logs.
        given: how many of the logs are given.
        joint: gain in 2 ln likelihood of the wave with the same zero in all logs.
    """
    tables = [b.rows(x) for b, x in zip(evidence.balances, f.columns(evidence), strict=True)]
    none = [np.zeros_like(t) for t in tables]
    pairs = enumerate(zip(tables, none, strict=True))
    best = evidence.maximised([np.vstack([t, z] if i < given else [z, t]) for i, (t, z) in pairs])
    k = len(f.amplitudes)  # sine and cosine of the longest wave stand first
    here, there = (complex(cosine, sine) for sine, cosine in best.theta[-2 * k :].reshape(2, k)[:, :2])
    alike = 0.5 < abs(there) / max(abs(here), 1e-300) < 2.0
    gain = (best.none.cost - best.cost) / best.inflation
    if not alike or f.period is None or gain < joint + THRESHOLD + 2.0 * np.log(f.N):
        return 0.0
    return float(np.angle(here / there)) * f.period / (2 * np.pi)


def released(evidence: Evidence, path: str) -> Maximum:
    """The likeliest model without what is stated of one parameter."""
    other = copy(evidence)
    other.prior_sigma = evidence.prior_sigma.copy()
    other.prior_sigma[evidence.paths.index(path)] = np.inf
    return other.maximised()


def block_edges(evidence: Evidence) -> NDArray[np.intp]:
    """First rows of the blocks of motion, none over two logs."""
    size = round(BLOCK * evidence.balances[0].rate)
    edges: list[int] = []
    at = 0
    for m in evidence.counted:
        n = int(m.sum())
        edges += list(range(at, max(at + 1, at + n - size // 2), size))
        at += n
    return np.array(edges, dtype=np.intp)


def shares(contenders: Sequence[Contender], seed: int = 1) -> FloatArray:
    """Probability of each candidate, none being one of them, averaged over motion that is resampled block by block.

    What inflations show by chance is believed every other time.
    """
    rng = np.random.default_rng(seed)
    blocks = np.array([c.blocks for c in contenders])
    stated = np.array([c.ratio - c.blocks.sum() for c in contenders])  # what agrees better with the statement
    paid = np.array([c.score - c.ratio for c in contenders])
    n = blocks.shape[1]
    weights = rng.multinomial(n, np.full(n, 1.0 / n), RESAMPLED)
    ratios = np.array([c.ratio for c in contenders])
    wrong = COLUMN_ERROR * ratios * rng.standard_normal((RESAMPLED, len(contenders)))
    chance = np.minimum([c.inflation for c in contenders], CHANCE) ** rng.integers(0, 2, (RESAMPLED, 1))
    scores = np.hstack([(weights @ blocks.T + stated) * chance + paid + wrong, np.zeros((RESAMPLED, 1))])
    odds = np.exp(0.5 * (scores - scores.max(axis=1, keepdims=True)))
    return np.asarray(np.mean(odds / odds.sum(axis=1, keepdims=True), axis=0)[:-1])
