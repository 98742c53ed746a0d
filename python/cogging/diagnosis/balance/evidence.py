"""Evidence: what a model leaves of the force balance of logs, and how much likelier it is with something more."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from functools import cached_property
from typing import Any

import numpy as np
from scipy.linalg import solve_triangular
from scipy.optimize import nnls
from scipy.signal import butter, oaconvolve, sosfiltfilt

from cogging._core import Predictor
from cogging.arrays import FloatArray, Mask
from cogging.diagnosis.balance.cells import hats, splines
from cogging.diagnosis.balance.force_balance import ForceBalance
from cogging.effects.effect import Effect, Wave, Window, kind_of
from cogging.estimation.residuals import quiet_plant
from cogging.model.model import Model
from cogging.model.parameters import Parameter, effect_paths, parameters_of, with_values

# Noise
FEWEST = 60  # rows that count: fewer are less than two for each of what is fitted
MEMORY = 1.5  # s, of the noise filter: what is slower is the screen's, which has slow forces of any shape taken out
BAND = 1.3  # about a frequency, up and down, of whose power the noise filter takes the median: a third of an octave
LINES = 24  # of the spectrum, at least, in that band: the median of fewer is too uncertain
CENTRES = 96  # frequencies at which the median is taken, a few in each band
TAIL = 5.0  # degrees of freedom of Student's noise: tails of measured residuals
SINGULAR = 1e-8  # of the largest eigenvalue of columns that are scaled to 1: less is rounding
OUTLIER = 5.0  # deviations at which rows are cut for the noise filter
BLOCKS = (0.1, 0.5)  # s, over which the products of a score are summed for its variance: reversals, strokes
LARGELY = 0.3  # of the command's deviation: where more is left, that is no noise, and no noise filter is made of it
# Nuisances
TIMING = 0.25  # rows of a log by which friction may be late
WIDTHS = 32  # of Coulomb friction's rise, of which its law is made: a factor of 1.3 apart over four decades
KNEE = 0.6  # of the highest speed, up to which friction may bend: beyond, a bend is as good as viscous friction
WIDER = (1.0, 0.35, 0.5, 0.7, 1.4, 2.0)  # times the width of friction, that are tried for a model alone
SHARES_OF_A_STEP = (1.0, 0.5, 0.25, 0.1)  # of re-tuning, until it leads nearer to the likeliest
UNSTATED = 1.0  # uncertainty of mass and friction where none is stated
LEAST_MASS = 0.05  # of the mass: re-tuning makes it no smaller
COGGING_STEP = 0.05  # relative, and rad: step of gain and phase of the known cogging for their columns
# Instruments: the command regressed on what the model asks for along the reference, earlier and later
LAGS = (-2, -1, 0, 1, 2, 3, 4, 6, 8, 12, 16, 24, 32, 48, 64, 96)  # of LAG: a loop's answer lasts some 40 ms
LAG = 4e-4  # s
MOST_BAND = 0.8  # of half the rate of the rows: highest corner of these filters
SLOW = 10.0  # Hz, below which the measured acceleration holds little noise


def noise_filter(e: FloatArray, mask: Mask, rate: float) -> FloatArray:
    """Taps of the causal whitening filter of smallest phase of rows e (n,), the first one 1.

    The spectrum at a frequency is the median of the power over a band about it: a line is a signal, as what is periodic
    in motion shows as lines, and noise has none that are so narrow. The taps follow from it by its cepstrum.
    """
    size = int(2 ** np.ceil(np.log2(2 * len(e))))
    power = np.abs(np.fft.rfft(np.where(mask, e, 0.0), size)) ** 2
    lines = np.arange(1, len(power))
    centres = np.unique(np.geomspace(LINES, lines[-1], CENTRES).astype(int))
    low = np.maximum(1, np.minimum((centres / BAND).astype(int), centres - LINES // 2))
    high = np.minimum(len(power), np.maximum((centres * BAND).astype(int), centres + LINES // 2) + 1)
    level = np.array([np.median(power[a:b]) for a, b in zip(low, high, strict=True)])
    smooth = np.interp(np.log(lines), np.log(centres), np.log(level + 1e-9 * level.max()))
    cepstrum = np.fft.irfft(-0.5 * np.concatenate([smooth[:1], smooth]), size)
    cepstrum[1 : size // 2] *= 2.0
    cepstrum[size // 2 + 1 :] = 0.0
    taps = np.fft.irfft(np.exp(np.fft.rfft(cepstrum)), size)
    return np.asarray(taps[: max(2, int(MEMORY * rate))] / taps[0])


class TooLittleMotion(ValueError):
    """Logs of which too few rows count."""


@dataclass
class Maximum:
    """A hypothesis at its likeliest: columns x (p, n) in whitened rows r (n,).

    Attributes:
        cost: minus twice the logarithm of the likelihood.
        w: amplitudes of the columns as scaled, (p,).
        rest: whitened rows less the columns, (n,), and their variance.
        weight: of each row, less than 1 for outliers, (n,).
        gram: weighted products of the columns with each other, priors included, (p, p).
        unit: twice the logarithm of the deviation of each row before its filter.
        theta: amplitudes of the columns in their own units, (p,).
        taps: noise filter of each log.
        r, x: rows and columns behind the filter, the latter scaled to 1.
        prior: deviation and mean of each scaled amplitude.
        size: by which columns are scaled, (p,).
        none: the same rows without the columns that were added.
        inflation: largest ratio of the variance of a score to what independent rows would have.
        told: what the added columns explain of each row, in deviations, (n,).
    """

    cost: float
    w: FloatArray
    rest: FloatArray
    variance: float
    weight: FloatArray
    gram: FloatArray
    unit: FloatArray = field(default_factory=lambda: np.zeros(1))
    theta: FloatArray = field(init=False)
    taps: list[FloatArray] = field(init=False)
    r: FloatArray = field(init=False)
    x: FloatArray = field(init=False)
    prior: tuple[FloatArray, FloatArray] = field(init=False)
    size: FloatArray = field(init=False)
    none: Maximum = field(init=False)
    inflation: float = field(init=False, default=1.0)
    told: FloatArray = field(init=False)

    def solved(self, free: Mask, theta: FloatArray, r: FloatArray | None = None) -> FloatArray:
        """Amplitudes theta (p,) with those that are free at their likeliest beside the others, in its rows or in r."""
        sigma, target = self.prior
        slope = self.x @ (self.weight * (self.r if r is None else r)) + target / np.maximum(
            sigma**2 / self.variance, 1e-12
        )
        w = np.where(free, 0.0, theta * self.size)
        w[free] = np.linalg.lstsq(self.gram[np.ix_(free, free)], (slope - self.gram @ w)[free])[0]
        return np.asarray(w / self.size)

    def by_row(self) -> FloatArray:
        """Minus twice the logarithm of the density of each row, (n,)."""
        return student_cost(self.rest, self.variance) + self.unit


def deviation(x: FloatArray) -> float:
    """Standard deviation of normal rows from their median size, which outliers do not change."""
    return max(1.4826 * float(np.median(np.abs(x))), 1e-300)


def student_cost(rest: FloatArray, variance: float) -> FloatArray:
    """Minus twice the logarithm of Student's density of each row, without its constant."""
    return np.asarray((TAIL + 1.0) * np.log1p(rest**2 / (TAIL * variance)) + np.log(variance))


