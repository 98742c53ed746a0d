"""Logs: columns over time, measured or simulated, in memory and in CSV files."""

from __future__ import annotations

import importlib.metadata
import os
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt

from cogging.files import InputError, read_text, read_toml, to_toml, write_text

FloatArray = npt.NDArray[np.float64]

REQUIRED = ("time", "position", "command")
OPTIONAL = ("reference", "reference_velocity", "reference_acceleration")


@dataclass(frozen=True)
class Log:
    """One run of an axis, measured or simulated: one row a sample.

    Attributes:
        time: s, strictly increasing, (n,).
        position: m, encoder reading at `time`.
        command: V, computed from that reading, applied from `time` and held until the next row.
        reference: m, or None; its derivatives (m/s, m/s^2) likewise.
        true_position: m, the plant's own; None in a measured log. Likewise true_velocity, m/s.
        estimates: what the controller believed, (n, p), where it was asked for.
        metadata: what a CSV cannot hold: model, reference, version and seed of a simulated log.
    """

    time: FloatArray
    position: FloatArray
    command: FloatArray
    reference: FloatArray | None = None
    reference_velocity: FloatArray | None = None
    reference_acceleration: FloatArray | None = None
    true_position: FloatArray | None = None
    true_velocity: FloatArray | None = None
    estimates: FloatArray | None = None
    metadata: Mapping[str, Any] = field(default_factory=dict)

    @classmethod
    def of(cls, columns: Mapping[str, FloatArray], metadata: Mapping[str, Any] | None = None) -> Log:
        """Make a log of columns by name, as a file or a run gives them."""
        return cls(
            time=columns["time"],
            position=columns["position"],
            command=columns["command"],
            reference=columns.get("reference"),
            reference_velocity=columns.get("reference_velocity"),
            reference_acceleration=columns.get("reference_acceleration"),
            true_position=columns.get("true_position"),
            true_velocity=columns.get("true_velocity"),
            estimates=columns.get("estimates"),
            metadata=metadata or {},
        )

    def __len__(self) -> int:
        return len(self.time)

    @property
    def error(self) -> FloatArray:
        """Encoder reading minus reference, m, (n,).

        Raises:
            ValueError: the log has no reference.
        """
        if self.reference is None:
            raise ValueError("reference: must be in the log to know the error, got none")
        return self.position - self.reference

    def columns(self) -> dict[str, FloatArray]:
        """The columns of a log file that this log has, by name."""
        values = {name: getattr(self, name) for name in (*REQUIRED, *OPTIONAL)}
        return {name: value for name, value in values.items() if value is not None}

    def write(self, path: str | os.PathLike[str]) -> None:
        """Write a CSV with a header row, every number to its last bit, and `PATH.toml` with the metadata."""
        columns = self.columns()
        rows = np.column_stack(list(columns.values())).tolist()
        lines = [",".join(columns), *(",".join(map(repr, row)) for row in rows)]
        if self.metadata:
            document = {"version": importlib.metadata.version("cogging"), **self.metadata}
            write_text(f"{path}.toml", to_toml(document))
        write_text(path, "\n".join(lines) + "\n")


def read_columns(
    path: str | os.PathLike[str],
    names: Sequence[str],
    *,
    optional: Sequence[str] = (),
    columns: Mapping[str, str] | None = None,
    scale: Mapping[str, float] | None = None,
    rows: slice | None = None,
) -> dict[str, FloatArray]:
    """Read named columns of a CSV file with a header row.

    Args:
        path: the file.
        names: columns that must be there.
        optional: columns that may be there.
        columns: what a column is called in the file, by its name here (`{"position": "qm"}`).
        scale: factor by which a column is multiplied, by its name here.
        rows: the data rows to take, counted from 0.

    Raises:
        InputError: a missing column, text in a number, a NaN, no rows; names file, line or column, and the value.
    """
    columns, scale = dict(columns or {}), dict(scale or {})
    for option, mapping in (("columns", columns), ("scale", scale)):
        for name in mapping:
            if name not in (*names, *optional):
                raise InputError(f"{option}: {name}: must be one of {', '.join((*names, *optional))}")
    lines = read_text(path).splitlines()
    header = [entry.strip().strip('"') for entry in lines[0].split(",")] if lines else []
    wanted = {name: columns.get(name, name) for name in (*names, *optional)}
    for name, there in wanted.items():
        if there not in header and (name in names or name in columns):
            raise InputError(f"{path}: column {there}: must be in the header, which has {', '.join(header) or 'none'}")
    index = {name: header.index(there) for name, there in wanted.items() if there in header}
    body = [(number, line) for number, line in enumerate(lines[1:], start=2) if line.strip()]
    body = body[rows] if rows is not None else body
    if not body:
        raise InputError(f"{path}: rows: must be at least 1, got 0")
    try:
        table = np.loadtxt(
            [line for _, line in body], delimiter=",", usecols=list(index.values()), ndmin=2, comments=None
        )
    except ValueError:
        raise _culprit(path, body, index) from None
    if not np.isfinite(table).all():
        raise _culprit(path, body, index)
    return {name: table[:, i] * scale.get(name, 1.0) for i, name in enumerate(index)}


def _culprit(path: str | os.PathLike[str], body: list[tuple[int, str]], index: Mapping[str, int]) -> InputError:
    """Find the first entry that is no finite number."""
    for number, line in body:
        entries = line.split(",")
        for name, column in index.items():
            if column >= len(entries):
                return InputError(f"{path}: line {number}: {name}: must be there, got {len(entries)} columns")
            try:
                good = bool(np.isfinite(float(entries[column])))
            except ValueError:
                good = False
            if not good:
                value = entries[column].strip()
                return InputError(f"{path}: line {number}: {name}: must be a finite number, got {value!r}")
    return InputError(f"{path}: must be a table of numbers")


def read_log(
    path: str | os.PathLike[str],
    *,
    columns: Mapping[str, str] | None = None,
    scale: Mapping[str, float] | None = None,
    rows: slice | None = None,
) -> Log:
    """Read a log from a CSV file (see read_columns for the arguments).

    Raises:
        InputError: the file cannot be used, or `time` is not strictly increasing.
    """
    table = read_columns(path, REQUIRED, optional=OPTIONAL, columns=columns, scale=scale, rows=rows)
    steps = np.diff(table["time"])
    if (steps <= 0).any():
        row = int(np.argmax(steps <= 0)) + 1
        raise InputError(
            f"{path}: row {row}: time: must be strictly increasing, got {table['time'][row]:g} "
            f"after {table['time'][row - 1]:g}"
        )
    beside = Path(f"{path}.toml")
    metadata: dict[str, Any] = {}
    if beside.exists():
        metadata = read_toml(beside)
    return Log.of(table, metadata)
