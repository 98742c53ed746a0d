"""Reading and writing files so that a bad one is answered in one line and none is left half written."""

from __future__ import annotations

import os
import re
import sys
from collections.abc import Iterable, Mapping
from pathlib import Path
from typing import Any

import tomli_w

if sys.version_info >= (3, 11):
    import tomllib
else:
    import tomli as tomllib


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

    Raises:
        InputError: one cannot be written; nothing is left behind.
    """
    targets = {path: Path(path) for path in files}
    beside = {path: t.with_name(f".{t.name}.{os.getpid()}.part") for path, t in targets.items() if t.name}
    path = ""
    try:
        for path, pieces in files.items():
            if path not in beside or targets[path].is_dir():
                raise InputError(f"{path or '.'}: cannot be written: Is a directory")
            with open(beside[path], "wb") as file:
                for piece in pieces:
                    file.write(piece)
        for path in files:
            beside[path].replace(targets[path])
    except OSError as error:
        raise InputError(f"{path}: cannot be written: {error.strerror}") from None
    finally:
        for part in beside.values():
            part.unlink(missing_ok=True)


def read_text(path: str | os.PathLike[str]) -> str:
    """Read a text file.

    Raises:
        InputError: the file is missing, cannot be read or is no text.
    """
    try:
        return Path(path).read_text(encoding="utf-8-sig")
    except OSError as error:
        raise InputError(f"{path}: cannot be read: {error.strerror}") from None
    except UnicodeDecodeError as error:
        raise InputError(f"{path}: must be UTF-8 text, got the byte {error.object[error.start]:#x}") from None


def read_toml(path: str | os.PathLike[str]) -> dict[str, Any]:
    """Read a TOML file.

    Raises:
        InputError: the file cannot be read or breaks TOML's grammar; names the line.
    """
    try:
        return parse_toml(read_text(path))
    except tomllib.TOMLDecodeError as error:
        raise InputError(f"{path}: must be TOML: {error}") from None


def parse_toml(text: str) -> dict[str, Any]:
    """Parse TOML text."""
    return tomllib.loads(text)


def to_toml(document: Mapping[str, Any]) -> str:
    """Format a document as TOML text, numbers to their last bit."""
    return tomli_w.dumps(document)


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
