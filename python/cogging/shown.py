"""What a message may show of a user's text: names, keys and values that are neutral to a terminal, and not endless."""

from __future__ import annotations

from typing import Any

LONGEST_LINE = 1500  # characters of an answer
LONGEST_VALUE = 120  # characters of a value in it


def printable(text: str, keep: str = "") -> str:
    r"""A text in which what a terminal would obey, or cannot show, is written as an escape.

    Control characters, formatting characters (which may reverse a line) and unassigned ones become `\x1b`, `\u202e`;
    a byte of a file name that is no UTF-8 becomes `\xff`.

    Args:
        text: any.
        keep: characters that stay, such as the line ends of a text of several lines.
    """
    if text.isprintable():
        return text
    return "".join(c if c.isprintable() or c in keep else _escaped(c) for c in text)


def one_line(text: str) -> str:
    """A message as one printable line; the middle of an endless one is left out."""
    return shortened(printable(text.strip()), LONGEST_LINE)


def quoted(value: Any) -> str:
    """A value as an error shows it: as Python writes it, the middle of a long one left out."""
    try:
        text = repr(value)
    except (ValueError, RecursionError):  # an integer of thousands of digits, lists in lists without end
        return f"a value too long to show ({type(value).__name__})"
    return shortened(text, LONGEST_VALUE)


def shortened(text: str, longest: int) -> str:
    """A text of at most about so many characters, its middle left out where need be."""
    if len(text) <= longest:
        return text
    return f"{text[: 2 * longest // 3]} ... {text[-longest // 3 :]}"


def _escaped(character: str) -> str:
    code = ord(character)
    if 0xDC80 <= code <= 0xDCFF:  # how Python carries a byte of a name that it cannot decode
        return f"\\x{code - 0xDC00:02x}"
    return character.encode("unicode_escape").decode("ascii")
