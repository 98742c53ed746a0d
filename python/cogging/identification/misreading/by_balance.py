"""Which misreading would let mass and friction explain a command that they do not explain as the log was read."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from cogging.identification.misreading.balance import AXIS, Balance, Bounds, Fit, thinned
from cogging.identification.misreading.by_columns import exchanged, follows, other_units
from cogging.identification.misreading.readings import Reading, moved, scales, signs
from cogging.logs.log import Log
from cogging.model.model import Model

WIDE = 9.0  # by which mass and friction may be wrong before a reading is doubted: a payload beside a wrong model
ANY: Bounds = dict.fromkeys(AXIS, (0.0, np.inf))


@dataclass(frozen=True)
class Limits:
    """When a misreading is a clear winner; shares of the power that forces of any place and time leave of a command.

    Attributes:
        unexplained: the log as read leaves at least so much, whatever mass and friction.
        explained: the misreading leaves at most so much.
        margin: and so many times less.
        stretches: of time, at least, that speak for it: (sum of their gains)^2 over the sum of squares.
        needed, times: without a parameter that counts as shown, what is left rises by so much, and so many times.
    """

    unexplained: float
    explained: float
    margin: float = 4.0
    stretches: float = 9.0
    needed: float = 0.005
    times: float = 1.25


SIGN = Limits(unexplained=0.3, explained=0.3)
SCALE = Limits(unexplained=0.03, explained=0.25, margin=5.0)
SWAP = Limits(unexplained=0.2, explained=0.1, margin=6.0)
SHIFT = Limits(unexplained=0.2, explained=0.1, margin=5.0)
SHOWN = 2  # of mass, viscous and Coulomb friction, at least, that tell a unit
AS_WELL = 2.0  # times as much left: another reading explains the log as well ...
SLIGHT = 1e-3  # ... and if both leave as little as that
LEAD_ROWS = 2  # by which a position may be ahead of its command before that is a misreading
DELAY_ROWS, DELAY = 10, 0.015  # rows and s by which it may be behind: a drive, a bus, a filter, which are effects
NEAR = 4.0  # by which mass and friction may then be wrong
ONE_WAVE = 0.7  # of command times acceleration: of one wave a shift is told from mass and friction, or a tone, no more
FREE = 0.05  # of the command's power, that no force of place makes
SHIFTS = 60  # that are tried either way before the best is sought between them


def bounds_of(model: Model, factor: float) -> Bounds:
    """Mass and friction within a factor of the model's, either way; of any size where the model has 0."""
    values = {name: getattr(model.axis, name) for name in AXIS}
    return {name: (v / factor, v * factor) if v > 0.0 else (0.0, np.inf) for name, v in values.items()}


@dataclass(frozen=True)
class Winners:
    """Readings of one kind that explain a log, the likeliest first, and what the best of them leaves."""

    readings: list[Reading]
    ratio: float = np.inf


class Case:
    """A log as it was read, its rows thinned, and what other readings of it leave unexplained."""

    def __init__(self, log: Log, model: Model, balance: Balance, whole: Log) -> None:
        self.log, self.model, self.balance, self.whole = log, model, balance, whole

    @cached_property
    def any_size(self) -> Fit:
        """As read, with mass and friction of any size that is not negative."""
        return self.balance.fit(ANY)

    @cached_property
    def near(self) -> Fit:
        """As read, with mass and friction within WIDE of the model's."""
        return self.balance.fit(bounds_of(self.model, WIDE))

    def other(self, reading: Reading, bounds: Bounds | None = None) -> tuple[Balance, Fit] | None:
        """The balance of another reading, and its fit with mass and friction within bounds, else those of WIDE."""
        try:
            balance = Balance.of(reading.of(self.log), self.model)
        except ValueError:
            return None
        return None if balance is None else (balance, balance.fit(bounds or bounds_of(self.model, WIDE)))

    @staticmethod
    def wins(before: Fit, after: Fit, limits: Limits) -> bool:
        """Whether a reading that leaves `after` is clear of one that leaves `before`."""
        if after.ratio > min(limits.explained, before.ratio / limits.margin) or before.ratio < limits.unexplained:
            return False
        if len(before.by_block) != len(after.by_block):
            return True
        gain = before.by_block / before.free - after.by_block / after.free
        return float(gain.sum()) > 0.0 and float(gain.sum()) ** 2 > limits.stretches * float(np.sum(gain**2))


def misread_by_balance(log: Log, model: Model) -> list[Reading]:
    """The reading that explains the command by far better than the log as read, and those that do as well; or none."""
    try:
        thin = thinned(log)
        balance = Balance.of(thin, model)
    except ValueError:
        return []
    if balance is None:
        return []
    case = Case(thin, model, balance, log)
    beside_reference = _units_of_reference(case)
    if beside_reference:
        return beside_reference
    found = [winners for judge in (_signs, _scales, _swaps, _shifts) if (winners := judge(case)).readings]
    least = min((winners.ratio for winners in found), default=0.0)  # of those that do as well, the simplest
    return next((winners.readings for winners in found if winners.ratio <= AS_WELL * least + SLIGHT), [])


def the_likelier(log: Log, model: Model, found: Sequence[Reading]) -> list[Reading]:
    """Of readings that a controller cannot tell apart, those that mass and friction speak for."""
    if len(found) < 2 or (balance := Balance.of(thin := thinned(log), model)) is None:
        return list(found)
    case = Case(thin, model, balance, log)
    ratios = [other[1].ratio if (other := case.other(reading)) is not None else np.inf for reading in found]
    return [
        r
        for ratio, r in sorted(zip(ratios, found, strict=True), key=lambda two: two[0])
        if ratio <= AS_WELL * min(ratios)
    ]


