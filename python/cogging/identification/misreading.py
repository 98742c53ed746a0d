"""Detect a column of a log that was read as something else; reported only where the evidence is clear."""

from __future__ import annotations

import contextlib
import math
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from functools import cache, cached_property
from typing import Any

import numpy as np

from cogging.arrays import FloatArray, cross_correlation
from cogging.estimation.axis_balance import AXIS, AxisBalance, AxisFit, Bounds, explained_share, thinned
from cogging.log_check.controller_check import check_controller, compared
from cogging.log_check.controller_recovery import recover_controller
from cogging.log_check.encoder_readings import encoder_quantum
from cogging.log_check.log_audit import ANGLES, TIME_UNITS, position_units
from cogging.logs.log import Log
from cogging.logs.spikes import repaired, spikes
from cogging.model.model import Model

# Units
COMMANDS = {  # by the factor to the model's unit
    1e-3: "thousandths of the model's unit",
    1e3: "thousands of the model's unit",
    1e-2: "percent",
    1e2: "hundredths of a percent, or a share where the model has percent",
}
WHOLE = 0.98  # share of readings that are whole numbers in a position in counts
NEAR, EXACT = 2.5, 1.1  # ratio to a known unit, of a factor from mass and friction, or from the controller
REFERENCES = ("reference", "reference_velocity", "reference_acceleration")

# The columns by themselves
FOLLOWED = 0.2  # rms of the difference over that of the column, below which a column follows another
UNLIKE = 0.6  # likewise, above which it does not
SAME_SIZE = 1.5  # ratio of amplitudes of a column and the one it is
OTHER_SIZE = 3.0  # ratio of amplitudes from which the unit is another
EQUAL = 0.999  # share of rows in which a position equals its reference: no axis does that
SMOOTH = 1e-4  # of the encoder's step: sixth differences of a column that was not read from an encoder
FINE = 0.1  # m: a finer encoder does not give whole numbers
QUANTA = 0.01  # relative difference of two encoder steps that are equal

# The controller
CLOSE = 5e-3  # of the rms command: a log that the stated controller reproduces this well was read correctly
IMPROVED = 0.2  # of the difference to the stated controller, that another reading may leave
UNIT = 9.0  # ratio of the commands from which the unit is doubted rather than a gain
FURTHEST = 0.1  # of the rows: largest shift of the command

# The force balance: factors by which mass and friction may differ from the model's
ONE_SIGN = 0.01  # of the rows: a command that changes its sign less often is a magnitude, or holds a load
WIDE = 9.0  # before a reading is doubted: a payload and a wrong model together
NARROWER = 4.0  # for a swap or a shift
SHOWN = 2  # of mass, viscous and Coulomb friction, at least, must be needed to tell a unit
NEEDED, TIMES_MORE = 0.005, 1.25  # increase of the unexplained share without a parameter that counts as needed
AS_WELL, SLIGHT = 2.0, 1e-3  # a second reading explains the log as well: ratio, or difference, of unexplained shares
LEAD_ROWS = 2  # by which a position may lead its command
DELAY_ROWS, DELAY = 10, 0.015  # rows and s by which it may lag: a drive, a bus or a filter, which are effects
FREE = 0.05  # of the command's power, that no force of position explains
SHIFTS = 60  # tried either way before the best is refined


