"""Logs: columns over time, measured or simulated, in memory and in files."""

from __future__ import annotations

import importlib.metadata
import io
import math
import numbers
import os
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
import numpy.typing as npt

from cogging import plot
from cogging._core import format_rows
from cogging.arrays import FloatArray, no_number_in
from cogging.calls import PATHS, check_arguments, check_constructor
from cogging.files import LARGEST, FieldError, InputError, read_toml
from cogging.logs.columns import read_columns
from cogging.model.units import Units
from cogging.outputs import Checksum, checksum_of, sidecar, target_of, to_toml, write_files
from cogging.resources import require_table
from cogging.shown import quoted
from cogging.tables import frame_of, html_table
from cogging.values import ByValue

if TYPE_CHECKING:
    from matplotlib.figure import Figure

SHORTEST = 1e-12  # s, from row to row: what is differentiated over less leaves all bounds
SMALLEST = 1e-30  # of what a column spans in any unit: the square of its square is not yet zero
REQUIRED = ("time", "position", "command")
ROWS_AT_ONCE = 1 << 16  # rows that are formatted before they are written
READ_WITH = "read_with"  # key of the metadata: what was found of the file that bears on its numbers
CHECKSUM = "log_checksum"  # key of a sidecar: of its log as it was written
TRUE = ("true_position", "true_velocity")
OPTIONAL = ("reference", "reference_velocity", "reference_acceleration")


COLUMN_UNITS = {"time": "s", "position": "m", "command": "V", "reference": "m", "error": "m"}
COLUMN_UNITS |= {"reference_velocity": "m/s", "reference_acceleration": "m/s^2"}
COLUMN_UNITS |= {"true_position": "m", "true_velocity": "m/s"}


