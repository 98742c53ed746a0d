"""What the header and the numbers of a column say about its quantity and unit."""

from __future__ import annotations

import math
import re
from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from cogging.arrays import FloatArray
from cogging.files import shipped_toml
from cogging.logs.readers.column_request import FACTORS, SPELLINGS, TIME_FACTORS, bracketed, split_unit

#: Names by quantity, the most specific first.
WORDS: dict[str, list[str]] = shipped_toml("first_model/column_names.toml")
#: Factors to SI of units of position, time and command, and the label of the command's unit.
LENGTHS = {**dict.fromkeys(SPELLINGS["m"][:5], 1.0), "micron": 1e-6, "microns": 1e-6, "inch": 0.0254}
ANGLES = {"rad": 1.0, "mrad": 1e-3, "deg": math.pi / 180.0, "°": math.pi / 180.0, "grad": math.pi / 180.0}
ANGLES |= dict.fromkeys(("rev", "revs", "turn", "turns", "u"), 2.0 * math.pi)
LENGTHS |= {unit: factor for unit, factor in FACTORS.items() if unit not in ANGLES}
COUNTS = ("counts", "count", "cnt", "cnts", "inc", "incs", "inkr", "inkremente", "ticks", "steps", "lsb")
TIMES = TIME_FACTORS | dict.fromkeys((*SPELLINGS["s"], "sek", "sekunden"), 1.0) | {"msec": 1e-3, "usec": 1e-6}
COMMANDS = {"V": (1.0, "V"), "A": (1.0, "A"), "N": (1.0, "N"), "Nm": (1.0, "Nm"), "mV": (1e-3, "V"), "mA": (1e-3, "A")}
COMMANDS |= {"mN": (1e-3, "N"), "kN": (1e3, "N"), "kA": (1e3, "A"), "mNm": (1e-3, "Nm"), "%": (1.0, "%")}
COMMANDS |= {"volt": (1.0, "V"), "volts": (1.0, "V"), "ampere": (1.0, "A"), "amps": (1.0, "A"), "newton": (1.0, "N")}
COMMANDS |= {"Arms": (1.0, "Arms"), "Apk": (1.0, "Apk"), "amp": (1.0, "A"), "lbf": (4.4482216, "N")}
TORQUES = ("Nm", "mNm")
#: A unit after a name without brackets: `x_mm`, `x / mm`, `x, mm`, `x in mm`, `x mm`.
BEHIND = re.compile(r"(.+?)(?:\s*/\s*|\s*,\s*|\s+in\s+|[\s_.-]+)([^\s_/,()\[\]]+)")
REFERENCE_OF = {"position": "reference"} | {one: f"reference_{one}" for one in ("velocity", "acceleration")}
LONGEST = 200  # characters of a name that is searched for a unit, in quadratic time
#: Parts of a name that mean a rotary axis: a torque, an angle.
TORQUE = re.compile(r"(?:(?:^|_)tau|torque|moment)\d*(?:_|$)")
ANGLE = re.compile(r"(?:(?:^|_)(?:theta|phi)|angle|winkel)\d*(?:_|$)")
RATES = re.compile(r"(?:.+/(?:s|sec|min|s\^?2|s²)|rpm|1/min|U/min|Hz)", re.IGNORECASE)
STATED, LIKELY, UNKNOWN = "stated", "likely", "cannot tell"
#: Largest step between rows and the unit in which it is a usual rate: 50 Hz to 50 kHz.
STEPS = ((0.02, 1.0, "s"), (20.0, 1e-3, "ms"), (math.inf, 1e-6, "us"))
#: Ranges of travel, speed and acceleration of axes in m or rad, m/s, m/s^2 (assumed, from stages to gantries and from
#: joints to spindles), and typical values.
RANGES = {"m": ((2e-4, 6.0), (2e-4, 8.0), (1e-3, 300.0)), "rad": ((1e-3, 1e4), (1e-3, 1e3), (1e-2, 1e5))}
USUAL = {"m": (0.2, 0.3, 5.0), "rad": (3.0, 5.0, 50.0)}
TRIED = {"m": {"m": 1.0, "mm": 1e-3, "um": 1e-6}, "rad": {"rad": 1.0, "deg": math.pi / 180.0}}
COUNT = 1e-6  # m or rad, assumed for an encoder count of unknown size
MANY = 1000  # span from which whole numbers are counts


