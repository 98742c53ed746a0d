"""The search: what is missing in a force balance."""

from __future__ import annotations

from dataclasses import dataclass, field, replace
from functools import cached_property
from typing import Any

import numpy as np
from scipy.linalg import solve_toeplitz
from scipy.ndimage import median_filter
from scipy.signal import butter, lfilter, oaconvolve, sosfiltfilt

from cogging._core import Predictor
from cogging.estimation.residuals import quiet_plant
from cogging.model.parameters import effect_paths, parameters_of, with_values

ORDER = 24
SLOPES = (0.0, 0.2, 0.4, 0.6)  # exponents of the fractional difference
SHORT, LONG = 0.02, 1.5  # s, memory of the filter that screens, and of that which decides
TAIL = 5.0  # degrees of freedom of Student's noise


def replace_width(model, width):
    return with_values(model, {"axis.coulomb_width": width})


def noise_filter(segments, masks, rate, memory=0.4):
    """Causal whitening filter: a fractional difference for what is slow, and an autoregression of ORDER rows.

    Slow noise is drawn from the whole spectrum by one exponent: a filter with free weights for the rows long ago would
    take a constant force for noise, whatever its size.
    """
    size = 2 * max(map(len, segments))
    power = sum(np.abs(np.fft.rfft(np.where(m, e, 0.0), size)) ** 2 for e, m in zip(segments, masks))
    turn = 2.0 * np.sin(np.pi * np.arange(len(power)) / size)  # |1 - exp(-i w)|
    best = None
    for d in SLOPES:
        r = np.fft.irfft(power * turn ** (2.0 * d), size)[: ORDER + 1]
        w = solve_toeplitz(np.concatenate([[r[0] * (1.0 + 1e-9)], r[1:-1]]), r[1:])
        variance = r[0] - w @ r[1:]
        if best is None or variance < best[0]:
            best = variance, d, w
    _, d, w = best
    k = np.arange(1, int(memory * rate))
    slow = np.concatenate([[1.0], np.cumprod((k - 1.0 - d) / k)]) if d else np.ones(1)
    return np.convolve(slow, np.concatenate([[1.0], -w]))


def without_lines(x, rate, most=3, ratio=40.0):
    """A residual without lines of its spectrum: a tone is a signal, which a filter with a memory would take away."""
    n = len(x)
    for _ in range(most):
        spectrum = np.fft.rfft(x * np.hanning(n))
        power = np.abs(spectrum) ** 2
        level = median_filter(power, 81) + 1e-300
        j = int(np.argmax(power / level * (np.arange(len(power)) > 4)))
        if power[j] < ratio * level[j]:
            break
        t = 2 * np.pi * np.arange(n) / n
        table = np.vstack([f((j + d) * t) for d in (-1.0, -0.5, 0.0, 0.5, 1.0) for f in (np.sin, np.cos)])
        w = np.linalg.lstsq(table.T, x, rcond=1e-6)[0]
        x = x - w @ table
    return x


@dataclass
class Maximum:
    """A hypothesis at its likeliest: `cost` is minus twice the logarithm of the likelihood."""

    cost: float
    w: Any
    rest: Any
    variance: float
    at: Any  # weight of each row
    gram: Any

    def by_row(self):
        """Minus twice the logarithm of Student's density, row by row."""
        return by_row(self.rest, self.variance)


def by_row(rest, variance):
    return (TAIL + 1.0) * np.log1p(rest**2 / (TAIL * variance)) + np.log(variance)


def likeliest(x, r, sigma, target, variance):
    """Columns x (p, n) at their likeliest in rows r under priors; Student's noise: what nothing explains decides little."""
    at = np.ones(len(r))
    for _ in range(3):
        weight = 1.0 / np.maximum(sigma**2 / variance, 1e-12)
        scaled = x * np.sqrt(at)
        gram = scaled @ scaled.T + np.diag(weight + 1e-12 * len(r))
        w = np.linalg.solve(gram, x @ (at * r) + weight * target)
        rest = r - w @ x
        at = (TAIL + 1.0) / (TAIL + rest**2 / variance)
        variance = float(at @ rest**2) / len(rest)
    cost = by_row(rest, variance).sum() + float(np.sum(((w - target) / sigma) ** 2))
    return Maximum(cost, w, rest, variance, at, gram)


