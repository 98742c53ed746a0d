"""Logs of every format with something wrong in them: each is read as sound numbers, or refused in one line.

Binary formats are read here by the reader itself, without the process of its own that a user has around it: what ends
this process is tried once more with it (`again`), and must then be one line.
"""

from __future__ import annotations

import functools
import os
import random
import tempfile
import warnings
from pathlib import Path

import numpy as np

import cogging
from cogging.files import InputError
from cogging.logs.columns import _request, format_of
from cogging.logs.readers import isolate
from tests.attack.mutations import of_bytes, of_table
from tests.fixtures.log_files import COLUMNS, hdf5_bytes, mat_bytes, mdf_bytes

FORMATS = {"csv": ".csv", "matlab": ".mat", "hdf5": ".mat", "mdf": ".mf4", "parquet": ".parquet"}
NAMES = ("time", "position", "command")


@functools.cache
def sound(kind: str) -> tuple[bytes, ...]:
    """Whole files of a format."""
    if kind == "csv":
        rows = zip(*(column.tolist() for column in COLUMNS.values()), strict=True)
        return ((",".join(COLUMNS) + "\n" + "".join(",".join(map(repr, row)) + "\n" for row in rows)).encode(),)
    if kind == "matlab":
        return mat_bytes(), mat_bytes(compress=True), mat_bytes({"log": COLUMNS})
    if kind == "hdf5":
        return (hdf5_bytes(),)
    if kind == "parquet":
        return (_with_checksums(),)
    with tempfile.TemporaryDirectory() as folder:
        return (mdf_bytes(Path(folder)),)


def _with_checksums() -> bytes:
    """A log as this package writes it to Parquet."""
    with tempfile.TemporaryDirectory() as folder:
        path = os.path.join(folder, "log.parquet")
        cogging.Log(**COLUMNS).write(path)
        with open(path, "rb") as file:
            return file.read()


def run_case(seed: int, kind: str, whole: bool = False) -> str | None:
    """Read one mutated file; what is wrong with the answer, behind a "~" what is no fault, or None.

    Args:
        seed: of the mutation.
        kind: key of FORMATS.
        whole: read as a user does, binary formats in a process of their own.
    """
    chance = random.Random(f"{kind} {seed}")
    content = chance.choice(sound(kind))
    content = of_table(content, chance) if kind == "csv" and chance.random() < 0.8 else of_bytes(content, chance)
    with tempfile.TemporaryDirectory() as folder:
        path = os.path.join(folder, f"log{FORMATS[kind]}")
        with open(path, "wb") as file:
            file.write(content)
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")
            found = _read(path, kind, whole)
            if found and not found.startswith("~") and kind != "csv":
                found = _read(path, kind, True)  # what a user's way to the file makes of it
            return found


def _read(path: str, kind: str, whole: bool) -> str | None:
    try:
        if kind == "csv" or whole:
            log = cogging.read_log(path)
            found = {name: getattr(log, name) for name in NAMES}
        else:
            found = _beside(path)
    except InputError as refused:
        return _judged(str(refused))
    return _nonsense(found, log_made=kind == "csv" or whole)


def _beside(path: str) -> dict[str, np.ndarray]:
    """What the reader of a binary format makes of a file, in this process."""
    request = _request(path, NAMES, (), None, None, None, False)
    kind = format_of(path)
    if kind is None:
        return {name: np.asarray(column) for name, column in cogging.read_log(path).columns.items() if name in NAMES}
    return {name: np.asarray(column) for name, column in isolate._read(kind, request).items()}


def _judged(text: str) -> str | None:
    if "\n" in text:
        return f"not one line: {text[:200]!r}"
    if "Traceback" in text or len(text) > 4000:
        return f"no answer for a user: {text[:200]!r}"
    return None


def _nonsense(found: dict[str, np.ndarray], log_made: bool) -> str | None:
    lengths = {len(column) for column in found.values()}
    if len(lengths) != 1 or not lengths.pop():
        return "columns of different lengths, or none, accepted"
    for name, column in found.items():
        if not np.isfinite(column).all():
            return f"{name}: a number that is not finite accepted"
    if log_made and (np.diff(found["time"]) <= 0.0).any():
        return "a time that does not increase accepted"
    same = all(np.array_equal(found[name], COLUMNS[name]) for name in NAMES if name in found)
    return None if same else "~read with other numbers"
