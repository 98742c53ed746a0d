"""Which column of a log's file is what: by its name, else by how its numbers behave."""

from __future__ import annotations

import os
from collections.abc import Mapping, Sequence

import numpy as np

from cogging.arrays import FloatArray
from cogging.files import InputError
from cogging.first_model.column_guess import ColumnGuess, ColumnGuesses, placed
from cogging.first_model.headers import Header, header_of
from cogging.first_model.references import references
from cogging.first_model.table import Table, numbers
from cogging.first_model.units import (
    LIKELY,
    STATED,
    TRIED,
    Unit,
    stated_unit,
    turning,
    unit_of_command,
    unit_of_position,
    unit_of_time,
)
from cogging.logs.columns import read_columns, survey_columns
from cogging.logs.readers.column_request import listed
from cogging.model.units import UNIT_KEYS, Units
from cogging.shown import nearest, printable

ROUGHER = 3.0  # of second differences over the span, from which a command is told from a position
FOLLOWED = 0.99  # correlation of a position with a reference that tells its unit
NEAR = 0.03  # of a known factor, from which that is meant
EVEN = 0.5  # of their median, by which the steps of a time may scatter


def guess_columns(
    path: str | os.PathLike[str],
    columns: Mapping[str, str],
    scale: Mapping[str, float],
    rows: slice | None,
    units: Units | None,
) -> ColumnGuesses:
    """Find the columns of a log in a file of any format, and their units.

    Args:
        path: of the file.
        columns: what its owner says of them, by their names in a log.
        scale: factors that its owner states.
        rows: data rows to take.
        units: that what stands beside the log states; None: nothing.

    Raises:
        InputError: it cannot be read, or which column is time, position or command cannot be told.
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
        others = [
            h.label for h in headers.values() if h.kind == guess.name and h.label in table and h.label not in taken
        ]
        if others and guess.name not in own:
            notes.append(
                f"{guess.name} may also be {listed([repr(label) for label in others])}: say which with --columns"
            )
    return ColumnGuesses(used, tuple(label for label in headers if label not in taken), tuple(notes))


def _meant(path: str | os.PathLike[str], label: str, headers: Mapping[str, Header]) -> str:
    """The header that an owner's name means."""
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
    """Add time, position and command to what is found: label, why and how sure."""
    for name in ("time", "position", "command"):
        if name in found:
            continue
        taken = {label for label, _, _ in found.values()}
        named = [h for h in headers.values() if h.kind == name and h.label in table and h.label not in taken]
        named = [h for h in named if np.ptp(table[h.label]) > 0.0] or named
        if not named:  # one alone of a telling unit: `q1 [deg]`, `motor 1 [Nm]`
            of_unit = [
                h for h in headers.values() if h.kind_of_unit == name and h.label in table and h.label not in taken
            ]
            if len(of_unit) == 1:
                found[name] = (of_unit[0].label, "by its unit", LIKELY)
                continue
        if name == "time":
            named = [h for h in named if _rises(table[h.label])] or named
        if named:
            best = min(named, key=lambda header: header.rank)
            found[name] = (best.label, "by its name", STATED if len(named) == 1 else LIKELY)
            continue
        free = [h.label for h in headers.values() if h.label in table and h.label not in taken and not h.kind]
        behaving = _by_behaviour(name, free, table, found)
        if behaving is None:
            raise _untold(path, name, headers, table)
        found[name] = behaving


def _rises(values: FloatArray) -> bool:
    steps = np.diff(values)
    return bool(len(steps) and np.all(steps > 0.0))


def _by_behaviour(
    name: str, free: Sequence[str], table: Table, found: Mapping[str, tuple[str, str, str]]
) -> tuple[str, str, str] | None:
    """The column of no telling name that behaves as a time, a position or a command does."""
    if name == "time":
        for label in free:
            steps = np.diff(table[label])
            if _rises(table[label]) and np.std(steps) < EVEN * float(np.median(steps)):
                return label, "its numbers rise evenly", LIKELY
        return None
    moving = [label for label in free if np.ptp(table[label]) > 0.0]
    rough = sorted(moving, key=lambda label: _roughness(table[label]))
    if name == "command" and len(rough) == 1:
        return rough[0], "the only other column that changes", LIKELY
    if name == "position" and "command" not in found and len(rough) == 1:
        return rough[0], "the only other column that changes", LIKELY
    if len(rough) != 2 or _roughness(table[rough[1]]) < ROUGHER * _roughness(table[rough[0]]):
        return None
    return (rough[0], "the smoother of two", LIKELY) if name == "position" else (rough[1], "the rougher of two", LIKELY)


def _roughness(values: FloatArray) -> float:
    """Second differences over what a column spans."""
    return float(np.sqrt(np.mean(np.diff(values, 2) ** 2))) / float(np.ptp(values)) if len(values) > 2 else 0.0


def _untold(path: str | os.PathLike[str], name: str, headers: Mapping[str, Header], table: Table) -> InputError:
    numbers = [repr(label) for label in headers if label in table]
    kinds = [f"{h.label!r} looks like a {h.kind}" for h in headers.values() if h.kind in ("velocity", "error")]
    said = f"; {', '.join(kinds)}" if kinds and name == "position" else ""
    rule = f"column {name}: cannot tell which it is of {listed(numbers)}{said}"
    return InputError(f"{path}: {rule}: say it with --columns {name}=NAME")


def _guess(
    name: str,
    headers: Mapping[str, Header],
    table: Table,
    found: Mapping[str, tuple[str, str, str]],
    scale: Mapping[str, float],
    units: Units | None,
) -> ColumnGuess:
    """A column with its unit."""
    label, told, sure = found[name]
    header = headers[label]
    turns = turning(headers[found["position"][0]], headers[found["command"][0]])
    stated = stated_unit(header)
    if name in scale:
        labels = {"time": "s", "command": unit_of_command(header, turns).label, "position": "rad" if turns else "m"}
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
        unit = unit_of_position(header, _time(headers[found["time"][0]], time, scale), table[label], turns)
        if unit.sure != STATED:
            unit = _unit_by_reference(unit, headers, table, label)
    return placed(name, header, headers, unit, told, sure)


def _unit_by_reference(unit: Unit, headers: Mapping[str, Header], table: Table, label: str) -> Unit:
    """The unit of a position that follows a reference whose unit is stated."""
    for header in headers.values():
        if header.kind != "reference" or header.label not in table or not header.unit:
            continue
        stated = stated_unit(header)
        if stated is None:
            continue
        x, r = (values - values.mean() for values in (table[label], stated.factor * table[header.label]))
        power = float(np.sqrt((x @ x) * (r @ r)))
        if power == 0.0 or abs(float(x @ r)) < FOLLOWED * power:
            continue
        slope = abs(float(x @ r)) / float(x @ x)
        factor = next(
            (known for known in TRIED.get(stated.label, {}).values() if abs(slope / known - 1.0) < NEAR),
            float(f"{slope:.4g}"),
        )
        told = f"times {factor:.4g} it is as long as {printable(header.label)!r}, whose unit is stated"
        return Unit(factor, stated.label, told, LIKELY)
    return unit


def _time(header: Header, time: FloatArray, scale: Mapping[str, float]) -> FloatArray:
    return time * (scale["time"] if "time" in scale else unit_of_time(header, time).factor)
