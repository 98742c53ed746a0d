"""Reading and writing files so that a bad one is answered in one line and none is left half written."""

from __future__ import annotations

import contextlib
import errno
import itertools
import json
import math
import os
import re
import secrets
import stat
import sys
import unicodedata
from collections.abc import Iterable, Iterator, Mapping, Sequence
from pathlib import Path
from typing import IO, Any

import tomli_w

from cogging.shown import printable, quoted

if sys.version_info >= (3, 11):
    import tomllib
else:
    import tomli as tomllib

MOST_TEXT = 1 << 28  # bytes of a model, a reference, or what stands beside a log


DEEPEST = 32  # tables and lists in one another: no file of ours has more than four
DOTTED = rf"""(?<![\w-])(?:(?:"[^"\n]*"|'[^'\n]*'|[\w-]+)[ \t]*\.[ \t]*){{{DEEPEST + 1}}}"""
LARGEST = 1e30  # of a finite number in any unit: the square of its square is still a number
WHOLE = 1 << 63  # TOML's whole numbers have 64 bits


class InputError(ValueError):
    """An input that cannot be used: file, line or field, rule and value in one line."""


def write_text(path: str | os.PathLike[str], text: str) -> None:
    """Write a file beside its place and rename it, so that it is there whole or not at all."""
    write_bytes(path, text.encode())


def write_bytes(path: str | os.PathLike[str], content: bytes) -> None:
    """Write a binary file beside its place and rename it (see write_text)."""
    write_files({os.fspath(path): [content]})


def write_files(files: Mapping[str, Iterable[bytes]]) -> None:
    """Write files that belong together, each given in pieces: none takes its place before all are whole.

    What stands there is replaced: behind a link its target, with the mode that it had. A new file has the mode that
    the user's mask leaves.

    Raises:
        InputError: one cannot be written, or two are one file; nothing is left behind.
    """
    targets = {path: target_of(path) for path in files}
    for path, other in itertools.combinations(targets, 2):
        if same_file(targets[path], targets[other]):
            raise InputError(f"{path}, {other}: must be different files, got one twice")
    parts: dict[str, Path] = {}
    path = ""
    try:
        for path, pieces in files.items():
            parts[path] = targets[path].with_name(f".{secrets.token_hex(8)}.part")
            with _new_file(parts[path], targets[path]) as file:
                for piece in pieces:
                    file.write(piece)
        for path in files:
            parts[path].replace(targets[path])
    except OSError as error:
        raise InputError(f"{path}: cannot be written: {error.strerror}") from None
    finally:
        for part in parts.values():
            part.unlink(missing_ok=True)


def _new_file(part: Path, target: Path) -> IO[bytes]:
    """Open a file that was not there before, with owner and mode of the one that it will replace."""
    old = target.stat() if target.exists() else None
    flags = os.O_WRONLY | os.O_CREAT | os.O_EXCL | getattr(os, "O_BINARY", 0)
    descriptor = os.open(part, flags, 0o666 if old is None else 0o600)
    if old is not None and hasattr(os, "fchown"):
        if (old.st_uid, old.st_gid) != (os.geteuid(), os.getegid()):
            with contextlib.suppress(OSError):  # what only an administrator may
                os.fchown(descriptor, old.st_uid, old.st_gid)
        os.fchmod(descriptor, stat.S_IMODE(old.st_mode))
    return os.fdopen(descriptor, "wb")


def target_of(path: str | os.PathLike[str]) -> Path:
    """The file that an output is written to, behind links.

    Raises:
        InputError: there is a folder, a device or a pipe, its folder is missing, or it may not be written.
    """
    called = os.fspath(path) or "."
    try:
        target = Path(os.path.realpath(called))
        if target.is_symlink():
            raise InputError(f"{called}: cannot be written: {os.strerror(errno.ELOOP)}")
        if target.exists():
            if target.is_dir():
                raise InputError(f"{called}: cannot be written: {os.strerror(errno.EISDIR)}")
            require_file(target, called)
        elif not target.parent.is_dir():
            code = errno.ENOTDIR if target.parent.exists() else errno.ENOENT
            raise InputError(f"{called}: cannot be written: {os.strerror(code)}")
        if not os.access(target.parent, os.W_OK) or (target.exists() and not os.access(target, os.W_OK)):
            raise InputError(f"{called}: cannot be written: {os.strerror(errno.EACCES)}")
    except OSError as error:
        raise InputError(f"{called}: cannot be written: {error.strerror}") from None
    except InputError:
        raise
    except ValueError as error:  # a zero byte in the name
        raise InputError(f"{called!r}: cannot be written: {error}") from None
    return target


