"""A request to a reader: columns with their names and units in the file, and rows."""

from __future__ import annotations

import math
import os
from collections.abc import Collection, Mapping, Sequence
from dataclasses import dataclass, field

from cogging.files import InputError
from cogging.shown import nearest, printable, shortened

MIB = 1 << 20
COLUMNS = 16384  # most columns of a spreadsheet
SMALL = 256 * MIB  # bytes of numbers that any file may hold
EXPANSION = 256  # further bytes of numbers for each byte of a file; compressed time reaches 50
#: SI units by the last word of a column's name; a column of another name takes the command unit.
SI_UNITS = {"time": "s", "velocity": "m/s", "acceleration": "m/s^2", "position": "m", "reference": "m"}
#: Spellings of units that need no conversion.
SPELLINGS = {
    "s": ("s", "sec", "second", "seconds"),
    "m": ("m", "meter", "meters", "metre", "metres", "rad", "radian", "radians"),
    "m/s": ("m/s", "m s^-1", "m*s^-1", "m·s^-1", "m s-1", "rad/s"),
    "m/s^2": (
        *("m/s^2", "m/s2", "m/s²", "m/s**2", "m s^-2", "m*s^-2", "m·s^-2", "m s-2"),
        *("rad/s^2", "rad/s2", "rad/s²"),
    ),
    "V": ("V", "A", "N", "Nm", "N m", "volt", "volts", "ampere", "amperes", "amp", "amps", "newton", "newtons"),
}
#: Units in messages.
NEEDED = {"s": "s", "m": "m or rad", "m/s": "m/s or rad/s", "m/s^2": "m/s^2 or rad/s^2", "V": "V, A, N or Nm"}
#: Factors that a message proposes.
FACTORS = {"mm": 1e-3, "um": 1e-6, "µm": 1e-6, "μm": 1e-6, "nm": 1e-9, "cm": 1e-2, "km": 1e3, "in": 0.0254}
FACTORS |= {"mrad": 1e-3, "deg": math.pi / 180.0, "°": math.pi / 180.0, "rev": 2.0 * math.pi}
TIME_FACTORS = {"ms": 1e-3, "us": 1e-6, "µs": 1e-6, "μs": 1e-6, "ns": 1e-9, "min": 60.0, "h": 3600.0}
COMMAND_FACTORS = {"mV": 1e-3, "mA": 1e-3, "mN": 1e-3, "kN": 1e3, "kV": 1e3, "kA": 1e3, "mNm": 1e-3}
#: In round brackets only known units are units: a name may have a remark there.
OTHER_UNITS = ("rpm", "%", "counts", "count", "inc", "g")
SQUARED = ("s^2", "s2", "s²")
SHOWN = 40  # columns that a message lists
LONGEST = 80  # characters of a name in a message


def numbers_most(size: int) -> int:
    """Return the bytes of numbers, 8 each, that a file of a size may hold."""
    return SMALL + EXPANSION * size


