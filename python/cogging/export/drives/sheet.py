"""What is known of a drive, with its source, and what is assumed: for the side text and docs/export.md."""

from __future__ import annotations

from dataclasses import dataclass

#: The questions that a sheet answers, in the order of the table, each with its field.
COLUMNS = (
    ("takes", "quantity"),
    ("entries", "entries"),
    ("one entry", "quantum"),
    ("between entries", "between"),
    ("sign", "sign"),
    ("zero and direction", "zero"),
    ("loaded by", "loading"),
    ("source", "source"),
)


@dataclass(frozen=True)
class Sheet:
    """A drive's compensation of cogging, as its documents tell it.

    Attributes:
        drive: maker and name.
        quantity: what it takes, with unit.
        entries: how many, over what.
        quantum: resolution of one.
        between: how it reads between them.
        sign: what it does with the value.
        zero: where entry 0 lies, and which way they go.
        loading: how the file gets into the drive.
        source: documents, by title, number or address.
        assumed: what no source tells, each with the option that sets it.
    """

    drive: str
    quantity: str
    entries: str
    quantum: str
    between: str
    sign: str
    zero: str
    loading: str
    source: str
    assumed: tuple[str, ...]

    def text(self) -> str:
        """The sheet in lines."""
        lines = [f"{title + ':':20s}{getattr(self, name)}" for title, name in COLUMNS]
        return "\n".join([self.drive, *lines, *(f"{'assumed:':20s}{one}" for one in self.assumed)])

    def markdown(self) -> str:
        """The sheet as a section of docs/export.md."""
        rows = [f"| {title} | {getattr(self, name)} |" for title, name in COLUMNS]
        rows += [f"| assumed | {one} |" for one in self.assumed]
        return "\n".join([f"### {self.drive}", "", "| | |", "|---|---|", *rows])
