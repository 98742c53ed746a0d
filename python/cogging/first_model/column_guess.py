"""Identify the columns of a log's file by name, else by the behaviour of their numbers."""

from __future__ import annotations

import contextlib
import os
from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from cogging.arrays import FloatArray
from cogging.files import InputError
from cogging.first_model.headers import (
    LIKELY,
    STATED,
    TRIED,
    UNKNOWN,
    Header,
    Unit,
    header_of,
    stated_unit,
    turning,
    unit_of_command,
    unit_of_position,
    unit_of_time,
)
from cogging.logs.columns import read_columns, survey_columns
from cogging.logs.readers.column_request import is_si, listed, split_unit
from cogging.model.units import UNIT_KEYS, Units
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


def placed(name: str, header: Header, headers: Mapping[str, Header], unit: Unit, reason: str, sure: str) -> ColumnGuess:
    """A guess with its names for the options."""
    alike = [h for h in headers.values() if h.label != header.label and name.casefold() == _bare(h).casefold()]
    plain = _bare(header)
    shared = [h for h in headers.values() if h.label != header.label and _bare(h).casefold() == plain.casefold()]
    called = name if plain == name and not alike and not shared else (header.label if shared else plain)
    bracketed = split_unit(header.label)[1] or (header.unit if header.bare == header.label else "")
    scaled = unit.factor != 1.0 or bool(bracketed and not is_si(name, bracketed))
    return ColumnGuess(name, header.label, unit, reason, sure, called.strip(), scaled)


def _bare(header: Header) -> str:
    """The name of a column without a unit in brackets."""
    return split_unit(header.label)[0].strip()


Table = dict[str, FloatArray]


def numbers(path: str | os.PathLike[str], labels: Sequence[str], rows: slice | None) -> Table:
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


ALIKE = 0.3  # of the position's deviation: largest deviation of a followed reference
FACTORS_OF_DERIVATIVES = (1.0, -1.0, 1e-3, -1e-3, 1e-6, -1e-6, 60.0)
DERIVATIVE = 0.1  # relative difference of a derivative column from the differentiated reference


def references(
    used: dict[str, ColumnGuess],
    found: dict[str, tuple[str, str, str]],
    headers: Mapping[str, Header],
    table: Mapping[str, FloatArray],
    scale: Mapping[str, float],
    notes: list[str],
) -> None:
    """Add the reference and its derivatives if the position follows it."""
    named = sorted((h for h in headers.values() if h.kind == "reference" and h.label in table), key=lambda h: h.rank)
    position = used["position"]
    x = position.unit.factor * table[position.label]
    for header in [headers[found["reference"][0]]] if "reference" in found else named:
        unit, reason = _unit_of_reference(header, position, x, table[header.label], scale)
        if unit is not None:
            used["reference"] = placed("reference", header, headers, unit, reason, STATED)
            break
        notes.append(f"{header.label!r} is named like a reference, but the position does not follow it: not used")
    else:
        return
    reference = used["reference"]
    t = used["time"].unit.factor * table[used["time"].label]
    x = reference.unit.factor * table[reference.label]
    for name in ("reference_velocity", "reference_acceleration"):
        x = np.gradient(x, t)
        named = [h for h in headers.values() if h.kind == name and h.label in table]
        for header in named[:1]:
            values, most = table[header.label], DERIVATIVE**2 * float(np.mean(x**2))
            factor = next((f for f in FACTORS_OF_DERIVATIVES if float(np.mean((x - f * values) ** 2)) < most), None)
            if factor is None:
                break
            unit = Unit(factor, "", f"the {'first' if name.endswith('y') else 'second'} derivative of it", LIKELY)
            used[name] = placed(name, header, headers, unit, "by its name", STATED)


