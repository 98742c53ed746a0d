"""Whitened residuals of the force balance under a model, and likelihood ratios of candidate terms.

Nuisance parameters (mass, friction, known cogging, accepted effects) are fitted under their priors in every hypothesis.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property
from itertools import pairwise
from operator import itemgetter
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.fft import irfft, next_fast_len, rfft
from scipy.ndimage import minimum_filter1d
from scipy.optimize import brentq, minimize_scalar, nnls

from cogging.arrays import FloatArray, IntArray, Mask
from cogging.diagnosis.balance.cells import hats, splines
from cogging.diagnosis.balance.differenced_balance import ROWS_PER_CORNER, DifferencedBalance
from cogging.diagnosis.balance.nuisances import ROUNDING, SECANT, WIDTH, Instruments, instruments_of, nuisances_of
from cogging.model.intervals import SIGMAS_95
from cogging.model.model import Model
from cogging.model.parameters import effect_paths, parameters_of, renamed_path, with_values

# Noise
FEWEST = 60  # minimum number of valid rows, about two for each fitted parameter
MEMORY = 1.5  # s: length of the whitening filter; the screening filter accounts for slower forces
BAND = 1.3  # ratio of the band edges to the centre frequency of the median power: a third of an octave
LINES = 24  # minimum number of spectral lines in that band
CENTRES = 96  # frequencies at which the median is taken, several in each band
TAIL = 5.0  # degrees of freedom of the Student-t noise: tails of measured residuals
SYSTEMATIC_TAIL = 50.0  # the same of a systematic residual: nearly normal, but for outliers that stand far out
OUTLIER = 5.0  # standard deviations at which rows are clipped before the whitening filter is estimated
WINDOW = 0.3  # s: of the local noise level
OCTAVES = 14  # of the speed, below the highest, in each of which the noise has a level
FEWEST_IN_OCTAVE = 5.0  # rows of the usual level that are added to each octave
BLOCKS = (0.1, 0.5)  # s: block lengths of the variance of a score, a reversal and a stroke
HELD = 3.0  # standard deviations of a reading: presliding of a contact that sticks, as far as the readings show
LARGELY = 0.3  # share of the command's standard deviation above which the residual is not treated as noise
# Re-tuning
WIDER = (0.35, 0.5, 0.7, 1.4, 2.0)  # factors of the friction width that `settled` tries
SHARES_OF_A_STEP = (1.0, 0.5, 0.25, 0.1)  # step lengths of the line search
RIDGE = 1e-12  # relative information that is added on each scaled amplitude, for columns that are collinear
LARGEST_CHANGE = 10.0  # largest factor between mass or friction and its stated value


def noise_filter(e: FloatArray, mask: Mask, rate: float) -> FloatArray:
    """Return the taps of the minimum-phase whitening filter of a residual, normalised to a first tap of 1.

    The spectrum at each frequency is the median power in a band about it, so that narrow lines count as signal, not as
    noise. The taps follow from the cepstrum of that spectrum.

    Args:
        e: residual, (n,).
        mask: rows that count, (n,).
        rate: Hz.
    """
    size = int(2 ** np.ceil(np.log2(2 * len(e))))
    power = np.abs(np.fft.rfft(np.where(mask, e, 0.0), size)) ** 2
    lines = np.arange(1, len(power))
    centres = np.unique(np.geomspace(LINES, lines[-1], CENTRES).astype(int))
    low = np.maximum(1, np.minimum((centres / BAND).astype(int), centres - LINES // 2))
    high = np.minimum(len(power), np.maximum((centres * BAND).astype(int), centres + LINES // 2) + 1)
    level = np.array([median(power[a:b]) for a, b in zip(low, high, strict=True)])
    smooth = np.interp(np.log(lines), np.log(centres), np.log(level + 1e-9 * level.max()))
    cepstrum = np.fft.irfft(-0.5 * np.concatenate([smooth[:1], smooth]), size)
    cepstrum[1 : size // 2] *= 2.0
    cepstrum[size // 2 + 1 :] = 0.0
    taps = np.fft.irfft(np.exp(np.fft.rfft(cepstrum)), size)
    return np.asarray(taps[: max(2, int(MEMORY * rate))] / taps[0])


def convolved(rows: FloatArray, taps: FloatArray) -> FloatArray:
    """Return rows (..., n) behind a filter with an impulse response, (..., n), by one transform."""
    if taps.shape[-1] == 1:
        return np.asarray(rows * taps)
    size = next_fast_len(rows.shape[-1] + len(taps) - 1, real=True)
    return np.asarray(irfft(rfft(rows, size) * rfft(taps, size), size)[..., : rows.shape[-1]])


class TooLittleMotion(ValueError):
    """The logs have too few valid rows."""


@dataclass
class Maximum:
    """Maximum-likelihood fit of columns x (p, n) to whitened rows r (n,)."""

    cost: float  # -2 ln likelihood
    w: FloatArray  # amplitudes of the scaled columns, (p,)
    rest: FloatArray  # residual r - w x, (n,)
    variance: float  # of the residual
    weight: FloatArray  # of each row, less than 1 for outliers, (n,)
    gram: FloatArray  # weighted Gram matrix of the scaled columns, priors included, (p, p)
    tail: float = TAIL  # degrees of freedom of the noise
    unit: FloatArray = field(default_factory=lambda: np.zeros(1))  # 2 ln of the noise scale before the filter, (n,)
    theta: FloatArray = field(init=False)  # amplitudes in their own units, w / size, (p,)
    taps: list[FloatArray] = field(init=False)  # whitening filter of each log
    r: FloatArray = field(init=False)  # whitened rows, (n,)
    x: FloatArray = field(init=False)  # whitened and scaled columns, (p, n)
    prior: tuple[FloatArray, FloatArray] = field(init=False)  # standard deviation and mean of each scaled amplitude
    size: FloatArray = field(init=False)  # scale of each column, (p,)
    #: The likelier fit without the added columns: `same`, or that behind its own filter.
    none: Maximum = field(init=False)
    same: Maximum = field(init=False)  # fit to the same rows without the added columns
    inflation: float = field(init=False, default=1.0)  # largest ratio of a score's variance to that of independent rows
    explained: FloatArray = field(init=False)  # part of each row that the added columns explain, in deviations, (n,)

    def slope(self, r: FloatArray, target: FloatArray) -> FloatArray:
        """Return the products of the columns with rows r (n,), with a prior of mean `target` (p,), (p,)."""
        return np.asarray(self.x @ (self.weight * r) + target / np.maximum(self.prior[0] ** 2 / self.variance, 1e-12))

    def solved(self, free: Mask, theta: FloatArray, r: FloatArray) -> FloatArray:
        """Return theta (p,) with the free amplitudes re-fitted to rows r (n,) and the others held."""
        slope, w = self.slope(r, self.prior[1]), np.where(free, 0.0, theta * self.size)
        w[free] = np.linalg.lstsq(self.gram[np.ix_(free, free)], (slope - self.gram @ w)[free])[0]
        return np.asarray(w / self.size)

    def by_row(self) -> FloatArray:
        """Return -2 ln of the density of each row, (n,)."""
        return student_cost(self.rest, self.variance, self.tail) + self.unit

    @property
    def spread(self) -> float:
        """Variance of the amplitude of a column of unit weight, which exceeds `variance`: rows of noise lose weight.

        It is the asymptotic variance of an M-estimator (Huber 1964), which needs no normal distribution.
        """
        far = self.rest**2 / (self.tail * self.variance)
        score, slope = self.rest / (1.0 + far), (1.0 - far) / (1.0 + far) ** 2
        return float(np.mean(self.weight) * np.mean(score**2) / np.mean(slope) ** 2)


def median(x: FloatArray) -> float:
    """Return the median of a few numbers, (n,), without the checks that take most of the time of np.median."""
    half = len(x) // 2
    least = np.partition(x, half)
    return float(least[half] if len(x) % 2 else 0.5 * (least[half] + least[:half].max()))


def deviation(x: FloatArray) -> float:
    """Return a robust standard deviation from the median absolute value; 1 without values."""
    return max(1.4826 * float(np.median(np.abs(x))), 1e-300) if len(x) else 1.0


def student_cost(rest: FloatArray, variance: float, tail: float = TAIL) -> FloatArray:
    """Return -2 ln of the Student-t density of each row, up to a constant."""
    return np.asarray((tail + 1.0) * np.log1p(rest**2 / (tail * variance)) + np.log(variance))


def likeliest(
    x: FloatArray,
    r: FloatArray,
    sigma: FloatArray,
    target: FloatArray,
    rounds: int = 3,
    near: Maximum | None = None,
    tail: float = TAIL,
) -> Maximum:
    """Fit columns x (p, n) to rows r (n,) with Student-t noise, by iteratively re-weighted least squares.

    Amplitudes have normal priors of mean `target` and standard deviation `sigma` (infinite: no prior), (p,). A fit of
    other columns, or behind other filters, provides the first weights, which saves a round.
    """
    weight, variance = (np.ones(len(r)), deviation(r) ** 2) if near is None else (near.weight, near.variance)
    for _ in range(rounds if near is None else rounds - 1):
        prior = 1.0 / np.maximum(sigma**2 / variance, 1e-12)
        root = np.sqrt(weight)
        scaled = x * root
        gram = scaled @ scaled.T
        gram += np.diag(prior + RIDGE * (len(r) + np.diag(gram)))
        # drop directions of nearly collinear columns: their amplitudes would be huge and cancel
        unit = np.sqrt(np.diag(gram))
        value, vector = np.linalg.eigh(gram / np.outer(unit, unit))
        seen = value > ROUNDING * value[-1]
        along = vector[:, seen].T @ ((scaled @ (root * r) + prior * target) / unit)
        w = vector[:, seen] @ (along / value[seen]) / unit
        rest = r - w @ x
        weight = (tail + 1.0) / (tail + rest**2 / variance)
        variance = float(weight @ rest**2) / len(rest)
    cost = student_cost(rest, variance, tail).sum() + float(np.sum(((w - target) / sigma) ** 2))
    return Maximum(cost, w, rest, variance, weight, gram, tail)


class Sticking:
    """Contact that holds an axis at rest, a bristle no longer than the noise of a reading: rival of a longer one."""

    def columns(self, evidence: Evidence) -> list[FloatArray]:
        """Return the force of the contact along each log, (1, n)."""
        return [b.bristle(evidence.model.axis, HELD * b.encoder_noise)[None] for b in evidence.balances]


@dataclass
class Evidence:
    """Force balances of logs under a model and the terms accepted so far.

    There are p nuisance parameters, and q with the columns of `extra`. The rows (m,) of a log are its residual behind
    low-pass filter and decimation.
    """

    balances: list[DifferencedBalance]
    given: Model  # stated model, which sets the priors
    model: Model  # re-tuned model with the accepted effects
    extra: list[Any] = field(default_factory=list)  # accepted candidates without a law: each has `columns(evidence)`
    free: tuple[str, ...] = ()  # paths of the axis without a prior
    plainly: bool = False  # whether to skip whitening whatever the size of the residual
    uniform: bool = False  # whether all rows have the same noise level, as where a model lacks most of the command
    #: Whether the width of the model's friction law is a nuisance parameter. In the search it is not: the change of an
    #: arctangent with its width has the shape of Stribeck friction.
    with_width: bool = False
    #: Evidence of the model whose noise the residual has (see `Instruments.change`); None for the model's own.
    base: Evidence | None = field(default=None, repr=False)
    instruments: list[Instruments] = field(init=False, repr=False)  # of each log
    largely: bool = field(init=False, repr=False, default=False)  # whether the residual is too large to be noise
    alike: float = field(init=False, repr=False, default=1.0)  # rows that count as one independent row; 1 for noise
    paths: list[str] = field(init=False, repr=False)  # of the nuisance parameters, (p,)
    prior_sigma: FloatArray = field(init=False, repr=False)  # prior standard deviation of each amplitude, (q,)
    prior_offset: FloatArray = field(init=False, repr=False)  # prior mean, (q,)
    #: Bounds of re-tuned parameters, by path.
    limits: dict[str, tuple[float, float]] = field(init=False, repr=False, default_factory=dict)
    masks: list[Mask] = field(init=False, repr=False)  # valid rows of each log before the whitening filter
    counted: list[Mask] = field(init=False, repr=False)  # valid rows behind it
    levels: list[FloatArray] = field(init=False, repr=False, default_factory=list)  # their relative noise level
    raw: list[FloatArray] = field(init=False, repr=False)  # residual of each log, V, (n,)
    residuals: list[FloatArray] = field(init=False, repr=False)  # its rows, (m,)
    nuisances: list[FloatArray] = field(init=False, repr=False)  # rows of the columns of all amplitudes, (q, m)
    start: list[FloatArray] = field(init=False, repr=False)  # whitening filters of the first fit
    fit: Maximum = field(init=False, repr=False)  # of the nuisance parameters behind `start`

    def prepare(self, rounds: int = 0, listen: bool = False, orthogonal: bool = False) -> Evidence:
        """Make the columns and re-tune the model in steps with a line search; return self.

        Args:
            rounds: number of steps.
            listen: whether to choose the low-pass corner of each balance from the first residual.
            orthogonal: whether these are steps of `orthogonal_step`, for a model that lacks little, not Gauss-Newton's.
        """
        if listen:
            self.make_columns()
            for b, r in zip(self.balances, self.raw, strict=True):
                b.listen(r, self.model.axis, self.largely)
        for _ in range(rounds):
            self.make()
            before = self.decrement(self.model)
            step = self.orthogonal_step() if orthogonal else self.fit.theta
            for share in SHARES_OF_A_STEP:
                model = self.retuned(step, share)
                if self.decrement(model) <= before:
                    self.model = model
                    break
            else:
                break
        self.levels = []
        self.make()
        return self

    def decrement(self, model: Model) -> float:
        """Return the Newton decrement of a re-tuned model: the gain in 2 ln likelihood that its parameters still allow.

        The residual power is a weaker criterion: unlike the columns, it contains the noise of the readings.
        """
        fit, known = self.fit, parameters_of(model, together=True)
        old = parameters_of(self.model, together=True)
        has = self.mask_of(p in known for p in self.paths)
        moved = [known[p].value - old[p].value if p in known else 0.0 for p in self.paths]
        target = fit.prior[1]
        target = np.where(has, target - np.pad(moved, (0, len(fit.w) - len(moved))) * fit.size, target)
        slope = fit.slope(self.rows_under(model, fit.taps), target)
        beside = fit.gram[np.ix_(has, ~has)] @ np.linalg.pinv(fit.gram[np.ix_(~has, ~has)], hermitian=True)
        own = slope[has] - beside @ slope[~has]
        return float(own @ np.linalg.solve(fit.gram[np.ix_(has, has)] - beside @ fit.gram[np.ix_(~has, has)], own))

    def orthogonal_step(self) -> FloatArray:
        """Return the changes of all amplitudes (q,) after which the residual is orthogonal to the columns.

        The columns are instruments: they have no noise, but mass and effects change the residual by more than they say.
        """
        fit, x, known = self.fit, self.fit.x.copy(), parameters_of(self.model, together=True)
        for k, path in enumerate(self.paths):
            if path == "axis.mass":
                rows = [-b.acceleration for b in self.balances]
            elif path.startswith("effects."):
                step = SECANT * float(self.prior_sigma[k])
                models = (with_values(self.model, {path: known[path].value + q}) for q in (-step, step))
                rows = [(low - high) / (2.0 * step) for low, high in zip(*map(self.raw_under, models), strict=True)]
            else:
                continue
            x[k] = self.filtered([b.rows(r) for b, r in zip(self.balances, rows, strict=True)], fit.taps)[0]
            x[k] /= fit.size[k]
        # priors, and a ridge for columns that are collinear
        diagonal = fit.variance / np.maximum(fit.prior[0] ** 2, 1e-12 * fit.variance)
        diagonal += RIDGE * (len(fit.r) + np.sum(fit.x**2, axis=1))
        gram = (fit.x * fit.weight) @ x.T + np.diag(diagonal)
        return np.asarray(np.linalg.lstsq(gram, fit.slope(fit.r, fit.prior[1]))[0] / fit.size)

    @cached_property
    def near_rest(self) -> Evidence:
        """Evidence of the same model with rows near rest, where friction may hold the axis."""
        balances, extra = [b.with_creep() for b in self.balances], [*self.extra, Sticking()]
        return replace(self, balances=balances, extra=extra).prepare()

    @property
    def drives(self) -> list[FloatArray]:
        """Part of the command that the reference motion explains, V, (n,) of each log (see `Instruments`)."""
        return [one.drive for one in self.instruments]

    def raw_under(self, model: Model) -> list[FloatArray]:
        """Return the residual of each log under a model, V, (n,)."""
        return [one.residual(b, model) for b, one in zip(self.balances, self.instruments, strict=True)]

    def rows_under(self, model: Model, taps: Sequence[FloatArray]) -> FloatArray:
        """Return the residual under a model behind the filter of each log, logs concatenated, (n,)."""
        rows = [b.rows(r) for b, r in zip(self.balances, self.raw_under(model), strict=True)]
        return np.asarray(self.filtered(rows, taps)[0])

    def raw_of(self, model: Model) -> list[FloatArray]:
        """Return the residual of each log under another model, with the noise that it has under this one, V, (n,)."""
        parts = zip(self.balances, self.raw, self.instruments, strict=True)
        return [raw + one.change(b, self.model, model) for b, raw, one in parts]

    def make(self) -> None:
        """Make residuals and columns under the model, and fit the nuisance parameters.

        Raises:
            TooLittleMotion: fewer than FEWEST rows are valid.
        """
        theta, stale = self.make_columns()
        taps = self.taps_of(theta)
        if stale:
            self.levels = self.local_levels(taps)
            taps = self.taps_of(self.fitted(self.plain, rounds=1).theta)
        first = self.fitted(taps, rounds=1)
        self.keep_needed(first)
        self.start, self.fit = taps, self.fitted(taps, base=first)

    def make_columns(self) -> tuple[FloatArray, bool]:
        """Make residuals and columns; return amplitudes without a filter, and whether the noise levels are unknown."""
        self.instruments = [b.remembered("instruments", self.model, instruments_of) for b in self.balances]
        free = (*self.free, WIDTH) if self.with_width else self.free
        known = nuisances_of(self.model, self.given, self.balances, self.instruments, free)
        self.paths, self.limits = known.paths, known.limits
        more = [s.columns(self) for s in self.extra]
        tables = [
            np.vstack([np.zeros((0, len(b.time))), *t, *(s[i] for s in more)])
            for i, (b, t) in enumerate(zip(self.balances, known.tables, strict=True))
        ]
        count = len(tables[0]) - len(self.paths)
        self.prior_sigma = np.array(known.sigma + [np.inf] * count)
        self.prior_offset = np.array(known.offset + [0.0] * count)
        self.raw = self.raw_under(self.model) if self.base is None else self.base.raw_of(self.model)
        self.masks = [b.mask for b in self.balances]
        self.counted = [b.counted for b in self.balances]
        if (count := sum(int(m.sum()) for m in self.counted)) < FEWEST:
            raise TooLittleMotion(f"the encoder resolves the motion in {count} rows at {self.rate:.3g} Hz only")
        self.residuals = [b.rows(r)[0] for b, r in zip(self.balances, self.raw, strict=True)]
        self.nuisances = [b.rows(t) for b, t in zip(self.balances, tables, strict=True)]
        for name in ("null", "information", "screen", "basis", "unfiltered", "near_rest"):
            self.__dict__.pop(name, None)
        stale = [len(one) for one in self.levels] != [int(m.sum()) for m in self.counted]
        if stale:
            self.levels = [np.ones(int(m.sum())) for m in self.counted]
        theta = self.fitted(self.plain, rounds=1).theta
        rows = zip(self.residuals, self.nuisances, self.masks, strict=True)
        left = np.hstack([(r - theta @ x)[m] for r, x, m in rows])
        command = np.hstack([b.rows(b.command)[0][m] for b, m in zip(self.balances, self.masks, strict=True)])
        self.largely = self.plainly or bool(np.std(left) > LARGELY * np.std(command))
        self.alike = 1.0
        if self.largely:  # rows of a systematic residual are dependent: weight the priors accordingly
            self.alike = float(self.inflation(left[None] / np.std(left))[0] / len(left))
        return theta, stale

    def filtered(self, tables: Sequence[FloatArray], taps: Sequence[FloatArray]) -> FloatArray:
        """Return the valid rows of columns (p, m) of each log behind its filter, logs concatenated, (p, n)."""
        parts = zip(tables, taps, self.counted, self.levels, strict=True)
        return np.hstack([convolved(t, h)[:, m] / level for t, h, m, level in parts])

    def local_levels(self, taps: list[FloatArray]) -> list[FloatArray]:
        """Return the noise level of each valid row, relative to its log, at its time and at its speed.

        The quantum of an encoder makes a noise that depends on the motion, and an inexact friction law a force that
        is large wherever the axis is slow. Without these levels, candidates that act there are detected falsely.
        """
        if self.largely or self.uniform:
            return self.levels
        fit = self.fitted(taps, self.any_force(), rounds=2)
        ends = np.cumsum([len(one) for one in self.levels])[:-1]
        rests = np.split(fit.rest / np.sqrt(fit.variance), ends)
        of_time, speeds = [], []
        for b, m, rest in zip(self.balances, self.counted, rests, strict=True):
            edges = np.linspace(0, len(rest), max(1, round(len(rest) / self.rate / WINDOW)) + 1).astype(int)
            windows = [deviation(rest[start:stop]) for start, stop in pairwise(edges)]
            of_time.append(np.interp(np.arange(len(rest)), 0.5 * (edges[1:] + edges[:-1]), windows))
            # the low-pass filter spreads what happens at rest over rows of higher speed
            slowest = minimum_filter1d(np.abs(b.velocity), round(2 * ROWS_PER_CORNER + 1) * b.every)
            speeds.append(slowest[:: b.every][m])
        level, speed = np.hstack(of_time), np.hstack(speeds)
        octave = np.minimum(-np.log2(np.maximum(speed / speed.max(), 1e-9)), OCTAVES).round().astype(int)
        power = np.bincount(octave, (np.hstack(rests) / level) ** 2)
        count = np.bincount(octave)
        level *= np.sqrt((power + FEWEST_IN_OCTAVE) / (count + FEWEST_IN_OCTAVE))[octave]
        return np.split(level, ends)

    @property
    def tail(self) -> float:
        """Degrees of freedom of the noise: rows of a systematic residual are no outliers, unless they stand far out."""
        return SYSTEMATIC_TAIL if self.largely else TAIL

    @property
    def rate(self) -> float:
        """Sample rate of the rows, Hz."""
        return self.balances[0].rate

    def taps_of(self, theta: FloatArray, parts: Sequence[FloatArray] | None = None) -> list[FloatArray]:
        """Return the whitening filter of each log from its clipped residual, scaled to unit standard deviation."""
        taps = []
        for r, x, m in zip(self.residuals, self.nuisances if parts is None else parts, self.masks, strict=True):
            left = r - theta @ x
            if self.largely or not m.any():
                taps.append(np.ones(1) / deviation(left[m]))
                continue
            most = OUTLIER * deviation(left[m])
            one = noise_filter(np.clip(left, -most, most), m, self.rate)
            taps.append(one / deviation(convolved(left, one)[m]))
        return taps

    @property
    def plain(self) -> list[FloatArray]:
        """Filters that only scale each log to unit standard deviation."""
        return [np.ones(1) / deviation(r[m]) for r, m in zip(self.residuals, self.masks, strict=True)]

    def fitted(
        self,
        taps: list[FloatArray],
        tables: Sequence[FloatArray] | None = None,
        rounds: int = 3,
        base: Maximum | None = None,
        near: Maximum | None = None,
    ) -> Maximum:
        """Fit the nuisance parameters and added columns (k, m) of each log behind whitening filters.

        Args:
            taps: filter of each log.
            tables: added columns.
            rounds: of re-weighting.
            base: fit without the added columns behind the same filters, whose rows are reused.
            near: fit that provides the first weights of the rows.
        """
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
        best = likeliest(x, r, sigma, target, rounds, near, self.tail)
        scale = [-2.0 * np.log(abs(h[0])) for h in taps]
        best.unit = np.repeat(scale, [int(m.sum()) for m in self.counted])
        best.cost += best.unit.sum()
        best.theta, best.taps, best.r, best.x, best.prior = best.w / size, taps, r, x, (sigma, target)
        best.size = size
        return best

    def maximised(
        self, tables: Sequence[FloatArray] | None = None, tried: list[FloatArray] | None = None, sudden: bool = False
    ) -> Maximum:
        """Fit the nuisance parameters, added columns (k, m) of each log and the whitening filter by maximum likelihood.

        The filter belongs to the hypothesis: the null's filter absorbs part of a slow force, and the candidate's filter
        raises false alarms under the null. Several filters are starting points, the unfiltered residual among them,
        because a filter that has absorbed a force cannot release it.

        Args:
            tables: added columns.
            tried: a further filter of each log, that of a rival.
            sudden: whether the columns act in few rows, which are outliers of the fit without them.
        """
        if tables is None:
            parts, rounds = self.nuisances, 2
            best = min((self.fitted(taps) for taps in (self.plain, self.start)), key=lambda fit: fit.cost)
        else:
            parts, rounds = [np.vstack([n, t]) for n, t in zip(self.nuisances, tables, strict=True)], 1
            base = self.bases[int(np.argmin(self.costs_with(tables, [np.arange(len(tables[0]))])))]
            # what a model largely lacks may be far from the fit without it, as outliers are: first with equal weights
            best = self.fitted(base.taps, tables, base=base, near=None if self.largely or sudden else base)
            if tried is not None:
                best = min(best, self.fitted(tried, tables, near=best), key=lambda fit: fit.cost)
        for _ in range(rounds):
            fit = self.fitted(self.taps_of(best.theta, parts), tables, near=best)
            if fit.cost >= best.cost:
                break
            best = fit
        if tables is not None:
            self._compare(best, len(self.nuisances[0]))
        return best

    def _compare(self, best: Maximum, n: int) -> None:
        """Compare a fit with its first n columns alone, and free its rows to save memory."""
        x, (sigma, target) = best.x, best.prior
        # the null hypothesis may be likelier behind the candidate's filter than behind its own
        none = likeliest(x[:n], best.r, sigma[:n], target[:n], near=best, tail=self.tail)
        none.unit = best.unit
        none.cost += best.unit.sum()
        best.same, best.none = none, none if none.cost < self.null.cost else self.null
        near = x[:n] @ (x[n:] * best.weight).T
        more = x[n:] - np.linalg.solve(best.gram[:n, :n], near).T @ x[:n]
        ortho = orthonormal(more * np.sqrt(best.weight)) * np.sqrt(best.weight)
        best.inflation = float(np.max(self.inflation(ortho * best.rest / np.sqrt(best.variance)), initial=1.0))
        best.explained = np.sqrt(best.weight / best.spread) * (best.w[n:] @ more)
        best.x = best.r = best.gram = np.zeros(0)

    def retuned(self, theta: FloatArray, share: float) -> Model:
        """Return the model moved by a share of a step of the nuisance parameters, (q,)."""
        whole = dict(zip(self.paths, map(float, theta), strict=False))
        steps = {path: share * step for path, step in whole.items()}
        width = self.likeliest_width(whole)
        return self.moved(self.model, steps | {WIDTH: share * (width - self.model.axis.coulomb_width)})

    def settled(self, model: Model, gone: Sequence[str] = (), kept: Sequence[int] = ()) -> Model:
        """Return a model whose own parameters minimise the residual of the force balance, to first order.

        The fit has nuisance parameters that a model lacks, such as mixtures of friction laws. Effects keep the values
        of that fit; mass, friction, known cogging and what the mixture may replace are then re-fitted to the rows
        without whitening.

        Args:
            model: model of this evidence, followed by effects for some of `extra`.
            gone: paths of effects to remove, and of axis parameters to reset to their stated values.
            kept: indexes in `extra` of the terms that the model has as effects.
        """
        known = parameters_of(model, together=True)
        free, moved = np.ones(len(self.null.theta), dtype=bool), np.zeros(len(self.null.theta))
        paths = self.paths_in(model)
        for k, path in enumerate(paths):
            free[k] = not any(path == one or path.startswith(one + ".") for one in gone)
            if path in gone:
                moved[k] = getattr(self.given.axis, path.removeprefix("axis.")) - known[path].value
        own_paths = [path for path, _ in effect_paths(model.effects)]
        remain = [e for path, e in zip(own_paths, self.model.effects, strict=False) if path not in gone]
        bare = self.model.replace(effects=tuple(remain))
        own = self.mask_of(p in known and not p.startswith("effects.") for p in paths)
        own |= self.mixed & self.mask_of(p in known for p in paths)
        at = len(paths)
        for place, column in enumerate(self.extra):
            free[at : at + len(column.amplitudes)] = place in kept
            at += len(column.amplitudes)
        # fit the effects beside all nuisance parameters, then the axis alone with the friction width
        moved = self.null.solved(free, moved, self.rows_under(bare, self.null.taps))
        moved, gap = np.where(self.mask_of(p not in known for p in paths), 0.0, moved), self.unfiltered
        width = self.model.axis.coulomb_width

        def tuned(share: float, factor: float = 1.0) -> tuple[float, float, Model]:
            """Return the residual power, the share of a step, and the model after it with a factor of the width."""
            wider = with_values(bare, {WIDTH: factor * width})
            whole = gap.solved(own & free, moved, self.rows_under(wider, gap.taps))
            steps = dict(zip(paths, map(float, moved + share * (whole - moved)), strict=False))
            at = self.moved(model.replace(axis=wider.axis), steps)
            at = at.replace(effects=tuple(effect for path, effect in effect_paths(at.effects) if path not in gone))
            left = zip(self.balances, self.raw_under(at), strict=True)
            return sum(float(np.mean(b.rows(r)[0][b.mask] ** 2)) for b, r in left), share, at

        best = min(map(tuned, SHARES_OF_A_STEP), key=itemgetter(0))
        is_free = width > 0.0 and self.given.uncertainty.get("coulomb_width") != 0.0
        return min([best, *(tuned(best[1], factor) for factor in WIDER if is_free)], key=itemgetter(0))[2]

    def mask_of(self, chosen: Iterable[bool]) -> Mask:
        """Return a choice of nuisance parameters as one of all amplitudes, (q,): those of `extra` are not chosen."""
        chosen = list(chosen)
        return np.array(chosen + [False] * (len(self.prior_sigma) - len(chosen)), dtype=bool)

    def paths_in(self, model: Model) -> list[str]:
        """Return `paths` as named in a model with further effects: effects of one name are numbered."""
        own, other = ([path for path, _ in effect_paths(m.effects)] for m in (self.model, model))
        names = dict(zip(own, other, strict=False))
        return [renamed_path(path, names) for path in self.paths]

    def moved(self, model: Model, steps: Mapping[str, float]) -> Model:
        """Return a model with parameters moved by steps and clipped to their bounds; those stated exactly stay."""
        known, values = parameters_of(model, together=True), {}
        exact = {f"axis.{name}" for name, u in self.given.uncertainty.items() if u == 0.0} - set(self.free)
        for path, step in steps.items():
            if path in known and path not in exact:
                value = known[path].value
                mass = self.given.axis.mass
                axis = (mass / LARGEST_CHANGE, mass * LARGEST_CHANGE) if path == "axis.mass" else (0.0, np.inf)
                low, high = axis if path.startswith("axis.") else self.limits.get(path, (-np.inf, np.inf))
                values[path] = min(max(value + step, low), high)
        try:
            return with_values(model, values)
        except ValueError:  # the effect rejects the shape
            return with_values(model, {k: v for k, v in values.items() if not k.startswith("effects.")})

    def likeliest_width(self, steps: Mapping[str, float]) -> float:
        """Return the arctangent width (m/s) that best matches a mixture of friction laws over the measured speeds."""
        parts = {float(path[6:]): step for path, step in steps.items() if path.startswith("width.")}
        own = max(self.model.axis.coulomb_width + steps.get(WIDTH, 0.0), 0.5 * self.model.axis.coulomb_width)
        if not parts:
            return own
        own = max(own, 0.1 * min(parts))  # a ramp saturates where a narrower arctangent does
        v = np.quantile(np.concatenate([np.abs(b.velocity[b.keep > 0]) for b in self.balances]), np.linspace(0, 1, 400))
        level = self.model.axis.coulomb - sum(parts.values())
        law = level * np.arctan(v / own) + 0.5 * np.pi * sum(t * np.minimum(v / w, 1.0) for w, t in parts.items())
        if not np.any(law):
            return own
        # where all laws stay, their narrowest may be much wider than the arctangent that stands for them
        least = 0.1 if self.largely or self.uniform else 1.0 / 3.0
        tried = np.geomspace(min(own, least * min(parts)), max(own, max(parts)), 80)
        fits = np.arctan(v / tried[:, None])
        return float(tried[np.argmax((fits @ law) ** 2 / np.sum(fits**2, axis=1))])

    def keep_needed(self, fit: Maximum) -> None:
        """Remove the friction widths that the rows do not need, also from the rows of a fit.

        Where a given model lacks most of the command, those are the widths whose non-negative least-squares weight is
        zero. Beside noise a width has to raise 2 ln likelihood by ln n, the Bayesian information criterion (Schwarz
        1978): many collinear laws of levels that are not negative fit noise, always towards a more concave law.
        """
        own = self.mixture
        if not len(own):
            return
        slope = fit.slope(fit.r, fit.prior[1])
        if self.largely or self.uniform:
            needed = own[nnls(*reduced(fit.gram, slope, own))[0] > 0.0]
        else:
            parts, y = self.friction_parts(fit.gram, slope, fit)
            first, bic = parts.shape[1] - len(own), fit.variance * np.log(len(fit.r))
            chosen = list(range(first))
            least = positive_loss(parts[:, chosen], y)
            while len(chosen) < parts.shape[1]:
                more = np.setdiff1d(np.arange(parts.shape[1]), chosen)
                left = [positive_loss(parts[:, [*chosen, k]], y) for k in more]
                if min(left) > least - bic:
                    break
                least = min(left)
                chosen.append(int(more[np.argmin(left)]))
            needed = own[np.array(chosen[first:], dtype=np.intp) - first]
        kept = np.setdiff1d(np.arange(len(fit.w)), np.setdiff1d(own, needed))
        self.paths = [self.paths[j] for j in kept if j < len(self.paths)]
        self.prior_sigma, self.prior_offset = self.prior_sigma[kept], self.prior_offset[kept]
        self.nuisances = [t[kept] for t in self.nuisances]
        fit.x, fit.size = fit.x[kept], fit.size[kept]

    @property
    def mixture(self) -> NDArray[np.intp]:
        """Indexes of the amplitudes of the mixture of friction laws, which are not negative."""
        return np.array([k for k, path in enumerate(self.paths) if path.startswith("width.")], dtype=np.intp)

    @property
    def mixed(self) -> Mask:
        """Whether most of the information on an amplitude is lost to the mixture of friction laws, (q,)."""
        gram, rest = self.null.gram, np.setdiff1d(np.arange(len(self.null.w)), self.mixture)
        alone = np.full(len(gram), np.inf)
        alone[rest] = np.diag(np.linalg.inv(gram[np.ix_(rest, rest)]))
        return np.asarray(np.diag(np.linalg.inv(gram)) > 2.0 * alone)

    def loss(self, held: Sequence[int], moved: FloatArray | float) -> float:
        """Return by how much -2 ln likelihood exceeds that of `null` if amplitudes `held` move by `moved`.

        The other amplitudes are re-fitted, those of friction laws to levels that are not negative.
        """
        fit = self.null
        return positive_loss(*self.friction_parts(self.information, self.information @ fit.w, fit, held, moved))

    def friction_parts(
        self,
        gram: FloatArray,
        slope: FloatArray,
        fit: Maximum,
        held: Sequence[int] = (),
        moved: FloatArray | float = 0.0,
    ) -> tuple[FloatArray, FloatArray]:
        """Return A (p, q) and y (p,): |A u - y|^2 is w G w - 2 slope w, up to a constant, of friction laws of level u.

        Amplitudes `held` move by `moved` from those of the fit, all others but the mixture of friction laws take their
        likeliest values. Where the level of Coulomb friction does so, the model's own law stands before the mixture.
        """
        own, count = np.setdiff1d(self.mixture, held), len(held)
        level = [k for k, path in enumerate(self.paths) if path == "axis.coulomb" and k not in held and len(own)]
        rows = np.array([*held, *level, *own], dtype=np.intp)
        root, y = reduced(gram, slope, rows)
        y = y - root[:, :count] @ (fit.w[rows[:count]] + np.asarray(moved) * fit.size[rows[:count]])
        parts = root[:, count:] * fit.size[rows[count:]]
        if level:  # the levels of all laws add up to that of Coulomb friction
            parts[:, 1:] += parts[:, :1]
            y = y + parts[:, 0] * self.model.axis.coulomb
        return parts, y

    def interval(self, k: int) -> tuple[float, float]:
        """Return the ends of the 95 % interval of an amplitude, less its estimate: where the likelihood ratio ends."""
        null = self.null
        deviation = np.sqrt(np.linalg.inv(self.information)[k, k]) / null.size[k]
        most = self.loss((), 0.0) + SIGMAS_95**2
        end = np.sqrt(most) * float(deviation)  # the constraints make the interval narrower

        def excess(moved: float) -> float:
            return self.loss((k,), moved) - most

        if not np.isfinite(end):
            return -np.inf, np.inf
        middle = minimize_scalar(excess, bounds=(-end, end), method="bounded")
        ends = [
            side if middle.fun >= 0.0 or excess(side) <= 0.0 else float(brentq(excess, middle.x, side))
            for side in (-end, end)
        ]
        return min(ends[0], 0.0), max(ends[1], 0.0)

    @property
    def bases(self) -> tuple[Maximum, Maximum, Maximum]:
        """Fits of the nuisance parameters without a filter, with their own, and with the screening filter."""
        return self.unfiltered, self.null, self.screen

    def costs_with(self, tables: Sequence[FloatArray], groups: Sequence[IntArray]) -> FloatArray:
        """Return -2 ln likelihood with groups of added columns behind the filters of each of `bases`, (3, groups).

        One least-squares step takes a hundredth of the time of `maximised`; it selects candidates and filters.
        """
        costs = np.empty((len(self.bases), len(groups)))
        for row, base in zip(costs, self.bases, strict=True):
            c = self.filtered(tables, base.taps)
            size = np.linalg.norm(c, axis=1)[:, None]
            c = np.where(np.isfinite(size), c / (size + 1e-300), 0.0)  # the force of a load may diverge
            weighted = c * base.weight
            near = base.x @ weighted.T
            gram = weighted @ c.T - near.T @ np.linalg.solve(base.gram, near)
            products = weighted @ base.rest
            for n, own in enumerate(groups):
                value, vector = np.linalg.eigh(gram[np.ix_(own, own)])
                good = value > 1e-6
                along = vector[:, good].T @ products[own] / np.sqrt(value[good])
                row[n] = base.cost - float(along @ along) / base.variance
        return costs

    @cached_property
    def null(self) -> Maximum:
        """Null hypothesis: fit of the nuisance parameters alone."""
        return self.maximised()

    @property
    def information_of_rows(self) -> FloatArray:
        """Fisher information of the rows on the scaled amplitudes of `null`, without their priors, (q, q)."""
        null = self.null
        rows = (null.x * null.weight) @ null.x.T
        rows += RIDGE * np.diag(len(null.r) + np.diag(rows))
        return np.asarray(rows / (null.spread * self.alike))

    @cached_property
    def information(self) -> FloatArray:
        """Fisher information of rows and priors on the scaled amplitudes of `null`, (q, q)."""
        return np.asarray(self.information_of_rows + np.diag(1.0 / (self.null.prior[0] ** 2 * self.alike)))

    @cached_property
    def unfiltered(self) -> Maximum:
        """Fit of the nuisance parameters to rows without whitening."""
        return self.fitted(self.plain)

    def inflation(self, products: FloatArray) -> FloatArray:
        """Return the ratio of the variance of a score to that of independent rows, at least 1, (p,).

        Args:
            products: residual times each column of unit length, row by row, in standard deviations, (p, n).
        """
        v = np.maximum(np.sum(products**2, axis=1), 1.0)
        for seconds in BLOCKS:
            edges = np.arange(0, products.shape[1], max(1, round(seconds * self.rate)))
            v = np.maximum(v, np.sum(np.add.reduceat(products, edges, axis=1) ** 2, axis=1))
        return np.asarray(v)

    def any_force(self) -> list[FloatArray]:
        """Return columns of generic forces of position, time, speed and command of each log."""
        low, high = (f(g(b.position) for b in self.balances) for f, g in ((min, np.min), (max, np.max)))
        last = max(b.time[-1] for b in self.balances)
        any_force = []
        for b, d in zip(self.balances, self.drives, strict=True):
            table = [splines(b.position, low, high, 14), hats(b.time, np.linspace(0.0, last, 12))]
            more = [np.sign(b.velocity), b.velocity * np.abs(b.velocity), d * np.abs(d), np.gradient(d)]
            any_force.append(b.rows(np.vstack([*table, more])))
        return any_force

    @cached_property
    def screen(self) -> Maximum:
        """Fit of the nuisance parameters behind the screening filter, which absorbs no slow force.

        The filter is estimated from the residual beside generic forces of position, time, speed and command.
        """
        any_force = self.any_force()
        parts = [np.vstack([n, t]) for n, t in zip(self.nuisances, any_force, strict=True)]
        taps = self.taps_of(self.fitted(self.plain, any_force, rounds=1).theta, parts)
        return self.fitted(taps)

    @cached_property
    def basis(self) -> tuple[FloatArray, FloatArray, FloatArray]:
        """Row weights, orthonormal nuisance columns with pseudo-observations of the priors, and their residual."""
        null = self.screen
        sigma, target = null.prior
        root = np.sqrt(null.weight / null.variance)
        y = np.concatenate([null.r * root, (target / sigma)[np.isfinite(sigma)]])
        q = nuisance_basis(null.x * root, sigma)
        return root, q, y - (q @ y) @ q

    def project(self, tables: Sequence[FloatArray]) -> tuple[FloatArray, FloatArray]:
        """Return whitened candidate columns orthogonal to the nuisances, (k, n + priors), and their norms before."""
        root, q, _ = self.basis
        c = self.filtered(tables, self.screen.taps) * root
        return beside(c, q), np.linalg.norm(c, axis=1)

    def score(self, tables: Sequence[FloatArray]) -> tuple[float, FloatArray, int]:
        """Return the score statistic T of columns (k, m), their amplitudes (k,) and the degrees of freedom of T.

        T has a chi-square distribution under the null hypothesis.
        """
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


def reduced(gram: FloatArray, slope: FloatArray, kept: NDArray[np.intp]) -> tuple[FloatArray, FloatArray]:
    """Return R (k, k) and y (k,) of the quadratic w G w - 2 slope w, least over the amplitudes that are not kept.

    Up to a constant it is |R w - y|^2 of the kept amplitudes.
    """
    rest = np.setdiff1d(np.arange(len(gram)), kept)
    others = np.linalg.solve(gram[np.ix_(rest, rest)], np.column_stack([gram[np.ix_(rest, kept)], slope[rest]]))
    own = gram[np.ix_(kept, kept)] - gram[np.ix_(kept, rest)] @ others[:, :-1]
    right = slope[kept] - gram[np.ix_(kept, rest)] @ others[:, -1]
    value, vector = np.linalg.eigh(own)
    root = np.sqrt(np.maximum(value, 1e-10 * np.trace(own)))  # collinear columns: below zero by rounding
    return root[:, None] * vector.T, (vector.T @ right) / root


def positive_loss(parts: FloatArray, y: FloatArray) -> float:
    """Return the least |A u - y|^2 over u that are not negative, with A (p, q) and y (p,)."""
    return float(nnls(parts, y, maxiter=100 * parts.shape[1])[1]) ** 2 if parts.shape[1] else float(y @ y)


def nuisance_basis(x: FloatArray, sigma: FloatArray) -> FloatArray:
    """Return orthonormal rows that span columns x (p, n) with pseudo-observations of priors, (p, n + priors).

    `sigma`: standard deviation of each prior, (p,); infinite without one.
    """
    finite = np.isfinite(sigma)
    return orthonormal(np.hstack([x, np.diag(1.0 / np.where(finite, sigma, 1.0))[:, finite]]))


def beside(c: FloatArray, q: FloatArray) -> FloatArray:
    """Return columns c (k, n) orthogonal to a `nuisance_basis` q (p, n + priors), (k, n + priors)."""
    c = np.hstack([c, np.zeros((len(c), q.shape[1] - c.shape[1]))])
    return np.asarray(c - (c @ q.T) @ q)


def orthonormal(rows: FloatArray) -> FloatArray:
    """Return orthonormal rows that span rows (p, n), without directions at rounding level."""
    size = np.linalg.norm(rows, axis=1)
    if not np.any(size):
        return rows[:0]
    rows = rows[size > 1e-12 * size.max()] / size[size > 1e-12 * size.max(), None]
    value, vector = np.linalg.eigh(rows @ rows.T)
    good = value > 1e-9 * value[-1]
    return np.asarray((vector[:, good] / np.sqrt(value[good])).T @ rows)
