"""Terms that a force balance may lack, each at the shape and size that leave least of it."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from cogging._core import DivergedError
from cogging.arrays import FloatArray
from cogging.diagnosis.candidates.intervals import acts_at_place, acts_in_interval, bumps
from cogging.diagnosis.candidates.signatures import Candidate, Seen, candidates, known_periods, quantities
from cogging.diagnosis.candidates.waves import is_wave, plain_wave
from cogging.diagnosis.large.balance import WEAKENING, Balances, is_load
from cogging.diagnosis.large.nuisances import Nuisances
from cogging.diagnosis.large.spectrum import peaks, sharpened
from cogging.diagnosis.physical import ends
from cogging.diagnosis.thresholds import ALLOWANCE, SEED, SPECTRUM
from cogging.effects.effect import Effect, Wave, Window, kind_of


@dataclass(frozen=True)
class Seed:
    """A term at its best size.

    Attributes:
        candidate: effect and shape.
        amplitudes: its amplitudes, (q,); empty where its shape alone makes it.
        left: power of the residual that it leaves, nuisances re-tuned beside it, V^2 times rows.
    """

    candidate: Candidate
    amplitudes: tuple[float, ...]
    left: float

    @property
    def name(self) -> str:
        """Name of the effect."""
        return self.candidate.name

    def effect(self) -> Effect:
        """The effect with its amplitudes."""
        return self.candidate.effect(self.amplitudes)


def seeds(balances: Balances, nuisances: Nuisances, vocabulary: Mapping[str, Effect]) -> list[Seed]:
    """The best term of each name, what leaves least first."""
    best: dict[str, Seed] = {}
    waves = [law for law in vocabulary.values() if is_wave(law)]
    others = [law for law in vocabulary.values() if not is_wave(law) and "state" not in law.HOOKS]
    found = [*_waves(balances, nuisances, waves)]
    for law in others:
        # No period but the known ones: several plain waves look like one that changes along the travel.
        found += judged(balances, nuisances, list(candidates(balances, law)))
        if acts_in_interval(law):
            found += _intervals(balances, nuisances, law)
        if acts_at_place(law):
            found += _places(balances, nuisances, law)
    for law in vocabulary.values():
        if is_load(law) and not any("state" in effect.HOOKS for effect in balances.model.effects):
            found += _resonances(balances, nuisances, law)
    for name in {seed.name for seed in found}:
        first = sorted((seed for seed in found if seed.name == name), key=lambda seed: seed.left)[: SEED.looked_at]
        best[name] = min((as_it_is(balances, nuisances, seed) for seed in first), key=lambda seed: seed.left)
    return sorted(best.values(), key=lambda seed: seed.left)


def _places(balances: Balances, nuisances: Nuisances, law: Effect) -> list[Seed]:
    """Forces at the places where they explain most of what re-tuning leaves."""
    first = next(iter(candidates(balances, law)))
    residual = nuisances.moved(nuisances.alone()[0])
    positions = balances.joined([source.balance.dynamics.motion.middle_position for source in balances.sources])
    found = sorted(bumps(balances, law, positions, residual), key=lambda pair: -float(pair[1].max()))
    return judged(balances, nuisances, [replace(first, shape={**first.shape, **shape}) for shape, _ in found])


def _intervals(balances: Balances, nuisances: Nuisances, law: Effect) -> list[Seed]:
    """Forces between two moments of the first log: where its residual has one sign, then edge by edge."""
    window = kind_of(law, Window)
    source = balances.sources[0]
    even = source.balance.dynamics.even - source.balance.dynamics.even[0]
    full = np.zeros(len(even))
    full[source.mask] = nuisances.moved(nuisances.alone()[0])[: int(source.mask.sum())]
    total, rows = (np.concatenate([[0.0], np.cumsum(row)]) for row in (full, source.mask.astype(float)))
    likely = []
    for length in np.unique(np.geomspace(SEED.interval_min, 0.95, SEED.interval_lengths) * len(even)).astype(int):
        score = (total[length:] - total[:-length]) ** 2 / np.maximum(rows[length:] - rows[:-length], 1.0)
        place = int(np.argmax(score)) if length else 0
        likely.append((float(score[place]), float(even[place]), float(even[min(place + length, len(even) - 1)])))
    first = next(iter(candidates(balances, law)), None)
    if first is None or window is None:
        return []

    def at(edges: tuple[float, float]) -> Seed | None:
        shape = {**first.shape, window.start: edges[0], window.stop: edges[1]}
        one = judged(balances, nuisances, [replace(first, shape=shape)]) if edges[1] > edges[0] else []
        return one[0] if one else None

    best: Seed | None = None
    for _, start, stop in sorted(likely, reverse=True)[: SEED.peaks]:
        seed = _edge_by_edge(at, (start, stop), 0.1 * (stop - start), float(even[1]))
        best = seed if best is None or (seed is not None and seed.left < best.left) else best
    return [] if best is None else [best]


def _edge_by_edge(
    at: Callable[[tuple[float, float]], Seed | None], edges: tuple[float, float], step: float, least: float
) -> Seed | None:
    """The seed whose edges, moved one at a time by shorter and shorter steps (s), leave least."""
    best = at(edges)
    while step > least and best is not None:
        moved = [(edges[0] + d, edges[1]) for d in (-step, step)] + [(edges[0], edges[1] + d) for d in (-step, step)]
        tried = [(seed, one) for one in moved if (seed := at(one)) is not None and seed.left < best.left]
        if tried:
            best, edges = min(tried, key=lambda pair: pair[0].left)
        else:
            step *= 0.5
    return best


def judged(balances: Balances, nuisances: Nuisances, tried: list[Candidate]) -> list[Seed]:
    """Each candidate at its best size; those left out that cannot be simulated or would be no such machine."""
    found: list[Seed] = []
    for first in range(0, len(tried), SEED.tried_together):
        part = tried[first : first + SEED.tried_together]
        try:
            tables = _tables(balances, part)
        except (DivergedError, ValueError):
            tables = []
            for one in part:
                try:
                    tables += _tables(balances, [one])
                except (DivergedError, ValueError):
                    tables.append(np.zeros((0, 0)))
        for candidate, columns in zip(part, tables, strict=True):
            seed = _judge(balances, nuisances, candidate, columns) if len(columns) else None
            if seed is not None:
                found.append(seed)
    return found


def _tables(balances: Balances, tried: list[Candidate]) -> list[FloatArray]:
    """Columns of candidates, V per unit of an amplitude, (q, n) each."""
    effects: list[Effect] = []
    units: list[float] = []
    counts = []
    for candidate in tried:
        q = len(candidate.amplitudes)
        counts.append(max(q, 1))
        if not q:
            effects.append(candidate.effect())
            units.append(1.0)
        for k, unit in enumerate(candidate.unit):
            effects.append(candidate.effect([unit if i == k else 0.0 for i in range(q)]))
            units.append(unit)
    table = balances.added(effects) / np.array(units)[:, None]
    return np.split(table, np.cumsum(counts)[:-1])


def _judge(balances: Balances, nuisances: Nuisances, candidate: Candidate, columns: FloatArray) -> Seed | None:
    if not candidate.amplitudes:
        weights, left = nuisances.fitted(columns, np.zeros(1), np.array([SEED.finite[1]]))
        if weights[-1] < SEED.finite[0]:
            return None
        return Seed(_resized(candidate, float(weights[-1])), (), left)
    roles = candidate.law.ROLES
    low, high = np.array([amplitude_ends(roles[field], balances) for field, _ in candidate.amplitudes]).T
    weights, left = nuisances.fitted(columns, low, high)
    amplitudes = weights[len(nuisances.paths) :]
    count = balances.model.encoder.resolution
    if "reading" in candidate.law.HOOKS and len(amplitudes) > 1:
        short = (candidate.period or np.inf) < SPECTRUM.rounding_counts * count
        if short or float(np.linalg.norm(amplitudes)) < SEED.counts * count:
            return None
    return Seed(candidate, tuple(float(a) for a in amplitudes), left)


def amplitude_ends(role: Mapping[str, Any], seen: Seen) -> tuple[float, float]:
    """Between what an amplitude lies: no force is larger than the largest command, others may make less of it.

    A level of friction is measured against the model's, which may be as far off as nobody states (ALLOWANCE.unstated).
    """
    quantity, sizes = role["quantity"], quantities(seen)
    least, most = ends([source.log for source in seen.sources], role)
    room = 1.0 if quantity == "force" else ALLOWANCE.unstated if quantity == "friction" else SEED.amplitude_room
    return max(room * role["low"] * sizes[quantity], least), min(room * role["high"] * sizes[quantity], most)


def as_it_is(balances: Balances, nuisances: Nuisances, seed: Seed) -> Seed:
    """The seed with what it leaves at its own size: what acts through the command is not in proportion to it."""
    if not WEAKENING & set(seed.candidate.law.HOOKS):
        return seed
    column = balances.added([seed.effect()])
    return replace(seed, left=replace(nuisances, residual=nuisances.residual + column[0]).alone()[1])


def _resized(candidate: Candidate, factor: float) -> Candidate:
    """The candidate with a shape that starts from nothing made larger by a factor, where it has one."""
    for field, value in candidate.shape.items():
        role = candidate.law.ROLES[field]
        if role["role"] == "shape" and role["neutral"] == 0.0:
            return replace(candidate, shape={**candidate.shape, field: value * factor})
    return candidate


def _waves(balances: Balances, nuisances: Nuisances, laws: Iterable[Effect]) -> Iterator[Seed]:
    """Waves in place and in time; one along the travel also as every other wave of its period."""
    laws = list(laws)
    steps, _ = nuisances.alone()
    residual = nuisances.moved(steps)
    spatial: list[float] = []
    for law in laws:
        wave = plain_wave(law)
        if wave is None or "reading" in law.HOOKS:
            continue
        along = law.ROLES[wave.shape]["quantity"] == "distance"
        found = peaks(balances, residual, SEED.peaks, spatial=along, gained="command_gain" in law.HOOKS)
        for value in found:
            seed = _sharpest(balances, nuisances, law, value, along)
            if seed is not None:
                yield seed
                if along:
                    spatial.append(float(seed.candidate.shape[wave.shape]))
    known = known_periods(balances.model)
    for law in laws:
        wave = kind_of(law, Wave)
        if wave is not None and law.ROLES[wave.shape]["quantity"] == "distance":
            yield from judged(balances, nuisances, [wave_of(balances, law, period) for period in [*spatial, *known]])


def _sharpest(balances: Balances, nuisances: Nuisances, law: Effect, value: float, along: bool) -> Seed | None:
    span = balances.scales.position if along else balances.scales.time

    def seed_at(number: float) -> Seed | None:
        one = judged(balances, nuisances, [wave_of(balances, law, 1.0 / number if along else number)])
        return one[0] if one else None

    def explained(number: float) -> float:
        seed = seed_at(number)
        return -np.inf if seed is None else -seed.left

    first = explained(value)
    return None if not np.isfinite(first) else seed_at(sharpened(explained, value, 0.6 / span))


def wave_of(balances: Balances, law: Effect, value: float) -> Candidate:
    """A wave at one period (m) or frequency (Hz)."""
    wave = plain_wave(law)
    assert wave is not None
    role = law.ROLES[wave.sine]
    unit = 0.02 * abs(role["high"]) * quantities(balances)[role["quantity"]]
    return Candidate(law, {wave.shape: value}, ((wave.sine, None), (wave.cosine, None)), (unit, unit))


def _resonances(balances: Balances, nuisances: Nuisances, law: Effect) -> Iterator[Seed]:
    """A load that hangs on the motor: its inertia where it does not follow, its share of the mass free."""
    from scipy.optimize import minimize

    top = min(0.5 * source.balance.dynamics.cutoff for source in balances.sources)
    bottom = max(ends([source.log for source in balances.sources], law.ROLES["frequency"])[0], 0.5)
    if not bottom < top:
        return
    limits = np.log([bottom, 1e-3]), np.log([2.0 * top, law.ROLES["damping_ratio"]["high"]])
    frequencies = np.geomspace(bottom, top, SEED.mode_frequencies)
    grid = [(float(frequency), damping) for damping in SEED.damping_ratios for frequency in frequencies]
    seeds = [seed for seed in _loads(balances, nuisances, law, grid) if seed is not None]

    def left(logarithms: FloatArray) -> float:
        frequency, damping = np.exp(np.clip(logarithms, *limits))
        (seed,) = _loads(balances, nuisances, law, [(float(frequency), float(damping))])
        return np.inf if seed is None else seed.left

    for seed in sorted(seeds, key=lambda one: one.left)[: SEED.sharpened]:
        root = (1.0 - seed.candidate.shape["mass_ratio"]) ** 0.5
        start = np.log([seed.candidate.shape["frequency"] * root, seed.candidate.shape["damping_ratio"] * root])
        until = {"maxfev": SEED.mode_evaluations, "xatol": 1e-3, "fatol": 1e-3 * seed.left}
        better = minimize(left, start, method="Nelder-Mead", options=until)
        frequency, damping = np.exp(np.clip(better.x, *limits))
        yield _loads(balances, nuisances, law, [(float(frequency), float(damping))])[0] or seed


def _loads(
    balances: Balances, nuisances: Nuisances, law: Effect, tried: Sequence[tuple[float, float]]
) -> list[Seed | None]:
    """Loads of antiresonances (Hz) and damping ratios, each of the share that leaves least.

    None where one would have none of the mass, or nearly all, or be so damped that it is no resonance.
    """
    mass = balances.model.axis.mass
    rows = []
    for source in balances.sources:
        dynamics = source.balance.dynamics
        answers = np.array([source.load_acceleration(frequency, damping) for frequency, damping in tried])
        rows.append(dynamics.filtered(mass * (dynamics.motion.acceleration - answers)))
    place = nuisances.paths.index("axis.mass") if "axis.mass" in nuisances.paths else None
    found: list[Seed | None] = []
    for (antiresonance, damping), column in zip(tried, balances.joined(rows), strict=True):
        weights, left = nuisances.fitted(column[None, :], np.zeros(1), np.array([np.inf]))
        moved = 0.0 if place is None else float(weights[place])
        share = float(weights[-1]) * mass / (mass + moved)
        if not 0.0 < share < SEED.load_max:
            found.append(None)
            continue
        root = (1.0 - share) ** 0.5
        shape = {"frequency": antiresonance / root, "damping_ratio": damping / root, "mass_ratio": share}
        possible = shape["damping_ratio"] < law.ROLES["damping_ratio"]["high"]
        found.append(Seed(Candidate(law, shape, (), ()), (), left) if possible else None)
    return found