def _unit_of_reference(
    header: Header, position: ColumnGuess, x: FloatArray, values: FloatArray, scale: Mapping[str, float]
) -> tuple[Unit | None, str]:
    """The unit in which the position follows a reference, or None."""
    label, own = position.unit.label, stated_unit(header)
    if "reference" in scale:
        return Unit(scale["reference"], label, f"times {scale['reference']:g} as stated", STATED), "as stated"
    factors = [own.factor] if own is not None else [position.unit.factor, *TRIED.get(label, TRIED["m"]).values()]
    said = "in the unit in which it is followed" if own is None else own.reason
    for sign, sure in ((1.0, LIKELY if own is None else STATED), (-1.0, UNKNOWN)):
        for factor in dict.fromkeys(factors):
            if float(np.std(x - sign * factor * values)) < ALIKE * float(np.std(x)):
                reason = f"the position follows it{', with the other sign' if sign < 0.0 else ''}"
                return Unit(sign * factor, label, said, sure), reason
    return None, ""


ROUGHER = 3.0  # ratio of roughness that distinguishes a command from a position
FOLLOWED = 0.99  # correlation of a position with the reference that gives its unit
NEAR = 0.03  # relative distance within which a known factor is assumed
EVEN = 0.5  # relative scatter of the steps of a time column


