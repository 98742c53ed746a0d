"""What a reproduced paper leaves behind: tables beside the paper's, figures, JSON."""

from __future__ import annotations

import io
import os
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import TYPE_CHECKING, Any

from cogging.files import InputError
from cogging.outputs import to_json, write_files
from cogging.tables import frame_of
from cogging.values import ByValue

if TYPE_CHECKING:
    from matplotlib.figure import Figure


@dataclass(frozen=True)
class Row:
    """One number of a table.

    Attributes:
        controller: as the paper calls it.
        index: name of the index in the result files.
        unit: SI.
        paper: the printed number, or None.
        simulated: ours.
        status: "calibrated" (the setup was fitted to it), "predicted" or "exploratory".
        labels: further columns of the result file, such as the set or the motor.
    """

    controller: str
    index: str
    unit: str
    paper: float | None
    simulated: float
    status: str
    labels: Mapping[str, str] = field(default_factory=dict)

    def to_dict(self) -> dict[str, Any]:
        """The row as the result file has it."""
        return {
            "controller": self.controller,
            "index": self.index,
            "unit": self.unit,
            "paper": self.paper,
            "simulated": self.simulated,
            "status": self.status,
            **self.labels,
        }


@dataclass(frozen=True, eq=False, repr=False)
class Table(ByValue):
    """A table of the paper with ours beside it."""

    id: str
    title: str
    rows: Sequence[Row]

    def _brief(self) -> str:
        return f"{self.id}, {len(self.rows)} rows"

    def to_frame(self) -> Any:
        """The rows as a pandas DataFrame; the unit of each stands in its row.

        Raises:
            ImportError: pandas is not there; names the extra that brings it.
        """
        return frame_of([row.to_dict() for row in self.rows], {}, title=self.title)

    @staticmethod
    def _name(row: Row) -> str:
        return ", ".join([row.controller, *(f"{label} {value}" for label, value in row.labels.items())])

    def text(self) -> str:
        """The table for the screen."""
        width = max([15, *(len(self._name(row)) + 2 for row in self.rows)])
        lines = [self.title, f"{'':4}{'controller':<{width}}{'index':<8}{'paper':>12}{'simulated':>12}{'ratio':>8}  "]
        for row in self.rows:
            scale, unit = (1e6, "um") if row.unit == "m" else (1.0, row.unit.removeprefix("1"))
            printed = f"{row.paper * scale:.4g} {unit}" if row.paper is not None else "-"
            ratio = f"{row.simulated / row.paper:.3f}" if row.paper else "-"
            simulated = f"{row.simulated * scale:.4g} {unit}"
            lines.append(
                f"{'':4}{self._name(row):<{width}}{row.index:<8}{printed:>12}{simulated:>12}{ratio:>8}  {row.status}"
            )
        return "\n".join(lines)


@dataclass(frozen=True, eq=False, repr=False)
class Reproduction(ByValue):
    """Tables and figures of one paper.

    Attributes:
        paper: its name, such as "lu2008".
        tables: one Table for each of the paper's.
        figures: matplotlib figures by file name without ending.
        notes: sentences for the screen.
    """

    paper: str
    tables: Sequence[Table]
    figures: Mapping[str, Figure]
    notes: Sequence[str] = ()

    def _brief(self) -> str:
        return f"{self.paper}: {len(self.tables)} tables, {len(self.figures)} figures"

    def to_dict(self) -> dict[str, Any]:
        """The content of `<paper>.json`."""
        return {
            "paper": self.paper,
            "tables": [{"id": table.id, "rows": [row.to_dict() for row in table.rows]} for table in self.tables],
        }

    def to_frame(self) -> Any:
        """The rows of all tables as a pandas DataFrame; the unit of each stands in its row.

        Raises:
            ImportError: pandas is not there; names the extra that brings it.
        """
        rows = [{"table": table.id, **row.to_dict()} for table in self.tables for row in table.rows]
        return frame_of(rows, {}, paper=self.paper)

    def text(self) -> str:
        """Tables and notes for the screen."""
        return "\n\n".join([*(table.text() for table in self.tables), *self.notes])

    def write(self, folder: str | os.PathLike[str]) -> list[Path]:
        """Write `<paper>.json` and one PNG a figure into a folder, which is made if need be; says which."""
        out = Path(folder)
        try:
            out.mkdir(parents=True, exist_ok=True)
        except OSError as error:
            raise InputError(f"{out}: cannot be made: {error.strerror}") from None
        written = [out / f"{self.paper}.json"]
        content = [to_json(self.to_dict(), indent=2).encode()]
        for name, figure in self.figures.items():
            written.append(out / f"{name}.png")
            content.append(png(figure))
        write_files({os.fspath(path): [piece] for path, piece in zip(written, content, strict=True)})
        return written


def png(figure: Figure) -> bytes:
    """The picture of a figure, as the content of a file."""
    picture = io.BytesIO()
    figure.savefig(picture, format="png", dpi=120)
    return picture.getvalue()