@dataclass
class Context:
    """Logs under a model with what was accepted; everything whitened."""

    balances: list
    model: Any
    extra: list = field(default_factory=list)  # accepted Shapes without a law: (Shape, free)
    taps: Any = None
    generic: bool = True
    nuisance_free: tuple = ()
    start_model: Any = None
    taps_given: Any = None
    suspects: tuple = ()  # candidates that the noise filter leaves out
    frozen: bool = False  # effects and extras as they are
    root: Any = 1.0  # of the weight of each row that counts

    def prepare(self, rounds=2):
        if self.start_model is None:
            self.start_model = self.model
        self.taps_given = self.taps
        for k in range(rounds):
            self.prepare_once()
            if k == 0 and self.taps_given is None:
                for b, r in zip(self.balances, self.raw):
                    b.hear(r, self.model.axis.mass)
                self.taps = None
            self.model = self.retuned()
        self.prepare_once()
        return self

    def suspecting(self, *suspects):
        """The same with a noise filter that leaves the suspects out."""
        other = replace(self, suspects=tuple(f for f in suspects if f.columns is not None), taps=None)
        other.prepare_once()
        return other

    def retuned(self):
        """The model with nuisances as fitted."""
        known = parameters_of(self.model, together=True)
        values = {}
        for path, step in zip(self.paths, self.theta):
            if path in known:
                value = known[path].value + float(step)
                if path.startswith("axis."):
                    low = 0.05 * known[path].value if path == "axis.mass" else 0.0
                    value = max(value, low)
                if path in self.limits:
                    low, high = self.limits[path]
                    value = min(max(value, low), high)
                values[path] = value
        try:
            model = with_values(self.model, values)
        except ValueError:
            model = with_values(self.model, {k: v for k, v in values.items() if not k.startswith("effects.")})
        return replace_width(model, self.likeliest_width())

    def likeliest_width(self):
        """Width of the arctangent that is closest to the fitted friction law over the speeds of the motion, m/s."""
        own = self.model.axis.coulomb_width
        parts = {float(q[6:]): float(t) for q, t in zip(self.paths, self.theta) if q.startswith("width.")}
        if not parts:
            return own
        v = np.quantile(np.concatenate([np.abs(b.velocity[b.keep > 0]) for b in self.balances]), np.linspace(0, 1, 400))
        level = self.model.axis.coulomb - sum(parts.values())
        law = level * np.arctan(v / own) + 0.5 * np.pi * sum(t * np.minimum(v / w, 1.0) for w, t in parts.items())
        if not np.any(law):
            return own
        tried = np.geomspace(min(own, min(parts)), max(own, max(parts)), 60)
        fits = np.arctan(v / tried[:, None])
        return float(tried[np.argmax((fits @ law) ** 2 / np.sum(fits**2, axis=1))])

    def prepare_once(self):
        m = self.model
        self.masks = [b.mask for b in self.balances]
        both = [drive(b, m) for b in self.balances]
        self.drives = [u for u, _ in both]
        self.accelerations = [a for _, a in both]
        self.paths, nuis = nuisance_columns(self)
        self.raw = [b.residual(m) for b in self.balances]
        self.residuals = [b.rows(r)[0] for b, r in zip(self.balances, self.raw)]
        self.nuisances = [b.rows(t) for b, t in zip(self.balances, nuis)]
        made = [s.columns(self) for s in self.extra]
        if self.frozen and made:
            for i, b in enumerate(self.balances):
                self.residuals[i] = (
                    self.residuals[i] - b.rows(sum(s.amplitudes @ t[i] for s, t in zip(self.extra, made)))[0]
                )
            made = []
        extra = [
            b.rows(np.vstack([t[i] for t in made])) if made else np.zeros((0, len(r)))
            for i, (b, r) in enumerate(zip(self.balances, self.residuals))
        ]
        self.nuisances = [np.vstack([a, e]) for a, e in zip(self.nuisances, extra)]
        if self.taps is None:
            self.taps = self.noise_filter()
        self.whiten_all()
        return self

    def noise_filter(self):
        """Whitening filter from what a generic basis leaves."""
        cols = []
        more = [f.columns(self) for f in self.suspects]
        for i, b in enumerate(self.balances):
            cols.append(np.vstack([self.nuisances[i], *(b.rows(t[i]) for t in more)]))
        r = np.concatenate([x[m] for x, m in zip(self.residuals, self.masks)])
        c = np.hstack([x[:, m] for x, m in zip(cols, self.masks)])
        norm = np.linalg.norm(c, axis=1)
        norm[norm == 0] = 1
        w = np.linalg.lstsq((c / norm[:, None]).T, r, rcond=1e-7)[0] / norm
        left = [x - w @ t for x, t in zip(self.residuals, cols)]
        left = [without_lines(x * m, b.rate) for x, m, b in zip(left, self.masks, self.balances)]
        # outliers do not decide the filter
        scale = 1.4826 * np.median(np.abs(np.concatenate([x[m] for x, m in zip(left, self.masks)])))
        left = [np.clip(x, -8 * scale, 8 * scale) for x in left]
        return noise_filter(left, self.masks, self.balances[0].rate)

    def maximised(self, tables=None):
        """Nuisances and columns at their likeliest, with the noise filter that suits them best.

        The filter is part of each hypothesis: with that of the null, a slow force is half taken for noise; with that of
        the candidate, nulls alarm. Their likelihood ratio, each with its own, does neither. A filter that has swallowed
        a force finds no force that it could give back: what is left without any filter is a start as well.
        """
        known = len(self.prior_sigma)
        parts = self.nuisances if tables is None else [np.vstack([n, t]) for n, t in zip(self.nuisances, tables)]
        size = np.sqrt(sum(np.sum(x**2, axis=1) for x in parts)) + 1e-300
        free = np.full(len(size) - known, np.inf)
        sigma = np.concatenate([self.prior_sigma, free]) * size
        target = np.concatenate([self.prior_offset[:known], np.zeros(len(free))]) * size
        rows = [np.vstack([r, x]) for r, x in zip(self.residuals, parts)]
        best, n, tried = None, len(self.nuisances[0]), []
        for start in (np.ones(1), self.taps if tables is None else self.null.taps):
            taps = start
            for k in range(3):
                white = self.whitened(rows, taps)
                r, x = white[0], white[1:] / size[:, None]
                variance = max(1.4826 * float(np.median(np.abs(r))), 1e-300) ** 2
                told = likeliest(x, r, sigma, target, variance)
                if k and (best is None or told.cost < best.cost):
                    best = told
                    best.theta, best.taps, best.white, best.x, best.r = told.w / size, taps, white, x, r
                    best.prior = sigma, target
                if k == (2 if tables is None else 1):
                    break
                taps = noise_filter(self.left(told.w / size, parts), self.masks, self.balances[0].rate, LONG)
        if tables is not None:
            x, (wide, middle) = best.x, best.prior
            # none may be likelier behind the candidate's filter than behind its own
            none = likeliest(x[:n], best.r, wide[:n], middle[:n], best.variance)
            best.none = none if none.cost < self.null.cost else self.null
            near = (x[:n] * best.at) @ x[n:].T
            more = x[n:] - np.linalg.solve(best.gram[:n, :n], near).T @ x[:n]
            val, vec = np.linalg.eigh((more * best.at) @ more.T)
            good = val > 1e-6 * val[-1]
            ortho = (vec[:, good] / np.sqrt(val[good])).T @ more
            best.inflation = float(np.max(self.inflation(ortho * best.at * best.rest / np.sqrt(best.variance))))
            best.told = np.sqrt(best.at) * (best.w[n:] @ more) / np.sqrt(best.variance)
        best.x = best.gram = None
        return best

    @cached_property
    def null(self):
        return self.maximised()

    def left(self, theta, parts):
        """What columns leave, outliers cut, one (m,) a log."""
        left = [r - theta @ x for r, x in zip(self.residuals, parts)]
        scale = 1.4826 * np.median(np.abs(np.concatenate([x[m] for x, m in zip(left, self.masks)])))
        return [np.clip(x, -5 * scale, 5 * scale) for x in left]

    def settle(self):
        """The noise filter at its likeliest, for the search."""
        left = self.left(self.null.theta, self.nuisances)
        self.taps = noise_filter(left, self.masks, self.balances[0].rate, SHORT)
        self.sigma, self.root = 1.0, np.sqrt(self.null.at)
        self.whiten_all()
        return self

    def inflation(self, products):
        """Largest ratio of the variance of a score to what independent rows would have."""
        v = np.maximum(np.sum(products**2, axis=1), 1.0)
        for seconds in (0.1, 0.5):
            edges = np.arange(0, products.shape[1], max(1, round(seconds * self.balances[0].rate)))
            v = np.maximum(v, np.sum(np.add.reduceat(products, edges, axis=1) ** 2, axis=1))
        return v

    def whitened(self, tables, taps):
        """Rows that count behind a filter, logs after each other, (p, n)."""
        out = [
            oaconvolve(t, taps[None, :], axes=1)[:, : t.shape[1]][:, self.counted(m)]
            for t, m in zip(tables, self.masks)
        ]
        return np.hstack(out)

    def whiten(self, tables):
        """Rows that count, whitened, logs after each other: (p, n)."""
        out = []
        for t, m in zip(tables, self.masks):
            t = np.atleast_2d(t)
            w = oaconvolve(t, self.taps[None, :], axes=1)[:, : t.shape[1]]
            out.append(w[:, self.counted(m)])
        return np.hstack(out) * (self.root / self.sigma)

    @staticmethod
    def counted(mask):
        """Rows whose filter saw masked rows do not count."""
        bad = lfilter(np.ones(ORDER), 1.0, (~mask).astype(float)) > 0.5
        return ~bad

    def whiten_all(self):
        self.sigma = 1.0
        r = self.whiten([x[None, :] for x in self.residuals])[0]
        n = self.whiten(self.nuisances)
        self.keep_positive(n, r)
        n = n[self.kept]
        self.rows = len(r)
        sigma = max(1.4826 * float(np.median(np.abs(r))), 1e-300)
        for _ in range(3):
            self.priors(n / sigma)
            norm = np.maximum(np.linalg.norm(self.N, axis=0), 1e-300)
            y = np.concatenate([r / sigma, self.prior_target])
            theta = np.linalg.lstsq(self.N / norm, y, rcond=1e-9)[0]
            e = (y - (self.N / norm) @ theta)[: self.rows] * sigma
            sigma = max(1.4826 * float(np.median(np.abs(e))), 0.7 * float(np.std(e)), 1e-300)
        self.sigma = sigma
        self.r = r / self.sigma
        n = n / self.sigma
        self.priors(n)
        norm = np.maximum(np.linalg.norm(self.N, axis=0), 1e-300)
        self.Q, self.R = np.linalg.qr(self.N / norm)
        good = np.abs(np.diag(self.R)) > 1e-7
        self.Q = self.Q[:, good]
        y = np.concatenate([self.r, self.prior_target])
        self.theta = np.linalg.lstsq(self.N / norm, y, rcond=1e-9)[0] / norm
        self.e_full = y - self.Q @ (self.Q.T @ y)
        self.e = self.e_full[: self.rows]

    def keep_positive(self, n, r):
        """Friction falls nowhere from rest on: widths that would need a negative share of it are left out."""
        sig = np.array([*self.prior_sigma, *[np.inf] * (len(n) - len(self.prior_sigma))])
        off = np.array([*self.prior_offset, *[0.0] * (len(n) - len(self.prior_offset))])
        sigma = max(1.4826 * float(np.median(np.abs(r))), 1e-300)
        size = np.linalg.norm(n, axis=1)
        size = np.maximum(size, 1e-9 * size.max())
        d = n / size[:, None]
        gram, right = d @ d.T, d @ r
        weight = np.where(np.isfinite(sig), (sigma / (sig * size)) ** 2, 0.0)
        right = right + weight * np.where(np.isfinite(sig), off, 0.0) * size
        gram = gram + np.diag(weight + 1e-10)
        kept = list(range(len(n)))
        while True:
            w = np.linalg.solve(gram[np.ix_(kept, kept)], right[kept])
            widths = [
                (w[i], j) for i, j in enumerate(kept) if j < len(self.paths) and self.paths[j].startswith("width.")
            ]
            if not widths or min(widths)[0] >= 0.0:
                break
            kept.remove(min(widths)[1])
        self.kept = kept
        self.extra_at = sum(1 for j in kept if j < len(self.paths))
        self.paths = [self.paths[j] for j in kept if j < len(self.paths)]
        self.prior_sigma = [float(sig[j]) for j in kept]
        self.prior_offset = [float(off[j]) for j in kept]
        self.nuisances = [t[kept] for t in self.nuisances]

    def priors(self, n):
        """Nuisance columns with their pseudo-observations."""
        sig = self.prior_sigma
        p = n.shape[0]
        rows = []
        target = []
        for j in range(p):
            s = sig[j] if j < len(sig) else np.inf
            if np.isfinite(s):
                row = np.zeros(p)
                row[j] = 1.0 / s
                rows.append(row)
                target.append(self.prior_offset[j] / s)
        self.N = np.vstack([n.T, np.array(rows).reshape(len(rows), p)])
        self.prior_target = np.array(target)

    def project(self, tables):
        """Whitened candidate columns freed of the nuisances, (k, n + priors)."""
        c = self.whiten(tables)
        self.before = np.linalg.norm(c, axis=1)
        c = np.hstack([c, np.zeros((c.shape[0], len(self.prior_target)))])
        return c - (c @ self.Q) @ self.Q.T

    def score_columns(self, columns_mid):
        """T and amplitudes of a group of columns (per log at the middle rate)."""
        tables = [b.rows(c) for b, c in zip(self.balances, columns_mid)]
        return self.score_tables(tables)

    def score_tables(self, tables):
        c = self.project(tables)
        return self.score_projected(c)

    def score_projected(self, c):
        size = np.linalg.norm(c, axis=1)
        ok = size > np.maximum(0.02 * self.before, 1e-9)
        if not ok.any():
            return 0.0, np.zeros(len(c)), np.zeros((len(c), len(c))), 0
        d = c[ok] / size[ok, None]
        gram = d @ d.T
        val, vec = np.linalg.eigh(gram)
        keep = val > 1e-6 * val[-1]
        s = vec[:, keep].T @ (d @ self.e_full)
        amp = vec[:, keep] @ (s / val[keep])
        # robust: the score's variance from the rows themselves
        ortho = (vec[:, keep].T @ d) / np.sqrt(val[keep])[:, None]
        rest = self.e_full - (amp @ d)
        t_rows = (ortho * rest)[:, : self.rows]
        v = np.maximum(np.sum(t_rows**2, axis=1), 1.0)
        for seconds in (0.1, 0.5):
            edges = np.arange(0, self.rows, max(1, round(seconds * self.balances[0].rate)))
            v = np.maximum(v, np.sum(np.add.reduceat(t_rows, edges, axis=1) ** 2, axis=1))
        T = float(np.sum((s / np.sqrt(val[keep])) ** 2 / v))
        full = np.zeros(len(c))
        full[ok] = amp / size[ok]
        cov = np.zeros((len(c), len(c)))
        cov[np.ix_(ok, ok)] = (vec[:, keep] / val[keep]) @ vec[:, keep].T / np.outer(size[ok], size[ok])
        return T, full, cov, int(keep.sum())


