"""One column of a log's file as it was guessed, and what the options must say of it."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

from cogging.first_model.headers import Header
from cogging.first_model.units import Unit
from cogging.logs.readers.column_request import is_si, split_unit
from cogging.shown import printable


@dataclass(frozen=True)
class ColumnGuess:
    """One column of a log, and where it stands in the file.

    Attributes:
        name: in a log: time, position, command, reference, ...
        label: header in the file.
        unit: factor to the unit of the log, that unit's label, and how it is known.
        told: why it is this column.
        sure: STATED (its name says so, or its owner), LIKELY or UNKNOWN.
        called: what the option `--columns` calls it; the whole header where the name alone may be another's.
        scaled: whether `--scale` must be given, also for a factor of 1.
    """

    name: str
    label: str
    unit: Unit
    told: str
    sure: str
    called: str
    scaled: bool

    def text(self) -> str:
        """One line."""
        factor = f" x {self.unit.factor:.6g}" if self.unit.factor != 1.0 else ""
        return f"{self.name} is {printable(self.label)!r}{factor} ({self.told}); {self.unit.told}"


@dataclass(frozen=True)
class ColumnGuesses:
    """All columns of a log's file.

    Attributes:
        used: by their names in a log.
        unused: headers of the others.
        notes: what else is to be said.
    """

    used: dict[str, ColumnGuess]
    unused: tuple[str, ...]
    notes: tuple[str, ...]

    @property
    def columns(self) -> dict[str, str]:
        """What `--columns` must say."""
        return {name: guess.called for name, guess in self.used.items() if guess.called != name}

    @property
    def scale(self) -> dict[str, float]:
        """What `--scale` must say."""
        return {name: guess.unit.factor for name, guess in self.used.items() if guess.scaled}


def placed(name: str, header: Header, headers: Mapping[str, Header], unit: Unit, told: str, sure: str) -> ColumnGuess:
    """A guess with what the options must say of it."""
    alike = [h for h in headers.values() if h.label != header.label and name.casefold() == _bare(h).casefold()]
    plain = _bare(header)
    shared = [h for h in headers.values() if h.label != header.label and _bare(h).casefold() == plain.casefold()]
    called = name if plain == name and not alike and not shared else (header.label if shared else plain)
    bracketed = _stated(header)
    scaled = unit.factor != 1.0 or bool(bracketed and not is_si(name, bracketed))
    return ColumnGuess(name, header.label, unit, told, sure, called.strip(), scaled)


def _bare(header: Header) -> str:
    """The name by which the readers know a column: without a unit in brackets."""
    return split_unit(header.label)[0].strip()


def _stated(header: Header) -> str:
    """The unit that the readers see: in brackets, or apart from the name."""
    inside = split_unit(header.label)[1]
    return inside or (header.unit if header.bare == header.label else "")
