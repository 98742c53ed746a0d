"""Writing files: whole or not at all, never over an input, no output twice."""

from __future__ import annotations

import collections
import contextlib
import errno
import itertools
import json
import math
import os
import re
import secrets
import shutil
import stat
import zlib
from collections.abc import Iterable, Iterator, Mapping, Sequence
from pathlib import Path
from typing import Any

import tomli_w

from cogging.files import InputError, parse_toml, require_file
from cogging.shown import printable

AnyPath = str | os.PathLike[str]
synced = True  # data reach the disk before their names do; tests switch it off


def check_outputs(outputs: Mapping[str, AnyPath | None], inputs: Sequence[AnyPath] = ()) -> None:
    """Raise InputError if an output, by option, would overwrite an input or another output, or cannot be written."""
    given = {name: path for name, path in outputs.items() if path is not None}
    for name, path in given.items():
        for other in inputs:
            if same_file(path, other):
                raise InputError(f"{name}: {path}: must not be a file that is read, got {os.fspath(other)}")
    _require_different(given)
    for path in given.values():
        target_of(path)


def _require_different(paths: Mapping[str, AnyPath]) -> None:
    for (name, path), (second, other) in itertools.combinations(paths.items(), 2):
        if same_file(path, other):
            raise InputError(f"{name}, {second}: must be different files, got one twice")


def require_folder() -> None:
    """Raise InputError if the current folder was deleted: relative paths mean nothing then."""
    try:
        os.getcwd()
    except OSError as error:
        raise InputError(f"the current folder: must be there, got one that was deleted ({error.strerror})") from None


def check_folder(path: AnyPath) -> None:
    """Raise InputError if a folder for results neither exists nor can be created."""
    place = Path(os.path.realpath(path))
    while not place.exists() and place != place.parent:
        place = place.parent
    if not place.is_dir():
        raise InputError(f"{path}: cannot be made: {place} is no folder")
    if not os.access(place, os.W_OK):
        raise InputError(f"{path}: cannot be made: Permission denied")


@contextlib.contextmanager
def made_folder(path: AnyPath) -> Iterator[None]:
    """Create a folder and its parents; remove the new ones again if the block raises and they are empty."""
    folder = Path(path)
    made = list(itertools.takewhile(lambda place: not os.path.lexists(place), (folder, *folder.parents)))
    try:
        try:
            folder.mkdir(parents=True, exist_ok=True)
        except OSError as error:
            raise InputError(f"{path}: cannot be made: {error.strerror}") from None
        yield
    except BaseException:
        with contextlib.suppress(OSError):  # not created, or not empty
            for place in made:
                place.rmdir()
        raise


def sidecar(log: AnyPath) -> str:
    """Return the path of the file that holds a log's metadata."""
    return f"{os.fspath(log)}.toml"


def with_sidecars(logs: Iterable[AnyPath]) -> list[AnyPath]:
    """Return the paths of logs and of their sidecars."""
    return [path for log in logs for path in (log, sidecar(log))]


def write_text(path: AnyPath, text: str) -> None:
    """Write a text file (see write_files)."""
    write_files({os.fspath(path): [text.encode()]})


def write_bytes(path: AnyPath, content: bytes) -> None:
    """Write a binary file (see write_files)."""
    write_files({os.fspath(path): [content]})


def write_files(files: Mapping[str, Iterable[bytes] | None]) -> None:
    """Write files that belong together, all or none.

    All are written to part files beside their targets and then renamed in reverse order: a log after its sidecar. A
    link is followed; an existing file keeps its mode. Data reach the disk before the rename, so that a power failure
    leaves the old or the new file. After an InputError no part file remains.

    Args:
        files: content in pieces, by path; None: the file is removed.
    """
    targets = {
        path: target_of(path) if pieces is not None else Path(os.path.realpath(Path(path).parent), Path(path).name)
        for path, pieces in files.items()  # a link itself is removed
    }
    _require_different(targets)
    parts: dict[str, Path] = {}
    path = ""
    try:
        for path, pieces in files.items():
            if pieces is not None:
                parts[path] = targets[path].with_name(f".cogging-{secrets.token_hex(8)}.part")
                _write_part(parts[path], targets[path], pieces)
        for path, target in reversed(targets.items()):
            if path in parts:
                os.replace(parts[path], target)
            else:
                target.unlink(missing_ok=True)
    except OSError as error:
        raise InputError(f"{path}: cannot be written: {error.strerror or error}") from None
    finally:
        for part in parts.values():
            with contextlib.suppress(OSError):  # the first error is reported
                part.unlink(missing_ok=True)