def guess_columns(
    path: str | os.PathLike[str],
    columns: Mapping[str, str],
    scale: Mapping[str, float],
    rows: slice | None,
    units: Units | None,
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
    found = {name: (label, "as stated", STATED) for name, label in own.items()}
    _required(path, found, headers, table)
    notes: list[str] = []
    used = {name: _guess(name, headers, table, found, scale, units) for name in ("time", "position", "command")}
    references(used, found, headers, table, scale, notes)
    taken = {guess.label for guess in used.values()}
    for guess in used.values():
        alike = [h.label for h in headers.values() if h.kind == guess.name and h.label in table]
        others = [repr(label) for label in alike if label not in taken]
        if others and guess.name not in own:
            notes.append(f"{guess.name} may also be {listed(others)}: say which with --columns")
    return ColumnGuesses(used, tuple(label for label in headers if label not in taken), tuple(notes))


def _meant(path: str | os.PathLike[str], label: str, headers: Mapping[str, Header]) -> str:
    """The header that a name given by the user refers to."""
    for header in headers.values():
        if label in (header.label, header.bare):
            return header.label
    known = [header.bare for header in headers.values()]
    raise InputError(f"{path}: column {label}: must be in the header, which has {listed(known)}{nearest(label, known)}")


def _required(
    path: str | os.PathLike[str],
    found: dict[str, tuple[str, str, str]],
    headers: Mapping[str, Header],
    table: Table,
) -> None:
    """Add time, position and command: label, reason and certainty."""
    for name in ("time", "position", "command"):
        if name in found:
            continue
        taken = {label for label, _, _ in found.values()}
        free_headers = [h for h in headers.values() if h.label in table and h.label not in taken]
        named = [h for h in free_headers if h.kind == name]
        named = [h for h in named if np.ptp(table[h.label]) > 0.0] or named
        of_unit = [h for h in free_headers if h.kind_of_unit == name]
        if not named and len(of_unit) == 1:  # the only column with a suitable unit: `q1 [deg]`, `motor 1 [Nm]`
            found[name] = (of_unit[0].label, "by its unit", LIKELY)
            continue
        if name == "time":
            named = [h for h in named if _rises(table[h.label])] or named
        if named:
            best = min(named, key=lambda header: header.rank)
            found[name] = (best.label, "by its name", STATED if len(named) == 1 else LIKELY)
            continue
        free = [h.label for h in free_headers if not h.kind]
        behaving = _by_behaviour(name, free, table, found)
        if behaving is None:
            known = [repr(label) for label in headers if label in table]
            kinds = [f"{h.label!r} looks like a {h.kind}" for h in headers.values() if h.kind in ("velocity", "error")]
            said = f"; {', '.join(kinds)}" if kinds and name == "position" else ""
            rule = f"column {name}: cannot be identified among {listed(known)}{said}"
            raise InputError(f"{path}: {rule}: name it with --columns {name}=NAME")
        found[name] = behaving


def _rises(values: FloatArray) -> bool:
    return bool(len(values) > 1 and np.all(np.diff(values) > 0.0))


def _by_behaviour(
    name: str, free: Sequence[str], table: Table, found: Mapping[str, tuple[str, str, str]]
) -> tuple[str, str, str] | None:
    """The column without a known name that behaves like a time, a position or a command."""
    if name == "time":
        for label in free:
            steps = np.diff(table[label])
            if _rises(table[label]) and np.std(steps) < EVEN * float(np.median(steps)):
                return label, "its numbers rise evenly", LIKELY
        return None
    moving = [label for label in free if np.ptp(table[label]) > 0.0]
    rough = sorted(moving, key=lambda label: _roughness(table[label]))
    if len(rough) == 1 and (name == "command" or "command" not in found):
        return rough[0], "the only other column that changes", LIKELY
    if len(rough) != 2 or _roughness(table[rough[1]]) < ROUGHER * _roughness(table[rough[0]]):
        return None
    return (rough[0], "the smoother of two", LIKELY) if name == "position" else (rough[1], "the rougher of two", LIKELY)


def _roughness(values: FloatArray) -> float:
    """Rms of the second differences over the span of a column."""
    return float(np.sqrt(np.mean(np.diff(values, 2) ** 2))) / float(np.ptp(values)) if len(values) > 2 else 0.0


def _guess(
    name: str,
    headers: Mapping[str, Header],
    table: Table,
    found: Mapping[str, tuple[str, str, str]],
    scale: Mapping[str, float],
    units: Units | None,
) -> ColumnGuess:
    """A column with its unit."""
    label, reason, sure = found[name]
    header = headers[label]
    turns = turning(headers[found["position"][0]], headers[found["command"][0]])
    stated = stated_unit(header)
    if name in scale:
        labels = {
            "time": "s",
            "command": unit_of_command(header, turns).label,
            "position": "rad" if turns else "m",
        }
        in_log = getattr(units, name, labels[name] if stated is None or name == "time" else stated.label)
        unit = Unit(scale[name], in_log, f"times {scale[name]:g} as stated", STATED)
    elif units is not None and name in UNIT_KEYS and label == name:
        unit = Unit(1.0, getattr(units, name), "as the model beside the log says", STATED)
    elif name == "time":
        unit = unit_of_time(header, table[label])
    elif name == "command":
        unit = unit_of_command(header, turns)
    else:
        time = table[found["time"][0]]
        second = scale["time"] if "time" in scale else unit_of_time(headers[found["time"][0]], time).factor
        unit = unit_of_position(header, time * second, table[label], turns)
        if unit.sure != STATED:
            unit = _unit_by_reference(unit, headers, table, label)
    return placed(name, header, headers, unit, reason, sure)


def _unit_by_reference(unit: Unit, headers: Mapping[str, Header], table: Table, label: str) -> Unit:
    """The unit of a position that follows a reference of stated unit."""
    for header in headers.values():
        stated = stated_unit(header)
        if header.kind != "reference" or header.label not in table or stated is None:
            continue
        x, r = (values - values.mean() for values in (table[label], stated.factor * table[header.label]))
        power = float(np.sqrt((x @ x) * (r @ r)))
        if power == 0.0 or abs(float(x @ r)) < FOLLOWED * power:
            continue
        slope = abs(float(x @ r)) / float(x @ x)
        near = (known for known in TRIED.get(stated.label, {}).values() if abs(slope / known - 1.0) < NEAR)
        factor = next(near, float(f"{slope:.4g}"))
        reason = f"times {factor:.4g} it is as long as {printable(header.label)!r}, whose unit is stated"
        return Unit(factor, stated.label, reason, LIKELY)
    return unit
