"""The finished pieces of a sweep: files in a folder beside its output, each there whole or not at all."""

from __future__ import annotations

import hashlib
import io
import json
import os
import shutil
import zipfile
from collections.abc import Iterable, Mapping
from pathlib import Path
from typing import Any

import numpy as np

from cogging.files import InputError
from cogging.outputs import target_of, write_bytes, write_text

Table = dict[str, Any]


class Pieces:
    """Keeps the tables of a sweep's pieces, so that a sweep that was ended goes on where it was.

    Attributes:
        folder: where they stand; it goes when the sweep is done.
    """

    def __init__(self, out: str | os.PathLike[str], asked: Mapping[str, Any]) -> None:
        """Make the folder, or open the one that an earlier call of the same sweep left.

        Args:
            out: the output beside which it stands.
            asked: all that decides what the runs give, as JSON can hold it.

        Raises:
            InputError: another sweep's pieces stand there, or none can be written.
        """
        target = target_of(out)
        self.folder = target.with_name(f"{target.name}.pieces")
        self._called = f"{os.fspath(out)}.pieces"
        digest = digest_of(asked)
        told = self.folder / "sweep.json"
        try:
            self.folder.mkdir(exist_ok=True)
            if told.exists():
                if json.loads(told.read_text(encoding="utf-8")).get("digest") != digest:
                    raise InputError(
                        f"{self._called}: holds pieces of another sweep, or of another version: "
                        "remove it, or write to another file"
                    )
                return
        except (OSError, json.JSONDecodeError, AttributeError) as error:
            raise InputError(f"{self._called}: cannot be used: {error}") from None
        write_text(told, json.dumps({"digest": digest}) + "\n")

    def keep(self, table: Table) -> None:
        """Write a piece.

        Raises:
            InputError: it cannot be written, as on a full disk; those before it stand.
        """
        file = io.BytesIO()
        np.savez(file, **{name: _saved(values) for name, values in table.items()})  # type: ignore[arg-type]
        try:
            write_bytes(self.folder / f"{table['run'][0]:09d}.npz", file.getvalue())
        except InputError as error:
            raise InputError("; ".join(filter(None, (str(error), self.stands)))) from None

    def tables(self, runs: int) -> list[Table]:
        """The pieces that were finished, of a sweep of so many runs; no two hold the same run."""
        done, tables = np.zeros(runs, dtype=bool), []
        for path in sorted(self.folder.glob("[0-9]*.npz")):
            table = _read(path)
            places = np.arange(0) if table is None else table["run"]
            if table is not None and places[-1] < runs and not done[places].any():
                done[places] = True
                tables.append(table)
        return tables

    def remove(self) -> None:
        """Take the folder away."""
        shutil.rmtree(self.folder, ignore_errors=True)

    def remove_empty(self) -> None:
        """Take the folder away where it has no piece."""
        if not any(self.folder.glob("[0-9]*.npz")):
            self.remove()

    @property
    def stands(self) -> str:
        """What to tell of the finished runs where a sweep has ended before its time; nothing where none is."""
        if not any(self.folder.glob("[0-9]*.npz")):
            return ""
        return f"finished runs stand in {self._called}, the same call goes on from there"


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
