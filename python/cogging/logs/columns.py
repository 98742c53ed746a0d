"""Named columns of numbers from files of all formats."""

from __future__ import annotations

import os
from collections.abc import Mapping, Sequence
from pathlib import Path

import numpy as np

from cogging.arrays import FloatArray
from cogging.files import InputError, reading, require_file
from cogging.logs.readers import text_table
from cogging.logs.readers.column_request import Request
from cogging.logs.readers.isolate import FORMATS, read_isolated
from cogging.shown import nearest

SUFFIXES = {".mat": "matlab", ".mf4": "mdf", ".mdf": "mdf", ".parquet": "parquet"}
HDF5_SIGNATURE = b"\x89HDF\r\n\x1a\n"
OTHERS = {  # files that users give by mistake
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
    notes: list[str] | None = None,
) -> dict[str, FloatArray]:
    """Read named columns of a text table (CSV), MATLAB, ASAM MDF or Parquet file.

    The first bytes of the file determine the format. A text table has a header row, possibly below other lines, and
    commas, semicolons, tabs or blanks between columns. All numbers have a decimal point, or a decimal comma if columns
    are separated otherwise or numbers are quoted. A unit may follow a name, `position [mm]`: one that is not SI (or V,
    A, N) is refused unless `scale` gives a factor.

    Args:
        path: the file.
        names: columns that must be there.
        optional: columns that may be there.
        columns: names in the file by name here (`{"position": "qm"}`).
        scale: factors by name here.
        rows: the data rows to read, counted from 0.
        notes: extended by notes on the numbers of the file: decimal commas.

    Returns:
        The columns by name, each (n,).
    """
    columns, scale, rows = dict(columns or {}), dict(scale or {}), rows or slice(0, None)
    known, start, stop = (*names, *optional), rows.start or 0, rows.stop
    for option, name in [("columns", name) for name in columns] + [("scale", name) for name in scale]:
        if name not in known:
            raise InputError(f"{option}: {name}: must be one of {', '.join(known)}{nearest(name, known)}")
    for name, factor in scale.items():
        if not np.isfinite(factor) or factor == 0.0:
            raise InputError(f"scale: {name}: must be a finite number and not 0, got {factor!r}")
    if rows.step not in (None, 1) or start < 0 or (stop is not None and stop <= start):
        raise InputError(f"rows: needs 0 <= first < end and a step of 1, got {start}:{stop}")
    request = Request(path, tuple(names), tuple(optional), columns, frozenset(scale), slice(start, stop))
    kind = format_of(path)
    arrays = text_table.read(request) if kind is None else read_isolated(kind, request)
    if notes is not None:
        notes += request.notes
    if not arrays or not next(iter(arrays.values())).size:
        raise request.refuse("rows: must be at least 1, got 0")
    for name, factor in scale.items():
        if name in arrays and factor != 1.0:
            with np.errstate(over="ignore"):
                arrays[name] = arrays[name] * factor
            if not np.isfinite(arrays[name]).all():
                raise request.refuse(f"{name}: must stay finite when scaled, got a factor of {factor:g}")
    return arrays


def survey_columns(path: str | os.PathLike[str]) -> list[tuple[str, str]]:
    """Return the names of all columns of a file, each with the unit that the file states separately, or ""."""
    request = Request(path, (), survey=[])
    kind = format_of(path)
    if kind is None:
        text_table.survey(request)
    else:
        read_isolated(kind, request)
    return request.survey or []


def format_of(path: str | os.PathLike[str]) -> str | None:
    """Return the format of a file from its first bytes: a key of FORMATS, or None for text."""
    with reading(path):
        require_file(path)
        with open(path, "rb") as file:
            head = file.read(1024)
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
