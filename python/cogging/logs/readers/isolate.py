"""Readers of binary formats, run in a separate process.

Damaged MATLAB, HDF5, ASAM MDF and Parquet files can crash the libraries that read them, or make them loop or allocate
all memory. The process imports no code from the working folder or that of the log, has limited memory and time, and
ends with its parent.
"""

from __future__ import annotations

import contextlib
import errno
import json
import math
import os
import signal
import subprocess
import sys
import tempfile
import threading
import time
from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt

from cogging.arrays import FloatArray
from cogging.files import InputError
from cogging.logs.readers import matlab, mdf, parquet
from cogging.logs.readers.column_request import MIB, Request, numbers_most

#: Description, extra that installs the library, and reader of each format.
FORMATS: dict[str, tuple[str, str, Callable[[Request], dict[str, Any]]]] = {
    "matlab": ("MATLAB file", "matlab", matlab.read),
    "hdf5": ("MATLAB 7.3 (HDF5) file", "matlab", matlab.read_hdf5),
    "mdf": ("ASAM MDF file", "mdf", mdf.read),
    "parquet": ("Parquet file", "parquet", parquet.read),
}
TEMPORARY = ("mdf",)  # formats whose library always creates a temporary file

COPIES = 4  # of the numbers in a library while it reads; 2 measured, 3 for Parquet
LIBRARIES = 2048 * MIB  # bytes of address space of a library without a file; 374 MiB measured for asammdf
ADDRESSES = 512 * MIB  # bytes of address space beyond the free memory, which are not all used
SECONDS = 30.0  # time limit for a small file
BYTES_A_SECOND = 2e6  # further time for a large one
PROCESSOR_SECONDS = 4.0  # processor time for each second of it
PR_SET_PDEATHSIG = 1  # linux/prctl.h

#: Program of the process. It does not run the package's __init__, which readers do not need.
BEGIN = """
import json, sys, types
job = json.loads(sys.stdin.readline())
sys.path += [entry for entry in job["sys_path"] if entry not in sys.path]
package = types.ModuleType("cogging")
package.__path__ = job["package"]
sys.modules["cogging"] = package
"""
START = "from cogging.logs.readers.isolate import serve; serve(job)"
OPTIONS = ("-I", "-B") if sys.flags.dont_write_bytecode else ("-I",)
#: Environment variables that are passed on: places, language, and libraries loaded here already.
KEPT: tuple[str, ...] = ("HOME", "LANG", "LC_ALL", "LC_CTYPE", "TMPDIR", "TEMP", "TMP", "LD_PRELOAD")
KEPT += ("HDF5_USE_FILE_LOCKING", "SYSTEMROOT", "SYSTEMDRIVE", "WINDIR", "USERPROFILE")
#: Lists of folders, of which only absolute paths are passed on: an empty one is the current folder.
FOLDERS = ("PATH", "LD_LIBRARY_PATH", "DYLD_LIBRARY_PATH", "DYLD_FALLBACK_LIBRARY_PATH")
#: Reading needs no threads, each of which allocates memory.
ONE_THREAD = ("OPENBLAS_NUM_THREADS", "OMP_NUM_THREADS", "MKL_NUM_THREADS", "NUMEXPR_MAX_THREADS")
ANSWER = b"\0cogging: what was read\0\n"  # precedes the result, behind other text on standard output
#: Errors of the machine, not of the file.
NO_ROOM = (errno.ENOSPC, errno.EDQUOT, errno.EFBIG, errno.EROFS, errno.EMFILE, errno.ENFILE)

# The parent process ------------------------------------------------------------------------------------------------


def read_isolated(kind: str, request: Request) -> dict[str, FloatArray]:
    """Return columns of finite real numbers of equal length; `kind` is a key of FORMATS."""
    from cogging._core import memory_left  # not in the reading process

    what, size = FORMATS[kind][0], os.path.getsize(request.path)
    seconds = SECONDS + size / BYTES_A_SECOND
    job = {
        "kind": kind,
        "memory": int(min(LIBRARIES + COPIES * numbers_most(size), ADDRESSES + memory_left())),
        "seconds": seconds,
        "parent": os.getpid(),
        "request": {
            **vars(request),
            "path": os.path.abspath(request.path),
            "shown": os.fspath(request.path),
            "scaled": sorted(request.scaled),
            "rows": [request.rows.start, request.rows.stop],
        },
        "sys_path": import_paths(os.fspath(request.path)),
        "package": [os.path.abspath(folder) for folder in sys.modules["cogging"].__path__],
    }
    folder: contextlib.AbstractContextManager[str | None] = contextlib.nullcontext()
    if kind in TEMPORARY:  # removed with its content, however the process ends
        try:
            folder = tempfile.TemporaryDirectory(prefix="cogging", ignore_cleanup_errors=True)
        except OSError as error:
            raise request.refuse(f"cannot be read: no room for temporary files: {error.strerror}") from None
    with folder as job["temporary"]:
        try:
            done = subprocess.run(
                [sys.executable, *OPTIONS, "-X", f"utf8={sys.flags.utf8_mode}", "-c", BEGIN + START],
                input=json.dumps(job).encode() + b"\n",
                stdout=subprocess.PIPE,
                stderr=subprocess.DEVNULL,
                cwd=os.path.abspath(os.sep),
                env=environment(),
                timeout=seconds,
            )
        except subprocess.TimeoutExpired:
            raise request.refuse(f"must be a whole {what}, got one that is not read within {seconds:.0f} s") from None
    at = done.stdout.find(ANSWER) + len(ANSWER)
    end = done.stdout.find(b"\n", at) + 1
    answer = json.loads(done.stdout[at:end]) if at >= len(ANSWER) and end else {}
    if "error" in answer:
        raise InputError(answer["error"])
    rows, names = answer.get("rows", 0), answer.get("names", [])
    if not answer or done.returncode or len(done.stdout) < end + 8 * rows * len(names):
        how = f"signal {-done.returncode}" if done.returncode < 0 else f"status {done.returncode}"
        raise request.refuse(f"must be a whole {what}, got one that ends its reader ({how})")
    if request.survey is not None:
        request.survey.extend((name, unit) for name, unit in answer["survey"])
    table = np.frombuffer(done.stdout, count=rows * len(names), offset=end).reshape(len(names), rows)
    return {name: column.copy() for name, column in zip(names, table, strict=True)}


