"""Readers of binary formats, run in a process of their own.

The libraries that read MATLAB, HDF5, ASAM MDF and Parquet files were not made for broken ones: cut or altered files
made them end the whole process, loop without end or ask for all memory. What happens there stays there.
"""

from __future__ import annotations

import contextlib
import errno
import json
import os
import subprocess
import tempfile
import threading
from collections.abc import Callable, Iterator, Mapping
from typing import IO, Any

import numpy as np
import numpy.typing as npt

from cogging.arrays import FloatArray
from cogging.files import InputError
from cogging.logs.readers import matlab, mdf, parquet
from cogging.logs.readers.isolated import confine, isolated
from cogging.logs.readers.limits import memory_most, seconds_most
from cogging.logs.readers.request import Request

#: Formats by name: what they are called, the extra that brings the library, and the reader.
FORMATS: dict[str, tuple[str, str, Callable[[Request], dict[str, Any]]]] = {
    "matlab": ("MATLAB file", "matlab", matlab.read),
    "hdf5": ("MATLAB 7.3 (HDF5) file", "matlab", matlab.read_hdf5),
    "mdf": ("ASAM MDF file", "mdf", mdf.read),
    "parquet": ("Parquet file", "parquet", parquet.read),
}
START = "from cogging.logs.readers.apart import serve; serve(job)"
TEMPORARY = ("mdf",)  # formats whose library wants a temporary file whatever it does
ANSWER = b"\0cogging: what was read\0\n"  # behind whatever else was written to standard output
NO_ROOM = (
    errno.ENOSPC,
    errno.EDQUOT,
    errno.EFBIG,
    errno.EROFS,
    errno.EMFILE,
    errno.ENFILE,
)  # the machine's, not a file's


def read_apart(kind: str, request: Request) -> dict[str, FloatArray]:
    """Read columns of finite real numbers of one length; `kind` is a key of FORMATS.

    Raises:
        InputError: the file cannot be used, or its reader fails in whatever way; the library is not installed.
    """
    what, job = FORMATS[kind][0], _job(kind, request)
    seconds = job["seconds"]
    late = threading.Event()
    with contextlib.ExitStack() as stack:
        job["temporary"] = stack.enter_context(_temporary_folder(request)) if kind in TEMPORARY else None
        process = stack.enter_context(isolated(START, job, beside=os.fspath(request.path)))

        def stop() -> None:
            late.set()
            process.kill()

        timer = threading.Timer(seconds, stop)
        timer.daemon = True
        timer.start()
        try:
            columns = _received(process, request)
            if columns is not None:
                return columns
            status = process.wait()
        finally:
            timer.cancel()
    if late.is_set():
        raise request.refuse(f"must be a whole {what}, got one that is not read within {seconds:.0f} s")
    how = f"signal {-status}" if status < 0 else f"status {status}"
    raise request.refuse(f"must be a whole {what}, got one that ends its reader ({how})")


def _job(kind: str, request: Request) -> dict[str, Any]:
    """What the process that reads is told."""
    from cogging._core import memory_left  # which that process does without

    size = os.path.getsize(request.path)
    return {
        "kind": kind,
        "memory": memory_most(size, memory_left()),
        "seconds": seconds_most(size),
        "path": os.path.abspath(request.path),
        "shown": os.fspath(request.path),
        "names": list(request.names),
        "optional": list(request.optional),
        "columns": dict(request.columns),
        "scaled": sorted(request.scaled),
        "rows": [request.rows.start, request.rows.stop],
        "survey": request.survey is not None,
    }


@contextlib.contextmanager
def _temporary_folder(request: Request) -> Iterator[str]:
    """A folder that goes with what a library left there, however its process ended."""
    try:
        folder = tempfile.TemporaryDirectory(prefix="cogging", ignore_cleanup_errors=True)
    except OSError as error:
        raise request.refuse(f"cannot be read: no room for temporary files: {error.strerror}") from None
    with folder as name:
        yield name


def _received(process: subprocess.Popen[bytes], request: Request) -> dict[str, FloatArray] | None:
    """The columns that serve() writes, or None if it ends before all are there.

    Raises:
        InputError: what serve() refuses.
    """
    stream = process.stdout
    assert stream is not None
    while (line := stream.readline()) and not line.endswith(ANSWER):
        pass
    told = stream.readline()
    if not told.endswith(b"\n"):
        return None
    answer = json.loads(told)
    if "error" in answer:
        raise InputError(answer["error"])
    if request.survey is not None:
        request.survey.extend((name, unit) for name, unit in answer["survey"])
    from cogging._core import require_memory

    rows, names = answer["rows"], answer["names"]
    try:
        require_memory("rows", 8.0 * rows * len(names), f"{rows} rows of {len(names)} columns", str(rows))
    except ValueError as error:
        raise request.refuse(str(error)) from None
    columns = {name: np.empty(rows) for name in names}
    for column in columns.values() if rows else ():
        rest = column.data.cast("B")
        while rest:
            got = stream.readinto(rest)  # type: ignore[attr-defined]
            if not got:
                return None
            rest = rest[got:]
    return columns


