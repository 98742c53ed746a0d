"""What a message may show of a user's text: names, keys and values that are neutral to a terminal, and not endless."""

from __future__ import annotations

import difflib
from collections.abc import Iterable
from typing import Any

LONGEST_LINE = 1500  # characters of an answer
LONGEST_VALUE = 120  # characters of a value in it
ALIKE = 0.7  # of two names (twice the letters in common, of all), from which one is taken for the other mistyped
LONGEST_NAME = 200  # letters: what is longer is no slip of a finger, and would take its square to compare
BEGINNING = 3  # letters with which a name must have been begun to be taken for it


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


def nearest_name(name: str, known: Iterable[str]) -> str | None:
    """The name that was probably meant by one that is not known; None where nothing is near.

    Capitals and hyphens count as the letters that they stand for. A name without a dot may mean the last part of a
    path (`mass`: `axis.mass`), and the beginning of one name alone means that name.
    """
    written, best, found = _plain(str(name)), ALIKE, None
    names = [str(entry) for entry in known if len(str(entry)) <= LONGEST_NAME]
    if len(written) > LONGEST_NAME:
        return None
    matcher = difflib.SequenceMatcher(None, "", written)
    for entry in names:
        plain = _plain(entry)
        forms = [plain] if "." in written else [plain, plain.rpartition(".")[2]]
        for rank, form in enumerate(forms):
            matcher.set_seq1(form)
            if matcher.real_quick_ratio() < best or matcher.quick_ratio() < best:  # bounds of what the next line finds
                continue
            alike = matcher.ratio() - 0.01 * rank  # the whole name comes first
            if alike >= best and (found is None or alike > best):
                best, found = alike, entry
    if found is None and len(written) >= BEGINNING:
        begun = [entry for entry in names if _plain(entry).startswith(written)]
        found = begun[0] if len(begun) == 1 else None
    return found


def nearest(name: str, known: Iterable[str]) -> str:
    """The end of a message about a name that is not known: ` (did you mean 'mass'?)`, or nothing where none is near.

    Args:
        name: as it was typed.
        known: names that it might have been.
    """
    found = nearest_name(name, known)
    return "" if found is None else f" (did you mean {quoted(found)}?)"


def _plain(name: str) -> str:
    return name.strip().casefold().replace("-", "_")


def _escaped(character: str) -> str:
    code = ord(character)
    if 0xDC80 <= code <= 0xDCFF:  # how Python carries a byte of a name that it cannot decode
        return f"\\x{code - 0xDC00:02x}"
    return character.encode("unicode_escape").decode("ascii")