@dataclass(frozen=True)
class Reading:
    """One way to read a log differently."""

    column: str  # that is read differently
    kind: str  # sign, scale, swap, derivative, shift, or reference
    said: str = field(compare=False)  # what is wrong, a clause with the column as its subject
    factors: Mapping[str, float] = field(default_factory=dict)  # by column
    renamed: Mapping[str, str] = field(default_factory=dict)  # the column that takes the place of another, by place
    shift: int = 0  # rows by which the command is too late, negative: too early

    def of(self, log: Log) -> Log:
        """The log read this way."""
        columns = log.columns()
        columns |= {place: columns[column] for place, column in self.renamed.items()}
        if self.kind == "derivative":
            steps = np.diff(log.time, append=log.time[-1])
            moved = 0.5 * (log.position + np.append(log.position[1:], log.position[-1])) * steps
            columns["position"] = np.concatenate([[0.0], np.cumsum(moved)[:-1]])
        columns |= {name: factor * columns[name] for name, factor in self.factors.items() if name in columns}
        if self.shift:
            early, last = slice(0, len(log) - abs(self.shift)), slice(abs(self.shift), len(log))
            kept, command = (early, last) if self.shift > 0 else (last, early)
            columns = {name: column[command if name == "command" else kept] for name, column in columns.items()}
        return Log.of(columns)

    def option(self, log: Log, prefixes: Sequence[str]) -> str:
        """The command-line option, for the logs with these prefixes; "" where no option does it."""
        pairs = [f"{column}={factor:.6g}" for column, factor in self.factors.items() if column in log.columns()]
        pairs += [f"{place}={column}" for place, column in self.renamed.items()]
        word = "--scale " if self.factors else "--columns " if self.renamed else ""
        return word + ",".join(prefix + pair for prefix in prefixes for pair in pairs)

    def advice(self, option: str) -> str:
        """What to do."""
        if self.factors:
            return f"give {option} (times what was given there before)"
        if self.renamed:
            return f"give {option} (or the reverse of what was given there before)"
        if self.shift:
            way = "up" if self.shift > 0 else "down"
            return f"move the column {abs(self.shift)} rows {way} against the others, in the file or in Python"
        if self.kind == "derivative":
            return "name the column of the position with --columns position=NAME, or integrate it over time"
        return "name the column of the encoder with --columns position=NAME"


@dataclass(frozen=True)
class Misreading:
    """A column of a log that was read as something else."""

    column: str  # of the log
    misreading: str  # sign, scale, swap, derivative (of the position), shift, or reference (given as position)
    factor: float | None  # by which the column is to be multiplied, or None
    rows: int | None  # by which the command is too late, negative: too early; or None
    option: str  # to give on the command line, or "" where no option does it
    alternatives: tuple[str, ...]  # options that these logs cannot distinguish from it
    explained: float | None  # share of the command's power in motion that the model explains as read; None: unknown
    explained_otherwise: float | None  # the same with the column read correctly
    logs: tuple[str, ...]  # names of the logs
    advice: str  # what to do
    text: str  # all of it in a sentence

    def to_dict(self) -> dict[str, Any]:
        """All fields for JSON."""
        return {**vars(self), "alternatives": list(self.alternatives), "logs": list(self.logs)}


@np.errstate(all="ignore")  # extreme values are refused where they are used
def misreading(logs: Sequence[Log], model: Model, names: Sequence[str] | None = None) -> Misreading | None:
    """Find the simple misreading that would explain logs which a model does not explain; None where none is clear.

    Tried for each log by itself: the sign of command, position or reference; units; swapped columns; a velocity, or the
    reference, in place of the position; a command that is rows too late or far too early. The evidence is the columns
    themselves, the stated controller, and the force balance, which decides only where the log as read is excluded even
    with mass and friction far from the model's, and the other reading fits. The result is the misreading of the first
    log that has one, and of all that share it.
    """
    called = list(names) if names is not None else [f"log {i + 1}" for i in range(len(logs))]
    clean = [repaired(log, spikes(log.position), spikes(log.command))[0] for log in logs]
    judged = [readings_of(log, model) for log in clean]
    first = next((i for i, readings in enumerate(judged) if readings), None)
    if first is None:
        return None
    readings, log = judged[first], clean[first]

    def share(log: Log) -> float | None:
        try:
            explained = explained_share([log], model)
        except ValueError:
            return None
        return explained if explained is not None and math.isfinite(explained) else None

    def percent(share: float) -> str:
        return f"{100.0 * max(share, 0.0):.0f} %" if share < 0.995 else f"{100.0 * share:.3g} %"

    best = readings[0]
    concerned = [name for name, found in zip(called, judged, strict=True) if found[:1] == [best]]
    explained, otherwise = share(log), None if best.kind == "reference" else share(best.of(log))
    prefixes = [""] if len(concerned) == len(logs) else [f"{name}:" for name in concerned]
    options = [one.option(log, prefixes) for one in readings]
    text = f"{', '.join(concerned)}: {best.column} {best.said}"
    if explained is not None and otherwise is not None:
        text += f"; the model explains {percent(explained)} of the command's power in motion as it was read, "
        text += f"{percent(otherwise)} otherwise"
    others = [f"{r.column} {r.said} ({option})" for r, option in zip(readings, options, strict=True)][1:]
    if others:
        text += f"; not distinguishable in these logs from: {'; '.join(others)}"
    advice = best.advice(options[0])
    return Misreading(
        column=best.column,
        misreading=best.kind,
        factor=best.factors.get(best.column),
        rows=best.shift or None,
        option=options[0],
        alternatives=tuple(options[1:]),
        explained=explained,
        explained_otherwise=otherwise,
        logs=tuple(concerned),
        advice=f"{advice[0].upper()}{advice[1:]}.",
        text=f"{text}: {advice}",
    )