def serve(job: Mapping[str, Any]) -> None:
    """Read in this process what read_apart asks for, and write it to standard output."""
    output = os.fdopen(os.dup(1), "wb")
    os.dup2(os.open(os.devnull, os.O_WRONLY), 1)  # whatever a library says
    confine(job)
    tempfile.tempdir = job["temporary"]
    request = Request(
        job["path"],
        job["names"],
        job["optional"],
        job["columns"],
        job["scaled"],
        slice(*job["rows"]),
        shown=job["shown"],
        survey=[] if job["survey"] else None,
    )
    try:
        columns = _read(job["kind"], request)
    except InputError as error:
        _answer(output, {"error": str(error)})
    else:
        rows = len(next(iter(columns.values()), ()))
        _answer(output, {"names": list(columns), "rows": rows, "survey": request.survey})
        for values in columns.values() if rows else ():
            output.write(np.ascontiguousarray(values).data.cast("B"))
    output.flush()
    os._exit(0)  # without the libraries' own ends, which broken files have made to fail


def _answer(output: IO[bytes], answer: Mapping[str, Any]) -> None:
    output.write(ANSWER + json.dumps(answer).encode() + b"\n")


def _read(kind: str, request: Request) -> dict[str, FloatArray]:
    what, extra, reader = FORMATS[kind]
    try:
        return _numbers(request, reader(request))
    except InputError:
        raise
    except ImportError as error:
        needed = error.name or str(error)
        raise request.refuse(f"needs {needed} to read a {what}: pip install 'cogging[{extra}]'") from None
    except MemoryError:
        raise request.refuse(f"must be a whole {what}, got one that asks for more memory than there is") from None
    except OSError as error:
        if error.errno in NO_ROOM and not error.filename:
            raise request.refuse(f"cannot be read: no room for temporary files: {error.strerror}") from None
        raise _broken(request, what, error) from None
    except Exception as error:  # whatever a library answers to a broken file
        raise _broken(request, what, error) from None


def _broken(request: Request, what: str, error: Exception) -> InputError:
    said = " ".join(str(error).split())[:120]
    return request.refuse(f"must be a whole {what}, got {type(error).__name__}{': ' * bool(said)}{said}")


def _numbers(request: Request, table: Mapping[str, Any]) -> dict[str, FloatArray]:
    """Check that what a reader gave is columns of finite real numbers of one length, and take the rows."""
    arrays: dict[str, FloatArray] = {}
    for name, values in table.items():
        array = np.asarray(values)
        if array.dtype.names is not None or array.dtype.kind not in "fiu":
            raise request.refuse(f"{name}: must be real numbers, got {_described(array)}")
        if sum(length != 1 for length in array.shape) > 1:
            shape = " x ".join(map(str, array.shape))
            raise request.refuse(f"{name}: must be one column, got an array of {shape}")
        arrays[name] = array.reshape(-1).astype(np.float64)
    lengths = {name: array.size for name, array in arrays.items()}
    first = next(iter(lengths), "")
    for name, length in lengths.items():
        if length != lengths[first]:
            raise request.refuse(f"{name}: must be as long as {first} ({lengths[first]}), got {length}")
    start = request.rows.start or 0
    for name in arrays:
        arrays[name] = array = arrays[name][request.rows]
        good = np.isfinite(array)
        if not good.all():
            row = int(np.argmin(good))
            raise request.refuse(f"row {start + row}: {name}: must be a finite number, got {array[row]:g}")
    return arrays


def _described(array: npt.NDArray[Any]) -> str:
    fields = set(array.dtype.names or ())
    if array.dtype.kind == "c" or fields == {"real", "imag"}:
        return "complex numbers"
    if fields:
        return f"a struct of {', '.join(sorted(fields))}"
    if array.dtype.kind == "b":
        return "truth values"
    kinds = {"U": "text", "S": "text", "O": "objects (cells or texts)", "M": "dates", "m": "durations"}
    return kinds.get(array.dtype.kind, str(array.dtype))
