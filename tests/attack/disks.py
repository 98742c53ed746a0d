"""Full and read-only disks, errors, kills, other writers, wherever a file is written: `python -m tests.attack.disks`.

Every kind of output (tests/attack/written.py) is written where an older version of it stands and where none does, while
a file system of a few kilobytes or a few files is full at every stage, an error comes before any of its file
operations, the process is killed there, a folder cannot be written to, twenty processes write at once. What stands
afterwards is the old version or the new one, whole; what is told is one line that names the output; nothing else is
left. After a kill the next writer may have to take back what was begun: that is counted apart, with what is left until
then. Options: NAME ... kinds, --writers N, --short: every fifth case.
"""

from __future__ import annotations

import argparse
import errno
import json
import os
import shutil
import signal
import subprocess
import sys
import tempfile
import traceback
from collections.abc import Callable
from pathlib import Path

from cogging.files import InputError
from tests.attack.judged import NEW, OLD, Judge, Tally, Write, in_child
from tests.attack.mounted import Disk, mount
from tests.attack.operations import at_operation
from tests.attack.written import KINDS, VERSIONS, left, state

ERRORS = (errno.ENOSPC, errno.EIO, errno.EROFS, errno.EACCES)
NOBODY = 65534
PAGE = 4096
MOST_SIZES = 120  # of a file system that is too small
MS_RDONLY, MS_REMOUNT = 1, 32


def begun(write: Write, folder: Path, had_old: bool) -> None:
    if had_old:
        write(folder, OLD)


