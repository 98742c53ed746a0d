"""From logs to a verdict."""

from __future__ import annotations

from dataclasses import dataclass, field, replace
from typing import Any

import numpy as np

from studies.balance_engine.evidence import Context
from studies.balance_engine.force_balance import ForceBalance
from studies.balance_engine.search import search_once

THRESHOLD = 16.0
SHARE = 0.05  # of the resampled motions, from which on a name is an alternative
BLOCK = 0.5  # s, of motion that is resampled
RESAMPLED = 2000
SURVIVORS = 14


@dataclass
class Contender:
    """A candidate on all logs: its log-likelihood ratio against none, and what it is worth on the confirm logs."""

    found: Any
    ratio: float
    score: float
    blocks: Any = field(repr=False, default=None)
    gain: float = 0.0
    expected: float = 0.0


def score_of(T, k, N):
    return T - k * np.log1p(max(T, 0.0) / max(k, 1)) - 2 * np.log(max(N, 1))


def prior_column(ctx, path):
    """A nuisance beyond its stated uncertainty: the pseudo-observation is released."""
    j = ctx.paths.index(path)
    sigma = list(ctx.prior_sigma)
    sigma[j] = np.inf
    return replace(ctx, prior_sigma=sigma)


def contender(ctx, f, confirm):
    """The candidate on all logs."""
    if f.columns is None:
        if f.effect not in ctx.paths:
            return None
        other = prior_column_context(ctx, f.effect)
        best = other.maximised()
        inflation = 1.0
    else:
        best = ctx.maximised([b.rows(x) for b, x in zip(ctx.balances, f.columns(ctx))])
        inflation = best.inflation
    ratio = (ctx.null.cost - best.cost) / inflation
    edges = block_edges(ctx)
    blocks = np.add.reduceat(ctx.null.by_row() - best.by_row(), edges) / inflation
    return Contender(f, ratio, score_of(ratio, max(f.k, 1), f.N), blocks)


def prior_column_context(ctx, path):
    other = replace(ctx)
    other.__dict__.update({k: v for k, v in ctx.__dict__.items() if k != "null"})
    sigma = list(ctx.prior_sigma)
    sigma[ctx.paths.index(path)] = np.inf
    other.prior_sigma = sigma
    return other


def block_edges(ctx):
    """First rows of the blocks of motion, none over two logs."""
    size = round(BLOCK * ctx.balances[0].rate)
    edges, at = [], 0
    for m in ctx.masks:
        n = int(ctx.counted(m).sum())
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


def frozen(ctx, f):
    """What the frozen candidate gains here, and what it would gain if it were right."""
    if f.columns is None:
        return 0.0, 0.0
    c = ctx.project([b.rows(x) for b, x in zip(ctx.balances, f.columns(ctx))])
    one = f.amplitudes @ c
    return float(2 * one @ ctx.e_full - one @ one), float(one @ one)


def run(given, confirm, model, log=None):
    width, q = model.axis.coulomb_width, model.encoder.resolution
    G = [ForceBalance(x, width, q) for x in given]
    C = [ForceBalance(x, width, q) for x in confirm]
    extra, free, terms, refused = [], [], [], []
    g_model = model
    excluded = set()
    for step in range(6):
        ctx = Context(G, g_model, list(extra), start_model=model, nuisance_free=tuple(free))
        ctx.prepare(2 if step == 0 else 3)
        g_model = ctx.model
        for b in C:
            b.corner = G[0].corner
        at = ctx.extra_at
        for n, f in enumerate(extra):
            k = len(f.amplitudes)
            extra[n] = replace(f, amplitudes=ctx.theta[at : at + k])
            at += k
        ctx.settle()
        found = [f for f in search_once(ctx) if f.name not in excluded]
        if log:
            log(f"   step {step}: " + "; ".join(f"{f.name} {f.label} T {f.T:.0f} s {f.score:.0f}" for f in found[:5]))
        found = [f for f in found if f.T > 6][:SURVIVORS]
        both = ctx
        if C:
            both = Context(G + C, g_model, list(extra), start_model=model, nuisance_free=tuple(free), taps=ctx.taps)
            both.prepare_once()
        contenders = [c for f in found if (c := contender(both, f, C)) is not None]
        if log:
            log(
                "      joint: "
                + "; ".join(
                    f"{c.found.name} {c.found.label} {c.ratio:.0f} s {c.score:.0f}"
                    for c in sorted(contenders, key=lambda t: -t.score)[:6]
                )
            )
        contenders = [c for c in contenders if c.score > 0]
        if not contenders or max(c.score for c in contenders) < THRESHOLD:
            break
        if C:
            cc = Context(C, g_model, list(extra), start_model=model, nuisance_free=tuple(free), taps=both.null.taps)
            cc.frozen = True
            cc.prepare_once()
            kept = []
            for c in contenders:
                c.gain, c.expected = frozen(cc, c.found)
                if c.expected > 10 and c.gain < 0.0:
                    refused.append((c.found.name, f"gain {c.gain:.0f} of {c.expected:.0f}"))
                    if log:
                        log(f"      refused {refused[-1]}")
                else:
                    kept.append(c)
            contenders = kept
        contenders.sort(key=lambda c: -c.score)
        if not contenders or contenders[0].score < THRESHOLD:
            break
        part = shares(contenders)
        top = contenders[0]
        if log:
            log("      shares: " + "; ".join(f"{c.found.name} {p:.2f}" for c, p in zip(contenders, part) if p > 0.01))
        alternatives = [(c.found.name, float(p)) for c, p in zip(contenders[1:], part[1:]) if p > SHARE]
        f = top.found
        terms.append((f, top.score, float(part[0]), alternatives))
        if f.columns is None:
            free.append(f.effect)
        else:
            effect = f.effect(f.amplitudes) if f.effect is not None else None
            if effect is None or "state" in effect.HOOKS:
                extra.append(f)
            else:
                g_model = g_model.replace(effects=(*g_model.effects, effect))
        if f.name.startswith("~"):
            excluded.add(f.name)
    return verdict(terms, refused)


def verdict(terms, refused):
    """Names with what they are worth."""
    effects, unlisted = [], None
    for f, _, share, alternatives in terms:
        names = [f.name, *(n for n, _ in alternatives)]
        if f.name.startswith("~"):
            unlisted = unlisted or f.name
            continue
        others = [n for n in names[1:] if not n.startswith("~")]
        effects.append(
            {"name": f.name, "alternatives": others, "confidence": share, "parameters": {}, "where": None}
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