def likeliest(x: FloatArray, r: FloatArray, sigma: FloatArray, target: FloatArray, rounds: int = 3) -> Maximum:
    """Columns x (p, n) at their likeliest in rows r, by re-weighted least squares: Student's noise.

    Amplitudes have normal priors of deviation sigma (infinite: none) about target. Outliers decide little.
    """
    weight, variance = np.ones(len(r)), deviation(r) ** 2
    for _ in range(rounds):
        prior = 1.0 / np.maximum(sigma**2 / variance, 1e-12)
        scaled = x * np.sqrt(weight)
        gram = scaled @ scaled.T + np.diag(prior + 1e-12 * len(r))
        # of columns that say nearly the same, one direction is left out: else they cancel at enormous sizes
        unit = np.sqrt(np.diag(gram))
        value, vector = np.linalg.eigh(gram / np.outer(unit, unit))
        seen = value > SINGULAR * value[-1]
        along = vector[:, seen].T @ ((x @ (weight * r) + prior * target) / unit)
        w = vector[:, seen] @ (along / value[seen]) / unit
        rest = r - w @ x
        weight = (TAIL + 1.0) / (TAIL + rest**2 / variance)
        variance = float(weight @ rest**2) / len(rest)
    cost = student_cost(rest, variance).sum() + float(np.sum(((w - target) / sigma) ** 2))
    return Maximum(cost, w, rest, variance, weight, gram)


