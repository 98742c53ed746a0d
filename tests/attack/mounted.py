"""Folders to write into, on file systems of their own where the machine allows them."""

from __future__ import annotations

import contextlib
import ctypes
import os
import shutil
import sys
import tempfile
from collections.abc import Iterator
from pathlib import Path


class Disk:
    """Folders to write into, and file systems of their own where the machine allows them."""

    def __init__(self, place: Path) -> None:
        self.place = place
        self.mounts = can_mount()

    @contextlib.contextmanager
    def folder(self, options: str = "") -> Iterator[Path]:
        """A new folder; with options of tmpfs it is a file system of its own."""
        path = Path(tempfile.mkdtemp(dir=self.place))
        if options:
            mount("cogging", path, "tmpfs", 0, options)
        try:
            yield path
        finally:
            if options:
                unmount(path)
            for place, _, _ in os.walk(path):
                os.chmod(place, 0o700)  # from above, where a case has taken the right to change it
            shutil.rmtree(path)


def mount(source: str, target: Path, kind: str, flags: int, options: str) -> None:
    """Mount a file system.

    Raises:
        OSError: it may not be.
    """
    library = ctypes.CDLL(None, use_errno=True)
    given = [source.encode(), os.fsencode(target), kind.encode(), flags, options.encode()]
    if library.mount(given[0], given[1], given[2], ctypes.c_ulong(given[3]), given[4]):
        raise OSError(ctypes.get_errno(), os.strerror(ctypes.get_errno()))


def unmount(target: Path) -> None:
    """Take a file system away.

    Raises:
        OSError: it is in use.
    """
    if ctypes.CDLL(None, use_errno=True).umount(os.fsencode(target)):
        raise OSError(ctypes.get_errno(), os.strerror(ctypes.get_errno()))


def can_mount() -> bool:
    """Whether this process may mount a file system."""
    if sys.platform != "linux":
        return False
    with tempfile.TemporaryDirectory() as folder:
        try:
            mount("cogging", Path(folder), "tmpfs", 0, "size=64k")
            unmount(Path(folder))
        except (OSError, AttributeError):
            return False
    return True