def readings_of(log: Log, model: Model) -> list[Reading]:
    """The misreading of one log and those indistinguishable from it; empty where none is clear."""
    check = check_controller(log, model) if log.reference is not None else None
    if check is not None and check.reproduces:
        return misread_by_controller(log, model)
    found = misread_columns(log, model)
    if not found:
        by_controller = misread_by_controller(log, model)
        try:
            case = BalanceCase(log, model)
        except ValueError:  # the log hardly moves
            return by_controller
        if by_controller:
            return case.likeliest(by_controller)
        found = case.readings()
    # A controller of unknown gains that made the log excludes all misreadings but units.
    made = found and found[0].kind != "scale" and log.reference is not None and recover_controller(log) is not None
    return [] if made else found


# The columns by themselves --------------------------------------------------------------------------------------------


def _following(column: FloatArray, leader: FloatArray) -> tuple[float, float]:
    """Slope of a column over another, and rms of the difference over that of the column, both without their means."""
    column, leader = column - np.mean(column), leader - np.mean(leader)
    power, size = float(np.mean(leader**2)), float(np.sqrt(np.mean(column**2)))
    if power == 0.0 or size == 0.0:
        return 0.0, 1.0
    slope = float(np.mean(column * leader)) / power
    return slope, float(np.sqrt(np.mean((column - slope * leader) ** 2))) / size


def _follows(log: Log) -> float:
    """Slope of the position over the reference that it follows; 0 where it does not or there is none."""
    if log.reference is None:
        return 0.0
    slope, left = _following(log.position, log.reference)
    return slope if left < FOLLOWED else 0.0


def misread_columns(log: Log, model: Model) -> list[Reading]:
    """Readings that the columns alone prove, the likeliest first."""

    def equals(column: FloatArray, leader: FloatArray) -> bool:
        slope, left = _following(column, leader)
        return left < FOLLOWED and 1.0 / SAME_SIZE < slope < SAME_SIZE

    if log.reference is not None:
        reference, position = log.reference, log.position
        slope, left = _following(position, reference)
        resembles = slope > 0.0 and left < UNLIKE
        if np.ptp(reference) > 0.0 and float(np.mean(np.abs(position - reference) <= 1e-9 * np.ptp(reference))) > EQUAL:
            return [Reading("position", "reference", "equals the reference row by row, as no axis follows it")]
        if equals(log.command, reference) and not resembles:
            return [_exchanged("position", "command")]
        velocity = log.reference_velocity
        velocity = np.gradient(reference, log.time) if velocity is None else velocity
        if equals(position, velocity) and not resembles:
            return [Reading("position", "derivative", "is the velocity: it follows that of the reference")]
        if _is_too_smooth(position, encoder_quantum(reference)) and equals(position, reference):
            return [_exchanged("position", "reference")]
    resolution, unit = model.encoder.resolution, model.units.position
    if 0.0 < resolution < FINE and _is_whole(log.position):
        others = REFERENCES if _follows(log) > 0.0 else ()
        return [_in_unit(f"is in counts of the encoder, of {resolution:g} {unit}", resolution, others)]
    if resolution > 0.0:
        if abs(encoder_quantum(log.command) / resolution - 1.0) < QUANTA and encoder_quantum(log.position) == 0.0:
            return [_exchanged("position", "command")]
        if _is_too_smooth(log.position, resolution):
            said = f"is smoother than the readings of an encoder of {resolution:g} {unit}: a reference, or filtered"
            return [Reading("position", "reference", said)]
    return []


