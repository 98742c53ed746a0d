"""Colour on a terminal, for words that say the same without it."""

from __future__ import annotations

import os
import re
from typing import TextIO

BOLD, RED, GREEN, YELLOW, CYAN, PLAIN = (f"\x1b[{code}m" for code in ("1", "31", "32", "33", "36", "0"))
VERDICTS = {"named": GREEN, "no_gap": GREEN, "ambiguous": YELLOW, "unlisted": YELLOW}  # the others: RED
#: What is coloured of a line, and how; the first that fits.
PATTERNS = (
    (re.compile(r"^verdict: (\w+)"), ""),
    (re.compile(r"^  ([a-z]\w+(?: or [a-z][\w, ]*)?)(?=: confidence )"), BOLD),
    (re.compile(r"^\s*(warning:)"), YELLOW),
    (re.compile(r"^(next:) "), CYAN),
    (re.compile(r"^(cogging[ \w]*:) "), RED),
)


def wants_colour(stream: TextIO) -> bool:
    """Whether what is printed there may be coloured.

    NO_COLOR says no; FORCE_COLOR and CLICOLOR_FORCE say yes, whatever it is; else it must be a terminal that can, and
    CLICOLOR=0 says no (no-color.org, force-color.org, bixense.com/clicolors).
    """
    said = os.environ
    if said.get("NO_COLOR"):
        return False
    if said.get("FORCE_COLOR", "0") not in ("", "0", "false") or said.get("CLICOLOR_FORCE", "0") not in ("", "0"):
        return True
    if said.get("CLICOLOR") == "0" or said.get("TERM", "dumb" if os.name != "nt" else "") == "dumb":
        return False
    if os.name == "nt" and not (said.get("WT_SESSION") or said.get("TERM") or said.get("ANSICON")):
        return False  # an old console, which shows the codes
    try:
        return stream.isatty()
    except ValueError:  # closed
        return False


def coloured(text: str) -> str:
    """A text with its verdict, names and warnings coloured."""
    return "\n".join(map(_line, text.split("\n")))


def _line(line: str) -> str:
    for pattern, colour in PATTERNS:
        found = pattern.match(line)
        if found:
            begin, end = found.span(1)
            paint = colour or BOLD + VERDICTS.get(found[1], RED)
            return f"{line[:begin]}{paint}{line[begin:end]}{PLAIN}{line[end:]}"
    return line
