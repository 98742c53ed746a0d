"""Logs: columns over time, measured or simulated, in memory and in files."""

from __future__ import annotations

import importlib.metadata
import io
import os
from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt

from cogging._core import format_rows
from cogging.columns import read_columns
from cogging.files import LARGEST, InputError, read_toml, to_toml, write_files

FloatArray = npt.NDArray[np.float64]

SHORTEST = 1e-12  # s, from row to row: what is differentiated over less leaves all bounds
SMALLEST = 1e-30  # of what a column spans in any unit: the square of its square is not yet zero
REQUIRED = ("time", "position", "command")
ROWS_AT_ONCE = 1 << 16  # rows that are formatted before they are written
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
        """Write a file of the format that the suffix names, and `PATH.toml` with the metadata.

        `.mat` (MATLAB 5, extra `matlab`), `.parquet` (extra `parquet`); any other name but those of ASAM MDF is a CSV
        with a header row. Every number is kept to its last bit.

        Raises:
            InputError: the file cannot be written, or a library is not installed; nothing is left behind.
        """
        suffix = Path(path).suffix.lower()
        if suffix in (".mf4", ".mdf", ".dat"):
            raise InputError(f"{path}: must be a CSV, .mat or .parquet file to be written, got {suffix}")
        try:
            pieces = {".mat": self._matlab, ".parquet": self._parquet}.get(suffix, self._csv)()
        except ImportError as error:
            extra = {".mat": "matlab", ".parquet": "parquet"}[suffix]
            raise InputError(f"{path}: needs {error.name} to be written: pip install 'cogging[{extra}]'") from None
        files: dict[str, Iterable[bytes]] = {os.fspath(path): pieces}
        beside = f"{os.fspath(path)}.toml"
        if self.metadata:
            document = {"version": importlib.metadata.version("cogging"), **self.metadata}
            files[beside] = [to_toml(_plain(document)).encode()]
        write_files(files)
        if not self.metadata:
            Path(beside).unlink(missing_ok=True)  # of another log that stood here

    def _csv(self) -> Iterator[bytes]:
        columns = self.columns()
        arrays = [np.ascontiguousarray(column, dtype=np.float64) for column in columns.values()]
        yield (",".join(columns) + "\n").encode()
        for first in range(0, len(self), ROWS_AT_ONCE):
            yield format_rows(arrays, first, min(first + ROWS_AT_ONCE, len(self)))

    def _matlab(self) -> Iterable[bytes]:
        from scipy.io import savemat

        buffer = io.BytesIO()
        savemat(buffer, self.columns(), oned_as="column")
        return [buffer.getvalue()]

    def _parquet(self) -> Iterable[bytes]:
        import pyarrow as pa
        import pyarrow.parquet as parquet

        buffer = pa.BufferOutputStream()
        parquet.write_table(pa.table(self.columns()), buffer)
        return [buffer.getvalue().to_pybytes()]


def _plain(value: Any) -> Any:
    """A document with lists in place of arrays."""
    if isinstance(value, Mapping):
        return {key: _plain(entry) for key, entry in value.items()}
    return value.tolist() if isinstance(value, np.ndarray) else value


def read_log(
    path: str | os.PathLike[str],
    *,
    columns: Mapping[str, str] | None = None,
    scale: Mapping[str, float] | None = None,
    rows: slice | None = None,
) -> Log:
    """Read a log from a file (see columns.read_columns for formats and arguments), and `PATH.toml` if it is there.

    Raises:
        InputError: the file cannot be used, has fewer than two rows, or `time` is not strictly increasing.
    """
    table = read_columns(path, REQUIRED, optional=OPTIONAL, columns=columns, scale=scale, rows=rows)
    time = table["time"]
    if time.size < 2:
        raise InputError(f"{path}: rows: must be at least 2, got {time.size}")
    rising = time[1:] > time[:-1]
    if not rising.all():
        at = int(np.argmin(rising)) + 1
        row = at + (rows.start or 0 if rows is not None else 0)
        before, here = _told_apart(time[at - 1], time[at])
        raise InputError(f"{path}: row {row}: time: must be strictly increasing, got {here} after {before}")
    beside = Path(f"{os.fspath(path)}.toml")
    metadata: dict[str, Any] = read_toml(beside) if beside.exists() else {}
    return Log.of(table, metadata)


def require_sizes(log: Log) -> None:
    """Refuse a log whose numbers cannot be squared and divided: of no machine, but of a file that went wrong.

    Raises:
        ValueError: a column above LARGEST in size; a position or command that is not constant or zero but below
            SMALLEST; rows closer than SHORTEST on average. Names column, rule and value.
    """
    for name, values in log.columns().items():
        size = max(float(values.max(initial=0.0)), -float(values.min(initial=0.0)))
        if size > LARGEST:
            row = int(np.argmax(np.abs(values)))
            raise ValueError(f"{name}: must be at most {LARGEST:g} in size, got {values[row]:g} in row {row}")
    for name, size in (("position", np.ptp(log.position)), ("command", np.abs(log.command).max())):
        if 0.0 < size < SMALLEST:
            raise ValueError(f"{name}: must be constant or change by at least {SMALLEST:g}, got {size:g}")
    step = float(log.time[-1] - log.time[0]) / max(len(log) - 1, 1)
    if step < SHORTEST:
        raise ValueError(f"time: must have rows at least {SHORTEST:g} s apart on average, got {step:g} s")


def _told_apart(first: float, second: float) -> tuple[str, str]:
    short = f"{first:g}", f"{second:g}"
    return short if short[0] != short[1] or first == second else (repr(float(first)), repr(float(second)))
