"""A Python process that runs this package's code and that of installed libraries, and nothing that lies about.

Its folder of work, its search path and its environment hold nothing of the folder in which a user works or of that
in which a log lies: a `json.py` there is a user's file, not a module. It ends with its parent, however that ends.
"""

from __future__ import annotations

import contextlib
import json
import math
import os
import signal
import subprocess
import sys
import threading
from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import Any

import numpy as np

#: What a process of its own is started with. The package's own start is left out: readers need none of it.
BEGIN = """
import json, sys, types
job = json.loads(sys.stdin.readline())
sys.path += [entry for entry in job["sys_path"] if entry not in sys.path]
package = types.ModuleType("cogging")
package.__path__ = job["package"]
sys.modules["cogging"] = package
"""
OPTIONS = ("-I", "-B") if sys.flags.dont_write_bytecode else ("-I",)
#: Variables that are handed on as they are: places, language, and what a dynamic linker has already loaded here.
KEPT: tuple[str, ...] = ("HOME", "LANG", "LC_ALL", "LC_CTYPE", "TMPDIR", "TEMP", "TMP", "LD_PRELOAD")
KEPT += ("HDF5_USE_FILE_LOCKING", "SYSTEMROOT", "SYSTEMDRIVE", "WINDIR", "USERPROFILE")
#: Lists of folders, of which those that are no absolute paths are left out: an empty one is the current folder.
FOLDERS = ("PATH", "LD_LIBRARY_PATH", "DYLD_LIBRARY_PATH", "DYLD_FALLBACK_LIBRARY_PATH")
#: Reading columns needs no threads, each of which asks for memory.
ONE_THREAD = ("OPENBLAS_NUM_THREADS", "OMP_NUM_THREADS", "MKL_NUM_THREADS", "NUMEXPR_MAX_THREADS")
PROCESSOR_SECONDS = 4.0  # that a process may take for each second that it is given
PR_SET_PDEATHSIG = 1  # linux/prctl.h


@contextlib.contextmanager
def isolated(code: str, job: Mapping[str, Any], beside: str) -> Iterator[subprocess.Popen[bytes]]:
    """Run code with `job` in a process of its own, whose standard output is open to be read, and end it at the end.

    Args:
        code: what follows BEGIN.
        job: what JSON can hold; `sys_path` and `package` are added.
        beside: a file beside which no code is taken from.
    """
    job = {
        **job,
        "sys_path": import_paths(beside),
        "package": [os.path.abspath(folder) for folder in sys.modules["cogging"].__path__],
    }
    process = subprocess.Popen(
        [sys.executable, *OPTIONS, "-X", f"utf8={sys.flags.utf8_mode}", "-c", BEGIN + code],
        stdin=subprocess.PIPE,
        stdout=subprocess.PIPE,
        stderr=subprocess.DEVNULL,
        cwd=os.path.abspath(os.sep),
        env=environment(),
    )
    try:
        assert process.stdin is not None
        with contextlib.suppress(BrokenPipeError):  # it has ended: its status says how
            process.stdin.write(json.dumps(job).encode() + b"\n")
            process.stdin.flush()  # left open: its end is the parent's
        yield process
    finally:
        process.kill()
        for stream in (process.stdin, process.stdout):
            assert stream is not None
            with contextlib.suppress(BrokenPipeError):
                stream.close()
        process.wait()


def import_paths(beside: str) -> list[str]:
    """The entries of this process' search path, but for the current folder, that of a file, and relative ones.

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
    """The variables that a process of its own needs, without what makes Python or a linker take code from elsewhere."""
    kept = {name: os.environ[name] for name in KEPT if name in os.environ}
    for name in FOLDERS:
        folders = [folder for folder in os.environ.get(name, "").split(os.pathsep) if os.path.isabs(folder)]
        if folders:
            kept[name] = os.pathsep.join(folders)
    return kept | dict.fromkeys(ONE_THREAD, "1")


def confine(job: Mapping[str, Any]) -> None:
    """Bind this process to its parent's life and to the job's `memory` (bytes) and `seconds`."""
    if sys.platform == "linux":
        with contextlib.suppress(ImportError, OSError, AttributeError):  # at once, even out of a loop of a library
            import ctypes

            ctypes.CDLL(None).prctl(PR_SET_PDEATHSIG, signal.SIGKILL)
    signal.signal(signal.SIGINT, signal.SIG_IGN)  # Ctrl-C is the parent's to answer
    threading.Thread(target=_end_with_parent, daemon=True).start()
    try:
        import resource
    except ImportError:  # not on Windows
        return
    seconds = math.ceil(PROCESSOR_SECONDS * (job["seconds"] + 1.0))
    for limit, most in (
        (resource.RLIMIT_AS, job["memory"]),
        (resource.RLIMIT_CPU, seconds),
        (resource.RLIMIT_CORE, 0),
    ):
        hard = resource.getrlimit(limit)[1]
        if hard == resource.RLIM_INFINITY or most < hard:
            resource.setrlimit(limit, (most, hard))


def _end_with_parent() -> None:
    """Wait for the end of standard input, which nobody writes any more, and end this process."""
    while os.read(0, 1):
        pass
    os._exit(1)