def _write_part(part: Path, target: Path, pieces: Iterable[bytes]) -> None:
    """Write a new file with the mode of the one that it will replace."""
    flags = os.O_WRONLY | os.O_CREAT | os.O_EXCL | getattr(os, "O_BINARY", 0)
    descriptor = os.open(part, flags, 0o600 if target.exists() else 0o666)
    with os.fdopen(descriptor, "wb") as file:
        if target.exists():
            shutil.copymode(target, part)
        for piece in pieces:
            file.write(piece)
        if synced:
            file.flush()
            os.fsync(descriptor)


class Checksum:
    """CRC-32 of the pieces of a file, computed as they are written; `str` gives it."""

    def __init__(self, pieces: Iterable[bytes] = ()) -> None:
        self._pieces = pieces
        self._value = 0

    def __iter__(self) -> Iterator[bytes]:
        for piece in self._pieces:
            self._value = zlib.crc32(piece, self._value)
            yield piece

    def __str__(self) -> str:
        return f"crc32:{self._value:08x}"


def checksum_of(path: AnyPath) -> str:
    """Return the checksum of a file, as Checksum formats it."""
    with open(path, "rb") as file:
        checksum = Checksum(iter(lambda: file.read(1 << 20), b""))
        collections.deque(checksum, maxlen=0)
    return str(checksum)


def target_of(path: AnyPath) -> Path:
    """Return the file behind links to which an output is written; raise InputError if it cannot be written."""
    called = os.fspath(path) or "."
    try:
        target, mode = Path(os.path.realpath(called)), 0
        target.parent.stat()
        with contextlib.suppress(FileNotFoundError):
            mode = target.stat().st_mode
        if stat.S_ISDIR(mode):
            raise OSError(errno.EISDIR, os.strerror(errno.EISDIR))
        if mode:
            require_file(target, called)
        if not all(os.access(place, os.W_OK) for place in (target.parent, *([target] if mode else []))):
            raise OSError(errno.EACCES, os.strerror(errno.EACCES))
    except OSError as error:
        raise InputError(f"{called}: cannot be written: {error.strerror}") from None
    except InputError:
        raise
    except ValueError as error:  # a zero byte in the name
        raise InputError(f"{called!r}: cannot be written: {error}") from None
    return target


def same_file(one: AnyPath, other: AnyPath) -> bool:
    """Return whether two paths lead to one file, or would if it existed."""
    with contextlib.suppress(OSError, ValueError):
        return os.path.samefile(one, other)
    try:
        return os.path.normcase(os.path.realpath(one)) == os.path.normcase(os.path.realpath(other))
    except ValueError:  # a zero byte in a name
        return one == other


def to_toml(document: Mapping[str, Any], *, like: str = "") -> str:
    """Return a document as TOML, numbers to their last bit; like: an earlier text, whose comments and order stay."""
    text = tomli_w.dumps(document)
    with contextlib.suppress(ValueError):  # a layout that _updated does not follow
        updated = _updated(like, document) if like else text
        text = updated if parse_toml(updated) == parse_toml(text) else text
    if broken := re.search("[\ud800-\udfff]", text):
        line = text[text.rfind("\n", 0, broken.start()) + 1 :].partition("\n")[0]
        raise ValueError(f"{printable(line)}: must be text that UTF-8 holds, got half of a pair of surrogates")
    return text