@dataclass(frozen=True)
class Unit:
    """The unit of a column."""

    factor: float  # to the unit of the log
    label: str  # of the unit of the log: s, m, rad, V, A, ...
    reason: str  # why, in words
    sure: str  # STATED (in the header), LIKELY or UNKNOWN


@dataclass(frozen=True)
class Header:
    """Quantity and unit in the header of a column."""

    label: str  # the whole text
    bare: str  # the name without its unit
    unit: str  # as written, or ""
    kind: str  # quantity, a key of WORDS, or ""
    rank: int  # 0 for the most specific name, larger for others

    @property
    def kind_of_unit(self) -> str:
        """The quantity by the unit if the name is unknown: position, command, or ""."""
        if self.kind or not self.unit:
            return ""
        return "command" if self.unit in COMMANDS else "" if self.is_angle is None else "position"

    @property
    def is_torque(self) -> bool:
        """Whether it is a torque by its unit, or else by its name."""
        return self.unit in TORQUES or (not self.unit and TORQUE.search(_plain(self.bare)) is not None)

    @property
    def is_angle(self) -> bool | None:
        """Whether it is an angle by its unit, or else by its name; None: unknown."""
        for known, angle in ((LENGTHS, False), (ANGLES, True)):
            if self.unit in known or self.unit.lower() in known:
                return angle
        return True if ANGLE.search(_plain(self.bare)) else None

    def _stated(self, factors: Mapping[str, float], label: str) -> Unit | None:
        factor = factors.get(self.unit, factors.get(self.unit.lower()))
        return None if factor is None else Unit(factor, label, f"in {self.unit} as its header says", STATED)

    def unit_of_time(self, time: FloatArray) -> Unit:
        """The unit of a time: as stated, else the one that gives a usual rate."""
        if (stated := self._stated(TIMES, "s")) is not None:
            return stated
        step = float(np.median(np.diff(time))) if len(time) > 1 else 0.0
        factor, unit = next((factor, unit) for most, factor, unit in STEPS if step < most)
        rate = 1.0 / (step * factor) if step > 0.0 else math.inf
        said = f"in {unit}: its rows are {step:.4g} apart, {rate:.4g} Hz if so"
        if step == 1.0:
            return Unit(factor, "s", f"{said}; it may be the number of the row, then give 1 / rate", UNKNOWN)
        return Unit(factor, "s", said, LIKELY)

    def turns_with(self, command: Header) -> bool:
        """Whether the axis of this position is rotary, by the unit, else by a torque."""
        return command.is_torque if self.is_angle is None else self.is_angle

    def unit_of_command(self, turns: bool) -> Unit:
        """The unit of a command, as stated; numbers do not show it."""
        known = COMMANDS.get(self.unit) or COMMANDS.get(self.unit.lower())
        if known is not None:
            return Unit(known[0], known[1], f"in {self.unit} as its header says", STATED)
        label = "Nm" if turns and self.is_torque else "V"
        return Unit(1.0, label, f"its unit is not stated: assumed to be {label}, edit [units]", UNKNOWN)

    def stated_unit(self) -> Unit | None:
        """The unit of a position that its header states."""
        return self._stated(LENGTHS, "m") or self._stated(ANGLES, "rad")

    def unit_of_position(self, time: FloatArray, position: FloatArray, turns: bool) -> Unit:
        """The unit of a position: as stated, else the one with plausible travel, speed and acceleration."""
        stated, label = self.stated_unit(), "rad" if turns else "m"
        if stated is not None:
            return stated
        motion, tried = motion_of(time, position), TRIED[label]
        if self.unit.lower() in COUNTS or (motion[0] > MANY and np.array_equal(position, np.round(position))):
            reason = f"in counts of an encoder of unknown size: 1e-06 {label} assumed, give its own"
            return Unit(COUNT, label, reason, UNKNOWN)
        sizes = {unit: [max(factor * value, 1e-300) for value in motion] for unit, factor in tried.items()}
        within = {u: [a <= x <= b for x, (a, b) in zip(one, RANGES[label], strict=True)] for u, one in sizes.items()}
        fitting = [unit for unit, good in within.items() if all(good)]
        if self.label == "position" and label in fitting:
            beside = " beside a torque or as an angle" * turns
            said = f"in {label}, as a log of this name has it{beside}; give a factor if it is not"
            return Unit(1.0, label, said, LIKELY)
        unit = min(fitting or tried, key=lambda u: np.sum(np.log(np.divide(sizes[u], USUAL[label])) ** 2))
        factor, (travel, speed, _) = tried[unit], sizes[unit]
        said = f"in {unit}: it then spans {travel:.3g} {label} at up to {speed:.3g} {label}/s"
        if not fitting:
            none = f"its span of {motion[0]:.4g} fits an axis in none of {', '.join(tried)}"
            return Unit(1.0, label, f"taken as {label}: {none}", UNKNOWN)
        if len(fitting) > 1:
            others = " or ".join(other for other in fitting if other != unit)
            angle = "" if turns else ", and rad where it turns"
            return Unit(factor, label, f"taken {said}; {others} would do as well{angle}", UNKNOWN)
        return Unit(factor, label, said if turns else f"{said}; if it turns, its unit may be rad or degrees", LIKELY)


