"""Results of commands: text for a person, JSON, files, and the next command.

The text goes to standard output, the next command last. `--json -` prints the JSON result instead, and `--quiet` prints
no text. Only errors go to standard error.
"""

from __future__ import annotations

import argparse
from collections.abc import Iterable, Mapping, Sequence
from typing import Any

from cogging.cli.terminal import print_text
from cogging.outputs import to_json, write_files
from cogging.shown import printable

STANDARD_OUTPUT = "-"
OUTPUT_GROUP = "output"  # group of options in the help


def add_answer_options(group: argparse._ActionsContainer, *, json: str = "the result") -> None:
    """Add `--json` and `--quiet`; `json`: what `--json` writes, in words."""
    group.add_argument("--json", metavar="OUT", help=f"write {json} as JSON; - is standard output")
    group.add_argument("-q", "--quiet", action="store_true", help="print only errors, and the result of --json -")


def json_file(arguments: argparse.Namespace) -> str | None:
    """Return the file of `--json`; None without one, and for standard output."""
    return None if arguments.json == STANDARD_OUTPUT else arguments.json


def print_part(arguments: argparse.Namespace, text: str) -> None:
    """Print a part of the text for a person, unless `--quiet` or `--json -` suppresses it."""
    if not arguments.quiet and arguments.json != STANDARD_OUTPUT:
        print_text(text)


def print_result(
    arguments: argparse.Namespace,
    text: str,
    *,
    document: Any = None,
    indent: int = 1,
    files: Mapping[str, Iterable[bytes]] | None = None,
    written: Sequence[str] = (),
    next_command: str = "",
) -> None:
    """Write the files of a command, all or none, and print its result.

    text: for a person; document, indent: for `--json`; files: content in pieces by path; written: files that exist
    already and are named; next_command: see cogging.cli.next_command.
    """
    json = "" if arguments.json is None else to_json(document, indent=indent)
    content: dict[str, Iterable[bytes]] = {} if json_file(arguments) is None else {arguments.json: [json.encode()]}
    content |= files or {}
    write_files(content)
    if arguments.json == STANDARD_OUTPUT:
        print_text(json.rstrip("\n"), plain=True)
    names = ", ".join(map(printable, [*written, *content]))
    for part in (text, f"{names} written" if names else "", f"next: {next_command}" if next_command else ""):
        if part:
            print_part(arguments, part)
