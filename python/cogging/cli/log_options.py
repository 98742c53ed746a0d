"""Options of commands that read logs or scans: names, factors and zeros of columns, and rows.

An option applies to all files, or to one file named before a colon: `--scale a.csv:command=35`.
"""

from __future__ import annotations

import argparse
import math
import re
from collections.abc import Callable, Mapping, Sequence
from functools import partial
from pathlib import Path
from typing import Any, TypeAlias

from cogging.arrays import FloatArray
from cogging.files import InputError
from cogging.logs.log import Log, read_log
from cogging.shown import nearest, quoted

ONE_FILE = "for one of several files, put its name before: %s"
NEXT = re.compile(r",(?=[^,=]*=)|,(?=\s*$)")  # before NAME=: a column of a file may have commas in its name
OPTIONS = ("columns", "scale", "zero", "rows")
Entries: TypeAlias = dict[str, dict[str, Any]]  # values by file ("": all) and name
Given: TypeAlias = tuple[str, Entries]  # an option's text, for the next command, and what it says


def add_log_options(command: argparse.ArgumentParser) -> None:
    """Add the options `--columns`, `--scale`, `--zero` and `--rows`."""
    group = command.add_argument_group("reading files")
    scales, zeros = "a.csv:command=35,b.csv:command=2", "a.csv:position=0.012"
    for option, convert, metavar, text, example in (
        ("--columns", _names, "NAME=IN_FILE,...", "names of columns in the file", "a.csv:position=qm"),
        ("--scale", _factors, "NAME=FACTOR,...", "factors on columns of the file", scales),
        ("--zero", _zeros, "NAME=VALUE,...", "values subtracted from columns, after the factors", zeros),
        ("--rows", _rows, "FIRST:END", "the data rows to read, from 0", "a.csv:0:500,b.csv:100:"),
    ):
        help = f"{text}; {ONE_FILE % example}"
        group.add_argument(option, action="append", type=convert, default=[], metavar=metavar, help=help)


def options_of(arguments: argparse.Namespace, path: str) -> tuple[dict[str, Any], dict[str, float]]:
    """Return columns, scale and rows with which a file is read, and the zeros of columns."""
    found: dict[str, dict[str, Any]] = {option: {} for option in OPTIONS}
    for option, values in found.items():
        for file in ("", Path(path).name, path):
            for _, entries in getattr(arguments, option):
                values.update(entries.get(file, {}))
    zero = found.pop("zero")
    return {**found, "rows": found["rows"].get("rows")}, zero


def read_logs(arguments: argparse.Namespace, paths: Sequence[str]) -> list[Log]:
    """Return logs read with these options."""
    require_known(arguments, [*arguments.logs, *getattr(arguments, "confirm", ())])
    logs = []
    for path in paths:
        how, zero = options_of(arguments, path)
        log = read_log(path, **how)
        logs.append(Log.of(without_zero(log.columns(), zero, path), log.metadata) if zero else log)
    return logs


def without_zero(columns: Mapping[str, FloatArray], zero: Mapping[str, float], path: str) -> dict[str, FloatArray]:
    """Return columns with their zeros subtracted."""
    for name in zero:
        if name not in columns:
            rule = f"must be a column of {path}, {', '.join(columns)}{nearest(name, columns)}"
            raise InputError(f"--zero: {quoted(name)}: {rule}")
    return {name: column - zero[name] if name in zero else column for name, column in columns.items()}


def require_known(arguments: argparse.Namespace, paths: Sequence[str]) -> None:
    """Raise InputError if an option names a file that the call does not read."""
    for option in OPTIONS:
        for file in (file for _, entries in getattr(arguments, option) for file in entries):
            if file and not any(file in (path, Path(path).name) for path in paths):
                rule = f"must be a file of this call, {', '.join(paths)}{nearest(file, paths)}"
                raise InputError(f"--{option}: {quoted(file)}: {rule}")


def _pairs(text: str, convert: Callable[[str], Any], rule: str) -> Given:
    pairs: Entries = {}
    for entry in NEXT.split(text):
        key, _, value = entry.partition("=")
        file, _, name = key.rpartition(":")
        try:
            if not (key and value):
                raise ValueError
            pairs.setdefault(file.strip(), {})[name.strip()] = convert(value.strip())
        except ValueError:
            raise argparse.ArgumentTypeError(f"must be {rule}, got {quoted(text)}") from None
    return text, pairs


_names = partial(_pairs, convert=str, rule="NAME=VALUE,...")
_factors = partial(_pairs, convert=float, rule="NAME=NUMBER,...")


def _zeros(text: str) -> Given:
    given = _factors(text)
    if not all(math.isfinite(value) for entries in given[1].values() for value in entries.values()):
        raise argparse.ArgumentTypeError(f"must be finite numbers, got {quoted(text)}")
    return given


def _rows(text: str) -> Given:
    found: Entries = {}
    for entry in text.split(","):
        before, colon, last = entry.rpartition(":")
        file, _, first = before.rpartition(":")
        try:
            start, stop = int(first or 0), int(last) if last else None
        except ValueError:
            colon = ""
        if not colon:
            raise argparse.ArgumentTypeError(f"must be FIRST:END, got {quoted(text)}")
        if start < 0 or (stop is not None and stop <= start):
            raise argparse.ArgumentTypeError(f"needs 0 <= FIRST < END, got {quoted(text)}")
        found[file.strip()] = {"rows": slice(start, stop)}
    return text, found