def same_file(one: str | os.PathLike[str], other: str | os.PathLike[str]) -> bool:
    """Whether two paths lead to one file, by whatever name; of files that are not there yet, whether they would."""
    try:
        return os.path.samefile(one, other)
    except (OSError, ValueError):
        return _place(one) == _place(other)


def _place(path: str | os.PathLike[str]) -> str:
    try:
        place = os.path.normcase(os.path.realpath(path))
    except ValueError:  # a zero byte in the name
        return repr(path)
    return unicodedata.normalize("NFD", place).casefold() if sys.platform == "darwin" else place


def require_file(path: str | os.PathLike[str], called: str = "") -> int:
    """Refuse what is no file with an end, before it is opened: a pipe would wait for ever. Its size in bytes.

    Raises:
        InputError: a directory, a device or a pipe.
        OSError: it is not there.
    """
    status = os.stat(path)
    if not stat.S_ISREG(status.st_mode):
        what = "a directory" if stat.S_ISDIR(status.st_mode) else "a device or pipe"
        raise InputError(f"{called or path}: must be a file, got {what}")
    return status.st_size


def read_text(path: str | os.PathLike[str]) -> str:
    """Read a text file.

    Raises:
        InputError: the file is missing, cannot be read, is larger than MOST_TEXT or is no text.
    """
    try:
        size = require_file(path)
        with open(path, encoding="utf-8-sig") as file:
            text = file.read(MOST_TEXT + 1) if size <= MOST_TEXT else ""
    except OSError as error:
        raise InputError(f"{path}: cannot be read: {error.strerror}") from None
    except UnicodeDecodeError as error:
        raise InputError(f"{path}: must be UTF-8 text, got the byte {error.object[error.start]:#x}") from None
    except InputError:
        raise
    except ValueError as error:  # a zero byte in the name
        raise InputError(f"{path!r}: cannot be read: {error}") from None
    if max(size, len(text)) > MOST_TEXT:
        raise InputError(f"{path}: must be at most {MOST_TEXT >> 20} MiB of text, got {max(size, len(text))} bytes")
    return text


def read_toml(path: str | os.PathLike[str]) -> dict[str, Any]:
    """Read a TOML file.

    Raises:
        InputError: the file cannot be read, breaks TOML's grammar, or holds what parse_toml refuses; names the line.
    """
    text = read_text(path)
    try:
        return parse_toml(text)
    except FieldError as error:
        raise error.in_file(path, text) from None
    except ValueError as error:
        raise InputError(f"{path}: must be TOML: {error}") from None


def parse_toml(text: str) -> dict[str, Any]:
    """Parse TOML text.

    Raises:
        ValueError: it breaks TOML's grammar, or is nested without end.
        FieldError: a number that 64 bits do not hold, which would be another one or infinite.
    """
    if re.search(DOTTED, text):  # the parser takes a time that grows as the square of their number
        raise ValueError(f"a key must have at most {DEEPEST} dots")
    try:
        document = tomllib.loads(text, parse_float=_float)
    except RecursionError:
        raise ValueError(f"tables and lists must be nested at most {DEEPEST} deep") from None
    except tomllib.TOMLDecodeError:
        raise
    except ValueError:  # Python's own limit of digits
        raise ValueError("a whole number must have 64 bits, got one of thousands of digits") from None
    for path, value in _entries(document):
        if isinstance(value, _Beyond) or (isinstance(value, int) and not -WHOLE <= value < WHOLE):
            *sections, key = path
            number = value.text if isinstance(value, _Beyond) else quoted(value)
            raise FieldError(".".join(sections), key, f"must be a number that 64 bits hold, got {number}")
    return document


