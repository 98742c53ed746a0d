"""What is asked of a file: which columns, under which names and units, and which rows."""

from __future__ import annotations

import math
import os
from collections.abc import Collection, Mapping, Sequence
from dataclasses import dataclass, field

from cogging.files import InputError
from cogging.shown import nearest, printable, shortened

MIB = 1 << 20
COLUMNS = 16384  # as many as a spreadsheet has
SMALL = 256 * MIB  # bytes of numbers that a small file may ask for
EXPANSION = 256  # bytes of numbers for each byte of a file: packed time that rises has never been seen beyond 50
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
#: What an error asks for.
NEEDED = {"s": "s", "m": "m or rad", "m/s": "m/s or rad/s", "m/s^2": "m/s^2 or rad/s^2", "V": "V, A, N or Nm"}
#: Lengths, angles and times whose factor is known, so that the error can propose it.
FACTORS = {"mm": 1e-3, "um": 1e-6, "µm": 1e-6, "μm": 1e-6, "nm": 1e-9, "cm": 1e-2, "km": 1e3, "in": 0.0254}
FACTORS |= {"mrad": 1e-3, "deg": math.pi / 180.0, "°": math.pi / 180.0, "rev": 2.0 * math.pi}
TIME_FACTORS = {"ms": 1e-3, "us": 1e-6, "µs": 1e-6, "μs": 1e-6, "ns": 1e-9, "min": 60.0, "h": 3600.0}
COMMAND_FACTORS = {"mV": 1e-3, "mA": 1e-3, "mN": 1e-3, "kN": 1e3, "kV": 1e3, "kA": 1e3, "mNm": 1e-3}
#: In round brackets only these are units: a name may have a remark in them.
OTHER_UNITS = ("rpm", "%", "counts", "count", "inc", "g")
SQUARED = ("s^2", "s2", "s²")
SHOWN = 40  # columns that an error lists
LONGEST = 80  # characters of a name in an error


def numbers_most(size: int) -> int:
    """Return the bytes of numbers, 8 each, that a file of so many bytes may ask for."""
    return SMALL + EXPANSION * size


@dataclass(frozen=True)
class Request:
    """Columns and rows that a reader must deliver.

    Attributes:
        path: the file, for what is refused.
        names: columns that must be there.
        optional: columns that may be there.
        columns: what a column is called in the file, by its name here.
        scaled: columns whose factor was given, so that a unit other than SI is converted.
        rows: data rows to take, from 0.
        progress: whether a long reading may show how far it is.
        shown: what the file is called in what is refused; as `path` where empty.
        notes: what a reader found of the file that bears on its numbers, in words.
        survey: filled with all names and units of the file, in place of choosing among them; None: chosen.
    """

    path: str | os.PathLike[str]
    names: Sequence[str]
    optional: Sequence[str] = ()
    columns: Mapping[str, str] = field(default_factory=dict)
    scaled: Collection[str] = ()
    rows: slice = field(default_factory=lambda: slice(0, None))
    progress: bool = True
    shown: str = ""
    notes: list[str] = field(default_factory=list)
    survey: list[tuple[str, str]] | None = None

    def refuse(self, problem: str) -> InputError:
        """Make the error that names the file, on one line whatever the file's names hold."""
        return InputError(f"{self.shown or self.path}: {printable(problem)}")

    def require_room(self, name: str, rows: int, numbers: float) -> None:
        """Refuse what a file asks for beyond its size, before any of it is read.

        Args:
            name: of what asks.
            rows: of it.
            numbers: that they take together, of 8 bytes each.
        """
        size = os.path.getsize(self.path)
        if 8 * numbers > numbers_most(size):
            most = numbers_most(size) // 8
            rule = f"must ask for at most {most} numbers in a file of {size} bytes"
            raise self.refuse(f"{name}: {rule}, got {rows} rows, {numbers:.4g} numbers")

    def in_file(self, name: str) -> str:
        """What a column is called in the file."""
        return self.columns.get(name, name)

    def choose(self, present: Sequence[str], place: str, units: Sequence[str] | None = None) -> dict[str, int]:
        """Find the columns among those that a file has: index by name.

        A name matches a column's whole text or what stands before its unit, `position [mm]`. `units` are those that
        the file states apart from the names. Which of several columns is meant is asked, not guessed, unless `columns`
        says it: those that differ from the name by a unit or by capitals alone may all be meant.
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
                raise self._ask(name, there, [present[i] for i in sorted({*places, *alike})], place)
            found[name] = places[0]
            stated = parts[places[0]][1] or (units[places[0]].strip() if units else "")
            if stated and name not in self.scaled:
                self._require_si(name, there, stated)
        return found

    def _ask(self, name: str, there: str, among: Sequence[str], place: str) -> InputError:
        names = [repr(text.strip()) for text in among]
        advice = " or ".join(f'"{name}={shortened(text.strip(), LONGEST)}"' for text in among[:2])
        return self.refuse(
            f"column {there}: must be one column of the {place}, got {listed(names)}: say which, --columns {advice}"
        )

    def _require_si(self, name: str, there: str, unit: str) -> None:
        wanted = SI_UNITS.get(name.rpartition("_")[2], "V")
        spelled = unit.strip().replace("**", "^")
        if is_si(name, unit):
            return
        factors = {"s": TIME_FACTORS, "V": COMMAND_FACTORS}.get(wanted, FACTORS)
        length, slash, rest = spelled.partition("/")
        factor = factors.get(length)
        if slash and (rest not in ("s", *SQUARED) or wanted not in ("m/s", "m/s^2")):
            factor = None
        advice = f"--scale {name}={factor:g}" if factor else f"--scale {name}=FACTOR, 1 to take it as it is"
        stated = shortened(unit, LONGEST)
        raise self.refuse(f"column {there}: must be in {NEEDED[wanted]}, got the unit {stated!r}; give {advice}")


def is_si(name: str, unit: str) -> bool:
    """Whether a column of a log may be taken as it is in a stated unit."""
    wanted = SI_UNITS.get(name.rpartition("_")[2], "V")
    spelled = unit.strip().replace("**", "^")
    return spelled in SPELLINGS[wanted] or spelled.lower() in SPELLINGS[wanted][1:]


def bracketed(text: str) -> tuple[str, str, str]:
    """A name, what stands in brackets behind it, and the bracket that opens; all empty where there are none.

    By hand, in one pass: a pattern would look at a name of many blanks once for each pair of them, or three.
    """
    whole = text.strip()
    opening = {"]": "[", ")": "("}.get(whole[-1:], "")
    at = whole.find(opening, whole.rfind(whole[-1], 0, -1) + 1) if opening else -1
    name = whole[: max(at, 0)].rstrip()
    return (name, whole[at + 1 : -1].strip(), opening) if name and "\n" not in name else ("", "", "")


def split_unit(text: str) -> tuple[str, str]:
    """Part a column's name from the unit in brackets behind it; ("force (filtered)", "") where there is none."""
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
    """Names as an error shows them."""
    shown = ", ".join(shortened(name.strip(), LONGEST) for name in names[:SHOWN])
    return (shown or "none") + (f" and {len(names) - SHOWN} more" if len(names) > SHOWN else "")
