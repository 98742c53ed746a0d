"""Evidence: what is left of a force balance under a model, and how much likelier it is with something more."""

from __future__ import annotations

from dataclasses import dataclass, field
from functools import cached_property
from typing import Any

import numpy as np
from scipy.linalg import solve_triangular
from scipy.optimize import nnls
from scipy.signal import butter, lfilter, oaconvolve, sosfiltfilt

from cogging._core import Predictor
from cogging.estimation.residuals import quiet_plant
from cogging.model.parameters import effect_paths, parameters_of, with_values
from cogging.diagnosis.balance.cells import hats, splines

GAP = 24  # rows after a gap that do not count
MEMORY = 1.5  # s, of the noise filter
BAND = 1.3  # about a frequency, up and down, of whose power the noise filter takes the median
LINES = 24  # of the spectrum, at least
TAIL = 5.0  # degrees of freedom of Student's noise
OUTLIER = 5.0  # deviations beyond which a row does not count in the noise filter
TIMING = 0.25  # rows of a log by which friction may be late
WIDTHS = 32  # of Coulomb friction's rise, of which its law is made


def noise_filter(e, m, rate):
    """Causal whitening filter of smallest phase, from the median of the power over a band about each frequency.

    A line of the spectrum is a signal: what is periodic in motion shows as lines, and noise has none that are so narrow.
    """
    size = int(2 ** np.ceil(np.log2(2 * len(e))))
    power = np.abs(np.fft.rfft(np.where(m, e, 0.0), size)) ** 2
    lines = np.arange(1, len(power))
    centres = np.unique(np.geomspace(LINES, lines[-1], 96).astype(int))
    low = np.maximum(1, np.minimum((centres / BAND).astype(int), centres - LINES // 2))
    high = np.minimum(len(power), np.maximum((centres * BAND).astype(int), centres + LINES // 2) + 1)
    level = np.array([np.median(power[a:b]) for a, b in zip(low, high)])
    smooth = np.interp(np.log(lines), np.log(centres), np.log(level + 1e-9 * level.max()))
    cepstrum = np.fft.irfft(-0.5 * np.concatenate([smooth[:1], smooth]), size)
    cepstrum[1 : size // 2] *= 2.0
    cepstrum[size // 2 + 1 :] = 0.0
    taps = np.fft.irfft(np.exp(np.fft.rfft(cepstrum)), size)
    return taps[: max(2, int(MEMORY * rate))] / taps[0]


@dataclass
class Maximum:
    """A hypothesis at its likeliest: `cost` is minus twice the logarithm of the likelihood.

    Attributes:
        w: amplitudes of the columns, by their sizes.
        rest: whitened rows less the columns.
        variance: of them.
        at: weight of each row.
        gram: weighted products of the columns with each other, priors included.
        unit: twice the logarithm of the deviation of each row before its filter.
    """

    cost: float
    w: Any
    rest: Any
    variance: float
    at: Any
    gram: Any
    unit: Any = 0.0

    def by_row(self):
        """Minus twice the logarithm of Student's density, row by row."""
        return by_row(self.rest, self.variance) + self.unit


def deviation(x):
    """Robust deviation of rows."""
    return max(1.4826 * float(np.median(np.abs(x))), 1e-300)


def by_row(rest, variance):
    return (TAIL + 1.0) * np.log1p(rest**2 / (TAIL * variance)) + np.log(variance)


def likeliest(x, r, sigma, target, rounds=3):
    """Columns x (p, n) at their likeliest in rows r under priors; Student's noise: what nothing explains decides little."""
    at, variance = np.ones(len(r)), deviation(r) ** 2
    for _ in range(rounds):
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
class Evidence:
    """Logs under a model with what was accepted.

    Attributes:
        balances: force balances of the logs.
        given: model as it was read, which the priors are of.
        model: the same re-tuned, with what was accepted.
        extra: what was accepted without a law.
        free: paths of the axis whose prior is released.
    """

    balances: list
    given: Any
    model: Any
    extra: list = field(default_factory=list)
    free: tuple = ()

    def prepare(self, rounds=0, listen=False):
        """Make the columns and the null, re-tuning the model round by round; `listen`: choose the balance's band."""
        for k in range(rounds):
            self.make()
            if k == 0 and listen:
                for b, r in zip(self.balances, self.raw):
                    b.hear(r, self.model.axis.mass)
                self.make()
            self.model = self.retuned()
        self.make()
        return self

    def make(self):
        """Columns of the balance under the model, and the null."""
        both = [drive(b, self.model) for b in self.balances]
        self.drives, self.accelerations = [u for u, _ in both], [a for _, a in both]
        self.paths, tables = nuisance_columns(self)
        made = [s.columns(self) for s in self.extra]
        tables = [np.vstack([t, *(s[i] for s in made)]) for i, t in enumerate(tables)]
        count = len(tables[0]) - len(self.paths)
        self.prior_sigma = np.concatenate([self.prior_sigma, np.full(count, np.inf)])
        self.prior_offset = np.concatenate([self.prior_offset, np.zeros(count)])
        self.raw = [b.residual(self.model) for b in self.balances]
        self.masks = [b.mask for b in self.balances]
        self.counted = [lfilter(np.ones(GAP), 1.0, (~m).astype(float)) < 0.5 for m in self.masks]
        self.residuals = [b.rows(r)[0] for b, r in zip(self.balances, self.raw)]
        self.nuisances = [b.rows(t) for b, t in zip(self.balances, tables)]
        for name in ("null", "screen", "basis"):
            self.__dict__.pop(name, None)
        taps = self.taps_of(self.fitted(self.plain)[0])
        self.keep_positive(taps)
        self.start, self.theta = taps, self.fitted(taps)[0]

    def filtered(self, tables, taps):
        """Rows that count behind each log's filter, logs after each other, (p, n)."""
        return np.hstack(
            [oaconvolve(t, h[None, :], axes=1)[:, : t.shape[1]][:, m] for t, h, m in zip(tables, taps, self.counted)]
        )

    @property
    def rate(self):
        return self.balances[0].rate

    def taps_of(self, theta, parts=None):
        """Noise filter of each log, of what columns leave, to a deviation of 1; outliers are cut."""
        taps = []
        for r, x, m in zip(self.residuals, self.nuisances if parts is None else parts, self.masks):
            left = r - theta @ x
            most = OUTLIER * deviation(left[m])
            one = noise_filter(np.clip(left, -most, most), m, self.rate)
            taps.append(one / deviation(oaconvolve(left, one)[: len(left)][m]))
        return taps

    @property
    def plain(self):
        """No filter, but each log to a deviation of 1."""
        return [np.ones(1) / deviation(r[m]) for r, m in zip(self.residuals, self.masks)]

    def fitted(self, taps, parts=None, rounds=3):
        """Amplitudes of nuisances, or of parts, behind a filter, and the maximum."""
        parts = self.nuisances if parts is None else parts
        size = np.sqrt(sum(np.sum(x**2, axis=1) for x in parts))
        size = np.maximum(size, 1e-12 * size.max())
        more = len(size) - len(self.prior_sigma)
        sigma = np.concatenate([self.prior_sigma, np.full(more, np.inf)]) * size
        target = np.concatenate([self.prior_offset, np.zeros(more)]) * size
        white = self.filtered([np.vstack([r, x]) for r, x in zip(self.residuals, parts)], taps)
        r, x = white[0], white[1:] / size[:, None]
        best = likeliest(x, r, sigma, target, rounds)
        scale = [-2.0 * np.log(abs(h[0])) for h in taps]
        best.unit = np.repeat(scale, [int(m.sum()) for m in self.counted])
        best.cost += best.unit.sum()
        best.theta, best.taps, best.r, best.x, best.prior, best.size = best.w / size, taps, r, x, (sigma, target), size
        return best.theta, best

    def maximised(self, tables=None):
        """Nuisances and columns at their likeliest, with the noise filter that suits them best.

        The filter is part of each hypothesis: with that of the null, a slow force is half taken for noise; with that of
        the candidate, nulls alarm. Their likelihood ratio, each with its own, does neither. A filter that has swallowed
        a force finds no force that it could give back: what is left without any filter is a start as well.
        """
        parts = self.nuisances if tables is None else [np.vstack([n, t]) for n, t in zip(self.nuisances, tables)]
        best, n = None, len(self.nuisances[0])
        for taps in (self.plain, self.start) if tables is None else (self.plain, self.null.taps, self.screen.taps):
            for k in range(3 if tables is None else 2):
                theta, told = self.fitted(taps, parts)
                if best is None or told.cost < best.cost:
                    best = told
                taps = self.taps_of(theta, parts)
        if tables is not None:
            x, (sigma, target) = best.x, best.prior
            # none may be likelier behind the candidate's filter than behind its own
            none = likeliest(x[:n], best.r, sigma[:n], target[:n])
            none.unit = best.unit
            none.cost += best.unit.sum()
            best.none = none if none.cost < self.null.cost else self.null
            near = (x[:n] * best.at) @ x[n:].T
            more = x[n:] - np.linalg.solve(best.gram[:n, :n], near).T @ x[:n]
            ortho = orthonormal(more * np.sqrt(best.at)) * np.sqrt(best.at)
            best.inflation = float(np.max(self.inflation(ortho * best.rest / np.sqrt(best.variance))))
            best.told = np.sqrt(best.at) * (best.w[n:] @ more) / np.sqrt(best.variance)
            best.x = best.r = best.gram = None
        return best

    def retuned(self):
        """The model with nuisances as fitted."""
        known = parameters_of(self.model, together=True)
        values = {"axis.coulomb_width": self.likeliest_width()}
        for path, step in zip(self.paths, self.theta):
            if path in known:
                value = known[path].value + float(step)
                if path.startswith("axis."):
                    value = max(value, 0.05 * known[path].value if path == "axis.mass" else 0.0)
                low, high = self.limits.get(path, (-np.inf, np.inf))
                values[path] = min(max(value, low), high)
        try:
            return with_values(self.model, values)
        except ValueError:  # a shape that its effect does not take
            return with_values(self.model, {k: v for k, v in values.items() if not k.startswith("effects.")})

    def likeliest_width(self):
        """Width of the arctangent that is closest to the fitted friction law over the speeds of the motion, m/s."""
        own = self.model.axis.coulomb_width
        parts = {float(q[6:]): float(t) for q, t in zip(self.paths, self.theta) if q.startswith("width.")}
        if not parts:
            return own
        own = max(own, 0.1 * min(parts))
        v = np.quantile(np.concatenate([np.abs(b.velocity[b.keep > 0]) for b in self.balances]), np.linspace(0, 1, 400))
        level = self.model.axis.coulomb - sum(parts.values())
        law = level * np.arctan(v / own) + 0.5 * np.pi * sum(t * np.minimum(v / w, 1.0) for w, t in parts.items())
        if not np.any(law):
            return own
        tried = np.geomspace(min(own, min(parts)), max(own, max(parts)), 60)
        fits = np.arctan(v / tried[:, None])
        return float(tried[np.argmax((fits @ law) ** 2 / np.sum(fits**2, axis=1))])

    def keep_positive(self, taps):
        """Leave out the widths of friction's rise that would need a negative share of it."""
        _, told = self.fitted(taps)
        sigma, target = told.prior
        weight = 1.0 / np.maximum(sigma**2 / told.variance, 1e-12)
        right, gram = told.x @ (told.at * told.r) + weight * target, told.gram
        own = np.array([j < len(self.paths) and self.paths[j].startswith("width.") for j in range(len(right))])
        if not own.any():
            return
        others = np.linalg.solve(gram[np.ix_(~own, ~own)], np.column_stack([gram[np.ix_(~own, own)], right[~own]]))
        beside = gram[np.ix_(own, own)] - gram[np.ix_(own, ~own)] @ others[:, :-1]
        root = np.linalg.cholesky(beside + 1e-10 * np.trace(beside) * np.eye(len(beside)))
        share, _ = nnls(
            root.T, solve_triangular(root, right[own] - gram[np.ix_(own, ~own)] @ others[:, -1], lower=True)
        )
        kept = np.flatnonzero(~own | np.isin(np.arange(len(own)), np.flatnonzero(own)[share > 0.0]))
        self.paths = [self.paths[j] for j in kept if j < len(self.paths)]
        self.prior_sigma, self.prior_offset = self.prior_sigma[kept], self.prior_offset[kept]
        self.nuisances = [t[kept] for t in self.nuisances]

    def glance(self, tables):
        """Log-likelihood ratio of columns against none behind the filters of the null and of the screen.

        It tells, at a hundredth of the time, whom to look at closely.
        """
        costs = []
        for base in (self.null, self.screen):
            c = self.filtered(tables, base.taps)
            c /= np.linalg.norm(c, axis=1)[:, None] + 1e-300
            near = (base.x * base.at) @ c.T
            beside = (c * base.at) @ c.T - near.T @ np.linalg.solve(base.gram, near)
            value, vector = np.linalg.eigh(beside)
            good = value > 1e-6
            heard = vector[:, good].T @ (c @ (base.at * base.rest)) / np.sqrt(value[good])
            costs.append(base.cost - float(heard @ heard) / base.variance)
        return min(self.null.cost, self.screen.cost) - min(costs)

    @cached_property
    def null(self):
        return self.maximised()

    def inflation(self, products):
        """Largest ratio of the variance of a score to what independent rows would have, for each column (p, n)."""
        v = np.maximum(np.sum(products**2, axis=1), 1.0)
        for seconds in (0.1, 0.5):
            edges = np.arange(0, products.shape[1], max(1, round(seconds * self.rate)))
            v = np.maximum(v, np.sum(np.add.reduceat(products, edges, axis=1) ** 2, axis=1))
        return v

    @cached_property
    def screen(self):
        """The nuisances behind a noise filter that no slow force has gone into, for the search.

        It comes from what is left beside forces of any shape along the travel, in time and over the command.
        """
        low, high = (f(g(b.position) for b in self.balances) for f, g in ((min, np.min), (max, np.max)))
        last = max(b.time[-1] for b in self.balances)
        any_force = []
        for b, d in zip(self.balances, self.drives):
            table = [splines(b.position, low, high, 14), hats(b.time, np.linspace(0.0, last, 12))]
            more = [np.sign(b.velocity), b.velocity * np.abs(b.velocity), d * np.abs(d), np.gradient(d)]
            any_force.append(b.rows(np.vstack([*table, more])))
        parts = [np.vstack([n, t]) for n, t in zip(self.nuisances, any_force)]
        taps = self.taps_of(self.fitted(self.plain, parts, rounds=1)[0], parts)
        return self.fitted(taps)[1]

    @cached_property
    def basis(self):
        """Weights of the rows, orthonormal columns of nuisances with their pseudo-observations, and what they leave."""
        null = self.screen
        sigma, target = null.prior
        root = np.sqrt(null.at / null.variance)
        finite = np.isfinite(sigma)
        prior = np.diag(1.0 / np.where(finite, sigma, 1.0))[:, finite]
        y = np.concatenate([null.r * root, (target / sigma)[finite]])
        q = orthonormal(np.hstack([null.x * root, prior]))
        return root, q, y - (q @ y) @ q

    def project(self, tables):
        """Whitened candidate columns freed of the nuisances, (k, n + priors), and their sizes before."""
        root, q, e = self.basis
        c = self.filtered(tables, self.screen.taps) * root
        before = np.linalg.norm(c, axis=1)
        c = np.hstack([c, np.zeros((len(c), len(e) - c.shape[1]))])
        return c - (c @ q.T) @ q, before

    def score(self, tables):
        """T of a group of columns in the null's filter, their amplitudes, and the degrees of freedom."""
        e = self.basis[2]
        c, before = self.project(tables)
        size = np.linalg.norm(c, axis=1)
        seen = size > np.maximum(0.02 * before, 1e-9)
        amplitudes = np.zeros(len(c))
        if not seen.any():
            return 0.0, amplitudes, 0
        c = c[seen] / size[seen, None]
        value, vector = np.linalg.eigh(c @ c.T)
        good = value > 1e-6 * value[-1]
        ortho = (vector[:, good] / np.sqrt(value[good])).T @ c
        s = ortho @ e
        n = len(self.screen.r)
        v = self.inflation(ortho[:, :n] * (e - s @ ortho)[:n])
        amplitudes[seen] = (vector[:, good] @ (s / np.sqrt(value[good]))) / size[seen]
        return float(np.sum(s**2 / v)), amplitudes, int(good.sum())


def orthonormal(rows):
    """Orthonormal rows that span rows (p, n), but for what is nothing beside the largest."""
    size = np.linalg.norm(rows, axis=1)
    rows = rows[size > 1e-12 * size.max()] / size[size > 1e-12 * size.max(), None]
    value, vector = np.linalg.eigh(rows @ rows.T)
    good = value > 1e-9 * value[-1]
    return (vector[:, good] / np.sqrt(value[good])).T @ rows


LAGS = (-2, -1, 0, 1, 2, 3, 4, 6, 8, 12, 16, 24, 32, 48, 64, 96)  # of 0.4 ms


def drive(b, model):
    """The command as far as the motion asked for tells it, and what it accelerates the axis with, V and m/s^2 (n,).

    What the loop makes of its own noise is in the command, and in the noise of later rows: a column made of that alarms
    without any cause. The command is regressed on what the model asks for along the reference, earlier and later.
    So is the friction that slows the axis down: along the reference, no noise of the speed is in it.
    """
    only = model.replace(effects=tuple(e for e in model.effects if "force" in e.HOOKS or "friction_level" in e.HOOKS))
    plant = quiet_plant(only)
    if b.reference is None:
        forces = b.forces([plant])[0]
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
    return told, (told + along) / model.axis.mass


def nuisance_columns(evidence):
    """Columns of what re-tuning may change, with their pseudo-observations: paths (p), and tables (p, n) of each log.

    Mass, friction and the known cogging; the law of friction as a positive mixture of laws that rise to 1 at one speed,
    which is any law that rises ever more slowly; and the parameters of what was accepted.
    """
    model, given, balances = evidence.model, evidence.given, evidence.balances
    known = parameters_of(model, together=True)
    paths, sigma, offset, tables = [], [], [], [[] for _ in balances]

    def add(path, deviation, stated, rows):
        paths.append(path)
        sigma.append(deviation)
        offset.append(stated)
        for table, row in zip(tables, rows):
            table.append(row)

    own, width = model.axis.coulomb, model.axis.coulomb_width
    widths = []
    if given.uncertainty.get("coulomb_width") != 0.0:
        slowest = 2.0 * min(b.speed_noise for b in balances)
        fastest = max(np.abs(b.velocity).max() for b in balances)
        widths = [0.1 * slowest, *(float(w) for w in np.geomspace(slowest, max(12.0 * width, 4.0 * slowest, 0.3 * fastest), WIDTHS))]
    laws = []
    for b in balances:
        if b.cache.get("friction", (None,))[0] != (width, widths):
            v = b.fine[3]
            table = [np.arctan(v / width) * 2 / np.pi if width > 0 else np.sign(v)]
            table += [np.clip(v / w, -1.0, 1.0) for w in widths]
            b.cache["friction"] = (width, widths), b.averaged(np.array(table))
        laws.append(b.cache["friction"][1])
    # the residual is M a less the forces: more mass adds a
    axis = {
        "mass": [-a for a in evidence.accelerations],
        "viscous": [-b.velocity for b in balances],
        "coulomb": [-law[0] for law in laws],
    }
    for name, rows in axis.items():
        u = given.uncertainty.get(name)
        if u != 0.0:
            stated, path = getattr(given.axis, name), f"axis.{name}"
            loose = u is None or path in evidence.free
            add(path, np.inf if loose else u * max(abs(stated), 1e-12), stated - getattr(model.axis, name), rows)
    # friction may follow a bend of the contact instead of the speed: it is a part of a row late
    late = [np.diff(law[0], prepend=law[0][0]) / b.thinning for law, b in zip(laws, balances)]
    add("friction.late", TIMING * max(own, 1e-12), 0.0, late)
    for k, w in enumerate(widths, 1):
        add(f"width.{w:g}", max(own, 1e-12), 0.0, [law[0] - law[k] for law in laws])

    largest = max(float(np.max(np.abs(b.command))) for b in balances)
    if model.cogging is not None:
        steps, changed = {}, []
        for row in range(len(model.cogging.sine)):
            size = np.hypot(np.max(np.abs(model.cogging.sine[row])), np.max(np.abs(model.cogging.cosine[row])))
            if size > 0.0 and model.cogging.sine.shape[1] > 1:
                steps |= {f"cogging.gain[{row}]": 0.05, f"cogging.phase[{row}]": 0.05}
            else:
                steps |= {f"cogging.{kind}[{row}][*]": 1e-2 * largest for kind in ("sine", "cosine")}
        changed = [with_values(model, {path: known[path].value + step}) for path, step in steps.items()]
        plants = [quiet_plant(m.replace(effects=())) for m in (model, *changed)]
        forces = [b.forces(plants) for b in balances]
        for k, (path, step) in enumerate(steps.items(), 1):
            add(path, np.inf, 0.0, [(f[k] - f[0]) / step for f in forces])

    evidence.limits = {}
    low, high = (f(g(b.position) for b in balances) for f, g in ((min, np.min), (max, np.max)))
    prefixes = [prefix for prefix, _ in effect_paths(model.effects)]
    for effect, prefix in list(zip(model.effects, prefixes))[len(given.effects) :]:
        for path in [p for p in known if p.startswith(prefix + ".")]:
            name = path[len(prefix) + 1 :].split("[")[0]
            role, quantity = effect.ROLES[name]["role"], effect.ROLES[name]["quantity"]
            if role == "setting" or role == "shape" and isinstance(getattr(effect, name), list):
                continue
            value = known[path].value
            if role == "amplitude":
                deviation = max(abs(value), 1e-3 * largest)
            elif name == "period":
                deviation = 0.5 * value**2 / (high - low)  # half a turn over the travel
            elif name in ("start", "stop"):
                deviation = 0.02
            else:
                deviation = {"frequency": 0.3 / balances[0].time[-1], "position": 0.1 * (high - low)}.get(
                    quantity, 0.3 * abs(value)
                )
            if deviation == 0.0:
                continue
            try:
                pair = [with_values(model, {path: value + q}) for q in (1e-2 * deviation, -1e-2 * deviation)]
                rows = [-(b.residual(pair[0]) - b.residual(pair[1])) / (2e-2 * deviation) for b in balances]
            except ValueError:
                continue
            add(path, deviation, 0.0, rows)
            if role != "amplitude":
                evidence.limits[path] = value - deviation, value + deviation
    evidence.prior_sigma, evidence.prior_offset = np.array(sigma), np.array(offset)
    return paths, [np.array(t) if t else np.zeros((0, len(b.time))) for t, b in zip(tables, balances)]
