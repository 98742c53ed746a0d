"""Reading text files: a bad one raises one line that names file, field, rule and value."""

from __future__ import annotations

import contextlib
import functools
import math
import os
import re
import stat
import sys
from collections.abc import Iterable, Iterator
from pathlib import Path
from typing import Any

from cogging.calls import did_you_mean
from cogging.shown import nearest_name, quoted

if sys.version_info >= (3, 11):
    import tomllib
else:
    import tomli as tomllib

MOST_TEXT = 1 << 26  # bytes of a model, a reference or a sidecar
DEEPEST = 32  # dots of a key; keys of this package have at most four
DOTTED = rf"""(?<![\w-])(?:(?:"[^"\n]*"|'[^'\n]*'|[\w-]+)[ \t]*\.[ \t]*){{{DEEPEST + 1}}}"""
LARGEST = 1e30  # finite number in any unit: its fourth power is finite
WHOLE = 1 << 63  # TOML's integers have 64 bits


class InputError(ValueError):
    """An input that cannot be used: file, line or field, rule and value in one line."""


class FieldError(ValueError):
    """A field of a section that breaks a rule; the reader of the file adds file and line."""

    def __init__(self, section: str, key: str, problem: str, occurrence: int = 0) -> None:
        self.section, self.key, self.problem, self.occurrence = section, key, problem, occurrence
        path = ".".join(part for part in (section, key) if part)
        super().__init__(f"{path}: {problem}")

    def in_file(self, path: str | os.PathLike[str], text: str) -> InputError:
        """Return the error that names the file and, if it can be found, the line."""
        line = line_of(text, self.section, self.key, self.occurrence)
        place = f"{path}: line {line}" if line else f"{path}"
        return InputError(f"{place}: {self}")


@contextlib.contextmanager
def errors_of_section(name: str, occurrence: int = 0) -> Iterator[None]:
    """Let an error name section and occurrence; that of the core or of a class is "field: rule, got value"."""
    try:
        yield
    except FieldError as error:
        raise FieldError(error.section, error.key, error.problem, occurrence) from None
    except ValueError as error:
        key, _, problem = str(error).partition(": ")
        raise FieldError(name, key.rpartition(".")[2], problem, occurrence) from None


@contextlib.contextmanager
def errors_of(path: str | os.PathLike[str]) -> Iterator[None]:
    """Let the errors of a block be InputErrors that name a file, and the line of a field if it can be found."""
    try:
        yield
    except InputError:
        raise
    except FieldError as error:
        text = ""
        with contextlib.suppress(InputError):  # a file that is no text has no lines
            text = read_text(path)
        raise error.in_file(path, text) from None
    except ValueError as error:
        raise InputError(f"{os.fspath(path)}: {error}") from None


def require_file(path: str | os.PathLike[str], called: str = "") -> int:
    """Return the size of a regular file in bytes; raise InputError for a folder, device or pipe, which may block."""
    status = os.stat(path)
    if not stat.S_ISREG(status.st_mode):
        what = "a directory" if stat.S_ISDIR(status.st_mode) else "a device or pipe"
        raise InputError(f"{called or path}: must be a file, got {what}")
    return status.st_size


@contextlib.contextmanager
def reading(path: str | os.PathLike[str]) -> Iterator[None]:
    """Let the errors of opening and decoding a file be InputErrors that name it."""
    try:
        yield
    except OSError as error:
        raise InputError(f"{path}: cannot be read: {error.strerror}") from None
    except UnicodeDecodeError as error:
        raise InputError(f"{path}: must be UTF-8 text, got the byte {error.object[error.start]:#x}") from None
    except InputError:
        raise
    except ValueError as error:  # a zero byte in the name
        raise InputError(f"{path!r}: cannot be read: {error}") from None


