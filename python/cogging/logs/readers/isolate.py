"""Readers of binary formats, run in a process of their own.

The libraries that read MATLAB, HDF5, ASAM MDF and Parquet files were not made for broken ones: cut or altered files
made them end the whole process, loop without end or ask for all memory. That process takes no code from the folder in
which a user works or a log lies, has bounded memory and time, and ends with its parent.
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
from collections.abc import Callable, Iterator, Mapping
from pathlib import Path
from typing import IO, Any

import numpy as np
import numpy.typing as npt

from cogging.arrays import FloatArray
from cogging.files import InputError
from cogging.logs.readers import matlab, mdf, parquet
from cogging.logs.readers.request import MIB, Request, numbers_most

#: Formats by name: what they are called, the extra that brings the library, and the reader.
FORMATS: dict[str, tuple[str, str, Callable[[Request], dict[str, Any]]]] = {
    "matlab": ("MATLAB file", "matlab", matlab.read),
    "hdf5": ("MATLAB 7.3 (HDF5) file", "matlab", matlab.read_hdf5),
    "mdf": ("ASAM MDF file", "mdf", mdf.read),
    "parquet": ("Parquet file", "parquet", parquet.read),
}
TEMPORARY = ("mdf",)  # formats whose library wants a temporary file whatever it does

COPIES = 4  # of its numbers that a library holds while it reads: twice were seen, three times of Parquet
LIBRARIES = 2048 * MIB  # bytes of addresses that a library takes without a file: 374 MiB were seen, of asammdf
ADDRESSES = 512 * MIB  # bytes of them that it may take beyond the memory that is left: they are not all in use
SECONDS = 30.0  # in which a small file must be read
BYTES_A_SECOND = 2e6  # slower is no reading
PROCESSOR_SECONDS = 4.0  # that a process may take for each second that it is given
PR_SET_PDEATHSIG = 1  # linux/prctl.h

#: What the process runs. The package's own start is left out: readers need none of it.
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
#: Variables that are handed on as they are: places, language, and what a dynamic linker has already loaded here.
KEPT: tuple[str, ...] = ("HOME", "LANG", "LC_ALL", "LC_CTYPE", "TMPDIR", "TEMP", "TMP", "LD_PRELOAD")
KEPT += ("HDF5_USE_FILE_LOCKING", "SYSTEMROOT", "SYSTEMDRIVE", "WINDIR", "USERPROFILE")
#: Lists of folders, of which those that are no absolute paths are left out: an empty one is the current folder.
FOLDERS = ("PATH", "LD_LIBRARY_PATH", "DYLD_LIBRARY_PATH", "DYLD_FALLBACK_LIBRARY_PATH")
#: Reading columns needs no threads, each of which asks for memory.
ONE_THREAD = ("OPENBLAS_NUM_THREADS", "OMP_NUM_THREADS", "MKL_NUM_THREADS", "NUMEXPR_MAX_THREADS")
ANSWER = b"\0cogging: what was read\0\n"  # behind whatever else was written to standard output
#: Errors of the machine, not of a file.
NO_ROOM = (errno.ENOSPC, errno.EDQUOT, errno.EFBIG, errno.EROFS, errno.EMFILE, errno.ENFILE)

# The process that asks ------------------------------------------------------------------------------------------------


def memory_most(size: int, left: float) -> int:
    """Return the bytes of addresses that reading a file of so many bytes may take where `left` bytes are free."""
    return int(min(LIBRARIES + COPIES * numbers_most(size), ADDRESSES + left))


def seconds_most(size: int) -> float:
    """Return the seconds in which a file of so many bytes must be read."""
    return SECONDS + size / BYTES_A_SECOND


def read_isolated(kind: str, request: Request) -> dict[str, FloatArray]:
    """Read columns of finite real numbers of one length; `kind` is a key of FORMATS."""
    from cogging._core import memory_left  # which the process that reads does without

    what, size = FORMATS[kind][0], os.path.getsize(request.path)
    seconds, late = seconds_most(size), threading.Event()
    job = {
        "kind": kind,
        "memory": memory_most(size, memory_left()),
        "seconds": seconds,
        "path": os.path.abspath(request.path),
        "shown": os.fspath(request.path),
        "names": list(request.names),
        "optional": list(request.optional),
        "columns": dict(request.columns),
        "scaled": sorted(request.scaled),
        "rows": [request.rows.start, request.rows.stop],
        "survey": request.survey is not None,
        "sys_path": import_paths(os.fspath(request.path)),
        "package": [os.path.abspath(folder) for folder in sys.modules["cogging"].__path__],
        "temporary": None,
    }
    with contextlib.ExitStack() as stack:
        if kind in TEMPORARY:  # a folder that goes with what the library left there, however the process ended
            try:
                folder = tempfile.TemporaryDirectory(prefix="cogging", ignore_cleanup_errors=True)
            except OSError as error:
                raise request.refuse(f"cannot be read: no room for temporary files: {error.strerror}") from None
            job["temporary"] = stack.enter_context(folder)
        process = stack.enter_context(_started(job))

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


@contextlib.contextmanager
def _started(job: Mapping[str, Any]) -> Iterator[subprocess.Popen[bytes]]:
    """Start the process that reads; it is ended with the block."""
    process = subprocess.Popen(
        [sys.executable, *OPTIONS, "-X", f"utf8={sys.flags.utf8_mode}", "-c", BEGIN + START],
        stdin=subprocess.PIPE,
        stdout=subprocess.PIPE,
        stderr=subprocess.DEVNULL,
        cwd=os.path.abspath(os.sep),
        env=environment(),
    )
    assert process.stdin is not None
    assert process.stdout is not None
    try:
        with contextlib.suppress(BrokenPipeError):  # it has ended: its status says how
            process.stdin.write(json.dumps(job).encode() + b"\n")
            process.stdin.flush()  # left open: its end is the parent's
        yield process
    finally:
        process.kill()
        for stream in (process.stdin, process.stdout):
            with contextlib.suppress(BrokenPipeError):
                stream.close()
        process.wait()


def _received(process: subprocess.Popen[bytes], request: Request) -> dict[str, FloatArray] | None:
    """Return the columns that serve() writes, or None if it ends before all are there."""
    from cogging._core import require_memory

    stream = process.stdout
    assert stream is not None
    while (line := stream.readline()) and not line.endswith(ANSWER):
        pass
    head = stream.readline()
    if not head.endswith(b"\n"):
        return None
    answer = json.loads(head)
    if "error" in answer:
        raise InputError(answer["error"])
    if request.survey is not None:
        request.survey.extend((name, unit) for name, unit in answer["survey"])
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


def import_paths(beside: str) -> list[str]:
    """Return the entries of this process' search path, but for the current folder, that of a file, and relative ones.

    A folder from which numpy was loaded is one of installed libraries, wherever it is.
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
    """Return the variables that the process needs, without what makes Python or a linker take code from elsewhere."""
    kept = {name: os.environ[name] for name in KEPT if name in os.environ}
    for name in FOLDERS:
        folders = [folder for folder in os.environ.get(name, "").split(os.pathsep) if os.path.isabs(folder)]
        if folders:
            kept[name] = os.pathsep.join(folders)
    return kept | dict.fromkeys(ONE_THREAD, "1")


# The process that reads -----------------------------------------------------------------------------------------------


def serve(job: Mapping[str, Any]) -> None:
    """Read in this process what read_isolated asks for, and write it to standard output."""
    output = os.fdopen(os.dup(1), "wb")
    os.dup2(os.open(os.devnull, os.O_WRONLY), 1)  # whatever a library prints
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


def confine(job: Mapping[str, Any]) -> None:
    """Bind this process to its parent's life and to the job's `memory` (bytes) and `seconds`."""
    if sys.platform == "linux":
        with contextlib.suppress(ImportError, OSError, AttributeError):  # at once, even out of a loop of a library
            import ctypes

            ctypes.CDLL(None).prctl(PR_SET_PDEATHSIG, signal.SIGKILL)
    signal.signal(signal.SIGINT, signal.SIG_IGN)  # Ctrl-C is the parent's to answer

    def end_with_parent() -> None:
        while os.read(0, 1):  # which nobody writes any more
            pass
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
