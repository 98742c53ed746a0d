"""Readers of binary formats, run in a process of their own.

The libraries that read MATLAB, HDF5, ASAM MDF and Parquet files were not made for broken ones: cut or altered files
made them end the whole process, loop without end or ask for all memory. What happens there stays there.
"""

from __future__ import annotations

import json
import os
import subprocess
import sys
import tempfile
from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt

from cogging.files import InputError
from cogging.readers import matlab, mdf, parquet
from cogging.readers.request import Request

FloatArray = npt.NDArray[np.float64]

#: Formats by name: what they are called, the extra that brings the library, and the reader.
FORMATS: dict[str, tuple[str, str, Callable[[Request], dict[str, Any]]]] = {
    "matlab": ("MATLAB file", "matlab", matlab.read),
    "hdf5": ("MATLAB 7.3 (HDF5) file", "matlab", matlab.read_hdf5),
    "mdf": ("ASAM MDF file", "mdf", mdf.read),
    "parquet": ("Parquet file", "parquet", parquet.read),
}
SECONDS = 30.0  # in which a small file must be read
BYTES_A_SECOND = 2e6  # slower is no reading
MEMORY = 8 << 30  # bytes, for a small file
EXPANSION = 64  # of compressed numbers
START = "import json, sys; job = json.load(sys.stdin); sys.path[:] = job['sys_path']; "
START += "from cogging.readers.apart import serve; serve(job)"


def read_apart(kind: str, request: Request) -> dict[str, FloatArray]:
    """Read columns of finite real numbers of one length; `kind` is a key of FORMATS.

    Raises:
        InputError: the file cannot be used, or its reader fails in whatever way; the library is not installed.
    """
    size = os.path.getsize(request.path)
    seconds = SECONDS + size / BYTES_A_SECOND
    what = FORMATS[kind][0]
    with tempfile.TemporaryDirectory(prefix="cogging") as folder:
        job = {
            "sys_path": [os.path.abspath(entry) for entry in sys.path],
            "kind": kind,
            "folder": folder,
            "memory": MEMORY + EXPANSION * size,
            "path": os.fspath(request.path),
            "names": list(request.names),
            "optional": list(request.optional),
            "columns": dict(request.columns),
            "scaled": sorted(request.scaled),
            "rows": [request.rows.start, request.rows.stop],
        }
        try:
            done = subprocess.run(
                [sys.executable, "-c", START],
                input=json.dumps(job),
                stdout=subprocess.DEVNULL,
                stderr=subprocess.DEVNULL,
                text=True,
                timeout=seconds,
                check=False,
            )
        except subprocess.TimeoutExpired:
            raise request.refuse(f"must be a whole {what}, got one that is not read within {seconds:.0f} s") from None
        answer = Path(folder) / "answer.json"
        if not answer.exists():
            how = f"signal {-done.returncode}" if done.returncode < 0 else f"status {done.returncode}"
            raise request.refuse(f"must be a whole {what}, got one that ends its reader ({how})")
        told = json.loads(answer.read_text())
        if "error" in told:
            raise InputError(told["error"])
        return {name: np.load(Path(folder) / f"{i}.npy") for i, name in enumerate(told["names"])}


def serve(job: Mapping[str, Any]) -> None:
    """Read in this process what read_apart asks for: arrays and answer.json in the job's folder."""
    _limit_memory(job["memory"])
    request = Request(job["path"], job["names"], job["optional"], job["columns"], job["scaled"], slice(*job["rows"]))
    answer: dict[str, Any]
    try:
        columns = _read(job["kind"], request)
        for i, values in enumerate(columns.values()):
            np.save(Path(job["folder"]) / f"{i}.npy", values)
        answer = {"names": list(columns)}
    except InputError as error:
        answer = {"error": str(error)}
    # Last and at once: what stands there is whole.
    part = Path(job["folder"]) / "part"
    part.write_text(json.dumps(answer))
    part.rename(Path(job["folder"]) / "answer.json")
    os._exit(0)  # without the libraries' own ends, which broken files have made to fail


def _limit_memory(limit: int) -> None:
    try:
        import resource
    except ImportError:  # not on Windows
        return
    hard = resource.getrlimit(resource.RLIMIT_AS)[1]
    if hard == resource.RLIM_INFINITY or limit < hard:
        resource.setrlimit(resource.RLIMIT_AS, (limit, hard))
    resource.setrlimit(resource.RLIMIT_CORE, (0, resource.getrlimit(resource.RLIMIT_CORE)[1]))


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
    except Exception as error:  # whatever a library answers to a broken file
        said = " ".join(str(error).split())[:120]
        raise request.refuse(f"must be a whole {what}, got {type(error).__name__}{': ' * bool(said)}{said}") from None


def _numbers(request: Request, table: Mapping[str, Any]) -> dict[str, FloatArray]:
    """Check that what a reader gave is columns of finite real numbers of one length, and take the rows."""
    arrays: dict[str, FloatArray] = {}
    for name, values in table.items():
        array = np.asarray(values)
        if array.dtype.names is not None or array.dtype.kind not in "fiub":
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
    kinds = {"U": "text", "S": "text", "O": "objects (cells or texts)", "M": "dates", "m": "durations"}
    return kinds.get(array.dtype.kind, str(array.dtype))