LINE = re.compile(r"""((?:"(?:\\.|[^"\\])*"|'[^']*'|[^"'#])*)(#.*)?""")  # of a value: TOML, comment
WAS = 24  # letters of a replaced value that its comment still shows


def _updated(text: str, document: Mapping[str, Any]) -> str:
    """Return a TOML text with the values of a document; a comment of a changed value says what it was."""
    left: dict[tuple[str, int], dict[str, Any]] = {}

    def collect(name: str, number: int, table: Mapping[str, Any]) -> None:
        left[name, number] = {}
        for key, value in table.items():
            path = f"{name}.{key}" if name else key
            if isinstance(value, Mapping):
                collect(path, 0, value)
            elif isinstance(value, list) and value and isinstance(value[0], Mapping):
                for place, entry in enumerate(value):
                    collect(path, place, entry)
            else:
                left[name, number][key] = value

    def end_section() -> None:
        written[last:last] = map(_toml_line, left[here], left.pop(here).values()) if here in left else ()

    collect("", 0, document)
    written: list[str] = []
    here, last, seen = ("", 0), 0, {"": 1}
    lines = iter(text.splitlines())
    for line in lines:
        if line.lstrip().startswith("["):
            end_section()
            name = line.partition("]")[0].strip(" [")
            here, seen[name] = (name, seen.get(name, 0)), seen.get(name, 0) + 1
            if here in left:
                written.append(line)
                last = len(written)
        elif line.lstrip().startswith("#") or "=" not in line:
            written.append(line)
        else:
            start, _, value = line.partition("=")
            rows, depth, comment = [line], 0, ""
            while True:
                toml, comment = (part or "" for part in LINE.fullmatch(value).groups())  # type: ignore[union-attr]
                depth += toml.count("[") - toml.count("]")
                if depth <= 0 or (value := next(lines, None)) is None:  # type: ignore[assignment]
                    break
                rows.append(value)
            key, old = next(iter(parse_toml("\n".join(rows)).items()))
            if key not in left.get(here, {}):
                continue
            new = left[here].pop(key)
            if new != old:
                was = f"; was {toml.strip()}" if len(rows) == 1 and len(toml) < WAS else ""
                comment = comment and re.sub("; was [^;]*$", "", comment) + was
                rows = [f"{f'{start.rstrip()} = {_toml_value(new)}':<27} {comment}".rstrip()]
            written += rows
            last = len(written)
    end_section()
    for (name, _), values in left.items():  # sections that the earlier text lacks
        head = ("", f"[[{name}]]" if name == "effects" else f"[{name}]") if values else ()
        written += [*head, *map(_toml_line, values, values.values())]
    return "\n".join(written) + "\n"


def _toml_line(key: str, value: Any) -> str:
    return f"{tomli_w.dumps({key: 0}).partition(' = ')[0]} = {_toml_value(value)}"


def _toml_value(value: Any) -> str:
    if isinstance(value, list | tuple):
        return f"[{', '.join(map(_toml_value, value))}]"
    return tomli_w.dumps({"x": value}).removeprefix("x = ").strip()


def to_json(document: Any, *, indent: int = 1) -> str:
    """Return a document as strict JSON with a final newline; numbers that are not finite become null."""
    return json.dumps(finite(document), indent=indent, allow_nan=False) + "\n"


def finite(value: Any) -> Any:
    """Return a copy for JSON: tuples and arrays as lists, numbers that are not finite as None, surrogates escaped."""
    if isinstance(value, Mapping):
        return {str(key): finite(entry) for key, entry in value.items()}
    if isinstance(value, str):
        return value if value.isascii() else re.sub("[\ud800-\udfff]", lambda one: printable(one[0]), value)
    if isinstance(value, bool | int) or value is None:
        return value
    if isinstance(value, Sequence):
        return [finite(entry) for entry in value]
    if hasattr(value, "tolist"):
        return finite(value.tolist())
    return float(value) if math.isfinite(value) else None
