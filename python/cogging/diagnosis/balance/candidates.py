"""Search: candidates of all names, their scores, and what is accepted."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from scipy.signal import freqz, lfilter, oaconvolve

from cogging.effects.effect import VOCABULARY
from cogging.estimation.residuals import quiet_plant
from cogging.diagnosis.balance.cells import dahl, hats, load_answer, splines

E = VOCABULARY


@dataclass
class Found:
    """The best shape of one name."""

    name: str
    label: str
    T: float
    k: int
    N: int
    amplitudes: Any
    columns: Any  # function(ctx) -> per-log columns at the middle rate
    effect: Any = None  # function(amplitudes) -> Effect or None
    others: tuple = ()  # names that a shape of no law may bear as well
    period: Any = None  # of a wave along the travel, of two columns
    refine: Any = None  # (value, function value -> (columns, effect, label))

    @property
    def score(self):
        return self.T - self.k * np.log1p(self.T / max(self.k, 1)) - 2 * np.log(max(self.N, 1))


def span(ctx):
    low = min(x.position.min() for x in ctx.balances)
    high = max(x.position.max() for x in ctx.balances)
    return low, high


def adjoint(ctx):
    """What each middle row of each log weighs in the score of a column, lists of (n,)."""
    root, _, e = ctx.basis
    weighed, out, at = root * e[: len(root)], [], 0
    for b, counted, taps in zip(ctx.balances, ctx.counted, ctx.screen.taps):
        full = np.zeros(len(counted))
        full[counted] = weighed[at : at + int(counted.sum())]
        at += int(counted.sum())
        out.append(b.adjoint(oaconvolve(full[::-1], taps)[: len(full)][::-1]))
    return out


def gain_of(ctx, f):
    """Power gain of low-pass filter, decimation and whitening at frequency f (Hz)."""
    b = ctx.balances[0]
    folded = np.abs((np.asarray(f) + 0.5 * b.rate) % b.rate - 0.5 * b.rate)
    _, h = freqz(ctx.screen.taps[0], 1.0, np.ravel(folded / b.rate * 2 * np.pi))
    return np.abs(h.reshape(np.shape(f))) ** 2 / ctx.screen.variance * b.power(np.asarray(f))


def wave_scan(ctx, g, multipliers, count, low_turns=0.7):
    """Wavenumbers (1/m) of the highest peaks of multiplier * wave along the travel."""
    low, high = span(ctx)
    length = high - low
    top_speed = max(np.abs(b.velocity).max() for b in ctx.balances)
    quantum = 4e-4
    n = int(2 ** np.ceil(np.log2(max(256, min(length / quantum, 2**17) * 4))))
    dx = length * 1.0 / (n // 8)
    grid = np.zeros(n)
    for b, gi, m in zip(ctx.balances, g, multipliers):
        p = (b.position - low) / dx
        i = p.astype(int)
        fr = p - i
        np.add.at(grid, i, gi * m * (1 - fr))
        np.add.at(grid, i + 1, gi * m * fr)
    spectrum = np.abs(np.fft.rfft(grid)) ** 2
    kappa = np.fft.rfftfreq(n, dx)
    # norm
    speeds, weight = [], []
    for b, m in zip(ctx.balances, multipliers):
        keep = np.repeat(b.mask, b.every)[: len(b.time)]
        keep = np.pad(keep, (0, len(b.time) - len(keep)))
        speeds.append(np.abs(b.velocity)[keep])
        weight.append((m**2)[keep])
    speeds, weight = np.concatenate(speeds), np.concatenate(weight)
    hist, edges = np.histogram(speeds, bins=60, range=(0, top_speed * 1.0001), weights=weight)
    mid = 0.5 * (edges[1:] + edges[:-1])
    use = (kappa > low_turns / length) & (kappa < 0.25 / dx)
    # below 0.3 mm nothing is scanned
    use &= kappa < 2500.0
    k = kappa[use]
    norm = np.zeros(len(k))
    table_f = np.linspace(0.0, 0.5 / ctx.balances[0].step, 4096)
    table_g = gain_of(ctx, table_f)
    for h, v in zip(hist, mid):
        if h > 0:
            norm += h * np.interp(k * v, table_f, table_g)
    score = 2 * spectrum[use] / np.maximum(norm, 1e-9 * norm.max())
    # a wave that is hardly ever in the band shows nothing
    score[norm < 1e-3 * norm.max()] = 0
    peaks = []
    s = score.copy()
    for _ in range(count):
        j = int(np.argmax(s))
        if s[j] <= 0:
            break
        peaks.append((float(k[j]), float(score[j])))
        s[np.abs(k - k[j]) < 1.0 / length] = 0
    return peaks, int(max(10, (k[-1] - k[0]) * length))


def sharpen(f, x, step, rounds=7):
    """The maximum of f near x."""
    best = f(x)
    for _ in range(rounds):
        moved = False
        for d in (-step, step):
            t = f(x + d)
            if t > best:
                best, x, moved = t, x + d, True
                break
        if not moved:
            step *= 0.5
    return x, best


def search_once(ctx, also=(), limit_time=None):
    """The best shape of each name, and of each cell without one, what scores highest first."""
    bs = ctx.balances
    g = adjoint(ctx)
    u = ctx.drives
    low, high = span(ctx)
    length = high - low
    top = max(np.abs(b.velocity).max() for b in bs)
    duration = max(b.time[-1] for b in bs)
    model = ctx.model
    found = {}

    def put(name, label, columns, N, effect=None, amplitude_ok=None, refine=None, period=None):
        T, amp, k = ctx.score([b.rows(x) for b, x in zip(bs, columns(ctx))])
        if amplitude_ok is not None and not amplitude_ok(amp):
            return 0.0
        one = Found(name, label, T, k, N, amp, columns, effect, period=period, refine=refine)
        if name not in found or one.score > found[name].score:
            found[name] = one
        return one.T

    def added(make, unit):
        return lambda c: [b.added(c.model, make, d) / np.asarray(unit)[:, None] for b, d in zip(c.balances, c.drives)]

    def law(name, fields, amplitudes, units, N, label="", refine=None, **more):
        """A built-in law at one shape; amplitudes: names of fields."""
        if refine is not None:
            value = fields[refine]

            def again(v):
                return lawed(name, {**fields, refine: float(v)}, amplitudes, units)

            more["refine"] = (value, again)
        columns, effect, _ = lawed(name, fields, amplitudes, units)
        return put(name, label, columns, N, effect, **more)

    def lawed(name, fields, amplitudes, units):
        base = E[name].replace(**fields)
        effects = [base.replace(**{a: un}) for a, un in zip(amplitudes, units)]

        def effect(values):
            return base.replace(**dict(zip(amplitudes, map(float, values))))

        return (
            added(effects, units),
            effect,
            ", ".join(f"{k} {v:.4g}" for k, v in fields.items() if isinstance(v, float)),
        )

    force = max(np.abs(b.command).max() for b in bs)
    S = lambda b: np.sign(b.velocity) * np.minimum(np.abs(b.velocity) / max(b.speed_noise, 1e-12) / 3, 1.0)  # noqa: E731

    def free(name, value, make, N, effect, **more):
        """A candidate with one number that is refined."""
        return put(
            name,
            f"{value:.4g}",
            make(value),
            N,
            effect(value),
            refine=(value, lambda v: (make(v), effect(v), f"{v:.4g}")),
            **more,
        )

    # forces of place -------------------------------------------------------------------------------
    law("constant_force", {}, ["force"], [0.01 * force], 1)
    law("cable_spring", {"center": 0.5 * (low + high)}, ["stiffness"], [0.01 * force / length], 1, "linear")
    put(
        "cable_spring",
        "with offset",
        lambda c: [np.vstack([b.position - 0.5 * (low + high), np.ones(len(b.time))]) for b in c.balances],
        1,
        lambda a: E["cable_spring"].replace(
            stiffness=-float(a[0]), center=0.5 * (low + high) - float(a[1]) / (float(a[0]) or 1e-300) if a[0] else 0.0
        ),
    )
    share = lambda b: 2 * (b.position - low) / length - 1  # noqa: E731
    put("cable_spring", "curved", lambda c: [np.vstack([share(b) ** p for p in range(4)]) for b in c.balances], 1)
    travel = list(model.axis.travel) if np.isfinite(model.axis.travel).all() else [low, high]
    for L in np.geomspace(0.01, 0.25, 8) * length:
        law(
            "end_effect",
            {"decay_length": float(L), "travel": travel},
            ["force"],
            [0.01 * force],
            8,
            f"{L:.3g}",
            refine="decay_length",
        )
        put(
            "end_effect",
            f"two sides {L:.3g}",
            lambda c, L=L: [
                np.vstack([np.exp(-(b.position - low) / L), np.exp(-(high - b.position) / L)]) for b in c.balances
            ],
            8,
        )
    grid = np.linspace(low, high, 33)
    for w in (0.02, 0.05):
        widths = w * length
        table = [np.array([np.exp(-(((b.position - x) / widths) ** 2)) for x in grid[1:-1]]) for b in bs]
        cs, _ = ctx.project([b.rows(t) for b, t in zip(bs, table)])
        size = np.linalg.norm(cs, axis=1) + 1e-300
        e = ctx.basis[2]
        j = int(np.argmax(np.where(size > 0.2 * size.max(), ((cs @ e) / size) ** 2, 0)))
        put(
            "local_force",
            f"{grid[1 + j]:.4g} {widths:.3g}",
            lambda c, x=grid[1 + j], widths=widths: [
                np.exp(-(((b.position - x) / widths) ** 2))[None] for b in c.balances
            ],
            62,
        )
    # friction ----------------------------------------------------------------------------------------
    unit_f = 1e-3 * max(model.axis.coulomb, 1e-3 * force)
    law("coulomb_asymmetry", {}, ["difference"], [unit_f], 1)
    law("viscous_asymmetry", {}, ["difference"], [unit_f / top], 1)
    positive = lambda a: a[0] > 0  # noqa: E731
    for v in np.geomspace(max(2e-3 * top, 2 * min(b.speed_noise for b in bs)), 0.3 * top, 8):
        for ex in (1.0, 2.0):
            law(
                "stribeck_friction",
                {"velocity": float(v), "exponent": ex},
                ["static_excess"],
                [unit_f],
                16,
                f"{v:.3g} {ex}",
                amplitude_ok=positive,
                refine="velocity",
            )
    for count in (3, 5, 8):
        nodes = [float(x) for x in np.linspace(low, high, count)]
        law_pdf(ctx, put, added, nodes, unit_f, N=3)
    law("quadratic_drag", {}, ["coefficient"], [1e-3 * force / top**2], 1)

    def powers(c):
        return [
            np.vstack([-np.sign(b.velocity) * (np.abs(b.velocity) / top) ** p for p in (1.5, 2.0, 3.0)])
            for b in c.balances
        ]

    put("quadratic_drag", "other shape", powers, 1)
    low_speeds = top * np.geomspace(2e-3, 0.2, 5)

    def slow_friction(c):
        return [
            hats(np.log(np.maximum(np.abs(b.velocity), low_speeds[0])), np.log(low_speeds))[:-1] * S(b)
            for b in c.balances
        ]

    put("stribeck_friction", "other shape", slow_friction, 1, amplitude_ok=lambda a: np.sum(a) < 0)
    for p in (1.5, 3.0):
        put(
            "quadratic_drag",
            f"power {p}",
            lambda c, p=p: [(-np.sign(b.velocity) * (np.abs(b.velocity) / top) ** p)[None] for b in c.balances],
            3,
        )
    for L in np.geomspace(max(1e-6, 12 * min(b.encoder_noise for b in bs)), 3e-3, 8):
        free(
            "presliding_friction",
            L,
            lambda L: (
                lambda c: [
                    -(
                        c.model.axis.coulomb
                        * (dahl(b.position, L) - np.tanh(b.velocity / max(c.model.axis.coulomb_width, 1e-6)))
                    )[None]
                    for b in c.balances
                ]
            ),
            8,
            lambda L: lambda a: E["presliding_friction"].replace(stiffness=float(model.axis.coulomb / L)),
            amplitude_ok=lambda a: 0.3 < a[0] < 3,
        )
    # command -------------------------------------------------------------------------------------------
    shift = lambda c, b, d, tau: np.interp(b.time - tau, b.time, d) - d  # noqa: E731
    h = float(np.median(np.diff(bs[0].log.time)))
    t1 = put(
        "command_delay",
        "slope",
        lambda c: [-np.diff(d, prepend=d[0])[None] / b.step for b, d in zip(c.balances, c.drives)],
        1,
        lambda a: E["command_delay"].replace(delay=float(a[0])),
        amplitude_ok=lambda a: a[0] > 0.25 * h,
    )
    if t1 and "command_delay" in found:
        base = float(found["command_delay"].amplitudes[0])
        for f in (0.7, 1.0, 1.4):
            put(
                "command_delay",
                f"{f * base:.3g}",
                lambda c, t=f * base: [shift(c, b, d, t)[None] for b, d in zip(c.balances, c.drives)],
                3,
                lambda a, t=f * base: E["command_delay"].replace(delay=float(t * a[0])),
                amplitude_ok=lambda a, t=f * base: a[0] * t > 0.25 * h,
            )
            put(
                "actuator_lag",
                f"{f * base:.3g}",
                lambda c, t=f * base: [lag(d, b.step, t)[None] for b, d in zip(c.balances, c.drives)],
                3,
                lambda a, t=f * base: E["actuator_lag"].replace(time_constant=float(t * a[0])),
                amplitude_ok=lambda a, t=f * base: a[0] * t > 0.25 * h,
            )
    peak = force
    for s in (0.95, 0.85, 0.7, 0.5, 0.3):
        L = s * peak
        free(
            "command_saturation",
            L,
            lambda L: lambda c: [(np.clip(b.command, -L, L) - b.command)[None] for b in c.balances],
            5,
            lambda L: lambda a: E["command_saturation"].replace(limit=float(L)),
            amplitude_ok=positive,
        )
    for s in np.geomspace(0.003, 0.3, 6):
        W = s * peak
        free(
            "command_dead_zone",
            W,
            lambda W: lambda c: [-np.clip(b.command, -W, W)[None] for b in c.balances],
            6,
            lambda W: lambda a: E["command_dead_zone"].replace(width=float(W * a[0])),
            amplitude_ok=lambda a: a[0] > 0.02,
        )
    for tau in np.geomspace(0.05, 2.0, 5) * duration:
        law(
            "force_constant_drift",
            {"time_constant": float(tau)},
            ["change"],
            [1e-3],
            5,
            f"{tau:.3g}",
            refine="time_constant",
        )

    # the reading ---------------------------------------------------------------------------------------
    def reading(c, b, a, error, slope, bend):
        """What an error of the reading (its slope, its bend along the travel) puts into the balance.

        The acceleration is the model's: the measured one holds the noise of its own row.
        """
        inertia = c.model.axis.mass * (slope(b.position) * a + bend(b.position) * b.velocity**2)
        plant = quiet_plant(c.model.replace(effects=()))
        return inertia + b.forces([plant], None, error(b.fine[2]))[0] - b.forces([plant])[0]

    put(
        "encoder_scale_error",
        "",
        lambda c: [
            reading(c, b, a, lambda x: 1e-3 * x, lambda x: 1e-3, lambda x: 0.0)[None] / 1e-3
            for b, a in zip(c.balances, c.accelerations)
        ],
        1,
        lambda a: E["encoder_scale_error"].replace(scale=float(a[0])),
    )
    # states --------------------------------------------------------------------------------------------
    lowest, highest = max(3.0 / duration, 2.0), min(0.25 * bs[0].rate, bs[0].corner)  # Hz

    def mode_columns(f, z):
        seen = float(f < 1.1 * highest)
        return lambda c: [
            seen * c.model.axis.mass * (a - load_answer(a, b.step, f, z))[None]
            for b, a in zip(c.balances, c.accelerations)
        ]

    def mode(f, z):
        return lambda a: E["flexible_mode"].replace(
            frequency=float(f / np.sqrt(1 - min(a[0], 0.9))),
            damping_ratio=float(z / np.sqrt(1 - min(a[0], 0.9))),
            mass_ratio=float(min(a[0], 0.9)),
        )

    for z in (0.02, 0.1, 0.3):
        fr = np.geomspace(lowest, highest, 18)
        size = np.linalg.norm(
            ctx.project(
                [np.vstack(c) for c in zip(*([b.rows(x)[0] for b, x in zip(bs, mode_columns(f, z)(ctx))] for f in fr))]
            )[0],
            axis=1,
        )
        fine = np.geomspace(lowest, highest, int(np.log(highest / lowest) / max(z, 0.02)))
        met = np.array([sum(gi @ x[0] for gi, x in zip(g, mode_columns(f, z)(ctx))) for f in fine])
        worth = np.where(met > 0, met, 0.0) / np.exp(np.interp(np.log(fine), np.log(fr), np.log(size + 1e-300)))
        for f in fine[np.argsort(-worth)[:2]]:
            put(
                "flexible_mode",
                f"{f:.4g} Hz, damping {z}",
                mode_columns(f, z),
                3 * len(fine),
                mode(f, z),
                amplitude_ok=lambda a: 0 < a[0] < 0.95,
                refine=(f, lambda v, z=z: (mode_columns(v, z), mode(v, z), f"{v:.4g} Hz, damping {z}")),
            )
    # time ------------------------------------------------------------------------------------------------
    windows(ctx, put)
    tones(ctx, g, put)
    # waves along the travel -------------------------------------------------------------------------------
    known = [] if model.cogging is None else [float(w) / (2 * np.pi) for w in model.cogging.basis.wavenumbers]

    def wave_columns(kappa, multiplier, orders=(1,)):
        def columns(c):
            out = []
            for b, d in zip(c.balances, c.drives):
                m = multiplier(c, b, d)
                ang = 2 * np.pi * kappa * b.position
                out.append(np.vstack([m * f(o * ang) for o in orders for f in (np.sin, np.cos)]))
            return out

        return columns

    def encoder_columns(kappa):
        k = 2 * np.pi * kappa
        size = 1e-4 / kappa
        sine = lambda x: size * np.sin(k * x)  # noqa: E731
        cosine = lambda x: size * np.cos(k * x)  # noqa: E731

        def columns(c):
            return [
                np.vstack(
                    [
                        reading(c, b, a, sine, lambda x: k * cosine(x), lambda x: -k * k * sine(x)),
                        reading(c, b, a, cosine, lambda x: -k * sine(x), lambda x: -k * k * cosine(x)),
                    ]
                )
                / size
                for b, a in zip(c.balances, c.accelerations)
            ]

        return columns

    families = {
        "cogging_harmonic": (lambda c, b, d: np.ones(len(b.time))),
        "force_constant_ripple": (lambda c, b, d: d),
        "encoder_periodic_error": (lambda c, b, d: b.velocity**2),
        "~eddy": (lambda c, b, d: b.velocity),
        "~reluctance": (lambda c, b, d: d**2 / peak),
        "~friction wave": (lambda c, b, d: S(b)),
    }
    spatial = []
    places = np.concatenate([b.position for b in bs])
    for name, mult in families.items():
        multipliers = [mult(ctx, b, d) for b, d in zip(bs, u)]
        weighed = np.concatenate([gi * m for gi, m in zip(g, multipliers)])
        peaks, N = wave_scan(ctx, g, multipliers, 4)
        for kappa, s in peaks:
            if s < 12:
                continue
            make = encoder_columns if name == "encoder_periodic_error" else (lambda k, mult=mult: wave_columns(k, mult))
            kappa, _ = sharpen(
                lambda k: abs(weighed @ np.exp(2j * np.pi * k * places)) if k * length > 0.7 else -1.0,
                kappa,
                0.25 / length,
                6,
            )
            period = 1 / kappa

            def effect(a, name=name, period=period):
                if name.startswith("~"):
                    return None
                sign = -1.0 if name == "cogging_harmonic" else 1.0
                return E[name].replace(period=period, sine=sign * float(a[0]), cosine=sign * float(a[1]))

            spatial.append((s, kappa))
            near_known = name == "cogging_harmonic" and any(abs(kappa - q) < 0.5 / length for q in known)
            if near_known:
                continue
            put(name, f"{period:.4g}", make(kappa), N, effect, period=period)
            if name in ("cogging_harmonic", "force_constant_ripple"):
                put(name, f"{period:.4g} with harmonics", wave_columns(kappa, mult, (1, 2, 3)), N)
    spatial.sort(reverse=True)
    tried = known + [k for _, k in spatial[:3]]
    for kappa in tried:

        def modulated(c, kappa=kappa):
            out = []
            for b in c.balances:
                env = splines(b.position, low, high, 6)
                ang = 2 * np.pi * kappa * b.position
                out.append(np.vstack([env * np.sin(ang), env * np.cos(ang)]))
            return out

        if kappa * length > 2.5:
            put(
                "cogging_modulation",
                f"{1 / kappa:.4g}",
                modulated,
                max(1, len(known)) if kappa in known else 3000,
                None,
            )
    for offer in also:
        offer(ctx, g, put)
    # cells that bear no name ------------------------------------------------------------------------------
    put(
        "~gain of speed",
        "",
        lambda c: [
            np.vstack([d * np.abs(b.velocity) / top, d * (b.velocity / top) ** 2]) for b, d in zip(c.balances, c.drives)
        ],
        1,
    )
    put("~viscous along travel", "", lambda c: [splines(b.position, low, high, 6) * b.velocity for b in c.balances], 1)
    put(
        "~viscous in time",
        "",
        lambda c: [hats(b.time, np.linspace(0, duration, 5)) * b.velocity for b in c.balances],
        1,
    )
    put("~friction in time", "", lambda c: [hats(b.time, np.linspace(0, duration, 12)) * S(b) for b in c.balances], 1)
    put("~force in time", "", lambda c: [hats(b.time, np.linspace(0, duration, 12)) for b in c.balances], 1)
    put("~force along travel", "", lambda c: [splines(b.position, low, high, 14) for b in c.balances], 1)
    put(
        "~gain along travel",
        "",
        lambda c: [splines(b.position, low, high, 8) * d for b, d in zip(c.balances, c.drives)],
        1,
    )
    put("~command", "", lambda c: [np.vstack([d * np.abs(d), d**3, d**2]) for d in c.drives], 1)
    speeds = top * np.geomspace(2e-3, 0.9, 8)
    put(
        "~friction over speed",
        "",
        lambda c: [hats(np.log(np.maximum(np.abs(b.velocity), speeds[0])), np.log(speeds)) * S(b) for b in c.balances],
        1,
    )
    # mass and friction beyond what is stated of them
    for name in ("mass", "viscous", "coulomb"):
        path = f"axis.{name}"
        if path in ctx.paths:
            j = ctx.paths.index(path)
            finite = [i for i, q in enumerate(ctx.prior_sigma) if np.isfinite(q)]
            if j in finite:
                _, q, e = ctx.basis
                c = np.zeros(len(e))
                c[len(e) - len(finite) + finite.index(j)] = 1.0
                c -= (q @ c) @ q
                T = float((c @ e) ** 2 / max(c @ c, 1e-12))
                found[f"{name}_change"] = Found(f"{name}_change", "", T, 1, 1, np.array([0.0]), None, path)
    best = sorted(found.values(), key=lambda f: -f.score)
    limit = best[0].score - 40.0
    done = []
    for f in best:
        if f.refine is not None and f.score > max(limit, 5.0):
            value, again = f.refine
            store = {}

            def at(logarithm):
                columns, effect, label = again(float(np.exp(logarithm)))
                T, amp, k = ctx.score([b.rows(x) for b, x in zip(bs, columns(ctx))])
                store[logarithm] = (T, amp, k, columns, effect, label)
                return T

            x, T = sharpen(at, float(np.log(value)), 0.2, 8)
            T, amp, k, columns, effect, label = store[x]
            if T > f.T:
                f = replace(f, label=label, T=T, k=k, amplitudes=amp, columns=columns, effect=effect)
        done.append(f)
    return sorted(with_cells(done), key=lambda f: -f.score)


#: What bears no name, and the names whose laws it contains.
CELLS = {
    "~force along travel": ("cable_spring", "end_effect", "local_force", "constant_force"),
    "~gain along travel": ("force_constant_ripple",),
    "~gain of speed": ("mass_change", "command_delay", "actuator_lag"),
    "~command": ("command_saturation", "command_dead_zone"),
    "~friction wave": ("position_dependent_friction",),
    "~force in time": ("disturbance_step", "disturbance_tone", "constant_force"),
    "~friction in time": ("coulomb_change", "coulomb_asymmetry"),
    "~viscous in time": ("viscous_change",),
    "~viscous along travel": ("viscous_change", "position_dependent_friction"),
    "~friction over speed": ("coulomb_change", "viscous_change", "quadratic_drag", "stribeck_friction"),
}
#: Cells whose whole shape the names may take: a spring, a bump or a profile of friction has any.
SHAPED = {
    "~force along travel": 0.3,
    "~gain along travel": 0.3,
    "~command": 0.3,
    "~friction wave": 0.3,
    "~force in time": 0.6,
}
NESTED = 0.7  # share of a cell's ratio from which on a law inside it is told instead


def with_cells(found):
    """A force of any shape along a coordinate bears the name of the law along it that explains most."""
    by = {f.name: f for f in found}
    for cell, least in SHAPED.items():
        members = sorted((by[n] for n in CELLS[cell] if n in by), key=lambda f: -f.T)
        if cell not in by or not members or members[0].T < least * by[cell].T:
            continue
        best = members[0]
        if by[cell].score > best.score:
            others = tuple(f.name for f in members[1:] if f.T > NESTED * best.T)
            by[best.name] = replace(by[cell], name=best.name, label="other shape", effect=None, others=others)
        del by[cell]
    return list(by.values())


def law_pdf(ctx, put, added, nodes, unit, N):
    """Friction along the travel, without its mean, which is Coulomb friction."""
    base = E["position_dependent_friction"]
    contrast = np.eye(len(nodes))[:-1] - 1.0 / len(nodes)
    effects = [base.replace(nodes=nodes, levels=[float(x) for x in unit * row]) for row in contrast]
    put(
        "position_dependent_friction",
        f"{len(nodes)} nodes",
        added(effects, [unit] * len(effects)),
        N,
        lambda a: base.replace(nodes=nodes, levels=[float(v) for v in a @ contrast]),
    )


def lag(d, step, tau):
    """What a lag of first order does to a held command, mean over each step (n,): no row knows a later command."""
    p = np.exp(-step / tau)
    before = lfilter([0.0, 1 - p], [1, -p], d - d[0]) + d[0]
    return (before - d) * (1 - p) * tau / step


def windows(ctx, put):
    """A force between two moments: the best of all pairs of moments, which are then made finer."""
    last = max(b.time[-1] for b in ctx.balances)
    spacing = last / 48
    starts = stops = np.arange(0.0, last, spacing)
    for _ in range(3):
        times = np.concatenate([starts, stops])
        c, _ = ctx.project([b.rows((b.time >= times[:, None]).astype(float)) for b in ctx.balances])
        heard, gram = c @ ctx.basis[2], c @ c.T
        i, j = np.arange(len(starts)), len(starts) + np.arange(len(stops))
        size = np.diag(gram)[i][:, None] + np.diag(gram)[j] - 2.0 * gram[np.ix_(i, j)]
        T = (heard[i][:, None] - heard[j]) ** 2 / np.maximum(size, 1e-4 * np.max(np.diag(gram)))
        T[starts[:, None] > stops - 0.02] = 0.0
        at = np.unravel_index(np.argmax(T), T.shape)
        begin, end = float(starts[at[0]]), float(stops[at[1]])
        fine = np.linspace(-spacing, spacing, 17)
        starts, stops, spacing = np.clip(begin + fine, 0.0, last), np.clip(end + fine, 0.0, last), spacing / 8
    put(
        "disturbance_step",
        f"{begin:.3g} to {end:.3g}",
        lambda c: [((x.time >= begin) & (x.time < end)).astype(float)[None] for x in c.balances],
        300,
        lambda a: E["disturbance_step"].replace(force=float(a[0]), start=begin, stop=end),
    )


def tones(ctx, g, put):
    """A force in time with a frequency."""
    b = ctx.balances[0]
    n = max(len(x.time) for x in ctx.balances)
    size = int(2 ** np.ceil(np.log2(4 * n)))
    spec = sum(np.fft.rfft(np.pad(gi, (0, size - len(gi)))) for gi in g)
    f = np.fft.rfftfreq(size, b.step)
    duration = n * b.step
    rows = sum(int(m.sum()) * x.every for m, x in zip(ctx.masks, ctx.balances))
    use = (f > 2.0 / duration) & (f < 0.38 * b.rate)
    s = 2 * np.abs(spec[use]) ** 2 / (rows * gain_of(ctx, f[use]))
    ff = f[use]
    heard = lambda q: sum(gi @ np.exp(2j * np.pi * q * x.time) for gi, x in zip(g, ctx.balances))  # noqa: E731
    for _ in range(3):
        j = int(np.argmax(s))
        if s[j] < 12:
            break
        make = lambda q: (
            lambda c: [np.vstack([np.sin(2 * np.pi * q * x.time), np.cos(2 * np.pi * q * x.time)]) for x in c.balances]
        )  # noqa: E731
        q, _ = sharpen(lambda q: abs(heard(q)), float(ff[j]), 0.25 / duration, 6)
        put(
            "disturbance_tone",
            f"{q:.4g} Hz",
            make(q),
            int(duration * 0.38 * b.rate),
            lambda a, q=q: E["disturbance_tone"].replace(frequency=float(q), sine=float(a[0]), cosine=float(a[1])),
        )
        many = lambda c, q=q: [
            np.vstack([w(2 * np.pi * q * o * x.time) for o in (1, 2, 3) for w in (np.sin, np.cos)]) for x in c.balances
        ]  # noqa: E731
        put("disturbance_tone", f"{q:.4g} Hz with harmonics", many, int(duration * 0.38 * b.rate))
        s[np.abs(ff - ff[j]) < 1.0 / duration] = 0
