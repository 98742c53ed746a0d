"""Tables of runs, one row a run: pandas, xarray, CSV and Parquet, with units."""

from __future__ import annotations

import csv
import io
import os
from collections.abc import Iterable, Mapping, Sequence
from typing import Any

import numpy as np

from cogging.arrays import FloatArray
from cogging.outputs import write_bytes
from cogging.simulation.reductions import unit_of
from cogging.tables import frame_of, library, parquet_of
from cogging.values import ByValue


class RunsTable(ByValue):
    """Base of results with one row a run; a subclass gives the columns and their units."""

    def _rows(self) -> tuple[Mapping[str, Any], Mapping[str, str]]:
        """Return the columns by name, (runs,), and units beside those of `unit_of`."""
        raise NotImplementedError

    def _recorded(self) -> Mapping[str, Sequence[FloatArray]]:
        """Return recorded columns by name, one array a run."""
        return {}

    def to_pandas(self) -> Any:
        """Return the table as a pandas DataFrame with `run` as its index and the units in `attrs["units"]`.

        Raises:
            ImportError: pandas is not installed; names the extra.
        """
        table, units = self._rows()
        return frame_of(table, _with_known_units(table, units)).set_index("run")

    to_frame = to_pandas

    def to_xarray(self) -> Any:
        """Return an xarray Dataset: the table over `run`, recorded columns over `run` and `row`, with their `units`.

        A shorter run is padded with NaN.

        Raises:
            ImportError: xarray is not installed; names the extra.
        """
        xarray = library("xarray")
        table, units = self._rows()
        variables: dict[str, Any] = {name: ("run", np.asarray(table[name])) for name in table if name != "run"}
        for name, runs in self._recorded().items():
            padded = np.full((len(runs), max(map(len, runs), default=0)), np.nan)
            for place, values in enumerate(runs):
                padded[place, : len(values)] = values
            variables[name] = (("run", "row"), padded)
        dataset = xarray.Dataset(variables, coords={"run": np.asarray(table["run"])})
        for name, unit in _with_known_units(variables, units).items():
            dataset[name].attrs["units"] = unit
        return dataset

    def write(self, path: str | os.PathLike[str]) -> None:
        """Write the table as CSV, NaN as empty, or as Parquet with `units` if the name ends in `.parquet`.

        Raises:
            InputError: the file cannot be written.
            ImportError: pyarrow is not installed; names the extra.
        """
        table, units = self._rows()
        if is_parquet(path):
            write_bytes(path, parquet_of(table, _with_known_units(table, units)))
            return
        text = io.StringIO()
        writer = csv.writer(text, lineterminator="\n")
        writer.writerow(table)
        columns = [["" if value != value else value for value in np.asarray(one).tolist()] for one in table.values()]
        writer.writerows(zip(*columns, strict=True))
        write_bytes(path, text.getvalue().encode())


def is_parquet(path: str | os.PathLike[str]) -> bool:
    """Return whether a file name ends in `.parquet`."""
    return os.fspath(path).lower().endswith(".parquet")


def _with_known_units(names: Iterable[str], units: Mapping[str, str]) -> dict[str, str]:
    return {name: unit for name in names if (unit := units.get(name) or unit_of(name))}