def import_paths(beside: str) -> list[str]:
    """Return the search path of this process without the current folder, that of a file, and relative entries.

    The folder from which numpy was imported counts as one of installed libraries.
    """
    libraries = Path(np.__file__).parents[1]
    user = [folder for folder in (os.curdir, os.path.dirname(os.path.abspath(beside))) if os.path.exists(folder)]
    entries = []
    for entry in sys.path:
        if not isinstance(entry, str) or not os.path.isabs(entry) or not os.path.exists(entry):
            continue
        if os.path.samefile(entry, libraries) or not any(os.path.samefile(entry, folder) for folder in user):
            entries.append(entry)
    return entries


def environment() -> dict[str, str]:
    """Return the environment of the process, without variables that load code from other places."""
    kept = {name: os.environ[name] for name in KEPT if name in os.environ}
    for name in FOLDERS:
        folders = [folder for folder in os.environ.get(name, "").split(os.pathsep) if os.path.isabs(folder)]
        if folders:
            kept[name] = os.pathsep.join(folders)
    return kept | dict.fromkeys(ONE_THREAD, "1")


# The reading process -----------------------------------------------------------------------------------------------


def serve(job: Mapping[str, Any]) -> None:
    """Read the columns of a job, and write them to standard output."""
    output = os.fdopen(os.dup(1), "wb")
    os.dup2(os.open(os.devnull, os.O_WRONLY), 1)  # discards what a library prints
    confine(job)
    tempfile.tempdir = job["temporary"]
    request = Request(**{**job["request"], "rows": slice(*job["request"]["rows"])})
    answer: dict[str, Any]
    try:
        columns = _read(job["kind"], request)
    except InputError as error:
        columns, answer = {}, {"error": str(error)}
    else:
        rows = len(next(iter(columns.values()), ()))
        answer = {"names": list(columns), "rows": rows, "survey": request.survey}
    output.write(ANSWER + json.dumps(answer).encode() + b"\n")
    for values in columns.values():
        output.write(np.ascontiguousarray(values).data)
    output.flush()
    os._exit(0)  # skips the libraries' exit handlers, which damaged files can crash


def confine(job: Mapping[str, Any]) -> None:
    """Limit this process to the job's `memory` (bytes) and `seconds`, and end it with its parent."""
    if sys.platform == "linux":
        with contextlib.suppress(ImportError, OSError, AttributeError):  # at once, even in a loop of a library
            import ctypes

            ctypes.CDLL(None).prctl(PR_SET_PDEATHSIG, signal.SIGKILL)
    signal.signal(signal.SIGINT, signal.SIG_IGN)  # the parent handles Ctrl-C

    end = time.monotonic() + job["seconds"]

    def end_with_parent() -> None:
        while os.getppid() == job["parent"] and time.monotonic() < end:
            time.sleep(0.1)
        os._exit(1)

    threading.Thread(target=end_with_parent, daemon=True).start()
    try:
        import resource
    except ImportError:  # not on Windows
        return
    seconds = math.ceil(PROCESSOR_SECONDS * (job["seconds"] + 1.0))
    limits = {resource.RLIMIT_AS: job["memory"], resource.RLIMIT_CPU: seconds, resource.RLIMIT_CORE: 0}
    for limit, most in limits.items():
        hard = resource.getrlimit(limit)[1]
        if hard == resource.RLIM_INFINITY or most < hard:
            resource.setrlimit(limit, (most, hard))


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
    except Exception as error:  # any error of a library
        if isinstance(error, OSError) and error.errno in NO_ROOM and not error.filename:
            raise request.refuse(f"cannot be read: no room for temporary files: {error.strerror}") from None
        said = " ".join(str(error).split())[:120]
        got = f"{type(error).__name__}{': ' * bool(said)}{said}"
        raise request.refuse(f"must be a whole {what}, got {got}") from None


def _numbers(request: Request, table: Mapping[str, Any]) -> dict[str, FloatArray]:
    """Return the requested rows as arrays; refuse columns that are not finite real numbers of equal length."""
    arrays: dict[str, FloatArray] = {}
    for name, values in table.items():
        array = np.asarray(values)
        if array.dtype.names is not None or array.dtype.kind not in "fiu":
            raise request.refuse(f"{name}: must be real numbers, got {_described(array)}")
        if sum(length != 1 for length in array.shape) > 1:
            shape = " x ".join(map(str, array.shape))
            raise request.refuse(f"{name}: must be one column, got an array of {shape}")
        arrays[name] = array.reshape(-1).astype(np.float64)
    first = next(iter(arrays), "")
    for name, array in arrays.items():
        if array.size != arrays[first].size:
            raise request.refuse(f"{name}: must be as long as {first} ({arrays[first].size}), got {array.size}")
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
