"""Tables of runs as others' frames and files; the libraries are extras, imported where they are used."""

from __future__ import annotations

import csv
import io
import os
from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np

from cogging.arrays import FloatArray
from cogging.outputs import write_bytes

#: The extra of the package that brings a library.
EXTRAS = {"pandas": "frames", "xarray": "frames", "pyarrow": "parquet"}


def library(name: str, submodule: str = "") -> Any:
    """Import a library, or a module of it.

    Raises:
        ImportError: it is not there; names the extra that brings it.
    """
    import importlib

    try:
        return importlib.import_module(f"{name}.{submodule}" if submodule else name)
    except ImportError as error:
        extra = EXTRAS[name]
        raise ImportError(f"{name} is needed for this and is not there: pip install 'cogging[{extra}]'") from error


def to_pandas(table: Mapping[str, Any]) -> Any:
    """A pandas DataFrame of columns by name.

    Raises:
        ImportError: pandas is not there; names the extra.
    """
    return library("pandas").DataFrame(dict(table))


def to_xarray(table: Mapping[str, Any], columns: Mapping[str, Sequence[FloatArray]]) -> Any:
    """An xarray Dataset: a table over `run`, and columns over `run` and `row`, NaN beyond the end of a shorter one.

    Raises:
        ImportError: xarray is not there; names the extra.
    """
    xarray = library("xarray")
    variables: dict[str, Any] = {name: ("run", np.asarray(values)) for name, values in table.items() if name != "run"}
    for name, runs in columns.items():
        rows = max(map(len, runs), default=0)
        variables[name] = (("run", "row"), np.full((len(runs), rows), np.nan))
        for place, values in enumerate(runs):
            variables[name][1][place, : len(values)] = values
    return xarray.Dataset(variables, coords={"run": np.asarray(table["run"])})


def write_frame(path: str | os.PathLike[str], table: Mapping[str, Any]) -> None:
    """Write a table, whole or not at all: Parquet where the name ends so, else CSV.

    Raises:
        InputError: the file cannot be written.
        ImportError: pyarrow is not there; names the extra.
    """
    write_bytes(path, frame_bytes(path, table))


def is_parquet(path: str | os.PathLike[str]) -> bool:
    """Whether the name of a file says that it is Parquet."""
    return os.fspath(path).lower().endswith(".parquet")


def frame_bytes(path: str | os.PathLike[str], table: Mapping[str, Any]) -> bytes:
    """A table as the file of this name holds it.

    Raises:
        ImportError: pyarrow is not there; names the extra.
    """
    if is_parquet(path):
        pyarrow, parquet = library("pyarrow"), library("pyarrow", "parquet")
        sink = io.BytesIO()
        parquet.write_table(pyarrow.table({name: _plain(values) for name, values in table.items()}), sink)
        return sink.getvalue()
    text = io.StringIO()
    writer = csv.writer(text, lineterminator="\n")
    writer.writerow(table)
    # Numbers to their last bit; none where there is none.
    columns = [["" if value != value else value for value in np.asarray(values).tolist()] for values in table.values()]
    writer.writerows(zip(*columns, strict=True))
    return text.getvalue().encode()


def _plain(values: Any) -> Any:
    array = np.asarray(values)
    return array.tolist() if array.dtype == object else array
