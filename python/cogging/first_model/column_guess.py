"""Identify the columns of a log's file by name, else by the behaviour of their numbers."""

from __future__ import annotations

import contextlib
from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from cogging.arrays import FloatArray
from cogging.files import InputError
from cogging.first_model.headers import LIKELY, STATED, TRIED, UNKNOWN, Header, Unit, header_of
from cogging.logs.columns import read_columns, survey_columns
from cogging.logs.readers.column_request import is_si, listed, split_unit
from cogging.model.units import UNIT_KEYS, Units
from cogging.outputs import AnyPath
from cogging.shown import nearest, printable


@dataclass(frozen=True)
class ColumnGuess:
    """One identified column of a file."""

    name: str  # in a log: time, position, command, ...
    label: str  # header in the file
    unit: Unit  # factor to the unit of the log, that unit's label, and how it is known
    reason: str  # why it is this column
    sure: str  # STATED (by its name or the user), LIKELY or UNKNOWN
    called: str  # its name in the option `--columns`; the whole header if the name alone is ambiguous
    scaled: bool  # whether `--scale` is needed, also for a factor of 1

    def text(self) -> str:
        """One line."""
        factor = f" x {self.unit.factor:.6g}" if self.unit.factor != 1.0 else ""
        return f"{self.name} is {printable(self.label)!r}{factor} ({self.reason}); {self.unit.reason}"


@dataclass(frozen=True)
class ColumnGuesses:
    """The identified columns of a file."""

    used: dict[str, ColumnGuess]  # by their names in a log
    unused: tuple[str, ...]  # headers of the others
    notes: tuple[str, ...]  # further remarks

    @property
    def columns(self) -> dict[str, str]:
        """The names for `--columns`."""
        return {name: guess.called for name, guess in self.used.items() if guess.called != name}

    @property
    def scale(self) -> dict[str, float]:
        """The factors for `--scale`."""
        return {name: guess.unit.factor for name, guess in self.used.items() if guess.scaled}


Table = dict[str, FloatArray]
ALIKE = 0.3  # of the position's deviation: largest deviation of a followed reference
FACTORS_OF_DERIVATIVES = (1.0, -1.0, 1e-3, -1e-3, 1e-6, -1e-6, 60.0)
DERIVATIVE = 0.1  # relative difference of a derivative column from the differentiated reference
ROUGHER = 3.0  # ratio of roughness that distinguishes a command from a position
FOLLOWED = 0.99  # correlation of a position with the reference that gives its unit
NEAR = 0.03  # relative distance within which a known factor is assumed
EVEN = 0.5  # relative scatter of the steps of a time column


def guess_columns(
    path: AnyPath, columns: Mapping[str, str], scale: Mapping[str, float], rows: slice | None, units: Units | None
) -> ColumnGuesses:
    """Identify the columns of a log in a file of any format, and their units, beside those that are given.

    InputError: it cannot be read, or time, position or command cannot be identified.
    """
    surveyed = survey_columns(path)
    headers = {label: header_of(label, apart) for label, apart in surveyed}
    labels = [label for label, _ in surveyed]
    table = numbers(path, [label for label in headers if labels.count(label) == 1 and label], rows)
    own = {name: _meant(path, label, headers) for name, label in columns.items()}
    for label in own.values():
        if label not in table:
            read_columns(path, [label], columns={label: label}, scale={label: 1.0}, rows=rows)  # says why
            raise InputError(f"{path}: column {label}: must be named once, and as long as the columns of numbers are")
    file = FileColumns(path, headers, table, scale, units, own)
    taken = {guess.label for guess in file.used.values()}
    for guess in file.used.values():
        others = [repr(h.label) for h in file.of_kind(guess.name) if h.label not in taken]
        if others and guess.name not in own:
            file.notes.append(f"{guess.name} may also be {listed(others)}: say which with --columns")
    return ColumnGuesses(file.used, tuple(label for label in headers if label not in taken), tuple(file.notes))


def numbers(path: AnyPath, labels: Sequence[str], rows: slice | None) -> Table:
    """The numeric columns of the most common length."""
    table: Table = {}
    for some in (labels, *([label] for label in labels)):  # one by one if a text, a scalar or a hole is among them
        with contextlib.suppress(InputError):
            columns, scale = {label: label for label in some}, dict.fromkeys(some, 1.0)
            table |= read_columns(path, some, columns=columns, scale=scale, rows=rows) if some else {}
        if len(table) == len(labels):
            break
    lengths = [len(values) for values in table.values()]
    usual = max(lengths, key=lengths.count, default=0)
    return {label: values for label, values in table.items() if len(values) == usual}


