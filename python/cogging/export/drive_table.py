"""Compensation tables: the map in the drive's position and unit, and a table of it compared with the map."""

from __future__ import annotations

import math
from dataclasses import dataclass, field

import numpy as np

from cogging._core import CoggingModel, effects
from cogging.arrays import FloatArray
from cogging.design.linear_plant import OF_SPEED
from cogging.effects.effect import laws_of
from cogging.model.model import Model
from cogging.shown import quoted

CoggingEffect = effects.CoggingHarmonic | effects.CoggingModulation
CLOSES = 0.01  # of a period: tolerance of a whole number of periods in a turn, 4 degrees of phase
MANY_SPANS = 20  # compared spans if neither travel nor turn limits the motion
POSITIONS = 100_000  # at which table and map are compared
GOLDEN = 0.5 * (math.sqrt(5.0) - 1.0)  # step of a low-discrepancy sequence
MOST_SPANS = 100  # over which a mean is taken; of a longer motion so many, evenly spaced
NEGLIGIBLE = 1e-12  # of the map's rms


@dataclass(frozen=True)
class Frame:
    """The map in the position p = direction (x - zero) and the quantity of a drive, which adds c(p) to its command.

    c(p) = direction sign scale F_cogging(x): a drive that counts the other way also pushes the other way.
    """

    cogging: CoggingModel | None  # F_cogging(x), in the command unit of the model; None if all is in `waves`
    waves: tuple[CoggingEffect, ...]  # cogging among the effects: periods or amplitudes added by a diagnosis
    left_out: tuple[str, ...]  # names of position-dependent effects that are not cogging
    direction: int  # 1, or -1 if the drive counts down as x increases
    sign: int  # 1, or -1 if the drive subtracts its table, or the map has the sign of the motor's force
    scale: float  # units of the drive per command unit of the model
    zero: float  # x at the drive's position 0
    low: float  # lower end of the motion, x; infinite if unknown
    high: float
    turn: float  # x of one mechanical revolution; 0 = a linear axis
    scale_said: bool  # whether a number or the model's units state the scale

    @property
    def bounded(self) -> bool:
        """Whether both ends of the motion are known."""
        return math.isfinite(self.low) and math.isfinite(self.high)

    @property
    def periods(self) -> FloatArray:
        """Spatial periods of the map, (terms,)."""
        known = [] if self.cogging is None else [2.0 * math.pi / k for k in self.cogging.basis.wavenumbers]
        return np.array([*known, *(one.period for one in self.waves)], dtype=np.float64)

    @property
    def pitch(self) -> float:
        """Pitch of the map; 0 if it has none."""
        return 0.0 if self.cogging is None else float(self.cogging.basis.pitch)

    @property
    def modulated(self) -> bool:
        """Whether amplitudes vary along the travel."""
        known = self.cogging is not None and self.cogging.basis.spline.control_points > 1
        return known or any(isinstance(one, effects.CoggingModulation) for one in self.waves)

    @property
    def gain(self) -> float:
        """Units of the drive per command unit of the model, with both signs."""
        return self.direction * self.sign * self.scale

    def wanted(self, position: FloatArray) -> FloatArray:
        """Return the ideal compensation at x, in the drive's unit."""
        total = np.zeros(position.shape)
        if self.cogging is not None:
            total += self.cogging.force(position)
        for one in self.waves:
            total -= laws_of(one).force_at(position=position)
        return self.gain * total

    def place(self, position: FloatArray) -> FloatArray:
        """Return the drive's position p at x."""
        return self.direction * (position - self.zero)

    def axis_position(self, place: FloatArray) -> FloatArray:
        """Return x at the drive's position p."""
        return self.zero + self.direction * place

    def ends(self, span: float) -> tuple[float, float]:
        """Return the compared motion, x: one turn, the travel, or MANY_SPANS of the table."""
        if self.turn > 0.0:
            return self.zero, self.zero + self.turn
        return (self.low, self.high) if self.bounded else (self.zero, self.zero + MANY_SPANS * span)

    def compared(self, span: float) -> FloatArray:
        """Return positions x of that motion, uniform within each entry, (n,)."""
        low, high = self.ends(span)
        share = np.mod(GOLDEN * np.arange(1, POSITIONS + 1), 1.0)
        return np.asarray(low + (high - low) * share, dtype=np.float64)

    def misfits(self, span: float) -> list[float]:
        """Return the periods of the map that do not divide the span of a table."""
        times = span / self.periods
        return [float(p) for p, n in zip(self.periods, times, strict=True) if abs(n - round(n)) > 1e-6 * n or n < 0.5]


