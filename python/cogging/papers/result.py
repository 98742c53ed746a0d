"""The result of a reproduction: tables beside the paper's, figures, JSON."""

from __future__ import annotations

import os
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import TYPE_CHECKING, Any

from cogging.arrays import FloatArray
from cogging.outputs import made_folder, to_json, write_files
from cogging.plot.canvas import png
from cogging.tables import frame_of
from cogging.values import ByValue

if TYPE_CHECKING:
    from matplotlib.figure import Figure


def with_tuples(value: Any) -> Any:
    """Return a value of a TOML file with tuples in place of lists."""
    if isinstance(value, dict):
        return {key: with_tuples(entry) for key, entry in value.items()}
    return tuple(map(with_tuples, value)) if isinstance(value, list) else value


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
            table, not counted) or "exploratory".
        labels: further columns of the result file, such as the set or the motor.
    """

    controller: str
    index: str
    unit: str
    paper: float | None
    simulated: float
    status: str
    labels: Mapping[str, str] = field(default_factory=dict)

    @property
    def name(self) -> str:
        """Controller and labels, as a table shows them."""
        return ", ".join([self.controller, *(f"{label} {value}" for label, value in self.labels.items())])

    @property
    def ratio(self) -> float | None:
        """Simulated over printed; None where the paper prints nothing."""
        return self.simulated / self.paper if self.paper else None

    def to_dict(self) -> dict[str, Any]:
        """Return the row as in the result file."""
        return {**{name: value for name, value in vars(self).items() if name != "labels"}, **self.labels}


def explored(controller: str, index: str, unit: str, value: float, **labels: str) -> Row:
    """Return an exploratory row: a number that the paper does not print."""
    return Row(controller, index, unit, None, float(value), "exploratory", labels)


def known(column: FloatArray | None) -> FloatArray:
    """Return a column that every simulated log has."""
    assert column is not None
    return column


#: Relative distances to the printed number within which simulated ones are counted.
WITHIN = (0.05, 0.15, 0.40)


@dataclass(frozen=True, eq=False, repr=False)
class Table(ByValue):
    """A table of the paper beside the simulated one.

    Attributes:
        id: its name in the result file.
        title: for the screen.
        rows: its numbers.
        free: names of the calibrated parameters; empty: no counts are shown.
        before: other values of the same numbers, shown beside them; None: there are none.
        beside: heading of those values.
    """

    id: str
    title: str
    rows: Sequence[Row]
    free: Sequence[str] = ()
    before: Table | None = None
    beside: str = "before"

    def counts(self) -> dict[str, Any]:
        """Return how many printed numbers are calibrated, predicted, and near, as in the result file."""
        calibrated, predicted = (
            [abs(row.ratio - 1.0) for row in self.rows if row.ratio is not None and row.status == status]
            for status in ("calibrated", "predicted")
        )
        within, predicted_within = (
            {f"{100 * share:.0f}": sum(error <= share for error in errors) for share in WITHIN}
            for errors in (calibrated + predicted, predicted)
        )
        found: dict[str, Any] = {"numbers": len(calibrated) + len(predicted), "calibrated": len(calibrated)}
        found |= {"predicted": len(predicted), "within": within, "predicted_within": predicted_within}
        return {**found, "free_parameters": len(self.free)}

    def _counts_text(self) -> str:
        found = self.counts()
        near, of_predicted = (", ".join(map(str, found[name].values())) for name in ("within", "predicted_within"))
        predicted = f", of the {found['predicted']} predicted {of_predicted}" if found["predicted"] else ""
        fitted = f"{found['calibrated']} calibrated by {len(self.free)} free parameter{'s' * (len(self.free) != 1)}"
        shares = ", ".join(f"{name} %" for name in found["within"])
        return f"{found['numbers']} numbers, {fitted}; within {shares}: {near}{predicted}"

    def to_dict(self) -> dict[str, Any]:
        """Return the table as in the result file."""
        found: dict[str, Any] = {"id": self.id, "rows": [row.to_dict() for row in self.rows]}
        if self.free:
            found |= {"free_parameters": list(self.free), "counts": self.counts()}
        return found

    def _brief(self) -> str:
        return f"{self.id}, {len(self.rows)} rows"

    def to_frame(self) -> Any:
        """Return the rows as a pandas DataFrame, each with its unit.

        Raises:
            ImportError: pandas is not installed; names the extra that brings it.
        """
        return frame_of([row.to_dict() for row in self.rows], {}, title=self.title)

    def text(self) -> str:
        """Return the table for the screen."""
        width = max([15, *(len(row.name) + 2 for row in self.rows)])
        earlier = {(row.name, row.index): row for row in self.before.rows} if self.before else {}
        head = f"{self.beside:>12}{'ratio':>8}" if earlier else ""
        lines = [self.title]
        lines.append(f"{'':4}{'controller':<{width}}{'index':<13}{'paper':>12}{head}{'simulated':>14}{'ratio':>8}  ")
        for row in self.rows:
            before = _simulated(earlier.get((row.name, row.index)), 12) if earlier else ""
            start = f"{'':4}{row.name:<{width}}{row.index:<13}{_shown(row.paper, row.unit):>12}{before}"
            lines.append(f"{start}{_simulated(row, 14)}  {row.status}")
        if self.before is not None and self.before.free:
            lines.append(f"{'':4}{self.beside}: {self.before._counts_text()}")
        if self.free:
            lines += [f"{'':4}{self._counts_text()}", f"{'':4}free: {', '.join(self.free)}"]
        return "\n".join(lines)


def _shown(value: float | None, unit: str) -> str:
    scale, label = {"m": (1e6, "um"), "1": (1.0, "")}.get(unit, (1.0, unit))
    return f"{value * scale:.4g} {label}".rstrip() if value is not None else "-"


def _simulated(row: Row | None, width: int) -> str:
    """Return value and ratio of a row in two columns, the first so wide; `-` for what there is not."""
    value = _shown(row.simulated, row.unit) if row else "-"
    ratio = f"{row.ratio:.3f}" if row and row.ratio is not None else "-"
    return f"{value:>{width}}{ratio:>8}"


@dataclass(frozen=True, eq=False, repr=False)
class Reproduction(ByValue):
    """Tables and figures of one paper.

    Attributes:
        paper: its name, such as "lu2008".
        tables: one Table for each of the paper's, and further ones.
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
        """Return the content of `<paper>.json`."""
        return {"paper": self.paper, "tables": [table.to_dict() for table in self.tables]}

    def to_frame(self) -> Any:
        """Return the rows of all tables as a pandas DataFrame, each with its unit.

        Raises:
            ImportError: pandas is not installed; names the extra that brings it.
        """
        rows = [{"table": table.id, **row.to_dict()} for table in self.tables for row in table.rows]
        return frame_of(rows, {}, paper=self.paper)

    def text(self, every: bool = True) -> str:
        """Return tables and notes for the screen.

        Args:
            every: False lists the tables without a number of the paper by their titles alone.
        """
        shown = [table for table in self.tables if every or any(row.status != "exploratory" for row in table.rows)]
        named = [f"    {table.title} ({len(table.rows)} numbers)" for table in self.tables if table not in shown]
        further = ["\n".join(["Further tables, in no paper (--all shows them):", *named])] if shown and named else []
        return "\n\n".join([*(table.text() for table in shown or self.tables), *further, *self.notes])

    def write(self, folder: str | os.PathLike[str]) -> list[Path]:
        """Write `<paper>.json` and a PNG of each figure into a folder, all or none; other files stay.

        Args:
            folder: is made if it does not exist.

        Returns:
            The paths.

        Raises:
            InputError: a file cannot be written; nothing has changed.
        """
        out = Path(folder)
        content = {out / f"{self.paper}.json": to_json(self.to_dict(), indent=2).encode()}
        content |= {out / f"{name}.png": png(figure) for name, figure in self.figures.items()}
        with made_folder(out):
            write_files({os.fspath(path): [piece] for path, piece in content.items()})
        return list(content)
