"""Tables of runs as others' frames and files; the libraries are extras, imported where they are used."""

from __future__ import annotations

import csv
import io
import os
import types
from collections.abc import Iterable, Mapping, Sequence
from typing import Any

import numpy as np

from cogging.arrays import FloatArray
from cogging.outputs import write_bytes
from cogging.simulation.reductions import unit_of
from cogging.tables import frame_of, library


def to_pandas(table: Mapping[str, Any]) -> Any:
    """A pandas DataFrame of columns by name."""
    return library("pandas").DataFrame(dict(table))


def to_frame(table: Mapping[str, Any], units: Mapping[str, str] = types.MappingProxyType({})) -> Any:
    """A pandas DataFrame of columns by name, with their units in `attrs["units"]`.

    Args:
        table: arrays by name, (runs,).
        units: by name, beside those of `unit_of`.
    """
    return frame_of(table, _units(table, units))


def to_xarray(
    table: Mapping[str, Any],
    columns: Mapping[str, Sequence[FloatArray]],
    units: Mapping[str, str] = types.MappingProxyType({}),
) -> Any:
    """An xarray Dataset: a table over `run`, and columns over `run` and `row`, NaN beyond the end of a shorter one.

    Each variable has its unit as the attribute `units`, where it has one.

    Args:
        table: arrays by name, (runs,).
        columns: arrays by name, one a run.
        units: by name, beside those of `unit_of`.
    """
    xarray = library("xarray")
    variables: dict[str, Any] = {name: ("run", np.asarray(values)) for name, values in table.items() if name != "run"}
    for name, runs in columns.items():
        rows = max(map(len, runs), default=0)
        variables[name] = (("run", "row"), np.full((len(runs), rows), np.nan))
        for place, values in enumerate(runs):
            variables[name][1][place, : len(values)] = values
    dataset = xarray.Dataset(variables, coords={"run": np.asarray(table["run"])})
    for name, unit in _units(variables, units).items():
        dataset[name].attrs["units"] = unit
    return dataset


def write_frame(
    path: str | os.PathLike[str],
    table: Mapping[str, Any],
    units: Mapping[str, str] = types.MappingProxyType({}),
) -> None:
    """Write a table, whole or not at all: Parquet where the name ends so, with `units` of its columns, else CSV."""
    write_bytes(path, frame_bytes(path, table, units))


def is_parquet(path: str | os.PathLike[str]) -> bool:
    """Whether the name of a file says that it is Parquet."""
    return os.fspath(path).lower().endswith(".parquet")


def frame_bytes(path: str | os.PathLike[str], table: Mapping[str, Any], units: Mapping[str, str]) -> bytes:
    """A table as the file of this name holds it."""
    if is_parquet(path):
        pyarrow, parquet = library("pyarrow"), library("pyarrow", "parquet")
        sink, known = io.BytesIO(), _units(table, units)
        whole = pyarrow.table({name: _plain(values) for name, values in table.items()})
        fields = [field.with_metadata({"units": known.get(field.name, "")}) for field in whole.schema]
        parquet.write_table(whole.cast(pyarrow.schema(fields)), sink, write_page_checksum=True)
        return sink.getvalue()
    text = io.StringIO()
    writer = csv.writer(text, lineterminator="\n")
    writer.writerow(table)
    # Numbers to their last bit; none where there is none.
    columns = [["" if value != value else value for value in np.asarray(values).tolist()] for values in table.values()]
    writer.writerows(zip(*columns, strict=True))
    return text.getvalue().encode()


def _units(names: Iterable[str], units: Mapping[str, str]) -> dict[str, str]:
    known = {name: units.get(name) or unit_of(name) for name in names}
    return {name: unit for name, unit in known.items() if unit}


def _plain(values: Any) -> Any:
    array = np.asarray(values)
    return array.tolist() if array.dtype == object else array
