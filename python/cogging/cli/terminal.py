"""What commands print: text on standard output, one line on standard error, and colour."""

from __future__ import annotations

import os
import re
import sys
from typing import TextIO

from cogging.files import InputError
from cogging.shown import one_line, printable

BOLD, RED, GREEN, YELLOW, CYAN, PLAIN = (f"\x1b[{code}m" for code in ("1", "31", "32", "33", "36", "0"))
VERDICTS = {"named": GREEN, "no_gap": GREEN, "ambiguous": YELLOW, "unlisted": YELLOW}  # the others: RED
#: What is coloured in a line, and how; the first pattern that matches.
PATTERNS = (
    (re.compile(r"^verdict: (\w+)"), ""),
    (re.compile(r"^  ([a-z]\w+(?: or [a-z][\w, ]*)?)(?=: confidence )"), BOLD),
    (re.compile(r"^\s*(warning:)"), YELLOW),
    (re.compile(r"^(next:) "), CYAN),
    (re.compile(r"^(cogging[ \w]*:) "), RED),
)


def print_text(text: str, *, plain: bool = False) -> None:
    """Print a text on standard output, with control characters and what the encoding lacks escaped.

    If the reader has gone, as `head -1` does, the rest is discarded. `plain`: for a program, never coloured.
    """
    out = sys.stdout
    encoding = getattr(out, "encoding", None) or "utf-8"
    safe = printable(text, keep="\n").encode(encoding, "backslashreplace").decode(encoding)
    if not plain and wants_colour(out):
        safe = coloured(safe)
    try:
        out.write(f"{safe}\n")
        out.flush()
    except BrokenPipeError:
        _discard(out)
    except OSError as error:
        _discard(out)
        raise InputError(f"standard output: cannot be written: {error.strerror}") from None


def print_error(text: str) -> None:
    """Print one line on standard error."""
    line = one_line(text)
    try:
        sys.stderr.write((coloured(line) if wants_colour(sys.stderr) else line) + "\n")
        sys.stderr.flush()
    except OSError:  # nobody reads it
        _discard(sys.stderr)


def _discard(stream: TextIO) -> None:
    """Discard what a stream has buffered, so that the interpreter does not try again to write it."""
    try:
        null = os.open(os.devnull, os.O_WRONLY)
        os.dup2(null, stream.fileno())
        os.close(null)
    except (OSError, ValueError):  # a stream without a descriptor
        pass


def wants_colour(stream: TextIO) -> bool:
    """Return whether text on a stream is coloured.

    NO_COLOR forbids it; FORCE_COLOR and CLICOLOR_FORCE demand it; otherwise the stream must be a capable terminal, and
    CLICOLOR=0 forbids it (no-color.org, force-color.org, bixense.com/clicolors).
    """
    wishes = os.environ
    if wishes.get("NO_COLOR"):
        return False
    if wishes.get("CLICOLOR_FORCE", "0") not in ("", "0") or wishes.get("FORCE_COLOR", "0") not in ("", "0", "false"):
        return True
    kind = wishes.get("TERM") or wishes.get("WT_SESSION") or wishes.get("ANSICON")  # Windows has the latter two
    return wishes.get("CLICOLOR") != "0" and kind not in (None, "dumb") and not stream.closed and stream.isatty()


def coloured(text: str) -> str:
    """Return a text with verdict, names and warnings coloured."""
    lines = text.split("\n")
    for place, line in enumerate(lines):
        found, colour = next(((hit, paint) for pattern, paint in PATTERNS if (hit := pattern.match(line))), (None, ""))
        if found is not None:
            begin, end = found.span(1)
            paint = colour or BOLD + VERDICTS.get(found[1], RED)
            lines[place] = f"{line[:begin]}{paint}{line[begin:end]}{PLAIN}{line[end:]}"
    return "\n".join(lines)
