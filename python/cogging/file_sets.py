"""Files that belong together take their places as one, whatever comes between: a failure, another writer, a kill.

No call of a file system replaces several files at once. So what stands in a folder keeps a second name (OLD) until all
new files have their places, and a record in the folder (RECORD) says which: a failure is taken back at once, and what
a kill or a power failure has interrupted is taken back by the next writer of such files there. Who has the record
locked is the one writer; another waits.
"""

from __future__ import annotations

import contextlib
import errno
import json
import os
import re
import secrets
import shutil
import stat
import sys
from collections.abc import Iterable, Sequence
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import IO, NamedTuple

from cogging.file_locks import opened_alone, rewrite

RECORD = ".cogging-writing"
PART, OLD = ".cogging-{}.part", ".cogging-{}.old"  # beside a file: one that is not whole yet, what stood there
OF_OURS = re.compile(r"\.cogging-[0-9a-f]{16}\.(part|old)")
LONGEST_WAIT = 30.0  # s, for another writer, who takes milliseconds
LARGEST_RECORD = 1 << 20  # bytes: of some thousand files
PENDING, DONE = b"-", b"+"  # the first byte of a record: take it back, or only clear up behind it
synced = True  # data reach the disk before their names do; what only tests many small files has no use for it


class Change(NamedTuple):
    """A file that takes its place.

    Attributes:
        target: the place, behind links.
        part: what takes it, in the same folder; None: what stands there goes away.
    """

    target: Path
    part: Path | None


@dataclass(frozen=True)
class _Entry:
    """A change as a record holds it: names in its folder, and the number by which the new file is told from others."""

    name: str
    part: str | None
    old: str | None
    after: int | None


def beside(target: Path, pattern: str) -> Path:
    """A name that nobody foresees and that says whose it is, in the folder of a file."""
    return target.with_name(pattern.format(secrets.token_hex(8)))


def take_places(changes: Sequence[Change]) -> None:
    """Make all changes or none; those of one folder also where the process is killed.

    Raises:
        OSError: one cannot be made; all is as it was.
    """
    folders = sorted({change.target.parent for change in changes})
    with contextlib.ExitStack() as open_sets:
        sets: list[_FolderSet] = []
        if len(changes) > 1:
            sets = [open_sets.enter_context(_FolderSet(folder)) for folder in folders]
            changes = [change for change in changes if change.part is not None or os.path.lexists(change.target)]
        if len(changes) == 1 and changes[0].part is not None:
            os.replace(changes[0].part, changes[0].target)
        elif changes:
            _take_places(sets, changes)
    for folder in folders:
        sync_folder(folder)


def _take_places(sets: Sequence[_FolderSet], changes: Sequence[Change]) -> None:
    try:
        for one in sets:
            one.prepare(changes)
        for one in sets:
            one.exchange()
        for one in sets:
            one.settle()
    except BaseException:
        for one in sets:
            one.take_back()
        raise
    for one in sets:
        one.clear_up()


def settle(targets: Sequence[Path]) -> None:
    """Take back what a writer who was killed has begun with any of some files; one who is still at it is waited for.

    Args:
        targets: places in one folder, behind links.

    Raises:
        OSError: it cannot be taken back, as where this user may not write.
    """
    folder = targets[0].parent
    try:
        if sys.platform == "win32" or not stat.S_ISREG(os.lstat(folder / RECORD).st_mode) or not _is_trusted(folder):
            return
        content = _content(folder / RECORD)
    except OSError:  # none, or none that this user is told of
        return
    if content[:1] == PENDING and {entry.name for entry in _entries(content)} & {path.name for path in targets}:
        opened_alone(folder / RECORD, wait=LONGEST_WAIT).close()  # or tells why it cannot
        with _FolderSet(folder):
            pass


def _content(record: Path) -> bytes:
    with open(record, "rb") as file:
        return file.read(LARGEST_RECORD)


def sync_folder(folder: Path) -> None:
    """Let names in a folder outlast a power failure, where the system can be asked to."""
    if synced and os.name != "nt":
        with contextlib.suppress(OSError):  # a file system that has no such thing
            descriptor = os.open(folder, os.O_RDONLY)
            try:
                os.fsync(descriptor)
            finally:
                os.close(descriptor)