@dataclass
class Evidence:
    """Logs under a model with what was accepted.

    Attributes:
        balances: force balances of the logs.
        given: model as it was read, which the priors are of.
        model: the same re-tuned, with what was accepted.
        extra: candidates that were accepted without a law: each has `columns(evidence)`.
        free: paths of the axis whose prior is released.
        plainly: whether nothing is whitened, however little is left: what is left of large effects is no noise either.
        drives: part of the command that the motion asked for explains, V, (n,) of each log; accelerations (m/s^2) and
            blurs (V): see `drive`.
        largely: whether what is left is so much of the command that it is no noise.
        alike: how many rows of it say the same; 1 for noise.
        paths: of the nuisances, p of them, before the columns of `extra`.
        prior_sigma: deviation of each nuisance and column of `extra`, (q,); prior_offset its mean.
        limits: range in which re-tuning keeps a parameter, by path.
        counted: rows of each log that count behind a noise filter; masks: before it.
        residuals: what the model leaves of each log, as it is compared, (m,); nuisances likewise, (q, m).
        fit: nuisances at their likeliest behind the noise filters `start`, of amplitudes `theta`, (q,).
    """

    balances: list[ForceBalance]
    given: Model
    model: Model
    extra: list[Any] = field(default_factory=list)
    free: tuple[str, ...] = ()
    plainly: bool = False
    drives: list[FloatArray] = field(init=False, repr=False)
    accelerations: list[FloatArray] = field(init=False, repr=False)
    blurs: list[FloatArray] = field(init=False, repr=False)
    largely: bool = field(init=False, repr=False, default=False)
    alike: float = field(init=False, repr=False, default=1.0)
    paths: list[str] = field(init=False, repr=False)
    prior_sigma: FloatArray = field(init=False, repr=False)
    prior_offset: FloatArray = field(init=False, repr=False)
    limits: dict[str, tuple[float, float]] = field(init=False, repr=False, default_factory=dict)
    masks: list[Mask] = field(init=False, repr=False)
    counted: list[Mask] = field(init=False, repr=False)
    raw: list[FloatArray] = field(init=False, repr=False)
    residuals: list[FloatArray] = field(init=False, repr=False)
    nuisances: list[FloatArray] = field(init=False, repr=False)
    start: list[FloatArray] = field(init=False, repr=False)
    fit: Maximum = field(init=False, repr=False)
    theta: FloatArray = field(init=False, repr=False)

    def prepare(self, rounds: int = 0, listen: bool = False) -> Evidence:
        """The same with columns and null, the model re-tuned round by round; `listen`: choose the balance's band.

        A step is halved until it leads nearer to the likeliest: one along columns of a law that bends may be too long.
        """
        for k in range(rounds):
            self.make()
            if k == 0 and listen:
                for b, r in zip(self.balances, self.raw, strict=True):
                    b.set_corner(r, self.model.axis.mass, self.largely)
                self.make()
            before = self.decrement(self.model)
            for share in SHARES_OF_A_STEP:
                model = self.retuned(share)
                if self.decrement(model) <= before:
                    self.model = model
                    break
        self.make()
        return self

    def decrement(self, model: Model) -> float:
        """By how much 2 ln likelihood would still rise from a re-tuned model on, in the parameters that it has.

        The power that is left says less: columns hold no noise of the readings, which what is left does.
        """
        fit, known = self.fit, parameters_of(model, together=True)
        old = parameters_of(self.model, together=True)
        has = np.array([p in known for p in self.paths] + [False] * (len(fit.w) - len(self.paths)))
        moved = [known[p].value - old[p].value if p in known else 0.0 for p in self.paths]
        sigma, target = fit.prior
        target = np.where(has, target - np.pad(moved, (0, len(fit.w) - len(moved))) * fit.size, target)
        left = self.filtered([b.rows(b.residual(model)) for b in self.balances], fit.taps)[0]
        slope = fit.x @ (fit.weight * left) + target / np.maximum(sigma**2 / fit.variance, 1e-12)
        beside = fit.gram[np.ix_(has, ~has)] @ np.linalg.pinv(fit.gram[np.ix_(~has, ~has)], hermitian=True)
        own = slope[has] - beside @ slope[~has]
        return float(own @ np.linalg.solve(fit.gram[np.ix_(has, has)] - beside @ fit.gram[np.ix_(~has, has)], own))

    def make(self) -> None:
        """Make the columns of the balance under the model, and fit them."""
        made = [drive(b, self.model) for b in self.balances]
        self.drives, self.accelerations, self.blurs = ([one[k] for one in made] for k in range(3))
        self.paths, tables = nuisance_columns(self)
        more = [s.columns(self) for s in self.extra]
        tables = [np.vstack([t, *(s[i] for s in more)]) for i, t in enumerate(tables)]
        count = len(tables[0]) - len(self.paths)
        self.prior_sigma = np.concatenate([self.prior_sigma, np.full(count, np.inf)])
        self.prior_offset = np.concatenate([self.prior_offset, np.zeros(count)])
        self.raw = [b.residual(self.model) for b in self.balances]
        self.masks = [b.mask for b in self.balances]
        self.counted = [b.counted for b in self.balances]
        if (count := sum(int(m.sum()) for m in self.counted)) < FEWEST:
            raise TooLittleMotion(f"the encoder resolves the motion in {count} rows at {self.rate:.3g} Hz only")
        self.residuals = [b.rows(r)[0] for b, r in zip(self.balances, self.raw, strict=True)]
        self.nuisances = [b.rows(t) for b, t in zip(self.balances, tables, strict=True)]
        for name in ("null", "screen", "basis", "unfiltered"):
            self.__dict__.pop(name, None)
        theta = self.fitted(self.plain, rounds=1).theta
        rows = zip(self.residuals, self.nuisances, self.masks, strict=True)
        left = np.hstack([(r - theta @ x)[m] for r, x, m in rows])
        command = np.hstack([b.rows(b.command)[0][m] for b, m in zip(self.balances, self.masks, strict=True)])
        self.largely = self.plainly or bool(np.std(left) > LARGELY * np.std(command))
        self.alike = 1.0
        if self.largely:  # what is left is motion, and its rows are far from independent: priors count by as much more
            self.alike = float(self.inflation(left[None] / np.std(left))[0] / len(left))
        taps = self.taps_of(theta)
        self.keep_positive(taps)
        self.start, self.fit = taps, self.fitted(taps)
        self.theta = self.fit.theta

    def filtered(self, tables: Sequence[FloatArray], taps: Sequence[FloatArray]) -> FloatArray:
        """Rows that count behind each log's filter, logs after each other, (p, n)."""
        return np.hstack(
            [
                oaconvolve(t, h[None, :], axes=1)[:, : t.shape[1]][:, m]
                for t, h, m in zip(tables, taps, self.counted, strict=True)
            ]
        )

    @property
    def rate(self) -> float:
        """Rate of the rows, Hz."""
        return self.balances[0].rate

    def taps_of(self, theta: FloatArray, parts: Sequence[FloatArray] | None = None) -> list[FloatArray]:
        """Noise filter of each log, of what columns leave, to a deviation of 1; outliers are cut."""
        taps = []
        for r, x, m in zip(self.residuals, self.nuisances if parts is None else parts, self.masks, strict=True):
            left = r - theta @ x
            if self.largely:
                taps.append(np.ones(1) / deviation(left[m]))
                continue
            most = OUTLIER * deviation(left[m])
            one = noise_filter(np.clip(left, -most, most), m, self.rate)
            taps.append(one / deviation(oaconvolve(left, one)[: len(left)][m]))
        return taps

    @property
    def plain(self) -> list[FloatArray]:
        """No filter, but each log to a deviation of 1."""
        return [np.ones(1) / deviation(r[m]) for r, m in zip(self.residuals, self.masks, strict=True)]

    def fitted(
        self,
        taps: list[FloatArray],
        tables: Sequence[FloatArray] | None = None,
        rounds: int = 3,
        base: Maximum | None = None,
    ) -> Maximum:
        """Nuisances, and columns of each log (k, m), at their likeliest behind a filter: that of `base` where given."""
        if base is None:
            base_rows = zip(self.residuals, self.nuisances, strict=True)
            white = self.filtered([np.vstack([r, x]) for r, x in base_rows], taps)
            size = np.sqrt(sum(np.sum(x**2, axis=1) for x in self.nuisances))
            size = np.maximum(size, 1e-12 * size.max())
            r, x = white[0], white[1:] / size[:, None]
        else:
            size, r, x = base.size, base.r, base.x
        if tables is not None:
            more = np.sqrt(sum(np.sum(t**2, axis=1) for t in tables))
            size = np.concatenate([size, np.maximum(more, 1e-12 * size.max())])
            x = np.vstack([x, self.filtered(tables, taps) / size[len(x) :, None]])
        count = len(size) - len(self.prior_sigma)
        sigma = np.concatenate([self.prior_sigma, np.full(count, np.inf)]) * size / np.sqrt(self.alike)
        target = np.concatenate([self.prior_offset, np.zeros(count)]) * size
        best = likeliest(x, r, sigma, target, rounds)
        scale = [-2.0 * np.log(abs(h[0])) for h in taps]
        best.unit = np.repeat(scale, [int(m.sum()) for m in self.counted])
        best.cost += best.unit.sum()
        best.theta, best.taps, best.r, best.x, best.prior = best.w / size, taps, r, x, (sigma, target)
        best.size = size
        return best

    def maximised(self, tables: Sequence[FloatArray] | None = None) -> Maximum:
        """Nuisances and columns of each log (k, m) at their likeliest, with the noise filter that suits them best.

        The filter is part of each hypothesis: with that of the null, a slow force is half taken for noise; with that of
        the candidate, nulls alarm. Their likelihood ratio, each with its own, does neither. A filter that has swallowed
        a force finds no force that it could give back: what is left without any filter is a start as well.
        """
        if tables is None:
            parts, rounds = self.nuisances, 2
            best = min((self.fitted(taps) for taps in (self.plain, self.start)), key=lambda fit: fit.cost)
        else:
            parts, rounds = [np.vstack([n, t]) for n, t in zip(self.nuisances, tables, strict=True)], 1
            base = self.bases[int(np.argmin(self.costs_with(tables)))]
            best = self.fitted(base.taps, tables, base=base)
        for _ in range(rounds):
            fit = self.fitted(self.taps_of(best.theta, parts), tables)
            if fit.cost >= best.cost:
                break
            best = fit
        if tables is not None:
            self._compare(best, len(self.nuisances[0]))
        return best

    def _compare(self, best: Maximum, n: int) -> None:
        """Fill in what a maximum adds to its first n columns, and release its rows: many maxima are held at once."""
        x, (sigma, target) = best.x, best.prior
        # none may be likelier behind the candidate's filter than behind its own
        none = likeliest(x[:n], best.r, sigma[:n], target[:n])
        none.unit = best.unit
        none.cost += best.unit.sum()
        best.none = none if none.cost < self.null.cost else self.null
        near = (x[:n] * best.weight) @ x[n:].T
        more = x[n:] - np.linalg.solve(best.gram[:n, :n], near).T @ x[:n]
        ortho = orthonormal(more * np.sqrt(best.weight)) * np.sqrt(best.weight)
        best.inflation = float(np.max(self.inflation(ortho * best.rest / np.sqrt(best.variance)), initial=1.0))
        best.told = np.sqrt(best.weight) * (best.w[n:] @ more) / np.sqrt(best.variance)
        best.x = best.r = best.gram = np.zeros(0)

    def retuned(self, share: float = 1.0) -> Model:
        """The model with the nuisances as fitted."""
        steps = {path: share * float(step) for path, step in zip(self.paths, self.theta, strict=False)}
        width = self.likeliest_width()
        return self.moved(self.model, steps | {"axis.coulomb_width": width - self.model.axis.coulomb_width})

    def settled(self, model: Model, gone: Sequence[str] = (), kept: Sequence[int] = ()) -> Model:
        """A model alone that leaves as little of the balance as it can, as far as that is linear.

        The balance is explained by more than a model can have, as mixtures of laws of friction. Effects are as they are
        likeliest beside these; with mass, friction and known cogging likewise, the model by itself would explain less
        than it could: they are tuned to the gap, in rows that are not whitened.

        Args:
            model: the evidence's, with effects behind it for some of `extra`.
            gone: paths of effects that are dropped too, and of parameters of the axis, which go back to what is stated.
            kept: places in `extra` of what is an effect of the model.
        """
        known, effects = parameters_of(model, together=True), dict(effect_paths(model.effects))
        free, moved = np.ones(len(self.null.theta), dtype=bool), np.zeros(len(self.null.theta))
        paths = self.paths_in(model)
        for k, path in enumerate(paths):
            owner = next((one for one in gone if path == one or path.startswith(one + ".")), "")
            free[k] = not owner
            if owner == path:
                moved[k] = getattr(self.given.axis, path.removeprefix("axis.")) - known[path].value
            elif owner:  # of a law that has amplitudes, these alone make it vanish
                roles = {name: role["role"] for name, role in effects[owner].ROLES.items()}
                if roles[path[len(owner) + 1 :].split("[")[0]] == "amplitude" or "amplitude" not in roles.values():
                    moved[k] = -known[path].value
        own = np.array(
            [p in known and not p.startswith("effects.") for p in paths] + [False] * (len(free) - len(paths))
        )
        at = len(paths)
        for place, column in enumerate(self.extra):
            free[at : at + len(column.amplitudes)] = place in kept
            at += len(column.amplitudes)
        # effects as they are likeliest beside all nuisances, then the axis as it leaves least of the gap without these
        moved = self.null.solved(free, moved)
        beside = np.array([p not in known for p in paths] + [False] * (len(free) - len(paths)))
        moved, gap, least = np.where(beside, 0.0, moved), self.unfiltered, np.inf
        width = self.model.axis.coulomb_width
        for factor in WIDER if width > 0.0 and self.given.uncertainty.get("coulomb_width") != 0.0 else (1.0,):
            wider = with_values(self.model, {"axis.coulomb_width": factor * width})
            left = self.filtered([b.rows(b.residual(wider)) for b in self.balances], gap.taps)[0]
            whole = gap.solved(own & free, moved, left)
            for share in SHARES_OF_A_STEP:
                steps = dict(zip(paths, map(float, moved + share * (whole - moved)), strict=False))
                tuned = self.moved(model.replace(axis=wider.axis), steps)
                kept_effects = [effect for path, effect in effect_paths(tuned.effects) if path not in gone]
                tuned = tuned.replace(effects=tuple(kept_effects))
                power = sum(float(np.mean(b.rows(b.residual(tuned))[0][b.mask] ** 2)) for b in self.balances)
                if power < least:
                    least, best = power, tuned
        return best

    def paths_in(self, model: Model) -> list[str]:
        """`paths` as a model with more effects behind those of this one calls them: two of a name have numbers."""
        own, other = ([path for path, _ in effect_paths(m.effects)] for m in (self.model, model))
        renamed = {old: new for old, new in zip(own, other, strict=False) if old != new}
        owners = [next((old for old in renamed if path.startswith(old + ".")), "") for path in self.paths]
        return [renamed.get(old, "") + path[len(old) :] for path, old in zip(self.paths, owners, strict=True)]

    def moved(self, model: Model, steps: Mapping[str, float]) -> Model:
        """A model whose parameters are moved, as far as they may."""
        known, values = parameters_of(model, together=True), {}
        for path, step in steps.items():
            if path in known:
                value = known[path].value
                least = LEAST_MASS * value if path == "axis.mass" else 0.0 if path.startswith("axis.") else -np.inf
                low, high = self.limits.get(path, (-np.inf, np.inf))
                values[path] = min(max(value + step, least, low), high)
        try:
            return with_values(model, values)
        except ValueError:  # a shape that its effect does not take
            return with_values(model, {k: v for k, v in values.items() if not k.startswith("effects.")})

    def likeliest_width(self) -> float:
        """Width of the arctangent that is closest to the fitted friction law over the speeds of the motion, m/s."""
        own = self.model.axis.coulomb_width
        parts = {float(q[6:]): float(t) for q, t in zip(self.paths, self.theta, strict=False) if q.startswith("width.")}
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

    def keep_positive(self, taps: list[FloatArray]) -> None:
        """Leave out the widths of friction's rise that would need a negative share of it."""
        fit = self.fitted(taps, rounds=1)
        sigma, target = fit.prior
        prior = 1.0 / np.maximum(sigma**2 / fit.variance, 1e-12)
        right, gram = fit.x @ (fit.weight * fit.r) + prior * target, fit.gram
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

    @property
    def bases(self) -> tuple[Maximum, Maximum, Maximum]:
        """The nuisances at their likeliest behind no filter, behind their own, and behind that of the search."""
        return self.unfiltered, self.null, self.screen

    def costs_with(self, tables: Sequence[FloatArray]) -> list[float]:
        """Minus twice the logarithm of the likelihood with columns, behind the filter of each of `bases`.

        One step of least squares: it takes a hundredth of the time of `maximised`, and says for which candidates that
        is worth while, and from where.
        """
        costs = []
        for base in self.bases:
            c = self.filtered(tables, base.taps)
            c /= np.linalg.norm(c, axis=1)[:, None] + 1e-300
            near = (base.x * base.weight) @ c.T
            beside = (c * base.weight) @ c.T - near.T @ np.linalg.solve(base.gram, near)
            value, vector = np.linalg.eigh(beside)
            good = value > 1e-6
            along = vector[:, good].T @ (c @ (base.weight * base.rest)) / np.sqrt(value[good])
            costs.append(base.cost - float(along @ along) / base.variance)
        return costs

    def quick_ratio(self, tables: Sequence[FloatArray]) -> float:
        """Twice the logarithm of the likelihood ratio of columns against none, behind the same filters."""
        return min(base.cost for base in self.bases) - min(self.costs_with(tables))

    @cached_property
    def null(self) -> Maximum:
        """The nuisances alone at their likeliest."""
        return self.maximised()

    @cached_property
    def unfiltered(self) -> Maximum:
        """The nuisances at their likeliest in rows that are not whitened."""
        return self.fitted(self.plain)

    def inflation(self, products: FloatArray) -> FloatArray:
        """Ratio of the variance of a score to 1, what independent rows would have, at least 1, (p,).

        Args:
            products: of each row with each of p columns of length 1, in deviations, (p, n).
        """
        v = np.maximum(np.sum(products**2, axis=1), 1.0)
        for seconds in BLOCKS:
            edges = np.arange(0, products.shape[1], max(1, round(seconds * self.rate)))
            v = np.maximum(v, np.sum(np.add.reduceat(products, edges, axis=1) ** 2, axis=1))
        return np.asarray(v)

    @cached_property
    def screen(self) -> Maximum:
        """The nuisances at their likeliest behind a noise filter that contains no slow force, for the search.

        It comes from what is left beside forces of any shape along the travel, in time and over the command.
        """
        low, high = (f(g(b.position) for b in self.balances) for f, g in ((min, np.min), (max, np.max)))
        last = max(b.time[-1] for b in self.balances)
        any_force = []
        for b, d in zip(self.balances, self.drives, strict=True):
            table = [splines(b.position, low, high, 14), hats(b.time, np.linspace(0.0, last, 12))]
            more = [np.sign(b.velocity), b.velocity * np.abs(b.velocity), d * np.abs(d), np.gradient(d)]
            any_force.append(b.rows(np.vstack([*table, more])))
        parts = [np.vstack([n, t]) for n, t in zip(self.nuisances, any_force, strict=True)]
        return self.fitted(self.taps_of(self.fitted(self.plain, any_force, rounds=1).theta, parts))

    @cached_property
    def basis(self) -> tuple[FloatArray, FloatArray, FloatArray]:
        """Weights of the rows, orthonormal columns of nuisances with their pseudo-observations, and what they leave."""
        null = self.screen
        sigma, target = null.prior
        root = np.sqrt(null.weight / null.variance)
        finite = np.isfinite(sigma)
        prior = np.diag(1.0 / np.where(finite, sigma, 1.0))[:, finite]
        y = np.concatenate([null.r * root, (target / sigma)[finite]])
        q = orthonormal(np.hstack([null.x * root, prior]))
        return root, q, y - (q @ y) @ q

    def project(self, tables: Sequence[FloatArray]) -> tuple[FloatArray, FloatArray]:
        """Whitened candidate columns freed of the nuisances, (k, n + priors), and their sizes before."""
        root, q, e = self.basis
        c = self.filtered(tables, self.screen.taps) * root
        before = np.linalg.norm(c, axis=1)
        c = np.hstack([c, np.zeros((len(c), len(e) - c.shape[1]))])
        return c - (c @ q.T) @ q, before

    def score(self, tables: Sequence[FloatArray]) -> tuple[float, FloatArray, int]:
        """Score statistic T of columns (k, m), chi-square if nothing is missing, amplitudes, degrees of freedom."""
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


