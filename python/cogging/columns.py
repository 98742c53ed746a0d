"""Named columns of numbers out of a file of any format that is read."""

from __future__ import annotations

import os
import stat
from collections.abc import Callable, Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt

from cogging.files import InputError
from cogging.readers import matlab, mdf, parquet, text_table
from cogging.readers.request import Request

FloatArray = npt.NDArray[np.float64]
Reader = Callable[[Request], dict[str, Any]]

#: Formats that need an optional library: what they are called, the extra that brings it, and the reader.
FORMATS: dict[str, tuple[str, str, Reader]] = {
    "matlab": ("MATLAB file", "matlab", matlab.read),
    "hdf5": ("MATLAB 7.3 (HDF5) file", "matlab", matlab.read_hdf5),
    "mdf": ("ASAM MDF file", "mdf", mdf.read),
    "parquet": ("Parquet file", "parquet", parquet.read),
}
SUFFIXES = {".mat": "matlab", ".mf4": "mdf", ".mdf": "mdf", ".parquet": "parquet"}
HDF5_SIGNATURE = b"\x89HDF\r\n\x1a\n"
OTHERS = {  # what is often given by mistake
    b"\x89PNG": "a PNG picture",
    b"\xff\xd8\xff": "a JPEG picture",
    b"PK\x03\x04": "a ZIP archive (or a spreadsheet)",
    b"\x1f\x8b": "a gzip archive",
    b"%PDF": "a PDF document",
    b"\xd0\xcf\x11\xe0": "an Office document",
    b"SQLite format 3": "an SQLite database",
}


def read_columns(
    path: str | os.PathLike[str],
    names: Sequence[str],
    *,
    optional: Sequence[str] = (),
    columns: Mapping[str, str] | None = None,
    scale: Mapping[str, float] | None = None,
    rows: slice | None = None,
    progress: bool = True,
) -> dict[str, FloatArray]:
    """Read named columns of a text table (CSV), MATLAB, ASAM MDF or Parquet file.

    The format is told by the file's first bytes. A text table has a header row, below any other lines, and commas,
    semicolons, tabs or blanks between its columns. A unit may stand behind a name, `position [mm]`: one that is not
    SI (or V, A, N) is refused unless `scale` says what to make of it.

    Args:
        path: the file.
        names: columns that must be there.
        optional: columns that may be there.
        columns: what a column is called in the file, by its name here (`{"position": "qm"}`).
        scale: factor by which a column is multiplied, by its name here.
        rows: the data rows to take, counted from 0.
        progress: show on a terminal how far the reading of a large text table is.

    Returns:
        The columns by name, each (n,).

    Raises:
        InputError: a missing column, text in a number, a NaN, no rows, columns of different lengths, a broken file, a
            library that is not installed; names file, line or row, column, and the value.
    """
    request = _request(path, names, optional, columns, scale, rows, progress)
    kind = format_of(path)
    table = text_table.read(request) if kind is None else _read_with(FORMATS[kind], request)
    arrays = table if kind is None else _numbers(request, table)
    if not arrays or not next(iter(arrays.values())).size:
        raise request.refuse("rows: must be at least 1, got 0")
    for name, factor in (scale or {}).items():
        if name in arrays and factor != 1.0:
            with np.errstate(over="ignore"):
                arrays[name] = arrays[name] * factor
            if not np.isfinite(arrays[name]).all():
                raise request.refuse(f"{name}: must stay finite when scaled, got a factor of {factor:g}")
    return arrays


def _request(
    path: str | os.PathLike[str],
    names: Sequence[str],
    optional: Sequence[str],
    columns: Mapping[str, str] | None,
    scale: Mapping[str, float] | None,
    rows: slice | None,
    progress: bool,
) -> Request:
    columns, scale, rows = dict(columns or {}), dict(scale or {}), rows or slice(0, None)
    for option, mapping in (("columns", columns), ("scale", scale)):
        for name in mapping:
            if name not in (*names, *optional):
                raise InputError(f"{option}: {name}: must be one of {', '.join((*names, *optional))}")
    for name, factor in scale.items():
        if not np.isfinite(factor) or factor == 0.0:
            raise InputError(f"scale: {name}: must be a finite number and not 0, got {factor!r}")
    start, stop = rows.start or 0, rows.stop
    if rows.step not in (None, 1) or start < 0 or (stop is not None and stop <= start):
        raise InputError(f"rows: needs 0 <= first < end and a step of 1, got {start}:{stop}")
    return Request(path, tuple(names), tuple(optional), columns, frozenset(scale), slice(start, stop), progress)