def frame_of(
    model: Model,
    unit: str,
    *,
    scale: float | None = None,
    sign: int = 1,
    zero: float = 0.0,
    reverse: bool = False,
    turn: float | None = None,
) -> Frame:
    """Return the map of a model in the position and unit of a drive; options: see Frame.

    scale: None if the units are the same; turn: None for 2 pi if the position is in rad, else a linear axis. Raises
    ValueError for no map, one that is zero or does not close over a turn, another unit, or an option out of range.
    """
    known = [one.resolved(model.axis, model.cogging) for one in model.effects]
    waves = tuple(one for one in known if isinstance(one, CoggingEffect))
    if model.cogging is None and not waves:
        raise ValueError("cogging: must be given to export a map, got a model without [cogging]")
    sizes = [] if model.cogging is None else [model.cogging.coefficients]
    if not any(np.any(size) for size in (*sizes, *(value for one in waves for value in (one.sine, one.cosine)))):
        raise ValueError("cogging: must have an amplitude other than 0, got a map without any: nothing to compensate")
    if sign not in (1, -1):
        raise ValueError(f"sign: must be 1 or -1, got {quoted(sign)}")
    if not math.isfinite(zero):
        raise ValueError(f"zero: must be finite, got {quoted(zero)}")
    if turn is None:
        turn = 2.0 * math.pi if model.units.position == "rad" else 0.0
    if turn < 0.0 or not math.isfinite(turn):
        raise ValueError(f"turn: must be finite and at least 0, got {quoted(turn)}")
    stated = model.units.command
    if scale is None and stated not in ("V", unit):  # V stands for whatever the amplifier takes
        raise ValueError(f"scale: must be given, {unit} per {stated}: the drive takes {unit}, got a model in {stated}")
    factor = 1.0 if scale is None else scale
    if not (math.isfinite(factor) and factor > 0.0):
        raise ValueError(f"scale: must be finite and above 0 (see sign), got {quoted(factor)}")
    others = (*OF_SPEED, CoggingEffect, effects.DisturbanceStep, effects.DisturbanceTone)
    by_position = [one for one in known if not isinstance(one, others) and {"force", "command_gain"} & set(one.HOOKS)]
    left_out = tuple(one.NAME for one in by_position)
    direction, is_stated = -1 if reverse else 1, scale is not None or stated == unit
    low, high = model.axis.travel
    frame = Frame(model.cogging, waves, left_out, direction, sign, factor, zero, low, high, turn, is_stated)
    for period in frame.periods if turn else ():
        times = turn / period
        if times < 0.5 or abs(times - round(times)) > CLOSES:
            rule = f"must be a whole number of times each period of the map, here {period:.6g}"
            raise ValueError(f"turn: {rule}, got {turn:.6g}: {times:.4g} times")
    return frame


@dataclass(frozen=True)
class Law:
    """How a drive reads its table at its position."""

    entries: int  # n
    start: float  # the drive's position p at the first entry
    span: float  # range of p
    wraps: bool  # whether the table repeats; otherwise the drive adds nothing outside
    between: str  # "linear" interpolation, entry i at start + i step, or "hold" until the next entry

    @property
    def step(self) -> float:
        """Distance of entries; a linear table that does not wrap has entries at both ends."""
        return self.span / (self.entries - (self.between == "linear" and not self.wraps))

    @property
    def places(self) -> FloatArray:
        """Positions at which entries are taken from the map: of the entries, or the middle of each hold, (n,)."""
        count = np.arange(self.entries, dtype=np.float64) + 0.5 * (self.between == "hold")
        return np.asarray(self.start + count * self.step, dtype=np.float64)

    def read(self, values: FloatArray, place: FloatArray) -> FloatArray:
        """Return what the drive adds at its positions p, (m,), for entries of these values, (n,)."""
        count = (place - self.start) / self.step
        whole = np.floor(count).astype(np.int64)
        if self.wraps:
            inside = np.ones(count.shape, dtype=np.bool_)
            first, behind = whole % self.entries, (whole + 1) % self.entries
        else:
            inside = (place >= self.start) & (place <= self.start + self.span)
            first, behind = (np.clip(whole + more, 0, self.entries - 1) for more in (0, 1))
        line = 0.0 if self.between == "hold" else (count - whole) * (values[behind] - values[first])
        return np.asarray(np.where(inside, values[first] + line, 0.0), dtype=np.float64)


