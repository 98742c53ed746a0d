"""From logs to a verdict."""

from __future__ import annotations

from copy import copy
from dataclasses import dataclass, field, replace
from functools import partial
from typing import Any

import numpy as np

from cogging.diagnosis.balance.evidence import Evidence
from cogging.diagnosis.balance.force_balance import ForceBalance
from cogging.diagnosis.balance.candidates import CELLS, NESTED, Found, search_once
from cogging.diagnosis.balance.own_laws import own_candidates

THRESHOLD = 16.0
SHARE = 0.05  # of the resampled motions, from which on a name is an alternative
BLOCK = 0.5  # s, of motion that is resampled
RESAMPLED = 2000
STEPS = 6  # effects, at most, and a last look at what is left
SURVIVORS = 24  # of the screen
CLOSE = 7  # of these, whose noise filters are their own
BURST = 6.0  # deviations from which on noise comes and goes
SHOWN = 10.0  # expected gain from which on logs can refute
LARGEST_CHANGE = 10.0  # of mass or friction against what is stated, as a factor either way
REPEATED = ("cogging_harmonic", "disturbance_tone", "disturbance_step", "force_constant_ripple")


BURSTS = Found("~noise in time", "", 0.0, 0, 1, np.zeros(0), None)


@dataclass
class Contender:
    """A candidate on all logs: its log-likelihood ratio against none, and what it is worth on the confirm logs."""

    found: Any
    ratio: float
    score: float
    blocks: Any = field(repr=False, default=None)
    gains: tuple = (0.0, 0.0)  # on given and confirm logs
    expected: tuple = (0.0, 0.0)  # of the same, if it is right

    @property
    def refuted(self):
        """Logs that can show it show the contrary."""
        return any(e > SHOWN and g < 0.0 for g, e in zip(self.gains, self.expected))


def score_of(ratio, k, N, blocks):
    """What is left of a log-likelihood ratio after paying for k amplitudes (blocks of motion count) and N trials."""
    return ratio - k * max(np.log1p(max(ratio, 0.0) / k), np.log(blocks)) - 2 * np.log(max(N, 1))


def contender(ctx, f, given):
    """The candidate on all logs."""
    if f.columns is None:
        if f.effect not in ctx.paths:
            return None
        best = released(ctx, f.effect)
        stated = getattr(ctx.given.axis, f.effect.removeprefix("axis."))
        value = getattr(ctx.model.axis, f.effect.removeprefix("axis.")) + best.theta[ctx.paths.index(f.effect)]
        if not stated / LARGEST_CHANGE < value < stated * LARGEST_CHANGE:
            return None
        best.none, inflation = ctx.null, 1.0
    else:
        best = ctx.maximised([b.rows(x) for b, x in zip(ctx.balances, f.columns(ctx))])
        inflation = best.inflation
    ratio = (best.none.cost - best.cost) / inflation
    edges = block_edges(ctx)
    by_row = (best.none.by_row() - best.by_row()) / inflation
    one = Contender(f, ratio, score_of(ratio, max(f.k, 1), f.N, len(edges)), np.add.reduceat(by_row, edges))
    if f.columns is not None:
        first = sum(int(m.sum()) for m in ctx.counted[:given])
        one.gains = float(by_row[:first].sum()), float(by_row[first:].sum())
        told = best.told**2 / inflation
        one.expected = float(told[:first].sum()), float(told[first:].sum())
    return one


def closest(both, found):
    """Those of whom a closer look may find that they are the likeliest on all logs."""

    def worth(f):
        if f.columns is None:
            return f.score
        tables = [b.rows(x) for b, x in zip(both.balances, f.columns(both))]
        ratio = both.glance(tables)
        return score_of(ratio, max(f.k, 1), f.N, len(block_edges(both)))

    return sorted(found, key=worth, reverse=True)[:CLOSE]


def shift_of_zero(both, f, given, joint):
    """Distance (m) by which the zero of the confirm logs lies elsewhere, as a wave of place tells it; 0 where it does not.

    Args:
        both: all logs.
        f: wave that was found in the given logs.
        given: how many of the logs are given.
        joint: log-likelihood ratio of the wave with the same zero in all logs.
    """
    tables = [b.rows(x) for b, x in zip(both.balances, f.columns(both))]
    none = [np.zeros_like(t) for t in tables]
    apart = [np.vstack([t, z] if i < given else [z, t]) for i, (t, z) in enumerate(zip(tables, none))]
    best = both.maximised(apart)
    here, there = (complex(*best.theta[at : at + 2][::-1]) for at in (-4, -2))
    alike = 0.5 < abs(there) / max(abs(here), 1e-300) < 2.0
    if not alike or (best.none.cost - best.cost) / best.inflation < joint + THRESHOLD + 2.0 * np.log(f.N):
        return 0.0
    return float(np.angle(here / there)) * f.period / (2 * np.pi)


