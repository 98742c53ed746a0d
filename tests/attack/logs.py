"""Logs of every format with something wrong in them: each is read as sound numbers, or refused in one line.

Binary formats are read here without the process of its own that a user has around the reader, which is quicker; what
is wrong then is tried again with it (`whole`).
"""

import functools
import random
import tempfile
import warnings
from pathlib import Path

import numpy as np

import cogging
from cogging.files import InputError
from cogging.logs.columns import format_of
from cogging.logs.readers import isolate
from cogging.logs.readers.column_request import Request
from tests.attack.mutations import of_bytes, of_table
from tests.fixtures.log_files import COLUMNS, hdf5_bytes, mat_bytes, mdf_bytes

FORMATS = {"csv": ".csv", "matlab": ".mat", "hdf5": ".mat", "mdf": ".mf4", "parquet": ".parquet"}
NAMES = ("time", "position", "command")


@functools.cache
def sound(kind: str) -> tuple[bytes, ...]:
    """Whole files of a format."""
    if kind == "matlab":
        return mat_bytes(), mat_bytes(compress=True), mat_bytes({"log": COLUMNS})
    if kind == "hdf5":
        return (hdf5_bytes(),)
    with tempfile.TemporaryDirectory() as folder:
        if kind == "mdf":
            return (mdf_bytes(Path(folder)),)
        path = Path(folder) / f"log{FORMATS[kind]}"
        cogging.Log(**COLUMNS).write(path)
        return (path.read_bytes(),)


def run_case(seed: int, kind: str, whole: bool = False) -> str | None:
    """Read one mutated file of a key of FORMATS; what is wrong, "~..." for what is no fault, or None."""
    chance = random.Random(f"{kind} {seed}")
    content = chance.choice(sound(kind))
    content = of_table(content, chance) if kind == "csv" and chance.random() < 0.8 else of_bytes(content, chance)
    with tempfile.TemporaryDirectory() as folder, warnings.catch_warnings():
        warnings.simplefilter("ignore")
        path = Path(folder) / f"log{FORMATS[kind]}"
        path.write_bytes(content)
        found = fault_of(str(path), whole or kind == "csv")
        return fault_of(str(path), True) if found and not found.startswith("~") else found


def fault_of(path: str, whole: bool) -> str | None:
    try:
        kind = format_of(path)
        if whole or kind is None:
            log = cogging.read_log(path)
            found = {name: getattr(log, name) for name in NAMES}
        else:
            columns = isolate._read(kind, Request(path, NAMES))
            found = {name: np.asarray(column) for name, column in columns.items()}
    except InputError as refused:
        text = str(refused)
        is_line = "\n" not in text and "Traceback" not in text and len(text) <= 4000
        return None if is_line else f"no line for a user: {text[:200]!r}"
    if len({len(column) for column in found.values()}) != 1 or not all(map(len, found.values())):
        return "columns of different lengths, or none, accepted"
    if not all(np.isfinite(column).all() for column in found.values()):
        return "a number that is not finite accepted"
    if whole and (np.diff(found["time"]) <= 0.0).any():
        return "a time that does not increase accepted"
    same = all(np.array_equal(found[name], COLUMNS[name]) for name in NAMES if name in found)
    return None if same else "~read with other numbers"