@check_constructor
@dataclass(frozen=True, eq=False, repr=False)
class Log(ByValue):
    """One run of an axis, measured or simulated: one row a sample.

    Columns may be anything that is an array of real numbers (lists, pandas Series). They are held as read-only float64
    arrays, without a copy where they are float64 arrays already.

    Attributes:
        time: s, strictly increasing, (n,).
        position: m, encoder reading at `time`.
        command: V, computed from that reading, applied from `time` and held until the next row.
        reference: m, or None; reference_velocity (m/s) and reference_acceleration (m/s^2) likewise.
        true_position: m, the plant's own; None in a measured log. Likewise true_velocity, m/s.
        estimates: what the controller believed, (n, p), where it was asked for.
        metadata: what a CSV cannot hold: model, reference, version and seed of a simulated log.

    Raises:
        ValueError: a column is missing, not of real numbers, of another shape or length than `time`, has a masked
            entry or one that is not finite, or `time` is not strictly increasing; names column, row, rule and value.

    Example:
        >>> cogging.Log(time=[0.0, 0.001, 0.002], position=[0.0, 1e-6, 3e-6], command=[0.1, 0.1, 0.0])
        Log(3 rows, 0.002 s at 1000 Hz, 0 to 3e-06 m)
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
        for name in (*REQUIRED, *OPTIONAL, "true_position", "true_velocity", "estimates"):
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

    def __setstate__(self, state: dict[str, Any]) -> None:
        for name, value in state.items():
            if isinstance(value, np.ndarray) and value.flags.writeable:
                value.flags.writeable = False  # a copy has the right to be written, a log has not
            self.__dict__[name] = value

    def _brief(self) -> str:
        if len(self) < 2:
            return "1 row"
        span = float(self.time[-1] - self.time[0])
        extra = [name for name in OPTIONAL[:1] if getattr(self, name) is not None]
        extra += ["true motion"] * (self.true_position is not None) + ["estimates"] * (self.estimates is not None)
        low, high = float(self.position.min()), float(self.position.max())
        told = f"{len(self)} rows, {span:.6g} s at {(len(self) - 1) / span:.6g} Hz, "
        told += f"{low:.6g} to {high:.6g} {self.units.position}"
        return f"{told}, with {', '.join(extra)}" if extra else told

    def __len__(self) -> int:
        return len(self.time)

    @property
    def units(self) -> Units:
        """Labels of command and position: those of the model that the metadata tell; V and m where they tell none."""
        return _units_told(self.metadata) or Units()

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

    def to_frame(self) -> Any:
        """All columns as a pandas DataFrame, with their units in `attrs["units"]`; estimates as `estimates[0]` and on.

        Raises:
            ImportError: pandas is not there; names the extra that brings it.
        """
        columns = self.columns()
        columns |= {name: value for name in TRUE if (value := getattr(self, name)) is not None}
        if self.estimates is not None:
            columns |= {f"estimates[{i}]": column for i, column in enumerate(self.estimates.T)}
        return frame_of(columns, self._column_units())

    def _column_units(self) -> dict[str, str]:
        units = self.units
        return {name: units.of(unit) for name, unit in COLUMN_UNITS.items()}

    def _repr_html_(self) -> str:
        units = self._column_units()
        columns = self.columns() | ({"error": self.error} if self.reference is not None else {})
        rows = [
            [name, units[name], float(values.min()), float(values.max()), float(np.sqrt(np.mean(values**2)))]
            for name, values in columns.items()
        ]
        return html_table(f"Log: {self._brief()}", ["column", "unit", "least", "largest", "rms"], rows)

    def plot(self, columns: str | Sequence[str] | None = None, *, units: Any = None, ax: Any = None) -> Figure:
        """Draw columns over time, a panel each (cogging.plot.log).

        Args:
            columns: names of one or more, `error` among them; None: position, error and command.
            units: labels of command and position (cogging.Units); None: those of the model that the log carries.
            ax: axes; None: a new figure.

        Returns:
            The figure.
        """
        return plot.log(self, columns, units=self.units if units is None else units, ax=ax).figure

    def write(self, path: str | os.PathLike[str]) -> None:
        """Write a file of the format that the suffix names, and `PATH.toml` with the metadata.

        `.mat` (MATLAB 5), `.parquet` (extra `parquet`); any other name but those of ASAM MDF is a CSV
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
            raise InputError(f"{path}: needs {error.name} to be written: pip install 'cogging[parquet]'") from None
        checksum = Checksum(pieces)
        files: dict[str, Iterable[bytes] | None] = {os.fspath(path): checksum}
        beside = sidecar(path)
        _require_sidecar(beside)
        metadata = {key: value for key, value in self.metadata.items() if key != READ_WITH}  # of the other file
        if metadata:
            known = {"version": importlib.metadata.version("cogging"), **metadata}
            # Formatted after the log has been written: its checksum is known then.
            files[beside] = (to_toml(_plain({**known, CHECKSUM: str(checksum)})).encode() for _ in range(1))
        else:
            files[beside] = None  # what stands there is of another log
        write_files(files)

    def _csv(self) -> Iterator[bytes]:
        columns = self.columns()
        arrays = [np.ascontiguousarray(column, dtype=np.float64) for column in columns.values()]
        yield (",".join(columns) + "\n").encode()
        for first in range(0, len(self), ROWS_AT_ONCE):
            yield format_rows(arrays, first, min(first + ROWS_AT_ONCE, len(self)))

    def _matlab(self) -> Iterable[bytes]:
        from scipy.io import savemat

        require_table("rows", len(self), len(self.columns()), 1.5)
        buffer = io.BytesIO()
        savemat(buffer, self.columns(), oned_as="column")
        return [buffer.getvalue()]

    def _parquet(self) -> Iterable[bytes]:
        import pyarrow as pa
        import pyarrow.parquet as parquet

        require_table("rows", len(self), len(self.columns()), 4.0)
        buffer = pa.BufferOutputStream()
        parquet.write_table(pa.table(self.columns()), buffer, write_page_checksum=True)
        return [buffer.getvalue().to_pybytes()]


