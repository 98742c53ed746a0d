"""In which units a log's columns are written: as their headers say, or as their numbers suggest."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from cogging.arrays import FloatArray
from cogging.first_model.headers import ANGLES, COMMANDS, COUNTS, LENGTHS, TIMES, Header

STATED, LIKELY, UNKNOWN = "stated", "likely", "cannot tell"
#: From seconds between rows, the unit in which that is a drive's or a logger's rate: 50 Hz to 50 kHz.
STEPS = ((0.02, 1.0, "s"), (20.0, 1e-3, "ms"), (math.inf, 1e-6, "us"))
#: What axes do: travel, speed, acceleration in m or rad, m/s, m/s^2. An assumption on machines, wide enough for stages
#: and for gantries, for joints and for spindles; and in the middle of these.
RANGES = {
    "m": ((2e-4, 6.0), (2e-4, 8.0), (1e-3, 300.0)),
    "rad": ((1e-3, 1e4), (1e-3, 1e3), (1e-2, 1e5)),
}
USUAL = {"m": (0.2, 0.3, 5.0), "rad": (3.0, 5.0, 50.0)}
TRIED = {"m": {"m": 1.0, "mm": 1e-3, "um": 1e-6}, "rad": {"rad": 1.0, "deg": math.pi / 180.0}}
COUNT = 1e-6  # m or rad, assumed of an encoder's count that nothing tells
MANY = 1000  # whole numbers further apart than that are counts


@dataclass(frozen=True)
class Unit:
    """The unit of a column.

    Attributes:
        factor: to the unit of the log.
        label: of the log's unit: s, m, rad, V, A, N, Nm, ...
        told: why, in words.
        sure: STATED (in the header), LIKELY or UNKNOWN.
    """

    factor: float
    label: str
    told: str
    sure: str


def unit_of_time(header: Header, time: FloatArray) -> Unit:
    """The unit of a time: as stated, else that in which the rows come at a usual rate."""
    factor = TIMES.get(header.unit, TIMES.get(header.unit.lower()))
    if factor is not None:
        return Unit(factor, "s", f"in {header.unit} as its header says", STATED)
    step = float(np.median(np.diff(time))) if len(time) > 1 else 0.0
    factor, unit = next((factor, unit) for most, factor, unit in STEPS if step < most)
    rate = 1.0 / (step * factor) if step > 0.0 else math.inf
    said = f"in {unit}: its rows are {step:.4g} apart, {rate:.4g} Hz if so"
    if step == 1.0:
        return Unit(factor, "s", f"{said}; it may be the number of the row, then give 1 / rate", UNKNOWN)
    return Unit(factor, "s", said, LIKELY)


def turning(position: Header, command: Header) -> bool:
    """Whether an axis turns: as the unit of its position says, else as the names and what drives it do."""
    angle = position.is_angle
    return command.is_torque if angle is None else angle


def unit_of_command(header: Header, turns: bool) -> Unit:
    """The unit of a command: as stated; no number tells it."""
    known = COMMANDS.get(header.unit) or COMMANDS.get(header.unit.lower())
    if known is not None:
        return Unit(known[0], known[1], f"in {header.unit} as its header says", STATED)
    label = "Nm" if turns and header.is_torque else "V"
    return Unit(
        1.0, label, f"its unit is not stated and no number tells it: called {label} here, edit [units]", UNKNOWN
    )


def stated_unit(header: Header) -> Unit | None:
    """The unit of a position that its header states."""
    for known, label in ((LENGTHS, "m"), (ANGLES, "rad")):
        factor = known.get(header.unit, known.get(header.unit.lower()))
        if factor is not None:
            return Unit(factor, label, f"in {header.unit} as its header says", STATED)
    return None


def unit_of_position(header: Header, time: FloatArray, position: FloatArray, turns: bool) -> Unit:
    """The unit of a position: as stated, else that in which travel, speed and acceleration are those of an axis.

    Args:
        header: of the column.
        time: s, (n,).
        position: as written, (n,).
        turns: whether it is an angle.
    """
    stated, label = stated_unit(header), "rad" if turns else "m"
    if stated is not None:
        return stated
    motion, tried = motion_of(time, position), TRIED[label]
    if header.unit.lower() in COUNTS or (motion[0] > MANY and np.array_equal(position, np.round(position))):
        told = f"in counts of an encoder, and how long one is is not told: 1e-06 {label} assumed, give its own"
        return Unit(COUNT, label, told, UNKNOWN)
    fitting = [unit for unit, factor in tried.items() if _plausible(motion, factor, label)]
    if header.label == "position" and label in fitting:
        beside = " beside a torque or as an angle" * turns
        return Unit(1.0, label, f"in {label}, as a log of this name has it{beside}; give a factor if it is not", LIKELY)
    unit = min(fitting or tried, key=lambda unit: _strangeness(motion, tried[unit], label))
    factor = tried[unit]
    travel, speed = factor * motion[0], factor * motion[1]
    said = f"in {unit}: it then spans {travel:.3g} {label} at up to {speed:.3g} {label}/s"
    if not fitting:
        none = f"its span of {motion[0]:.4g} fits an axis in none of {', '.join(tried)}"
        return Unit(1.0, label, f"taken as {label}: {none}", UNKNOWN)
    if len(fitting) > 1:
        others = " or ".join(other for other in fitting if other != unit)
        angle = "" if turns else ", and rad where it turns"
        return Unit(factor, label, f"taken {said}; {others} would do as well{angle}", UNKNOWN)
    return Unit(factor, label, said if turns else f"{said}; if it turns, its unit may be rad or degrees", LIKELY)


def motion_of(time: FloatArray, position: FloatArray) -> tuple[float, float, float]:
    """Travel, top speed and acceleration of a position in its own unit, roughly."""
    if len(time) < 8:
        return float(np.ptp(position)), 0.0, 0.0
    span = max(1, len(time) // 500)
    t, x = time[::span], position[::span]
    speed = np.diff(x) / np.diff(t)
    middle = 0.5 * (t[1:] + t[:-1])
    acceleration = np.diff(speed) / np.diff(middle) if len(speed) > 2 else np.zeros(1)
    sizes = [float(np.quantile(np.abs(values), 0.98)) for values in (speed, acceleration)]
    return float(np.ptp(position)), sizes[0], sizes[1]


def _plausible(motion: tuple[float, float, float], factor: float, label: str) -> bool:
    ranges = zip(motion, RANGES[label], strict=True)
    return all(low <= factor * value <= high for value, (low, high) in ranges)


def _strangeness(motion: tuple[float, float, float], factor: float, label: str) -> float:
    pairs = zip(motion, USUAL[label], strict=True)
    return sum(math.log(max(factor * value, 1e-300) / usual) ** 2 for value, usual in pairs)