def _exchanged(one: str, other: str) -> Reading:
    return Reading(one, "swap", f"and {other} are swapped", renamed={one: other, other: one})


def _is_too_smooth(position: FloatArray, resolution: float) -> bool:
    """Whether readings are far smoother than an encoder of this resolution (m) gives, and on no grid."""
    moving = np.abs(np.diff(position, 6))[np.diff(position)[5:] != 0.0]
    is_smooth = resolution > 0.0 and moving.size >= 50 and float(np.median(moving)) <= SMOOTH * resolution
    return is_smooth and encoder_quantum(position) == 0.0


def _is_whole(position: FloatArray) -> bool:
    """Whether readings, but for a few interpolated ones, are whole numbers."""
    return bool(np.ptp(position) > 10.0 and np.mean(position == np.round(position)) > WHOLE)


# The stated controller ------------------------------------------------------------------------------------------------


def misread_by_controller(log: Log, model: Model) -> list[Reading]:
    """The reading whose command the stated controller reproduces, where it does not reproduce the log as read.

    Two for a unit: the controller cannot tell whether the command is in another one, or all positions are.
    """
    if log.reference is None or model.controller is None:
        return []
    check = check_controller(log, model)
    if check is None or check.reproduces is None or check.relative is None or check.relative < CLOSE:
        return []

    def candidates() -> Iterator[Reading]:
        if not check.reproduces:
            controller = "has the opposite sign of what the stated controller"
            yield Reading("command", "sign", f"{controller} gives", {"command": -1.0})
            yield Reading("position", "sign", f"{controller} reads", {"position": -1.0})
            yield Reading("reference", "sign", f"{controller} follows", dict.fromkeys(REFERENCES, -1.0))
            yield _exchanged("position", "reference")
            yield _exchanged("position", "command")
            if check.ratio and abs(math.log(abs(check.ratio))) > math.log(UNIT):
                yield _command_unit(1.0 / check.ratio, EXACT)
                lengths, factor = position_units(model.units) | ANGLES, abs(check.ratio)
                known = min(lengths, key=lambda length: abs(math.log(length / factor)))
                near = abs(math.log(known / factor)) < math.log(EXACT)
                factor = known if near else float(f"{factor:.4g}")
                said = f"is in {lengths[known] if near else f'a unit of {factor:g} {model.units.position}'}"
                yield _in_unit(said, factor, REFERENCES)
        # The rows by which the logged command may be later than that of the controller, the likeliest first.
        both = compared(log, model)
        if len(both.computed) == len(both.samples.command):
            pair, rows = (both.samples.command, both.computed), both.judged
            logged, given = (np.where(rows, command - np.mean(command[rows]), 0.0) for command in pair)
            most = max(3, int(FURTHEST * len(logged)))
            lags = np.setdiff1d(np.arange(-most, most + 1), [0])
            order = np.argsort(-cross_correlation(logged, given)[len(given) - 1 + lags])[:3]
            yield from (_moved(int(lag), log) for lag in lags[order])

    found: list[Reading] = []
    for reading in candidates():
        if found and {found[0].kind, reading.kind} != {"scale"}:
            break
        with contextlib.suppress(ValueError):
            other = check_controller(reading.of(log), model)
            if other is not None and other.reproduces and (other.relative or 0.0) < IMPROVED * min(check.relative, 1.0):
                found.append(reading)
    return found


