"""Candidates: effects of the vocabulary and generic forces as columns along the measured motion, ranked by their score.

A candidate is a group of columns at one shape (a period, a width, a time constant). `search_once` scans the shapes of
each coordinate, keeps the best shape of each name and refines the best candidates.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from copy import copy
from dataclasses import dataclass, replace
from functools import partial
from itertools import product
from typing import Any, NamedTuple

import numpy as np
from scipy.ndimage import maximum_filter1d
from scipy.signal import lfilter
from scipy.special import expit, logit

from cogging.arrays import FloatArray, IntArray
from cogging.diagnosis.balance.cells import hats, splines
from cogging.diagnosis.balance.differenced_balance import DifferencedBalance, gain_of_taps
from cogging.diagnosis.balance.evidence import Evidence, convolved, deviation, likeliest, student_cost
from cogging.effects.effect import VOCABULARY, Effect
from cogging.logs.log import Log
from cogging.resources import on_threads

E = VOCABULARY
Columns = Callable[[Evidence], list[FloatArray]]  # columns (k, n) of each log along its motion
Law = Callable[[FloatArray], Effect | tuple[Effect, ...] | None]  # effect, or effects, with amplitudes (k,)

# Sizes and limits of laws
SMALL = 1e-2  # of the largest command: amplitude at which the column of a force law is evaluated
UNIT = 1e-3  # amplitude at which columns of gains, reading errors and own effects are evaluated
LEAST_DELAY = 0.02  # samples: accuracy of the time stamps
WHOLE = (0.65, 1.5)  # allowed amplitude of a command limit, whose column is the complete effect, by its instrument
WIDTHS = 31  # of a dead zone that are tried
LIMIT_STEP = 0.25  # step of a saturation, in the logit of its share of the largest command
MOST = 0.9  # quantile: a saturation lets most forces pass that the motion needs
PASSED = 0.45  # of the power of the force that the motion needs: least that a limit of the command lets pass
BRISTLE = (0.3, 2.0)  # allowed amplitude of presliding, which replaces most of Coulomb friction
SHORTEST, LONGEST = 4.0, 0.1  # of the noise of a reading, of the travel: shortest and longest presliding
NEAR_REST = ("presliding_friction",)  # tried with the rows near rest, where other friction is not known
GAPS = 24  # widths of a play that are tried
LOAD = (0.0, 0.95)  # allowed share of the mass that is the load
DAMPINGS = (0.02, 0.1)  # damping ratios of a resonance; above, it is indistinguishable from a lag
LIMITS = ("command_saturation", "command_dead_zone")
GAINS = (  # laws in proportion to the command, or nearly so
    *("force_constant_ripple", "force_constant_drift", "~gain along travel"),
    *("~gain of speed", "~command", "~reluctance"),
)
LINEAR = 0.1  # of the command's standard deviation: columns of a larger change of it are evaluated at its size
LARGEST_SCALE = 0.1  # largest scale error of an encoder
SECANTS = 3  # sizes at which columns of large effects are evaluated, each the one that the columns before give
OWN_SHAPES = 6  # grid values of each shape parameter of an own effect
BUMPS = (0.004, 0.12)  # of the travel: range of the widths of a local force
SPRING, REVERSED = 8, 0.05  # splines of a cable's force along the travel; share of its variation that may turn back
PLACES = 1001  # grid of the centre of a local force
FAR_END = 50.0  # decay lengths: distance at which an end has no effect
# Scans
PEAKS, TONES = 4, 3  # peaks of a spectrum that are tried for each kind of wave along the travel, and in time
LEAST_PEAK = 12.0  # minimum score of a peak: noise exceeds it in a few hundred of 100,000 lines
LEAST_TURNS = 1.0  # minimum periods in the travel: a longer wave is a spring or an offset
FAMILY_TURNS = 1.5  # minimum periods of a wave with harmonics
WAVE_GRID = 1e-4  # m: grid of the position spectrum, a quarter of the shortest wave
MODULATIONS = (4, 6)  # splines of the amplitude of a modulated wave along the travel
NESTED = 0.7  # minimum share of the gain of a wider family that a law explains, to give its name
MOST_WAVES = 3  # waves that are fitted together
SHORTEST_WAVE = 1.0 / 2500.0  # m: shorter than the pitch of any motor or scale
ROWS_PER_WAVE = 2.2  # minimum rows in the shortest wave at the highest speed; fewer alias
BAND_SHARE = 1e-3  # of the largest gain: waves with less power in the band are skipped
TONE_SHARE = 0.38  # of the sample rate: highest frequency of a tone, below the stop band of the decimation
WINDOW_SPACING = 48  # grid of start and stop of a force, before refinement
LEAST_WINDOW, LOCAL = 2e-3, 0.3  # of the range: shortest such force, longest local one
FAST = 0.05  # of the top speed: slower motion is close to a reversal
APART = 0.02  # s: minimum time between two jumps of the reading, and from slow motion
MOST_JUMPS = 8  # jumps that are fitted together
PLACES_A_ROW = 4  # at the top speed: grid of a place at which the reading jumps
STEP = 0.2  # first step of the refinement, in the logarithm of the shape
REFINED, REFINED_SHARE = 40.0, 0.25  # difference from the best score, or share of it, up to which shapes are refined
CERTAIN_ZERO = 5.0  # minimum score of a shape that is refined


class Shape(NamedTuple):
    """A candidate at one shape: label, columns, and law (None for a generic force)."""

    label: str
    columns: Columns
    law: Law | None = None
    instrument: Columns | None = None  # without noise, of one column that is the complete effect, of amplitude 1
    sudden: bool = False  # whether the one column acts in few rows, which a fit without it takes for outliers


Refine = tuple[float, Callable[[float], Shape], float]


@dataclass(eq=False)
class Found:
    """Best shape of one name."""

    name: str  # of the effect, or of a generic force, which starts with ~
    label: str  # of the shape
    T: float  # score statistic
    k: int  # degrees of freedom of T
    N: float  # number of shapes that were tried
    amplitudes: Any  # of the columns, (k,)
    columns: Any  # function(evidence) that returns the columns of each log; None for a parameter of the axis
    effect: Any = None  # function(amplitudes) that returns one law or several; None without; path of a parameter
    others: tuple[str, ...] = ()  # further names of a shape without a law
    likeness: float = 1.0  # share of the gain of a shape without a law that the law of its name explains
    period: float | None = None  # of a wave along the travel, m
    refine: Refine | None = None  # a number of the shape, function(number) that returns a `Shape`, first relative step
    sudden: bool = False  # see `Shape`
    accept: Callable[[FloatArray], bool] | None = None  # test of the amplitudes

    def accepts(self, amplitudes: FloatArray) -> bool:
        """Return whether amplitudes (k,) are those of this effect."""
        return self.accept is None or self.accept(amplitudes)

    @property
    def near_rest(self) -> bool:
        """Whether rows near rest count."""
        return self.name in NEAR_REST

    def laws(self, amplitudes: FloatArray) -> tuple[Effect, ...]:
        """Return the effects with these amplitudes; empty without a law, or where the law excludes them."""
        if self.effect is None or self.columns is None:
            return ()
        try:
            made = self.effect(amplitudes)
        except ValueError:  # a mass ratio below zero, say: beside other effects, this one is not there
            return ()
        return () if made is None else made if isinstance(made, tuple) else (made,)

    def rows(self, evidence: Evidence) -> tuple[Evidence, list[FloatArray]]:
        """Return the evidence whose rows count, and the columns as its rows, of each log."""
        evidence = evidence.near_rest if self.near_rest else evidence
        return evidence, rows_of(evidence, self.columns)

    @property
    def score(self) -> float:
        """T less the expected gain of k amplitudes and N trials under the null hypothesis."""
        return float(self.T - self.k * np.log1p(max(self.T, 0.0) / max(self.k, 1)) - 2 * np.log(max(self.N, 1)))


def rows_of(evidence: Evidence, columns: Columns) -> list[FloatArray]:
    """Return columns as rows of the evidence, of each log."""
    return [b.rows(x) for b, x in zip(evidence.balances, columns(evidence), strict=True)]


def along(make: Callable[[DifferencedBalance], Any]) -> Columns:
    """Return columns made from each balance."""
    return lambda c: [np.atleast_2d(make(b)) for b in c.balances]


def at_commands(c: Evidence, columns: Columns, commands: Sequence[FloatArray]) -> list[FloatArray]:
    """Return columns made from other commands, V, (n,) of each log."""
    other = copy(c)
    other.instruments = [one._replace(drive=u) for one, u in zip(c.instruments, commands, strict=True)]
    return columns(other)


def under_law(columns: Columns, amplitudes: FloatArray) -> Columns:
    """Return columns of a law of the command, at the command that the motion needs under this law.

    Columns of the measured command would explain every force that the command balances.
    """

    def at_needed(c: Evidence) -> list[FloatArray]:
        x = [np.zeros((len(amplitudes), len(b.time))) for b in c.balances]
        for _ in range(1 + SECANTS * bool(np.any(amplitudes))):
            x = at_commands(c, columns, [one.needed - amplitudes @ t for one, t in zip(c.instruments, x, strict=True)])
        return x

    return at_needed


def driven(make: Callable[[DifferencedBalance, FloatArray], Any]) -> Columns:
    """Return columns made from each balance and its drive."""
    return lambda c: [np.atleast_2d(make(b, d)) for b, d in zip(c.balances, c.drives, strict=True)]


def within(limits: tuple[float, float]) -> Callable[[FloatArray], bool]:
    """Return a test of whether the first amplitude is between limits."""
    return lambda a: bool(limits[0] < a[0] < limits[1])


class Search:
    """Candidates of one round of the search, with the ranges of the motion."""

    def __init__(self, ctx: Evidence) -> None:
        bs = ctx.balances
        self.ctx, self.balances, self.model = ctx, bs, ctx.model
        self.low = min(b.position.min() for b in bs)  # m
        self.high = max(b.position.max() for b in bs)
        self.length = self.high - self.low
        self.top = max(np.abs(b.velocity).max() for b in bs)  # m/s
        self.duration = max(b.time[-1] for b in bs)  # s
        self.force = max(np.abs(b.command).max() for b in bs)  # V
        self.weights = adjoint(ctx, ctx.basis[0], ctx.basis[2])
        self.found: dict[str, Found] = {}
        self.least: dict[str, float] = {}  # smallest value of a shape; below half of it the effect vanishes
        self.most: dict[str, float] = {}  # largest value of a shape; beyond it the law is that of another effect

    def put(
        self,
        name: str,
        shape: Shape,
        trials: int = 1,
        accept: Callable[[FloatArray], bool] | None = None,
        refine: Refine | None = None,
        period: float | None = None,
        family: str = "",
    ) -> float:
        """Keep a shape if it is the best of its name and family; return its T, or 0 if its amplitudes are rejected."""
        shape, T, amplitudes, k = self.fitted(name, shape)
        if accept is not None and not accept(amplitudes):
            return 0.0
        key, made = family or name, (shape.columns, shape.law)
        one = Found(name, shape.label, T, k, trials, amplitudes, *made, period=period, refine=refine)
        one.sudden, one.accept = shape.sudden, accept
        if key not in self.found or one.score > self.found[key].score:
            self.found[key] = one
        return T

    def share_of_command(self, columns: Columns, amplitudes: FloatArray) -> float:
        """Return the largest share of a command that columns with these amplitudes take, in standard deviations."""
        taken = zip(columns(self.ctx), self.ctx.drives, strict=True)
        return max(float(np.std(amplitudes @ x)) / max(float(np.std(d)), 1e-300) for x, d in taken)

    def fitted(self, name: str, shape: Shape) -> tuple[Shape, float, FloatArray, int]:
        """Return a shape with its T, amplitudes and degrees of freedom.

        A law that changes much of the command has its columns at the command that the motion needs under the law. There
        they are instruments of the columns at the measured command, which give the first amplitudes.
        """
        T, amplitudes, k = self.scored(name, shape)
        linear, ctx = shape.columns, self.ctx
        if name in GAINS and self.share_of_command(linear, amplitudes) > LINEAR:
            none = under_law(linear, np.zeros(len(amplitudes)))
            z = np.hstack(none(ctx))
            x = np.hstack(at_commands(ctx, linear, [b.command for b in ctx.balances]))
            taken = self.scored(name, Shape("", none))[1] @ z
            amplitudes = np.asarray(np.linalg.lstsq(z @ x.T, z @ taken, rcond=1e-6)[0])
            for _ in range(SECANTS):
                shape = shape._replace(columns=under_law(linear, amplitudes))
                T, amplitudes, k = self.scored(name, shape)
        return shape, T, amplitudes, k

    def scored(self, name: str, shape: Shape) -> tuple[float, FloatArray, int]:
        """Return T, amplitudes and degrees of freedom of a shape."""
        ctx = self.ctx.near_rest if name in NEAR_REST else self.ctx
        if shape.sudden:
            return *fall_of_cost(ctx, shape.columns), 1
        T, a, k = ctx.score(rows_of(ctx, shape.columns))
        if shape.instrument is not None and k:
            x, z = (ctx.project(rows_of(ctx, columns))[0][0] for columns in (shape.columns, shape.instrument))
            whole = a[0] > 0.5 and WHOLE[0] < z @ ctx.basis[2] / (z @ x) < WHOLE[1]
            # the fall of the sum of squares with the amplitude 1: a rise where a < 0.5
            T, a = T * (1.0 - (1.0 / a[0] - 1.0) ** 2) if whole else 0.0, np.ones(1)
        return T, a, k

    def varied(
        self,
        name: str,
        value: float,
        make: Callable[[float], Shape],
        trials: int,
        accept: Callable[[FloatArray], bool] | None = None,
    ) -> None:
        """Try the shape with one number, to be refined if it is among the best."""
        self.put(name, make(value), trials, accept, (value, make, STEP))

    def law(
        self,
        name: str,
        fields: Mapping[str, Any],
        amplitude: str,
        size: float,
        trials: int = 1,
        vary: str | None = None,
        accept: Callable[[FloatArray], bool] | None = None,
    ) -> float:
        """Try an effect of the vocabulary at one shape; `size`: of its amplitude, where its column is evaluated."""

        def make(**changed: float) -> Shape:
            held = {**fields, **changed}
            base = E[name].replace(**held)
            label = ", ".join(f"{field} {value:.4g}" for field, value in held.items() if isinstance(value, float))
            columns = added([base.replace(**{amplitude: size})], size)
            return Shape(label, columns, lambda a: base.replace(**{amplitude: float(a[0])}))

        refine = None if vary is None else (fields[vary], lambda value: make(**{vary: float(value)}), STEP)
        return self.put(name, make(), trials, accept, refine)


def added(effects: Sequence[Effect], size: float) -> Columns:
    """Return columns of the force of effects over their size."""
    return lambda c: [b.added(c.model, effects, d) / size for b, d in zip(c.balances, c.drives, strict=True)]


def adjoint(ctx: Evidence, root: FloatArray, e: FloatArray) -> list[FloatArray]:
    """Return the weight of each row of the motion in the score of a column, (n,) of each log.

    `root` is the square root of the weight of each whitened row, e their residual; pseudo-observations may follow it.
    """
    out, at = [], 0
    weighed = root * e[: len(root)]
    for b, counted, taps, level in zip(ctx.balances, ctx.counted, ctx.screen.taps, ctx.levels, strict=True):
        full = np.zeros(len(counted))
        full[counted] = weighed[at : at + int(counted.sum())] / level
        at += int(counted.sum())
        out.append(b.adjoint(convolved(full[::-1], taps)[::-1]))
    return out


def fall_of_cost(ctx: Evidence, columns: Columns) -> tuple[float, FloatArray]:
    """Return the fall of -2 ln likelihood with one column, and its amplitude, (1,), by a fit from equal weights."""
    none, c = ctx.screen, ctx.filtered(rows_of(ctx, columns), ctx.screen.taps)
    fit = likeliest(c, none.rest, np.full(1, np.inf), np.zeros(1), tail=ctx.tail)
    return float(np.sum(student_cost(none.rest, none.variance, ctx.tail)) - fit.cost), fit.w


def gain_of(ctx: Evidence, frequency: FloatArray) -> FloatArray:
    """Return the power gain of low-pass filter, decimation and whitening at frequencies (Hz), (k,)."""
    b = ctx.balances[0]
    folded = np.abs((frequency + 0.5 * b.rate) % b.rate - 0.5 * b.rate)
    gain = gain_of_taps(ctx.screen.taps[0], folded / b.rate)
    return np.asarray(gain**2 / ctx.screen.variance * b.power(frequency))


def direction(b: DifferencedBalance, velocity: FloatArray | None = None) -> FloatArray:
    """Return the sign of a speed (m/s, (n,); None for that of the rows), linear within its noise, (n,)."""
    return np.asarray(np.clip((b.velocity if velocity is None else velocity) / (3.0 * b.speed_noise), -1.0, 1.0))


def friction_hats(b: DifferencedBalance, speeds: FloatArray) -> FloatArray:
    """Return friction laws that are hats of the logarithm of the speed, averaged as the known law is, (k, n)."""
    v = b.fine.velocity
    return b.averaged(hats(np.log(np.maximum(np.abs(v), speeds[0])), np.log(speeds)) * direction(b, v))


def contrast(table: FloatArray) -> FloatArray:
    """Return basis functions (k, n) that sum to 1, without their constant: re-tuning absorbs it, (k - 1, n)."""
    return np.asarray(table[:-1] - 1.0 / len(table))


def sharpen(f: Callable[[float], float], x: float, step: float, rounds: int = 7) -> float:
    """Return a local maximiser of f near x, by steps in both directions that are halved without progress."""
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
    return x


def wave_sum(
    weights: Sequence[FloatArray], places: Sequence[FloatArray], least: float = -np.inf
) -> Callable[[float], float]:
    """Return |sum w exp(2 pi i k x)| of weights w at places x of each log as a function of k; -1 up to the least k."""
    w, x = np.concatenate(weights), np.concatenate(places)
    return lambda k: float(abs(w @ np.exp(2j * np.pi * k * x))) if k > least else -1.0


def peaks_of(score: FloatArray, places: FloatArray, apart: float, count: int, least: float = 0.0) -> list[int]:
    """Return the indexes of the highest peaks of a score above `least`, at places that are `apart` from each other."""
    left, peaks = score.copy(), list[int]()
    while len(peaks) < count and left.max() > least:
        peaks.append(int(np.argmax(left)))
        left[np.abs(places - places[peaks[-1]]) < apart] = 0.0
    return peaks


def search_once(ctx: Evidence, also: Mapping[str, Effect]) -> list[Found]:
    """Return the best shape of each name and generic force, the highest score first; `also`: own effects."""
    s = Search(ctx)
    scans: list[Callable[[Search], None]] = [waves, forces_of_place, friction, command, reading, motor_and_load, time]
    scans += [jumps, unnamed, changes_of_axis]
    scans += [partial(own_effect, name=name, effect=effect) for name, effect in also.items()]

    @np.errstate(all="ignore")  # each thread has its own
    def part(scan: Callable[[Search], None]) -> Search:
        alone = copy(s)
        alone.found, alone.least, alone.most = {}, {}, {}
        scan(alone)
        return alone

    for done in on_threads(part, scans):
        s.found |= done.found
        s.least |= done.least
        s.most |= done.most
    best = sorted(s.found.values(), key=lambda f: -f.score)
    limit = max(min(best[0].score - REFINED, REFINED_SHARE * best[0].score), CERTAIN_ZERO)
    final = [f for f in on_threads(lambda f: refined(s, f) if f.score > limit else f, best) if f is not None]
    final = [f for f in final if f.name not in LIMITS or passes(ctx, f)]
    return sorted(with_cells(final), key=lambda f: -f.score)


@np.errstate(all="ignore")
def refined(s: Search, f: Found) -> Found | None:
    """Return a candidate at the best value of its number, if it has one; None if the effect vanishes there."""
    if f.refine is None:
        return f
    value, make, step = f.refine
    tried = {}

    def at(logarithm: float) -> float:
        tried[logarithm] = s.fitted(f.name, make(float(value * np.exp(logarithm))))
        return tried[logarithm][1] if f.accepts(tried[logarithm][2]) else 0.0

    x = sharpen(at, 0.0, step, 8)
    if value * np.exp(x) < 0.5 * s.least.get(f.name, -np.inf):
        return None
    shape, T, amplitudes, k = tried[x]
    if T <= f.T or value * np.exp(x) > s.most.get(f.name, np.inf):
        return f
    return replace(f, label=shape.label, T=T, k=k, amplitudes=amplitudes, columns=shape.columns, effect=shape.law)


def forces_of_place(s: Search) -> None:
    """Try offset, spring, end effects, local forces and gravity."""
    low, high, length, middle = s.low, s.high, s.length, 0.5 * (s.low + s.high)
    small = SMALL * s.force
    s.law("constant_force", {}, "force", small)
    s.law("cable_spring", {"center": middle}, "stiffness", small / length)

    def spring(a: FloatArray) -> Effect:
        center = middle - float(a[1]) / (float(a[0]) or 1e-300) if a[0] else 0.0
        return E["cable_spring"].replace(stiffness=-float(a[0]), center=center)

    linear = along(lambda b: np.vstack([b.position - middle, np.ones(len(b.time))]))
    s.put("cable_spring", Shape("with offset", linear, spring))
    cubic = along(lambda b: np.vstack([(2 * (b.position - low) / length - 1) ** p for p in range(4)]))
    s.put("cable_spring", Shape("curved", cubic), 2)
    s.put("cable_spring", Shape("curved", along(lambda b: splines(b.position, low, high, SPRING))), 2, is_monotone)
    travel = list(s.model.axis.travel) if np.isfinite(s.model.axis.travel).all() else [low, high]
    lengths = np.geomspace(0.01, 0.25, 8) * length
    s.least["end_effect"], s.most["end_effect"] = lengths[0], lengths[-1]  # what decays more slowly is a spring
    for L in lengths:
        fields = {"decay_length": float(L), "travel": travel}
        s.law("end_effect", fields, "force", small, 8, vary="decay_length")
        s.varied("end_effect", float(L), partial(two_ends, s), 8)
    widths = [float(width) for width in np.geomspace(*BUMPS, 7) * length]

    def bump(center: float, width: float) -> float:
        fields = {"center": center, "width": width}
        return s.law("local_force", fields, "force", small, round(length / width), vary="width")

    _, best, at = max((bump(center, width), center, width) for width in widths for center in best_places(s, width))
    best = sharpen(partial(bump, width=at), best, 0.5 * at)
    for width in widths:
        bump(best, width)
    place = pulse("position", *best_window(s, "position", low, high, LOCAL * length))
    s.put("local_force", place, 300, family="local_force of other shape")
    if s.model.units.position == "rad":
        turn = along(lambda b: -np.vstack([np.sin(b.position), np.cos(b.position)]))
        moment = E["gravity"].replace
        gravity = Shape(
            "one turn", turn, lambda a: moment(moment=float(np.hypot(*a)), angle=float(np.arctan2(-a[1], a[0])))
        )
        s.put("gravity", gravity)


def is_monotone(a: FloatArray) -> bool:
    """Return whether a force of splines with amplitudes (k,) rises, or falls, along the travel, but for REVERSED."""
    steps = np.diff(splines(np.linspace(0.0, 1.0, 101), 0.0, 1.0, len(a)).T @ a)
    return bool(abs(steps.sum()) > (1.0 - 2.0 * REVERSED) * np.abs(steps).sum())


def best_places(s: Search, width: float) -> list[float]:
    """Return the two best centres (m) of a local force of a width (m), ignoring the nuisance parameters."""
    edges = np.linspace(s.low, s.high, PLACES + 1)
    push, rows = np.zeros(PLACES), np.zeros(PLACES)
    for b, w in zip(s.balances, s.weights, strict=True):
        push += np.histogram(b.position, edges, weights=w)[0]
        rows += np.histogram(b.position, edges, weights=b.keep)[0]
    middles = 0.5 * (edges[1:] + edges[:-1])
    bell = np.exp(-(((middles - middles[PLACES // 2]) / width) ** 2))
    seen = np.convolve(rows, bell**2, "same")
    score = np.convolve(push, bell, "same") ** 2 / np.maximum(seen, 0.1 * np.median(seen))
    first = int(np.argmax(score))
    apart = np.abs(middles - middles[first]) > 2.0 * width
    return [float(middles[k]) for k in (first, int(np.argmax(score * apart)))]


def two_ends(s: Search, length: float) -> Shape:
    """Return end effects of either end of the motion, of different forces that decay over a length (m)."""

    def columns(b: DifferencedBalance) -> FloatArray:
        return np.exp(np.minimum(np.vstack([s.low - b.position, b.position - s.high]) / length, FAR_END))

    def law(a: FloatArray) -> tuple[Effect, ...]:
        far = FAR_END * length
        ends = zip((-a[0], a[1]), ([s.low, s.high + far], [s.low - far, s.high]), strict=True)
        effect = E["end_effect"].replace(decay_length=float(length))
        return tuple(effect.replace(force=float(force), travel=travel) for force, travel in ends)

    return Shape(f"two sides {length:.3g}", along(columns), law)


def friction(s: Search) -> None:
    """Try friction that depends on direction, speed and position, and presliding."""
    top, small = s.top, UNIT * max(s.model.axis.coulomb, 1e-3 * s.force)
    s.law("coulomb_asymmetry", {}, "difference", small)
    # where friction is steeper than that of the model, its asymmetry acts as a constant force on an axis that moves
    steep = along(lambda b: np.full(len(b.time), -0.5))
    difference = E["coulomb_asymmetry"].replace
    s.put("coulomb_asymmetry", Shape("steep", steep, lambda a: difference(difference=float(a[0]))), 2)
    s.law("viscous_asymmetry", {}, "difference", small / top)
    for v in np.geomspace(max(2e-3 * top, 2 * min(b.speed_noise for b in s.balances)), 0.3 * top, 8):
        for exponent in (1.0, 2.0):
            fields = {"velocity": float(v), "exponent": exponent}
            s.law("stribeck_friction", fields, "static_excess", small, 16, "velocity", lambda a: bool(a[0] > 0))
    slow = top * np.geomspace(2e-3, 0.2, 5)
    falling = along(lambda b: friction_hats(b, slow)[:-1])
    s.put("stribeck_friction", Shape("other shape", falling), accept=lambda a: bool(np.sum(a) < 0))
    for count in (3, 5, 8):
        s.put("position_dependent_friction", friction_profile(s, count, small), 3)
    s.law("quadratic_drag", {}, "coefficient", 1e-3 * s.force / top**2)

    def powers(*exponents: float) -> Columns:
        return along(lambda b: np.vstack([-np.sign(b.velocity) * (np.abs(b.velocity) / top) ** p for p in exponents]))

    s.put("quadratic_drag", Shape("other shape", powers(1.5, 2.0, 3.0)))
    for p in (1.5, 3.0):
        s.put("quadratic_drag", Shape(f"power {p}", powers(p)), 3)

    def presliding(length: float) -> Shape:
        law = E["presliding_friction"].replace(stiffness=max(float(s.model.axis.coulomb), 1e-12) / length)
        return Shape(
            f"{length:.4g}", lambda c: [b.bristle(c.model.axis, length)[None] for b in c.balances], lambda a: law
        )

    if any(f.name == "presliding_friction" for f in s.ctx.extra):
        return
    lengths = np.geomspace(SHORTEST * min(b.encoder_noise for b in s.balances), LONGEST * s.length, 12)
    s.least["presliding_friction"] = lengths[0]
    for length in lengths:
        s.varied("presliding_friction", length, presliding, 12, within(BRISTLE))


def friction_profile(s: Search, count: int, size: float) -> Shape:
    """Return friction that is linear between nodes along the travel, less its mean, which is Coulomb friction."""
    profile = partial(E["position_dependent_friction"].replace, nodes=np.linspace(s.low, s.high, count).tolist())
    levels = contrast(np.eye(count))
    columns = added([profile(levels=row) for row in (size * levels).tolist()], size)
    return Shape(f"{count} nodes", columns, lambda a: profile(levels=(a @ levels).tolist()))


def command(s: Search) -> None:
    """Try delay, lag, saturation, dead zone and gain drift of the command."""
    least = LEAST_DELAY * float(np.median(np.diff(s.balances[0].log.time)))

    def later(name: str, field: str, change: Callable[[float, DifferencedBalance, FloatArray], FloatArray]) -> None:
        """Try a change of the command by a time, s, near that of the slope; the amplitude multiplies the time."""

        def shape(size: float) -> Shape:
            law = E[name].replace
            return Shape(f"{size:.3g}", timed(partial(change, size)), lambda a: law(**{field: float(size * a[0])}))

        for size in (0.7 * first, first, 1.4 * first):
            s.varied(name, size, shape, 3, within((least / size, np.inf)))

    def falling(b: DifferencedBalance, d: FloatArray) -> FloatArray:
        return np.asarray(-np.diff(d, prepend=d[0]) / b.step)

    def timed(change: Callable[[DifferencedBalance, FloatArray], FloatArray]) -> Columns:
        """Return columns of a change of the command whose timing is known."""
        return driven(lambda b, d: change(b, b.timed(d)))

    s.put(LATE, Shape("", driven(falling)), accept=lambda a: bool(a[0] < -least))
    slope = Shape("slope", timed(falling), lambda a: E["command_delay"].replace(delay=float(a[0])))
    if s.put("command_delay", slope, accept=lambda a: bool(a[0] > least)):
        first = float(s.found["command_delay"].amplitudes[0])
        later("command_delay", "delay", delayed)
        later("actuator_lag", "time_constant", lagged)

    def limited(label: str, make: Callable[[FloatArray], FloatArray], law: Callable[[], Effect]) -> Shape:
        """Return a limit, which acts on peaks and small values of the command itself: its drive smooths them away."""
        return Shape(label, along(lambda b: make(b.command)), lambda a: law(), driven(lambda b, d: make(d)))

    def saturation(limit: float) -> Shape:
        law = partial(E["command_saturation"].replace, limit=float(limit))
        return limited(f"{limit:.4g}", lambda u: np.clip(u, -limit, limit) - u, law)

    def dead_zone(width: float) -> Shape:
        law = partial(E["command_dead_zone"].replace, width=float(width))
        return limited(f"{width:.4g}", lambda u: -np.clip(u, -width, width), law)

    needed = max(float(np.quantile(np.abs(one.needed), MOST)) for one in s.ctx.instruments)
    s.least["command_saturation"] = 2.0 * needed
    shares = expit(np.arange(logit(0.99), logit(np.clip(needed / s.force, 1e-6, 0.9)), -LIMIT_STEP))
    for limit in shares * s.force:
        s.varied("command_saturation", limit, saturation, len(shares))
    for width in np.geomspace(1e-3, 1.0, WIDTHS) * s.force:
        s.varied("command_dead_zone", width, dead_zone, WIDTHS)
    for power in (2, 4, 8):
        soft = driven(partial(lambda power, b, u: -u * np.abs(u / s.force) ** power, power))
        s.put("command_saturation", Shape(f"power {power}", soft), 3, lambda a: bool(a[0] > 0))
    for tau in np.geomspace(0.05, 2.0, 5) * s.duration:
        s.law("force_constant_drift", {"time_constant": float(tau)}, "change", UNIT, 5, vary="time_constant")


def passes(c: Evidence, f: Found) -> bool:
    """Return whether the command that passes a limit is most of the force that the motion needs.

    A limit that lets little pass explains every force that the command balances: it deletes the command. What motion
    needs depends on mass and friction: the share is averaged over those re-tuned without the limit and with it.
    """
    rows, shares = f.rows(c)[1], list[float]()
    limits = [e for e in c.model.effects if e.NAME in LIMITS]
    passed = [b.rows(sum(b.added(c.model, limits, b.command), b.command)[None])[0] for b in c.balances]
    for fit in (c.null, c.fitted(c.plain, rows)):
        left, needed = 0.0, 0.0
        for u, x, r, n, m in zip(passed, rows, c.residuals, c.nuisances, c.masks, strict=True):
            rest = r - fit.theta[: len(n)] @ n
            left += float(np.sum((rest - f.amplitudes @ x)[m] ** 2))
            needed += float(np.sum((u + rest)[m] ** 2))
        shares.append(1.0 - left / needed)
    return sum(shares) > 2.0 * PASSED


def delayed(time: float, b: DifferencedBalance, d: FloatArray) -> FloatArray:
    """Return the change of the command by a delay (s)."""
    return np.asarray(np.interp(b.time - time, b.time, d) - d)


def lagged(tau: float, b: DifferencedBalance, d: FloatArray) -> FloatArray:
    """Return the mean change of the held command by a first-order lag (s) over each step; it is causal."""
    p = np.exp(-b.step / tau)
    before = lfilter([0.0, 1 - p], [1, -p], d - d[0]) + d[0]
    return np.asarray((before - d) * (1 - p) * tau / b.step)


def misread(effects: Sequence[Effect], size: float) -> Columns:
    """Return the apparent force of errors of the reading over their size, V, by the acceleration that has no noise."""

    def columns(c: Evidence) -> list[FloatArray]:
        models = [c.model.replace(effects=made) for made in ((), *((e,) for e in effects))]
        tables = []
        for b, one in zip(c.balances, c.instruments, strict=True):
            alone, *rest = (b.residual(m, one.drive, one.acceleration) for m in models)
            tables.append((alone - np.array(rest)) / size)
        return tables

    return columns


def reading(s: Search) -> None:
    """Try a scale error of the reading; `waves` tries its periodic error."""
    size = UNIT

    def scale(size: float) -> Shape:
        error = E["encoder_scale_error"].replace
        return Shape("", misread([error(scale=size)], size), lambda a: error(scale=float(a[0])))

    for _ in range(SECANTS):  # the phase of known cogging is not linear in the scale
        s.put("encoder_scale_error", scale(size), accept=within((-LARGEST_SCALE, LARGEST_SCALE)))
        if "encoder_scale_error" not in s.found:
            return
        size = float(s.found["encoder_scale_error"].amplitudes[0]) or UNIT


def motor_and_load(s: Search) -> None:
    """Try a load behind a spring (resonance) and behind a gap (backlash)."""
    ctx, b0 = s.ctx, s.balances[0]
    lowest, highest = max(3.0 / s.duration, 2.0), min(0.25 * b0.rate, b0.corner)  # Hz
    coarse = np.geomspace(lowest, highest, 18)

    def mode(f: float, damping: float) -> Shape:
        half = E["flexible_mode"].replace(frequency=float(f), damping_ratio=damping, mass_ratio=0.5)
        columns = loaded(half if f < 1.1 * highest else half.replace(mass_ratio=0.0))
        law = half.replace  # its force is proportional to r / (1 - r) of its share r of the mass
        return Shape(f"{f:.4g} Hz, damping {damping}", columns, lambda a: law(mass_ratio=float(a[0] / (1.0 + a[0]))))

    for damping in DAMPINGS:
        shape = partial(mode, damping=damping)
        tables = [rows_of(ctx, shape(f).columns) for f in coarse]
        size = np.linalg.norm(ctx.project([np.vstack(rows) for rows in zip(*tables, strict=True)])[0], axis=1)
        fine = np.geomspace(lowest, highest, int(np.log(highest / lowest) / max(damping, 0.02)))
        products = [sum(w @ x[0] for w, x in zip(s.weights, shape(f).columns(ctx), strict=True)) for f in fine]
        met = np.array(products, dtype=float)
        worth = np.where(met > 0, met, 0.0) / np.exp(np.interp(np.log(fine), np.log(coarse), np.log(size + 1e-300)))
        for f in fine[np.argsort(-worth)[:2]]:
            s.varied("flexible_mode", f, shape, 3 * len(fine), lambda a: bool(a[0] > 0.0))

    def play(gap: float, impacts: bool, sudden: bool = False) -> Shape:
        """Return the force of a load behind a gap, with impacts or without: they may come at other instants."""
        law = partial(E["backlash"].replace, gap=float(gap))

        def apart(c: Evidence) -> list[FloatArray]:
            parts = zip(c.balances, c.instruments, strict=True)
            tables = [c.model.axis.mass * b.play(one.moves, float(gap)) for b, one in parts]
            return [t.sum(axis=0)[None] if impacts else t[:1] for t in tables]

        return Shape(f"{gap:.4g}", apart, lambda a: law(mass_ratio=float(a[0])), sudden=sudden)

    gaps = np.geomspace(max(4.0 * max(b.encoder_noise for b in s.balances), 2e-6), LONGEST * s.length, GAPS)
    s.least["backlash"] = gaps[0]
    tried = [*product(gaps, [False]), *product(gaps[::2], [True])]  # with impacts: those that last for a row or two
    for gap, impacts in tried:
        s.varied("backlash", gap, partial(play, impacts=impacts), len(tried), within(LOAD))
    for gap in (way for way in ways_to_outliers(s) if gaps[0] < way < gaps[-1]):
        s.varied("backlash", gap, partial(play, impacts=True, sudden=True), len(tried), within(LOAD))


def ways_to_outliers(s: Search) -> list[float]:
    """Return the ways (m) by which the motor has left a load when the largest outliers come: possible gaps."""
    even, ways = np.full(len(s.ctx.screen.rest), 1.0 / np.sqrt(s.ctx.screen.variance)), list[float]()
    parts = zip(s.balances, s.ctx.instruments, adjoint(s.ctx, even, even * s.ctx.screen.rest), strict=True)
    for b, one, w in parts:
        a = one.moves * ~b.resting
        for met in peaks_of(np.abs(w), b.time, APART, MOST_JUMPS):
            turned = np.flatnonzero(a[:met] * a[met - 1] < 0.0)
            start = int(turned[-1]) + 1 if len(turned) else 0
            ways.append(float(abs(np.sum(np.cumsum(a[start : met + 1])))) * b.step**2)
    return ways


def loaded(effect: Effect) -> Columns:
    """Return the force of a load behind a spring."""

    def columns(c: Evidence) -> list[FloatArray]:
        model = c.model.replace(effects=(effect,))
        parts = zip(c.balances, c.instruments, strict=True)
        return [b.loads(model, one.force, one.moves)[None] for b, one in parts]

    return columns


def time(s: Search) -> None:
    """Try a force between two times, and tones."""
    begin, end = best_window(s, "time", 0.0, s.duration, s.duration)
    step = Shape(
        f"{begin:.3g} to {end:.3g}",
        along(lambda b: ((b.time >= begin) & (b.time < end)).astype(float)),
        lambda a: E["disturbance_step"].replace(force=float(a[0]), start=begin, stop=end),
    )
    s.put("disturbance_step", step, 300)

    s.put("disturbance_step", pulse("time", begin, end), 300)
    tones, trials = best_tones(s)
    for q in tones:
        resolved = [1, *(k for k in (2, 3) if k * q < TONE_SHARE * s.balances[0].rate)]
        for family, orders in (("", [1]), ("s", resolved)):

            def shape(q: float, orders: Sequence[int] = orders) -> Shape:
                def law(a: FloatArray) -> tuple[Effect, ...]:
                    tone, pairs = E["disturbance_tone"].replace, enumerate(np.reshape(a, (-1, 2)), 1)
                    return tuple(tone(frequency=k * q, sine=float(x), cosine=float(y)) for k, (x, y) in pairs)

                label = f"{q:.4g} Hz" + (" with harmonics" if len(orders) > 1 else "")
                return Shape(label, sines("time", 2 * np.pi * q * np.array(orders)), law)

            refine = q, shape, 0.1 / (q * s.duration)
            s.put("disturbance_tone", shape(q), trials, refine=refine, family=f"disturbance_tone{family}")


def pulse(coordinate: str, begin: float, end: float) -> Shape:
    """Return a force that is a parabola of a coordinate between two values and 0 elsewhere."""

    def columns(b: DifferencedBalance) -> FloatArray:
        at = getattr(b, coordinate)
        share = np.clip((at - begin) / max(end - begin, 1e-300), 0.0, 1.0)
        return np.asarray(((at >= begin) & (at < end)) * share ** np.arange(3)[:, None])

    return Shape("other shape", along(columns))


def best_window(s: Search, coordinate: str, low: float, high: float, longest: float) -> tuple[float, float]:
    """Return the two values of a coordinate, at most `longest` apart, between which a constant force acts best.

    All pairs of a grid over the range from low to high are tried; the grid is then refined.
    """
    ctx, spacing = s.ctx, (high - low) / WINDOW_SPACING
    starts = stops = np.arange(low, high, spacing)
    for _ in range(4):
        edges, at = np.unique(np.concatenate([starts, stops]), return_inverse=True)
        c, _ = ctx.project([b.rows((getattr(b, coordinate) >= edges[:, None]).astype(float)) for b in ctx.balances])
        products, gram = c @ ctx.basis[2], c @ c.T
        i, j = at[: len(starts)], at[len(starts) :]
        size = np.diag(gram)[i][:, None] + np.diag(gram)[j] - 2.0 * gram[np.ix_(i, j)]
        T = (products[i][:, None] - products[j]) ** 2 / np.maximum(size, 1e-4 * np.max(np.diag(gram)))
        width = stops - starts[:, None]
        T[(width < LEAST_WINDOW * (high - low)) | (width > longest)] = 0.0
        first, last = np.unravel_index(np.argmax(T), T.shape)
        begin, end = float(starts[first]), float(stops[last])
        fine = np.linspace(-spacing, spacing, 9)
        starts, stops, spacing = np.clip(begin + fine, low, high), np.clip(end + fine, low, high), spacing / 4
    return begin, end


def best_tones(s: Search) -> tuple[list[float], int]:
    """Return the frequencies (Hz) of the highest peaks of the residual in time, and the number of trials."""
    ctx, b = s.ctx, s.balances[0]
    n = max(len(x.time) for x in s.balances)
    size = int(2 ** np.ceil(np.log2(4 * n)))
    spectrum = np.sum([np.fft.rfft(np.pad(w, (0, size - len(w)))) for w in s.weights], axis=0)
    f = np.asarray(np.fft.rfftfreq(size, b.step), dtype=np.float64)
    duration = n * b.step
    rows = sum(int(m.sum()) * x.every for m, x in zip(ctx.masks, s.balances, strict=True))
    use = (f > 2.0 / duration) & (f < TONE_SHARE * b.rate)
    f, score = f[use], 2 * np.abs(spectrum[use]) ** 2 / (rows * gain_of(ctx, f[use]))

    size_at = wave_sum(s.weights, [x.time for x in s.balances])
    peaks = peaks_of(score, f, 1.0 / duration, TONES, LEAST_PEAK)
    best = [sharpen(size_at, float(f[j]), 0.25 / duration, 6) for j in peaks]
    return best, int(duration * TONE_SHARE * b.rate)


def jumps(s: Search) -> None:
    """Try jumps of the reading, as of lost counts, a slip of the scale or a late clock, at the likeliest instants.

    A jump e between two rows adds M e'' to the balance. A fit with heavy tails takes it for an outlier, so its filter
    is matched to rows of equal weight. Friction is least certain near a reversal: only rows in fast motion count.
    """
    ctx = s.ctx
    even = np.full(len(ctx.screen.rest), 1.0 / np.sqrt(ctx.screen.variance))
    scores, fast = [], []
    for b, w in zip(s.balances, adjoint(ctx, even, even * ctx.screen.rest), strict=True):
        f = np.linspace(0.0, 0.5 / b.step, 4096)
        size = np.sqrt(np.mean((2.0 * np.sin(np.pi * f * b.step)) ** 2 * gain_of(ctx, f)))
        scores.append(np.diff(w, prepend=w[0]) / size)
        slow = (np.abs(b.velocity) < FAST * s.top) | (b.keep == 0)
        fast.append(maximum_filter1d(slow.astype(np.uint8), 2 * round(APART / b.step) + 1) == 0)
    rows = sum(int(np.sum(ok)) for ok in fast)
    if not rows:
        return
    noise = deviation(np.concatenate([z[ok] for z, ok in zip(scores, fast, strict=True)]))
    jumps_at_a_place(s, scores, noise)
    peaks: list[tuple[float, Log, int, str]] = []
    for b, z, ok in zip(s.balances, scores, fast, strict=True):
        left, apart = np.where(ok, (z / noise) ** 2, 0.0), round(APART / b.step)
        for _ in range(MOST_JUMPS):
            at = int(np.argmax(left))
            if left[at] - np.log1p(left[at]) < 2.0 * np.log(rows):
                break
            peaks.append((float(left[at]), b.log, at, f"{b.log.time[0] + b.time[at]:.4g} s"))
            left[max(0, at - apart) : at + apart] = 0.0
    peaks.sort(key=lambda peak: -peak[0])
    cost = np.sum(student_cost(ctx.screen.rest, ctx.screen.variance, ctx.tail))
    # the largest difference of two readings by their noise; that of a quantised reading is correlated with the motion
    least = 2.0 * np.sqrt(np.log(rows)) * max(b.encoder_noise for b in s.balances)
    for count in range(1, min(len(peaks), MOST_JUMPS) + 1):
        instants = [(log, at) for _, log, at, _ in peaks[:count]]
        columns = jumped(partial(lambda instants, b: [[at] if b.log is log else [] for log, at in instants], instants))
        c = ctx.filtered(rows_of(ctx, columns), ctx.screen.taps)
        amplitudes = np.linalg.lstsq(c.T, ctx.screen.rest)[0]
        if UNIT * np.min(np.abs(amplitudes)) < least:
            break
        T = float(cost - np.sum(student_cost(ctx.screen.rest - amplitudes @ c, ctx.screen.variance, ctx.tail)))
        label = ", ".join(said for *_, said in peaks[:count])
        one = Found(JUMPS, label, T, count, float(rows) ** count, amplitudes, columns)
        if JUMPS not in s.found or one.score > s.found[JUMPS].score:
            s.found[JUMPS] = one


def jumps_at_a_place(s: Search, scores: Sequence[FloatArray], noise: float) -> None:
    """Try equal jumps of the reading each time the axis passes one place in one direction, as of lost counts.

    `scores` are those of a jump in each row, of each log, with their standard deviation `noise`.
    """
    count = max(1, int(PLACES_A_ROW * s.length / (s.top * s.balances[0].step)))

    def passed(b: DifferencedBalance, way: int, places: FloatArray) -> tuple[IntArray, IntArray]:
        """Return rows in which the axis, in fast motion, has just passed places, which rise with `way`, and which."""
        at = np.searchsorted(places, way * b.position)
        new = np.where((way * b.velocity > FAST * s.top) & (b.keep > 0), np.diff(at, prepend=at[0]), 0).clip(0)
        rows = np.repeat(np.arange(len(at)), new)
        return rows, at[rows] - 1 - (np.cumsum(new)[rows] - 1 - np.arange(len(rows)))

    for way, said in ((1, "forwards"), (-1, "backwards")):
        places = way * np.linspace(s.low, s.high, count + 2)[1:-1][::way]
        total, passes = np.zeros(count), np.zeros(count)
        for b, z in zip(s.balances, scores, strict=True):
            rows, index = passed(b, way, places)
            np.add.at(total, index, z[rows] / noise)
            np.add.at(passes, index, 1.0)
        best = int(np.argmax(np.where(passes > 1, total**2 / np.maximum(passes, 1.0), 0.0)))
        place = partial(passed, way=way, places=places[best : best + 1])
        columns = jumped(partial(lambda place, b: [place(b)[0]], place))
        s.put(LOST, Shape(f"{way * places[best]:.4g} {s.model.units.of('m')} {said}", columns), 2 * count)


def jumped(rows_of_jumps: Callable[[DifferencedBalance], list[Any]]) -> Columns:
    """Return the apparent force of jumps of the reading in rows of a motion, a list of rows for each column."""

    def columns(b: DifferencedBalance, mass: float) -> FloatArray:
        jumps = [np.asarray(at, dtype=int) for at in rows_of_jumps(b)]
        table = np.zeros((len(jumps), len(b.time)))
        for row, at in zip(table, jumps, strict=True):
            np.add.at(row, [at - 1, at], mass * UNIT / b.step**2 * np.array([[1.0], [-1.0]]))
        return table

    return lambda c: [columns(b, c.model.axis.mass) for b in c.balances]


#: Kinds of waves along the travel, with the factor of the wave: a function of balance, drive and largest command.
WAVES: dict[str, Callable[[DifferencedBalance, FloatArray, float], FloatArray]] = {
    "cogging_harmonic": lambda b, d, peak: np.ones(len(b.time)),
    "force_constant_ripple": lambda b, d, peak: d,
    "encoder_periodic_error": lambda b, d, peak: b.velocity**2,
    "~eddy": lambda b, d, peak: b.velocity,
    "~reluctance": lambda b, d, peak: d**2 / peak,
    "~friction wave": lambda b, d, peak: direction(b),
}


def waves(s: Search) -> None:
    """Try waves along the travel of each kind, then modulated waves of the known and the found periods."""
    ctx, length, cogging = s.ctx, s.length, s.model.cogging
    known = [] if cogging is None else [float(w) / (2 * np.pi) for w in cogging.basis.wavenumbers]  # 1/m
    turn = [1.0 / (2 * np.pi)] if s.model.units.position == "rad" else []  # one turn: gravity
    peaks = []
    for name, multiplier in WAVES.items():
        multipliers = [multiplier(b, d, s.force) for b, d in zip(s.balances, ctx.drives, strict=True)]
        weighed = [w * m for w, m in zip(s.weights, multipliers, strict=True)]
        size_at = wave_sum(weighed, [b.position for b in s.balances], LEAST_TURNS / length)
        scanned, trials = wave_scan(s, multipliers)
        for kappa, score in scanned:
            if score < LEAST_PEAK:
                continue
            kappa = sharpen(size_at, kappa, 0.25 / length, 6)
            peaks.append((score, kappa))
            in_model = [1.0 / e.to_dict()["period"] for e in s.model.effects if name == e.NAME]
            if name == "cogging_harmonic":
                in_model += known + turn
            if any(abs(kappa - q) < 0.5 / length for q in in_model):
                continue
            s.most[name] = length / LEAST_TURNS
            # a long wave with harmonics is a generic force
            long = name.startswith("~") or kappa * length < FAMILY_TURNS
            orders = {"": (1,)} if long else {"": (1,), "s": (1, 2, 3)}
            for family, one in orders.items():

                def shape(period: float, name: str = name, orders: Sequence[int] = one) -> Shape:
                    law = None if name.startswith("~") else wave_law(name, *(period / order for order in orders))
                    label = f"{period:.4g} with harmonics" if len(orders) > 1 else f"{period:.4g}"
                    return Shape(label, wave(s, 1.0 / period, name, orders), law)

                period = 1.0 / kappa
                refine = period, shape, 0.1 * period / length
                s.put(name, shape(period), trials, period=period, refine=refine, family=f"{name}{family}")
    plain = s.found.get("cogging_harmonic")
    several_waves(s)
    peaks.sort(reverse=True)
    for kappa in known + [k for _, k in peaks[:3]]:
        same = plain is not None and plain.period is not None and abs(1.0 / plain.period - kappa) < 1.0 / length
        constant = plain.T if same and plain is not None else 0.0  # the score with a constant amplitude
        trials = max(1, len(known)) if kappa in known else 3000
        # an envelope of n splines changes its sign up to n - 1 times, a carrier more often
        for count in (n for n in MODULATIONS if kappa * length > n - 1):
            modulated = modulated_wave(s, kappa, count)
            if constant < NESTED * s.scored("cogging_modulation", modulated)[0]:
                s.put("cogging_modulation", modulated, len(MODULATIONS) * trials)


def several_waves(s: Search) -> None:
    """Try several waves together: each further one is the highest peak of the residual of the others."""
    first, e = None if "cogging_harmonic" not in s.found else s.found["cogging_harmonic"].period, s.ctx.basis[2]
    if first is None or first > s.length / FAMILY_TURNS:
        return
    kappas = [1.0 / first]
    for count in range(2, MOST_WAVES + 1):
        c, _ = s.ctx.project(rows_of(s.ctx, sines("position", 2 * np.pi * np.array(kappas))))
        left = adjoint(s.ctx, s.ctx.basis[0], e - np.linalg.lstsq(c.T, e, rcond=None)[0] @ c)
        peaks, trials = wave_scan(s, [np.ones(len(b.time)) for b in s.balances], left)
        peaks = [peak for peak in peaks if peak[0] * s.length > FAMILY_TURNS]
        if not peaks:
            return
        kappas = [*kappas, peaks[0][0]]
        label = " and ".join(f"{1 / k:.4g}" for k in kappas)
        columns = sines("position", 2 * np.pi * np.array(kappas))
        shape = Shape(label, columns, wave_law("cogging_harmonic", *(1.0 / k for k in kappas)))
        s.put("cogging_harmonic", shape, trials**count, period=first, family=f"cogging_harmonic {count}")


def sines(coordinate: str, turns: FloatArray) -> Columns:
    """Return sine and cosine of a coordinate times each of `turns` (rad per unit)."""
    return along(lambda b: np.vstack([f(q * getattr(b, coordinate)) for q in turns for f in (np.sin, np.cos)]))


def wave_law(name: str, *periods: float) -> Law:
    """Return the laws of sine and cosine with periods (m); cogging opposes the command."""
    sign = -1.0 if name == "cogging_harmonic" else 1.0

    def law(a: FloatArray) -> tuple[Effect, ...]:
        pairs = zip(periods, sign * np.reshape(a, (-1, 2)), strict=True)
        return tuple(E[name].replace(period=p, sine=float(one), cosine=float(other)) for p, (one, other) in pairs)

    return law


def wave(s: Search, kappa: float, name: str, orders: Sequence[int]) -> Columns:
    """Return sine and cosine of multiples of a wavenumber (1/m), times the factor of a kind of wave."""
    if name == "encoder_periodic_error":
        size = 1e-4 / kappa
        parts = [{"sine": size, "cosine": 0.0}, {"sine": 0.0, "cosine": size}]
        return misread([E[name].replace(period=1.0 / (o * kappa), **part) for o in orders for part in parts], size)
    w, peak = 2 * np.pi * kappa, s.force
    return driven(
        lambda b, d: np.vstack(
            [WAVES[name](b, d, peak) * f(o * (w * b.position)) for o in orders for f in (np.sin, np.cos)]
        )
    )


def modulated_wave(s: Search, kappa: float, count: int) -> Shape:
    """Return cogging of a wavenumber (1/m) whose amplitudes are `count` splines along the travel."""

    def make(b: DifferencedBalance) -> FloatArray:
        amplitude, angle = splines(b.position, s.low, s.high, count), 2 * np.pi * kappa * b.position
        return np.vstack([amplitude * np.sin(angle), amplitude * np.cos(angle)])

    def law(a: FloatArray) -> Effect:
        sine, cosine = np.reshape(-a, (2, count)).tolist()
        knots = {"pitch": s.length / (count - 3), "order": 4, "origin": s.low}
        return E["cogging_modulation"].replace(period=1.0 / kappa, sine=sine, cosine=cosine, **knots)

    return Shape(f"{1 / kappa:.4g}", along(make), law)


def wave_scan(
    s: Search, multipliers: Sequence[FloatArray], weights: Sequence[FloatArray] | None = None
) -> tuple[list[tuple[float, float]], int]:
    """Return wavenumbers (1/m) and scores of the highest peaks of multiplier * wave, and the number of trials."""
    n = int(2 ** np.ceil(np.log2(8 * min(s.length / WAVE_GRID, 2**17))))
    dx = s.length / (n // 8)
    grid = np.zeros(n)
    for b, w, m in zip(s.balances, s.weights if weights is None else weights, multipliers, strict=True):
        place = (b.position - s.low) / dx
        left = place.astype(int)
        share = place - left
        np.add.at(grid, left, w * m * (1 - share))
        np.add.at(grid, left + 1, w * m * share)
    spectrum = np.abs(np.fft.rfft(grid)) ** 2
    kappa = np.fft.rfftfreq(n, dx)
    shortest = max(4.0 * dx, SHORTEST_WAVE, ROWS_PER_WAVE * s.top * max(b.step for b in s.balances))
    use = (kappa > LEAST_TURNS / s.length) & (kappa < 1.0 / shortest)
    if not use.any():  # every wave within the travel would alias
        return [], 1
    k = kappa[use]
    norm = wave_power(s, multipliers, k)
    score = 2 * spectrum[use] / np.maximum(norm, 1e-9 * norm.max())
    score[norm < BAND_SHARE * norm.max()] = 0
    peaks = [(float(k[j]), float(score[j])) for j in peaks_of(score, k, 1.0 / s.length, PEAKS)]
    return peaks, int(max(10, (k[-1] - k[0]) * s.length))


def wave_power(s: Search, multipliers: Sequence[FloatArray], k: FloatArray) -> FloatArray:
    """Return the power of waves of wavenumbers k (1/m) behind all filters; at speed v their frequency is k v."""
    speeds, weights = [], []
    for b, m in zip(s.balances, multipliers, strict=True):
        keep = np.repeat(b.mask, b.every)[: len(b.time)]
        keep = np.pad(keep, (0, len(b.time) - len(keep)))
        speeds.append(np.abs(b.velocity)[keep])
        weights.append((m**2)[keep])
    counts, edges = np.histogram(
        np.concatenate(speeds), bins=60, range=(0, s.top * 1.0001), weights=np.concatenate(weights)
    )
    f = np.linspace(0.0, 0.5 / s.balances[0].step, 4096)
    gain = gain_of(s.ctx, f)
    power = np.zeros(len(k))
    for count, v in zip(counts, 0.5 * (edges[1:] + edges[:-1]), strict=True):
        if count > 0:
            power += count * np.interp(k * v, f, gain)
    return power


def unnamed(s: Search) -> None:
    """Try generic forces along each coordinate, which have no name."""
    low, high, top, duration = s.low, s.high, s.top, s.duration
    speeds = top * np.geomspace(2e-3, 0.9, 8)
    knots = np.linspace(0, duration, 12)
    cells = {
        "~gain of speed": driven(lambda b, d: np.vstack([d * np.abs(b.velocity) / top, d * (b.velocity / top) ** 2])),
        "~viscous along travel": along(lambda b: contrast(splines(b.position, low, high, 6)) * b.velocity),
        "~viscous in time": along(lambda b: contrast(hats(b.time, np.linspace(0, duration, 5))) * b.velocity),
        "~friction in time": along(lambda b: contrast(hats(b.time, knots)) * direction(b)),
        "~force in time": along(lambda b: hats(b.time, knots)),
        "~force along travel": along(lambda b: splines(b.position, low, high, 14)),
        "~gain along travel": driven(lambda b, d: contrast(splines(b.position, low, high, 8)) * d),
        "~command": driven(lambda b, d: np.vstack([d * np.abs(d), d**3, d**2])),
        "~friction over speed": along(lambda b: friction_hats(b, speeds)),
    }
    for name, columns in cells.items():
        s.put(name, Shape("", columns))


def changes_of_axis(s: Search) -> None:
    """Try changes of mass and friction beyond their stated uncertainty: the score of their pseudo-observations."""
    ctx = s.ctx
    finite = [i for i, sigma in enumerate(ctx.prior_sigma) if np.isfinite(sigma)]
    _, q, e = ctx.basis
    for name in ("mass", "viscous", "coulomb"):
        path = f"axis.{name}"
        if path not in ctx.paths or ctx.paths.index(path) not in finite:
            continue
        c = np.zeros(len(e))
        c[len(e) - len(finite) + finite.index(ctx.paths.index(path))] = 1.0
        c -= (q @ c) @ q
        T = float((c @ e) ** 2 / max(float(c @ c), 1e-12)) / ctx.alike
        s.found[f"{name}_change"] = Found(f"{name}_change", "", T, 1, 1, np.array([0.0]), None, path)


def own_effect(s: Search, name: str, effect: Effect) -> None:
    """Try a user-defined effect: its amplitudes as columns, on a grid of its shape parameters."""
    scales = {"velocity": s.top, "distance": s.length, "time": s.duration, "force": s.force}

    def values_of(role: Mapping[str, Any]) -> FloatArray:
        space = np.geomspace if role["logarithmic"] else np.linspace
        inner = role["neutral"] is not None  # then skip the ends of the range
        grid = space(role["low"], role["high"], OWN_SHAPES + 2 * inner)[inner : OWN_SHAPES + inner]
        if role["quantity"] == "position":
            return np.asarray(s.low + s.length * grid)
        return np.asarray(scales.get(role["quantity"], 1.0) * grid)

    amplitudes = [field for field, role in effect.ROLES.items() if role["role"] == "amplitude"]
    shapes = {
        field: values_of(role)
        for field, role in effect.ROLES.items()
        if role["role"] == "shape" and not isinstance(getattr(effect, field), list)
    }
    grid = list(product(*shapes.values()))
    for values in grid:
        at = dict(zip(shapes, map(float, values), strict=True))

        def make(value: float | None = None, at: dict[str, float] = at) -> Shape:
            fields = at if value is None else {**at, next(iter(at)): float(value)}
            label = ", ".join(f"{field} {number:.4g}" for field, number in fields.items())
            return own_shape(label, effect.replace(**fields), amplitudes)

        first = next(iter(at.values()), 0.0)  # only the first shape parameter is refined
        s.put(name, make(), len(grid), refine=(first, make, STEP) if first > 0.0 else None)


def own_shape(label: str, base: Effect, amplitudes: Sequence[str]) -> Shape:
    """Return a user-defined effect at one shape, with a column per amplitude or entry of a list of amplitudes."""
    units: list[tuple[str, int | None]] = []
    for name in amplitudes:
        value = getattr(base, name)
        units += [(name, k) for k in range(len(value))] if isinstance(value, list) else [(name, None)]

    def law(sizes: FloatArray) -> Effect:
        fields: dict[str, Any] = {name: [0.0] * len(getattr(base, name)) for name, k in units if k is not None}
        for (name, k), size in zip(units, sizes, strict=True):
            if k is None:
                fields[name] = float(size)
            else:
                fields[name][k] = float(size)
        return base.replace(**fields)

    def columns(c: Evidence) -> list[FloatArray]:
        alone = [b.residual(c.model) for b in c.balances]
        models = [c.model.replace(effects=(*c.model.effects, law(one))) for one in np.eye(len(units)) * UNIT]
        return [np.array([(r - b.residual(m)) / UNIT for m in models]) for b, r in zip(c.balances, alone, strict=True)]

    return Shape(label, columns, law)


JUMPS, LOST = "~jump of the reading in time", "~jump of the reading along travel"
LATE = "~command logged late"  # a fault of the log: its amplitude is the negative time shift, s
#: Generic forces along a coordinate, and the effects whose law may have such a shape.
CELLS = {
    "~force along travel": ("cable_spring", "end_effect", "local_force", "constant_force"),
    "~gain along travel": ("force_constant_ripple",),
    "~command": ("command_saturation", "command_dead_zone"),
    "~friction wave": ("position_dependent_friction",),
    "~force in time": ("disturbance_step", "disturbance_tone"),
}


def with_cells(found: Sequence[Found]) -> list[Found]:
    """Return the candidates with each generic force renamed after the best law of its coordinate, if one fits."""
    by = {f.name: f for f in sorted(found, key=lambda f: f.score)}
    out = {(f.name, f.label): f for f in found}
    for cell, names in CELLS.items():
        members = sorted((by[n] for n in names if n in by and n != "constant_force"), key=lambda f: -f.T)
        if cell not in by or not members or members[0].T - members[0].k < NESTED * (by[cell].T - by[cell].k):
            continue
        del out[cell, by[cell].label]
        best = members[0]
        if by[cell].score > best.score:
            others = tuple(f.name for f in members[1:] if f.T > NESTED * best.T)
            likeness = best.T / max(best.T, by[cell].T, 1e-9)
            named = replace(by[cell], name=best.name, label="other shape", effect=None)
            out[cell, ""] = replace(named, others=others, likeness=likeness)
    return list(out.values())