class _Beyond(float):
    """An infinity that was written as a finite number, `1e309`."""

    text = ""


def _float(text: str) -> float:
    value = float(text)
    if math.isinf(value) and "inf" not in text:
        value = _Beyond(text)
        value.text = text
    return value


def _entries(document: Mapping[str, Any]) -> Iterator[tuple[tuple[str, ...], Any]]:
    """The values of a document with the keys that lead to them; entries of lists have their list's.

    Raises:
        ValueError: tables and lists are nested too deep.
    """
    pending: list[tuple[tuple[str, ...], Any]] = [((), document)]
    for _ in range(DEEPEST + 1):
        below: list[tuple[tuple[str, ...], Any]] = []
        for path, value in pending:
            if isinstance(value, Mapping):
                below += [((*path, key), entry) for key, entry in value.items()]
            elif isinstance(value, list):
                below += [(path, entry) for entry in value]
            else:
                yield path, value
        pending = below
    if pending:
        raise ValueError(f"tables and lists must be nested at most {DEEPEST} deep")


def to_toml(document: Mapping[str, Any]) -> str:
    """Format a document as TOML text, numbers to their last bit."""
    return tomli_w.dumps(document)


def to_json(document: Any, *, indent: int = 1) -> str:
    """Format a document as strict JSON text with a line end: null stands for a number that is not finite."""
    return json.dumps(finite(document), indent=indent, allow_nan=False) + "\n"


def finite(value: Any) -> Any:
    """A copy for JSON: tuples and arrays as lists, numbers that are not finite as None, texts that UTF-8 can hold."""
    if isinstance(value, Mapping):
        return {str(key): finite(entry) for key, entry in value.items()}
    if isinstance(value, str):
        return value if value.isascii() else "".join(printable(c) if "\ud800" <= c <= "\udfff" else c for c in value)
    if isinstance(value, bool | int) or value is None:
        return value
    if isinstance(value, Sequence):
        return [finite(entry) for entry in value]
    if hasattr(value, "tolist"):
        return finite(value.tolist())
    return float(value) if math.isfinite(value) else None


def line_of(text: str, section: str, key: str, occurrence: int = 0) -> int | None:
    """The line (from 1) on which a key of a section stands; occurrence counts [[section]] tables from 0."""
    here, seen = "", -1
    for number, line in enumerate(text.splitlines(), start=1):
        header = re.match(r"\s*\[\[?\s*([^\]]+?)\s*\]?\]", line)
        if header:
            here = header.group(1)
            seen += here == section
            if not key and here == section and seen == occurrence:
                return number
        elif here == section and (not section or seen == occurrence):
            found = re.match(r"\s*[\"']?([^\"'=]+?)[\"']?\s*=", line)
            if found and found.group(1) == key:
                return number
    return None


def refuse_unknown_keys(given: Iterable[str], known: Iterable[str], section: str) -> None:
    """Raise if a key is not known: an unknown key is an error, never ignored.

    Raises:
        FieldError: names the key and the known ones.
    """
    known = list(known)
    for key in given:
        if key not in known:
            raise FieldError(section, key, f"is not known here; known: {', '.join(known)}")


class FieldError(ValueError):
    """A field of a section that breaks a rule; the reader of the file adds file and line."""

    def __init__(self, section: str, key: str, problem: str, occurrence: int = 0) -> None:
        self.section, self.key, self.problem, self.occurrence = section, key, problem, occurrence
        path = ".".join(part for part in (section, key) if part)
        super().__init__(f"{path}: {problem}")

    def in_file(self, path: str | os.PathLike[str], text: str) -> InputError:
        """Make the error that names the file and, where it can be found, the line."""
        line = line_of(text, self.section, self.key, self.occurrence)
        place = f"{path}: line {line}" if line else f"{path}"
        return InputError(f"{place}: {self}")
