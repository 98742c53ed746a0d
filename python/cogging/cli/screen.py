"""What the command prints: texts on standard output, one line on standard error, whatever stands at the other end."""

from __future__ import annotations

import os
import sys
from typing import TextIO

from cogging.cli.colour import coloured, wants_colour
from cogging.files import InputError
from cogging.shown import one_line, printable


def stand_in_for_closed_streams() -> None:
    """Where standard output or error was closed before the command began, let what is printed there go nowhere.

    Libraries write to both without asking, and the next file that is opened would take the closed one's number.
    """
    for name in ("stdout", "stderr"):
        if getattr(sys, name) is None:
            setattr(sys, name, open(os.devnull, "w", encoding="utf-8"))  # noqa: SIM115 (until the end of the process)


def require_open_output() -> None:
    """Refuse a standard output that was closed before the command began, where a program is to read it."""
    if getattr(sys.stdout, "name", None) == os.devnull:  # what stands in; one that leads to it is named <stdout>
        raise InputError("standard output: must be open for what is asked, got a closed one")


def say(text: str, *, plain: bool = False) -> None:
    """Print a text on standard output.

    What the terminal would obey and what its encoding lacks is escaped. A reader that has gone, as `head -1` does,
    has seen enough: the rest of the output goes nowhere, and the command does what it was asked for to its end.

    Args:
        text: of any number of lines.
        plain: what a program reads, which is never coloured.
    """
    if plain:
        require_open_output()
    out = sys.stdout
    encoding = getattr(out, "encoding", None) or "utf-8"
    safe = printable(text, keep="\n").encode(encoding, "backslashreplace").decode(encoding)
    if not plain and wants_colour(out):
        safe = coloured(safe)
    try:
        out.write(f"{safe}\n")
        out.flush()
    except BrokenPipeError:
        _give_up(out)
    except OSError as error:
        _give_up(out)
        raise InputError(f"standard output: cannot be written: {error.strerror}") from None


def complain(text: str) -> None:
    """Print one line on standard error."""
    line = one_line(text)
    try:
        sys.stderr.write((coloured(line) if wants_colour(sys.stderr) else line) + "\n")
        sys.stderr.flush()
    except OSError:  # nobody to tell
        _give_up(sys.stderr)


def _give_up(stream: TextIO) -> None:
    """Let what is still in a stream's buffer go nowhere, so that the interpreter's end does not try once more."""
    try:
        nowhere = os.open(os.devnull, os.O_WRONLY)
        os.dup2(nowhere, stream.fileno())
        os.close(nowhere)
    except (OSError, ValueError):  # a stream without a descriptor
        pass
