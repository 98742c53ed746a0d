"""Tables: pandas frames with units, and small HTML tables for notebooks."""

from __future__ import annotations

import html
import importlib
import json
import math
from collections.abc import Iterable, Mapping, Sequence
from typing import Any

import numpy as np

from cogging.shown import printable, shortened

#: Extra of the package that installs a library.
EXTRAS = {"pandas": "frames", "xarray": "frames", "pyarrow": "parquet", "control": "control", "shtab": "completion"}
LONGEST_CELL = 80  # characters
#: Without colours, so that a table suits light and dark pages.
STYLE = "border-collapse: collapse; text-align: left; font-size: inherit"
SPACED = "padding: 0 1em 0 0; text-align: left"
RULE = "border-bottom: 1px solid currentColor; opacity: 0.75"


def library(name: str, submodule: str = "") -> Any:
    """Return an optional library, or a module of it; the ImportError of an absent one names the extra."""
    try:
        return importlib.import_module(f"{name}.{submodule}" if submodule else name)
    except ImportError as error:
        extra = EXTRAS[name]
        raise ImportError(f"{name} is needed but not installed: pip install 'cogging[{extra}]'") from error


def frame_of(columns: Mapping[str, Any] | Sequence[Mapping[str, Any]], units: Mapping[str, str], **more: Any) -> Any:
    """Return a pandas DataFrame of arrays by name, or of rows; `attrs` has the units of its columns, and `more`."""
    frame = library("pandas").DataFrame(dict(columns) if isinstance(columns, Mapping) else list(columns))
    frame.attrs.update(more)
    frame.attrs["units"] = _with_unit(frame.columns, units)
    return frame


def parquet_of(columns: Mapping[str, Any], units: Mapping[str, str]) -> bytes:
    """Return columns by name as a Parquet file, with their units for pandas (`attrs["units"]`) and in each field."""
    pyarrow, parquet = library("pyarrow"), library("pyarrow", "parquet")
    arrays = {name: np.asarray(values) for name, values in columns.items()}
    table = pyarrow.table({name: one.tolist() if one.dtype == object else one for name, one in arrays.items()})
    fields = [field.with_metadata({"units": units.get(field.name, "")}) for field in table.schema]
    # The key from which pandas.read_parquet restores attrs.
    known = {"PANDAS_ATTRS": json.dumps({"units": _with_unit(columns, units)})}
    sink = pyarrow.BufferOutputStream()
    parquet.write_table(table.cast(pyarrow.schema(fields, known)), sink, write_page_checksum=True)
    return bytes(sink.getvalue().to_pybytes())


def _with_unit(names: Iterable[str], units: Mapping[str, str]) -> dict[str, str]:
    return {name: units[name] for name in names if units.get(name, "1") not in ("", "1")}


def html_table(title: str, headers: Sequence[str], rows: Iterable[Sequence[Any]], notes: Iterable[str] = ()) -> str:
    """Return a table as HTML with all text escaped; numbers have six digits, None and NaN are empty."""
    head = "".join(f'<th style="{RULE}; {SPACED}">{_cell(name)}</th>' for name in headers)
    lines = ("".join(f'<td style="{SPACED}">{_cell(value)}</td>' for value in row) for row in rows)
    body = "".join(f"<tr>{line}</tr>" for line in lines)
    below = "".join(f"<div>{_text(note)}</div>" for note in notes)
    table = f'<table style="{STYLE}"><thead><tr>{head}</tr></thead><tbody>{body}</tbody></table>'
    return f'<div class="cogging"><div><b>{_text(title)}</b></div>{table}{below}</div>'


def _text(text: str) -> str:
    return html.escape(printable(text))


def _cell(value: Any) -> str:
    if value is None or (isinstance(value, float | np.floating) and math.isnan(value)):
        return ""
    if isinstance(value, bool | np.bool_):
        return "yes" if value else "no"
    if isinstance(value, float | np.floating):
        return f"{value:.6g}"
    if isinstance(value, list | tuple | np.ndarray):
        cells = [_cell(entry) for entry in np.ravel(np.asarray(value, dtype=object))[:6]]
        return ", ".join([*cells, "..."] if np.size(value) > 6 else cells)
    return _text(shortened(str(value), LONGEST_CELL))
