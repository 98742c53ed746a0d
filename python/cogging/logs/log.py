"""Logs: columns over time, measured or simulated, in memory and in files."""

from __future__ import annotations

import contextlib
import importlib.metadata
import io
import itertools
import math
import numbers
import os
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
import numpy.typing as npt

from cogging import _core, plot
from cogging._core import Performance, format_rows
from cogging.arrays import FloatArray, no_number_in
from cogging.calls import PATHS, check_arguments, check_constructor
from cogging.files import LARGEST, FieldError, InputError, errors_of, read_toml
from cogging.logs.columns import read_columns
from cogging.model.units import Units
from cogging.outputs import Checksum, checksum_of, sidecar, target_of, to_toml, write_files
from cogging.plot.traces import UNITS
from cogging.resources import require_table
from cogging.shown import quoted
from cogging.tables import frame_of, html_table, parquet_of
from cogging.values import ByValue

if TYPE_CHECKING:
    from matplotlib.figure import Figure

SHORTEST = 1e-12  # s, mean step between rows: differences over less overflow
SMALLEST = 1e-30  # range of a column in any unit: its fourth power is not zero
REQUIRED = ("time", "position", "command")
ROWS_AT_ONCE = 1 << 16  # rows formatted before they are written
READ_WITH = "read_with"  # key of the metadata: notes of the reader
CHECKSUM = "log_checksum"  # key of a sidecar: checksum of its log
TRUE = ("true_position", "true_velocity")
OPTIONAL = ("reference", "reference_velocity", "reference_acceleration")
FURTHER = (*OPTIONAL, *TRUE, "estimates")
COLUMN_UNITS = {"time": "s", **UNITS}