class _FolderSet:
    """The changes of one folder, and its record while they are made."""

    def __init__(self, folder: Path) -> None:
        self._folder = folder
        self._entries: list[_Entry] = []
        self._record: IO[bytes] | None = None

    def __enter__(self) -> _FolderSet:
        if sys.platform != "win32" and _is_trusted(self._folder):  # on Windows a file that is open cannot go
            with contextlib.suppress(PermissionError):  # of another user, whom this one cannot wait for
                self._record = opened_alone(self._folder / RECORD, wait=LONGEST_WAIT)
        if self._record is not None:
            try:
                _finish(self._folder, self._record)
            except BaseException:
                self._record.close()
                raise
        return self

    def __exit__(self, *_: object) -> None:
        if self._record is not None:
            with self._record, contextlib.suppress(OSError):
                if not self._record.seek(0, os.SEEK_END):  # else what could not be taken back is still told there
                    (self._folder / RECORD).unlink(missing_ok=True)

    def prepare(self, changes: Iterable[Change]) -> None:
        """Keep what stands there, and note what will be done, before it is; of the changes those of this folder."""
        for target, part in changes:
            if target.parent != self._folder:
                continue
            old = beside(target, OLD).name if os.path.lexists(target) else None
            after = None if part is None else os.lstat(part).st_ino
            self._entries.append(_Entry(target.name, None if part is None else part.name, old, after))
        self._note(PENDING + json.dumps([asdict(entry) for entry in self._entries]).encode())
        for entry in self._entries:
            if entry.old is not None and entry.part is not None:
                _keep(self._folder / entry.name, self._folder / entry.old)

    def exchange(self) -> None:
        """Make the changes."""
        for entry in self._entries:
            target = self._folder / entry.name
            if entry.part is not None:
                os.replace(self._folder / entry.part, target)
            elif entry.old is not None:
                os.rename(target, self._folder / entry.old)
        sync_folder(self._folder)

    def settle(self) -> None:
        """From here on the new files stand, whatever kills the process."""
        self._note(DONE)

    def clear_up(self) -> None:
        """Take away what stood there; where that fails the record stays, for the next writer."""
        with contextlib.suppress(OSError):
            _clear_up(self._folder, self._entries)
            self._note(b"")

    def take_back(self) -> None:
        """Put back what stood there; where that fails the record stays, for the next writer."""
        with contextlib.suppress(OSError):
            for entry in self._entries:
                _take_back(self._folder, entry)
            self._note(b"")

    def _note(self, content: bytes) -> None:
        if self._record is None:
            return
        if content != DONE:  # that is one byte over another, whole or not there
            self._record.truncate(0)
        rewrite(self._record, content)
        if synced:
            os.fsync(self._record.fileno())


def _keep(target: Path, old: Path) -> None:
    """Give what stands at a place a second name, or a copy where the file system has no second names."""
    try:
        os.link(target, old)
    except FileExistsError:
        raise
    except OSError as error:
        if error.errno in (errno.ENOSPC, errno.EDQUOT, errno.EROFS):
            raise
        os.close(os.open(old, os.O_WRONLY | os.O_CREAT | os.O_EXCL, 0o600))  # nobody else's to read meanwhile
        shutil.copy2(target, old)


def _is_trusted(folder: Path) -> bool:
    """Whether the record of a folder, if there is one, may be heeded: where it is shared as /tmp is, not another's."""
    try:
        owner = os.lstat(folder / RECORD).st_uid
    except OSError:
        return True
    shared = os.stat(folder)
    return not shared.st_mode & stat.S_ISVTX or owner in (0, os.geteuid(), shared.st_uid)


def _finish(folder: Path, record: IO[bytes]) -> None:
    """Take back, or clear up, what a writer left who was killed."""
    content = record.read(LARGEST_RECORD)
    if not content:
        return
    entries = _entries(content)
    for entry in entries:
        if content[:1] == PENDING:
            _take_back(folder, entry)
    _clear_up(folder, entries)
    record.truncate(0)


def _entries(content: bytes) -> list[_Entry]:
    """What a record tells; nothing where it is none, or tells of other folders or of files that are not ours."""
    try:
        entries = [_Entry(**told) for told in json.loads(content[1:])]
        ours = all(
            os.path.basename(entry.name) == entry.name not in ("", ".", "..")
            and all(name is None or OF_OURS.fullmatch(name) for name in (entry.part, entry.old))
            for entry in entries
        )
    except (ValueError, TypeError, RecursionError):
        return []
    return entries if ours else []


def _take_back(folder: Path, entry: _Entry) -> None:
    """Undo a change where it was made; what somebody has put there since stays."""
    target, now = folder / entry.name, _number(folder / entry.name)
    old = None if entry.old is None else folder / entry.old
    made = now is None if entry.part is None else now == entry.after
    if made and old is not None and os.path.lexists(old):
        os.replace(old, target)
    elif made and old is None and entry.part is not None:
        target.unlink()
    _clear_up(folder, [entry])


def _clear_up(folder: Path, entries: Iterable[_Entry]) -> None:
    for entry in entries:
        for name in (entry.part, entry.old):
            if name is not None:
                with contextlib.suppress(FileNotFoundError):
                    os.unlink(folder / name)


def _number(path: Path) -> int | None:
    try:
        return os.lstat(path).st_ino
    except FileNotFoundError:
        return None
