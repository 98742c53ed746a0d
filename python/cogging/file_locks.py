"""Files that one writer at a time has open, where the file system has locks; else whoever writes twice must know it."""

from __future__ import annotations

import errno
import os
import stat
import sys
import time
from pathlib import Path
from typing import IO

if sys.platform != "win32":
    import fcntl

LOOK_EVERY = 0.002  # s, between two looks whether another writer is done


def opened_alone(path: Path, *, wait: float = 0.0, by_process: bool = False) -> IO[bytes]:
    """Open a file for reading and writing, made if need be, that nobody else has opened so, until it is closed.

    Args:
        path: of the file; it may go when its writer is done.
        wait: s, for another writer.
        by_process: a worker that is forked meanwhile has no part in the lock, which goes with this process; two threads
            of one process are not kept apart. Else they are, and the lock goes with the last that has the file open.

    Raises:
        BlockingIOError: another has it.
        OSError: it cannot be made.
    """
    end = time.monotonic() + wait
    flags = os.O_RDWR | os.O_CREAT | getattr(os, "O_NOFOLLOW", 0) | getattr(os, "O_BINARY", 0)
    while True:
        file = os.fdopen(os.open(path, flags, 0o666), "r+b", buffering=0)
        try:
            if not stat.S_ISREG(os.fstat(file.fileno()).st_mode):
                raise OSError(errno.EINVAL, "must be a file, got a device or pipe", os.fspath(path))
            _lock(file, end, by_process)
            if os.path.lexists(path) and os.path.samestat(os.fstat(file.fileno()), os.lstat(path)):
                return file
        except FileNotFoundError:  # of a writer who has just been done
            pass
        except BaseException:
            file.close()
            raise
        file.close()


def rewrite(file: IO[bytes], content: bytes) -> None:
    """Write from the beginning of an unbuffered file on, which may take several calls; what stands behind it stays."""
    file.seek(0)
    while content:
        content = content[file.write(content) :]


def _lock(file: IO[bytes], end: float, by_process: bool) -> None:
    while sys.platform != "win32":
        try:
            (fcntl.lockf if by_process else fcntl.flock)(file, fcntl.LOCK_EX | fcntl.LOCK_NB)
            return
        except OSError as error:
            if error.errno not in (errno.EAGAIN, errno.EACCES):  # a file system without locks
                return
        if time.monotonic() >= end:
            raise BlockingIOError(errno.EAGAIN, "another process is writing there")
        time.sleep(LOOK_EVERY)
