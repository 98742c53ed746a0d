"""A table of compensation values and the law by which a drive reads it, compared with the map that it was made of."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np

from cogging.arrays import FloatArray
from cogging.export.drive_frame import Frame, ends, looked_at
from cogging.shown import quoted

BETWEEN = ("linear", "hold")
MOST_SPANS = 100  # that a mean is taken over: of a longer motion so many, evenly spread
ALONE = 1e-12  # of the map's rms: below it a rest is none


@dataclass(frozen=True)
class Law:
    """How a drive turns its position into an entry.

    Attributes:
        entries: n.
        start: the drive's position p where the table begins.
        span: of p that the table covers.
        wraps: whether it repeats; else the drive adds nothing outside.
        between: "linear": straight lines between entries, i at start + i step; "hold": entry i from there to the next.
    """

    entries: int
    start: float
    span: float
    wraps: bool
    between: str

    def __post_init__(self) -> None:
        if self.between not in BETWEEN:
            raise ValueError(f"between: must be one of {', '.join(BETWEEN)}, got {quoted(self.between)}")

    @property
    def step(self) -> float:
        """From entry to entry; lines that do not wrap have an entry at both ends."""
        return self.span / (self.entries - (self.between == "linear" and not self.wraps))

    @property
    def places(self) -> FloatArray:
        """Where the entries are taken from the map: their own places, or the middle of what each holds for, (n,)."""
        count = np.arange(self.entries, dtype=np.float64) + 0.5 * (self.between == "hold")
        return np.asarray(self.start + count * self.step, dtype=np.float64)

    def read(self, values: FloatArray, place: FloatArray) -> FloatArray:
        """What the drive adds at its position p, in its unit.

        Args:
            values: of the entries, (n,).
            place: p, (m,).
        """
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
    """What a drive leaves of the cogging, rms over the positions looked at, in the model's command unit.

    Attributes:
        cogging: of F_cogging itself.
        left: F_cogging less what the drive adds.
        span: the part that is not the same in every span of the table: no entry could remove it.
        entries: the rest: between entries, and of their quantum.
    """

    cogging: float
    left: float
    span: float
    entries: float

    @property
    def removed(self) -> float:
        """Share of the cogging's rms that is gone: 1 - left / cogging."""
        return 1.0 - self.left / self.cogging if self.cogging > 0.0 else 0.0


@dataclass(frozen=True)
class Table:
    """Entries as the drive keeps them.

    Attributes:
        frame: how it sees the axis.
        law: how it reads them.
        values: in its unit, as rounded, (n,).
        quantum: of an entry, its unit; 0 = 24 bits of a number; None = 53.
        rest: what it leaves of the cogging.
    """

    frame: Frame
    law: Law
    values: FloatArray
    quantum: float | None
    rest: Rest = field(compare=False)


def table_of(frame: Frame, law: Law, *, quantum: float | None = 0.0, steps: int = 0) -> Table:
    """Fill a table from the map: in each entry the mean of what the map wants there, span by span of the motion.

    Args:
        frame: how the drive sees the axis.
        law: how it reads its table.
        quantum: of an entry, in the drive's unit; 0 = rounded to 24 bits; None = not rounded.
        steps: where entries are whole numbers from -steps to steps and a factor of 24 bits: that number.
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
    return Table(frame, law, values, quantum, rest_of(frame, law, values))


def folded(frame: Frame, law: Law, places: FloatArray) -> FloatArray:
    """What the drive should add at its positions, the mean over all spans that the motion meets, (n,)."""
    if not _repeats(frame, law):
        return frame.wanted(frame.axis_position(places))
    low, high = np.sort(frame.place(np.array(ends(frame, law.span))))
    first, last = np.floor((low - law.start) / law.span), np.ceil((high - law.start) / law.span)
    total, met = np.zeros(places.shape), np.zeros(places.shape)
    for turn in np.unique(np.round(np.linspace(first, last, int(min(last - first + 1.0, MOST_SPANS))))):
        at = places + turn * law.span
        inside = (at >= low) & (at <= high)
        total += np.where(inside, frame.wanted(frame.axis_position(at)), 0.0)
        met += inside
    # Half an entry may stick out at an end of the motion: it continues that end.
    nearest = places + law.span * np.round((0.5 * (low + high) - places) / law.span)
    return np.where(met > 0, total / np.maximum(met, 1.0), frame.wanted(frame.axis_position(nearest)))


def _repeats(frame: Frame, law: Law) -> bool:
    """Whether the motion meets an entry in more than one place, or elsewhere than in the first span."""
    if not law.wraps:
        return False
    if frame.turn > 0.0:
        return law.span < 0.999 * frame.turn
    return frame.bounded or frame.modulated or bool(misfits(frame, law.span))


def misfits(frame: Frame, span: float) -> list[float]:
    """Periods of the map that do not go into the span of a table a whole number of times."""
    times = span / frame.periods
    return [float(p) for p, n in zip(frame.periods, times, strict=True) if abs(n - round(n)) > 1e-6 * n or n < 0.5]


def rest_of(frame: Frame, law: Law, values: FloatArray) -> Rest:
    """What the drive leaves of the map, by its own law."""
    x = looked_at(frame, law.span)
    place = frame.place(x)
    wanted = frame.wanted(x)
    left = wanted - law.read(values, place)
    first = law.start + np.mod(place - law.start, law.span) if law.wraps else place
    best = folded(frame, law, first) if _repeats(frame, law) else wanted
    gain = abs(frame.gain)
    return Rest(_rms(wanted) / gain, _rms(left) / gain, _rms(wanted - best) / gain, _rms(left - (wanted - best)) / gain)


def _rms(values: FloatArray) -> float:
    return float(np.sqrt(np.mean(values**2)))