def header_of(label: str, apart: str = "") -> Header:
    """Parse a column's header, with a unit that the file states apart from it."""
    bare, unit = split_unit(label)
    unit = unit or apart.strip()
    if not unit:
        bare, unit = _behind(label)
    name, inside, _ = bracketed(label)
    if not unit and name and _is_unit(inside):
        bare, unit = name, inside
    kind, rank = _kind(bare)
    if kind in ("position", "reference") and RATES.fullmatch(unit):  # `x [mm/s]`
        kind = "velocity" if kind == "position" else "reference_velocity"
    return Header(label, bare.strip(), unit, kind, rank)


def _behind(label: str) -> tuple[str, str]:
    """Split a name and a unit without brackets."""
    found = BEHIND.fullmatch(label.strip()) if len(label) <= LONGEST else None
    if found is None or not _is_unit(found.group(2)):
        return label, ""
    alone = found.group(2) in ("u", "h", "in", "f", "A", "V", "N", "m", "s", "U", "min")
    named = _kind(found.group(1))[0]
    right = {"time": set(TIMES), "command": set(COMMANDS)}.get(named, {*LENGTHS, *ANGLES, *COUNTS})
    if (alone and not named) or (named and found.group(2) not in right and not RATES.fullmatch(found.group(2))):
        return label, ""  # `joint u`, `x_A`: part of the name
    return found.group(1), found.group(2)


def _is_unit(text: str) -> bool:
    return any(text in known or text.lower() in known for known in (LENGTHS, ANGLES, COUNTS, TIMES)) or (
        text in COMMANDS or RATES.fullmatch(text) is not None
    )


def _plain(bare: str) -> str:
    """A name in small letters, its parts joined by underscores."""
    return "_".join(re.findall(r"[a-zäöüß0-9]+", re.sub(r"(?<=[a-z])(?=[A-Z])", "_", bare.strip()).lower()))


def _kind(bare: str) -> tuple[str, int]:
    """The quantity of a name, and its rank."""
    plain = _plain(bare)
    for kind, words in WORDS.items():
        for form in (plain, plain.replace("_", "")):
            if form in words:
                return kind, words.index(form)
    parts, longest = set(plain.split("_")), dict[str, int]()  # known words that the name holds
    for kind, words in WORDS.items():
        inside = [w for w in words if len(w) > 3 and (w in plain or set(w.split("_")) <= parts)]
        longest[kind] = max(map(len, inside), default=0)
    best = max(longest, key=lambda kind: longest[kind])
    if not longest[best]:  # the first part of a short name: `x_axis1`, `iq_filtered`
        first = plain.split("_")[0]
        short = [(kind, 60 + words.index(first)) for kind, words in WORDS.items() if first in words]
        return short[0] if short and len(parts) > 1 else ("", 0)
    is_reference = parts & {"ref", "reference", "soll", "setpoint", "demand", "target", "cmd", "sollwert"}
    return (REFERENCE_OF.get(best, best) if is_reference else best), 100 - longest[best]


def motion_of(time: FloatArray, position: FloatArray) -> tuple[float, float, float]:
    """Travel, top speed and acceleration of a position in its own unit, roughly."""
    if len(time) < 8:
        return float(np.ptp(position)), 0.0, 0.0
    span = max(1, len(time) // 500)
    t, x = time[::span], position[::span]
    speed = np.diff(x) / np.diff(t)
    acceleration = np.diff(speed) / np.diff(0.5 * (t[1:] + t[:-1]))
    speed_most, acceleration_most = (float(np.quantile(np.abs(one), 0.98)) for one in (speed, acceleration))
    return float(np.ptp(position)), speed_most, acceleration_most
