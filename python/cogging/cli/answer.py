"""How a command answers: a text, a result as JSON, files, and the next command; with `--quiet` and `--json -`.

What a person reads goes to standard output, the next command last, on a terminal and into a file alike. `--json -`
gives the result to standard output in its place, and `--quiet` leaves it out. Errors alone go to standard error.
"""

from __future__ import annotations

import argparse
from collections.abc import Iterable, Mapping, Sequence
from typing import Any

from cogging.cli.screen import require_open_output, say
from cogging.outputs import to_json, write_files
from cogging.shown import printable

STANDARD_OUTPUT = "-"
COMES_OUT = "what comes out"  # the group of options that say so


def add_answer_options(group: argparse._ActionsContainer, *, json: str = "the result") -> None:
    """Give a command `--json` and `--quiet`, as the last of what it writes.

    Args:
        group: named COMES_OUT, of the command.
        json: what `--json` writes, in words; "" for a command without it.
    """
    if json:
        group.add_argument("--json", metavar="OUT", help=f"where {json} is written as JSON; - is standard output")
    group.add_argument("-q", "--quiet", action="store_true", help="print errors alone, and what --json - asks for")


def json_file(arguments: argparse.Namespace) -> str | None:
    """The file that `--json` names; None without one, and where it is standard output, which must then be open."""
    path: str | None = arguments.json
    if path != STANDARD_OUTPUT:
        return path
    require_open_output()
    return None


def show(arguments: argparse.Namespace, text: str) -> None:
    """Print a part of the answer for a person, before all is done; nothing where it is not wanted."""
    if not arguments.quiet and getattr(arguments, "json", None) != STANDARD_OUTPUT:
        say(text)


def give(
    arguments: argparse.Namespace,
    text: str,
    *,
    document: Any = None,
    indent: int = 1,
    files: Mapping[str, Iterable[bytes]] | None = None,
    written: Sequence[str] = (),
    next_command: str = "",
) -> None:
    """Write what a command was asked for, and print its answer.

    Args:
        arguments: of the command, with what add_answer_options has added.
        text: the answer for a person, or "" where `show` has said it.
        document: the result for `--json`.
        indent: of the document.
        files: what is written now, in pieces, by path; all or none.
        written: files that stand already and are named.
        next_command: the sensible next one (cogging.cli.next_command), or nothing.
    """
    asked = getattr(arguments, "json", None)
    told = "" if asked is None else to_json(document, indent=indent)
    content: dict[str, Iterable[bytes]] = {}
    if asked is not None and asked != STANDARD_OUTPUT:
        content[asked] = [told.encode()]
    content |= files or {}
    write_files(content)
    if asked == STANDARD_OUTPUT:
        say(told.rstrip("\n"), plain=True)
    names = ", ".join(map(printable, [*written, *content]))
    for part in (text, f"{names} written" if names else "", f"next: {next_command}" if next_command else ""):
        if part:
            show(arguments, part)
