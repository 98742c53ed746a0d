"""Effects of a user's own as candidates: what the core says that they do along the motion, at a grid of shapes."""

from __future__ import annotations

from collections.abc import Callable
from itertools import product
from typing import Any

import numpy as np

from cogging.diagnosis.balance.candidates import sharpen, span, wave_scan
from cogging.effects.effect import Effect, Wave, kind_of

GRID = 5  # values of each shape that are tried; the best is refined
SHAPES = 125  # that are tried of one effect, at most
PEAKS = 3  # of a wave's spectrum


def own_candidates(law: Effect, ctx: Any, g: Any, put: Callable[..., float]) -> None:
    """Offer an effect at its shapes: `put(name, label, columns, N, effect, refine=, period=)`.

    Args:
        law: the effect.
        ctx: evidence.
        g: what each row weighs in the score of a column (candidates.adjoint).
        put: takes a candidate.
    """
    low, high = span(ctx)
    scales = {
        "position": high - low,
        "distance": high - low,
        "velocity": max(float(np.abs(b.velocity).max()) for b in ctx.balances),
        "time": max(float(b.time[-1]) for b in ctx.balances),
        "command": max(float(np.abs(b.command).max()) for b in ctx.balances),
    }
    force = max(float(np.abs(b.command).max()) for b in ctx.balances)
    amplitudes = [name for name, role in law.ROLES.items() if role["role"] == "amplitude"]
    shapes = {
        name: role
        for name, role in law.ROLES.items()
        if role["role"] == "shape" and not isinstance(getattr(law, name), list)
    }
    tries: list[tuple[dict[str, float], Any]] = [({}, None)]
    trials = 1.0
    wave = kind_of(law, Wave)
    if wave is not None and law.ROLES[wave.shape]["quantity"] == "distance":
        every = {"command_gain": ctx.drives}.get(law.HOOKS[0], [np.ones(len(b.time)) for b in ctx.balances])
        if "reading_error" in law.HOOKS or "reading" in law.HOOKS:
            every = [b.velocity**2 for b in ctx.balances]
        peaks, trials = wave_scan(ctx, g, every, PEAKS)
        places = np.concatenate([b.position for b in ctx.balances])
        pulls = np.concatenate([row * one for row, one in zip(g, every, strict=True)])
        tries = []
        for number, _ in peaks:
            number, _ = sharpen(lambda k: abs(pulls @ np.exp(2j * np.pi * k * places)), number, 0.25 / (high - low))
            tries.append(({wave.shape: 1.0 / number}, 1.0 / number))
    elif shapes:
        count = max(2, min(GRID, int(SHAPES ** (1.0 / len(shapes)))))
        grids = []
        for role in shapes.values():
            first, last = float(role["low"]), float(role["high"])
            ratio = role["logarithmic"] and first > 0.0
            values = np.geomspace(first, last, count) if ratio else np.linspace(first, last, count)
            grids.append(values * scales.get(role["quantity"], 1.0))
        tries = [(dict(zip(shapes, map(float, one), strict=True)), None) for one in product(*grids)]
        trials = float(len(tries))
    for fields, period in tries:
        columns, effect = _columns(law, fields, amplitudes, force)
        refine = None
        if len(fields) == 1 and period is None:
            name, value = next(iter(fields.items()))

            def again(v: float, name: str = name) -> tuple[Any, Any, str]:
                return (*_columns(law, {name: float(v)}, amplitudes, force), f"{name} {v:.4g}")

            refine = (value, again) if value > 0.0 else None
        label = ", ".join(f"{name} {value:.4g}" for name, value in fields.items())
        put(law.NAME, label, columns, trials, effect, refine=refine, period=period)


def _columns(law: Effect, fields: dict[str, float], amplitudes: list[str], force: float) -> tuple[Any, Any]:
    base = law.replace(**fields)
    parts: list[tuple[str, int | None]] = []
    for name in amplitudes:
        value = getattr(base, name)
        parts += [(name, k) for k in range(len(value))] if isinstance(value, list) else [(name, None)]
    unit = 1e-2 * force

    def at(values: Any) -> Effect:
        told: dict[str, Any] = {
            name: list(getattr(base, name)) if isinstance(getattr(base, name), list) else 0.0 for name in amplitudes
        }
        for (name, k), value in zip(parts, values, strict=True):
            if k is None:
                told[name] = float(value)
            else:
                told[name][k] = float(value)
        return base.replace(**told)

    effects = [at(unit * row) for row in np.eye(len(parts))]
    reads = "reading" in law.HOOKS

    def columns(c: Any) -> list[Any]:
        if not reads:
            return [b.added(c.model, effects, u) / unit for b, u in zip(c.balances, c.drives, strict=True)]
        small = 1e-6 * (span(c)[1] - span(c)[0])
        erring = [at(small * row) for row in np.eye(len(parts))]
        none = [b.residual(c.model) for b in c.balances]
        with_each = [
            np.array([b.residual(c.model.replace(effects=(*c.model.effects, one))) for one in erring])
            for b in c.balances
        ]
        return [(before - after) / small for before, after in zip(none, with_each, strict=True)]

    return columns, at