def orthonormal(rows: FloatArray) -> FloatArray:
    """Orthonormal rows that span rows (p, n), without directions that are rounding errors of the largest."""
    size = np.linalg.norm(rows, axis=1)
    if not np.any(size):
        return rows[:0]
    rows = rows[size > 1e-12 * size.max()] / size[size > 1e-12 * size.max(), None]
    value, vector = np.linalg.eigh(rows @ rows.T)
    good = value > 1e-9 * value[-1]
    return np.asarray((vector[:, good] / np.sqrt(value[good])).T @ rows)


def drive(b: ForceBalance, model: Model) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Part of the command that the motion asked for explains, the acceleration that it causes, and friction's blur.

    V, m/s^2 and V, (n,) each. What the loop makes of its own noise is in the command, and in the noise of later rows: a
    column made of that alarms without any cause. The command is regressed on what the model asks for along the
    reference, earlier and later; friction is taken along the reference too. The blur is what the bare axis' forces
    along the measured motion have beyond those: mostly noise of the speed, of which no scale of forces may make use.
    """
    only = model.replace(effects=tuple(e for e in model.effects if "force" in e.HOOKS or "friction_level" in e.HOOKS))
    plant = quiet_plant(only)
    if b.reference is None:
        forces = b.forces([plant])[0]
        slow = sosfiltfilt(butter(2, min(b.corner * b.step, MOST_BAND), output="sos"), b.command)
        caused = (slow + forces) / model.axis.mass
        # below SLOW what was measured: the command holds against forces that the model lacks as well
        read = butter(2, min(2.0 * SLOW * b.step, MOST_BAND), output="sos")
        caused = caused + sosfiltfilt(read, b.acceleration - caused)
        slow = model.axis.mass * caused - forces
        return slow, caused, np.zeros_like(slow)
    x, v, a = b.reference
    along = Predictor(b.time, x, np.zeros(len(x))).net_force([plant], x, v)[0]
    rows = np.arange(len(x))
    stride = max(1, round(LAG / b.step))
    columns = [np.ones(len(x)), x - x.mean(), v]
    for lag in LAGS:
        at = np.clip(rows - stride * lag, 0, len(x) - 1)
        columns += [a[at], along[at]]
    table = np.array(columns)
    size = np.linalg.norm(table, axis=1) + 1e-300
    table /= size[:, None]
    w = np.linalg.solve(table @ table.T + 1e-9 * np.eye(len(table)), table @ b.command)
    explained = w @ table
    bare = quiet_plant(model.replace(effects=()))
    blur = b.forces([bare])[0] - Predictor(b.time, x, np.zeros(len(x))).net_force([bare], x, v)[0]
    return explained, (explained + along) / model.axis.mass, blur


def nuisance_columns(evidence: Evidence) -> tuple[list[str], list[FloatArray]]:
    """Columns of what re-tuning may change, with their priors: paths (p), and a table (p, n) of each log.

    Mass, friction and the known cogging; the law of friction as a positive mixture of laws that rise to 1 at one speed,
    which is any law that rises ever more slowly; and the parameters of what was accepted.
    """
    model, given, balances = evidence.model, evidence.given, evidence.balances
    known = parameters_of(model, together=True)
    columns = Nuisances(balances)
    laws, widths = friction_laws(evidence)
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
            loose = path in evidence.free or stated == 0.0
            sigma = np.inf if loose else (UNSTATED if u is None else u) * max(abs(stated), 1e-12)
            columns.add(path, sigma, rows, stated - getattr(model.axis, name))
    # friction may follow a bend of the contact instead of the speed: it is a part of a row late
    own = model.axis.coulomb
    rubs = own > SINGULAR * columns.largest  # nothing can be told of a friction that is hardly there
    late = [np.diff(law[0], prepend=law[0][0]) / b.thinning for law, b in zip(laws, balances, strict=True)]
    if rubs:
        columns.add("friction.late", TIMING * own, late)
    if any(np.any(blur) for blur in evidence.blurs):
        columns.add("friction.blur", 1.0, evidence.blurs)
    for k, w in enumerate(widths if rubs else [], 1):
        columns.add(f"width.{w:g}", own, [law[0] - law[k] for law in laws])
    add_cogging(columns, model, known)
    evidence.limits = {}
    prefixes = [prefix for prefix, _ in effect_paths(model.effects)]
    for effect, prefix in list(zip(model.effects, prefixes, strict=True))[len(given.effects) :]:
        for path in [p for p in known if p.startswith(prefix + ".")]:
            add_parameter(columns, evidence, effect, path[len(prefix) + 1 :].split("[")[0], known[path])
    evidence.prior_sigma, evidence.prior_offset = np.array(columns.sigma), np.array(columns.offset)
    tables = zip(columns.tables, balances, strict=True)
    return columns.paths, [np.array(t) if t else np.zeros((0, len(b.time))) for t, b in tables]


class Nuisances:
    """Columns of several logs with paths and normal priors, one after the other."""

    def __init__(self, balances: list[ForceBalance]) -> None:
        self.balances = balances
        self.largest = max(float(np.max(np.abs(b.command))) for b in balances)  # V
        self.paths: list[str] = []
        self.sigma: list[float] = []
        self.offset: list[float] = []
        self.tables: list[list[FloatArray]] = [[] for _ in balances]

    def add(self, path: str, sigma: float, rows: Sequence[FloatArray], offset: float = 0.0) -> None:
        """Add a column, one row of each log, of a parameter that is offset +- sigma from where it stands."""
        self.paths.append(path)
        self.sigma.append(sigma)
        self.offset.append(offset)
        for table, row in zip(self.tables, rows, strict=True):
            table.append(row)


def friction_laws(evidence: Evidence) -> tuple[list[FloatArray], list[float]]:
    """Laws of friction of level 1, (1 + widths, n) of each log: the model's own, ramps that end at widths (m/s)."""
    model, balances = evidence.model, evidence.balances
    width, widths = model.axis.coulomb_width, []
    if evidence.given.uncertainty.get("coulomb_width") != 0.0:
        slowest = 2.0 * min(b.speed_noise for b in balances)
        fastest = max(np.abs(b.velocity).max() for b in balances)
        last = max(12.0 * width, 4.0 * slowest, KNEE * fastest)
        widths = [0.1 * slowest, *(float(w) for w in np.geomspace(slowest, last, WIDTHS))]
    laws = []
    for b in balances:
        if b.cache.get("friction", (None,))[0] != (width, widths):
            v = b.fine.velocity
            table = [np.arctan(v / width) * 2 / np.pi if width > 0 else np.sign(v)]
            table += [np.clip(v / w, -1.0, 1.0) for w in widths]
            b.cache["friction"] = (width, widths), b.averaged(np.array(table))
        laws.append(b.cache["friction"][1])
    return laws, widths


