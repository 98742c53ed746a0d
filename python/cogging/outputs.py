"""Writing files so that none is left half written: never over an input, and no output twice."""

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
import zlib
from collections.abc import Iterable, Iterator, Mapping, Sequence
from pathlib import Path
from typing import IO, Any

import tomli_w

from cogging.files import InputError, require_file
from cogging.shown import printable

AnyPath = str | os.PathLike[str]
PART_FILE = re.compile(r"\.cogging-[0-9a-f]{16}\.part")  # beside a file: one that is not whole yet
synced = True  # data reach the disk before their names do; tests switch it off


def check_outputs(outputs: Mapping[str, AnyPath | None], inputs: Iterable[AnyPath] = ()) -> None:
    """Refuse what would destroy an input or another output, before anything is computed.

    Args:
        outputs: files that the call writes, by what asks for them (`--out`); None where nothing does.
        inputs: files that it reads, those that may stand beside them included (with_sidecars).
    """
    given = {name: path for name, path in outputs.items() if path is not None}
    read = list(inputs)
    for name, path in given.items():
        for other in read:
            if same_file(path, other):
                raise InputError(f"{name}: {path}: must not be a file that is read, got {os.fspath(other)}")
    for (name, path), (second, other) in itertools.combinations(given.items(), 2):
        if same_file(path, other):
            raise InputError(f"{name}, {second}: must be different files, got one twice")
    for path in given.values():
        target_of(path)


def require_folder() -> None:
    """Refuse to work in a current folder that is gone: no name of a file means anything there."""
    try:
        os.getcwd()
    except OSError as error:
        raise InputError(f"the current folder: must be there, got one that was deleted ({error.strerror})") from None


def check_folder(path: AnyPath) -> None:
    """Refuse a folder for results that is none and cannot be made, before anything is computed."""
    place = Path(os.path.realpath(path))
    while not place.exists() and place != place.parent:
        place = place.parent
    if not place.is_dir():
        raise InputError(f"{path}: cannot be made: {place} is no folder")
    if not os.access(place, os.W_OK):
        raise InputError(f"{path}: cannot be made: Permission denied")


@contextlib.contextmanager
def made_folder(path: AnyPath) -> Iterator[None]:
    """Make a folder for what is written within, with those on the way there; where that fails they go again."""
    folder = Path(path)
    made = list(itertools.takewhile(lambda place: not os.path.lexists(place), (folder, *folder.parents)))
    try:
        try:
            folder.mkdir(parents=True, exist_ok=True)
        except OSError as error:
            raise InputError(f"{path}: cannot be made: {error.strerror}") from None
        yield
    except BaseException:
        with contextlib.suppress(OSError):  # one that was not made, or in which something stands
            for place in made:
                place.rmdir()
        raise


def sidecar(log: AnyPath) -> str:
    """The file beside a log in which stands what a table of numbers cannot hold."""
    return f"{os.fspath(log)}.toml"


def with_sidecars(logs: Iterable[AnyPath]) -> list[AnyPath]:
    """Logs and what may stand beside them."""
    return [path for log in logs for path in (log, sidecar(log))]


def write_text(path: AnyPath, text: str) -> None:
    """Write a file beside its place and rename it, so that it is there whole or not at all."""
    write_bytes(path, text.encode())


def write_bytes(path: AnyPath, content: bytes, *, sync: bool = True) -> None:
    """Write a binary file beside its place and rename it (see write_files)."""
    write_files({os.fspath(path): [content]}, sync=sync)


