"""The finished pieces of a sweep: files in a folder beside its output, each there whole or not at all."""

from __future__ import annotations

import contextlib
import hashlib
import io
import json
import os
import shutil
import sys
import zipfile
from collections.abc import Iterable, Mapping
from pathlib import Path
from typing import IO, Any

import numpy as np

from cogging.file_locks import opened_alone, rewrite
from cogging.files import InputError
from cogging.outputs import target_of, write_bytes

Table = dict[str, Any]
LARGEST_TOLD = 4096  # bytes of `sweep.json`, which has 80


class Pieces:
    """Keeps the tables of a sweep's pieces, so that a sweep that was ended goes on where it was.

    One process at a time has them: it holds a lock on `sweep.json`, which goes with the process. That file is the first
    in the folder and the first to go: without it, what else stands there is of a sweep that is done.

    Attributes:
        folder: where they stand; it goes when the sweep is done.
    """

    def __init__(self, out: str | os.PathLike[str], asked: Mapping[str, Any]) -> None:
        """Make the folder, or open the one that an earlier call of the same sweep left.

        Args:
            out: the output beside which it stands.
            asked: all that decides what the runs give, as JSON can hold it.

        Raises:
            InputError: another sweep's pieces stand there, another process is at it, or none can be written.
        """
        target = target_of(out)
        self.folder = target.with_name(f"{target.name}.pieces")
        self._called = f"{os.fspath(out)}.pieces"
        self._told = self.folder / "sweep.json"
        try:
            self._lock = self._opened()
        except BlockingIOError:
            raise InputError(
                f"{self._called}: another process is making this sweep, or another to the same file"
            ) from None
        except OSError as error:
            raise InputError(f"{self._called}: cannot be used: {error.strerror}") from None
        try:
            self._begin(digest_of(asked))
        except BaseException:
            self._lock.close()
            raise

    def _opened(self) -> IO[bytes]:
        while True:
            self.folder.mkdir(exist_ok=True)
            with contextlib.suppress(FileNotFoundError):  # the folder has gone meanwhile, with a sweep that was done
                return opened_alone(self._told, by_process=True)

    def _begin(self, digest: str) -> None:
        """Hold the sweep against that of the folder; a new one begins with none of what stands there."""
        text = self._lock.read(LARGEST_TOLD)
        try:
            if text:
                if json.loads(text).get("digest") != digest:
                    raise InputError(
                        f"{self._called}: holds pieces of another sweep, or of another version: "
                        "remove it, or write to another file"
                    )
                return
            for path in self._finished():
                path.unlink()
            rewrite(self._lock, json.dumps({"digest": digest}).encode() + b"\n")
            os.fsync(self._lock.fileno())
        except (ValueError, AttributeError) as error:
            if isinstance(error, InputError):
                raise
            raise InputError(f"{self._called}: cannot be used: {error}") from None
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
            write_bytes(self.folder / f"{table['run'][0]:09d}.npz", file.getvalue(), synced=False)  # see _read
        except InputError as error:
            raise InputError("; ".join(filter(None, (str(error), self.stands)))) from None

    def tables(self, runs: int) -> list[Table]:
        """The pieces that were finished, of a sweep of so many runs; no two hold the same run."""
        done, tables = np.zeros(runs, dtype=bool), []
        for path in self._finished():
            table = _read(path)
            places = np.arange(0) if table is None else table["run"]
            if table is not None and places[-1] < runs and not done[places].any():
                done[places] = True
                tables.append(table)
        return tables

    def remove(self) -> None:
        """Take the folder away."""
        if sys.platform == "win32":  # which removes no file that is open
            self._lock.close()
        with contextlib.suppress(OSError):
            self._told.unlink(missing_ok=True)
        shutil.rmtree(self.folder, ignore_errors=True)

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
        return sorted(self.folder.glob("[0-9]*.npz"))


def digest_of(asked: Mapping[str, Any]) -> str:
    """A number for what was asked: equal for equal sweeps."""
    return hashlib.sha256(json.dumps(asked, sort_keys=True, default=_as_json).encode()).hexdigest()


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


def _read(path: Path) -> Table | None:
    """A piece, or None where a crash of the machine left a file that is none."""
    try:
        with open(path, "rb") as piece, np.load(piece, allow_pickle=False) as file:
            table = {name: file[name] for name in file.files}
        return table if len(table["run"]) else None
    except (OSError, ValueError, EOFError, KeyError, zipfile.BadZipFile):
        return None


def _saved(values: Any) -> np.ndarray[Any, Any]:
    array = np.asarray(values)
    return array.astype(str) if array.dtype == object else array


def _as_json(value: Any) -> Any:
    if isinstance(value, Path):
        return os.fspath(value)
    return value.tolist()