def _meant(path: AnyPath, label: str, headers: Mapping[str, Header]) -> str:
    """The header that a name given by the user refers to."""
    for header in headers.values():
        if label in (header.label, header.bare):
            return header.label
    known = [header.bare for header in headers.values()]
    raise InputError(f"{path}: column {label}: must be in the header, which has {listed(known)}{nearest(label, known)}")


@dataclass
class FileColumns:
    """The columns of a file: time, position, command, and the reference and its derivatives if it is followed."""

    path: AnyPath
    headers: Mapping[str, Header]  # by label
    table: Table
    scale: Mapping[str, float]
    units: Units | None
    own: Mapping[str, str]  # labels that are given, by name

    def __post_init__(self) -> None:
        self.notes: list[str] = []
        #: Label, reason and certainty by name.
        self.found = {name: (label, "as stated", STATED) for name, label in self.own.items()}
        for name in ("time", "position", "command"):
            if name not in self.found:
                self.found[name] = self._identified(name)
        self.used = {name: self._guess(name) for name in ("time", "position", "command")}
        self._add_reference()

    def of_kind(self, kind: str) -> list[Header]:
        """The headers of columns of numbers that are named as a quantity."""
        return [h for h in self.headers.values() if h.kind == kind and h.label in self.table]

    def _placed(self, name: str, header: Header, unit: Unit, reason: str, sure: str) -> ColumnGuess:
        """A guess with its names for the options."""
        others = [_bare(h).casefold() for h in self.headers.values() if h.label != header.label]
        plain = _bare(header)
        is_shared = plain.casefold() in others
        called = name if plain == name and name.casefold() not in others else (header.label if is_shared else plain)
        bracketed = split_unit(header.label)[1] or (header.unit if header.bare == header.label else "")
        scaled = unit.factor != 1.0 or bool(bracketed and not is_si(name, bracketed))
        return ColumnGuess(name, header.label, unit, reason, sure, called.strip(), scaled)

    def _identified(self, name: str) -> tuple[str, str, str]:
        """Label, reason and certainty of time, position or command."""
        taken = {label for label, _, _ in self.found.values()}
        free = [h for h in self.headers.values() if h.label in self.table and h.label not in taken]
        named = [h for h in free if h.kind == name]
        named = [h for h in named if np.ptp(self.table[h.label]) > 0.0] or named
        of_unit = [h for h in free if h.kind_of_unit == name]
        if not named and len(of_unit) == 1:  # the only column with a suitable unit: `q1 [deg]`, `motor 1 [Nm]`
            return of_unit[0].label, "by its unit", LIKELY
        if name == "time":
            named = [h for h in named if _rises(self.table[h.label])] or named
        if named:
            best = min(named, key=lambda header: header.rank)
            return best.label, "by its name", STATED if len(named) == 1 else LIKELY
        behaving = self._by_behaviour(name, [h.label for h in free if not h.kind])
        if behaving is None:
            known = [repr(label) for label in self.headers if label in self.table]
            alike = [h for h in self.headers.values() if h.kind in ("velocity", "error")]
            kinds = [f"{h.label!r} looks like a {h.kind}" for h in alike]
            said = f"; {', '.join(kinds)}" if kinds and name == "position" else ""
            rule = f"column {name}: cannot be identified among {listed(known)}{said}"
            raise InputError(f"{self.path}: {rule}: name it with --columns {name}=NAME")
        return behaving

    def _by_behaviour(self, name: str, free: Sequence[str]) -> tuple[str, str, str] | None:
        """The column without a known name that behaves like a time, a position or a command."""
        if name == "time":
            steps = {label: np.diff(self.table[label]) for label in free if _rises(self.table[label])}
            even = [label for label, one in steps.items() if np.std(one) < EVEN * float(np.median(one))]
            return (even[0], "its numbers rise evenly", LIKELY) if even else None
        moving = [label for label in free if np.ptp(self.table[label]) > 0.0]
        rough = sorted(moving, key=lambda label: _roughness(self.table[label]))
        if len(rough) == 1 and (name == "command" or "command" not in self.found):
            return rough[0], "the only other column that changes", LIKELY
        if len(rough) != 2 or _roughness(self.table[rough[1]]) < ROUGHER * _roughness(self.table[rough[0]]):
            return None
        of_two = (rough[0], "the smoother of two") if name == "position" else (rough[1], "the rougher of two")
        return *of_two, LIKELY

    def _guess(self, name: str) -> ColumnGuess:
        """A column with its unit."""
        label, reason, sure = self.found[name]
        header = self.headers[label]
        turns = self.headers[self.found["position"][0]].turns_with(self.headers[self.found["command"][0]])
        stated = header.stated_unit()
        if name in self.scale:
            usual = {"time": "s", "position": "rad" if turns else "m"}
            in_log = usual.get(name) or header.unit_of_command(turns).label
            in_log = in_log if stated is None or name == "time" else stated.label
            in_log = getattr(self.units, name, in_log)
            unit = Unit(self.scale[name], in_log, f"times {self.scale[name]:g} as stated", STATED)
        elif self.units is not None and name in UNIT_KEYS and label == name:
            unit = Unit(1.0, getattr(self.units, name), "as the model beside the log says", STATED)
        elif name == "time":
            unit = header.unit_of_time(self.table[label])
        elif name == "command":
            unit = header.unit_of_command(turns)
        else:
            of_time = self.found["time"][0]
            time = self.table[of_time]
            second = self.scale["time"] if "time" in self.scale else self.headers[of_time].unit_of_time(time).factor
            unit = header.unit_of_position(time * second, self.table[label], turns)
            if unit.sure != STATED:
                unit = self._unit_by_reference(unit, label)
        return self._placed(name, header, unit, reason, sure)

    def _unit_by_reference(self, unit: Unit, label: str) -> Unit:
        """The unit of a position that follows a reference of stated unit."""
        for header in self.of_kind("reference"):
            stated = header.stated_unit()
            if stated is None:
                continue
            x, r = (one - one.mean() for one in (self.table[label], stated.factor * self.table[header.label]))
            power = float(np.sqrt((x @ x) * (r @ r)))
            if power == 0.0 or abs(float(x @ r)) < FOLLOWED * power:
                continue
            slope = abs(float(x @ r)) / float(x @ x)
            near = (known for known in TRIED.get(stated.label, {}).values() if abs(slope / known - 1.0) < NEAR)
            factor = next(near, float(f"{slope:.4g}"))
            reason = f"times {factor:.4g} it is as long as {printable(header.label)!r}, whose unit is stated"
            return Unit(factor, stated.label, reason, LIKELY)
        return unit

    def _add_reference(self) -> None:
        """Add the reference and its derivatives if the position follows it."""
        position, stated = self.used["position"], self.found.get("reference")
        x = position.unit.factor * self.table[position.label]
        named = sorted(self.of_kind("reference"), key=lambda h: h.rank) if stated is None else [self.headers[stated[0]]]
        for header in named:
            unit, reason = self._unit_of_reference(header, position, x)
            if unit is not None:
                self.used["reference"] = self._placed("reference", header, unit, reason, STATED)
                break
            said = "is named like a reference, but the position does not follow it: not used"
            self.notes.append(f"{header.label!r} {said}")
        else:
            return
        t, x = (guess.unit.factor * self.table[guess.label] for guess in (self.used["time"], self.used["reference"]))
        for name in ("reference_velocity", "reference_acceleration"):
            x = np.gradient(x, t)
            for header in self.of_kind(name)[:1]:
                values, most = self.table[header.label], DERIVATIVE**2 * float(np.mean(x**2))
                factor = next((f for f in FACTORS_OF_DERIVATIVES if float(np.mean((x - f * values) ** 2)) < most), None)
                if factor is None:
                    break
                unit = Unit(factor, "", f"the {'first' if name.endswith('y') else 'second'} derivative of it", LIKELY)
                self.used[name] = self._placed(name, header, unit, "by its name", STATED)

    def _unit_of_reference(self, header: Header, position: ColumnGuess, x: FloatArray) -> tuple[Unit | None, str]:
        """The unit in which the position (m) follows a reference, or None."""
        label, own, values = position.unit.label, header.stated_unit(), self.table[header.label]
        if (factor := self.scale.get("reference")) is not None:
            return Unit(factor, label, f"times {factor:g} as stated", STATED), "as stated"
        factors = [position.unit.factor, *TRIED.get(label, TRIED["m"]).values()] if own is None else [own.factor]
        said = "in the unit in which it is followed" if own is None else own.reason
        for sign, sure in ((1.0, LIKELY if own is None else STATED), (-1.0, UNKNOWN)):
            for factor in dict.fromkeys(factors):
                if float(np.std(x - sign * factor * values)) < ALIKE * float(np.std(x)):
                    reason = f"the position follows it{', with the other sign' if sign < 0.0 else ''}"
                    return Unit(sign * factor, label, said, sure), reason
        return None, ""


def _bare(header: Header) -> str:
    """The name of a column without a unit in brackets."""
    return split_unit(header.label)[0].strip()


def _rises(values: FloatArray) -> bool:
    return bool(len(values) > 1 and np.all(np.diff(values) > 0.0))


def _roughness(values: FloatArray) -> float:
    """Rms of the second differences over the span of a column."""
    return float(np.sqrt(np.mean(np.diff(values, 2) ** 2))) / float(np.ptp(values)) if len(values) > 2 else 0.0
