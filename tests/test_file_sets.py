"""Files that belong together take their places as one, whatever comes between; every kind: `tests.attack.disks`."""

import concurrent.futures
import errno
import json
import os
import stat
import subprocess
import sys
import threading
from pathlib import Path

import numpy as np
import pytest

import cogging
from cogging import file_sets, outputs
from cogging.file_locks import opened_alone
from cogging.files import InputError
from cogging.papers import result as papers

pytestmark = pytest.mark.skipif(os.name == "nt", reason="locks and links of POSIX")
OLD = {"a": b"old a", "b": b"old b", "gone": b"old too"}
NEW = {"a": b"new a", "b": b"new b", "c": b"new too"}


def standing(folder):
    return {path.name: path.read_bytes() for path in folder.iterdir()}


def place(folder):
    for name, content in OLD.items():
        (folder / name).write_bytes(content)


def write(folder):
    new = {name: [content] for name, content in NEW.items()}
    outputs.write_files({str(folder / name): pieces for name, pieces in {**new, "gone": None}.items()})


def failing_at(patch, number, thrown):
    """From here on the n-th call of what changes a folder fails; gives how many are left until then."""
    left = [number]

    def failing(plain):
        def call(*given, **options):
            left[0] -= 1
            if left[0] == 0:
                raise thrown
            return plain(*given, **options)

        return call

    for name in ("open", "link", "replace", "rename", "unlink"):
        patch.setattr(os, name, failing(getattr(os, name)))
    return left


@pytest.mark.parametrize("thrown", [OSError(errno.EIO, os.strerror(errno.EIO)), KeyboardInterrupt()])
def test_a_failure_between_any_two_steps_leaves_all_as_it_was(thrown, tmp_path, monkeypatch):
    """An error or a signal at each step: the old or the new ones; what is left is gone with the next writer."""
    counts = {"old": 0, "new": 0}
    for number in range(1, 60):
        folder, told = tmp_path / f"{number}", None
        folder.mkdir()
        place(folder)
        with monkeypatch.context() as patch:
            left = failing_at(patch, number, thrown)
            try:
                write(folder)
            except (InputError, KeyboardInterrupt) as error:
                told = error
        found = standing(folder)
        found = {name: content for name, content in found.items() if not name.startswith(".cogging-")}
        assert found in (OLD, NEW)
        counts["old" if found == OLD else "new"] += 1
        if isinstance(thrown, OSError):
            assert (found == OLD) == (told is not None), "what is told is what stands"
            assert told is None or f"{folder}" in str(told)
        outputs.write_files({str(folder / "x"): [b""], str(folder / "y"): [b""]})
        assert standing(folder) == {**found, "x": b"", "y": b""}
        if left[0] > 0:
            break
    assert counts["old"] >= 8
    assert counts["new"] >= 4


def test_every_kill_leaves_the_old_or_the_new_by_the_next_writer_and_the_next_reader(tmp_path):
    """A log and its metadata: SIGKILL before each operation; who reads or writes next finds one version of both."""
    code = """
import os, signal, sys
from pathlib import Path
import numpy as np
import cogging
from tests.attack.operations import at_operation

def log(seed):
    made = {name: np.full(3, float(seed)) for name in ("position", "command")}
    return cogging.Log(time=np.arange(3.0), **made, metadata={"seed": seed})

for number in range(1, 40):
    folder = Path(f"{number}")
    folder.mkdir()
    log(1).write(folder / "log.csv")
    child = os.fork()
    if not child:
        ours = lambda event, path: path.startswith(f"{folder.resolve()}")
        at_operation(number, ours, lambda *_: os.kill(os.getpid(), 9))
        log(2).write(folder / "log.csv")
        os._exit(0)
    status = os.waitstatus_to_exitcode(os.waitpid(child, 0)[1])
    begun = (folder / ".cogging-writing").exists()
    read = cogging.read_log(folder / "log.csv")
    print(status, read.command[0], read.metadata["seed"], begun)
    if not status:
        break
"""
    environment = {**os.environ, "PYTHONPATH": f"{Path(__file__).parents[1]}:{Path(cogging.__file__).parents[1]}"}
    done = subprocess.run(
        [sys.executable, "-c", code], cwd=tmp_path, env=environment, capture_output=True, text=True, check=False
    )
    assert done.returncode == 0, done.stderr
    lines = [line.split() for line in done.stdout.splitlines()]
    assert all(float(command) == float(seed) for _, command, seed, _ in lines), (
        "never one's numbers, another's metadata"
    )
    assert {seed for _, _, seed, _ in lines} == {"1", "2"}
    assert sum(begun == "True" for *_, begun in lines) > 3
    assert lines[-1][0] == "0"