def full_disk(judge: Judge, disk: Disk, tally: Tally, step: int) -> None:
    """A file system so small that it is full at every stage: in bytes, then in files."""
    for option, most in (("size", 3 * judge.size // PAGE + 40), ("nr_inodes", 24)):
        for had_old in (True, False):
            for number in range(2, most, max(step, most // MOST_SIZES)):
                limit = f"size={number * PAGE}" if option == "size" else f"nr_inodes={number}"
                room = "size=64m,nr_inodes=1000"
                with disk.folder(room) as folder:
                    begun(judge.write, folder, had_old)
                    try:
                        mount("cogging", folder, "tmpfs", MS_REMOUNT, limit)
                    except OSError:  # less than what is there
                        continue
                    status, told = in_child(lambda folder=folder: judge.write(folder, NEW))
                    standing = judge.standing(folder, had_old)
                    tally.add(standing, judge.told(status, told, folder, standing) or over(folder))


def over(folder: Path) -> str:
    """What is wrong with what is left beside the output; "" if nothing is."""
    found = left(folder)
    return f"left: {found}" if found else ""


def concerns(folder: Path) -> Callable[[str, str], bool]:
    return lambda event, path: path.startswith(str(folder))


def failing(judge: Judge, disk: Disk, tally: Tally, step: int) -> None:
    """An error before the n-th operation on files, for each n."""
    for had_old in (True, False):
        for code in ERRORS[: None if step == 1 else 1]:
            for number in range(1, 400, step):
                with disk.folder() as folder:
                    begun(judge.write, folder, had_old)

                    def work(folder=folder, number=number, code=code):
                        def fail(event, path):
                            raise OSError(code, os.strerror(code), path)

                        at_operation(number, concerns(folder), fail)
                        judge.write(folder, NEW)

                    status, told = in_child(work)
                    standing = judge.standing(folder, had_old)
                    tally.add(standing, judge.told(status, told, folder, standing))
                    tally.counts["left something behind"] += bool(left(folder))
                    if not told and number > 1:
                        break


def killed(judge: Judge, disk: Disk, tally: Tally, step: int) -> None:
    """SIGKILL before the n-th operation on files, for each n; then the next writer comes."""
    for had_old in (True, False):
        for number in range(1, 400, step):
            with disk.folder() as folder:
                begun(judge.write, folder, had_old)

                def work(folder=folder, number=number):
                    at_operation(number, concerns(folder), lambda *_: os.kill(os.getpid(), signal.SIGKILL))
                    judge.write(folder, NEW)

                status, told = in_child(work)
                if told:
                    tally.add("half", f"traceback: {told.splitlines()[-1]}")
                at_once = judge.standing(folder, had_old)
                judge.next_writer(folder)
                standing = judge.standing(folder, had_old)
                tally.add(standing)
                tally.counts["of them by the next writer"] += at_once != standing
                if not status:
                    break
                tally.counts["left a file by its name until then or longer"] += bool(left(folder))


def read_only(judge: Judge, disk: Disk, tally: Tally, step: int) -> None:
    """A file system that is read-only, a folder or files that somebody else may not write to."""
    for had_old in (True, False):
        if disk.mounts:
            with disk.folder("size=64m") as folder:
                begun(judge.write, folder, had_old)
                mount("cogging", folder, "tmpfs", MS_REMOUNT | MS_RDONLY, "")
                status, told = in_child(lambda folder=folder: judge.write(folder, NEW))
                standing = judge.standing(folder, had_old)
                tally.add(standing, judge.told(status, told, folder, standing) or over(folder))
        for protect in (no_folder, no_files, sticky):
            with disk.folder() as folder:
                begun(judge.write, folder, had_old)
                protect(folder)
                status, told = in_child(lambda folder=folder: as_somebody(lambda: judge.write(folder, NEW)))
                standing = judge.standing(folder, had_old)
                tally.add(standing, judge.told(status, told, folder, standing) or over(folder))


def no_folder(folder: Path) -> None:
    for path in (folder, *folder.rglob("*")):
        path.chmod(0o555 if path.is_dir() else 0o666)


def no_files(folder: Path) -> None:
    for path in (folder, *folder.rglob("*")):
        path.chmod(0o777 if path.is_dir() else 0o444)


def sticky(folder: Path) -> None:
    """As /tmp: whoever may write, but nobody replaces another's."""
    for path in (folder, *folder.rglob("*")):
        path.chmod(0o1777 if path.is_dir() else 0o666)


def in_the_way(judge: Judge, disk: Disk, tally: Tally, step: int) -> None:
    """Links to files, also to none yet, which stay links, and modes, which stay; folders and endless links, refused."""
    for had_old in (True, False):
        with disk.folder() as folder, disk.folder() as elsewhere:
            begun(judge.write, folder, True)
            linked = [path for path in folder.rglob("*") if os.path.relpath(path, folder) in judge.whole[NEW]]
            for number, path in enumerate(linked):
                path.chmod(0o640)
                shutil.move(path, elsewhere / f"{number}")
                path.symlink_to(elsewhere / f"{number}")
                if not had_old:
                    (elsewhere / f"{number}").unlink()
            status, told = in_child(lambda folder=folder: judge.write(folder, NEW))
            standing = judge.standing(folder, had_old)
            kept = all(path.is_symlink() for path in linked)
            modes = not had_old or {path.stat().st_mode & 0o777 for path in linked} == {0o640}
            fault = "" if kept and modes else f"links {kept}, modes {modes}"
            tally.add(standing, judge.told(status, told, folder, standing) or fault or over(folder))
    for name in judge.whole[NEW]:
        for put in (Path.mkdir, lambda path: path.symlink_to(path)):
            with disk.folder() as folder:
                begun(judge.write, folder, True)
                (folder / name).unlink()
                put(folder / name)
                before = state(folder)
                status, told = in_child(lambda folder=folder: judge.write(folder, NEW))
                standing = "old" if state(folder) == before else "half"
                tally.add(standing, judge.told(status, told, folder, standing) or over(folder))


def as_somebody(work: Callable[[], object]) -> None:
    """Without an administrator's rights."""
    if os.geteuid() == 0:
        os.setgroups([])
        os.setgid(NOBODY)
        os.setuid(NOBODY)
    work()


def writers(judge: Judge, disk: Disk, tally: Tally, many: int, *, kills: bool = False) -> None:
    """Many processes write at once, old and new by turns; with kills, a third of them do not come to their end."""
    for had_old in (True, False):
        with disk.folder() as folder:
            begun(judge.write, folder, had_old)
            children = []
            for number in range(many):
                child = os.fork()
                if not child:
                    os._exit(_written_by_turns(judge, folder, number, kills=kills and number % 3 == 0))
                children.append(child)
            ends = [os.waitstatus_to_exitcode(os.waitpid(child, 0)[1]) for child in children]
            if kills:
                judge.next_writer(folder)
            found = state(folder)
            standing = next((version for version in VERSIONS if found == judge.whole[version]), "half")
            unlike = [end for end in ends if end not in (0, 2, -signal.SIGKILL)]
            fault = f"ends: {unlike}" if unlike else "" if kills else over(folder)
            tally.add(standing, fault)
            tally.counts["writers done"] += ends.count(0)
            tally.counts["writers refused"] += ends.count(2)
            tally.counts["writers killed"] += ends.count(-signal.SIGKILL)


def _written_by_turns(judge: Judge, folder: Path, number: int, *, kills: bool) -> int:
    status = 0
    if kills:
        at_operation(3 + 5 * number, concerns(folder), lambda *_: os.kill(os.getpid(), signal.SIGKILL))
    for turn in range(4):
        try:
            judge.write(folder, VERSIONS[(number + turn) % 2])
        except InputError:
            status = 2
        except BaseException:
            traceback.print_exc()
            return 3
    return status


def attacked(names: list[str], disk: Disk, many: int, step: int) -> dict[str, dict[str, Tally]]:
    """Every condition for every kind."""
    found: dict[str, dict[str, Tally]] = {}
    for name in names:
        judge = Judge(KINDS[name], disk)
        conditions: dict[str, Callable[[Tally], None]] = {
            "an error at any operation": lambda tally, judge=judge: failing(judge, disk, tally, step),
            "killed at any operation": lambda tally, judge=judge: killed(judge, disk, tally, step),
            "read-only": lambda tally, judge=judge: read_only(judge, disk, tally, step),
            "links and folders in the way": lambda tally, judge=judge: in_the_way(judge, disk, tally, step),
            f"{many} writers": lambda tally, judge=judge: writers(judge, disk, tally, many),
            f"{many} writers, some killed": lambda tally, judge=judge: writers(judge, disk, tally, many, kills=True),
        }
        if disk.mounts:
            conditions["full disk"] = lambda tally, judge=judge: full_disk(judge, disk, tally, step)
        found[name] = {}
        for condition, make in conditions.items():
            found[name][condition] = tally = Tally()
            make(tally)
            print(f"{name}, {condition}: {tally.text()}", flush=True)
            for fault in tally.faults[:5]:
                print(f"    {fault}", flush=True)
    return found


def main() -> int:
    """Attack; status 1 where anything is half, left, or told otherwise than in one line."""
    parser = argparse.ArgumentParser(prog="python -m tests.attack.disks", description=__doc__)
    parser.add_argument("names", nargs="*", metavar="NAME", help=f"{', '.join(KINDS)}; all when none is named")
    parser.add_argument("--writers", type=int, default=20)
    parser.add_argument("--short", action="store_true")
    parser.add_argument("--json", help="where the counts are written")
    parser.add_argument("--folder", default="/dev/shm" if os.path.isdir("/dev/shm") else None)
    arguments = parser.parse_args()
    alone = os.environ.get("COGGING_ALONE")
    if not alone and shutil.which("unshare"):  # mounts of its own, which go with it
        words = ["unshare", "-m"] if os.geteuid() == 0 else ["unshare", "-rm"]
        if not subprocess.run([*words, "true"], capture_output=True, check=False).returncode:
            os.environ["COGGING_ALONE"] = "1"
            os.execvp(words[0], [*words, sys.executable, "-m", "tests.attack.disks", *sys.argv[1:]])
    with tempfile.TemporaryDirectory(dir=arguments.folder) as folder:
        os.chmod(folder, 0o755)
        disk = Disk(Path(folder))
        if not disk.mounts:
            print("no file system may be mounted here: no full disk, none that is read-only", flush=True)
        found = attacked(arguments.names or list(KINDS), disk, arguments.writers, 5 if arguments.short else 1)
    if arguments.json:
        counts = {name: {what: dict(t.counts) for what, t in tallies.items()} for name, tallies in found.items()}
        Path(arguments.json).write_text(json.dumps(counts, indent=1))
    return 1 if any(tally.faults for tallies in found.values() for tally in tallies.values()) else 0


if __name__ == "__main__":
    sys.exit(main())