def read_text(path: str | os.PathLike[str]) -> str:
    """Return the content of a UTF-8 text file of at most MOST_TEXT bytes."""
    with reading(path):
        size = require_file(path)
        with open(path, encoding="utf-8-sig") as file:
            text = file.read(MOST_TEXT + 1) if size <= MOST_TEXT else ""
    if max(size, len(text)) > MOST_TEXT:
        raise InputError(f"{path}: must be at most {MOST_TEXT >> 20} MiB of text, got {max(size, len(text))} bytes")
    return text


def read_toml(path: str | os.PathLike[str]) -> dict[str, Any]:
    """Return the content of a TOML file; an InputError names the line."""
    text = read_text(path)
    try:
        return parse_toml(text)
    except FieldError as error:
        raise error.in_file(path, text) from None
    except ValueError as error:
        raise InputError(f"{path}: must be TOML: {error}") from None


def parse_toml(text: str) -> dict[str, Any]:
    """Return the content of TOML text.

    Raises:
        ValueError: the text breaks TOML's grammar, or nests too deep.
        FieldError: a whole number exceeds 64 bits.
    """
    if re.search(DOTTED, text):  # the parser's time grows with the square of the dots
        raise ValueError(f"a key must have at most {DEEPEST} dots")
    try:
        document = tomllib.loads(text, parse_float=_float_or_text)
        _require_64_bits(document)
    except RecursionError:
        raise ValueError("tables and lists must not be nested so deep") from None
    except (tomllib.TOMLDecodeError, FieldError):
        raise
    except ValueError:  # Python's own limit of digits
        raise ValueError("a whole number must have 64 bits, got one of thousands of digits") from None
    return document


@functools.cache
def shipped_toml(path: str) -> dict[str, Any]:
    """Return the content of a TOML file of this package, by its path within it."""
    return parse_toml((Path(__file__).parent / path).read_text(encoding="utf-8"))


def _float_or_text(text: str) -> float | str:
    """Return a number; as text where it would become infinite (1e309), which no field accepts."""
    value = float(text)
    return text if math.isinf(value) and "inf" not in text else value


def _require_64_bits(value: Any, keys: tuple[str, ...] = ()) -> None:
    for key, entry in value.items() if isinstance(value, dict) else ():
        _require_64_bits(entry, (*keys, key))
    for entry in value if isinstance(value, list) else ():
        _require_64_bits(entry, keys)
    if isinstance(value, int) and not -WHOLE <= value < WHOLE:
        problem = f"must be a number that 64 bits hold, got {quoted(value)}"
        raise FieldError(".".join(keys[:-1]), keys[-1], problem)


def line_of(text: str, section: str, key: str, occurrence: int = 0) -> int | None:
    """Return the line (from 1) of a key of a section; occurrence counts [[section]] tables from 0."""
    here, seen = "", -1
    for number, line in enumerate(text.splitlines(), start=1):
        begun, header = line.lstrip(), ""
        if begun.startswith("["):  # parsed by hand: a regular expression takes the square of a line of blanks
            name, closed, _ = begun[2 if begun.startswith("[[") else 1 :].partition("]")
            header = name.strip() if closed else ""
        if header:
            here = header
            seen += here == section
            if not key and here == section and seen == occurrence:
                return number
        elif here == section and (not section or seen == occurrence):
            before, equals, _ = line.partition("=")
            if key and equals and before.strip() in (key, f'"{key}"', f"'{key}'"):
                return number
    return None


def refuse_unknown_keys(given: Iterable[str], known: Iterable[str], section: str) -> None:
    """Raise FieldError for a key that is not known: an unknown key is never ignored."""
    known = list(known)
    for key in given:
        if key not in known:
            raise FieldError(section, key, f"is unknown; {did_you_mean(key, known)}")


def refuse_mistyped(given: Iterable[str], key: str, section: str, occurrence: int = 0) -> None:
    """Raise FieldError if a required key is absent and a similar one is given."""
    given = list(given)
    near = None if key in given else nearest_name(key, given)
    if near is not None:
        raise FieldError(section, near, f"is unknown; did you mean {key}?", occurrence)
