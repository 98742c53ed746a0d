"""Parquet files, through pyarrow."""

from __future__ import annotations

from typing import Any

from cogging.logs.readers.column_request import Request


def read(request: Request) -> dict[str, Any]:
    """Return columns of a Parquet file; a unit is in the name or in the field's metadata `unit`."""
    import pyarrow as pa
    import pyarrow.parquet as parquet

    with parquet.ParquetFile(request.path, page_checksum_verification=True) as file:
        schema = file.schema_arrow
        units = [(field.metadata or {}).get(b"unit", b"").decode(errors="replace") for field in schema]
        chosen = request.choose(list(schema.names), "file", units)
        for name, place in chosen.items():
            kind = schema.field(place).type
            if not (pa.types.is_floating(kind) or pa.types.is_integer(kind) or pa.types.is_decimal(kind)):
                raise request.refuse(f"{name}: must be real numbers, got {kind}")
        rows = file.metadata.num_rows
        request.require_room("rows", rows, float(rows) * len(chosen))
        columns = {}
        for name, place in chosen.items():
            values = file.read(columns=[schema.names[place]], use_threads=False).column(0)
            if values.null_count:
                row = values.is_null().to_numpy().argmax()
                raise request.refuse(f"row {row}: {name}: must be a finite number, got null")
            columns[name] = values.cast(pa.float64()).to_numpy()
        return columns
