"""A writer in a process of its own, and what came of it: the old version, the new one, or half of one."""

from __future__ import annotations

import contextlib
import os
import traceback
from collections import Counter
from collections.abc import Callable
from pathlib import Path

from cogging.files import InputError
from cogging.outputs import write_files
from tests.attack.mounted import Disk
from tests.attack.written import VERSIONS, left, state

Write = Callable[[Path, str], None]
OLD, NEW = VERSIONS


def in_child(work: Callable[[], object]) -> tuple[int, str]:
    """Do something in a forked process; its status and what it told: nothing, one line, or a traceback."""
    reading, writing = os.pipe()
    child = os.fork()
    if not child:
        told = ""
        try:
            work()
        except InputError as error:
            told = f"InputError {error}"
        except BaseException:
            told = traceback.format_exc()
        with contextlib.suppress(BaseException):
            os.write(writing, told.encode()[-60_000:])
        os._exit(2 if told else 0)
    os.close(writing)
    with os.fdopen(reading, "rb") as pipe:
        told = pipe.read().decode()
    status = os.waitstatus_to_exitcode(os.waitpid(child, 0)[1])
    return status, told


class Judge:
    """Says what came of writing a kind over its old version, or where there was none."""

    def __init__(self, write: Write, disk: Disk) -> None:
        self.write = write
        self.whole = {}
        for version in VERSIONS:
            with disk.folder() as folder:
                write(folder, version)
                self.whole[version] = state(folder)
        with disk.folder() as folder:  # as a new one is written over an old one
            write(folder, OLD)
            write(folder, NEW)
            if state(folder) != self.whole[NEW] or left(folder) or self.whole[NEW] == self.whole[OLD]:
                raise AssertionError("a new version over an old one, undisturbed, is not the new one and another")
        self.size = sum(map(len, self.whole[OLD].values())) + sum(map(len, self.whole[NEW].values()))

    def standing(self, folder: Path, had_old: bool) -> str:
        """ "old", "new" or "half"; where there was none before, nothing is the old version."""
        found = state(folder)
        if found == self.whole[NEW]:
            return "new"
        return "old" if found == (self.whole[OLD] if had_old else {}) else "half"

    def told(self, status: int, told: str, folder: Path, standing: str) -> str:
        """What is wrong with the answer of a writer that was not killed; "" if nothing is."""
        if not told:
            return "" if standing == "new" else f"done, and {standing}"
        if not told.startswith("InputError "):
            return f"traceback: {told.splitlines()[-1]}"
        if "\n" in told:
            return f"not one line: {told[:300]!r}"
        return "" if str(folder) in told and standing == "old" else f"{standing}, and told {told[:300]!r}"

    def next_writer(self, folder: Path) -> None:
        """Somebody writes two files of his own where this kind is written."""
        for place in sorted({path.parent for path in folder.rglob("*") if path.is_file()} | {folder}):
            if not place.name.endswith(".pieces"):
                own = [place / "own", place / "own too"]
                write_files({str(path): [b"mine"] for path in own})
                for path in own:
                    path.unlink()


class Tally:
    """What came of a condition."""

    def __init__(self) -> None:
        self.counts: Counter[str] = Counter()
        self.faults: list[str] = []

    def add(self, standing: str, fault: str = "") -> None:
        self.counts[standing] += 1
        if standing == "half" or fault:
            self.faults.append(fault or "half")

    def text(self) -> str:
        told = ", ".join(f"{self.counts[name]} {name}" for name in ("old", "new", "half"))
        further = "".join(f", {n} {name}" for name, n in sorted(self.counts.items()) if name not in (*VERSIONS, "half"))
        return f"{sum(self.counts[name] for name in (*VERSIONS, 'half'))} cases: {told}{further}"