def _in_unit(said: str, factor: float, others: Sequence[str]) -> Reading:
    """A position, and other columns, in another unit."""
    return Reading("position", "scale", said, {"position": factor, **dict.fromkeys(others, factor)})


def _moved(rows: int, log: Log) -> Reading:
    step, way = float(np.median(np.diff(log.time))), "late" if rows > 0 else "early"
    said = f"is {abs(rows)} row{'s' * (abs(rows) != 1)} ({abs(rows) * step:.3g} s) too {way}"
    return Reading("command", "shift", said, shift=rows)


def _command_unit(gain: float, near: float) -> Reading:
    """A command whose unit is `gain` of the model's: a known unit if one lies within a factor `near`."""
    known = min(COMMANDS, key=lambda factor: abs(math.log(factor / abs(gain))))
    if abs(math.log(known / abs(gain))) < math.log(near):
        return Reading("command", "scale", f"is in {COMMANDS[known]}", {"command": math.copysign(known, gain)})
    factor = float(f"{gain:.{2 if near > EXACT else 4}g}")
    return Reading("command", "scale", f"is in a unit that is {factor:g} of the model's", {"command": factor})


# The force balance ----------------------------------------------------------------------------------------------------


@dataclass(frozen=True)
class Evidence:
    """When a reading is clearly better; shares are of the power that free forces of position and time leave."""

    unexplained: float  # of the log as read, at least, whatever mass and friction
    explained: float  # of the other reading, at most
    margin: float = 4.0  # ratio of both, at least
    stretches: float = 9.0  # effective number of blocks that support it, at least: (sum of gains)^2 / sum of squares

    def favours(self, after: AxisFit, before: AxisFit) -> bool:
        """Whether the reading fitted by `after` is clearly better than the one fitted by `before`."""
        if after.ratio > min(self.explained, before.ratio / self.margin) or before.ratio < self.unexplained:
            return False
        if len(before.by_block) != len(after.by_block):
            return True
        gain = before.by_block / before.free - after.by_block / after.free
        return float(gain.sum()) > 0.0 and float(gain.sum()) ** 2 > self.stretches * float(np.sum(gain**2))


SIGN = Evidence(unexplained=0.3, explained=0.3)
SCALE = Evidence(unexplained=0.03, explained=0.25, margin=5.0)
SWAP = Evidence(unexplained=0.2, explained=0.1, margin=6.0)
SHIFT = Evidence(unexplained=0.2, explained=0.1, margin=5.0)

Winners = tuple[list[Reading], float]  # readings that explain a log, the likeliest first, and the best's ratio