def add_cogging(columns: Nuisances, model: Model, known: dict[str, Parameter]) -> None:
    """Add gain and phase of each harmonic of the known cogging; sine and cosine where it has one amplitude or none."""
    if model.cogging is None:
        return
    steps: dict[str, float] = {}
    for row in range(len(model.cogging.sine)):
        size = np.hypot(np.max(np.abs(model.cogging.sine[row])), np.max(np.abs(model.cogging.cosine[row])))
        if size > 0.0 and model.cogging.sine.shape[1] > 1:
            steps |= {f"cogging.{kind}[{row}]": COGGING_STEP for kind in ("gain", "phase")}
        else:
            steps |= {f"cogging.{kind}[{row}][*]": 1e-2 * columns.largest for kind in ("sine", "cosine")}
    changed = [with_values(model, {path: known[path].value + step}) for path, step in steps.items()]
    plants = [quiet_plant(m.replace(effects=())) for m in (model, *changed)]
    forces = [b.forces(plants) for b in columns.balances]
    for k, (path, step) in enumerate(steps.items(), 1):
        columns.add(path, np.inf, [(f[k] - f[0]) / step for f in forces])


def add_parameter(columns: Nuisances, evidence: Evidence, effect: Effect, name: str, parameter: Parameter) -> None:
    """Add a field of an accepted effect by the difference quotient of the residual, unless it is a setting.

    The prior keeps a field that is no amplitude where the law is nearly linear in it: half a turn over the travel.
    """
    balances, path, value = evidence.balances, parameter.path, parameter.value
    wave, window = kind_of(effect, Wave), kind_of(effect, Window)
    role, quantity = effect.ROLES[name]["role"], effect.ROLES[name]["quantity"]
    if role == "setting" or (role == "shape" and isinstance(getattr(effect, name), list)):
        return
    low, high = min(np.min(b.position) for b in balances), max(np.max(b.position) for b in balances)
    if role == "amplitude":
        sigma = max(abs(value), 1e-3 * columns.largest)
    elif wave is not None and name == wave.shape and quantity == "distance":
        sigma = 0.5 * value**2 / (high - low)
    elif window is not None and name in (window.start, window.stop):
        sigma = 0.02
    else:
        sizes = {"frequency": 0.3 / balances[0].time[-1], "position": 0.1 * (high - low)}
        sigma = sizes.get(quantity, 0.3 * abs(value))
    if sigma == 0.0:
        return
    try:
        pair = [with_values(evidence.model, {path: value + q}) for q in (1e-2 * sigma, -1e-2 * sigma)]
        rows = [
            -(b.residual(pair[0], d) - b.residual(pair[1], d)) / (2e-2 * sigma)
            for b, d in zip(balances, evidence.drives, strict=True)
        ]
    except ValueError:  # a value that the effect does not take
        return
    columns.add(path, sigma, rows)
    if role != "amplitude":
        evidence.limits[path] = value - sigma, value + sigma
