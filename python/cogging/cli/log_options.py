"""The options of every command that reads logs or scans: what columns are called, their factors, the rows to take."""

from __future__ import annotations

import argparse
from collections.abc import Sequence

from cogging.logs.log import Log, read_log
from cogging.shown import quoted


def add_log_options(command: argparse.ArgumentParser) -> None:
    """Give a command the options `--columns`, `--scale` and `--rows`."""
    command.add_argument(
        "--columns", type=_pairs, default={}, metavar="NAME=IN_FILE,...", help="what columns are called in the file"
    )
    command.add_argument(
        "--scale", type=_factors, default={}, metavar="NAME=FACTOR,...", help="factors on columns of the file"
    )
    command.add_argument("--rows", type=_rows, default=None, metavar="FIRST:END", help="the data rows to take, from 0")


def read_logs(arguments: argparse.Namespace, paths: Sequence[str]) -> list[Log]:
    """Read logs as the options say.

    Raises:
        InputError: one cannot be read as a log.
    """
    return [read_log(path, columns=arguments.columns, scale=arguments.scale, rows=arguments.rows) for path in paths]


def _pairs(text: str) -> dict[str, str]:
    pairs = {}
    for entry in text.split(","):
        name, equals, value = entry.partition("=")
        if not (name and equals and value):
            raise argparse.ArgumentTypeError(f"must be NAME=VALUE,..., got {quoted(text)}")
        pairs[name.strip()] = value.strip()
    return pairs


def _factors(text: str) -> dict[str, float]:
    try:
        return {name: float(value) for name, value in _pairs(text).items()}
    except ValueError:
        raise argparse.ArgumentTypeError(f"must be NAME=NUMBER,..., got {quoted(text)}") from None


def _rows(text: str) -> slice:
    try:
        first, last = text.split(":")
        rows = slice(int(first) if first else 0, int(last) if last else None)
    except ValueError:
        raise argparse.ArgumentTypeError(f"must be FIRST:END, got {quoted(text)}") from None
    if (rows.start < 0) or (rows.stop is not None and rows.stop <= rows.start):
        raise argparse.ArgumentTypeError(f"needs 0 <= FIRST < END, got {quoted(text)}")
    return rows