LAGS = (-2, -1, 0, 1, 2, 3, 4, 6, 8, 12, 16, 24, 32, 48, 64, 96)  # rows of 0.4 ms


def drive(b, model):
    """The command as far as the motion asked for tells it, and what it accelerates the axis with, V and m/s^2 (n,).

    What the loop makes of its own noise is in the command, and in the noise of later rows: a column made of that alarms
    without any cause. The command is regressed on what the model asks for along the reference, earlier and later.
    """
    only = model.replace(effects=tuple(e for e in model.effects if "force" in e.HOOKS or "friction_level" in e.HOOKS))
    plant = quiet_plant(only)
    forces = b.forces([plant])[0]
    if b.reference is None:
        slow = sosfiltfilt(butter(2, b.corner * b.step, output="sos"), b.command)
        return slow, (slow + forces) / model.axis.mass
    x, v, a = b.reference
    along = Predictor(b.time, x, np.zeros(len(x))).net_force([plant], x, v)[0]
    rows = np.arange(len(x))
    stride = max(1, round(4e-4 / b.step))
    table = [np.ones(len(x)), x - x.mean(), v]
    for lag in LAGS:
        at = np.clip(rows - stride * lag, 0, len(x) - 1)
        table += [a[at], along[at]]
    table = np.array(table)
    size = np.linalg.norm(table, axis=1) + 1e-300
    table /= size[:, None]
    w = np.linalg.solve(table @ table.T + 1e-9 * np.eye(len(table)), table @ b.command)
    told = w @ table
    return told, (told + forces) / model.axis.mass


