"""The finished pieces of a sweep: files in a folder beside its output, each there whole or not at all."""

from __future__ import annotations

import contextlib
import hashlib
import io
import os
import re
import sys
from collections.abc import Iterable
from pathlib import Path
from typing import IO, Any

import numpy as np

from cogging.files import InputError, require_file
from cogging.outputs import PART_FILE, target_of, write_bytes
from cogging.shown import quoted

if sys.platform != "win32":
    import fcntl

Table = dict[str, Any]
OTHERWISE = "remove it, or write to another file"
PIECE = re.compile(r"[0-9]{9}-[0-9a-f]{64}\.npz")  # the first run, and what `_name` makes of the content


class Pieces:
    """Keeps the tables of a sweep's pieces, so that a sweep that was ended goes on where it was.

    One process at a time has them: it holds a lock on `sweep.json`, which goes with the process. That file is the first
    in the folder and the first to go: without it, what else stands there is of a sweep that is done. A piece has in its
    name a checksum of the sweep and of all that it holds: what is not as it was written is made anew. What has another
    name is not the sweep's: a folder that holds any is refused, and none is ever removed.

    Attributes:
        folder: where they stand; it goes when the sweep is done.
    """

    def __init__(self, out: str | os.PathLike[str], digest: str) -> None:
        """Make the folder, or open the one that an earlier call of the same sweep left.

        Args:
            out: the output beside which it stands.
            digest: of all that decides what the runs give.

        Raises:
            InputError: something else or another sweep's pieces stand there, another process is at it, or none can be
                written.
        """
        target = target_of(out)
        self.folder = target.with_name(f"{target.name}.pieces")
        self._called = f"{os.fspath(out)}.pieces"
        self._told = self.folder / "sweep.json"
        self._digest = digest.encode()
        try:
            self._lock = self._opened()
        except BlockingIOError:
            raise InputError(
                f"{self._called}: another process is making this sweep, or another to the same file"
            ) from None
        except OSError as error:
            raise InputError(f"{self._called}: cannot be used: {error.strerror}") from None
        try:
            self._begin()
        except BaseException:
            self._lock.close()
            raise

    def _opened(self) -> IO[bytes]:
        while True:
            if self.folder.is_symlink():
                raise InputError(f"{self._called}: must be a folder, got a link: {OTHERWISE}")
            self.folder.mkdir(exist_ok=True)
            if others := [path.name for path in self.folder.glob("*") if not self._is_own(path)]:
                what = f"must hold nothing but the pieces of a sweep, got {quoted(min(others))}"
                raise InputError(f"{self._called}: {what}: {OTHERWISE}")
            with contextlib.suppress(FileNotFoundError):  # the folder has gone meanwhile, with a sweep that was done
                flags = os.O_RDWR | os.O_CREAT | getattr(os, "O_NOFOLLOW", 0) | getattr(os, "O_BINARY", 0)
                descriptor = os.open(self._told, flags, 0o666)
                file = os.fdopen(descriptor, "r+b", buffering=0)
                try:
                    require_file(self._told)
                    if sys.platform != "win32":
                        fcntl.lockf(file, fcntl.LOCK_EX | fcntl.LOCK_NB)  # a forked worker has no part in it
                    if os.path.samestat(os.fstat(descriptor), os.lstat(self._told)):
                        return file
                except BaseException:
                    file.close()
                    raise
                file.close()

    def _begin(self) -> None:
        """Hold the sweep against that of the folder; a new one begins with none of what stands there."""
        wanted = b'{"digest": "' + self._digest + b'"}\n'
        try:
            if text := self._lock.read(len(wanted) + 1):
                if text != wanted:
                    what = "holds pieces of another sweep, or of another version"
                    raise InputError(f"{self._called}: {what}: {OTHERWISE}")
                return
            for path in self._finished():
                path.unlink()
            self._lock.write(wanted)
            os.fsync(self._lock.fileno())
        except OSError as error:
            self.remove()
            raise InputError(f"{self._called}: cannot be written: {error.strerror}") from None

    def __enter__(self) -> Pieces:
        return self

    def __exit__(self, *_: object) -> None:
        self._lock.close()

    def keep(self, table: Table) -> None:
        """Write a piece.

        Raises:
            InputError: it cannot be written, as on a full disk; those before it stand.
        """
        file = io.BytesIO()
        np.savez(file, **{name: _saved(values) for name, values in table.items()})  # type: ignore[arg-type]
        try:
            write_bytes(self.folder / self._name(table["run"][0], file.getvalue()), file.getvalue(), sync=False)
        except InputError as error:
            raise InputError("; ".join(filter(None, (str(error), self.stands)))) from None

    def tables(self, runs: int) -> list[Table]:
        """The pieces that were finished, of a sweep of so many runs; no two hold the same run. Broken ones go."""
        done, tables = np.zeros(runs, dtype=bool), []
        for path in self._finished():
            table = self._read(path)
            if table is None:
                with contextlib.suppress(OSError):
                    path.unlink()
            elif not done[table["run"]].any():
                done[table["run"]] = True
                tables.append(table)
        return tables

    def remove(self) -> None:
        """Take away what the sweep has written, and the folder with it."""
        own = [path for path in self.folder.glob("*") if self._is_own(path)]
        if sys.platform == "win32":  # which removes no file that is open
            self._lock.close()
        for path in (self._told, *own):
            with contextlib.suppress(OSError):
                path.unlink(missing_ok=True)
        with contextlib.suppress(OSError):
            self.folder.rmdir()

    def remove_empty(self) -> None:
        """Take the folder away where it has no piece."""
        if not self._finished():
            self.remove()

    @property
    def stands(self) -> str:
        """What to tell of the finished runs where a sweep has ended before its time; nothing where none is."""
        if not self._finished():
            return ""
        return f"finished runs stand in {self._called}, the same call goes on from there"

    def _finished(self) -> list[Path]:
        return sorted(path for path in self.folder.glob("*") if PIECE.fullmatch(path.name))

    def _is_own(self, path: Path) -> bool:
        return bool(path == self._told or PIECE.fullmatch(path.name) or PART_FILE.fullmatch(path.name))

    def _name(self, first: int, content: bytes) -> str:
        return f"{first:09d}-{hashlib.sha256(self._digest + content).hexdigest()}.npz"

    def _read(self, path: Path) -> Table | None:
        """A piece, or None where it is not what the sweep wrote there."""
        try:
            require_file(path)
            content = path.read_bytes()
        except (OSError, InputError):
            return None
        if path.name != self._name(int(path.name[:9]), content):
            return None
        with np.load(io.BytesIO(content), allow_pickle=False) as file:
            return {name: file[name] for name in file.files}


def missing(tables: Iterable[Table], runs: int, size: int) -> list[range]:
    """Which of so many runs are in none of the tables, in parts of a size at most."""
    done = np.zeros(runs, dtype=bool)
    for table in tables:
        done[table["run"]] = True
    places = np.flatnonzero(~done)
    gaps = np.split(places, np.flatnonzero(np.diff(places) > 1) + 1) if len(places) else []
    ends = [(int(gap[0]), int(gap[-1]) + 1) for gap in gaps]
    return [range(first, min(first + size, end)) for begin, end in ends for first in range(begin, end, size)]


def joined(tables: list[Table]) -> Table:
    """The rows of all pieces, in the order of their runs."""
    tables = sorted(tables, key=lambda table: int(table["run"][0]))
    return {name: np.concatenate([table[name] for table in tables]) for name in tables[0]}


def _saved(values: Any) -> np.ndarray[Any, Any]:
    array = np.asarray(values)
    return array.astype(str) if array.dtype == object else array
