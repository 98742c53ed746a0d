"""From logs to a verdict."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from studies.balance_engine.evidence import Context
from studies.balance_engine.force_balance import ForceBalance
from studies.balance_engine.search import search_once

THRESHOLD = 16.0
MARGIN = 9.2


def context(balances, model, extra=(), start=None, free=(), taps=None, frozen=False):
    return Context(
        balances, model, extra=list(extra), start_model=start, nuisance_free=tuple(free), taps=taps, frozen=frozen
    )


def score_of(T, k, N):
    return T - k * np.log1p(T / max(k, 1)) - 2 * np.log(max(N, 1))


def joint(ctx, f):
    """Score of a candidate in another context."""
    if f.columns is None:
        path = f.effect
        j = ctx.paths.index(path)
        finite = [i for i, q in enumerate(ctx.prior_sigma) if np.isfinite(q)]
        c = np.zeros(len(ctx.e_full))
        c[ctx.rows + finite.index(j)] = 1.0
        c -= ctx.Q @ (ctx.Q.T @ c)
        T = float((c @ ctx.e_full) ** 2 / max(c @ c, 1e-12))
        return T, np.zeros(1), np.zeros((1, 1)), 1
    return ctx.score_columns(f.columns(ctx))


def frozen(ctx, f):
    """What the frozen candidate is worth here, 2 ln L, and what it would be worth if it were right."""
    if f.columns is None:
        return 0.0, 0.0
    c = ctx.project([b.rows(x) for b, x in zip(ctx.balances, f.columns(ctx))])
    one = f.amplitudes @ c
    return float(2 * one @ ctx.e_full - one @ one), float(one @ one)


def run(given, confirm, model, log=None):
    width, q = model.axis.coulomb_width, model.encoder.resolution
    G = [ForceBalance(x, width, q) for x in given]
    C = [ForceBalance(x, width, q) for x in confirm]
    start, extra, free, terms, refused = model, [], [], [], []
    for b in G[1:]:
        b.corner = G[0].corner
    g_model = model
    excluded = set()
    for step in range(5):
        ctx = context(G, g_model, extra, start, free).prepare(2 if step == 0 else 3)
        g_model = ctx.model
        for b in C:
            b.corner = G[0].corner
        at = ctx.extra_at
        for n, f in enumerate(extra):
            k = len(f.amplitudes)
            extra[n] = replace(f, amplitudes=ctx.theta[at : at + k])
            at += k
        found = [f for f in search_once(ctx) if f.name not in excluded]
        if found[0].score > THRESHOLD:
            ctx = ctx.suspecting(found[0])
            found = [f for f in search_once(ctx) if f.name not in excluded]
        best = found[0]
        if log:
            log(f"   step {step}: " + "; ".join(f"{f.name} {f.label} T {f.T:.0f} s {f.score:.0f}" for f in found[:4]))
        if best.score < THRESHOLD:
            break
        cc = context(C, g_model, extra, start, free, taps=ctx.taps, frozen=True).prepare() if C else None
        both = context(G + C, g_model, extra, start, free, taps=ctx.taps).prepare(1) if C else ctx
        contenders = []
        for f in found:
            if f.score < max(THRESHOLD, best.score - max(25.0, 0.3 * best.score)):
                continue
            if both is ctx:
                contenders.append((f.score, f, 0.0, 0.0))
                continue
            T, amp, cov, k = joint(both, f)
            gain, expected = frozen(cc, f)
            if expected > 10 and gain < 0.0:
                refused.append((f.name, f"gain {gain:.0f} of {expected:.0f}"))
                continue
            contenders.append((score_of(T, k, f.N), f, gain, expected))
        if log:
            log(
                "      joint: "
                + "; ".join(
                    f"{f.name} {s:.0f} ({g:.0f}/{e:.0f})" for s, f, g, e in sorted(contenders, key=lambda t: -t[0])[:5]
                )
                + "  refused "
                + str(refused[-4:])
            )
        if not contenders:
            excluded |= {name for name, _ in refused}
            continue
        contenders.sort(key=lambda t: -t[0])
        top = contenders[0]
        if top[0] < THRESHOLD:
            excluded |= {f.name for _, f, *_ in contenders}
            continue
        alternatives = [f.name for s, f, *_ in contenders[1:] if s > top[0] - MARGIN]
        f = top[1]
        terms.append((f, top[0], alternatives))
        if f.columns is None:
            free.append(f.effect)
        else:
            effect = f.effect(f.amplitudes) if f.effect is not None else None
            if effect is None or "state" in effect.HOOKS:
                extra.append(f)
            else:
                g_model = g_model.replace(effects=(*g_model.effects, effect))
        excluded.add(f.name) if f.name.startswith("~") else None
    else:
        found = []
    return verdict(terms, refused)


def verdict(terms, refused):
    effects = []
    unlisted = None
    for f, score, alternatives in terms:
        names = [n for n in [f.name, *alternatives] if not n.startswith("~")]
        if f.name.startswith("~"):
            unlisted = f.name
            continue
        confidence = 0.95 if not alternatives else 0.6
        effects.append(
            {"name": names[0], "alternatives": names[1:], "confidence": confidence, "parameters": {}, "where": None}
        )
    merged = {}
    for e in effects:
        merged.setdefault(e["name"], e)
    effects = list(merged.values())
    if unlisted:
        v = "unlisted"
    elif not effects:
        v = "no_gap"
    elif all(e["confidence"] >= 0.9 for e in effects):
        v = "named"
    else:
        v = "ambiguous"
    return {"verdict": v, "effects": effects, "unlisted": unlisted, "gap": {}}