def format_of(path: str | os.PathLike[str]) -> str | None:
    """What a file is, by its first bytes: a key of FORMATS, or None for text.

    Raises:
        InputError: it cannot be read, is no file, is empty of what its suffix promises, or is of a known other kind.
    """
    try:
        if not stat.S_ISREG(os.stat(path).st_mode):
            what = "a directory" if os.path.isdir(path) else "a device or pipe"
            raise InputError(f"{path}: must be a file, got {what}")
        with open(path, "rb") as file:
            head = file.read(1024)
    except OSError as error:
        raise InputError(f"{path}: cannot be read: {error.strerror}") from None
    except ValueError as error:  # a zero byte in the name
        if isinstance(error, InputError):
            raise
        raise InputError(f"{path!r}: cannot be read: {error}") from None
    if HDF5_SIGNATURE in (head[:8], head[512:520]):
        return "hdf5"
    if head[:6] == b"MATLAB" and head[126:128] in (b"IM", b"MI"):
        return "matlab"
    if head[:8] in (b"MDF     ", b"UnFinMF "):
        return "mdf"
    if head[:4] == b"PAR1":
        return "parquet"
    for signature, what in OTHERS.items():
        if head.startswith(signature):
            raise InputError(f"{path}: must be a log (CSV, MATLAB, MDF or Parquet), got {what}")
    promised = SUFFIXES.get(Path(path).suffix.lower())
    if promised is not None:
        got = f"{head[:8]!r} at its start" if head else "an empty file"
        raise InputError(f"{path}: must be a {FORMATS[promised][0]} as its name says, got {got}")
    return None


def _read_with(kind: tuple[str, str, Reader], request: Request) -> dict[str, Any]:
    """Call a reader whose library may be missing, and may fail in any way on a broken file."""
    what, extra, reader = kind
    try:
        return reader(request)
    except InputError:
        raise
    except ImportError as error:
        raise request.refuse(
            f"needs {error.name or error} to read a {what}: pip install 'cogging[{extra}]'"
        ) from None
    except MemoryError:
        raise request.refuse(f"must be a whole {what}, got one that asks for more memory than there is") from None
    except Exception as error:
        said = " ".join(str(error).split())[:120]
        raise request.refuse(f"must be a whole {what}, got {type(error).__name__}{': ' * bool(said)}{said}") from None


def _numbers(request: Request, table: Mapping[str, Any]) -> dict[str, FloatArray]:
    """Check that what a reader gave is columns of finite real numbers of one length, and take the rows."""
    arrays: dict[str, FloatArray] = {}
    for name, values in table.items():
        array = np.asarray(values)
        if array.dtype.names is not None or array.dtype.kind == "c":
            complex_pair = array.dtype.kind == "c" or set(array.dtype.names or ()) == {"real", "imag"}
            what = "complex numbers" if complex_pair else f"a struct of {', '.join(array.dtype.names or ())}"
            raise request.refuse(f"{name}: must be real numbers, got {what}")
        if array.dtype.kind not in "fiub":
            raise request.refuse(f"{name}: must be real numbers, got {_kind(array)}")
        if sum(length != 1 for length in array.shape) > 1:
            shape = " x ".join(map(str, array.shape))
            raise request.refuse(f"{name}: must be one column, got an array of {shape}")
        arrays[name] = array.reshape(-1).astype(np.float64)
    lengths = {name: array.size for name, array in arrays.items()}
    first = next(iter(lengths), "")
    for name, length in lengths.items():
        if length != lengths[first]:
            raise request.refuse(f"{name}: must be as long as {first} ({lengths[first]}), got {length}")
    for name, array in arrays.items():
        arrays[name] = array = array[request.rows]
        bad = ~np.isfinite(array)
        if bad.any():
            row = int(np.argmax(bad))
            value = array[row]
            raise request.refuse(f"row {row + (request.rows.start or 0)}: {name}: must be a finite number, got {value:g}")
    return arrays


def _kind(array: npt.NDArray[Any]) -> str:
    return {"U": "text", "S": "text", "O": "objects (cells)", "M": "dates", "m": "durations"}.get(
        array.dtype.kind, str(array.dtype)
    )