@dataclass(frozen=True)
class Rest:
    """What a drive leaves of the cogging, rms in the model's command unit."""

    cogging: float  # of F_cogging itself
    left: float  # F_cogging minus the compensation
    span: float = 0.0  # the part that differs between spans of the table, which no entry can remove
    entries: float = 0.0  # the rest, due to interpolation and quantisation of entries

    @property
    def removed(self) -> float:
        """Removed share of the cogging's rms: 1 - left / cogging."""
        return 1.0 - self.left / self.cogging if self.cogging > 0.0 else 0.0


@dataclass(frozen=True)
class Table:
    """Entries as stored in the drive."""

    frame: Frame  # of the drive
    law: Law  # how it reads them
    values: FloatArray  # rounded, in its unit, (n,)
    quantum: float | None  # of an entry, in its unit; 0 = 24-bit numbers; None = 53-bit
    rest: Rest = field(compare=False)  # what it leaves of the cogging


def table_of(frame: Frame, law: Law, *, quantum: float | None = 0.0, steps: int = 0) -> Table:
    """Return a table of the map: each entry is the mean over all spans of the motion.

    quantum: see Table; steps: for entries that are integers from -steps to steps times a 24-bit factor; 0 = others.
    """
    values = folded(frame, law, law.places)
    if steps:
        quantum = float(np.float32(np.abs(values).max(initial=0.0) / steps)) or 1.0
    if quantum == 0.0:
        with np.errstate(over="ignore"):
            values = values.astype(np.float32).astype(np.float64)
    elif quantum is not None:
        values = quantum * np.round(values / quantum)
    if not np.isfinite(values).all():
        raise ValueError(f"scale: must keep entries within 32-bit numbers, got {frame.scale:g} for this map")
    x, gain = frame.compared(law.span), abs(frame.gain)
    place, wanted = frame.place(x), frame.wanted(x)
    left = wanted - law.read(values, place)
    first = law.start + np.mod(place - law.start, law.span) if law.wraps else place
    best = folded(frame, law, first) if _repeats(frame, law) else wanted
    parts = (wanted, left, wanted - best, left - (wanted - best))
    return Table(frame, law, values, quantum, Rest(*(float(np.sqrt(np.mean(part**2))) / gain for part in parts)))


def folded(frame: Frame, law: Law, places: FloatArray) -> FloatArray:
    """Return the ideal compensation at positions p, the mean over all spans of the motion, (n,)."""
    if not _repeats(frame, law):
        return frame.wanted(frame.axis_position(places))
    low, high = np.sort(frame.place(np.array(frame.ends(law.span))))
    first, last = np.floor((low - law.start) / law.span), np.ceil((high - law.start) / law.span)
    total, met = np.zeros(places.shape), np.zeros(places.shape)
    for turn in np.unique(np.round(np.linspace(first, last, int(min(last - first + 1.0, MOST_SPANS))))):
        at = places + turn * law.span
        inside = (at >= low) & (at <= high)
        total += np.where(inside, frame.wanted(frame.axis_position(at)), 0.0)
        met += inside
    # An entry beyond an end of the motion continues that end.
    nearest = places + law.span * np.round((0.5 * (low + high) - places) / law.span)
    return np.where(met > 0, total / np.maximum(met, 1.0), frame.wanted(frame.axis_position(nearest)))


def _repeats(frame: Frame, law: Law) -> bool:
    """Return whether the motion reaches an entry at several positions, or outside the first span."""
    if not law.wraps:
        return False
    if frame.turn > 0.0:
        return law.span < 0.999 * frame.turn
    return frame.bounded or frame.modulated or bool(frame.misfits(law.span))