@dataclass(frozen=True)
class Request:
    """Columns and rows that a reader must deliver."""

    path: str | os.PathLike[str]
    names: Sequence[str]  # required columns
    optional: Sequence[str] = ()  # further columns
    columns: Mapping[str, str] = field(default_factory=dict)  # names in the file by name here
    scaled: Collection[str] = ()  # columns with a factor, which converts a unit other than SI
    rows: slice = field(default_factory=lambda: slice(0, None))  # data rows to read, from 0
    shown: str = ""  # name of the file in messages; `path` if empty
    notes: list[str] = field(default_factory=list)  # of the reader, on the numbers
    survey: list[tuple[str, str]] | None = None  # filled with all names and units instead of choosing columns

    def refuse(self, problem: str) -> InputError:
        """Return the error that names the file, in one line."""
        return InputError(f"{self.shown or self.path}: {printable(problem)}")

    def require_room(self, name: str, rows: int, numbers: float) -> None:
        """Raise InputError if a file states more numbers (of 8 bytes) than one of its size may hold."""
        size = os.path.getsize(self.path)
        if 8 * numbers > numbers_most(size):
            most = numbers_most(size) // 8
            rule = f"must ask for at most {most} numbers in a file of {size} bytes"
            raise self.refuse(f"{name}: {rule}, got {rows} rows, {numbers:.4g} numbers")

    def in_file(self, name: str) -> str:
        """Return the name of a column in the file."""
        return self.columns.get(name, name)

    def choose(self, present: Sequence[str], place: str, units: Sequence[str] | None = None) -> dict[str, int]:
        """Return the index of each column among those of the file.

        A name matches a column's whole text or the part before its unit, `position [mm]`. `units` are those that the
        file states separately. If several columns match, or differ only by case or unit, `columns` must select one.
        """
        if self.survey is not None:
            stated_apart = units or [""] * len(present)
            self.survey.extend((name.strip(), unit.strip()) for name, unit in zip(present, stated_apart, strict=True))
            return {}
        if len(present) > COLUMNS:
            raise self.refuse(f"{place}: must have at most {COLUMNS} columns, got {len(present)}")
        parts = [split_unit(text) for text in present]
        found = {}
        for name in (*self.names, *self.optional):
            there = self.in_file(name)
            whole = [i for i, text in enumerate(present) if text == there]
            places = whole or [i for i, (bare, _) in enumerate(parts) if bare == there]
            if not places:
                if name in self.names or name in self.columns:
                    near = nearest(there, [bare.strip() for bare, _ in parts])
                    raise self.refuse(f"column {there}: must be in the {place}, which has {listed(present)}{near}")
                continue
            if len(whole) > 1:
                raise self.refuse(f"column {there}: must stand once in the {place}, got {len(whole)} of that name")
            alike = [i for i, (bare, _) in enumerate(parts) if bare.strip().casefold() == there.strip().casefold()]
            if len(places) > 1 or (len({*places, *alike}) > 1 and name not in self.columns):
                among = [present[i].strip() for i in sorted({*places, *alike})]
                advice = " or ".join(f'"{name}={shortened(text, LONGEST)}"' for text in among[:2])
                got = f"got {listed(list(map(repr, among)))}: say which, --columns {advice}"
                raise self.refuse(f"column {there}: must be one column of the {place}, {got}")
            found[name] = places[0]
            stated = parts[places[0]][1] or (units[places[0]].strip() if units else "")
            if stated and name not in self.scaled and not is_si(name, stated):
                raise self._not_si(name, there, stated)
        return found

    def _not_si(self, name: str, there: str, unit: str) -> InputError:
        """Return the error for a column in another unit, with the factor to give."""
        wanted = SI_UNITS.get(name.rpartition("_")[2], "V")
        spelled = unit.strip().replace("**", "^")
        factors = {"s": TIME_FACTORS, "V": COMMAND_FACTORS}.get(wanted, FACTORS)
        length, slash, rest = spelled.partition("/")
        factor = factors.get(length)
        if slash and (rest not in ("s", *SQUARED) or wanted not in ("m/s", "m/s^2")):
            factor = None
        advice = f"--scale {name}={factor:g}" if factor else f"--scale {name}=FACTOR, 1 to take it as it is"
        stated = shortened(unit, LONGEST)
        return self.refuse(f"column {there}: must be in {NEEDED[wanted]}, got the unit {stated!r}; give {advice}")


def is_si(name: str, unit: str) -> bool:
    """Return whether a unit of a column needs no conversion."""
    wanted = SI_UNITS.get(name.rpartition("_")[2], "V")
    spelled = unit.strip().replace("**", "^")
    return spelled in SPELLINGS[wanted] or spelled.lower() in SPELLINGS[wanted][1:]


def bracketed(text: str) -> tuple[str, str, str]:
    """Return a name, the text in brackets behind it, and the opening bracket; all empty without brackets.

    Parsed by hand: a regular expression takes the square of the length of a name of blanks.
    """
    whole = text.strip()
    opening = {"]": "[", ")": "("}.get(whole[-1:], "")
    at = whole.find(opening, whole.rfind(whole[-1], 0, -1) + 1) if opening else -1
    name = whole[: max(at, 0)].rstrip()
    return (name, whole[at + 1 : -1].strip(), opening) if name and "\n" not in name else ("", "", "")


def split_unit(text: str) -> tuple[str, str]:
    """Return a column's name and the unit in brackets behind it, or the whole text and ""."""
    name, inside, opening = bracketed(text)
    if not name:
        return text, ""
    if opening == "[":
        return name, inside
    spelled = (unit for spellings in SPELLINGS.values() for unit in spellings)
    rates = (f"{length}/{rest}" for length in FACTORS for rest in ("s", *SQUARED))
    known = (*OTHER_UNITS, *FACTORS, *TIME_FACTORS, *COMMAND_FACTORS, *spelled, *rates)
    return (name, inside) if inside in known else (text, "")


def listed(names: Sequence[str]) -> str:
    """Return names for a message."""
    shown = ", ".join(shortened(name.strip(), LONGEST) for name in names[:SHOWN])
    return (shown or "none") + (f" and {len(names) - SHOWN} more" if len(names) > SHOWN else "")