@check_constructor
@dataclass(frozen=True, eq=False, repr=False)
class Log(ByValue):
    """One run of an axis, measured or simulated: one row a sample.

    Columns may be lists, pandas Series or arrays of real numbers. They are stored as read-only float64 arrays, without
    a copy of one that is float64 already.

    Attributes:
        time: s, strictly increasing, (n,).
        position: m, encoder reading at `time`.
        command: V, computed from that reading, applied from `time` and held until the next row.
        reference: m, or None; reference_velocity (m/s) and reference_acceleration (m/s^2) likewise.
        true_position: m, of the plant; None in a measured log. Likewise true_velocity, m/s.
        estimates: of the controller, (n, p), if they were recorded.
        metadata: what a CSV cannot hold: model, reference, version and seed of a simulated log.

    Raises:
        ValueError: a column is missing, not of real numbers, of another shape or length than `time`, has a masked
            entry or one that is not finite, or `time` is not strictly increasing; names column, row, rule and value.

    Example:
        >>> cogging.Log(time=[0.0, 0.001, 0.002], position=[0.0, 1e-6, 3e-6], command=[0.1, 0.1, 0.0])
        Log(3 rows, 0.002 s at 1000 Hz, 0 to 3e-06 m)
        >>> log[::100], log[log.time > 1.0]
        (Log(...), Log(...))
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

    def __post_init__(self) -> None:
        rows = -1
        for name in (*REQUIRED, *FURTHER):
            given = getattr(self, name)
            if given is None and name not in REQUIRED:
                continue
            values = _numbers(name, given, dimensions=2 if name == "estimates" else 1)
            if rows < 0:
                rows = len(values)
                _require_increasing(values)
            if len(values) != rows:
                raise ValueError(f"{name}: must be as long as time ({rows} rows), got {len(values)}")
            object.__setattr__(self, name, values)

    @classmethod
    def of(cls, columns: Mapping[str, Any], metadata: Mapping[str, Any] | None = None) -> Log:
        """Return a log of columns by name."""
        known: dict[str, Any] = {name: columns.get(name) for name in (*REQUIRED, *FURTHER)}
        return cls(**known, metadata=metadata or {})

    def __setstate__(self, state: dict[str, Any]) -> None:
        for name, value in state.items():
            if isinstance(value, np.ndarray) and value.flags.writeable:
                value.flags.writeable = False  # of an unpickled array
            self.__dict__[name] = value

    def _brief(self) -> str:
        if len(self) < 2:
            return "1 row"
        span = float(self.time[-1] - self.time[0])
        extra = ["reference"] * (self.reference is not None)
        extra += ["true motion"] * (self.true_position is not None) + ["estimates"] * (self.estimates is not None)
        low, high = float(self.position.min()), float(self.position.max())
        rate = f"{span:.6g} s at {(len(self) - 1) / span:.6g} Hz"
        line = f"{len(self)} rows, {rate}, {low:.6g} to {high:.6g} {self.units.position}"
        return f"{line}, with {', '.join(extra)}" if extra else line

    def __len__(self) -> int:
        return len(self.time)

    def __getitem__(self, rows: slice | npt.ArrayLike) -> Log:
        """Return the log of some rows, such as `log[100:200]` or `log[log.time > 1.0]`, with the same metadata."""
        if isinstance(rows, numbers.Number | str):
            rule = "must be a slice such as log[100:200], or an array of rows"
            raise TypeError(f"Log: rows: {rule}, got {quoted(rows)}: a column is an attribute, as log.position")
        chosen = rows if isinstance(rows, slice) else np.asarray(rows)
        columns = {name: getattr(self, name) for name in (*REQUIRED, *FURTHER)}
        return Log.of({name: None if one is None else one[chosen] for name, one in columns.items()}, self.metadata)

    def between(self, start: float, stop: float = math.inf) -> Log:
        """Return the rows with start <= time < stop (s)."""
        return self[(self.time >= start) & (self.time < stop)]

    @property
    def units(self) -> Units:
        """Unit labels of the model in the metadata; V and m by default."""
        return _units_in(self.metadata) or Units()

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
        """Return the columns of a log file by name."""
        values = {name: getattr(self, name) for name in (*REQUIRED, *OPTIONAL)}
        return {name: value for name, value in values.items() if value is not None}

    def to_frame(self) -> Any:
        """Return all columns as a pandas DataFrame (extra `frames`), estimates as `estimates[0]` and on."""
        columns = self.columns() | {name: one for name in TRUE if (one := getattr(self, name)) is not None}
        if self.estimates is not None:
            columns |= {f"estimates[{i}]": column for i, column in enumerate(self.estimates.T)}
        return frame_of(columns, self._column_units())

    def _column_units(self) -> dict[str, str]:
        units = self.units
        return {name: units.of(unit) for name, unit in COLUMN_UNITS.items()}

    def _repr_html_(self) -> str:
        columns, rows = self.columns() | ({"error": self.error} if self.reference is not None else {}), []
        for name, values in columns.items():
            sizes = (values.min(), values.max(), np.sqrt(np.mean(values**2)))
            rows.append([name, self._column_units()[name], *map(float, sizes)])
        return html_table(f"Log: {self._brief()}", ["column", "unit", "least", "largest", "rms"], rows)

    def plot(self, columns: str | Sequence[str] | None = None, *, units: Any = None, ax: Any = None) -> Figure:
        """Plot columns over time, one panel each, and return the figure (arguments as of cogging.plot.log)."""
        return plot.log(self, columns, units=self.units if units is None else units, ax=ax).figure

    def write(self, path: str | os.PathLike[str]) -> None:
        """Write a file in the format of its suffix, and the metadata as `PATH.toml`.

        The formats are `.mat` (MATLAB 5), `.parquet` (extra `parquet`) and CSV with a header row for other names; ASAM
        MDF is not written. Numbers keep their last bit.

        Raises:
            InputError: the file cannot be written, or a library is not installed; no file remains.
        """
        suffix = Path(path).suffix.lower()
        if suffix in (".mf4", ".mdf", ".dat"):
            raise InputError(f"{path}: must be a CSV, .mat or .parquet file to be written, got {suffix}")
        pieces: Iterable[bytes]
        if suffix in (".mat", ".parquet"):
            require_table("rows", len(self), len(self.columns()), 1.5 if suffix == ".mat" else 4.0)
        try:
            if suffix == ".mat":
                from scipy.io import savemat

                buffer = io.BytesIO()
                savemat(buffer, self.columns(), oned_as="column")
                pieces = [buffer.getvalue()]
            elif suffix == ".parquet":
                pieces = [parquet_of(self.columns(), self._column_units())]
            else:
                arrays = [np.ascontiguousarray(column, dtype=np.float64) for column in self.columns().values()]
                rows = [*range(0, len(self), ROWS_AT_ONCE), len(self)]
                header = [(",".join(self.columns()) + "\n").encode()]
                pieces = itertools.chain(header, (format_rows(arrays, *part) for part in itertools.pairwise(rows)))
        except ImportError as error:
            raise InputError(f"{path}: {error}") from None
        checksum = Checksum(pieces)
        files: dict[str, Iterable[bytes] | None] = {os.fspath(path): checksum}
        beside = sidecar(path)
        _require_sidecar(beside)
        metadata = {key: value for key, value in self.metadata.items() if key != READ_WITH}  # of the other file
        if metadata:
            known = {"version": importlib.metadata.version("cogging"), **metadata}
            # Formatted after the log is written, when its checksum is known.
            files[beside] = (to_toml(_plain({**known, CHECKSUM: str(checksum)})).encode() for _ in range(1))
        else:
            files[beside] = None  # that of another log is removed
        write_files(files)


@check_arguments()
def performance(
    time: Log | npt.ArrayLike,
    error: npt.ArrayLike | None = None,
    command: npt.ArrayLike | None = None,
    *,
    start: float = -math.inf,
    stop: float = math.inf,
    final_window: float = 2.0,
) -> Performance:
    """Return the indexes of a run over the rows with start <= time < stop.

    Args:
        time: the log; or its time, s, with the columns error (m) and command (V).
        error: m, if `time` is no log.
        command: V, likewise.
        start, stop: s.
        final_window: s: error_final_max is over the last so many seconds of them (Xu and Yao 2001, section 4.2).

    Returns:
        The indexes.

    Raises:
        ValueError: the log has no reference, no row is left, or a number is not finite.

    Example:
        >>> last = cogging.performance(log, start=1.0)
        >>> last.error_rms < last.error_max
        True
    """
    columns: Any = (time.time, time.error, time.command) if isinstance(time, Log) else (time, error, command)
    return _core.performance(*columns, start=start, stop=stop, final_window=final_window)


def _numbers(name: str, given: Any, dimensions: int) -> FloatArray:
    """Return a column as a read-only float64 array, without a copy of one."""
    array = given if type(given) is np.ndarray and given.dtype.kind != "O" else _array(name, given)
    if isinstance(given, list | tuple) and (found := no_number_in(given)):
        raise ValueError(f"{name}: must be real numbers, got {found[0]!r} among them")
    if array.dtype.kind not in "fiu":
        raise ValueError(f"{name}: must be real numbers, got {'none' if given is None else array.dtype}")
    if array.ndim != dimensions:
        wanted = "(rows,)" if dimensions == 1 else "(rows, estimates)"
        raise ValueError(f"{name}: must have the shape {wanted}, got {array.shape}")
    if not array.size and dimensions == 1:
        raise ValueError(f"{name}: must have at least 1 row, got 0")
    if isinstance(given, np.ma.MaskedArray) and np.ma.getmaskarray(given).any():
        row = int(np.argmax(np.ma.getmaskarray(given))) // max(1, array.size // len(array))
        raise ValueError(f"row {row}: {name}: must not be masked: leave out the rows that are, got a mask there")
    with np.errstate(over="ignore"):  # too large for float64: infinite, reported below
        values: FloatArray = array.astype(np.float64, copy=False).view()
    if not np.isfinite(values).all():
        bad = np.unravel_index(int(np.argmin(np.isfinite(values))), values.shape)
        raise ValueError(f"row {bad[0]}: {name}: must be a finite number, got {values[bad]:g}")
    values.flags.writeable = False
    return values


def _array(name: str, given: Any) -> npt.NDArray[Any]:
    try:
        array = np.asarray(given)
    except ValueError:  # rows of different lengths
        raise ValueError(f"{name}: must be real numbers, got a {type(given).__name__} that is no array") from None
    if array.dtype.kind != "O" or array.ndim == 0:
        return array
    for row, value in enumerate(array.flat):  # of a table with missing entries, or integers beyond 64 bits
        if not isinstance(value, numbers.Real) or isinstance(value, bool):
            raise ValueError(f"row {row}: {name}: must be a real number, got {value!r}")
    return np.array([_as_float(value) for value in array.flat]).reshape(array.shape)


def _as_float(value: Any) -> float:
    """Return a real number; infinity for a whole number or a fraction beyond the range of floats."""
    try:
        return float(value)
    except OverflowError:
        return math.inf


def _require_increasing(time: FloatArray, first_row: int = 0) -> None:
    rising = time[1:] > time[:-1]
    if not rising.all():
        row = int(np.argmin(rising)) + 1
        before, here = float(time[row - 1]), float(time[row])
        same = f"{here:g}" == f"{before:g}" and here != before  # they differ in later digits
        got = f"{here!r} after {before!r}" if same else f"{here:g} after {before:g}"
        raise ValueError(f"row {first_row + row}: time: must be strictly increasing, got {got}")


def _plain(value: Any) -> Any:
    """Return a document with lists in place of arrays."""
    if isinstance(value, Mapping):
        return {key: _plain(entry) for key, entry in value.items()}
    return value.tolist() if isinstance(value, np.ndarray) else value


@check_arguments(path=PATHS)
def read_log(
    path: str | os.PathLike[str],
    *,
    columns: Mapping[str, str] | None = None,
    scale: Mapping[str, float] | None = None,
    rows: slice | None = None,
) -> Log:
    """Read a log and its metadata, `PATH.toml`, if that exists.

    Formats are CSV, MATLAB, ASAM MDF and Parquet (see cogging.logs.columns.read_columns).

    Args:
        path: of a CSV, MATLAB, ASAM MDF or Parquet file.
        columns: names in the file by the names of a log: `{"position": "qm"}`.
        scale: factors on columns, by the names of a log: `{"position": 1e-3}` for mm.
        rows: the data rows to take, from 0.

    Returns:
        The log.

    Raises:
        InputError: the file is invalid, has fewer than two rows, `time` is not strictly increasing, or the metadata
            were written with another log.

    Example:
        >>> log.write("log.csv")
        >>> in_mm = cogging.read_log("log.csv", scale={"position": 1e3})
        >>> [len(in_mm) == len(log), bool(abs(in_mm.position[9] / log.position[9] - 1e3) < 1e-6)]
        [True, True]
    """
    notes: list[str] = []
    table = read_columns(path, REQUIRED, optional=OPTIONAL, columns=columns, scale=scale, rows=rows, notes=notes)
    time = table["time"]
    if time.size < 2:
        raise InputError(f"{path}: rows: must be at least 2, got {time.size}")
    with errors_of(path):
        _require_increasing(time, 0 if rows is None else rows.start or 0)
    metadata = _metadata_beside(path)
    if notes:
        metadata[READ_WITH] = notes
    return Log.of(table, metadata)


def units_beside(path: str | os.PathLike[str]) -> Units | None:
    """Return the unit labels in the sidecar of a log; None if it has none."""
    return _units_in(_metadata_beside(path))


def _metadata_beside(path: str | os.PathLike[str]) -> dict[str, Any]:
    """Return the metadata of a log file; a checksum in them is verified and removed."""
    beside = Path(sidecar(path))
    metadata = read_toml(beside) if beside.exists() else {}
    expected, found = metadata.pop(CHECKSUM, None), None
    if expected is not None and expected != (found := checksum_of(path)):
        rule = f"must be the {CHECKSUM} of {path}, {found}: remove the line if that log was changed on purpose"
        raise InputError(f"{beside}: {CHECKSUM}: {rule}, got {quoted(expected)}")
    return metadata


def _units_in(metadata: Mapping[str, Any]) -> Units | None:
    """Return the unit labels of the model in metadata; None without a model."""
    with contextlib.suppress(FieldError, AttributeError, KeyError, TypeError):  # an invalid one leaves the log valid
        return Units.from_dict(metadata["model"].get("units", {}))
    return None


def _require_sidecar(path: str) -> None:
    """Raise InputError if a sidecar would replace another file, such as the model `machine.toml` of a log `machine`."""
    try:
        known = not os.path.lexists(path) or not target_of(path).exists() or "version" in read_toml(path)
    except InputError:
        if os.path.lexists(path):
            raise
        return  # removed meanwhile by another process
    if not known:
        raise InputError(f"{path}: must be what a log left here to be replaced, got a file without `version`")


def require_sizes(log: Log) -> None:
    """Raise ValueError for a log whose numbers would overflow: no machine has them, but a damaged file may."""
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
