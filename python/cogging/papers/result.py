"""The result of a reproduction: tables beside the paper's, figures, JSON."""

from __future__ import annotations

import io
import os
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import TYPE_CHECKING, Any

from cogging.outputs import made_folder, to_json, write_files
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
        status: "calibrated" (the setup was fitted to it), "predicted", "derived" (follows from others of the same
            table, and is counted nowhere) or "exploratory".
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
        return {**{name: getattr(self, name) for name in ROW_FIELDS}, **self.labels}


ROW_FIELDS = ("controller", "index", "unit", "paper", "simulated", "status")


def explored(controller: str, index: str, unit: str, value: float, labels: Mapping[str, str] | None = None) -> Row:
    """Return an exploratory row: a number that the paper does not print."""
    return Row(controller, index, unit, None, float(value), "exploratory", labels or {})


#: Shares of the printed number within which a simulated one is counted.
WITHIN = (0.05, 0.15, 0.40)


@dataclass(frozen=True)
class Counts:
    """How many numbers of a table lie near the paper's.

    Attributes:
        numbers: that the paper prints.
        calibrated, predicted: of these, by their status.
        within: how many lie within each of WITHIN of the paper's.
        predicted_within: likewise of those that are predicted.
        free: parameters that were calibrated.
    """

    numbers: int
    calibrated: int
    predicted: int
    within: tuple[int, ...]
    predicted_within: tuple[int, ...]
    free: int

    def to_dict(self) -> dict[str, Any]:
        """As the result file has it, the shares in percent."""
        return {
            "numbers": self.numbers,
            "calibrated": self.calibrated,
            "predicted": self.predicted,
            "within": _by_percent(self.within),
            "predicted_within": _by_percent(self.predicted_within),
            "free_parameters": self.free,
        }

    def text(self) -> str:
        """One line for the screen."""
        shares = ", ".join(f"{100 * share:.0f} %" for share in WITHIN)
        near, of_predicted = (", ".join(map(str, counts)) for counts in (self.within, self.predicted_within))
        predicted = f", of the {self.predicted} predicted {of_predicted}" if self.predicted else ""
        fitted = f"{self.calibrated} calibrated by {self.free} free parameter{'s' * (self.free != 1)}"
        return f"{self.numbers} numbers, {fitted}; within {shares}: {near}{predicted}"


def _by_percent(counts: Sequence[int]) -> dict[str, int]:
    return {f"{100 * share:.0f}": count for share, count in zip(WITHIN, counts, strict=True)}


@dataclass(frozen=True, eq=False, repr=False)
class Table(ByValue):
    """A table of the paper with ours beside it.

    Attributes:
        id: its name in the result file.
        title: for the screen.
        rows: its numbers.
        free: names of the parameters that its calibrated numbers were fitted by; empty: no counts are given.
        before: the same numbers under the conditions that were assumed before, shown beside; None: there are none.
        beside: what those numbers are, as the column says it.
    """

    id: str
    title: str
    rows: Sequence[Row]
    free: Sequence[str] = ()
    before: Table | None = None
    beside: str = "before"

    @property
    def is_exploratory(self) -> bool:
        """Whether none of its numbers is one of the paper's."""
        return all(row.status == "exploratory" for row in self.rows)

    def counts(self) -> Counts:
        """How many of the numbers lie near the printed ones."""
        errors = {
            status: [abs(row.simulated / row.paper - 1.0) for row in self.rows if row.paper and row.status == status]
            for status in ("calibrated", "predicted")
        }
        both = [*errors["calibrated"], *errors["predicted"]]
        return Counts(
            len(both),
            len(errors["calibrated"]),
            len(errors["predicted"]),
            tuple(sum(error <= share for error in both) for share in WITHIN),
            tuple(sum(error <= share for error in errors["predicted"]) for share in WITHIN),
            len(self.free),
        )

    def to_dict(self) -> dict[str, Any]:
        """The table as the result file has it."""
        found: dict[str, Any] = {"id": self.id, "rows": [row.to_dict() for row in self.rows]}
        if self.free:
            found |= {"free_parameters": list(self.free), "counts": self.counts().to_dict()}
        return found

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
        earlier = {(self._name(row), row.index): row for row in self.before.rows} if self.before else {}
        head = f"{self.beside:>12}{'ratio':>8}" if earlier else ""
        lines = [
            self.title,
            f"{'':4}{'controller':<{width}}{'index':<13}{'paper':>12}{head}{'simulated':>14}{'ratio':>8}  ",
        ]
        for row in self.rows:
            name, before = self._name(row), ""
            if earlier:
                found = earlier.get((name, row.index))
                before = f"{_shown(found):>12}{_ratio(found):>8}" if found else f"{'-':>12}{'-':>8}"
            lines.append(
                f"{'':4}{name:<{width}}{row.index:<13}{_shown(row, printed=True):>12}{before} {_shown(row):>13}"
                f"{_ratio(row):>8}  {row.status}"
            )
        if self.before is not None and self.before.free:
            lines.append(f"{'':4}{self.beside}: {self.before.counts().text()}")
        if self.free:
            lines += [f"{'':4}{self.counts().text()}", f"{'':4}free: {', '.join(self.free)}"]
        return "\n".join(lines)


def _shown(row: Row, printed: bool = False) -> str:
    value = row.paper if printed else row.simulated
    scale, unit = (1e6, "um") if row.unit == "m" else (1.0, "" if row.unit == "1" else row.unit)
    return f"{value * scale:.4g} {unit}".rstrip() if value is not None else "-"


def _ratio(row: Row) -> str:
    return f"{row.simulated / row.paper:.3f}" if row.paper else "-"


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
        return {"paper": self.paper, "tables": [table.to_dict() for table in self.tables]}

    def to_frame(self) -> Any:
        """The rows of all tables as a pandas DataFrame; the unit of each stands in its row.

        Raises:
            ImportError: pandas is not there; names the extra that brings it.
        """
        rows = [{"table": table.id, **row.to_dict()} for table in self.tables for row in table.rows]
        return frame_of(rows, {}, paper=self.paper)

    def text(self, every: bool = True) -> str:
        """Tables and notes for the screen.

        Args:
            every: False names the tables that hold no number of the paper by their titles alone.
        """
        shown = [table for table in self.tables if every or not table.is_exploratory]
        named = [f"    {table.title} ({len(table.rows)} numbers)" for table in self.tables if table not in shown]
        further = ["\n".join(["Further tables, in no paper (--all shows them):", *named])] if shown and named else []
        return "\n\n".join([*(table.text() for table in shown or self.tables), *further, *self.notes])

    def write(self, folder: str | os.PathLike[str]) -> list[Path]:
        """Write `<paper>.json` and one PNG a figure into a folder, which is made if need be; says which.

        They take their places as one: the folder holds the old ones or the new ones, and other files stay.

        Raises:
            InputError: one cannot be written; all is as it was.
        """
        out = Path(folder)
        content = {out / f"{self.paper}.json": to_json(self.to_dict(), indent=2).encode()}
        content |= {out / f"{name}.png": png(figure) for name, figure in self.figures.items()}
        with made_folder(out):
            write_files({os.fspath(path): [piece] for path, piece in content.items()})
        return list(content)


def png(figure: Figure) -> bytes:
    """The picture of a figure, as the content of a file."""
    picture = io.BytesIO()
    figure.savefig(picture, format="png", dpi=120)
    return picture.getvalue()