def _units_of_reference(case: Case) -> list[Reading]:
    """Where a position follows its reference backwards, or in another unit: the one that the balance speaks for."""
    found = other_units(case.log)
    if not found:
        return []
    position, reference = found
    other = case.other(position)
    if other is not None and case.wins(case.near, other[1], SIGN):
        return [position]
    if other is not None and case.wins(other[1], case.near, SIGN):
        return [reference]
    return found


def _signs(case: Case) -> Winners:
    if case.balance.work > 0.0 or case.any_size.ratio < SIGN.unexplained:
        return Winners([])
    return _best(case, signs(case.log, follows=follows(case.log) > 0.0), case.any_size, SIGN)


def _swaps(case: Case) -> Winners:
    """A column in the place of another: as read no force of place explains the command, so read no drag is needed."""
    before = case.near
    if before.free < FREE * before.whole or before.ratio < SWAP.unexplained:
        return Winners([])
    bounds = {**bounds_of(case.model, NEAR), "drag": (0.0, 0.0)}
    velocity = Reading("position", "derivative", "is a velocity")
    return _if_shown(case, _best(case, [exchanged("position", "command"), velocity], before, SWAP, bounds), bounds)


def _best(
    case: Case, readings: Sequence[Reading], before: Fit, limits: Limits, bounds: Bounds | None = None
) -> Winners:
    """Readings that win, and do as well as the best; those first that need the least change of mass and friction."""
    winners = []
    for reading in readings:
        other = case.other(reading, bounds)
        if other is not None and case.wins(before, other[1], limits):
            winners.append((other[1].ratio, _change(case.model, other[1]), reading))
    least = min((ratio for ratio, _, _ in winners), default=np.inf)
    alike = [winner for winner in winners if winner[0] <= AS_WELL * least + SLIGHT]
    return Winners([reading for _, _, reading in sorted(alike, key=lambda winner: winner[1])], least)


def _change(model: Model, fit: Fit) -> float:
    """By how much a fit changes mass and viscous friction, as a power of ten, in whole steps of a tenth."""
    changes = [math.log10(fit.values[n] / v) for n in AXIS[:2] if (v := getattr(model.axis, n)) > 0.0 < fit.values[n]]
    return round(math.hypot(*changes), 1)


def _scales(case: Case) -> Winners:
    """Units; and a unit together with the other sign of the command."""
    if case.near.ratio < SCALE.unexplained:
        return Winners([])
    values, axis = case.any_size.values, case.model.axis
    mass = values["mass"] / axis.mass
    gain = math.copysign(case.balance.gain({name: getattr(axis, name) for name in AXIS}), case.balance.work)
    readings = scales(case.whole, case.model, gain=gain, mass=mass, follows=follows(case.log) > 0.0)
    return _if_shown(
        case, _best(case, [r for r in readings if _on_travel(r.of(case.log), case.model)], case.near, SCALE)
    )


def _if_shown(case: Case, winners: Winners, bounds: Bounds | None = None) -> Winners:
    """Winners of which one needs two of mass, viscous and Coulomb friction, so that their ratio tells; else none."""
    bounds = bounds or bounds_of(case.model, WIDE)
    for reading in winners.readings:
        balance, fit = case.other(reading, bounds) or (case.balance, case.near)
        without = [balance.fit({**bounds, name: (0.0, 0.0)}).ratio for name in AXIS]
        if sum(ratio > max(fit.ratio + SCALE.needed, SCALE.times * fit.ratio) for ratio in without) >= SHOWN:
            return winners
    return Winners([])


def _on_travel(log: Log, model: Model) -> bool:
    """Whether a log lies on the model's travel."""
    low, high = model.axis.travel
    margin = 0.05 * (high - low)
    return not math.isfinite(margin) or bool(low - margin <= np.median(log.position) <= high + margin)


def _shifts(case: Case) -> Winners:
    """A command that stands too late, or far too early."""
    before = case.any_size
    waves = case.balance.one_wave < ONE_WAVE and before.free > FREE * before.whole
    if not waves or before.ratio < SHIFT.unexplained:
        return Winners([])
    most = max(2, int(case.balance.quarter_period / case.balance.step))
    best = _best_shift(case, most)
    step = float(np.median(np.diff(case.whole.time)))
    rows = round(best * case.balance.step / step)
    early = max(DELAY_ROWS, math.ceil(DELAY / step))
    if not (rows >= LEAD_ROWS or -rows >= early) or abs(best) >= most:
        return Winners([])
    after = case.balance.fit(bounds_of(case.model, NEAR), shift=best)
    return Winners([moved(rows, case.whole)], after.ratio) if case.wins(before, after, SHIFT) else Winners([])


def _best_shift(case: Case, most: int) -> int:
    """Rows by which the command is best taken later, at most so many either way."""
    bounds = bounds_of(case.model, NEAR)
    tried: dict[int, float] = {}

    def left(shift: int) -> float:
        if shift not in tried:
            tried[shift] = case.balance.fit(bounds, shift=shift).ratio
        return tried[shift]

    steps = np.unique(np.geomspace(1, most, SHIFTS).astype(int)).tolist()
    best: int = min((0, *steps, *(-step for step in steps)), key=left)
    width = max(1, abs(best) // 4)
    while width >= 1:
        nearer = min((best, best - width, best + width), key=left)
        width = width // 2 if nearer == best else width
        best = nearer
    return best
