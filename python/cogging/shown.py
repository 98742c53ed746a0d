"""Text in messages: values and names escaped for a terminal and shortened, and the nearest known name."""

from __future__ import annotations

import difflib
from collections.abc import Iterable
from typing import Any

LONGEST_LINE = 1500  # characters of a message
LONGEST_VALUE = 120  # characters of a value in it
SIMILAR = 0.7  # twice the matching letters over all letters, from which one name counts as the other mistyped
LONGEST_NAME = 200  # letters; a longer name is no typing error, and comparing takes the square of its length
BEGINNING = 3  # letters that may abbreviate a name


def printable(text: str, keep: str = "") -> str:
    r"""Return a text with control, formatting and unassigned characters escaped, as `\x1b`, except those in `keep`."""
    if text.isprintable():
        return text
    shown = []
    for character in text:
        code = ord(character)
        if character.isprintable() or character in keep:
            shown.append(character)
        elif 0xDC80 <= code <= 0xDCFF:  # how Python represents a byte of a name that it cannot decode
            shown.append(f"\\x{code - 0xDC00:02x}")
        else:
            shown.append(character.encode("unicode_escape").decode("ascii"))
    return "".join(shown)


def one_line(text: str) -> str:
    """Return a message as one printable line of limited length."""
    return shortened(printable(text.strip()), LONGEST_LINE)


def quoted(value: Any) -> str:
    """Return the repr of a value, shortened."""
    try:
        text = repr(value)
    except (ValueError, RecursionError):  # an integer of thousands of digits, or endlessly nested lists
        return f"a value too long to show ({type(value).__name__})"
    return shortened(text, LONGEST_VALUE)


def shortened(text: str, longest: int) -> str:
    """Return a text of about `longest` characters, its middle left out if it is longer."""
    return text if len(text) <= longest else f"{text[: 2 * longest // 3]} ... {text[-longest // 3 :]}"


def nearest_name(name: str, known: Iterable[str]) -> str | None:
    """Return the known name that was probably meant, or None.

    A name without a dot may mean the last part of a path (`mass`: `axis.mass`), and the beginning of exactly one name
    means that name.
    """
    written = _plain(str(name))
    names = [str(entry) for entry in known if len(str(entry)) <= LONGEST_NAME]
    if len(written) > LONGEST_NAME:
        return None
    forms = {_plain(entry): entry for entry in reversed(names)}
    if "." not in written:
        forms |= {form: entry for entry in names if (form := _plain(entry).rpartition(".")[2]) not in forms}
    if similar := difflib.get_close_matches(written, forms, n=1, cutoff=SIMILAR):
        return forms[similar[0]]
    begun = [entry for entry in names if _plain(entry).startswith(written)]
    return begun[0] if len(begun) == 1 and len(written) >= BEGINNING else None


def nearest(name: str, known: Iterable[str]) -> str:
    """Return ` (did you mean 'mass'?)` for the end of a message, or nothing if no known name is near."""
    found = nearest_name(name, known)
    return "" if found is None else f" (did you mean {quoted(found)}?)"


def not_one_of(value: Any, known: Iterable[str]) -> str:
    """Return the rule that a value breaks: `must be one of mass, force, got 'mas' (did you mean 'mass'?)`."""
    names = list(known)
    return f"must be one of {', '.join(names)}, got {quoted(value)}{nearest(str(value), names)}"


def _plain(name: str) -> str:
    return name.strip().casefold().replace("-", "_")