AXIS = ("mass", "viscous", "coulomb")


def nuisance_columns(ctx):
    """Columns of mass, friction, its width, the known cogging; with priors."""
    m, balances = ctx.model, ctx.balances
    first = ctx.start_model
    known = parameters_of(m, together=True)
    paths, sig, off = [], [], []
    tables = [[] for _ in balances]
    for name in AXIS:
        u = first.uncertainty.get(name)
        if u == 0.0:
            continue
        value = getattr(m.axis, name)
        stated = getattr(first.axis, name)
        paths.append(f"axis.{name}")
        s = np.inf if u is None or f"axis.{name}" in ctx.nuisance_free else u * max(abs(stated), 1e-12)
        sig.append(s)
        off.append(stated - value)
    # residual falls with -column: r = M a - f; more mass: + a
    w0 = max(m.axis.coulomb_width, 1e-6)
    widths = []
    if first.uncertainty.get("coulomb_width") != 0.0:
        slow = 2.0 * min(b.speed_noise for b in balances)
        fastest = max(np.abs(b.velocity).max() for b in balances)
        widths = list(np.geomspace(slow, max(12.0 * w0, 4.0 * slow, 0.3 * fastest), 32))
    for i, b in enumerate(balances):
        own = m.axis.coulomb_width
        key = own, tuple(widths)
        if b.kept.get("friction", (None,))[0] != key:
            v = b.fine[3]
            laws = [np.arctan(v / own) * 2 / np.pi if own > 0 else np.sign(v)]
            laws += [np.clip(v / w, -1.0, 1.0) for w in widths]
            b.kept["friction"] = key, b.averaged(np.array(laws))
        smooth = b.kept["friction"][1]
        col = {"axis.mass": -ctx.accelerations[i], "axis.viscous": -b.velocity, "axis.coulomb": -smooth[0]}
        for p in paths:
            tables[i].append(col[p])
        for s in smooth[1:]:
            tables[i].append(-(s - smooth[0]))
    for w in widths:
        paths.append(f"width.{w:g}")
        sig.append(max(m.axis.coulomb, 1e-12))
        off.append(0.0)
    if m.cogging is not None:
        changed, steps = [], []
        for row in range(len(m.cogging.sine)):
            amp = np.hypot(np.max(np.abs(m.cogging.sine[row])), np.max(np.abs(m.cogging.cosine[row])))
            if amp > 0.0 and m.cogging.sine.shape[1] > 1:
                for kind, step in (("gain", 0.05), ("phase", 0.05)):
                    path = f"cogging.{kind}[{row}]"
                    changed.append(with_values(m, {path: known[path].value + step}))
                    steps.append(step)
                    paths.append(path)
            else:
                scale = float(np.max(np.abs(b.command)))
                for kind in ("sine", "cosine"):
                    path = f"cogging.{kind}[{row}][*]"
                    changed.append(with_values(m, {path: known[path].value + 1e-2 * scale}))
                    steps.append(1e-2 * scale)
                    paths.append(path)
            sig += [np.inf, np.inf]
            off += [0.0, 0.0]
        for i, b in enumerate(balances):
            f = b.forces([quiet_plant(x.replace(effects=())) for x in (m, *changed)])
            for row, s in zip(f[1:], steps):
                tables[i].append((row - f[0]) / s)
    ctx.limits = {}
    if not ctx.frozen:
        new = range(len(first.effects), len(m.effects))
        prefixes = [q for q, _ in effect_paths(m.effects)]
        for j in new:
            roles = m.effects[j].ROLES
            for path in [q for q in known if q.startswith(prefixes[j] + ".")]:
                name = path[len(prefixes[j]) + 1 :].split("[")[0]
                role = roles[name]["role"]
                if role == "setting" or isinstance(getattr(m.effects[j], name), list) and role == "shape":
                    continue
                value = known[path].value
                size = (
                    max(abs(value), 1e-3 * max(float(np.max(np.abs(b.command))) for b in balances))
                    if role == "amplitude"
                    else abs(value)
                )
                step = 1e-3 * size
                if name == "period":
                    span = max(b.position.max() for b in balances) - min(b.position.min() for b in balances)
                    step = 1e-2 * value**2 / span
                if step <= 0:
                    continue
                try:
                    pair = [with_values(m, {path: value + q}) for q in (step, -step)]
                    for i, b in enumerate(balances):
                        tables[i].append(-(b.residual(pair[0]) - b.residual(pair[1])) / (2 * step))
                except ValueError:
                    for i in range(len(balances)):
                        del tables[i][len(paths) :]
                    continue
                paths.append(path)
                if role == "amplitude":
                    sig.append(max(size, abs(value)))
                else:
                    sig.append(50 * step if name == "period" else 0.3 * size)
                    if roles[name]["quantity"] == "time" and name in ("start", "stop"):
                        sig[-1] = 0.02
                    if roles[name]["quantity"] == "frequency":
                        sig[-1] = 0.3 / balances[0].time[-1]
                    if roles[name]["quantity"] == "position":
                        sig[-1] = 0.1 * (
                            max(b.position.max() for b in balances) - min(b.position.min() for b in balances)
                        )
                    ctx.limits[path] = (value - sig[-1], value + sig[-1])
                    if value > 0 and roles[name]["quantity"] not in ("position",):
                        ctx.limits[path] = (max(0.3 * value, ctx.limits[path][0]), ctx.limits[path][1])
                off.append(0.0)
    # offset in the stated value: pseudo-observation of delta = stated - value
    ctx.prior_sigma, ctx.prior_offset = sig, off
    return paths, [np.array(t) if t else np.zeros((0, len(b.time))) for t, b in zip(tables, balances)]