def released(ctx, path):
    """The likeliest null without what is stated of one parameter."""
    other = copy(ctx)
    other.prior_sigma = ctx.prior_sigma.copy()
    other.prior_sigma[ctx.paths.index(path)] = np.inf
    return other.maximised()


def block_edges(ctx):
    """First rows of the blocks of motion, none over two logs."""
    size = round(BLOCK * ctx.balances[0].rate)
    edges, at = [], 0
    for m in ctx.counted:
        n = int(m.sum())
        edges += list(range(at, max(at + 1, at + n - size // 2), size))
        at += n
    return np.array(edges)


def shares(contenders, seed=1):
    """How often each candidate is the likeliest, and how often none is, when the motion is resampled block by block."""
    rng = np.random.default_rng(seed)
    blocks = np.array([c.blocks for c in contenders])
    extra = np.array([c.score - c.blocks.sum() for c in contenders])
    n = blocks.shape[1]
    weights = rng.multinomial(n, np.full(n, 1.0 / n), RESAMPLED)
    scores = weights @ blocks.T + extra
    best = np.argmax(np.hstack([scores, np.zeros((RESAMPLED, 1))]), axis=1)
    return np.bincount(best, minlength=len(contenders) + 1)[:-1] / RESAMPLED


def bursts(ctx):
    """Largest excess of the power of what is left over 0.05 to 0.2 s, in deviations; rows near standstill do not count.

    Held packets, lost counts and bursts have no force of their own: they show as noise that comes and goes.
    """
    worst, at = 0.0, 0
    unit = ctx.null.rest / np.sqrt(ctx.null.variance)
    for b, counted in zip(ctx.balances, ctx.counted):
        n = int(counted.sum())
        power, speed = np.minimum(unit[at : at + n] ** 2, 9.0), np.abs(b.velocity[:: b.every][counted])
        at += n
        fast = speed > 0.1 * speed.max()
        for seconds in (0.05, 0.2):
            size = round(seconds * b.rate)
            count = n // size
            whole = fast[: count * size].reshape(count, size).mean(axis=1) > 0.9
            if whole.sum() < 8:
                continue
            level = power[: count * size].reshape(count, size).mean(axis=1)[whole]
            middle = np.median(level)
            spread = max(1.4826 * np.median(np.abs(level - middle)), np.std(power[fast]) / np.sqrt(size))
            worst = max(worst, float((level.max() - middle) / spread))
    return worst


@dataclass
class Accepted:
    """What was taken into the model.

    Attributes:
        found: candidate, with the amplitudes of its columns; `effect(amplitudes)` is its law, None without one.
        score: log-likelihood ratio less what its amplitudes and its scan cost.
        share: how often it is the likeliest on copies of the motion.
        alternatives: other names with the same.
        before, after: model without and with it, re-tuned.
    """

    found: Found
    score: float
    share: float
    alternatives: list
    before: Any
    after: Any = None


@dataclass
class Outcome:
    """What the search came to.

    Attributes:
        nominal: evidence of the given logs under the re-tuned model, before anything was added.
        evidence: the same with all that was accepted: `model` holds what has a law, `extra` what has none.
        both: given and confirm logs together, with all that was accepted; `evidence` without confirm logs.
        accepted: what was added, in the order of its weight.
        refused: (name, gains on given and confirm logs, what these can show) of what the logs contradict.
        found: last candidates, the likeliest first.
        shift: distance by which the zero of the confirm logs lies elsewhere, m.
    """

    nominal: Evidence
    evidence: Evidence
    both: Evidence
    accepted: list
    refused: list
    found: list
    shift: float = 0.0


def search(given, confirm, model, log=None, also=()):
    offers = [partial(own_candidates, law) for law in also]
    width, q = model.axis.coulomb_width, model.encoder.resolution
    G = [ForceBalance(x, width, q) for x in given]
    C = [ForceBalance(x, width, q) for x in confirm]
    extra, free, accepted, refused = [], [], [], []
    g_model, nominal, shift = model, None, 0.0
    excluded = set()
    for step in range(STEPS):
        ctx = Evidence(G, model, g_model, list(extra), tuple(free)).prepare(2 if step == 0 else 3, listen=step == 0)
        g_model = ctx.model
        if step == 0:
            nominal = ctx
            for b in C:
                b.hear(b.residual(g_model), g_model.axis.mass)
        if accepted:
            accepted[-1].after = g_model
        at = len(ctx.paths)
        for n, f in enumerate(extra):
            k = len(f.amplitudes)
            extra[n] = replace(f, amplitudes=ctx.null.theta[at : at + k])
            at += k
        found = [f for f in search_once(ctx, offers) if f.name not in excluded]
        if log:
            log(f"   step {step}: " + "; ".join(f"{f.name} {f.label} T {f.T:.0f} s {f.score:.0f}" for f in found[:5]))
        outcome = Outcome(nominal, ctx, ctx, accepted, refused, found, shift)
        both = ctx
        if C:
            both = outcome.both = Evidence(G + C, model, g_model, list(extra), tuple(free)).prepare()
        if step == STEPS - 1:
            break
        found = [f for f in found if f.T > max(4.0, 0.1 * found[0].T)][:SURVIVORS]
        found = closest(both, found)
        contenders = [c for f in found if (c := contender(both, f, len(G))) is not None]
        waves = [c for c in contenders if c.found.period is not None and c.found.T > 2.0 * c.ratio + THRESHOLD]
        if C and waves and not shift and model.cogging is None:
            top = max(waves, key=lambda c: c.found.T)
            distance = shift_of_zero(both, top.found, len(G), top.ratio)
            if distance:
                shift, C = distance, [b.moved(distance) for b in C]
                if log:
                    log(f"      zero of the confirm logs moved by {distance:.4g}")
                both = outcome.both = Evidence(G + C, model, g_model, list(extra), tuple(free)).prepare()
                contenders = [c for f in found if (c := contender(both, f, len(G))) is not None]
        if log:
            log(
                "      joint: "
                + "; ".join(
                    f"{c.found.name} {c.found.label} {c.ratio:.0f} s {c.score:.0f} ({c.gains[0]:.0f}/{c.expected[0]:.0f} {c.gains[1]:.0f}/{c.expected[1]:.0f})"
                    for c in sorted(contenders, key=lambda t: -t.score)[:6]
                )
            )
        contenders = [c for c in contenders if c.score > 0]
        if C:
            for c in contenders:
                if c.refuted:
                    refused.append((c.found.name, c.gains, c.expected))
                    if log:
                        log(f"      refused {c.found.name} {np.round(c.gains)} of {np.round(c.expected)}")
            contenders = [c for c in contenders if not c.refuted]
        by = {c.found.name: c.ratio for c in contenders}
        contenders = [
            c
            for c in contenders
            if max((by.get(n, 0.0) for n in CELLS.get(c.found.name, ())), default=0.0) < NESTED * c.ratio
        ]
        contenders.sort(key=lambda c: -c.score)
        if not contenders or contenders[0].score < THRESHOLD:
            if bursts(both) > BURST and not any(b.coarse for b in G + C):
                accepted.append(Accepted(BURSTS, 0.0, 1.0, [], g_model, g_model))
            break
        part = shares(contenders)
        top = contenders[0]
        if log:
            log("      shares: " + "; ".join(f"{c.found.name} {p:.2f}" for c, p in zip(contenders, part) if p > 0.01))
        alternatives = [(c.found.name, float(p)) for c, p in zip(contenders[1:], part[1:]) if p > SHARE]
        f = top.found
        accepted.append(Accepted(f, top.score, float(part[0]), alternatives, g_model))
        if f.columns is None:
            free.append(f.effect)
        else:
            effect = f.effect(f.amplitudes) if f.effect is not None else None
            if effect is None or "state" in effect.HOOKS:
                extra.append(f)
            else:
                g_model = g_model.replace(effects=(*g_model.effects, effect))
        if f.name not in REPEATED:
            excluded.add(f.name)
    return outcome


def run(given, confirm, model, log=None):
    """Names with what they are worth, for the bench."""
    return verdict(search(given, confirm, model, log).accepted)


def verdict(accepted):
    """Names with what they are worth."""
    effects, unlisted = [], None
    for one in accepted:
        f = one.found
        names = list(dict.fromkeys([f.name, *(n for n, _ in one.alternatives), *f.others]))
        if f.name.startswith("~"):
            unlisted = unlisted or f.name
            continue
        others = [n for n in names[1:] if not n.startswith("~")]
        effects.append(
            {"name": f.name, "alternatives": others, "confidence": one.share, "parameters": {}, "where": None}
        )
    merged = {}
    for e in effects:
        merged.setdefault(e["name"], e)
    effects = list(merged.values())
    if unlisted:
        v = "unlisted"
        for e in effects:
            e["confidence"] = min(e["confidence"], 0.85)
    elif not effects:
        v = "no_gap"
    elif all(e["confidence"] >= 0.9 for e in effects):
        v = "named"
    else:
        v = "ambiguous"
    return {"verdict": v, "effects": effects, "unlisted": unlisted, "gap": {}}