def write_files(files: Mapping[str, Iterable[bytes] | None], *, sync: bool = True) -> None:
    """Write files that belong together, each given in pieces.

    All are written beside their places before the first takes its place, so that each is whole or not there. They take
    their places in reverse order: a log after its sidecar. What stands there is replaced: behind a link its target,
    with the mode that it had. A new file has the mode that the user's mask leaves.

    Args:
        files: pieces by path; None where no file is to stand.
        sync: data reach the disk before their names do, so that a power failure too leaves the old or the new.
    """
    targets = {path: target_of(path) if pieces is not None else _own_place(path) for path, pieces in files.items()}
    for path, other in itertools.combinations(targets, 2):
        if same_file(targets[path], targets[other]):
            raise InputError(f"{path}, {other}: must be different files, got one twice")
    parts: dict[str, Path] = {}
    path = ""
    try:
        for path, pieces in files.items():
            if pieces is not None:
                parts[path] = targets[path].with_name(f".cogging-{secrets.token_hex(8)}.part")
                _write_part(parts[path], targets[path], pieces, sync and synced)
        for path, target in reversed(targets.items()):
            if path in parts:
                os.replace(parts[path], target)
            else:
                target.unlink(missing_ok=True)
    except OSError as error:
        named = {os.fspath(place): path for places in (targets, parts) for path, place in places.items()}
        raise InputError(_unwritten(error, named, path)) from None
    finally:
        for part in parts.values():
            with contextlib.suppress(OSError):  # the first error is reported
                part.unlink(missing_ok=True)


class Checksum:
    """Pieces of a file on their way to it, and the checksum of those that have passed."""

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
    """Return the checksum of a file, as Checksum gives it."""
    with open(path, "rb") as file:
        checksum = Checksum(iter(lambda: file.read(1 << 20), b""))
        for _ in checksum:
            pass
    return str(checksum)


def _write_part(part: Path, target: Path, pieces: Iterable[bytes], sync: bool) -> None:
    with _new_file(part, target) as file:
        for piece in pieces:
            file.write(piece)
        if sync:
            file.flush()
            os.fsync(file.fileno())


def _unwritten(error: OSError, named: Mapping[str, str], path: str) -> str:
    """What to tell of an error: the output of the call that it concerns, and the file where that is another."""
    why = error.strerror or str(error)
    for place in (error.filename2, error.filename):
        if isinstance(place, str | os.PathLike):
            if os.fspath(place) in named:
                return f"{named[os.fspath(place)]}: cannot be written: {why}"
            why = f"{os.fspath(place)}: {why}"
    return f"{path}: cannot be written: {why}"


def _own_place(path: AnyPath) -> Path:
    """Where a name itself stands, be it a link."""
    given = Path(path)
    return Path(os.path.realpath(given.parent), given.name)


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


def target_of(path: AnyPath, *, looks: int = 10) -> Path:
    """The file that an output is written to, behind links."""
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
        if target.exists() and not _may_replace(target):
            raise InputError(f"{called}: cannot be written: {os.strerror(errno.EPERM)}")
    except OSError as error:
        if isinstance(error, FileNotFoundError) and looks > 1:  # another writer replaced it between two looks
            return target_of(path, looks=looks - 1)
        raise InputError(f"{called}: cannot be written: {error.strerror}") from None
    except InputError:
        raise
    except ValueError as error:  # a zero byte in the name
        raise InputError(f"{called!r}: cannot be written: {error}") from None
    return target


def _may_replace(target: Path) -> bool:
    """Whether the folder of a file lets this user rename another over it: where it is shared as /tmp is, its owner."""
    folder = target.parent.stat()
    owners = {0, folder.st_uid, target.stat().st_uid}
    return not folder.st_mode & stat.S_ISVTX or not hasattr(os, "geteuid") or os.geteuid() in owners


def same_file(one: AnyPath, other: AnyPath) -> bool:
    """Whether two paths lead to one file, by whatever name; of files that are not there yet, whether they would."""
    try:
        return os.path.samefile(one, other)
    except (OSError, ValueError):
        return _place(one) == _place(other)


def _place(path: AnyPath) -> str:
    try:
        place = os.path.normcase(os.path.realpath(path))
    except ValueError:  # a zero byte in the name
        return repr(path)
    return unicodedata.normalize("NFD", place).casefold() if sys.platform == "darwin" else place


def to_toml(document: Mapping[str, Any]) -> str:
    """Format a document as TOML text, numbers to their last bit."""
    text = tomli_w.dumps(document)
    for line in text.splitlines() if any("\ud800" <= letter <= "\udfff" for letter in text) else ():
        if any("\ud800" <= letter <= "\udfff" for letter in line):
            raise ValueError(f"{printable(line)}: must be text that UTF-8 holds, got half of a pair of surrogates")
    return text


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
