"""Ways in which a log may have been misread, and the log as it would then be."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field

import numpy as np

from cogging.log_check.unit_check import ANGLES, position_units
from cogging.logs.log import Log
from cogging.model.model import Model
from cogging.model.units import Units

TIMES = {1e-3: "ms", 1e-6: "us"}
#: Shares of a model's unit in which a command may be written, by their factor.
COMMANDS = {
    1e-3: "thousandths of the model's unit",
    1e3: "thousands of the model's unit",
    1e-2: "percent",
    1e2: "hundredths of a percent, or a share where the model has percent",
}
WHOLE = 0.98  # of the readings
NEAR, EXACT = 2.5, 1.1  # by which a factor that mass and friction tell, or a controller, may differ from a known one
REFERENCES = ("reference", "reference_velocity", "reference_acceleration")


@dataclass(frozen=True)
class Reading:
    """One way to read a log otherwise than it was.

    Attributes:
        column: whose reading is another.
        kind: sign, scale, swap, derivative or shift.
        factors: by the names of columns.
        renamed: the column that takes the place of another, by the name of that place.
        shift: rows by which the command stands too late, negative: too early.
        said: what is wrong, a clause with the column as its subject.
    """

    column: str
    kind: str
    said: str
    factors: Mapping[str, float] = field(default_factory=dict)
    renamed: Mapping[str, str] = field(default_factory=dict)
    shift: int = 0

    def of(self, log: Log) -> Log:
        """The log as it would be."""
        columns = log.columns()
        columns.update({place: log.columns()[column] for place, column in self.renamed.items()})
        if self.kind == "derivative":
            steps = np.diff(log.time, append=log.time[-1])
            moved = 0.5 * (log.position + np.append(log.position[1:], log.position[-1])) * steps
            columns["position"] = np.concatenate([[0.0], np.cumsum(moved)[:-1]])
        for name, factor in self.factors.items():
            if name in columns:
                columns[name] = factor * columns[name]
        if self.shift:
            late, rows = abs(self.shift), len(log)
            early, last = slice(0, rows - late), slice(late, rows)
            kept, command = (early, last) if self.shift > 0 else (last, early)
            columns = {name: column[command if name == "command" else kept] for name, column in columns.items()}
        return Log.of(columns)

    def option(self, log: Log, prefixes: Sequence[str] = ("",)) -> str:
        """What to give on the command line, for some logs by the prefix of each, or "" where no option does it."""
        pairs, name = [], ""
        if self.factors:
            name = "--scale "
            pairs = [f"{column}={factor:.6g}" for column, factor in self.factors.items() if column in log.columns()]
        elif self.renamed:
            name = "--columns "
            pairs = [f"{place}={column}" for place, column in self.renamed.items()]
        return name + ",".join(prefix + pair for prefix in prefixes for pair in pairs)

    def advice(self, option: str) -> str:
        """What to do."""
        if self.factors:
            return f"give {option} (times what was given there before)"
        if self.renamed:
            return f"give {option} (or the other way round what was given there before)"
        if self.shift:
            way = "up" if self.shift > 0 else "down"
            return f"move the column {abs(self.shift)} rows {way} against the others, in the file or in Python"
        if self.kind == "derivative":
            return "name the column of the position with --columns position=NAME, or integrate it over time"
        return "name the column of the encoder with --columns position=NAME"


def signs(log: Log, *, follows: bool) -> list[Reading]:
    """Other signs, the likeliest first; follows: whether the position follows the reference of the log."""
    command = Reading("command", "sign", "has the other sign: it pushes back", {"command": -1.0})
    others = dict.fromkeys(REFERENCES if follows else (), -1.0)
    position = Reading("position", "sign", "has the other sign", {"position": -1.0, **others})
    return [command, position]


def scales(log: Log, model: Model, *, gain: float, mass: float, follows: bool) -> Iterator[Reading]:
    """Other units.

    Args:
        log: as read.
        model: its resolution and rate are those of the encoder and of the controller.
        gain: command that the model asks for, over the logged one.
        mass: mass that the logged motion asks for, over the model's.
        follows: whether the position follows the reference, and would have its unit.
    """
    if gain:
        yield in_unit_of_command(gain, NEAR)
    others = REFERENCES if follows else ()
    lengths = position_units(model.units) | ANGLES
    if whole(log.position):
        resolution = model.encoder.resolution
        known = resolution if resolution not in (0.0, 1.0) else float(f"{mass:.2g}")
        lengths = {known: "counts of the encoder"}
    for factor, unit in lengths.items():
        if 0.0 < factor != 1.0:
            factors = {"position": factor, **dict.fromkeys(others, factor)}
            yield Reading("position", "scale", f"is in {unit}", factors)
    steps = np.diff(log.time)
    if np.allclose(steps, 1.0, atol=1e-9):
        rate = model.controller.sample_rate if model.controller is not None else math.sqrt(mass)
        if rate > 0.0:
            yield Reading("time", "scale", "is the number of the sample", {"time": float(f"{1.0 / rate:.3g}")})
    else:
        for factor, unit in TIMES.items():
            yield Reading("time", "scale", f"is in {unit}", {"time": factor})


def in_unit_of_command(gain: float, near: float = EXACT) -> Reading:
    """A command in a unit of which one is `gain` of the model's: a known one, where it is within a factor of it."""
    known = min(COMMANDS, key=lambda factor: abs(math.log(factor / abs(gain))))
    if abs(math.log(known / abs(gain))) < math.log(near):
        factor = math.copysign(known, gain)
        return Reading("command", "scale", f"is in {COMMANDS[known]}", {"command": factor})
    factor = float(f"{gain:.{2 if near > EXACT else 4}g}")
    return Reading("command", "scale", f"is in a unit that is {factor:g} of the model's", {"command": factor})


def in_unit_of_length(factor: float, others: Sequence[str], units: Units) -> Reading:
    """Positions, and other columns, in a unit of which one is so many of the model's."""
    lengths = position_units(units) | ANGLES
    known = min(lengths, key=lambda length: abs(math.log(length / factor)))
    near = abs(math.log(known / factor)) < math.log(EXACT)
    factor = known if near else float(f"{factor:.4g}")
    said = f"is in {lengths[known]}" if near else f"is in a unit of {factor:g} {units.position}"
    return Reading("position", "scale", said, {"position": factor, **dict.fromkeys(others, factor)})


def whole(position: np.ndarray) -> bool:
    """Whether readings, but for a few that were put between others, are whole numbers."""
    return bool(np.ptp(position) > 10.0 and np.mean(position == np.round(position)) > WHOLE)


def moved(rows: int, log: Log) -> Reading:
    """A command that stands so many rows too late or, negative, too early."""
    step, way = float(np.median(np.diff(log.time))), "late" if rows > 0 else "early"
    said = f"stands {abs(rows)} row{'s' * (abs(rows) != 1)} ({abs(rows) * step:.3g} s) too {way}"
    return Reading("command", "shift", said, shift=rows)