def test_what_somebody_has_put_there_since_stays(tmp_path, monkeypatch):
    """A kill between two renames, then one of the files is written by hand: the next writer leaves that one."""
    place(tmp_path)

    def killed(*_):
        raise SystemExit

    with monkeypatch.context() as patch:
        patch.setattr(file_sets._FolderSet, "settle", killed)
        patch.setattr(file_sets._FolderSet, "take_back", lambda _: None)
        with pytest.raises(SystemExit):
            write(tmp_path)
    assert (tmp_path / file_sets.RECORD).exists()
    (tmp_path / "by hand").write_bytes(b"mine")
    (tmp_path / "by hand").replace(tmp_path / "a")
    begun = standing(tmp_path)
    file_sets.settle([tmp_path / "another"])
    assert standing(tmp_path) == begun, "of no concern to who reads another file"
    file_sets.settle([tmp_path / "b"])
    assert standing(tmp_path) == {**OLD, "a": b"mine"}


@pytest.mark.parametrize(
    "told",
    [
        {"name": "../victim", "part": None, "old": None, "after": None},
        {"name": "victim", "part": "victim", "old": None, "after": None},
        {"name": "victim", "part": None, "old": "/etc/passwd", "after": None},
        {"name": "..", "part": None, "old": None, "after": None},
        {"name": 1},
    ],
)
def test_a_record_that_a_stranger_has_planted_moves_nothing(told, tmp_path):
    folder = tmp_path / "work"
    folder.mkdir()
    place(folder)
    for victim in (tmp_path / "victim", folder / "victim"):
        victim.write_bytes(b"mine")
    told["after"] = os.stat(tmp_path / "victim").st_ino
    (folder / file_sets.RECORD).write_bytes(b"-" + json.dumps([told]).encode())
    file_sets.settle([folder / "victim", folder / "a"])
    outputs.write_files({str(folder / "x"): [b""], str(folder / "y"): [b""]})
    assert standing(folder) == {**OLD, "victim": b"mine", "x": b"", "y": b""}
    assert (tmp_path / "victim").read_bytes() == b"mine"


@pytest.mark.root
def test_a_record_of_another_in_a_shared_folder_is_not_heeded(tmp_path):
    """As a stranger may leave one in /tmp, and hold its lock."""
    place(tmp_path)
    (tmp_path / ".cogging-0123456789abcdef.old").write_bytes(b"a stranger's")
    told = {"name": "a", "part": ".cogging-0123456789abcdef.part", "old": ".cogging-0123456789abcdef.old"}
    told["after"] = os.stat(tmp_path / "a").st_ino
    record = tmp_path / file_sets.RECORD
    record.write_bytes(b"-" + json.dumps([told]).encode())
    os.chown(record, 3, 3)
    os.chown(tmp_path, 2, 2)
    tmp_path.chmod(0o1777)
    before = standing(tmp_path)
    with opened_alone(record):
        file_sets.settle([tmp_path / "a"])
        assert standing(tmp_path) == before
        write(tmp_path)
    planted = {name: before[name] for name in (record.name, told["old"])}
    assert standing(tmp_path) == {**NEW, **planted}
    tmp_path.chmod(0o777)  # where anybody may rename anything, it is as good as any
    told["after"] = os.stat(tmp_path / "a").st_ino
    record.write_bytes(b"-" + json.dumps([told]).encode())
    file_sets.settle([tmp_path / "a"])
    assert standing(tmp_path) == {**NEW, "a": b"a stranger's"}


def test_a_log_that_cannot_be_restored_is_one_line(tmp_path, monkeypatch):
    """A folder that may only be read, with what a killed writer has begun: not read as if it were whole."""
    log = cogging.Log(time=np.arange(3.0), position=np.zeros(3), command=np.ones(3), metadata={"seed": 1})
    log.write(tmp_path / "log.csv")
    told = {"name": "log.csv.toml", "part": ".cogging-0123456789abcdef.part", "old": None, "after": 0}

    def refused(path, **_):
        raise PermissionError(errno.EACCES, os.strerror(errno.EACCES), f"{path}")

    for first, whole in ((b"-", False), (b"+", True)):
        (tmp_path / file_sets.RECORD).write_bytes(first + json.dumps([told]).encode())
        with monkeypatch.context() as patch:
            patch.setattr(file_sets, "opened_alone", refused)
            if whole:
                assert cogging.read_log(tmp_path / "log.csv").metadata["seed"] == 1
            else:
                with pytest.raises(InputError, match=r"log\.csv: must be whole: its writer was killed .* denied$"):
                    cogging.read_log(tmp_path / "log.csv")
    assert cogging.read_log(tmp_path / "log.csv").metadata["seed"] == 1


def planted_pipe(record):
    os.mkfifo(record)


def planted_link(record):
    record.symlink_to(record.with_name("a"))


@pytest.mark.parametrize("plant", [planted_pipe, planted_link, os.mkdir])
def test_a_record_that_is_no_file_is_one_line(plant, tmp_path):
    place(tmp_path)
    plant(tmp_path / file_sets.RECORD)
    with pytest.raises(InputError, match=r"^\S*: cannot be written: \S*/\.cogging-writing: [^\n]*$"):
        write(tmp_path)
    (tmp_path / file_sets.RECORD).rmdir() if plant is os.mkdir else (tmp_path / file_sets.RECORD).unlink()
    assert standing(tmp_path) == OLD
    write(tmp_path)
    assert standing(tmp_path) == NEW