def _numbers(name: str, given: Any, dimensions: int) -> FloatArray:
    """A column as a read-only float64 array; a view of what is one already."""
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
    with np.errstate(over="ignore"):  # what is too large for float64 is infinite, and told below
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
    for row, value in enumerate(array.flat):  # what a table with missing entries holds, or integers beyond 64 bits
        if not isinstance(value, numbers.Real) or isinstance(value, bool):
            raise ValueError(f"row {row}: {name}: must be a real number, got {value!r}")
    return np.array([_as_float(value) for value in array.flat], dtype=np.float64).reshape(array.shape)


def _as_float(value: numbers.Real) -> float:
    try:
        return float(value)
    except OverflowError:
        return math.inf


def _require_increasing(time: FloatArray) -> None:
    rising = time[1:] > time[:-1]
    if not rising.all():
        row = int(np.argmin(rising)) + 1
        before, here = _told_apart(time[row - 1], time[row])
        raise ValueError(f"row {row}: time: must be strictly increasing, got {here} after {before}")


def _plain(value: Any) -> Any:
    """A document with lists in place of arrays."""
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
    """Read a log from a file (see columns.read_columns for formats and arguments), and `PATH.toml` if it is there.

    Args:
        path: of a CSV, MATLAB, ASAM MDF or Parquet file.
        columns: names in the file by the names of a log: `{"position": "qm"}`.
        scale: factors on columns, by the names of a log: `{"position": 1e-3}` for mm.
        rows: the data rows to take, from 0.

    Returns:
        The log.

    Raises:
        InputError: the file cannot be used, has fewer than two rows, `time` is not strictly increasing, or what stands
            beside it was written beside another log.

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
    rising = time[1:] > time[:-1]
    if not rising.all():
        at = int(np.argmin(rising)) + 1
        row = at + (rows.start or 0 if rows is not None else 0)
        before, here = _told_apart(time[at - 1], time[at])
        raise InputError(f"{path}: row {row}: time: must be strictly increasing, got {here} after {before}")
    metadata = _metadata_beside(path)
    if notes:
        metadata[READ_WITH] = notes
    return Log.of(table, metadata)


def units_beside(path: str | os.PathLike[str]) -> Units | None:
    """Labels of command and position that the metadata beside a log tell; None where there are none."""
    return _units_told(_metadata_beside(path))


def _metadata_beside(path: str | os.PathLike[str]) -> dict[str, Any]:
    """The metadata beside a log; its checksum, where one stands there, is compared and left out."""
    beside = Path(sidecar(path))
    metadata = read_toml(beside) if beside.exists() else {}
    expected, found = metadata.pop(CHECKSUM, None), None
    if expected is not None and expected != (found := checksum_of(path)):
        rule = f"must be the {CHECKSUM} of {path}, {found}: remove the line if that log was changed on purpose"
        raise InputError(f"{beside}: {CHECKSUM}: {rule}, got {quoted(expected)}")
    return metadata


def _units_told(metadata: Mapping[str, Any]) -> Units | None:
    """Those of the model that the metadata hold: V and m where it has no labels of its own."""
    model = metadata.get("model")
    if not isinstance(model, Mapping):
        return None
    try:
        return Units.from_dict(model.get("units", {}))
    except (FieldError, AttributeError, TypeError):
        return None  # what a sidecar says of a model is not held against its log


def _require_sidecar(path: str) -> None:
    """Refuse to replace, with what belongs to a log, a file that never did: the model `machine.toml` of `machine`."""
    try:
        known = not os.path.lexists(path) or not target_of(path).exists() or "version" in read_toml(path)
    except InputError:
        if os.path.lexists(path):
            raise
        return  # gone meanwhile, with another writer's log
    if not known:
        raise InputError(f"{path}: must be what a log left here to be replaced, got a file without `version`")


def require_sizes(log: Log) -> None:
    """Refuse a log whose numbers cannot be squared and divided: of no machine, but of a file that went wrong."""
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
