"""The columns of numbers of a file, whatever else it holds."""

from __future__ import annotations

import contextlib
import os
from collections.abc import Sequence

from cogging.arrays import FloatArray
from cogging.files import InputError
from cogging.logs.columns import read_columns

GLANCE = slice(0, 64)  # rows in which a column is seen to be one of numbers

Table = dict[str, FloatArray]


def numbers(path: str | os.PathLike[str], labels: Sequence[str], rows: slice | None) -> Table:
    """The columns of numbers of the length that most of them have."""
    with contextlib.suppress(InputError):  # a text, a scalar, a hole among them
        return _columns(path, labels, rows) if labels else {}
    start = (rows.start or 0) if rows is not None else 0
    glance: dict[str, int] = {}
    for label in labels:
        try:
            found = _columns(path, [label], slice(start, start + GLANCE.stop))
        except InputError:  # text, or nothing
            continue
        glance[label] = len(found[label])
    longest = max(glance.values(), default=0)
    kept = [label for label, length in glance.items() if length == longest]
    try:
        return _columns(path, kept, rows) if kept else {}
    except InputError:  # one that is cut short or has a hole: each by itself
        tables = [table for label in kept if (table := _whole(path, label, rows)) is not None]
    lengths = [len(values) for table in tables for values in table.values()]
    usual = max(lengths, key=lengths.count, default=0)
    return {label: values for table in tables for label, values in table.items() if len(values) == usual}


def _whole(path: str | os.PathLike[str], label: str, rows: slice | None) -> Table | None:
    try:
        return _columns(path, [label], rows)
    except InputError:
        return None


def _columns(path: str | os.PathLike[str], labels: Sequence[str], rows: slice | None) -> Table:
    same = {label: label for label in labels}
    return read_columns(path, labels, columns=same, scale=dict.fromkeys(labels, 1.0), rows=rows)