def test_threads_that_write_at_once_leave_one_version(tmp_path):
    versions = [{name: f"{number} {name}".encode() * 100 for name in "abc"} for number in range(8)]
    start = threading.Barrier(len(versions))

    def by(version):
        start.wait()
        for _ in range(10):
            outputs.write_files({str(tmp_path / name): [content] for name, content in version.items()})

    with concurrent.futures.ThreadPoolExecutor(len(versions)) as pool:
        list(pool.map(by, versions))
    assert standing(tmp_path) in versions


def test_logs_with_and_without_metadata_that_are_written_at_once_keep_their_own(tmp_path):
    """Whether something stands beside a log is known only to who has the record."""

    def log(number):
        made = {name: np.full(3, float(number)) for name in ("position", "command")}
        return cogging.Log(time=np.arange(3.0), **made, metadata={"seed": number} if number % 2 else {})

    def by(number):
        for _ in range(15):
            log(number).write(tmp_path / "log.csv")

    with concurrent.futures.ThreadPoolExecutor(6) as pool:
        list(pool.map(by, range(1, 7)))
    read = cogging.read_log(tmp_path / "log.csv")
    number = int(read.command[0])
    assert read.metadata.get("seed") == (number if number % 2 else None)
    assert len(list(tmp_path.iterdir())) == 1 + number % 2


def test_another_writer_is_waited_for_and_then_told(tmp_path, monkeypatch):
    monkeypatch.setattr(file_sets, "LONGEST_WAIT", 0.05)
    place(tmp_path)
    with (
        opened_alone(tmp_path / file_sets.RECORD),
        pytest.raises(InputError, match="cannot be written: another process is writing there"),
    ):
        write(tmp_path)
    write(tmp_path)
    assert standing(tmp_path) == NEW


def test_data_reach_the_disk_before_their_names_and_names_before_the_end(tmp_path, monkeypatch):
    """What is promised of a power failure is an order of calls, which alone can be seen here."""
    calls = []
    monkeypatch.setattr(file_sets, "synced", True)
    for name in ("fsync", "replace"):
        plain = getattr(os, name)

        def call(*given, name=name, plain=plain):
            folder = name == "fsync" and stat.S_ISDIR(os.fstat(given[0]).st_mode)
            calls.append("folder" if folder else name)
            return plain(*given)

        monkeypatch.setattr(os, name, call)
    outputs.write_text(tmp_path / "a", "new")
    assert calls == ["fsync", "replace", "folder"]
    calls.clear()
    outputs.write_files({str(tmp_path / "a"): [b"1"], str(tmp_path / "b"): [b"2"]})
    assert calls[:6] == ["fsync", "fsync", "fsync", "replace", "replace", "folder"], "both, the record, then the places"


def test_a_folder_that_was_made_goes_with_what_could_not_be_written(tmp_path, monkeypatch):
    rows = [papers.Row("C1", "e_inf", "m", 1.0, 2.0, "predicted")]
    monkeypatch.setattr(papers, "png", lambda name: name.encode())
    found = papers.Reproduction("paper", [papers.Table("table1", "Table 1", rows)], {"fig": "fig", "x" * 300: "long"})
    with pytest.raises(InputError, match=r"xxx\.png: cannot be written: File name too long"):
        found.write(tmp_path / "deep" / "results")
    assert standing(tmp_path) == {}
    found.figures.pop("x" * 300)
    written = found.write(tmp_path / "deep" / "results")
    assert sorted(path.name for path in written) == ["fig.png", "paper.json"]
    assert (tmp_path / "deep" / "results" / "fig.png").read_bytes() == b"fig"


@pytest.mark.root
def test_a_file_of_another_in_a_shared_folder_is_refused_before_anything_is_computed(tmp_path, monkeypatch):
    tmp_path.chmod(0o1777)
    (tmp_path / "a").write_text("old")
    os.chown(tmp_path, 1, 1)
    os.chown(tmp_path / "a", 2, 2)
    for user, may in ((0, True), (1, True), (2, True), (3, False)):
        monkeypatch.setattr(os, "geteuid", lambda user=user: user)
        if may:
            outputs.check_outputs({"--out": tmp_path / "a"})
        else:
            with pytest.raises(InputError, match="a: cannot be written: Operation not permitted"):
                outputs.check_outputs({"--out": tmp_path / "a"})


def test_disks_and_kills_in_short(tmp_path):
    """Real file systems that are full or read-only, where this machine mounts any; kills and writers at once always."""
    kind, told = "reproduce", tmp_path / "told.json"
    done = subprocess.run(
        [sys.executable, "-m", "tests.attack.disks", kind, "--short", "--writers", "4", "--json", told],
        cwd=Path(__file__).parents[1],
        capture_output=True,
        text=True,
        check=False,
    )
    assert done.returncode == 0, done.stdout + done.stderr
    found = json.loads(told.read_text())[kind]
    for condition in ("an error at any operation", "killed at any operation", "full disk"):
        if condition in found:
            assert found[condition]["old"] > 2
            assert found[condition]["new"] > 2
            assert not found[condition].get("half")
    if "full disk" not in found:
        assert "no file system may be mounted here" in done.stdout