class BalanceCase:
    """A log as read, thinned, and what other readings of it leave unexplained."""

    def __init__(self, log: Log, model: Model) -> None:
        self.whole, self.log, self.model = log, thinned(log), model
        self.axis = {name: getattr(model.axis, name) for name in AXIS}
        balance = AxisBalance.of(self.log, model)
        if balance is None:
            raise ValueError("position: must move, got an axis that hardly does")
        self.balance = balance

    def within(self, factor: float) -> Bounds:
        """Mass and friction within a factor of the model's, either way; free where the model has 0."""
        return {name: (v / factor, v * factor) if v > 0.0 else (0.0, np.inf) for name, v in self.axis.items()}

    @cached_property
    def any_size(self) -> AxisFit:
        """As read, with any mass and friction that are not negative."""
        return self.balance.fit(dict.fromkeys(AXIS, (0.0, np.inf)))

    @cached_property
    def near(self) -> AxisFit:
        """As read, with mass and friction within WIDE of the model's."""
        return self.balance.fit(self.within(WIDE))

    def other(self, reading: Reading, bounds: Bounds | None = None) -> tuple[AxisBalance, AxisFit] | None:
        """The balance of another reading and its fit within bounds (None: WIDE); None where there is none."""
        try:
            balance = AxisBalance.of(reading.of(self.log), self.model)
        except ValueError:
            return None
        return None if balance is None else (balance, balance.fit(bounds or self.within(WIDE)))

    def best(self, tried: list[Reading], before: AxisFit, evidence: Evidence, bounds: Bounds | None = None) -> Winners:
        """Readings that are clearly better, and as good as the best; smallest change of mass and friction first."""
        winners = []
        for reading in tried:
            other = self.other(reading, bounds)
            if other is not None and evidence.favours(other[1], before):
                pairs = [(other[1].values[name], self.axis[name]) for name in AXIS[:2]]
                decades = math.hypot(*(math.log10(new / old) for new, old in pairs if old > 0.0 < new))
                winners.append((round(decades, 1), other[1].ratio, reading))
        least = min((ratio for _, ratio, _ in winners), default=np.inf)
        winners.sort(key=lambda winner: winner[0])
        return [reading for _, ratio, reading in winners if ratio <= AS_WELL * least + SLIGHT], least

    def if_shown(self, winners: Winners, bounds: Bounds | None = None) -> Winners:
        """Winners of which one needs two of mass, viscous and Coulomb friction, whose ratio is evidence; else none."""
        bounds = bounds or self.within(WIDE)
        for reading in winners[0]:
            balance, fit = self.other(reading, bounds) or (self.balance, self.near)
            without = [balance.fit({**bounds, name: (0.0, 0.0)}).ratio for name in AXIS]
            if sum(ratio > max(fit.ratio + NEEDED, TIMES_MORE * fit.ratio) for ratio in without) >= SHOWN:
                return winners
        return [], np.inf

    def readings(self) -> list[Reading]:
        """The reading that explains the command far better than the log as read, and those that do as well."""
        if found := self.units_of_reference():
            return found
        tried = [winners for judge in (self.signs, self.scales, self.swaps, self.shifts) if (winners := judge())[0]]
        least = min((ratio for _, ratio in tried), default=0.0)
        return next((readings for readings, ratio in tried if ratio <= AS_WELL * least + SLIGHT), [])  # the simplest

    def likeliest(self, found: list[Reading]) -> list[Reading]:
        """Of readings that a controller cannot tell apart, those that mass and friction support."""
        if len(found) < 2:
            return found
        ratios = [other[1].ratio if (other := self.other(reading)) is not None else np.inf for reading in found]
        order = sorted(zip(ratios, found, strict=True), key=lambda pair: pair[0])
        return [reading for ratio, reading in order if ratio <= AS_WELL * min(ratios)]

    def units_of_reference(self) -> list[Reading]:
        """A position that follows its reference backwards or in another unit: which of both to change."""
        slope = _follows(self.log)
        if slope == 0.0 or 1.0 / OTHER_SIZE < slope < OTHER_SIZE:
            return []
        if slope < 0.0:
            kind, said, factor = "sign", "has the opposite sign of", -1.0
        else:
            kind, said, factor = "scale", "is in another unit than", float(f"{slope:.3g}")
        position = Reading("position", kind, f"{said} the reference", {"position": 1.0 / factor})
        reference = Reading("reference", kind, f"{said} the position", dict.fromkeys(REFERENCES, factor))
        other = self.other(position)
        if other is not None and SIGN.favours(other[1], self.near):
            return [position]
        if other is not None and SIGN.favours(self.near, other[1]):
            return [reference]
        return [position, reference]

    def signs(self) -> Winners:
        """Another sign of command or position."""
        alone = min(float(np.mean(self.log.command > 0.0)), float(np.mean(self.log.command < 0.0))) < ONE_SIGN
        if alone or self.balance.work > 0.0 or self.any_size.ratio < SIGN.unexplained:
            return [], np.inf
        others = dict.fromkeys(REFERENCES if _follows(self.log) > 0.0 else (), -1.0)
        command = Reading("command", "sign", "has the opposite sign: it pushes back", {"command": -1.0})
        position = Reading("position", "sign", "has the opposite sign", {"position": -1.0, **others})
        return self.best([command, position], self.any_size, SIGN)

    def scales(self) -> Winners:
        """Other units, also together with the other sign of the command."""
        if self.near.ratio < SCALE.unexplained:
            return [], np.inf
        mass = self.any_size.values["mass"] / self.model.axis.mass
        gain = math.copysign(self.balance.gain(self.axis), self.balance.work)
        low, high = self.model.axis.travel
        margin = 0.05 * (high - low)
        readings = [  # on the model's travel
            reading
            for reading in self._units(gain, mass)
            if margin == np.inf or low - margin <= np.median(reading.of(self.log).position) <= high + margin
        ]
        return self.if_shown(self.best(readings, self.near, SCALE))

    def _units(self, gain: float, mass: float) -> Iterator[Reading]:
        """Other units; `gain`: needed over logged command; `mass`: mass that the motion needs, over the model's."""
        if gain:
            yield _command_unit(gain, NEAR)
        others = REFERENCES if _follows(self.log) > 0.0 else ()
        lengths = position_units(self.model.units) | ANGLES
        if _is_whole(self.whole.position):
            resolution = self.model.encoder.resolution
            known = resolution if resolution not in (0.0, 1.0) else float(f"{mass:.2g}")
            lengths = {known: "counts of the encoder"}
        for factor, unit in lengths.items():
            if 0.0 < factor != 1.0:
                yield _in_unit(f"is in {unit}", factor, others)
        if np.allclose(np.diff(self.whole.time), 1.0, atol=1e-9):
            controller = self.model.controller
            rate = controller.sample_rate if controller is not None else math.sqrt(mass)
            if rate > 0.0:
                yield Reading("time", "scale", "is the number of the sample", {"time": float(f"{1.0 / rate:.3g}")})
        else:
            for factor, unit in TIME_UNITS.items():
                yield Reading("time", "scale", f"is in {unit}", {"time": factor})

    def swaps(self) -> Winners:
        """Swapped columns, or a velocity for the position: as read, no force of position explains the command."""
        before = self.near
        if before.free < FREE * before.whole or before.ratio < SWAP.unexplained:
            return [], np.inf
        bounds = {**self.within(NARROWER), "drag": (0.0, 0.0)}
        velocity = Reading("position", "derivative", "is a velocity")
        return self.if_shown(self.best([_exchanged("position", "command"), velocity], before, SWAP, bounds), bounds)

    def shifts(self) -> Winners:
        """A command that is too late, or far too early."""
        # a shift of a single wave cannot be told from mass, nor from a force of that frequency
        wave, bounds = self.balance.wave(self.any_size.values), self.within(NARROWER)
        before = self.balance.fit(dict.fromkeys(AXIS, (0.0, np.inf)), beside=wave)
        if before.free < FREE * before.whole or before.ratio < SHIFT.unexplained:
            return [], np.inf

        @cache
        def left(shift: int) -> float:
            return self.balance.fit(bounds, shift=shift).ratio

        most = max(2, int(self.balance.quarter_period / self.balance.step))
        steps = np.unique(np.geomspace(1, most, SHIFTS).astype(int)).tolist()
        best: int = min((0, *steps, *(-step for step in steps)), key=left)
        width = max(1, abs(best) // 4)
        while width >= 1:
            nearer = min((best, best - width, best + width), key=left)
            width = width // 2 if nearer == best else width
            best = nearer
        step = float(np.median(np.diff(self.whole.time)))
        rows = round(best * self.balance.step / step)
        early = max(DELAY_ROWS, math.ceil(DELAY / step))
        if not (rows >= LEAD_ROWS or -rows >= early) or abs(best) >= most:
            return [], np.inf
        after = self.balance.fit(bounds, shift=best)
        return ([_moved(rows, self.whole)], after.ratio) if SHIFT.favours(after, before) else ([], np.inf)
